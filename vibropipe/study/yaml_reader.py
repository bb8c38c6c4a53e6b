"""From YAML text to mappings, lists, text, numbers and booleans.

The tree is built from the events of the parser, so that no tag creates an object, no alias grows without bound and no
duplicate key is lost. Plain scalars that YAML 1.1 and 1.2 read differently (`on`, `12:30`, `010`) are rejected.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from io import StringIO
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple

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
_NOT_FINITE = re.compile(r"[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)")
_TWO_READINGS = re.compile(
    r"(?i:on|off|yes|no)|[-+]?0[\d_]+|[-+]?0[ob][0-7_]+|[-+]?\d[\d_]*_[\d_]*(\.[\d_]*)?"
    r"|[-+]?\d[\d_]*(:[0-5]?\d)+(\.[\d_]*)?|\d{4}-\d\d?-\d\d?([Tt ].*)?",
    re.ASCII,
)
_CONSTANTS: dict[str, bool | None] = {"": None, "~": None, "null": None, "Null": None, "NULL": None}
_CONSTANTS |= {
    "true": True,
    "True": True,
    "TRUE": True,
    "false": False,
    "False": False,
    "FALSE": False,
}
# The C parser is about ten times faster; both give the same events.
_LOADER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


class _Built(NamedTuple):
    """A complete node: its value, its number of nodes with every alias expanded, and its depth."""

    value: Any
    nodes: int = 1
    depth: int = 1


class _StopError(Exception):
    """Reading cannot go on; `args[0]` is the problem."""


def read_file(file: Path) -> tuple[Any, list[Problem]]:
    """Read a YAML file.

    Returns
    -------
    tree : object
        Mappings, lists, text, numbers, booleans and None.
    problems : list of Problem
        Faults that did not stop the reading.

    Raises
    ------
    StudyError
        If the file is not readable UTF-8 YAML within the limits.
    """
    try:
        with file.open("rb") as stream:
            raw = stream.read(MAX_BYTES + 1)
        if len(raw) > MAX_BYTES:
            raise _StopError(
                Problem((), f"more than {MAX_BYTES}", must=f"must have at most {MAX_BYTES} bytes")
            )
        return read_text(raw.decode("utf-8-sig"), str(file))
    except OSError as error:
        reason = (error.strerror or type(error).__name__).lower()
        must = f"cannot be read ({reason}): name a readable YAML file"
        raise StudyError(str(file), [Problem((), "", must=must)]) from None
    except UnicodeDecodeError as error:
        found = f"an invalid byte at position {error.start}"
        raise StudyError(str(file), [Problem((), found, "text in UTF-8")]) from None
    except _StopError as stop:
        raise StudyError(str(file), [stop.args[0]]) from None


def read_text(text: str, source: str) -> tuple[Any, list[Problem]]:
    """Read YAML text, which messages call `source`; results and errors as in `read_file`."""
    builder = _Builder(text)
    try:
        return builder.document(), builder.problems
    except _StopError as stop:
        raise StudyError(source, [*builder.problems, stop.args[0]]) from None
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        if mark and _TAB_INDENT.match(_line(text, mark.line)):
            found = f"a tab at the start of line {mark.line + 1}"
            hint = "put spaces in place of each tab"
            tab = Problem((), found, hint=hint, must="must be indented by spaces")
            raise StudyError(source, [*builder.problems, tab]) from None
        at = f" in line {mark.line + 1}, column {mark.column + 1}" if mark else ""
        where = f"{at} ({error.problem or error.context})"
        line = _line(text, mark.line) if mark else ""
        is_text = _SECOND_COLON.match(line[: mark.column + 1]) if mark else None
        hint = 'put a text with ": " in quotes' if is_text else ""
        raise _broken(source, builder, where, hint) from None
    except yaml.YAMLError as error:
        raise _broken(source, builder, f" ({str(error).splitlines()[0]})") from None


def _broken(source: str, builder: _Builder, where: str, hint: str = "") -> StudyError:
    problem = Problem((), f"a syntax error{where}", "valid YAML", hint)
    return StudyError(source, [*builder.problems, problem])


def _line(text: str, number: int) -> str:
    """Return a line of a text, counted from 0; empty beyond the last one."""
    return next(islice(StringIO(text), number, None), "")


class _Builder:
    """Builds the tree in one pass over the events of the parser."""

    def __init__(self, text: str) -> None:
        self.events: Iterator[Any] = yaml.parse(text, Loader=_LOADER)
        self.anchors: dict[str, _Built] = {}
        self.problems: list[Problem] = []

    def document(self) -> Any:
        """Return the value of the only document, None for an empty text."""
        next(self.events)  # start of the stream
        if isinstance(next(self.events), yaml.StreamEndEvent):
            return None
        value = self.node(next(self.events), ()).value
        next(self.events)  # end of the document
        if not isinstance(next(self.events), yaml.StreamEndEvent):
            raise _StopError(
                Problem((), "a second one (`---`)", must="must have one YAML document")
            )
        return value

    def node(self, event: Any, path: KeyPath) -> _Built:
        if isinstance(event, yaml.AliasEvent):
            return self.alias(event, path)
        if event.tag is not None:
            found = f"the tag {describe(event.tag)}"
            self.problems.append(Problem(path, found, "a value without a YAML tag"))
        if isinstance(event, yaml.ScalarEvent):
            built = _Built(self.scalar(event, path))
        elif len(path) >= MAX_DEPTH:
            raise _StopError(too_deep(path))
        elif isinstance(event, yaml.MappingStartEvent):
            built = self.mapping(event, path)
        else:
            built = self.sequence(path)
        if built.nodes > MAX_NODES:
            must = f"must have at most {MAX_NODES} values"
            raise _StopError(Problem(path, f"more than {MAX_NODES}", must=must))
        if event.anchor is not None:
            self.anchors[event.anchor] = built
        return built

    def alias(self, event: Any, path: KeyPath) -> _Built:
        built = self.anchors.get(event.anchor)
        if built is None:
            found = describe("*" + event.anchor)
            raise _StopError(
                Problem(path, found, "an alias of an anchor that is complete before it")
            )
        if len(path) + built.depth > MAX_DEPTH + 1:
            raise _StopError(too_deep(path))
        return built

    def mapping(self, start: Any, path: KeyPath) -> _Built:
        value: dict[str, Any] = {}
        nodes, depth = 1, 0
        before: tuple[str, Any] | None = (
            None  # the previous key in braces, and the event of its value
        )
        while not isinstance(event := next(self.events), yaml.MappingEndEvent):
            held = next(self.events)
            if before is not None and _is_decimal_comma(before[1], event, held):
                # YAML reads {l: 0,5} as {l: 0, 5: null}, and {l: 8,5 mm} as {l: 8, 5 mm: null}
                written = f"{before[1].value},{event.value}"
                self.problems.append(decimal_comma((*path, before[0]), written))
                pointed, name = written.replace(",", "."), before[0]
                value[name] = float(pointed) if NUMBER.fullmatch(pointed) else pointed
                before = None
                continue
            key = self.key(event, path)
            child = self.node(held, (*path, key))
            before = (key, held) if start.flow_style else None
            if key in value:
                self.problems.append(repeated((*path, key)))
            else:
                value[key] = child.value
            nodes, depth = nodes + 1 + child.nodes, max(depth, child.depth)
        return _Built(value, nodes, depth + 1)

    def sequence(self, path: KeyPath) -> _Built:
        value: list[Any] = []
        nodes, depth = 1, 0
        while not isinstance(event := next(self.events), yaml.SequenceEndEvent):
            child = self.node(event, (*path, len(value)))
            value.append(child.value)
            nodes, depth = nodes + child.nodes, max(depth, child.depth)
        return _Built(value, nodes, depth + 1)

    def key(self, event: Any, path: KeyPath) -> str:
        """Return a key, which must be text by every version of YAML."""
        if not isinstance(event, yaml.ScalarEvent):
            found = "a key that is not plain text"
            raise _StopError(Problem(path, found, must="must have keys of text"))
        key: str = event.value
        if event.tag is not None or (key == "<<" and event.style in (None, "")):
            found = "the merge key `<<`" if event.tag is None else "a YAML tag on a key"
            raise _StopError(Problem(path, found, must="must have every key written out"))
        if event.style in (None, "") and (key in _CONSTANTS or _TWO_READINGS.fullmatch(key)):
            self.problems.append(_two_readings((*path, key), key))
        if event.anchor is not None:
            self.anchors[event.anchor] = _Built(key)
        return key

    def scalar(self, event: Any, path: KeyPath) -> Any:
        text: str = event.value
        if event.style not in (None, ""):
            return Quoted(text) if NUMBER.fullmatch(text) else text
        if text in _CONSTANTS:
            return _CONSTANTS[text]
        if _TWO_READINGS.fullmatch(text):
            self.problems.append(_two_readings(path, text))
            return text
        if _NOT_FINITE.fullmatch(text):
            return float(text.replace(".", "", 1))
        typeset, text = text, text.replace(MINUS, "-")
        # A number that overflows a float stays text, so that the message shows it as written.
        if NUMBER.fullmatch(text) and math.isfinite(number := float(text)):
            whole = text.lstrip("+-").isdigit() and len(text) < 300
            return int(text) if whole else number
        return typeset


def _is_decimal_comma(whole: Any, after: Any, held: Any) -> bool:
    """Return whether a value, the next key and the value of that key are one number with a decimal comma."""
    parts = (whole, after, held)
    plain = all(
        isinstance(event, yaml.ScalarEvent) and event.style in (None, "") and event.tag is None
        for event in parts
    )
    return (
        plain
        and held.value == ""
        and _WHOLE.fullmatch(whole.value) is not None
        and _AFTER_COMMA.fullmatch(after.value) is not None
    )


def too_deep(path: KeyPath) -> Problem:
    """Return the fault of too deep nesting; its path is shortened."""
    must = f"must have at most {MAX_DEPTH} levels of nesting"
    return Problem(path[:3], f"more than {MAX_DEPTH}", must=must)


def _two_readings(path: KeyPath, text: str) -> Problem:
    hint = "YAML 1.1 and 1.2 read it differently"
    found = describe(text).strip("'\"") or "an empty key"
    return Problem(path, found, "a plain number or quoted text", hint)
