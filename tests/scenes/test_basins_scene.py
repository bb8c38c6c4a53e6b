"""A scene of basins, from its keys to its picture and table."""

from itertools import combinations

import numpy as np
import pytest
import xarray as xr
from command_line import run
from drawing import draw, picture_of
from figures.figure_text import words
from matplotlib.colors import to_rgba

import vibropipe as vp
from vibropipe.figures.canvas import axes, new_canvas
from vibropipe.figures.palette import FAILED, MIN_STEP, REGIME_STYLES, lightness
from vibropipe.figures.text import format_number
from vibropipe.jobs.solving import count_unresolved
from vibropipe.jobs.verify import verify
from vibropipe.scenes.basins import pictures
from vibropipe.scenes.basins.answers import (
    basin_answers,
    knock_answers,
    knock_text,
    safety_table,
    steps_text,
)
from vibropipe.scenes.basins.attractors import (
    at_rest,
    beside,
    beyond_map,
    distinct_colours,
    knocks_of,
    letters_of,
    ordered,
    reach,
    states_of,
    step_of,
)
from vibropipe.scenes.basins.basin_map import draw_basins
from vibropipe.scenes.basins.cut import join, row_range, store
from vibropipe.scenes.basins.keys import BasinsFigure, plan
from vibropipe.scenes.basins.motions_beside import motion_texts
from vibropipe.scenes.basins.pictures import draw_shares, title_basins, write_beside
from vibropipe.scenes.basins.report import (
    answers,
    describe_shares,
    rare_answer,
    tables,
    title_shares,
    together_answer,
)
from vibropipe.scenes.basins.text import describe_basins
from vibropipe.scenes.costs import PlanError
from vibropipe.scenes.registry import kinds
from vibropipe.store import StoreError, load, save
from vibropipe.study import StudyError, load_study, study_of_text
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


@pytest.fixture(scope="module")
def dataset():
    exciter = vp.Exciter(l=0.5, nu=3.48, f=0.7, h=0.1, delta=0.1, R1=0.8, R2=0.8)
    return vp.basins(exciter, np.linspace(-0.4, 0.6, 40), np.linspace(-2, 2, 40), starts=64)


def test_a_motion_that_does_not_repeat_is_known_in_a_window(dataset):
    assert "window" not in describe_basins(dataset)
    chaos = dataset.copy(deep=True)
    chaos["regime"][0], chaos["window_periods"][0] = Regime.APERIODIC, 128
    told = "Aperiodic: without repetition in a window of at least 128 forcing periods"
    assert told in describe_basins(chaos)


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
        ("exciter: {l: 0.3}", "over.x0: must be numbers from -0.2 to"),
    ],
)
def test_bad_keys_are_refused(more, must):
    with pytest.raises(StudyError, match=must):
        study_of_text(STUDY.replace("PHASE", more), "starts")


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
    scene = study_of_text(text, "starts").scenes["starts"]
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
    figure = draw_basins(dataset)
    shown = words(figure)
    for letter, motion in (("A", "no impact"), ("B", "both supports, once a period")):
        assert motion in shown
        assert {letter} <= {text.get_text() for ax in figure.axes for text in ax.texts}
    assert "support 2, every third period" in shown
    for share in dataset.basin_share.values:
        assert f"{100 * share:.1f}\u00a0%" in shown
    # the map, and a motion beside it for each attractor, between the supports
    assert len(figure.axes) == 4
    for ax in figure.axes[1:]:
        x = np.concatenate([line.get_ydata() for line in ax.lines])
        assert -0.4 - 1e-12 <= x.min() <= x.max() <= 0.6 + 1e-12
    assert max(np.ptp(ax.lines[0].get_ydata()) for ax in figure.axes[1:]) == pytest.approx(1.0)


@pytest.mark.parametrize("name", ["attractor", "periods_to_attractor"])
def test_one_map_alone(dataset, name):
    options = BasinsFigure(show=[name])
    figure = draw("basins", dataset, options)
    has_basins = name == "attractor"
    # the map with the motions, or with the bar of the periods
    assert len(figure.axes) == (4 if has_basins else 2)
    assert figure.axes[0].get_xlabel()
    picture = picture_of("basins", dataset)
    caption = picture.describe(dataset, options, {})
    assert ("the motion on which they settle" in caption) == has_basins
    assert ("Forcing periods until" in caption) == (not has_basins)
    assert "Below" not in caption
    assert bool(picture.title(dataset, options, {})) == has_basins
    both = picture.describe(dataset, BasinsFigure(show=["attractor", "periods_to_attractor"]), {})
    assert "Below: displacement of the motions" in both
    assert "The slowest start takes" in both


