"""Pictures of every kind: whole files, the same to the byte, legible, and nothing left out."""

from __future__ import annotations

from itertools import combinations, pairwise

import numpy as np
import pytest
from matplotlib.collections import PolyCollection, QuadMesh
from matplotlib.colors import to_rgb
from matplotlib.text import Text

from vibropipe.figures import draw, draw_scene, picture_of, save_motion
from vibropipe.figures.amplitude_frequency import parts
from vibropipe.figures.options import Options, options_of
from vibropipe.figures.pieces import curve, jumps
from vibropipe.figures.regime_map import widest_spot
from vibropipe.figures.strips import cell_edges
from vibropipe.figures.style import (
    CM_PER_INCH,
    PRINT_WIDTH_CM,
    REGIME_STYLES,
    SMALL_FONT_SIZE,
    SUPPORT_COLOURS,
    house_style,
)
from vibropipe.figures.sweep import isolated, row_kinds
from vibropipe.figures.words import REGIME_WORDS, regime_name
from vibropipe.vocabulary import REGIMES, quantity

NAMES = [
    "forced",
    "impacts",
    "conservative",
    "law",
    "free_0",
    "free_1",
    "hard",
    "line",
    "lines",
    "columns",
    "map",
    "bands",
]


@pytest.fixture(scope="module")
def figures(made):
    """Return every picture, laid out as it will be printed."""
    drawn = {}
    for name, (kind, dataset) in made.items():
        options = Options(beside=made["free_1"][1]) if name == "lines" else Options()
        with house_style():
            drawn[name] = draw(kind, dataset, options)
            drawn[name].draw_without_rendering()
    return drawn


def texts(figure) -> list[Text]:
    """Return the texts that are drawn (labels of ticks outside an axis exist, but are not)."""
    drawn: list[Text] = []
    original = Text.draw

    def draw_text(self, renderer, *arguments, **keywords):
        drawn.append(self)
        original(self, renderer, *arguments, **keywords)

    with pytest.MonkeyPatch.context() as patch, house_style():
        patch.setattr(Text, "draw", draw_text)
        figure.draw_without_rendering()
    return [text for text in dict.fromkeys(drawn) if text.get_text().strip() and text.get_visible()]


def words(figure) -> str:
    return "\n".join(text.get_text() for text in texts(figure))


@pytest.mark.parametrize("name", NAMES)
def test_files_are_whole_and_the_same_to_the_byte(name, study, made, tmp_path):
    others = {scene: dataset for scene, (_, dataset) in made.items()}
    first = draw_scene(study, name, made[name][1], tmp_path / "a", others)
    second = draw_scene(study, name, made[name][1], tmp_path / "b", others)
    assert [path.name for path in first] == [f"{name}.svg", f"{name}.pdf"]
    for one, two in zip(first, second, strict=True):
        assert one.read_bytes() == two.read_bytes()
    assert first[0].read_bytes().lstrip().startswith(b"<?xml")
    assert first[1].read_bytes().startswith(b"%PDF-")
    assert sorted(path.name for path in (tmp_path / "a").iterdir()) == sorted(
        path.name for path in first
    )


@pytest.mark.parametrize("name", NAMES)
def test_nothing_overlaps_and_nothing_sticks_out(name, figures):
    figure = figures[name]
    boxes = [(text.get_text(), text.get_window_extent().padded(-1.0)) for text in texts(figure)]
    touching = [
        (one, other)
        for (one, box), (other, second) in combinations(boxes, 2)
        if box.width > 0 and second.width > 0 and box.overlaps(second)
    ]
    assert not touching
    width, height = figure.get_window_extent().size
    for text, box in boxes:
        assert min(box.x0, box.y0) >= -1, text
        assert box.x1 <= width + 1, text
        assert box.y1 <= height + 1, text


@pytest.mark.parametrize("name", NAMES)
def test_print_width_and_size_of_letters(name, figures):
    assert figures[name].get_figwidth() * CM_PER_INCH == pytest.approx(PRINT_WIDTH_CM)
    assert min(text.get_fontsize() for text in texts(figures[name])) >= SMALL_FONT_SIZE


@pytest.mark.parametrize(
    ("name", "quantities"),
    [
        ("forced", ["tau", "force", "displacement", "velocity", "nu", "delta", "R1", "R2"]),
        ("conservative", ["tau", "displacement", "velocity", "l"]),
        ("law", ["tau_bar", "omega_bar", "velocity_over_l", "delta_over_l"]),
        ("free_1", ["eigenfrequency", "displacement_mean", "velocity_mean", "delta"]),
        ("lines", ["nu", "f", "displacement_mean", "h"]),
        ("columns", ["nu", "f", "delta"]),
        ("map", ["nu", "f", "impact_velocity_max"]),
    ],
)
def test_symbols_of_the_vocabulary_are_on_the_picture(name, quantities, figures):
    for each in quantities:
        assert quantity(each).symbol in words(figures[name])


@pytest.mark.parametrize("name", ["line", "lines", "columns", "map", "bands"])
def test_every_regime_present_is_in_the_legend(name, figures, made):
    codes = np.unique(made[name][1]["regime"].values)
    for code in codes:
        assert REGIME_WORDS[regime_name(int(code))] in words(figures[name])


