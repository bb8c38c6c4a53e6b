"""Pictures, answers and the table of work-precision data follow from the data."""

import numpy as np
import pytest
from drawing import draw, picture_of
from figures.figure_text import words
from figures.sample_datasets import Scene
from sentence_numbers import missing, numbers_in

from vibropipe.figures.canvas import CM_PER_INCH, MIN_TYPE, WIDE
from vibropipe.figures.style import save
from vibropipe.figures.text import format_number
from vibropipe.report.parts import DASH
from vibropipe.scenes.accuracy.report import REPORT, answers_of_scene, asked_answer
from vibropipe.scenes.accuracy.text import answers, times_table, title_of
from vibropipe.words.measurements import Outcome
from vibropipe.words.status import Status


@pytest.fixture
def one(work_precision):
    """One motion, on which all methods end."""
    return work_precision.isel(motion=[0])


@pytest.fixture
def asked(one):
    """Four accuracies that are asked of the program, the last of which it refuses."""
    dims = ("motion", "accuracy")
    columns = {
        "asked_estimate": np.full((1, 4), 2e-12),
        "asked_error": np.full((1, 4), 3.14e-13),
        "asked_steps": np.zeros((1, 4)),
        "asked_status": np.array([[Status.OK] * 3 + [Status.INACCURATE]], np.int8),
        **{f"asked_time{side}": np.full((1, 4), 5000.0) for side in ("", "_low", "_high")},
    }
    plain = {f"plain_time{side}": ("motion", [2000.0]) for side in ("", "_low", "_high")}
    return one.assign(
        {name: (dims, values) for name, values in columns.items()} | plain
    ).assign_coords(accuracy=[1e-3, 1e-6, 1e-9, 1e-15])


def lines_of(ax, marker):
    return [line for line in ax.lines if line.get_marker() == marker]


def test_one_motion_has_every_method_with_its_name_at_its_line(one):
    figure = draw("accuracy", one)
    written = words(figure)
    for name in ("exact", "Newmark,\nimpacts located", "RK45", "impact at the\nend of a step"):
        assert name in written
    ax = figure.axes[0]
    (newmark,) = lines_of(ax, "s")
    # 5/steps^2 at 20 ns a step: times in seconds
    assert newmark.get_xdata() == pytest.approx(5 / np.array([16, 64, 256.0]) ** 2)
    assert newmark.get_ydata() == pytest.approx(20e-9 * np.array([16, 64, 256.0]))
    assert ax.get_xlim()[0] > ax.get_xlim()[1]  # more accurate to the right
    assert "times the exact method" in written


def test_steps_whose_force_is_in_no_table_are_drawn_apart(one):
    one.attrs["tabulated_steps"] = 64
    figure = draw("accuracy", one)
    hollow = [
        line for line in lines_of(figure.axes[0], "s") if line.get_markerfacecolor() == "white"
    ]
    assert [line.get_xdata().tolist() for line in hollow] == [[5 / 256**2]]
    caption = picture_of("accuracy", one).describe(one, None, {})
    assert "Hollow (*): above 64 steps a period" in caption
    told = "Times of this program are without the checks and labels of a call"
    assert told in caption
    others = one.sel({"method": ["RK45"]})
    assert told not in picture_of("accuracy", others).describe(others, None, {})
    # the price of a digit is that of steps from the table
    steps = answers(one)[1]
    assert steps.lead.startswith("Newmark's method: ")
    assert steps.rest == (
        "This holds near its most accurate run with a tabulated force, which leaves 0.0013."
    )


