"""Captions of every kind of scene follow from the data, in plain text."""

import numpy as np
import pytest
from drawing import caption, picture_of
from figures.figure_text import words
from figures.sample_datasets import motion, sweep

import vibropipe as vp
from vibropipe.figures.text import digits
from vibropipe.scenes.backbone.pictures import describe_amplitude_frequency
from vibropipe.scenes.motion.captions import describe_impacts, describe_motion
from vibropipe.scenes.motion.findings import answers
from vibropipe.scenes.motion.impacts import draw_impacts_only
from vibropipe.scenes.sweep.captions import describe_sweep
from vibropipe.words.quantities import REGIMES
from vibropipe.words.regimes import Regime


def test_motion_counts_impacts_and_names_grazing(made):
    dataset = made["conservative"][1]
    text = describe_motion(dataset)
    for support in (1, 2):
        at = dataset["impact_support"].values == support
        assert f"{at.sum()} impacts on support {support}" in text
    assert "Support 1 is grazed (contact at zero velocity) twice, first at τ = 4.71" in text
    assert text.startswith("Displacement and velocity")


def test_the_marks_are_those_of_the_supports_that_are_struck(made):
    whole = made["conservative"][1]
    assert "velocity before an impact, up (orange) on support 1, down (blue) on" in describe_motion(
        whole
    )
    one = whole.isel(impact=whole["impact_support"].values == 2)
    assert "velocity before an impact, down (blue) on support 2; hatched" in describe_motion(one)
    assert "Triangles" not in describe_motion(whole.isel(impact=slice(0)))


def test_a_motion_that_stays_on_a_soft_support_strikes_nothing():
    held = motion().isel(impact=slice(0, 1))
    held["impact_velocity"] = 0.0 * held["impact_velocity"]
    held["impact_support"][:] = 1
    assert "1 contact with support 1, without velocity" in describe_motion(held)
    assert [answer.lead for answer in answers({"held": held})["held"]] == [
        "No support is struck with a velocity in the record."
    ]


def test_motion_says_how_far_it_departs_from_the_exact_one(made):
    text = describe_motion(made["forced"][1])
    assert "the displacement by Newmark's method differs from it by at most 0.001" in text
    assert "Impacts, with rests, on support 1" in text
    assert "rests on a support once, for up to 2.5" in text


@pytest.mark.parametrize("is_sampled", [True, False])
def test_a_motion_without_impacts_says_that_nothing_is_struck(is_sampled):
    dataset = motion(f=-0.1)
    assert dataset.sizes["impact"] == 0
    dataset = dataset if is_sampled else dataset.drop_dims("tau")
    figure = draw_impacts_only(dataset)
    for text in (words(figure), describe_impacts(dataset)):
        assert "No support is struck" in text
        assert ("are not stored" in text) is not is_sampled


def test_free_response_names_its_parts(made):
    kind, dataset = made["free_1"]
    text = picture_of(kind, dataset).describe(dataset, None, {})
    assert text.startswith(
        "Free motion against its frequency: displacement (left) and velocity (right)."
    )
    assert "Dashed: no support is struck. On grey: only support 2 is struck." in text
    alone = describe_amplitude_frequency(dataset, ["velocity_amplitude"])
    assert alone.startswith("Free motion against its frequency: velocity.")
    _, symmetric = made["free_0"]
    text = picture_of(kind, symmetric).describe(symmetric, None, {})
    assert "the mean displacement and the even harmonics vanish" in text
    assert "On grey" not in text


def test_sweep_counts_what_is_no_plain_orbit(made):
    dataset = made["lines"][1]
    text = describe_sweep(dataset)
    none = int((dataset["regime"] >= REGIMES["aperiodic"]).sum())
    assert f"Of {dataset['regime'].size} rows, " in text
    assert f"{none} have no periodic orbit" in text
    assert "ν for f = 0.1, 0.2, 0.5" in text


def test_captions_of_maps_name_what_has_no_label_and_the_largest_values(made):
    kind, dataset = made["map"]
    assert "Not labelled" not in picture_of(kind, dataset).describe(dataset, None, {})
    rare = dataset.copy(deep=True)
    rare["regime"] = rare["regime"].where(rare["regime"] != Regime.ONE_SIDED_1, Regime.NO_IMPACT)
    rare["regime"][30, 20] = Regime.ONE_SIDED_1
    text = picture_of(kind, rare).describe(rare, None, {})
    assert "Not labelled: only support 1 struck, under 0.1 %." in text
    assert "at 60 × 50 points of ν and f" in text
    text = picture_of(kind, dataset, "quantities").describe(dataset, None, {})
    assert (dataset["regime"] == Regime.APERIODIC).any()  # which is no maximum beside orbits
    orbits = dataset["regime"] < Regime.APERIODIC
    top = float(dataset["impact_velocity_max"].where(orbits).max())
    assert (
        f"Largest in size of each map, in orbits: {digits(top)} (largest velocity before impact"
        in text
    )


def test_every_scene_has_a_caption(study, made):
    others = {name: dataset for name, (_, dataset) in made.items()}
    for name, (_, dataset) in made.items():
        text = caption(study.scenes[name], dataset, others)
        assert text.endswith(".")
        assert "nan" not in text
        assert "$" not in text
    assert "free motion without losses" in caption(study.scenes["lines"], others["lines"], others)


def test_captions_name_the_panels_that_a_page_has_no_room_for():
    dataset = sweep(31, f=[0.1, 0.2], delta=np.linspace(0.0, 0.1, 5))
    text = describe_sweep(dataset)
    assert "Not drawn, since a page with a column for each" in text
    assert "mean displacement" in text
    assert "Not drawn" not in describe_sweep(dataset, ["displacement_mean"])
    assert "Not drawn" not in describe_sweep(sweep(31))
    columns = describe_sweep(sweep(31, f=[0.1, 0.2], delta=[0.0, 0.1, 0.2]))
    assert "has no room: third harmonic amplitude of displacement." in columns  # not the impacts


def test_a_caption_tells_supports_apart_that_share_a_panel():
    colours = "Orange: support 1; blue, dashed: support 2. "
    assert colours in describe_sweep(sweep(31))
    assert colours not in describe_sweep(sweep(31), ["displacement_mean"])
    assert colours not in describe_sweep(sweep(31, f=[0.1, 0.2]))  # either support


def test_captions_name_what_is_shown(made):
    motion = made["forced"][1]
    assert describe_motion(motion).startswith("Force, displacement and velocity over τ")
    assert describe_motion(motion, ["velocity"]).startswith("Velocity over τ")
    assert "not stored" not in describe_impacts(motion)
    assert "not stored" in describe_impacts(made["impacts"][1])


def test_rests_on_both_supports_are_told_together():
    dataset = vp.simulate(vp.Exciter(l=0.5, nu=0.3, f=1.5, h=0.1, R1=0.5, R2=0.5), 60.0)
    assert set(dataset["rest_support"].values) == {1, 2}
    assert "Impacts, with rests, on both supports." in describe_motion(dataset)
