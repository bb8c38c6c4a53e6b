"""Phase portraits, sections, spectra, energies and bifurcation diagrams: what is drawn where."""

from itertools import combinations

import numpy as np
import pytest
import xarray as xr
from figures.figure_text import texts, words
from figures.sample_datasets import motion, steady, sweep
from matplotlib import style
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

import vibropipe as vp
from vibropipe.figures.canvas import axes, new_canvas
from vibropipe.figures.phase_plane import (
    Impacts,
    certain_jumps,
    draw_points,
    draw_spectrum,
    lines_of,
    path,
    spectrum_handles,
)
from vibropipe.figures.style import MAX_VECTOR, save_as
from vibropipe.scenes.motion.balance import describe_energy, draw_energy, draw_spectra, energy_terms
from vibropipe.scenes.motion.curves import curve
from vibropipe.scenes.motion.phase_plane import draw_phase_portrait, draw_section, visits
from vibropipe.scenes.sweep.bifurcation import describe_bifurcation, draw_bifurcation, points_of
from vibropipe.scenes.sweep.bifurcation import diagram_panels as panels_of
from vibropipe.scenes.sweep.curves import draw_sweep
from vibropipe.scenes.sweep.keys import SweepFigure
from vibropipe.scenes.sweep.pictures import PICTURES
from vibropipe.scenes.sweep.sweep_rows import orbit_impacts, row_at
from vibropipe.words.regimes import Regime


def ragged(dataset: xr.Dataset, periods: int = 64) -> xr.Dataset:
    """Add impacts to a sweep: one on each support, and in aperiodic rows one a period on support 1."""
    regime = dataset["regime"].values
    sizes = np.where(regime == Regime.APERIODIC, periods, 2)
    rows = np.repeat(np.arange(sizes.size), sizes.ravel())
    first = np.concatenate([[0], np.cumsum(sizes.ravel())])[rows]
    number = np.arange(rows.size) - first
    aperiodic = regime.ravel()[rows] == Regime.APERIODIC
    support = np.where(aperiodic, 1, number + 1).astype(np.int8)
    velocity = np.where(support == 1, 1.0, -1.0) * (1 + rows + number / 100)
    visit = np.where((regime == Regime.APERIODIC)[..., None], np.linspace(-0.4, 0.4, 64), 0.1)
    return dataset.assign(
        row_size=(dataset["regime"].dims, sizes),
        impact_phase=("impact", np.where(aperiodic, 0.5, 0.25 + 0.5 * number)),
        impact_period=("impact", np.where(aperiodic, number, 0).astype(np.int32)),
        impact_support=("impact", support),
        impact_velocity=("impact", velocity),
        poincare_displacement=((*dataset["regime"].dims, "visit"), visit),
        poincare_velocity=((*dataset["regime"].dims, "visit"), visit**2),
    )


def overlapping(figure) -> bool:
    figure.draw_without_rendering()
    boxes = [text.get_window_extent().padded(-1.0) for text in texts(figure)]
    return any(a.overlaps(b) for a, b in combinations(boxes, 2) if a.width > 0 < b.width)


def test_a_path_has_its_jumps_on_the_supports():
    time = np.linspace(0, 1, 11)
    impacts = Impacts(np.array([0.5]), np.array([1], np.int8), np.array([2.0]), np.array([-1.0]))
    x, v = path(time, time, time, impacts, {1: 0.7, 2: -0.7})
    (gap,) = np.flatnonzero(np.isnan(v))
    assert np.array_equal(x[[gap - 1, gap + 1]], [0.7, 0.7])
    assert np.array_equal(v[[gap - 1, gap + 1]], [2.0, -1.0])
    assert x.size == 11 - 1 + 3  # the sample at the impact is dropped


def test_the_jumps_of_a_portrait_are_vertical():
    dataset = motion()
    figure = draw_phase_portrait(dataset, 2)
    segments = [
        segment
        for lines in figure.axes[0].findobj(LineCollection)
        for segment in lines.get_segments()
    ]
    assert len(segments) >= 4
    for segment in segments:
        assert segment[0][0] == segment[1][0]
        assert abs(segment[0][0]) == 0.5
        assert segment[1][1] == pytest.approx(-0.7 * segment[0][1])
    curve_x = figure.axes[0].lines[0].get_xdata()
    assert np.nanmax(np.abs(np.diff(curve_x))) < 0.1
    assert not overlapping(figure)


