"""Named quantities with index, which targets, bounds and spreads name, and their exact derivatives."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import vibropipe as vp
from vibropipe.solve.rows.gradient import by_differences, exact_slopes, values_and_jacobian
from vibropipe.solve.rows.named import SMOOTH, labels, named, outputs_of
from vibropipe.solve.rows.points import solve_points
from vibropipe.words.vocabulary import STEADY

EXCITER = vp.Exciter(l=0.5, nu=1.0, f=-1.0, h=0.2, delta=0.01, R1=0.7, R2=0.7, friction=0.1)
SOFT = replace(EXCITER, R1=1.0, R2=1.0, k1=200.0, h1=3.0, k2=100.0, h2=2.0)


SLIDES = replace(SOFT, mass_ratio=0.5, housing_friction_1=0.1, housing_friction_2=0.1)


@pytest.mark.parametrize("exciter", [EXCITER, SOFT, SLIDES], ids=["rigid", "soft", "slides"])
def test_every_name_is_the_column_of_a_table(exciter):
    is_there = {"": True, "friction": True, "housing": exciter.mass_ratio > 0}
    is_there["soft"] = exciter.k1 > 0 and not is_there["housing"]
    names = [
        named(label, "target")
        for variable in SMOOTH
        if not variable.startswith("subharmonic") and is_there[STEADY[variable].effect]
        for label in labels(variable)
    ]
    outputs = outputs_of(names)
    row = [list(exciter.parameters())]
    values = solve_points(np.array(row), (None, 0.0), outputs, 3).values(names)[0]
    table = vp.table(vp.sweep(exciter, over={"nu": [1.0]}, outputs=outputs))
    assert {name.name for name in names} <= {*table.columns}
    np.testing.assert_array_equal([table[name.name][0] for name in names], values)


def test_rows_without_friction_lose_nothing_by_it():
    name = named("energy_friction", "target")
    rows = np.array([replace(EXCITER, friction=0.0).parameters()] * 2)
    rows[1, list(vars(EXCITER)).index("nu")] = 2.3  # chaos, whose energies are means over a window
    outputs = (*outputs_of([name]), "sensitivity")
    points = solve_points(rows, (None, 0.0), outputs, 1)
    assert points.values([name])[:, 0].tolist() == pytest.approx([0.0, 0.0])
    assert np.isnan(exact_slopes(points, [name], [0])).all()


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("impact_velocity_max", "must be one of impact_velocity_max_1, impact_velocity_max_2, got"),
        ("impact_velocity_max_3", "must be one of impact_velocity_max_1, impact_velocity_max_2"),
        ("displacement_amplitude_0", "displacement_amplitude_1, .* and so on"),
        ("contact_force_max_1", "did you mean 'support_force_max_1'"),
        ("support_force_max_std_1", "must be a quantity of a steady state"),
        ("displacement_mean_1", "must have no number after displacement_mean"),
        ("displacment_mean", "did you mean 'displacement_mean'"),
        ("floquet_multiplier_1", "did you mean 'floquet_multiplier_1_re'"),
        ("displacement_mean_sensitivity_R3", "must be a quantity of a steady state"),
        ("regime", "must be a quantity that can have a goal or a bound"),
        ("wear_rate_1", "which only datasets have"),
        (3, "must be names of quantities"),
    ],
)
def test_a_wrong_name_is_refused_with_what_is_near(name, message):
    with pytest.raises(vp.ParameterError, match=message):
        named(name, "target")


def test_derived_quantities_have_their_suffix_before_the_number():
    spread = named("impact_velocity_max_std_2", "minimise")
    assert (spread.variable, spread.number, spread.derived) == ("impact_velocity_max", 2, "std")
    slope = named("impact_velocity_max_sensitivity_1_R1", "minimise")
    assert (slope.number, slope.derived, slope.parameter) == (1, "sensitivity", "R1")


STRUCK = vp.Exciter(l=0.5, nu=1.0, f=-1.0, h=0.2, delta=0.01, R1=0.7, R2=0.6)
ORBIT_OUTPUTS = ("harmonics", "impacts", "stability", "energy", "lyapunov")
NAMES = [
    named(name, "names")
    for name in (
        "displacement_mean", "displacement_amplitude_2", "velocity_phase_1", "impact_velocity_max_2",
        "energy_impact_1", "floquet_multiplier_1_re", "lyapunov_exponent", "delta", "period_multiple",
    )
]  # fmt: skip


def near(parameters, states, sensitivity=False):
    outputs = (*ORBIT_OUTPUTS, "sensitivity") if sensitivity else ORBIT_OUTPUTS
    return solve_points(parameters, (states[:, 0], states[:, 1]), outputs, 3)


def test_both_agree():
    parameters = np.array(STRUCK.parameters())
    state = near(parameters[None], np.zeros((1, 2))).states[0]
    arguments = (
        parameters,
        state,
        list(range(7)),
        near,
        lambda points: points.values(NAMES),
        np.subtract,
    )
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
