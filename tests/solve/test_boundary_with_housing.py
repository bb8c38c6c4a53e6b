"""Boundaries of exciters with a housing that slides: against differences of motions, branches, and touches."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from housings import RUBBED, SECTION, STRUCK, SYMMETRIC, section_map

import vibropipe as vp
from vibropipe.words.bifurcations import Bifurcation, Meeting

CASES = {
    "struck": (STRUCK, ("fold", "flip", "grazing"), ("nu", "f"), ((0.9, 1.2), (0.7, 1.1))),
    "ground": (
        STRUCK,
        ("fold", "grazing"),
        ("mass_ratio", "housing_friction_1"),
        ((0.2, 1.0), (0.1, 0.6)),
    ),
    "symmetric": (SYMMETRIC, ("fold", "pitchfork"), ("nu", "f"), ((1.1, 1.6), (0.6, 1.2))),
    "rubbed": (RUBBED, ("flip", "grazing"), ("nu", "friction"), ((1.1, 1.5), (0.05, 0.3))),
}


@pytest.fixture(scope="module")
def curves():
    return {
        name: vp.boundary(exciter, of, along, within, lines=4)
        for name, (exciter, of, along, within) in CASES.items()
    }


def sampled(case, curve, mask, n=5):
    """Return some points of a mask away from where curves meet something: there differences of motions mix two laws."""
    _exciter, _of, along, within = CASES[case]
    away = np.full(curve.sizes["point"], np.inf)
    for point in curve.meeting_point.values:
        shares = [
            np.abs(curve[name].values - float(curve[name][point])) / (high - low)
            for name, (low, high) in zip(along, within, strict=True)
        ]
        away = np.minimum(away, np.max(shares, axis=0))
    found = np.flatnonzero(mask & (away > 0.01))
    return found[np.linspace(0, found.size - 1, min(n, found.size)).astype(int)]


def orbit_at(case, curve, i):
    """Return the exciter at a point, the state at the section of its orbit, and its period multiple."""
    exciter, _of, along, _within = CASES[case]
    at = replace(exciter, **{name: float(curve[name][i]) for name in along})
    state = np.array([float(curve[name][i]) for name in SECTION])
    return at, state, int(curve.period_multiple[i])


@pytest.mark.parametrize(
    "case",
    [pytest.param(case, marks=pytest.mark.slow) if case == "struck" else case for case in CASES],
)
def test_orbits_have_the_multiplier_of_their_bifurcation(curves, case):
    """The multiplier is that of differences of motions, too."""
    curve = curves[case]
    kinds = curve.boundary_kind.values
    assert curve.floquet_multiplier.shape[1] == 3
    for kind, unit in ((Bifurcation.FOLD, 1.0), (Bifurcation.FLIP, -1.0), (Bifurcation.PITCHFORK, 1.0)):  # fmt: skip
        is_own = kinds == kind
        unknown = is_own & np.isnan(curve.floquet_multiplier.values).any(axis=1)
        assert set(np.flatnonzero(unknown)) <= set(curve.meeting_point.values.tolist())
        is_own &= ~unknown
        if kind.name.lower() in CASES[case][1]:
            assert is_own.sum() > 10
        away = np.abs(curve.floquet_multiplier.values[is_own] - unit).min(axis=1, initial=np.inf)
        assert (away < 1e-8).all()
        mild = is_own & (np.abs(curve.floquet_multiplier.values).max(axis=1) < 5.0)
        for i in sampled(case, curve, mild):
            exciter, state, m = orbit_at(case, curve, i)
            np.testing.assert_allclose(section_map(exciter, state, m), state, atol=1e-9)
            matrix, step = np.empty((3, 3)), 1e-7
            for j in range(3):
                change = step * np.eye(3)[j]
                ends = [section_map(exciter, state + way * change, m) for way in (1.0, -1.0)]
                matrix[:, j] = (ends[0] - ends[1]) / (2.0 * step)
            # Off by the curvature of the map, which grows towards a grazing.
            assert np.abs(np.linalg.eigvals(matrix) - unit).min() < 2e-3


@pytest.mark.parametrize("case", ["struck", "ground", "rubbed"])
def test_an_orbit_at_a_grazing_touches_a_support(curves, case):
    curve = curves[case]
    grazes = curve.boundary_kind.values == Bifurcation.GRAZING
    assert grazes.sum() > 20
    for i in sampled(case, curve, grazes & (curve.stable.values == 1)):
        exciter, state, m = orbit_at(case, curve, i)
        x, v, velocity = (float(each) for each in state)
        tau = m * 2.0 * np.pi / exciter.nu
        motion = vp.simulate(exciter, tau, x, v, housing_v0=velocity, samples_per_period=4000)
        struck = motion.impact_tau.values[np.abs(motion.impact_velocity.values) > 1e-4]
        taus, path = motion.tau.values, motion.displacement.values
        gaps = []
        for position, way in ((exciter.l + exciter.delta, 1.0), (exciter.delta - exciter.l, -1.0)):
            gap = way * (position - path)
            turns = np.flatnonzero((gap[1:-1] <= gap[:-2]) & (gap[1:-1] <= gap[2:])) + 1
            free = [t for t in turns if not np.any(np.abs(struck - taus[t]) < 2.0 * tau / 4000)]
            gaps += gap[free].tolist()
        # A parabola between two samples rises by less than this.
        assert -1e-9 < min(gaps) < 1e-5


def test_a_branch_folds_and_doubles_where_the_boundary_is(curves):
    curve = curves["symmetric"]
    compared = 0
    for kind in (Bifurcation.FOLD, Bifurcation.PITCHFORK):
        for i in sampled(
            "symmetric", curve, (curve.boundary_kind.values == kind) & (curve.nu.values < 1.5), 6
        ):
            value, nu = float(curve.f[i]), float(curve.nu[i])
            branch = vp.branch(replace(SYMMETRIC, nu=nu), "f", (0.6, 1.2), harmonics=1)
            found = branch.bifurcation_f.values[branch.bifurcation_kind.values == kind]
            if found.size:
                compared += 1
                assert np.abs(found - value).min() < 1e-8
    assert compared >= 6


@pytest.mark.parametrize("case", CASES)
def test_curves_end_at_the_box_or_where_others_begin(curves, case):
    curve = curves[case]
    ends = {Meeting(int(each)).name for each in curve.meeting_kind.values[curve.meeting_ends == 1]}
    assert "LOST" not in ends
    assert "BOX" in ends
    for name, (low, high) in zip(*CASES[case][2:], strict=True):
        values = curve[name].values
        assert low <= values.min() <= values.max() <= high


def test_what_has_no_isolated_orbits_is_refused_in_words():
    loose = replace(STRUCK, housing_friction_1=0.0, housing_friction_2=0.0)
    with pytest.raises(vp.ParameterError, match="housing_friction_1: must be above 0, or"):
        vp.boundary(loose, "fold", ("nu", "f"), ((0.9, 1.2), (0.7, 1.1)))


@pytest.mark.slow
def test_an_orbit_that_grazes_alone_keeps_off_the_other_support():
    """Of an orbit without contacts no gap was looked at but the one that vanishes."""
    exciter = vp.Exciter(
        l=0.5, nu=1.17, f=1.92, h=0.09, R1=0.77, R2=0.46, delta=-0.05, f2=0.5, mass_ratio=0.88,
        housing_friction_1=0.23, housing_friction_2=0.03,
    )  # fmt: skip
    with pytest.warns(vp.UnsolvedWarning):
        curve = vp.boundary(exciter, "grazing")
    alone = np.flatnonzero(curve.impacts_per_orbit.sum("support").values == 0)
    assert alone.size > 100
    for i in alone[:: alone.size // 40]:
        at = replace(exciter, nu=float(curve.nu[i]), f=float(curve.f[i]))
        x, v, velocity = (float(curve[name][i]) for name in SECTION)
        tau = int(curve.period_multiple[i]) * at.period
        motion = vp.simulate(at, tau, x, v, housing_v0=velocity, samples_per_period=0)
        assert np.abs(motion.impact_velocity.values).max(initial=0.0) < 1e-4


# Exciter, kinds, box, lines, and how many of some 60 points rest at least.
RETURNING = {
    "rests": (
        vp.Exciter(
            l=0.5, nu=0.43, f=1.13, h=0.1, R1=0.37, R2=0.55, delta=0.17, f2=0.18, mass_ratio=1.56,
            housing_friction_1=0.22, housing_friction_2=0.08,
        ),
        ("fold", "flip"),
        ((0.3, 0.8), (0.5, 1.6)),
        4,
        20,
    ),
    # The housing would stop within a chatter that is counted as one event.
    "chatter": (
        vp.Exciter(
            l=0.5, nu=0.88, f=1.68, h=0.073, R1=0.437, R2=0.629, delta=0.137, f2=0.0276,
            mass_ratio=1.168, housing_friction_1=0.077, housing_friction_2=0.184,
        ),
        "flip",
        ((0.9, 1.0), (1.35, 2.0)),
        3,
        0,
    ),
    # Along the curve the touch passes a slip of the housing.
    "touch": (
        vp.Exciter(
            l=0.5, nu=1.535, f=0.8865, h=0.173, R1=0.353, R2=0.531, delta=-0.113, mass_ratio=0.55,
            housing_friction_1=0.0829, housing_friction_2=0.0661,
        ),
        "grazing",
        ((1.3, 1.76), (0.71, 1.06)),
        3,
        0,
    ),
    # A mass that turned against its friction would go on as it was where the housing stops.
    "rubbed": (
        vp.Exciter(
            l=0.5, nu=1.58, f=1.95, h=0.07, R1=0.336, R2=0.327, delta=-0.0826, friction=0.0407,
            mass_ratio=0.833, housing_friction_1=0.301, housing_friction_2=0.252,
        ),
        "grazing",
        ((1.34, 1.82), (1.56, 2.34)),
        3,
        0,
    ),
}  # fmt: skip


@pytest.mark.parametrize(
    "case",
    [
        pytest.param(case, marks=pytest.mark.slow)
        if case in ("chatter", "rests", "rubbed")
        else case
        for case in RETURNING
    ],
)
def test_orbits_on_boundaries_return_when_marched(case):
    exciter, of, within, lines, least = RETURNING[case]
    curve = vp.boundary(exciter, of, within=within, lines=lines)
    points, resting = curve.sizes["point"], 0
    assert points > 50
    for i in range(0, points, max(1, points // 60)):
        at = replace(exciter, nu=float(curve.nu[i]), f=float(curve.f[i]))
        state = np.array([float(curve[name][i]) for name in SECTION])
        largest = float(np.abs(curve.floquet_multiplier.values[i]).max())
        growth = 1.0 + np.nan_to_num(largest) ** 2
        # At a grazing rounding decides whether the support is met, at a speed of its root.
        atol = (1e-6 if of == "grazing" else 1e-9) * growth
        ends = section_map(at, state, int(curve.period_multiple[i]))
        np.testing.assert_allclose(ends, state, atol=atol)
        resting += float(vp.steady_state(at, *state[:2]).rests_per_orbit.sum()) > 0.0
    assert resting >= least
