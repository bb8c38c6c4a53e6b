"""Where a list of short texts is broken into lines that fit on a figure."""

from __future__ import annotations

import re

import numpy as np

LINE_DIGITS = (
    95  # width of a line of parameters across a figure, in digits: 14.6 cm, with many units 15.6 cm
)


def in_lines(parts: list[str]) -> str:
    """Join texts by commas, in as few lines of at most LINE_DIGITS as they need, all about as long."""
    ends = np.cumsum([width_in_digits(f"{part},  ") for part in parts])
    for amount in range(1, len(parts) + 1):
        middles = ends - np.diff(ends, prepend=0) / 2
        line_of = (amount * middles / ends[-1]).astype(int)
        lines = [
            ",  ".join(part for part, n in zip(parts, line_of, strict=True) if n == line)
            for line in dict.fromkeys(line_of.tolist())
        ]
        if max(map(width_in_digits, lines)) <= LINE_DIGITS:
            break
    return ",\n".join(lines) if parts else ""


def width_in_digits(text: str) -> float:
    """Return about how wide a mathtext is, in digits: spaces and points are narrow, capitals and signs are wide."""
    shown = re.sub(r"[${}^_]", "", re.sub(r"\\[A-Za-z]+ ?", "x", text))
    narrow = sum(letter in " ,.·/" for letter in shown)
    wide = sum(letter.isupper() or letter in "=−" for letter in shown)
    return len(shown) - 0.5 * narrow + 0.4 * wide
