"""How good a fit to measurements is, and which parameters the measurements determine."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from vibropipe.words.designs import FitResult, FoundResult

# A misfit is beyond the noise if noise alone is as large in fewer than 1 of 1000 cases; as deviations of a normal variable.
CHANCE, CHANCE_DEVIATIONS = 1e-3, 3.09
# Share of the largest measured value below which a misfit is that of the model: a curve is interpolated.
RESOLUTION = 1e-6
# Directions whose effect is this share of the largest one are without effect: derivatives are differences.
SINGULAR = 1e-7
# A parameter takes part in a direction by more than this, in shares of the ranges.
PART = 1e-6
# Within this share of its range from an end a parameter ended there.
AT_END = 1e-6


class Quality(NamedTuple):
    """The quality of a fit.

    Attributes
    ----------
    noise : (q,) array
        Standard deviation of each quantity: given, or estimated.
    chi : float
        Sum of squares over the noise, over the degrees of freedom.
    limit : float
        The largest that noise alone gives in 999 of 1000 cases; infinite where too few numbers can tell.
    result : FitResult
    """

    noise: np.ndarray
    chi: float
    limit: float
    result: FitResult


def quality_of(
    measured: np.ndarray,
    fitted: np.ndarray,
    misfits: np.ndarray,
    freedom: int,
    order: np.ndarray,
    noise: np.ndarray | None,
) -> Quality:
    """Return the quality of a fit.

    Without given noise it is estimated from the differences of successive misfits [1]_: noise has no memory, and what a
    model leaves has.

    Parameters
    ----------
    measured, fitted, misfits : (n, q) array
        Fitted values are NaN where the motion has none.
    freedom : int
        Numbers less parameters.
    order : (n,) int array
        Measurements in the order of the phase or of the swept parameters.
    noise : (q,) array, optional
        Standard deviations.

    References
    ----------
    .. [1] J. von Neumann, Distribution of the ratio of the mean square successive difference to the variance, Annals of
       Mathematical Statistics 12 (1941) 367.
    """
    from scipy.stats import chi2

    floor = RESOLUTION * np.maximum(np.abs(measured).max(axis=0), np.finfo(float).tiny)
    if noise is not None:
        sigma, limit = noise, float(chi2.isf(CHANCE, freedom)) / freedom
    else:
        steps = np.diff(misfits[order], axis=0)
        sigma = np.maximum(np.sqrt((steps**2).mean(axis=0) / 2), floor)
        limit = _ratio_limit(len(misfits))
    chi = float((misfits**2 / sigma**2).sum()) / freedom
    return Quality(sigma, chi, limit, _result(measured, fitted, chi, limit, sigma))


def _ratio_limit(n: int) -> float:
    """Return the largest ratio of the variance of n numbers without memory to that of their successive differences."""
    # The mean square successive difference over twice the variance has mean 1 and this standard deviation.
    left = 1.0 - CHANCE_DEVIATIONS * np.sqrt(max(n - 2, 1) / max(n**2 - 1, 1))
    return float(1.0 / left) if left > 0 else np.inf


def _result(
    measured: np.ndarray, fitted: np.ndarray, chi: float, limit: float, sigma: np.ndarray
) -> FitResult:
    """Return the verdict."""
    if not np.isfinite(fitted).all():
        return FitResult.ABSENT
    is_silent = (measured**2).sum(axis=0) <= len(measured) * limit_of_silence(sigma)
    if (len(measured) > 2 and (np.ptp(measured, axis=0) == 0).any()) or is_silent.any():
        return FitResult.CONSTANT
    if chi > limit:
        return FitResult.BEYOND_NOISE
    return FitResult.EXPLAINED if np.isfinite(limit) else FitResult.NOT_JUDGED
