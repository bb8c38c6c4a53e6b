"""A scene of basins, from its keys to its picture and table."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from drawing import draw, picture_of
from figures.figure_text import words

import vibropipe as vp
from vibropipe.cli import main
from vibropipe.figures.style import house_style
from vibropipe.jobs.solving import count_unresolved
from vibropipe.jobs.verify import verify
from vibropipe.scenes.basins.basin_map import draw_basins
from vibropipe.scenes.basins.cut import join, row_range, store
from vibropipe.scenes.basins.keys import BasinsFigure
from vibropipe.scenes.basins.plan import plan
from vibropipe.scenes.basins.text import describe_basins, findings, sections
from vibropipe.scenes.costs import PlanError
from vibropipe.scenes.registry import kinds
from vibropipe.store import StoreError, load, write
from vibropipe.study import StudyError, load_study
from vibropipe.words.bifurcations import Bifurcation
from vibropipe.words.regimes import Regime
from vibropipe.words.vocabulary import describe

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


@pytest.mark.parametrize(
    "keys",
    [
        pytest.param("", id="one exciter"),
        # values between 1 and 3.6 with other attractors each, and starts that are left to the join
        pytest.param("over: {nu: {start: 1, stop: 3.6, points: 3}, GRID}", id="over nu"),
        pytest.param("UNITS", marks=pytest.mark.slow),
    ],
)
def test_shards_of_starts_join_to_the_whole(tmp_path, keys):
    text = STUDY.replace("PHASE", "starts: 30\n    phase: 0.3")
    if "GRID" in keys:
        grid = "x0: {start: -0.4, stop: 0.5, points: 12}, v0: {start: -2, stop: 2, points: 15}"
        begin, end = text.index("    over:"), text.index("    starts:")
        text = f"{text[:begin]}    {keys.replace('GRID', grid)}\n{text[end:]}"
    if keys == "UNITS":
        text = """
title: Starts
physical: {m: 2 kg, C: 8 N/mm, H: 12 N s/m, l: 8 mm, F: 60 N, omega: 220 rad/s}
exciter: {R1: 0.8, R2: 0.8}
scenes:
  starts:
    kind: basins
    over: {x0: {start: -8 mm, stop: 8 mm, points: 12}, v0: {start: -1.5 m/s, stop: 1.5 m/s, points: 15}}
    starts: 30
"""
    path = tmp_path / "starts.yaml"
    path.write_text(text, encoding="utf-8")
    scene = load_study(path).scenes["starts"]
    attrs = {"fingerprint": scene.fingerprint(), "method": "exact"}
    store(scene, tmp_path / "whole.nc", attrs)
    parts, told = [tmp_path / f"{n}.nc" for n in (1, 2, 3, 4)], []
    for n, part in enumerate(parts, 1):
        store(scene, part, attrs, (n, 4), lambda *done: told.append(done))
    ends = [row_range(scene, n, 4) for n in (1, 2, 3, 4)]
    assert [done[1] for done in told if done[0] == done[1]] == [end - begin for begin, end in ends]
    join(scene, parts[::-1], tmp_path / "joined.nc", attrs)
    whole, joined = load(tmp_path / "whole.nc"), load(tmp_path / "joined.nc")
    xr.testing.assert_identical(whole, joined)
    for name, variable in whole.variables.items():
        assert variable.values.tobytes() == joined[name].values.tobytes(), name
    with pytest.raises(StoreError, match="solve the shards that hold them"):
        join(scene, parts[:3], tmp_path / "joined.nc", attrs)
    with pytest.raises(StoreError, match="shard of another study"):
        join(scene, parts, tmp_path / "joined.nc", {**attrs, "fingerprint": "other"})


def test_a_scene_has_no_more_shards_than_it_pays_for(tmp_path):
    scene = load_study(study_in(tmp_path, "starts: 64")).scenes["starts"]
    assert plan(scene).pieces == 12 * 15 // 64
    with pytest.raises(PlanError, match=r"scenes\.starts: must be cut into 1 to 2 shards, got 3"):
        row_range(scene, 1, 3)


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
    assert describe_basins(free).endswith(" until it settles. No attractor was found.")
    assert "slowest" not in describe_basins(free, ("periods_to_attractor",))
    assert sections({"free": free}) == []


def test_table_lists_every_attractor(dataset):
    (section,) = sections({"starts": dataset})
    table = section.tables[0].as_data()
    assert [row[0] for row in table["rows"]] == ["starts", "", ""]
    assert [row[2] for row in table["rows"]] == ["two-sided", "no impact", "one-sided, support 2"]
    assert [row[3] for row in table["rows"]] == ["1", "1", "3"]
    assert table["rows"][1][6] == "–"


def test_forces_of_soft_supports_have_a_column(dataset):
    force = np.where([[True, True], [False, False], [False, True]], 12.5, np.nan)
    soft = describe(dataset.assign(support_force_max=(("attractor_id", "support"), force)))
    (section,) = sections({"starts": dataset, "soft": soft})
    table = section.tables[0]
    assert table.head[-2:] == ["force", "share"]
    assert [row[7] for row in table.rows] == ["–", "–", "–", "12.5", "–", "12.5"]
    assert "largest force of a soft support, and share" in table.note


OVER = """
title: Shares
physical: {m: 2 kg, C: 8 N/mm, H: 40 N s/m, l: 8 mm, F: 60 N}
exciter: {R1: 0.7, R2: 0.7}
scenes:
  shares:
    kind: basins
    over:
      omega: {start: 80 rad/s, stop: 140 rad/s, points: 4}
      x0: {start: -8 mm, stop: 8 mm, points: 8}
      v0: {start: -1 m/s, stop: 1 m/s, points: 9}
    starts: 32
    figure: {pictures: [shares, maps], branches: laws}
  laws: {kind: branch, along: {omega: {from: 81 rad/s, to: [80 rad/s, 140 rad/s]}}}