def test_several_motions_have_a_panel_each_and_what_fails_is_a_cross(work_precision):
    work_precision["outcome"][0, 1] = Outcome.MISSED_IMPACT
    figure = draw("accuracy", work_precision)
    first, second, key = figure.axes
    crosses = [line.get_ydata().tolist() for line in lines_of(first, "x") if line.get_xdata().size]
    assert crosses == [pytest.approx([320e-9, 1280e-9, 5120e-9])]
    assert any("no run finishes:\nRK45" in text.get_text() for text in second.texts)
    assert not any("no run finishes" in text.get_text() for text in first.texts)
    assert "4 periods, 2 impacts a period" in words(figure)
    methods = {"impact at step's end", "Newmark", "exact", "RK45"}
    assert {text.get_text() for text in key.texts} == {*methods, "failed"}
    told = "In the grey band, hollow and with a cross"
    assert told in picture_of("accuracy", work_precision).describe(work_precision, None, {})
    whole = work_precision.isel(motion=[0, 0], method=[0, 2, 3])
    finished = draw("accuracy", whole)
    assert "failed" not in words(finished)
    assert first.patches  # the band
    assert not any(ax.patches for ax in finished.axes)
    assert told not in picture_of("accuracy", whole).describe(whole, None, {})


def test_runs_without_a_point_are_named(one):
    told = "Without a point, since failed or stopped: "
    assert told not in picture_of("accuracy", one).describe(one, None, {})
    one["outcome"][0, 3, 2] = Outcome.DID_NOT_END
    one["outcome"][0, 2, 0] = Outcome.MISSED_IMPACT
    text = picture_of("accuracy", one).describe(one, None, {})
    assert f"{told}exact; RK45 at {format_number(float(one['setting_value'][3, 2]), 6)}." in text


@pytest.mark.parametrize("amount", [1, 2, 4, 7, 8])
def test_a_page_holds_the_panels_and_no_type_is_too_small(work_precision, amount):
    many = work_precision.isel(motion=([0, 1] * 4)[:amount])
    figure = draw("accuracy", many)
    width, height = figure.get_size_inches() * CM_PER_INCH
    assert width == pytest.approx(WIDE)
    assert height <= 11
    figure.draw_without_rendering()
    for ax in figure.axes:
        for text in ax.texts:
            box = text.get_window_extent()
            assert text.get_fontsize() >= MIN_TYPE
            assert box.x0 >= 0
            assert box.x1 <= figure.bbox.x1


def test_the_times_are_multiples_interpolated_between_settings(one):
    table = times_table("one", one)
    assert table.head[1:] == ["10⁻²", "10⁻⁴", "10⁻⁸", "10⁻¹²"]
    assert table.rows[0][0] == "The exact method"  # of which the others are multiples
    rows = {row[0]: row[1:] for row in table.rows}
    assert rows["The exact method"] == ["1.0"] * 4
    # 5/steps^2 = 1e-2 at 22.4 steps of 20 ns: 447 ns, 4.5 times 100 ns; 1e-4 at 223.6 steps
    assert rows["Newmark's method"] == ["4.5", "45", DASH, DASH]
    # 1e-3, 1e-6, 1e-9 at 1e5, 2e5, 4e5 ns: one third of the way from 1e-3 to 1e-6
    assert rows["scipy's RK45"][:2] == ["1,000", "1,300"]
    assert table.picture == "work_precision"


def test_answers_say_what_accuracy_costs(one):
    exact, steps, packages = answers(one)
    assert exact.lead == "Exact: 0.1 µs a period, whatever the error."
    # 10 ns a step: ten steps would take as long, of which none was tried
    assert exact.rest == ""
    # from 5/16^2 to 5/256^2, 16 times the time: sqrt(10) for each digit
    assert steps.lead == "Newmark's method: 3.2 times the time for one more digit."
    assert packages.lead == "scipy's RK45: at least 1,000 times as long."
    assert packages.rest == "Its fastest run leaves an error of 0.001."
    one["time_per_period"][0, 2, 0] = 170.0
    assert answers(one)[0].rest == (
        "In that time, Newmark's method with impacts at the ends of steps leaves an error of 3.2 %."
    )


def test_another_race_has_another_answer(work_precision):
    lost, exact = answers(work_precision)
    assert lost.lead == "On 1 of 2 motions, no run of scipy's RK45 finishes."
    assert exact.lead == "Exact: 0.1 µs a period on all motions."
    work_precision["time_per_period"][1, 2, 0] = 250.0
    assert answers(work_precision)[1].lead == "Exact: 0.1 µs to 0.25 µs a period on all motions."
    assert title_of(work_precision) == "Only the exact method reaches ten digits on both motions"
    work_precision["outcome"][:, 2] = Outcome.MISSED_IMPACT
    assert title_of(work_precision) == "No method reaches ten digits on both motions"
    lone = work_precision.isel(motion=[0])
    assert answers(lone)[0].lead == "The exact method does not solve this motion."
    assert answers(work_precision.isel(method=[0, 1])) == []