def test_a_velocity_without_stored_impacts_has_breaks_in_place_of_slopes():
    dataset = motion()
    names = [name for name in dataset if str(name).startswith("impact_")]
    bare = dataset.drop_vars(names)
    _, values = curve(bare, "velocity")
    assert np.isnan(values).sum() == dataset.sizes["impact"]
    pieces = np.split(values, np.flatnonzero(np.isnan(values)))
    assert all(np.nanmax(np.abs(np.diff(piece[1:])), initial=0.0) < 0.2 for piece in pieces)
    tau = np.linspace(0, 6, 400)
    assert certain_jumps(tau, np.sin(tau), 1.0).size == 0


def test_a_section_shows_the_states_once_per_period():
    tau = 2 * np.pi * np.arange(0, 20, 0.25)
    dataset = motion().drop_dims("tau").assign_coords(tau=tau)
    dataset = dataset.assign(displacement=("tau", 0.1 * np.cos(tau)), velocity=("tau", np.sin(tau)))
    assert np.array_equal(visits(dataset), np.arange(0, 80, 4))
    figure = draw_section(dataset)
    assert np.allclose(figure.axes[0].lines[0].get_xdata(), 0.1)
    assert "once per forcing period" in words(figure)
    assert not overlapping(figure)


def test_points_of_a_diagram_are_all_impacts_of_every_row():
    dataset = ragged(sweep())
    first, second, section = panels_of(dataset)
    one, two = points_of(dataset, first), points_of(dataset, second)
    assert one.row.size + two.row.size == dataset.sizes["impact"]
    assert (one.value > 0).all()
    assert np.array_equal(np.floor(one.value).astype(int) - 1, one.row)
    aperiodic = np.flatnonzero(dataset["regime"].values == Regime.APERIODIC)
    assert (np.bincount(one.row)[aperiodic] == 64).all()
    assert points_of(dataset, section).row.size == dataset["regime"].size * 64


def test_a_bifurcation_diagram_is_drawn_over_the_parameter():
    dataset = ragged(sweep(delta=[0.0, 0.1]))
    figure = draw_bifurcation(dataset)
    assert "velocity before impact" in words(figure).replace("\n", " ")
    assert not overlapping(figure)
    panel = figure.axes[0]
    row = points_of(dataset, panels_of(dataset)[0]).row
    # The first column is delta = 0, every second row of the grid.
    assert panel.lines[0].get_xdata().size == int((row % 2 == 0).sum())
    assert panel.lines[0].get_rasterized() == (4 * (row % 2 == 0).sum() > MAX_VECTOR)


def test_the_caption_of_a_diagram_names_the_panels_that_a_page_has_no_room_for():
    dataset = ragged(sweep(31, delta=np.linspace(0.0, 0.1, 5)))
    figure = draw_bifurcation(dataset)
    drawn = words(figure).replace("\n", " ")
    assert "displacement at the section" not in drawn
    text = describe_bifurcation(dataset)
    assert "the velocity of each impact" in text
    assert "once per forcing period" not in text
    left_out = "velocity before impact, support 2 and displacement at the section"
    said = f"a page with a column for each δ has no room: {left_out}."
    assert f"Not drawn, since {said}" in text
    few = ragged(sweep(31, delta=[0.0, 0.1]))
    assert "Not drawn" not in describe_bifurcation(few)
    assert "once per forcing period" in describe_bifurcation(few)


def test_labels_below_columns_do_not_overlap():
    dataset = ragged(sweep(31, delta=np.linspace(0.0, 0.1, 5)))
    dataset["nu"].attrs |= {"long_name": "angular frequency of excitation", "units": "rad s-1"}
    figures = draw_bifurcation(dataset), draw_sweep(dataset.expand_dims(l=[0.5, 0.6]))
    for figure in figures:
        assert "rad/s" in words(figure)
        assert not overlapping(figure)


def test_the_caption_counts_columns_of_both_directions():
    dataset = sweep(31, delta=np.linspace(0.0, 0.1, 7))
    both = xr.concat([dataset, dataset], "direction").assign_coords(direction=["up", "down"])
    text = describe_bifurcation(ragged(both))
    assert "Of 14 combinations of δ and direction, 12 evenly spaced ones are drawn" in text


