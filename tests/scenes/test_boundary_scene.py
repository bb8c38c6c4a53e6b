"""Scenes of boundaries: keys, data, picture, table of curves."""

import re

import numpy as np
import pytest
import xarray as xr
from figures.figure_text import words
from figures.sample_datasets import sweep
from matplotlib.collections import QuadMesh
from matplotlib.contour import ContourSet

import vibropipe as vp
from vibropipe.figures.motion_words import amount_text
from vibropipe.scenes.boundary.pictures import draw_boundaries, ends_of_axis
from vibropipe.scenes.boundary.report import (
    answers,
    end_text,
    far_text,
    lengths_of,
    place_text,
    tables,
)
from vibropipe.scenes.boundary.solve import in_box
from vibropipe.scenes.boundary.text import UNMARKED, meetings_text
from vibropipe.scenes.registry import kind_of
from vibropipe.scenes.sweep.laws import regions_of
from vibropipe.study import StudyError, study_of_text
from vibropipe.words.quantities import FLAGS

CURVE = {
    "curve_id": ("point", [0, 0]),
    "boundary_kind": ("point", [FLAGS["boundary_kind"]["fold"]] * 2),
    "meeting_point": ("meeting", [0]),
    "stable": ("point", [1, 1]),
}

STUDY = """
title: Borders
exciter: {l: 0.5, h: 0.2, R1: 0.7, R2: 0.7}
scenes:
  regimes: {kind: sweep, over: {nu: {start: 0.8, stop: 2, points: 12}, f: {start: 0.05, stop: 1, points: 10}}}
  borders:
    kind: boundary
    of: [grazing, pitchfork, fold]
    over: {nu: [0.8, 2], f: [0.05, 1]}
    lines: 4
    figure: {map: regimes}
"""


@pytest.fixture(scope="module")
def study():
    return study_of_text(STUDY, "laws")


@pytest.fixture(scope="module")
def datasets(study):
    return {name: kind_of(scene).solve(scene) for name, scene in study.scenes.items()}


def test_a_place_nearer_to_0_than_its_digits_is_0():
    """As of curves that meet on the axis of symmetry, where their ends are located to 1e-6 of the range."""
    columns = {"nu": ("point", [1.2, 2.0]), "delta": ("point", [-2e-6, 0.4])}
    near = xr.Dataset(columns, attrs={"boundary": "nu delta"})
    assert place_text(near, 0) == "(1.2, 0)"
    near.delta[0] = 2e-4
    assert place_text(near, 0) == "(1.2, 0.0002)"


def test_a_scene_is_the_call(study, datasets):
    exciter = vp.Exciter(l=0.5, h=0.2, R1=0.7, R2=0.7)
    called = vp.boundary(
        exciter, ("fold", "grazing", "pitchfork"), within=((0.8, 2), (0.05, 1)), lines=4
    )
    for name in ("nu", "f", "curve_id", "boundary_kind", "meeting_kind", "stable"):
        assert np.array_equal(datasets["borders"][name], called[name])


def test_the_order_of_kinds_is_no_part_of_the_data(study):
    other = study_of_text(
        STUDY.replace("[grazing, pitchfork, fold]", "[fold, grazing, pitchfork]"), "laws"
    )
    swapped = study_of_text(
        STUDY.replace("{nu: [0.8, 2], f: [0.05, 1]}", "{f: [0.05, 1], nu: [0.8, 2]}"), "laws"
    )
    own = study.scenes["borders"].fingerprint()
    assert other.scenes["borders"].fingerprint() == own
    assert swapped.scenes["borders"].fingerprint() != own


