"""A housing that slides: references, exact nulls, order of Newmark's method, steady states and their multipliers."""

from __future__ import annotations

import dataclasses
import json
import math
from decimal import Decimal
from typing import Any

import numpy as np
import pytest
from comparisons import REFERENCE
from helpers.reference_housing import HousingReferenceSolver
from housings import ENDS as OF_STATE
from housings import SECTION, SYMMETRIC, exciter_of

import vibropipe as vp
from vibropipe.words.status import Status

ENTRIES = json.loads((REFERENCE / "housing.json").read_text())
ENDS = (*OF_STATE, "housing_displacement_end")
MOTIONS, STEADY = range(len(ENTRIES["motions"])), range(len(ENTRIES["steady"]))
# both supports struck, slipping either way
FORCED = vp.Exciter(
    l=0.3, nu=2.1, f=0.9, h=0.1, delta=0.05, R1=0.5, R2=0.6, mass_ratio=0.8,
    housing_friction_1=0.1, housing_friction_2=0.2, housing_load=0.03,
)  # fmt: skip


def ends_of(exciter: vp.Exciter, tau_end: float, *start: float, **options: Any) -> np.ndarray:
    """Return the state of both bodies at the end of a motion."""
    x0, v0, u0 = (*start, 0.0, 0.0, 0.0)[:3]
    ds = vp.simulate(exciter, tau_end, x0, v0, housing_v0=u0, samples_per_period=0, **options)
    assert int(ds.status) == Status.OK
    return np.array([float(ds[name]) for name in ENDS])


def expected_ends(entry: dict[str, Any]) -> np.ndarray:
    """Return the state at the end of a reference."""
    names = ("x", "v", "housing_velocity", "housing_displacement")
    return np.array([float(entry[name]) for name in names])


def slips_and_stops(motion: Any) -> list[tuple[float, str, int]]:
    """Return the events of a housing but for those that an impact causes, as the references list them."""
    found = []
    for name, kind in (("housing_slip_start", "slip"), ("housing_slip_end", "stop")):
        for tau, way in zip(motion[name].values, motion.housing_slip_direction.values, strict=True):
            if math.isfinite(tau) and tau not in motion.impact_tau.values:
                found.append((float(tau), kind, int(way)))
    return sorted(found)


@pytest.mark.parametrize("i", MOTIONS)
def test_motions_and_events_agree_with_the_references(i: int) -> None:
    entry = ENTRIES["motions"][i]
    motion = vp.simulate(exciter_of(entry), entry["t_end"], samples_per_period=0)
    ends = np.array([float(motion[name]) for name in ENDS])
    assert np.abs(ends - expected_ends(entry)).max() < 1e-12
    listed = [(float(tau), kind, of) for tau, kind, of in entry["events"]]
    slips = sorted((tau, kind, int(way)) for tau, kind, way in listed if kind in ("slip", "stop"))
    found = slips_and_stops(motion)
    assert [each[1:] for each in found] == [each[1:] for each in slips]
    assert np.abs([a[0] - b[0] for a, b in zip(found, slips, strict=True)]).max() < 1e-12
    impacts = [(tau, float(v)) for tau, kind, v in listed if kind in ("1", "2", "in1", "in2")]
    computed = np.column_stack([motion.impact_tau.values, motion.impact_velocity.values])
    assert np.abs(computed.reshape(-1, 2) - np.reshape(impacts, (-1, 2))).max(initial=0) < 1e-12


@pytest.mark.parametrize("i", [0, 1, 4])
def test_newmark_converges_with_the_square_of_the_step(i: int) -> None:
    entry = ENTRIES["motions"][i]
    exciter, expected, errors = exciter_of(entry), expected_ends(entry), []
    for steps in (400, 800, 1600):
        ends = ends_of(exciter, entry["t_end"], method="newmark", steps_per_period=steps)
        errors.append(np.abs(ends - expected))
    assert errors[-1].max() < 2e-5
    # of the state; the error of the drift may change its sign
    assert 11.0 < errors[0][:3].max() / errors[-1][:3].max() < 21.0


