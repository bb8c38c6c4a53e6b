"""Derivatives of named quantities: exact ones against central differences."""

from __future__ import annotations

import numpy as np

import vibropipe as vp
from vibropipe.solve.rows.gradient import by_differences, values_and_jacobian
from vibropipe.solve.rows.named import named
from vibropipe.solve.rows.points import solve_points

EXCITER = vp.Exciter(l=0.5, nu=1.0, f=-1.0, h=0.2, delta=0.01, R1=0.7, R2=0.6)
OUTPUTS = ("harmonics", "impacts", "stability", "energy", "lyapunov")
NAMES = [
    named(name, "names")
    for name in (
        "displacement_mean", "displacement_amplitude_2", "velocity_phase_1", "impact_velocity_max_2",
        "energy_impact_1", "floquet_multiplier_1_re", "lyapunov_exponent", "delta", "period_multiple",
    )
]  # fmt: skip


def near(parameters, states, sensitivity=False):
    outputs = (*OUTPUTS, "sensitivity") if sensitivity else OUTPUTS
    return solve_points(parameters, (states[:, 0], states[:, 1]), outputs, 3)


def read(points):
    return points.values(NAMES)


def test_both_agree():
    parameters = np.array(EXCITER.parameters())
    state = near(parameters[None], np.zeros((1, 2))).states[0]
    arguments = parameters, state, list(range(7)), near, read, np.subtract
    point, values, exact = values_and_jacobian(*arguments, names=NAMES)
    # the error of a central difference is its step squared times the third derivative, large by nu
    _, same, differences = by_differences(*arguments)
    assert point.is_stable.all()
    assert np.allclose(values, same, rtol=1e-10)
    assert np.allclose(exact, differences, rtol=1e-5, atol=1e-7)


def test_the_vanishing_harmonic_of_a_symmetric_orbit_has_differences():
    symmetric = np.array(vp.Exciter(l=0.5, nu=1.0, f=-1.0, h=0.2, R1=0.7, R2=0.7).parameters())
    state = near(symmetric[None], np.zeros((1, 2))).states[0]
    names = [named("displacement_amplitude_2", "names")]
    _, _, slopes = values_and_jacobian(
        symmetric, state, [4], near, lambda points: points.values(names), np.subtract, names=names
    )
    assert np.isfinite(slopes).all()
