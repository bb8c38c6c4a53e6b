"""The 40-digit reference solver against the 20-digit reference data and the independent oracle of the tests."""

from decimal import Context, Decimal, localcontext

import numpy as np
import pytest
from comparisons import reference
from oracles import Oracle
from textbook import Parameters, digits

from vibropipe.lab.power_series import PI, period_of
from vibropipe.lab.reference_solver import ReferenceSolver
from vibropipe.physics.exciter import Exciter

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