def test_samples_are_those_of_motions_that_end_there() -> None:
    motion = vp.simulate(FORCED, 20.0, 0.1, 0.2, housing_v0=-0.3, samples_per_period=7)
    for n in range(1, motion.tau.size, 5):
        ends = ends_of(FORCED, float(motion.tau[n]), 0.1, 0.2, -0.3)
        found = motion.isel(tau=n)
        names = ("displacement", "velocity", "housing_velocity", "housing_displacement")
        assert np.abs([float(found[name]) for name in names] - ends).max() < 1e-12
    assert float(motion.housing_velocity[0]) == -0.3
    assert float(motion.housing_displacement[0]) == 0.0


def test_a_mirrored_exciter_moves_the_other_way_bit_for_bit() -> None:
    ends = ends_of(FORCED, 40.0, 0.1, 0.2, -0.3)
    mirrored = ends_of(FORCED.mirrored(), 40.0, -0.1, -0.2, 0.3)
    assert (ends == -mirrored).all()


def test_the_momentum_of_both_bodies_has_the_rate_of_the_outer_forces() -> None:
    """Without friction on the ground m (x + X)' + M X' grows by the loads, whatever strikes what."""
    loaded = vp.Exciter(
        l=0.3, nu=1.7, f=1.1, h=0.2, R1=0.5, k2=30.0, friction=0.1, load=0.1, mass_ratio=0.7,
        housing_load=-0.03,
    )  # fmt: skip
    x, v, velocity, displacement = ends_of(loaded, 30.0, 0.05, 0.4, 0.2)
    share = 0.7 / 1.7
    assert abs(velocity + share * v - (0.2 + share * 0.4 + share * 0.07 * 30.0)) < 1e-12
    drift = (0.2 + share * 0.4) * 30.0 + 0.5 * share * 0.07 * 30.0**2
    assert abs(displacement + share * (x - 0.05) - drift) < 1e-10


def test_a_housing_that_friction_holds_is_the_fixed_one() -> None:
    held = vp.Exciter(
        l=1.0, nu=0.6, f=0.5, h=0.1, friction=0.05, mass_ratio=0.5,
        housing_friction_1=10.0, housing_friction_2=10.0,
    )  # fmt: skip
    fixed = vp.Exciter(l=1.0, nu=0.6, f=0.5, h=0.1, friction=0.05)
    ends = ends_of(held, 20.0, 0.2, 0.1)
    motion = vp.simulate(fixed, 20.0, 0.2, 0.1, samples_per_period=0)
    assert ends[0] == float(motion.displacement_end)
    assert ends[1] == float(motion.velocity_end)
    assert ends[2] == ends[3] == 0.0


def test_an_impact_pushes_a_held_housing_off() -> None:
    struck = vp.Exciter(
        l=0.3, R1=0.5, mass_ratio=1.0, housing_friction_1=10.0, housing_friction_2=10.0
    )
    motion = vp.simulate(struck, 0.5, 0.0, 1.0, samples_per_period=0)
    before = float(motion.impact_velocity[0])
    # c (1 + R) v-, stopped at the rate of the friction and the forces on the housing
    push = 0.5 * 1.5 * before
    first = motion.isel(housing_slip=0)
    assert float(first.housing_slip_start) == float(motion.impact_tau[0])
    assert int(first.housing_slip_direction) == 1
    lasts = float(first.housing_slip_end - first.housing_slip_start)
    assert 0.9 * push / 10.0 < lasts < 1.1 * push / 9.0


def test_a_mass_at_rest_on_a_support_slides_on_with_the_housing() -> None:
    """Both bodies are one then: it stops under the friction alone."""
    pressed = vp.Exciter(
        l=0.5, load=2.0, R1=0.0, mass_ratio=1.0, housing_friction_1=2.5, housing_friction_2=2.5
    )
    motion = vp.simulate(pressed, 3.0, 0.5, 0.0, housing_v0=0.4, samples_per_period=0)
    # P' = c (load - friction) with c = 1/2
    stop = 0.4 / (0.5 * 0.5)
    assert abs(float(motion.housing_slip_end[0]) - stop) < 1e-14
    assert abs(float(motion.housing_displacement_end) - 0.5 * 0.4 * stop) < 1e-14
    assert float(motion.rest_end[0]) == math.inf


