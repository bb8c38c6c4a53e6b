"""Panels, laws of motion and layout of the pictures of sweeps."""

from itertools import combinations

import numpy as np
import pytest
import xarray as xr
from drawing import draw, picture_of
from figures.figure_text import texts, words
from figures.sample_datasets import sweep
from matplotlib.collections import QuadMesh
from matplotlib.text import Annotation
from sampling import sampled

from vibropipe.figures.canvas import CM_PER_INCH, SMALL, WIDE
from vibropipe.figures.map_shapes import borders
from vibropipe.figures.palette import lightness
from vibropipe.figures.style import house_style
from vibropipe.report.findings import place_texts
from vibropipe.scenes.sweep.captions import describe_map, describe_quantities, describe_sweep
from vibropipe.scenes.sweep.curves import draw_sweep
from vibropipe.scenes.sweep.figure_keys import SweepFigure
from vibropipe.scenes.sweep.laws import (
    MORE,
    OTHER,
    Law,
    chosen_rows,
    laws_of,
    regions_of,
    share_text,
)
from vibropipe.scenes.sweep.lines import BAR_NAME
from vibropipe.scenes.sweep.maps import draw_quantity_maps, draw_regime_map
from vibropipe.scenes.sweep.neighbours import jump_steps
from vibropipe.scenes.sweep.quantities import fitted_label, panels_of
from vibropipe.scenes.sweep.report import tables
from vibropipe.scenes.sweep.sweep_rows import axis_and_others, directions, swept
from vibropipe.scenes.sweep.titles import map_title, quantities_title
from vibropipe.words.regimes import Regime
from vibropipe.words.vocabulary import describe

PAGE_CM = 21.5  # height of a figure with its caption below on A4


def with_impacts(dataset: xr.Dataset) -> xr.Dataset:
    """Add impacts per orbit: m on support 1, and on support 2 m up to nu = 1, else 2 m."""
    m = dataset["period_multiple"]
    second = m.where(dataset["nu"] < 1, 2 * m)
    both = xr.concat([m, second], "support").transpose(*m.dims, "support").astype(float)
    return dataset.assign(impacts_per_orbit=both)


def followed(dataset: xr.Dataset) -> xr.Dataset:
    """Return rows followed up and down; downwards, nothing is struck above nu = 1.5 (a hysteresis)."""
    down = dataset.copy(deep=True)
    late = (down["nu"] > 1.5).broadcast_like(down["regime"])
    down["regime"] = down["regime"].where(~late, Regime.NO_IMPACT).astype(np.int8)
    down["displacement_mean"] = down["displacement_mean"].where(~late, 0.3)
    both = xr.concat([dataset, down], "direction").assign_coords(direction=["up", "down"])
    for name in both.variables:
        if name in dataset:
            both[name].attrs = dataset[name].attrs
    return both.assign_attrs(follow="nu both")


def test_a_sweep_of_one_parameter_shows_what_a_design_needs():
    figure = draw("sweep", with_impacts(sweep()))
    said = words(figure).replace("\n", " ")
    for text in ("mean displacement", "harmonic amplitude", "velocity before impact",
                 "impacts per forcing period", "support 1", "support 2", "$A_1$"):  # fmt: skip
        assert text in said
    names = [
        text.get_text() for ax in figure.axes for text in ax.texts if text.get_gid() == BAR_NAME
    ]
    assert names == ["no impact", "aperiodic"]  # other bars are too short for their words
    assert "each support struck once a period" in words(figure)


def test_lines_are_named_where_they_are_and_names_do_not_overlap():
    dataset = sweep(f=[0.1, 0.2, 0.5])
    figure = draw_sweep(dataset)
    figure.draw_without_rendering()
    main = figure.axes[0]
    names = [
        text
        for text in main.texts
        if text.get_transform() == main.transAxes and text.get_bbox_patch()
    ]
    assert [text.get_text() for text in names] == ["$f$ = 0.1", "0.2", "0.5"]
    boxes = [text.get_window_extent() for text in names]
    assert not any(a.overlaps(b) for a, b in combinations(boxes, 2))
    colours = {text.get_color() for text in names}
    assert len(colours) == 3
    points = [main.transData.transform(np.column_stack(line.get_data())) for line in main.lines]
    for box in boxes:  # a name stands beside a line
        at = np.array([box.x0 + box.x1, box.y0 + box.y1]) / 2
        assert min(np.nanmin(np.hypot(*(p - at).T)) for p in points if len(p)) < 20.0


