"""Return map, multipliers, harmonics: against finite differences, identities and quadrature."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vibropipe.march.grid import Instant, exact_grid, grid_time
from vibropipe.march.log import RESTS, new_log
from vibropipe.march.loop import march
from vibropipe.march.state import REST, initial_state
from vibropipe.orbits.forces import Integrals
from vibropipe.orbits.harmonics import add_support_forces, divide_by_stiffness
from vibropipe.orbits.quadrature import integrate_along
from vibropipe.orbits.return_map import floquet_multipliers, return_map_jacobian, state_xv
from vibropipe.orbits.return_map import march_periods as orbit_periods
from vibropipe.orbits.room import new_sections
from vibropipe.orbits.settling import find_steady_state
from vibropipe.orbits.verdict import PERIODIC
from vibropipe.physics.effects import ALL_EFFECTS
from vibropipe.physics.exciter import Parameters
from vibropipe.physics.flow import DEGREE
from vibropipe.words.status import Status

FORCED = Parameters(1.0, -1.0, 0.2, 0.5, 0.01, 0.6, 0.8)
CHATTER = Parameters(0.3, 1.5, 0.2, 0.5, 0.0, 0.7, 0.7)


def marched(p, x, v, periods, capacity=2000):
    grid = exact_grid(ALL_EFFECTS, p)
    start = initial_state(ALL_EFFECTS, p, grid, 0.0, x, v, None)
    log = new_log(capacity, 100)
    end, status = march(
        ALL_EFFECTS,
        p,
        grid,
        start,
        Instant(periods, 0, 0.0),
        log,
        None,
        np.empty(DEGREE + 1),
        10**6,
    )
    return start, end, status, log


def steady_state(p):
    grid = exact_grid(ALL_EFFECTS, p)
    start = initial_state(ALL_EFFECTS, p, grid, 0.0, 0.0, 0.0, None)
    log = new_log(2000, 100)
    max_periods = np.int64(1000)
    c = np.empty(DEGREE + 1)
    return find_steady_state(
        ALL_EFFECTS,
        p,
        grid,
        start,
        log,
        c,
        max_periods,
        max_periods,
        None,
        new_sections(ALL_EFFECTS, max_periods),
    ), log


@pytest.mark.parametrize("periods", [1, 2, 5])
def test_the_derivative_is_that_of_the_marched_map(periods: int) -> None:
    x, v, step = 0.1, -0.2, 1e-6
    start, end, _status, log = marched(FORCED, x, v, periods)
    jacobian = np.reshape(
        return_map_jacobian(ALL_EFFECTS, FORCED, log, start, end, periods), (2, 2)
    )
    for column, (dx, dv) in enumerate([(step, 0.0), (0.0, step)]):
        up = np.array(state_xv(FORCED, marched(FORCED, x + dx, v + dv, periods)[1]))
        down = np.array(state_xv(FORCED, marched(FORCED, x - dx, v - dv, periods)[1]))
        np.testing.assert_allclose(jacobian[:, column], (up - down) / (2 * step), atol=2e-6)


def test_a_rest_forgets_where_the_mass_came_from() -> None:
    start, end, _status, log = marched(CHATTER, 0.0, 0.0, 1)
    assert log.counts[RESTS] >= 1
    assert return_map_jacobian(ALL_EFFECTS, CHATTER, log, start, end, 1) == (0.0, 0.0, 0.0, 0.0)


@given(st.tuples(*[st.floats(-3, 3)] * 4))
def test_multipliers_are_eigenvalues(matrix: tuple[float, float, float, float]) -> None:
    first, second = floquet_multipliers(*matrix)
    expected = np.linalg.eigvals(np.reshape(matrix, (2, 2)))
    assert abs(first) >= abs(second) - 1e-12
    assert first + second == pytest.approx(expected.sum(), abs=1e-12)
    assert first * second == pytest.approx(expected.prod(), abs=1e-11)


@pytest.mark.parametrize(
    "p", [FORCED, CHATTER, FORCED._replace(R1=0.0), FORCED._replace(h=0.0, R1=0.5)]
)
def test_closed_harmonics_and_energy_agree_with_quadrature(p: Parameters) -> None:
    orbit, log = steady_state(p)
    assert orbit.kind == PERIODIC
    m = orbit.m
    closed, direct = np.zeros(7, complex), np.zeros(7, complex)
    resting = orbit.end.home if orbit.end.mode == REST else 0
    add_support_forces(p, log, resting, orbit.end.rest_start, m, float(m), closed)
    complete = divide_by_stiffness(p, m, float(m), closed)
    x, v = state_xv(p, orbit.state)
    energy = np.zeros(2)
    sums = Integrals(energy, np.zeros(0), direct, m)
    integrate_along(ALL_EFFECTS, p, x, v, 0.0, float(m), orbit.end, log, sums, np.empty(DEGREE + 1))
    kept = np.arange(7) if complete else np.array([k for k in range(7) if k * p.nu / m != 1])
    np.testing.assert_allclose(closed[kept], direct[kept] / m, atol=1e-9)
    struck = log.support[: log.counts[0]] > 0
    before = log.velocity[: log.counts[0]][struck]
    after = before + log.impulse[: log.counts[0]][struck]
    lost = 0.5 * float(np.sum(before**2 - after**2))
    assert energy[0] == pytest.approx(energy[1] + lost, abs=1e-10)


@given(turns=st.floats(0, 1e6), steps=st.integers(1, 10_000))
def test_a_time_is_located_on_the_grid(turns: float, steps: int) -> None:
    period, step, theta = grid_time(turns, steps)
    assert 0 <= step < steps
    assert 0 <= theta < 1
    assert period + (step + theta) / steps == pytest.approx(turns, rel=1e-15, abs=1e-15)


def test_every_bound_has_a_status() -> None:
    _start, _end, status, _log = marched(FORCED, 0.0, 0.0, 1000, capacity=50)
    assert status == Status.LOG_FULL
    grid = exact_grid(ALL_EFFECTS, FORCED)
    start = initial_state(ALL_EFFECTS, FORCED, grid, 0.0, 0.0, 0.0, None)
    log = new_log(2000, 100)
    _end, status = march(
        ALL_EFFECTS, FORCED, grid, start, Instant(1000, 0, 0.0), log, None, np.empty(DEGREE + 1), 20
    )
    assert status == Status.MAX_IMPACTS
    broken = start._replace(y=math.nan)
    _end, status = march(
        ALL_EFFECTS,
        FORCED,
        grid,
        broken,
        Instant(1000, 0, 0.0),
        log,
        None,
        np.empty(DEGREE + 1),
        20,
    )
    assert status == Status.NOT_FINITE


def test_the_bound_on_impacts_holds_over_logs_filled_and_emptied() -> None:
    p = FORCED._replace(delta=-1.5, f=0.0, R1=1 - 1e-9, R2=1 - 1e-9)
    grid, log = exact_grid(ALL_EFFECTS, p), new_log(50, 10)
    start = initial_state(ALL_EFFECTS, p, grid, 0.0, -1.5, 0.0, None)
    max_events = np.int64(1000)
    _end, status = orbit_periods(
        ALL_EFFECTS, p, grid, start, np.int64(10**6), log, np.empty(DEGREE + 1), max_events
    )
    assert status == Status.MAX_IMPACTS
