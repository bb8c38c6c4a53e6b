"""Motions to an accuracy, judged by the arbitrary-precision twin: errors, choice of method, refusals."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import pytest
from comparisons import cut_off, parameters_of, reference
from oracles import Motion, Oracle
from textbook import Parameters, digits

import vibropipe as vp
from vibropipe.march.grid import newmark_grid
from vibropipe.physics.effects import ALL_EFFECTS
from vibropipe.solve.accuracy.method_choice import NEWMARK_PRICES, choose, cost
from vibropipe.solve.accuracy.request import simulate_to_accuracy
from vibropipe.solve.run import MotionRequest, run_motion
from vibropipe.words.status import Status

IN_DOUBT = ("high_frequency", "fig7_conservative_graze")
ACCURACIES = (1e-2, 1e-3, 1e-4, 1e-6, 1e-8, 1e-10)


class Case(NamedTuple):
    p: Parameters
    tau_end: float
    x0: float
    v0: float
    accuracy: float


def random_case(seed: int) -> Case:
    """An exciter of any kind over a few periods: too short for chaos to eat the digits."""
    draw = np.random.default_rng([20, seed])
    nu, l = 10 ** draw.uniform(-0.8, 0.8), 10 ** draw.uniform(-1, 0.5)  # noqa: E741
    h = draw.choice([0.0, 10 ** draw.uniform(-2, 0.5), 2.0])
    restitution = [
        draw.choice([0.0, 1.0, draw.uniform(0.1, 0.95)], p=[0.1, 0.1, 0.8]) for _ in "12"
    ]
    if h > 0:
        # Pressed in and damped, a mass strikes an ideal support for ever: the twin would never end.
        restitution = [min(R, 0.95) for R in restitution]
    delta = l * draw.choice([0.0, draw.uniform(-0.9, 0.9), draw.uniform(-1.5, 1.5)])
    f = l * draw.choice([0.0, 10 ** draw.uniform(-0.5, 0.7)], p=[0.1, 0.9]) * max(1.0, nu)
    p = Parameters(nu=nu, f=f, h=float(h), l=l, delta=delta, R1=restitution[0], R2=restitution[1])
    x0 = p.lower + draw.uniform(0.01, 0.99) * (p.upper - p.lower)
    tau_end = float(draw.uniform(2, 6)) * 2 * math.pi / max(nu, 0.5)
    accuracy = float(draw.choice(ACCURACIES))
    return Case(p, tau_end, x0, l * draw.uniform(-2, 2), accuracy)


def truth(case: Case) -> Motion:
    return Oracle(case.p, digits(case.p, 40)).run(case.tau_end, case.x0, case.v0)


def ratios(case: Case, ds: Any, motion: Motion) -> list[float]:
    """True error over estimate, quantity by quantity; inf where contacts differ."""
    found = []

    def compare(got: float, want: Any, estimate: float) -> None:
        error = 0.0 if got == want else abs(float(got - want))
        found.append(error / estimate if estimate else math.inf * (error > 0) if error else 0.0)

    compare(float(ds.displacement_end), motion.displacement_end, float(ds.displacement_end_error))
    compare(float(ds.velocity_end), motion.velocity_end, float(ds.velocity_end_error))
    least = max(cut_off(case.p, motion), 2 * ds.accuracy_reached)
    known = [i for i in motion.impacts if abs(i.before) > least]
    seen = np.flatnonzero(np.abs(ds.impact_velocity.values) > least)
    if ds.impact_support.values[seen].tolist() != [i.support for i in known]:
        return [*found, math.inf]
    for place, impact in zip(seen, known, strict=True):
        one = ds.isel(impact=place)
        compare(float(one.impact_tau), impact.tau, float(one.impact_tau_error))
        compare(float(one.impact_velocity), impact.before, float(one.impact_velocity_error))
        compare(
            float(one.impact_velocity_after), impact.after, float(one.impact_velocity_after_error)
        )
    still = [k for k in range(ds.sizes["rest"]) if ds.rest_end[k] > ds.rest_start[k]]
    if len(still) != len(motion.rests):
        return [*found, math.inf]
    for place, rest in zip(still, motion.rests, strict=True):
        one = ds.isel(rest=place)
        compare(float(one.rest_start), rest.start, float(one.rest_start_error))
        if rest.end <= float(ds.tau[-1]):
            compare(float(one.rest_end), rest.end, float(one.rest_end_error))
    for place in range(0, ds.sizes["tau"], 7):
        one = ds.isel(tau=place)
        x, v = motion.state(motion.pieces[0][0] * 0 + float(one.tau))
        compare(float(one.displacement), x, float(one.displacement_error))
        compare(float(one.velocity), v, float(one.velocity_error))
    return found


def solve(case: Case) -> Any:
    return vp.simulate(
        vp.Exciter(**case.p._asdict()), case.tau_end, case.x0, case.v0, accuracy=case.accuracy,
        samples_per_period=9,
    )  # fmt: skip


# -- errors ------------------------------------------------------------------------------------


def check_errors(seeds: range) -> None:
    found = {}
    for seed in seeds:
        case = random_case(seed)
        found[seed] = max(ratios(case, solve(case), truth(case)))
    worst = max(found, key=lambda seed: found[seed])
    assert found[worst] <= 30, f"seed {worst}: error {found[worst]:.1f} times the estimate"
    beyond = [seed for seed, ratio in found.items() if ratio > 3]
    assert len(beyond) <= 0.01 * len(found), f"seeds {beyond}: error above 3 times the estimate"


def test_errors_hold_against_the_twin() -> None:
    check_errors(range(500, 512))


@pytest.mark.slow
def test_errors_hold_for_500_exciters() -> None:
    check_errors(range(500))


@pytest.mark.parametrize("name", sorted(reference("motions")))
def test_errors_hold_against_the_references(name: str) -> None:
    entry = reference("motions")[name]
    exciter = vp.Exciter(**parameters_of(entry)._asdict())
    tau_end, x0, v0 = (float(entry[key]) for key in ("tau_end", "x0", "v0"))
    ds = vp.simulate(exciter, tau_end, x0, v0, accuracy=1e-8, samples_per_period=0)
    for mine, theirs in (("displacement_end", "x_end"), ("velocity_end", "v_end")):
        error = abs(float(ds[mine]) - float(entry[theirs]))
        assert error <= 3 * float(ds[f"{mine}_error"])
        # Not a bound that says nothing: the digits are there, unless chaos or a touch is in doubt.
        assert float(ds[f"{mine}_error"]) <= 1e-10 or name in IN_DOUBT


def test_every_quantity_has_its_error() -> None:
    exciter = vp.Exciter(l=0.5, nu=0.3, f=1.5, h=0.2, R1=0.7, R2=0.7)
    for accuracy in (1e-2, 1e-9):
        ds = vp.simulate(exciter, 40.0, accuracy=accuracy, samples_per_period=16)
        told = [n for n in ds.data_vars if f"{n}_error" in ds]
        silent = {str(n) for n in ds.data_vars} - set(told) - {f"{n}_error" for n in told}
        supports = {"impact_support", "rest_support", "grazing_support"}
        assert silent == {*supports, "status"}
        for name in told:
            assert ds[f"{name}_error"].dims == ds[name].dims
            assert ds[f"{name}_error"].attrs["long_name"].startswith("error estimate")
            assert (ds[f"{name}_error"] >= 0).all()


def test_a_chaotic_motion_says_that_its_digits_are_lost() -> None:
    exciter = vp.Exciter(l=0.5, nu=200, f=4e4, h=0.2, R1=0.7, R2=0.7)
    ds = vp.simulate(exciter, 1.0, 0.0, 1.0, accuracy=1e-8, samples_per_period=0)
    assert int(ds.status) == Status.INACCURATE
    assert ds.accuracy_reached > 1e-8
    assert float(ds.velocity_end_error) > 1e-4
    assert "tau_end" in Status.INACCURATE.remedy


def test_a_touch_within_rounding_is_known_to_be_in_doubt() -> None:
    """Whether it strikes at all is not known, so neither is the velocity: sqrt(2 a depth) of it."""
    exciter = vp.Exciter(l=0.5, delta=0.01, R1=0.5)
    ds = vp.simulate(exciter, 25.0, 0.0, -0.51, accuracy=1e-4, samples_per_period=0)
    plain = vp.simulate(exciter, 1.0, 0.0, -0.51, accuracy=1e-4, samples_per_period=0)
    assert ds.sizes["grazing"] > 0
    assert float(ds.velocity_end_error) > 1e4 * float(plain.velocity_end_error)


def test_a_doubt_in_the_start_is_carried_on() -> None:
    exciter = vp.Exciter(l=5.0, h=0.1)
    task = MotionRequest(0.0, 3.0, 1.0, 0.0, 0, x_uncertainty=1e-6)
    ds = simulate_to_accuracy(exciter, task, 1e-3)
    # The free motion is linear: the doubt shrinks by the flow, the error is SAFETY times that.
    root = math.sqrt(1 - 0.0025)
    flow = math.exp(-0.15) * (math.cos(3 * root) + 0.05 / root * math.sin(3 * root))
    assert float(ds.displacement_end_error) == pytest.approx(2e-6 * abs(flow), rel=1e-6)


# -- choice ------------------------------------------------------------------------------------


def cheapest(case: Case) -> tuple[float, float]:
    """Cost of the cheapest march that is accurate enough by the exact motion's judgement, and of that."""
    exciter = vp.Exciter(**case.p._asdict())
    task = MotionRequest(0.0, case.tau_end, case.x0, case.v0, 0)
    exact = vp.simulate(exciter, case.tau_end, case.x0, case.v0, samples_per_period=0)
    least = full = choose(exciter, case.tau_end, case.x0, case.v0, 1e-13).nanoseconds
    x, v = float(exact.displacement_end), float(exact.velocity_end)
    fast = np.abs(exact.impact_velocity.values) > 2 * case.accuracy
    for steps in np.unique(np.geomspace(1, 2000, 120).astype(int)):
        run = run_motion(exciter, task, newmark_grid(ALL_EFFECTS, exciter.parameters(), int(steps)))
        spent, struck = cost(NEWMARK_PRICES, int(steps), run), run.contacts
        same = np.array_equal(struck["impact_support"], exact.impact_support.values)
        if spent >= least or not same or run.status != Status.OK:
            continue
        errors = [abs(run.end[0] - x), abs(run.end[1] - v)]
        for name in ("impact_tau", "impact_velocity"):
            errors += np.abs(struck[name] - exact[name].values)[fast].tolist()
        least = spent if max(errors) <= case.accuracy * min(1.0, case.p.l) / 2 else least
    return least, full


