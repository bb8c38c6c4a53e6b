"""Coincident events: on one another, on the start or end of a motion, and releases of zero rate."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from comparisons import disagreements, impacts_of, judge, methods, reference, rests_of
from textbook import Flight, Parameters, digits

import vibropipe as vp
from vibropipe.words.status import Status

TURN = 2 * math.pi
mirrors = pytest.mark.parametrize("side", [1, -1], ids=["support 1", "support 2"])


def exciter(side: int = 1, **parameters: float) -> Any:
    """Return an exciter defined for support 1, mirrored for support 2."""
    original = vp.Exciter(**parameters)
    return original if side == 1 else original.mirrored()


# -- starting on a support ---------------------------------------------------------------------

# The force is zero at tau = 0: the spring alone presses the mass on (delta < -l) or pulls it off (delta > -l).
PUSHED = {"l": 0.5, "delta": -0.8, "R1": 0.6}
PULLED = {"l": 0.5, "delta": 0.0, "R1": 0.6}
BALANCED = {"l": 0.5, "delta": -0.5, "R1": 0.6}


@methods
@mirrors
@pytest.mark.parametrize("speed", [0.3, 1e-7, 1e-12])
@pytest.mark.parametrize("where", [PUSHED, PULLED, BALANCED])
def test_a_start_into_a_support_has_one_impact_there(
    where: dict[str, float], speed: float, side: int, method: dict[str, Any]
) -> None:
    e = exciter(side, **where)
    start = {"x0": side * (0.5 + where["delta"]), "v0": side * speed}
    for tau_end in (0.0, 0.1):
        ds = vp.simulate(e, tau_end=tau_end, **start, **method)
        first = impacts_of(ds)[0]
        assert first[:2] == (0.0, 1 if side == 1 else 2)
        assert first[2:] == pytest.approx((side * speed, -side * 0.6 * speed), rel=1e-15)
        assert ds.impact_tau.values.tolist().count(0.0) == 1


@methods
@mirrors
@pytest.mark.parametrize("where", [PUSHED, PULLED, BALANCED])
def test_a_start_off_a_support_has_no_impact_there(
    where: dict[str, float], side: int, method: dict[str, Any]
) -> None:
    e = exciter(side, **where)
    ds = vp.simulate(e, tau_end=0.1, x0=side * (0.5 + where["delta"]), v0=-side * 0.3, **method)
    assert ds.impact_tau.size == 0
    assert ds.rest_start.size == 0
    assert side * float(ds.displacement_end) < 0.5 + where["delta"]


@methods
@mirrors
@pytest.mark.parametrize("where", [PUSHED, BALANCED])
def test_a_start_at_rest_and_not_pulled_stays(
    where: dict[str, float], side: int, method: dict[str, Any]
) -> None:
    ds = vp.simulate(
        exciter(side, **where), tau_end=30.0, x0=side * (0.5 + where["delta"]), **method
    )
    assert ds.impact_tau.size == 0
    assert rests_of(ds) == [(0.0, math.inf, 1 if side == 1 else 2)]
    assert float(ds.displacement_end) == side * (0.5 + where["delta"])
    assert float(ds.velocity_end) == 0


@methods
@mirrors
def test_a_start_at_rest_and_pulled_leaves(side: int, method: dict[str, Any]) -> None:
    ds = vp.simulate(exciter(side, **PULLED), tau_end=1.0, x0=side * 0.5, **method)
    assert ds.impact_tau.size == 0
    assert rests_of(ds) == []
    coarse = 1e-12 if not method else 0.4 / method["steps_per_period"]
    assert float(ds.displacement_end) == pytest.approx(side * 0.5 * math.cos(1), abs=coarse)


@methods
@mirrors
@pytest.mark.parametrize("f", [0.4, -0.4])
def test_a_balanced_start_follows_the_growing_force(
    f: float, side: int, method: dict[str, Any]
) -> None:
    """The support is at the equilibrium: the growing force presses (half a period of rest) or pulls."""
    e = exciter(side, **BALANCED, f=f, nu=2.0)
    ds = vp.simulate(e, tau_end=1.0, x0=0.0, **method)
    assert ds.impact_tau.size == 0
    if f > 0:
        assert rests_of(ds)[0][0] == 0.0
        assert float(ds.displacement_end) == 0
        late = vp.simulate(e, tau_end=2.0, x0=0.0, **method)
        assert rests_of(late)[0][1] == pytest.approx(math.pi / 2, abs=1e-12)
        assert side * float(late.displacement_end) < 0
    else:
        assert rests_of(ds) == []
        assert side * float(ds.displacement_end) < 0


@methods
@mirrors
def test_a_force_equal_to_the_spring_force_does_not_release(
    side: int, method: dict[str, Any]
) -> None:
    """f equals the spring force exactly: the gap acceleration touches zero once a period from below."""
    e = exciter(side, l=0.5, delta=-1.0, nu=1.0, f=-0.5, R1=0.5)
    ds = vp.simulate(e, tau_end=40.0, x0=-side * 0.5, **method)
    assert rests_of(ds) == [(0.0, math.inf, 1 if side == 1 else 2)]
    assert ds.impact_tau.size == 0


# -- events at one instant ---------------------------------------------------------------------


@methods
@pytest.mark.parametrize("name", ["fig9_offset", "one_sided_at_equilibrium", "plastic_R0"])
def test_an_impact_at_tau_end_precedes_the_end_state(name: str, method: dict[str, Any]) -> None:
    entry = reference("motions")[name]
    e = vp.Exciter(**{key: float(entry[key]) for key in Parameters._fields})
    start = {"x0": float(entry["x0"]), "v0": float(entry["v0"])}
    impacts = impacts_of(vp.simulate(e, tau_end=10.0, **start, **method))
    for k, (tau, support, before, after) in enumerate(impacts):
        if method and tau % (TURN / e.nu / method["steps_per_period"]) == 0:
            continue
        late = vp.simulate(e, tau_end=tau + 1e-9, **start, **method)
        early = vp.simulate(e, tau_end=tau - 1e-9, **start, **method)
        assert late.impact_tau.size == k + 1
        assert early.impact_tau.size == k
        assert float(late.velocity_end) == pytest.approx(after, abs=1e-7)
        assert float(early.velocity_end) == pytest.approx(before, abs=1e-7)
        if not method:
            at_impact = vp.simulate(e, tau_end=tau, **start)
            assert impacts_of(at_impact)[-1][1] == support
            assert at_impact.impact_tau.size == k + 1
            assert float(at_impact.velocity_end) == pytest.approx(after, abs=1e-13)
            assert float(at_impact.displacement[-1]) == float(at_impact.displacement_end)


@methods
def test_a_rest_that_ends_at_tau_end(method: dict[str, Any]) -> None:
    e = vp.Exciter(l=0.5, nu=0.7, f=1.2, h=0.2, R1=0.0, R2=0.0)
    start, end, _ = rests_of(vp.simulate(e, tau_end=5.0, **method))[0]
    for tau_end in (end, (start + end) / 2):
        ds = vp.simulate(e, tau_end=tau_end, **method)
        assert float(ds.displacement_end) == 0.5
        assert float(ds.velocity_end) == pytest.approx(0, abs=1e-15)
        assert rests_of(ds)[0][1] >= tau_end
    after = vp.simulate(e, tau_end=end + 0.1, **method)
    assert float(after.displacement_end) < 0.5


def test_an_impact_at_the_instant_of_release() -> None:
    """The gap acceleration is zero within rounding and grows: there is one impact, and the mass leaves."""
    p = Parameters(nu=1.0, f=1.0, h=0.0, l=0.5, R1=0.0, R2=0.0)
    release = math.pi - math.asin(0.5)  # sin(tau) falls below l here
    c = digits(p)
    back = Flight(c, c.mpf(1), c.mpf(1), c.mpf(0), (c.mpf(release), c.mpf("0.5"), c.mpf(1)))
    for off in (0.0, 1e-9, -1e-9):
        x0, v0 = (float(part) for part in back(c.mpf(release) + off - c.mpf("0.3")))
        start = {"x0": x0, "v0": v0, "tau_start": release + off - 0.3}
        ds = vp.simulate(vp.Exciter(**p._asdict()), tau_end=release + 2, **start)
        judged = judge(p, release + 2, **start)
        struck = [i for i in impacts_of(ds) if i[0] < release + 0.1]
        assert [i[1] for i in struck] == [1]
        x, _ = judged.motion.state(judged.motion.pieces[0][0])
        assert x0 == x
        # the motion after the release does not depend on the time of the impact, up to off
        assert float(ds.displacement_end) == pytest.approx(
            float(judged.motion.displacement_end), abs=1e-9
        )


@pytest.mark.parametrize("nu", [0.1, 1.0, 20.0])
def test_a_mass_stopped_by_a_support_grazes_it_every_period(nu: float) -> None:
    """R = 0 and no other loss: the mass returns to the support with zero velocity, a grazing per period."""
    e = vp.Exciter(l=0.7, delta=-0.1, nu=nu, f=1e-300, R1=0.0, R2=0.0)
    ds = vp.simulate(e, 1000.0, 0.0, 1.0, samples_per_period=0)
    start = math.asin(0.6)
    assert ds.impact_tau.values == pytest.approx([start], abs=1e-15)
    expected = start + TURN * np.arange(1, ds.grazing_tau.size + 1)
    assert ds.grazing_tau.size == (1000 - start) // TURN
    np.testing.assert_allclose(ds.grazing_tau, expected, rtol=0, atol=1e-6)
    # each grazing has its time within the root of rounding only; the energy is kept to rounding
    x, v = float(ds.displacement_end), float(ds.velocity_end)
    assert math.hypot(x, v) == pytest.approx(0.6, rel=1e-12)


@pytest.mark.parametrize("length", [1e-3, 1e-6, 1e-9, 1e-12])
def test_supports_close_together(length: float) -> None:
    """l -> 0 at fixed force: the mass strikes both supports in turn."""
    p = Parameters(nu=1.0, f=1.0, h=0.2, l=length, R1=0.9, R2=0.9)
    tau_end = 12 * length
    ds = vp.simulate(vp.Exciter(**p._asdict()), tau_end=tau_end, x0=0.0, v0=1.0)
    judged = judge(p, tau_end, 0.0, 1.0)
    assert len(judged.motion.impacts) >= 3
    assert not disagreements(p, ds, judged, tau_end)


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
