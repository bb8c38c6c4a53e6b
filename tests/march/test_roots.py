"""The certified search finds the first root of a gap, and one wherever there is one."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from vibropipe.march.log import COUNTS, EVALUATIONS
from vibropipe.march.roots import CROSSING, GRAZING, MAX_STRIDES, NONE, STRIDE_LIMIT, first_root
from vibropipe.physics.flow import DEGREE

COEFFICIENTS = st.lists(st.floats(-1, 1), min_size=5, max_size=9)


def search(
    c: list[float], power: int = 0, sign: float = 1.0, offset: float = 0.0, span: float = 1.0
) -> tuple[float, int]:
    """Return `first_root` of a polynomial with some coefficients."""
    full = np.zeros(DEGREE + 1)
    full[: len(c)] = c
    return first_root(full, power, sign, offset, 0.0, span, np.zeros(COUNTS, np.int64))


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
