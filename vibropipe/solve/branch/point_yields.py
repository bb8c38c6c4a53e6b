"""What share of scattered parts keeps the law of motion and bounds at points of branches, and what foretells which."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.orbits.law.problem import Problem
from vibropipe.physics.exciter import ParameterError, Parameters
from vibropipe.solve.branch.problem import NO_TIES
from vibropipe.solve.design.goals import Bound, Goals, bounds_of_parts, check_presence
from vibropipe.solve.design.scattered_parts import Tied, moved_rows
from vibropipe.solve.design.sorting import kept_parts, sorting_variables, stacked, yield_variables
from vibropipe.solve.design.tolerance import spread_names
from vibropipe.solve.rows.label import Variables
from vibropipe.solve.rows.named import Named, outputs_of
from vibropipe.solve.rows.points import Points, solve_points
from vibropipe.words.outputs import OF_BRANCH, OF_STEADY_STATE, OUTPUTS
from vibropipe.words.vocabulary import STEADY, describe

if TYPE_CHECKING:
    import xarray as xr

# Scattered parts of a point: 0.1 s of two cores, and an interval of 4 % at most at a share of 90 %.
PARTS = 1024
# Points that parts are scattered at where none are wanted: some seconds, of soft supports a minute.
MAX_POINTS = 32
SHARES = ("yield", "yield_low", "yield_high", "law_yield")
LAW = ("regime", "period_multiple", "impacts_per_orbit", "stable")
STATE = ("displacement_strobe", "velocity_strobe", "housing_velocity_strobe")


def check_bounds(
    values: Mapping[str, Any],
    varied: Collection[str],
    subject_to: Mapping[str, Any] | None,
    tolerance: Mapping[str, float] | None,
) -> tuple[Bound, ...] | None:
    """Return the bounds that parts are to keep, None without a yield; ParameterError for bounds that no part has.

    values : of parameters; varied : those that have other values on the branch
    """
    if subject_to is None:
        return None
    if not tolerance:
        must = "is required beside subject_to: parts scatter by it"
        raise ParameterError("tolerance", tolerance, must=must, got="")
    bounds = bounds_of_parts(subject_to)
    for name in (bound.quantity for bound in bounds):
        argument = f"subject_to.{name.name}"
        if name.is_place:
            must = "must be a quantity of the motion: the branch of each part would have to be followed"
            raise ParameterError(argument, None, must=must, got="")
        if STEADY[name.variable].output not in ("", *OF_BRANCH):
            must = "must be a quantity that the points of a branch have"
            raise ParameterError(argument, None, must=must, got="")
    check_presence({**values, **dict.fromkeys(varied, 1.0)}, Goals(bounds, ()))
    return bounds


def outputs_beside(outputs: Sequence[str], bounds: Sequence[Bound] | None) -> tuple[str, ...]:
    """Return the outputs of points with those that their yields need."""
    more = () if bounds is None else outputs_of(bound.quantity for bound in bounds)
    return tuple(name for name in OUTPUTS if name in {*outputs, *more})


def with_yields(
    dataset: xr.Dataset,
    problem: Problem,
    tolerance: Mapping[str, float] | None,
    bounds: Sequence[Bound] | None,
    at: Sequence[float],
) -> xr.Dataset:
    """Return a dataset of branches with the yields of some of its points and their sorting rules; NaN at the others.

    It stays as it is without bounds, which may be none.

    dataset : without units, with the outputs of `outputs_beside`
    tolerance : standard deviations of parameters
    at : values of the parameter that yields are wanted at; if empty they are those of MAX_POINTS points
    """
    if bounds is None or tolerance is None:
        return dataset
    sigma = {name: float(tolerance[name]) for name in Parameters._fields if name in tolerance}
    harmonics = dataset.sizes.get("harmonic", 1)
    names = spread_names(harmonics, dataset.data_vars)
    law: Variables = {
        name: (("row", *map(str, dataset[name].dims[1:])), dataset[name].values) for name in LAW
    }
    laws = Points(np.empty((dataset.sizes["point"], 0)), law).laws
    size, chosen = len(laws), _chosen(dataset, problem.name, at)
    yields, rules, best = list[Variables](), list[Variables](), np.full(size, "", object)
    for point in chosen.tolist():
        parts = _parts(dataset.isel(point=point), problem, sigma, [b.quantity for b in bounds])
        own, law_of_point = parts.take(slice(PARTS, None)), laws[point]
        each, kept = kept_parts(bounds, parts, law_of_point, PARTS, problem.values[L])
        yields.append(yield_variables(bounds, parts, law_of_point, each, kept))
        found, best[point] = sorting_variables(names, [*sigma], own, parts, kept)
        rules.append(found)
    # Without a stable point that is wanted, too, there are shares.
    variables: dict[str, Any] = {name: (("point",), np.full(size, np.nan)) for name in SHARES}
    for name, (dims, values) in (stacked(yields, "point") | stacked(rules, "point")).items():
        over_all = np.full((size, *values.shape[1:]), np.nan)
        over_all[chosen] = values
        variables[name] = dims, over_all
    variables["foretold_by"] = ("point",), best.astype(str)
    return describe(dataset.assign(variables).assign_attrs(Goals(tuple(bounds), ()).texts))


L = Parameters._fields.index("l")


def _chosen(dataset: xr.Dataset, along: str, at: Sequence[float]) -> np.ndarray:
    """Return the stable points that parts are scattered at."""
    stable = (dataset["stable"].values == 1) & (dataset["period_multiple"].values > 0)
    if len(at):
        return np.flatnonzero(stable & np.isin(dataset[along].values, np.asarray(at, float)))
    found = np.flatnonzero(stable)
    if len(found) <= MAX_POINTS:
        return found
    return found[np.linspace(0, len(found) - 1, MAX_POINTS).round().astype(int)]


def _parts(
    row: xr.Dataset, problem: Problem, sigma: Mapping[str, float], names: Sequence[Named]
) -> Points:
    """Return PARTS motions of scattered parts from the orbit of a point, and then that of the point itself."""
    values = problem.values_at(float(row[problem.name]))
    base, tied = values[: len(Parameters._fields)], problem.tied
    ties = NO_TIES if tied is None else tied.ties
    own = {} if tied is None else dict(zip(tied.names, values.tolist(), strict=True))
    own = {name: value for name, value in own.items() if name not in Parameters._fields}
    rows = moved_rows(base, sigma, PARTS, 0.0, Tied(ties, own))[:PARTS]
    wanted = {*OF_STEADY_STATE, *outputs_of(names)}
    return solve_points(
        np.vstack([rows, base]), tuple(float(row[name]) for name in STATE if name in row),
        tuple(name for name in OUTPUTS if name in wanted), row.sizes.get("harmonic", 1),
    )  # fmt: skip
