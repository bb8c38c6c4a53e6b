"""Bounds, margins and borders in sentences: what is written holds of the number itself."""

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

from vibropipe.figures.claims import (
    at_least,
    at_most,
    between_text,
    even_digits,
    from_to,
    only_between_text,
    outwards,
    rising_text,
)

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


def test_ends_of_a_range_are_told_apart() -> None:
    ends = [from_to(0.6, 1.6), from_to(1.0, 1.00002), from_to(1.0, 1.0)]
    assert ends == ["0.6 to 1.6", "1 to 1.00002", "1"]


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
    grid = ["0.145 … 1.075", "1.0775 … 1.565", "2 … 3"]
    exact = ["0.1450 … 1.0750", "1.0775 … 1.5650", "2.0000 … 3.0000"]
    assert even_digits(grid, are_exact=True) == exact
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