def test_an_unforced_motion_has_no_force_panel(figures):
    assert len(figures["forced"].axes) == 3
    assert len(figures["conservative"].axes) == 2
    assert quantity("force").symbol not in words(figures["conservative"])


def test_grazing_is_named_and_its_own_mark(figures, made):
    dataset = made["conservative"][1]
    assert "grazing" in words(figures["conservative"])
    assert "grazing" not in words(figures["forced"])
    upper = figures["conservative"].axes[0]
    rings = [line for line in upper.lines if line.get_markerfacecolor() == "none"]
    assert np.array_equal(rings[0].get_xdata(), dataset["grazing_tau"].values)


def test_impacts_stand_on_the_support_they_strike(figures, made):
    dataset = made["forced"][1]
    panel = figures["forced"].axes[1]
    for support, colour in SUPPORT_COLOURS.items():
        marks = [line for line in panel.lines if line.get_markerfacecolor() == colour]
        at = dataset["impact_support"].values == support
        assert np.array_equal(marks[0].get_xdata(), dataset["impact_tau"].values[at])
        assert np.allclose(marks[0].get_ydata(), 0.5 if support == 1 else -0.5)


def test_velocity_jumps_are_gaps(made):
    dataset = made["forced"][1]
    tau, values = curve(dataset, "velocity")
    gaps = np.flatnonzero(np.isnan(values))
    assert gaps.size == dataset.sizes["impact"]
    assert np.array_equal(values[gaps - 1], dataset["impact_velocity"].values)
    assert np.array_equal(values[gaps + 1], dataset["impact_velocity_after"].values)
    assert (np.diff(tau) >= 0).all()
    pieces = np.split(values, gaps)
    assert all(np.nanmax(np.abs(np.diff(piece[1:]))) < 0.2 for piece in pieces)


def test_a_sample_at_the_impact_does_not_slope_the_jump(made):
    dataset = made["forced"][1]
    hit = float(dataset["impact_tau"][3])
    moved = dataset["tau"].values.copy()
    moved[np.argmin(np.abs(moved - hit))] = hit
    _, values = curve(dataset.assign_coords(tau=moved), "velocity")
    pieces = np.split(values, np.flatnonzero(np.isnan(values)))
    assert all(np.nanmax(np.abs(np.diff(piece[1:]))) < 0.2 for piece in pieces)


def test_jumps_finds_the_steepest_step_near_each_impact():
    tau = np.arange(10.0)
    velocity = np.where(tau < 5, 1.0, -1.0)
    assert np.array_equal(jumps(tau, velocity, np.array([3.7])), [5])


def test_periods_shows_the_end_of_a_motion(made):
    dataset = made["forced"][1]
    with house_style():
        figure = draw("motion", dataset, Options(periods=2))
    low, high = figure.axes[0].get_xlim()
    assert high == pytest.approx(float(dataset["tau"][-1]))
    assert high - low == pytest.approx(4 * np.pi)


def test_rests_are_shaded_up_to_the_end_if_never_released(made):
    dataset = made["forced"][1].assign(rest_end=("rest", np.array([np.inf])))
    with house_style():
        figure = draw("motion", dataset)
    assert figure.axes[1].get_xlim()[1] == pytest.approx(float(dataset["tau"][-1]))
    assert "rest on a support" in words(figure)


@pytest.mark.parametrize("name", ["line", "lines", "columns", "map"])
def test_every_row_of_a_sweep_is_drawn_once(name, made):
    masks = np.stack(list(row_kinds(made[name][1]).values()))
    assert (masks.sum(axis=0) == 1).all()


def test_a_row_between_two_others_is_a_point(made):
    assert np.array_equal(
        isolated(np.array([True, False, True, True, False, True])),
        [True, False, False, False, False, True],
    )
    dataset = made["line"][1].copy(deep=True)
    dataset["period_multiple"][:] = 2
    dataset["period_multiple"][10] = 1
    with house_style():
        figure = draw("sweep", dataset)
    points = [line for line in figure.axes[1].lines if line.get_marker() == "."]
    heights = np.concatenate([line.get_ydata() for line in points])
    assert float(dataset["displacement_amplitude"][10, 0]) in heights


def test_bars_show_every_row_of_a_sweep(figures, made):
    dataset = made["lines"][1]
    bars = figures["lines"].axes[-1]
    assert len(bars.yaxis.get_ticklabels()) == dataset.sizes["f"]
    polygons = [c for c in bars.collections if isinstance(c, PolyCollection)]
    for position in range(dataset.sizes["f"]):
        lengths = [
            np.ptp(path.vertices[:, 0])
            for collection in polygons
            for path in collection.get_paths()
            if abs(path.vertices[:, 1].mean() - position) < 0.5
        ]
        edges = cell_edges(dataset["nu"].values)
        assert len(lengths) == 1 + np.count_nonzero(np.diff(dataset["regime"].values[:, position]))
        covered = max(p.vertices[:, 0].max() for c in polygons for p in c.get_paths())
        assert covered == pytest.approx(edges[-1])