def test_picture_of_starts_without_an_attractor():
    free = vp.basins(vp.Exciter(l=0.5), [0.0, 0.1], [0.0, 1.0], starts=8)
    figure = draw_basins(free)
    assert len(figure.axes) == 1
    assert title_basins(free) == "No isolated motion was found on which the starts settle"
    assert describe_basins(free).endswith("for which no motion was found.")
    assert "period" not in describe_basins(free)
    assert "slowest" not in describe_basins(free, ("periods_to_attractor",))
    assert tables({"free": free}) == []
    (answer,) = answers({"free": free})["free"]
    assert answer.lead == "No isolated motion was found on which the starts settle."


def test_the_answers_are_shares_rest_and_the_smallest_knock(dataset):
    coexist, rest, knock = basin_answers(dataset)
    share = np.sort(dataset.basin_share.values)[::-1]
    assert coexist.lead == "At least three motions coexist."
    assert f"{100 * share[0]:.1f}\u00a0% of the starts settle on A (no impact)" in coexist.rest
    assert rest.lead == "Starts near rest settle on A (no impact)."
    assert f"{100 * float(dataset.border.mean()):.1f}\u00a0%" in rest.rest
    assert knock.lead == "Knocked at the beginning of a period, motion C is lost most easily."
    least = float(dataset.knock_impulse.min())
    told = knock.rest.removeprefix(
        "Of the impulses tried, the least that ended it is "
    ).removesuffix(".")
    assert least <= float(told) < 1.1 * least
    # they act at the section, at whatever phase the motions of the map start
    late = dataset.assign_coords(start_phase=0.25)
    assert basin_answers(late)[2] == knock
    assert "Impulse at the beginning of a period" in safety_table("s", late).note
    assert "at 0.25 of a forcing period" in describe_basins(late)
    dataset = dataset.drop_vars("knock_impulse")
    knock = basin_answers(dataset)[2]
    assert knock.lead == "Knocked at the beginning of a period, motion C is lost most easily."
    assert knock.rest.startswith("Beside its states, the map (steps of 0.103 in velocity)")
    others = dataset.isel(attractor_id=[0, 1])
    least = min(knocks_of(others).values())
    assert least > step_of(dataset)
    text = f"By the map, they survive knocks up to at least {knock_text(least, step_of(dataset))} in velocity"
    assert np.ptp(list(knocks_of(others).values())) < step_of(dataset)
    assert basin_answers(others)[2].rest.startswith(text)
    assert float(knock_text(least, step_of(dataset))) <= least


def test_all_starts_within_a_knock_lead_back(dataset):
    """Counted start by start: those next to the states in displacement, within the knock in velocity."""
    dataset = dataset.drop_vars("knock_impulse")
    x0, v0, step = dataset.x0.values, dataset.v0.values, step_of(dataset)
    knocks = knocks_of(dataset)
    assert min(knocks.values()) >= 0.0
    for index, knock in knocks.items():
        foreign = []
        for x, v in states_of(dataset, index):
            columns = [n for n in range(x0.size) if abs(x0[n] - x) < x0[1] - x0[0]]
            own = dataset.attractor.values[columns] == index
            inside = np.abs(v0 - v) <= knock
            assert own[:, inside].all()
            foreign.append(np.abs(v0 - v)[~own.all(axis=0)].min())
        # no more than a step further, one does not
        assert knock <= min(foreign) <= knock + 1.001 * step
    elsewhere = dataset.assign_coords(start_phase=0.25)
    assert all(np.isnan(list(knocks_of(elsewhere).values())))


