"""Supports that only push, and static friction above kinetic: against 40 digits, closed forms and single motions."""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from dataclasses import replace
from decimal import Decimal

import numpy as np
import pytest
import xarray as xr
from helpers.reference_housing import HousingReferenceSolver
from orbit_motions import motion_of

import vibropipe as vp
from vibropipe.lab.reference_solver import ReferenceSolver
from vibropipe.words.bifurcations import Bifurcation

PUSHES = {"contact_1": "no_pull", "contact_2": "no_pull"}
BASE = vp.Exciter(l=0.5, nu=1.5, f=1.2, h=0.1, k1=200.0, k2=300.0, h1=4.0, h2=7.0, **PUSHES)
# Pressed on support 2, which pushes again before the mass has left it; its orbit does not leave it at all.
PRESSED = vp.Exciter(
    l=0.5, nu=5.8, f=0.56, h=0.23, load=-2.05, k1=94.0, k2=1.1, h1=7.2, h2=5.8, f2=2.14, **PUSHES
)
STICKING = vp.Exciter(l=1.0, nu=0.5, f=1.2, h=0.1, R1=0.7, R2=0.6, friction=0.3, friction_ratio=1.6)


def random_exciter(seed: int, **further: float) -> vp.Exciter:
    """Return an exciter with soft supports that only push; some have friction, two harmonics or a rigid support."""
    draw = random.Random(seed)
    values = {
        name: draw.uniform(low, high)
        for name, low, high in (
            ("l", 0.3, 0.8), ("nu", 0.3, 2.0), ("f", 0.5, 2.0), ("h", 0.0, 0.3), ("delta", -0.2, 0.2),
            ("load", -0.8, 0.8), ("h1", 0.3, 8.0), ("h2", 0.3, 8.0),
        )
    }  # fmt: skip
    values |= {k: 10.0 ** draw.uniform(0.3, 3.0) for k in ("k1", "k2")}
    if seed % 3 == 0:
        values |= {"friction": draw.uniform(0.02, 0.3), "friction_ratio": draw.uniform(1.0, 2.0)}
    if seed % 4 == 0:
        values |= {"f2": draw.uniform(-0.3, 0.3), "phi2": 1.0}
    if seed % 5 == 0:
        values |= {"k2": 0.0, "h2": 0.0, "R2": 0.6}
    return vp.Exciter(**values, **PUSHES, **further)


def random_sticking_exciter(seed: int, **further: float) -> vp.Exciter:
    """Return an exciter that is held now and then; some have a soft support, two harmonics or a load."""
    draw = random.Random(seed)
    values = {
        name: draw.uniform(low, high)
        for name, low, high in (
            ("l", 0.4, 1.0), ("nu", 0.3, 1.5), ("f", 0.3, 1.5), ("h", 0.0, 0.3), ("delta", -0.2, 0.2),
            ("R1", 0.2, 0.9), ("R2", 0.2, 0.9), ("friction", 0.05, 0.4), ("friction_ratio", 1.0, 2.5),
        )
    }  # fmt: skip
    if seed % 3 == 0:
        values |= {"k1": draw.uniform(5.0, 200.0), "h1": draw.uniform(0.0, 2.0), "R1": 1.0}
    if seed % 4 == 0:
        values |= {"f2": draw.uniform(-0.3, 0.3), "phi2": 1.0}
    if seed % 5 == 0:
        values["load"] = draw.uniform(-0.2, 0.2)
    return vp.Exciter(**values, **further)


def motion_and_events(exciter: vp.Exciter, atol: float) -> tuple[xr.Dataset, list[str]]:
    """Return a motion, which ends like its twin in long arithmetic, and the kinds of the twin's events."""
    motion = vp.simulate(exciter, 30.0, 0.1, -0.2, samples_per_period=0)
    found = ReferenceSolver(exciter).run(0.1, -0.2, [Decimal(30)])
    ends = [float(motion.displacement_end), float(motion.velocity_end)]
    np.testing.assert_allclose(ends, np.array(found.states[0], float), atol=atol)
    return motion, [kind for _tau, kind, _support, _v in found.events]


def test_random_motions_agree_with_the_twin_in_long_arithmetic() -> None:
    unloads = reloads = 0
    for exciter in (*map(random_exciter, range(0, 40, 2)), PRESSED, replace(PRESSED, l=0.3)):
        motion, kinds = motion_and_events(exciter, 3e-14)
        assert motion.sizes["impact"] == kinds.count("in") + kinds.count("impact")
        unloads, reloads = unloads + kinds.count("unload"), reloads + kinds.count("reload")
    assert unloads > 200
    assert reloads > 20


