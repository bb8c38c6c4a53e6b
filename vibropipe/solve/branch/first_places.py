"""Places of bifurcations as quantities of steady states: the first of its kind on the way, and its derivatives."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from vibropipe.orbits.branches.following import Branch
from vibropipe.orbits.branches.tree import follow_tree
from vibropipe.physics.exciter import Exciter, ParameterError, Parameters
from vibropipe.physics.restitution import SUPPORTS, is_contact_damping
from vibropipe.solve.branch.places import place_slopes, values_of
from vibropipe.solve.branch.problem import problem_of, seed_of_steady_state
from vibropipe.solve.rows.named import Named
from vibropipe.solve.rows.points import Points
from vibropipe.words.bifurcations import without_slope
from vibropipe.words.parameters import CONTINUOUS, PARAMETERS
from vibropipe.words.vocabulary import PLACES, SENSITIVITY_SUFFIX

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
