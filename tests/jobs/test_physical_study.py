"""A study with units, solved, cut, joined, verified and opened: its data are in SI."""

import math
import shutil

import numpy as np
import pytest
import xarray as xr
from matplotlib.text import Text
from typer.testing import CliRunner

import vibropipe as vp
from vibropipe.cli.commands import app
from vibropipe.jobs.plan import plan_scene
from vibropipe.jobs.solving import join_to_file, solve_scene, solve_to_file
from vibropipe.jobs.terminal_tables import plan_text
from vibropipe.jobs.verify import verify
from vibropipe.store import save, summary
from vibropipe.study import study_of_text
from vibropipe.view.results import open_results

HEAD = """
title: With units
physical: {m: 2 kg, C: 8 N/mm, H: 40 N s/m, l: 8 mm, F: 120 N, omega: 55 rad/s}
exciter: {R1: 0.7, R2: 0.6}
"""
UNITS = (
    HEAD
    + """\
scenes:
  sweep:
    kind: sweep
    over: {omega: {start: 20 rad/s, stop: 200 rad/s, points: 19}, delta: [0, 1 mm]}
    follow: {along: omega, direction: up}
  motion:
    kind: motion
    tau_end: 0.5 s
    start: {x0: 5 mm, v0: 0.1 m/s}
    outputs: [motion, impacts, harmonics, stability, energy]
  free: {kind: backbone, amplitude: [1 mm, 8 mm, 20 mm]}
"""
)
IN_HZ = UNITS.replace("start: 20 rad/s, stop: 200 rad/s", "start: 3 Hz, stop: 30 Hz")
M, C = 2.0, 8000.0
P = math.sqrt(C / M)
SHARDS = 2


@pytest.fixture(scope="module")
def study():
    return study_of_text(UNITS, "units")


@pytest.fixture(scope="module")
def results(study, tmp_path_factory):
    """Return a folder with the datasets of all scenes, the sweep joined from shards."""
    folder = tmp_path_factory.mktemp("results")
    for name in ("motion", "free"):
        solve_to_file(study, name, folder / f"{name}.nc", None, 1)
    shards = [folder / "shards" / f"{n}.nc" for n in range(1, SHARDS + 1)]
    for n, shard in enumerate(shards, 1):
        solve_to_file(study, "sweep", shard, (n, SHARDS), 1)
    join_to_file(study, "sweep", shards[::-1], folder / "sweep.nc")
    return folder


def test_the_data_are_those_without_units_in_si(study, results) -> None:
    numbers = study.scenes["motion"].resolved_exciter()
    exciter = vp.Exciter(**numbers)
    sweep = vp.sweep(
        exciter, over=study.scenes["sweep"].over_arrays(), follow=("nu", "up")
    )  # fmt: skip
    stored = vp.load(results / "sweep.nc")
    expected = vp.to_physical(sweep, M, C)
    assert stored.identical(expected.assign_attrs(stored.attrs))
    assert stored["delta"].attrs["units"] == "m"
    motion = vp.load(results / "motion.nc")
    steady = vp.steady_state(exciter, x0=0.005, v0=0.1 / P)
    assert float(motion["orbit_energy_input"]) == float(steady["energy_input"]) * C
    assert motion["time"].values[-1] == pytest.approx(0.5, rel=1e-15)
    assert motion.attrs["start"] == "x0 = 0.005 m, v0 = 0.1 m/s"


def test_one_file_and_joined_shards_are_the_same_bytes(study, results, tmp_path) -> None:
    solve_to_file(study, "sweep", tmp_path / "sweep.nc", None, 1)
    whole, joined = (vp.load(folder / "sweep.nc") for folder in (tmp_path, results))
    xr.testing.assert_identical(whole, joined)
    in_memory = solve_scene(study, "sweep")
    for name, variable in whole.variables.items():
        np.testing.assert_array_equal(in_memory[name].values, variable.values)
        assert in_memory[name].attrs.get("units") == variable.attrs.get("units")


def test_frequencies_are_found_as_they_were_given(results) -> None:
    tree = vp.open_study(results)
    rows = tree["sweep"].to_dataset()
    assert rows["displacement_amplitude"].chunks is not None
    row = rows.sel(omega=50, delta=0.001)
    assert int(row["regime"]) in range(8)
    assert rows["omega"].values.tolist() == [20.0 + 10 * n for n in range(19)]