def test_random_motions_with_sticks_agree_with_the_twin_in_long_arithmetic() -> None:
    slips = rests = 0
    for seed in range(0, 60, 2):
        motion, kinds = motion_and_events(random_sticking_exciter(seed), 2e-14)
        assert motion.stick_start.size == kinds.count("stick"), seed
        slips, rests = slips + kinds.count("slip"), rests + kinds.count("rest")
    assert slips > 50
    assert rests > 0


@pytest.mark.parametrize(
    ("draw", "seeds"),
    [pytest.param(random_exciter, 8, marks=pytest.mark.slow), (random_sticking_exciter, 12)],
)
def test_random_motions_in_a_housing_agree_with_the_twin_in_long_arithmetic(
    draw: Callable[..., vp.Exciter], seeds: int
) -> None:
    further = {"mass_ratio": 0.3, "housing_friction_1": 0.3, "housing_friction_2": 0.4}
    for seed in range(seeds):
        exciter = draw(seed, **further)
        motion = vp.simulate(exciter, 20.0, 0.1, -0.2, samples_per_period=0)
        found, housing = HousingReferenceSolver(exciter).run_housing(0.1, -0.2, 0.0, [Decimal(20)])
        names = ("displacement", "velocity", "housing_velocity")
        ends = [float(motion[f"{name}_end"]) for name in names]
        exact = np.array([*found.states[0], housing[0][0]], float)
        np.testing.assert_allclose(ends, exact, atol=1e-12, err_msg=str(seed))


@pytest.mark.parametrize("exciter", [BASE, pytest.param(PRESSED, marks=pytest.mark.slow)])
def test_newmark_motions_converge_to_the_exact_one(exciter: vp.Exciter) -> None:
    exact = vp.simulate(exciter, 20.0, 0.1, 0.3, samples_per_period=64).displacement
    errors = []
    for steps in (256, 16384):
        method = {"method": "newmark", "steps_per_period": steps}
        motion = vp.simulate(exciter, 20.0, 0.1, 0.3, samples_per_period=64, **method)
        errors.append(float(abs(motion.displacement - exact).max()))
    assert errors[1] < 1e-5
    # Of second order: over six halvings, between which events move from step to step.
    assert (errors[0] / errors[1]) ** (1 / 3) == pytest.approx(16.0, rel=0.2)


@pytest.mark.parametrize(("given", "is_"), [(0.7, 0.718), (0.5, 0.550), (0.3, 0.397)])
def test_a_contact_gives_the_speed_of_the_closed_form(given: float, is_: float) -> None:
    """A contact of a spring and a damper alone that ends where its force is zero.

    T. Schwager, T. Poeschel, "Coefficient of restitution and linear-dashpot model revisited", Granular Matter 9 (2007).
    """
    z = -math.log(given) / math.hypot(math.pi, math.log(given))
    root = math.sqrt(1.0 - z * z)
    closed = math.exp(-z / root * (math.pi - math.atan2(2.0 * z * root, root * root - z * z)))
    assert closed == pytest.approx(is_, abs=5e-4)
    exciter = vp.Exciter(l=0.5, k1=1e10, R1=given, contact_1="no_pull")
    motion = vp.simulate(exciter, 1.0, 0.49, 1.0)
    after = float(motion.impact_velocity_after[0] / motion.impact_velocity[0])
    assert after == pytest.approx(-closed, rel=1e-4)
    # It ends before the mass is back at the support.
    pulls = vp.simulate(replace(exciter, contact_1="pull"), 1.0, 0.49, 1.0)
    assert float(motion.contact_duration[0]) < float(pulls.contact_duration[0])


@pytest.mark.parametrize("undamped", [True, pytest.param(False, marks=pytest.mark.slow)])
def test_a_support_that_never_pulls_is_the_same_either_way(undamped: bool) -> None:
    soft = {"k1": 80.0, "k2": 80.0} if undamped else {"R1": 0.6, "R2": 0.6}
    plain = vp.Exciter(l=0.5, nu=1.3, f=1.1, h=0.1, **soft)
    one, two = (vp.steady_state(each) for each in (plain, replace(plain, **PUSHES)))
    for name in one.data_vars:
        np.testing.assert_array_equal(one[name], two[name], err_msg=name)