def test_mirror_images_share_the_smaller_knock():
    """A and B of 9 x 9 starts, each the other one half a period later; a third motion differs in one amplitude."""
    x0, v0 = np.linspace(-0.4, 0.4, 9), np.linspace(-2.0, 2.0, 9)
    owner = np.where(v0 < 0.25, 1, 0) * np.ones((9, 1), int)
    several = ("attractor_id", "visit")
    dataset = xr.Dataset(
        {
            "attractor": (("x0", "v0"), owner),
            "basin_share": ("attractor_id", [0.4, 0.5, 0.1]),
            "period_multiple": ("attractor_id", [1, 1, 1]),
            "impacts_per_orbit": (
                ("attractor_id", "support"),
                [[1.0, 2.0], [2.0, 1.0], [2.0, 1.0]],
            ),
            "displacement_mean": ("attractor_id", [0.1, -0.1, -0.1]),
            "displacement_amplitude": (("attractor_id", "harmonic"), [[0.3], [0.3], [0.2]]),
            "poincare_displacement": (several, [[0.05], [-0.05], [0.9]]),
            "poincare_velocity": (several, [[0.8], [-0.6], [0.0]]),
        },
        {"x0": x0, "v0": v0, "attractor_id": [0, 1, 2], "start_phase": 0.0, "f": 1.0},
    )
    knocks = knocks_of(dataset)
    assert knocks[0] == knocks[1] == pytest.approx(0.7)  # B alone: 0.9
    assert np.isnan(knocks[2])
    (answer,) = knock_answers(dataset.isel(attractor_id=[0, 1]))
    assert (
        answer.lead
        == "Knocked at the beginning of a period, motions A and B are lost about equally easily."
    )
    assert "they survive knocks up to at least 0.7 in velocity (steps of 0.5)" in answer.rest
    dataset["displacement_mean"][1] = -0.11
    assert knocks_of(dataset)[1] == pytest.approx(0.9)
    # a knock to the end of the map may be longer: it is not the least
    dataset["poincare_velocity"][1] = -1.0
    assert beyond_map(dataset) == {1}
    (answer,) = knock_answers(dataset.isel(attractor_id=[0, 1]))
    assert answer.lead == "A knock at the beginning of a period may end motion B."


def test_a_knock_ends_at_the_end_of_the_map():
    v0 = np.linspace(-1.0, 1.0, 21)
    own = np.ones((2, 21), bool)
    assert reach(v0, own, 0.25) == (pytest.approx(0.75), True)
    own[1, 5] = False  # at -0.5
    assert reach(v0, own, 0.25) == (pytest.approx(0.65), False)
    assert np.isnan(reach(v0, own, 1.5)[0])
    # what is beyond the map is not known: no knock of a step is
    assert np.isnan(reach(v0, np.ones((1, 21), bool), 0.95)[0])
    assert np.isnan(reach(v0[:1], own[:, :1], v0[0])[0])
    assert beside(v0, 2.0).size == 0
    assert beside(v0, v0[3]).tolist() == [3]


def test_rest_is_told_only_where_its_neighbours_agree(dataset):
    index, is_start = at_rest(dataset)
    assert not is_start
    assert int(dataset.regime[index]) == Regime.NO_IMPACT
    mixed = dataset.assign(attractor=dataset.attractor.copy())
    near = [np.abs(mixed[name].values).argmin() for name in ("x0", "v0")]
    mixed.attractor[near[0], near[1]] = 2
    assert at_rest(mixed) == (None, False)
    assert at_rest(dataset.isel(x0=slice(0, 3))) == (None, False)
    assert at_rest(dataset.assign_coords(load=0.1)) == (None, False)
    assert at_rest(dataset.assign_coords(start_phase=0.25)) == (None, False)
    exact = dataset.assign_coords(
        x0=dataset.x0 - dataset.x0[near[0]], v0=dataset.v0 - dataset.v0[near[1]]
    )
    assert at_rest(exact) == (index, True)
    assert basin_answers(exact)[1].lead == "From rest it settles on A (no impact)."


def test_basins_that_share_a_regime_differ_in_lightness():
    names = ["two_sided_more", "two_sided_more", "no_impact", "two_sided"]
    colours = distinct_colours(names)
    assert [colours[0], *colours[2:]] == [
        REGIME_STYLES[name].colour for name in [names[0], *names[2:]]
    ]
    light = sorted(map(lightness, colours))
    assert np.diff(light).min() >= MIN_STEP


def test_many_attractors_have_letters_and_colours_of_their_own(dataset):
    many = dataset.isel(attractor_id=np.arange(30) % 3).assign_coords(attractor_id=np.arange(30))
    letters = letters_of(many)
    assert len(set(letters.values())) == 30
    assert {"A", "Z", "AA", "AD"} <= set(letters.values())
    assert len(distinct_colours(["two_sided"] * 7)) == 7


