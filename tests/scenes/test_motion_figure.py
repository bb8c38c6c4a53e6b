"""Pictures of motions: what is drawn where, contacts and times that are shown in milliseconds."""

import math
import re
from itertools import combinations

import numpy as np
import pytest
import xarray as xr
from drawing import draw
from figures.figure_text import words
from figures.sample_datasets import motion

import vibropipe as vp
from vibropipe.figures.palette import SUPPORT_COLOURS
from vibropipe.figures.text import value_text
from vibropipe.figures.units import display_units
from vibropipe.scenes.motion.balance import describe_spectra, draw_energy, energy_terms
from vibropipe.scenes.motion.captions import describe_impacts, describe_motion, rest_text
from vibropipe.scenes.motion.curves import curve, jumps
from vibropipe.scenes.motion.impacts import draw_impacts_only
from vibropipe.scenes.motion.keys import MotionFigure
from vibropipe.scenes.motion.panels import window
from vibropipe.scenes.motion.phase_plane import describe_section, turns, visits
from vibropipe.scenes.motion.pictures import draw_together, head_lines
from vibropipe.scenes.motion.solve import solve
from vibropipe.study import parse_study, study_of_text
from vibropipe.words.vocabulary import ENERGIES, quantity

M, C = 1.0, 1e4  # 40 units of tau are then 0.4 s


@pytest.fixture(scope="module")
def shown() -> xr.Dataset:
    """Return a motion with units, as it is drawn."""
    return display_units({"motion": vp.to_physical(motion(), M, C)})["motion"]


def test_impacts_of_a_motion_without_samples_are_drawn_over_its_time(shown):
    bare = shown.drop_dims("time")
    figure = draw_impacts_only(bare)
    assert figure.axes[0].get_xlabel() == "time $t$ (ms)"
    assert describe_impacts(bare).startswith("Velocity before each impact against t;")


def test_forcing_periods_are_counted_in_the_unit_that_is_shown(shown):
    assert shown["time"].attrs["units"] == "ms"
    exact = motion()
    assert turns(shown, shown["impact_time"].values) == pytest.approx(
        turns(exact, exact["impact_tau"].values), rel=1e-12
    )
    first, last = window(shown, 2)
    assert last - first == pytest.approx(1e3 * 4 * math.pi / math.sqrt(C / M))


def test_a_section_in_milliseconds_has_one_state_for_each_period():
    at = 2 * math.pi * np.arange(0, 6.01, 0.25)
    sampled = motion().isel(tau=slice(at.size)).assign_coords(tau=("tau", at))
    shown = display_units({"motion": vp.to_physical(sampled, M, C)})["motion"]
    assert np.array_equal(visits(shown), np.arange(0, 25, 4))
    assert describe_section(shown).startswith("a: 7 states")


def test_the_caption_has_the_span_that_is_drawn(shown):
    text = describe_motion(shown, periods=2)
    assert " over t = 274.3 … 400 ms, the end of a record from 0 ms. In the whole record: " in text
    assert " over t = 0 … 400 ms. " in describe_motion(shown)


def test_the_length_of_a_rest_has_its_unit():
    shown = display_units({"motion": vp.to_physical(motion(rest=True), M, C)})["motion"]
    assert rest_text(shown, is_shaded=False) == "The mass rests on a support once, for up to 25 ms"
    # the record ends in a rest, not the rests before it
    held = vp.simulate(vp.Exciter(l=0.5, h=0.05, R1=0.3, R2=0.2, f=1.0, nu=0.2), 40.0)
    told = "The mass rests on a support 3 times, for up to 8.531 and at last until the end of the record"
    assert rest_text(held, is_shaded=False) == told
    always = vp.simulate(vp.Exciter(l=0.5, delta=0.6, R1=0.3, R2=0.2, nu=0.2), 40.0)
    told = "The mass rests on a support once, until the end of the record"
    assert rest_text(always, is_shaded=False) == told