@pytest.mark.parametrize("name", ["curves", "quantities"])
def test_points_of_a_diagram_leave_curves_and_maps_to_their_own_quantities(name):
    dataset = ragged(sweep(delta=[0.0, 0.1]))
    picture = next(picture for picture in PICTURES if picture.name == name)
    plain, shown = (SweepFigure(show=show) for show in ([], ["poincare_displacement"]))
    drawn = [words(picture.draw(dataset, options, {})) for options in (plain, shown)]
    assert drawn[0] == drawn[1]
    assert picture.describe(dataset, plain, {}) == picture.describe(dataset, shown, {})


def test_a_diagram_does_not_depend_on_the_order_of_the_grid():
    dataset = ragged(sweep())
    points = []
    for given in (dataset, dataset.assign_coords(nu=dataset["nu"].values[::-1])):
        line = draw_bifurcation(given).axes[0].lines[0]
        points.append(dict(zip(line.get_ydata(), line.get_xdata(), strict=True)))
    nu = dataset["nu"].values
    for value, x in points[0].items():
        assert points[1][value] == pytest.approx(nu[0] + nu[-1] - x)


def test_no_point_of_a_diagram_is_cut_off_in_either_direction():
    dataset = sweep()
    both = ragged(
        xr.concat([dataset, dataset], "direction").assign_coords(direction=["up", "down"])
    )
    figure = draw_bifurcation(both)
    assert "followed downwards" in words(figure)
    drawn = [(ax, line) for ax in figure.axes for line in ax.lines]
    assert len(drawn) == 6
    for ax, line in drawn:
        low, high = ax.get_ylim()
        assert low <= line.get_ydata().min() <= line.get_ydata().max() <= high


def test_impacts_of_one_row_stand_on_its_orbit():
    dataset = ragged(sweep())
    row = row_at(dataset, 7)
    impacts = orbit_impacts(row)
    assert np.array_equal(impacts.support, [1, 2])
    assert np.allclose(impacts.time * max(1, int(row["period_multiple"])), [0.25, 0.75])
    assert np.allclose(impacts.after, -0.7 * impacts.before)


def test_a_spectrum_has_subharmonics_between_the_harmonics():
    row = xr.Dataset(
        {
            "displacement_amplitude": ("harmonic", [0.3, 0.02]),
            "subharmonic_displacement_amplitude": ("subharmonic", [0.1, np.nan, 0.05, np.nan]),
            "period_multiple": 2,
        },
        {"harmonic": [1, 2], "subharmonic": [1, 2, 3, 4]},
    )
    harmonics, between = lines_of(row, "displacement")
    assert np.array_equal(harmonics[0], [1, 2])
    assert np.array_equal(between[0], [0.5, 1.5])
    assert np.array_equal(between[1], [0.1, 0.05])


@pytest.mark.parametrize("name", ["nu", "omega"])
@pytest.mark.parametrize("value", [0.1, np.nan])
def test_the_legend_of_a_spectrum_names_the_frequency_and_what_is_drawn(name, value):
    row = xr.Dataset(
        {
            "displacement_amplitude": ("harmonic", [0.3]),
            "subharmonic_displacement_amplitude": ("subharmonic", [value]),
        },
        {"harmonic": [1], "subharmonic": [1], name: 1.0},
    )
    shown = [handle.get_label() for handle in spectrum_handles(row)]
    formula = rf"$\{name}$"
    assert shown[0] == f"harmonics, multiples of {formula}"
    assert len(shown) == (2 if value > 0 else 1)
    assert all(rf"\{name}" in text for text in shown)


def test_labels_of_small_diagrams_stay_in_the_figure():
    over = {"nu": np.linspace(0.8, 1.2, 13), "f": np.linspace(0.1, 0.9, 12)}
    rows = vp.sweep(vp.Exciter(l=0.5, nu=1.0, h=0.2, R1=0.7, R2=0.6), over)
    figure = draw_bifurcation(vp.to_physical(rows, 2.0, 8000.0))
    figure.draw_without_rendering()
    labels = [ax.yaxis.label for ax in figure.axes if ax.get_ylabel()]
    assert labels
    for label, ax in zip(labels, (ax for ax in figure.axes if ax.get_ylabel()), strict=True):
        assert "support 1" in label.get_text().replace("\n", " ")
        assert label.get_window_extent().x0 >= 0.0
        assert label.get_window_extent().height <= 1.1 * ax.get_window_extent().height


