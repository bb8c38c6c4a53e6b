"""The closed-form flight against the Taylor steps of the march, at resonance, critical and strong damping."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from strategies import log

import vibropipe as vp
from vibropipe.physics.flow import DEGREE, displacement, steps_for_exact, taylor, velocity
from vibropipe.physics.forced_flow import acceleration, fly_freely
from vibropipe.physics.load import force_at


def taylor_flight(p, start, end, x, v):
    """The same flight in short steps of the polynomial, which shares no formula with the closed form."""
    steps = max(1, int(np.ceil(2 * (end - start) * steps_for_exact(p.nu, p.h))))
    dt = (end - start) * 2 * np.pi / p.nu / steps
    c = np.empty(DEGREE + 1)
    for step in range(steps):
        turn = start + (end - start) * step / steps
        taylor(c, x, v, force_at(p, 1.0, turn), 0.0, p.h, p.nu, dt)
        x, v = displacement(c, DEGREE, 1.0), velocity(c, DEGREE, 1.0, dt)
    return x, v


@given(
    nu=st.one_of(st.sampled_from([1.0, 1 + 1e-9, 1 - 1e-12]), log(-1, 1)),
    h=st.one_of(st.sampled_from([0.0, 1e-12, 2.0, 2 + 1e-12, 2 - 1e-9]), log(-6, 1.5)),
    start=st.floats(-2, 2),
    length=log(-3, 0.5),
)
@example(nu=1.0, h=0.0, start=0.3, length=5.0)
def test_flight_is_that_of_short_steps(nu: float, h: float, start: float, length: float) -> None:
    p = vp.Exciter(l=1.0, nu=nu, f=1.0, h=h).parameters()
    x, v = taylor_flight(p, start, start + length, 0.7, -0.4)
    found = fly_freely(p, start, start + length, 0.7, -0.4)
    # The steps lose an ulp each, and the motion grows at resonance.
    assert found[:2] == pytest.approx((x, v), abs=2e-13 * (1 + length / nu))


def test_derivatives_are_those_of_differences() -> None:
    p = vp.Exciter(l=1.0, nu=1.3, f=0.8, h=0.2).parameters()
    x, v, *matrix = fly_freely(p, 0.1, 0.9, 0.3, 0.5)
    step = 1e-6
    columns = [
        (np.array(fly_freely(p, 0.1, 0.9, *ahead)[:2]) - fly_freely(p, 0.1, 0.9, *back)[:2])
        / 2
        / step
        for ahead, back in (
            ((0.3 + step, 0.5), (0.3 - step, 0.5)),
            ((0.3, 0.5 + step), (0.3, 0.5 - step)),
        )
    ]
    assert np.transpose(columns).ravel() == pytest.approx(matrix, abs=1e-9)
    later, earlier = (fly_freely(p, 0.1, 0.9 + side * step, 0.3, 0.5) for side in (1, -1))
    rate = 2 * step * 2 * np.pi / p.nu
    assert (later[0] - earlier[0]) / rate == pytest.approx(v, abs=1e-8)
    assert (later[1] - earlier[1]) / rate == pytest.approx(acceleration(p, x, v, 0.9), abs=1e-8)
