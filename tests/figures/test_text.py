"""Text of numbers, parameters and grids in figures."""

import numpy as np
import pytest
import xarray as xr
from figures.sample_datasets import sweep

from vibropipe.figures.canvas import new_canvas
from vibropipe.figures.regime_words import regime_name
from vibropipe.figures.style import house_style
from vibropipe.figures.text import (
    axis_label,
    format_number,
    grid_text,
    modulus_text,
    parameter_line,
    scalar_parameters,
)
from vibropipe.words.quantities import REGIMES
from vibropipe.words.vocabulary import describe
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
    with pytest.raises(ValueError, match="99"):
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


def test_an_axis_has_no_remark_on_numbers_of_a_table():
    both = describe(xr.Dataset({name: ("row", [0.2, 0.5]) for name in ("k1", "mass_ratio")}))
    assert "0 if rigid" in both.k1.attrs["long_name"]
    assert axis_label(both.k1) == "stiffness of support 1 $k_1$"
    assert "0 if that is fixed" in both.mass_ratio.attrs["long_name"]
    assert axis_label(both.mass_ratio) == "ratio of the mass to that of the housing $\\kappa$"


def test_a_multiplier_below_one_is_not_written_as_one() -> None:
    texts = [modulus_text(value) for value in (0.9996, 1.0004, 1.0 - 1e-12, 0.33333)]
    assert texts == ["0.9996", "1.0004", "1", "0.333"]
