"""Invariants of random motions with soft supports and friction, and their agreement with 40 digits."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from decimal import Decimal
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

import vibropipe as vp
from vibropipe.lab.hard_cases.case import Solver
from vibropipe.lab.hard_cases.pieces import agrees_with_reference
from vibropipe.lab.reference_solver import ReferenceSolver
from vibropipe.words.status import Status

TAU_END = 12.0


class Start(NamedTuple):
    """A random motion."""

    exciter: vp.Exciter
    x0: float
    v0: float


@st.composite
def motions(draw: Any, lossless: bool = False) -> Start:
    """Draw a motion with a soft support, or friction, or both."""
    number = lambda low, high: draw(st.floats(low, high, allow_subnormal=False))  # noqa: E731
    of_support = {}
    for support in "12":
        k = draw(st.just(0.0) | st.floats(0.0, 6.0).map(lambda n: 10.0**n))
        of_support[f"k{support}"] = k
        of_support[f"R{support}"] = 1.0 if lossless else number(0.1, 1.0)
        if k > 0.0 and draw(
            st.booleans()
        ):  # a damping of its own, in place of that of a restitution
            h = 2.0 * math.sqrt(k) * number(0.0, 1.5) * (not lossless)
            of_support |= {f"h{support}": h, f"R{support}": 1.0}
    friction = draw(st.just(0.0) | st.floats(0.01, 0.6)) * (not lossless)
    second = 0.0 if lossless else draw(st.just(0.0) | st.floats(-1.0, 1.0, allow_subnormal=False))
    assume(friction > 0.0 or of_support["k1"] + of_support["k2"] > 0.0)
    exciter = vp.Exciter(
        l=0.5,
        nu=number(0.3, 3.0),
        f=0.0 if lossless else number(-1.5, 1.5),
        h=0.0 if lossless else number(0.0, 0.5),
        delta=number(-0.4, 0.4),
        friction=friction,
        load=draw(st.just(0.0) | st.floats(-0.5, 0.5, allow_subnormal=False)),
        f2=second,
        phi2=number(-3.0, 3.0) if second else 0.0,
        **of_support,
    )
    return Start(exciter, number(exciter.lower, exciter.upper), number(-1.0, 1.0))


def end_of(motion: Start, **changed: float) -> np.ndarray:
    """Return (x, x') at the end."""
    x0, v0 = changed.get("x0", motion.x0), changed.get("v0", motion.v0)
    ds = vp.simulate(motion.exciter, TAU_END, x0, v0, samples_per_period=0)
    assert int(ds["status"]) == Status.OK
    return np.array([float(ds["displacement_end"]), float(ds["velocity_end"])])


def amplification(motion: Start) -> float:
    """Return by how much the motion amplifies a small change of its start, at least 1."""
    nudge = 1e-9
    x0 = motion.x0 + (nudge if motion.x0 < motion.exciter.delta else -nudge)
    return max(1.0, float(np.abs(end_of(motion, x0=x0) - end_of(motion)).max()) / nudge)


def balances(motion: Start) -> None:
    """Work of the force = losses by damping, at supports and by friction + stored energy."""
    ds = vp.simulate(
        motion.exciter, TAU_END, motion.x0, motion.v0, samples_per_period=0, energy=True
    )
    scale = 1.0 + abs(float(ds["energy_input"])) + float(ds["energy_impact"].sum())
    assert abs(float(ds["energy_residual"])) < 1e-11 * scale
    assert float(ds.get("energy_friction", 0.0)) >= 0.0


def mirrors(motion: Start) -> None:
    """x -> -x gives the same motion, bit for bit."""
    mirrored = Start(motion.exciter.mirrored(), -motion.x0, -motion.v0)
    assert (end_of(mirrored) == -end_of(motion)).all()


def splits(motion: Start) -> None:
    """A motion that is stopped and goes on from there ends as the whole."""
    first = vp.simulate(motion.exciter, 5.0, motion.x0, motion.v0, samples_per_period=0)
    assert int(first["status"]) == Status.OK
    x, v = float(first["displacement_end"]), float(first["velocity_end"])
    second = vp.simulate(motion.exciter, TAU_END, x, v, tau_start=5.0, samples_per_period=0)
    end = np.array([float(second["displacement_end"]), float(second["velocity_end"])])
    assert np.abs(end - end_of(motion)).max() < 1e-12 * amplification(motion) ** 2 + 1e-11


def keeps_energy(motion: Start) -> None:
    """Without force, damping and friction each contact gives back the speed that it takes."""
    ds = vp.simulate(motion.exciter, TAU_END, motion.x0, motion.v0, samples_per_period=0)
    after, before = ds["impact_velocity_after"].values, ds["impact_velocity"].values
    ended = np.isfinite(after)
    assert np.allclose(after[ended], -before[ended], rtol=1e-9, atol=1e-13)


def agrees_with_40_digits(motion: Start) -> None:
    """Events and end state are those of the twin in long arithmetic, where the motion is not too sensitive.

    Where a force is the friction within rounding, the twin tells a stick from a slip that no double can.
    """
    e = motion.exciter
    numbers = (e.f, e.h, e.f2, e.load, motion.v0)
    assume(all(number == 0.0 or abs(number) > 1e-6 for number in numbers))
    phase = np.linspace(0.0, 2.0 * math.pi, 4001)
    force = e.f * np.sin(phase) + e.f2 * np.sin(2.0 * phase + e.phi2)
    pull = e.load - motion.x0
    held = np.abs([pull, force.max(), *(pull + np.array([force[0], force.min(), force.max()]))])
    assume((np.abs(held - e.friction) > 2e-6).all())
    sensitivity = amplification(motion)
    assume(sensitivity < 1e4)
    task = (motion.exciter, TAU_END, motion.x0, motion.v0)
    assert agrees_with_reference(Solver("exact"), [task]) < 1e-12 * sensitivity**2 + 1e-10


def as_soft(rigid: vp.Exciter, k: float) -> vp.Exciter:
    """Return an exciter with soft supports that tend to the rigid ones of another."""
    of_support = {}
    for support in "12":
        log = math.log(getattr(rigid, f"R{support}"))
        of_support |= {
            f"k{support}": k,
            f"h{support}": -2.0 * log / math.hypot(math.pi, log) * math.sqrt(k),
        }
    return replace(rigid, **of_support)


def tends_to_rigid(motion: Start) -> None:
    """A motion with soft supports tends to the rigid one like 1/sqrt(k), unless impacts are slow or it chatters."""
    rigid = motion._replace(exciter=replace(motion.exciter, k1=0.0, k2=0.0, h1=0.0, h2=0.0))
    ds = vp.simulate(rigid.exciter, TAU_END, motion.x0, motion.v0, samples_per_period=0)
    speeds = np.abs(ds["impact_velocity"].values)
    assume(speeds.size > 0 and speeds.min() > 0.05 and ds.sizes["rest"] == 0)
    # A velocity that jumps tends to its limit only before and after the jump.
    assume(ds["impact_tau"].values[-1] < TAU_END - 0.1)
    end = end_of(rigid)
    # A soft support acts later and farther out at each impact, as if it were moved.
    moved = rigid._replace(exciter=replace(rigid.exciter, delta=rigid.exciter.delta + 1e-9))
    x0 = min(max(rigid.x0, moved.exciter.lower), moved.exciter.upper)
    by_support = float(np.abs(end_of(moved, x0=x0) - end).max()) / 1e-9
    sensitivity = max(amplification(rigid), by_support)
    assume(sensitivity < 100.0)
    soft = [motion._replace(exciter=as_soft(rigid.exciter, k)) for k in (1e4, 1e6, 1e8)]
    farther, far, near = (np.abs(end_of(each) - end).max() for each in soft)
    # A support that is soft enough for other impacts is far from a rigid one.
    struck = vp.simulate(soft[1].exciter, TAU_END, motion.x0, motion.v0, samples_per_period=0)
    assume(struck.sizes["impact"] == speeds.size)
    assert near < 0.02 * sensitivity
    # Terms of several orders may cancel at one stiffness, not at two.
    assert near < 0.3 * max(far, 0.1 * farther) + 1e-6 * sensitivity


def friction_vanishes(motion: Start) -> None:
    """A motion with little friction differs from the one without in proportion to it."""
    assume(abs(motion.exciter.f) > 1e-3)  # a force that the friction does not hold
    free = motion._replace(exciter=replace(motion.exciter, friction=0.0))
    end, sensitivity = end_of(free), amplification(free)
    assume(sensitivity < 1e3)
    more, less = (
        np.abs(end_of(motion._replace(exciter=replace(free.exciter, friction=d))) - end).max()
        for d in (1e-8, 1e-10)
    )
    assert more < 1e-3 * sensitivity
    assert less < 0.03 * more + 1e-11 * sensitivity


def lists_its_sticks(motion: Start) -> None:
    """By Newmark's steps a mass sticks and slips in turn; a stick that has not ended ends at infinity."""
    assume(motion.exciter.friction > 0.0)
    ds = vp.simulate(
        motion.exciter, TAU_END, motion.x0, motion.v0,
        samples_per_period=0, method="newmark", steps_per_period=200,
    )  # fmt: skip
    assert int(ds["status"]) in (Status.OK, Status.SHORT_FLIGHTS)
    start, end = ds["stick_start"].values, ds["stick_end"].values
    assert (start <= end).all()
    assert (end[:-1] <= start[1:]).all()
    assert np.isin(start[start > 0.0], ds["turn_tau"].values).all()


CHECKS: dict[str, tuple[Callable[[Start], None], Any, int]] = {
    "balances": (balances, motions(), 30),
    "mirrors": (mirrors, motions(), 30),
    "splits": (splits, motions(), 20),
    "keeps_energy": (keeps_energy, motions(lossless=True), 30),
    "tends_to_rigid": (tends_to_rigid, motions(), 20),
    "friction_vanishes": (friction_vanishes, motions(), 20),
    "lists_its_sticks": (lists_its_sticks, motions(), 20),
    "agrees_with_40_digits": (agrees_with_40_digits, motions(), 8),
}
SUPPRESSED = [HealthCheck.too_slow, HealthCheck.filter_too_much]


@pytest.mark.parametrize("many", [False, pytest.param(True, marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", CHECKS)
def test_random_motions(name: str, many: bool) -> None:
    check, strategy, few = CHECKS[name]
    count = 20_000 if many else few

    @settings(max_examples=count, deadline=None, suppress_health_check=SUPPRESSED)
    @given(strategy)
    def run(motion: Start) -> None:
        check(motion)

    run()


@pytest.mark.parametrize("z", [0.0, 0.05, 0.3, 0.7])
def test_a_soft_support_tends_to_a_rigid_one(z: float) -> None:
    limit = math.exp(-math.pi * z / math.sqrt(1.0 - z * z))
    errors = []
    for k in (1e5, 1e7):
        exciter = vp.Exciter(
            l=0.5,
            nu=1.0,
            f=-1.0,
            h=0.2,
            k1=k,
            k2=k,
            h1=2 * z * math.sqrt(k),
            h2=2 * z * math.sqrt(k),
        )
        ds = vp.simulate(exciter, 3.0, samples_per_period=0)
        errors.append(
            abs(-float(ds["impact_velocity_after"][0] / ds["impact_velocity"][0]) - limit)
        )
    assert errors[0] < 0.01
    assert errors[1] / errors[0] == pytest.approx(0.1, rel=0.1)


def test_the_twin_records_states_and_rests() -> None:
    exciter = vp.Exciter(l=1.0, delta=-1.5, f=-1.0, nu=0.8, friction=0.1)
    found = ReferenceSolver(exciter).run(-0.5, 0.0, [Decimal(n) / 10 for n in range(1, 11)])
    assert [event[1] for event in found.events] == ["rest", "release"]
    assert float(found.events[1][0]) == pytest.approx(math.asin(0.6) / 0.8, rel=1e-15)
    assert [float(x) for x, _v in found.states[:8]] == [-0.5] * 8