def test_table_lists_every_attractor(dataset):
    (table,) = tables({"starts": dataset})
    data = table.as_data()
    assert [row[0] for row in data["rows"]] == ["A", "B", "C"]
    assert [row[1] for row in data["rows"]] == [
        "no impact", "both supports, once a period", "support 2, every third period",
    ]  # fmt: skip
    assert data["rows"][0][4] == "–"
    assert (table.scene, len(table.head)) == ("starts", 6)


def test_forces_of_soft_supports_have_a_column(dataset):
    force = np.where([[True, True], [False, False], [False, True]], 12.5, np.nan)
    soft = describe(dataset.assign(support_force_max=(("attractor_id", "support"), force)))
    hard, table = tables({"starts": dataset, "soft": soft})
    assert hard.head[4] == "hardest impact"
    assert table.head[4] == "largest force"
    assert [row[4] for row in table.rows] == ["–", "12.5", "12.5"]


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
def over_omega():
    """Return a study of shares over a frequency in rad/s, and its datasets."""
    study = study_of_text(OVER, "shares")
    kind = kinds()
    return study, {name: kind[scene.kind].solve(scene) for name, scene in study.scenes.items()}


def test_shares_over_a_parameter_with_units(over_omega):
    study, datasets = over_omega
    data = datasets["shares"]
    assert data["attractor"].dims == ("omega", "x0", "v0")
    assert (data.omega.values[0], data.omega.attrs["units"]) == (80.0, "rad s-1")
    figure = draw("basins", data, study.scenes["shares"].figure, datasets)
    shown = words(figure)
    assert "rad/s" in shown
    letters = {text.get_text() for ax in figure.axes for text in ax.texts}
    assert {"A", "B"} <= letters
    caption = picture_of("basins", data).describe(data, study.scenes["shares"].figure, datasets)
    assert "unstable ones dashed" in caption
    (table,) = tables({"shares": data})
    assert table.head[2:4] == ["from (rad/s)", "to (rad/s)"]
    rows = table.as_data()["rows"]
    # The motion with impacts vanishes at the fold of its branch, the other one downwards at the grazing.
    branches = datasets["laws"]
    places = dict(
        zip(branches.bifurcation_kind.values, branches.bifurcation_omega.values, strict=True)
    )
    assert rows[0][1:4] == ["both supports, once a period", "–", f"{places[Bifurcation.FOLD]:.4g}"]
    assert rows[1][1:3] == ["no impact", f"{places[Bifurcation.GRAZING]:.4g}"]
    together, change, *_ = answers({"shares": data})["shares"]
    assert together.lead.startswith("The start decides which motion settles from ")
    assert f"vanishes at ω = {places[Bifurcation.FOLD]:.4g} rad/s and B follows." in change.rest
    table = vp.table(data)
    assert len(table) == int(data.basin_share.count())
    assert len(vp.table(data, impacts=True)) == data.sizes["impact"]


def test_pictures_of_a_parameter_are_drawn(over_omega):
    study, datasets = over_omega
    scene = study.scenes["shares"]
    for picture in kinds()["basins"].pictures_of(datasets["shares"], scene.figure.chosen()):
        figure = picture.draw(datasets["shares"], scene.figure, datasets)
        assert figure.axes
        assert "settle" in picture.describe(datasets["shares"], scene.figure, datasets).lower()


def test_letters_are_placed_once_the_limits_are_known(over_omega, monkeypatch):
    seen = []
    monkeypatch.setattr(pictures, "write_beside", lambda ax, *_: seen.append(ax.get_xlim()))
    figure = pictures.draw_shares(over_omega[1]["shares"].isel(omega=[0, 1]))
    assert seen == [figure.axes[0].get_xlim()]
    assert seen[0] == (80.0, 100.0)


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
def test_bad_keys_over_a_parameter_are_refused(old, new, must):
    with pytest.raises(StudyError, match=must):
        study_of_text(OVER.replace(old, new), "shares")


def test_lines_are_told_only_where_they_are_drawn(dataset):
    with_lines = dataset.assign(border=dataset.border * 0)
    crowded = dataset.assign(border=dataset.border * 0 + 1)
    assert "thin lines: the starts that approach them" in describe_basins(with_lines)
    assert "thin lines" not in describe_basins(crowded)
    assert "of those in the borders" in describe_basins(crowded)


