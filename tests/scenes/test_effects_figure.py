"""Figure, caption and tables of timed scenes follow from the data."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from drawing import draw, picture_of

from vibropipe.figures.style import house_style, save
from vibropipe.scenes.accuracy.report import NOT_REACHED, work_precision_table
from vibropipe.scenes.effects.pictures import describe_effects
from vibropipe.scenes.effects.report import effect_table, findings
from vibropipe.words.measurements import Outcome
from vibropipe.words.vocabulary import describe

DIMS = ("motion", "kernel")


@pytest.fixture
def costs() -> xr.Dataset:
    """Three motions: the full one, one that misses its target, one that meets that against another."""
    time = np.array([[400.0, 400, 400], [85, 100, 400], [40, 41, 400]])
    ratio = time[:, :1] / time
    columns = {
        f"kernel_time{s}": (DIMS, time * k) for s, k in (("", 1), ("_low", 0.9), ("_high", 1.1))
    }
    columns |= {
        f"time_ratio{s}": (DIMS, ratio * k) for s, k in (("", 1), ("_low", 0.9), ("_high", 1.1))
    }
    measured = np.array([1.0, 0.85, 40 / 85])
    columns |= {
        f"target_ratio{s}": ("motion", measured * k) for s, k in (("", 1), ("_low", 0.9), ("_high", 1.1))
    }  # fmt: skip
    columns |= {
        "bytes_per_row": (DIMS, np.array([[200.0, 200, 200], [50, 50, 200], [25, 25, 200]])),
        "bytes_ratio": (DIMS, np.array([[1.0, 1, 1], [1, 1, 0.25], [1, 1, 0.125]])),
        "target": ("motion", np.array([np.nan, 0.7, 0.5])),
        "target_met": ("motion", np.array([2, 0, 1], np.int8)),
        "target_against": ("motion", ["all effects", "all effects", "no_force"]),
        "effects_present": (
            "motion",
            ["damping, forcing, support_1, support_2, restitution, rest", "damping, support_1", ""],
        ),
        "outputs_asked": ("motion", ["impacts", "impacts", "steady state"]),
    }
    coords = {"motion": ["full", "no_force", "bare"], "kernel": ["own", "all", "full"]}
    return describe(xr.Dataset(columns, coords))


def test_every_motion_has_a_row_and_every_target_a_bar(costs):
    left, right = draw("effects", costs).axes
    assert [text.get_text() for text in left.get_yticklabels()] == ["full", "no force", "bare"]
    (bars,) = (c for c in left.collections if c.get_linewidth()[0] == 2)
    assert [segment[0][0] for segment in bars.get_segments()] == [0.7, 0.5]
    circles, squares, diamonds = (
        next(line for line in left.lines if line.get_marker() == marker) for marker in "osD"
    )
    assert circles.get_xdata().tolist() == pytest.approx([1, 0.85, 40 / 41])
    assert squares.get_xdata().tolist() == pytest.approx([1, 85 / 400, 0.1])
    assert diamonds.get_xdata().tolist() == pytest.approx([40 / 85])
    sizes = next(line for line in right.lines if line.get_marker() == "P")
    assert sizes.get_xdata().tolist() == [200, 50, 25]


def test_words_come_from_the_data(costs):
    text = describe_effects(costs)
    assert text == (
        "3 motions; 1 of 2 targets are met. Missed: no force (0.85 of the all-effects kernel, target 0.7)."
    )
    costs["target_met"][:] = [2, 1, 0]
    text = describe_effects(costs)
    assert "1 of 2 targets" in text
    assert "bare (0.47 of no force, target 0.5)" in text


def test_the_report_says_them_too(costs):
    (found,) = findings({"law": xr.Dataset(), "costs": costs})
    assert found.scene == "costs"
    assert found.sentences[0] == describe_effects(costs)
    assert findings({"law": xr.Dataset()}) == []


def test_two_runs_of_the_drawing_give_the_same_bytes(costs, tmp_path):
    written = []
    for folder in ("one", "two"):
        with house_style():
            figure = picture_of("effects", costs).draw(costs, None, {})
            written.append([path.read_bytes() for path in save(figure, tmp_path / folder, "costs")])
    assert written[0] == written[1]


def test_a_scene_without_targets_is_drawn(costs):
    costs["target"][:], costs["target_met"][:], costs["target_against"][:] = (
        np.nan,
        2,
        "all effects",
    )
    labels = [text.get_text() for text in draw("effects", costs).legends[0].get_texts()]
    assert len(labels) == 2


def test_the_table_tells_targets_and_verdicts(costs):
    table = effect_table(costs).as_data()
    rows = {row[0].replace("\u200b", ""): row[1:] for row in table["rows"]}
    assert rows["full"][:2] == ["all", "impacts"]
    assert rows["full"][-3:] == ["–", "–", "–"]
    assert rows["no_force"][3] == "0.85 (0.765 to 0.935)"
    assert rows["no_force"][-3:] == ["0.7 of all effects", "0.85 (0.765 to 0.935)", "missed"]
    assert rows["bare"][0] == "–"
    assert rows["bare"][-1] == "met"


def test_the_table_of_work_precision_tells_times_and_what_is_not_reached(work_precision):
    table = work_precision_table(work_precision).as_data()
    assert table["head"][2:] == ["0.01", "0.0001", "1 × 10⁻⁶", "1 × 10⁻⁸", "1 × 10⁻¹⁰"]
    rows = {(row[0].replace("\u200b", ""), row[1]): row[2:] for row in table["rows"]}
    assert rows["plain", "exact"] == ["100"] * 5
    # an error of 5/steps^2 at 16, 64 and 256 steps, 20 ns each
    assert rows["plain", "newmark"] == ["1280", "5120", *[NOT_REACHED] * 3]
    # a method that reaches none has no row of its motion, but one of the medians
    assert ("with_chatter", "RK45") not in rows
    assert rows["median of all", "RK45"][0] == "100000 (1/2)"
    assert rows["median of all", "crude"] == ["640", *[NOT_REACHED] * 4]


def test_a_method_that_is_not_installed_has_no_rows(work_precision):
    work_precision["outcome"][:, 3] = Outcome.NOT_INSTALLED
    assert all(row[1] != "RK45" for row in work_precision_table(work_precision).rows)
