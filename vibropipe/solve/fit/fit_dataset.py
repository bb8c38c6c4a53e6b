"""The dataset of a fit: values found, how good the fit is, what it determines, and what fits as well."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.physics.effects import all_effect_names
from vibropipe.physics.start import start_text
from vibropipe.solve.design.goals import CURVE
from vibropipe.solve.fit.fit_model import Model, Search
from vibropipe.solve.fit.fit_quality import RESOLUTION, Quality, determined, quality_of
from vibropipe.solve.fit.record_model import RecordModel, RowFit
from vibropipe.solve.fit.twins import find_twins
from vibropipe.solve.origin_attrs import origin_attrs
from vibropipe.solve.rows.named import SIZES, Named
from vibropipe.words.vocabulary import describe, quantity

if TYPE_CHECKING:
    import xarray as xr


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
    parameters = {
        **model.exciter.stated(),
        **dict(zip(found, best.tolist(), strict=True)),
    }
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
    for suffix, values in (
        ("measured", data.values),
        ("fitted", fitted),
        ("noise", quality.noise),
    ):
        variables |= _by_quantity(data.names or [Named(CURVE, CURVE)], values, suffix)
    coords: dict[str, Any] = {
        name: ((), value)
        for name, value in parameters.items()
        if name not in {**data.over, **along}
    }
    if fit is not None and isinstance(model, RecordModel):
        variables |= _sensors(model, fit)
        coords["phase"] = ("measurement", fit.phase)
    coords |= {name: ("measurement", values) for name, values in {**data.over, **along}.items()}
    if len(twins.points):
        variables |= {
            f"{name}_twin": (("twin",), column)
            for name, column in zip(found, twins.points.T, strict=True)
        }
        variables |= {
            "twin_kind": (("twin",), twins.kinds),
            "twin_excess": (("twin",), twins.excess),
        }
        coords["twin"] = np.arange(1, len(twins.points) + 1)
    labelled = [(dims, np.shape(values)) for dims, values in variables.values()]
    sizes = {dim: n for dims, shape in labelled for dim, n in zip(dims, shape, strict=True)}
    coords |= {dim: np.arange(1, size + 1) for dim, size in sizes.items() if dim in SIZES}
    coords |= {"parameter": found, "other_parameter": found}
    coords["direction_of_fit"] = np.arange(1, len(found) + 1)
    values = {**vars(model.exciter), **parameters, **data.over, **along}
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
    qualities = [
        quality_of(
            data.values[kept] - offsets,
            fitted[kept] - offsets,
            misfits[kept],
            freedom,
            order,
            given,
        )
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
