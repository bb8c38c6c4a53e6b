"""Power, and what reaches frame and supports, beside an independent integration, momentum balances and closed forms."""

from __future__ import annotations

import functools
import itertools
from typing import Any, NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import vibropipe as vp
from vibropipe.solve.rows.power import largest_drive_force
from vibropipe.solve.rows.row_results import new_rows

OUTPUTS = ("harmonics", "impacts", "stability", "energy", "power", "frame")
BASE = {"l": 0.5, "nu": 1.0, "f": -1.0, "h": 0.2, "delta": 0.01, "R1": 0.7, "R2": 0.7}
# by what their orbits are made of
CASES: dict[str, dict[str, float]] = {
    "rigid": {"load": 0.05},
    "rest": {"R1": 0.2, "R2": 0.2, "nu": 0.5, "load": 0.1},
    "soft": {"k1": 400, "h1": 4, "k2": 300, "h2": 4, "R1": 1, "R2": 1, "load": 0.05},
    "one_soft": {"R2": 1, "k2": 30, "h2": 1, "delta": 0.05},
    "turns": {"friction": 0.05, "f": 0.4, "nu": 2.0, "load": -0.03},
    "sticks": {"friction": 0.35, "nu": 0.6, "f": 0.7, "h": 0.05},
    "free": {"l": 9.0, "load": 0.05, "f2": 0.2, "phi2": 1.0},
}
SHARES = np.linspace(0.0, 1.0, 4001)


def exciter(case: str) -> vp.Exciter:
    return vp.Exciter(**(BASE | CASES[case]))


@functools.cache
def orbit(case: str) -> Any:
    return vp.steady_state(exciter(case), outputs=OUTPUTS)


class Forces(NamedTuple):
    """Forces on the frame and on the supports, and that of the drive, at (tau, x, v) or over arrays of them."""

    frame: Any
    supports: tuple[Any, Any]
    drive: Any


def forces(x: vp.Exciter, tau: Any, at: Any, v: Any, slides: float) -> Forces:
    """The force of each part on the frame, one by one; slides : the sign of the velocity."""
    beyond = at - (x.l + x.delta), (x.delta - x.l) - at
    supports = (
        (x.k1 * beyond[0] + x.h1 * v) * (x.k1 > 0) * (beyond[0] > 0),
        (x.k2 * beyond[1] - x.h2 * v) * (x.k2 > 0) * (beyond[1] > 0),
    )
    drive = x.f * np.sin(x.nu * tau) + x.f2 * np.sin(2 * x.nu * tau + x.phi2)
    frame = at + x.h * v + supports[0] - supports[1] + x.friction * slides - drive
    return Forces(frame, supports, drive)


def wave(x: vp.Exciter, k: int, tau: float) -> complex:
    """The integral of exp(-i k nu tau)."""
    return complex(np.exp(-1j * k * x.nu * tau) / (-1j * k * x.nu))


