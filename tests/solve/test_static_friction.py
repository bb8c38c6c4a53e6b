"""Static friction above kinetic: motions against 40 digits and a closed form, sweeps and branches against motions."""

from __future__ import annotations

import random
from decimal import Decimal

import numpy as np
import pytest
from helpers.reference_housing import HousingReferenceSolver

import vibropipe as vp
from vibropipe.lab.reference_solver import ReferenceSolver
from vibropipe.words.bifurcations import Bifurcation

BASE = vp.Exciter(l=1.0, nu=0.5, f=1.2, h=0.1, R1=0.7, R2=0.6, friction=0.3, friction_ratio=1.6)


def random_exciter(seed: int, **further: float) -> vp.Exciter:
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


def test_random_motions_agree_with_the_twin_in_long_arithmetic() -> None:
    slips = rests = 0
    for seed in range(0, 60, 2):
        exciter = random_exciter(seed)
        motion = vp.simulate(exciter, 30.0, 0.1, -0.2, samples_per_period=0)
        found = ReferenceSolver(exciter).run(0.1, -0.2, [Decimal(30)])
        ends = [float(motion.displacement_end), float(motion.velocity_end)]
        np.testing.assert_allclose(ends, np.array(found.states[0], float), atol=2e-14)
        kinds = [kind for _tau, kind, _support, _v in found.events]
        assert motion.stick_start.size == kinds.count("stick"), seed
        slips, rests = slips + kinds.count("slip"), rests + kinds.count("rest")
    assert slips > 50
    assert rests > 0


def test_random_motions_in_a_housing_agree_with_the_twin_in_long_arithmetic() -> None:
    for seed in range(12):
        further = {"mass_ratio": 0.3, "housing_friction_1": 0.3, "housing_friction_2": 0.4}
        exciter = random_exciter(seed, **further)
        motion = vp.simulate(exciter, 20.0, 0.1, -0.2, samples_per_period=0)
        found, housing = HousingReferenceSolver(exciter).run_housing(0.1, -0.2, 0.0, [Decimal(20)])
        ends = [
            float(motion[f"{name}_end"])
            for name in ("displacement", "velocity", "housing_velocity")
        ]
        exact = np.array([*found.states[0], housing[0][0]], float)
        np.testing.assert_allclose(ends, exact, atol=1e-12, err_msg=str(seed))


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


def test_a_sweep_has_the_rows_of_single_states() -> None:
    over = {"friction_ratio": [1.0, 1.3, 1.8], "friction": [0.0, 0.2]}
    sweep = vp.sweep(BASE, over, outputs=("harmonics", "impacts", "stability"))
    for ratio in over["friction_ratio"]:
        exciter = vp.Exciter(**{**BASE.stated(), "friction_ratio": ratio, "friction": 0.2})
        row, one = sweep.sel(friction_ratio=ratio, friction=0.2), vp.steady_state(exciter)
        for name in ("displacement_amplitude", "floquet_multiplier", "impact_velocity_max"):
            np.testing.assert_allclose(row[name].values[:2], one[name].values[:2], atol=1e-11)
    without = sweep.sel(friction=0.0).displacement_amplitude.values
    assert (without == without[0]).all()


@pytest.mark.parametrize(
    ("along", "to"), [("friction_ratio", (1.0, 2.5)), ("nu", (0.4, 0.8)), ("friction", (0.1, 0.5))]
)
def test_points_of_a_branch_are_orbits(along: str, to: tuple[float, float]) -> None:
    branch = vp.branch(BASE, along, to, harmonics=1)
    assert branch.point.size > 10
    assert Bifurcation.CHANGE in branch.bifurcation_kind
    held = 0
    for i in range(0, branch.point.size, max(1, branch.point.size // 25)):
        if i in branch.bifurcation_point:
            continue  # another law begins
        point = branch.isel(point=i)
        exciter = vp.Exciter(**{**BASE.stated(), along: float(point[along])})
        x, v = float(point.displacement_strobe), float(point.velocity_strobe)
        m = int(point.period_multiple)
        motion = vp.simulate(exciter, m * exciter.period, x, v, samples_per_period=0)
        growth = 1.0 + np.abs(point.floquet_multiplier.values).max()
        assert abs(float(motion.displacement_end) - x) < 1e-11 * growth
        assert abs(float(motion.velocity_end) - v) < 1e-11 * growth
        held += motion.stick_start.size > 0
    assert held > 5
