"""Boundaries in two parameters: against closed forms, branches, regimes of a sweep, and themselves."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from orbit_motions import motion_of

import vibropipe as vp
from vibropipe.physics import closed_orbits as closed
from vibropipe.words.bifurcations import Bifurcation, Meeting
from vibropipe.words.regimes import Regime

EXCITER = vp.Exciter(l=0.5, h=0.2, R1=0.7, R2=0.7, nu=1.0, f=0.5)
# A second harmonic; the first one is in the box.
TWO_HARMONICS = dataclasses.replace(EXCITER, f2=0.25, phi2=0.6)
BOX = ((0.6, 3.0), (0.05, 1.5))
ALL = ("fold", "flip", "pitchfork", "grazing")


@pytest.fixture(scope="module")
def borders():
    return vp.boundary(EXCITER, ALL, within=BOX, lines=8)


@pytest.fixture(scope="module")
def borders_of_two():
    return vp.boundary(TWO_HARMONICS, ALL, within=((0.7, 2.0), (0.05, 1.2)), lines=4)


def of_law(dataset, kind, m, p1, p2):
    """Return nu and f of the points of one kind and law of motion."""
    impacts = dataset["impacts_per_orbit"].transpose("point", "support").values
    mask = (
        (dataset["boundary_kind"].values == Bifurcation[kind.upper()])
        & (dataset["period_multiple"].values == m)
        & (impacts == (p1, p2)).all(axis=1)
    )
    return dataset["nu"].values[mask], dataset["f"].values[mask]


def linear_grazing(exciter, nu):
    """Return the amplitude at which the motion without impacts touches a support."""
    return (exciter.l - abs(exciter.delta)) * np.hypot(1.0 - nu**2, exciter.h * nu)


def closed_force(exciter, nu, n, kind):
    """Return the amplitude of a fold, or of a flip or pitchfork, of the orbits in closed form."""
    terms = closed.flight_terms(nu, exciter.h, n)
    response = closed.response(nu, exciter.h, exciter.R1, terms)
    b = exciter.l + exciter.delta
    if kind == "fold":
        v = closed.fold_velocity(b, response)
    else:
        v = closed.flip_velocity(nu, b, exciter.R1, terms, response)
    return np.abs(closed.forcing_at_impact(b, v, response))


def assert_close(f, expected):
    """Check forces to 1e-10; the closed form has none where, at an end of a curve, the impact velocity is 0."""
    assert np.isnan(expected).sum() <= 4
    assert np.nanmax(np.abs(f - expected)) < 1e-10


def test_first_grazing_is_that_of_the_linear_motion(borders):
    nu, f = of_law(borders, "grazing", 1, 0, 0)
    assert nu.size > 50
    assert np.abs(f - linear_grazing(EXCITER, nu)).max() < 1e-12


@pytest.mark.parametrize("kind", ["fold", "pitchfork"])
def test_symmetric_orbit_has_its_closed_forms(borders, kind):
    # Asymmetric orbits have the same law of motion, and folds without a closed form.
    speeds = borders["impact_velocity_max"].transpose("point", "support").values
    symmetric = borders.isel(point=np.abs(speeds[:, 0] - speeds[:, 1]) < 1e-9)
    nu, f = of_law(symmetric, kind, 1, 1, 1)
    assert nu.size > 50
    assert_close(f, closed_force(EXCITER, nu, 1, kind))


@pytest.mark.parametrize("delta", [pytest.param(0.2, marks=pytest.mark.slow), -0.2])
def test_one_sided_orbit_has_its_closed_forms(delta):
    exciter = dataclasses.replace(EXCITER, delta=delta)
    found = vp.boundary(exciter, ("fold", "flip", "grazing"), within=BOX, lines=8)
    near = exciter if delta < 0 else exciter.mirrored()
    law = (1, 0) if delta < 0 else (0, 1)
    nu, f = of_law(found, "grazing", 1, 0, 0)
    assert np.abs(f - linear_grazing(exciter, nu)).max() < 1e-12
    for kind in ("fold", "flip"):
        nu, f = of_law(found, kind, 1, *law)
        assert nu.size > 10
        assert_close(f, closed_force(near, nu, 2, kind))


@pytest.mark.slow
def test_mirrored_exciter_has_the_same_curves():
    exciter = vp.Exciter(l=0.5, h=0.2, delta=0.1, R1=0.7, R2=0.8)
    first = vp.boundary(exciter, ALL, within=((0.7, 2.0), (0.1, 0.8)), lines=5)
    second = vp.boundary(exciter.mirrored(), ALL, within=((0.7, 2.0), (0.1, 0.8)), lines=5)
    ends = [
        sorted(
            (int(k), round(float(x), 6), round(float(y), 6))
            for k, x, y in zip(d["meeting_kind"], d["meeting_nu"], d["meeting_f"], strict=True)
            if k == Meeting.BOX
        )
        for d in (first, second)
    ]
    assert ends[0] == ends[1]
    assert np.unique(first["curve_id"]).size == np.unique(second["curve_id"]).size


@pytest.mark.slow
def test_halved_steps_find_the_same_curves(borders):
    halved = vp.boundary(EXCITER, ALL, within=BOX, lines=8, max_step=0.01)
    one, two = ends_of(halved), ends_of(borders)
    assert len(one) == len(two)
    # Where an orbit touches twice at once the equations are singular: such ends are known to half of the digits.
    apart = np.abs(one[:, None] - two).max(axis=2)
    assert apart.min(axis=1).max() < 3e-6
    assert apart.min(axis=0).max() < 3e-6


def ends_of(dataset):
    """Return kind and both ends of each curve, that with the lower frequency first."""
    found = []
    for number in np.unique(dataset["curve_id"]):
        points = np.flatnonzero(dataset["curve_id"] == number)
        ends = sorted(
            (float(dataset["nu"][n]), float(dataset["f"][n])) for n in (points[0], points[-1])
        )
        found.append([float(dataset["boundary_kind"][points[0]]), *ends[0], *ends[1]])
    return np.array(found)


def test_a_branch_across_a_curve_meets_its_bifurcation_there(borders):
    assert count_crossed(EXCITER, borders) >= 10


def count_crossed(exciter, borders):
    """Return how many of some random points are bifurcations of the branch across their curve."""
    rng = np.random.default_rng(1)
    checked = 0
    stable = (borders["stable"].values == 1) & (borders["nu"].values < 2.9)
    inside = (
        (borders["f"].values > 0.15) & (borders["f"].values < 1.4) & (borders["nu"].values > 0.7)
    )
    for kind in ALL:
        code = Bifurcation[kind.upper()]
        candidates = np.flatnonzero((borders["boundary_kind"].values == code) & stable & inside)
        for n in rng.choice(candidates, 4, replace=False) if candidates.size else []:
            checked += crosses(exciter, borders, int(n), kind)
    return checked


def crosses(exciter, dataset, n, kind):
    """Return whether the branch next to a point meets its bifurcation at that force; either side has the orbit."""
    nu, f = float(dataset["nu"][n]), float(dataset["f"][n])
    x0, v0 = float(dataset["displacement_strobe"][n]), float(dataset["velocity_strobe"][n])
    for side in (1.0, -1.0):
        near = dataclasses.replace(exciter, nu=nu, f=f + side * 2e-3)
        if int(vp.steady_state(near, x0, v0).period_multiple) == 0:
            continue
        branch = vp.branch(near, "f", (f - 1e-2, f + 1e-2), x0, v0)
        at = branch["bifurcation_f"].values[
            branch["bifurcation_kind"].values == Bifurcation[kind.upper()]
        ]
        if np.abs(at - f).min(initial=math.inf) < 1e-9:
            return True
    return False


def test_borders_of_regimes_lie_on_curves(borders):
    """From no impact upwards, what settles on the linear motion leaves it on the curve of its grazing."""
    nu = np.linspace(0.7, 1.9, 13)
    force = np.linspace(0.05, 1.5, 291)
    rows = vp.sweep(EXCITER, over={"nu": nu, "f": force}, follow=("f", "up"))
    curve_nu, curve_f = of_law(borders, "grazing", 1, 0, 0)
    order = np.argsort(curve_nu)
    step = force[1] - force[0]
    for k, value in enumerate(nu):
        has_impacts = rows["regime"].values[k] != Regime.NO_IMPACT
        change = np.flatnonzero(np.diff(has_impacts))[0]
        at = np.interp(value, curve_nu[order], curve_f[order])
        # Each step of the force starts a transient, at most twice as large as the change that it decays to.
        assert force[change] - 1e-3 <= at <= force[change + 1] + step + 1e-3


def test_points_are_motions(borders):
    check_motions(EXCITER, borders)


def check_motions(base, borders):
    """No orbit on a curve leaves the supports: a motion from it stays on it for a period."""
    rng = np.random.default_rng(2)
    for n in rng.choice(borders.sizes["point"], 40, replace=False):
        exciter = dataclasses.replace(base, nu=float(borders["nu"][n]), f=float(borders["f"][n]))
        point = borders.isel(point=n)
        # At a grazing rounding decides whether the touch is an impact without speed.
        motion = motion_of(exciter, point, samples_per_period=8)
        grazes = int(point.boundary_kind) == Bifurcation.GRAZING
        moved = abs(float(motion.displacement[-1] - point.displacement_strobe))
        assert moved < (1e-4 if grazes else 1e-8)


def check_multipliers(dataset):
    """Check that the multipliers, from the saltation matrices, are those of the bifurcation."""
    multipliers = dataset["floquet_multiplier"].transpose("point", "multiplier").values
    kinds = dataset["boundary_kind"].values
    # At ends where an impact has no velocity the derivative is infinite, next to them it is large, and so its rounding.
    away = np.hypot(
        dataset["nu"].values[:, None] - dataset["meeting_nu"].values,
        dataset["f"].values[:, None] - dataset["meeting_f"].values,
    ).min(axis=1, initial=1.0)
    for kind, value in (("fold", 1.0), ("flip", -1.0), ("pitchfork", 1.0)):
        mask = (kinds == Bifurcation[kind.upper()]) & (away > 1e-3)
        product = np.abs(multipliers[mask].prod(axis=1))
        from_value = np.abs(multipliers[mask] - value).min(axis=1, initial=1.0)
        # A double multiplier, without losses, has half of the digits.
        assert np.max(from_value[product < 0.9], initial=0.0) < 1e-7


def test_multipliers_are_those_of_the_bifurcations(borders):
    check_multipliers(borders)


def largest_linear_displacement(exciter, nu, f):
    """Return the largest displacement without impacts, of samples and the parabola through the largest three."""
    phase = 2 * np.pi * np.arange(20_000) / 20_000
    h, response = exciter.h, 0.0
    for k, force in ((1, f), (2, exciter.f2 * np.exp(1j * exciter.phi2))):
        response += (force / (1 - (k * nu) ** 2 + 1j * k * h * nu) * np.exp(1j * k * phase)).imag
    x = np.abs(response)
    n = int(x.argmax())
    before, top, after = x[n - 1], x[n], x[(n + 1) % x.size]
    return top + (before - after) ** 2 / (8 * (2 * top - before - after))


@pytest.mark.slow
def test_under_two_harmonics_the_first_grazing_is_that_of_the_linear_motion(borders_of_two):
    nu, f = of_law(borders_of_two, "grazing", 1, 0, 0)
    assert nu.size > 50
    found = [largest_linear_displacement(TWO_HARMONICS, *each) for each in zip(nu, f, strict=True)]
    # The parabola has an error of 1e-12.
    np.testing.assert_allclose(found, TWO_HARMONICS.l, rtol=1e-11)


def test_under_two_harmonics_points_are_motions_with_their_bifurcations(borders_of_two):
    check_motions(TWO_HARMONICS, borders_of_two)
    check_multipliers(borders_of_two)
    assert count_crossed(TWO_HARMONICS, borders_of_two) >= 8
    kinds = {Bifurcation(int(kind)) for kind in borders_of_two["boundary_kind"].values}
    # Without a symmetry there are no pitchforks.
    assert kinds == {Bifurcation.FOLD, Bifurcation.FLIP, Bifurcation.GRAZING}


def test_a_multiplier_jumps_and_is_not_one_where_an_impact_begins_without_speed():
    """Along the grazing of (1; 0, 1) det(D - 1) is below -12: it grows without bound as the impact loses its speed."""
    exciter = dataclasses.replace(EXCITER, h=0.15)
    curves = vp.boundary(
        exciter, ["grazing", "fold", "flip"], ("nu", "f2"), ((0.8, 2.0), (0.0, 0.5)), lines=4
    )
    multipliers = {Meeting.GRAZING_FOLD: 1.0, Meeting.GRAZING_FLIP: -1.0}
    on_grazings = 0
    for kind, point in zip(curves.meeting_kind.values, curves.meeting_point.values, strict=True):
        one = curves.isel(point=int(point))
        if kind in multipliers and one.boundary_kind == Bifurcation.GRAZING:
            on_grazings += 1
            distance = np.abs(one.floquet_multiplier.values - multipliers[Meeting(kind)]).min()
            assert distance < 1e-6
    assert on_grazings >= 10
    own = (curves.boundary_kind == Bifurcation.GRAZING) & (curves.period_multiple == 1)
    own &= (curves.impacts_per_orbit == (0, 1)).all("support")
    met = np.isin(curves.meeting_point.values, np.flatnonzero(own.values))
    kinds = {Meeting(int(kind)).name for kind in curves.meeting_kind.values[met]}
    assert kinds == {"BOX", "DOUBLE_GRAZING"} or kinds == {"BOX"}


def test_a_second_harmonic_that_vanishes_has_the_curves_of_one():
    """The curve over f2 passes f2 = 0 at the force of the closed form."""
    exciter = dataclasses.replace(EXCITER, delta=-0.2, nu=1.4, phi2=0.6)
    found = vp.boundary(exciter, "grazing", ("f", "f2"), ((0.05, 1.0), (-0.2, 0.2)), lines=4)
    impacts = found["impacts_per_orbit"].transpose("point", "support").values
    first = (found["period_multiple"].values == 1) & (impacts == 0).all(axis=1)
    f, f2 = found["f"].values[first], found["f2"].values[first]
    order = np.argsort(f2)
    assert f2[order][0] == pytest.approx(-0.2)
    at = np.interp(0.0, f2[order], f[order])
    assert at == pytest.approx(float(linear_grazing(exciter, 1.4)), rel=1e-4)


@pytest.mark.slow
@settings(max_examples=6, deadline=None)
@given(
    h=st.floats(0.05, 0.6),
    R=st.floats(0.4, 0.9),
    delta=st.one_of(st.just(0.0), st.floats(-0.3, 0.3)),
)
def test_grazing_of_the_linear_motion_for_random_exciters(h, R, delta):
    exciter = vp.Exciter(l=0.5, h=h, delta=delta, R1=R, R2=R)
    found = vp.boundary(exciter, ALL, within=((0.8, 2.0), (0.05, 1.0)), lines=3)
    nu, f = of_law(found, "grazing", 1, 0, 0)
    assert nu.size > 5
    assert np.abs(f - linear_grazing(exciter, nu)).max() < 1e-10
    low = (found["nu"].values >= 0.8) & (found["nu"].values <= 2.0)
    assert low.all()
    assert np.all((found["f"].values >= 0.05) & (found["f"].values <= 1.0))
    check_multipliers(found)
    lost = found["meeting_kind"].values == Meeting.LOST
    assert not lost.any()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"of": "turn"}, "of: must be"),
        ({"of": ()}, "of: must be"),
        ({"of": "fold", "along": ("nu", "nu")}, "along: must be"),
        (
            {"of": "fold", "along": {"nu": (0.5, 1.0), "f": (0.1, 0.4)}},
            "along: must be two names in",
        ),
        ({"of": "fold", "within": ((1, 2), (3, 1))}, "within: must be"),
        ({"of": "fold", "within": ((0, 2), (1, 3))}, "within: must be"),
        ({"of": "fold", "lines": 0}, "lines: must be"),
        ({"of": "fold", "max_step": 1}, "max_step: must be"),
    ],
)
def test_bad_arguments_are_named(arguments, message):
    with pytest.raises(vp.ParameterError, match=message):
        vp.boundary(EXCITER, **arguments)


def test_a_second_harmonic_alone_is_refused():
    alone = dataclasses.replace(EXCITER, f=0.0, f2=0.3)
    with pytest.raises(vp.ParameterError, match=r"^f: must not be 0 beside f2: .* got 0\.0$"):
        vp.boundary(alone, "fold", ("nu", "h"), ((0.7, 2.0), (0.1, 0.4)))
