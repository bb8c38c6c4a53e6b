"""Designs and tolerances with soft supports, friction and two harmonics of the force."""

from __future__ import annotations

from dataclasses import replace

import pytest

import vibropipe as vp
from vibropipe.solve.rows import points

SOFT = vp.Exciter(l=0.5, nu=1.0, f=-1.0, h=0.2, R1=0.7, delta=0.02, k2=200.0, h2=3.0, friction=0.1)
TWO = vp.Exciter(l=0.5, nu=1.0, f=-1.0, h=0.2, R1=0.7, R2=0.7, f2=0.4, phi2=0.7)
QUANTITY = "displacement_mean"


def slope_of(exciter: vp.Exciter, name: str) -> float:
    """Return the derivative of the mean displacement by differences of fourth order."""
    step = 1e-3 * max(abs(getattr(exciter, name)), 0.05)
    values = [
        float(vp.steady_state(replace(exciter, **{name: getattr(exciter, name) + n * step})).displacement_mean)
        for n in (-2, -1, 1, 2)
    ]  # fmt: skip
    return (values[0] - 8 * values[1] + 8 * values[2] - values[3]) / (12 * step)


@pytest.mark.parametrize(
    ("exciter", "names"), [(SOFT, ("f", "k2", "h2", "friction")), (TWO, ("nu", "f2", "phi2"))]
)
def test_slopes_are_those_of_neighbours(exciter: vp.Exciter, names: tuple[str, ...]) -> None:
    ds = vp.tolerance(
        exciter, {name: 1e-3 * abs(getattr(exciter, name)) for name in names}, samples=64
    )
    assert float(ds.law_change_share) == 0.0
    for name in names:
        slope = float(ds[f"{QUANTITY}_sensitivity"].sel(parameter=name))
        assert slope == pytest.approx(slope_of(exciter, name), rel=1e-4, abs=1e-7)


def test_friction_and_stiffness_are_designed() -> None:
    target = float(vp.steady_state(replace(SOFT, friction=0.13, k2=260.0)).displacement_mean)
    ds = vp.design(
        SOFT, {"k2": (100.0, 400.0), "friction": (0.05, 0.2)}, {QUANTITY: target},
        samples=64, designs=2,
    )  # fmt: skip
    assert float(ds.design_miss[0]) < 1e-3
    best = {name: float(ds[name][0]) for name in ("k2", "friction")}
    found = float(vp.steady_state(replace(SOFT, **best)).displacement_mean)
    assert found == pytest.approx(float(ds[QUANTITY][0]), abs=1e-12)
    assert found == pytest.approx(target, rel=0.02)


def test_the_loss_by_friction_is_a_target() -> None:
    exciter = replace(SOFT, friction=0.0)
    name = "energy_friction"
    ds = vp.design(exciter, {"friction": (0.0, 0.2)}, {name: 0.1}, samples=64, designs=1)
    found = replace(exciter, friction=float(ds.friction[0]))
    assert float(vp.steady_state(found)[name]) == pytest.approx(0.1, rel=1e-6)
    assert float(ds[f"{name}_target"]) == 0.1


def test_a_support_does_not_turn_rigid() -> None:
    with pytest.raises(vp.ParameterError, match=r"vary.k2: must be above 0 .*, got 0.0"):
        vp.design(SOFT, {"k2": (0.0, 400.0)}, {QUANTITY: 0.0})
    with pytest.raises(vp.ParameterError, match="k1: must be above 0 where k1 or h1 vary"):
        vp.tolerance(SOFT, {"h1": 0.1})


def test_a_search_among_motions_that_take_too_many_steps_ends_in_words(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(points, "LONG_MARCHES", 4)
    monkeypatch.setattr(points, "START_WORK", 10_000)
    exciter = vp.Exciter(l=0.5, nu=2.5, f=1.0, h=0.1, k1=5e4, h1=7e-8, k2=1e-6, h2=1e9)
    with pytest.raises(
        vp.ParameterError, match=r"vary: must leave motions that are settled sooner"
    ):
        vp.design(exciter, {"delta": (-0.3, 0.3), "f": (0.5, 2.0)}, {QUANTITY: 0.1}, samples=16)
