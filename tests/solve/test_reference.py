"""Agreement with 20-digit references, and with the oracle over random exciters."""

from __future__ import annotations

import math
import random
from typing import Any, NamedTuple

import numpy as np
import pytest
from comparisons import (
    backbone_velocity,
    disagreements,
    energy,
    impacts_of,
    judge,
    parameters_of,
    reference,
    rests_of,
)
from oracles import Oracle
from sampling import sampled
from textbook import Parameters, digits

import vibropipe as vp

MOTIONS = reference("motions")
CHAOTIC = "high_frequency"  # one ulp of R grows to 1e-2 within its 97 impacts


def simulate(p: Parameters, entry: dict[str, Any], **settings: Any) -> Any:
    start = {name: float(entry[name]) for name in ("tau_end", "x0", "v0")}
    return vp.simulate(vp.Exciter(**p._asdict()), **start, **settings)


def fast_impacts(impacts: list[Any], least: float = 1e-6) -> list[Any]:
    """Return the impacts above the speed below which the tail of a chatter may be summed."""
    return [impact for impact in impacts if abs(float(impact[2])) > least]


def expected_impacts(entry: dict[str, Any]) -> list[tuple[float, int, float, float]]:
    return [
        (float(i["tau"]), i["support"], float(i["velocity_before"]), float(i["velocity_after"]))
        for i in entry["impacts"]
    ]


# -- the oracle itself -------------------------------------------------------------------------


@pytest.mark.parametrize("name", MOTIONS)
def test_the_twin_gives_the_reference_motion(name: str) -> None:
    """To all digits of the reference, with the parameters as decimals."""
    entry = MOTIONS[name]
    c = digits(parameters_of(entry))
    p = Parameters(**{key: c.mpf(entry[key]) for key in Parameters._fields})
    motion = Oracle(p, c).run(*(c.mpf(entry[key]) for key in ("tau_end", "x0", "v0")))

    def same(got: Any, want: str) -> bool:
        return bool(abs(got - c.mpf(want)) < 1e-17 * max(1, abs(got)))

    assert same(motion.displacement_end, entry["x_end"])
    assert same(motion.velocity_end, entry["v_end"])
    expected = [i for i in entry["impacts"] if abs(float(i["velocity_before"])) > 1e-10]
    computed = [i for i in motion.impacts if abs(i.before) > 1e-10]
    assert [i.support for i in computed] == [i["support"] for i in expected]
    for got, want in zip(computed, expected, strict=True):
        assert same(got.tau, want["tau"])
        assert same(got.before, want["velocity_before"])
        assert same(got.after, want["velocity_after"])
    assert [rest.support for rest in motion.rests] == [r["support"] for r in entry["rests"]]
    for rest, expected_rest in zip(motion.rests, entry["rests"], strict=True):
        # In the reference a chatter ends at its last impact, of velocity 1e-16.
        assert abs(rest.start - c.mpf(expected_rest["start"])) < 1e-15
        assert same(min(rest.end, c.mpf(entry["tau_end"])), expected_rest["end"])


# -- motions -----------------------------------------------------------------------------------


@pytest.mark.parametrize("name", [name for name in MOTIONS if name != CHAOTIC])
def test_exact_motion(name: str) -> None:
    entry = MOTIONS[name]
    ds = simulate(parameters_of(entry), entry)
    tau_end = float(entry["tau_end"])
    assert float(ds.displacement_end) == pytest.approx(float(entry["x_end"]), abs=1e-10)
    assert float(ds.velocity_end) == pytest.approx(float(entry["v_end"]), abs=1e-10)
    computed, expected = fast_impacts(impacts_of(ds)), fast_impacts(expected_impacts(entry))
    assert [i[1] for i in computed] == [i[1] for i in expected]
    np.testing.assert_allclose(computed, expected, rtol=0, atol=1e-10)
    rests = [(start, min(end, tau_end), support) for start, end, support in rests_of(ds)]
    expected_rests = [(float(r["start"]), float(r["end"]), r["support"]) for r in entry["rests"]]
    np.testing.assert_allclose(rests, expected_rests, rtol=0, atol=1e-10)


def test_exact_motion_as_far_as_one_ulp_allows() -> None:
    """The chaotic motion: 1e-10 plus the growth of the rounding of the parameters."""
    entry = MOTIONS[CHAOTIC]
    p = parameters_of(entry)
    judged = judge(p, float(entry["tau_end"]), float(entry["x0"]), float(entry["v0"]))
    computed, expected = impacts_of(simulate(p, entry)), expected_impacts(entry)
    assert len(computed) == len(expected)
    n_accurate = 0
    for k, (got, want) in enumerate(zip(computed, expected, strict=True)):
        assert got[1] == want[1]
        assert abs(got[0] - want[0]) <= 1e-10 + 100 * judged.wobble_tau[k]
        assert abs(got[2] - want[2]) <= 1e-10 + 100 * judged.wobble_velocity[k]
        n_accurate += 100 * judged.wobble_velocity[k] < 1e-10
    assert n_accurate >= 5


