"""Tangent release: the force amplitude equals the pull of a support, so the gap acceleration touches zero.

It does so once per forcing period, from above. After an impact with R = 0 at or near that instant the mass stands on
its support with neither gap acceleration nor jerk, and the gap grows with the fourth power of time. The mass leaves at
once: its motion is the closed form from the instant of the impact on, since no force holds it.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from comparisons import impacts_of
from textbook import Flight, Parameters, digits

import vibropipe as vp
from vibropipe.words.status import Status

TANGENT = Parameters(l=0.5, delta=-0.5, f=-1.0, R1=0.5, R2=0.0)
OFFSETS = [0.0, *(side * 10.0**-k for k in range(3, 14) for side in (1, -1))]
SPEED, LEAD, TAU_END = 1.0, 0.3, 3.0


def impact_near_release(p: Parameters, off: float, side: int, **method: Any) -> tuple[Any, Any]:
    """Return (dataset, exact final displacement) of a motion with an impact at the time `off` after the release.

    Support 2 is struck, or support 1 of the mirrored exciter.
    """
    c = digits(p, 110)  # at resonance
    at = c.pi / 2 + c.mpf(off)
    parameters = c.mpf(p.nu), c.mpf(p.f), c.mpf(p.h)
    before = Flight(c, *parameters, (at, c.mpf(p.lower), c.mpf(-SPEED)))
    after = Flight(c, *parameters, (at, c.mpf(p.lower), c.mpf(0)))
    tau = float(at) - LEAD
    x, v = (float(part) for part in before(c.mpf(tau)))
    e = vp.Exciter(**p._asdict())
    e = e if side == 2 else e.mirrored()
    sign = 1 if side == 2 else -1
    ds = vp.simulate(e, TAU_END, sign * x, sign * v, tau_start=tau, **method)
    return ds, sign * float(after(c.mpf(TAU_END))[0])


@pytest.mark.parametrize("side", [1, 2])
@pytest.mark.parametrize("off", OFFSETS)
def test_the_exact_method_leaves_by_snap(off: float, side: int) -> None:
    ds, expected = impact_near_release(TANGENT, off, side, samples_per_period=0)
    assert [i[1] for i in impacts_of(ds)] == [side]
    assert float(ds.displacement_end) == pytest.approx(expected, abs=1e-14)
    assert int(ds.status) == Status.OK
    # sticks at most until the gap acceleration is zero
    assert (ds.rest_end.values - ds.rest_start.values).sum() <= max(-off, 0.0) + 1e-12


@pytest.mark.parametrize("ulps", [-3, -1, 1, 2, 5])
@pytest.mark.parametrize("off", [0.0, 1e-9, -1e-9, 3e-8, -3e-8])
def test_a_force_within_ulps_of_the_pull_gives_the_same_motion(off: float, ulps: int) -> None:
    """A smaller force holds the mass for at most 1e-8, which does not count to the fourth power."""
    p = TANGENT._replace(f=-1.0 - ulps * 2.0**-53)
    ds, expected = impact_near_release(p, off, 2, samples_per_period=0)
    # contacts of zero velocity may follow while the support holds the mass
    assert [i[1] for i in impacts_of(ds) if abs(i[2]) > 1e-20] == [2]
    assert float(ds.displacement_end) == pytest.approx(expected, abs=1e-14)


@pytest.mark.parametrize("steps", [8, 60, 400])
@pytest.mark.parametrize("off", [0.0, 1e-9, -1e-9, 1e-3, -1e-3])
def test_newmark_leaves_with_an_error_of_second_order(off: float, steps: int) -> None:
    method = {"method": "newmark", "steps_per_period": steps}
    ds, expected = impact_near_release(TANGENT, off, 2, **method)
    assert [i[1] for i in impacts_of(ds)] == [2]
    assert float(ds.displacement_end) == pytest.approx(expected, abs=(2 * math.pi / steps) ** 2)
    assert (np.diff(ds.displacement.values[ds.tau.values > math.pi / 2 + 1.0]) > 0).all()


def test_a_start_at_rest_at_the_release_leaves() -> None:
    e = vp.Exciter(**TANGENT._asdict())
    c = digits(TANGENT, 110)
    for tau in (math.pi / 2, 5 * math.pi / 2 + 1e-9, 9 * math.pi / 2 - 1e-9):
        ds = vp.simulate(e, tau + 1.0, -1.0, 0.0, tau_start=tau, samples_per_period=0)
        start = c.mpf(tau), c.mpf(-1), c.mpf(0)
        expected, _ = Flight(c, c.mpf(1), c.mpf(-1), c.mpf(0), start)(c.mpf(tau) + 1)
        assert ds.impact_tau.size == 0
        assert float(ds.displacement_end) == pytest.approx(float(expected), abs=1e-14)
