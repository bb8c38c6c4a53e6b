"""The function `identify`: the parameters that explain a measured motion or response."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.physics.effects import all_effect_names
from vibropipe.physics.exciter import Exciter, ParameterError, Parameters
from vibropipe.physics.parameter_error import number_within
from vibropipe.physics.ties import Ties
from vibropipe.solve.checks import check_whole
from vibropipe.solve.design.goals import CURVE
from vibropipe.solve.design.ranges import at_lower_ends, check_vary
from vibropipe.solve.fit.fit_model import Measured, Model, search, with_absent
from vibropipe.solve.fit.fit_quality import determined, quality_of
from vibropipe.solve.origin_attrs import origin_attrs
from vibropipe.solve.rows.named import SIZES, Named, named
from vibropipe.words.designs import DESIGN_SAMPLES
from vibropipe.words.records import POSITIVE
from vibropipe.words.vocabulary import describe, quantity

if TYPE_CHECKING:
    import xarray as xr

SAMPLES = 128
A_TABLE = "a table with columns phase and displacement, or with swept parameters and quantities"


def identify(
    exciter: Exciter,
    measured: Any,
    vary: Mapping[str, tuple[float, float]],
    x0: float | None = None,
    v0: float = 0.0,
    noise: Mapping[str, float] | None = None,
    samples: int = SAMPLES,
    ties: Mapping[str, Any] | None = None,
) -> xr.Dataset:
    """Find the parameters nearest to a measured motion or response in weighted least squares, and how near they are.

    Samples of low discrepancy in the ranges of `vary` come first; the best are refined [1]_. The covariance is that of
    the linear model at the solution [2]_.

    Parameters
    ----------
    exciter : Exciter
        The parameters that are known.
    measured : pandas.DataFrame or mapping of str to array_like
        A motion: `phase`, in forcing periods after a rising zero of sin(nu tau), and `displacement`. Or a response:
        swept parameters (nu) and quantities named as the columns of `table` are. `pandas.read_csv` reads either.
    vary : mapping of str to (float, float)
        Lower and upper end of each parameter to be found, or name that `ties` use.
    x0, v0 : float, optional
        Start of every motion, as for `steady_state`.
    noise : mapping of str to float, optional
        Standard deviation of each measured quantity; needed for several. Otherwise it is estimated from the differences
        of successive misfits.
    samples : int
        Number of samples, from 8 to 1e6.
    ties : mapping of str to str or float, optional
        Parameters by expressions of others, swept ones included, or of names of one's own, as of `sweep`.

    Returns
    -------
    xarray.Dataset
        <parameter>, <parameter>_std
            Each parameter; of the varied ones the value found, and its standard deviation: infinite if the measurements
            do not depend on it, or on a combination of it with others alone.
        parameter_covariance (parameter, other_parameter)
            Covariance of the values found.
        parameter_result (parameter)
            Whether the measurements determine a parameter, it ended at its range, or its deviation is as wide as that.
        singular_value (direction_of_fit), singular_vector (direction_of_fit, parameter)
            Change of the fit along orthogonal directions, over all of the ranges, in deviations of the noise.
        <name>_measured, <name>_fitted (measurement)
            Each quantity, measured and computed.
        <name>_noise
            Standard deviation of each quantity: given, or estimated.
        reduced_chi_square, reduced_chi_square_limit
            Sum of squares of misfits over the noise, over the degrees of freedom; what noise alone exceeds in one of
            1000 cases.
        fit_result
            explained: the misfit is within that limit. beyond_noise: it is not. constant: a quantity has one value
            only, or all are no larger than the noise. absent: the motion found lacks a measured quantity. not_judged:
            too few measurements to estimate their noise.

    Raises
    ------
    ParameterError
        If a name, a range or a table is wrong, or there are not more numbers than parameters.

    References
    ----------
    .. [1] M. A. Branch, T. F. Coleman, Y. Li, A subspace, interior, and conjugate gradient method for large-scale
       bound-constrained minimization problems, SIAM Journal on Scientific Computing 21 (1999) 1.
    .. [2] D. M. Bates, D. G. Watts, Nonlinear Regression Analysis and Its Applications, Wiley 1988.
    """
    tied = Ties(ties)
    swept = _first_of_swept(measured)
    ranges = check_vary(exciter, vary, tied, swept)
    data = read_measured(measured, ranges, noise)
    check_whole("samples", samples, DESIGN_SAMPLES)
    exciter = at_lower_ends(exciter, ranges, tied, swept)
    exciter.check_start(x0, v0)
    low, high = np.array(list(ranges.values())).T
    found = [*ranges]
    model = Model(exciter, data, found, x0, v0, np.zeros(1), high - low, tied)
    model = with_absent(model, low, high)
    best = search(model, low, high, samples)
    over = {name: data.over[name] for name in swept}
    tied.checked({**exciter.numbers()._asdict(), **over, **dict(zip(found, best, strict=True))})
    return _dataset(model, best, low, high)


def _first_of_swept(measured: Any) -> dict[str, float]:
    """Return the first value of each column that is a parameter; none of a table that `read_measured` refuses."""
    try:
        names = [str(name) for name in measured if name in Parameters._fields]
        return {name: float(np.ravel(measured[name])[0]) for name in names}
    except (KeyError, TypeError, ValueError, IndexError):
        return {}


def read_measured(
    measured: Any, ranges: Mapping[str, Any], noise: Mapping[str, float] | None
) -> Measured:
    """Return a table of measurements, or raise a ParameterError."""
    try:
        table = {str(name): np.asarray(measured[name], float) for name in measured}
    except (KeyError, TypeError, ValueError, IndexError):
        raise ParameterError("measured", measured, A_TABLE, got="another value") from None
    sizes = {values.shape for values in table.values()}
    if len(sizes) != 1 or len(sizes.copy().pop()) != 1:
        raise ParameterError("measured", measured, A_TABLE, got="columns of different lengths")
    if not all(np.isfinite(values).all() for values in table.values()):
        raise ParameterError("measured", measured, "a table of finite numbers", got="nan")
    if {"phase", CURVE} == {*table}:
        over, names, values = {"phase": table["phase"]}, [], table[CURVE][:, None]
    else:
        over = {name: table[name] for name in table if name in Parameters._fields}
        names = [named(name, "measured") for name in table if name not in over]
        if not over or not names:
            raise ParameterError("measured", measured, A_TABLE, got=", ".join(table))
        for name in over.keys() & ranges.keys():
            must = f"must leave out {name}, since it stands in the table"
            raise ParameterError("vary", ranges, must=must, got="")
        values = np.column_stack([table[name.name] for name in names])
    columns = [name.name for name in names] or [CURVE]
    if noise is None and len(columns) > 1:
        must = f"is required, since several quantities are measured ({', '.join(columns)})"
        raise ParameterError("noise", noise, must=must, got="")
    if noise is not None and {*noise} != {*columns}:
        must = f"must have the measured quantities as keys ({', '.join(columns)})"
        raise ParameterError("noise", noise, must=must, got=", ".join(noise))
    if values.size <= len(ranges):
        must = f"must have more numbers than parameters to be found ({len(ranges)})"
        raise ParameterError("measured", values.size, must=must)
    sigma = [number_within(f"noise.{c}", (noise or {}).get(c, 1.0), POSITIVE) for c in columns]
    return Measured(over, values, names, 1 / np.array(sigma), noise is not None)


def _dataset(model: Model, best: np.ndarray, low: np.ndarray, high: np.ndarray) -> xr.Dataset:
    """Return the values found, how good the fit is and what it determines, as a labelled dataset."""
    import xarray as xr

    data, found, fitted = model.data, model.found, model.values(best[None])[0]
    misfits = model.residuals(best[None])[0].reshape(data.values.shape) / data.weights
    order = np.lexsort([*data.over.values()][::-1])
    given = 1 / data.weights if data.has_noise else None
    freedom = misfits.size - best.size
    quality = quality_of(data.values, fitted, misfits, freedom, order, given)
    weights = np.tile(1 / (data.weights * quality.noise), len(data.values))
    slopes = model.jacobian(best) * weights[:, None]
    known = determined(slopes, 1.0 if data.has_noise else quality.chi, best, low, high)
    parameters = {
        **model.exciter.stated(),
        **dict(zip(found, best.tolist(), strict=True)),
    }
    numbers = model.exciter.numbers()._asdict()
    tied = model.ties.values({**numbers, **parameters, **data.over})
    parameters |= {name: value for name, value in tied.items() if np.ndim(value) == 0}
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
    for suffix, values in (
        ("measured", data.values),
        ("fitted", fitted),
        ("noise", quality.noise),
    ):
        variables |= _by_quantity(data.names or [Named(CURVE, CURVE)], values, suffix)
    coords: dict[str, Any] = {
        name: ((), value) for name, value in parameters.items() if name not in data.over
    }
    along = {name: values for name, values in tied.items() if np.ndim(values)}
    coords = {name: value for name, value in coords.items() if name not in along}
    coords |= {name: ("measurement", values) for name, values in {**data.over, **along}.items()}
    labelled = [(dims, np.shape(values)) for dims, values in variables.values()]
    sizes = {dim: n for dims, shape in labelled for dim, n in zip(dims, shape, strict=True)}
    coords |= {dim: np.arange(1, size + 1) for dim, size in sizes.items() if dim in SIZES}
    coords |= {"parameter": found, "other_parameter": found}
    coords["direction_of_fit"] = np.arange(1, len(found) + 1)
    start = f"x0 = {model.x0 or 0.0:g}, v0 = {model.v0:g}"
    effects = all_effect_names(
        {**vars(model.exciter), **parameters, **data.over, **along}, pieces=True, housing=True
    )
    attrs = origin_attrs(effects, start) | {"noise": "given" if data.has_noise else "estimated"}
    attrs |= model.ties.attrs
    return describe(xr.Dataset(variables, coords, attrs))


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
