"""Files of figures in units for display, and what `snakemake --report` says of them."""

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from figures.sample_datasets import Scene, motion, sweep

from vibropipe.compiler.sources import PACKAGE
from vibropipe.figures.units import display_units
from vibropipe.jobs.drawing import (
    DRAWN,
    _files,
    figure_names,
    figures_of,
    remove_unchosen,
    scenes_drawn,
)
from vibropipe.jobs.html_report import caption_files, captions, escaped, is_requested, write_opening
from vibropipe.jobs.run import read_run
from vibropipe.jobs.solving import solve_to_file
from vibropipe.scenes.sweep.figure_keys import SweepFigure
from vibropipe.study import study_of_text


def test_pictures_no_longer_chosen_are_removed(tmp_path):
    scene = Scene("sweep", "line", figure=SweepFigure(pictures=["curves", "energy"]))
    kept = ["line.svg", "line-energy.pdf", "line-notes.pdf", "lines-map.svg", "line-map.txt"]
    stale = ["line-map.svg", "line-map.pdf", "line-bifurcation.svg"]
    for name in (*kept, *stale):
        (tmp_path / name).touch()
    assert figure_names(scene) == ["line", "line-energy"]
    removed = remove_unchosen(scene, tmp_path)
    assert sorted(path.name for path in removed) == sorted(stale)
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(kept)


def test_datasets_without_units_are_drawn_as_they_are():
    dataset = sweep()
    assert display_units({"line": dataset})["line"] is dataset


def test_datasets_of_a_study_have_the_same_prefixes():
    small, large = motion(), motion()
    for dataset, scale in ((small, 1e-4), (large, 1e-2)):
        dataset["displacement"] = dataset["displacement"] * scale
        dataset["displacement"].attrs |= {"units": "m"}
    shown = display_units({"small": small, "large": large})
    assert shown["small"]["displacement"].attrs["units"] == "mm"
    assert np.array_equal(shown["small"]["displacement"], 1e3 * small["displacement"])
    again = display_units(shown)
    assert np.array_equal(again["large"]["displacement"], shown["large"]["displacement"])


@pytest.mark.parametrize(
    ("given", "others", "unit"),
    [
        ({"F": 120.0}, 1453.0, "N"),
        ({"F": 0.3}, 1453.0, "N"),
        ({"F": 1200.0, "friction": 0.3}, 10.0, "N"),
        ({"F": 1200.0, "friction": 0.0}, 14530.0, "kN"),
        ({"F": 0.3}, 0.2, "mN"),
        ({"F": 4e-5}, 3e-4, "µN"),
    ],
)
def test_forces_get_a_prefix_in_which_no_parameter_is_small(given, others, unit):
    forces = {**given, "contact_force_max": ("impact", np.array([others, np.nan]))}
    dataset = xr.Dataset(forces)
    for name in forces:
        dataset[name].attrs["units"] = "N"
    assert display_units({"a": dataset})["a"]["F"].attrs["units"] == unit


def test_what_is_derived_from_a_length_chooses_no_prefix():
    names = (
        "l",
        "displacement_mean_sensitivity",
        "displacement_mean_std",
        "displacement_mean_error",
    )
    dataset = xr.Dataset(dict(zip(names, (0.008, 40.0, 3.0, 2.0), strict=True)))
    for name in names:
        dataset[name].attrs["units"] = "m"
    shown = display_units({"a": dataset})["a"]
    assert [shown[name].attrs["units"] for name in names] == ["mm", "m", "mm", "mm"]
    assert float(shown["displacement_mean_sensitivity"]) == 40.0


def test_physical_datasets_are_drawn_in_small_numbers():
    dataset = motion()
    for name in ("displacement", "l", "delta"):
        dataset[name] = dataset[name] * 0.016
        dataset[name].attrs |= {"units": "m", "long_name": name, "symbol": "$x$"}
    dataset["velocity"].attrs["units"] = "m s-1"
    shown = display_units({"motion": dataset})["motion"]
    assert np.array_equal(shown["displacement"], 1e3 * dataset["displacement"])
    assert [shown[name].attrs["units"] for name in ("displacement", "l", "velocity")] == [
        "mm", "mm", "m s-1",
    ]  # fmt: skip
    assert float(shown["l"]) == 8.0
    assert dataset["displacement"].attrs["units"] == "m"


