"""Pictures of sweeps: every row, its regime, and what lies beside it."""

import numpy as np
import pytest
import xarray as xr
from drawing import draw, picture_of
from figures.figure_text import words
from figures.sample_datasets import sweep
from matplotlib.collections import PolyCollection, QuadMesh
from matplotlib.text import Text

import vibropipe as vp
from vibropipe.figures import line_names
from vibropipe.figures.canvas import axes, new_canvas
from vibropipe.figures.line_names import Named, label_lines
from vibropipe.figures.map_shapes import cell_edges, label_regions, widest_spot
from vibropipe.figures.style import LINES
from vibropipe.scenes.keys.parts import MAX_LINES
from vibropipe.scenes.sweep import curves
from vibropipe.scenes.sweep.bifurcation import draw_bifurcation
from vibropipe.scenes.sweep.captions import describe_quantities, describe_sweep
from vibropipe.scenes.sweep.curves import draw_sweep
from vibropipe.scenes.sweep.figure_keys import SweepFigure
from vibropipe.scenes.sweep.laws import regions_of
from vibropipe.scenes.sweep.lines import BAR_NAME, breaks_of, isolated, lines_of
from vibropipe.scenes.sweep.map_layout import draw_hatch
from vibropipe.scenes.sweep.maps import draw_quantity_maps, value_norm
from vibropipe.scenes.sweep.report import grid_texts
from vibropipe.scenes.sweep.sweep_rows import row_kinds
from vibropipe.words.regimes import Regime


@pytest.mark.parametrize("name", ["map", "bands"])
def test_every_region_of_a_map_is_named(name, figures, made):
    said = words(figures[name]).replace("\n", " ")
    for region in regions_of(made[name][1])[1]:
        assert region.words in said


@pytest.mark.parametrize("name", ["line", "lines", "columns"])
def test_every_regime_present_is_named_in_a_bar_or_in_the_legend(name, figures, made):
    in_bars = {
        text.get_text() for text in figures[name].findobj(Text) if text.get_gid() == BAR_NAME
    }
    names = {region.words for region in regions_of(made[name][1])[1]}  # as on maps
    legends = figures[name].legends
    in_legend = {text.get_text() for legend in legends for text in legend.get_texts()}
    assert in_bars | in_legend == names
    assert not in_bars & in_legend


def test_a_bifurcation_diagram_names_a_regime_in_a_bar_or_in_the_legend():
    figure = draw_bifurcation(sweep().assign(displacement_strobe=sweep()["displacement_mean"]))
    in_bars = {text.get_text() for text in figure.findobj(Text) if text.get_gid() == BAR_NAME}
    in_legend = {text.get_text() for legend in figure.legends for text in legend.get_texts()}
    assert in_bars | in_legend == {region.words for region in regions_of(sweep())[1]}
    assert in_bars
    assert not in_bars & in_legend


def test_the_label_of_a_region_is_in_its_middle():
    ax = axes(new_canvas(9.0), 1.2, 1.2, 14.0, 7.0, xlim=(0.0, 2.0), ylim=(0.0, 1.0))
    edges = np.linspace(0.0, 2.0, 41), np.linspace(0.0, 1.0, 21)
    halves = np.tile(np.repeat([0, 1], 20), (20, 1))
    label_regions(ax, halves, edges, {0: ["left"], 1: ["right"]})
    places = {text.get_text(): text.get_position() for text in ax.texts}
    assert places["left"] == pytest.approx((0.25, 0.5), abs=0.02)
    assert places["right"] == pytest.approx((0.75, 0.5), abs=0.02)


def test_what_is_rounding_has_the_scale_of_its_family():
    grids = {"nu": np.linspace(1.6, 3.0, 12), "f": np.linspace(0.1, 0.9, 9)}
    rows = vp.sweep(vp.Exciter(l=0.5, h=0.2, R1=0.7, R2=0.7), grids)  # symmetric motions
    largest = float(abs(rows["displacement_amplitude"]).max())
    assert 0.0 < float(abs(rows["displacement_mean"]).max()) < 1e-9
    norm = value_norm(rows, "displacement_mean")
    assert norm.vmax == pytest.approx(0.05 * largest)
    assert "and 0 (mean displacement)" in describe_quantities(rows)