def test_only_starts_without_an_attractor_are_unresolved(over_omega, tmp_path):
    data = over_omega[1]["shares"]
    assert (data.regime == Regime.UNRESOLVED).any()  # an attractor that is not there at a value
    lost = data.attractor.copy()
    lost[0, 0, :2] = -1
    for number, each in ((0, data), (2, data.assign(attractor=lost))):
        save(each, tmp_path / f"{number}.nc")
        assert count_unresolved(tmp_path / f"{number}.nc") == number


@pytest.mark.parametrize("over", [{"nu": [1.3, 1.5]}, {"h": [0.0, 0.1]}], ids=str)
def test_pictures_where_attractors_are_absent(over):
    """Without damping and loss nothing attracts: at no value, or at the first one."""
    data = vp.basins(vp.Exciter(l=0.5, f=0.3, nu=1.3), [0.0, 0.2], [0.0, 1.0], starts=16, over=over)
    for picture in kinds()["basins"].pictures_of(data, ("shares", "maps")):
        assert picture.draw(data, None, {}).axes
        assert "for which no motion was found" in picture.describe(data, None, {})
    found = answers({"over": data})["over"]
    if "nu" in over:
        assert [answer.lead for answer in found] == [
            "No isolated motion was found on which the starts settle."
        ]
        assert tables({"over": data}) == []
    else:
        assert ((data.bifurcation_h > 0) & (data.bifurcation_h < 1e-3)).all()
        assert found[1].lead == "Motions appear or vanish at one value of h or more."


@pytest.mark.parametrize("n", [0, 1])
def test_letters_keep_off_marks_the_frame_and_each_other(dataset, n):
    # of a motion whose basin is narrow the letter stands beside its mark, with a line to it
    narrow = dataset.copy(deep=True)
    narrow["attractor"][:] = n
    figure = draw_basins(narrow)
    figure.draw_without_rendering()
    ax = figure.axes[0]
    discs = [text.get_window_extent() for text in ax.texts if len(text.get_text()) == 1]
    marks = np.concatenate([states_of(narrow, index) for index in letters_of(narrow)])
    points = ax.transData.transform(marks)
    assert len(discs) == narrow.sizes["attractor_id"]
    frame = ax.get_window_extent()
    for disc in discs:
        assert not any(disc.contains(*point) for point in points)
        assert frame.x0 < disc.x0 < disc.x1 < frame.x1
        assert frame.y0 < disc.y0 < disc.y1 < frame.y1
    assert not any(a.overlaps(b) for a, b in combinations(discs, 2))


def test_letters_beside_points_keep_off_curves_each_other_and_the_frame():
    ax = axes(new_canvas(6.0), 1.4, 1.1, 14.3, 3.8, xlim=(0.0, 4.0), ylim=(0.0, 0.4))
    points = np.array([[1.5, 0.27], [1.5, 0.24], [3.5, 0.01], [3.5, 0.025], [4.0, 0.01]])
    sides = [(0.0, 9.0), (0.0, -10.0), (-9.0, 0.0), (9.0, 0.0)]
    at = {"E": (1.5, 0.27), "D": (1.5, 0.27), "H": (3.5, 0.01), "F": (4.0, 0.01)}
    write_beside(ax, points, [(letter, place, sides) for letter, place in at.items()])
    pixels = ax.figure.dpi / 72
    boxes = [text.get_window_extent() for text in ax.texts]
    centres = np.array([[(box.x0 + box.x1) / 2, (box.y0 + box.y1) / 2] for box in boxes])
    gaps = np.hypot(*(centres[:, None] - ax.transData.transform(points)).T)
    assert gaps.min() > 6.5 * pixels
    assert not any(one.overlaps(two) for one, two in combinations(boxes, 2))
    frame = ax.get_window_extent()
    assert all(frame.containsx(x) and frame.containsy(y) for x, y in centres)


