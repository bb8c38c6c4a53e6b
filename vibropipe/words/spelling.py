"""Spelling of keys: Greek letters, look-alike letters, the nearest known word, what a damping ratio is written as."""

from __future__ import annotations

import difflib
import re
import unicodedata
from collections.abc import Collection, Iterable
from typing import Any

from vibropipe.words.parameters import PARAMETERS
from vibropipe.words.vocabulary import PLAIN_SYMBOLS

_SPELLED = (*PARAMETERS, "tau", "omega")
GREEK = {name: PLAIN_SYMBOLS[name] for name in _SPELLED if not PLAIN_SYMBOLS[name].isascii()}
_TO_LATIN = str.maketrans(
    {"₁": "1", "₂": "2", "φ": "phi"} | {s: name for name, s in GREEK.items() if len(s) == 1}
)

# Letters that look like others, as typed or copied from a PDF; used for hints only.
_LOOK_ALIKE = str.maketrans(
    {"а": "a", "е": "e", "о": "o", "р": "p", "с": "c", "т": "t", "у": "y", "х": "x", "і": "i"}
    | {"һ": "h", "н": "h", "ӏ": "l", "ѕ": "s", "м": "m", "к": "k", "ο": "o", "ι": "i", "α": "a"}
    | {"ѵ": "nu", "ʋ": "nu", "υ": "nu", "Ν": "nu", "ƒ": "f", "ғ": "f", "Ƒ": "f"}
    | {"∂": "delta", "ẟ": "delta", "Δ": "delta", "∆": "delta", "ð": "delta", "Τ": "tau"}
)
_SLIPS = {"v": "nu", "I": "l", "1": "l", "d": "delta", "omega": "nu", "ω": "nu"}
_SLIPS |= {"frequency": "omega", "freq": "omega"}

# Former names of keys.
OLD_KEYS = {"beside": "backbone"}


def latin(key: Any) -> Any:
    """Return a key with `ν δ τ φ ₁ ₂` spelled out, under its present name; other values unchanged."""
    if not isinstance(key, str):
        return key
    spelled = key.translate(_TO_LATIN)
    return OLD_KEYS.get(spelled, spelled)


def greek(key: str) -> str:
    """Return the Greek spelling of a key, the inverse of `latin`, or the key itself."""
    for word, letter in GREEK.items():
        if key == word or (word in ("tau", "delta") and key.startswith(f"{word}_")):
            return letter + key[len(word) :]
    return key


def _skeleton(word: str) -> str:
    return latin(unicodedata.normalize("NFKC", word)).translate(_LOOK_ALIKE)


def nearest(word: str, known: Iterable[str]) -> str | None:
    """Return the known word that is closest to `word`, or None."""
    choices = list(known)
    plain = _skeleton(word[:80])
    for guess in (plain, _SLIPS.get(plain), plain.upper(), plain.lower()):
        if guess in choices:
            return guess
    lowered = {choice.lower(): choice for choice in choices}
    close = difflib.get_close_matches(plain.lower(), lowered, n=1)
    return lowered[close[0]] if close else None


def only_looks_right(word: str, near: str) -> bool:
    """Return whether `word` differs from `near` only by letters of another alphabet."""
    return not word.isascii() and _skeleton(word) == near


def did_you_mean(word: Any, known: Iterable[str]) -> str:
    """Return the hint for a word that is none of `known`, or an empty text when nothing is near."""
    near = nearest(word, known) if isinstance(word, str) else None
    if near is None:
        return ""
    disguised = "; some of its letters only look right" if only_looks_right(word, near) else ""
    return f"did you mean {near!r}?{disguised}"


def hint_of_key(key: Any, known: Iterable[str]) -> str:
    """Return the hint for a key that is none of `known`: what states a damping ratio, else the nearest that exists."""
    choices = list(known)
    return _damping_ratio(str(key), choices) or did_you_mean(key, choices)


def _damping_ratio(key: str, choices: Collection[str]) -> str:
    """Return what to write for a damping ratio; empty for any other key."""
    match = re.fullmatch(r"(?:zeta|ζ|ξ|xi|damping_?ratio)_?([12₁₂]?)", key, re.IGNORECASE)
    if match is None:
        return ""
    n = match[1].translate(str.maketrans("₁₂", "12"))
    if f"h{n}" in choices:
        return f"a damping ratio is written as h{n} = 2 zeta" + (f" sqrt(k{n})" if n else "")
    return f"a damping ratio is written as H{n} = 2 zeta sqrt(m C{n})" if f"H{n}" in choices else ""