def test_neighbouring_rows_differ_in_a_table():
    axis = xr.DataArray(np.linspace(0.3, 3.0, 100_000), dims="nu", name="nu")
    at = [axis.values[[100, 31_600]], axis.values[[31_601, 31_601]], axis.values[[31_602, -1]]]
    first, lone, last = grid_texts(axis, at)
    assert len({first.split(" … ")[1], lone, last.split(" … ")[0]}) == 3
    coarse = xr.DataArray([0.5, 0.75, 1.0], dims="nu", name="nu")
    assert grid_texts(coarse, [coarse.values[[0, 1]], coarse.values[[2]]]) == [
        "0.50 … 0.75",
        "1.00",
    ]


def test_a_lone_point_is_within_its_panel_and_under_no_name():
    outputs = ["harmonics", "impacts", "stability", "motion"]
    exciter = vp.Exciter(l=0.5, nu=1.0, f=-1.0, h=0.2, R1=0.7, R2=0.7)
    row = vp.sweep(exciter, {"nu": [1.0]}, outputs=outputs)
    for figure in (draw_sweep(row), draw_bifurcation(row)):
        figure.draw_without_rendering()
        points = [
            (ax, line)
            for ax in figure.axes
            for line in ax.lines
            if line.get_marker() == "." and np.isfinite(line.get_ydata()).any()
        ]
        assert points
        for ax, line in points:
            low, high = ax.get_ylim()
            at = np.asarray(line.get_ydata(), float)
            at = at[np.isfinite(at)]
            is_shown = (abs(at) < 1e-9) | (
                (at > low + 0.02 * (high - low)) & (at < high - 0.02 * (high - low))
            )
            assert is_shown.all()
            for x, y in ax.transData.transform(np.stack([np.full(at.size, 1.0), at], axis=1)):
                assert not any(text.get_window_extent().contains(x, y) for text in ax.texts)
    assert "from light to dark" not in describe_sweep(
        vp.sweep(exciter, {"nu": [0.9, 1.0], "f": [-1.0]})
    )
    picture = picture_of("sweep", row, "portrait")
    assert picture.title(row, None, {}) == "Phase portrait of one law of motion"


def test_a_name_beside_a_bar_is_within_the_figure(made):
    dataset = made["lines"][1].assign_coords(
        f=("f", [100.0, 200.0, 800.0], {"units": "N", "symbol": "$F_{long}$"})
    )
    figure = draw_sweep(dataset)
    figure.draw_without_rendering()
    names = [label for ax in figure.axes for label in ax.get_yticklabels() if label.get_text()]
    assert min(label.get_window_extent().x0 for label in names) >= 0.0


def test_names_of_lines_keep_off_other_lines_and_jumps():
    x = np.linspace(5.0, 40.0, 141)
    values = [
        np.where(x < end, top * (0.6 + 0.02 * x), 40.0 / x)
        for end, top in ((26, 6), (27, 5.6), (29, 5))
    ]
    figure = new_canvas(8.0)
    ax = axes(figure, 1.5, 1.0, 8.6, 6.0)
    for y in values:
        ax.plot(x, y)
    ax.set_ylim(bottom=0.0)
    label_lines(ax, [Named(x, y, f"{n} N/mm", "k") for n, y in enumerate(values)])
    for number, text in enumerate(ax.texts):
        box = text.get_window_extent()
        for other in (y for n, y in enumerate(values) if n != number):
            fine = np.linspace(x[0], x[-1], 20_000)
            points = ax.transData.transform(np.stack([fine, np.interp(fine, x, other)], axis=1))
            inside = (points > [box.x0, box.y0]).all(axis=1) & (points < [box.x1, box.y1]).all(
                axis=1
            )
            assert not inside.any()
    assert len(ax.texts) == 3


def test_lines_are_named_once_the_limits_of_their_panel_are_known(made, monkeypatch):
    seen = []

    def limits(ax):
        return *ax.get_xlim(), *ax.get_ylim()

    def kept(ax, lines, others=()):
        seen.extend([(ax, limits(ax))] if lines else [])

    monkeypatch.setattr(curves, "label_lines", kept)
    draw_sweep(made["line"][1])
    assert seen
    assert all(limits(ax) == then for ax, then in seen)


def test_a_name_beside_a_line_is_close_to_it_and_off_the_frame():
    x = np.linspace(0.0, 1.0, 101)
    ax = axes(new_canvas(5), 1, 1, 8, 1.7)
    ax.set(xlim=(0, 1), ylim=(0, 1))
    label_lines(ax, [Named(x, 0.4 + 0.1 * x, "line", "k"), Named(x, 0.0 * x, "other", "k")])
    box = ax.texts[0].get_window_extent().transformed(ax.transData.inverted())
    assert 0.0 < box.y0 - (0.4 + 0.1 * box.x1) < 0.12  # 0.2 cm
    assert 0.02 < box.y0 < box.y1 < 0.98


