"""Findings of backbones in sentences with numbers from the data."""

from __future__ import annotations

import numpy as np
import pytest
from figures.sample_datasets import amplitude_frequency, backbone

import vibropipe as vp
from vibropipe.scenes.backbone.curves import longest_period
from vibropipe.scenes.backbone.report import answers


def test_findings_of_a_backbone_over_the_period():
    (answer,) = answers({"law": backbone()})["law"]
    # (1 - d) + (1 + d) cos(period / 2) is positive up to period = 2 arccos(-(1 - d) / (1 + d))
    low, high = (2 * np.arccos(-(1 - d) / (1 + d)) for d in (0.3, 0.0))
    assert answer.lead == "Free motions strike both supports up to a longest period."
    assert answer.rest.startswith(f"It falls from τ̄ = {high:.4g} to {low:.4g} with the offset ")


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


def test_findings_of_a_backbone_over_amplitude():
    first, second = answers({"free": amplitude_frequency(0.01)})["free"]
    assert first.lead == "Free motions strike one support before both."
    assert first.rest == "One from amplitude 0.49 on, both from 0.51."
    assert second.lead == "The frequency of the free motion reaches 3 here."
    assert second.rest == "That is at the largest amplitude."
    (both, _) = answers({"free": amplitude_frequency(0.0)})["free"]
    assert both.lead == "Free motions strike both supports from amplitude 0.5 on."
