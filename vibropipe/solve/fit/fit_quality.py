"""How good a fit to measurements is, and which parameters the measurements determine."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from vibropipe.words.designs import FitResult, FoundResult

# A misfit is beyond the noise if noise alone is as large in fewer than 1 of 1000 cases; in deviations of a normal one.
CHANCE, CHANCE_DEVIATIONS = 1e-3, 3.09
# With fewer than eleven numbers noise alone may fall below this share of its usual differences: they do not tell it.
LEAST_LEFT = 0.15
# Share of the largest value below which a misfit is that of the model: a curve is interpolated.
RESOLUTION = 1e-6
# Size of a quantity that is zero throughout.
SMALLEST = 1e-12
# Directions whose effect is this share of the largest one are without effect: derivatives are differences.
SINGULAR = 1e-7
# A parameter takes part in a direction by more than this, in shares of the ranges.
PART = 1e-6
# Within this share of its range from an end a parameter ended there.
AT_END = 1e-6


class Quality(NamedTuple):
    """The quality of a fit.

    noise : (q,), standard deviation of each quantity: given, or estimated
    chi : sum of squares over the noise, over the degrees of freedom
    limit : the largest that noise alone gives in 999 of 1000 cases; infinite where too few numbers can tell
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

    measured, fitted, misfits : (n, q), fitted values are NaN where the motion has none
    freedom : numbers less parameters
    order : (n,), measurements in the order of the phase or of the swept parameters
    noise : (q,), standard deviations

    References
    ----------
    .. [1] J. von Neumann, Distribution of the ratio of the mean square successive difference to the variance, Annals of
       Mathematical Statistics 12 (1941) 367.
    """
    from scipy.stats import chi2

    sizes = np.abs(np.nan_to_num(np.vstack([measured, fitted]))).max(axis=0)
    floor = RESOLUTION * np.maximum(sizes, SMALLEST)
    if noise is not None:
        sigma, limit = noise, float(chi2.isf(CHANCE, freedom)) / freedom
    else:
        steps = np.diff(misfits[order], axis=0)
        sigma = np.maximum(np.sqrt((steps**2).mean(axis=0) / 2), floor)
        limit = _ratio_limit(len(misfits))
    chi = float((misfits**2 / sigma**2).sum()) / freedom
    # With estimated noise a mean that fits as well as the motion is explained by no motion.
    signal = measured if noise is not None else measured - measured.mean(axis=0)
    power = (signal**2 / sigma**2).sum(axis=0)
    is_noise = bool((power <= chi2.isf(CHANCE, len(measured))).all())
    return Quality(sigma, chi, limit, _result(measured, fitted, chi, limit, is_noise))


def _ratio_limit(n: int) -> float:
    """Return the largest ratio of the variance of n numbers without memory to that of their successive differences."""
    # The mean square successive difference over twice the variance has mean 1 and this standard deviation.
    left = 1.0 - CHANCE_DEVIATIONS * np.sqrt(max(n - 2, 1) / max(n**2 - 1, 1))
    return float(1.0 / left) if left > LEAST_LEFT else np.inf


def _result(
    measured: np.ndarray, fitted: np.ndarray, chi: float, limit: float, is_noise: bool
) -> FitResult:
    """Return whether the misfit is no larger than the noise; nothing is explained where only noise was measured."""
    if not np.isfinite(fitted).all():
        return FitResult.ABSENT
    if len(measured) > 2 and (np.ptp(measured, axis=0) == 0).any():
        return FitResult.CONSTANT
    if not np.isfinite(limit):
        return FitResult.NOT_JUDGED
    if chi > limit:
        return FitResult.BEYOND_NOISE
    if is_noise:
        return FitResult.CONSTANT
    return FitResult.EXPLAINED


class Determined(NamedTuple):
    """What the measurements determine.

    covariance : (k, k), of the parameters found; infinite along directions without effect
    singular_values : (k,), change of the fit along each direction, over all of the ranges, in standard deviations of
        the noise
    directions : (k, k), directions in rows, in shares of the ranges
    results : (k,), FoundResult of each parameter
    """

    covariance: np.ndarray
    singular_values: np.ndarray
    directions: np.ndarray
    results: np.ndarray


def determined(
    slopes: np.ndarray, scale: float, found: np.ndarray, low: np.ndarray, high: np.ndarray
) -> Determined:
    """Return which parameters a fit determines, from its singular directions [1]_.

    slopes : (n, k), derivatives of the misfits, in standard deviations of the noise, by the parameters
    scale : what the covariance is multiplied by
    found, low, high : (k,), values found, and the ends of their ranges

    References
    ----------
    .. [1] G. H. Golub, C. F. Van Loan, Matrix Computations, 4th ed., Johns Hopkins 2013, section 5.5.
    """
    width = high - low
    _, singular, directions = np.linalg.svd(slopes * width, full_matrices=False)
    is_blind = singular <= SINGULAR * max(float(singular.max()), np.finfo(float).tiny)
    seen = directions[~is_blind] / singular[~is_blind, None]
    covariance = scale * (seen.T @ seen) * np.outer(width, width)
    for direction in directions[is_blind]:
        takes_part = np.where(np.abs(direction) > PART, direction, 0.0)
        signs = np.sign(np.outer(takes_part, takes_part))
        with np.errstate(invalid="ignore"):
            covariance = np.where(signs != 0, covariance + signs * np.inf, covariance)
    std = np.sqrt(np.diag(covariance))
    share = (found - low) / width
    results = np.where(
        std >= width, FoundResult.UNDETERMINED,
        np.where(np.minimum(share, 1 - share) < AT_END, FoundResult.AT_RANGE, FoundResult.DETERMINED),
    ).astype(np.int8)  # fmt: skip
    return Determined(covariance, singular, directions, results)
