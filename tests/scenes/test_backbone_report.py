"""Backbones: findings in sentences, pictures and captions, in the units of the dataset."""

import math

import numpy as np
import pytest
import xarray as xr
from figures.sample_datasets import amplitude_frequency, backbone

import vibropipe as vp
from vibropipe.scenes.backbone.curves import draw_amplitude_frequency, draw_backbone, longest_period
from vibropipe.scenes.backbone.overlay import FAMILIES, draw_overlay, jumps_of, lines_of
from vibropipe.scenes.backbone.pictures import (
    amplitude_title,
    describe_amplitude_frequency,
    describe_backbone,
    describe_characteristics,
    free_and_forced,
)
from vibropipe.scenes.backbone.report import answers


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


def test_amplitudes_have_units(over_amplitude) -> None:
    axes = draw_amplitude_frequency(vp.to_physical(over_amplitude, M, C)).axes
    x, y = [ax.get_xlabel() for ax in axes], [ax.get_ylabel() for ax in axes]
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