def test_friction_stops_what_a_chatter_pushes_by_less_than_its_rounding() -> None:
    """The last impacts push a housing off by 1e-15, against a friction of 9."""
    held = vp.Exciter(
        l=0.375, nu=1.2, f=1.0, h=0.1, R1=0.4, R2=0.4, delta=0.02, mass_ratio=0.4,
        housing_friction_1=9.0, housing_friction_2=9.0,
    )  # fmt: skip
    motion = vp.simulate(held, 4 * held.period, 0.0, 0.0)
    assert motion.rest_start.size > 2
    assert np.isfinite(motion.rest_end[:-1]).all()
    # no push is larger than that of the fastest impact, and all stop
    push = 0.4 / 1.4 * 1.4 * float(abs(motion.impact_velocity).max())
    assert float(abs(motion.housing_velocity).max()) <= push * (1 + 1e-14)
    assert np.isfinite(motion.housing_slip_end[:-1]).all()


def random_motion(seed: int) -> tuple[vp.Exciter, tuple[float, float, float]]:
    """Return an exciter with any of all effects, and a start."""
    random = np.random.default_rng(seed)

    def one_of(*values: float) -> float:
        return float(random.choice(values))

    def between(low: float, high: float) -> float:
        return float(random.uniform(low, high))

    k1, k2 = (one_of(0.0, 10.0 ** between(0.0, 3.0)) for _ in range(2))
    up = one_of(0.0, between(0.0, 1.0))
    exciter = vp.Exciter(
        l=0.5, nu=between(0.3, 3.0), f=between(-1.5, 1.5), h=one_of(0.0, between(0.0, 0.5)),
        delta=between(-0.6, 0.6), k1=k1, k2=k2, R1=1.0 if k1 else between(0.05, 1.0),
        R2=1.0 if k2 else one_of(0.0, between(0.05, 1.0)), load=one_of(0.0, between(-0.5, 0.5)),
        friction=one_of(0.0, between(0.0, 0.6)), f2=one_of(0.0, between(-1.0, 1.0)),
        phi2=between(-3.0, 3.0), mass_ratio=one_of(0.1, 1.0, between(0.0, 5.0)),
        housing_friction_1=up, housing_friction_2=one_of(up, 0.0, between(0.0, 1.0)),
        housing_load=one_of(0.0, between(-0.4, 0.4)),
    )  # fmt: skip
    x0 = one_of(
        exciter.lower, exciter.upper, *(between(exciter.lower, exciter.upper) for _ in "123")
    )
    return exciter, (x0, one_of(0.0, between(-1.0, 1.0)), one_of(0.0, between(-0.5, 0.5)))


def test_the_twin_in_long_arithmetic_agrees_with_the_references() -> None:
    for entry in ENTRIES["motions"][::2]:
        solver = HousingReferenceSolver(exciter_of(entry))
        motion, housing = solver.run_housing(0.0, 0.0, 0.0, [Decimal(entry["t_end"])])
        ends = np.array([*motion.states[0], *housing[0]], float)
        assert np.abs(ends - expected_ends(entry)).max() < 1e-14


def test_random_motions_agree_with_the_twin_in_long_arithmetic() -> None:
    compared, end = 0, 8.0
    for seed in range(30):
        exciter, start = random_motion(seed)
        motion = vp.simulate(exciter, end, *start[:2], housing_v0=start[2], samples_per_period=0)
        ends = np.array([float(motion[name]) for name in ENDS])
        inwards = 1e-9 if start[0] < exciter.delta else -1e-9
        nudged = ends_of(exciter, end, start[0] + inwards, *start[1:])
        growth = max(1.0, np.abs(nudged - ends).max() / 1e-9)
        # a touch of no more than rounding is no impact here, and one in long arithmetic
        if growth > 1e3 or motion.grazing_tau.size:
            continue
        found, housing = HousingReferenceSolver(exciter).run_housing(*start, [Decimal(end)])
        exact = np.array([*found.states[0], *housing[0]], float)
        assert np.abs(ends - exact).max() < 1e-12 * growth + 1e-12, seed
        compared += 1
    assert compared >= 24