def test_a_name_on_a_line_leaves_the_ends_of_its_stretches_seen():
    """Two lines that coincide have no room beside them; the middle of the panel is where both are broken."""
    x = np.linspace(0.0, 1.0, 41)
    ax = axes(new_canvas(5), 1, 1, 8, 1.7)
    ax.set(xlim=(0, 1), ylim=(0, 1))
    label_lines(ax, [Named(x, 0.0 * x + 0.5, text, "k", breaks=[20]) for text in ("one", "two")])
    assert len(ax.texts) == 2
    for text in ax.texts:
        box = text.get_window_extent().transformed(ax.transData.inverted())
        assert box.y0 < 0.5 < box.y1
        assert not any(box.x0 < x[n] < box.x1 for n in (0, 20, 21, 40))


def test_a_steep_line_is_named_left_or_right_of_it():
    """Level curves of a boundary, one of them upright along the whole panel, and a curve on its left."""
    y = np.linspace(0.0, 1.0, 101)
    ax = axes(new_canvas(7), 1, 1, 8, 5)
    ax.set(xlim=(0, 1), ylim=(0, 1))
    label_lines(ax, [Named(0.0 * y + 0.3, y, "a long name of it", "k")], [(0.0 * y + 0.28, y)])
    box = ax.texts[0].get_window_extent().transformed(ax.transData.inverted())
    assert 0.3 < box.x0 < 0.34


def test_a_line_of_few_points_is_named_beside_it(made):
    """Of ten rows, neighbours are a centimetre apart: no jump."""
    x = np.linspace(0.0, 1.0, 10)
    ax = axes(new_canvas(5), 1, 1, 8, 1.7)
    ax.set(xlim=(0, 1), ylim=(0, 1))
    label_lines(ax, [Named(x, 0.0 * x + 0.5, "few", "k", breaks=[])])
    box = ax.texts[0].get_window_extent().transformed(ax.transData.inverted())
    assert box.y1 < 0.5 or box.y0 > 0.5
    row = made["line"][1].isel(nu=slice(0, 10))
    (line,) = lines_of(row, None)
    y = np.where(np.arange(10) == 4, np.nan, 1.0)
    assert breaks_of(row.nu.values, y, line, False) == [3, 4]


def test_names_of_lines_of_many_points_are_written_at_once(monkeypatch):
    x, compared = np.linspace(0.0, 1.0, 40_001), [0]
    chaos = np.random.default_rng(1).random(x.size)
    lines = [Named(x, chaos, "chaos", "k"), Named(x, 0.5 + 0.4 * np.sin(9 * x), "wave", "k")]
    lines.append(Named(x, np.full(x.size, np.nan), "nowhere", "k"))
    plain = line_names._distance

    def counted(at, half, others):
        compared[0] += len(at) * sum(map(len, others))
        return plain(at, half, others)

    monkeypatch.setattr(line_names, "_distance", counted)
    ax = axes(new_canvas(5), 1, 1, 8, 3)
    for line in lines:
        ax.plot(line.x, line.y)
    label_lines(ax, lines)
    assert compared[0] < 2e8  # of 40,001 points with each other 6e9


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
    dataset["regime"][9:12] = [Regime.APERIODIC, Regime.TWO_SIDED, Regime.APERIODIC]
    figure = draw("sweep", dataset)
    points = [line for line in figure.axes[0].lines if line.get_marker() == "."]
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
    alone = draw("sweep", dataset)
    beside = draw("sweep", dataset, SweepFigure(backbone="free"), {"free": free})
    # Three curves for the harmonics, which share a panel, one for the mean displacement.
    for one, two, amount in zip(alone.axes[:2], beside.axes[:2], (3, 1), strict=True):
        assert len(two.lines) == len(one.lines) + amount
        assert np.array_equal(two.lines[0].get_xdata(), free["eigenfrequency"].values)
        assert two.lines[0].get_zorder() < two.lines[-1].get_zorder()
    assert "free motion without losses" in describe_sweep(dataset, backbone=free)