def test_titles_say_what_the_start_decides(dataset):
    assert title_basins(dataset) == "The start decides whether the mass strikes a support"
    struck = dataset.copy(deep=True)
    struck["impacts_per_orbit"][:] = 1
    struck["regime"][:] = Regime.TWO_SIDED
    n = struck.sizes["attractor_id"]
    amount = {2: "two", 3: "three"}[n]
    struck["border"][:] = 0
    assert title_basins(struck) == f"The start decides which of {amount} motions settles"
    chaos = struck.copy(deep=True)
    chaos["regime"][0] = Regime.APERIODIC
    assert title_basins(chaos) == "The start decides whether the motion repeats itself"
    share = np.full(n, 0.0012)
    share[0] = 1.0 - share[1:].sum()
    rare = struck.assign(basin_share=("attractor_id", share))
    assert title_basins(rare).startswith("Few starts settle on B")
    assert "at most 0.2\u00a0%" in title_basins(rare)
    rare["border"][:] = 1
    assert title_basins(rare) == "Most starts have a neighbour that settles elsewhere"
    speeds = {
        "housing_velocity_mean": np.linspace(-0.1, 0.2, n),
        "housing_velocity_max": np.ones(n),
    }
    creeps = rare.assign({name: ("attractor_id", each) for name, each in speeds.items()})
    assert title_basins(creeps) == "The start decides which way the housing progresses"


@pytest.mark.parametrize(("n_x", "n_v"), [(1, 1), (1, 3), (3, 1)])
def test_one_start_and_one_row_of_starts(dataset, n_x, n_v):
    exciter = vp.Exciter(l=0.5, nu=3.48, f=0.7, h=0.1, delta=0.1, R1=0.8, R2=0.8)
    few = vp.basins(
        exciter, np.linspace(-0.1, 0.1, n_x + 2)[1:-1], np.linspace(-1, 1, n_v + 2)[1:-1], starts=64
    )
    for show in (["attractor"], ["periods_to_attractor"], ["attractor", "periods_to_attractor"]):
        figure = draw_basins(few, show)
        figure.draw_without_rendering()
        said = [text.get_text() for text in figure.axes[0].texts]
        is_map = show[0] == "attractor"
        letters = [each for each in said if len(each) == 1 and each.isupper()]
        assert len(letters) == is_map * len(np.unique(few["attractor"]))
        describe_basins(few, show)
    assert basin_answers(few)
    assert answers({"s": few})
    steps = {(1, 1): "", (1, 3): "0.5 apart. ", (3, 1): "0.05 apart. "}[n_x, n_v]
    assert steps_text(few) == ("Neighbours in the map are " + steps) * bool(steps)
    assert tables({"s": few})
    assert title_basins(few)


def test_the_steps_of_a_map_are_told_where_they_are_alike(dataset):
    step_x, step_v = (format_number(float(np.diff(dataset[name])[0]), 2) for name in ("x0", "v0"))
    told = f"Neighbours in the map are {step_x} or {step_v} apart. "
    assert steps_text(dataset) == told
    assert safety_table("s", dataset).note.startswith(told)
    assert steps_text(dataset.isel(x0=[0, 1, 5])) == ""


def test_a_motion_that_no_impulse_ends_has_no_column_of_them(dataset):
    none = dataset.assign(knock_impulse=np.nan * dataset["basin_share"])
    assert "impulse" not in " ".join(safety_table("s", none).head)
    assert "mpulse" not in safety_table("s", none).note
    some = none.copy(deep=True)
    some["knock_impulse"][0] = 0.3
    assert "least impulse that ends it" in safety_table("s", some).head


def test_a_mirror_image_is_told_as_one(dataset):
    exciter = vp.Exciter(l=0.5, nu=1.24, f=1.29, h=0.05, R1=0.9, R2=0.9)
    pair = vp.basins(exciter, np.linspace(-0.5, 0.5, 5), np.linspace(-2, 2, 5), starts=32)
    texts = motion_texts(pair, ordered(pair))
    assert texts[1] == "mirror image of A"
    assert "mirror" not in texts[0]
    assert not any("mirror" in text for text in motion_texts(dataset, ordered(dataset)))
    assert "Mirror images have one knock" in safety_table("s", pair).note
    unknown = pair.assign(knock_impulse=np.nan * pair["basin_share"])
    assert "knock" not in safety_table("s", unknown).note


PROVED_STUDY = """
title: Starts
exciter: {l: 0.5, nu: 1.8, f: 0.4, h: 0.15, R1: 0.7, R2: 0.6}
scenes:
  starts:
    kind: basins
    over:
      x0: {start: -0.5, stop: 0.5, points: 9}
      v0: {start: -1, stop: 1, points: 9}
    starts: 256
    prove: true
"""


