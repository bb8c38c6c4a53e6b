"""Parts of a report that kinds of scenes write: answers, tables, lines on methods, numbers beside the exciter.

How to write them is in CONTRIBUTING.md, "a picture".
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import xarray as xr

from vibropipe.figures.claims import even_digits
from vibropipe.figures.text import scalar_parameters
from vibropipe.figures.units import LOWERED
from vibropipe.words.vocabulary import PLAIN_SYMBOLS

DASH = "–"  # as `format_number` writes NaN
MAX_ROWS, ROWS_SHOWN = 12, 10  # of a table, and of one that is cut

Datasets = Mapping[str, xr.Dataset]


# Heads and first cells that are names of quantities -> what is written.
SYMBOLS = {
    **PLAIN_SYMBOLS,
    "multiple": "periods", "impacts_1": "struck, support 1", "impacts_2": "struck, support 2",
    "mean": "mean",
    "multipliers": "multipliers",
}  # fmt: skip


@dataclass(frozen=True)
class Table:
    """A table; the first cell of each row names the row.

    head : one entry per column, with the one unit of the column in brackets. Names of quantities (`delta`, `harmonic
        2`) are written as symbols, in the head and in first cells
    rows : cells, as many per row as `head` has entries, with keys and commands in backticks. Of more than MAX_ROWS
        only ROWS_SHOWN are shown, and the note says so
    note : below the table: what a dash means, what the numbers are
    widths : column widths as typst expressions, for a table that is wider than the text; all "auto" if empty
    left : number of columns that are flush left; the others are flush right
    title : above the table, as of a figure: one line of at most 85 letters
    scene, picture : the scene and the picture after which the table stands; empty: after those of its kind, of its
        scene
    repeated : heads of columns that a picture has as well, and which: the table does without them where that is drawn
    """

    head: list[str]
    rows: list[list[str]] = field(default_factory=list)
    note: str = ""
    widths: tuple[str, ...] = ()
    left: int = 1
    title: str = ""
    scene: str = ""
    picture: str = ""
    repeated: tuple[Sequence[str], str] = ((), "")

    def as_data(self) -> dict[str, Any]:
        """Return the table as JSON data; raises ValueError if a row has not one cell per column."""
        for row in self.rows:
            if len(row) != len(self.head):
                raise ValueError(
                    f"a table of {len(self.head)} columns has a row of {len(row)}: {row}"
                )
        widths = self.widths or ("auto",) * len(self.head)
        if len(widths) != len(self.head):
            raise ValueError(f"a table of {len(self.head)} columns has {len(widths)} widths")
        rows, note = self.rows, self.note
        if len(rows) > MAX_ROWS:
            rows = rows[:ROWS_SHOWN]
            note = f"{note} {len(self.rows) - ROWS_SHOWN} more rows are in the dataset.".strip()
        columns = [list(column) for column in zip(*rows, strict=True)]
        columns = columns[: self.left] + [even_digits(column) for column in columns[self.left :]]
        rows = [list(row) for row in zip(*columns, strict=True)]
        return {
            "type": "table",
            "title": self.title,
            "head": [symbol(name) for name in self.head],
            "rows": [[symbol(row[0]), *row[1:]] for row in rows],
            "note": note,
            "widths": list(widths),
            "left": self.left,
        }


def head_and_rows(columns: Mapping[str, Sequence[str]]) -> tuple[list[str], list[list[str]]]:
    """Return the first two fields of a table, from its cells by the heads of their columns."""
    return [*columns], [list(row) for row in zip(*columns.values(), strict=True)]


def told_once(table: Table, whose: str) -> Table:
    """Return a table without the columns whose cells are all equal, unless all are; its note tells these of `whose`."""
    columns = range(len(table.head)) if len(table.rows) > 1 else range(0)
    equal = [
        n for n in columns if n and {table.rows[0][n]} == {row[n] for row in table.rows} != {DASH}
    ]
    if len(equal) in (0, len(table.head) - 1):
        return table
    told = "; ".join(f"{symbol(table.head[n])}: {table.rows[0][n]}" for n in equal)
    return replace(without_columns(table, equal), note=f"Of {whose}, {told}. {table.note}".strip())


def beside_pictures(table: Table, drawn: Collection[str]) -> Table | None:
    """Return a table without the columns that one of the pictures that are drawn has as well; None without another."""
    heads, picture = table.repeated
    if picture not in drawn:
        return table
    kept = without_columns(table, [n for n, head in enumerate(table.head) if head in heads])
    return kept if len(kept.head) > 1 else None


def without_columns(table: Table, left_out: Collection[int]) -> Table:
    """Return a table without some columns."""

    def kept(cells: Sequence[str]) -> list[str]:
        return [cell for n, cell in enumerate(cells) if n not in left_out]

    return replace(
        table,
        head=kept(table.head),
        rows=[kept(row) for row in table.rows],
        widths=tuple(kept(table.widths)),
    )


def symbol(name: str) -> str:
    """Return the symbol of a quantity by its name, which may have a unit in brackets; any other text stays."""
    bare, bracket, unit = name.partition(" (")
    if harmonic := re.fullmatch(r"harmonic (\d+)", bare):
        return f"A{harmonic[1].translate(LOWERED)}{bracket}{unit}"
    return f"{SYMBOLS.get(bare, bare)}{bracket}{unit}"


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


def of_each(answers_of: Callable[[xr.Dataset], Sequence[Answer]]) -> Callable[[Datasets], Answers]:
    """Return the answers of several scenes: of each, those of its dataset."""
    return lambda datasets: {label: answers_of(data) for label, data in datasets.items()}


def not_repeated(answers: Answers, datasets: Datasets) -> dict[str, list[Answer]]:
    """Return answers by scene without those whose lead, with its numbers, an earlier scene of the same exciter has.

    datasets : by scene, in the order in which the scenes stand in the report
    """
    told: set[tuple[object, ...]] = set()
    kept = {label: list(own) for label, own in answers.items()}
    for label in (each for each in datasets if each in kept):
        exciter = frozenset(scalar_parameters(datasets[label]).items())
        kept[label] = [each for each in kept[label] if (exciter, each.lead) not in told]
        told |= {(exciter, each.lead) for each in kept[label] if re.search(r"\d", each.lead)}
    return kept


def tables_of_each(
    *made: Callable[[str, xr.Dataset], Table | None],
) -> Callable[[Datasets], list[Table]]:
    """Return the tables of several scenes: of each, those that are made of its label and dataset."""
    return lambda datasets: [
        table
        for label, data in datasets.items()
        for make in made
        if (table := make(label, data)) is not None
    ]


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
