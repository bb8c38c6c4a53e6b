"""The picture of a race and the sentences under it: they change with the data."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from drawing import draw, picture_of

from vibropipe.figures.style import house_style, save
from vibropipe.scenes.accuracy.text import conclusion
from vibropipe.words.measurements import Outcome
from vibropipe.words.parameters import PARAMETERS
from vibropipe.words.vocabulary import describe

DIMS = ("motion", "method", "setting")
METHODS = ["crude", "newmark", "exact", "RK45"]


@pytest.fixture
def race() -> xr.Dataset:
    """Two motions: all goes well on the first, RK45 does not end on the second."""
    steps = np.array([16.0, 64, 256])
    error, time = np.full((2, 4, 3), np.nan), np.full((2, 4, 3), np.nan)
    outcome = np.full((2, 4, 3), Outcome.NOT_TRIED, np.int8)
    error[:, 0], error[:, 1], error[:, 2, 0] = 0.5 / steps, 5 / steps**2, 1e-14
    time[:, 0], time[:, 1], time[:, 2, 0] = 10 * steps, 20 * steps, 100
    error[0, 3], time[0, 3] = [1e-3, 1e-6, 1e-9], [1e5, 2e5, 4e5]
    outcome[:, :2], outcome[:, 2, 0], outcome[0, 3] = Outcome.OK, Outcome.OK, Outcome.OK
    outcome[1, 3] = Outcome.DID_NOT_END
    setting = np.array([steps, steps, [np.nan] * 3, [1e-3, 1e-6, 1e-9]])
    columns = {f"error_{n}": (DIMS, error) for n in ("end", "impact_tau", "impact_velocity")}
    columns |= {f"time_per_period{side}": (DIMS, time) for side in ("", "_low", "_high")}
    columns |= {f"work_{n}": (DIMS, error) for n in ("steps", "evaluations", "iterations")}
    columns |= {
        "error_harmonics": (DIMS, error),
        "outcome": (DIMS, outcome),
        "setting_value": (DIMS[1:], setting),
        "periods_run": (DIMS[:2], np.full((2, 4), 4)),
    }
    coords = {name: ("motion", [1.0, 1.0]) for name in PARAMETERS}
    coords |= {"motion": ("motion", ["plain", "with_chatter"]), "method": ("method", METHODS)}
    return describe(xr.Dataset(columns, coords))


def test_each_motion_has_a_panel_and_all_together_have_one(race):
    figure = draw("accuracy", race)
    assert [ax.get_title() for ax in figure.axes if ax.get_visible()] == [
        "plain", "with chatter", "all motions, median",
    ]  # fmt: skip
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert labels == [
        "Newmark, impact at the step's end",
        "Newmark, impact located",
        "exact",
        "RK45",
    ]


def test_orders_stand_at_lines_and_failures_are_named(race):
    plain, chatter = draw("accuracy", race).axes[:2]
    said = [[text.get_text() for text in ax.texts] for ax in (plain, chatter)]
    assert {"1.0", "2.0"} <= set(said[0])
    assert "no end: RK45" in said[1]
    assert "no end: RK45" not in said[0]


def test_a_run_that_fell_through_is_a_cross_at_its_time(race):
    race["outcome"][0, 1] = Outcome.FELL_THROUGH
    ax = draw("accuracy", race).axes[0]
    crosses = [line for line in ax.lines if line.get_marker() == "x"]
    assert len(crosses) == 1
    assert crosses[0].get_xdata().tolist() == [320.0, 1280.0, 5120.0]


def test_two_runs_of_the_drawing_give_the_same_bytes(race, tmp_path):
    written = []
    for folder in ("one", "two"):
        with house_style():
            figure = picture_of("accuracy", race).draw(race, None, {})
            written.append([path.read_bytes() for path in save(figure, tmp_path / folder, "race")])
    assert written[0] == written[1]


def test_the_conclusion_comes_from_the_data(race):
    text = conclusion(race)
    assert "The exact method errs by 1 × 10⁻¹⁴ (median)" in text
    assert "in 100 ns per forcing period" in text
    assert "newmark 51 (2 motions)" in text
    assert "RK45 2 × 10³ (1 motion)" in text
    assert "crude 1.0 (from 1.0 to 1.0) and newmark 2.0 (from 2.0 to 2.0)" in text
    assert "RK45 does not end on with chatter, at every setting tried." in text


def test_another_race_draws_another_conclusion(race):
    race["time_per_period"][:, 2] = 1e7
    race["outcome"][:, 0] = Outcome.MISSED_IMPACT
    text = conclusion(race)
    assert (
        "less than exact needs RK45 on plain, newmark on plain and newmark on with chatter" in text
    )
    assert "crude misses impacts, at every setting tried" in text
    assert "crude 1.0" not in text


def test_a_race_without_the_exact_method_compares_with_nothing(race):
    text = conclusion(race.isel(method=[0, 1]))
    assert "exact" not in text
    assert "newmark 2.0" in text


def test_a_race_that_nobody_finished_can_be_drawn(race):
    race["outcome"][:] = Outcome.DID_NOT_END
    for name in race.data_vars:
        if str(name).startswith(("error", "time")):
            race[name][:] = np.nan
    assert "got through none" in conclusion(race)
    draw("accuracy", race)
