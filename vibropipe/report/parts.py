"""Parts of a report that kinds of scenes write: answers, lines on methods, and the numbers beside the exciter.

How to write them is in CONTRIBUTING.md, "a picture".
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from vibropipe.report.table import Datasets, Table


def own_answers(texts: Iterable[str]) -> list[Answer]:
    """Return texts as answers, each split after its first sentence."""
    parts = (text.partition(". ") for text in texts)
    return [Answer(f"{lead}." if found else lead, rest) for lead, found, rest in parts]


def own_table(title: str, head: Sequence[str], rows: Sequence[Sequence[str]], note: str) -> Table:
    """Return a table whose columns are all flush left."""
    return Table(list(head), [list(row) for row in rows], note, left=len(head), title=title)


MAX_ANSWERS = 3  # of a scene
MAX_LINES = 6  # of methods and provenance


@dataclass(frozen=True)
class Answer:
    """A sentence and a half: `lead`, set bold, holds alone; `rest` has what it rests on. Both end with full stops."""

    lead: str
    rest: str = ""


Answers = Mapping[str, Sequence[Answer]]
"""Answers by scene; those of the key "" are on all scenes of the kind and stand on page 1 in place of one scene's."""


@dataclass(frozen=True)
class Line:
    """A line of methods: what it is on, and its text, in which commands and files stand in backticks.

    A text that is `plain` is a user's own and has no marks.
    """

    name: str
    text: str
    plain: bool = False


@dataclass(frozen=True)
class Row:
    """A row beside the exciter: symbol, value or range with its unit, words. With a symbol alone it is a heading."""

    symbol: str
    value: str = ""
    words: str = ""


@dataclass(frozen=True)
class Side:
    """What stands beside the answers: rows, below the drawing of the exciter unless `has_drawing` is false.

    The drawing has the effects of the datasets in `drawn` (default: of all).
    """

    rows: Sequence[Row]
    has_drawing: bool = True
    drawn: Datasets | None = None
