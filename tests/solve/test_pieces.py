"""Soft supports and dry friction: references, Newmark's order, energy, and what `simulate` says of them."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from comparisons import reference

import vibropipe as vp
from vibropipe.solve import rebuild
from vibropipe.words.parameters import PARAMETERS
from vibropipe.words.regimes import Regime
from vibropipe.words.status import Status

MOTIONS = reference("effects")


def exciter_of(name: str) -> vp.Exciter:
    """Return the exciter of a reference motion."""
    entry = MOTIONS[name]
    names = {"friction": "d", "load": "q"}
    values = {n: float(entry[names.get(n, n)]) for n in PARAMETERS if names.get(n, n) in entry}
    # a soft support has the damping of the entry, and no restitution
    soft = {f"R{n}": 1.0 for n in "12" if values[f"k{n}"] > 0.0}
    return vp.Exciter(**values | soft)


def motion_of(name: str, **options: Any) -> Any:
    """Return a reference motion as computed."""
    entry = MOTIONS[name]
    start = float(entry["x0"]), float(entry["v0"])
    return vp.simulate(
        exciter_of(name), float(entry["tau_end"]), *start, samples_per_period=0, **options
    )


def events_of(motion: Any) -> list[tuple[float, str, float]]:
    """Return (tau, kind, velocity) of the events of a motion, named and sorted as those of the references."""
    found: list[tuple[float, int, str, float]] = []
    durations = motion.get("contact_duration", np.nan * motion["impact_tau"]).values
    columns = ("impact_tau", "impact_support", "impact_velocity", "impact_velocity_after")
    for (tau, support, before, after), lasts in zip(
        zip(*(motion[name].values for name in columns), strict=True), durations, strict=True
    ):
        is_soft = float(motion.coords.get(f"k{support}", 0.0)) > 0.0
        found.append((tau, 0, f"in{support}" if is_soft else f"{support}", before))
        if math.isfinite(lasts):
            found.append((tau + lasts, 0, f"out{support}", after))
    for order, (kind, name) in enumerate(
        (("turn", "turn_tau"), ("stick", "stick_start"), ("slip", "stick_end")), start=1
    ):
        if name in motion:
            found += [(tau, order, kind, 0.0) for tau in motion[name].values if math.isfinite(tau)]
    return [(tau, kind, v) for tau, _order, kind, v in sorted(found)]


@pytest.mark.parametrize("name", MOTIONS)
def test_motions_and_events_agree_with_the_references(name: str) -> None:
    motion, entry = motion_of(name, energy=True), MOTIONS[name]
    assert int(motion["status"]) == Status.OK
    assert abs(float(motion["displacement_end"]) - float(entry["x_end"])) < 1e-12
    assert abs(float(motion["velocity_end"]) - float(entry["v_end"])) < 1e-12
    assert abs(float(motion["energy_residual"])) < 1e-13
    events = events_of(motion)
    assert [kind for _tau, kind, _v in events] == [event["kind"] for event in entry["events"]]
    for (tau, _kind, velocity), expected in zip(events, entry["events"], strict=True):
        assert abs(tau - float(expected["tau"])) < 1e-12
        assert abs(velocity - float(expected["velocity_before"])) < 1e-12


@pytest.mark.slow
@pytest.mark.parametrize("name", ["soft_one", "friction"])
def test_newmark_converges_with_the_square_of_the_step(name: str) -> None:
    errors = []
    for steps in (400, 800, 1600):
        motion = motion_of(name, method="newmark", steps_per_period=steps)
        errors.append(abs(float(motion["displacement_end"]) - float(MOTIONS[name]["x_end"])))
    ratios = np.array(errors[:-1]) / errors[1:]
    assert (abs(ratios - 4.0) < 0.4).all()


def test_the_force_and_the_depth_of_one_contact() -> None:
    # x'' + x = 0 from the support on, x'' + 101 (x - b) = -b in contact: an oscillation about -b/101.
    exciter = vp.Exciter(l=0.5, k1=100.0)
    motion = vp.simulate(exciter, 3.0, 0.0, 1.0, samples_per_period=0)
    speed, rate = math.sqrt(0.75), math.sqrt(101.0)
    depth = math.hypot(speed / rate, 0.5 / 101.0) - 0.5 / 101.0
    duration = (math.pi - 2.0 * math.atan2(0.5 / rate, speed)) / rate
    assert float(motion["impact_velocity"][0]) == pytest.approx(speed, rel=1e-14)
    assert float(motion["impact_velocity_after"][0]) == pytest.approx(-speed, rel=1e-14)
    assert float(motion["contact_depth_max"][0]) == pytest.approx(depth, rel=1e-14)
    assert float(motion["contact_force_max"][0]) == pytest.approx(100.0 * depth, rel=1e-14)
    assert float(motion["contact_duration"][0]) == pytest.approx(duration, rel=1e-14)


def test_a_contact_at_the_end_is_not_over() -> None:
    motion = vp.simulate(vp.Exciter(l=0.5, k1=1.0), 1.0, 0.0, 1.0, samples_per_period=16)
    assert motion["impact_velocity_after"].isnull().all()
    assert motion["contact_duration"].isnull().all()
    assert float(motion["displacement"].max()) > 0.5


@pytest.mark.parametrize("k", [1e2, 1e5, 1e8])
def test_a_stiff_support_loses_no_digits(k: float) -> None:
    # without force and damping the energy tells the velocity at each impact
    motion = vp.simulate(vp.Exciter(l=0.5, k1=k, k2=k), 40.0, 0.0, 1.0, samples_per_period=0)
    speeds = np.abs(motion["impact_velocity"].values)
    assert speeds.size > 10
    assert abs(speeds / math.sqrt(0.75) - 1.0).max() < 1e-13
    assert np.ptp(motion["contact_duration"].values) < 1e-12 * motion["contact_duration"].values[0]


def test_free_friction_loses_twice_itself_at_every_turn() -> None:
    motion = vp.simulate(vp.Exciter(l=2.0, friction=0.1), 20.0, 1.0, samples_per_period=0)
    # 1 -> -0.8 -> 0.6 -> -0.4 -> 0.2 -> 0, where it sticks
    assert np.allclose(motion["turn_tau"], math.pi * np.arange(1, 6), rtol=1e-14)
    assert float(motion["displacement_end"]) == pytest.approx(0.0, abs=1e-15)
    assert motion["stick_start"].values[-1] == pytest.approx(5 * math.pi)
    assert motion["stick_end"].values[-1] == math.inf


def test_a_force_that_exceeds_the_friction_by_less_than_rounding() -> None:
    # The spring alone pulls as much as the friction holds; what the force adds is far below rounding.
    exciter = vp.Exciter(
        l=0.5, nu=0.3, f=-2.5e-139, h=0.42556842202358447, delta=-0.08639514326948855,
        friction=0.038946636351345994,
    )  # fmt: skip
    motion = vp.simulate(exciter, 12.0, exciter.friction, 2.2e-38, samples_per_period=0)
    assert int(motion["status"]) == Status.OK
    assert motion.sizes["turn"] < 10
    assert float(motion["displacement_end"]) == pytest.approx(exciter.friction, abs=1e-15)


def test_a_mass_that_hardly_touches_a_soft_support_under_tiny_friction_is_not_held() -> None:
    # The contact at the start takes 1e-20 of a step; to hold the mass for that step moved its end by 0.02.
    exciter = vp.Exciter(l=0.5, nu=1.0, f=1.0, delta=-0.24803788093940768, R1=1.0, R2=1.0, k2=1.0)
    free = vp.simulate(exciter, 12.0, exciter.lower, -1e-20, samples_per_period=0)
    held = vp.simulate(
        replace(exciter, friction=1e-8), 12.0, exciter.lower, -1e-20, samples_per_period=0
    )
    for name in ("displacement_end", "velocity_end"):
        assert float(held[name]) == pytest.approx(float(free[name]), abs=1e-6)


def test_newmark_lists_a_stick_that_begins_with_a_step() -> None:
    # A slip whose step does not begin to move is held for a step, and then sticks again.
    exciter = vp.Exciter(
        l=0.5, nu=0.97065423, f=-1.38405872, h=0.08427633, delta=-0.34925027, R1=1.0, R2=1.0,
        k1=36484.683, k2=3.59865593, h1=166.858875, h2=0.0917849666, friction=0.0461322542,
    )  # fmt: skip
    task = exciter, 20.0, -0.42437759, 0.65212625
    exact = vp.simulate(*task, samples_per_period=0)
    motion = vp.simulate(*task, samples_per_period=0, method="newmark", steps_per_period=500)
    assert motion.sizes["stick"] >= exact.sizes["stick"] > 0
    assert (motion["stick_end"].values >= motion["stick_start"].values).all()


def test_at_rest_on_a_support_and_stuck_are_two_things() -> None:
    # a support beyond the equilibrium presses the mass; one at the equilibrium does not, but friction holds it
    pressed = vp.simulate(vp.Exciter(l=1.0, delta=-1.5, friction=0.2), 5.0, samples_per_period=0)
    assert (pressed.sizes["rest"], pressed.sizes["stick"]) == (1, 0)
    held = vp.simulate(vp.Exciter(l=1.0, friction=0.2), 5.0, 0.1, samples_per_period=0)
    assert (held.sizes["rest"], held.sizes["stick"]) == (0, 1)
    # it is released where the force exceeds spring and friction
    released = vp.simulate(
        vp.Exciter(l=1.0, delta=-1.5, friction=0.2, f=-1.0, nu=1.0), 5.0, samples_per_period=0
    )
    assert released["rest_end"].values[0] == pytest.approx(math.asin(0.7), rel=1e-13)


def test_a_chatter_against_friction_ends_earlier() -> None:
    exciters = [vp.Exciter(l=1.0, delta=-1.5, R1=0.8, friction=d) for d in (0.0, 0.1)]
    motions = [vp.simulate(e, 30.0, -0.6, samples_per_period=0) for e in exciters]
    starts = [float(motion["rest_start"][0]) for motion in motions]
    assert starts[1] < starts[0]
    ratios = [
        motion["impact_velocity"].values[1:] / motion["impact_velocity"].values[:-1]
        for motion in motions
    ]
    # the last hops rise against 0.5 + d and fall under 0.5 - d
    assert ratios[0][-1] == pytest.approx(0.8, rel=1e-5)
    assert ratios[1][-1] == pytest.approx(0.8 * math.sqrt(0.4 / 0.6), rel=1e-5)


def test_newmark_has_no_energy_balance_by_pieces() -> None:
    with pytest.raises(vp.ParameterError, match="energy: must be left out"):
        motion_of("friction", method="newmark", steps_per_period=100, energy=True)


def test_a_start_beyond_a_soft_support_is_in_contact() -> None:
    exciter = vp.Exciter(l=0.5, k1=100.0)
    motion = vp.simulate(exciter, 10.0, 0.6, samples_per_period=0, energy=True)
    speed = math.sqrt(0.6**2 - 0.5**2 + 100.0 * 0.1**2)
    # the contact at the start is not an impact, since the mass did not pass the support
    assert np.allclose(np.abs(motion["impact_velocity"]), speed, rtol=1e-13)
    assert int(motion["impact_support"][0]) == 2
    assert abs(float(motion["energy_residual"])) < 1e-14
    with pytest.raises(vp.ParameterError, match="x0: must be a finite number from"):
        vp.simulate(exciter, 1.0, -0.6)


def test_energies_of_a_motion_that_starts_with_an_impact() -> None:
    exciter = vp.Exciter(l=0.5, delta=0.1, friction=0.5)
    motion = vp.simulate(exciter, 12.0, exciter.upper, 1.0, samples_per_period=0, energy=True)
    assert float(motion["impact_tau"][0]) == 0.0
    assert abs(float(motion["energy_residual"])) < 1e-15
    assert float(motion["energy_friction"]) > 0.5


def test_a_contact_too_short_for_the_times_of_a_motion_has_a_status() -> None:
    """It ended in a mass glued to its support, with status ok."""
    exciter = vp.Exciter(l=0.5, nu=1.0, f=-1.0, h=0.2, R2=0.7, k1=1e60)
    with pytest.warns(vp.UnsolvedWarning, match="too many steps"):
        motion = vp.simulate(exciter, 10.0)
    assert motion.status == Status.MAX_STEPS
    assert np.isnan(motion.displacement_end)
    row = vp.steady_state(exciter)
    assert row.status == Status.MAX_STEPS
    assert row.regime == Regime.UNRESOLVED


def test_a_motion_is_made_again_from_within_a_contact_with_a_soft_support() -> None:
    soft = vp.Exciter(l=0.5, nu=1.8, f=0.6, h=0.1, delta=-0.05, k1=20.0, k2=15.0, R1=0.6, R2=0.5)
    state = vp.steady_state(soft)
    assert state.displacement_strobe < soft.lower
    motion = rebuild.motion_of(state)
    assert motion is not None
    x = motion.plain["displacement"].values
    assert x[0] == pytest.approx(float(state.displacement_strobe), rel=1e-12)
    assert x[-1] == pytest.approx(x[0], rel=1e-9)
