"""Work-precision comparison of motions with soft supports and friction: every method against 40 digits."""

import importlib.util
import math

import numpy as np
import pytest

import vibropipe as vp
from vibropipe.lab.motion_reference import MotionReference, reference_motion
from vibropipe.lab.peers.solve_ivp import Recorder
from vibropipe.lab.work_precision import build_method
from vibropipe.lab.work_precision_methods import BenchmarkMotion, newmark_crude
from vibropipe.words.measurements import Outcome

SHARED = {"l": 0.5, "nu": 1.0, "f": -1, "h": 0.2, "R1": 0.7, "R2": 0.7}
SOFT = BenchmarkMotion(
    vp.Exciter(**SHARED | {"R1": 1, "R2": 1}, k1=50, h1=1, k2=200, h2=0.5), 0.0, 0.0, 2
)
# Held from the start, and after each impact.
SLIDING = BenchmarkMotion(vp.Exciter(**SHARED, friction=0.2), 0.0, 0.0, 2)
BOTH = BenchmarkMotion(
    vp.Exciter(l=0.5, nu=0.8, f=0.9, h=0.05, f2=0.2, phi2=0.5, R1=0.7, k2=100, h2=2, friction=0.15),
    0.0,
    0.0,
    2,
)
MOTIONS = pytest.mark.parametrize(
    "motion", [SOFT, SLIDING, BOTH], ids=["soft", "friction", "soft supports and friction"]
)


@pytest.fixture(scope="module")
def reference():
    references = {motion: MotionReference(motion) for motion in (SOFT, SLIDING, BOTH)}
    return references.__getitem__


def errors_of(method, value, motion, reference):
    outcome, errors = reference(motion).errors(build_method(method, value, motion).show())
    assert outcome == Outcome.OK
    return np.array(errors)


@MOTIONS
def test_the_exact_method_is_at_rounding(motion, reference):
    assert errors_of("exact", math.nan, motion, reference).max() < 1e-13


@MOTIONS
def test_newmark_converges_with_order_2(motion, reference):
    coarse, fine = (errors_of("newmark", steps, motion, reference) for steps in (2048, 16384))
    assert np.log2(coarse / fine).max() / 3 == pytest.approx(2, abs=0.25)
    assert fine.max() < 1e-4


@MOTIONS
def test_crude_converges_with_order_1(motion, reference):
    coarse, fine = (errors_of("crude", steps, motion, reference).max() for steps in (2**12, 2**17))
    assert 0.7 < np.log2(coarse / fine) / 5 < 1.4


def crude_by_hand(motion, steps):
    """Constant average acceleration in absolute coordinates, each step with what acts at its beginning."""
    e, dt = motion.exciter, motion.exciter.period / steps
    x, v, contacts = motion.x0, motion.v0, []

    def force(n):
        return e.f * math.sin(n * e.nu * dt) + e.f2 * math.sin(2 * n * e.nu * dt + e.phi2)

    for n in range(motion.periods * steps):
        k, h, b = 0.0, 0.0, 0.0
        if x >= e.upper and e.k1 > 0:
            k, h, b = e.k1, e.h1, e.upper
        elif x <= e.lower and e.k2 > 0:
            k, h, b = e.k2, e.h2, e.lower
        pull = force(n) - x - k * (x - b)
        way = np.sign(v) if v != 0 else np.sign(pull)
        if v == 0 and abs(pull) <= e.friction != 0:
            continue
        before = force(n) - x - k * (x - b) - (e.h + h) * v - e.friction * way
        # a1 = F1 - friction - k (x1 - b) - x1 - h v1, with x1 and v1 by the average of both accelerations
        known_x, known_v = x + dt * v + 0.25 * dt * dt * before, v + 0.5 * dt * before
        rest = force(n + 1) - e.friction * way + k * b - (1 + k) * known_x - (e.h + h) * known_v
        after = rest / (1 + 0.5 * dt * (e.h + h) + 0.25 * dt * dt * (1 + k))
        x1, v1 = known_x + 0.25 * dt * dt * after, known_v + 0.5 * dt * after
        if e.friction > 0 and way * v1 < 0:
            v1 = 0.0
        for support, bound, stiffness in ((1, e.upper, e.k1), (2, e.lower, e.k2)):
            side = 1 if support == 1 else -1
            if side * x1 < side * bound:
                continue
            if stiffness > 0:
                if side * x < side * bound:
                    contacts.append((support, v1))
            else:
                x1 = bound
                if side * v1 > 0:
                    contacts.append((support, v1))
                    v1 = -0.7 * v1
        x, v = x1, v1
    return (x, v), contacts


@MOTIONS
def test_the_crude_kernel_follows_the_equations_of_the_method(motion):
    end, contacts = crude_by_hand(motion, 64)
    result = newmark_crude(motion, 64).show()
    assert contacts
    assert result.end == pytest.approx(end, abs=1e-10)
    assert result.impact_support.tolist() == [support for support, _ in contacts]
    np.testing.assert_allclose(result.impact_velocity, [v for _, v in contacts], atol=1e-10)


@MOTIONS
@pytest.mark.parametrize("method", ["DOP853", "Radau"])
def test_an_integrator_of_scipy_stops_at_each_end_of_a_piece(method, motion, reference):
    coarse, fine = (errors_of(method, value, motion, reference).max() for value in (1e-5, 1e-8))
    assert coarse < 1e-3
    assert fine < 2e-6


@MOTIONS
@pytest.mark.skipif(importlib.util.find_spec("heyoka") is None, reason="heyoka is not installed")
def test_heyoka_changes_its_equation_at_each_end_of_a_piece(motion, reference):
    assert errors_of("heyoka", 1e-15, motion, reference).max() < 1e-12


def test_beginnings_of_soft_contacts_are_impacts_of_the_reference():
    _states, impacts = reference_motion(SOFT, [3])
    assert len(impacts) >= 1
    run = vp.simulate(SOFT.exciter, tau_end=3.0)
    np.testing.assert_allclose(impacts[:, 0], run.impact_tau, rtol=1e-14)
    np.testing.assert_allclose(impacts[:, 2], run.impact_velocity, rtol=1e-13)


@pytest.mark.parametrize(
    ("start", "pressed", "direction"),
    [
        ((0.0, 0.0), 0, 0.0),
        ((0.0, -1.0), 0, -1.0),
        ((0.6, 0.0), 1, -1.0),
        ((0.5, 0.2), 1, 1.0),
        ((0.5, -0.2), 0, -1.0),
        ((0.5, 0.0), 0, -1.0),
        ((-0.5, -0.1), 2, -1.0),
    ],
)
def test_the_first_piece_of_a_run_follows_from_its_start(start, pressed, direction):
    run = Recorder(BenchmarkMotion(SOFT.exciter, *start, 1))
    assert (run.pressed, run.direction) == (pressed, direction)


def test_a_soft_support_is_not_fallen_through():
    work = (1.0, 1.0, 1.0)
    deep = np.full(64, 0.7)
    assert Recorder(SOFT).result(deep, (0.0, 0.0), work).outcome == Outcome.OK
    assert Recorder(SLIDING).result(deep, (0.0, 0.0), work).outcome == Outcome.FELL_THROUGH