def test_random_motions_mirror_and_go_on_from_where_they_are_stopped() -> None:
    for seed in range(100, 150):
        exciter, start = random_motion(seed)
        ends = ends_of(exciter, 12.0, *start)
        mirrored = ends_of(exciter.mirrored(), 12.0, *(-part for part in start))
        assert (ends == -mirrored).all(), seed
        first = ends_of(exciter, 5.0, *start)
        second = ends_of(exciter, 12.0, *first[:3], tau_start=5.0)
        inwards = 1e-9 if start[0] < exciter.delta else -1e-9
        nudged = ends_of(exciter, 12.0, start[0] + inwards, *start[1:])
        growth = max(1.0, np.abs(nudged - ends).max() / 1e-9)
        gap = np.abs(second + np.array([0.0, 0.0, 0.0, first[3]]) - ends).max()
        assert gap < 1e-12 * growth**2 + 1e-11, seed


@pytest.mark.parametrize("i", STEADY)
def test_steady_states_agree_with_the_references(i: int) -> None:
    entry = ENTRIES["steady"][i]
    steady = vp.steady_state(exciter_of(entry))
    names = (*SECTION, "housing_velocity_mean")
    expected = [float(entry[n]) for n in ("x", "v", "housing_velocity", "housing_velocity_mean")]
    assert int(steady.status) == Status.OK
    assert np.abs([float(steady[name]) for name in names] - np.array(expected)).max() < 1e-12
    assert steady.impacts_per_orbit.values.tolist() == entry["impacts"]
    assert steady.floquet_multiplier.shape == (3,)
    assert int(steady.stable) == 1


def test_multipliers_are_those_of_the_return_map() -> None:
    """By central differences of motions over a period of an orbit on which the housing always slides."""
    exciter = exciter_of(ENTRIES["steady"][0])
    steady = vp.steady_state(exciter, outputs=["stability"])
    section = np.array([float(steady[name]) for name in SECTION])
    period, step, columns = 2 * math.pi / exciter.nu, 1e-5, []
    for k in range(3):
        shift = step * np.eye(3)[k]
        ends = [ends_of(exciter, period, *(section + sign * shift))[:3] for sign in (1, -1)]
        columns.append((ends[0] - ends[1]) / (2 * step))
    expected = np.linalg.eigvals(np.column_stack(columns))
    found = steady.floquet_multiplier.values
    assert abs(found.sum() - expected.sum()) < 1e-8
    assert np.abs(np.sort_complex(found) - np.sort_complex(expected)).max() < 1e-7


def test_the_means_are_those_of_the_motion() -> None:
    exciter = exciter_of(ENTRIES["steady"][1])
    steady = vp.steady_state(exciter, outputs=["harmonics", "motion", "poincare"])
    start = [float(steady[name]) for name in SECTION]
    period = 2 * math.pi / exciter.nu
    motion = vp.simulate(
        exciter, period, start[0], start[1], housing_v0=start[2], samples_per_period=4096
    )
    drift = float(motion.housing_displacement_end)
    assert abs(float(steady.housing_velocity_mean) - drift / period) < 1e-13
    # between two samples the speed changes by the largest acceleration, or an impact
    speeds = np.abs(motion.housing_velocity.values)
    assert 0.0 <= float(steady.housing_velocity_max) - speeds.max() < 2e-3
    ends = np.minimum(motion.housing_slip_end.values, period)
    share = (ends - motion.housing_slip_start.values).sum() / period
    assert abs(float(steady.housing_slip_share) - share) < 1e-13
    mean = np.trapezoid(motion.displacement.values, motion.tau.values) / period
    assert abs(float(steady.displacement_mean) - mean) < 1e-6
    first = 2 * np.abs(
        np.trapezoid(
            motion.displacement.values * np.exp(-1j * exciter.nu * motion.tau.values),
            motion.tau.values,
        )
        / period
    )
    assert abs(float(steady.displacement_amplitude[0]) - first) < 1e-6
    sampled = np.interp(steady.phase.values * period, motion.tau, motion.displacement)
    assert np.abs(sampled - steady.displacement.values).max() < 1e-5


