"""The reference of Python calls and of quantities, made from docstrings and records.

`python -m vibropipe.study` writes both pages into `docs/`; a test fails if they are out of date.
"""

from __future__ import annotations

import inspect
import re
import tomllib
from collections.abc import Iterator
from importlib.resources import files
from pathlib import Path
from typing import Any

import vibropipe
from vibropipe.words.parameters import PARAMETERS
from vibropipe.words.quantities import FLAGS, QUANTITIES
from vibropipe.words.units import DIMENSIONS, plain_units

PYTHON, QUANTITIES_PAGE = "python.md", "quantities.md"
# Methods of an exciter that users call.
METHODS = ("from_physical", "mirrored")
_HEAD = re.compile(r"^(?P<name>[A-Z][A-Za-z ]+)\n-{3,}$", re.MULTILINE)
_ROLE = re.compile(r"\[(\d)\]_")
# Sections of docstrings whose entries are names.
LISTED = ("Parameters", "Returns", "Attributes", "Raises", "Warns", "Yields")
TEXTS = {
    "motion": "Motions", "steady_state": "Steady states and sweeps", "branch": "Branches", "boundary": "Boundaries",
    "exciter": "The exciter",
}  # fmt: skip


def python_page() -> str:
    """Return the page of all public calls in Markdown."""
    names = [name for name in vibropipe.__all__ if not name.startswith("__")]
    calls = {name: getattr(vibropipe, name) for name in names}
    lines = [
        "# Python calls",
        "",
        "Written by `python -m vibropipe.study` from the docstrings; `help(vp.sweep)` shows the same. The quantities "
        "in datasets are in [quantities](quantities.md), the keys of a study in "
        "[config](../config/README.md#all-keys).",
        "",
        "| call | what it does |",
        "|---|---|",
        *(
            f"| [`vp.{name}`](#vp{name.lower()}) | {_summary(call)} |"
            for name, call in calls.items()
        ),
    ]
    for name, call in calls.items():
        lines += ["", f"## `vp.{name}`", "", *_of_call(f"vp.{name}", call)]
        if name == "Exciter":
            for method in METHODS:
                full = f"vp.Exciter.{method}"
                lines += ["", f"### `{full}`", "", *_of_call(full, getattr(call, method))]
    return "\n".join(lines) + "\n"


def _summary(call: Any) -> str:
    """Return the first sentence of a docstring, in one line."""
    return " ".join((inspect.getdoc(call) or "").split("\n\n")[0].split()).replace("|", r"\|")


def _of_call(name: str, call: Any) -> Iterator[str]:
    """Yield the lines of a call: its signature, and the sections of its docstring."""
    if not (isinstance(call, type) and issubclass(call, Exception)):
        yield from ("```text", f"{name}{_signature(call)}", "```", "")
    text = _ROLE.sub(r"[\1]", inspect.getdoc(call) or "").replace(".. [", "[")
    heads = list(_HEAD.finditer(text))
    ends = [head.start() for head in heads] + [len(text)]
    yield from _prose(text[: ends[0]])
    for head, end in zip(heads, ends[1:], strict=True):
        body = text[head.end() : end].strip("\n")
        yield ""
        yield f"**{head['name']}**"
        yield ""
        yield from _entries(body) if head["name"] in LISTED else _prose(body)


def _signature(call: Any) -> str:
    """Return a signature without types, one argument a line where it is long."""
    parameters = inspect.signature(call).parameters.values()
    bare = [each.replace(annotation=inspect.Parameter.empty) for each in parameters]
    text = str(inspect.Signature([each for each in bare if each.name != "self"]))
    return text if len(text) <= 90 else "(\n    " + ",\n    ".join(map(str, bare)) + ",\n)"


def _prose(text: str) -> Iterator[str]:
    """Yield paragraphs as lines; what is indented stays as it is, in a block."""
    for n, part in enumerate(text.strip("\n").split("\n\n")):
        if n:
            yield ""
        if part.startswith(("    ", ">>> ")):
            yield from ("```text", *part.splitlines(), "```")
        else:
            yield " ".join(_escaped(part).split())


