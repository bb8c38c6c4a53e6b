"""Identification from records of sensors: phase, offset and frequency unknown, samples clipped, mirror images named."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from helpers.sensors import record_by_solve_ivp

import vibropipe as vp
from vibropipe.scenes.identify.pictures import twin_texts
from vibropipe.solve.fit.curve_fit import displacement_at, orbit_curve
from vibropipe.solve.fit.record_model import acceleration
from vibropipe.solve.rows.points import solve_points
from vibropipe.words.designs import FitResult, FoundResult, Twin

TRUE = vp.Exciter(l=0.5, nu=1.0, f=-0.7, h=0.2, delta=0.03, R1=0.75, R2=0.65)
KNOWN = vp.Exciter(l=0.5, f=-0.7, h=0.2)
VARY = {"delta": (-0.1, 0.1), "R1": (0.5, 0.9), "R2": (0.5, 0.9)}
# The 99.9 % quantile of chi-square of 4: nu is found as well.
CHI_SQUARE_4 = 18.5


def distance(found, true=TRUE):
    """Distance from the true parameters in the metric of the covariance: its square is a chi-square."""
    off = [float(found[name]) - getattr(true, str(name)) for name in found.parameter.values]
    return float(np.dot(off, np.linalg.solve(found.parameter_covariance.values, off)))


def identified(record, known=KNOWN, vary=VARY, **given):
    return vp.identify(known, record, vary, **{"samples": 16, **given})


@pytest.mark.parametrize("contact", ["pull", "no_pull"])
def test_accelerations_are_the_rates_of_velocities(contact):
    soft = vp.Exciter(l=0.5, nu=1.0, f=1.0, h=0.1, k1=60.0, h1=5.0, k2=90.0, h2=4.0, load=0.1,
                      contact_1=contact, contact_2=contact)  # fmt: skip
    rows = np.array(soft.parameters())[None]
    solved = solve_points(rows, (None, 0.0), ("impacts", "motion"), 1)
    curve = orbit_curve(solved.variables, rows[0], 0)
    start = (float(solved.variables[name][1][0, 0]) for name in ("displacement", "velocity"))
    motion = vp.simulate(soft, soft.period, *start, samples_per_period=20_000)
    x, v, tau = (motion[name].values for name in ("displacement", "velocity", "tau"))
    apart = np.abs(acceleration(curve, tau / soft.period, x, v) - np.gradient(v, tau))
    # It jumps where the mass comes to a support and where it leaves one that pulls, between two samples.
    assert (apart > 1e-2).sum() <= 4 * motion.sizes["impact"]


@pytest.fixture(scope="module")
def displacement():
    """A record of displacements, the force beside it."""
    return record_by_solve_ivp(TRUE, {"displacement": 2e-3}, seed=0)


def test_a_record_tells_parameters_frequency_and_offset(displacement):
    record, _force = displacement
    found = identified(record, samples=64)
    assert int(found.fit_result) == FitResult.EXPLAINED
    assert found.parameter.values.tolist() == ["nu", "delta", "R1", "R2"]
    assert (found.parameter_result == FoundResult.DETERMINED).all()
    assert distance(found) < CHI_SQUARE_4
    # Means of 864 samples, of which the phase takes some.
    assert float(found.displacement_offset) == pytest.approx(0.1, abs=5e-4)
    assert float(found.displacement_noise) == pytest.approx(2e-3, rel=0.15)
    assert float(found.displacement_sign) == 1.0
    assert int(found.transient_samples) == int(found.displacement_left_out) == 0
    # 24 periods at the frequency found: the phase is the time times the frequency.
    turns = np.diff(found.phase.values) % 1.0
    expected = np.diff(record["tau"]) * float(found.nu) / (2 * np.pi)
    assert turns == pytest.approx(expected, abs=1e-9)


@pytest.mark.slow
def test_the_mirror_image_is_named_where_the_direction_of_the_sensor_is_not_known(displacement):
    record, _force = displacement
    found = identified(record)
    assert found.twin_kind.values.tolist() == [Twin.MIRROR_IMAGE]
    assert float(found.twin_excess[0]) == 0.0
    assert float(found.delta_twin[0]) == -float(found.delta)
    assert float(found.R1_twin[0]) == float(found.R2)
    assert float(found.R2_twin[0]) == float(found.R1)
    # It does fit: the reversed record gives it, with the direction known.
    reversed_record = {**record, "displacement": -record["displacement"]}
    other = identified(reversed_record, sign="known")
    assert "twin" not in other.dims
    std = float(found.delta_std)
    assert float(other.delta) == pytest.approx(-float(found.delta), abs=0.1 * std)
    chi = float(found.reduced_chi_square)
    assert float(other.reduced_chi_square) == pytest.approx(chi, rel=0.01)
    assert "twin" not in identified(record, sign="known").dims


@pytest.mark.slow
def test_a_mirror_image_with_a_blind_support_is_one_twin():
    true = vp.Exciter(l=0.5, nu=0.9, f=0.3, h=0.1, R1=0.6, R2=0.7, delta=0.3)
    record, _force = record_by_solve_ivp(true, {"displacement": 2e-3}, seed=3)
    vary = {"delta": (-0.45, 0.45), "R1": (0.4, 0.9), "R2": (0.4, 0.9)}
    found = identified(record, vp.Exciter(l=0.5, nu=0.9, f=0.3, h=0.1), vary, samples=64)
    # Support 1 is not struck, so that R1 is any; of the mirror image R2 is.
    assert float(found.delta) == pytest.approx(0.3, abs=4 * float(found.delta_std))
    assert found.twin_kind.values.tolist() == [Twin.MIRROR_IMAGE]
    (told,) = twin_texts(found)
    assert told.startswith("With the sensors reversed, the mirror image fits as well: δ = −0.3")
    assert told.endswith(", R₂ not determined")


@pytest.mark.slow
def test_a_reversed_sensor_is_told_where_the_ranges_decide(displacement):
    record, _force = displacement
    reversed_record = {**record, "displacement": -record["displacement"]}
    found = identified(reversed_record, vary={**VARY, "delta": (0.0, 0.1)})
    assert float(found.displacement_sign) == -1.0
    assert distance(found) < CHI_SQUARE_4
    assert "twin" not in found.dims
    wrong = identified(reversed_record, vary={**VARY, "delta": (0.0, 0.1)}, sign="known")
    assert int(wrong.fit_result) == FitResult.BEYOND_NOISE


def test_a_force_that_may_have_either_sign_has_a_twin(displacement):
    record, _force = displacement
    known = vp.Exciter(l=0.5, nu=1.0, h=0.2, delta=0.03, R1=0.75, R2=0.65)
    found = identified(record, known, {"f": (-0.8, 0.8)}, sign="known")
    (kind,), (twin,) = found.twin_kind.values, found.f_twin.values
    assert kind == Twin.OTHER
    # Half a period later, and so from another start of the search.
    assert twin == pytest.approx(-float(found.f), abs=float(found.f_std))
    assert abs(float(found.f)) == pytest.approx(0.7, abs=4 * float(found.f_std))


def test_a_column_of_the_force_tells_phase_and_sign(displacement):
    record, force = displacement
    known = vp.Exciter(l=0.5, h=0.2, delta=0.03, R1=0.75, R2=0.65, f=-0.7)
    found = identified({**record, "force": force}, known, {"h": (0.1, 0.3)})
    assert "twin" not in found.dims
    rise = float(found.phase[0])
    assert -0.7 * np.sin(2 * np.pi * rise) == pytest.approx(force[0], abs=1e-3)
    assert distance(found) < CHI_SQUARE_4


def test_a_trigger_tells_the_phase_within_an_interval(displacement):
    record, force = displacement
    # sin(nu tau) is positive for half a period after each rise.
    found = identified({**record, "trigger": np.where(force < 0, 5.0, 0.0)})
    assert int(found.fit_result) == FitResult.EXPLAINED
    assert "twin" not in found.dims
    assert distance(found) < CHI_SQUARE_4
    expected = np.arcsin(force[0] / -0.7) / (2 * np.pi)
    off = (float(found.phase[0]) - np.array([expected, 0.5 - expected]) + 0.5) % 1.0 - 0.5
    assert np.abs(off).min() < 1e-3


def test_clipped_samples_do_not_count(displacement):
    record, _force = displacement
    x = record["displacement"]
    low, high = np.quantile(x, [0.1, 0.85])
    found = identified({**record, "displacement": np.clip(x, low, high)})
    assert int(found.fit_result) == FitResult.EXPLAINED
    assert distance(found) < CHI_SQUARE_4
    n_clipped = int(((x <= low) | (x >= high)).sum())
    assert int(found.displacement_left_out) == n_clipped
    assert int(np.isnan(found.displacement_fitted).sum()) == n_clipped
    assert n_clipped == pytest.approx(0.25 * x.size, abs=2)


@pytest.mark.parametrize(
    ("noise", "seed"),
    [
        ({"velocity": 2e-3}, 2),
        pytest.param({"acceleration": 2e-2}, 4, marks=pytest.mark.slow),
        pytest.param({"displacement": 2e-3, "acceleration": 2e-2}, 5, marks=pytest.mark.slow),
    ],
)
def test_velocities_and_accelerations_are_blanked_next_to_impacts(noise, seed):
    record, _force = record_by_solve_ivp(TRUE, noise, seed=seed)
    found = identified(record, samples=32)
    assert int(found.fit_result) == FitResult.EXPLAINED
    assert distance(found) < CHI_SQUARE_4
    assert found.twin_kind.values.tolist() == [Twin.MIRROR_IMAGE]
    # Two impacts in each of 24.24 periods, 1.5 intervals on each side: three samples.
    rapid = next(name for name in noise if name != "displacement")
    assert int(found[f"{rapid}_left_out"]) == pytest.approx(2 * 24.24 * 3, abs=4)
    if "displacement" in noise:
        assert int(found.displacement_left_out) == 0
    wide = identified(record, blanking=3 * 1.01 * 2 * np.pi / 36, samples=32)
    assert int(wide[f"{rapid}_left_out"]) == pytest.approx(2 * 24.24 * 6, abs=8)
    assert distance(wide) < CHI_SQUARE_4


@pytest.mark.slow
def test_a_transient_is_left_out():
    record, _force = record_by_solve_ivp(
        TRUE, {"displacement": 2e-3}, seed=6, settle=0, start=(0.3, 1.0), periods=60
    )
    found = identified(record)
    before = int(found.transient_samples)
    assert 36 < before < 0.5 * 60 * 36
    assert int(found.fit_result) == FitResult.EXPLAINED
    assert distance(found) < CHI_SQUARE_4
    begin = float(record["tau"][before])
    assert float(found.tau[0]) == begin
    told = identified(record, steady_from=begin)
    assert int(told.transient_samples) == before
    assert float(told.R1) == pytest.approx(float(found.R1), abs=0.1 * float(found.R1_std))
    # With the transient the record is that of no steady state.
    assert int(identified(record, steady_from=0.0).fit_result) == FitResult.BEYOND_NOISE


@pytest.mark.slow
def test_the_forcing_frequency_may_be_a_multiple_of_the_largest_line():
    true = vp.Exciter(l=1.0, nu=3.6, f=1.0, h=0.1, delta=-1.0, R1=0.8, R2=0.8)
    assert int(vp.steady_state(true).period_multiple) == 2
    record, _force = record_by_solve_ivp(
        true, {"displacement": 2e-3}, seed=7, periods=48, rate=24, settle=300, start=(-0.3, 0.0)
    )
    known = vp.Exciter(l=1.0, f=1.0, h=0.1, delta=-1.0, R2=0.8)
    found = identified(record, known, {"R1": (0.6, 0.95)})
    assert float(found.nu) == pytest.approx(3.6, abs=5 * float(found.nu_std))
    assert distance(found, true) < CHI_SQUARE_4
    assert float(found.phase.max()) > 1.0
    assert (
        found.phase.attrs["long_name"] == "phase in forcing periods"
    )  # of no fraction of the orbit


def test_soft_supports_are_found_from_a_record():
    true = vp.Exciter(l=0.5, nu=1.0, f=-0.7, h=0.2, delta=0.03, k1=60.0, k2=40.0, h1=2.0, h2=2.0)
    orbit = vp.steady_state(true)
    start = float(orbit.displacement_strobe), float(orbit.velocity_strobe)
    motion = vp.simulate(true, 20 * 2 * np.pi, *start, samples_per_period=40)
    generator = np.random.default_rng(8)
    kept = slice(13, None)
    record = {
        "tau": motion.tau.values[kept] - motion.tau.values[13],
        "displacement": motion.displacement.values[kept] + 1e-3 * generator.standard_normal(788),
    }
    known = vp.Exciter(l=0.5, f=-0.7, h=0.2, delta=0.03, k1=50.0, k2=50.0, h1=2.0, h2=2.0)
    found = identified(record, known, {"k1": (30.0, 90.0), "k2": (30.0, 90.0)}, sign="known")
    assert int(found.fit_result) == FitResult.EXPLAINED
    assert distance(found, true) < 16.3


def test_the_curve_of_an_orbit_is_that_of_its_motion_with_soft_supports_too():
    # At a first contact the velocity went on as if the support were rigid: 2.3e-3 off.
    soft = vp.Exciter(l=0.5, nu=1.0, f=-0.7, h=0.2, delta=0.03, k1=200.0, k2=100.0, R1=0.7, R2=0.8)
    for exciter, error in ((soft, 3e-5), (TRUE, 1e-8)):
        rows = np.array([exciter.numbers()])
        solved = solve_points(rows, (0.0, 0.0), ("impacts", "motion", "stability"), 1)
        orbit = vp.steady_state(exciter)
        start = float(orbit.displacement_strobe), float(orbit.velocity_strobe)
        motion = vp.simulate(exciter, 2 * np.pi, *start, samples_per_period=2000)
        own = displacement_at(solved.variables, rows, np.arange(2000) / 2000)[0]
        assert np.abs(own - motion.displacement.values[:2000]).max() < error


PHYSICAL = {"m": "2 kg", "C": "8 N/mm", "H": "25 N s/m", "F": "40 N", "l": "8 mm"}


@pytest.fixture(scope="module")
def bench():
    """The true exciter with units, and a record in s, m and m/s^2."""
    true = vp.Exciter.from_physical(**PHYSICAL, delta="0.6 mm", omega="70 rad/s", R1=0.75, R2=0.65)
    p = (8000.0 / 2.0) ** 0.5
    noise = {"displacement": 1e-5, "acceleration": 2e-4}
    record, _force = record_by_solve_ivp(true, noise, seed=9, offset=1e-3)
    return {
        "time": record["tau"] / p,
        "displacement": record["displacement"],
        "acceleration": record["acceleration"] * p**2,
    }


VARY_UNITS = {"delta": ("0 mm", "1 mm"), "R1": (0.5, 0.9), "R2": (0.5, 0.9)}


def frames(bench):
    """The same record as tables of several kinds."""
    frame = pd.DataFrame(
        {
            "Time (ms)": bench["time"] * 1e3,
            "displacement/mm": bench["displacement"] * 1e3,
            "acceleration (g)": bench["acceleration"] / 9.80665,
        }
    )
    attrs = {"displacement": "m", "acceleration": "m s-2"}
    arrays = {name: ("time", bench[name], {"units": unit}) for name, unit in attrs.items()}
    return frame, xr.Dataset(arrays, {"time": ("time", bench["time"], {"units": "s"})})


@pytest.mark.slow
def test_a_record_with_units_of_any_kind_gives_parameters_with_units(bench, tmp_path):
    known = vp.Exciter.from_physical(**PHYSICAL)
    frame, dataset = frames(bench)
    found = vp.identify(known, frame, VARY_UNITS, samples=16)
    assert int(found.fit_result) == FitResult.EXPLAINED
    assert found.parameter.values.tolist() == ["omega", "delta", "R1", "R2"]
    for name, value in (("omega", 70.0), ("delta", 6e-4), ("R1", 0.75), ("R2", 0.65)):
        assert abs(float(found[name]) - value) < 4 * float(found[f"{name}_std"]), name
    assert found.time.attrs["units"] == "s"
    assert found.acceleration_measured.attrs["units"] == "m s-2"
    assert np.allclose(found.acceleration_measured, bench["acceleration"])
    assert float(found.displacement_offset) == pytest.approx(1e-3, abs=2e-6)
    assert float(found.acceleration_noise) == pytest.approx(2e-4 * 4000, rel=0.2)
    path = tmp_path / "record.csv"
    frame.to_csv(path, index=False, sep=";")
    for table in (bench, dataset, path):
        same = vp.identify(known, table, VARY_UNITS, samples=16)
        assert float(same.R1) == pytest.approx(float(found.R1), abs=0.1 * float(found.R1_std))


def test_arguments_of_records_have_units(bench):
    known = vp.Exciter.from_physical(**PHYSICAL)
    found = vp.identify(
        known, bench, {**VARY_UNITS, "omega": ("10 Hz", "12 Hz")}, samples=16,
        noise={"displacement": "10 um", "acceleration": "0.8 m/s^2"},
        steady_from="200 ms", blanking="6 ms", sign="known",
    )  # fmt: skip
    assert found.attrs["noise"] == "given"
    assert float(found.time[0]) >= 0.2
    assert int(found.transient_samples) == int((bench["time"] < 0.2).sum())
    assert float(found.omega) == pytest.approx(70.0, abs=4 * float(found.omega_std))
    assert float(found.displacement_noise) == pytest.approx(1e-5)
    # 12 ms of each of two impacts in a period of 89.8 ms.
    share = int(found.acceleration_left_out) / found.sizes["measurement"]
    assert share == pytest.approx(2 * 12 / 89.8, abs=0.01)


@pytest.mark.slow
@pytest.mark.parametrize(
    "noise", [{"displacement": 2e-3}, {"velocity": 2e-3}, {"acceleration": 2e-2}]
)
def test_the_covariance_is_that_of_many_records(noise):
    distances = [
        distance(identified(record_by_solve_ivp(TRUE, noise, seed=seed)[0], samples=32))
        for seed in range(20)
    ]
    # The mean of 20 chi-squares of 4 has the standard deviation 0.63.
    assert 2.1 < np.mean(distances) < 6.0


def changed(**columns):
    """A record of a sine with some columns changed; None leaves one out."""
    tau = np.arange(400) * 0.2
    table = {"tau": tau, "displacement": np.sin(tau), **columns}
    return {name: values for name, values in table.items() if values is not None}


HOUSED = vp.Exciter(l=0.5, f=0.5, mass_ratio=0.1)
NOISE = np.random.default_rng(0).standard_normal(400)
TAU = np.arange(400) * 0.2


@pytest.mark.parametrize(
    ("table", "given", "message"),
    [
        (changed(displacement=NOISE), {}, "measured: must have a period, got a record whose spectrum has no line"),
        (changed(tau=TAU * 10, displacement=np.sin(TAU * 10)), {}, "8 samples in each forcing period, got 3.14"),
        (changed(tau=TAU[:80], displacement=np.sin(TAU[:80])), {}, "at least 3 forcing periods long .* got 2.5"),
        (changed(tau=TAU[:20], displacement=np.sin(TAU[:20])), {}, "at least 32 samples of a record, got 20"),
        (changed(tau=np.where(TAU == 2.0, 1.8, TAU)), {}, "got none between samples 10 and 11"),
        (changed(displacement=np.where(TAU == 2.0, np.nan, np.sin(TAU))), {}, "got nan in line 11 of displacement"),
        (changed(displacement=np.sin(TAU)[:-1]), {}, "columns of different lengths"),
        (changed(displacement=np.zeros(400)), {}, "one value only, as of a dead sensor"),
        (changed(displacement=np.clip(np.sin(TAU), -0.3, 0.3)), {}, "within the limits of its sensor, got 8.% of them"),
        (changed(displacement=None), {}, "must have time and displacement, velocity, acceleration, or one of them"),
        (changed(speed=TAU), {}, "must have time and displacement.* got speed"),
        (changed(force=np.sin(TAU), trigger=np.sin(TAU)), {}, "one column that tells .* got both"),
        (changed(), {"sign": "plus"}, "sign: must be known or unknown, got 'plus'"),
        (changed(), {"blanking": -1.0}, "blanking: must be"),
        (changed(), {"steady_from": 75.0}, "steady_from: must leave at least 32 samples"),
        (changed(), {"steady_from": "1 s"}, "steady_from: must be"),
        (changed(), {"noise": {"velocity": 1.0}}, r"noise: must have the measured quantities as keys \(displacement\)"),
        (changed(), {"vary": {"R1": (0.5, 0.9), "nu": (1.2, 1.5)}}, "vary.nu: must hold the frequency .*, 1$"),
        (changed(), {"known": vp.Exciter(l=0.5, nu=1.1, f=0.5)}, "nu: must be the forcing .* line is at 1.*, got 1.1"),
        (changed(acceleration=TAU % 1), {"known": HOUSED}, "must leave out acceleration"),
        ({"time (s)": TAU, "displacement": np.sin(TAU)}, {}, r"Exciter.from_physical, got time \(s\)"),
        ({"phase": TAU % 1, "displacement": TAU}, {"steady_from": 1.0}, "steady_from: must be left out, since"),
    ],
)  # fmt: skip
def test_wrong_records_are_refused_in_words(table, given, message):
    given = {"known": vp.Exciter(l=0.5, f=0.5), "vary": {"R1": (0.5, 0.9)}, **given}
    with pytest.raises(vp.ParameterError, match=message):
        identified(table, **given)


@pytest.mark.parametrize(
    ("head", "message"),
    [
        ("displacement (mmm)", r"measured.displacement: must be a unit of length.* got 'mmm'"),
        ("displacement (kg)", r"measured.displacement: must be a unit of length.* got 'kg' \(kg is no unit of length"),
        ("acceleration (mm)", r"measured.acceleration: must be a unit of acceleration, such as m/s\^2"),
        ("trigger (V)", r"measured.trigger: must be a number without a unit"),
    ],
)  # fmt: skip
def test_wrong_units_are_refused_in_words(head, message):
    table = {"time (s)": TAU / 60, "velocity (m/s)": np.sin(TAU), head: np.sin(TAU)}
    known = vp.Exciter.from_physical(**PHYSICAL)
    with pytest.raises(vp.ParameterError, match=message):
        vp.identify(known, table, VARY_UNITS)


def test_a_frequency_that_is_not_that_of_the_record_is_told_in_hertz(bench):
    known = vp.Exciter.from_physical(**PHYSICAL, omega="12 Hz")
    with pytest.raises(
        vp.ParameterError, match=r"omega: must be .* line is at 11\.14.* Hz.* got 12 Hz"
    ):
        vp.identify(known, bench, VARY_UNITS)


def test_a_file_that_is_none_is_refused(tmp_path):
    with pytest.raises(
        vp.ParameterError, match=r"path of a CSV file, got '.*none.csv' \(No such file"
    ):
        vp.identify(KNOWN, str(tmp_path / "none.csv"), VARY)


def test_ties_hold_in_the_fit_of_a_record(displacement):
    """The restitutions by a name of one's own, and a force of negative sign, whose record tells the phase."""
    record, force = displacement
    ties = {"R1": "1 - loss", "R2": "R1 - 0.1", "f": "-0.7"}
    known, vary = vp.Exciter(l=0.5, h=0.2), {"delta": (-0.1, 0.1), "loss": (0.15, 0.45)}
    for table in (record, {**record, "force": force}):
        found = identified(table, known, vary, ties=ties)
        assert int(found.fit_result) == FitResult.EXPLAINED
        assert found.parameter.values.tolist() == ["nu", "delta", "loss"]
        for name, true in {"nu": 1.0, "delta": 0.03, "loss": 0.25}.items():
            assert abs(float(found[name]) - true) < 5 * float(found[f"{name}_std"]), name
        assert float(found.R1) == 1 - float(found.loss)
        assert float(found.R2) == float(found.R1) - 0.1
        assert float(found.f) == -0.7
        assert found.attrs["ties"] == "R1 = 1 - loss; R2 = R1 - 0.1; f = -0.7"
        # The mirrored exciter has the larger restitution at the other support, which the ties exclude.
        assert "twin" not in found.dims


@pytest.mark.slow
def test_the_mirror_image_keeps_ties(displacement):
    record, _force = displacement
    ties = {"R1": "1 - loss", "R2": "R1"}
    vary = {"delta": (-0.1, 0.1), "loss": (0.15, 0.45)}
    found = identified(record, KNOWN, vary, ties=ties)
    assert found.twin_kind.values.tolist() == [Twin.MIRROR_IMAGE]
    assert float(found.delta_twin[0]) == -float(found.delta)
    assert float(found.loss_twin[0]) == float(found.loss)


@pytest.mark.parametrize(
    ("ties", "told"),
    [
        ({"nu": "1"}, "ties.nu: must be left out beside a record, in which the frequency is found"),
        ({"h": "0.2 * nu"}, "ties.h: must have a value for nu: give it in vary or by a tie"),
    ],
)
def test_ties_of_the_frequency_of_a_record_are_refused(displacement, ties, told):
    record, _force = displacement
    with pytest.raises(vp.ParameterError, match=told):
        identified(record, vp.Exciter(l=0.5, f=-0.7), ties=ties)