def test_a_figure_depends_on_the_scenes_that_it_shows():
    text = """\
title: T
exciter: {l: 0.5, nu: 1, f: -1, h: 0.2, R1: 0.7, R2: 0.7}
scenes:
  spine: {kind: backbone, amplitude: {start: 0.6, stop: 2, points: 9}}
  under: {kind: sweep, over: {nu: [0.9, 1, 1.1]}, figure: {backbone: spine}}
  alone: {kind: motion, tau_end: 5}
"""
    study = study_of_text(text, "t")
    names = {scene: scenes_drawn(study, study.scenes[scene]) for scene in study.scenes}
    assert names == {"spine": ["spine"], "under": ["spine", "under"], "alone": ["alone"]}


def test_the_hash_covers_what_fills_the_pages():
    files = {path.name for entry in DRAWN for path in _files(PACKAGE / entry)}
    assert {"template.typ", "report_data.py", "reporting.py", "exciter.py", "claims.py"} <= files


def test_scenes_that_others_draw_have_no_picture_of_their_own():
    text = """
title: One
exciter: {l: 0.5, nu: 1, f: -1}
scenes:
  a: {kind: motion, figure: {together: [b, c, d]}}
  b: {kind: motion}
  c: {kind: motion, figure: {pictures: [portrait]}}
  d: {kind: motion, figure: {together: [b]}}
"""
    study = study_of_text(text, "mine")
    assert list(figures_of(study)) == ["a", "c", "d"]
    assert scenes_drawn(study, study.scenes["d"]) == ["b", "d"]


STUDY = """
title: An exciter & its *laws*
description: |
  What the offset {{ does }}.

  More of it.
exciter: {l: 0.5, nu: 1, f: -1, h: 0.2, R1: 0.7, R2: 0.7}
scenes:
  one: {kind: motion, tau_end: 7, caption: 'Impacts {{ on }} *both*', samples_per_period: 16}
  two: {kind: motion, title: Two_, tau_end: 7, figure: {pictures: [panels, impacts]}, samples_per_period: 16}
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "config").mkdir()
    (tmp_path / "config" / "config.yaml").write_text("studies: [first]\n")
    (tmp_path / "config" / "first.yaml").write_text(STUDY)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_opening_page_says_what_each_study_is(folder):
    path = write_opening(read_run(None, {}))
    assert path == str(folder / ".snakemake/captions/opening.rst")
    lines = Path(path).read_text().splitlines()
    assert lines[:2] == ["Results of vibropipe", "=" * 20]
    assert lines[-2] == r"**An exciter \& its \*laws\***"
    assert lines[-1] == r"    What the offset \{\{ does \}\}\. 2 motion scenes, 3 figures."


def test_captions_are_text_whatever_marks_they_have_and_written_from_data(folder):
    run = read_run(None, {})
    # nothing is solved yet
    assert captions(run, "first") == {
        "one": r"Impacts \{\{ on \}\} \*both\*",
        "two": r"Two\_",
        "two-impacts": r"Two\_",
    }
    for name in ("one", "two"):
        solve_to_file(run.studies["first"], name, folder / f"results/first/{name}.nc", None, 1)
    found = captions(run, "first")
    assert found["one"] == r"Impacts \{\{ on \}\} \*both\*"
    assert "on support 1" in found["two"]
    assert found["two-impacts"].startswith("Velocity before each impact")
    files = caption_files(run)
    assert Path(files["first", "two"]).read_text() == found["two"] + "\n"


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["snakemake", "--report"], True),
        (["--report=a.html"], True),
        (["--report-stylesheet", "x"], False),
        (["results/first/report.pdf"], False),
    ],
)
def test_a_report_is_requested_by_its_option(arguments, expected):
    assert is_requested(arguments) == expected


def test_escaped_text_is_one_line():
    assert escaped("a\n b_.") == r"a b\_\."
