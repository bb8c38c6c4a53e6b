"""How the bifurcations of branches move with each parameter: the tangents of the boundaries through them.

Their places are also quantities of steady states: the first of its kind on the way, and its derivatives.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from vibropipe.continuation.path import Event
from vibropipe.orbits.boundaries.curve import KINDS, Box
from vibropipe.orbits.boundaries.law_curve import LawBoundary
from vibropipe.orbits.boundaries.seeds import linear_grazing
from vibropipe.orbits.boundaries.touches import Grazing, grazing_at
from vibropipe.orbits.branches.following import Branch
from vibropipe.orbits.branches.symmetry import whole_orbit
from vibropipe.orbits.branches.tree import follow_tree
from vibropipe.orbits.law.curve import NO_TOUCH
from vibropipe.orbits.law.marching import Marcher
from vibropipe.orbits.law.problem import Problem, Scales
from vibropipe.orbits.law.tied import Tied
from vibropipe.physics.contact import support_offset
from vibropipe.physics.exciter import Exciter, ParameterError, Parameters
from vibropipe.physics.load import has_second
from vibropipe.physics.restitution import SUPPORTS, is_contact_damping
from vibropipe.solve.branch.problem import (
    KEEP_SYMMETRY,
    is_symmetric,
    problem_of,
    seed_of_steady_state,
)
from vibropipe.solve.rows.named import Named
from vibropipe.solve.rows.points import Points
from vibropipe.words.bifurcations import without_slope
from vibropipe.words.parameters import CONTINUOUS, PARAMETERS
from vibropipe.words.vocabulary import PLACES, SENSITIVITY_SUFFIX

# Parameters that move the equilibrium between the supports, and all that end the symmetry of an exciter.
OF_OFFSET = ("delta", "load", "f2", "phi2")
ENDS_SYMMETRY = {*PARAMETERS} - {*KEEP_SYMMETRY}
# Range of a parameter, as a share of its value and of l, that scales the equations.
RANGE = 0.1
# Share of a parameter by which it moves where its symmetry is looked at.
MOVED = 1e-3
# Share of the range within which two places are one.
SAME_PLACE = 1e-9
# Width of a step that scales nothing here.
ANY_LENGTH = 0.02


def scattered_places(
    branches: Sequence[Branch], sigma: Mapping[str, float]
) -> tuple[np.ndarray, np.ndarray]:
    """Return `place_slopes` of all branches by the parameters that scatter, and standard deviations of the places.

    The end of doubled orbits has no regular equations of its own: it is the bifurcation of their parent.
    """
    names = [*sigma]
    slopes = [place_slopes(branch, names) for branch in branches]
    events = [
        (event.kind, values_of(branch)[event.point], rows[n])
        for branch, rows in zip(branches, slopes, strict=True)
        for n, event in enumerate(branch.events)
    ]
    for kind, value, row in events:
        reach = SAME_PLACE * (branches[0].problem.high - branches[0].problem.low)
        twins = (
            other for its, at, other in events
            if its == kind and abs(at - value) <= reach and np.isfinite(other).all()
        )  # fmt: skip
        if np.isnan(row).all():
            row[:] = next(twins, row)
    found = np.concatenate(slopes) if slopes else np.zeros((0, len(names)))
    return found, np.sqrt(((found * np.array([*sigma.values()])) ** 2).sum(axis=1))


def values_of(branch: Branch) -> list[float]:
    """Return the parameter at the points of a branch."""
    return branch.values or [point.value for point in branch.points]


def place_slopes(branch: Branch, names: Sequence[str]) -> np.ndarray:
    """Return the derivatives (bifurcations, names) of the places of the bifurcations of a branch by parameters.

    They are NaN of other kinds than fold, flip, pitchfork and grazing, and where the place has none: that of a
    pitchfork, or at which an orbit that is its own mirror image touches both supports, by a parameter that ends the
    symmetry.

    The place p(q) lies on the boundary g(u, p, q) = 0 of its kind, which has the tangent of the branch of orbits in
    both parameters: dp/dq follows from the equations of the orbit and the condition, linearised.
    """
    slopes = np.full((len(branch.events), len(names)), np.nan)
    for row, event in enumerate(branch.events):
        if event.kind not in KINDS:
            continue
        found = _orbit_at(branch, event)
        if found is None:
            continue
        orbit, excluded = found
        for column, name in enumerate(names):
            if not _is_excluded(branch.problem, name, excluded):
                slopes[row, column] = _slope(branch, event, orbit, name)
    return slopes


def _orbit_at(branch: Branch, event: Event) -> tuple[Grazing, Collection[str]] | None:
    """Return the orbit of a bifurcation, and the parameters by which its place has no derivative."""
    if branch.curve is None:
        return _linear_touch(branch, branch.values[event.point])
    point = branch.points[event.point]
    curve = point.curve
    if event.kind == "grazing":
        grazing = grazing_at(point)
        if grazing is None:
            return None
        return grazing, ENDS_SYMMETRY if curve.sequence.mirrored else ()
    law, unknowns = curve.sequence, point.u
    if event.kind == "fold" and law.mirrored:
        # The whole orbit has the fold, too, and each support its own share in it.
        law, unknowns = whole_orbit(law, unknowns)
    n, width = len(law.codes), curve.width
    u = np.ascontiguousarray(unknowns[: width * n].reshape(width, n).T)
    return Grazing(law, u, NO_TOUCH), ENDS_SYMMETRY if event.kind == "pitchfork" else ()


def _is_excluded(problem: Problem, name: str, excluded: Collection[str]) -> bool:
    """Return whether a parameter is one of some that end the symmetry, and what follows it does not keep that."""
    if problem.tied is None:
        return name in excluded
    tied, index = Tied(problem.tied.ties, (problem.name, name)), Parameters._fields.index(name)
    if {name, *tied.ties.following([name])}.isdisjoint(excluded):
        return False
    values = problem.values_at(problem.low)
    values[index] += MOVED * (abs(values[index]) or 1.0)
    tied.fill(values)
    return not is_symmetric(Parameters(*values[: len(Parameters._fields)]))


def _linear_touch(branch: Branch, value: float) -> tuple[Grazing, Collection[str]]:
    """Return the motion without impacts where it touches a support, as `_orbit_at`: maybe both at once."""
    p = branch.problem.parameters_at(value)
    touches_both = support_offset(p) == 0.0 and not has_second(p)
    return linear_grazing(p), OF_OFFSET if touches_both else ()


def _slope(branch: Branch, event: Event, orbit: Grazing, name: str) -> float:
    """Return the derivative of the place of a bifurcation by a parameter, or NaN."""
    problem, index = branch.problem, Parameters._fields.index(name)
    place, own = values_of(branch)[event.point], float(problem.values[index])
    l = float(problem.values[Parameters._fields.index("l")])  # noqa: E741
    ends = np.array([place, own])
    half = RANGE * np.maximum(np.abs(ends), l)
    box = Box(
        problem.values_at(place), np.array([problem.along, index]), ends - half, ends + half, problem.symmetric,
        ANY_LENGTH, problem.effects,
        None if problem.tied is None else Tied(problem.tied.ties, (problem.name, name)),
    )  # fmt: skip
    if branch.curve is None:
        scales, marcher = Scales(l, l * problem.values[0]), Marcher(problem.effects)
    else:
        curve = branch.points[event.point].curve
        scales, marcher = curve.scales, curve.marcher
    # codes that kernels can read
    law = orbit.law._replace(codes=np.ascontiguousarray(orbit.law.codes))
    boundary = LawBoundary(box, KINDS[event.kind], law, orbit.touch, scales, marcher)
    return boundary.slope_at(np.concatenate([orbit.u.T.ravel(), ends]))


# A motion is followed to this multiple of the parameter or to the share of it; an offset by l.
REACH = 4.0
# As of `branch`.
MAX_STEP = 0.02
# Dimension of the derivatives by every parameter, in the order of `Parameters`.
EVERY_PARAMETER = "every_parameter"
# What the orbit of a steady state is read from.
OF_ORBIT = ("period_multiple", "displacement_strobe", "velocity_strobe", "displacement_amplitude")
OF_HOUSING = "housing_velocity_strobe"
OF_IMPACTS = ("impact_phase", "impact_period", "impact_velocity", "impact_support")


def with_places(
    points: Points, names: Iterable[Named], slopes: bool = False, begin: int = 0
) -> Points:
    """Return points with those of some quantities that are places of bifurcations.

    A place is NaN where the motion is no stable orbit or has rests, and where its branch meets no bifurcation of the
    kind up to its first fold, its end, or REACH. The branch is followed as by `branch`, so that places are known to
    rounding; the derivatives are those of the boundary through the bifurcation (`place_slopes`). A derivative is NaN
    where the place has none, and where it is not known in closed form: at the end of doubled orbits, and by what gives
    the damping of a soft support.

    points : with harmonics, impacts and stability
    slopes : whether to add the derivatives by every parameter, over EVERY_PARAMETER
    begin : the first point whose places are sought; those before it have none
    """
    wanted = {name.variable: PLACES[name.variable] for name in names if name.is_place}
    if not wanted:
        return points
    n = len(points.parameters)
    values = {name: np.full(n, np.nan) for name in wanted}
    by = {name: np.full((n, len(Parameters._fields)), np.nan) for name in wanted}
    ways = dict.fromkeys((along, way) for _kind, along, way in wanted.values())
    rests = points.variables["rests_per_orbit"][1].sum(axis=1)
    sought = points.is_stable & (rests == 0) & (np.arange(n) >= begin)
    for row in np.flatnonzero(sought).tolist():
        for along, way in ways:
            branch = _followed(points, row, along, way)
            if branch is None:
                continue
            for name, (kind, *its) in wanted.items():
                of_kind = [event for event in branch.events if event.kind == kind]
                if its == [along, way] and of_kind:
                    values[name][row] = values_of(branch)[of_kind[0].point]
                    if slopes:
                        by[name][row] = _slopes(replace(branch, events=of_kind[:1]))
    added = {name: (("row",), column) for name, column in values.items()}
    if slopes:
        added |= {
            name + SENSITIVITY_SUFFIX: (("row", EVERY_PARAMETER), columns)  # type: ignore[misc]
            for name, columns in by.items()
        }
    return points._replace(variables={**points.variables, **added})


def _followed(points: Points, row: int, along: str, way: str) -> Branch | None:
    """Return the branch through the orbit of a point, followed upwards or downwards; None if there is none."""
    import xarray as xr

    exciter = Exciter(**dict(zip(Parameters._fields, points.parameters[row].tolist(), strict=True)))
    try:
        problem, signs = problem_of(exciter, along, _limit(exciter, along, way), (), MAX_STEP)
    except ParameterError:  # it cannot have other values, or has no orbits that are isolated
        return None
    variables, sizes = points.variables, points.variables["row_size"][1]
    begin = int(sizes[:row].sum())
    held = [name for name in (*OF_ORBIT, OF_HOUSING) if name in variables]
    start = xr.Dataset(
        {name: (variables[name][0][1:], variables[name][1][row]) for name in held}
        | {
            name: ("impact", variables[name][1][begin : begin + int(sizes[row])])
            for name in OF_IMPACTS
        }
    )
    followed = problem._replace(until_fold=True)
    seed = seed_of_steady_state(exciter, followed, signs, start)
    if seed is None:
        return None
    return follow_tree(followed, seed, ()).branches[0]


def _limit(exciter: Exciter, along: str, way: str) -> float:
    """Return the value up to which a parameter is followed."""
    own, sign = float(getattr(exciter, along)), 1.0 if way == "up" else -1.0
    if along == "delta":
        return own + sign * exciter.l
    limits = PARAMETERS[along].range
    end = own * REACH if sign * own > 0.0 else own / REACH
    return float(np.clip(end, limits.low, limits.high))


def _slopes(branch: Branch) -> np.ndarray:
    """Return the derivatives of the only bifurcation of a branch by every parameter; 0 by the one it lies along."""
    values = dict(zip(Parameters._fields, branch.problem.values.tolist(), strict=True))
    along = Parameters._fields[branch.problem.along]
    missing = {*without_slope(values, along)}
    for restitution, stiffness, damping in SUPPORTS:
        own = values[damping], values[restitution], values[stiffness]
        if own[-1] > 0.0 and is_contact_damping(*own):
            missing |= {restitution, stiffness, damping}
    names = [name for name in CONTINUOUS if name not in missing]
    slopes = np.full(len(values), np.nan)
    slopes[[Parameters._fields.index(name) for name in names]] = place_slopes(branch, names)[0]
    slopes[branch.problem.along] = 0.0
    return slopes
