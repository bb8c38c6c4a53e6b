"""Captions of a backbone in the units of its dataset."""

from __future__ import annotations

import numpy as np
import pytest

import vibropipe as vp
from vibropipe.scenes.backbone.captions import describe_amplitude_frequency, describe_backbone

M, C = 2.0, 8000.0
P = np.sqrt(C / M)


@pytest.fixture(scope="module")
def over_amplitude():
    exciter = vp.Exciter.from_physical(m=M, C=C, H=0, F=0, omega=1, l="8 mm", delta="1 mm")
    grid = np.linspace(0.001, 0.02, 20)
    return vp.amplitude_frequency(exciter, amplitude=grid)


@pytest.fixture(scope="module")
def curves():
    return vp.backbone([0.0, 0.2], np.linspace(2.0, 7.0, 40))


def test_captions_have_units(over_amplitude, curves) -> None:
    plain = describe_amplitude_frequency(over_amplitude)
    assert "Up to A = 0.007 no support is reached and the frequency is 1," in plain
    text = describe_amplitude_frequency(vp.to_physical(over_amplitude, M, C))
    assert "Up to A = 0.007 m no support is reached and the frequency is 63.2 rad/s," in text
    plain, text = (describe_backbone(data) for data in (curves, vp.to_physical(curves, M, C)))
    ends = [float(part.split()[-1]) for part in plain.split(" at δ")[:-1]]
    assert ends
    for end in ends:
        assert f"{end / P:.4g} s at δ" in text