"""


@pytest.fixture(scope="module")
def over_omega(tmp_path_factory):
    """Return a study of shares over a frequency in rad/s, and its datasets."""
    path = tmp_path_factory.mktemp("shares") / "shares.yaml"
    path.write_text(OVER)
    study = load_study(path)
    kind = kinds()
    return study, {name: kind[scene.kind].solve(scene) for name, scene in study.scenes.items()}


def test_shares_over_a_parameter_with_units(over_omega):
    study, datasets = over_omega
    data = datasets["shares"]
    assert data["attractor"].dims == ("omega", "x0", "v0")
    assert (data.omega.values[0], data.omega.attrs["units"]) == (80.0, "rad s-1")
    with house_style():
        figure = draw("basins", data, study.scenes["shares"].figure, datasets)
        shown = words(figure)
    assert "two-sided" in shown
    assert "unstable orbit" in shown
    assert "rad/s" in shown
    (section,) = sections({"shares": data})
    rows = section.tables[0].as_data()["rows"]
    # The motion with impacts vanishes at the fold of its branch, the other one downwards at the grazing.
    branches = datasets["laws"]
    places = dict(
        zip(branches.bifurcation_kind.values, branches.bifurcation_omega.values, strict=True)
    )
    assert rows[0][3].startswith(f"{places[Bifurcation.FOLD]:.4g} rad/s")
    assert rows[1][2].startswith(f"{places[Bifurcation.GRAZING]:.4g} rad/s")
    (finding,) = findings({"shares": data})
    assert "vanishes at" in finding.texts[1]
    table = vp.table(data)
    assert len(table) == int(data.basin_share.count())
    assert len(vp.table(data, impacts=True)) == data.sizes["impact"]


def test_pictures_of_a_parameter_are_drawn(over_omega):
    study, datasets = over_omega
    scene = study.scenes["shares"]
    for picture in kinds()["basins"].pictures_of(datasets["shares"], scene.figure.chosen()):
        with house_style():
            figure = picture.draw(datasets["shares"], scene.figure, datasets)
        assert figure.legends
        assert "attractor" in picture.describe(datasets["shares"], scene.figure, datasets).lower()


@pytest.mark.parametrize(
    ("old", "new", "must"),
    [
        ("x0: {start: -8 mm, stop: 8 mm, points: 8}", "", "over.x0: is required"),
        ("R1: 0.7", "R1: 0.7, delta: 2 mm", "delta"),
        ("branches: laws", "branches: shares", "figure.branches: must be a branch scene along"),
        ("[shares, maps]", "[basins]", "figure.pictures: must be chosen without a parameter"),
        ("pictures: [shares, maps]", "show: [attractor]", "figure.show: must be left out"),
        ("v0: {", "R1: [0.5, 0.6]\n      v0: {", "at most one parameter"),
    ],
)
def test_bad_keys_over_a_parameter_are_refused(tmp_path, old, new, must):
    path = tmp_path / "shares.yaml"
    path.write_text(OVER.replace(old, new))
    with pytest.raises(StudyError, match=must):
        load_study(path)


def test_lines_are_told_only_where_they_are_drawn(dataset):
    with_lines = dataset.assign(border=dataset.border * 0)
    crowded = dataset.assign(border=dataset.border * 0 + 1)
    assert "lines separate basins" in describe_basins(with_lines)
    assert "lines separate basins" not in describe_basins(crowded)
    assert "of those that the borders contain" in describe_basins(crowded)


def test_only_starts_without_an_attractor_are_unresolved(over_omega, tmp_path):
    data = over_omega[1]["shares"]
    assert (data.regime == Regime.UNRESOLVED).any()  # an attractor that is not there at a value
    lost = data.attractor.copy()
    lost[0, 0, :2] = -1
    for number, each in ((0, data), (2, data.assign(attractor=lost))):
        write(each, tmp_path / f"{number}.nc")
        assert count_unresolved(tmp_path / f"{number}.nc") == number


@pytest.mark.parametrize("over", [{"nu": [1.3, 1.5]}, {"h": [0.0, 0.1]}], ids=str)
def test_pictures_where_attractors_are_absent(over):
    """Without damping and loss nothing attracts: at no value, or at the first one."""
    data = vp.basins(vp.Exciter(l=0.5, f=0.3, nu=1.3), [0.0, 0.2], [0.0, 1.0], starts=16, over=over)
    for picture in kinds()["basins"].pictures_of(data, ("shares", "maps")):
        with house_style():
            shown = words(picture.draw(data, None, {}))
        assert "no attractor found" in shown
    texts = findings({"over": data})[0].texts
    if "nu" in over:
        assert texts == ["No attractor was found."]
        assert sections({"over": data}) == []
    else:
        assert ((data.bifurcation_h > 0) & (data.bifurcation_h < 1e-3)).all()
        assert "settle on none of them" in picture.describe(data, None, {})
