"""Scenes of level curves: keys, data, values on the lines, words, and wrong keys."""

import itertools
import re

import numpy as np
import pytest
from figures.figure_text import words

import vibropipe as vp
from vibropipe.scenes.boundary.pictures import draw_boundaries
from vibropipe.scenes.boundary.report import answers, tables
from vibropipe.scenes.boundary.text import describe_boundaries
from vibropipe.scenes.registry import kind_of
from vibropipe.study import StudyError, study_of_text

STUDY = """
title: Levels
exciter: {l: 0.5, h: 0.2, R1: 0.7, R2: 0.7}
scenes:
  regimes: {kind: sweep, over: {nu: {start: 0.8, stop: 2, points: 12}, f: {start: 0.05, stop: 1, points: 10}}}
  borders:
    kind: boundary
    of: [fold, {impact_velocity_max_1: 0.5}, {displacement_amplitude_1: 0.3}]
    over: {nu: [0.8, 2], f: [0.05, 1]}
    lines: 3
    figure: {map: regimes}
"""
PHYSICAL = """
title: Levels with units
units: {velocity: mm/s}
physical: {m: 2 kg, C: 8 N/mm, H: 40 N s/m, l: 8 mm}
exciter: {R1: 0.7, R2: 0.7}
scenes:
  borders:
    kind: boundary
    of: [{impact_velocity_max_1: 0.4 m/s}]
    over: {omega: [70 rad/s, 120 rad/s], F: [30 N, 90 N]}
    lines: 2
"""
WORDS = "largest impact velocity at support 1"


@pytest.fixture(scope="module")
def study():
    return study_of_text(STUDY, "levels")


@pytest.fixture(scope="module")
def datasets(study):
    return {name: kind_of(scene).solve(scene) for name, scene in study.scenes.items()}


def test_a_scene_is_the_call(study, datasets):
    exciter = vp.Exciter(l=0.5, h=0.2, R1=0.7, R2=0.7)
    sought = study.scenes["borders"].sought
    assert {"displacement_amplitude_1": 0.3} in sought
    called = vp.boundary(exciter, sought, within=((0.8, 2), (0.05, 1)), lines=3)
    for name in ("nu", "f", "curve_id", "boundary_kind", "level_of", "meeting_kind", "stable"):
        assert np.array_equal(datasets["borders"][name], called[name])


def test_the_order_of_levels_is_no_part_of_the_data(study):
    listed = "[fold, {impact_velocity_max_1: 0.5}, {displacement_amplitude_1: 0.3}]"
    turned = "[{displacement_amplitude_1: 0.3}, {impact_velocity_max_1: 0.5}, fold]"
    other = study_of_text(STUDY.replace(listed, turned), "levels")
    own = study.scenes["borders"].fingerprint()
    assert other.scenes["borders"].fingerprint() == own
    changed = study_of_text(STUDY.replace("max_1: 0.5", "max_1: 0.6"), "levels")
    assert changed.scenes["borders"].fingerprint() != own


def test_values_stand_on_their_lines(study, datasets):
    scene, dataset = study.scenes["borders"], datasets["borders"]
    (picture,) = kind_of(scene).pictures
    figure = picture.draw(dataset, scene.figure, datasets)
    (ax,) = figure.axes
    values = {text.get_text(): text for text in ax.texts if " = " in text.get_text()}
    assert len(values) == 2
    assert any("A_1" in text and text.endswith("= 0.3") for text in values)
    places = ax.transData.transform(np.column_stack([dataset.nu, dataset.f]))
    for text, label in values.items():
        own = dataset["level_of"].values == (0 if text.endswith("= 0.3") else 1)
        box = label.get_window_extent()
        gaps = np.maximum(np.maximum(box.min - places, places - box.max), 0.0)
        away = np.hypot(*gaps.T) / figure.dpi * 2.54
        assert away[own].min() < 0.4  # cm
        assert away[own].min() < away[~own].min()  # it is nearer to its line than to any other
    boxes = [text.get_window_extent() for text in ax.texts]
    assert not any(one.overlaps(two) for one, two in itertools.combinations(boxes, 2))
    (legend,) = figure.legends
    entries = {
        text.get_text(): line
        for text, line in zip(legend.get_texts(), legend.get_lines(), strict=True)
    }
    assert entries["level"].get_color() != entries["fold"].get_color()
    caption = picture.describe(dataset, scene.figure, datasets)
    assert f"{WORDS} = 0.5" in caption
    assert "amplitude of harmonic 1 = 0.3" in caption
    assert picture.title(dataset, scene.figure, datasets) == (
        f"Motions change at folds; levels of amplitude of harmonic 1 and {WORDS}"
    )


def test_answers_and_tables_name_the_level(datasets):
    dataset = datasets["borders"]
    leads = [answer.lead for answer in answers({"borders": dataset})["borders"]]
    assert f"Along at least one curve the {WORDS} is 0.5." in leads
    (table,) = tables({"borders": dataset})
    assert f"{WORDS} = 0.5" in [row[0] for row in table.rows]


