"""Work-precision diagrams and their conclusions follow from the data."""

from __future__ import annotations

import numpy as np
from drawing import draw, picture_of

from vibropipe.figures.style import house_style, save
from vibropipe.scenes.accuracy.text import conclusion
from vibropipe.words.measurements import Outcome


def test_each_motion_has_a_panel_and_all_together_have_one(work_precision):
    figure = draw("accuracy", work_precision)
    assert [ax.get_title() for ax in figure.axes if ax.get_visible()] == [
        "plain", "with chatter", "all motions, median",
    ]  # fmt: skip
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert labels == [
        "Newmark, impact at end of step",
        "Newmark, event location",
        "exact",
        "RK45",
    ]


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