def _entries(text: str) -> Iterator[str]:
    """Yield the entries of a section as a list: `name : type`, and what is indented beneath it."""
    for block in re.split(r"\n(?=\S)", text):
        head, _, body = block.partition("\n")
        name, _, kind = head.partition(" : ")
        paragraphs = inspect.cleandoc(body).split("\n\n") if body else []
        kind_text, first = f" ({_escaped(kind)})" if kind else "", ""
        if paragraphs and not _is_list(paragraphs[0]):
            first = f": {' '.join(_escaped(paragraphs.pop(0)).split())}"
        yield f"- `{name}`{kind_text}{first}"
        for paragraph in paragraphs:
            yield ""
            if _is_list(paragraph):
                for inner in re.split(r"\n(?=\S)", paragraph):
                    its, _, meaning = inner.partition("\n")
                    yield f"  - `{its}`: {' '.join(_escaped(meaning).split())}"
            else:
                yield "  " + " ".join(_escaped(paragraph).split())


def _is_list(paragraph: str) -> bool:
    """Return whether a paragraph is a list of its own: names, and their meanings indented beneath them."""
    return re.search(r"\n {4}", paragraph) is not None


def _escaped(text: str) -> str:
    """Return a text whose angle brackets are no tags."""
    parts = text.split("`")  # every other one is code
    parts[::2] = [re.sub(r"<([a-z_]+)>", r"&lt;\1&gt;", part) for part in parts[::2]]
    return "`".join(parts)


def quantities_page() -> str:
    """Return the page of all quantities of datasets in Markdown."""
    source = files("vibropipe.words").joinpath("quantities.toml").read_text(encoding="utf-8")
    lines = [
        "# Quantities",
        "",
        "Written by `python -m vibropipe.study` from the records that datasets, figures and reports are made of. Each "
        "variable of a dataset has its meaning, symbol and unit as attributes. Without units lengths are in the unit "
        "of `l`, and times in 1/p with p = sqrt(C/m); in SI some have other names. Beside `<name>` there may be "
        "`<name>_error`, an estimate of its error, and `<name>_sensitivity` over `parameter`, its derivatives.",
    ]
    for subject, names in tomllib.loads(source).items():
        rows = [row for name, words in names.items() for row in _row(name, words)]
        title = TEXTS.get(subject, subject.replace("_", " ").capitalize())
        lines += [
            "",
            f"## {title}",
            "",
            "| name | symbol | unit | meaning | over | output |",
            "|---|---|---|---|---|---|",
        ]
        lines += rows
    return "\n".join(lines) + "\n"


def _row(name: str, words: dict[str, Any]) -> Iterator[str]:
    """Yield the row of a quantity, or of all that one stands for with each parameter."""
    if name == "{}":
        for each in PARAMETERS:
            yield from _row(each, {"si": QUANTITIES[each].si})
        return
    shown = name.replace("{}", "<parameter>")
    si = words.get("si", {}).get("name", "")
    if "{}" in name:
        symbol, unit = "", "of the parameter"
        meaning = words["long_name"].format("the parameter")
    else:
        entry = QUANTITIES[name]
        dimension = DIMENSIONS.get(entry.dimension)
        symbol, unit = entry.symbol, plain_units(dimension.units) if dimension else ""
        meaning = entry.long_name
    if "flags" in words:
        meaning += f" ({', '.join(FLAGS[words['flags']])})"
    names = f"`{shown}`" + (f", in SI `{si}`" if si else "")
    over = ", ".join(f"`{dim}`" for dim in words.get("dims", "").split())
    output = f"`{words['output']}`" if words.get("output") else ""
    symbol = symbol if not symbol or symbol.startswith("$") else f"*{symbol}*"
    yield f"| {names} | {symbol} | {unit} | {meaning} | {over} | {output} |".replace("|x", r"\|x")


def write(folder: Path) -> None:
    """Write both pages into a folder."""
    (folder / PYTHON).write_text(python_page(), encoding="utf-8")
    (folder / QUANTITIES_PAGE).write_text(quantities_page(), encoding="utf-8")
