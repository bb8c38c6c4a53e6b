"""The 40-digit reference solver, and every method against it on motions by pieces."""

import importlib.util
import math
from decimal import Context, Decimal, localcontext

import numpy as np
import pytest
from comparisons import reference
from oracles import Oracle
from textbook import Parameters, digits

import vibropipe as vp
from vibropipe.lab.motion_reference import MotionReference, reference_motion
from vibropipe.lab.peers.solve_ivp import Recorder
from vibropipe.lab.power_series import PI, period_of
from vibropipe.lab.reference_solver import ReferenceSolver
from vibropipe.lab.work_precision import build_method
from vibropipe.lab.work_precision_methods import BenchmarkMotion, newmark_crude
from vibropipe.physics.exciter import Exciter
from vibropipe.words.measurements import Outcome

TWENTY_DIGITS = Decimal("1e-20")
# At a grazing contact, rounding leaves half of the forty digits.
GRAZING_TOLERANCE = {"fig7_conservative_graze": Decimal("1e-19")}


def reference_solver_of(entry: dict[str, str]) -> ReferenceSolver:
    """Return the solver with the decimal parameters of a reference, not their nearest doubles."""
    p = {name: Decimal(entry[name]) for name in ("nu", "f", "h", "l", "delta", "R1", "R2")}
    solver = ReferenceSolver(Exciter(**{name: float(value) for name, value in p.items()}))
    solver.nu, solver.f, solver.h = p["nu"], p["f"], p["h"]
    solver.bound = {1: p["l"] + p["delta"], 2: p["delta"] - p["l"]}
    solver.restitution = {1: p["R1"], 2: p["R2"]}
    return solver


@pytest.mark.parametrize("name", sorted(reference("motions")))
def test_references_are_met_to_twenty_digits(name: str) -> None:
    entry = reference("motions")[name]
    start = (Decimal(entry["x0"]), Decimal(entry["v0"]))
    motion = reference_solver_of(entry).run(*start, [Decimal(entry["tau_end"])])  # type: ignore[arg-type]
    tolerance = GRAZING_TOLERANCE.get(name, TWENTY_DIGITS)
    size = max(Decimal(1), abs(Decimal(entry["v_end"])))
    for computed, expected in zip(motion.states[0], (entry["x_end"], entry["v_end"]), strict=True):
        assert abs(computed - Decimal(expected)) <= tolerance * size
    fast = [impact for impact in motion.impacts if abs(impact[2]) > Decimal("1e-6")]
    expected_fast = [
        i for i in entry["impacts"] if abs(Decimal(i["velocity_before"])) > Decimal("1e-6")
    ]
    assert [impact[1] for impact in fast] == [int(i["support"]) for i in expected_fast]
    for impact, expected in zip(fast, expected_fast, strict=True):
        assert abs(impact[0] - Decimal(expected["tau"])) <= tolerance
    rests = [event for event in motion.events if event[1] == "rest"]
    assert len(rests) == len(entry["rests"])


def test_intermediate_states_agree_with_the_oracle() -> None:
    exciter = Exciter(l=0.5, nu=0.3, f=1.5, h=0.2, R1=0.7, R2=0.7)
    p = Parameters(nu=0.3, f=1.5, h=0.2, l=0.5, R1=0.7, R2=0.7)
    times = [Decimal(k) for k in range(0, 40, 3)]
    computed = ReferenceSolver(exciter).run(0.0, 0.0, times)
    motion = Oracle(p, digits(p, 40)).run(40.0)
    for time, (x, v) in zip(times, computed.states, strict=True):
        expected = motion.state(motion.pieces[0][0] * 0 + int(time))
        assert abs(float(x) - float(expected[0])) <= 1e-16
        assert abs(float(v) - float(expected[1])) <= 1e-15


def test_copied_cycles_equal_marched_ones(monkeypatch: pytest.MonkeyPatch) -> None:
    exciter = Exciter(l=0.5, delta=0.01)
    times = [period_of(1.0) * 20, period_of(1.0) * 30]
    copied = ReferenceSolver(exciter).run(0.0, -0.8, times)
    monkeypatch.setattr(ReferenceSolver, "repeat_cycle", lambda self, support: None)
    marched = ReferenceSolver(exciter).run(0.0, -0.8, times)
    assert len(copied.impacts) == len(marched.impacts) > 50
    for one, two in zip(copied.impacts, marched.impacts, strict=True):
        assert abs(one[0] - two[0]) <= Decimal("1e-34")
    for one, two in zip(copied.states, marched.states, strict=True):
        assert max(abs(a - b) for a, b in zip(one, two, strict=True)) <= Decimal("1e-34")


def test_the_period_has_more_digits_than_a_double() -> None:
    with localcontext(Context(prec=60)):
        assert abs(period_of(0.5) - 4 * PI) <= Decimal("1e-36")
    assert float(PI) == np.pi


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
def reference_of():
    references = {motion: MotionReference(motion) for motion in (SOFT, SLIDING, BOTH)}
    return references.__getitem__


def errors_of(method, value, motion, reference_of):
    outcome, errors = reference_of(motion).errors(build_method(method, value, motion).show())
    assert outcome == Outcome.OK
    return np.array(errors)


@MOTIONS
def test_the_exact_method_is_at_rounding(motion, reference_of):
    assert errors_of("exact", math.nan, motion, reference_of).max() < 1e-13


@MOTIONS
def test_newmark_converges_with_order_2(motion, reference_of):
    coarse, fine = (errors_of("newmark", steps, motion, reference_of) for steps in (2048, 16384))
    assert np.log2(coarse / fine).max() / 3 == pytest.approx(2, abs=0.25)
    assert fine.max() < 1e-4


@MOTIONS
def test_crude_converges_with_order_1(motion, reference_of):
    coarse, fine = (
        errors_of("crude", steps, motion, reference_of).max() for steps in (2**12, 2**17)
    )
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
def test_an_integrator_of_scipy_stops_at_each_end_of_a_piece(method, motion, reference_of):
    coarse, fine = (errors_of(method, value, motion, reference_of).max() for value in (1e-5, 1e-8))
    assert coarse < 1e-3
    assert fine < 2e-6


@MOTIONS
@pytest.mark.skipif(importlib.util.find_spec("heyoka") is None, reason="heyoka is not installed")
def test_heyoka_changes_its_equation_at_each_end_of_a_piece(motion, reference_of):
    assert errors_of("heyoka", 1e-15, motion, reference_of).max() < 1e-12


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