@pytest.mark.parametrize("i", MOTIONS)
def test_energy_balances_in_motions(i: int) -> None:
    entry = ENTRIES["motions"][i]
    exciter = vp.Exciter(**{**vars(exciter_of(entry)), "load": 0.05, "friction": 0.03})
    motion = vp.simulate(
        exciter, 25.0, 0.1, 0.4, housing_v0=-0.2, samples_per_period=0, energy=True
    )
    assert abs(float(motion.energy_residual)) < 1e-12
    assert float(motion.energy_housing_friction) > 0.01


def test_energy_balances_in_steady_states_and_without_an_orbit() -> None:
    for entry in ENTRIES["steady"]:
        steady = vp.steady_state(exciter_of(entry))
        assert abs(float(steady.energy_residual)) < 1e-13
        assert float(steady.energy_housing_friction) > 1e-3
    chaotic = vp.Exciter(
        l=0.3, nu=0.77, f=1.4, h=0.02, delta=0.1, R1=0.95, R2=0.9, mass_ratio=0.1,
        housing_friction_1=0.7, housing_friction_2=0.6, housing_load=0.1,
    )  # fmt: skip
    steady = vp.steady_state(chaotic, outputs=["energy"])
    assert int(steady.period_multiple) == 0
    assert int(steady.window_periods) > 0
    assert abs(float(steady.energy_residual)) < 1e-12
    assert abs(float(steady.energy_change)) > 1e-6


def test_a_symmetric_orbit_does_not_progress() -> None:
    steady = vp.steady_state(SYMMETRIC)
    assert steady.impacts_per_orbit.values.tolist() == [1.0, 1.0]
    assert abs(float(steady.housing_velocity_mean)) < 1e-14
    assert float(steady.housing_slip_share) > 0.1


def test_a_housing_that_turns_at_impacts_alone_keeps_a_shift_of_its_velocity() -> None:
    """A mirror-symmetric exciter may so progress, on orbits that differ by the velocity of the housing alone."""
    exciter = vp.Exciter(
        nu=1.3, f=0.8, h=0.1, l=0.5, R1=0.6, R2=0.6,
        mass_ratio=0.6, housing_friction_1=0.15, housing_friction_2=0.15,
    )  # fmt: skip
    steady = vp.steady_state(exciter, outputs=["stability"])
    assert abs(complex(steady.floquet_multiplier[0]) - 1.0) < 1e-9
    assert not bool(steady.stable)
    section = np.array([float(steady[name]) for name in SECTION])
    span = 20 * 2 * math.pi / exciter.nu
    for shift in (0.0, 0.02):
        start = section + np.array([0.0, 0.0, shift])
        end = ends_of(exciter, span, *start)
        assert np.abs(end[:3] - start).max() < 1e-12
        assert abs(end[3] / span - float(steady.housing_velocity_mean) - shift) < 1e-12


def test_mirrored_exciters_progress_the_other_way() -> None:
    over = {"nu": np.linspace(1.5, 2.5, 5)}
    sweep = vp.sweep(FORCED, over=over, outputs=["stability"])
    mirrored = vp.sweep(FORCED.mirrored(), over=over, outputs=["stability"])
    assert (sweep.period_multiple > 0).sum() >= 4
    progress = sweep.housing_velocity_mean.values
    assert (np.abs(progress) > 1e-3).any()
    assert np.abs(progress + mirrored.housing_velocity_mean.values).max() < 1e-12


