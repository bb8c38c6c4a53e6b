"""Text of numbers, parameters, grids, motions and bounds in figures and sentences."""

import numpy as np
import pytest
import xarray as xr
from figures.sample_datasets import sweep
from hypothesis import given
from hypothesis import strategies as st

from vibropipe.figures.canvas import new_canvas
from vibropipe.figures.claims import (
    at_least,
    at_most,
    between_text,
    even_digits,
    only_between_text,
    outwards,
    rising_text,
)
from vibropipe.figures.motion_words import amount_text, motion_words, number_word
from vibropipe.figures.style import house_style
from vibropipe.figures.text import (
    format_number,
    grid_text,
    parameter_line,
    regime_name,
    scalar_parameters,
)
from vibropipe.words.quantities import REGIMES
from vibropipe.words.regimes import Regime
from vibropipe.words.wording import count, series


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"),
        (-0.0, "0"),
        (-0.035367, "−0.03537"),
        (1.5e-13, "1.5 × 10⁻¹³"),
        (2e10, "2 × 10¹⁰"),
        (16000.0, "16,000"),
        (-99994.0, "−99,990"),
        (123456.0, "1.235 × 10⁵"),
        (float("nan"), "–"),
        (float("-inf"), "−∞"),
    ],
)
def test_number(value, text):
    assert format_number(value) == text


def test_number_keeps_the_digits_asked_for():
    assert float(format_number(0.888613761684971, 6)) == 0.888614
    assert format_number(1058.3, 3) == "1,060"
    assert format_number(12345.67, 7) == "12,345.67"


def test_number_has_raised_powers_of_ten():
    assert format_number(1.5e-13) == "1.5 × 10⁻¹³"
    assert format_number(-0.5) == "−0.5"
    assert format_number(4.0192e-7, 3) == "4.02 × 10⁻⁷"


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


def test_parameters_stand_in_as_few_lines_as_fit():
    dataset = sweep()
    assert "\n" not in parameter_line(dataset)
    soft = dataset.assign_coords(k1=200.0, k2=200.0, h1=3.191, h2=3.191, delta=0.01)
    assert "\n" not in parameter_line(soft)
    units = {
        "m": "kg",
        "C": "N/m",
        "F": "kN",
        "H": "N s/m",
        "C1": "N/m",
        "C2": "N/m",
        "H1": "N s/m",
        "H2": "N s/m",
    }
    for name, unit in units.items():
        dataset[name] = ((), 1.25e6, {"units": unit, "symbol": f"${name[0]}_{{{name[1:]}}}$"})
    lines = parameter_line(dataset).split("\n")
    assert len(lines) == 2
    with house_style():
        figure = new_canvas(3.0)
        figure.suptitle("\n".join(lines))
        figure.draw_without_rendering()
        box = figure._suptitle.get_window_extent()
    assert box.x0 > 0
    assert box.x1 < figure.get_window_extent().x1
    entries = [entry for line in lines for entry in line.removesuffix(",").split(",  ")]
    assert len(entries) == len(scalar_parameters(dataset))


def test_grids_are_written_whole_or_by_their_ends():
    assert grid_text(np.array([0.1, 0.5])) == "0.1, 0.5"
    assert grid_text(np.linspace(3, 0, 31)) == "0 … 3 (31 values)"


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


NUMBERS = st.floats(-1e9, 1e9).filter(lambda value: value == 0.0 or abs(value) > 1e-9)


def number(text: str) -> float:
    mantissa, _, power = text.replace("−", "-").replace(",", "").partition(" × 10")
    superscripts = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
    return float(f"{mantissa}e{power.translate(superscripts)}" if power else mantissa)


@given(NUMBERS, st.integers(2, 6))
def test_a_bound_is_never_inside(value: float, digits: int) -> None:
    # Digits beyond the twelfth do not count.
    slack, unit = 1e-11 * abs(value), 10.0 ** (1 - digits) * abs(value)
    above, below = number(at_most(value, digits)), number(at_least(value, digits))
    assert value - slack <= above <= value + unit + slack
    assert value - unit - slack <= below <= value + slack


@given(NUMBERS, st.floats(1e-6, 1.0))
def test_an_interval_is_written_outwards_and_hardly_wider(low: float, share: float) -> None:
    high = low + share * max(abs(low), 1.0)
    first, last = map(number, outwards(low, high))
    slack = 1e-11 * (abs(low) + abs(high))
    assert first <= low + slack
    assert last >= high - slack
    assert last - first <= 1.2 * (high - low) + 4 * slack


def test_numbers_that_are_exact_stay() -> None:
    assert (at_most(2.5), at_least(2.5), at_most(0.1 + 0.2), at_most(0.0)) == (
        "2.5",
        "2.5",
        "0.3",
        "0",
    )
    assert (at_most(2.0001), at_least(1.9999), at_least(-2.0001)) == ("2.01", "1.99", "−2.01")
    assert [at_most(value, 2) for value in (1.21e-9, 1.2e-9, 9.91e-3)] == [
        "1.3 × 10⁻⁹", "1.2 × 10⁻⁹", "0.01",
    ]  # fmt: skip
    assert at_most(1.2345e-12, 2) == "1.3 × 10⁻¹²"
    assert (at_most(np.inf), at_most(np.nan)) == ("∞", "–")


def test_ends_of_ranges_in_a_column_have_as_many_digits() -> None:
    cells = ["10 … 80", "10 … 54.75", "–", "30.25"]
    assert even_digits(cells) == ["10.00 … 80.00", "10.00 … 54.75", "–", "30.25"]
    assert even_digits(["1 … 2", "0", "77.3 % (74 … 80)"]) == ["1 … 2", "0", "77.3 % (74 … 80)"]


AXIS = xr.DataArray([2.515, 2.52, 2.525, 2.53], dims="nu", name="nu")


def test_a_border_lies_between_two_rows() -> None:
    assert between_text(AXIS, 2.52, 2.515) == "between ν = 2.515 and 2.520"
    units = AXIS.rename("omega").assign_attrs(units="rad s-1")
    assert between_text(units, 251.3274, 251.3281) == "between ω = 251.3274 and 251.3281 rad/s"


@pytest.mark.parametrize(
    ("mask", "text"),
    [
        ([0, 1, 1, 0], "only between ν = 2.515 and 2.530"),
        ([1, 1, 0, 0], "only below ν = 2.525"),
        ([0, 0, 0, 1], "only above ν = 2.525"),
        ([1, 0, 0, 1], ""),
        ([0, 0, 0, 0], ""),
    ],
)
def test_rows_are_told_by_those_beyond(mask: list[int], text: str) -> None:
    assert only_between_text(AXIS, np.array(mask, bool)) == text


@pytest.mark.parametrize(
    ("values", "text"),
    [
        ([1.0, 2.0, 3.0, 4.0], "it still rises at the end of the range of ν"),
        ([4.0, 2.0, 3.0, 1.0], "it still rises at the end of the range of ν"),
        ([1.0, 4.0, 3.0, 2.0], ""),
        ([1.0, 2.0, 4.0, 4.0], ""),  # level
        ([1.0, 2.0, np.nan, 4.0], ""),  # nothing is known beside it
    ],
)
def test_the_largest_value_at_an_end_still_rises(values: list[float], text: str) -> None:
    array = xr.DataArray(values, {"nu": AXIS.values}, ["nu"])
    top = array.isel(nu=int(np.nanargmax(array.values)))
    assert rising_text(array, top, ["nu"]) == text