@functools.cache
def integrated(case: str) -> dict[str, Any]:
    """The same quantities, integrated by DOP853 between the events of the orbit."""
    x, steady = exciter(case), orbit(case)
    span = x.period * int(steady.period_multiple)
    start = float(steady.displacement_strobe), float(steady.velocity_strobe)
    motion = vp.simulate(x, tau_end=span, x0=start[0], v0=start[1], samples_per_period=0)
    events = {0.0, span}
    for name in ("impact_tau", "rest_start", "rest_end", "turn_tau", "stick_start", "stick_end"):
        if name in motion:
            events |= {float(tau) for tau in motion[name].values}
    if "contact_duration" in motion:
        events |= {float(tau) for tau in (motion.impact_tau + motion.contact_duration).values}
    cuts = sorted(tau for tau in events if 0.0 <= tau <= span)
    sums, largest_power, largest_force = np.zeros(9), 0.0, 0.0
    held = [
        (a, b)
        for name in ("rest", "stick")
        if f"{name}_start" in motion
        for a, b in zip(motion[f"{name}_start"].values, motion[f"{name}_end"].values, strict=True)
    ]
    for begin, end in itertools.pairwise(cuts):
        middle = 0.5 * (begin + end)
        if any(a <= middle <= b for a, b in held):
            sums[:2] += (end - begin) * np.array([x.load, x.load**2])
            waves = [x.load * (wave(x, k, end) - wave(x, k, begin)) for k in (1, 2)]
            sums[5:] += np.array([part for each in waves for part in (each.real, each.imag)])
            largest_force = max(largest_force, abs(x.load))
            continue
        if end - begin < 1e-9:
            continue
        state = vp.simulate(
            x, tau_end=begin + 1e-3 * (end - begin), x0=start[0], v0=start[1], samples_per_period=0
        )
        at, v = float(state.displacement_end), float(state.velocity_end)
        slides = np.sign(v)

        def rates(tau: float, y: np.ndarray, slides: float = slides) -> list[float]:
            now = forces(x, tau, y[0], y[1], slides)
            a = x.load - now.frame
            turned = [now.frame * np.exp(-1j * k * x.nu * tau) for k in (1, 2)]
            waves = [part for each in turned for part in (each.real, each.imag)]
            return [y[1], a, now.frame, now.frame**2, *now.supports, now.drive * y[1], *waves]

        for stop in (begin, end):
            solved = solve_ivp(
                rates, (begin + 1e-3 * (end - begin), stop), [at, v, *np.zeros(9)],
                method="DOP853", rtol=1e-12, atol=1e-13, dense_output=True,
            )  # fmt: skip
            sums += (1.0 if stop == end else -1.0) * solved.y[2:, -1]
            tau = solved.t[0] + (stop - solved.t[0]) * SHARES
            y = solved.sol(tau)
            now = forces(x, tau, y[0], y[1], slides)
            largest_power = max(largest_power, np.max(now.drive * y[1]))
            largest_force = max(largest_force, np.abs(now.frame).max())
    mean, square, one, two, work = sums[:5] / span
    waves = 2 * (sums[5::2] + 1j * sums[6::2])
    for support, tau, impulse in zip(
        steady.impact_support.values,
        (steady.impact_period + steady.impact_phase).values * x.period,
        steady.impact_impulse.values,
        strict=True,
    ):
        if (x.k1, x.k2)[support - 1] == 0:
            towards = 1 if support == 1 else -1
            waves += 2 * towards * impulse * np.exp(-1j * np.array([1, 2]) * x.nu * tau)
    return {
        "frame_force_mean": mean,
        "frame_force_rms": np.sqrt(square),
        "frame_force_max": largest_force,
        "soft_impulses": np.array([one, two]) * x.period,
        "power_input": work,
        "power_input_max": largest_power,
        "amplitudes": np.abs(waves) / span,
    }


@pytest.mark.parametrize("case", CASES)
def test_forces_and_powers_are_those_of_an_independent_integration(case: str) -> None:
    row, known = orbit(case), integrated(case)
    assert int(row.period_multiple) > 0
    for name in ("frame_force_mean", "frame_force_rms", "power_input"):
        assert float(row[name]) == pytest.approx(known[name], abs=1e-9), name
    # the twin looks at 4,001 instants between events
    for name in ("frame_force_max", "power_input_max"):
        assert known[name] - 1e-9 <= float(row[name]) <= known[name] * (1 + 1e-6) + 1e-9, name
    x = exciter(case)
    if not row.rests_per_orbit.any():  # the tail of a chatter is not listed
        found = row.frame_force_amplitude.values[:2]
        assert np.allclose(found, known["amplitudes"], rtol=0, atol=1e-9)
    for side, k in enumerate((x.k1, x.k2)):
        if k > 0:
            taken = float(row.impulse_per_period[side])
            assert taken == pytest.approx(known["soft_impulses"][side], abs=1e-9)


