"""Shooting finds stable and unstable orbits; whether a motion settles on one is a separate decision."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np
import pytest
from comparisons import determinant
from oracles import Oracle
from textbook import Parameters as TextbookParameters

from vibropipe.march.grid import exact_grid
from vibropipe.march.log import Log, new_log
from vibropipe.march.state import initial_state
from vibropipe.orbits.closing import NEWTON_REACH, settles_on
from vibropipe.orbits.housing_jacobian import no_coupling
from vibropipe.orbits.return_map import floquet_multipliers, march_periods, state_xv
from vibropipe.orbits.room import new_sections
from vibropipe.orbits.settling import find_steady_state
from vibropipe.orbits.shooting import CLOSURE_TOLERANCE, Orbit, Shooting, shoot
from vibropipe.orbits.verdict import PERIODIC
from vibropipe.physics.effects import ALL_EFFECTS
from vibropipe.physics.exciter import Parameters
from vibropipe.physics.flow import DEGREE
from vibropipe.words.status import Status

TURN = 2 * math.pi
# Its symmetric orbit (1; 1, 1) is stable above the pitchfork bifurcation at nu = 1.475.
TWO_SIDED = Parameters(1.6, 1.0, 0.1, 0.5, 0.0, 0.7, 0.7)
# Its orbit (1; 1, 0) is stable up to the flip bifurcation at nu = 2.66.
ONE_SIDED = Parameters(2.3, 1.0, 0.1, 50.0, -50.0, 0.8, 0.8)
ALONE = no_coupling()


def kernel_arguments(p: Parameters, x: float, v: float) -> tuple[Any, ...]:
    grid = exact_grid(ALL_EFFECTS, p)
    return ALL_EFFECTS, p, grid, initial_state(ALL_EFFECTS, p, grid, 0.0, x, v, None)


def shot(
    p: Parameters, x: float, v: float, m: int, shooting: Shooting | None = None
) -> tuple[Orbit, Log]:
    log, c = new_log(2000, 100), np.empty(DEGREE + 1)
    bounds = Shooting() if shooting is None else shooting
    return shoot(*kernel_arguments(p, x, v), np.int64(m), bounds, log, c), log


def steady_state(p: Parameters, x: float = 0.0, v: float = 0.0) -> Any:
    log, c, max_periods = new_log(2000, 100), np.empty(DEGREE + 1), np.int64(1000)
    limits, sections = (max_periods, max_periods), new_sections(ALL_EFFECTS, max_periods)
    return find_steady_state(*kernel_arguments(p, x, v), log, c, *limits, None, sections)


def followed(p: Parameters, frequencies: Iterable[float]) -> tuple[Parameters, Orbit, Log]:
    """Return the steady state at p, continued along nu by shooting."""
    x, v = state_xv(p, steady_state(p).state)
    for nu in frequencies:
        p = p._replace(nu=float(nu))
        orbit, log = shot(p, x, v, 1)
        assert orbit.is_closed
        x, v = state_xv(p, orbit.state)
    return p, orbit, log


def image(p: Parameters, x: float, v: float, m: int) -> np.ndarray:
    """Return (x, v) after m forcing periods."""
    log, c = new_log(2000, 100), np.empty(DEGREE + 1)
    end, status = march_periods(*kernel_arguments(p, x, v), np.int64(m), log, c, np.int64(10**6))
    assert status == Status.OK
    return np.array(state_xv(p, end))


def past_the_pitchfork() -> tuple[Parameters, Orbit, Log]:
    return followed(TWO_SIDED, np.linspace(1.58, 1.4, 10))


def past_the_flip() -> tuple[Parameters, Orbit, Log]:
    return followed(ONE_SIDED, np.linspace(2.35, 2.7, 8))


@pytest.mark.parametrize(
    ("unstable", "struck", "sign"), [(past_the_pitchfork, (1, 1), 1), (past_the_flip, (1, 0), -1)]
)
def test_an_unstable_orbit_is_found_and_not_settled_on(
    unstable: Any, struck: tuple[int, int], sign: int
) -> None:
    p, orbit, log = unstable()
    assert orbit.residual <= CLOSURE_TOLERANCE
    assert orbit.status == Status.OK
    supports = log.support[: log.counts[0]]
    assert (int((supports == 1).sum()), int((supports == 2).sum())) == struck
    large, small = floquet_multipliers(*orbit.derivative)
    assert large.imag == 0
    assert sign * large.real > 1.1
    assert large * small == pytest.approx(determinant(p, 1, struck), rel=1e-9)
    x, v = state_xv(p, orbit.state)
    # A motion that starts near it settles on another orbit.
    other = steady_state(p, x + 1e-3, v)
    assert other.kind == PERIODIC
    assert abs(other.first) < 1
    assert np.abs(np.subtract(state_xv(p, other.state), (x, v))).max() > 1e-2
    assert not settles_on(orbit)


@pytest.mark.parametrize("unstable", [past_the_pitchfork, past_the_flip])
@pytest.mark.parametrize("m", [1, 2])
def test_the_derivative_is_that_of_the_return_map(unstable: Any, m: int) -> None:
    p, orbit, _log = unstable()
    x, v = state_xv(p, orbit.state)
    again, _log = shot(p, x, v, m)
    assert again.is_closed
    step = 1e-6
    differences = np.stack(
        [
            (image(p, x + dx, v + dv, m) - image(p, x - dx, v - dv, m)) / (2 * step)
            for dx, dv in [(step, 0.0), (0.0, step)]
        ],
        axis=1,
    )
    jacobian = np.reshape(again.derivative, (2, 2))
    np.testing.assert_allclose(jacobian, differences, rtol=1e-6, atol=1e-7)
    once = np.reshape(orbit.derivative, (2, 2))
    np.testing.assert_allclose(jacobian, np.linalg.matrix_power(once, m), rtol=1e-9, atol=1e-11)


def test_the_unstable_orbit_past_a_pitchfork_is_the_symmetric_one() -> None:
    """Half a period later the oracle is at the mirror image of the start."""
    p, orbit, _log = past_the_pitchfork()
    x, v = state_xv(p, orbit.state)
    half = TURN / p.nu / 2
    motion = Oracle(TextbookParameters(*p[: len(TextbookParameters._fields)])).run(2 * half, x, v)
    np.testing.assert_allclose(np.array(motion.state(half), float), (-x, -v), atol=1e-12)
    np.testing.assert_allclose(np.array(motion.state(2 * half), float), (x, v), atol=1e-11)


def test_what_settles_past_a_flip_has_twice_the_period() -> None:
    p, _orbit, _log = past_the_flip()
    double = steady_state(p)
    assert double.m == 2
    again, _log = shot(p, *state_xv(p, double.state), 2)
    assert again.iterations == 0
    assert settles_on(again)


def test_newtons_method_begins_only_within_its_bounds() -> None:
    p, orbit, _log = past_the_flip()
    x, v = state_xv(p, orbit.state)
    largest = abs(floquet_multipliers(*orbit.derivative)[0])
    for bounds, iterations in [
        (Shooting(max_multiplier=largest * 1.5), True),
        (Shooting(max_multiplier=largest / 1.5), False),
        (Shooting(within=1e-2), True),
        (Shooting(within=1e-4), False),
    ]:
        near, _log = shot(p, x + 1e-3, v, 1, bounds)
        assert near.is_closed == iterations
        assert (near.iterations > 0) == iterations
        assert near.first_change > 1e-3
        if iterations:
            assert near.distance == pytest.approx(1e-3, rel=1e-6)
    # A start on the orbit is returned with any bounds.
    assert shot(p, x, v, 1, Shooting(1e-9, 0.0))[0].is_closed


def test_a_bad_start_gives_an_orbit_that_is_not_closed() -> None:
    orbit, _log = shot(TWO_SIDED, 0.0, math.nan, 1)
    assert not orbit.is_closed
    assert orbit.status == Status.NOT_FINITE
    assert not settles_on(orbit)


def test_who_settles_is_judged_by_stability_and_distance() -> None:
    state = kernel_arguments(TWO_SIDED, 0.1, 0.0)[3]
    stable, unstable = (0.5, 0.0, 0.0, 0.1), (1.5, 0.0, 0.0, 0.1)
    near = Orbit(True, 0, 1, state, state, 0.0, stable, 1, 1e-3, 1e-3, 5e-4, 0.0, 1.0, ALONE)
    reach = NEWTON_REACH * near.first_change / (1 - 0.5)
    assert settles_on(near)
    assert settles_on(near._replace(distance=0.99 * reach))
    assert not settles_on(near._replace(distance=1.01 * reach))
    assert not settles_on(near._replace(derivative=unstable))
    assert settles_on(near._replace(derivative=unstable, iterations=0))
    assert not settles_on(near._replace(is_closed=False))
    assert not settles_on(near._replace(derivative=(math.nan,) * 4))


def test_a_motion_that_goes_away_from_an_orbit_does_not_settle_on_it() -> None:
    state = kernel_arguments(TWO_SIDED, 0.1, 0.0)[3]
    derivative = (0.5, 0.0, 0.0, 0.1)
    near = Orbit(True, 0, 1, state, state, 0.0, derivative, 1, 1e-3, 1e-3, 2e-3, 9e-4, 1.0, ALONE)
    assert settles_on(near)  # as predicted: derivatives that are not normal lead away at first
    assert settles_on(near._replace(mismatch=5e-3, image_distance=9e-4))
    assert not settles_on(near._replace(mismatch=5e-3))
    assert not settles_on(near._replace(mismatch=math.nan, image_distance=math.nan))


# Slow passages of a stable orbit, next to an unstable one, on the way to another: the start is at rest.
PASSAGES = [
    (Parameters(1.1130070912, -2.2282288540, 0.3625337840, 0.5, 0.0, 0.4730314875, 0.4730314875)),
    (Parameters(0.5988212938, 1.3592496272, 0.0938612273, 0.5, -0.1696133593, 0.8281476123, 0.6077553582)),
    (Parameters(1.5956230896, -2.2804035368, 0.0205235399, 0.5, 0.0, 0.7924874429, 0.7924874429)),
]  # fmt: skip


@pytest.mark.parametrize("p", PASSAGES)
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_orbit_of_a_slow_passage_is_the_one_of_a_long_march(p: Parameters, sign: float) -> None:
    """Of a pair of mirror images, or of one orbit's two phases, the one that the motion goes to."""
    p = p._replace(f=sign * p.f, delta=sign * p.delta)
    if sign < 0.0:
        p = p._replace(R1=p.R2, R2=p.R1)
    orbit = steady_state(p)
    log, c = new_log(2000, 100), np.empty(DEGREE + 1)
    periods = np.int64(orbit.periods_marched + 300 * orbit.m)
    end, _ = march_periods(*kernel_arguments(p, 0.0, 0.0), periods, log, c, np.int64(10**6))
    np.testing.assert_allclose(state_xv(p, orbit.state), state_xv(p, end), atol=1e-3)