def test_pieces_of_a_level_that_touch_are_one_curve(datasets):
    dataset = datasets["borders"]
    ids = dataset["curve_id"].values
    level = int(ids[dataset["level_of"].values == 0][0])
    points = np.flatnonzero(ids == level)
    cut = points[points.size // 2]
    index = np.insert(
        np.arange(ids.size), cut + 1, cut
    )  # the law changes at a point that both have
    pieces = dataset.isel(point=index)
    changed = np.where((index >= cut) & (ids[index] == level), ids.max() + 1, ids[index])
    changed[cut] = level
    pieces["curve_id"] = "point", changed
    told = [[a.lead for a in answers({"s": data})["s"]] for data in (dataset, pieces)]
    level_leads = [[lead for lead in leads if lead.startswith("Along ")] for leads in told]
    assert level_leads[0] == level_leads[1]
    apart = pieces.isel(point=np.delete(np.arange(index.size), cut))  # with a gap between both
    leads = [answer.lead for answer in answers({"s": apart})["s"]]
    assert any(lead.startswith("Along at least two curves") for lead in leads)


def test_levels_are_shown_in_units_of_the_study():
    study = study_of_text(PHYSICAL, "levels")
    scene = study.scenes["borders"]
    dataset = kind_of(scene).solve(scene)
    assert dataset.attrs["levels"] == "impact_velocity_max_1 = 0.4 m s-1"
    np.testing.assert_allclose(dataset.impact_velocity_max.sel(support=1), 0.4, rtol=1e-10)
    (shown,) = study.shown({"borders": dataset}).values()
    (picture,) = kind_of(scene).pictures
    assert picture.title(shown, scene.figure, {}) == f"Where the {WORDS} is 400 mm/s"
    figure = picture.draw(shown, scene.figure, {})
    assert any(text.get_text().endswith("= 400 mm/s") for text in figure.axes[0].texts)


def test_a_level_that_no_motion_has_is_told_of():
    text = STUDY.replace("[fold, {impact_velocity_max_1: 0.5}, {displacement_amplitude_1: 0.3}]",
                         "[{impact_velocity_max_1: 50}]")  # fmt: skip
    scene = study_of_text(text, "levels").scenes["borders"]
    dataset = kind_of(scene).solve(scene)
    assert dataset.sizes["point"] == 0
    (answer,) = answers({"borders": dataset})["borders"]
    absent = f"No curve of {WORDS} = 50 is found within the ranges that were searched."
    assert answer.lead == absent
    beside = study_of_text(text.replace("[{impact", "[fold, {impact"), "levels").scenes["borders"]
    with_folds = kind_of(beside).solve(beside)
    told = answers({"borders": with_folds})["borders"]
    assert told[-1].lead == absent
    levels = describe_boundaries(with_folds, show=["level"])
    assert f"No curve of {WORDS} = 50 is found. Not drawn: fold" in levels
    assert "No such curve is found" in words(draw_boundaries(with_folds, show=["level"]))


@pytest.mark.parametrize(
    ("level", "message"),
    [
        ("{}", "of[1]: must be fold, flip, pitchfork, grazing or a quantity with its value"),
        ("{impact_velocity_max_1: }", "of[1]: must be a finite number for impact_velocity_max_1, got nothing"),
        ("{impact_velocity_max_1: 0.8 m/s}", "no unit belongs here: quantities with units go with `physical`"),
        ("{impact_velocity_max: 1}", "of[1].impact_velocity_max: must be one of impact_velocity_max_1"),
        ("{impact_velocity_max_1: -1}", "of[1].impact_velocity_max_1: must be >= 0"),
        ("{housing_velocity_mean: 0}", "exciter.mass_ratio: must be above 0, since housing_velocity_mean is wanted"),
        ("fold", "of: must have each name once"),
    ],
)  # fmt: skip
def test_a_wrong_level_is_named(level, message):
    with pytest.raises(StudyError, match=re.escape(message)):
        study_of_text(STUDY.replace("{impact_velocity_max_1: 0.5}", level), "levels")


@pytest.mark.parametrize(
    ("level", "message"),
    [
        ("0.4", "of[0].impact_velocity_max_1: must be a velocity with its unit, such as 0.3 m/s, got 0.4"),
        ("0.4 mm", "of[0].impact_velocity_max_1: must be a velocity with its unit, such as 0.3 m/s, got '0.4 mm'"),
    ],
)  # fmt: skip
def test_a_level_with_a_wrong_unit_is_named(level, message):
    with pytest.raises(StudyError) as error:
        study_of_text(PHYSICAL.replace("0.4 m/s", level), "levels")
    assert message in str(error.value)
    assert len(error.value.problems) == 1


def test_only_kinds_that_are_sought_are_shown():
    with pytest.raises(
        StudyError,
        match=re.escape("figure.show: must be a kind of curve that `of` has (fold, level)"),
    ):
        study_of_text(STUDY.replace("{map: regimes}", "{show: [grazing]}"), "levels")