@pytest.mark.parametrize("case", CASES)
def test_momentum_balances(case: str) -> None:
    # what the frame takes over an orbit is what acts on the mass from outside: the load
    x, row = exciter(case), orbit(case)
    impulses = row.impulse_per_period.values
    rigid = impulses * [x.k1 == 0, x.k2 == 0]
    total = float(row.frame_force_mean) + (rigid[0] - rigid[1]) / x.period
    assert total == pytest.approx(x.load, abs=1e-13)
    if x.friction == 0 and not row.rests_per_orbit.any():
        # spring and supports alone hold the load
        held = float(row.displacement_mean) + (impulses[0] - impulses[1]) / x.period
        assert held == pytest.approx(x.load, abs=1e-12)
    listed = [row.impact_impulse.values[row.impact_support.values == side].sum() for side in (1, 2)]
    if not row.rests_per_orbit.any():  # the tail of a chatter is not listed
        assert np.allclose(listed, int(row.period_multiple) * impulses, rtol=1e-11, atol=1e-14)


@pytest.mark.parametrize("case", CASES)
def test_powers_balance_and_are_energies_per_time(case: str) -> None:
    x, row = exciter(case), orbit(case)
    lost = float(row.power_damping) + float(row.power_impact.sum())
    if x.friction > 0:
        lost += float(row.power_friction)
    assert float(row.power_input) == pytest.approx(lost, abs=1e-14)
    assert float(row.power_residual) == pytest.approx(0.0, abs=1e-14)
    assert float(row.power_input) == pytest.approx(float(row.energy_input) / x.period, rel=1e-15)


@pytest.mark.parametrize("further", [{}, {"k1": 300.0, "h1": 6.0, "R1": 1.0}, {"friction": 0.001}])
def test_powers_without_an_orbit_balance_with_what_is_stored(further: dict[str, float]) -> None:
    x = vp.Exciter(**({"l": 0.5, "nu": 1.2, "f": 1.4, "h": 0.05, "R1": 0.6, "R2": 0.6} | further))
    row = vp.sweep(x, {"nu": [x.nu]}, outputs=("energy", "power", "frame", "impacts")).isel(nu=0)
    assert int(row.period_multiple) == 0
    assert int(row.window_periods) > 0
    lost = float(row.power_damping) + float(row.power_impact.sum()) + float(row.power_change)
    if x.friction > 0:
        lost += float(row.power_friction)
    assert float(row.power_change) != 0.0
    assert float(row.power_input) == pytest.approx(lost, abs=1e-12)
    # the window is long beside what the momentum changes over it
    rigid = row.impulse_per_period.values * [x.k1 == 0, x.k2 == 0]
    total = float(row.frame_force_mean) + (rigid[0] - rigid[1]) / x.period
    change = 4.0 * float(row.impact_velocity_max.max()) / (int(row.window_periods) * x.period)
    assert abs(total - x.load) < change


def test_a_conservative_orbit_passes_momentum_on_and_no_power() -> None:
    x = vp.Exciter(l=0.5, delta=0.2, load=0.1)
    row = vp.steady_state(x, x0=0.1, v0=1.5, outputs=OUTPUTS)
    period = 2 * np.pi / float(row.base_frequency)
    speeds = row.impact_velocity_max.values
    assert np.allclose(row.impulse_per_period, 2 * speeds, rtol=1e-14)
    total = float(row.frame_force_mean) + (speeds[0] - speeds[1]) * 2 / period
    assert total == pytest.approx(x.load, abs=1e-13)
    # between the supports the spring alone presses on the frame, most where it is longest
    assert float(row.frame_force_max) == pytest.approx(x.l + x.delta, rel=1e-14)
    motion = vp.simulate(x, tau_end=period, x0=0.1, v0=1.5, samples_per_period=20_000)
    square = np.trapezoid(motion.displacement.values**2, motion.tau.values) / period
    assert float(row.frame_force_rms) == pytest.approx(np.sqrt(square), rel=1e-6)
    assert float(row.power_input_max) == 0.0
    assert np.allclose(row.power_struck, 0.5 * speeds**2 / period, rtol=1e-13)


