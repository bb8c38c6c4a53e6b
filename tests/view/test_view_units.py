"""The page in the units of a study: numbers, motions, and what is computed from them."""

import math

import numpy as np
import pytest

import vibropipe as vp
from vibropipe.store import load
from vibropipe.study import study_of_text
from vibropipe.view.copies import as_python, as_yaml
from vibropipe.view.page import Page

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
