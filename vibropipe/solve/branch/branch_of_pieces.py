"""Branches of orbits with soft supports, friction, a housing or rests: through a steady state, and points as rows."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from vibropipe.march.log import limit_work
from vibropipe.orbits.branches.following import Branch, Seed
from vibropipe.orbits.branches.rows import write_piece_points
from vibropipe.orbits.law.curve import LawCurve
from vibropipe.orbits.law.marching import CAPACITY, Marcher
from vibropipe.orbits.law.problem import Problem, Scales
from vibropipe.orbits.results import RowResults
from vibropipe.orbits.row import LOAD
from vibropipe.orbits.sensitivity.law_rows import with_errors_of_pieces
from vibropipe.physics.effects import Effects, has_soft_support
from vibropipe.physics.exciter import Exciter
from vibropipe.physics.limits import MAX_CALL_WORK
from vibropipe.solve.equilibrium import from_equilibrium
from vibropipe.solve.rows.row_results import (
    ImpactBuffer,
    add_load,
    columns_of,
    compact_impacts,
    contact_columns,
    new_rows,
    without_impacts,
)
from vibropipe.words.outputs import computed

if TYPE_CHECKING:
    import xarray as xr

# Least scale of displacements, as a share of l.
MIN_SIZE = 1e-3
# Friction at which an orbit that is followed from none has its law read: without friction no turn is an event.
MIN_FRICTION = 1e-100


def seed_of_pieces(
    exciter: Exciter, problem: Problem, signs: tuple[float, ...], start: xr.Dataset
) -> Seed | None:
    """Return the start of the branch through the orbit of a steady state; None where its equations have no solution.

    signs : directions of the parameter: 1, -1 or both
    start : steady state of the exciter, with its first harmonic
    """
    effects = problem.effects
    x = from_equilibrium(exciter, float(start.displacement_strobe))
    v, own = float(start.velocity_strobe), float(problem.values[problem.along])
    amplitude = float(start.displacement_amplitude.max())
    size = max(amplitude, abs(x), MIN_SIZE * exciter.l)
    speed = max(exciter.nu * size, abs(v))
    marcher, p = Marcher(effects), exciter.parameters()
    if "friction" in problem.varied:
        p = p._replace(friction=max(p.friction, MIN_FRICTION))
    state = np.array([x, v])
    if effects.housing is not None:
        state = np.append(state, float(start.get("housing_velocity_strobe", 0.0)))
    read = marcher.law_of(p, state, int(start.period_multiple), problem.symmetric)
    if read is None:
        return None
    curve = LawCurve(problem, read.law, Scales(size, speed), marcher)
    point = curve.settle(np.concatenate([read.u.T.ravel(), [own]]))
    if point is None:
        return None
    return Seed(curve, point, own, signs)


def solve_branch_of_pieces(
    effects: Effects,
    branch: Branch,
    parameters: np.ndarray,
    harmonics: int,
    outputs: tuple[str, ...],
) -> RowResults:
    """Return the compacted results of the points of a branch.

    branch : of a `LawCurve`
    parameters : (points, parameters)
    outputs : any of `OF_BRANCH`
    """
    curve = branch.curve
    assert isinstance(curve, LawCurve)
    sections = np.array([point.curve.state_at(point) for point in branch.points])
    return solve_sections(
        effects, curve.marcher, curve.sequence.m, sections, parameters, harmonics, outputs
    )


def solve_sections(
    effects: Effects,
    marcher: Marcher,
    m: int,
    sections: np.ndarray,
    parameters: np.ndarray,
    harmonics: int,
    outputs: tuple[str, ...],
) -> RowResults:
    """Return the compacted results of orbits of m periods from their states at the section.

    sections : (points, 2 or 3) array, as for `write_piece_points`; all else as for `solve_branch_of_pieces`
    """
    march_room = marcher.room
    limit_work(march_room[0], 0, MAX_CALL_WORK)
    size = CAPACITY * len(parameters)
    listed = ImpactBuffer(np.empty(size), np.empty(size), np.empty(size, np.int8))
    out = new_rows(len(parameters), harmonics, outputs, listed, effects)
    write_piece_points(effects, parameters, m, sections, march_room, out)
    rows = compact_impacts(out)
    is_soft = has_soft_support(columns_of(parameters))
    rows = with_errors_of_pieces(
        rows, parameters, effects, march_room[0].pieces,
        contact_columns(outputs) if is_soft and effects.housing is None else 0,
    )  # fmt: skip
    add_load(rows, parameters[:, LOAD])
    return rows if "impacts" in computed(outputs) else without_impacts(rows)