def test_the_curve_beside_is_drawn_under_the_sweep(made):
    _, dataset = made["line"]
    free = made["free_1"][1]
    with house_style():
        alone = draw("sweep", dataset)
        beside = draw("sweep", dataset, Options(beside=free))
    for one, two in zip(alone.axes[:4], beside.axes[:4], strict=True):
        assert len(two.lines) == len(one.lines) + 1
        assert np.array_equal(two.lines[0].get_xdata(), free["eigenfrequency"].values)
        assert two.lines[0].get_zorder() < two.lines[1].get_zorder()
    assert "conservative exciter" in words(beside)


def test_grids_of_constant_factor_get_log_axes(made):
    nu = np.geomspace(0.01, 10, made["line"][1].sizes["nu"])
    line = made["line"][1].assign_coords(nu=nu)
    over = made["map"][1].assign_coords(nu=np.geomspace(0.01, 10, 60))
    with house_style():
        assert all(ax.get_xscale() == "log" for ax in draw("sweep", line).axes)
        chart = draw("sweep", over)
        chart.draw_without_rendering()
    assert (chart.axes[0].get_xscale(), chart.axes[0].get_yscale()) == ("log", "linear")
    edges = cell_edges(nu)
    assert edges.size == nu.size + 1
    assert np.allclose(edges[1:-1] ** 2, nu[1:] * nu[:-1])


def test_a_descending_grid_is_drawn_ascending(made):
    dataset = made["line"][1]
    with house_style():
        up = draw("sweep", dataset)
        down = draw("sweep", dataset.isel(nu=slice(None, None, -1)))
    for one, two in zip(up.axes, down.axes, strict=True):
        assert one.get_xlim() == two.get_xlim()
        for line, other in zip(one.lines, two.lines, strict=True):
            assert np.array_equal(line.get_xdata(), other.get_xdata())


def test_a_sweep_of_one_point(made):
    with house_style():
        figure = draw("sweep", made["line"][1].isel(nu=[30]))
        figure.draw_without_rendering()
    assert "two-sided" in words(figure)


def test_marks_of_a_map(figures, made):
    figure, dataset = figures["map"], made["map"][1]
    meshes = figure.findobj(QuadMesh)
    assert len(meshes) >= 3
    assert all(mesh.get_rasterized() for mesh in meshes if mesh.axes.get_label() != "<colorbar>")
    dots = figure.axes[0].lines[0]
    assert dots.get_xdata().size == int((dataset["period_multiple"] > 1).sum())
    assert dots.get_rasterized()
    assert "not struck" in words(figure)


def test_the_widest_spot_of_a_region():
    mask = np.zeros((40, 40), dtype=bool)
    mask[5:30, 10:35] = True
    row, column = widest_spot(mask)
    assert abs(row - 17) <= 1
    assert abs(column - 22) <= 1
    assert widest_spot(np.eye(40, dtype=bool)) is None


def test_regimes_are_told_apart_in_grey():
    looks = {}
    for name in REGIMES:
        style = REGIME_STYLES[name]
        red, green, blue = to_rgb(style.colour)
        looks[name] = (0.299 * red + 0.587 * green + 0.114 * blue, style.hatch)
    for (one, (grey, hatch)), (other, (second, pattern)) in combinations(looks.items(), 2):
        assert abs(grey - second) > 0.1 or hatch != pattern, (one, other)


def test_parts_of_a_curve_join(made):
    regime = made["free_1"][1]["regime"].values
    pieces = [piece for _, piece in parts(regime)]
    assert [code for code, _ in parts(regime)] == [0, 2, 3]
    assert pieces[0].start == 0
    assert pieces[-1].stop == regime.size
    assert all(after.start == before.stop - 1 for before, after in pairwise(pieces))


def test_a_vanishing_harmonic_gets_a_calm_axis(figures):
    second = figures["free_0"].axes[4]
    assert np.ptp(second.get_ylim()) > 1e-3


def test_options_of_mappings_and_models(made):
    others = {"free": made["free_1"][1]}
    assert options_of(None, {}) == Options()
    assert options_of({"periods": 3}, {}).periods == 3.0
    assert options_of({"beside": "free"}, others).beside is others["free"]
    with pytest.raises(KeyError, match=r"beside.*'fre'.*free"):
        options_of({"beside": "fre"}, others)


def test_a_kind_without_a_picture_is_named(made):
    with pytest.raises(ValueError, match=r"'basins'.*motion, backbone, sweep"):
        picture_of("basins", made["forced"][1])


@pytest.mark.parametrize("suffix", [".svg", ".pdf", ".png"])
def test_one_motion_in_any_format(suffix, made, tmp_path):
    path = tmp_path / f"motion{suffix}"
    save_motion(made["forced"][1], path)
    assert path.stat().st_size > 5000


def test_drawing_leaves_the_settings_of_matplotlib_alone(made):
    import matplotlib as mpl

    before = dict(mpl.rcParams)
    draw("motion", made["forced"][1])
    assert dict(mpl.rcParams) == before
