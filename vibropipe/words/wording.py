"""Amounts and lists as a sentence has them."""

from __future__ import annotations

from collections.abc import Iterable


def count(amount: int, noun: str, plural: str | None = None) -> str:
    """Write an amount with its noun: ``1 impact``, ``3 impacts``."""
    return f"{amount} {noun if amount == 1 else plural or noun + 's'}"


def share(part: int, whole: int, noun: str) -> str:
    """Write a part of an amount with its verb: ``2 of 3 checks are``, ``0 of 1 check is``."""
    return f"{part} of {count(whole, noun)} {'is' if whole == 1 else 'are'}"


def series(words: Iterable[str]) -> str:
    """Join words as a sentence does: ``a``, ``a and b``, ``a, b and c``."""
    listed = list(words)
    if len(listed) < 2:
        return "".join(listed)
    return f"{', '.join(listed[:-1])} and {listed[-1]}"
