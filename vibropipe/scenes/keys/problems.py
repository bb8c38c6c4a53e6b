"""What is wrong with a study: one `Problem` per fault, all of them together in one `StudyError`."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from vibropipe.physics.exciter import ParameterError
from vibropipe.words.parameters import PHYSICAL
from vibropipe.words.spelling import hint_of_key

KeyPath = tuple[str | int, ...]

_LONGEST = 60
REQUIRED = "is required"  # begins what must hold of a missing key


def describe(value: Any) -> str:
    """Return a value as a message shows it: short, with control characters escaped."""
    if value is None:
        return "nothing"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, dict):
        return "a mapping" if value else "an empty mapping"
    if isinstance(value, (list, tuple)):
        return f"a list of {len(value)}" if value else "an empty list"
    try:
        text = repr(value)
    except ValueError:  # Python refuses to print an integer of many thousand digits
        return "an integer of thousands of digits"
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}..."


def path_text(path: KeyPath) -> str:
    """Return a key's path as messages show it: `scenes.offset.over.nu[3]`."""
    text = ""
    for step in path:
        if isinstance(step, int):
            text += f"[{step}]"
        else:
            plain = re.fullmatch(r"\w{1,80}", step) is not None
            text += ("." if text else "") + (step if plain else describe(step))
    return text


@dataclass(frozen=True)
class Problem:
    """One fault of a study.

    path : path of the key
    found : the value found; empty where `must` says all there is to say
    allowed : what the key takes, a noun phrase: "a number from 0 to 1"
    hint : what was probably meant, printed in brackets at the end
    covers : whether faults beneath the path only follow from this one
    must : what must hold, a full predicate ("must occur once"); "must be <allowed>" if empty
    """

    path: KeyPath
    found: str
    allowed: str = ""
    hint: str = ""
    covers: bool = True
    must: str = ""

    def line(self, source: str) -> str:
        """Return the fault as one line: file, key path, what must hold, the value found, the hint."""
        where = f"{source}: {path_text(self.path)}" if self.path else source
        must = self.must or f"must be {self.allowed}"
        found = f", got {self.found}" if self.found else ""
        hint = f" ({self.hint})" if self.hint else ""
        return f"{where}: {must}{found}{hint}"


class StudyError(ValueError):
    """A study, or the list of studies, is invalid; the text has one line for each fault."""

    def __init__(self, source: str, problems: Sequence[Problem]) -> None:
        self.source = source
        self.problems = tuple(problems)
        super().__init__("\n".join(problem.line(source) for problem in self.problems))


def repeated(path: KeyPath, spelling: str = "") -> Problem:
    """Return the fault of a key that occurs twice; its first value is kept and checked."""
    spelt = f" spelt {describe(spelling)}" if spelling else ""
    return Problem(path, f"a duplicate key{spelt}", must="must occur once", covers=False)


def decimal_comma(path: KeyPath, written: str) -> Problem:
    """Return the fault of a number with a comma where the point should be."""
    pointed = written.replace(",", ".")
    quote = '"' if pointed[:1] in "<>" else ""
    return Problem(
        path, describe(written), "a number", f"write {quote}{pointed}{quote}, with a point"
    )


def one_of(choices: Iterable[str]) -> str:
    """Return choices as a noun phrase: "a or b", "one of a, b, c"."""
    words = list(choices)
    return " or ".join(words) if len(words) < 3 else f"one of {', '.join(words)}"


def required(path: KeyPath, allowed: str, where: str = "", hint: str = "") -> Problem:
    """Return the fault of a missing key; `where` says where it may be given, or why it is required."""
    return Problem(path, "", allowed, hint, must=f"{REQUIRED} ({allowed}){where}")


def refused(path: KeyPath, error: ParameterError) -> Problem:
    """Return the fault that an exciter finds in its parameters or in a start."""
    return Problem(path, error.got, error.allowed, must=error.must)


def argument_path(error: ParameterError) -> KeyPath:
    """Return the path of an argument that a call refuses: `vary.k1` is an entry of `vary`."""
    return tuple(error.name.split(".", 1))


def unknown(path: KeyPath, choices: Sequence[str]) -> Problem:
    """Return the fault of an unknown key, with the nearest one that exists or where its quantity belongs."""
    instead = f"be {one_of(choices)}" if choices else "be left out"
    hint, must = hint_of_key(path[-1], choices), f"is an unknown key; must {instead}"
    if path[-1] in PHYSICAL and ("nu" in choices or path[-2:-1] == ("exciter",)):
        hint = f"{path[-1]} has units: it stands under physical"
        # the long list of those without units is no answer
        must = "is an unknown key" if "nu" in choices else must
    return Problem(path, "", hint=hint, must=must)


def distinct(problems: Iterable[Problem]) -> list[Problem]:
    """Keep the first problem of each path, and none beneath a path whose problem covers it."""
    kept: list[Problem] = []
    for problem in problems:
        above = {problem.path[:length] for length in range(1, len(problem.path) + 1)}
        if not any(
            other.path in above and (other.covers or other.path == problem.path) for other in kept
        ):
            kept.append(problem)
    return kept
