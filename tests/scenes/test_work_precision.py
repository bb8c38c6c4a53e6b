"""Work-precision diagrams and their conclusions follow from the data."""

from __future__ import annotations

import numpy as np
import pytest
from drawing import draw, picture_of
from figures.figure_text import words
from figures.sample_datasets import Scene

from vibropipe.figures.style import CM_PER_INCH, PRINT_WIDTH_CM, house_style, save
from vibropipe.scenes.accuracy.text import conclusion
from vibropipe.words.measurements import Outcome


def draw_times(dataset):
    with house_style():
        return picture_of("accuracy", dataset, "times").draw(dataset, None, {})


def test_each_motion_has_a_panel_two_beside_each_other(work_precision):
    figure = draw("accuracy", work_precision)
    assert [ax.get_title() for ax in figure.axes if ax.get_visible()] == ["plain", "with chatter"]
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert set(labels) == {
        "crude: impact at end of step",
        "Newmark, event location",
        "exact",
        "scipy RK45, events by hand",
    }


def test_panels_of_eight_motions_fill_a_page_and_can_be_read(work_precision):
    eight = work_precision.isel(motion=[0, 1] * 4)
    figure = draw("accuracy", eight)
    with house_style():
        figure.draw_without_rendering()
    width, height = figure.get_size_inches() * CM_PER_INCH
    assert width == pytest.approx(PRINT_WIDTH_CM)
    assert height <= 20.3  # what the report gives a picture before it is scaled down
    boxes = [ax.get_window_extent() for ax in figure.axes]
    assert min(box.width for box in boxes) / figure.dpi * CM_PER_INCH > 6
    assert min(box.height for box in boxes) / figure.dpi * CM_PER_INCH > 3


def test_times_are_a_picture_in_which_what_is_not_reached_is_hollow(work_precision):
    figure = draw_times(work_precision)
    coarse, fine, median = figure.axes
    assert coarse.get_title() == "error at most 0.0001"
    assert median.get_title() == "all motions, median"
    labels = [text.get_text() for text in coarse.get_yticklabels()]
    assert labels == ["plain", "with chatter"]

    def times(ax, hollow):
        lines = [line for line in ax.lines if line.get_marker() not in ("None", "")]
        kept = [line for line in lines if (line.get_markerfacecolor() == "white") == hollow]
        return [[x for x in line.get_xdata() if np.isfinite(x)] for line in kept]

    # crude reaches no error of 1e-4; newmark: 5/steps^2 at 256 steps of 20 ns; exact; RK45 on the first motion
    assert times(coarse, hollow=False) == [[], [5120, 5120], [100, 100], [2e5]]
    assert [len(found) for found in times(coarse, hollow=True)] == [2, 0, 0, 1]
    assert [len(found) for found in times(fine, hollow=True)] == [2, 2, 0, 1]


def test_methods_that_are_not_installed_are_left_out_of_the_pictures(work_precision):
    work_precision["outcome"][:, 3] = Outcome.NOT_INSTALLED
    for figure in (draw("accuracy", work_precision), draw_times(work_precision)):
        labels = [text.get_text() for text in figure.legends[0].get_texts()]
        assert "scipy RK45, events by hand" not in labels
        assert "not installed" not in words(figure)
    assert "RK45 was not installed." in conclusion(work_precision)


def test_both_pictures_are_drawn_by_default():
    assert Scene("accuracy").figure.chosen() == ("work_precision", "times")


def test_orders_stand_at_lines_and_failures_are_named(work_precision):
    plain, chatter = draw("accuracy", work_precision).axes[:2]
    said = [[text.get_text() for text in ax.texts] for ax in (plain, chatter)]
    assert {"1.0", "2.0"} <= set(said[0])
    assert "did not finish: RK45" in said[1]
    assert "did not finish: RK45" not in said[0]


def test_a_run_that_fell_through_is_a_cross_at_its_time(work_precision):
    work_precision["outcome"][0, 1] = Outcome.FELL_THROUGH
    ax = draw("accuracy", work_precision).axes[0]
    crosses = [line for line in ax.lines if line.get_marker() == "x"]
    assert len(crosses) == 1
    assert crosses[0].get_xdata().tolist() == [320.0, 1280.0, 5120.0]


def test_two_runs_of_the_drawing_give_the_same_bytes(work_precision, tmp_path):
    written = []
    for folder in ("one", "two"):
        with house_style():
            figure = picture_of("accuracy", work_precision).draw(work_precision, None, {})
            written.append(
                [path.read_bytes() for path in save(figure, tmp_path / folder, "work_precision")]
            )
    assert written[0] == written[1]


def test_the_conclusion_comes_from_the_data(work_precision):
    text = conclusion(work_precision)
    assert "The exact method has a median error of 1 × 10⁻¹⁴ (largest: 1 × 10⁻¹⁴, plain)" in text
    assert "takes 100 ns per forcing period (median)" in text
    assert "newmark 51 (2 motions)" in text
    assert "RK45 2 × 10³ (1 motion)" in text
    assert "crude 1.0 (from 1.0 to 1.0) and newmark 2.0 (from 2.0 to 2.0)" in text
    assert "RK45 does not finish on with chatter, at every tested setting." in text


def test_another_race_draws_another_conclusion(work_precision):
    work_precision["time_per_period"][:, 2] = 1e7
    work_precision["outcome"][:, 0] = Outcome.MISSED_IMPACT
    text = conclusion(work_precision)
    assert "faster than exact: RK45 on plain, newmark on plain and newmark on with chatter" in text
    assert "crude misses impacts, at every tested setting" in text
    assert "crude 1.0" not in text


def test_a_race_without_the_exact_method_compares_with_nothing(work_precision):
    text = conclusion(work_precision.isel(method=[0, 1]))
    assert "exact" not in text
    assert "newmark 2.0" in text


def test_a_race_that_nobody_finished_can_be_drawn(work_precision):
    work_precision["outcome"][:] = Outcome.DID_NOT_END
    for name in work_precision.data_vars:
        if str(name).startswith(("error", "time")):
            work_precision[name][:] = np.nan
    assert "finished none" in conclusion(work_precision)
    draw("accuracy", work_precision)