def test_grids_of_constant_factor_get_log_axes(made):
    nu = np.geomspace(0.01, 10, made["line"][1].sizes["nu"])
    line = made["line"][1].assign_coords(nu=nu)
    over = made["map"][1].assign_coords(nu=np.geomspace(0.01, 10, 60))
    assert all(ax.get_xscale() == "log" for ax in draw("sweep", line).axes)
    chart = draw("sweep", over)
    chart.draw_without_rendering()
    assert (chart.axes[0].get_xscale(), chart.axes[0].get_yscale()) == ("log", "linear")
    edges = cell_edges(nu)
    assert edges.size == nu.size + 1
    assert np.allclose(edges[1:-1] ** 2, nu[1:] * nu[:-1])


def test_cells_do_not_claim_what_lies_beyond_a_grid():
    assert np.allclose(cell_edges(np.linspace(0, 1, 21)), np.linspace(-0.025, 1.025, 22))
    assert np.allclose(cell_edges(np.array([75.0, 220.0])), [67.75, 147.5, 227.25])
    assert np.allclose(cell_edges(np.array([0.02])), [0.019, 0.021])
    assert np.allclose(cell_edges(np.array([0.0])), [-0.05, 0.05])
    edges = cell_edges(np.geomspace(1, 100, 4))
    assert 0.78 < edges[0] < 1 < 100 < edges[-1] < 128


def test_a_hatch_fills_the_cells_of_its_region():
    edges = np.array([0.5, 1.5, 3.0, 5.0]), np.array([-1.0, 0.0, 1.0, 4.0])
    ax = axes(new_canvas(5), 1, 1, 8, 3)
    draw_hatch(ax, edges, np.array([[0, 0, 0], [0, 1, 0], [0, 0, 0]]) > 0, "//", "k")
    box = ax.collections[0].get_paths()[0].get_extents()
    assert (box.x0, box.y0, box.x1, box.y1) == pytest.approx((1.5, 0.0, 3.0, 1.0))
    corner = ax.collections[0].get_paths()[0].contains_point((1.51, 0.99), radius=0.0)
    assert corner  # not the rhombus between the middles of the neighbours


def test_the_scale_of_a_map_of_few_points_ends_at_the_largest():
    def of_values(values):
        points = {"displacement_mean": (("nu", "f"), values)}
        return xr.Dataset({**points, "regime": (("nu", "f"), np.zeros(values.shape, np.int8))})

    few = of_values(np.arange(9.0).reshape(3, 3))
    assert value_norm(few, "displacement_mean").vmax == 8.0
    many = of_values(np.arange(1e4).reshape(100, 100))
    top = value_norm(many, "displacement_mean").vmax
    assert 0.0 < (many["displacement_mean"] > top).mean() <= 0.005


def test_the_bar_of_a_lone_row_is_narrow(made):
    figure = draw("sweep", made["line"][1].isel(nu=[30]))
    bars = figure.axes[-1]
    (bar,) = [c for c in bars.collections if isinstance(c, PolyCollection)]
    width = np.ptp(bar.get_paths()[0].vertices[:, 0])
    low, high = bars.get_xlim()
    assert width == pytest.approx(0.1 * (high - low))


def test_a_descending_grid_is_drawn_ascending(made):
    dataset = made["line"][1]
    up = draw("sweep", dataset)
    down = draw("sweep", dataset.isel(nu=slice(None, None, -1)))
    for one, two in zip(up.axes, down.axes, strict=True):
        assert one.get_xlim() == two.get_xlim()
        for line, other in zip(one.lines, two.lines, strict=True):
            assert np.array_equal(line.get_xdata(), other.get_xdata())


def test_negative_states_at_the_section_are_drawn(made):
    dataset = made["line"][1]
    strobe = xr.DataArray(-0.1 - 0.1 * dataset["nu"], name="displacement_strobe")
    figure = draw(
        "sweep",
        dataset.assign(displacement_strobe=strobe),
        SweepFigure(show=["displacement_strobe"]),
    )
    low, high = figure.axes[0].get_ylim()
    assert low < float(strobe.min()) < float(strobe.max()) < high
    both = made["map"][1].assign(
        displacement_strobe=-0.1 * made["map"][1]["nu"] + 0 * made["map"][1]["f"]
    )
    norm = value_norm(both, "displacement_strobe")
    assert norm.vmax == -norm.vmin == pytest.approx(0.3, abs=0.02)