def test_every_dataset_is_verified(results) -> None:
    verdicts = list(verify(results, rows=10, seed=1))
    assert [verdict.name for verdict in verdicts] == ["free", "motion", "sweep"]
    assert all(verdict.good for verdict in verdicts), "\n".join(map(str, verdicts))


def test_a_wrong_value_is_named_by_the_frequency_with_unit(results, tmp_path) -> None:
    broken = vp.load(results / "sweep.nc")
    broken["displacement_mean"][3, 1] = 7.0
    save(broken, tmp_path / "sweep.nc")
    (verdict,) = verify(tmp_path / "sweep.nc", rows=1000, seed=1)
    assert verdict.faults[0].startswith(
        "displacement_mean at omega = 50 rad/s, delta = 1 mm: 7.0 m in the file, "
    )


def test_a_summary_shows_symbols_and_units_of_the_data(results) -> None:
    text = summary(vp.load(results / "motion.nc"))
    assert "time (s)" in text
    assert "angular frequency of excitation (rad s-1)" in text
    assert "ω " in text
    assert "τ" not in text


def head_of(file) -> list[str]:
    return CliRunner().invoke(app, ["table", str(file)]).output.splitlines()[0].split(",")


def axis_of(dataset) -> str:
    return vp.plot(dataset).axes[-1].get_xlabel()


@pytest.mark.slow
def test_an_edit_of_the_units_of_a_study_is_followed_at_once(results, tmp_path, monkeypatch):
    folder = tmp_path / "results" / "units"
    shutil.copytree(results, folder)
    monkeypatch.chdir(tmp_path / "results")  # not where the study is, which is beside the results
    response, opened = folder / "sweep.nc", vp.open_study(folder)["sweep"]
    assert head_of(response)[:2] == ["omega (rad/s)", "delta (mm)"]
    assert axis_of(opened).endswith("(rad/s)")
    file = tmp_path / "units.yaml"
    file.write_text(UNITS + "units: {frequency: rpm, length: cm}", encoding="utf-8")
    assert head_of(response)[:2] == ["omega (rpm)", "delta (cm)"]
    for shown in (folder, response):
        text = CliRunner().invoke(app, ["show", str(shown)]).output
        assert "frequency of excitation (rpm)" in text
        page = open_results(shown, folder)
        assert page.datasets["sweep"]["delta"].attrs["units"] == "cm"
    assert axis_of(opened).endswith("(rpm)")
    assert axis_of(opened.to_dataset().sel(delta=[0.0])).endswith("(rpm)")
    motion = folder / "motion.nc"
    assert "(cm)" in vp.plot([motion, vp.load(motion)]).axes[0].get_ylabel()
    # the pictures that it chooses, too
    chosen = "follow: {along: omega, direction: up}\n    figure: {show: [displacement_mean]}"
    file.write_text(UNITS.replace("follow: {along: omega, direction: up}", chosen))
    assert any("mean displacement" in text.get_text() for text in vp.plot(opened).findobj(Text))
    # a study of the same name that asks for other data is another one
    file.write_text(IN_HZ + "units: {length: cm}", encoding="utf-8")
    assert head_of(response)[:2] == ["omega (rad/s)", "delta (mm)"]
    assert head_of(motion)[0] == "time (s)"
    assert "displacement (cm)" in head_of(motion)
    file.write_text("scenes: [", encoding="utf-8")
    assert head_of(response)[:2] == ["omega (rad/s)", "delta (mm)"]


def test_simulated_points_of_a_backbone_have_units() -> None:
    scenes = (
        "scenes:\n  curves: {kind: backbone, delta_over_l: [0], tau_bar: [40 ms, 50 ms, 60 ms]}\n"
    )
    study = study_of_text(UNITS.partition("scenes:")[0] + scenes, "curves")
    curves = solve_scene(study, "curves")
    assert curves["simulated_free_period"].attrs["units"] == "s"
    assert curves["simulated_velocity_over_l"].attrs["units"] == "s-1"
    inside = curves["simulated_free_period"].values
    assert ((inside >= 0.0399) & (inside <= 0.0601)).all()


