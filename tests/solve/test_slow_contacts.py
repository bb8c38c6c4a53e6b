"""Contacts of enormous stiffness or damping, against their closed form in sixty digits: they took minutes or no end."""

from __future__ import annotations

import math
import time
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mp_contacts import contacts_of_support_1

import vibropipe as vp
from vibropipe.words.regimes import Regime
from vibropipe.words.status import Status

# Creep of first order, contacts of a millionth of the period, masses pressed on the support.
CASES: list[dict[str, float]] = [
    {"k1": 1.0, "h1": 1e9},
    {"k1": 1e-6, "h1": 1e7},
    {"k1": 1e4, "h1": 1e12},
    {"k1": 1e8, "h1": 3e3},
    {"k1": 1e12, "h1": 1e5},
    {"k1": 1e8, "h1": 3e3, "delta": -0.6, "f": 0.05},
    {"k1": 1e10, "h1": 1e5, "delta": -0.6, "f": 0.3},
    {"k1": 1e8, "h1": 1e6, "delta": -0.6, "f": 0.3},
]


@pytest.mark.parametrize("case", CASES)
def test_motions_agree_with_their_closed_form(case: dict[str, float]) -> None:
    exciter = vp.Exciter(**{"l": 0.5, "nu": 1.0, "f": 0.8, "h": 0.15, **case})
    start = exciter.upper - 0.2
    motion = vp.simulate(exciter, 4.0, x0=start, samples_per_period=0, energy=True)
    assert motion.status == Status.OK
    contacts, end = contacts_of_support_1(exciter, 4.0, start)
    assert motion.impact_support.values.tolist() == [1] * len(contacts)
    expected = np.array(contacts).T
    ended = np.isfinite(expected[2])
    np.testing.assert_allclose(motion.impact_tau, expected[0], rtol=1e-14)
    np.testing.assert_allclose(motion.impact_velocity, expected[1], rtol=1e-13)
    np.testing.assert_allclose(motion.contact_duration[ended], expected[2][ended], rtol=1e-12)
    np.testing.assert_allclose(float(motion.displacement_end), end[0], atol=1e-14)
    np.testing.assert_allclose(float(motion.velocity_end), end[1], atol=1e-14)
    assert abs(float(motion.energy_residual)) < 1e-13


def test_steady_states_with_slow_contacts() -> None:
    """The support stops the mass like a rigid one with R = 0 that does not let go at once."""
    exciter = vp.Exciter(l=0.5, nu=1.0, f=0.8, h=0.15, k1=1.0, h1=1e9, R2=0.6)
    row = vp.steady_state(exciter)
    assert row.status == Status.OK
    marched = vp.simulate(
        exciter,
        float(row.period_multiple) * exciter.period,
        x0=float(row.displacement_strobe),
        v0=float(row.velocity_strobe),
    )
    assert float(marched.displacement_end) == pytest.approx(
        float(row.displacement_strobe), abs=1e-12
    )
    assert np.isfinite(row.displacement_amplitude).all()


@pytest.mark.slow
def test_a_vibration_in_contact_that_never_decays_has_a_status() -> None:
    exciter = vp.Exciter(l=0.5, nu=1.0, f=0.01, h=0.0, k1=1e12, delta=-0.6)
    with pytest.warns(vp.UnsolvedWarning, match="too many steps"):
        motion = vp.simulate(exciter, 200.0, x0=exciter.upper + 1e-13, samples_per_period=0)
    assert motion.status == Status.MAX_STEPS


wide = st.floats(-8.0, 12.0).map(lambda exponent: 10.0**exponent)


@pytest.mark.filterwarnings("ignore::vibropipe.UnsolvedWarning")
@settings(max_examples=30, deadline=60_000)
@given(
    k1=wide,
    h1=wide,
    k2=st.none() | wide,
    h=wide | st.sampled_from([0.0, 0.15]),
    energy=st.booleans(),
)
def test_every_motion_ends(k1: float, h1: float, k2: float | None, h: float, energy: bool) -> None:
    """With a status, a refusal or a motion between or shortly beyond the supports."""
    others: dict[str, Any] = {} if k2 is None else {"k2": k2}
    exciter = vp.Exciter(l=0.5, nu=1.0, f=0.8, h=h, k1=k1, h1=h1, **others)
    if h > 1e5:  # free flights have too many steps
        with pytest.raises(vp.ParameterError, match="tau_end: must be reached in at most"):
            vp.simulate(exciter, 1e3, energy=energy, x0=0.5)
        return
    motion = vp.simulate(exciter, 20.0, energy=energy)
    if motion.status == Status.OK:
        assert math.isfinite(float(motion.displacement_end))
        if energy:
            scale = max(1.0, abs(float(motion.energy_input)))
            assert abs(float(motion.energy_residual)) < 1e-10 * scale


@pytest.mark.filterwarnings("ignore::vibropipe.UnsolvedWarning")
@settings(max_examples=15, deadline=None)
@given(k1=wide, h1=wide, h=wide | st.just(0.0), nu=st.floats(-3.0, 3.0).map(lambda n: 10.0**n))
def test_every_row_ends(k1: float, h1: float, h: float, nu: float) -> None:
    """Two rows take at most the work of two, a second of an idle core each."""
    exciter = vp.Exciter(l=0.5, nu=nu, f=0.8, h=h, k1=k1, h1=h1)
    began = time.process_time()
    rows = vp.sweep(exciter, {"nu": [nu, 1.1 * nu]}, outputs=())
    assert time.process_time() - began < 60.0  # compiling included
    unresolved = rows.regime == Regime.UNRESOLVED
    assert np.isin(rows.status.values, [int(each) for each in Status]).all()
    assert not (unresolved & (rows.status == Status.OK)).any()