def test_a_mass_that_repeats_while_friction_slows_the_housing_is_no_orbit_yet() -> None:
    """The velocity of the housing settles evenly, over 200 periods, long after the section of the mass."""
    climbing = vp.Exciter(
        l=0.003, nu=1.414, f=0.002563, h=0.1, delta=0.000553, R1=0.6, R2=0.6, load=-2.1368e-5,
        mass_ratio=0.4, housing_friction_1=1.875e-4, housing_friction_2=2.5e-4,
        housing_load=-5.3419e-5,
    )  # fmt: skip
    steady = vp.steady_state(climbing, outputs=["stability"])
    motion = vp.simulate(
        climbing, 300 * climbing.period, 0.0, 0.0, housing_v0=0.0, samples_per_period=1
    )
    velocity = motion.housing_velocity.values
    assert abs(velocity[60] - velocity[61]) > 1e-4 * np.ptp(motion.displacement.values)
    last = velocity[-1]
    assert abs(float(steady.housing_velocity_strobe) - last) < 1e-10
    settled = int(np.flatnonzero(np.abs(velocity - last) > 1e-4 * np.abs(velocity).max())[-1])
    # orbits that failed to close before held this up until period 2,241
    assert int(steady.periods_to_settle) < settled + 200
    assert int(steady.period_multiple) == 1


def test_the_mean_friction_of_a_housing_that_always_slides_is_its_load() -> None:
    exciter = exciter_of(ENTRIES["steady"][0])
    exciter = vp.Exciter(**{**vars(exciter), "housing_load": 0.05, "load": -0.02})
    steady = vp.steady_state(exciter, outputs=[])
    assert abs(float(steady.housing_slip_share) - 1.0) < 1e-14
    x, v, velocity = (float(steady[name]) for name in SECTION)
    length = 2 * math.pi / exciter.nu * int(steady.period_multiple)
    motion = vp.simulate(exciter, length, x, v, housing_v0=velocity, samples_per_period=0)
    spans = np.minimum(motion.housing_slip_end, length) - motion.housing_slip_start
    up = motion.housing_slip_direction > 0
    friction = np.where(up, exciter.housing_friction_1, -exciter.housing_friction_2)
    assert abs(float((spans * friction).sum()) / length - 0.03) < 1e-13


def test_units_are_those_of_both_masses_and_the_ground() -> None:
    exciter = vp.Exciter.from_physical(
        m="0.2 kg", M="0.5 kg", C="8 N/mm", H="4 N s/m", l="3 mm", F="20 N", omega="40 Hz",
        D1="1.5 N", D2="4 N", P="0.3 N", R1=0.6, R2=0.6,
    )  # fmt: skip
    assert exciter.mass_ratio == 0.4
    assert (exciter.housing_friction_1, exciter.housing_friction_2) == (1.5 / 8e3, 4.0 / 8e3)
    assert exciter.housing_load == 0.3 / 8e3
    sweep = vp.sweep(exciter, {"mass_ratio": [0.2, 0.4]}, outputs=[])
    si = vp.to_physical(sweep, exciter)
    assert si.M.values.tolist() == [1.0, 0.5]
    assert si.M.attrs["units"] == "kg"
    assert (float(si.D1), float(si.D2), float(si.P)) == (1.5, 4.0, 0.3)
    speed = math.sqrt(8e3 / 0.2)
    expected = sweep.housing_velocity_mean.values * speed
    assert np.allclose(si.housing_velocity_mean.values, expected, rtol=1e-15)
    assert si.housing_velocity_mean.attrs["units"] == "m s-1"
    with pytest.raises(vp.ParameterError, match="D1: must be left out without M"):
        vp.Exciter.from_physical(m=1, C=1e3, l=1, D1="1 N")
    with pytest.raises(vp.ParameterError, match="M: must be a finite number > 0"):
        vp.Exciter.from_physical(m=1, C=1e3, l=1, M=0)