def test_the_picture_draws_every_curve_over_the_regimes(study, datasets):
    scene, dataset = study.scenes["borders"], datasets["borders"]
    (picture,) = kind_of(scene).pictures
    figure = picture.draw(dataset, scene.figure, datasets)
    entries = [text.get_text() for legend in figure.legends for text in legend.get_texts()]
    assert {"grazing", "fold", "pitchfork"} <= set(entries)
    assert "flip" not in entries
    (ax,) = figure.axes
    drawn = np.concatenate([line.get_xdata() for line in ax.lines])
    assert set(dataset["nu"].values) <= set(drawn)
    assert sum(isinstance(each, QuadMesh) for each in ax.collections) == 1
    assert any(getattr(each, "hatches", None) for each in ax.collections)  # told apart in grey
    # what settles is named on the map
    shown = {text.get_text() for text in ax.texts}
    assert {"no impact", "each support struck once a period"} & shown
    caption = picture.describe(dataset, scene.figure, datasets)
    assert "curve: " not in caption  # the answer has their number
    assert "curves: " not in caption
    assert "Motions change at " in picture.title(dataset, scene.figure, datasets)
    assert not picture.draw(dataset, None, {}).axes[0].collections


def test_the_table_lists_each_curve(datasets):
    dataset = datasets["borders"]
    (table,) = tables({"borders": dataset})
    assert len(table.rows) == np.unique(dataset["curve_id"]).size
    first, _last = np.flatnonzero(dataset["curve_id"].values == dataset["curve_id"].values[0])[
        [0, -1]
    ]
    assert (
        table.rows[0][2] == f"({float(dataset['nu'][first]):.4g}, {float(dataset['f'][first]):.4g})"
    )
    assert any(row[0] == "grazing" and row[1] == "no impact" for row in table.rows)
    assert end_text("box") == "end of the range"
    one = dataset.isel(point=dataset["curve_id"].values == dataset["curve_id"].values[0])
    n = one.sizes["point"]
    back = one.isel(point=[*range(n), *range(n - 2, -1, -1)])
    turned = f"({float(one['nu'][-1]):.4g}, {float(one['f'][-1]):.4g})"
    assert far_text(back, 0, 2 * n - 2) == f"back, turning at {turned}"
    assert far_text(one, 0, n - 1) == turned


def test_the_table_has_what_a_curve_meets_between_its_ends(datasets):
    dataset = datasets["borders"]
    kind = FLAGS["meeting_kind"]["grazing_fold"]
    at = np.flatnonzero(dataset["meeting_ends"].values)[-1]
    inside = dataset.copy(deep=True)
    inside["meeting_ends"][at], inside["meeting_kind"][at] = 0, kind
    (table,) = tables({"borders": inside})
    place = ", ".join(f"{float(inside[f'meeting_{name}'][at]):.4g}" for name in ("nu", "f"))
    assert f"grazing and fold at ({place})" in table.note


def test_a_closed_curve_ends_where_it_begins(datasets):
    dataset = datasets["borders"]
    one = dataset.isel(point=dataset["curve_id"].values == dataset["curve_id"].values[0])
    n = one.sizes["point"]
    loop = one.isel(point=[*range(n), *range(n - 2, -1, -1)], meeting=slice(0))
    (table,) = tables({"loop": loop})
    (row,) = table.rows
    assert row[2] == row[4]
    assert row[3] == row[5] == "closed"


def test_the_curves_left_out_are_the_shortest_in_the_plane():
    nu = np.concatenate([np.linspace(1.0, 2.0, 3), np.linspace(1.0, 1.1, 50)])
    dataset = xr.Dataset(
        {"curve_id": ("point", [0] * 3 + [1] * 50)}, {"nu": ("point", nu), "f": ("point", 0 * nu)}
    )
    lengths = lengths_of(dataset.assign_attrs(boundary="nu f"))
    assert lengths[0] == pytest.approx(1.0)
    assert lengths[1] == pytest.approx(0.1)


