"""Free motion of the conservative exciter over its amplitude: the velocity before impact."""

from __future__ import annotations

import numpy as np
import pytest

import vibropipe as vp

AMPLITUDES = [0.3, 0.5, 0.8, 1.2]


def test_the_impact_velocity_is_that_of_a_simulated_motion() -> None:
    exciter = vp.Exciter(l=0.5, delta=0.1)
    free = vp.amplitude_frequency(exciter, AMPLITUDES)
    for amplitude in AMPLITUDES:
        # x' = amplitude at x = 0
        motion = vp.simulate(exciter, tau_end=20.0, x0=0.0, v0=amplitude)
        for support in (1, 2):
            struck = np.abs(motion.impact_velocity.values[motion.impact_support.values == support])
            velocity = float(free.impact_velocity_max.sel(amplitude=amplitude, support=support))
            if struck.size:
                assert struck == pytest.approx(velocity, rel=1e-13)
            else:
                assert np.isnan(velocity)


def test_it_is_the_backbone_of_eq_10() -> None:
    exciter = vp.Exciter(l=0.5, delta=0.1)
    free = vp.amplitude_frequency(exciter, [0.8, 1.2])
    periods = 2 * np.pi / free.eigenfrequency.values
    backbone = vp.backbone([0.2], np.sort(periods)).sortby("tau_bar", ascending=False)
    velocities = free.impact_velocity_max.sel(support=1).values
    assert backbone.velocity_over_l.values[0] * 0.5 == pytest.approx(velocities, rel=1e-12)
