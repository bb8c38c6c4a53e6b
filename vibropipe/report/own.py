"""What a study itself says in its report: answers and a table."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from vibropipe.report.parts import Answer
from vibropipe.report.table import Table


def own_answers(texts: Iterable[str]) -> list[Answer]:
    """Return texts as answers, each split after its first sentence."""
    parts = (text.partition(". ") for text in texts)
    return [Answer(f"{lead}." if found else lead, rest) for lead, found, rest in parts]


def own_table(title: str, head: Sequence[str], rows: Sequence[Sequence[str]], note: str) -> Table:
    """Return a table whose columns are all flush left."""
    return Table(list(head), [list(row) for row in rows], note, left=len(head), title=title)
