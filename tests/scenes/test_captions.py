"""Captions of every kind of scene follow from the data, in plain text."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from drawing import caption, picture_of
from figures.figure_text import words
from figures.sample_datasets import motion, sweep

from vibropipe.figures.style import house_style
from vibropipe.figures.text import format_number
from vibropipe.scenes.motion.captions import describe_impacts, describe_motion
from vibropipe.scenes.motion.findings import findings
from vibropipe.scenes.motion.impacts import draw_impacts_only
from vibropipe.scenes.sweep.captions import describe_sweep, location_text
from vibropipe.words.regimes import Regime
from vibropipe.words.vocabulary import REGIMES


def test_motion_counts_impacts_and_names_grazing(made):
    dataset = made["conservative"][1]
    text = describe_motion(dataset)
    for support in (1, 2):
        at = dataset["impact_support"].values == support
        hardest = np.abs(dataset["impact_velocity"].values[at]).max()
        impacts = f"{at.sum()} impacts on support {support}"
        assert f"{impacts} (largest velocity {format_number(hardest)})" in text
    assert "Support 1 is grazed (contact at zero velocity) twice, first at τ = 4.71" in text
    assert text.startswith("Displacement and velocity")


def test_a_motion_that_stays_on_a_soft_support_strikes_nothing():
    held = motion().isel(impact=slice(0, 1))
    held["impact_velocity"] = 0.0 * held["impact_velocity"]
    held["impact_support"][:] = 1
    assert "1 contact with support 1, without velocity" in describe_motion(held)
    (finding,) = findings({"held": held})
    assert "No support is struck with a velocity." in finding.texts


def test_motion_says_how_far_it_departs_from_the_exact_one(made):
    text = describe_motion(made["forced"][1])
    assert "the displacement computed by newmark differs from it by at most 0.001" in text
    assert "rests on a support once, for up to 2.5" in text


@pytest.mark.parametrize("is_sampled", [True, False])
def test_a_motion_without_impacts_says_that_nothing_is_struck(is_sampled):
    dataset = motion(f=-0.1)
    assert dataset.sizes["impact"] == 0
    dataset = dataset if is_sampled else dataset.drop_dims("tau")
    with house_style():
        figure = draw_impacts_only(dataset)
    for text in (words(figure), describe_impacts(dataset)):
        assert "No support is struck" in text
        assert ("are not stored" in text) is not is_sampled


def test_free_response_names_its_parts(made):
    kind, dataset = made["free_1"]
    text = picture_of(kind, dataset).describe(dataset, None, {})
    assert "Below A = 0.49 no support is reached" in text
    assert "then only support 2 is struck up to A = 0.51" in text
    assert "then both supports are struck and the frequency rises" in text
    _, symmetric = made["free_0"]
    text = picture_of(kind, symmetric).describe(symmetric, None, {})
    assert "the constant part and the even harmonics vanish" in text


def test_sweep_counts_what_is_no_plain_orbit(made):
    dataset = made["lines"][1]
    text = describe_sweep(dataset)
    none = int((dataset["regime"] >= REGIMES["aperiodic"]).sum())
    assert f"Of {dataset['regime'].size} rows, " in text
    assert f"{none} have no periodic orbit" in text
    assert "ν for f = 0.1, 0.2, 0.5" in text


def test_map_says_shares_and_where_impacts_are_hardest(made):
    kind, dataset = made["map"]
    text = picture_of(kind, dataset).describe(dataset, None, {})
    two_sided = float((dataset["regime"] == REGIMES["two_sided"]).mean())
    assert f"{format_number(100 * two_sided, 3)} % two-sided" in text
    top = dataset["impact_velocity_max"].sel(support=2).where(dataset["regime"] < Regime.APERIODIC)
    assert f"on support 2 of the orbits is {format_number(float(top.max()))}, at ν = " in text
    assert (
        "Lower panels: largest impact velocity on each support; its maximum on support 1 " in text
    )


def test_place_of_the_largest_value():
    values = xr.DataArray(
        [[1.0, np.nan], [5.0, 2.0]], dims=("nu", "f"), coords={"nu": [0.5, 2.0], "f": [1.0, 3.0]}
    )
    assert location_text(values) == "ν = 2, f = 1"


def test_every_scene_has_a_caption(study, made):
    others = {name: dataset for name, (_, dataset) in made.items()}
    for name, (_, dataset) in made.items():
        text = caption(study.scenes[name], dataset, others)
        assert text.endswith(".")
        assert "nan" not in text
        assert "$" not in text
    assert "conservative exciter" in caption(study.scenes["lines"], others["lines"], others)


def test_captions_name_the_panels_that_a_page_has_no_room_for():
    dataset = sweep(31, f=[0.1, 0.2], delta=np.linspace(0.0, 0.1, 5))
    text = describe_sweep(dataset)
    assert "Not drawn, since a page with a column for each" in text
    assert "(support 2)" in text
    assert "Not drawn" not in describe_sweep(dataset, ["displacement_mean"])
    assert "Not drawn" not in describe_sweep(sweep(31))


def test_captions_name_what_is_shown(made):
    motion = made["forced"][1]
    assert describe_motion(motion).startswith("Force, displacement and velocity over τ")
    assert describe_motion(motion, ["velocity"]).startswith("Velocity over τ")
    assert "not stored" not in describe_impacts(motion)
    assert "not stored" in describe_impacts(made["impacts"][1])
    lines = made["lines"][1]
    assert "first harmonic" in describe_sweep(lines)
    assert "first harmonic" not in describe_sweep(lines, ["impact_velocity_max"])
