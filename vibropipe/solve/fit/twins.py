"""Other parameters that fit measurements as well as those found: mirror images, and sets within the noise."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from vibropipe.solve.fit.fit_model import Model, Search, refined
from vibropipe.solve.fit.fit_quality import CHANCE
from vibropipe.solve.fit.record_model import RecordModel, mirror_image
from vibropipe.words.designs import Twin

MAX_TWINS = 8
# Sets are two if the linear model tells them apart by so many times what noise alone moves them.
APART = 4.0


class Twins(NamedTuple):
    """Other sets of parameters that fit as well, the best first.

    points : (n, k)
    kinds : (n,), of `Twin`
    excess : (n,), what their sum of squares over the noise exceeds that of the parameters found
    """

    points: np.ndarray
    kinds: np.ndarray
    excess: np.ndarray


def find_twins(
    model: Model, found: Search, low: np.ndarray, high: np.ndarray, slopes: np.ndarray, scale: float
) -> Twins:
    """Return the sets of parameters that noise does not tell from those found [1]_.

    Their sum of squares is larger by no more than noise alone changes it in 999 of 1000 cases, and the linear model
    tells them apart from the parameters found and from each other, so that they lie in no common neighbourhood.

    low, high : (k,), ends of the ranges
    slopes : (n, k), derivatives of the misfits, in standard deviations of the noise, by the parameters
    scale : sum of squares over the noise, for each degree of freedom, of misfits weighted as in the model

    References
    ----------
    .. [1] S. S. Wilks, The large-sample distribution of the likelihood ratio for testing composite hypotheses, Annals
       of Mathematical Statistics 9 (1938) 60.
    """
    from scipy.stats import chi2

    limit, least = float(chi2.isf(CHANCE, low.size)), float(found.costs.min())
    ends = [
        (2 * (cost - least) / scale, end) for cost, end in zip(found.costs, found.ends, strict=True)
    ]
    image = mirror_image(model, found.best) if isinstance(model, RecordModel) else None
    if image is not None and ((image >= low) & (image <= high)).all():
        # By symmetry it fits exactly as well, from the mirrored start.
        ends.append((0.0, image))
    kept: list[tuple[float, np.ndarray, Twin]] = []
    known = [(found.best, False)]
    sign = _sign_at(model, found.best)
    for excess, end in sorted(ends, key=lambda each: (each[0], each[1] is not image)):
        if excess > limit:
            break
        here, is_reversed = _of_sensors(model, end, sign)
        near = [w for each, w in known if _distance(slopes, here - each) <= APART * limit]
        if is_reversed in near:
            continue
        known.append((here, is_reversed))
        others = Twin.MIRROR_IMAGE if near else Twin.REVERSED
        kept.append((excess, end, others if is_reversed else Twin.OTHER))
    kept = kept[:MAX_TWINS]
    return Twins(
        np.array([each[1] for each in kept]).reshape(len(kept), low.size),
        np.array([each[2] for each in kept], np.int8),
        np.array([each[0] for each in kept]),
    )


def _sign_at(model: Model, point: np.ndarray) -> float:
    """Return the sign of the first sensor of a record; 1 of other measurements."""
    return float(model.fit_at(point).signs[0]) if isinstance(model, RecordModel) else 1.0


def _of_sensors(model: Model, end: np.ndarray, sign: float) -> tuple[np.ndarray, bool]:
    """Return parameters with the sensors as at the best fit, mirrored if they are reversed, and whether they are.

    At the best fit the slopes are known; at a mirror image each support has those of the other. sign : of its sensor
    """
    if not isinstance(model, RecordModel) or _sign_at(model, end) == sign:
        return end, False
    image = mirror_image(model, end)
    return end if image is None else image, True


def _distance(slopes: np.ndarray, step: np.ndarray) -> float:
    """Return the sum of squares over the noise that a step of the parameters (k,) makes in the linear model."""
    return float(((slopes @ step) ** 2).sum())


def nearest_first(model: RecordModel, found: Search, low: np.ndarray, high: np.ndarray) -> Search:
    """Return a search whose best fit is that of sensors which are not reversed, where its mirror image fits as well."""
    image = mirror_image(model, found.best)
    if image is None or not ((image >= low) & (image <= high)).all():
        return found
    if model.fit_at(found.best).signs[0] > 0:
        return found
    end, cost = refined(model, image, low, high)
    if cost > found.costs.min() * (1 + 1e-6) or model.fit_at(end).signs[0] < 0:
        return found
    ends, costs = np.vstack([found.ends, end]), np.append(found.costs, cost)
    return found._replace(best=end, ends=ends, costs=costs)
