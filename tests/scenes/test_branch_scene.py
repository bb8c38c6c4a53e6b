"""Scenes of branches: keys, data, picture, table of bifurcations."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import vibropipe as vp
from vibropipe.figures.style import house_style
from vibropipe.jobs.solving import solve_to_file
from vibropipe.jobs.verify import verify
from vibropipe.scenes.registry import kind_of
from vibropipe.study import StudyError, load_study

STUDY = """
title: Branches
exciter: {l: 0.5, h: 0.2, R1: 0.7, R2: 0.7}
scenes:
  response:
    kind: branch
    along: {nu: {from: 1.05, to: [0.8, 3]}}
    over: {f: [0.25, 0.5]}
    at: [1, 2]
"""


def loaded(tmp_path: Path, text: str = STUDY):
    path = tmp_path / "laws.yaml"
    path.write_text(text)
    return load_study(path)


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    return loaded(tmp_path_factory.mktemp("laws")).scenes["response"]


@pytest.fixture(scope="module")
def dataset(scene):
    return kind_of(scene).solve(scene)


def test_branches_of_several_forces_stand_one_after_the_other(dataset):
    parts = [
        vp.branch(
            vp.Exciter(l=0.5, h=0.2, R1=0.7, R2=0.7, nu=1.05, f=f), "nu", (0.8, 3), at=(1, 2), harmonics=3
        )
        for f in (0.25, 0.5)
    ]  # fmt: skip
    first = parts[0].sizes["point"]
    for part, points in zip(parts, (slice(None, first), slice(first, None)), strict=True):
        joined = dataset.isel(point=points)
        assert np.array_equal(joined["nu"], part["nu"])
        assert np.array_equal(joined["displacement_amplitude"], part["displacement_amplitude"])
        assert np.array_equal(np.unique(joined["f"]), [float(part["f"])])
    assert dataset.sizes["impact"] == int(dataset["row_size"].sum())
    assert np.unique(dataset["branch_id"]).tolist() == list(
        range(int(dataset["branch_id"].max()) + 1)
    )
    at = dataset["bifurcation_point"].values
    assert np.array_equal(dataset["nu"].values[at], dataset["bifurcation_nu"])
    for value in (1.0, 2.0):
        assert (dataset["nu"] == value).any()


def test_the_picture_marks_what_the_data_hold(scene, dataset):
    (picture,) = kind_of(scene).pictures
    with house_style():
        figure = picture.draw(dataset, scene.figure, {})
    entries = [text.get_text() for legend in figure.legends for text in legend.get_texts()]
    kinds = {vp_kind for vp_kind in ("fold", "pitchfork", "grazing") if vp_kind in entries}
    codes = {"fold": 0, "pitchfork": 2, "grazing": 3}
    assert kinds == {
        name for name, code in codes.items() if (dataset["bifurcation_kind"] == code).any()
    }
    drawn = np.concatenate([line.get_xdata() for line in figure.axes[0].lines])
    assert set(dataset["bifurcation_nu"].values) <= set(drawn)
    # Unstable points are dotted and nothing else is.
    dotted = [
        line
        for line in figure.axes[0].lines
        if line.get_linestyle() == ":" or line._dash_pattern[1]
    ]
    unstable = dataset["nu"].values[dataset["stable"].values == 0]
    assert set(unstable) <= set(np.concatenate([line.get_xdata() for line in dotted]))
    caption = picture.describe(dataset, scene.figure, {})
    assert "fold" in caption
    assert "ν = " in caption


def test_the_table_lists_each_bifurcation(scene, dataset):
    (section,) = kind_of(scene).report.sections({"response": dataset})
    (table,) = section.tables
    assert len(table.rows) == dataset.sizes["bifurcation"]


def test_a_file_of_branches_is_verified(tmp_path):
    text = STUDY.replace("to: [0.8, 3]", "to: 1.2").replace("    at: [1, 2]\n", "")
    study = loaded(tmp_path, text)
    folder = tmp_path / "results" / "laws"
    solve_to_file(study, "response", folder / "response.nc", None, 1)
    (verdict,) = verify(folder)
    assert verdict.good
    assert verdict.checked


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("from: 1.05", "from: 0", "along.nu.from: must be a finite number > 0, got 0"),
        ("to: [0.8, 3]", "to: 1.05", "along.nu.to: must differ from `from` and from each other"),
        ("to: [0.8, 3]", "to: [0.8, 1, 3]", "along.nu.to: must be a number or a list of two, got a list of 3"),
        ("from: 1.05", "from: high", "along.nu.from: must be a finite number, got 'high'"),
        ("from: 1.05, ", "", "along.nu.from: is required (a finite number)"),
        ("to: [0.8, 3]", "till: 3", "along.nu.till: is an unknown key; must be from or to"),
        ("f: [0.25, 0.5]", "nu: [0.25, 0.5]", "over.nu: must be left out, since nu is followed"),
        ("f: [0.25, 0.5]", "R1: [0.25, 1.5]", "over.R1: must be a number from 0 to 1"),
        ("at: [1, 2]", "at: [1, 4]", "at: must be values from 0.8 to 3.0, got 1.0 to 4.0"),
        ("at: [1, 2]", "switch: [turn]", "switch[0]: must be"),
        ("{l: 0.5, h: 0.2,", "{h: 0.2,", "exciter.l: is required"),
        ("at: [1, 2]", "start: {x0: 0.6}", "start.x0: must be"),
        ("at: [1, 2]", "exciter: {nu: 1}", "exciter.nu: must be left out, since it stands in along"),
        ("at: [1, 2]", "figure: {backbone: free}", "figure.backbone: must be a backbone scene"),
    ],
)  # fmt: skip
def test_a_wrong_key_is_named(tmp_path, old, new, message):
    with pytest.raises(StudyError) as error:
        loaded(tmp_path, STUDY.replace(old, new))
    assert f"scenes.response.{message}" in str(error.value)
