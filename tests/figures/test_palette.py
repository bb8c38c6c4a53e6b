"""Colours of pictures: apart in grey, legible on white."""

from itertools import combinations, pairwise

import pytest

from vibropipe.figures.palette import (
    METHODS,
    MIN_CONTRAST,
    MIN_STEP,
    REGIME_STYLES,
    SUPPORT_COLOURS,
    SUPPORT_TEXT,
    contrast,
    lightness,
    readable,
    shades,
)
from vibropipe.words.quantities import REGIMES


def test_every_regime_has_a_style():
    assert set(REGIMES) < set(REGIME_STYLES)


def test_regimes_that_touch_are_apart_in_grey():
    light = {name: lightness(style.colour) for name, style in REGIME_STYLES.items()}
    for one, other in combinations(light, 2):
        if {one, other} != {"no_impact", "unresolved"}:  # red crosses on white
            assert abs(light[one] - light[other]) >= MIN_STEP, (one, other)
    assert REGIME_STYLES["unresolved"].hatch


def test_hatches_are_seen_on_their_regime():
    for name, style in REGIME_STYLES.items():
        if style.hatch:
            assert abs(lightness(style.hatch_colour) - lightness(style.colour)) >= 25, name


def test_methods_differ_in_colour_and_marker():
    assert len({style.marker for style in METHODS.values()}) == len(METHODS)
    cold = [lightness(METHODS[name].colour) for name in ("exact", "newmark", "crude")]
    assert all(b - a >= MIN_STEP for a, b in pairwise(cold))


@pytest.mark.parametrize(
    ("colour", "value"), [("#FFFFFF", 100.0), ("#000000", 0.0), ("#777777", 50.0)]
)
def test_lightness_of_greys(colour, value):
    assert lightness(colour) == pytest.approx(value, abs=0.1)


def test_coloured_text_is_legible_on_white():
    colours = [style.colour for style in (*METHODS.values(), *REGIME_STYLES.values())]
    for colour in [*colours, *SUPPORT_COLOURS.values()]:
        assert contrast(readable(colour)) >= MIN_CONTRAST
    assert readable("#0B2A5B") == "#0b2a5b"
    assert all(contrast(colour) >= MIN_CONTRAST - 0.2 for colour in SUPPORT_TEXT.values())


def test_an_ordered_family_darkens():
    light = [lightness(colour) for colour in shades(4)]
    assert all(a > b for a, b in pairwise(light))
    assert shades(1) == shades(3)[-1:]
