"""The function `tolerance`: how far the quantities of an exciter scatter if its parameters do."""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.physics.effects import all_effect_names
from vibropipe.physics.exciter import Exciter, ParameterError, Parameters
from vibropipe.physics.limits import HARMONICS
from vibropipe.physics.parameter_error import number_within
from vibropipe.physics.start import start_text
from vibropipe.physics.stated import ties_of_call
from vibropipe.solve.basins.attractors import shares
from vibropipe.solve.branch.places import with_places
from vibropipe.solve.checks import check_whole
from vibropipe.solve.design.goals import Goals, bounds_of_parts, check_placed
from vibropipe.solve.design.scattered_parts import UNTIED, Tied, check_tied, moved_rows
from vibropipe.solve.design.sorting import kept_parts, sorting_variables, yield_variables
from vibropipe.solve.origin_attrs import origin_attrs
from vibropipe.solve.physical import to_physical
from vibropipe.solve.rows.gradient import values_and_jacobian
from vibropipe.solve.rows.label import Variables
from vibropipe.solve.rows.named import (
    SMOOTH,
    Named,
    gathered,
    harmonics_of,
    labels,
    named,
    outputs_of,
)
from vibropipe.solve.rows.points import Points, points_dataset, solve_points
from vibropipe.solve.with_units import are_with_units, plain_deviations, plain_goals, plain_values
from vibropipe.words.outputs import OUTPUTS as ALL_OUTPUTS
from vibropipe.words.progress import Progress
from vibropipe.words.records import POSITIVE
from vibropipe.words.vocabulary import PLACES, STEADY, describe

if TYPE_CHECKING:
    import xarray as xr

OUTPUTS = ("harmonics", "impacts", "stability", "energy")
# Quantities whose spread is computed.
SPREAD = tuple(
    name
    for name in SMOOTH
    if (STEADY[name].output in OUTPUTS or name == "housing_velocity_mean")
    and not (STEADY[name].is_constant or STEADY[name].is_complex)
)
SAMPLES, SAMPLES_LIMITS = 4096, (16, 10**7)
# Standard deviations that the worst case reaches to.
WORST = 3.0
ESTIMATES, SIDES = ("first_order", "samples"), ("below", "above")


