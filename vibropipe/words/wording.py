"""Amounts and lists in sentences, and rows of text with aligned columns."""

from __future__ import annotations

import unicodedata
from collections.abc import Iterable, Sequence


def count(amount: int, noun: str, plural: str | None = None) -> str:
    """Write an amount with its noun: `1 impact`, `3 impacts`, `4,096 parts`."""
    return f"{amount:,} {noun if amount == 1 else plural or noun + 's'}"


def capitalised(text: str) -> str:
    """Return a text with its first letter large."""
    return text[:1].upper() + text[1:]


def part_text(part: int, whole: int, noun: str, plural: str | None = None) -> str:
    """Write a part of an amount: `2 of 3 checks`, `all 3 checks`, `the only check`."""
    if part == whole > 0:
        return f"the only {noun}" if whole == 1 else f"all {count(whole, noun, plural)}"
    return f"{part:,} of {count(whole, noun, plural)}"


def share(part: int, whole: int, noun: str, plural: str | None = None) -> str:
    """Write a part of an amount with its verb: `2 of 3 checks are`, `all 3 checks are`, `0 of 1 check is`."""
    return f"{part_text(part, whole, noun, plural)} {'is' if 1 in (part, whole) else 'are'}"


def series(words: Iterable[str], last: str = "and") -> str:
    """Join a list for a sentence: `a`, `a and b`, `a, b and c`; `last` stands before the last."""
    listed = list(words)
    if len(listed) < 2:
        return "".join(listed)
    return f"{', '.join(listed[:-1])} {last} {listed[-1]}"


def method_text(method: str, steps_per_period: int | None = None) -> str:
    """Write a method with its number of steps: `newmark, 64 steps per forcing period`."""
    steps = (
        ""
        if steps_per_period is None
        else f", {count(steps_per_period, 'step')} per forcing period"
    )
    return method + steps


def paragraphs(text: str) -> list[str]:
    """Split text at empty lines."""
    blocks = [" ".join(block.split()) for block in text.replace("\r\n", "\n").split("\n\n")]
    return [block for block in blocks if block]


def aligned(rows: Sequence[Sequence[str]]) -> list[str]:
    """Return rows of cells as lines with aligned columns; a combining accent takes no column."""

    def width(text: str) -> int:
        return sum(not unicodedata.combining(letter) for letter in text)

    widths = [max(map(width, column)) for column in zip(*rows, strict=True)]
    return [
        "  ".join(
            cell + " " * (widest - width(cell)) for cell, widest in zip(row, widths, strict=True)
        ).rstrip()
        for row in rows
    ]