def test_a_box_without_curves_is_drawn():
    text = STUDY.replace("f: [0.05, 1]}", "f: [0.05, 0.06]}").replace(
        "    figure: {map: regimes}\n", ""
    )
    scene = study_of_text(text.replace("nu: [0.8, 2]", "nu: [1.8, 2]"), "laws").scenes["borders"]
    dataset = kind_of(scene).solve(scene)
    assert dataset.sizes["point"] == 0
    (picture,) = kind_of(scene).pictures
    figure = picture.draw(dataset, scene.figure, {})
    (ax,) = figure.axes
    assert "No curve is found" in words(figure)
    assert (ax.get_xlim(), ax.get_ylim()) == ((1.8, 2.0), (0.05, 0.06))
    text = "No curve of fold, grazing or pitchfork is found"
    assert text in picture.describe(dataset, scene.figure, {})
    (answer,) = answers({"borders": dataset})["borders"]
    assert answer.lead == f"{text} within the ranges that were searched."
    assert tables({"borders": dataset}) == []


def test_the_answers_count_curves_and_meetings(datasets):
    dataset = datasets["borders"]
    curves, meet = answers({"borders": dataset})["borders"]
    number = np.unique(dataset["curve_id"]).size
    assert curves.lead == f"Motions change along at least {amount_text(number, 'curve')}."
    assert curves.rest.startswith("Among those found are ")
    assert re.fullmatch(r"Curves meet in at least [a-z-]+ points?\.", meet.lead)
    assert re.fullmatch(
        r"(At [a-z-]+ of them|There) .* (meet|twice|begins|rest|direction)\.", meet.rest
    )
    assert "," not in curves.rest


def test_regimes_under_curves_have_the_hatches_of_their_map():
    regimes = sweep(20, f=np.linspace(0.05, 2, 15), all_regimes=True)
    figure = draw_boundaries(meetings(("box", 1.0, 0.5)).assign(**CURVE), regimes)
    (ax,) = figure.axes
    drawn = {hatch for each in ax.findobj(ContourSet) for hatch in each.hatches if hatch}
    assert drawn == {each.style.hatch for each in regions_of(regimes)[1] if each.style.hatch}
    assert len(drawn) > 2


def test_a_box_with_units_is_drawn_in_those_that_are_shown():
    length = xr.DataArray(np.empty(0), name="delta", attrs={"units": "mm", "box": [0.001, 0.002]})
    assert ends_of_axis(length) == (1.0, 2.0)
    assert in_box("delta", (0.001, 0.002), (2.0, 8000.0)).tolist() == [0.001, 0.002]
    assert in_box("f", (0.01, 0.02), (2.0, 8000.0)).tolist() == [80.0, 160.0]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("of: [grazing, pitchfork, fold]", "of: [turn]", "of[0]: must be"),
        ("of: [grazing, pitchfork, fold]", "of: []", "of: must be"),
        ("of: [grazing, pitchfork, fold]", "of: [fold, fold]", "of"),
        ("f: [0.05, 1]}\n    lines", "f: [1, 0.05]}\n    lines", "over.f: must be two increasing numbers"),
        ("f: [0.05, 1]}\n    lines", "f: [1]}\n    lines", "over.f: must be two increasing numbers"),
        (", f: [0.05, 1]}\n    lines", "}\n    lines", "over: must"),
        ("nu: [0.8, 2]", "nu: [0, 2]", "over.nu: must be a finite number > 0"),
        ("lines: 4", "lines: 0", "lines: must be a whole number from 1 to 200"),
        ("lines: 4", "line: 4", "line: is an unknown key"),
        ("lines: 4", "exciter: {f: 1}", "exciter.f: must be left out, since f stands in over"),
        ("map: regimes", "map: regime", "figure.map: must be a sweep over nu and f (regimes)"),
        ("{l: 0.5, h: 0.2,", "{h: 0.2,", "exciter.l: is required"),
    ],
)  # fmt: skip
def test_a_wrong_key_is_named(old, new, message):
    assert old in STUDY
    with pytest.raises(StudyError, match=re.escape(f"scenes.borders.{message}")):
        study_of_text(STUDY.replace(old, new), "laws")


