"""Level curves in two parameters: against closed forms, steady states, sweeps, and themselves."""

from __future__ import annotations

import dataclasses

import numpy as np
import pint
import pytest

import vibropipe as vp
from vibropipe.words.bifurcations import Meeting

EXCITER = vp.Exciter(l=0.5, h=0.2, R1=0.7, R2=0.7)
BOX = ((0.6, 3.0), (0.05, 1.5))
SPEED = 0.5
LEVEL = 4


@pytest.fixture(scope="module")
def struck():
    return vp.boundary(EXCITER, ["fold", {"impact_velocity_max_1": SPEED}], within=BOX, lines=6)


def levels(dataset, number=0):
    return dataset.isel(point=dataset["level_of"].values == number)


def settled(exciter, point, **options):
    """Return the steady state from the orbit of a point."""
    own = {name: float(point[name]) for name in point.coords if name in vars(exciter)}
    return vp.steady_state(
        dataclasses.replace(exciter, **own),
        x0=float(point.displacement_strobe),
        v0=float(point.velocity_strobe),
        **options,
    )


def stable_points(dataset, amount):
    places = np.flatnonzero(dataset["stable"].values == 1)
    return [dataset.isel(point=n) for n in places[:: max(1, places.size // amount)]]


def test_the_motion_without_impacts_has_its_closed_form():
    amplitude = 0.3
    found = vp.boundary(EXCITER, {"displacement_amplitude_1": amplitude}, within=BOX, lines=3)
    free = found.isel(point=found.impacts_per_orbit.sum("support").values == 0)
    expected = amplitude * np.hypot(1 - free.nu**2, EXCITER.h * free.nu)
    assert free.sizes["point"] > 50
    assert float(np.abs(free.f - expected).max()) < 1e-12
    assert (free.boundary_kind == LEVEL).all()
    # from one side of the box to the other
    assert float(free.nu.min()) == 0.6
    assert float(free.f.max()) == 1.5


def test_an_ellipse_is_closed_and_found_once():
    exciter = vp.Exciter(l=5.0, h=0.3, nu=0.7)
    found = vp.boundary(
        exciter, {"frame_force_rms": 0.5}, ("load", "f"), ((-1.0, 1.0), (-1.0, 1.1)), lines=3
    )
    assert np.unique(found.curve_id).size == 1
    assert found.sizes["meeting"] == 0
    load, force = found["load"].values, found["f"].values
    # x'' acts on the frame, and the load
    reaction = exciter.nu**2 * force / np.hypot(1 - exciter.nu**2, exciter.h * exciter.nu)
    assert np.abs(np.sqrt(load**2 + reaction**2 / 2) - 0.5).max() < 1e-12
    angles = np.unwrap(np.arctan2(force, load))
    assert abs(abs(angles[-1] - angles[0]) - 2 * np.pi) < 1e-9


def test_the_symmetric_orbit_has_its_closed_form(struck):
    found = levels(struck)
    speeds = found["impact_velocity_max"].transpose("point", "support").values
    assert np.abs(speeds[:, 0] - SPEED).max() < 1e-10
    for n in range(0, found.sizes["point"], 7):
        at = dataclasses.replace(EXCITER, nu=float(found.nu[n]), f=float(found.f[n]))
        closed = np.abs(vp.symmetric_orbit(at).impact_velocity.values)
        if np.isnan(closed).all():  # right at the fold, where rounding decides whether there is one
            folds = vp.symmetric_orbit_boundaries(EXCITER, at.nu)
            assert float(folds.fold_f[0]) == pytest.approx(at.f, rel=1e-12)
            closed = folds.fold_velocity.values
        assert np.nanmin(np.abs(closed - SPEED)) < 1e-9
    # it passes a fold, where its orbit becomes unstable and both curves touch
    assert set(found.stable.values) == {0, 1}
    at_fold = int(struck.meeting_point[struck.meeting_kind.values == Meeting.FOLD][0])
    folds = struck.isel(point=struck.level_of.values == -1)
    there = struck.isel(point=at_fold)
    distance = np.hypot(folds.nu - there.nu, folds.f - there.f)
    assert float(distance.min()) < 0.02


def test_every_point_is_that_of_a_steady_state(struck):
    points = stable_points(levels(struck), 12)
    assert len(points) >= 12
    for point in points:
        steady = settled(EXCITER, point)
        assert abs(float(steady.impact_velocity_max[0]) - SPEED) < 1e-9


def test_a_sweep_crosses_no_level_that_is_not_a_curve():
    speed, box = 1.2, ((0.8, 2.8), (0.6, 1.5))
    found = vp.boundary(EXCITER, {"impact_velocity_max_1": speed}, within=box, lines=8)
    nu, f = np.linspace(*box[0], 21)[1:-1], np.linspace(*box[1], 91)
    rows = vp.sweep(EXCITER, {"nu": nu, "f": f}).transpose("nu", "f", ...)
    missed = rows.impact_velocity_max.sel(support=1).values - speed
    same = (rows.period_multiple.values[:, 1:] == rows.period_multiple.values[:, :-1]) & (
        rows.impacts_per_orbit.values[:, 1:] == rows.impacts_per_orbit.values[:, :-1]
    ).all(axis=2)
    # one law goes on between two neighbours, and its speed is continuous
    near = np.abs(np.diff(missed, axis=1)) < 0.05
    crossed = np.argwhere((missed[:, 1:] > 0) & (missed[:, :-1] < 0) & same & near)
    assert len(crossed) > 8
    for i, j in crossed:
        share = missed[i, j] / (missed[i, j] - missed[i, j + 1])
        at = f[j] + share * (f[j + 1] - f[j])
        assert float(np.hypot(found.nu - nu[i], found.f - at).min()) < 0.05


@pytest.mark.slow
def test_a_symmetric_exciter_has_both_images():
    ones = [
        vp.boundary(EXCITER, {name: value}, within=BOX, lines=6)
        for name, value in (
            ("displacement_mean", 0.05), ("displacement_mean", -0.05),
            ("impact_velocity_max_1", 1.2), ("impact_velocity_max_2", 1.2),
        )
    ]  # fmt: skip
    for first, second in (ones[:2], ones[2:]):
        assert first.sizes["point"] > 50
        np.testing.assert_allclose(first.nu, second.nu, atol=1e-9)
        np.testing.assert_allclose(first.f, second.f, atol=1e-9)
    for found, mean in zip(ones[:2], (0.05, -0.05), strict=True):
        for point in stable_points(found, 5):
            assert abs(float(settled(EXCITER, point).displacement_mean) - mean) < 1e-9


@pytest.mark.parametrize(
    ("exciter", "level", "box", "kind"),
    [
        (
            vp.Exciter(l=0.5, h=0.1, delta=-0.3, R1=0.8, R2=0.8),
            {"energy_damping": 0.15},
            ((1.4, 2.8), (0.3, 1.5)),
            Meeting.FLIP,
        ),
        (EXCITER, {"impact_velocity_max_1": 0.9}, ((1.0, 1.6), (0.5, 1.5)), Meeting.PITCHFORK),
        (EXCITER, {"energy_damping": 0.3}, ((1.0, 1.6), (0.5, 1.5)), Meeting.PITCHFORK),
    ],
)  # fmt: skip
def test_doubled_orbits_end_on_the_curve_of_their_parent(exciter, level, box, kind):
    found = vp.boundary(exciter, level, within=box, lines=6)
    of_kind = found.meeting_kind.values == kind
    points, ends = found.meeting_point.values[of_kind], found.meeting_ends.values[of_kind]
    assert (ends == 1).any()
    shared = 2 if kind == Meeting.FLIP else 1
    for n in points[ends == 1]:
        child = found.isel(point=n)
        near = [
            p
            for p in points[ends == 0]
            if shared * int(found.period_multiple[p]) == int(child.period_multiple)
            and np.hypot(found.nu[p] - child.nu, found.f[p] - child.f) < 1e-8
        ]
        assert len(near) == 1
    # None goes there and back again, and none is there twice as its own mirror image.
    places = np.column_stack([found.nu, found.f])
    inner = ~np.isin(np.arange(found.sizes["point"]), found.meeting_point)
    ids = found.curve_id.values
    for n in np.flatnonzero(inner):
        apart = np.hypot(*(places - places[n]).T)
        others = (ids != ids[n]) | (np.abs(np.arange(ids.size) - n) > 3)
        assert apart[others & inner].min() > 1e-6


def test_a_law_keeps_its_curves():
    whole = vp.boundary(EXCITER, {"impact_velocity_max_1": 1.2}, within=BOX, lines=6)
    kept = vp.boundary(EXCITER, {"impact_velocity_max_1": 1.2}, within=BOX, lines=6, law=(2, 2, 2))
    other = vp.boundary(EXCITER, {"impact_velocity_max_1": 1.2}, within=BOX, lines=6, law=(1, 2, 2))
    assert kept.sizes["point"] == 0
    twice = whole.isel(point=whole.impacts_per_orbit.sel(support=1).values == 2)
    assert twice.sizes["point"] > 10
    np.testing.assert_array_equal(other.nu, twice.nu)


def test_soft_supports_and_friction_have_levels():
    soft = vp.Exciter(l=0.5, h=0.2, k1=20.0, R1=0.7, k2=20.0, R2=0.7, friction=0.02)
    wanted = {"support_force_max_1": 3.0, "energy_friction": 0.05}
    found = vp.boundary(soft, [wanted], within=((1.2, 1.8), (0.3, 0.8)), lines=2)
    for number, (name, value) in enumerate(wanted.items()):
        points = stable_points(levels(found, number), 5)
        assert len(points) >= 5
        for point in points:
            steady = settled(soft, point)
            reached = steady[name.removesuffix("_1")].values.ravel()[0]
            assert abs(float(reached) - value) < 1e-9


def test_a_symmetric_housing_does_not_progress():
    housing = vp.Exciter(
        l=0.5, h=0.3, R1=0.6, R2=0.6, mass_ratio=0.3, housing_friction_1=0.1,
        housing_friction_2=0.1, nu=1.2,
    )  # fmt: skip
    found = vp.boundary(
        housing,
        {"housing_velocity_mean": 0.0},
        ("delta", "f"),
        ((-0.02, 0.015), (1.12, 1.4)),
        lines=2,
    )
    # A curve ends where slips change; together they are the line of symmetry, and no region has a curve.
    assert np.abs(found.delta).max() < 1e-9
    ends = [float(found.f.min()), float(found.f.max())]
    assert ends == [1.12, 1.4]
    gaps = np.diff(np.sort(found.f.values))
    assert gaps.max() < 0.01
    for point in stable_points(found, 4):
        assert abs(float(settled(housing, point).housing_velocity_mean)) < 1e-9
    beside = found.isel(point=found.sizes["point"] // 2)
    signs = [
        float(
            settled(
                dataclasses.replace(housing, f=float(beside.f)), beside.assign_coords(delta=d)
            ).housing_velocity_mean
        )
        for d in (-0.005, 0.005)
    ]
    assert signs[0] * signs[1] < 0.0


def test_levels_have_units():
    units = pint.UnitRegistry()
    exciter = vp.Exciter.from_physical(
        m="0.2 kg", C="8 N/mm", H="4 N s/m", l="3 mm", R1=0.6, R2=0.6, F="20 N", omega="40 Hz"
    )
    ranges = (("24 Hz", "60 Hz"), ("3 N", "30 N"))
    found = vp.boundary(
        exciter, {"impact_velocity_max_1": "600 mm/s"}, ("omega", "F"), ranges, lines=3
    )
    other = vp.boundary(
        exciter, {"impact_velocity_max_1": 0.6 * units.m / units.s}, ("omega", "F"), ranges, lines=3
    )
    assert found.identical(other)
    assert found.attrs["levels"] == "impact_velocity_max_1 = 0.6 m s-1"
    assert found.sizes["point"] > 20
    np.testing.assert_allclose(found.impact_velocity_max.sel(support=1), 0.6, rtol=1e-10)


@pytest.mark.parametrize(
    ("of", "message"),
    [
        ([{}], "of: must be one or some of fold, flip, pitchfork, grazing, and of quantities"),
        ([{"impact_velocity_max": 1}], "of: must be one of impact_velocity_max_1, impact_velocity_max_2"),
        ({"impact_velocty_max_1": 1}, "did you mean 'impact_velocity_max_1'"),
        ({"impact_velocity_max_1": -1}, "of.impact_velocity_max_1: must be >= 0, since"),
        ({"impact_velocity_max_1": 0}, "of.impact_velocity_max_1: must be > 0, since"),
        ({"impact_velocity_max_1": "0.8 m/s"}, "of.impact_velocity_max_1: must be a finite number"),
        ({"h": 0.1}, "of: must be a quantity of the motion"),
        ({"period_multiple": 2}, "of: must depend continuously on the parameters"),
        ({"lyapunov_exponent": 0.1}, "of: must be a quantity that points of branches have"),
        ({"housing_velocity_mean": 0}, "mass_ratio: must be above 0, since housing_velocity_mean is wanted"),
        ({"support_force_max_1": 1}, "k1: must be above 0, since support_force_max_1 is wanted"),
    ],
)  # fmt: skip
def test_a_wrong_level_is_refused_in_words(of, message):
    with pytest.raises(vp.ParameterError) as error:
        vp.boundary(EXCITER, of)
    assert message in str(error.value)