@pytest.mark.parametrize("seed", range(600, 624))
def test_the_choice_is_within_twice_the_cheapest(seed: int) -> None:
    case = random_case(seed)
    exciter = vp.Exciter(**case.p._asdict())
    choice = choose(exciter, case.tau_end, case.x0, case.v0, case.accuracy)
    least, full = cheapest(case)
    assert choice.nanoseconds <= 2 * least
    assert choice.nanoseconds <= full


def test_newmark_is_chosen_where_it_is_cheaper_and_exact_where_digits_are_asked() -> None:
    # Strong damping makes the exact method's steps short; a slow force needs none of them. The mass
    # keeps off the supports, but too near for the certificate: the exact motion is marched as well.
    exciter = vp.Exciter(l=0.5, nu=0.1, f=0.5, h=10.0)
    coarse, fine = choose(exciter, 500.0, accuracy=1e-2), choose(exciter, 500.0, accuracy=1e-10)
    assert (coarse.method, fine.method) == ("newmark", "exact")
    assert coarse.nanoseconds < fine.nanoseconds / 2
    ds = vp.simulate(exciter, 500.0, accuracy=1e-2, samples_per_period=0)
    assert (ds.method, ds.steps_per_period) == ("newmark", coarse.steps_per_period)
    assert ds.accuracy_asked == 1e-2
    assert ds.accuracy_reached <= 1e-2


def test_the_same_exciter_is_given_the_same_method() -> None:
    case = random_case(3)
    choices = {choose(vp.Exciter(**case.p._asdict()), case.tau_end, accuracy=1e-3) for _ in "123"}
    assert len(choices) == 1


# -- refusals ----------------------------------------------------------------------------------


@pytest.mark.parametrize("bad", [0, 1, -1e-8, math.nan, "1e-8", True, [1e-8], None])
def test_an_accuracy_that_is_none_is_refused(bad: Any) -> None:
    with pytest.raises(vp.ParameterError, match="accuracy"):
        choose(vp.Exciter(l=1), 10.0, accuracy=bad)


def test_an_accuracy_stands_alone() -> None:
    for other in ({"method": "newmark"}, {"steps_per_period": 100}):
        ((name, value),) = other.items()
        told = f"accuracy: must not be combined with method or .*, got .*{name} = {value!r}"
        with pytest.raises(vp.ParameterError, match=told):
            vp.simulate(vp.Exciter(l=1), 10.0, accuracy=1e-8, **other)
