"""The page without a browser: events on its figures, and what its panels then hold."""

import numpy as np
import pytest
from bokeh.document import Document

import vibropipe as vp
from vibropipe.store import load
from vibropipe.view.page import Page
from vibropipe.view.results import open_results


@pytest.fixture
def page(study):
    return Page(open_results(study, study.parent))


def open_scene(page, name):
    page.scene.value = name
    return page


def point_at(page, *point):
    page.upright.location = point[0]
    if len(point) > 1:
        page.across.location = point[1]


def test_a_click_shows_the_stored_impacts_of_every_row(study):
    stored = load(study / "map.nc")
    page = open_scene(Page(open_results(study, study.parent)), "map")
    shown = 0
    for nu in stored["nu"].values:
        for f in stored["f"].values:
            point_at(page, nu, f)
            row = vp.table(stored.sel(nu=[nu], f=[f]).drop_dims("impact")).iloc[0]
            if row["period_multiple"] == 0:
                continue
            own = page.motion.row
            time = (own["impact_period"] + own["impact_phase"]).values * 2 * np.pi / nu
            jumps = page.motion_panel.jumps.data
            assert own["impact_velocity"].size == jumps["time"].size
            order = np.argsort(time)
            np.testing.assert_allclose(jumps["time"], time[order], rtol=0, atol=1e-9)
            np.testing.assert_allclose(
                jumps["before"], own["impact_velocity"].values[order], rtol=0, atol=1e-9
            )
            shown += jumps["time"].size
    assert shown > 100


def test_the_document_of_every_scene_is_valid(page):
    document = Document()
    document.add_root(page.root)
    for name in page.results.explorable:
        open_scene(page, name)
        for quantity in page.quantity.options:
            page.quantity.value = quantity
        document.validate()
        assert len(str(document.to_json())) > 10_000