def test_bars_are_aligned_with_the_panels():
    figure = draw("sweep", sweep())
    figure.draw_without_rendering()
    boxes = [ax.get_position().intervalx for ax in figure.axes]
    assert all(np.allclose(box, boxes[0], atol=1e-6) for box in boxes)
    assert len({ax.get_xlim() for ax in figure.axes}) == 1


def test_panels_follow_show_and_the_data():
    dataset = with_impacts(sweep())
    assert [p.series[0].name for p in panels_of(dataset, ["impact_velocity_max", "energy_input"])] == [
        "impact_velocity_max", "impact_velocity_max",
    ]  # fmt: skip
    soft = dataset.assign(energy_friction=0 * dataset["displacement_mean"])
    assert panels_of(soft, ["energy_friction"]) == []
    assert len(panels_of(dataset, joined=True)) == 3
    # three harmonics, the mean displacement, the larger velocity of both supports
    assert len(panels_of(dataset)) == 5


def test_both_directions_are_in_one_picture():
    both = followed(sweep())
    assert swept(both) == ["nu"]
    assert axis_and_others(both) == ("nu", [])
    assert directions(both) == ["up", "down"]
    figure = draw("sweep", both, SweepFigure(show=["displacement_mean"]))
    panel, bars = figure.axes
    arrows = [text for text in panel.texts if isinstance(text, Annotation)]
    assert arrows
    for (
        each
    ) in arrows:  # jumps, in the direction that was followed: only where the directions differ
        assert each.xy[0] < each.xyann[0]
        assert each.xy[0] == pytest.approx(1.5, abs=0.03)
    assert [label.get_text() for label in bars.get_yticklabels()] == ["↑", "↓"]
    assert "followed upwards and downwards along ν; arrows: jumps" in describe_sweep(both)


def test_a_single_direction_is_named():
    dataset = sweep().assign_attrs(follow="nu up")
    assert "followed upwards along ν" in describe_sweep(dataset)
    assert "followed" not in describe_sweep(sweep())


def test_lines_are_broken_at_jumps_and_counts_at_changes():
    x, values = np.arange(8.0), np.array([1.0, 1.1, 1.2, 1.3, 3.0, 3.1, 3.2, 3.3])
    struck = np.full(8, int(Regime.TWO_SIDED))
    assert jump_steps(x, values, struck).tolist() == [3]
    assert jump_steps(x, values, np.zeros(8, int)).size == 0
    assert jump_steps(x, np.where(x == 4, np.nan, values), struck).size == 0


def test_laws_are_told_by_m_and_the_impacts_on_each_support():
    dataset = with_impacts(sweep(60, f=np.linspace(0.05, 2, 50), all_regimes=True))
    codes, laws = laws_of(dataset)
    assert codes.dims == dataset["regime"].dims
    for number, law in enumerate(laws):
        rows = codes.values == number
        assert (dataset["regime"].values[rows] == law.regime).all()
        if law.m > 0:
            assert (dataset["period_multiple"].values[rows] == law.m).all()
            counts = dataset["impacts_per_orbit"].values[rows]
            assert (counts == [law.p1, law.p2]).all()
    assert {"(1; 1, 1)", "(1; 1, 2)", "with rest", "aperiodic"} <= {law.short for law in laws}


def test_rare_laws_of_a_regime_share_a_look():
    dataset = with_impacts(sweep(300))
    dataset["regime"][:] = Regime.TWO_SIDED
    dataset["period_multiple"][:] = np.concatenate([np.ones(260), np.arange(2, 42)])
    _, laws = laws_of(dataset.assign(impacts_per_orbit=with_impacts(dataset)["impacts_per_orbit"]))
    assert len(laws) <= 14
    assert [law.text for law in laws if law.m == OTHER] == ["two-sided, other"]


def test_laws_are_told_apart_in_grey():
    dataset = with_impacts(sweep(60, f=np.linspace(0.05, 2, 50), all_regimes=True))
    _, laws = laws_of(dataset)
    for one, other in combinations(laws, 2):
        assert abs(lightness(one.colour) - lightness(other.colour)) >= 8 or one.hatch != other.hatch