@pytest.mark.parametrize("name", ["fig9_offset", "overdamped", "plastic_R0", "resonance_undamped"])
def test_samples_lie_on_the_motion(name: str) -> None:
    entry = MOTIONS[name]
    p = parameters_of(entry)
    ds = simulate(p, entry, samples_per_period=16)
    motion = Oracle(p).run(float(entry["tau_end"]), float(entry["x0"]), float(entry["v0"]))
    impacts = [float(i.tau) for i in motion.impacts]
    for tau, x, v, force in zip(
        *(ds[key].values for key in ("tau", "displacement", "velocity", "force")), strict=True
    ):
        want_x, want_v = motion.state(tau)
        assert x == pytest.approx(float(want_x), abs=1e-10)
        if all(abs(tau - instant) > 1e-10 for instant in impacts):
            assert v == pytest.approx(float(want_v), abs=1e-10)
        assert force == pytest.approx(p.f * math.sin(p.nu * tau), abs=1e-13 * abs(p.f))


def test_touch_with_zero_velocity_is_named_and_is_no_impact() -> None:
    """Figure 7: 0.51 = l + delta, so support 1 is reached with zero velocity."""
    entry = MOTIONS["fig7_conservative_graze"]
    ds = simulate(parameters_of(entry), entry)
    assert set(ds.impact_support.values) == {2}
    assert ds.grazing_support.values.tolist() == [1] * 4
    struck = ds.impact_tau.values
    np.testing.assert_allclose(
        ds.grazing_tau.values, (struck[1:] + struck[:-1]) / 2, rtol=0, atol=1e-9
    )


# -- newmark -----------------------------------------------------------------------------------

SMOOTH = ["linear_no_impact"]
STRIKING = [
    "fig4_conservative_symmetric",
    "fig6_symmetric",
    "fig11_both",
    "resonance_undamped",
    "plastic_R0",
    "one_sided_at_equilibrium",
    "preloaded_stop",
    "critical",
]


@pytest.mark.parametrize("name", SMOOTH + STRIKING)
def test_newmark_is_of_second_order(name: str) -> None:
    """Slope of the error of the end state and of all fast impacts over the step."""
    entry = MOTIONS[name]
    p = parameters_of(entry)
    expected = fast_impacts(expected_impacts(entry), 1e-2)
    counts = np.unique(np.geomspace(300, 6000, 14).astype(int))
    errors = []
    for count in counts:
        ds = simulate(p, entry, method="newmark", steps_per_period=int(count), samples_per_period=0)
        errors_at_count = [float(ds.displacement_end) - float(entry["x_end"])]
        errors_at_count.append(float(ds.velocity_end) - float(entry["v_end"]))
        computed = fast_impacts(impacts_of(ds), 1e-2)
        assert [i[1] for i in computed] == [i[1] for i in expected]
        errors_at_count.extend(
            (np.array(computed) - np.array(expected)).ravel() if expected else []
        )
        errors.append(np.linalg.norm(errors_at_count))
    slope = -np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert 1.9 <= slope <= 2.1


# -- equation (10) and energy ------------------------------------------------------------------


@pytest.mark.parametrize("delta_over_l", [0.0, 0.1, 0.2, 0.3])
@pytest.mark.parametrize("speed", [0.02, 0.3, 1.0, 4.0, 50.0])
def test_equation_10_holds_for_simulated_motions(delta_over_l: float, speed: float) -> None:
    exciter = vp.Exciter(l=0.5, delta=0.5 * delta_over_l)
    ds = vp.simulate(exciter, tau_end=40.0, x0=exciter.l + exciter.delta, v0=-speed)
    on_1 = ds.impact_support.values == 1
    assert 1 <= on_1.sum() < on_1.size  # both are struck
    taus = np.concatenate([[0.0], ds.impact_tau.values[on_1]])
    for tau_bar, velocity in zip(np.diff(taus), ds.impact_velocity.values[on_1], strict=True):
        assert velocity / 0.5 == pytest.approx(
            backbone_velocity(delta_over_l, tau_bar), rel=1e-10, abs=1e-10
        )


def test_backbone_is_equation_10_where_both_supports_are_struck() -> None:
    delta_over_l = np.array([0.0, 0.1, 0.2, 0.3])
    tau_bar = np.linspace(0.1, 6.2, 62)
    ds = vp.backbone(delta_over_l, tau_bar)
    np.testing.assert_allclose(ds.omega_bar.values, 2 * math.pi / tau_bar, rtol=1e-14)
    for ratio in delta_over_l:
        for tau in tau_bar:
            got = float(ds.velocity_over_l.sel(delta_over_l=ratio, tau_bar=tau))
            want = backbone_velocity(ratio, tau)
            if want > 0:
                assert got == pytest.approx(want, rel=1e-12)
            else:
                assert math.isnan(got)


