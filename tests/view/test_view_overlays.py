"""What else is known at a point: branches, boundaries and borders over the map, texts, and the units of a study."""

import math
from dataclasses import replace

import numpy as np
import pytest
from figures.sample_datasets import sweep
from small_study import EXCITER

import vibropipe as vp
from vibropipe.scenes.registry import kind_of
from vibropipe.store import load, save
from vibropipe.study import study_of_text
from vibropipe.view.border import Borders
from vibropipe.view.copies import as_python, as_yaml
from vibropipe.view.overlays import MARKS, belongs, boundaries, branches
from vibropipe.view.page import Page
from vibropipe.view.plane import SIGNS, Plane
from vibropipe.view.results import Results, open_results
from vibropipe.view.slices import shown_series
from vibropipe.words.regimes import Regime

UNITS = """
title: Units
physical: {m: 2 kg, C: 8 N/mm, H: 25 N s/m, l: 8 mm, delta: 0.1 mm}
exciter: {R1: 0.7, R2: 0.7}
scenes:
  response:
    kind: sweep
    over:
      F: {start: 20 N, stop: 120 N, points: 9}
      omega: {start: 30 rad/s, stop: 150 rad/s, points: 9}
"""


@pytest.fixture(scope="module")
def branch():
    parameters = {**EXCITER.parameters()._asdict(), "nu": 1.0, "f": 0.5}
    return vp.branch(vp.Exciter(**parameters), "nu", (0.8, 2.6), switch=("grazing",))


@pytest.fixture(scope="module")
def si_page(tmp_path_factory):
    study = study_of_text(UNITS, "units")
    scene = study.scene("response")
    path = tmp_path_factory.mktemp("si") / "response.nc"
    save(kind_of(scene).solve(scene), path)
    page = Page(open_results(path, path.parent), background=lambda work: work())
    page.point_at(82.5, 75.0)
    return page


def test_branches_lie_on_the_map_and_on_the_curves(study, branch):
    whole, curves = Plane(load(study / "map.nc")), Plane(load(study / "both_ways.nc"), {"f": 0})
    for plane, series in ((whole, None), (curves, shown_series(curves, None)[0])):
        pieces = list(branches({"laws": branch}, plane, series))
        assert {piece["stable"] for piece in pieces} == {True, False}
        assert sum(piece["x"].size for piece in pieces) >= branch.sizes["point"]
    drawn = np.concatenate([piece["y"] for piece in branches({"laws": branch}, whole, None)])
    assert set(drawn) == {0.5}
    assert not list(branches({"laws": branch}, Plane(load(study / "both_ways.nc"), {"f": 1}), None))
    assert not list(branches({"laws": branch.assign_coords(h=0.3)}, whole, None))


def test_boundaries_lie_over_the_map_of_their_parameters(study):
    plane = Plane(load(study / "map.nc"))
    grazing = vp.boundary(EXCITER, "grazing", within=((0.8, 1.4), (0.1, 0.8)), lines=2)
    curves = list(boundaries({"borders": grazing}, plane))
    assert curves
    assert {each["kind"] for each in curves} == {"grazing"}
    assert sum(each["x"].size for each in curves) == grazing.sizes["point"]
    assert not belongs(grazing.assign_coords(R1=0.71), plane, plane.axes)
    page = Page(Results("t", {"map": load(study / "map.nc"), "borders": grazing}, "map"))
    assert set(page.overlays.curves.data["text"]) == {"grazing (borders)"}


def test_basins_at_a_point_of_a_map_are_offered_there(study):
    starts = load(study / "starts.nc")
    same = {name: float(starts[name]) for name in ("l", "h", "delta", "R1", "R2")}
    around = vp.sweep(
        vp.Exciter(**same), {"nu": np.linspace(3.4, 3.56, 9), "f": np.linspace(0.5, 0.9, 9)}
    )
    page = Page(Results("t", {"map": around, "starts": starts}, "map"))
    assert "basins: starts" in page.overlays.marks.data["text"]
    page.point_at(3.48, 0.7)
    assert len(page.point.coexisting.options) == 1 + starts.sizes["attractor_id"]
    page.point_at(3.56, 0.7)
    assert not page.point.coexisting.visible


@pytest.mark.parametrize("is_physical", [False, True])
def test_the_copied_texts_make_the_motion_again(results, si_page, is_physical):
    page = si_page if is_physical else Page(replace(results, first="map"))
    stored, shown = page.point.stored, page.point.panel.jumps.data
    copied = study_of_text(page.point.copies.data["yaml"][0], "copied").scene("point")
    motion = kind_of(copied).solve(copied)
    n = shown["before"].size
    np.testing.assert_allclose(motion["impact_velocity"].values[:n], shown["before"], atol=1e-9)
    names: dict = {}
    exec(page.point.copies.data["python"][0], names)
    np.testing.assert_allclose(
        names["row"]["impact_velocity"].values, stored["impact_velocity"].values, atol=1e-9
    )
    clock = "impact_time" if is_physical else "impact_tau"
    np.testing.assert_allclose(names["motion"][clock].values[:n], shown["time"], atol=1e-9)


def test_a_study_with_units_is_shown_in_them(si_page):
    jumps, stored = si_page.point.panel.jumps.data, si_page.point.stored
    np.testing.assert_allclose(np.sort(jumps["before"]), np.sort(stored["impact_velocity"].values))
    assert jumps["time"].max() < 2 * np.pi / 75.0
    assert "F = 82.5 N, ω = 75 rad/s" in si_page.point.law.text
    assert "N·s</td>" in si_page.point.numbers.text
    si_page.point.what_if.spinners["H"].value = 40.0
    si_page.solve_map()
    again = study_of_text(UNITS.replace("25 N s/m", "40 N s/m"), "units").scene("response")
    expected, found = kind_of(again).solve(again), si_page.plane.dataset
    for name in ("regime", "displacement_mean", "impact_velocity", "omega"):
        np.testing.assert_allclose(found[name], expected[name], rtol=1e-9, atol=1e-12)
    si_page.scene.value = "response"


