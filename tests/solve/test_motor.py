"""Speeds that a motor of limited power keeps, against closed forms and against the motor's own equation of motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.polynomial import Polynomial
from scipy.integrate import solve_ivp

import vibropipe as vp

OUTPUTS = ["stability", "power", "sensitivity"]
H, F = 0.1, 0.3
STALL, NO_LOAD = 0.55, 2.2
MOTOR = {"no_load": NO_LOAD, "stall": STALL}


@pytest.fixture(scope="module")
def linear():
    """Return the branch of a motion that strikes no support."""
    return vp.branch(vp.Exciter(nu=0.6, h=H, f=F, l=50.0), "nu", (0.2, 2.9), outputs=OUTPUTS)


def real_roots(polynomial):
    return sorted(z.real for z in polynomial.roots() if abs(z.imag) < 1e-9 and 0.2 < z.real < 2.9)


NU = Polynomial([0.0, 1.0])
DENOMINATOR = (1 - NU**2) ** 2 + H**2 * NU**2
LINE = STALL * (1 - NU / NO_LOAD)


def linear_torque(nu):
    return H * nu * F**2 / 2 / DENOMINATOR(nu)


def test_speeds_without_impacts_are_roots_of_a_polynomial(linear):
    found = vp.motor(linear, MOTOR)
    roots = real_roots(LINE * DENOMINATOR - H * F**2 / 2 * NU)
    assert len(roots) == 3
    np.testing.assert_allclose(found.nu, roots, rtol=0, atol=1e-11)
    np.testing.assert_allclose(found.motor_torque, LINE(found.nu.values), rtol=1e-11)
    assert found.speed_is_stable.values.tolist() == [1, 0, 1]
    assert found.stable.values.tolist() == [1, 1, 1]


def test_sommerfeld_jumps_are_at_tangencies(linear):
    found = vp.motor(linear, MOTOR)
    slope = H * F**2 / 2 * (DENOMINATOR - NU * DENOMINATOR.deriv())
    tangent = np.array(real_roots(slope + STALL / NO_LOAD * DENOMINATOR**2))
    added = linear_torque(tangent) - LINE(tangent)
    np.testing.assert_allclose(found.jump_nu, tangent[::-1], rtol=0, atol=1e-9)
    np.testing.assert_allclose(found.jump_torque, added[::-1], rtol=0, atol=1e-12)
    assert found.jump_way.values.tolist() == [0, 1]
    for torque, way, lost, to in zip(
        *(found[name].values for name in ("jump_torque", "jump_way", "jump_nu", "jump_to_nu")),
        strict=True,
    ):
        ends = real_roots((LINE + torque) * DENOMINATOR - H * F**2 / 2 * NU)
        expected = [root for root in ends if abs(root - lost) > 1e-3]
        np.testing.assert_allclose([to], expected, rtol=0, atol=1e-9)
        assert (to > lost) == bool(way)


def test_a_speed_past_the_range_is_not_known():
    branch = vp.branch(vp.Exciter(nu=0.6, h=H, f=F, l=50.0), "nu", (0.2, 2.5), outputs=OUTPUTS)
    assert np.isnan(vp.motor(branch, MOTOR).jump_to_nu.values[1])


def test_an_unbalanced_rotor_takes_a_torque_that_grows_with_its_force():
    unbalance = 0.2
    exciter = vp.Exciter(nu=0.6, h=H, shaker=unbalance, l=50.0)
    branch = vp.branch(exciter, "nu", (0.2, 2.9), outputs=OUTPUTS)
    found = vp.motor(branch, {"no_load": 2.2, "stall": 1.5})
    # f = u nu^2 in the torque of the motion without impacts
    line = 1.5 * (1 - NU / 2.2)
    roots = real_roots(line * DENOMINATOR - H * unbalance**2 / 2 * NU**5)
    np.testing.assert_allclose(found.nu, roots, rtol=0, atol=1e-10)
    load = H * unbalance**2 / 2 * NU**5
    slope = (load.deriv() * DENOMINATOR - load * DENOMINATOR.deriv()) + 1.5 / 2.2 * DENOMINATOR**2
    np.testing.assert_allclose(np.sort(found.jump_nu), real_roots(slope), rtol=0, atol=1e-8)


@pytest.mark.parametrize("torque", [[(1.16, 0.2), (1.3, 0.05)], {"no_load": 1.5, "stall": 0.8}])
def test_mirror_images_are_listed_once(torque):
    exciter = vp.Exciter(l=0.5, nu=1.0, f=1.0, h=0.2, R1=0.7, R2=0.7)
    branch = vp.branch(exciter, "nu", (0.8, 2.0), switch=["pitchfork"], outputs=OUTPUTS)
    found = vp.motor(branch, torque)
    ids, ends = branch.branch_id.values, branch.bifurcation_point.values
    assert set(ids.tolist()) == {0, 1, 2}
    alone = branch.isel(point=ids < 2, bifurcation=ids[ends] < 2)  # without one of both
    one = vp.motor(alone, torque)
    assert 1 in one.branch_id
    for name in ("nu", "branch_id", "speed_is_stable", "jump_nu", "jump_to_nu", "jump_torque"):
        np.testing.assert_allclose(found[name], one[name], rtol=1e-9)


def test_orbits_that_begin_at_a_bifurcation_may_keep_the_speed():
    exciter = vp.Exciter(l=0.5, nu=1.0, f=1.0, h=0.2, R1=0.7, R2=0.7)
    torque = {"no_load": 1.5, "stall": 0.8}
    branches = [
        vp.branch(exciter, "nu", (0.8, 2.0), switch=switch, outputs=OUTPUTS)
        for switch in ([], ["pitchfork"])
    ]
    alone, both = (vp.motor(branch, torque) for branch in branches)
    pitchfork = branches[0].bifurcation_nu.values[1]
    np.testing.assert_array_equal(alone.jump_nu.values[1], pitchfork)
    assert np.isnan(alone.jump_to_nu.values[1])
    assert not np.isclose(both.jump_nu, pitchfork).any()  # the two orbits that begin there keep it


def test_a_speed_that_hunts_is_kept_nowhere():
    exciter = vp.Exciter(l=0.5, nu=0.8, f=0.7, h=0.1, delta=0.1, R1=0.6, R2=0.7)
    branch = vp.branch(exciter, "nu", (0.5, 2.0), switch=["grazing"], outputs=OUTPUTS)
    for stall in (0.2, 0.4):
        found = vp.motor(branch, {"no_load": 2.5, "stall": stall})
        assert not np.isclose(found.jump_to_nu, found.jump_nu).any()


@pytest.mark.slow
def test_unstable_orbits_that_cannot_be_followed_are_left_out():
    exciter = vp.Exciter(l=0.5, nu=0.8, f=0.7, h=0.1, delta=0.1, R1=0.6, R2=0.7)
    branch = vp.branch(exciter, "nu", (0.5, 2.0), switch=["flip", "grazing"], outputs=OUTPUTS)
    found = vp.motor(branch, {"no_load": 2.5, "stall": 0.4})
    for n in np.flatnonzero(found.speed_is_stable):
        speed = float(found.nu[n])
        row = branch.isel(point=int(found.crossing_point[n]))
        start = [float(row[name]) for name in ("displacement_strobe", "velocity_strobe")]
        at = vp.Exciter(**{**vars(exciter), "nu": speed})
        orbit = vp.steady_state(at, *start, outputs=["power"])
        assert float(orbit.power_input) / speed == pytest.approx(0.4 * (1 - speed / 2.5), rel=1e-6)


def test_points_of_torque_are_joined_by_lines(linear):
    points = [(0.5, 0.4), (0.7, 0.3), (1.02, 0.4), (1.5, 0.002)]
    found = vp.motor(linear, points)
    speeds = np.linspace(0.5, 1.5, 200_001)
    excess = linear_torque(speeds) - np.interp(speeds, *np.transpose(points))
    at = np.flatnonzero(excess[:-1] * excess[1:] < 0)
    np.testing.assert_allclose(found.nu, speeds[at], rtol=0, atol=1e-5)
    assert found.speed_is_stable.values.tolist() == [int(excess[i + 1] > excess[i]) for i in at]
    np.testing.assert_allclose(
        found.motor_torque, np.interp(found.nu, *np.transpose(points)), rtol=1e-10
    )
    assert vp.motor(linear, [(1.8, 5.0), (2.5, 4.0)]).sizes["crossing"] == 0


def test_with_units():
    exciter = vp.Exciter.from_physical(
        m="2 kg", C="8 N/mm", H="12 N s/m", F="60 N", l="100 mm", omega="50 rad/s"
    )
    branch = vp.branch(exciter, "omega", ("30 rad/s", "120 rad/s"), outputs=OUTPUTS)
    found = vp.motor(branch, {"no_load": "18 Hz", "stall": "4 N m"})
    w = found.omega.values
    power = 12.0 * (60.0 * w) ** 2 / 2 / ((8e3 - 2 * w**2) ** 2 + (12 * w) ** 2)
    np.testing.assert_allclose(found.motor_torque, power / w, rtol=1e-10)
    np.testing.assert_allclose(4 * (1 - w / (36 * np.pi)), power / w, rtol=1e-9)
    assert found.motor_torque.units == "N m"
    assert found.jump_omega.units == found.jump_to_omega.units == "rad s-1"
    bare = vp.motor(branch, {"no_load": 36 * np.pi, "stall": 4.0})
    np.testing.assert_array_equal(found.jump_torque, bare.jump_torque)
    with pytest.raises(vp.ParameterError, match=r"torque\.stall"):
        vp.motor(branch, {"no_load": "18 Hz", "stall": "4 kg"})


def test_orbits_that_begin_within_a_contact_with_a_soft_support_are_followed():
    soft = vp.Exciter(l=0.5, nu=1.6, f=0.6, h=0.1, delta=-0.05, k1=20.0, k2=15.0, R1=0.6, R2=0.5)
    branch = vp.branch(soft, "nu", (1.55, 2.0), outputs=OUTPUTS)
    assert (branch.displacement_strobe.values < soft.lower).sum() > 5
    found = vp.motor(branch, [(1.6, 0.25), (1.95, 0.17)])
    (n,) = np.flatnonzero(found.speed_is_stable)
    nu, torque = float(found.nu[n]), float(found.motor_torque[n])
    assert torque == pytest.approx(np.interp(nu, (1.6, 1.95), (0.25, 0.17)), rel=1e-9)
    row = branch.isel(point=int(found.crossing_point[n]))
    start = {"x0": float(row.displacement_strobe), "v0": float(row.velocity_strobe)}
    assert start["x0"] < soft.lower
    state = vp.steady_state(replace(soft, nu=nu), **start, outputs=("power",))
    assert float(state.power_input) / nu == pytest.approx(torque, rel=1e-6)


def test_with_impacts_the_motor_runs_to_the_speed_found():
    exciter = vp.Exciter(nu=1.5, h=0.1, f=0.5, l=1.0, delta=0.2, R1=0.6, R2=0.6)
    branch = vp.branch(exciter, "nu", (1.3, 2.0), v0=2.0, outputs=OUTPUTS)
    found = vp.motor(branch, {"no_load": 3.0, "stall": 0.4})
    assert found.impacts_per_period.values.tolist() == [[1.0, 1.0]] * 2
    assert found.speed_is_stable.values.tolist() == [1, 0]
    speed = float(found.nu[0])
    at = vp.Exciter(**{**vars(exciter), "nu": speed})
    orbit = vp.steady_state(at, v0=2.0, outputs=["power"])
    assert abs(float(orbit.power_input) / speed - 0.4 * (1 - speed / 3)) < 1e-9
    stable = branch.isel(point=branch.stable.values == 1)
    for near in (1.5, 1.7):
        row = stable.isel(point=int(np.argmin(abs(stable.nu.values - near))))
        start = [float(row[name]) for name in ("displacement_strobe", "velocity_strobe", "nu")]
        assert run_of_motor(exciter, 0.4, 3.0, *start) == pytest.approx(speed, abs=4e-3)


def run_of_motor(exciter, stall, no_load, x, v, speed, inertia=50.0, end=1000.0):
    """Return the mean speed at the end of a run of the exciter with its motor, whose speed is free."""

    def rates(_tau, y):
        x, v, phase, w = y
        force = exciter.f * np.sin(phase)
        torque = stall * (1 - w / no_load) - force * v / w
        return [v, force - exciter.h * v - x, w, torque / inertia]

    def above(_tau, y):
        return y[0] - exciter.upper

    def below(_tau, y):
        return y[0] - exciter.lower

    above.terminal = below.terminal = True
    above.direction, below.direction = 1, -1
    y, tau, taus, speeds = np.array([x, v, 0.0, speed]), 0.0, [], []
    while tau < end:
        run = solve_ivp(
            rates, (tau, end), y, events=[above, below], rtol=1e-7, atol=1e-9, max_step=1.0
        )
        tau, y = run.t[-1], run.y[:, -1].copy()
        y[1] *= -exciter.R1
        taus.append(run.t)
        speeds.append(run.y[3])
    tau, w = np.concatenate(taus), np.concatenate(speeds)
    late = tau > 0.8 * end
    return np.trapezoid(w[late], tau[late]) / np.ptp(tau[late])


@pytest.mark.parametrize(
    ("torque", "says"),
    [
        ({"stall": 1.0}, "no_load: speed"),
        ({"no_load": 2.0, "stall": 0.0}, "torque.stall: must be above 0"),
        ({"no_load": 2.0, "stall": "1 N m"}, "has no units"),
        ([(1.0, 2.0)], "two or more pairs"),
        ([(1.0, 2.0), (1.0, 3.0)], "increasing speed"),
        ("fast", "two or more pairs"),
        (3.0, "two or more pairs"),
    ],
)
def test_bad_torques_are_refused(linear, torque, says):
    with pytest.raises(vp.ParameterError, match=says):
        vp.motor(linear, torque)


def test_other_datasets_are_refused(linear):
    exciter = vp.Exciter(nu=0.6, h=H, f=F, l=50.0)
    with pytest.raises(vp.ParameterError, match=r"vp\.branch along nu"):
        vp.motor(vp.steady_state(exciter), MOTOR)
    with pytest.raises(vp.ParameterError, match="along nu"):
        vp.motor(vp.branch(exciter, "f", (0.2, 0.4), outputs=OUTPUTS), MOTOR)
    with pytest.raises(vp.ParameterError, match="without power_input_sensitivity"):
        vp.motor(linear.drop_vars("power_input_sensitivity"), MOTOR)


@pytest.mark.slow
def test_an_unbalanced_rotor_passes_orbits_beside_a_grazing() -> None:
    """Where the derivative of the torque is not known, its extreme is sought by the torque itself."""
    rotor = vp.Exciter.from_physical(
        m="0.5 kg", C="5 N/mm", H="5 N s/m", l="4 mm", m_e="50 g", e="10 mm", omega="16 Hz", R1=0.75, R2=0.75
    )  # fmt: skip
    found = vp.branch(
        rotor, "omega", ("6 Hz", "45 Hz"), switch=("grazing",), outputs=("stability", "power", "sensitivity"),
    )  # fmt: skip
    speeds = 2 * np.pi * np.array([5.0, 20.0, 30.0])
    motor = vp.motor(found, [*zip(speeds, (0.2, 0.1, 0.0), strict=True)])
    assert motor.sizes["crossing"] > 0
    load = motor.power_input / motor.omega
    np.testing.assert_allclose(load, motor.motor_torque, rtol=1e-8, atol=1e-12)
