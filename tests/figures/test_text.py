"""Text of numbers, parameters and grids in figures."""

from __future__ import annotations

import numpy as np
import pytest
from figures.sample_datasets import sweep

from vibropipe.figures.text import (
    format_number,
    grid_text,
    mathtext,
    parameter_line,
    regime_name,
)
from vibropipe.words.vocabulary import REGIMES
from vibropipe.words.wording import count, series


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"),
        (-0.0, "0"),
        (-0.035367, "−0.03537"),
        (1.5e-13, "1.5 × 10⁻¹³"),
        (2e10, "2 × 10¹⁰"),
        (float("nan"), "–"),
        (float("-inf"), "−∞"),
    ],
)
def test_number(value, text):
    assert format_number(value) == text


def test_number_keeps_the_digits_asked_for():
    assert float(format_number(0.888613761684971, 6)) == 0.888614


def test_mathtext_raises_powers_of_ten():
    assert mathtext(1.5e-13) == r"$1.5\times 10^{-13}$"
    assert mathtext(-0.5) == "−0.5"


def test_amounts_lists_and_names():
    assert [count(1, "row"), count(3, "row")] == ["1 row", "3 rows"]
    assert [series([]), series("a"), series("abc")] == ["", "a", "a, b and c"]
    assert [regime_name(code) for code in REGIMES.values()] == list(REGIMES)
    with pytest.raises(KeyError, match="99"):
        regime_name(99)


def test_parameters_that_are_swept_are_not_in_the_line():
    line = parameter_line(sweep(f=[0.1, 0.2, 0.5]))
    assert "0.2" in line
    assert r"$\nu$" not in line
    assert "$f$" not in line


def test_grids_are_written_whole_or_by_their_ends():
    assert grid_text(np.array([0.1, 0.5])) == "0.1, 0.5"
    assert grid_text(np.linspace(3, 0, 31)) == "0 … 3 (31 values)"