def test_without_a_housing_its_parameters_are_refused_in_words() -> None:
    for name in ("housing_friction_1", "housing_friction_2", "housing_load"):
        with pytest.raises(vp.ParameterError, match=f"{name}: must be 0 where mass_ratio = 0"):
            vp.Exciter(l=1.0, **{name: 0.1})
    with pytest.raises(vp.ParameterError, match="housing_v0: must be 0 where mass_ratio = 0"):
        vp.simulate(vp.Exciter(l=1.0), 1.0, housing_v0=0.1)
    with pytest.raises(vp.ParameterError, match="housing_v0: must be a finite number, got inf"):
        vp.simulate(FORCED, 1.0, housing_v0=math.inf)


@pytest.mark.parametrize(
    ("call", "name"),
    [
        (lambda: vp.simulate(FORCED, 1.0, accuracy=1e-6), "accuracy"),
        (lambda: vp.steady_state(FORCED, accuracy=1e-6), "accuracy"),
        (lambda: vp.basins(FORCED, [0.0], [0.0], phase=0.5), "phase"),
        (lambda: vp.basins(FORCED, [0.0], [0.0], over={"nu": [1.0, 2.0]}), "over"),
        (lambda: vp.symmetric_orbit(SYMMETRIC), "mass_ratio"),
        (lambda: vp.amplitude_frequency(FORCED, [1.0]), "mass_ratio"),
    ],
)
def test_calls_that_do_not_compute_it_refuse_it_in_words(call: Any, name: str) -> None:
    with pytest.raises(vp.ParameterError, match=f"{name}: must .*(housing|not computed)"):
        call()


@pytest.mark.parametrize(
    ("half", "nu", "f", "mass_ratio", "friction"),
    [(0.673, 1.3027, 0.8389, 0.36983, 0.0273662), (0.691815309676105, 1.906018512569363, 0.7433221455448814,
     1.6796273485804865, 0.0379646016953393), (0.7, 1.7, 1.0, 0.8, 0.003)],
)  # fmt: skip
def test_a_housing_that_turns_at_impacts_alone_is_neutral(half, nu, f, mass_ratio, friction):
    # Friction takes as much from a perturbation one way as it gives the other way: a multiplier is 1.
    exciter = vp.Exciter(
        l=half, nu=nu, f=f, h=0.1, R1=0.6, R2=0.6, mass_ratio=mass_ratio,
        housing_friction_1=friction, housing_friction_2=friction,
    )  # fmt: skip
    row = vp.steady_state(exciter)
    assert int(row.period_multiple) > 0
    assert np.abs(row.floquet_multiplier.values).max() == pytest.approx(1.0, abs=1e-12)
    assert int(row.stable) == 0
    assert 0.0 < float(row.housing_slip_share) <= 1.0


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_housing_that_is_pushed_against_all_friction_is_unbounded(sign: float) -> None:
    # By the law of momentum: of both bodies it grows by at least force less friction, 0.3 - 0.1, in a unit of time.
    exciter = dataclasses.replace(
        FORCED, housing_load=sign * 0.3, housing_friction_1=0.1, housing_friction_2=0.1
    )
    state = vp.steady_state(exciter)
    assert str(state.regime.attrs["flag_meanings"]).split()[int(state.regime)] == "unbounded"
    assert np.isnan(state.housing_velocity_mean)
    assert np.isnan(state.housing_velocity_max)
    share = exciter.mass_ratio / (1.0 + exciter.mass_ratio)
    # the velocity of the housing within a period differs from that of both bodies by the share of the mass
    _x, v, u = ends_of(exciter, 500.0)[:3]
    assert sign * (u + share * v) == pytest.approx(share * 0.2 * 500.0, rel=0.02)


def test_a_housing_that_friction_holds_on_average_is_bounded() -> None:
    state = vp.steady_state(dataclasses.replace(FORCED, housing_load=0.09))
    assert str(state.regime.attrs["flag_meanings"]).split()[int(state.regime)] != "unbounded"