def test_regions_are_told_by_the_impacts_on_each_support():
    dataset = with_impacts(sweep(60, f=np.linspace(0.05, 2, 50), all_regimes=True))
    codes, regions = regions_of(dataset)
    assert sum(region.amount for region in regions) == codes.size
    m, per_orbit = dataset["period_multiple"], dataset["impacts_per_orbit"]
    once = (m == 1) & (per_orbit == 1).all("support") & (dataset["regime"] == Regime.TWO_SIDED)
    assert np.array_equal(codes == int(Regime.TWO_SIDED), once)
    more = next(region for region in regions if region.code == MORE)
    assert more.words == "both supports struck, more often"
    assert more.share == share_text(
        int(((dataset["regime"] == Regime.TWO_SIDED) & ~once).sum()), 3000
    )
    bare, _ = regions_of(dataset.drop_vars("impacts_per_orbit"))
    assert not (bare == MORE).any()


def test_regions_are_labelled_with_shares_and_labels_do_not_overlap():
    dataset = with_impacts(sweep(60, f=np.linspace(0.05, 2, 50), all_regimes=True))
    figure = draw_regime_map(dataset)
    figure.draw_without_rendering()
    boxes = [text.get_window_extent() for text in figure.axes[0].texts]
    frame = figure.axes[0].get_window_extent()
    said = words(figure).replace("\n", " ")
    for region in regions_of(dataset)[1]:
        assert f"{region.words} {region.share}" in said or f"{region.words}, {region.share}" in said
    assert not any(a.overlaps(b) for a, b in combinations(boxes, 2))
    assert all(frame.x0 <= box.x0 and box.x1 <= frame.x1 for box in boxes)


def test_a_map_has_its_most_frequent_orbits_in_a_table():
    dataset = with_impacts(sweep(60, f=np.linspace(0.05, 2, 50)))
    (table,) = tables({"map": dataset})
    rows = [tuple(int(cell) for cell in row[:3]) for row in table.rows]
    assert (1, 1, 2) in rows
    assert not any(row[3].startswith("under") for row in table.rows)
    m, p = dataset["period_multiple"].values, dataset["impacts_per_orbit"].values
    strikes = np.isin(dataset["regime"].values, [1, 2, 3])
    for row, cells in zip(rows, table.rows, strict=True):
        amount = int((strikes & (m == row[0]) & (p == row[1:]).all(-1)).sum())
        assert cells[3] == share_text(amount, m.size)


def test_titles_of_maps_say_what_is_seen():
    f = np.linspace(0.05, 2, 50)
    dataset = sweep(60, f=f)
    kept = dataset.isel(nu=dataset["nu"].values < 2.5)
    assert map_title(kept) == "Above one border in f the mass strikes a support, below it none"
    few = kept.isel(f=kept["f"].values > 1.2)  # most columns have no border
    few["regime"][0, 0] = Regime.NO_IMPACT
    assert (few["regime"] == Regime.NO_IMPACT).any("f").mean() < 0.5
    assert "kinds of motion share" in map_title(few)
    apart = kept.copy(deep=True)  # a border in nu alone, between two others
    apart["regime"][:] = np.where(
        (kept.nu > 1) & (kept.nu < 2), Regime.NO_IMPACT, Regime.WITH_REST
    )[:, None]
    assert map_title(apart) == "Two kinds of motion share the plane of ν and f"
    island = kept.copy(deep=True)
    island["regime"][5, 3] = Regime.ONE_SIDED_1
    assert map_title(island) == "Four kinds of motion share the plane of ν and f"
    orbits = kept["regime"] < Regime.APERIODIC
    velocity = kept["impact_velocity_max"].max("support").where(orbits)
    row = np.unravel_index(np.nanargmax(velocity), velocity.shape)
    at = {name: velocity[name].values[n] for name, n in zip(velocity.dims, row, strict=True)}
    place = f"ν = {at['nu']:.4g} and, at the end of its range, f = {f[-1]:.4g}"
    assert at["f"] == f[-1]
    assert quantities_title(kept) == f"On the grid, orbits strike hardest at {place}"
    ways = xr.concat([kept, kept], xr.Variable("direction", ["up", "down"]))
    ways = ways.assign_coords(direction=["up", "down"])
    assert quantities_title(ways) == f"On the grid, orbits strike hardest at {place}"
    everywhere = kept.copy(deep=True)  # as of many starts that settle on one motion
    everywhere["impact_velocity_max"].values[:] = 1.0 + 1e-15 * np.arange(f.size)[:, None]
    assert "at" not in quantities_title(everywhere)
    beside = kept.copy(deep=True)
    beside["regime"].loc[at] = Regime.TWO_SIDED
    beside["regime"][row[0], row[1] - 1] = Regime.APERIODIC
    assert quantities_title(beside) == "On the grid, orbits strike hardest beside aperiodic motion"
    tongue = island.copy(deep=True)
    tongue["regime"][10:20, 30:] = Regime.APERIODIC
    where = "between ν = 0.7118 and 1.216 and above f = 1.204"  # rounded outwards
    assert map_title(tongue) == f"The largest aperiodic region lies {where}"
    tongue["regime"][25:35, 30:] = Regime.APERIODIC  # another one of as many points
    where = "between ν = 0.7118 and 1.216 and above f = 1.204"
    assert map_title(tongue) == f"An aperiodic region lies {where}"
    corner = kept.where(kept["f"] < at["f"], 0.9 * kept)
    corner["regime"] = kept["regime"]
    corner["impact_velocity_max"][0, 0, 0] = 9.0
    ends = f"ν = {corner['nu'].values[0]:.4g}, f = {f[0]:.4g}, the ends of their ranges"
    assert quantities_title(corner.transpose(*kept.dims)).endswith(ends)
    assert "White is 0, orange positive, towards support 1" in describe_quantities(kept)


