"""Rows whose labels rounding must not decide: undamped motions that touch nothing, and motions that graze."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import vibropipe as vp
from vibropipe.physics.linear import linear_multipliers, undamped_multiple
from vibropipe.words.regimes import Regime

OUTPUTS = (
    "harmonics", "impacts", "motion", "stability", "energy", "subharmonics", "poincare", "lyapunov",
)  # fmt: skip


def steady(outputs: tuple[str, ...] = ("stability",), **kwargs: Any) -> Any:
    exciter = vp.Exciter(**{"l": 0.5, "h": 0.0, "R1": 0.7, "R2": 0.6, **kwargs})
    return exciter, vp.steady_state(exciter, outputs=outputs)


def assert_repeats(row: Any, m: int) -> None:
    assert int(row.regime) == Regime.NO_IMPACT
    assert int(row.period_multiple) == m
    assert int(row.status) == 0
    np.testing.assert_allclose(np.abs(row.floquet_multiplier), 1.0, rtol=1e-14)
    assert int(row.stable) == 0


def test_motions_at_a_whole_part_of_the_own_frequency_repeat_each_period() -> None:
    """With nu = 2, 7, 8, 9, 14, 16, 19, 24, 31 and 38 parts of 1 they were unbounded."""
    for n in range(2, 61):
        assert_repeats(steady(nu=1.0 / n, f=0.1)[1], 1)


@pytest.mark.parametrize(
    ("nu", "m"),
    [
        (2 / 3, 2),
        (0.31, 31),
        (0.3 + 4e-17, 3),
        (1.5, 3),
        (1e4, 10_000),
        (250.25, 1001),
        (7 / 11, 7),
        (2.0**20, 2**20),
        (1e7, 10_000_000),
    ],
)
def test_a_commensurable_motion_repeats_when_both_frequencies_do(nu: float, m: int) -> None:
    exciter, row = steady(OUTPUTS, nu=nu, f=0.1)
    assert_repeats(row, m)
    assert float(row.lyapunov_exponent) == 0.0
    assert float(row.base_frequency) == pytest.approx(nu / m, rel=1e-15)
    visits = min(64, 4 * m)
    motion = vp.simulate(exciter, visits * exciter.period, samples_per_period=1)
    size = float(np.abs(row.displacement).max() + np.abs(row.velocity).max())
    for name in ("displacement", "velocity"):
        at_section = motion[name].values[:visits]
        np.testing.assert_allclose(
            row[f"poincare_{name}"].values[: at_section.size], at_section, atol=1e-12 * size
        )
    # The motion is the sum of its harmonics and subharmonics: its mean square is that of their amplitudes.
    amplitudes = [*row.displacement_amplitude.values]
    amplitudes += [*np.nan_to_num(row.subharmonic_displacement_amplitude.values)]
    swings = round(m / nu)
    if m == 1 or swings <= row.sizes["subharmonic"]:
        square = float(np.mean(row.displacement.values**2))
        assert square == pytest.approx(0.5 * float(np.square(amplitudes).sum()), rel=1e-9)


@pytest.mark.parametrize(
    "others", [{"k1": 100.0, "h1": 1.0}, {"k1": 1e6, "k2": 10.0}, {"load": 0.05}, {"delta": 0.1}]
)
def test_supports_that_are_not_touched_do_not_matter(others: dict[str, float]) -> None:
    soft = {"R1": 1.0, "R2": 1.0} if "k1" in others else {}
    assert_repeats(steady(nu=0.5, f=0.1, **others, **soft)[1], 1)


def test_a_second_harmonic_repeats_too_and_resonates_at_half_the_frequency() -> None:
    assert_repeats(steady(nu=1 / 3, f=0.1, f2=0.05, phi2=0.3)[1], 1)
    assert_repeats(steady(nu=0.75, f=0.1, f2=0.05)[1], 3)
    far = {"l": 1e9, "f": 0.1, "R1": 1.0, "R2": 1.0}
    assert int(steady(nu=0.5, f2=0.1, **far)[1].regime) == Regime.UNBOUNDED
    assert int(steady(nu=0.5, f2=0.0, **far)[1].regime) == Regime.NO_IMPACT
    assert int(steady(nu=1.0, **far)[1].regime) == Regime.UNBOUNDED


@pytest.mark.parametrize("nu", [math.sqrt(2.0), math.pi / 10, 0.5 + 1e-7, 1234.5 * math.e])
def test_incommensurable_frequencies_are_aperiodic_and_bounded(nu: float) -> None:
    row = steady(nu=nu, f=0.05)[1]
    assert int(row.regime) == Regime.APERIODIC
    assert int(row.period_multiple) == 0
    assert row.chaos.attrs["flag_meanings"].split()[int(row.chaos)] == "none"


def test_a_beat_that_has_not_ended_is_not_unbounded() -> None:
    row = steady(nu=1.0 + 1e-9, f=1e-5, l=1e3)[1]
    assert int(row.regime) == Regime.UNRESOLVED


@pytest.mark.parametrize(("nu", "m"), [(0.5, 1), (2 / 3, 2), (0.3, 3)])
def test_impacts_that_cease_leave_an_undamped_motion(nu: float, m: int) -> None:
    exciter = vp.Exciter(l=0.5, h=0.0, nu=nu, f=0.1, R1=0.7, R2=0.6)
    row = vp.steady_state(exciter, x0=0.3, v0=3.0, outputs=("stability", "impacts"))
    assert_repeats(row, m)
    assert row.sizes["impact"] == 0


@pytest.mark.parametrize("start", [(0.0, 1.0), (0.0, 0.7), (-0.19847, -0.2753)])
def test_impacts_that_fade_are_no_orbit(start: tuple[float, float]) -> None:
    """The impact velocity falls like 1/tau, for ever: at 4.5e-5 the motion had the label of a stable orbit."""
    exciter = vp.Exciter(l=0.5, h=0.0, nu=1 / 8, f=0.1, R1=0.7, k1=100.0)
    row = vp.steady_state(exciter, *start, outputs=("stability", "impacts"))
    if int(row.regime) == Regime.NO_IMPACT:
        assert_repeats(row, 1)
        return
    assert int(row.regime) == Regime.UNRESOLVED
    assert int(row.period_multiple) == 0
    assert row.chaos.attrs["flag_meanings"].split()[int(row.chaos)] == "none"
    assert np.all(np.diff(np.abs(row.impact_velocity.values)) < 0.0)


@pytest.mark.parametrize("nu", [0.7, math.sqrt(3.0)])
def test_a_free_vibration_is_an_orbit_of_its_own_period(nu: float) -> None:
    """Where impacts had ceased it had the label aperiodic, or a multiple of the forcing period without a force."""
    for start in ((0.1, 0.05), (0.3, 3.0)):
        row = vp.steady_state(vp.Exciter(l=0.5, nu=nu, R1=0.7, R2=0.6), *start)
        assert_repeats(row, 1)
        assert float(row.base_frequency) == pytest.approx(1.0, rel=1e-15)


@pytest.mark.parametrize("nu", [0.7, 1.0])
@pytest.mark.parametrize("supports", [{"k1": 50.0, "k2": 50.0}, {"k1": 50.0, "R2": 1.0}])
def test_a_free_motion_against_soft_supports_is_not_aperiodic(
    nu: float, supports: dict[str, float]
) -> None:
    """It repeats after a period of its own, which is not found; it had the label aperiodic."""
    row = vp.steady_state(vp.Exciter(l=0.5, nu=nu, **supports), v0=0.7)
    assert int(row.regime) == Regime.UNRESOLVED
    assert int(row.period_multiple) == 0


def test_multiples_are_those_of_fractions() -> None:
    for q in range(1, 40):
        for m in range(1, 40):
            if math.gcd(m, q) == 1 and m != q:
                p = vp.Exciter(nu=m / q, f=0.1, l=1.0).parameters()
                assert undamped_multiple(p) == (m, q)
    assert undamped_multiple(vp.Exciter(nu=1e-7, f=0.1, l=1.0).parameters()) == (1, 10_000_000)
    assert undamped_multiple(vp.Exciter(nu=1.0, f=0.1, l=1.0).parameters()) == (0, 0)
    assert undamped_multiple(vp.Exciter(nu=0.5, h=0.1, l=1.0).parameters()) == (0, 0)


@pytest.mark.parametrize("n", [3, 7, 9, 13, 14, 24, 31, 38])
def test_a_frequency_of_15_or_16_digits_is_that_of_its_fraction(n: int) -> None:
    """0.1428571428571428 repeated after 5 forcing periods, and 15 digits of 1/7 never."""
    for nu in (f"{1 / n:.15g}", f"{1 / n:.16g}", str(math.floor(1e16 / n) / 1e16)):
        p = vp.Exciter(nu=float(nu), f=0.1, l=1.0).parameters()
        assert undamped_multiple(p) == (1, n)


@pytest.mark.parametrize(("nu", "f"), [(1.3106779661016950, 1.0), (2.0, 3.0)])
def test_a_motion_between_ideal_rigid_supports_is_bounded(nu: float, f: float) -> None:
    """Its energy grew in the window: at high speed it is far from any resonance (invariant curves confine it)."""
    row = vp.steady_state(vp.Exciter(l=0.5, nu=nu, f=f))
    assert int(row.regime) in (Regime.APERIODIC, Regime.UNRESOLVED)


@pytest.mark.parametrize("half", [50.0, 200.0])
@pytest.mark.parametrize("R", [0.5, 1.0])
def test_a_resonance_that_meets_rigid_supports_later_is_not_unbounded(
    half: float, R: float
) -> None:
    """The motion grows by pi f in each period, and reaches l = 50 after some 1,600."""
    row = vp.steady_state(vp.Exciter(l=half, nu=1.0, f=0.01, R1=R, R2=R), outputs=())
    assert int(row.regime) == Regime.UNRESOLVED


def test_the_resonances_of_large_motions() -> None:
    """A mass hopping on soft ideal support 1: half of its swing takes pi, half pi / sqrt(1 + k1)."""
    k1 = 3.0
    for nu, regime in ((2 / (1 + 1 / math.sqrt(1 + k1)), Regime.UNBOUNDED), (1.4, None)):
        row = vp.steady_state(vp.Exciter(l=1e9, delta=-1e9, nu=nu, f=1.0, k1=k1), outputs=())
        assert (int(row.regime) == Regime.UNBOUNDED) == (regime is not None)


def test_the_first_section_is_that_of_the_row_to_the_bit() -> None:
    """At nu = 2 a free vibration takes two periods, and the state at the section is rounding."""
    for f, delta in ((-0.496392399945797, -0.03883651563597157), (-0.5318474622293621, 0.0)):
        exciter = vp.Exciter(l=0.5, nu=2.0, f=f, delta=delta, R1=0.4, R2=0.0)
        row = vp.steady_state(exciter, outputs=("poincare",))
        assert row.period_multiple.item() == 2
        for name in ("displacement", "velocity"):
            assert row[f"poincare_{name}"].values[0] == row[f"{name}_strobe"].item() != 0.0


def exactly_grazing(**kwargs: Any) -> vp.Exciter:
    """An exciter whose linear motion has the amplitude f/h = l."""
    return vp.Exciter(**{"l": 0.5, "nu": 1.0, "f": 0.1, "h": 0.2, "R1": 0.7, "R2": 0.6, **kwargs})


def assert_grazes(exciter: vp.Exciter, row: Any) -> None:
    assert int(row.regime) == Regime.NO_IMPACT
    assert int(row.period_multiple) == 1
    assert row.impacts_per_orbit.values.tolist() == [0.0, 0.0]
    assert row.sizes["impact"] == 0
    assert np.isnan(row.impact_velocity_max).all()
    assert float(row.grazings_per_orbit.sum()) >= 1.0
    expected = np.sort_complex(linear_multipliers(exciter.parameters()))
    np.testing.assert_allclose(np.sort_complex(row.floquet_multiplier.values), expected, rtol=1e-9)
    assert int(row.stable) == 1


@pytest.mark.parametrize(
    "kwargs", [{}, {"f": -0.1}, {"R1": 1.0, "R2": 0.0}, {"l": 0.25, "f": 0.05}]
)
def test_an_exactly_grazing_row_is_the_linear_motion(kwargs: dict[str, float]) -> None:
    """It was one-sided with the impact velocity 1.4e-16 and the multiplier 1e14."""
    exciter = exactly_grazing(**kwargs)
    assert_grazes(exciter, vp.steady_state(exciter))


@pytest.mark.parametrize("delta", [0.1, -0.1, 0.25, -0.3])
def test_one_support_that_is_grazed_alone(delta: float) -> None:
    """Rounding of its position may lead to the orbit with an impact that is stable beside the grazing one."""
    exciter = exactly_grazing(l=0.5 + abs(delta), delta=delta)
    row = vp.steady_state(exciter)
    assert int(row.period_multiple) == 1
    assert int(row.stable) == 1
    assert (np.abs(row.impact_velocity.values) > 1e-3).all()
    if row.sizes["impact"] == 0:
        assert_grazes(exciter, row)
        assert row.grazings_per_orbit.values[0 if delta > 0 else 1] == 0.0


@pytest.mark.parametrize("others", [{}, {"k2": 100.0, "R2": 1.0}])
def test_a_soft_support_that_is_grazed(others: dict[str, float]) -> None:
    """A grazing at the end of a step was one again and again, up to the limit on impacts."""
    exciter = exactly_grazing(**{"k1": 1e4, "h1": 10.0, "R1": 1.0, **others})
    row = vp.steady_state(exciter)
    assert int(row.regime) == Regime.NO_IMPACT
    assert row.sizes["impact"] == 0
    assert float(np.abs(row.floquet_multiplier).max()) < 1.0


@pytest.mark.parametrize("off", [-1e-6, -1e-9, -1e-12, -1e-15, 1e-15])
def test_next_to_a_grazing(off: float) -> None:
    """Within rounding of it and below no impact is left; the amplitude is that of the linear motion."""
    row = vp.steady_state(exactly_grazing(f=0.1 * (1.0 + off)))
    assert int(row.regime) == Regime.NO_IMPACT
    assert float(row.displacement_amplitude[0]) == pytest.approx(0.5 * (1.0 + off), rel=1e-13)
    assert float(np.abs(row.floquet_multiplier).max()) < 1.0


@pytest.mark.parametrize("off", [1e-12, 1e-9, 1e-6])
def test_beyond_a_grazing_impacts_are_above_the_threshold(off: float) -> None:
    row = vp.steady_state(exactly_grazing(f=0.1 * (1.0 + off)))
    assert int(row.regime) != Regime.NO_IMPACT or row.period_multiple == 0
    if row.sizes["impact"]:
        assert float(np.abs(row.impact_velocity).min()) > 1e-9 * 0.5


@pytest.mark.parametrize("unit", [1.0, 3.0, 50.0, 1000.0, 1e6])
def test_a_grazing_at_the_section_counts_once(unit: float) -> None:
    """With l = 500 and f = 100 support 2 was grazed twice in an orbit."""
    row = vp.steady_state(exactly_grazing(l=0.5 * unit, f=0.1 * unit))
    assert row.grazings_per_orbit.values.max() == 1.0


def test_rows_of_a_sweep_keep_grazings_out_of_impacts() -> None:
    f = 0.1 * (1.0 + np.array([-1e-3, 0.0, 1e-15]))
    rows = vp.sweep(exactly_grazing(), over={"f": f}, follow=("f", "up"))
    assert (rows.regime == Regime.NO_IMPACT).all()
    assert np.isnan(rows.impact_velocity_max).all()
    assert float(np.abs(rows.floquet_multiplier).max()) < 1.0


def test_a_free_vibration_that_grazes() -> None:
    row = vp.steady_state(vp.Exciter(l=0.5), x0=0.5)
    assert int(row.regime) == Regime.NO_IMPACT
    assert row.grazings_per_orbit.values.tolist() == [1.0, 1.0]
    slower = vp.steady_state(vp.Exciter(l=0.5, delta=-0.1), x0=0.3, v0=math.sqrt(0.16 - 0.09))
    assert slower.grazings_per_orbit.values.tolist() == [1.0, 0.0]
