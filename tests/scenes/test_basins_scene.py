"""A scene of basins, from its keys to its picture and table."""

from __future__ import annotations

import numpy as np
import pytest
from drawing import draw, picture_of
from figures.figure_text import words

import vibropipe as vp
from vibropipe.cli import main
from vibropipe.figures.style import house_style
from vibropipe.jobs.verify import verify
from vibropipe.scenes.basins.basin_map import draw_basins
from vibropipe.scenes.basins.keys import BasinsFigure
from vibropipe.scenes.basins.text import describe_basins, sections
from vibropipe.study import StudyError, load_study

STUDY = """
title: Starts
exciter: {l: 0.5, nu: 3.48, f: 0.7, h: 0.1, delta: 0.1, R1: 0.8, R2: 0.8}
scenes:
  starts:
    kind: basins
    over:
      x0: {start: -0.4, stop: 0.6, points: 12}
      v0: {start: -2, stop: 2, points: 15}
    PHASE
"""


def study_in(tmp_path, more="starts: 64"):
    path = tmp_path / "starts.yaml"
    path.write_text(STUDY.replace("PHASE", more))
    return path


def run(*arguments):
    with pytest.raises(SystemExit) as end:
        main([str(argument) for argument in arguments])
    return end.value.code


@pytest.fixture(scope="module")
def dataset():
    exciter = vp.Exciter(l=0.5, nu=3.48, f=0.7, h=0.1, delta=0.1, R1=0.8, R2=0.8)
    return vp.basins(exciter, np.linspace(-0.4, 0.6, 40), np.linspace(-2, 2, 40), starts=64)


def test_from_yaml_to_report(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    path = study_in(tmp_path)
    assert run("plan", path) == 0
    assert "12 x0 x 15 v0" in capsys.readouterr().out
    output = "results/starts/starts.nc"
    assert run("solve", path, "--scene", "starts", "--output", output) == 0
    assert run("figure", path) == 0
    assert run("report", path, "--output", "results/starts/report.pdf") == 0
    assert all(verdict.good and verdict.checked for verdict in verify("results/starts"))
    stored = vp.open_study("results/starts")["starts"]
    exciter = vp.Exciter(**load_study(path).scenes["starts"].resolved_exciter())
    alone = vp.basins(exciter, stored.x0.values, stored.v0.values, starts=64)
    np.testing.assert_array_equal(stored.attractor, alone.attractor)
    np.testing.assert_array_equal(stored.floquet_multiplier, alone.floquet_multiplier)


@pytest.mark.parametrize(
    ("more", "must"),
    [
        ("phase: 1.5", "phase: must be a number from 0 to 1"),
        ("starts: 0", "starts: must be a whole number from 1"),
        ("exciter: {l: 0.3}", "over.x0: must be numbers from -0.19"),
    ],
)
def test_bad_keys_are_refused(tmp_path, more, must):
    with pytest.raises(StudyError, match=must):
        load_study(study_in(tmp_path, more))


def test_picture_names_every_attractor(dataset):
    with house_style():
        figure = draw_basins(dataset)
        shown = words(figure)
    for index, share in enumerate(dataset.basin_share.values):
        assert f"{index}: " in shown
        assert f"{100 * share:.3g} %" in shown
    assert describe_basins(dataset).count("on attractor") == 3


@pytest.mark.parametrize("name", ["attractor", "periods_to_attractor"])
def test_one_map_alone(dataset, name):
    options = BasinsFigure(show=[name])
    figure = draw("basins", dataset, options)
    has_basins = name == "attractor"
    # the map, and the bar of the periods
    assert len(figure.axes) == (1 if has_basins else 2)
    assert bool(figure.legends) == has_basins
    assert figure.axes[0].get_xlabel()
    caption = picture_of("basins", dataset).describe(dataset, options, {})
    assert ("on attractor" in caption) == has_basins
    assert ("Forcing periods until" in caption) == (not has_basins)
    assert "Above" not in caption


def test_picture_of_starts_without_an_attractor():
    free = vp.basins(vp.Exciter(l=0.5), [0.0, 0.1], [0.0, 1.0], starts=8)
    with house_style():
        shown = words(draw_basins(free))
    assert "no attractor found" in shown
    assert "No attractor was found." in describe_basins(free)
    assert sections({"free": free}) == []


def test_table_lists_every_attractor(dataset):
    (section,) = sections({"starts": dataset})
    table = section.tables[0].as_data()
    assert [row[0] for row in table["rows"]] == ["starts", "", ""]
    assert [row[2] for row in table["rows"]] == ["two-sided", "no impact", "one-sided, support 2"]
    assert [row[3] for row in table["rows"]] == ["1", "1", "3"]
    assert table["rows"][1][6] == "–"