def tolerance(
    exciter: Exciter,
    tolerances: Mapping[str, float],
    x0: float | None = None,
    v0: float = 0.0,
    samples: int = SAMPLES,
    worst: float = WORST,
    harmonics: int = 3,
    subject_to: Mapping[str, Any] | None = None,
    progress: Progress | None = None,
    ties: Mapping[str, Any] | None = None,
) -> xr.Dataset:
    """Estimate how far the quantities of a stable orbit scatter, to first order and by samples of the true model.

    Parameters
    ----------
    exciter : Exciter
    tolerances : mapping of str to float
        Standard deviations of parameters, > 0: independent normal deviations. Those that would leave the range of a
        parameter end there. Of an exciter made by `from_physical` they may have units; the dataset is then in SI.
    x0, v0 : float, optional
        Start of every motion, as for `steady_state`.
    samples : int
        Number of samples, from 16 to 1e7, a Sobol' sequence [1]_.
    worst : float
        The worst case is sought within so many standard deviations, above 0, of each parameter.
    harmonics : int
        Number of harmonics, from 1 to 1,000.
    subject_to : mapping of str to str or (float, float), optional
        Bounds of quantities that parts are to keep, as of `design`: {"impact_velocity_max_1": "< 0.8"}. Asks for the
        yield. Places of bifurcations (fold_nu_up), found anew of each part, have a scatter, too.
    progress : callable, optional
        Called as progress(done, total), in samples with those of the worst case.
    ties : mapping of str to str or float, optional
        Parameters by expressions of others or of names of one's own, as of `sweep`: {"R2": "R1"}. What is free
        scatters, and what is tied follows it, here and in the derivatives. A name of one's own that scatters has its
        value as a tie: {"zeta": 0.02, "h": "2 * zeta"} with {"zeta": 0.001} among the tolerances.

    Returns
    -------
    xarray.Dataset
        What `steady_state` returns of the exciter itself, and of each quantity <name> (mean displacement, amplitudes
        and phases of harmonics, impact velocities, contacts with soft supports, energies), beside its own dimensions:

        <name>_std (estimate)
            Standard deviation: first order, sqrt(sum (s_i sigma_i)^2) with the sensitivities s_i [2]_; and of the
            samples with the same law of motion.
        <name>_worst (estimate)
            Largest deviation within `worst` sigma_i of each parameter: first order, worst sum |s_i| sigma_i; and the
            largest at the ends of each axis of that box and, of up to ten parameters, at its corners.
        <name>_sensitivity (parameter)
            Derivative s_i by each parameter with a tolerance.
        <name>_contribution (parameter)
            Share of the first-order variance, (s_i sigma_i)^2 over their sum.
        <name>_deviation (parameter, side)
            Deviation of the true model if one parameter alone is `worst` sigma_i below or above.

        <parameter>_std are the given standard deviations. law_change_share, law_change_low, law_change_high: share of
        the samples with another law of motion (regime, m, p1, p2), with the 95 % confidence interval for as many
        random ones; law_change_corners: share of those corners and ends. With `subject_to` there are yield, yield_low,
        yield_high, the share of the samples that keep the law and all bounds, with its interval, law_yield, the share
        that keeps the law, and <name>_yield, that which keeps each bound. Where parts fail, each quantity and each
        scattered parameter has a sorting rule: <name>_sort_threshold, above or below which a part is taken as good (NaN
        where none is better than taking all or none), <name>_sort_area, the share of the pairs of a good and a bad
        part in which the good one has the larger value (from 0.5 on good parts lie above), and <name>_sort_wrong,
        <name>_sort_wrong_low, <name>_sort_wrong_high, the share of other parts, the second half of the samples, that
        it sorts wrongly, with its 95 % interval. The attribute `foretold_by` names the best by the first half; it is
        "no single quantity" where that sorts the second no better than taking all or none, and "no rule: ..." where so
        few parts fail, or do not, that no rule could be shown to.

    Raises
    ------
    ParameterError
        If an argument is out of range, or the motion from the start is no stable orbit.

    References
    ----------
    .. [1] I. M. Sobol', On the distribution of points in a cube and the approximate evaluation of integrals, USSR
       Computational Mathematics and Mathematical Physics 7 (1967) 86.
    .. [2] Guide to the expression of uncertainty in measurement, JCGM 100:2008, section 5.1.
    """
    if are_with_units(exciter, tolerances, subject_to, x0, v0):
        dataset = tolerance(
            exciter,
            plain_deviations(exciter, tolerances),
            plain_values(exciter, "x0", x0),
            plain_values(exciter, "v0", v0),
            samples,
            worst,
            harmonics,
            plain_goals(exciter, "subject_to", subject_to),
            progress,
            ties,
        )
        return to_physical(dataset, exciter)
    exciter, stated = ties_of_call(exciter, ties)
    exciter, tied, sigma = check_tied(exciter, tolerances, stated)
    exciter.check_frequency(sigma.keys() - {"nu"})
    check_whole("samples", samples, SAMPLES_LIMITS)
    check_whole("harmonics", harmonics, HARMONICS)
    reach = number_within("worst", worst, POSITIVE)
    exciter.check_start(x0, v0)
    base = np.array(exciter.numbers())
    bounds = bounds_of_parts(subject_to) if subject_to else ()
    check_placed(Goals(bounds, ()), tied.ties)
    wanted_names = [bound.quantity for bound in bounds]
    wanted = {*OUTPUTS, *outputs_of(wanted_names)}
    outputs = tuple(name for name in ALL_OUTPUTS if name in wanted)
    harmonics = harmonics_of(wanted_names, harmonics)

    def from_start(rows: np.ndarray) -> Points:
        solved = solve_points(rows, (x0, v0), outputs, harmonics, progress)
        return with_places(solved, wanted_names)

    point = with_places(solve_points(base[None], (x0, v0), outputs, harmonics), wanted_names)
    if not point.is_stable[0]:
        must = "must have a motion from the start that settles on a stable orbit"
        raise ParameterError("exciter", exciter, must=must)
    effects = all_effect_names(vars(exciter), pieces=True, housing=True)
    attrs = origin_attrs(effects, start_text(vars(exciter), x0, v0)) | stated.attrs
    dataset = points_dataset(point, "row", harmonics, attrs, ()).isel(row=0)
    dataset = dataset.assign_coords(tied.own)
    points = from_start(moved_rows(base, sigma, samples, reach, tied))
    spread = spread_variables(base, point, sigma, samples, reach, harmonics, points, tied)
    if bounds:
        each, kept = kept_parts(bounds, points, point.laws[0], samples, exciter.l)
        spread |= yield_variables(bounds, points, point.laws[0], each, kept)
        names = spread_names(harmonics, point.variables)
        parameters = [name for name in sigma if name in Parameters._fields]
        rules, best = sorting_variables(names, parameters, point, points, kept)
        spread |= rules
        dataset = dataset.assign_attrs(foretold_by=best)
    return with_spread(dataset.drop_vars("row_size", errors="ignore"), [spread], sigma, ())


