"""Pictures of motions with units: times that are shown in milliseconds."""

import math
import re

import numpy as np
import pytest
import xarray as xr
from figures.sample_datasets import motion

import vibropipe as vp
from vibropipe.figures.units import display_units
from vibropipe.scenes.motion.balance import draw_energy
from vibropipe.scenes.motion.captions import describe_impacts, describe_motion, rest_text
from vibropipe.scenes.motion.impacts import draw_impacts_only
from vibropipe.scenes.motion.panels import window
from vibropipe.scenes.motion.phase_plane import describe_section, turns, visits

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


def test_the_departure_from_the_exact_motion_has_its_unit():
    physical = vp.to_physical(motion(exact=True), M, C)
    physical.attrs["display_units"] = "length: mm"
    exact = display_units({"motion": physical})["motion"]
    assert re.search(
        r"Newmark's method differs from it by at most [\d.]+ mm\.", describe_motion(exact)
    )
