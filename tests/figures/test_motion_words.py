"""Motions in words."""

import pytest

from vibropipe.figures.motion_words import amount_text, motion_words, number_word
from vibropipe.words.regimes import Regime


@pytest.mark.parametrize(
    ("regime", "m", "impacts", "rests", "words"),
    [
        (Regime.NO_IMPACT, 1, (0, 0), (0, 0), "no impact"),
        (Regime.ONE_SIDED_1, 1, (1, 0), (0, 0), "support 1, once a period"),
        (Regime.ONE_SIDED_2, 3, (0, 1), (0, 0), "support 2, every third period"),
        (Regime.ONE_SIDED_2, 7, (0, 1), (0, 0), "support 2, once in seven periods"),
        (Regime.ONE_SIDED_1, 2, (2, 0), (0, 0), "support 1, twice in two periods"),
        (Regime.TWO_SIDED, 1, (3, 3), (0, 0), "both supports, three times a period"),
        (Regime.TWO_SIDED, 1, (1, 2), (0, 0), "support 1 once, support 2 twice a period"),
        (Regime.TWO_SIDED, 2, (4, 5), (0, 0), "support 1 four times, support 2 five times, in two periods"),
        (Regime.WITH_REST, 1, (8, 0), (1, 0), "rest on support 1"),
        (Regime.WITH_REST, 1, (8, 9), (1, 1), "rest on both supports"),
        (Regime.WITH_REST, 2, (9, 9), (0, 0), "rest on a support"),
        (Regime.WITH_REST, 1, (8, 1), (1, 0), "rest on support 1, support 2 once a period"),
        (Regime.WITH_REST, 1, (2, 8), (0, 1), "rest on support 2, support 1 twice a period"),
        (Regime.WITH_REST, 1, (8, 9), (1, 2), "rest on support 1 once, rest on support 2 twice a period"),
        (Regime.WITH_REST, 2, (16, 0), (1, 0), "rest on support 1 once in two periods"),
        (Regime.WITH_REST, 2, (16, 3), (2, 0), "rest on support 1 twice, support 2 three times, in two periods"),
        (Regime.APERIODIC, 0, (1.25, 0.75), (0, 0), "aperiodic"),
    ],
)  # fmt: skip
def test_a_motion_is_told_in_words(regime, m, impacts, rests, words):
    assert motion_words(regime, m, impacts, rests) == words


def test_amounts_are_written_in_letters():
    assert [number_word(n) for n in (0, 1, 13, 20, 21, 99, 100)] == [
        "no", "one", "thirteen", "twenty", "twenty-one", "ninety-nine", "100",
    ]  # fmt: skip
    assert amount_text(1, "fold") == "one fold"
    assert amount_text(2, "box", "boxes") == "two boxes"
