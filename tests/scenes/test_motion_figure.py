"""Pictures of motions: what is drawn where."""

import numpy as np
import pytest
from drawing import draw
from figures.figure_text import words

import vibropipe as vp
from vibropipe.figures.palette import SUPPORT_COLOURS
from vibropipe.figures.text import value_text
from vibropipe.scenes.motion.curves import curve, jumps
from vibropipe.scenes.motion.keys import MotionFigure
from vibropipe.scenes.motion.pictures import head_lines
from vibropipe.words.vocabulary import quantity


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
    assert [head_lines("one", each, (one, other), 2.6) for each in (one, other)] == [
        ["one", value_text(each["f"]), value_text(each["R2"])] for each in (one, other)
    ]
    third = other.assign_coords(R1=0.2)
    _, _, supports = head_lines("third", third, (one, third), 2.6)
    assert supports == f"{value_text(third['R1'])}, {value_text(third['R2'])}"


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