def test_exciters_that_pull_have_no_trace_of_it() -> None:
    plain = vp.Exciter(l=0.5, nu=1.3, f=1.1, h=0.1, k1=80.0, h1=3.0)
    stated = replace(plain, contact_1="pull")
    assert vp.steady_state(plain).identical(vp.steady_state(stated))
    assert "contact_1" not in vp.steady_state(plain)


def test_other_words_are_refused() -> None:
    with pytest.raises(vp.ParameterError, match=r"contact_1: must be pull or no_pull, got 'push'"):
        vp.Exciter(l=1.0, contact_1="push")
    with pytest.raises(vp.ParameterError, match=r"contact_2: must be pull or no_pull, got 0\.5"):
        vp.Exciter(l=1.0, contact_2=0.5)
    with pytest.raises(vp.ParameterError, match="along"):
        vp.branch(BASE, "contact_1", (0.0, 1.0))


def test_its_force_only_pushes() -> None:
    """The impulse of a contact is that of its force max(0, k y + h y') over samples, the loss its work."""
    names = ("impacts", "energy", "power", "frame")
    orbit = vp.steady_state(replace(BASE, load=0.1), outputs=names)
    assert int(orbit.period_multiple) == 1
    exciter, period = replace(BASE, load=0.1), BASE.period
    x0, v0 = float(orbit.displacement_strobe), float(orbit.velocity_strobe)
    motion = vp.simulate(exciter, period, x0, v0, samples_per_period=200_000)
    x, v, tau = motion.displacement.values, motion.velocity.values, motion.tau.values
    lost = 0.0
    for support, (k, h) in ((1, (200.0, 4.0)), (2, (300.0, 7.0))):
        side, bound = (1, exciter.upper) if support == 1 else (-1, exciter.lower)
        depth = side * (x - bound)
        force = np.where(depth > 0.0, np.maximum(0.0, k * depth + h * side * v), 0.0)
        impulse = np.trapezoid(force, tau)
        assert float(orbit.impulse_per_period.sel(support=support)) == pytest.approx(
            impulse, rel=1e-4
        )
        work = np.trapezoid(force * side * v, tau)
        loss = float(orbit.power_impact.sel(support=support)) * period
        assert loss == pytest.approx(work, rel=1e-3)
        lost += loss
        assert float(orbit.contact_force_max.max()) >= force.max() - 1e-3
    balance = float(orbit.power_input - orbit.power_damping - orbit.power_impact.sum())
    assert abs(balance) < 1e-13
    assert lost > 0.1


def test_a_sweep_has_the_rows_of_single_states() -> None:
    over = {"h1": [0.0, 2.0, 6.0], "contact_2": [0.0, 1.0]}
    sweep = vp.sweep(BASE, over, outputs=("harmonics", "impacts", "stability"))
    for h1 in over["h1"]:
        for contact in over["contact_2"]:
            row = sweep.sel(h1=h1, contact_2=contact)
            one = vp.steady_state(replace(BASE, h1=h1, contact_2=contact))
            for name in ("displacement_amplitude", "floquet_multiplier", "impact_velocity_max"):
                np.testing.assert_allclose(row[name].values[:2], one[name].values[:2], atol=1e-11)