def test_a_race_that_nobody_finished_can_be_drawn(work_precision):
    work_precision["outcome"][:] = Outcome.DID_NOT_END
    for name in work_precision.data_vars:
        if str(name).startswith(("error", "time")):
            work_precision[name][:] = np.nan
    for amount in (1, 2):
        draw("accuracy", work_precision.isel(motion=slice(amount)))
    assert times_table("one", work_precision.isel(motion=[0])) is None


def test_a_motion_in_closed_form_is_named(work_precision):
    text = picture_of("accuracy", work_precision).describe(work_precision, None, {})
    assert "closed form" not in text
    for name, value in {"f": 0.0, "h": 0.0, "f2": 0.0, "shaker": 0.0}.items():
        work_precision[name][1] = value
    text = picture_of("accuracy", work_precision).describe(work_precision, None, {})
    assert "the exact method evaluates a closed form" in text


def test_what_is_asked_is_drawn_beside_what_is_estimated_and_reached(asked):
    picture = picture_of("accuracy", asked, "asked")
    errors, times = picture.draw(asked, None, {}).axes
    kept, refused = (
        [line.get_xdata().tolist() for line in lines_of(errors, "D") if is_hollow(line) == hollow]
        for hollow in (False, True)
    )
    assert (kept, refused) == ([[1e-3, 1e-6, 1e-9]], [[1e-15]])
    assert [line.get_ydata().tolist() for line in lines_of(times, "D")] == [[5.0] * 3, [5.0]]
    # the call without an accuracy, and the march without the call
    levels = [line.get_ydata()[0] for line in times.lines if line.get_linestyle() == "--"]
    assert levels == [2.0, float(asked["time_per_period"].sel({"method": "exact"})[0, 0]) / 1e3]
    assert "its march alone" in words(times.figure)
    assert picture.title(asked, None, {}) == "What is asked for is reached, or refused"
    assert "Hollow: refused" in picture.describe(asked, None, {})
    answer = asked_answer(asked)
    assert answer.lead == "Asking for less saves nothing."
    assert answer.rest == (
        "The true error is at most 3.2 × 10⁻¹³; the estimate makes a call 2.5 times as long."
    )
    asked["asked_steps"][0, 0] = 60.0
    assert asked_answer(asked).lead == "Newmark's method is taken where it is enough."
    asked["asked_error"][0, 2] = 1e-8
    assert picture.title(asked, None, {}) == "Asked, estimated and reached"


def is_hollow(line) -> bool:
    return line.get_markerfacecolor() == "white"


def test_every_number_of_a_sentence_is_in_the_data(work_precision, one, asked):
    for dataset in (work_precision, one, asked):
        given = answers_of_scene(dataset)
        time = dataset["time_per_period"].values[0]
        ratios = [
            time[3].min() / time[2, 0],
            10 ** np.log(16) / 1,
            (16) ** (1 / np.log10(256)),
            2.5,
        ]
        texts = [f"{answer.lead} {answer.rest}" for answer in given]
        assert missing([*texts, title_of(dataset)], dataset, ratios) == []
        for text in texts:
            assert len(numbers_in(text)) <= 2, text


def test_the_exciter_of_the_first_scene_stands_beside_the_answers(one, work_precision):
    found = REPORT.side({"one": one, "others": work_precision})
    assert list(found.drawn) == ["one"]
    assert found.rows[0].value == "1"


def test_both_pictures_can_be_chosen_and_time_over_error_is_the_default():
    assert Scene("accuracy").figure.chosen() == ()


def test_two_runs_of_the_drawing_give_the_same_bytes(work_precision, tmp_path):
    written = []
    for folder in ("one", "two"):
        figure = picture_of("accuracy", work_precision).draw(work_precision, None, {})
        written.append(
            [path.read_bytes() for path in save(figure, tmp_path / folder, "work_precision")]
        )
    assert written[0] == written[1]
