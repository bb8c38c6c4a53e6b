"""Pictures, table and answers of the hard cases: what fails is drawn, and no check is missing."""

import numpy as np
import pytest
from drawing import draw, picture_of
from figures.figure_text import words
from figures.sample_datasets import failures, hard_cases
from sentence_numbers import missing, numbers_in

from vibropipe.figures.canvas import MIN_TYPE
from vibropipe.report.exciter import drawing_of
from vibropipe.scenes.hard_cases.keys import HardCasesFigure
from vibropipe.scenes.hard_cases.pictures import shares, title_of_margins
from vibropipe.scenes.hard_cases.report import answers_of, groups_table, side
from vibropipe.words.measurements import Outcome

ALL = HardCasesFigure(show=["exact", "newmark 8", "newmark 60"])


def margins(dataset, options=ALL):
    return picture_of("hard_cases", dataset, "margins").draw(dataset, options, {})


def test_every_check_is_a_mark_and_nothing_else_is():
    ax = margins(hard_cases()).axes[0]
    drawn = [line for line in ax.lines if line.get_linestyle() == "None" and line.get_clip_on()]
    marks = {
        marker: sum(len(line.get_xdata()) for line in drawn if line.get_marker() == marker)
        for marker in "Dosx"
    }
    assert marks == {"D": 3, "o": 2, "s": 2, "x": 3}
    crosses = [x for line in drawn if line.get_marker() == "x" for x in line.get_xdata()]
    assert min(crosses) > 1


def test_shares_of_wrong_counts_and_of_no_numbers():
    found = shares(hard_cases())
    assert np.isnan(found[2, 1:]).all()
    assert found[1].tolist() == [0, 0, 0]
    assert found[3].tolist() == [500, np.inf, np.inf]


def test_caption_and_title_say_what_is_not_passed():
    picture = picture_of("hard_cases", hard_cases(), "margins")
    text = picture.describe(hard_cases(), ALL, {})
    assert text.startswith(
        "A mark for each case and method (Newmark, 8 steps, in 3 and Newmark, 60 steps, in"
    )
    assert "Cross: grazing free exceeds its bound." in text
    assert title_of_margins(hard_cases()) == "One case of 4 exceeds its bound"
    good = hard_cases().isel(case=slice(3))
    assert title_of_margins(good) == "No case of 3 exceeds its bound"
    assert "Cross" not in picture.describe(good, ALL, {})


def test_the_table_has_a_row_for_each_group_with_its_worst_case():
    table = groups_table("hard", hard_cases())
    assert [row[0] for row in table.rows] == ["chatter", "contact", "labels"]
    chatter, contact, labels = table.rows
    assert chatter == ["chatter", "its series", "each flight rounded", "2", "2 × 10⁻¹⁵", "10⁻¹²"]
    # the case that is furthest beyond its bound
    assert contact == ["contact", "struck or not", "yes or no", "4", "0.5", "0.001"]
    assert labels[4:] == ["3 × 10⁻¹¹", "10⁻⁹"]
    assert table.title == "4 cases in 3 groups"
    assert "12 in all differ" in table.note
    good = groups_table("hard", hard_cases().isel(case=slice(3)))
    assert good.title.endswith("nothing is missed, every bound is kept")
    assert good.rows[1][4:] == ["0 wrong", "–"]


def test_what_fails_is_a_cross_in_the_band():
    dataset = failures()
    figure = draw("hard_cases", dataset)
    energy, grazing, chatter, step = figure.axes
    crosses = [line for line in grazing.lines if line.get_marker() == "x"]
    assert [line.get_xdata().tolist() for line in crosses] == [[1e-9], [1e-6, 1e-9]]
    assert all(min(line.get_ydata()) > 10 for line in crosses)
    rest = [line for line in chatter.lines if line.get_marker() == "x"]
    assert [len(line.get_xdata()) for line in rest] == [1, 2]
    ends = [line for line in energy.lines if line.get_marker() in ("x", "|")]
    assert [line.get_xdata().tolist() for line in ends] == [[1], [10], [10]]
    assert step.get_xlabel() == "steps per forcing period"
    for text in ("missed", "no rest", "DOP853: stuck, up to 2.3 % early", "exact: no step"):
        assert text in words(figure)