def test_the_label_of_a_narrow_axis_keeps_the_symbol():
    force = xr.DataArray(0.0, name="F", attrs={"units": "N"})
    assert [fitted_label(force, width) for width in (7.0, 3.5, 1.0)] == [
        "amplitude of excitation $F$ (N)", "amplitude $F$ (N)", "$F$ (N)",
    ]  # fmt: skip


def test_the_title_of_maps_says_that_a_value_lies_at_an_end_in_few_letters_too():
    dataset = xr.Dataset(
        {"regime": (("nu", "f"), np.zeros((3, 3)))}, {"nu": [1.0, 2.0, 3.0], "f": [0.25, 0.5, 1.0]}
    )
    dataset = describe(dataset)
    assert place_texts(dataset, dataset.regime.sel(nu=3.0, f=0.5)) == [
        "f = 0.5 and, at the end of its range, ν = 3", "f = 0.5 and the largest ν"
    ]  # fmt: skip
    assert place_texts(dataset, dataset.regime.sel(nu=1.0, f=1.0)) == [
        "ν = 1, f = 1, the ends of their ranges", "the smallest ν and the largest f"
    ]  # fmt: skip


def test_maps_say_what_is_shown_of_motions_without_an_orbit():
    dataset = sweep(30, f=np.linspace(0.05, 2, 25))
    orbits = dataset.assign(regime=xr.full_like(dataset["regime"], Regime.TWO_SIDED))
    orbits["displacement_mean"][10, 10] = 5.0
    show = ["displacement_mean"]
    assert "Lines" not in describe_quantities(orbits, show)
    assert "orbit" not in describe_quantities(orbits, show)
    assert quantities_title(orbits, show).startswith(
        "On the grid, the mean displacement is largest"
    )
    chaos = orbits.copy(deep=True)
    chaos["regime"][3, 4] = Regime.APERIODIC
    assert "Lines" not in describe_quantities(chaos, show)  # a point alone has no outline
    chaos["regime"][3, 5] = Regime.APERIODIC
    told = describe_quantities(chaos, show)
    assert "Lines: borders of aperiodic motion (under 1 %). " in told
    assert "Without an orbit: the average in a window" in told
    assert quantities_title(chaos, show).startswith("On the grid, mean displacement of orbits is")
    chaos["displacement_mean"][3, 4:6] = np.nan
    told = describe_quantities(chaos, show)
    assert "Lines: borders of hatched points without a value" in told
    assert "without an orbit" not in told
    assert "from the equilibrium without velocity" in describe_quantities(
        orbits.assign_attrs(start="x0 = 0 m, v0 = 0 m/s"), show
    )


