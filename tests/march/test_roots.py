"""First roots of a gap: the certified search finds them, the fast one returns those that it certifies."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from vibropipe.march.fast_path import GapEnds, crosses_once, refine_root
from vibropipe.march.grid import StepGrid, exact_grid
from vibropipe.march.log import COUNTS, EVALUATIONS
from vibropipe.march.roots import (
    CROSSING,
    GRAZING,
    MAX_STRIDES,
    NONE,
    STRIDE_LIMIT,
    first_root,
    hop_end,
    unique_root,
)
from vibropipe.physics.effects import ALL_EFFECTS, effects_from_names
from vibropipe.physics.exciter import Parameters
from vibropipe.physics.flow import DEGREE, combine, motion
from vibropipe.physics.load import Force
from vibropipe.physics.turns import TWO_PI
from vibropipe.words.parameters import COMMON_EFFECTS

COEFFICIENTS = st.lists(st.floats(-1, 1), min_size=5, max_size=9)


def padded(c: list[float]) -> np.ndarray:
    """Return coefficients padded to the length that kernels take."""
    full = np.zeros(DEGREE + 1)
    full[: len(c)] = c
    return full


def search(
    c: list[float], power: int = 0, sign: float = 1.0, offset: float = 0.0, span: float = 1.0
) -> tuple[float, int]:
    """Return `first_root` of a polynomial with some coefficients."""
    return first_root(padded(c), power, sign, offset, 0.0, span, np.zeros(COUNTS, np.int64))


def first_by_companion(c: list[float], span: float) -> float | None:
    """Return the first real root on (0, span] from the companion matrix, or None."""
    roots = np.roots(np.trim_zeros(c, "b")[::-1])
    real = sorted(r.real for r in roots if abs(r.imag) < 1e-9 and 0 < r.real <= span)
    return real[0] if real else None


@given(c=COEFFICIENTS, span=st.floats(0.1, 1))
@example(c=[1e-9, 1.0, -4.0, 3.0, 0.0], span=1.0)
def test_the_first_root_is_that_of_the_companion_matrix(c: list[float], span: float) -> None:
    c = [abs(c[0]) + 1e-6, *(v if abs(v) > 1e-3 else 0.0 for v in c[1:])]
    expected = first_by_companion(c, span)
    theta, kind = search(c, span=span)
    if kind == NONE:
        at = np.linspace(0, span, 20001)
        assert (np.polyval(c[::-1], at) > -1e-12).all()
    else:
        assert kind in (CROSSING, GRAZING)
        assert expected is not None
        # The companion matrix gives a double root to half the digits only.
        assert theta == pytest.approx(expected, abs=1e-5)
        assert abs(np.polyval(c[::-1], theta)) < 1e-12


@pytest.mark.parametrize("depth", [10.0**-k for k in range(4, 13)])
@pytest.mark.parametrize("at", [0.001, 0.4, 0.97])
def test_a_penetration_is_a_crossing_and_a_clearance_is_none(depth: float, at: float) -> None:
    """The gap is (theta - at)^2 shifted down and up by depth."""
    theta, kind = search([at * at - depth, -2 * at, 1.0]) if at * at > depth else (0.0, CROSSING)
    assert kind == CROSSING
    if at * at > depth:
        assert theta == pytest.approx(at - depth**0.5, abs=1e-15 / depth**0.5)
    assert search([at * at + depth, -2 * at, 1.0])[1] == NONE


def test_a_contact_within_rounding_is_a_grazing() -> None:
    for off in (-1e-16, 0.0, 1e-16):
        theta, kind = search([0.25 + off, -1.0, 1.0])
        assert kind == GRAZING
        assert theta == pytest.approx(0.5, abs=1e-7)


@pytest.mark.parametrize("w", [0.4, 1e-6, 1e-12, 1e-18, 1e-150])
def test_a_return_to_the_support_just_left_keeps_its_digits(w: float) -> None:
    """The gap y = w theta - theta^2/2 is divided by theta; it returns to zero at theta = 2 w."""
    theta, kind = search([0.0, w / 4, -0.5 / 4], power=1)
    assert kind == CROSSING
    assert theta == pytest.approx(2 * w, rel=4e-16)


def test_a_gap_of_fourth_order_needs_few_strides() -> None:
    """Near a tangent release only the fourth derivative is not tiny; the gap starts at 1e-21."""
    for c3 in (-1e-12, -1.3e-17, 0.0, 1.3e-17):
        assert search([1.25e-21, 1.3e-16, 0.0, c3, 1.6e-2, 0.0, -6.5e-4])[1] == NONE


def test_the_far_support_uses_the_same_search() -> None:
    theta, kind = search([0.0, 0.8, 0.3], sign=-1.0, offset=0.5)
    assert kind == CROSSING
    assert 0.8 * theta + 0.3 * theta**2 == pytest.approx(0.5, abs=1e-15)


@given(c=COEFFICIENTS, scale=st.floats(-900, 900))
def test_the_search_is_invariant_to_scale(c: list[float], scale: float) -> None:
    c = [abs(c[0]) + 1e-3, *c[1:]]
    factor = 2.0 ** round(scale)
    assume(all(v == 0 or abs(v * factor) > 1e-290 for v in c))
    assert search(c) == search([v * factor for v in c])


def test_the_stride_limit_is_reported() -> None:
    """The gap (theta - 1/2)^8 is flatter than that of any motion; a nan coefficient gives no root."""
    c = np.zeros(DEGREE + 1)
    c[:9] = (np.poly1d([1.0, -0.5]) ** 8).coeffs[::-1]
    counts = np.zeros(COUNTS, np.int64)
    theta, kind = first_root(c, 0, 1.0, 0.0, 0.0, 1.0, counts)
    assert (kind, counts[EVALUATIONS]) == (STRIDE_LIMIT, MAX_STRIDES)
    assert 0.4 < theta < 0.5
    theta, kind = search([np.nan, -1.0])
    assert not theta > 1.0


FORCED = Parameters(1.0, 1.5, 0.2, 0.5, 0.0, 0.7, 0.7)
GRID: StepGrid = exact_grid(ALL_EFFECTS, FORCED)
NOT_CERTIFIED = -1.0
UNIT_RANGE = st.floats(-1, 1)


def sampled_roots(c: np.ndarray, span: float) -> list[float]:
    """Return the points on (0, span] at which a polynomial turns negative, from 20,001 samples."""
    at = np.linspace(0, span, 20001)
    values = np.polyval(c[::-1], at)
    return list(at[1:][(values[1:] <= 0) & (values[:-1] > 0)])


@given(
    first=st.floats(1e-3, 1),
    coefficients=st.lists(UNIT_RANGE, min_size=2, max_size=8),
    distance=st.floats(0.1, 3),
)
@example(first=0.5, coefficients=[-1.0, 0.2], distance=1.0)
@example(first=0.5, coefficients=[1.0, -2.0], distance=1.0)
@example(first=0.5, coefficients=[1.0, -2.0], distance=0.55)
def test_a_certified_root_is_the_only_one(
    first: float, coefficients: list[float], distance: float
) -> None:
    c = padded([first, *coefficients])
    theta = unique_root(GRID, c, 1.0, 0.0, first, float(c.sum()), 1.0, distance)
    if theta == NOT_CERTIFIED:
        return
    (root,) = sampled_roots(c, 1.0)
    assert theta == pytest.approx(root, abs=1e-4)
    assert abs(np.polyval(c[::-1], theta)) < 1e-14
    if c[1] > 0:
        assert np.polyval(c[::-1], np.linspace(0, theta, 1001)).max() < distance


@pytest.mark.parametrize(
    ("coefficients", "distance", "is_certified"),
    [
        ([-1.0, 0.2], 1.0, True),  # falls throughout
        ([1.0, -2.0], 1.5, True),  # concave, rises first
        ([1.0, -2.0], 1.0, False),  # may reach the other support first
        ([-3.0, 3.1], 1.0, False),  # closes and opens again
        ([-0.1], 1.0, False),  # stays open
    ],
)
def test_usual_impacts_are_certified(
    coefficients: list[float], distance: float, is_certified: bool
) -> None:
    c = padded([0.5, *coefficients])
    theta = unique_root(GRID, c, 1.0, 0.0, 0.5, float(c.sum()), 1.0, distance)
    assert (theta != NOT_CERTIFIED) == is_certified


@given(
    speed=st.floats(1e-9, 1),
    coefficients=st.lists(UNIT_RANGE, min_size=1, max_size=8),
    far=st.floats(0.01, 1),
)
@example(speed=1e-9, coefficients=[-1.0, 0.3], far=1.0)
@example(speed=0.4, coefficients=[-1.0, 0.1], far=1.0)
def test_a_hop_ends_at_its_first_return(
    speed: float, coefficients: list[float], far: float
) -> None:
    c = padded([0.0, speed, *coefficients])
    theta = hop_end(GRID, c, far, float(c.sum()), 1.0)
    if theta == NOT_CERTIFIED:
        return
    quotient = c[1:]
    assert abs(np.polyval(quotient[::-1], theta)) < 1e-14
    before = np.linspace(0, theta * (1 - 1e-9), 1001)
    assert (np.polyval(quotient[::-1], before) > 0).all()
    assert np.polyval(c[::-1], before).max() < far


def test_a_concave_hop_is_certified() -> None:
    for speed in (1e-12, 1e-3, 0.4):
        c = padded([0.0, speed, -1.0, 0.1])
        expected = np.roots([0.1, -1.0, speed]).min()
        assert hop_end(GRID, c, 1.0, float(c.sum()), 1.0) == pytest.approx(expected, rel=1e-14)


@given(
    y=UNIT_RANGE,
    w=st.floats(-3, 3),
    load=UNIT_RANGE,
    phase=st.floats(0, 1),
    near=UNIT_RANGE,
    distance=st.floats(0.1, 2),
)
@example(y=0.1, w=-1.0, load=0.0, phase=0.2, near=-0.1, distance=1.0)
@example(y=0.02, w=0.3, load=-1.0, phase=0.75, near=0.0, distance=1.0)
def test_a_step_certified_by_its_ends_has_one_root(
    y: float, w: float, load: float, phase: float, near: float, distance: float
) -> None:
    s, rate = FORCED.f * np.sin(TWO_PI * phase), FORCED.f * np.cos(TWO_PI * phase)
    c = np.empty(DEGREE + 1)
    combine(ALL_EFFECTS, GRID.basis, c, y, w, load, Force(s, rate))
    y1, w1 = motion(c, 1.0, GRID.dt)
    ends = y - near, y1 - near, w * GRID.dt, w1 * GRID.dt
    if not crosses_once(GRID, y, w, load, *ends, distance):
        return
    gap = c.copy()
    gap[0] -= near
    (root,) = sampled_roots(gap, 1.0)
    if w > 0:
        assert np.polyval(gap[::-1], np.linspace(0, root, 1001)).max() < distance
    theta, slope = refine_root(ALL_EFFECTS, FORCED, GRID, c, load, GapEnds(1.0, -near, *ends))
    if theta <= 1.0:
        assert theta == pytest.approx(root, abs=1e-4)
        assert abs(np.polyval(gap[::-1], theta)) < 1e-15
        assert slope == pytest.approx(np.polyval(np.polyder(gap[::-1]), theta), abs=1e-12)


@pytest.mark.parametrize(("y", "w", "load"), [(0.1, -1.0, 0.0), (0.02, 0.3, -2.0)])
def test_falling_and_concave_steps_are_certified(y: float, w: float, load: float) -> None:
    c = np.empty(DEGREE + 1)
    combine(ALL_EFFECTS, GRID.basis, c, y, w, load, Force(0.0, 0.0))
    y1, w1 = motion(c, 1.0, GRID.dt)
    assert crosses_once(GRID, y, w, load, y, y1, w * GRID.dt, w1 * GRID.dt, 1.0)


@given(y=st.floats(0.01, 0.2), w=st.floats(-3, -0.5), load=UNIT_RANGE)
@example(y=0.1, w=-1.0, load=0.0)
def test_unforced_refinement_agrees_with_the_polynomial(y: float, w: float, load: float) -> None:
    c = np.empty(DEGREE + 1)
    combine(ALL_EFFECTS, GRID.basis, c, y, w, load, Force(0.0, 0.0))
    y1, w1 = motion(c, 1.0, GRID.dt)
    ends = y, y1, w * GRID.dt, w1 * GRID.dt
    if not crosses_once(GRID, y, w, load, *ends, 1.0):
        return
    arguments = FORCED, GRID, c, load, GapEnds(1.0, 0.0, *ends)
    theta, slope = refine_root(ALL_EFFECTS, *arguments)
    unforced = effects_from_names([name for name in COMMON_EFFECTS if name != "forcing"])
    assert refine_root(unforced, *arguments) == pytest.approx((theta, slope), rel=1e-14)