def test_the_unit_of_energies_stands_in_brackets():
    exciter = vp.Exciter(l=0.5, nu=1.0, f=-1.0, h=0.2, R1=0.7, R2=0.7)
    energies = vp.to_physical(vp.simulate(exciter, 20.0, energy=True), M, C)
    figure = draw_energy(display_units({"motion": energies})["motion"])
    assert figure.axes[0].get_ylabel() == "energy (J)"


def test_rounding_of_energies_and_harmonics_is_zero():
    """A free motion without losses keeps its energy and is symmetric; a mass that friction holds has no harmonics."""
    text = """
title: Without losses
exciter: {l: 0.5}
scenes:
  free: {kind: motion, start: {v0: 1}, tau_end: 40, outputs: [motion, impacts, energy, harmonics]}
  held:
    kind: motion
    exciter: {nu: 1.3, f: 0.5, h: 0.1, friction: 0.7}
    start: {x0: 0.1}
    outputs: [motion, energy, harmonics]
"""
    scenes = study_of_text(text, "mine").scenes
    free, held = solve(scenes["free"]), solve(scenes["held"])
    assert 0.0 < abs(free.energy_change) < 1e-15
    assert [value for _, _, value in energy_terms(free, "energy")] == [0.0] * 5
    assert 0.0 < abs(free.displacement_mean) < 1e-15
    told = describe_spectra(free)
    assert "The mean displacement is 0; the largest harmonic is number 1, 0.4135." in told
    assert "The mean displacement is 0.1; all harmonics are 0." in describe_spectra(held)


def test_names_below_bars_have_two_lines():
    losses = {name: (("support",), [0.1, 0.1]) if "impact" in name else 0.1 for name in ENERGIES}
    terms = energy_terms(xr.Dataset(losses, {"support": [1, 2]}), "energy")
    assert "loss on\nthe ground" in [text for text, _, _ in terms]
    assert max(text.count("\n") for text, _, _ in terms) == 1


def test_the_departure_from_the_exact_motion_has_its_unit():
    physical = vp.to_physical(motion(exact=True), M, C)
    physical.attrs["display_units"] = "length: mm"
    exact = display_units({"motion": physical})["motion"]
    assert re.search(
        r"Newmark's method differs from it by at most [\d.]+ mm\.", describe_motion(exact)
    )


# With losses by restitution all effects are called for, whose kernels other tests need as well.
SOFT = {"nu": 0.8, "f": 0.9, "l": 0.5, "h": 0.1, "k1": 20, "k2": 20, "h1": 0.2, "h2": 0.2}
MOTION = {"kind": "motion", "outputs": ["motion", "impacts", "harmonics"]}
STUDY = {"title": "Soft", "exciter": {**SOFT, "friction": 0.05}, "scenes": {"motion": MOTION}}
OF_EACH = ("impact_velocity_after", "contact_duration", "contact_force_max", "contact_depth_max")


def test_the_contacts_of_the_motion_and_those_of_its_orbit():
    scene = parse_study(STUDY).scenes["motion"]
    dataset = solve(scene)
    row = vp.steady_state(vp.Exciter(**scene.resolved_exciter()), outputs=("impacts",))
    for name in OF_EACH:
        assert dataset[name].dims == ("impact",)
        assert dataset[f"orbit_{name}"].dims == ("orbit_impact",)
        np.testing.assert_array_equal(dataset[f"orbit_{name}"].values, row[name].values)
    np.testing.assert_array_equal(dataset.support_force_max.values, row.support_force_max.values)
    assert dataset.sizes["impact"] > dataset.sizes["orbit_impact"]


def test_an_unforced_motion_has_no_force_panel(figures):
    assert len(figures["forced"].axes) == 4
    assert len(figures["conservative"].axes) == 3
    assert quantity("force").symbol not in words(figures["conservative"])


def test_grazing_is_named_and_its_own_mark(figures, made):
    dataset = made["conservative"][1]
    assert "grazing" in words(figures["conservative"])
    assert "ring: grazing" not in words(figures["conservative"])
    assert "grazing" not in words(figures["forced"])
    upper = figures["conservative"].axes[0]
    rings = [line for line in upper.lines if line.get_markerfacecolor() == "none"]
    assert np.array_equal(rings[0].get_xdata(), dataset["grazing_tau"].values)


