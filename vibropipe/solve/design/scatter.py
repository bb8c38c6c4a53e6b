"""What scattered parameters leave of a design: its yield, and how far its goals are from their limits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from vibropipe.physics.exciter import Exciter, Parameters
from vibropipe.physics.restitution import SUPPORTS
from vibropipe.solve.basins.attractors import shares
from vibropipe.solve.branch.places import with_places
from vibropipe.solve.design import tolerance as spread
from vibropipe.solve.design.problem import Problem
from vibropipe.solve.design.refine import Search
from vibropipe.solve.design.scattered_parts import moved_rows
from vibropipe.solve.design.search import Candidate, checked
from vibropipe.solve.rows.named import Named, harmonics_of, outputs_of
from vibropipe.solve.rows.points import Points, solve_points
from vibropipe.words.outputs import OUTPUTS
from vibropipe.words.parameters import DEFAULTS
from vibropipe.words.vocabulary import quantity

# Scattered parts of each design, harmonics of their spread, and quantiles of the wanted quantities over them.
PARTS, HARMONICS, QUANTILES = 4096, 3, (0.025, 0.5, 0.975)
# Distances from a bound that a design is moved to, in standard deviations of its quantity: the first that can be had.
INSIDE = (4.0, 2.0, 1.0)
# Moves to one of them, since the deviation changes on the way.
SAME_COST = 1e-4  # relative difference of objectives that are one
MAX_MOVES = 4
# Nearer than this to a limit, in standard deviations, nearly half of the parts break it.
ON_LIMIT = 0.1
# Least yield of a design of a front: whatever its costs, a law that most parts do not have is no choice.
LEAST_YIELD = 0.5
# Standard deviations of parameters, as shares of their values, where a study gives none.
ASSUMED = 1e-3


def assumed_scatter(exciter: Exciter, vary: Mapping[str, tuple[float, float]]) -> dict[str, float]:
    """Return standard deviations where none are given, the same for all designs.

    They are ASSUMED of each parameter that the exciter has, of the larger end of a range and, of an offset, of l.
    """
    sizes = {name: abs(value) for name, value in exciter.numbers()._asdict().items()}
    present = {name: sizes[name] for name in sizes if sizes[name] != DEFAULTS.get(name)}
    present |= {"nu": sizes["nu"]} | {name: max(map(abs, ends)) for name, ends in vary.items()}
    for restitution, stiffness, _ in SUPPORTS:  # its damping stands for it, where a support is soft
        if present.get(stiffness):
            present.pop(restitution, None)
    if "delta" in present:
        present["delta"] = present.get("l", sizes["l"])
    return {name: ASSUMED * present[name] for name in Parameters._fields if present.get(name)}


class Judged(NamedTuple):
    """A design among scattered parts.

    points : the parts, and then the ends of the axes and the corners of the worst case if deviations are given
    kept : (1 + goals, parts), whether a part keeps the law, and each target and bound
    reliability : least distance to a limit of a goal, to first order, in standard deviations of its quantity
    """

    points: Points
    kept: np.ndarray
    reliability: float

    @property
    def share(self) -> float:
        """The yield."""
        return float(self.kept.all(axis=0).mean())

    @property
    def interval(self) -> tuple[float, float, float]:
        """The yield with the ends of its 95 % confidence interval."""
        share, low, high = shares(np.array([self.kept.all(axis=0).sum()]), self.kept.shape[1])
        return float(share[0]), float(low[0]), float(high[0])


def judged(problem: Problem, candidate: Candidate) -> Judged:
    """Return a design among parts whose parameters scatter, each marched from the start."""
    base = problem.parameters(candidate.share[None])[0]
    rows = moved_rows(base, problem.scatter, PARTS, spread.WORST)
    plain = [bound.quantity for bound in problem.goals.bounds if not bound.quantity.derived]
    wanted = {*outputs_of(plain), *spread.OUTPUTS}
    points = solve_points(
        rows if problem.tolerance else rows[:PARTS], (problem.x0, problem.v0),
        tuple(name for name in OUTPUTS if name in wanted), harmonics_of(problem.names, HARMONICS),
        work=problem.work,
    )  # fmt: skip
    points = with_places_of_parts(problem, candidate, points)
    kept = kept_goals(problem, points, candidate.law)[:, :PARTS]
    distances = distances_to_limits(problem, candidate)
    return Judged(points, kept, float(distances.min(initial=np.inf)))


def with_places_of_parts(problem: Problem, candidate: Candidate, points: Points) -> Points:
    """Return parts, and what follows them, with the places of bifurcations that are wanted; NaN with another law.

    Those of parts are to first order: to follow a branch takes a hundred times as long as to march a part.
    """
    places = [n for n, name in enumerate(problem.names) if name.is_place and not name.derived]
    if not places:
        return points
    columns, _ = problem.scattered
    row = problem.parameters(candidate.share[None])[0]
    _, own, slopes = problem.linearised(row, candidate.state, columns)
    moved = own[places] + (points.parameters[:PARTS, columns] - row[columns]) @ slopes[places].T
    points = with_places(points, [problem.names[n] for n in places], begin=PARTS)
    has_law = points.has_law(candidate.law)
    for column, n in enumerate(places):
        values = points.variables[problem.names[n].variable][1]
        values[:PARTS] = moved[:, column]
        values[~has_law] = np.nan
    return points


def kept_goals(problem: Problem, points: Points, law: np.ndarray) -> np.ndarray:
    """Return which points (n,) have a law of motion, and keep each target and bound: (1 + goals, n).

    A target may be off by what is allowed, and by anything if nothing is said. Spreads and sensitivities are those of a
    design and not of a part.
    """
    has_law = points.has_law(law)
    kept = [has_law]
    for bound in problem.goals.bounds:
        name = bound.quantity
        room = problem.room(bound)
        if name.derived or np.isinf(room):
            kept.append(np.ones(len(has_law), bool))
            continue
        kept.append(bound.kept_at(points, problem.exciter.l, room))
    return np.array(kept)


def deviations(problem: Problem, candidate: Candidate) -> np.ndarray:
    """Return the standard deviations (bounds,) of quantities to first order; 0 of those that no part has."""
    columns, sigma = problem.scattered
    row = problem.parameters(candidate.share[None])[0]
    _, _, slopes = problem.linearised(row, candidate.state, columns)
    std = np.linalg.norm(slopes * sigma, axis=1)
    return np.array(
        [
            0.0 if bound.quantity.derived or bound.quantity.is_of_law
            else float(np.nan_to_num(std[problem.names.index(bound.quantity)]))
            for bound in problem.goals.bounds
        ]
    )  # fmt: skip


def distances_to_limits(problem: Problem, candidate: Candidate) -> np.ndarray:
    """Return how far each goal (goals,) is from its nearest limit, in standard deviations to first order."""
    std = deviations(problem, candidate)
    rooms = np.array([problem.distance(bound, candidate.values) for bound in problem.goals.bounds])
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(std > 0, rooms / std, np.inf)


def is_inside(problem: Problem, candidate: Candidate, reach: float) -> bool:
    """Return whether a design keeps so many standard deviations off each bound."""
    is_bound = np.array([not bound.is_target for bound in problem.goals.bounds], bool)
    return bool((distances_to_limits(problem, candidate)[is_bound] >= reach).all())


def moved_inside(
    problem: Problem, candidate: Candidate, reaches: Sequence[float] = INSIDE
) -> Candidate:
    """Return a design moved off its bounds, by as many of `reaches` standard deviations as can be had.

    A bound that is met exactly is broken by half of the parts. The law, the targets and other limits are kept. With an
    objective the room is taken anew from where the last one led, as long as that gains.
    """
    if not problem.scatter or not candidate.is_met or problem.goals.of_yield:
        return candidate
    limits = {}
    if len(problem.goals.objectives) == 2:
        limits = {1: float(problem.costs(candidate.values)[1])}
    for reach in reaches:
        found: Candidate | None = candidate
        inside: Candidate | None = None
        for _ in range(MAX_MOVES):
            assert found is not None
            if is_inside(problem, found, reach):
                if found is candidate or not problem.goals.objectives:
                    return found
                if inside is not None and not _is_cheaper(problem, found, inside):
                    break
                # Deviations may be smaller here: less room is needed.
                inside = found
            # A little more, so that a deviation that grows on the way does not undo the move.
            needed = 1.01 * reach * deviations(problem, found)
            aimed = replace(problem, margins=needed, reach=candidate.reach)
            found = _led_to(aimed, found, limits)
            if found is None:
                break
        if inside is not None:
            return inside
    return candidate


def _is_cheaper(problem: Problem, one: Candidate, other: Candidate) -> bool:
    """Return whether the first objective of a design is less than that of another."""
    costs = [float(problem.costs(each.values)[0]) for each in (one, other)]
    return costs[0] < costs[1] - SAME_COST * abs(costs[1])


def _led_to(problem: Problem, candidate: Candidate, limits: dict[int, float]) -> Candidate | None:
    """Return the design within the margins of a problem that another one leads to along its law, if there is one."""
    search = Search(problem, candidate.share, candidate.state, candidate.law)
    if not search.last.valid:
        return None
    trial = search.meet()
    if problem.goals.objectives and problem.is_met(trial.values):
        search.improve(0, limits)
        trial = search.meet()
    moved = checked(problem, search, trial)
    return moved if moved is not None and moved.is_met else None


def ranked(
    problem: Problem,
    candidates: Sequence[Candidate],
    order: Sequence[int],
    margins: Sequence[float],
    parts: Mapping[int, Judged],
) -> list[int]:
    """Return the numbers of designs by yield, the best first, without those on a limit if there are others.

    Equal yields: by the distance to the nearest limit and to the nearest change of law. With a quantity to be least, or
    a curve, yields of the same whole per cent count as equal, and that comes next.
    """
    yields = np.array([parts[n].share for n in order])
    values = np.array([candidates[n].values for n in order])
    keys = [
        -np.array([margins[n] for n in order]),
        -np.array([parts[n].reliability for n in order]),
    ]
    if problem.goals.curve is not None:
        misfit = np.linalg.norm(problem.residuals(values), axis=1)
        keys += [np.round(misfit, 9), -np.floor(100 * yields)]
    elif problem.goals.objectives and not problem.goals.of_yield:
        costs = problem.costs(values)[:, 0]
        keys += [np.round(costs / max(np.abs(costs).max(), 1e-300), 7), -np.floor(100 * yields)]
    else:
        keys.append(-yields)
    return off_limits([order[n] for n in np.lexsort(keys)], parts)


def off_limits(
    order: Sequence[int], parts: Mapping[int, Judged], least_yield: float = 0.0
) -> list[int]:
    """Return the numbers of designs without those on a limit of a goal or of less yield, if there are others."""
    return [
        n for n in order if parts[n].reliability >= ON_LIMIT and parts[n].share >= least_yield
    ] or list(order)


def variables_of_yield(problem: Problem, all_judged: Sequence[Judged]) -> dict[str, Any]:
    """Return the yields of designs, of all goals and of each, and the quantiles of the wanted quantities."""
    yields = np.array([each.interval for each in all_judged]).T
    names = ("yield", "yield_low", "yield_high")
    variables: dict[str, Any] = {
        name: ("design", values) for name, values in zip(names, yields, strict=True)
    }
    variables["law_yield"] = ("design", np.array([each.kept[0].mean() for each in all_judged]))
    variables["reliability_index"] = ("design", np.array([each.reliability for each in all_judged]))
    rows: dict[Named, list[np.ndarray]] = {}
    for name in dict.fromkeys(bound.quantity for bound in problem.goals.bounds):
        if name.is_parameter or name.derived or name.part:
            continue
        same = [k + 1 for k, other in enumerate(problem.goals.bounds) if other.quantity == name]
        rows[name] = []
        for each in all_judged:
            parts = name.values(each.points.variables, each.points.parameters)[:PARTS]
            found = parts[each.kept[0] & np.isfinite(parts)]
            ends = np.quantile(found, QUANTILES) if found.size else np.full(len(QUANTILES), np.nan)
            rows[name].append(np.append(ends, each.kept[same].all(axis=0).mean()))
    return variables | _by_variable(rows, harmonics_of(problem.names, HARMONICS))


def _by_variable(rows: Mapping[Named, list[np.ndarray]], harmonics: int) -> dict[str, Any]:
    """Return quantiles and, last, yields (designs, quantiles + 1) of quantities, with parts over a dimension."""
    sizes = {"support": 2, "harmonic": harmonics, "multiplier": 2}
    variables: dict[str, Any] = {}
    for name, values in rows.items():
        dims = quantity(name.variable).dims
        if any(dim not in sizes for dim in dims):
            continue
        table = np.array(values)
        for suffix, part, inner in (
            ("quantile", table[:, :-1], ("quantile",)),
            ("yield", table[:, -1], ()),
        ):
            shape = (len(table), *(sizes[dim] for dim in dims), *part.shape[1:])
            empty = np.full(shape, np.nan)
            _, filled = variables.setdefault(
                f"{name.variable}_{suffix}", (("design", *dims, *inner), empty)
            )
            filled[(slice(None), *([] if name.number is None else [name.number - 1]))] = part
    return variables