@pytest.mark.slow
def test_proved_knocks_stand_in_the_table(tmp_path):
    pytest.importorskip("flint")
    scene = study_of_text(PROVED_STUDY, "starts.yaml").scenes["starts"]
    dataset = kinds()["basins"].solve(scene)
    low = dataset["knock_impulse_low"].values
    assert (low > 0.4).all()
    assert (low < dataset["knock_impulse"].values).all()
    table = safety_table("starts", dataset)
    column = [cell.startswith("proved impulse") for cell in table.head].index(True)
    told = sorted(float(row[column]) for row in table.rows)
    assert told == pytest.approx(np.sort(low), rel=5e-3)
    assert (np.array(told) <= np.sort(low)).all()
    assert "certainly lead back" in table.note


@pytest.mark.parametrize(
    ("exciter", "over", "must"),
    [
        ("friction: 0.05", "", "must be left out: the friction of the exciter is beyond"),
        ("mass_ratio: 0.2", "", "must be left out: the mass_ratio of the exciter is beyond"),
        ("h: 0.15", "nu: [1.8, 1.9]", "must be left out with nu in over"),
    ],
)
def test_proofs_of_knocks_that_are_none_are_refused(exciter, over, must):
    text = PROVED_STUDY.replace("h: 0.15", exciter)
    if over:
        text = text.replace("over:\n", f"over:\n      {over}\n").replace("nu: 1.8, ", "")
    with pytest.raises(StudyError, match=must):
        study_of_text(text, "starts.yaml")


def test_the_smallest_share_may_be_that_of_several_motions():
    exciter = vp.Exciter(l=0.5, nu=1.0, f=0.4, h=0.15, R1=0.7, R2=0.6)
    grid = np.linspace(-0.4, 0.4, 8), np.linspace(-1, 1, 8)
    basins = vp.basins(exciter, *grid, over={"nu": [1.6, 1.8]}, starts=16)
    assert basins.basin_share.dims == ("nu", "attractor_id")
    assert basins.basin_share.shape == (2, 2)

    def told(shares):
        basins["basin_share"][:] = shares
        answer = rare_answer(basins)
        return answer.lead, answer.rest

    assert told([[0.01, 0.99], [0.99, 0.01]]) == ("The smallest shares are those of A and B.", "")
    assert told([[0.01, 0.99], [0.01, 0.99]]) == ("The smallest share is that of A.", "")
    lead, rest = told([[0.5, 0.5], [1 / 64, 63 / 64]])
    assert lead == "The smallest share is that of A."
    assert rest == "At ν = 1.8, one of 64 starts settles on it."


def test_starts_that_friction_holds_are_red_and_told():
    """A force below the friction moves nothing: the band of the starts is that of no motion, and says why."""
    held = vp.Exciter(l=0.5, f=0.1, nu=1.0, h=0.1, R1=0.7, R2=0.7, friction=0.2)
    start = np.linspace(-0.4, 0.4, 3), np.linspace(-1.0, 1.0, 3)
    data = vp.basins(held, *start, starts=16, over={"f": [0.1, 0.3, 0.4]})
    assert (data.attractor < 0).mean(["x0", "v0"]).values.tolist() == [1.0, 0.0, 0.0]
    bands = draw_shares(data).axes[1].patches
    red = [each for each in bands if each.get_facecolor() == to_rgba(FAILED)]
    values, _edges, baseline = red[0].get_data()
    assert len(red) == 1
    assert np.subtract(values, baseline).tolist() == [1.0, 0.0, 0.0]
    text = describe_shares(data)
    assert (
        "Red: 33.3\xa0% of the starts, for which no motion was found. Where friction holds" in text
    )
    assert title_shares(data) == "At each value of f, at most one motion was found"
    (table,) = tables({"over": data})
    assert table.rows[0][-2] == "?, –"
    assert "?: none was found" in table.note


def test_motions_that_coexist_up_to_the_end_of_the_range_do_from_a_value_on():
    exciter = vp.Exciter(l=0.5, nu=1, f=0.4, h=0.15, R1=0.7, R2=0.6)
    starts = np.linspace(-0.5, 0.5, 8), np.linspace(-1.0, 1.0, 8)
    data = vp.basins(exciter, *starts, starts=64, over={"nu": [1.2, 1.4, 1.8, 2.2]})
    told = together_answer(data).lead
    assert told == "The start decides which motion settles from ν = 1.332 on."