@pytest.mark.parametrize("both", [False, True], ids=["offsets", "directions"])
def test_maps_of_several_quantities_and_directions_are_legible(both):
    grids = {"f": np.linspace(0.05, 2, 30)}
    dataset = sweep(31, **grids, **({} if both else {"delta": [0.0, 0.1]}))
    dataset = followed(dataset) if both else dataset
    show = ["impact_velocity_max", "displacement_mean", "displacement_amplitude"]
    figure = draw_quantity_maps(dataset, show)
    figure.draw_without_rendering()
    panels = [ax for ax in figure.axes if ax.findobj(QuadMesh) and len(ax.texts) >= 2]
    assert len(panels) == 8
    titles = [text.get_text() for ax in panels for text in ax.texts]
    value = (
        ("followed upwards", "followed downwards") if both else ("$\\delta$ = 0", "$\\delta$ = 0.1")
    )
    assert all(titles.count(text) == 4 for text in value)
    boxes = [text.get_window_extent().padded(-1.0) for text in texts(figure)]
    assert not any(a.overlaps(b) for a, b in combinations(boxes, 2) if a.width > 0 < b.width)
    assert figure.get_figheight() * CM_PER_INCH <= PAGE_CM


def test_outlines_lie_between_regions_and_leave_speckles_out():
    codes = np.zeros((6, 8), int)
    codes[:, 4:] = 1
    codes[2, 1] = 5
    x, y = borders(codes, np.arange(9.0), np.arange(7.0))
    assert set(x[np.isfinite(x)]) == {4.0}
    assert sorted(set(y[np.isfinite(y)])) == list(np.arange(7.0))
    assert borders(np.zeros((4, 4), int), np.arange(5.0), np.arange(5.0)) is None
    codes[:, 6] = 2  # a region one cell wide has both borders
    x, _y = borders(codes, np.arange(9.0), np.arange(7.0))
    assert set(x[np.isfinite(x)]) == {4.0, 6.0, 7.0}


@pytest.mark.parametrize("count", sampled([2, 3, 4, 9, 30], 9))
@pytest.mark.parametrize("drawn", [draw_sweep, draw_regime_map])
def test_three_parameters_are_legible_multiples_on_a_page(count, drawn):
    lines = [0.1, 0.5] if drawn is draw_sweep else np.linspace(0.05, 2, 30)
    dataset = with_impacts(sweep(31, f=lines, delta=np.linspace(0, 0.2, count), all_regimes=True))
    figure = drawn(dataset)
    figure.draw_without_rendering()
    assert figure.get_figheight() * CM_PER_INCH <= PAGE_CM + 0.1
    assert figure.get_figwidth() * CM_PER_INCH == pytest.approx(WIDE)
    assert min(text.get_fontsize() for text in texts(figure)) >= SMALL
    boxes = [text.get_window_extent().padded(-1.0) for text in texts(figure)]
    assert not any(a.overlaps(b) for a, b in combinations(boxes, 2) if a.width > 0 < b.width)
    smallest = min(
        ax.get_window_extent().height for ax in figure.axes if ax.collections or ax.lines
    )
    assert smallest > 15
    describe = describe_sweep if drawn is draw_sweep else describe_map
    assert ("12 evenly spaced" in describe(dataset)) == (count == 30)


def test_one_row_of_each_law_is_chosen():
    dataset = with_impacts(sweep(all_regimes=True))
    rows = chosen_rows(dataset, 9)
    codes, laws = laws_of(dataset)
    assert len({law for _, law in rows}) == len(rows)
    for index, law in rows:
        assert laws[int(codes.values.ravel()[index])] == law
        assert law.regime not in (Regime.UNRESOLVED, Regime.UNBOUNDED)


def test_numbers_of_impacts_in_words_do_not_run_into_the_number_of_a_support() -> None:
    assert Law(Regime.TWO_SIDED, 1, 2, 3).words == "support 1 twice, support 2 three times a period"
    assert Law(Regime.ONE_SIDED_2, 3, 0, 4).words == "support 2 four times in three periods"


def test_energies_of_a_map_are_maps():
    grid = sweep(9, f=np.linspace(0.1, 0.9, 8))
    for name in ("energy_input", "energy_damping"):
        grid[name] = (grid["displacement_mean"].dims, np.ones(grid["displacement_mean"].shape))
    few = grid.isel(f=slice(3))
    for dataset, amount in ((grid, 2), (few, 0)):
        picture = picture_of("sweep", describe(dataset), "energy")
        with house_style():
            figure = picture.draw(describe(dataset), None, {})
        meshes = [m for ax in figure.axes for m in ax.collections if isinstance(m, QuadMesh)]
        assert len([mesh for mesh in meshes if mesh.axes.get_xlabel().startswith("freq")]) == amount
        caption = picture.describe(describe(dataset), None, {})
        assert caption.startswith(
            "Steady state at 9 × 8 points" if amount else "Steady states against"
        )
