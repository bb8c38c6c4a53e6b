"""Motions to an accuracy against the arbitrary-precision oracle: error estimates, choice of method, bad arguments."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import pytest
from comparisons import cut_off, parameters_of, reference
from oracles import Motion, Oracle
from sampling import sampled
from textbook import Parameters, digits

import vibropipe as vp
from vibropipe.march.grid import newmark_grid
from vibropipe.physics.effects import ALL_EFFECTS
from vibropipe.solve.accuracy.method_choice import (
    NEWMARK_PRICES,
    Choice,
    check_accuracy,
    choose_method,
    cost,
)
from vibropipe.solve.accuracy.request import simulate_to_accuracy
from vibropipe.solve.motion.run import MotionRequest, run_motion
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
    """Draw an exciter of any kind over a few periods, too short for chaos to consume all digits."""
    draw = np.random.default_rng([20, seed])
    nu, l = 10 ** draw.uniform(-0.8, 0.8), 10 ** draw.uniform(-1, 0.5)  # noqa: E741
    h = draw.choice([0.0, 10 ** draw.uniform(-2, 0.5), 2.0])
    restitution = [
        draw.choice([0.0, 1.0, draw.uniform(0.1, 0.95)], p=[0.1, 0.1, 0.8]) for _ in "12"
    ]
    if h > 0:
        # A damped mass pressed against an ideal support strikes it for ever: the oracle would not end.
        restitution = [min(R, 0.95) for R in restitution]
    delta = l * draw.choice([0.0, draw.uniform(-0.9, 0.9), draw.uniform(-1.5, 1.5)])
    f = l * draw.choice([0.0, 10 ** draw.uniform(-0.5, 0.7)], p=[0.1, 0.9]) * max(1.0, nu)
    p = Parameters(nu=nu, f=f, h=float(h), l=l, delta=delta, R1=restitution[0], R2=restitution[1])
    x0 = p.lower + draw.uniform(0.01, 0.99) * (p.upper - p.lower)
    tau_end = float(draw.uniform(2, 6)) * 2 * math.pi / max(nu, 0.5)
    accuracy = float(draw.choice(ACCURACIES))
    return Case(p, tau_end, x0, l * draw.uniform(-2, 2), accuracy)


def ratios(case: Case, ds: Any, motion: Motion) -> list[float]:
    """Return true error over estimate, quantity by quantity; inf if contacts differ."""
    ratio_list = []

    def compare(got: float, want: Any, estimate: float) -> None:
        error = 0.0 if got == want else abs(float(got - want))
        ratio_list.append(
            error / estimate if estimate else math.inf * (error > 0) if error else 0.0
        )

    compare(float(ds.displacement_end), motion.displacement_end, float(ds.displacement_end_error))
    compare(float(ds.velocity_end), motion.velocity_end, float(ds.velocity_end_error))
    min_velocity = max(cut_off(case.p, motion), 2 * ds.accuracy_reached)
    expected = [i for i in motion.impacts if abs(i.before) > min_velocity]
    fast_indices = np.flatnonzero(np.abs(ds.impact_velocity.values) > min_velocity)
    if ds.impact_support.values[fast_indices].tolist() != [i.support for i in expected]:
        return [*ratio_list, math.inf]
    for index, impact in zip(fast_indices, expected, strict=True):
        one = ds.isel(impact=index)
        compare(float(one.impact_tau), impact.tau, float(one.impact_tau_error))
        compare(float(one.impact_velocity), impact.before, float(one.impact_velocity_error))
        compare(
            float(one.impact_velocity_after), impact.after, float(one.impact_velocity_after_error)
        )
    rest_indices = [k for k in range(ds.sizes["rest"]) if ds.rest_end[k] > ds.rest_start[k]]
    if len(rest_indices) != len(motion.rests):
        return [*ratio_list, math.inf]
    for index, rest in zip(rest_indices, motion.rests, strict=True):
        one = ds.isel(rest=index)
        compare(float(one.rest_start), rest.start, float(one.rest_start_error))
        if rest.end <= float(ds.tau[-1]):
            compare(float(one.rest_end), rest.end, float(one.rest_end_error))
    for index in range(0, ds.sizes["tau"], 7):
        one = ds.isel(tau=index)
        x, v = motion.state(motion.pieces[0][0] * 0 + float(one.tau))
        compare(float(one.displacement), x, float(one.displacement_error))
        compare(float(one.velocity), v, float(one.velocity_error))
    return ratio_list


def solve(case: Case) -> Any:
    return vp.simulate(
        vp.Exciter(**case.p._asdict()), case.tau_end, case.x0, case.v0, accuracy=case.accuracy,
        samples_per_period=9,
    )  # fmt: skip


# -- errors ------------------------------------------------------------------------------------


@pytest.mark.parametrize("seeds", sampled([range(500, 512), range(500)]))
def test_errors_hold_against_the_twin(seeds: range) -> None:
    worst_ratios = {}
    for seed in seeds:
        case = random_case(seed)
        true = Oracle(case.p, digits(case.p, 40)).run(case.tau_end, case.x0, case.v0)
        worst_ratios[seed] = max(ratios(case, solve(case), true))
    worst = max(worst_ratios, key=lambda seed: worst_ratios[seed])
    assert worst_ratios[worst] <= 30, (
        f"seed {worst}: error {worst_ratios[worst]:.1f} times the estimate"
    )
    beyond = [seed for seed, ratio in worst_ratios.items() if ratio > 3]
    assert len(beyond) <= 0.01 * len(worst_ratios), (
        f"seeds {beyond}: error above 3 times the estimate"
    )


@pytest.mark.parametrize("name", sorted(reference("motions")))
def test_errors_hold_against_the_references(name: str) -> None:
    entry = reference("motions")[name]
    exciter = vp.Exciter(**parameters_of(entry)._asdict())
    tau_end, x0, v0 = (float(entry[key]) for key in ("tau_end", "x0", "v0"))
    ds = vp.simulate(exciter, tau_end, x0, v0, accuracy=1e-8, samples_per_period=0)
    for mine, theirs in (("displacement_end", "x_end"), ("velocity_end", "v_end")):
        error = abs(float(ds[mine]) - float(entry[theirs]))
        assert error <= 3 * float(ds[f"{mine}_error"])
        # The estimate is small as well, unless chaos or a contact within rounding makes the motion uncertain.
        assert float(ds[f"{mine}_error"]) <= 1e-10 or name in IN_DOUBT


def test_every_quantity_has_its_error() -> None:
    exciter = vp.Exciter(l=0.5, nu=0.3, f=1.5, h=0.2, R1=0.7, R2=0.7)
    for accuracy in (1e-2, 1e-9):
        ds = vp.simulate(exciter, 40.0, accuracy=accuracy, samples_per_period=16)
        with_error = [n for n in ds.data_vars if f"{n}_error" in ds]
        without_error = (
            {str(n) for n in ds.data_vars} - set(with_error) - {f"{n}_error" for n in with_error}
        )
        supports = {"impact_support", "rest_support", "grazing_support"}
        assert without_error == {*supports, "status"}
        for name in with_error:
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
    """Impact or miss is undecided, so the velocity is uncertain by sqrt(2 a depth)."""
    exciter = vp.Exciter(l=0.5, delta=0.01, R1=0.5)
    ds = vp.simulate(exciter, 25.0, 0.0, -0.51, accuracy=1e-4, samples_per_period=0)
    plain = vp.simulate(exciter, 1.0, 0.0, -0.51, accuracy=1e-4, samples_per_period=0)
    assert ds.sizes["grazing"] > 0
    assert float(ds.velocity_end_error) > 1e4 * float(plain.velocity_end_error)


def test_a_doubt_in_the_start_is_carried_on() -> None:
    exciter = vp.Exciter(l=5.0, h=0.1)
    request = MotionRequest(0.0, 3.0, 1.0, 0.0, 0, x_uncertainty=1e-6)
    ds = simulate_to_accuracy(exciter, request, 1e-3)
    # The free motion is linear: the uncertainty decays with the flow, and the error is SAFETY times it.
    root = math.sqrt(1 - 0.0025)
    flow = math.exp(-0.15) * (math.cos(3 * root) + 0.05 / root * math.sin(3 * root))
    assert float(ds.displacement_end_error) == pytest.approx(2e-6 * abs(flow), rel=1e-6)


# -- choice ------------------------------------------------------------------------------------


def choose(
    exciter: vp.Exciter,
    tau_end: float,
    x0: float | None = None,
    v0: float = 0.0,
    accuracy: float = 1e-8,
) -> Choice:
    """Return the method that `simulate` would take."""
    request = MotionRequest(0.0, tau_end, *exciter.check_start(x0, v0), samples_per_period=0)
    return choose_method(exciter, request, check_accuracy(accuracy))[0]


def cheapest(case: Case) -> tuple[float, float]:
    """Return the cost of the cheapest march that agrees with the exact motion, and that of the exact motion."""
    exciter = vp.Exciter(**case.p._asdict())
    request = MotionRequest(0.0, case.tau_end, case.x0, case.v0, 0)
    exact = vp.simulate(exciter, case.tau_end, case.x0, case.v0, samples_per_period=0)
    least = full = choose(exciter, case.tau_end, case.x0, case.v0, 1e-13).nanoseconds
    x, v = float(exact.displacement_end), float(exact.velocity_end)
    fast = np.abs(exact.impact_velocity.values) > 2 * case.accuracy
    for steps in np.unique(np.geomspace(1, 2000, 120).astype(int)):
        run = run_motion(
            exciter, request, newmark_grid(ALL_EFFECTS, exciter.parameters(), int(steps))
        )
        trial_cost, contacts = cost(NEWMARK_PRICES, int(steps), run), run.contacts
        has_same_impacts = np.array_equal(contacts["impact_support"], exact.impact_support.values)
        if trial_cost >= least or not has_same_impacts or run.status != Status.OK:
            continue
        errors = [abs(run.end[0] - x), abs(run.end[1] - v)]
        for name in ("impact_tau", "impact_velocity"):
            errors += np.abs(contacts[name] - exact[name].values)[fast].tolist()
        least = trial_cost if max(errors) <= case.accuracy * min(1.0, case.p.l) / 2 else least
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
    # Strong damping shortens the steps of the exact method, which a slow force does not need. The mass
    # stays off the supports, but too near for the certificate, so that the exact motion is marched.
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