def spread_names(harmonics: int, variables: Container[Any]) -> list[Named]:
    """Return all parts of the quantities whose spread is computed, of those that a point has."""
    return [
        named(label, "quantity")
        for variable in (*SPREAD, *PLACES)
        if variable in variables
        for label in labels(variable, harmonics)
    ]


def spread_variables(
    base: np.ndarray,
    point: Points,
    sigma: Mapping[str, float],
    n: int,
    reach: float,
    harmonics: int,
    points: Points,
    tied: Tied = UNTIED,
) -> Variables:
    """Return the variables of `tolerance` at one solved point, without a dimension of the point.

    `points` are the motions from the start at `moved_rows`.
    """
    names = spread_names(harmonics, point.variables)
    moving = [name for name in (*sigma, *tied.ties.following(sigma)) if name not in tied.own]
    columns = [Parameters._fields.index(name) for name in moving]
    deviations = np.array(list(sigma.values()))

    def near(parameters: np.ndarray, states: np.ndarray, sensitivity: bool = False) -> Points:
        outputs = (*OUTPUTS, "sensitivity") if sensitivity else OUTPUTS
        solved = solve_points(parameters, tuple(states.T), outputs, harmonics)
        return with_places(solved, names, sensitivity)

    def read(points: Points) -> np.ndarray:
        return points.values(names)

    def difference(one: np.ndarray, two: np.ndarray) -> np.ndarray:
        each = [name.difference(one[..., n], two[..., n]) for n, name in enumerate(names)]
        return np.stack(each, axis=-1)

    _, own, slopes = values_and_jacobian(
        base, point.states[0], columns, near, read, difference, names=names
    )
    if tied.ties:
        slopes = tied.ties.chained(tied.values(base), moving, sigma, slopes)
    slopes = np.where(np.isfinite(own)[:, None], slopes, np.nan)
    effects = slopes * deviations
    moved = difference(read(points), own)
    is_same = points.has_law(point.laws[0])
    low_high = slice(n, n + 2 * len(sigma))
    alone = moved[low_high].reshape(len(sigma), 2, -1)
    with np.errstate(invalid="ignore", divide="ignore"):
        contribution = effects**2 / (effects**2).sum(axis=1, keepdims=True)
    std = np.linalg.norm(effects, axis=1), _std(moved[:n][is_same[:n]])
    worst = reach * np.abs(effects).sum(axis=1), _largest(moved[n:])
    by_suffix: dict[str, tuple[tuple[str, ...], np.ndarray]] = {
        "std": (("estimate",), np.stack(std, axis=1)),
        "worst": (("estimate",), np.stack(worst, axis=1)),
        "sensitivity": (("parameter",), slopes),
        "contribution": (("parameter",), contribution),
        "deviation": (("parameter", "side"), alone.transpose(2, 0, 1)),
    }
    share, low, high = shares(np.array([(~is_same[:n]).sum()]), n)
    counts = {"share": share[0], "low": low[0], "high": high[0], "corners": (~is_same[n:]).mean()}
    variables: Variables = {
        f"law_change_{name}": ((), np.array(value)) for name, value in counts.items()
    }
    for suffix, (dims, values) in by_suffix.items():
        variables |= gathered(names, values, suffix, dims)
    return variables


def _std(moved: np.ndarray) -> np.ndarray:
    """Return standard deviations (q,) of those deviations (n, q) that are known; NaN with less than two of them."""
    result = np.full(moved.shape[1], np.nan)
    for column, each in enumerate(moved.T):
        found = each[np.isfinite(each)]
        if found.size > 1:
            result[column] = np.std(found, ddof=1)
    return result


def _largest(moved: np.ndarray) -> np.ndarray:
    """Return the largest |deviation| (q,) of those (n, q) that are known; NaN if none is."""
    is_known = np.isfinite(moved)
    worst = np.where(is_known, np.abs(moved), 0.0).max(axis=0)
    return np.where(is_known.any(axis=0), worst, np.nan)


def with_spread(
    dataset: xr.Dataset,
    spreads: Sequence[Variables],
    sigma: Mapping[str, float],
    dims: tuple[str, ...],
) -> xr.Dataset:
    """Return a dataset with the spreads of its points, which lie over `dims`, at most one dimension."""
    variables: dict[str, Any] = {
        name: ((*dims, *inner), np.stack([each[name][1] for each in spreads]) if dims else values)
        for name, (inner, values) in spreads[0].items()
    }
    variables |= {f"{name}_std": ((), value) for name, value in sigma.items()}
    coords = {"estimate": list(ESTIMATES), "side": list(SIDES), "parameter": list(sigma)}
    return describe(dataset.assign(variables).assign_coords(coords))
