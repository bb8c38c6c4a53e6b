"""Reset, chatter, frames, saltation, and the closed forms of motions that need no march."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from vibropipe.physics.conservative import arc, arc_harmonic, arc_state, backbone_velocity
from vibropipe.physics.contact import chatter_duration, frame_at, reset, to_displacement
from vibropipe.physics.effects import ALL_EFFECTS
from vibropipe.physics.exciter import Parameters
from vibropipe.physics.linear import linear_amplitude, settles_without_impact
from vibropipe.physics.load import NEVER
from vibropipe.physics.saltation import product, saltation_matrix

P = Parameters(1.0, 1.0, 0.2, 0.5, 0.01, 0.7, 0.6)


def test_a_frame_holds_the_reachable_supports() -> None:
    """From home 0 support 2 is near and support 1 far; from a support that one is near."""
    assert [frame_at(ALL_EFFECTS, P, home)[-2:] for home in range(3)] == [(True, True)] * 3
    alone = ALL_EFFECTS._replace(support_2=None)
    assert [frame_at(alone, P, home)[-2:] for home in (0, 1)] == [(False, True), (True, False)]
    alone = ALL_EFFECTS._replace(support_1=None)
    assert [frame_at(alone, P, home)[-2:] for home in (0, 2)] == [(True, False)] * 2


def test_reset_is_equation_6() -> None:
    assert reset(0.7, 2.0) == 1.4
    assert reset(0.0, 2.0) == 0.0


@pytest.mark.parametrize("home", [0, 1, 2])
def test_a_frame_maps_supports_to_its_ends(home: int) -> None:
    frame = frame_at(ALL_EFFECTS, P, home)
    ends = sorted([to_displacement(P, home, frame.near), to_displacement(P, home, frame.far)])
    assert ends == pytest.approx([P.delta - P.l, P.l + P.delta], abs=1e-16)
    # At y = 0 without force the spring force is the load.
    assert frame.load == pytest.approx(
        -to_displacement(P, home, 0.0) * (-1.0 if home == 1 else 1.0)
    )


@pytest.mark.parametrize("R", [0.05, 0.5, 0.9, 0.99])
def test_a_chatter_under_constant_acceleration_is_its_geometric_series(R: float) -> None:
    w, acceleration, duration = 1e-10, -0.8, 0.0
    for _ in range(5000):
        duration += 2 * w / -acceleration
        w *= R
    assert chatter_duration(1e-10, acceleration, 0.0, R, 0.0, 1.0) == pytest.approx(
        duration, rel=1e-12
    )


def test_a_chatter_is_not_completed_while_the_acceleration_changes() -> None:
    assert chatter_duration(1e-3, -0.8, 0.5, 0.7, 0.2, 1.0) == NEVER
    assert chatter_duration(1e-9, -0.8, 0.5, 1.0, 0.2, 1.0) == NEVER
    assert chatter_duration(1e-16, -0.8, 0.5, 1.0, 0.2, 1.0) == pytest.approx(2.5e-16)


@given(
    R=st.floats(0, 1), v=st.floats(0.1, 3), force=st.floats(-2, 2), h=st.floats(0, 1),
    dx=st.floats(-1, 1), dv=st.floats(-1, 1),
)  # fmt: skip
def test_saltation_is_the_derivative_of_a_late_impact(
    R: float, v: float, force: float, h: float, dx: float, dv: float
) -> None:
    """A perturbed motion is marched to its own impact and back, to first order in the deviation."""
    before, after = force - h * v, force + h * R * v
    s11, s12, s21, s22 = saltation_matrix(R, v, before, after)
    assert s11 * s22 - s12 * s21 == pytest.approx(R * R, abs=1e-14)
    e = 1e-6
    late = -e * dx / v
    x_after = e * dx + (v + e * dv) * late - (-R * (v + e * dv + before * late)) * late
    v_after = -R * (v + e * dv + before * late) - after * late + R * v
    assert x_after / e == pytest.approx(s11 * dx + s12 * dv, abs=1e-3)
    assert v_after / e == pytest.approx(s21 * dx + s22 * dv, abs=1e-3)


def test_product_is_the_matrix_product() -> None:
    a, b = np.arange(1.0, 5).reshape(2, 2), np.array([[2.0, -1.0], [0.5, 3.0]])
    np.testing.assert_array_equal(np.reshape(product(*a.ravel(), *b.ravel()), (2, 2)), a @ b)


def test_the_linear_motion_solves_equation_5() -> None:
    x = linear_amplitude(P)
    for tau in (0.0, 0.4, 2.0):
        phasor = complex(math.cos(P.nu * tau), math.sin(P.nu * tau))
        x_tau, velocity, acceleration = (
            2 * (x * factor * phasor).real for factor in (1, 1j * P.nu, -(P.nu**2))
        )
        assert acceleration + P.h * velocity + x_tau == pytest.approx(
            P.f * math.sin(P.nu * tau), abs=1e-14
        )


def test_the_certificate_holds_for_damped_motions_off_the_supports() -> None:
    quiet = P._replace(f=0.04)
    assert settles_without_impact(quiet, 0.0, 0.0)
    assert not settles_without_impact(P, 0.0, 0.0)
    assert not settles_without_impact(quiet._replace(h=0.0), 0.0, 0.0)
    assert not settles_without_impact(quiet, 0.0, 0.6)
    assert not settles_without_impact(quiet._replace(delta=0.6), 0.2, 0.0)


FREE = Parameters(1.0, 0.0, 0.0, 0.5, 0.01, 1.0, 1.0)


def test_the_backbone_gives_the_period_of_its_motion() -> None:
    """By eq. (10) a motion of that velocity takes half the period from one support to the other."""
    for d in (0.0, 0.1, 0.3):
        for tau_bar in (0.5, 1.0, 1.6):
            v = float(backbone_velocity(np.array(d), np.array(tau_bar)))
            a = arc(FREE._replace(l=1.0, delta=d), 1.0 + d, -v)
            assert 2 * a.half == pytest.approx(tau_bar, rel=1e-13)
            assert arc_state(a, a.half * (1 - 1e-12))[0] == pytest.approx(-(1 - d), abs=1e-10)


def test_the_backbone_is_nan_where_a_support_is_missed() -> None:
    assert math.isnan(backbone_velocity(np.array(0.3), np.array(4.6)))
    assert math.isnan(backbone_velocity(np.array(0.0), np.array(2 * math.pi + 0.1)))


@given(x=st.floats(-0.48, 0.5), v=st.floats(-2, 2))
def test_harmonics_of_an_arc_add_up_to_its_motion(x: float, v: float) -> None:
    assume(math.hypot(x, v) > 0.05)
    assume(min(abs(math.hypot(x, v) - 0.49), abs(math.hypot(x, v) - 0.51)) > 1e-3)
    a = arc(FREE, x, v)
    assert arc_state(a, 0.0) == pytest.approx((x, v), abs=1e-12)
    times = np.arange(4096) * 2 * a.half / 4096
    samples = np.array([arc_state(a, t)[0] for t in times])
    spectrum = np.fft.fft(samples) / 4096
    for k in range(4):
        assert arc_harmonic(a, k) == pytest.approx(spectrum[k], abs=1e-6)