def test_heads_of_columns_have_every_parameter_that_differs_and_both_supports_in_a_line(made):
    one = made["forced"][1].drop_vars("displacement_mean", errors="ignore")
    other = one.assign_coords(f=float(one["f"]) - 1.0, R2=0.35)
    assert [head_lines(each, (one, other), 2.6) for each in (one, other)] == [
        [value_text(each["f"]), value_text(each["R2"])] for each in (one, other)
    ]
    third = other.assign_coords(R1=0.2)
    _, supports = head_lines(third, (one, third), 2.6)
    assert supports == f"{value_text(third['R1'])}, {value_text(third['R2'])}"


@pytest.mark.parametrize("n", [2, 6])
def test_long_names_above_columns_do_not_overlap(made, n):
    names = ["a motion whose name takes up as many letters as a name may take", *"bcdef"][:n]
    figure = draw_together([made["forced"][1]] * n, [names[0], *[names[0]] * (n - 1)])
    figure.draw_without_rendering()
    boxes = [text.get_window_extent() for text in figure.texts if text.get_weight() == "bold"]
    assert len({box.y0 for box in boxes}) > 1
    assert not any(one.overlaps(two) for one, two in combinations(boxes, 2))
    assert max(box.x1 for box in boxes) <= figure.bbox.width


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
    figure = draw("motion", dataset, MotionFigure(periods=2))
    low, high = figure.axes[0].get_xlim()
    assert high == pytest.approx(float(dataset["tau"][-1]))
    assert high - low == pytest.approx(4 * np.pi)


def test_rests_are_shaded_up_to_the_end_if_never_released(made):
    dataset = made["forced"][1].assign(rest_end=("rest", np.array([np.inf])))
    figure = draw("motion", dataset)
    assert figure.axes[1].get_xlim()[1] == pytest.approx(float(dataset["tau"][-1]))
    assert "rest on a support" in words(figure)


def test_a_soft_support_is_entered_without_a_jump_of_the_velocity() -> None:
    exciter = vp.Exciter(l=0.5, nu=1.0, f=-1.0, h=0.2, R2=0.7, k1=100.0, h1=1.0)
    motion = vp.simulate(exciter, 20.0, samples_per_period=512)
    is_soft = motion["impact_support"].values == 1
    _tau, velocity = curve(motion, "velocity")
    at = np.flatnonzero(np.isnan(velocity))
    steps = np.abs(velocity[at + 1] - velocity[at - 1])
    assert is_soft.any()
    assert (steps[is_soft] == 0.0).all()
    assert (steps[~is_soft] > 0.1).all()


@pytest.mark.parametrize("kind", ["motion", "ramp"])
def test_the_name_of_a_soft_support_is_off_the_motion(kind) -> None:
    exciter = vp.Exciter(l=0.5, nu=1.0, f=-1.0, h=0.2, k1=30.0, k2=20.0, h1=1.0, h2=2.0, delta=0.05)
    keys = {"nu_end": 1.6} if kind == "ramp" else {}
    motion = vp.simulate(exciter, 60.0, **keys)
    figure = vp.plot(motion)
    panels = [(ax, text) for ax in figure.axes for text in ax.texts if "support" in text.get_text()]
    assert len(panels) == 2
    for ax, text in panels:
        box = text.get_window_extent()
        curves = [line for line in ax.lines if line.get_linestyle() == "-"]
        assert curves
        for line in curves:
            at = np.linspace(ax.get_xlim()[0], ax.get_xlim()[1], 20_000)
            heights = np.interp(at, *np.transpose(sorted(zip(*line.get_data(), strict=True))))
            x, y = ax.transData.transform(np.column_stack([at, heights])).T
            assert not ((x > box.x0) & (x < box.x1) & (y > box.y0) & (y < box.y1)).any()
