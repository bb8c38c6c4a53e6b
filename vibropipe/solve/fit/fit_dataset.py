"""The dataset of a fit: values found, how good the fit is, what it determines, and what fits as well."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vibropipe.physics.effects import all_effect_names
from vibropipe.physics.start import start_text
from vibropipe.solve.design.goals import CURVE
from vibropipe.solve.fit.fit_model import Model, Search, refined
from vibropipe.solve.fit.fit_quality import CHANCE, RESOLUTION, Quality, determined, quality_of
from vibropipe.solve.fit.record_model import RecordModel, RowFit, mirror_image
from vibropipe.solve.origin_attrs import origin_attrs
from vibropipe.solve.rows.named import SIZES, Named
from vibropipe.words.designs import Twin
from vibropipe.words.vocabulary import describe, quantity

if TYPE_CHECKING:
    import xarray as xr


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
    image = mirror_image(model, found.best)
    if image is not None and ((image >= low) & (image <= high)).all():
        if isinstance(model, RecordModel):
            # By symmetry it fits exactly as well, from the mirrored start.
            ends.append((0.0, image))
        else:
            ends.append(((float(model.costs(image[None])[0]) - 2 * least) / scale, image))
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


# Least sum of squares over an estimated noise: numbers that fit exactly are known to their rounding.
ROUNDING = (np.finfo(float).eps / RESOLUTION) ** 2


def fit_dataset(model: Model, search: Search, low: np.ndarray, high: np.ndarray) -> xr.Dataset:
    """Return the values found, how good the fit is, what it determines and what fits as well, as a labelled dataset."""
    import xarray as xr

    data, found, best = model.data, model.found, search.best
    fit = model.fit_at(best) if isinstance(model, RecordModel) else None
    fitted = model.values(best[None])[0] if fit is None else fit.values
    quality = fit_quality(model, best, fitted, fit)
    weights = np.tile(1 / (data.weights * quality.noise), len(data.values))
    slopes = model.jacobian(best) * weights[:, None]
    spread = 1.0 if data.has_noise else max(quality.chi, ROUNDING)
    known = determined(slopes, spread, best, low, high)
    scale = spread * float(np.mean((data.weights * quality.noise) ** 2))
    twins = find_twins(model, search, low, high, slopes / np.sqrt(spread), scale)
    parameters = model.exciter.stated() | dict(zip(found, best.tolist(), strict=True))
    numbers = model.exciter.numbers()._asdict()
    tied = model.ties.values({**numbers, **parameters, **data.over})
    along = {name: values for name, values in tied.items() if np.ndim(values)}
    parameters |= {name: value for name, value in tied.items() if name not in along}
    variables: dict[str, Any] = {
        "parameter_covariance": (("parameter", "other_parameter"), known.covariance),
        "parameter_result": (("parameter",), known.results),
        "singular_value": (("direction_of_fit",), known.singular_values),
        "singular_vector": (("direction_of_fit", "parameter"), known.directions),
        "reduced_chi_square": ((), quality.chi),
        "reduced_chi_square_limit": ((), quality.limit),
        "fit_result": ((), np.int8(quality.result)),
    }
    sigma = np.sqrt(np.diag(known.covariance))
    for suffix, column in (("std", sigma), ("lower", low), ("upper", high)):
        variables |= {f"{n}_{suffix}": ((), value) for n, value in zip(found, column, strict=True)}
    if isinstance(model, RecordModel):
        fitted = np.where(model.record.is_clipped, np.nan, fitted)
    over = {**data.over, **along}
    by_suffix = {"measured": data.values, "fitted": fitted, "noise": quality.noise}
    for suffix, values in by_suffix.items():
        variables |= _by_quantity(data.names or [Named(CURVE, CURVE)], values, suffix)
    coords: dict[str, Any] = {n: ((), v) for n, v in parameters.items() if n not in over}
    if fit is not None and isinstance(model, RecordModel):
        variables |= _sensors(model, fit)
        coords["phase"] = ("measurement", fit.phase)
    coords |= {name: ("measurement", values) for name, values in over.items()}
    if len(twins.points):
        variables |= {
            f"{name}_twin": (("twin",), column)
            for name, column in zip(found, twins.points.T, strict=True)
        }
        variables["twin_kind"] = (("twin",), twins.kinds)
        variables["twin_excess"] = (("twin",), twins.excess)
        coords["twin"] = np.arange(1, len(twins.points) + 1)
    labelled = [(dims, np.shape(values)) for dims, values in variables.values()]
    sizes = {dim: n for dims, shape in labelled for dim, n in zip(dims, shape, strict=True)}
    coords |= {dim: np.arange(1, size + 1) for dim, size in sizes.items() if dim in SIZES}
    coords |= {"parameter": found, "other_parameter": found}
    coords["direction_of_fit"] = np.arange(1, len(found) + 1)
    values = {**vars(model.exciter), **parameters, **over}
    effects = all_effect_names(values, pieces=True, housing=True)
    start = start_text(values, model.x0, model.v0)
    attrs = origin_attrs(effects, start) | {"noise": "given" if data.has_noise else "estimated"}
    attrs |= model.ties.attrs | {"samples": search.samples}
    return describe(xr.Dataset(variables, coords, attrs))


def fit_quality(model: Model, best: np.ndarray, fitted: np.ndarray, fit: RowFit | None) -> Quality:
    """Return the quality of a fit; of a record from the samples that count in all columns."""
    data = model.data
    misfits = model.residuals(best[None])[0].reshape(data.values.shape) / data.weights
    given = 1 / data.weights if data.has_noise else None
    if fit is None or not isinstance(model, RecordModel):
        order = np.lexsort([*data.over.values()][::-1])
        freedom = misfits.size - best.size
        return quality_of(data.values, fitted, misfits, freedom, order, given)
    kept = ~model.record.is_clipped.any(axis=1)
    if np.isfinite(fitted).any():
        kept &= np.isfinite(fitted).all(axis=1)
    # Phase and offsets are found as well.
    n_found = best.size + data.values.shape[1] + model.record.finds_phase
    freedom = max(misfits[kept].size - n_found, 1)
    offsets, by_phase = np.nan_to_num(fit.offsets), np.argsort(fit.phase[kept], kind="stable")
    # A wrong orbit leaves what has a memory over the phase, a transient or a drift what has one over time.
    measured, found = data.values[kept] - offsets, fitted[kept] - offsets
    qualities = [
        quality_of(measured, found, misfits[kept], freedom, order, given)
        for order in (by_phase, np.arange(by_phase.size))
    ]
    return max(qualities, key=lambda each: each.chi)


def _sensors(model: RecordModel, fit: RowFit) -> dict[str, Any]:
    """Return what was found of each sensor, and how many samples do not count."""
    left_out = model.record.is_clipped | np.isnan(fit.values)
    columns = zip(model.record.columns, fit.offsets, fit.signs, left_out.T, strict=True)
    variables: dict[str, Any] = {"transient_samples": ((), model.record.transient)}
    for name, offset, sign, left in columns:
        variables |= {
            f"{name}_offset": ((), float(offset)),
            f"{name}_sign": ((), float(sign)),
            f"{name}_left_out": ((), int(left.sum())),
        }
    return variables


def _by_quantity(names: list[Named], values: np.ndarray, suffix: str) -> dict[str, Any]:
    """Return columns (..., q) as variables, the parts of a vector over its dimension; NaN of parts not measured."""
    variables: dict[str, Any] = {}
    dims = ("measurement",) if values.ndim == 2 else ()
    for variable in dict.fromkeys(name.variable for name in names):
        columns = [n for n, name in enumerate(names) if name.variable == variable]
        if names[columns[0]].number is None:
            variables[f"{variable}_{suffix}"] = (dims, values[..., columns[0]])
            continue
        numbers = [(names[n].number or 1) - 1 for n in columns]
        parts = np.full((*values.shape[:-1], max(numbers) + 1), np.nan)
        parts[..., numbers] = values[..., columns]
        (dim,) = quantity(variable).dims
        variables[f"{variable}_{suffix}"] = ((*dims, f"{dim}"), parts)
    return variables