def test_a_motion_without_impacts_has_closed_forms() -> None:
    x, row = exciter("free"), orbit("free")
    k = row.harmonic.values
    squares = 0.5 * (k * x.nu) ** 4 * row.displacement_amplitude.values**2
    rms = np.sqrt(x.load**2 + squares.sum())
    assert float(row.frame_force_rms) == pytest.approx(rms, rel=1e-14)
    assert float(row.frame_force_mean) == pytest.approx(x.load, rel=1e-13)
    tau = np.linspace(0, x.period, 200_001)
    angle = k[:, None] * x.nu * tau
    amplitude, phase = (row[f"displacement_{n}"].values[:, None] for n in ("amplitude", "phase"))
    speed = -(k[:, None] * x.nu * amplitude * np.sin(angle + phase)).sum(axis=0)
    power = (x.f * np.sin(x.nu * tau) + x.f2 * np.sin(2 * x.nu * tau + x.phi2)) * speed
    assert float(row.power_input_max) == pytest.approx(power.max(), rel=1e-8)
    assert float(row.power_input) == pytest.approx(np.trapezoid(power, tau) / x.period, rel=1e-12)


def test_an_undamped_motion_of_several_periods_has_its_forces() -> None:
    x = vp.Exciter(l=5.0, nu=1.5, f=0.2)
    row = vp.steady_state(x, x0=0.3, v0=0.1, outputs=OUTPUTS)
    m = int(row.period_multiple)
    assert m == 3
    motion = vp.simulate(x, tau_end=m * x.period, x0=0.3, v0=0.1, samples_per_period=20_000)
    drive = x.f * np.sin(x.nu * motion.tau)
    force = motion.displacement - drive
    square = np.trapezoid(force.values**2, motion.tau.values) / (m * x.period)
    assert float(row.frame_force_rms) == pytest.approx(np.sqrt(square), rel=1e-8)
    assert float(row.frame_force_max) == pytest.approx(float(abs(force).max()), rel=1e-7)
    largest = float((drive * motion.velocity).max())
    assert float(row.power_input_max) == pytest.approx(largest, rel=1e-7)


@pytest.mark.parametrize("case", ["rigid", "soft"])
def test_wear_and_struck_power_are_sums_over_impacts(case: str) -> None:
    wearing = vp.Exciter(**(BASE | CASES[case]), wear_exponent=2.4)
    row = vp.steady_state(wearing, outputs=OUTPUTS)
    assert (row.impact_velocity.values == orbit(case).impact_velocity.values).all()
    span = wearing.period * int(row.period_multiple)
    for side in (1, 2):
        speeds = abs(row.impact_velocity.values[row.impact_support.values == side])
        rate = float(row.wear_rate.sel(support=side))
        assert rate == pytest.approx((speeds**2.4).sum() / span, rel=1e-13)
        struck = float(row.power_struck.sel(support=side))
        assert struck == pytest.approx(0.5 * (speeds**2).sum() / span, rel=1e-13)
        counted = float(orbit(case).wear_rate.sel(support=side))
        assert counted == pytest.approx(speeds.size / span, rel=1e-13)


def test_units_are_watts_newtons_and_newton_seconds() -> None:
    given = {
        "m": "2 kg",
        "C": "8 N/mm",
        "H": "40 N s/m",
        "F": "120 N",
        "omega": "9 Hz",
        "l": "8 mm",
    }
    x = vp.Exciter.from_physical(**given, R1=0.7, R2=0.7, wear_exponent=1.5)
    row = vp.to_physical(vp.steady_state(x, outputs=OUTPUTS), x)
    units = {"power_input": "W", "frame_force_rms": "N", "impulse_per_period": "N s"}
    assert {name: row[name].attrs["units"] for name in units} == units
    hertz = 9.0
    assert float(row.power_input) == pytest.approx(float(row.energy_input) * hertz, rel=1e-13)
    assert float(row.drive_force_max) == pytest.approx(120.0, rel=1e-13)
    speeds = abs(row.impact_velocity.values)
    struck = row.impact_impulse.values
    assert np.allclose(struck, 2.0 * 1.7 * speeds, rtol=1e-13)
    one = row.impact_support.values == 1
    wear = float(row.wear_rate.sel(support=1))
    rate = (speeds[one] ** 1.5).sum() * hertz / int(row.period_multiple)
    assert wear == pytest.approx(rate, rel=1e-12)


