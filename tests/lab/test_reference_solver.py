"""The judge of the race is judged itself: by the 20-digit references and by the other twin."""

from __future__ import annotations

from decimal import Context, Decimal, localcontext

import numpy as np
import pytest
from comparisons import reference
from oracles import Oracle as OtherTwin
from textbook import Parameters, digits

from vibropipe.lab.reference_solver import PI, ReferenceSolver, period_of
from vibropipe.physics.exciter import Exciter

TWENTY_DIGITS = Decimal("1e-20")
# Where the mass touches a support with zero velocity, half of the forty digits are left.
AT_A_TOUCH = {"fig7_conservative_graze": Decimal("1e-19")}


def twin_of(entry: dict[str, str]) -> ReferenceSolver:
    """The twin with the decimal parameters of a reference, not their nearest doubles."""
    p = {name: Decimal(entry[name]) for name in ("nu", "f", "h", "l", "delta", "R1", "R2")}
    twin = ReferenceSolver(Exciter(**{name: float(value) for name, value in p.items()}))
    twin.nu, twin.f, twin.h = p["nu"], p["f"], p["h"]
    twin.bound = {1: p["l"] + p["delta"], 2: p["delta"] - p["l"]}
    twin.restitution = {1: p["R1"], 2: p["R2"]}
    return twin


@pytest.mark.parametrize("name", sorted(reference("motions")))
def test_references_are_met_to_twenty_digits(name: str) -> None:
    entry = reference("motions")[name]
    start = (Decimal(entry["x0"]), Decimal(entry["v0"]))
    truth = twin_of(entry).run(*start, [Decimal(entry["tau_end"])])  # type: ignore[arg-type]
    allowed = AT_A_TOUCH.get(name, TWENTY_DIGITS)
    size = max(Decimal(1), abs(Decimal(entry["v_end"])))
    for mine, theirs in zip(truth.states[0], (entry["x_end"], entry["v_end"]), strict=True):
        assert abs(mine - Decimal(theirs)) <= allowed * size
    fast = [impact for impact in truth.impacts if abs(impact[2]) > Decimal("1e-6")]
    known = [i for i in entry["impacts"] if abs(Decimal(i["velocity_before"])) > Decimal("1e-6")]
    assert [impact[1] for impact in fast] == [int(i["support"]) for i in known]
    for impact, theirs in zip(fast, known, strict=True):
        assert abs(impact[0] - Decimal(theirs["tau"])) <= allowed
    assert len(truth.rests) == len(entry["rests"])


def test_states_on_the_way_agree_with_the_other_twin() -> None:
    exciter = Exciter(l=0.5, nu=0.3, f=1.5, h=0.2, R1=0.7, R2=0.7)
    p = Parameters(nu=0.3, f=1.5, h=0.2, l=0.5, R1=0.7, R2=0.7)
    times = [Decimal(k) for k in range(0, 40, 3)]
    truth = ReferenceSolver(exciter).run(0.0, 0.0, times)
    motion = OtherTwin(p, digits(p, 40)).run(40.0)
    for at, (x, v) in zip(times, truth.states, strict=True):
        other = motion.state(motion.pieces[0][0] * 0 + int(at))
        assert abs(float(x) - float(other[0])) <= 1e-16
        assert abs(float(v) - float(other[1])) <= 1e-15


def test_rounds_that_repeat_are_those_that_are_marched(monkeypatch: pytest.MonkeyPatch) -> None:
    exciter = Exciter(l=0.5, delta=0.01)
    times = [period_of(1.0) * 20, period_of(1.0) * 30]
    quick = ReferenceSolver(exciter).run(0.0, -0.8, times)
    monkeypatch.setattr(ReferenceSolver, "repeat", lambda self, on: None)
    slow = ReferenceSolver(exciter).run(0.0, -0.8, times)
    assert len(quick.impacts) == len(slow.impacts) > 50
    for one, two in zip(quick.impacts, slow.impacts, strict=True):
        assert abs(one[0] - two[0]) <= Decimal("1e-34")
    for one, two in zip(quick.states, slow.states, strict=True):
        assert max(abs(a - b) for a, b in zip(one, two, strict=True)) <= Decimal("1e-34")


def test_the_period_has_more_digits_than_a_double() -> None:
    with localcontext(Context(prec=60)):
        assert abs(period_of(0.5) - 4 * PI) <= Decimal("1e-36")
    assert float(PI) == np.pi
