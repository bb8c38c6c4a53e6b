"""The branch of an orbit with rests: rows of a sweep that follow it, up to where it has other rests.

After a rest the motion is that of the release, whatever came before: such an orbit has the multipliers 0, so it has
neither folds nor flips, and following what settles follows the branch.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibropipe.orbits.law.problem import Problem
from vibropipe.physics.exciter import Exciter
from vibropipe.physics.start import start_at
from vibropipe.solve.branch.problem import exciter_at
from vibropipe.solve.rows.label import Variables, concatenate
from vibropipe.solve.sweep.blocks import solve_shard
from vibropipe.solve.sweep.sweep_grid import SweepGrid
from vibropipe.words.outputs import OF_STEADY_STATE

if TYPE_CHECKING:
    import xarray as xr

# Points over the range of the parameter at the default step, and bisections that locate the end of a branch.
REST_POINTS, DEFAULT_STEP, MAX_BISECTIONS = 64, 0.02, 60
# Distance, as a share of the range, at which the end of a branch is located.
LOCATED = 1e-13


class RestBranch(NamedTuple):
    """Steady states with rests along a parameter: variables over `row`, the parameter, and whether it ends there."""

    variables: Variables
    values: np.ndarray
    ends_first: bool
    ends_last: bool


def _kind(state: xr.Dataset) -> tuple[float, ...]:
    """Return what orbits of one branch have in common: regime, period multiple, rests on each support."""
    rests = state.rests_per_orbit.values.ravel().tolist()
    return (state.regime.item(), state.period_multiple.item(), *rests)


def _section(state: xr.Dataset) -> tuple[float, float]:
    """Return the state at the section."""
    return state.displacement_strobe.item(), state.velocity_strobe.item()


def _variables(state: xr.Dataset) -> Variables:
    """Return the variables of a steady state over `row`."""
    return {
        str(name): (tuple(map(str, variable.dims)), variable.values)
        for name, variable in state.data_vars.items()
    }


def follow_rest(
    exciter: Exciter,
    problem: Problem,
    signs: tuple[float, ...],
    start: xr.Dataset,
    harmonics: int,
    outputs: tuple[str, ...] = OF_STEADY_STATE,
) -> RestBranch:
    """Follow an orbit with rests; the points are in the order of the parameter.

    signs : directions of the parameter: 1, -1 or both
    start : steady state of the exciter
    outputs : any of `OF_BRANCH`
    """
    kind = _kind(start)
    own = float(problem.values[problem.along])
    section = _section(start)

    def state_at(value: float, near: tuple[float, float]) -> xr.Dataset:
        stated = exciter_at(problem, value)._asdict()
        moved = replace(
            exciter, **{name: stated[name] for name in problem.varied if name in stated}
        )
        x = float(start_at(moved.l, moved.delta, *near))
        grid = SweepGrid({}, None, moved.stated())
        return solve_shard(grid, 0, 1, start=(x, near[1]), harmonics=harmonics, outputs=outputs)

    step = problem.max_length / DEFAULT_STEP * (problem.high - problem.low) / REST_POINTS
    parts = {sign: _one_way(problem, own, sign, step, kind, section, state_at) for sign in signs}
    below, above = parts.get(-1.0, ([], False)), parts.get(1.0, ([], False))
    states = [*reversed(below[0]), (own, state_at(own, section)), *above[0]]
    variables = concatenate([_variables(state) for _value, state in states])
    values = np.array([value for value, _state in states])
    return RestBranch(variables, values, below[1], above[1])


def _one_way(
    problem: Problem,
    own: float,
    sign: float,
    step: float,
    kind: tuple[float, ...],
    section: tuple[float, float],
    state_at: Callable[[float, tuple[float, float]], xr.Dataset],
) -> tuple[list[tuple[float, xr.Dataset]], bool]:
    """Follow the orbit in one direction; return its steady states and whether it ends before the limit."""
    limit = problem.high if sign > 0.0 else problem.low
    n = max(1, int(np.ceil(abs(limit - own) / step)))
    wanted = [value for value in problem.at if sign * (value - own) > 0.0]
    grid = sorted({*np.linspace(own, limit, n + 1)[1:].tolist(), *wanted}, key=lambda v: sign * v)
    states: list[tuple[float, xr.Dataset]] = []
    inside = own
    for value in grid:
        state = state_at(value, section)
        if _kind(state) != kind:
            outside, last = value, None
            for _ in range(MAX_BISECTIONS):
                middle = 0.5 * (inside + outside)
                if abs(outside - inside) <= LOCATED * (problem.high - problem.low):
                    break
                state = state_at(middle, section)
                if _kind(state) == kind:
                    inside, last = middle, state
                    section = _section(state)
                else:
                    outside = middle
            return [*states, (inside, last)] if last is not None else states, True
        states.append((value, state))
        inside = value
        section = _section(state)
    return states, False
