"""What is wrong with a study: one `Problem` per fault, all of them together in one `StudyError`."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from vibropipe.scenes.keys.spelling import nearest, only_looks_right

KeyPath = tuple[str | int, ...]

_LONGEST = 60


def describe(value: Any) -> str:
    """Return a short printable account of what was found; control characters come out escaped."""
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
    """Return a key's path as it is said in messages: `scenes.offset.over.nu[3]`."""
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
    """One fault: the key's path, what was found there, what is allowed, and perhaps a hint.

    `covers` tells that faults beneath the path would only follow from this one.
    """

    path: KeyPath
    found: str
    allowed: str
    hint: str = ""
    covers: bool = True

    def line(self, source: str) -> str:
        """Return the fault as one line that begins with the file's name."""
        where = f"{source}: {path_text(self.path)}" if self.path else source
        hint = f" ({self.hint})" if self.hint else ""
        return f"{where}: found {self.found}, allowed {self.allowed}{hint}"


class StudyError(ValueError):
    """A study, or the list of studies, cannot be taken; the text has one line for each fault."""

    def __init__(self, source: str, problems: Sequence[Problem]) -> None:
        self.source = source
        self.problems = tuple(problems)
        super().__init__("\n".join(problem.line(source) for problem in self.problems))


def did_you_mean(word: Any, known: Iterable[str]) -> str:
    """Return the hint for a word that is none of `known`, or an empty text when nothing is near."""
    near = nearest(word, known) if isinstance(word, str) else None
    if near is None:
        return ""
    disguised = "; some of its letters only look right" if only_looks_right(word, near) else ""
    return f"did you mean {near!r}?{disguised}"


def repeated(path: KeyPath, spelling: str = "") -> Problem:
    """Return the fault of a key that stands twice; its first value is kept and checked."""
    again = f", as {describe(spelling)}" if spelling else ""
    return Problem(path, f"this key a second time{again}", "each key once", covers=False)


def decimal_comma(path: KeyPath, written: str) -> Problem:
    """Return the fault of a number with a comma where the point should be."""
    hint = f"write {written.replace(',', '.')}, with a point"
    return Problem(path, describe(written), "a number", hint)


def unknown(path: KeyPath, known: Sequence[str]) -> Problem:
    """Return the fault of a key that nothing knows, with the nearest known one."""
    return Problem(
        path, "an unknown key", ", ".join(known) or "no key here", did_you_mean(path[-1], known)
    )


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
