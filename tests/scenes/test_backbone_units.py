"""Pictures and captions of a backbone in the units of its dataset."""

import math

import numpy as np
import pytest

import vibropipe as vp
from vibropipe.scenes.backbone.curves import draw_amplitude_frequency, draw_backbone
from vibropipe.scenes.backbone.pictures import describe_amplitude_frequency, describe_backbone

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


def labels(figure):
    return [ax.get_xlabel() for ax in figure.axes], [ax.get_ylabel() for ax in figure.axes]


def test_amplitudes_have_units(over_amplitude) -> None:
    x, y = labels(draw_amplitude_frequency(vp.to_physical(over_amplitude, M, C)))
    assert {text for text in x if text} == {r"eigenfrequency $\bar{\omega}$ (rad/s)"}
    assert {"first harmonic\n$A_1$ (m)", "first harmonic\n$B_1$ (m/s)"} <= {*y}


def test_captions_have_units(over_amplitude, curves) -> None:
    text = describe_amplitude_frequency(vp.to_physical(over_amplitude, M, C))
    assert text.endswith(
        f"l = {float(over_amplitude.l):.4g} m, δ = {float(over_amplitude.delta):.4g} m."
    )
    alone = describe_backbone(curves, ["omega_bar"])
    assert "against the frequency of free vibration" in alone
    plain, text = (describe_backbone(data) for data in (curves, vp.to_physical(curves, M, C)))
    limits = [2 * math.acos(-(1 - d) / (1 + d)) for d in abs(curves.delta_over_l.values)]
    assert limits
    for limit in limits:
        assert f"{limit:.4g} at δ" in plain
        assert f"{limit / P:.4g} s at δ" in text


@pytest.mark.parametrize("scale", [1.0, 1e3])
def test_markers_lie_on_the_curves_in_any_unit_of_time(curves, scale: float) -> None:
    physical = vp.to_physical(curves, M, C)
    marked = physical.assign(
        simulated_free_period=(("delta_over_l", "point"), physical["free_period"].values[None, 9:12].repeat(2, 0)),
        simulated_velocity_over_l=(("delta_over_l", "point"), physical["velocity_over_l"].values[:, 9:12]),
    )  # fmt: skip
    for name in ("free_period", "simulated_free_period"):
        marked[name] = marked[name] * scale
        words = physical["free_period"].attrs
        marked[name].attrs = {**words, "units": "s" if scale == 1.0 else "ms"}
    by_period, by_frequency = draw_backbone(marked).axes
    assert (
        by_period.get_xlabel()
        == f"period of free vibration $\\bar{{T}}$ ({'s' if scale == 1 else 'ms'})"
    )
    assert by_period.get_ylabel().endswith("(1/s)")
    curve, markers = by_frequency.lines[:2]
    assert markers.get_xdata() == pytest.approx(curve.get_xdata()[9:12], rel=1e-12)