def test_a_table_has_units_in_its_head(results) -> None:
    run = CliRunner().invoke(app, ["table", str(results / "sweep.nc")])
    head = run.output.splitlines()[0].split(",")
    assert head[:2] == ["omega (rad/s)", "delta (mm)"]
    assert {"F (N)", "H (N s/m)", "R1", "regime", "displacement_amplitude_2 (mm)"} <= {*head}
    assert {"impact_velocity_max_1 (m/s)", "displacement_phase_1 (rad)", "m (kg)"} <= {*head}
    last = dict(zip(head, run.output.splitlines()[-1].split(","), strict=True))
    assert [last[each] for each in ("omega (rad/s)", "delta (mm)", "l (mm)", "C (N/mm)")] == [
        "200.0",
        "1.0",
        "8.0",
        "8.0",
    ]
    frame = vp.table(results / "sweep.nc")
    assert frame.attrs["units"]["omega"] == "rad/s"
    assert "omega" in frame
    impacts = CliRunner().invoke(app, ["table", "--impacts", str(results / "sweep.nc")])
    assert "impact_velocity (m/s)" in impacts.output.splitlines()[0]
    motion = CliRunner().invoke(app, ["table", str(results / "motion.nc")])
    assert motion.output.startswith("time (s),")


def test_a_study_without_units_converts_nothing(tmp_path, monkeypatch) -> None:
    plain = study_of_text(
        "title: T\nexciter: {l: 0.5, nu: 1, f: 1, h: 0.2, R1: 0.7, R2: 0.7}\n"
        "scenes: {s: {kind: sweep, over: {nu: [0.5, 1]}}}\n",
        "plain",
    )
    monkeypatch.setattr("vibropipe.solve.physical.to_physical", None)
    solve_to_file(plain, "s", tmp_path / "s.nc", None, 1)
    assert vp.load(tmp_path / "s.nc")["nu"].attrs["units"] == "1"


PLANS = (
    HEAD
    + """\
scenes:
  sweep:
    kind: sweep
    over: {omega: {start: 20 rad/s, stop: 200 rad/s, points: 19}, delta: [0, 1 mm]}
    follow: {along: omega, direction: both}
  borders: {kind: boundary, of: [fold], over: {omega: [50 rad/s, 250 rad/s], F: [20 N, 200 N]}}
  pure: {kind: boundary, of: [fold], over: {R1: [0.2, 0.9], l: [4 mm, 9 mm]}}
  laws: {kind: branch, along: {omega: {from: 50 rad/s, to: [20 rad/s]}}, over: {delta: [0, 1 mm]}}
  wanted: {kind: design, vary: {omega: [40 rad/s, 90 rad/s], R1: [0.5, 0.9]}, target: {period_multiple: 1}}
"""
)


def test_plans_have_the_names_and_values_of_the_study():
    scenes = study_of_text(PLANS, "plans").scenes
    plans = {name: plan_scene(scene) for name, scene in scenes.items()}
    assert {name: plan.size for name, plan in plans.items()} == {
        "sweep": "2 direction x 19 omega x 2 delta",
        "borders": "omega 50 to 250 rad/s x F 20 to 200 N",
        "pure": "R1 0.2 to 0.9 x l 4 to 9 mm",
        "laws": "omega from 50 to 20 rad/s, 2 delta",
        "wanted": f"{scenes['wanted'].samples} samples over omega, R1",
    }
    assert plans["sweep"].method == "exact, omega both"


def test_the_terminal_has_the_units_of_the_study(study, results) -> None:
    assert "time 0.5 s" in plan_text(study)
    rpm = study_of_text("units: {frequency: rpm, time: ms}\n" + UNITS, "units")
    assert "time 500 ms" in plan_text(rpm)
    branch = "  branch: {kind: branch, along: {omega: {from: 60 rad/s, to: [10 Hz]}}}\n"
    assert "omega from 9.5493 to 10 Hz" in plan_text(study_of_text(IN_HZ + branch, "units"))
    shown = CliRunner().invoke(app, ["show", str(results / "sweep.nc")]).output
    assert "offset of the equilibrium (mm)" in shown