@pytest.mark.parametrize(("f", "f2"), [(1.0, 0.3), (-0.2, 0.5), (0.0, 0.7), (0.4, 0.1), (0.8, 0.2)])
@pytest.mark.parametrize("phi2", [0.0, 0.3, np.pi / 2, 2.0, -np.pi / 2])
def test_the_largest_drive_force_is_that_of_a_fine_grid(f: float, f2: float, phi2: float) -> None:
    u = np.linspace(0, 2 * np.pi, 1_000_001)
    fine = np.abs(f * np.sin(u) + f2 * np.sin(2 * u + phi2)).max()
    columns = {"f": np.array([f]), "f2": np.array([f2]), "phi2": np.array([phi2])}
    assert largest_drive_force(columns)[0] == pytest.approx(fine, rel=1e-11)


@pytest.mark.parametrize("case", ["rigid", "soft", "free"])
def test_points_of_branches_have_them_too(case: str) -> None:
    x = exciter(case)
    branch = vp.branch(x, "nu", (x.nu - 0.02, x.nu + 0.02), outputs=OUTPUTS, at=[x.nu])
    here = np.flatnonzero(branch.nu.values == x.nu)
    assert here.size > 0
    point, row = branch.isel(point=int(here[0])), orbit(case)
    names = ("power_input", "power_impact", "power_input_max", "frame_force_mean")
    for name in (*names, "frame_force_rms", "frame_force_max", "impulse_per_period", "wear_rate"):
        assert np.allclose(point[name], row[name], rtol=1e-9, atol=1e-11), name


@pytest.mark.parametrize("case", ["rigid", "one_soft"])
@pytest.mark.parametrize("parameter", ["nu", "f"])
def test_derivatives_are_differences(case: str, parameter: str) -> None:
    x, step = exciter(case), 1e-5
    row = vp.steady_state(x, outputs=(*OUTPUTS, "sensitivity"))
    value = getattr(x, parameter)
    sides = [
        vp.steady_state(
            vp.Exciter(**(BASE | CASES[case] | {parameter: value + sign * step})), outputs=OUTPUTS
        )
        for sign in (1, -1)
    ]
    for name in ("power_input", "power_damping", "power_impact", "frame_force_amplitude"):
        slope = row[f"{name}_sensitivity"].sel(parameter=parameter)
        difference = (sides[0][name] - sides[1][name]) / (2 * step)
        assert np.allclose(slope, difference, rtol=1e-5, atol=1e-6), name


def test_a_design_takes_powers_and_forces() -> None:
    x = vp.Exciter(l=0.5, nu=1.0, h=0.2, R1=0.7, R2=0.7)
    found = vp.design(
        x, {"f": (0.7, 1.5), "nu": (0.8, 1.2)}, target={"power_input": 0.15},
        subject_to={"frame_force_rms": "< 0.8", "impulse_per_period_1": "> 0.5"}, samples=64,
    )  # fmt: skip
    best = found.isel(design=0)
    assert float(best.power_input) == pytest.approx(0.15, rel=1e-6)
    assert float(best.frame_force_rms) < 0.8
    assert float(best.impulse_per_period.sel(support=1)) > 0.5


def test_forces_cost_nothing_unless_asked() -> None:
    assert new_rows(3, 2, ("energy", "harmonics")).forces.size == 0
    assert new_rows(3, 2, ("power",)).forces.shape[0] == 3
