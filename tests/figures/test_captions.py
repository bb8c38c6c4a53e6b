"""Words of captions: they say what the data holds, in plain text."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from drawing import caption, picture_of

from vibropipe.figures.text import (
    format_number,
    grid_text,
    mathtext,
    parameter_line,
    plain_parameters,
    regime_name,
)
from vibropipe.scenes.motion.captions import describe_motion
from vibropipe.scenes.sweep.captions import describe_sweep, place_words
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


def test_small_words():
    assert [count(1, "row"), count(3, "row")] == ["1 row", "3 rows"]
    assert [series([]), series("a"), series("abc")] == ["", "a", "a, b and c"]
    assert plain_parameters({"delta": 0.01, "R1": 0.7}) == "δ = 0.01, R₁ = 0.7"
    assert [regime_name(code) for code in REGIMES.values()] == list(REGIMES)
    with pytest.raises(KeyError, match="99"):
        regime_name(99)


def test_parameters_that_are_swept_are_not_in_the_line(made):
    line = parameter_line(made["lines"][1])
    assert "0.5" in line
    assert r"$\nu$" not in line
    assert "$f$" not in line


def test_grids_are_written_whole_or_by_their_ends():
    assert grid_text(np.array([0.1, 0.5])) == "0.1, 0.5"
    assert grid_text(np.linspace(3, 0, 31)) == "0 … 3 (31 values)"


def test_motion_counts_impacts_and_names_grazing(made):
    dataset = made["conservative"][1]
    text = describe_motion(dataset)
    for support in (1, 2):
        at = dataset["impact_support"].values == support
        hardest = np.abs(dataset["impact_velocity"].values[at]).max()
        assert (
            f"upport {support} is struck {at.sum()} times at up to {format_number(hardest)}" in text
        )
    assert "Support 1 is only grazed, touched at zero velocity, twice (first at τ = 4.71)" in text
    assert text.startswith("Displacement and velocity")


def test_motion_says_how_far_it_departs_from_the_exact_one(made):
    text = describe_motion(made["forced"][1])
    assert "newmark departs from it by at most 0.001 in displacement" in text
    assert "rests on a support once, for up to 2.5" in text


def test_free_response_names_its_parts(made):
    kind, dataset = made["free_1"]
    text = picture_of(kind, dataset).describe(dataset, None, {})
    assert "Up to A = 0.49 no support is reached" in text
    assert "then up to A = 0.51 only support 2 is struck" in text
    assert "then up to A = 1 both supports are struck" in text
    _, symmetric = made["free_0"]
    text = picture_of(kind, symmetric).describe(symmetric, None, {})
    assert "the constant part and the even harmonics vanish" in text


def test_sweep_counts_what_is_no_plain_orbit(made):
    dataset = made["lines"][1]
    text = describe_sweep(dataset)
    none = int((dataset["regime"] >= REGIMES["aperiodic"]).sum())
    assert f"Of {dataset['regime'].size} rows " in text
    assert f"{none} have no orbit" in text
    assert "ν for f = 0.1, 0.2, 0.5" in text


def test_map_says_shares_and_where_impacts_are_hardest(made):
    kind, dataset = made["map"]
    text = picture_of(kind, dataset).describe(dataset, None, {})
    two_sided = float((dataset["regime"] == REGIMES["two_sided"]).mean())
    assert f"{format_number(100 * two_sided, 3)} % two-sided" in text
    top = dataset["impact_velocity_max"].sel(support=2)
    assert f"support 2 is struck hardest, {format_number(float(top.max()))}, at ν = " in text


def test_place_of_the_largest_value():
    values = xr.DataArray(
        [[1.0, np.nan], [5.0, 2.0]], dims=("nu", "f"), coords={"nu": [0.5, 2.0], "f": [1.0, 3.0]}
    )
    assert place_words(values) == "ν = 2, f = 1"


def test_every_scene_has_a_caption(study, made):
    others = {name: dataset for name, (_, dataset) in made.items()}
    for name, (_, dataset) in made.items():
        text = caption(study.scenes[name], dataset, others)
        assert text.endswith(".")
        assert "nan" not in text
        assert "$" not in text
    assert "conservative exciter" in caption(study.scenes["lines"], others["lines"], others)
