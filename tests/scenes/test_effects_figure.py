"""Price list, answers and caption of timed scenes follow from the data."""

import numpy as np
import pytest
import xarray as xr
from drawing import draw, picture_of
from figures.figure_text import words
from sentence_numbers import missing, numbers_in

from vibropipe.figures.canvas import CM_PER_INCH, MIN_TYPE, WIDE
from vibropipe.figures.style import save
from vibropipe.report.exciter import drawing_of
from vibropipe.scenes.effects.pictures import describe_effects
from vibropipe.scenes.effects.report import answers, prices, side, title_of
from vibropipe.words.vocabulary import describe


@pytest.fixture
def costs() -> xr.Dataset:
    """A motion, four with one thing more or less, and two rows; times of two timings differ by 2 %."""
    names = ["plain", "offset", "friction", "chatter", "no_force", "row", "row_energy"]
    ratio = np.array([1.01, 1.03, 39.2, 54.0, 0.05, 1.0, 1.62])
    time = np.array([220.0, 227, 8624, 11880, 11, 7300, 11826])
    columns = {
        "time_per_unit": time,
        "time_ratio": ratio,
        "time_ratio_low": ratio * 0.99,
        "time_ratio_high": ratio * 1.01,
        "time_scatter": np.full(7, 0.02),
        "impacts_per_period": np.array([2.0, 2, 2, 102, 2.3, 2, 2]),
        "bytes_per_row": np.array([50.0, 50, 114, 2533, 57, 111, 151]),
        "unit": np.array(["period"] * 5 + ["row"] * 2),
        "compared_with": np.array(["plain"] * 5 + ["row"] * 2),
        "group": np.array(["Motion", *["Physics"] * 3, "Less", *["Outputs"] * 2]),
        "label": np.array(
            ["the motion", "offset, 0.01", "dry friction, 0.1", "chatter", "no force: closed", "a row", "energy"]
        ),
        "nu": np.array([1.0, 1, 1, 0.3, 1, 1, 1]),
        "f": np.full(7, -1.0),
    }  # fmt: skip
    data = {name: ("motion", values) for name, values in columns.items()}
    return describe(xr.Dataset(data, {"motion": names}))


def test_prices_are_in_words(costs):
    assert [price.text for price in prices(costs)] == [
        "nothing", "nothing", "39 times", "54 times", "1/20", "nothing", "1.6 times",
    ]  # fmt: skip
    costs["time_ratio"][4] = 0.61
    assert prices(costs)[4].text == "0.61 of it"


def test_what_is_nothing_grows_with_the_scatter(costs):
    costs["time_ratio"][1] = 1.08
    assert not prices(costs)[1].is_nothing
    costs["time_scatter"][:] = 0.04
    assert prices(costs)[1].is_nothing
    assert "the scatter of repeated timings, together at most 9 %" in describe_effects(costs)


def test_a_caption_tells_of_nothing_and_of_other_motions_only_where_they_are(costs):
    assert "“nothing”" in describe_effects(costs)
    assert "the motion is another one" in describe_effects(costs)
    dear = costs.sel(motion=["plain", "friction"])
    assert "“nothing”" not in describe_effects(dear)
    assert "another" not in describe_effects(dear)


def test_every_entry_is_a_bar_with_words_impacts_and_bytes(costs):
    figure = draw("effects", costs)
    (ax,) = figure.axes
    # from 1; nothing has none
    assert {bar.get_x() for bar in ax.patches} == {1.0}
    ends = sorted(bar.get_x() + bar.get_width() for bar in ax.patches)
    assert ends == pytest.approx([0.05, 1.62, 39.2, 54.0])
    written = words(figure)
    for text in ("Physics", "39 times", "1/20", "nothing", "102", "2,533", "1 = 0.22 µs a period"):
        assert text in written
    assert "1 = 7.3 µs a row" in written
    assert "Motion" not in written  # that the others are compared with stands in the caption
    assert "that of the motion and of a row" in describe_effects(costs)


def test_the_answers_are_of_the_same_motion(costs):
    physics, outputs, left_out = answers(costs)
    assert physics.lead == "Physics, at equal impacts: 39 times as long with dry friction."
    assert physics.rest == "Offset costs nothing."
    assert outputs.lead == "Outputs: 1.6 times as long with energy."
    told = "What a motion or a sweep does not call for costs hardly any time: its code is left out, or idle."
    assert left_out.lead == told
    assert title_of(costs) == "Price list: at equal impacts, dry friction and energy cost most"
    few = costs.isel(motion=costs["time_ratio"].values < 50)
    assert title_of(few) == "Price list: dry friction and energy cost most"
    costs["time_ratio"][2] = 1.01
    assert answers(costs)[0].lead == "Physics: nothing costs more."


def test_a_third_group_is_named_with_the_last_answer(costs):
    costs["impacts_per_period"][3:5] = 2.0
    assert answers(costs)[0].lead == (
        "Physics: 54 times as long with chatter and 39 times with dry friction."
    )
    assert [answer.rest for answer in answers(costs)] == ["Offset costs nothing.", "", ""]
    costs["time_ratio"][4] = 1.3
    leads = [answer.lead.split(":")[0] for answer in answers(costs)]
    assert leads[:2] == ["Physics", "Outputs"]
    assert answers(costs)[2].rest == "Less: up to 1.3 times as long."


def test_every_number_of_a_sentence_is_in_the_data(costs):
    texts = [f"{a.lead} {a.rest}" for a in answers(costs)]
    assert missing([*texts, title_of(costs)], costs) == []
    assert max(len(numbers_in(text)) for text in texts) <= 2
    # of the caption, all but what counts as nothing
    assert missing([describe_effects(costs).replace("5 %", "").replace("7 %", "")], costs) == []


def test_the_numbers_beside_the_exciter_are_of_the_motion_of_the_others(costs):
    told = side({"costs": costs.assign_coords(friction=("motion", [0.0, 0, 0.1, 0, 0, 0, 0]))})
    assert [row.value for row in told.rows] == ["1", "−1"]
    assert not drawing_of(told.drawn)["friction"]


def test_the_list_fits_a_page_and_no_type_is_too_small(costs):
    many = costs.isel(motion=[0, 1, 2, 3, 4, 5, *[6] * 20])
    figure = draw("effects", many)
    width, height = figure.get_size_inches() * CM_PER_INCH
    assert width == pytest.approx(WIDE)
    assert height < 15
    figure.draw_without_rendering()
    for text in figure.axes[0].texts:
        assert text.get_fontsize() >= MIN_TYPE
        assert text.get_window_extent().x0 >= -1
        assert text.get_window_extent().x1 <= figure.bbox.x1 + 1


def test_two_runs_of_the_drawing_give_the_same_bytes(costs, tmp_path):
    written = []
    for folder in ("one", "two"):
        figure = picture_of("effects", costs).draw(costs, None, {})
        written.append([path.read_bytes() for path in save(figure, tmp_path / folder, "costs")])
    assert written[0] == written[1]