def test_the_answers_say_where_common_methods_fail():
    found = answers_of(failures())
    assert [answer.lead for answer in found] == [
        "Grazing: vibropipe's exact method finds all 3 impacts.",
        "Chatter: the time of its end is off by at most 2.3 × 10⁻¹⁴ of it, up to a restitution of 0.9.",
        "A million impacts: the marched energy is off by at most 4.3 × 10⁻¹⁰ of it.",
    ]
    assert (
        found[0].rest == "DOP853 with events misses 2 of them, and none once its steps are short; "
        "Newmark's method misses none."
    )
    assert found[1].rest.startswith("DOP853 with events never comes to rest")
    assert "does not drift" in found[2].rest
    assert missing([f"{a.lead} {a.rest}" for a in found], failures(), [2.0, 3.0]) == []
    assert max(len(numbers_in(f"{a.lead} {a.rest}")) for a in found) <= 2


def test_the_answers_follow_the_data():
    worse = failures()
    worse["grazing_outcome"][5, 2] = Outcome.MISSED_IMPACT
    worse["chatter_outcome"][5, 1] = Outcome.DID_NOT_END
    worse["energy_error"][6, :] = 1e-9
    title = picture_of("hard_cases", worse).title(failures(), None, {})
    assert title == "Some common methods miss impacts, or do not end; the exact one does neither"
    leads = [answer.lead for answer in answers_of(worse)]
    assert leads[0] == "Grazing: vibropipe's exact method misses 1 of 3 impacts."
    assert leads[1] == "Chatter: its end is not found for every restitution."
    assert answers_of(worse)[2].rest == ""
    title = picture_of("hard_cases", worse).title(worse, None, {})
    assert title == "Common methods and the exact one: energy, grazing, chatter and step"


def test_an_error_of_0_is_said_to_stand_at_the_edge():
    picture = picture_of("hard_cases", failures())
    told = "Errors below 3 × 10⁻¹⁷ are drawn there."
    assert told in picture.describe(failures(), None, {})
    above = failures()
    above["energy_error"] = above["energy_error"].clip(min=1e-15)
    assert told not in picture.describe(above, None, {})


def test_newmark_is_praised_only_where_it_misses_nothing():
    worse = failures()
    worse["grazing_outcome"][1, 2] = Outcome.MISSED_IMPACT
    assert "Newmark" not in answers_of(worse)[0].rest


def test_a_scene_without_questions_answers_with_its_cases():
    (answer,) = answers_of(hard_cases())
    assert answer.lead == "4 cases: 1 bound exceeded."
    assert picture_of("hard_cases", hard_cases()).name == "margins"
    assert side({"hard": hard_cases()}).rows[0].words == "has its own exciter"
    assert [row.symbol for row in side({"hard": failures()}).rows] == ["a", "b", "c", "d"]


@pytest.mark.parametrize(
    "questions", [["grazing"], ["energy", "step"], ["energy", "grazing", "chatter"]]
)
def test_some_questions_alone_can_be_drawn(questions):
    dataset = failures()
    left_out = {"energy", "grazing", "chatter"} - set(questions)
    dataset = dataset.drop_vars([f"{q}_{n}" for q in left_out for n in ("error", "outcome")])
    if "step" not in questions:
        dataset = dataset.drop_vars(["step_error", "step_count"])
    figure = draw("hard_cases", dataset)
    assert len(figure.axes) == len(questions)
    assert picture_of("hard_cases", dataset).describe(dataset, None, {})
    for ax in figure.axes:
        for text in ax.texts:
            assert text.get_fontsize() >= MIN_TYPE


def test_the_drawing_has_the_force_of_cases_whose_parameters_are_not_held():
    effects = {"effects": "damping, forcing, support_1, support_2"}
    assert drawing_of({"hard": failures().assign_attrs(effects)})["symbols"]["force"] == "f(τ)"
    assert (
        drawing_of({"hard": failures().assign_attrs(effects="damping")})["symbols"]["force"] == ""
    )
