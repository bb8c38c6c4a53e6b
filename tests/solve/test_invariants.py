"""Invariants of every exciter, by both methods, for any parameters.

Each `check_*` states an invariant once. It runs over 300 examples (`strategies`), and over 20,000 as a slow test.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from comparisons import impacts_of, rests_of
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from strategies import PINNED, Case, cases

import vibropipe as vp
from vibropipe.words.status import Status

EPS = np.finfo(float).eps
MIRRORED = ("displacement", "velocity", "force", "impact_velocity", "impact_velocity_after")
KEPT = ("tau", "impact_tau", "rest_start", "rest_end", "grazing_tau")
SWAPPED = ("impact_support", "rest_support", "grazing_support")
# Options of a motion without samples.
ENDS: dict[str, Any] = {"samples_per_period": 0}


def over_all(check: Callable[[Case], None]) -> tuple[Any, Any]:
    """Return the check as a test over 300 examples, and as a slow one over 20,000."""
    patient = settings(max_examples=20_000, derandomize=False)(given(cases())(check))
    short = given(cases())(check)
    for case in PINNED:
        short = example(case)(short)
    return short, pytest.mark.slow(patient)


def check_numbers_are_finite_and_inside(case: Case) -> None:
    ds = case.run()
    lower, upper = case.rooms
    ulps = 4 * EPS * max(abs(lower), abs(upper))
    for name in ("displacement", "velocity", "force", "impact_tau", "impact_velocity"):
        assert np.isfinite(ds[name].values).all(), name
    x = np.append(ds.displacement.values, float(ds.displacement_end))
    assert np.isfinite(float(ds.velocity_end))
    assert (lower - ulps <= x).all()
    assert (x <= upper + ulps).all()


def check_events_are_in_order_and_resets_lose_energy(case: Case) -> None:
    ds = case.run()
    tau = ds.impact_tau.values
    assert (np.diff(tau) >= 0).all()
    assert ((tau >= 0) & (tau <= case.tau_end)).all()
    R = {1: case.exciter.R1, 2: case.exciter.R2}
    rounding = EPS * np.abs(ds.impact_velocity.values).max(initial=0.0)
    for _, support, before, after in impacts_of(ds):
        side = 1 if support == 1 else -1
        assert side * before > 0
        assert after == pytest.approx(-R[support] * before, rel=1e-15, abs=rounding)
        assert abs(after) <= abs(before)
    rests = rests_of(ds)
    for start, end, support in rests:
        assert 0 <= start < end
        assert not ((tau > start) & (tau < end)).any()
        assert support in (1, 2)
    assert all(one[1] <= two[0] for one, two in itertools.pairwise(rests))


def check_mirror(case: Case) -> None:
    one = case.run()
    two = case._replace(exciter=case.exciter.mirrored(), x0=-case.x0, v0=-case.v0).run()
    for name in MIRRORED:
        np.testing.assert_array_equal(one[name].values, -two[name].values, err_msg=name)
    for name in KEPT:
        np.testing.assert_array_equal(one[name].values, two[name].values, err_msg=name)
    for name in SWAPPED:
        np.testing.assert_array_equal(one[name].values, 3 - two[name].values, err_msg=name)
    assert float(one.displacement_end) == -float(two.displacement_end)
    assert float(one.velocity_end) == -float(two.velocity_end)
    assert int(one.status) == int(two.status)


def seconds(case: Case) -> float:
    started = time.process_time()
    case.run(samples_per_period=0)
    return time.process_time() - started


def check_time_is_bounded(case: Case) -> None:
    """The first run of a kind may compile; the next may not."""
    assert seconds(case) < 2.0 or seconds(case) < 2.0


def check_samples_end_at_tau_end(case: Case) -> None:
    ds = case.run()
    tau = ds.tau.values
    assert tau[0] == 0
    assert tau[-1] == case.tau_end
    assert (np.diff(tau) > 0).all()
    assert float(ds.displacement[-1]) == float(ds.displacement_end)
    assert float(ds.velocity[-1]) == float(ds.velocity_end)


def check_energy_balance(case: Case) -> None:
    """Work of the force = losses + change of stored energy: to rounding for exact, to second order for newmark."""
    ds = case.run(samples_per_period=0, energy=True)
    if int(ds.status) not in (Status.OK, Status.SHORT_FLIGHTS):
        return
    struck = 0.5 * float(np.sum(ds.impact_velocity.values**2))
    x, v = float(ds.displacement_end), float(ds.velocity_end)
    stored = 0.5 * (x * x + v * v + case.x0**2 + case.v0**2)
    size = struck + stored + float(ds.energy_damping) + abs(float(ds.energy_input))
    # A creep at h = 1e4 rounds once per time 1/h, always in the same direction.
    share, nu = 1e-11 + EPS * case.exciter.h * case.tau_end, case.exciter.nu
    if case.method:
        step = 2 * math.pi / nu / case.method["steps_per_period"]
        share += 0.1 * (step * max(1.0, nu, case.exciter.h)) ** 2
    # A place within the rounding of the room is on the support: what a force does on such a way is not seen.
    force = abs(case.exciter.f) + abs(case.rooms[0]) + abs(case.rooms[1])
    unseen = EPS * (case.exciter.l + abs(case.exciter.delta)) * force
    assert abs(float(ds.energy_residual)) <= share * size + unseen


def nudge(case: Case, x: float, of_x: float, of_room: float, to_h: float) -> Case:
    """Return the case from x times `of_x`, with its supports times `of_room` and its damping plus `to_h`.

    A start on a support stays on it.
    """
    e = case.exciter
    other = dataclasses.replace(e, l=e.l * of_room, delta=e.delta * of_room, h=e.h + to_h)
    nudged = case._replace(exciter=other)
    if x in case.rooms:
        return nudged._replace(x0=nudged.rooms[case.rooms.index(x)])
    return nudged._replace(x0=min(max(x * of_x, nudged.rooms[0]), nudged.rooms[1]))


def check_splitting(case: Case, share: float) -> None:
    """A motion continued from an intermediate state is the same: exact from any, newmark from the end of a step.

    The tolerance is 1e-12 of the motion and one rounding per time 1/h, plus the growth of a hundred ulps in the
    state at the split, in the supports and in the damping. The ulps themselves are followed: the speed of an impact
    that nearly grazes goes as the root of its depth, so that a larger perturbation, scaled down, is an underestimate.
    """
    whole = case.run()
    split = share * case.tau_end
    if case.method:
        step = 2 * math.pi / case.exciter.nu / case.method["steps_per_period"]
        split = math.floor(split / step) * step
    half = case.run(tau_end=split)
    x, v = float(half.displacement_end), float(half.velocity_end)
    second = case.run(x0=x, v0=v, tau_start=split, **ENDS)
    # Relative to the largest velocity: that of a start nearly at rest is no scale of the motion.
    ulps, e = 100 * EPS, case.exciter
    faster = math.copysign(ulps * float(np.abs(whole.velocity).max()), v)
    damped = nudge(case, x, 1 + ulps, 1.0, ulps * max(1.0, e.nu, e.h))
    narrow = nudge(case, x, 1.0, 1 - ulps, 0.0)
    near = [
        damped.run(v0=v + faster, tau_start=split, **ENDS),
        narrow.run(v0=v - faster, tau_start=split, **ENDS),
    ]
    assume(all(one.impact_tau.size == second.impact_tau.size for one in near))
    assume(all(one.rest_start.size == second.rest_start.size for one in near))
    for name in ("displacement", "velocity"):
        end = float(second[f"{name}_end"])
        grown = sum(abs(float(one[f"{name}_end"]) - end) for one in near)
        size = np.abs(whole[name].values).max() + np.abs(whole.displacement.values).max()
        roundings = 1e-12 + EPS * case.exciter.h * case.tau_end
        assert abs(float(whole[f"{name}_end"]) - end) <= roundings * size + grown


test_finite_and_inside, test_finite_and_inside_at_length = over_all(
    check_numbers_are_finite_and_inside
)
test_events, test_events_at_length = over_all(check_events_are_in_order_and_resets_lose_energy)
test_energy, test_energy_at_length = over_all(check_energy_balance)
test_mirror, test_mirror_at_length = over_all(check_mirror)
test_bounded_time, test_bounded_time_at_length = map(
    pytest.mark.benchmark, over_all(check_time_is_bounded)
)
test_samples, test_samples_at_length = over_all(check_samples_end_at_tau_end)


# The squares of such small numbers underflow: a contact was reported where there is none.
TINY = vp.Exciter(
    l=0.5,
    nu=0.23767561958313796,
    f=1e-300,
    h=2.8902639100224503e-05,
    delta=0.5,
    R1=0.0,
    R2=3.1622776601683795e-05,
)


@given(cases(), st.floats(0, 1))
@example(Case(TINY, 13.788582233137678, 0.0, 0.0, {}), 0.5625)
@example(Case(vp.Exciter(l=0.5, h=1e4, R1=0, R2=0), 10.0, -0.5, 0.0, {}), 0.5)
@example(Case(vp.Exciter(l=0.5, R1=0, R2=0), 2.0, -0.5, -1e-7, {}), 0.0)
@example(Case(vp.Exciter(l=0.5), 1.0, -0.5, -1.0, {}), 0.0)
# After an impact with R1 = 4e-7 the mass nearly grazes: an ulp of the start becomes 4e-10 at the end.
@example(
    Case(vp.Exciter(l=0.5, R1=4.402161300646418e-07), 7.619140625, 0.5, 1.0, {}), 0.8068371667196499
)
# An impact at rounding level (1e-13), which one of the motions classified as grazing.
@example(
    Case(
        vp.Exciter(l=0.5, nu=2.0, f=-2.3713737056616554e-07, R1=0, R2=0),
        3.9999990514508554,
        -0.5,
        0.0,
        {},
    ),
    0.5,
)
# The mass returns to the support that stopped it, with zero velocity.
@example(
    Case(
        vp.Exciter(l=1.0, nu=0.999999999999, delta=-0.125, R1=0, R2=0),
        9.428090415820634,
        -1.125,
        0.1,
        {},
    ),
    0.0,
)
# From a support to a grazing of it: perturbing all lengths alike has no effect.
@example(
    Case(
        vp.Exciter(
            l=2.371373705661655,
            nu=2.0,
            f=-0.1,
            delta=1.1856868528308275,
            R1=0.0,
            R2=0.0005623413251903491,
        ),
        12.884094651201913,
        -1.1856868528308275,
        0.31622776601683794,
        {},
    ),
    0.0,
)
@example(Case(vp.Exciter(l=1e-9, R1=0), 1e-12, -9.375000000000001e-10, -1e3, {}), 0.0)
def test_splitting(case: Case, share: float) -> None:
    check_splitting(case, share)


@pytest.mark.slow
@settings(max_examples=20_000, derandomize=False)
@given(cases(), st.floats(0, 1))
def test_splitting_at_length(case: Case, share: float) -> None:
    check_splitting(case, share)