def marched_points(exciter: vp.Exciter, along: str, branch: xr.Dataset) -> list[xr.Dataset]:
    """Return motions from some 25 points of a branch over their periods, after which each must be where it began."""
    motions = []
    for i in range(0, branch.point.size, max(1, branch.point.size // 25)):
        if i in branch.bifurcation_point:
            continue  # another law begins
        point = branch.isel(point=i)
        here = replace(exciter, **{along: float(point[along])})
        motions.append(motion_of(here, point))
        growth = 1.0 + np.abs(point.floquet_multiplier.values).max()
        for name in ("displacement", "velocity"):
            off = float(motions[-1][f"{name}_end"] - point[f"{name}_strobe"])
            assert abs(off) < 1e-11 * growth
    return motions


@pytest.mark.parametrize(
    ("exciter", "along", "to"),
    [
        pytest.param(BASE, "nu", (0.5, 4.0), id="two supports"),
        pytest.param(replace(BASE, k2=200.0, h2=4.0, friction=0.1), "nu", (0.5, 4.0), id="friction"),
        pytest.param(PRESSED, "load", (-3.0, 3.0), id="pressed", marks=pytest.mark.slow),
        pytest.param(replace(BASE, mass_ratio=0.3, housing_friction_1=0.3, housing_friction_2=0.4), "nu", (1.3, 1.6),
                     id="housing", marks=pytest.mark.slow),
    ],
)  # fmt: skip
def test_points_of_a_branch_are_orbits(
    exciter: vp.Exciter, along: str, to: tuple[float, float]
) -> None:
    branch = vp.branch(exciter, along, to, harmonics=1)
    assert branch.point.size > 60
    marched_points(exciter, along, branch)


@pytest.mark.parametrize(
    ("along", "to"), [("friction_ratio", (1.0, 2.5)), ("nu", (0.4, 0.8)), ("friction", (0.1, 0.5))]
)
def test_points_of_a_branch_with_sticks_are_orbits(along: str, to: tuple[float, float]) -> None:
    branch = vp.branch(STICKING, along, to, harmonics=1)
    assert branch.point.size > 10
    assert Bifurcation.CHANGE in branch.bifurcation_kind
    assert sum(each.stick_start.size > 0 for each in marched_points(STICKING, along, branch)) > 5


def test_a_branch_goes_from_a_mass_pressed_on_a_support_to_one_between_them() -> None:
    branch = vp.branch(PRESSED, "load", (-3.0, 3.0), harmonics=1)
    reached = branch["load"].values
    assert (reached.min(), reached.max()) == pytest.approx((-3.0, 3.0))
    assert (branch.impacts_per_period.sum("support") == 0).any()
    assert (branch.impacts_per_period.sum("support") > 0).any()


def test_a_mass_within_a_soft_support_leaves_it_along_a_branch() -> None:
    """With a support that pulls: the motion without any event is one in contact at first."""
    branch = vp.branch(
        replace(PRESSED, contact_1=0.0, contact_2=0.0), "load", (-3.0, 3.0), harmonics=1
    )
    assert (branch["load"].values.min(), branch["load"].values.max()) == pytest.approx((-3.0, 3.0))


def test_a_mass_is_held_up_to_the_static_friction() -> None:
    """Without impacts: f sin(nu tau) reaches friction_ratio friction, then the mass slides with friction alone."""
    exciter = vp.Exciter(l=9.0, nu=0.2, f=0.8, friction=0.3, friction_ratio=1.5)
    slip = np.arcsin(0.45 / 0.8) / 0.2
    motion = vp.simulate(exciter, 10.0, 0.0, 0.0)
    assert float(motion.stick_end[0]) == pytest.approx(slip, abs=1e-13)
    t = np.linspace(0.0, 1.0, 20)
    force = 0.8 / (1.0 - 0.04)
    # x'' + x = f sin(nu tau) - friction from rest at the slip
    a = -force * np.sin(0.2 * slip) + 0.3
    b = -force * 0.2 * np.cos(0.2 * slip)
    expected = force * np.sin(0.2 * (slip + t)) - 0.3 + a * np.cos(t) + b * np.sin(t)
    for at, x in zip(t, expected, strict=True):
        end = vp.simulate(exciter, slip + at, 0.0, 0.0, samples_per_period=0)
        assert float(end.displacement_end) == pytest.approx(x, abs=1e-13)


def test_equal_static_and_kinetic_friction_change_nothing() -> None:
    plain = vp.Exciter(l=1.0, nu=0.5, f=1.2, h=0.1, R1=0.7, R2=0.6, friction=0.3)
    stated = vp.Exciter(l=1.0, nu=0.5, f=1.2, h=0.1, R1=0.7, R2=0.6, friction=0.3, friction_ratio=1)
    assert vp.steady_state(plain).identical(vp.steady_state(stated))
    assert "friction_ratio" not in vp.steady_state(plain)


def test_it_is_refused_below_one() -> None:
    with pytest.raises(vp.ParameterError, match=r"friction_ratio: must be a finite number >= 1"):
        vp.Exciter(l=1.0, friction=0.1, friction_ratio=0.9)


def test_a_sweep_with_sticks_has_the_rows_of_single_states() -> None:
    over = {"friction_ratio": [1.0, 1.3, 1.8], "friction": [0.0, 0.2]}
    sweep = vp.sweep(STICKING, over, outputs=("harmonics", "impacts", "stability"))
    for ratio in over["friction_ratio"]:
        exciter = vp.Exciter(**{**STICKING.stated(), "friction_ratio": ratio, "friction": 0.2})
        row, one = sweep.sel(friction_ratio=ratio, friction=0.2), vp.steady_state(exciter)
        for name in ("displacement_amplitude", "floquet_multiplier", "impact_velocity_max"):
            np.testing.assert_allclose(row[name].values[:2], one[name].values[:2], atol=1e-11)
    without = sweep.sel(friction=0.0).displacement_amplitude.values
    assert (without == without[0]).all()
