"""Figure and table of the hard cases: passed cases lie left of the line, and no check is missing."""

from __future__ import annotations

import numpy as np
import pytest
from drawing import caption, draw
from figures.sample_datasets import Scene, hard_cases

from vibropipe.scenes.hard_cases.pictures import LEFT, RIGHT, shares
from vibropipe.scenes.hard_cases.report import hard_case_table, verdict_summary


@pytest.fixture(scope="module")
def points():
    """Return the points drawn, by solver: (x, y, whether filled)."""
    ax = draw("hard_cases", hard_cases()).axes[0]
    found: dict[str, list[tuple[float, float, bool]]] = {}
    for line in ax.lines:
        if line.get_linestyle() == "None":
            filled = line.get_markerfacecolor() != "white"
            places = zip(line.get_xdata(), line.get_ydata(), strict=True)
            found.setdefault(line.get_marker(), []).extend((x, y, filled) for x, y in places)
    return found


def test_every_check_is_a_point_and_nothing_else_is(points):
    assert {marker: len(drawn) for marker, drawn in points.items()} == {"o": 4, "s": 3, "D": 3}
    for drawn in points.values():
        for x, y, filled in drawn:
            assert filled == (round(y) != 3)
            assert filled == (x <= 1)


def test_what_is_exactly_right_and_what_is_off_the_scale_are_drawn(points):
    at = {(marker, round(y)): x for marker, drawn in points.items() for x, y, _ in drawn}
    assert at["o", 1] == at["s", 1] == LEFT
    assert at["s", 3] == at["D", 3] == at["o", 3] == RIGHT
    assert at["o", 0] == pytest.approx(2e-3)
    assert at["D", 0] == pytest.approx(0.8)


def test_shares_of_wrong_counts_and_of_no_numbers():
    found = shares(hard_cases())
    assert np.isnan(found[2, 1:]).all()
    assert found[1].tolist() == [0, 0, 0]
    assert found[3].tolist() == [500, np.inf, np.inf]


def test_caption_names_what_is_not_passed():
    assert caption(Scene("hard_cases"), hard_cases(), {}) == (
        "4 cases, not passed: grazing_free. 4 of 24 motions had flights shorter than the step."
    )
    good = hard_cases().isel(case=slice(3))
    assert caption(Scene("hard_cases"), good, {}).startswith("3 cases, all passed.")


def test_the_page_has_a_row_per_case_with_its_verdicts():
    table = hard_case_table(hard_cases())
    assert table.head == [
        "case",
        "description",
        "known property",
        "exact",
        "newmark 8",
        "newmark 60",
        "passed",
    ]
    chatter, start, drift, graze = table.rows
    assert chatter[1:3] == ["chatter, R = 0.5", "its series"]
    assert chatter[3] == "2 × 10⁻¹⁵ ≤\u00a010⁻¹²"
    assert start[3:] == ["0", "0", "0", "passed"]
    assert drift[3:] == ["3 × 10⁻¹¹ ≤\u00a010⁻⁹", "–", "–", "passed"]
    assert graze[3:] == [
        "not passed: 0.5 >\u00a00.001",
        "not passed: ∞ >\u00a01",
        "not passed: 1 >\u00a00",
        "0 of 3",
    ]
    assert verdict_summary({"hard": hard_cases()}).startswith(
        "7 of 10 checks are passed, over 24 motions with 600 impacts."
    )
    assert verdict_summary({}) == ""