PHYSICAL = """
title: Boundaries and basins with units
physical: {m: 2 kg, C: 8 N/mm, H: 40 N s/m, l: 8 mm, F: 120 N}
exciter: {R1: 0.7, R2: 0.7}
scenes:
  borders: {kind: boundary, of: [grazing], over: {omega: [70 rad/s, 120 rad/s], F: [30 N, 120 N]}, lines: 1}
  starts:
    kind: basins
    physical: {omega: 80 rad/s}
    over: {x0: {start: -7 mm, stop: 7 mm, points: 5}, v0: [-1 m/s, 1 m/s]}
    starts: 16
"""


def test_boundaries_and_basins_of_a_physical_study_are_in_si():
    study = study_of_text(PHYSICAL, "units")
    borders, starts = (kind_of(scene).solve(scene) for scene in study.scenes.values())
    # The first grazing of the linear motion: F / sqrt((C - m w^2)^2 + H^2 w^2) = l.
    omega, force = borders["omega"].values, borders["F"].values
    reach = force / np.sqrt((8000 - 2 * omega**2) ** 2 + (40 * omega) ** 2)
    linear = np.isclose(reach, 0.008, rtol=1e-9)
    assert linear.any()
    assert borders["F"].attrs["units"] == "N"
    assert borders["meeting_omega"].attrs["units"] == "rad s-1"
    assert borders.attrs["boundary"] == "omega F"
    assert np.allclose(starts["x0"], [-0.007, -0.0035, 0, 0.0035, 0.007], rtol=0, atol=1e-18)
    assert starts["v0"].attrs["units"] == "m s-1"
    for scene, dataset in zip(study.scenes.values(), (borders, starts), strict=True):
        (picture,) = kind_of(scene).pictures_of(dataset)
        figure = picture.draw(dataset, scene.figure, {})
        assert any("(N)" in ax.get_ylabel() or "(m)" in ax.get_xlabel() for ax in figure.axes)


def meetings(*each: tuple[str, float, float]) -> xr.Dataset:
    """Return a dataset of curves that have meetings, each a kind and a place."""
    kinds, nu, f = zip(*each, strict=True)
    codes = [FLAGS["meeting_kind"][kind] for kind in kinds]
    return xr.Dataset(
        {
            "nu": ("point", [1.0, 2.0]), "f": ("point", [0.0, 1.0]), "meeting_kind": ("meeting", codes),
            "meeting_nu": ("meeting", list(nu)), "meeting_f": ("meeting", list(f)),
        },
        attrs={"boundary": "nu f"},
    )  # fmt: skip


def test_where_curves_meet_is_counted_once():
    double, flip, fold = "double_grazing", "grazing_flip", "grazing_fold"
    a, b, c = (1.0, 0.1), (1.0, 0.9), (1.8, 0.1)  # a curve has the same place but for rounding
    found = meetings(
        (double, *a), (fold, 1.0 + 1e-9, 0.1), (fold, *c), (fold, *c), (fold, 1.0, 0.9 - 1e-9),
        (flip, *b), (flip, *b), (flip, *b), (flip, *b), ("box", 1.5, 0.5),
    )  # fmt: skip
    assert meetings_text(found) == ("three points", "There a grazing and a fold meet.")
    found = meetings((double, *a), (double, *a), (fold, *c), (fold, *c), (fold, *b))
    assert meetings_text(found) == ("three points", "At two of them a grazing and a fold meet.")


@pytest.mark.parametrize("kind", [name for name in FLAGS["meeting_kind"] if name not in UNMARKED])
def test_every_kind_of_meeting_has_a_sentence(kind: str) -> None:
    where, what = meetings_text(meetings((kind, 1.0, 0.5)))
    assert where == "one point"
    assert what.startswith("There ")
    assert what.endswith(".")
