"""Parts of a report that kinds of scenes write: answers, lines on methods, and the numbers beside the exciter.

How to write them is in CONTRIBUTING.md, "a picture".
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from vibropipe.report.findings import Finding
from vibropipe.report.section import Section
from vibropipe.report.table import Datasets, Table

MAX_ANSWERS = 3  # of a scene
MAX_LINES = 6  # of methods and provenance
MAX_LEAD = 80  # letters of a sentence that is bold as a whole


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


def answers_of(findings: Callable[[Datasets], list[Finding]]) -> Callable[[Datasets], Answers]:
    """Return a function that writes findings as answers, the first MAX_ANSWERS of each scene."""

    def answers(datasets: Datasets) -> Answers:
        return {
            finding.scene: [split(text) for text in finding.texts[:MAX_ANSWERS]]
            for finding in findings(datasets)
        }

    return answers


def split(sentence: str) -> Answer:
    """Split a sentence at its first colon or semicolon; a short one is bold as a whole, a long one nowhere."""
    for mark in (": ", "; "):
        lead, found, rest = sentence.partition(mark)
        if found and len(lead) <= MAX_LEAD:
            return Answer(f"{lead}{mark.strip()}", rest)
    return Answer(sentence) if len(sentence) <= MAX_LEAD else Answer("", sentence)


def tables_of(sections: Callable[[Datasets], list[Section]]) -> Callable[[Datasets], list[Table]]:
    """Return a function that gives the tables of sections, under the titles of these."""

    def tables(datasets: Datasets) -> list[Table]:
        return [
            replace(table, title=table.title or section.title)
            for section in sections(datasets)
            for table in section.tables
        ]

    return tables


def lines_of(
    name: str, notes: Callable[[Datasets], Iterable[str]]
) -> Callable[[Datasets], list[Line]]:
    """Return a function that writes notes as one line of methods."""

    def lines(datasets: Datasets) -> list[Line]:
        text = " ".join(notes(datasets))
        return [Line(name, text)] if text else []

    return lines
