"""The page without a browser: events on its figures, and what its panels then hold."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from bokeh.document import Document

import vibropipe as vp
from vibropipe.solve.rebuild import motion_of
from vibropipe.store import load
from vibropipe.view.border import Borders
from vibropipe.view.page import REGIONS, Page
from vibropipe.view.plane import Plane
from vibropipe.view.results import Results
from vibropipe.view.row_numbers import law_text, lines_of, momentum
from vibropipe.view.what_if import solve_anew, steady_row, unswept


def new_page(results, scene, **options):
    return Page(replace(results, first=scene), background=lambda work: work(), **options)


def assert_draws(page, row, nu):
    """The jumps of the motion are the stored impacts of a row."""
    own = (row["impact_period"] + row["impact_phase"]).values * 2 * np.pi / nu
    order, jumps = np.argsort(own), page.point.panel.jumps.data
    np.testing.assert_allclose(jumps["time"], own[order], rtol=0, atol=1e-9)
    before = row["impact_velocity"].values[order]
    np.testing.assert_allclose(jumps["before"], before, rtol=0, atol=1e-9)
    return own.size


def test_a_click_shows_the_stored_impacts(results):
    page, shown = new_page(results, "map"), 0
    for nu in page.plane.values[0][::3]:
        for f in page.plane.values[1][1::4]:
            page.point_at(nu, f)
            if page.point.motion.is_orbit:
                shown += assert_draws(page, page.point.stored, nu)
    assert shown > 10


def test_a_followed_motion_is_drawn_from_its_own_section(study, results):
    """Where two motions coexist, each direction shows its own; from rest both would be one."""
    stored = load(study / "both_ways.nc").sel(f=0.5)
    apart = (stored["regime"].sel(direction="up") != stored["regime"].sel(direction="down")).values
    nu = float(stored["nu"].values[np.flatnonzero(apart)[0]])
    page = new_page(results, "both_ways")
    menus = {str(menu.name): menu for menu in page.menus}
    menus["f"].value = "0.5"
    page.point_at(nu)
    struck = {}
    for direction in ("up", "down"):
        menus["direction"].value = direction
        struck[direction] = assert_draws(page, page.point.stored, nu)
    assert struck["up"] == 2
    assert struck["down"] == 0


def test_curves_have_both_directions_and_slices_the_colours_of_their_regions(study, results):
    page = new_page(results, "both_ways")
    points = page.slices[0].points.data
    assert page.map is None
    assert len(points["at"]) == 2 * 2 * 15  # supports, directions
    page = new_page(results, "map")
    codes, (level, upright) = page.plane.codes(), page.slices
    i, j = page.at
    colours = [page.plane.regions[code].colour for code in codes[j]]
    assert list(level.points.data["colour"][:9]) == colours
    series = next(one for one in page.plane.series.values() if one.name == "displacement_mean")
    page.quantity.value = page.plane.label(series)
    stored = load(study / "map.nc")["displacement_mean"]
    np.testing.assert_array_equal(upright.points.data["value"], stored.values[i])
    np.testing.assert_array_equal(page.map.image.data["image"][0], stored.values.T.astype("f4"))


def test_the_document_of_every_scene_is_valid(results):
    page = new_page(results, "map")
    document = Document()
    document.add_root(page.root)
    for name in page.scene.options:
        page.scene.value = name
        for quantity in page.quantity.options[1::12]:
            page.quantity.value = quantity
        assert page.quantity.value != REGIONS
        document.validate()
    document.to_json()  # complex numbers would fail here


def test_a_spinner_shows_the_motion_that_the_stored_one_settles_on(results):
    page = new_page(results, "map")
    page.point_at(1.9, 1.5)
    stored = page.point.stored
    page.point.what_if.spinners["R1"].value = 0.4
    values = {name: float(stored[name]) for name in ("l", "nu", "f", "h", "delta", "R2")}
    x0, v0 = float(stored["displacement_strobe"]), float(stored["velocity_strobe"])
    expected = vp.steady_state(vp.Exciter(**values, R1=0.4), x0=x0, v0=v0)
    assert_draws(page, expected, values["nu"])
    ghost, motion = (page.point.panel.sources[name].data for name in ("ghost", "motion"))
    assert len(ghost["time"]) > 256
    assert not np.array_equal(ghost["v"], motion["v"], equal_nan=True)
    page.point.what_if.spinners["R1"].value = 1.5
    assert "R1: must be a number from 0 to 1, got 1.5" in page.point.law.text
    page.point.what_if.as_stored()
    assert_draws(page, stored, values["nu"])
    assert not len(page.point.panel.sources["ghost"].data["time"])


def test_a_message_is_not_overwritten_by_what_was_to_be_written_before(results):
    waiting = []
    page = new_page(results, "map", later=waiting.append)
    page.point.what_if.spinners["R1"].value = 0.4
    page.point.what_if.spinners["R1"].value = 1.5
    for work in waiting:
        work()
    assert "R1: must be a number from 0 to 1, got 1.5" in page.point.law.text


def test_the_map_anew_is_the_sweep_with_the_changed_parameter(results):
    page = new_page(results, "map")
    page.point.what_if.spinners["h"].value = 0.3
    page.solve_map()
    assert page.scene.value == "map, h = 0.3"
    exciter = vp.Exciter(l=0.5, h=0.3, delta=0.01, R1=0.7, R2=0.7)
    nu, f = page.plane.values
    expected = vp.sweep(exciter, {"nu": nu, "f": f})
    assert expected.equals(page.datasets[page.scene.value])
    page.scene.value = "map"
    page.scene.value = "both_ways"
    page.point.what_if.spinners["R2"].value = 0.6
    page.solve_map()
    assert page.plane.dataset.attrs["follow"] == "nu both"
    assert float(page.plane.dataset["R2"]) == 0.6


def test_what_is_tied_follows_the_parameters_that_change():
    over, ties = (
        {"zeta": [0.02, 0.1], "nu": [0.9, 1.2]},
        {"R2": "R1", "f": "0.5 * nu**2", "h": "2 * zeta"},
    )
    rows = vp.sweep(vp.Exciter(l=1.0, R1=0.7), over, ties=ties)
    plane = Plane(rows)
    assert "R1" in unswept(plane)
    assert not {"R2", "f", "h"} & unswept(plane).keys()
    anew = solve_anew(plane, {"R1": 0.5}, lambda done, total: None)
    xr.testing.assert_equal(anew, vp.sweep(vp.Exciter(l=1.0, R1=0.5), over, ties=ties))
    changed = steady_row(rows.isel(zeta=1, nu=0), {"R1": 0.5})
    assert (float(changed.R2), float(changed.h), float(changed.f)) == (0.5, 0.2, 0.5 * 0.9**2)


def test_a_pinned_point_stays_beside_another(results):
    page = new_page(results, "map")
    page.point_at(1.3, 1.5)
    pinned = page.point.panel.sources["motion"].data["v"]
    page.point.toggle_pin()
    page.point_at(2.5, 1.9)
    assert (
        page.point.panel.sources["pinned"].data["v"]
        is not page.point.panel.sources["motion"].data["v"]
    )
    np.testing.assert_array_equal(page.point.panel.sources["pinned"].data["v"], pinned)
    assert page.point.numbers.text.split("</tr>")[0].count("<td>") == 4
    page.point.toggle_pin()
    assert page.point.numbers.text.split("</tr>")[0].count("<td>") == 3


def test_coexisting_motions_of_basins_are_a_choice_away(results):
    page = new_page(results, "starts")
    names = page.point.coexisting.options[1:]
    assert len(names) == page.plane.dataset.sizes["attractor_id"]
    for index, name in enumerate(names):
        page.point.coexisting.value = name
        row = page.plane.row(index)
        if int(row["period_multiple"]):
            assert_draws(page, row, 3.48)


def test_a_link_opens_its_point(results):
    page = new_page(results, "both_ways", chosen={"scene": "map", "nu": "1.31", "f": "bad"})
    assert page.scene.value == "map"
    assert page.pointed[0] == pytest.approx(1.3)
    link = dict(part.split("=") for part in page.point.copies.data["link"][0].split("&"))
    assert link["scene"] == "map"
    assert float(link["nu"]) == page.pointed[0]


def test_numbers_have_their_errors_and_reasons():
    exciter = vp.Exciter(l=0.5, nu=1.2, f=0.9, h=0.2, R1=0.7, R2=0.7)
    row = vp.steady_state(exciter, accuracy=1e-6)
    row["displacement_mean_error"] = 2e-12
    texts = {mark: text for mark, _name, text in lines_of(row)}
    assert texts["x̄"].endswith("± 2 × 10⁻¹²")
    assert law_text(row) == (
        "Repeats every forcing period and strikes support 1 once and support 2 once: two-sided."
    )
    row["regime"], row["status"] = 7, 1
    assert law_text(row).startswith("Unresolved: too many impacts in a forcing period.")
    assert "keep R further from 1" in law_text(row)


def test_momentum_of_the_supports_balances_the_mean_force(study):
    """Over an orbit m T mean(x) is the momentum from support 2 less that to support 1."""
    plane, seen = Plane(load(study / "map.nc")), set()
    for number in range(0, plane.dataset["regime"].size, 2):
        row = plane.row(number)
        if int(row["period_multiple"]) == 0:
            continue
        motion = motion_of(row)
        first, second = momentum(motion)
        mean = float(row["displacement_mean"]) * motion.exciter.period
        assert second - first == pytest.approx(mean, abs=1e-9)
        assert min(first, second) >= 0.0
        seen.add(int(row["regime"]))
    assert {0, 3, 4} <= seen  # no impact, two-sided, with rest


def test_the_nearest_border_is_the_nearest_change_of_regime(study):
    plane = Plane(load(study / "map.nc"))
    borders, (x, y) = Borders(plane), plane.values
    regime = plane.dataset["regime"].values
    for at in [(0, 0), (4, 5), (8, 9), (2, 7)]:
        best = np.inf
        for i, j in np.ndindex(*regime.shape):
            for k, m in ((i + 1, j), (i, j + 1)):
                if k < x.size and m < y.size and regime[i, j] != regime[k, m]:
                    place = 0.5 * (x[i] + x[k]), 0.5 * (y[j] + y[m])
                    scaled = (place[0] - x[at[0]]) / np.ptp(x), (place[1] - y[at[1]]) / np.ptp(y)
                    best = min(best, np.hypot(*scaled))
        found = borders.nearest(at)
        scaled = (found.at[0] - x[at[0]]) / np.ptp(x), (found.at[1] - y[at[1]]) / np.ptp(y)
        assert np.hypot(*scaled) == pytest.approx(best)
        assert found.beyond != regime[at]
        low, high = found.rows
        assert high > low
        assert found.at[found.axis] == pytest.approx(0.5 * (low + high))
        assert low in plane.values[found.axis]
        assert f"between {'νf'[found.axis]} = " in borders.sentence(at, (x[at[0]], y[at[1]]))


@pytest.mark.parametrize("changed", [{"load": 0.1}, {"R1": 1.0, "k1": 30.0, "h1": 1.0}])
def test_absent_effects_can_be_tried(results, changed):
    page = new_page(results, "map")
    page.point_at(1.9, 1.5)
    stored = page.point.stored
    for name, value in changed.items():
        page.point.what_if.spinners[name].value = value
    values = {name: float(stored[name]) for name in ("l", "nu", "f", "h", "delta", "R1", "R2")}
    x0, v0 = float(stored["displacement_strobe"]), float(stored["velocity_strobe"])
    expected = vp.steady_state(vp.Exciter(**values | changed), x0=x0, v0=v0)
    drawn = page.point.panel.sources["motion"].data
    assert_draws(page, expected, values["nu"])
    is_soft = "k1" in changed
    assert (np.nanmax(drawn["x"]) > page.point.motion.walls[1] + 0.01) == is_soft
    assert ("momentum" in page.point.numbers.text) != is_soft


def test_basins_at_each_value_of_a_parameter_have_a_menu_of_it(study):
    exciter = vp.Exciter(l=0.5, nu=1.0, f=0.5, h=0.2, R1=0.7, R2=0.7)
    nu, starts = [1.5, 2.2], (np.linspace(-0.4, 0.4, 4), np.linspace(-2, 2, 5))
    data = vp.basins(exciter, *starts, starts=16, over={"nu": nu})
    page = Page(Results("t", {"starts": data}, "starts"), background=lambda work: work())
    assert page.plane.axes == ("x0", "v0")
    (menu,) = page.menus
    for n, value in enumerate(menu.options):
        menu.value = value
        np.testing.assert_array_equal(page.plane.codes(), data["attractor"].values[n].T + 1)
        page.point_at(starts[0][1], starts[1][3])
        number = int(data["attractor"].values[n, 1, 3])
        assert float(page.point.stored["nu"]) == nu[n]
        assert int(page.point.stored["attractor_id"]) == number
        known = np.isfinite(data["basin_share"].values[n]).sum()
        assert len(page.point.coexisting.options) == 1 + known


def test_words_have_colours_of_their_own_and_the_legend_says_them(results):
    page = new_page(results, "map")
    assert "support 1</div>" in page.legend.text
    page.quantity.value = "stability of the orbit"
    assert page.map.regions.data["text"] == ["unstable", "stable"]
    assert (page.map.mapper.low, page.map.mapper.high) == (-0.5, 1.5)
    assert not page.map.bar.visible
    assert "</i>unstable</div>" in page.legend.text


def test_a_pinned_motion_stays_in_its_panels(results):
    page = new_page(results, "map")
    page.point_at(1.9, 1.5)  # between both supports
    page.point.toggle_pin()
    page.point_at(2.8, 0.1)  # no impact
    x = page.point.panel.sources["pinned"].data["x"]
    ends = page.point.panel.x_range
    assert ends.start < np.nanmin(x) < np.nanmax(x) < ends.end