def test_small_velocities_are_not_taken_for_rounding_beside_impacts_per_period():
    tiny = vp.Exciter(l=1e-9, f=1.6e-9, h=0.15, R1=0.7, R2=0.6)
    rows = vp.sweep(tiny, {"nu": np.linspace(0.5, 2.0, 11)})  # two impacts a period at first
    figure = draw_sweep(rows)
    (ax,) = (
        ax for ax in figure.axes if any("velocity before" in text.get_text() for text in ax.texts)
    )
    low, high = ax.get_ylim()
    largest = float(rows["impact_velocity_max"].max())
    assert low == 0.0
    assert largest <= high <= 2.0 * largest


def test_a_sweep_of_one_point(made):
    figure = draw("sweep", made["line"][1].isel(nu=[30]))
    figure.draw_without_rendering()
    assert "both supports struck" in words(figure)


def test_maps_are_pixels_and_say_where_there_is_no_value(figures, made):
    drawn = draw_quantity_maps(made["map"][1], ["impact_velocity_max", "displacement_mean"])
    drawn.draw_without_rendering()
    assert len(figures["map"].findobj(QuadMesh)) == 1
    meshes = [mesh for ax in drawn.axes[::2] for mesh in ax.findobj(QuadMesh)]
    assert len(meshes) == 3
    assert all(mesh.get_rasterized() for mesh in [*meshes, *figures["map"].findobj(QuadMesh)])
    for number, ax in zip((1, 2), drawn.axes[::2], strict=False):
        assert f"largest velocity before impact, support {number}" in ax.texts[-1].get_text()
    assert "no value" in words(drawn)


def test_the_widest_spot_of_a_region():
    mask = np.zeros((40, 40), dtype=bool)
    mask[5:30, 10:35] = True
    row, column = widest_spot(mask)
    assert abs(row - 17) <= 1
    assert abs(column - 22) <= 1
    assert widest_spot(np.eye(40, dtype=bool)) is None


def test_a_panel_has_as_many_lines_as_there_are_styles():
    assert len(LINES) == MAX_LINES


def followed(amplitudes, offsets):
    """A sweep in which only lines of large amplitude jump, and only columns with an offset have a second harmonic."""
    over = {"nu": np.linspace(0.5, 4.0, 36), "f": amplitudes, "delta": offsets}
    exciter = vp.Exciter(l=0.5, nu=1.0, f=1.0, h=0.15, R1=0.7, R2=0.6)
    return vp.sweep(exciter, over, follow=("nu", "up"), outputs=["harmonics"])


def test_columns_share_an_ordinate_that_holds_them_all():
    dataset = followed([0.01, 0.8], [0.0, 0.1])
    figure = draw_sweep(dataset)
    drawn = [
        (ax.get_ylim()[1], np.nanmax(line.get_ydata()))
        for ax in figure.axes
        for line in ax.lines
        if len(line.get_ydata()) > 1 and np.isfinite(line.get_ydata()).any()
    ]
    assert len(drawn) > 8
    assert all(top >= largest for top, largest in drawn)


@pytest.mark.parametrize("amplitudes", [[0.01], [0.01, 0.8], [0.8]])
def test_a_caption_tells_of_arrows_where_there_are_some(amplitudes):
    dataset = followed(amplitudes, [0.0, 0.1])
    texts = [text for ax in draw_sweep(dataset).axes for text in ax.texts]
    has_arrow = any(getattr(text, "arrow_patch", None) is not None for text in texts)
    assert ("arrows: jumps" in describe_sweep(dataset)) == has_arrow
    assert has_arrow == (0.8 in amplitudes)


def test_small_multiples_fit_on_page_1_at_their_size():
    figure = draw("sweep", sweep(31, f=[0.1, 0.2], delta=[0.0, 0.1, 0.2]))
    width, height = figure.get_size_inches() * 2.54
    assert width == pytest.approx(16.0)
    assert height < 15.5  # a higher one is made smaller there, letters and all
    panels = [ax for ax in figure.axes if ax.get_ylabel() or len(ax.lines) > 1]
    assert min(ax.get_position().height * height for ax in panels) > 1.5


def test_small_multiples_of_one_quantity_say_which():
    over = {"nu": [0.8, 1.0, 1.2], "f": [0.5, 0.8], "delta": [0.0, 0.1], "R1": [0.6, 0.8]}
    figure = draw_sweep(vp.sweep(vp.Exciter(l=0.5, nu=1.0, f=1.0, h=0.2, R2=0.6), over))
    (label,) = {ax.get_ylabel().replace("\n", " ") for ax in figure.axes} - {""}
    assert label == "first harmonic amplitude of displacement $A_1$"
