"""The largest of the multipliers of orbits, and whether it is below 1 by more than its error."""

from __future__ import annotations

import numpy as np

from vibropipe.words.regimes import NEUTRAL_TOLERANCE


def largest_modulus(
    multipliers: np.ndarray, error: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Return the largest modulus (...,) of multipliers (..., n), and its error; NaN where that is not known."""
    moduli = np.abs(multipliers)
    if error is None:
        return moduli.max(axis=-1), np.full(moduli.shape[:-1], np.nan)
    largest = moduli.argmax(axis=-1)[..., None]
    return moduli.max(axis=-1), np.take_along_axis(error, largest, axis=-1)[..., 0].astype(float)


def decay(multipliers: np.ndarray, error: np.ndarray | None = None) -> np.ndarray:
    """Return by how much the largest modulus is below 1 (...,); 0 where rounding decides.

    multipliers : (..., n) complex
    error : (..., n), their errors; NEUTRAL_TOLERANCE where they are not known, as beside a housing that slides
    """
    modulus, margin = largest_modulus(multipliers, error)
    margin = np.where(np.isnan(margin), NEUTRAL_TOLERANCE, margin)
    below = 1.0 - modulus
    return np.where(np.abs(below) <= margin, 0.0, below)