@pytest.mark.parametrize("name", ["fig4_conservative_symmetric", "fig7_conservative_graze"])
def test_a_conservative_motion_keeps_its_energy(name: str) -> None:
    ds = simulate(parameters_of(MOTIONS[name]), MOTIONS[name])
    now = energy(ds.displacement.values, ds.velocity.values)
    np.testing.assert_allclose(now, 0.51**2 / 2, rtol=0, atol=1e-13)


# -- mirrors -----------------------------------------------------------------------------------


@pytest.mark.parametrize("settings", [{}, {"method": "newmark", "steps_per_period": 97}])
@pytest.mark.parametrize("name", MOTIONS)
def test_mirrored_exciters_give_mirrored_motions_to_the_last_bit(
    name: str, settings: dict[str, Any]
) -> None:
    entry = MOTIONS[name]
    exciter = vp.Exciter(**parameters_of(entry)._asdict())
    tau_end, x0, v0 = (float(entry[key]) for key in ("tau_end", "x0", "v0"))
    one = vp.simulate(exciter, tau_end=tau_end, x0=x0, v0=v0, **settings)
    two = vp.simulate(exciter.mirrored(), tau_end=tau_end, x0=-x0, v0=-v0, **settings)
    for key in ("displacement", "velocity", "force", "impact_velocity", "impact_velocity_after"):
        np.testing.assert_array_equal(one[key].values, -two[key].values, err_msg=key)
    for key in ("tau", "impact_tau", "rest_start", "rest_end", "grazing_tau"):
        np.testing.assert_array_equal(one[key].values, two[key].values, err_msg=key)
    for key in ("impact_support", "rest_support", "grazing_support"):
        np.testing.assert_array_equal(one[key].values, 3 - two[key].values, err_msg=key)
    assert float(one.displacement_end) == -float(two.displacement_end)
    assert float(one.velocity_end) == -float(two.velocity_end)


class Case(NamedTuple):
    p: Parameters
    tau_end: float
    x0: float
    v0: float


def log_uniform(rng: random.Random, low: float, high: float) -> float:
    return float(10 ** rng.uniform(low, high))


def random_exciter(rng: random.Random) -> Parameters:
    def restitution() -> float:
        return rng.choice([0.0, 1.0, rng.random(), rng.random(), 1 - log_uniform(rng, -1.3, 0)])

    length = log_uniform(rng, -1, 1)
    p = Parameters(
        nu=rng.choice([1.0, *(log_uniform(rng, -1.5, 1.5) for _ in range(5))]),
        f=rng.choice([0.0, *(rng.choice([-1, 1]) * log_uniform(rng, -2, 1.5) for _ in range(8))]),
        h=rng.choice([0.0, 2.0, *(log_uniform(rng, -3, 1.5) for _ in range(4))]),
        l=length,
        delta=rng.choice([0.0, length, -length, *(length * rng.uniform(-1.6, 1.6) for _ in "12")]),
        R1=restitution(),
        R2=restitution(),
    )
    # Pressed by spring or force, a damped mass strikes an ideal support at an ever higher rate.
    if p.h > 0 and p.R1 == 1 and p.upper <= abs(p.f):
        p = p._replace(R1=0.9)
    if p.h > 0 and p.R2 == 1 and -p.lower <= abs(p.f):
        p = p._replace(R2=0.9)
    return p


def random_case(seed: int) -> Case:
    """Draw an exciter, a start, and a horizon of about a hundred impacts."""
    rng = random.Random(seed)
    p = random_exciter(rng)
    inside = p.lower + rng.random() * (p.upper - p.lower)
    x0 = rng.choice([p.upper, p.lower, inside, inside, inside])
    v0 = rng.choice([0.0, rng.choice([-1, 1]) * log_uniform(rng, -2, 0.7)])
    force = abs(p.f) + max(abs(p.upper), abs(p.lower))
    crossing = min(math.sqrt(2 * p.l / force), 2 * p.l / max(abs(v0), 1e-9))
    tau_end = min(rng.uniform(1, 8) * 2 * math.pi / p.nu, 60.0, 50 * crossing)
    return Case(p, tau_end, min(max(x0, p.lower), p.upper), v0)


@pytest.mark.parametrize("seed", sampled([*range(10), *range(1000, 2000)], 0, 1, 2, 3, 5, 7))
def test_exact_agrees_with_the_twin(seed: int) -> None:
    """Compare every event and the end state to the tolerance that one ulp of the input implies."""
    case = random_case(seed)
    start = {"x0": case.x0, "v0": case.v0}
    ds = vp.simulate(
        vp.Exciter(**case.p._asdict()), tau_end=case.tau_end, samples_per_period=0, **start
    )
    expected = judge(case.p, case.tau_end, **start)
    if math.isinf(expected.wobble_end[0]):
        pytest.fail(f"{case}: one ulp changes its events, choose another seed")
    differences = disagreements(case.p, ds, expected, case.tau_end)
    assert not differences, f"{case}\n" + "\n".join(differences[:6])
