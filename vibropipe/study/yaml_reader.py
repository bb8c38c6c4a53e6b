"""From YAML text to mappings, lists, text, numbers and booleans.

PyYAML's safe loader with the plain scalars of YAML 1.2, without tags: none creates an object. No alias grows without
bound and no duplicate key is lost. Scalars that YAML 1.1 and 1.2 read differently (`on`, `12:30`, `010`) are rejected.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

import yaml

from vibropipe.scenes.keys.problems import (
    KeyPath,
    Problem,
    StudyError,
    decimal_comma,
    describe,
    repeated,
)
from vibropipe.scenes.keys.values import NUMBER, Quoted
from vibropipe.words.units import MINUS

# Limits of a file: its bytes, levels of nesting, and values with every alias expanded. They lie far above any study and
# bound the time and memory that a hostile file takes.
MAX_BYTES = 1_000_000
MAX_DEPTH = 12
MAX_NODES = 200_000

# What stands before a comma that was meant as a point, a bound included, and after it, a unit included.
_WHOLE = re.compile(r"([<>]=?\s*)?[-+]?\d+", re.ASCII)
_AFTER_COMMA = re.compile(r"\d+([eE][-+]?\d+)?(\s*([^\W\d]|1\s*/)[^,]*)?")
_SECOND_COLON = re.compile(r".*\w: +[^'\"].*:$")
_TAB_INDENT = re.compile(r" *\t")
_CONSTANTS: dict[str, bool | None] = {"": None, "~": None}
for _words, _value in (
    ("null Null NULL", None),
    ("true True TRUE", True),
    ("false False FALSE", False),
):
    _CONSTANTS |= dict.fromkeys(_words.split(), _value)
# Tags of plain scalars. None of them can be written, so every other tag was.
_TEXT, _CONSTANT, _NOT_FINITE, _TWO_READINGS = "text", "constant", "not finite", "two readings"
_RESOLVED = {
    _CONSTANT: "|".join(map(re.escape, _CONSTANTS)),
    _NOT_FINITE: r"[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)",
    _TWO_READINGS: r"(?i:on|off|yes|no)|[-+]?0[\d_]+|[-+]?0[ob][0-7_]+|[-+]?\d[\d_]*_[\d_]*(\.[\d_]*)?"
    r"|[-+]?\d[\d_]*(:[0-5]?\d)+(\.[\d_]*)?|\d{4}-\d\d?-\d\d?([Tt ].*)?",
}


# The C parser is about ten times faster.
class _Loader(getattr(yaml, "CSafeLoader", yaml.SafeLoader)):  # type: ignore[misc]
    """Reads nodes whose tags tell the plain scalars of YAML 1.2 apart."""

    DEFAULT_SCALAR_TAG = _TEXT
    DEFAULT_SEQUENCE_TAG = "list"
    DEFAULT_MAPPING_TAG = "mapping"
    yaml_implicit_resolvers: ClassVar[dict[Any, Any]] = {}


for _tag, _written in _RESOLVED.items():
    _Loader.add_implicit_resolver(_tag, re.compile(rf"(?:{_written})\Z", re.ASCII), None)


class _Built(NamedTuple):
    """A complete node: its value, its number of nodes with every alias expanded, and its depth."""

    value: Any
    nodes: int = 1
    depth: int = 1


class _StopError(Exception):
    """Reading cannot go on; `args[0]` is the problem."""


def read_file(file: Path) -> tuple[Any, list[Problem]]:
    """Read a YAML file.

    Returns the tree of mappings, lists, text, numbers, booleans and None, and the faults that did not stop the reading.
    Raises StudyError if the file is not readable UTF-8 YAML within the limits.
    """
    try:
        with file.open("rb") as stream:
            raw = stream.read(MAX_BYTES + 1)
        if len(raw) > MAX_BYTES:
            must = f"must have at most {MAX_BYTES} bytes"
            raise StudyError(str(file), [Problem((), f"more than {MAX_BYTES}", must=must)])
        return read_text(raw.decode("utf-8-sig"), str(file))
    except OSError as error:
        reason = (error.strerror or type(error).__name__).lower()
        must = f"cannot be read ({reason}): name a readable YAML file"
        raise StudyError(str(file), [Problem((), "", must=must)]) from None
    except UnicodeDecodeError as error:
        found = f"an invalid byte at position {error.start}"
        raise StudyError(str(file), [Problem((), found, "text in UTF-8")]) from None


def read_text(text: str, source: str) -> tuple[Any, list[Problem]]:
    """Read YAML text, which messages call `source`; results and errors as in `read_file`."""
    problems: list[Problem] = []
    try:
        _check_depth(text)
        root = _Loader(text).get_single_node()
        return None if root is None else _Builder(problems).node(root, ()).value, problems
    except _StopError as stop:
        raise StudyError(source, [*problems, stop.args[0]]) from None
    except yaml.YAMLError as error:
        raise StudyError(source, [_syntax_error(error, text)]) from None


def _check_depth(text: str) -> None:
    """Stop at nesting so deep that the loader itself could end for want of memory."""
    depth = 0
    event: Any
    for event in yaml.parse(text, Loader=_Loader):
        depth += isinstance(event, yaml.CollectionStartEvent)
        depth -= isinstance(event, yaml.CollectionEndEvent)
        if depth > MAX_DEPTH + 1:
            raise _StopError(too_deep((), f" in line {event.start_mark.line + 1}"))


def _syntax_error(error: yaml.YAMLError, text: str) -> Problem:
    """Return the fault of text that is no YAML, with what was probably meant."""
    mark = getattr(error, "problem_mark", None) or getattr(error, "context_mark", None)
    if mark is None:
        return Problem((), f"a syntax error ({str(error).splitlines()[0]})", "valid YAML")
    reason = getattr(error, "problem", None) or getattr(error, "context", None)
    line = [*text.splitlines(), ""][min(mark.line, len(text.splitlines()))]
    at = f"line {mark.line + 1}"
    if reason == "but found another document":
        return Problem((), "a second one (`---`)", must="must have one YAML document")
    if reason == "found undefined alias":
        must = "must have every alias after its anchor"
        return Problem((), f"{describe(line[mark.column :].split()[0])} in {at}", must=must)
    if _TAB_INDENT.match(line):
        hint = "put spaces in place of each tab"
        return Problem(
            (), f"a tab at the start of {at}", hint=hint, must="must be indented by spaces"
        )
    hint = 'put a text with ": " in quotes' if _SECOND_COLON.match(line[: mark.column + 1]) else ""
    found = f"a syntax error in {at}, column {mark.column + 1} ({reason})"
    return Problem((), found, "valid YAML", hint)


class _Builder:
    """Builds the tree from the nodes of the loader; an alias is the node that it names."""

    def __init__(self, problems: list[Problem]) -> None:
        self.problems = problems
        self.complete: dict[int, _Built | None] = {}  # None: begun

    def node(self, node: yaml.Node, path: KeyPath) -> _Built:
        """Return the value of a node."""
        if isinstance(node, yaml.ScalarNode):
            return _Built(self.scalar(node, path))
        if id(node) not in self.complete:
            self.complete[id(node)] = None
            self.complete[id(node)] = self.collection(node, path)
        built = self.complete[id(node)]
        if built is None:
            raise _StopError(Problem(path, "an alias of what it stands in", "a complete value"))
        if len(path) + built.depth > MAX_DEPTH + 1:
            raise _StopError(too_deep(path))
        if built.nodes > MAX_NODES:
            must = f"must have at most {MAX_NODES} values"
            raise _StopError(Problem(path, f"more than {MAX_NODES}", must=must))
        return built

    def collection(self, node: yaml.Node, path: KeyPath) -> _Built:
        """Return the value of a mapping or a list."""
        if node.tag not in (_Loader.DEFAULT_MAPPING_TAG, _Loader.DEFAULT_SEQUENCE_TAG):
            self.problems.append(_tagged(path, node.tag))
        if isinstance(node, yaml.MappingNode):
            pairs = self.pairs(node, path)
        else:
            pairs = [(n, self.node(entry, (*path, n))) for n, entry in enumerate(node.value)]
        values = {key: built.value for key, built in pairs}
        nodes = 1 + sum(built.nodes for _, built in pairs)
        depth = 1 + max((built.depth for _, built in pairs), default=0)
        if isinstance(node, yaml.MappingNode):
            return _Built(values, nodes + len(pairs), depth)
        return _Built(list(values.values()), nodes, depth)

    def pairs(self, node: yaml.MappingNode, path: KeyPath) -> list[tuple[Any, _Built]]:
        """Return keys and values of a mapping, each key once."""
        pairs: dict[str, _Built] = {}
        before: yaml.Node | None = None  # the value of the previous key in braces
        name = ""
        for key, held in node.value:
            if before is not None and _is_decimal_comma(before, key, held):
                # YAML reads {l: 0,5} as {l: 0, 5: null}, and {l: 8,5 mm} as {l: 8, 5 mm: null}
                written = f"{before.value},{key.value}"
                self.problems.append(decimal_comma((*path, name), written))
                pointed = written.replace(",", ".")
                pairs[name] = _Built(float(pointed) if NUMBER.fullmatch(pointed) else pointed)
                before = None
                continue
            name = self.key(key, path)
            child = self.node(held, (*path, name))
            before = held if node.flow_style else None
            if name in pairs:
                self.problems.append(repeated((*path, name)))
            pairs.setdefault(name, child)
        return [*pairs.items()]

    def key(self, node: yaml.Node, path: KeyPath) -> str:
        """Return a key, which must be text by every version of YAML."""
        if not isinstance(node, yaml.ScalarNode):
            found = "a key that is not plain text"
            raise _StopError(Problem(path, found, must="must have keys of text"))
        key: str = node.value
        if node.tag not in (_TEXT, *_RESOLVED) or (key == "<<" and not node.style):
            found = "the merge key `<<`" if node.tag == _TEXT else "a YAML tag on a key"
            raise _StopError(Problem(path, found, must="must have every key written out"))
        if node.tag in (_CONSTANT, _TWO_READINGS):
            self.problems.append(_two_readings((*path, key), key))
        return key

    def scalar(self, node: yaml.ScalarNode, path: KeyPath) -> Any:
        """Return text, a number, a boolean or None."""
        text: str = node.value
        if node.tag == _CONSTANT:
            return _CONSTANTS[text]
        if node.tag == _NOT_FINITE:
            return float(text.replace(".", "", 1))
        if node.tag == _TWO_READINGS:
            self.problems.append(_two_readings(path, text))
        elif node.tag != _TEXT:
            self.problems.append(_tagged(path, node.tag))
        if node.style:
            return Quoted(text) if NUMBER.fullmatch(text) else text
        plain = text.replace(MINUS, "-")
        # A number that overflows a float stays text, so that the message shows it as written.
        if node.tag == _TEXT and NUMBER.fullmatch(plain) and math.isfinite(number := float(plain)):
            whole = plain.lstrip("+-").isdigit() and len(plain) < 300
            return int(plain) if whole else number
        return text


def _is_decimal_comma(whole: yaml.Node, after: yaml.Node, held: yaml.Node) -> bool:
    """Return whether a value, the next key and the value of that key are one number with a decimal comma."""
    parts: Sequence[yaml.Node] = (whole, after, held)
    plain = all(isinstance(node, yaml.ScalarNode) and not node.style for node in parts)
    return (
        plain
        and held.value == ""
        and _WHOLE.fullmatch(whole.value) is not None
        and _AFTER_COMMA.fullmatch(after.value) is not None
    )


def too_deep(path: KeyPath, where: str = "") -> Problem:
    """Return the fault of too deep nesting; its path is shortened."""
    must = f"must have at most {MAX_DEPTH} levels of nesting"
    return Problem(path[:3], f"more than {MAX_DEPTH}{where}", must=must)


def _tagged(path: KeyPath, tag: str) -> Problem:
    return Problem(path, f"the tag {describe(tag)}", "a value without a YAML tag")


def _two_readings(path: KeyPath, text: str) -> Problem:
    hint = "YAML 1.1 and 1.2 read it differently"
    found = describe(text).strip("'\"") or "an empty key"
    return Problem(path, found, "a plain number or quoted text", hint)