def test_every_mark_of_a_spectrum_lies_within_its_axes():
    row = xr.Dataset(
        {
            "displacement_amplitude": ("harmonic", [0.03, 0.02]),
            "subharmonic_displacement_amplitude": (
                "subharmonic",
                [0.3, np.nan, 0.05, np.nan, 0.01],
            ),
            "period_multiple": 2,
        },
        {"harmonic": [1, 2], "subharmonic": [1, 2, 3, 4, 5]},
    )
    ax = Figure().subplots()
    draw_spectrum(ax, row, "displacement")
    marks = np.concatenate([line.get_xydata() for line in ax.lines])
    assert marks[:, 1].max() <= 0.5 * ax.get_ylim()[1]
    assert marks[:, 0].max() < ax.get_xlim()[1]
    assert 0.5 in marks[:, 0]


def test_a_spectrum_of_less_than_two_decades_has_plain_ticks():
    dataset = steady(0.01)
    dataset["displacement_amplitude"].values[:] = np.linspace(0.3, 0.05, dataset.sizes["harmonic"])
    ax = draw_spectra(dataset).axes[0]
    low, high = ax.get_ylim()
    ticks = ax.yaxis.get_majorticklocs()
    seen = ax.yaxis.get_major_formatter().format_ticks(ticks[(ticks >= low) & (ticks <= high)])
    assert seen == ["0.02", "0.05", "0.1", "0.2", "0.5"]
    assert not any(ax.yaxis.get_minor_formatter().format_ticks([0.03, 0.3]))


def test_points_that_an_orbit_comes_back_to_are_as_large_as_one():
    ax = axes(new_canvas(5), 1, 1, 8, 3)
    few, rng = np.linspace(0.0, 1.0, 50), np.random.default_rng(1)
    draw_points(ax, few, few**2)
    draw_points(ax, np.tile(few, 200), np.tile(few, 200) ** 2 + 1e-9 * rng.random(10_000))
    draw_points(ax, rng.random(10_000), rng.random(10_000))
    alone, again, chaos = (line.get_markersize() for line in ax.lines)
    assert again == alone
    assert chaos == 1.3


def test_energies_and_spectra_of_a_motion_are_drawn():
    dataset = steady(0.01).assign(
        orbit_energy_input=0.628,
        orbit_energy_damping=0.223,
        orbit_energy_impact=("support", [0.232, 0.173]),
        orbit_energy_residual=1e-16,
    )
    in_joules = dataset["orbit_energy_residual"].assign_attrs(units="J")
    told = describe_energy(dataset.assign(orbit_energy_residual=in_joules))
    assert "per forcing period of the steady state: 1 × 10⁻¹⁶ J." in told
    values = [value for _, _, value in energy_terms(dataset, "orbit_energy")]
    assert sum(values) == pytest.approx(0.0, abs=1e-12)
    rubbing = dataset.assign(orbit_energy_friction=0.1, orbit_energy_damping=0.123)
    bars = [(text, value) for text, _, value in energy_terms(rubbing, "orbit_energy")]
    assert bars[-1] == ("friction", -0.1)
    soft = energy_terms(dataset.assign(orbit_energy_friction=0.0), "orbit_energy")
    assert "friction" not in [text for text, _, _ in soft]
    assert sum(value for _, value in bars) == pytest.approx(0.0, abs=1e-12)
    both = rubbing.assign(
        {f"energy_{name}": 4.02e-7 for name in ("input", "damping", "change", "friction")}
    )
    both["energy_impact"] = ("support", [0.232, 0.173])
    whole = draw_energy(both)
    assert "4.02 × 10⁻⁷" in [text.get_text() for text in texts(whole)]
    for figure in (draw_energy(dataset), draw_energy(rubbing), whole, draw_spectra(dataset)):
        assert not overlapping(figure)


def test_a_png_is_fine_enough_for_print_in_any_context(tmp_path):
    figure = draw_phase_portrait(motion())
    with style.context("default"):
        save_as(figure, tmp_path / "motion.png")
    head = (tmp_path / "motion.png").read_bytes()
    assert int.from_bytes(head[16:20], "big") == pytest.approx(16 / 2.54 * 300, abs=1)


def test_a_soft_support_is_entered_without_a_jump():
    exciter = vp.Exciter(l=0.5, nu=1.0, f=0.5, h=0.2, k1=40.0, h1=1.0, R2=0.7)
    impacts = orbit_impacts(vp.steady_state(exciter, outputs=["impacts"]))
    is_soft = impacts.support == 1
    assert 0 < is_soft.sum() < is_soft.size
    assert np.array_equal(impacts.after[is_soft], impacts.before[is_soft])
    assert np.array_equal(impacts.after[~is_soft], -0.7 * impacts.before[~is_soft])
