"""Findings of backbones in sentences with numbers from the data."""

import numpy as np
import pytest
import xarray as xr
from figures.sample_datasets import amplitude_frequency, backbone

import vibropipe as vp
from vibropipe.scenes.backbone.curves import draw_amplitude_frequency, draw_backbone, longest_period
from vibropipe.scenes.backbone.overlay import FAMILIES, draw_overlay, jumps_of, lines_of
from vibropipe.scenes.backbone.pictures import (
    amplitude_title,
    describe_backbone,
    describe_characteristics,
    free_and_forced,
)
from vibropipe.scenes.backbone.report import answers
from vibropipe.scenes.backbone.solve import simulated_points


def test_findings_of_a_backbone_over_the_period():
    (answer,) = answers({"law": backbone()})["law"]
    # (1 - d) + (1 + d) cos(period / 2) is positive up to period = 2 arccos(-(1 - d) / (1 + d))
    low, high = (2 * np.arccos(-(1 - d) / (1 + d)) for d in (0.3, 0.0))
    assert answer.lead == "Free motions strike both supports up to a longest period."
    assert answer.rest.startswith(f"It falls from τ̄ = {high:.4g} to {low:.4g} as ")


@pytest.mark.parametrize("delta_over_l", [0.0, 0.1, -0.3, 0.8])
def test_below_the_longest_period_alone_both_supports_are_struck(delta_over_l: float):
    limit = longest_period(backbone(), delta_over_l)
    row = vp.backbone([delta_over_l], limit * np.array([0.3, 1 - 1e-6, 1 + 1e-6, 1.1, 1.4]))
    assert np.isfinite(row["velocity_over_l"].values).tolist() == [
        [True, True, False, False, False]
    ]
    # the mirrored motion has the velocities of both supports exchanged: those squared differ by 4 delta/l
    mirrored = vp.backbone([-delta_over_l], row["tau_bar"].values)["velocity_over_l"]
    difference = mirrored**2 - row["velocity_over_l"].values ** 2
    np.testing.assert_allclose(difference[0, :2], 4 * delta_over_l, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("points", [0, 3])
def test_one_period_is_marked_and_only_motions_that_were_simulated(points: int):
    one = simulated_points(vp.backbone([0.0], [1.0]), points)
    lines = draw_backbone(one).axes[0].lines
    marked = [line for line in lines if line.get_marker() not in ("None", "")]
    assert marked
    assert all(len(line.get_xdata()) for line in marked)
    assert ("Markers: simulated motions" in describe_backbone(one)) == (points > 0)


def test_one_amplitude_is_marked():
    free = vp.amplitude_frequency(vp.Exciter(l=0.5), [0.1])
    lines = draw_amplitude_frequency(free).axes[0].lines
    assert [line.get_marker() for line in lines] == ["."]


def test_findings_of_a_backbone_over_amplitude():
    (first,) = answers({"free": amplitude_frequency(0.01)})["free"]
    assert first.lead == "Free motions strike one support before both."
    assert first.rest == "One from amplitude 0.49 on, both from 0.51."
    faster = "With impacts the free motion is up to 3 times as fast as without"
    assert amplitude_title(amplitude_frequency(0.01)) == faster
    (both,) = answers({"free": amplitude_frequency(0.0)})["free"]
    assert both.lead == "Free motions strike both supports from amplitude 0.5 on."


def test_of_free_motions_alone_the_harmonic_in_which_they_differ_is_large():
    free = [amplitude_frequency(0.0), amplitude_frequency(0.01)]
    figure = draw_overlay(free, [], "displacement")
    assert figure.axes[0].get_ylabel().startswith("second harmonic of the displacement")
    assert any(text.get_text().startswith("first harmonic") for text in figure.axes[2].texts)
    assert draw_overlay(free[:1], []).axes[0].get_ylabel().startswith("first harmonic")


def sweep_of(y: np.ndarray, impacts: np.ndarray) -> xr.Dataset:
    """Return a sweep over the frequency with a first harmonic and impacts on each support in each period."""
    one = ("nu", "support")
    columns = {
        "displacement_amplitude": (("nu", "harmonic"), y[:, None]),
        "period_multiple": ("nu", np.ones(y.size, int)),
        "impacts_per_orbit": (one, np.repeat(impacts[:, None], 2, axis=1)),
        "regime": ("nu", np.ones(y.size, int)),
    }
    return xr.Dataset(columns, {"nu": 1.0 + 0.1 * np.arange(y.size), "harmonic": [1]})


@pytest.mark.parametrize(
    ("y", "impacts", "jumps"),
    [
        # a square root, and back: steep, and no jump
        (np.sqrt([0, 0, 1, 2, 3, 4, 3, 2, 1, 0, 0]), np.ones(11), []),
        # of one law, far more than beside it
        ([1.0, 1.1, 1.2, 2.0, 2.1], np.ones(5), [2]),
        # another law: as steep as beside it
        ([0.0, 0.5, 1.0, 1.5, 2.0], np.array([0.0, 0, 1, 1, 1]), [1]),
        # another law, without a step that is seen
        ([1.0, 1.01, 1.02], np.array([0.0, 1, 1]), []),
        ([1.0, np.nan, 1.0, 2.0], np.ones(4), [2]),
    ],
)
def test_a_line_jumps_to_another_law_or_by_far_more_than_beside_it(y, impacts, jumps):
    (line,) = lines_of(sweep_of(np.array(y), impacts), "displacement", 1, FAMILIES[0])
    assert jumps_of(line, 0.05 * np.nanmax(y)).tolist() == jumps


def test_the_free_motion_of_the_least_offset_is_wide():
    free = {delta: amplitude_frequency(delta) for delta in (0.0, 0.01)}
    for first, other in ((0.0, 0.01), (0.01, 0.0)):
        found, _ = free_and_forced(free[first], [free[other]])
        assert [float(each["delta"]) for each in found] == [0.0, 0.01]
        text = describe_characteristics(free[first], (), [free[other]])
        assert "wide for l = 0.5 and δ = 0, thin for l = 0.5 and δ = 0.01" in text
