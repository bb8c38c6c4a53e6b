"""Figures in centimetres, their letters and their colours."""

import re
from itertools import combinations, pairwise

import numpy as np
import pytest
from matplotlib.font_manager import findfont

from vibropipe.figures.canvas import (
    HALF,
    WIDE,
    EvenTicks,
    axes,
    label,
    label_region,
    missed_band,
    new_canvas,
    noted_canvas,
    panel,
    power_ticks,
    size_of,
    support_bands,
    time_ticks,
)
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
from vibropipe.figures.style import FAMILY, FONTS, house_style, save, set_apart
from vibropipe.words.quantities import REGIMES


def test_axes_stand_where_they_are_put():
    figure = new_canvas(9.0)
    ax = axes(figure, 1.5, 1.0, 12.0, 7.0)
    assert size_of(ax) == pytest.approx((12.0, 7.0))
    corner = ax.get_window_extent().p0 / figure.dpi * 2.54
    assert corner == pytest.approx((1.5, 1.0))
    assert new_canvas(5.0, HALF).get_figwidth() * 2.54 == pytest.approx(7.75)


def test_ticks_have_equal_decimals_and_commas():
    with house_style():
        ticks = EvenTicks()
        assert ticks.format_ticks([0.0, 0.5, 1.0]) == ["0.0", "0.5", "1.0"]
        assert ticks.format_ticks([-1000.0, 0.0, 1000.0]) == ["−1,000", "0", "1,000"]
        assert ticks.format_ticks([0.65, 0.7, 0.75]) == ["0.65", "0.70", "0.75"]
        assert ticks.format_ticks([0.9, 0.90000002]) == ["0.90000000", "0.90000002"]
        assert ticks.format_ticks([0.0, 2e-9]) == ["0", "2 × 10⁻⁹"]
        assert ticks.format_ticks([0.0, 2e7]) == ["0", "2 × 10⁷"]


def test_saved_figures_have_equal_decimals_and_curly_apostrophes(tmp_path):
    with house_style():
        figure = new_canvas(5.0)
        ax = axes(figure, 1.6, 1.2, 12.8, 3.5, xlim=(0.0, 2000.0), ylim=(0.0, 1e-12))
        ax.set_xlabel("Newmark's velocity $U$ (mm/s)")
        for _ in range(2):
            save(figure, tmp_path, "one")
    assert ax.get_xlabel() == r"Newmark’s velocity $U\,$ (mm/s)"
    assert "1,000" in [label.get_text() for label in ax.get_xticklabels()]
    assert ax.yaxis.get_offset_text().get_text()  # a common power of ten remains


def test_powers_of_ten_are_written_as_people_do(tmp_path):
    with house_style():
        figure = new_canvas(5.0)
        ax = axes(figure, 1.6, 1.2, 12.8, 3.0, xscale="log", xlim=(1e-2, 1e2))
        small = axes(figure, 1.6, 1.2, 12.8, 3.0, xscale="log", xlim=(3.0, 30.0))
        save(figure, tmp_path, "one")
    texts = [re.sub(r"[^\d⁻¹²]", "", label.get_text()) for label in ax.get_xticklabels()]
    assert texts[1:-1] == ["10⁻²", "10⁻¹", "1", "10", "10²"]
    between = {re.sub(r"\D", "", label.get_text()) for label in small.get_xticklabels(minor=True)}
    assert {"4", "6", "20"} <= between


@pytest.mark.parametrize("ends", [(0.999, 1.001), (-0.11, -0.09), (0.0, 1.0)])
def test_ticks_that_the_figure_would_cut_off_are_left_out(tmp_path, ends):
    with house_style():
        figure = new_canvas(5.0)
        ax = axes(figure, 1.3, 1.2, WIDE - 1.3 if ends[0] < 0 else 14.4, 3.0, xlim=ends)
        save(figure, tmp_path, "one")
        figure.draw_without_rendering()
    boxes = [label.get_window_extent() for label in ax.get_xticklabels()]
    low, high = ax.get_window_extent().x0, ax.get_window_extent().x1
    shown = [box for box in boxes if low - 1 <= (box.x0 + box.x1) / 2 <= high + 1]
    assert len(shown) >= 3
    assert max(box.x1 for box in shown) <= figure.bbox.width
    if ends == (0.0, 1.0):  # these have room
        assert [label.get_text() for label in ax.get_xticklabels()][-1] == "1.0"