def test_a_motion_without_an_orbit_shows_its_section(results):
    page = Page(replace(results, first="map"))
    regime = page.plane.dataset["regime"].values
    i, j = (int(each[0]) for each in np.nonzero(regime == Regime.APERIODIC))
    page.point_at(page.plane.values[0][i], page.plane.values[1][j])
    assert "Aperiodic" in page.point.law.text
    assert "Poincaré section" in page.point.law.text
    assert len(page.point.panel.section.data["x"]) > 300
    first = page.point.panel.section.data["x"][0]
    assert first == float(page.point.stored["displacement_strobe"])


def test_every_mark_of_a_bifurcation_has_a_sign_in_the_legend():
    assert {*MARKS.values()} <= {*SIGNS}


@pytest.mark.parametrize(("follow", "first"), [("nu up", 0), ("nu down", -1), ("f up", None)])
@pytest.mark.parametrize("order", [1, -1])
def test_the_first_row_of_a_followed_line_is_beside_no_border(follow, first, order):
    dataset = sweep(12, f=np.linspace(0.05, 2, 12)).assign_attrs(follow=follow)
    regime = dataset["regime"].copy(data=np.full(dataset["regime"].shape, Regime.NO_IMPACT))
    # only the columns of the least and the largest frequency differ
    for column in (0, -1):
        regime[{"nu": column}] = Regime.TWO_SIDED
    plane = Plane(dataset.assign(regime=regime).isel(nu=slice(None, None, order)))
    borders = Borders(plane)
    steps = np.sort(dataset["nu"].values)
    places = {0: 0.5 * (steps[0] + steps[1]), -1: 0.5 * (steps[-1] + steps[-2])}
    x = plane.axes.index("nu")
    found = {
        round(borders.nearest(at).at[x], 9)
        for at in np.ndindex(*(values.size for values in plane.values))
    }
    assert found == {round(float(place), 9) for end, place in places.items() if end != first}


P = math.sqrt(8000.0 / 2.0)


@pytest.fixture
def page(with_units):
    return Page(with_units, background=lambda work: work())


@pytest.fixture
def point(page, study):
    """A point of the page, and the row without units."""
    row = load(study / "map.nc").isel(nu=5, f=8)
    page.point_at(float(row["nu"]) * P / (2 * math.pi), float(row["f"]) * 8000.0)
    return page.point, row


def test_axes_and_numbers_have_the_units_of_the_study(page, point):
    point, row = point
    np.testing.assert_allclose(page.plane.values[0] * 2 * math.pi / P, np.linspace(0.4, 2.8, 9))
    assert page.plane.dataset["omega"].attrs["units"] == "Hz"
    assert "ω/2π" in point.numbers.text
    assert " Hz" in point.numbers.text
    assert " mm/s" in point.numbers.text
    assert "rad/s" not in point.numbers.text
    jumps = point.panel.jumps.data
    hardest = float(row["impact_velocity_max"].max()) * P * 1e3
    assert np.abs(jumps["before"]).max() == pytest.approx(hardest, rel=1e-9)
    assert {*np.round(jumps["x"], 9)} == {510.0, -490.0}
    assert point.motion.period == pytest.approx(2 * math.pi / float(row["nu"]) / P * 1e3)
    assert point.panel.curves.xaxis.axis_label.endswith("(ms)")


def test_what_if_takes_the_units_of_the_study(point):
    point, row = point
    spinners = point.what_if.spinners
    assert spinners["l"].value == 500.0
    assert "(mm)" in spinners["l"].title
    spinners["delta"].value = 20.0
    spinners["load"].value = 80.0
    values = {name: float(row[name]) for name in ("l", "nu", "f", "h", "R1", "R2")}
    start = {"x0": float(row["displacement_strobe"]), "v0": float(row["velocity_strobe"])}
    expected = vp.steady_state(vp.Exciter(**values, delta=0.02, load=0.01), **start)
    assert point.shown.row["displacement_mean"].attrs["units"] == "mm"
    found = point.shown.row["impact_velocity_max"].values
    np.testing.assert_allclose(found, expected["impact_velocity_max"] * P * 1e3, rtol=1e-9)


def test_the_map_anew_is_in_the_same_units(page, point):
    point[0].what_if.spinners["delta"].value = 20.0
    page.solve_map()
    solved = page.datasets[page.scene.value]
    assert float(solved["delta"]) == 20.0
    assert solved["omega"].attrs["units"] == "Hz"
    np.testing.assert_allclose(solved["omega"], page.plane.values[0])


def test_recipes_give_the_same_exciter(point, tmp_path, monkeypatch):
    point, row = point
    text = as_yaml(point.stored, "again")
    assert "l: 500.0 mm" in text
    scene = study_of_text(text, "again").scenes["point"]
    found = {}
    exec(as_python(point.stored), found)
    for name in ("nu", "f", "l", "h", "delta"):
        assert scene.resolved_exciter()[name] == pytest.approx(float(row[name]), rel=1e-12)
        assert getattr(found["exciter"], name) == pytest.approx(float(row[name]), rel=1e-12)
    assert scene.start.x0 == pytest.approx(float(row["displacement_strobe"]), rel=1e-9)
