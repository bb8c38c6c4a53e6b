"""Designs as a labelled dataset, with the tolerances that they need."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.physics.effects import all_effect_names
from vibropipe.physics.exciter import Parameters
from vibropipe.physics.start import start_text
from vibropipe.solve.branch.from_rest import reached_from_rest
from vibropipe.solve.branch.places import with_places
from vibropipe.solve.design import tolerance as spread
from vibropipe.solve.design.goals import CURVE, Goals
from vibropipe.solve.design.problem import Problem
from vibropipe.solve.design.scatter import (
    HARMONICS,
    ON_LIMIT,
    PARTS,
    QUANTILES,
    Judged,
    assumed_scatter,
    kept_goals,
    variables_of_yield,
)
from vibropipe.solve.design.scattered_parts import box
from vibropipe.solve.design.search import Candidate, Samples
from vibropipe.solve.design.sorting import sorting_variables, stacked
from vibropipe.solve.origin_attrs import origin_attrs
from vibropipe.solve.rows.named import SENSITIVITY, harmonics_of
from vibropipe.solve.rows.points import Points, clipped, points_dataset, solve_points
from vibropipe.solve.rows.row_results import columns_of
from vibropipe.words.designs import ToleranceResult
from vibropipe.words.outputs import OUTPUTS
from vibropipe.words.progress import WorkCount
from vibropipe.words.vocabulary import describe, quantity

if TYPE_CHECKING:
    import xarray as xr

# Largest tolerance, as a share of a parameter (of l, of a length near 0); a box that fails shrinks by a factor.
LARGEST, SHRINK, MAX_TRIES = 0.2, 0.8, 40
OF_EITHER_SIGN = ("delta", "load")
# A design is on a bound nearer to it than this share of the bound, however small its quantity's deviation is.
ON_BOUND = 1e-6


def needed_tolerances(
    problem: Problem, candidate: Candidate, deviations: Mapping[str, float]
) -> tuple[np.ndarray, ToleranceResult]:
    """Return how far each parameter (p,) may be off, up or down, all at once; NaN of absent effects, or of all.

    What the tightest goal leaves is shared by what each parameter contributes with its deviation, to first order. If
    that is less than they take together, small contributions are left as they are and the large ones cut. At all
    corners and at the ends of the axes of this box the motion from the start is then marched: where a goal is missed or
    the law changes, the box shrinks. A target may be off by what `allow` gives.

    deviations : standard deviations of the parameters, given or assumed
    """
    nothing = np.full(len(Parameters._fields), np.nan)
    base = problem.parameters(candidate.share[None])[0]
    columns = [Parameters._fields.index(name) for name in deviations]
    sigma = np.array(list(deviations.values()))
    _, values, slopes = problem.linearised(base, candidate.state, columns)
    half, sizes = base[Parameters._fields.index("l")], np.abs(base[columns])
    # A length of either sign may be near 0 by chance: it is compared with l.
    is_length = np.isin([*deviations], OF_EITHER_SIGN)
    widths = LARGEST * np.where(is_length | (sizes == 0.0), np.maximum(sizes, half), sizes)
    for bound in (problem.goals.bounds[n] for n in problem.smooth):
        room = problem.distance(bound, values)
        effects = np.abs(slopes[problem.names.index(bound.quantity)]) * sigma
        if room < 0:
            return nothing, ToleranceResult.NOT_MET
        least = max(
            ON_LIMIT * float(np.linalg.norm(effects)), ON_BOUND * bound.scale(problem.exciter.l)
        )
        if room < least:
            is_target = bound.is_target
            return nothing, ToleranceResult.GOAL_MISSED if is_target else ToleranceResult.ON_BOUND
        widths = np.minimum(widths, sigma * shared(effects, room))
    corners = box(len(columns), 1.0)
    for _ in range(MAX_TRIES):
        rows = np.tile(base, (len(corners) + 1, 1))
        rows[1:, columns] += corners * widths
        points = problem.from_start(clipped(rows))
        kept = kept_goals(problem, points, candidate.law)
        if not kept[:, 0].all():
            return nothing, ToleranceResult.NOT_MET
        if kept.all():
            tolerances = nothing.copy()
            tolerances[columns] = widths
            return tolerances, ToleranceResult.FOUND
        widths = widths * SHRINK
        if (widths < ON_LIMIT * sigma).all():
            break
    return nothing, ToleranceResult.GOAL_MISSED if kept[0].all() else ToleranceResult.LAW_CHANGES


def shared(effects: np.ndarray, room: float) -> np.ndarray:
    """Return the factors of deviations, above 1 or below, with which the sum of their effects fits a room.

    All grow alike where there is room. Where there is not, effects above a common level are cut to it, so that as few
    parameters as possible need more than their deviation.
    """
    total = float(effects.sum())
    if total == 0:
        return np.full(effects.shape, np.inf)
    if total <= room:
        return np.full(effects.shape, room / total)
    ordered = np.sort(effects)
    below = np.concatenate([[0.0], np.cumsum(ordered)])[:-1]
    # The level that fits if the n smallest effects are kept whole.
    levels = (room - below) / np.arange(len(ordered), 0, -1)
    level = levels[np.flatnonzero(levels <= ordered)[0]]
    with np.errstate(divide="ignore"):
        return np.minimum(1.0, level / effects)


# Dimensions of quantities whose parts may be wanted, with their sizes.
SIZES = {"support": 2, "harmonic": HARMONICS, "multiplier": 2}


def design_dataset(
    problem: Problem,
    designs: Sequence[Candidate],
    margins: Sequence[float],
    all_judged: Sequence[Judged],
    steps: WorkCount,
    swept: Samples | None = None,
) -> xr.Dataset:
    """Return designs as a labelled dataset; `swept` are the points of a grid that a front was sought on."""
    harmonics = harmonics_of(problem.names, HARMONICS)
    shares = np.array([candidate.share for candidate in designs])
    parameters = problem.parameters(shares)
    held = {*spread.OUTPUTS, *problem.outputs} - {SENSITIVITY}
    outputs = tuple(name for name in OUTPUTS if name in held)
    points = solve_points(parameters, (problem.x0, problem.v0), outputs, harmonics)
    points = with_places(points, problem.names)
    attrs = attributes(problem, columns_of(parameters), has_yield=bool(all_judged))
    dataset = points_dataset(points, "design", harmonics, attrs, [*problem.ranges])
    found = problem.low + shares * problem.width
    own = [(n, name) for n, name in enumerate(problem.vary) if name not in Parameters._fields]
    dataset = dataset.assign_coords({name: ("design", found[:, n]) for n, name in own})
    misses = problem.misses(np.array([candidate.values for candidate in designs]))
    variables: dict[str, Any] = {
        "design_result": ("design", np.array([each.result for each in designs], np.int8)),
        "design_miss": ("design", np.abs(misses).max(axis=1, initial=0.0)),
        "law_margin": ("design", np.array(margins)),
        "from_rest": ("design", reached_from_rest(dataset)),
        **curve_misfit(problem, designs),
        **bound_variables(problem.goals, harmonics),
        **swept_variables(problem, swept, harmonics),
        **range_variables(problem.vary),
    }
    if all_judged:
        variables |= variables_of_yield(problem, all_judged) | tolerances(problem, designs)
        variables |= {f"{name}_std": ((), value) for name, value in problem.scatter.items()}
        variables |= sorting_of_designs(problem, points, all_judged)
    dataset = dataset.assign(variables)
    if all_judged:
        dataset = dataset.assign_coords(quantile=list(QUANTILES))
    if not problem.tolerance:
        return describe(dataset)
    spreads = []
    for row, each in enumerate(all_judged):
        point = points.take(slice(row, row + 1))
        spreads.append(
            spread.spread_variables(
                parameters[row], point, problem.tolerance, PARTS, spread.WORST, harmonics, each.points,
            )
        )  # fmt: skip
        steps.add()
    return spread.with_spread(dataset, spreads, problem.tolerance, ("design",))


def attributes(
    problem: Problem, columns: Mapping[str, np.ndarray], has_yield: bool
) -> dict[str, Any]:
    """Return the attributes of designs with some parameters: what was sought, and how parts scatter."""
    effects = all_effect_names(columns, pieces=True, housing=True)
    attrs = {
        **origin_attrs(effects, start_text(columns, problem.x0, problem.v0)),
        **problem.goals.texts,
        **problem.ties.attrs,
        "vary": " ".join(problem.vary),
    }
    if has_yield:
        attrs["scatter"] = "given" if problem.tolerance else "assumed"
        if problem.allow:
            allowed = (f"{name} = {off:.12g}" for name, off in problem.allow.items())
            attrs["allow"] = "; ".join(allowed)
    return attrs


def sorting_of_designs(
    problem: Problem, points: Points, all_judged: Sequence[Judged]
) -> dict[str, Any]:
    """Return the sorting rules of designs, and what foretells best of each; points : the designs themselves."""
    names = spread.spread_names(harmonics_of(problem.names, HARMONICS), points.variables)
    rules, best = zip(
        *(
            sorting_variables(
                names, [*problem.scatter], points.take(slice(row, row + 1)), each.points,
                np.asarray(each.kept.all(axis=0)),
            )
            for row, each in enumerate(all_judged)
        ),
        strict=True,
    )  # fmt: skip
    return {**stacked(rules, "design"), "foretold_by": ("design", np.array(best))}


def tolerances(problem: Problem, designs: Sequence[Candidate]) -> dict[str, Any]:
    """Return the tolerances that the parameters of designs need, if it is said how far all targets may be off."""
    if problem.goals.curve or any(np.isinf(problem.room(bound)) for bound in problem.goals.bounds):
        return {}
    # What has no given deviation takes its part with an assumed one.
    deviations = assumed_scatter(problem.exciter, problem.ranges) | dict(problem.scatter)
    found = [needed_tolerances(problem, each, deviations) for each in designs]
    variables: dict[str, Any] = {
        f"{name}_tolerance": ("design", column)
        for name, column in zip(
            Parameters._fields, np.array([widths for widths, _ in found]).T, strict=True
        )
        if name in deviations
    }
    results = np.array([result for _, result in found], np.int8)
    return variables | {"tolerance_result": ("design", results)}


def curve_misfit(problem: Problem, designs: Sequence[Candidate]) -> dict[str, Any]:
    """Return the root mean square distance of designs from the wanted curve, if there is one."""
    if problem.goals.curve is None:
        return {}
    misfits = np.array([candidate.values[len(problem.names) :] for candidate in designs])
    return {f"{CURVE}_misfit": ("design", np.sqrt((misfits**2).mean(axis=1)))}


def bound_variables(goals: Goals, harmonics: int) -> dict[str, Any]:
    """Return targets and bounds over the dimension of their quantity, NaN where there is none."""
    sizes = {**SIZES, "harmonic": harmonics}
    variables: dict[str, Any] = {}
    for bound in goals.bounds:
        name = bound.quantity
        if name.is_parameter or name.derived or name.part:
            continue  # the attributes have them
        dims = quantity(name.variable).dims
        ends = (
            {"target": bound.low} if bound.is_target else {"lower": bound.low, "upper": bound.high}
        )
        for suffix, end in ends.items():
            if not np.isfinite(end) or any(dim not in sizes for dim in dims):
                continue
            empty = np.full([sizes[dim] for dim in dims], np.nan)
            _, values = variables.setdefault(f"{name.variable}_{suffix}", (dims, empty))
            values[... if name.number is None else name.number - 1] = end
    return variables


def range_variables(vary: Mapping[str, tuple[float, float]]) -> dict[str, Any]:
    """Return the ends of the ranges of varied parameters."""
    return {
        f"{name}_{suffix}": ((), end)
        for name, ends in vary.items()
        for suffix, end in zip(("lower", "upper"), ends, strict=True)
    }


def swept_variables(problem: Problem, swept: Samples | None, harmonics: int) -> dict[str, Any]:
    """Return both objectives at the points of a sweep that keep all bounds; NaN of other parts of a quantity."""
    if swept is None:
        return {}
    values = swept.values[problem.is_met(swept.values)]
    variables: dict[str, Any] = {}
    for each in problem.goals.objectives:
        name = each.quantity
        dims = () if name.is_parameter else quantity(name.variable).dims
        if name.derived or name.part or any(dim not in SIZES for dim in dims):
            continue
        sizes = {**SIZES, "harmonic": harmonics}
        empty = np.full([len(values), *(sizes[dim] for dim in dims)], np.nan)
        _, filled = variables.setdefault(f"{name.variable}_swept", (("swept", *dims), empty))
        at = () if name.number is None else (name.number - 1,)
        filled[(slice(None), *at)] = values[:, problem.names.index(name)]
    return variables