def test_no_tick_is_read_as_a_sum_and_powers_keep_off_titles(tmp_path):
    with house_style():
        figure = new_canvas(5.0)
        ax = axes(figure, 1.6, 1.2, 12.8, 3.0, xlim=(0.9, 0.9 + 1e-7), ylim=(0.0, 1e-12))
        panel(ax, title="largest impact velocity")
        save(figure, tmp_path, "one")
        figure.draw_without_rendering()
        power, shown = ax.yaxis.get_offset_text(), figure.canvas.get_renderer()
        (title,) = (text for text in ax.texts if "largest" in text.get_text())
        assert power.get_text()
        assert not power.get_window_extent(shown).overlaps(title.get_window_extent(shown))
        assert not ax.xaxis.get_offset_text().get_text()
        labels = [label for label in ax.get_xticklabels() if label.get_text()]
        assert 2 <= len({label.get_text() for label in labels}) == len(labels)
        boxes = [label.get_window_extent(shown) for label in labels]
        assert max(box.x1 for box in boxes) <= figure.bbox.x1
        assert all(one.x1 < other.x0 for one, other in pairwise(boxes))


def test_digits_stand_beside_their_ticks():
    with house_style():
        figure = new_canvas(5.0)
        ax = axes(figure, 1.6, 1.2, 12.8, 3.5, ylim=(0.0, 1.0), yticks=[0.5])
        figure.draw_without_rendering()
        (label,) = ax.get_yticklabels()
        assert label.get_verticalalignment() == "center"


def test_letters_are_those_of_the_package():
    with house_style():
        for style, weight in (("normal", "normal"), ("italic", "normal"), ("normal", "bold")):
            found = findfont(f"{FAMILY}:style={style}:weight={weight}", fallback_to_default=False)
            assert str(found).startswith(str(FONTS))


def test_a_figure_has_one_family_of_type_and_is_the_same_to_the_byte(tmp_path):
    files = []
    for folder in ("a", "b"):
        with house_style():
            figure = new_canvas(5.0)
            ax = axes(figure, 1.5, 1.2, 12.0, 3.0)
            ax.set(
                xscale="log",
                yscale="log",
                xlim=(1e-8, 10),
                ylim=(1e-7, 1),
                xlabel=r"$\dot{x}_1$ · $\nu$",
            )
            power_ticks(ax, "x", (-8, -4, 0, 1))
            time_ticks(ax, "y", (-7, -6, -2, 0))
            panel(ax, "a", "title", "note")
            label(ax, 1e-3, 1e-3, "10⁻⁶ → ẋ", "#E08A2E")
            label_region(ax, 1e-5, 1e-5, "region")
            files.append(save(figure, tmp_path / folder, "one"))
            assert [t.get_text() for t in ax.get_xticklabels()] == ["10⁻⁸", "10⁻⁴", "1", "10"]
            assert [t.get_text() for t in ax.get_yticklabels()] == [
                "100 ns",
                "1 µs",
                "10 ms",
                "1 s",
            ]
    for one, other in zip(*files, strict=True):
        assert one.read_bytes() == other.read_bytes()
    pdf = files[0][1].read_bytes()
    assert b"/Subtype /Type3" in pdf
    assert b"STIX" not in pdf
    assert b"DejaVu" not in pdf


@pytest.mark.parametrize("axis", ["x", "y"])
def test_bands_keep_the_limits(axis):
    ax = axes(new_canvas(5.0), 1.0, 1.0, 5.0, 3.0)
    ax.set(xlim=(-1, 1), ylim=(-1, 1))
    support_bands(ax, -0.5, 0.5, axis)
    missed_band(ax, 0.6, 0.8, axis=axis)
    assert np.allclose([*ax.get_xlim(), *ax.get_ylim()], [-1, 1, -1, 1])
    assert len(ax.patches) == 3


def test_powers_of_accented_letters_are_as_low_as_others():
    def height(text):
        with house_style():
            figure = new_canvas(2.0)
            shown = figure.text(0.1, 0.5, set_apart(text))
            return shown.get_window_extent(figure.canvas.get_renderer()).height

    assert height(r"$\dot{x}^-$") == pytest.approx(height(r"$\dot{x}$"), abs=1.0)
    assert set_apart(set_apart(r"$\dot{x}(0)$")) == r"$\dot{x}\hspace{0.1}(0)$"
    assert set_apart("the max(0, a)") == "the max(0, a)"


def test_a_note_stands_below_axes_of_their_own_size():
    figure = noted_canvas(5.0, "f = 1\nh = 0.1", 1.5)
    ax = axes(figure, 1.5, 0.0, 10.0, 5.0)
    (note,) = figure.texts
    assert note.get_window_extent().y1 <= ax.get_window_extent().y0
    assert size_of(ax) == pytest.approx((10.0, 5.0))


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
