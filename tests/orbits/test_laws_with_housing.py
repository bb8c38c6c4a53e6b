"""Orbits by their laws beside a housing that slides: references, differences, marches, and a dense elimination."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from comparisons import REFERENCE
from housings import FREE, RESTING, RUBBED, SECTION, STOPPED, SYMMETRIC, exciter_of
from law_slopes import slopes

import vibropipe as vp
from vibropipe.march.piece_log import CAUSE, HOUSING_SLIP, HOUSING_STOP, REST_BEGINS
from vibropipe.orbits.law import least as of
from vibropipe.orbits.law.curve import LawCurve
from vibropipe.orbits.law.determinants import pair_share, return_map_of_three
from vibropipe.orbits.law.equations import fill_blocks, new_blocks
from vibropipe.orbits.law.following import follow_laws
from vibropipe.orbits.law.happenings import happenings, law_from
from vibropipe.orbits.law.law import WAY
from vibropipe.orbits.law.marching import Marcher
from vibropipe.orbits.law.problem import Problem, Scales
from vibropipe.orbits.law.steps import SPEED
from vibropipe.physics.effects import Effects
from vibropipe.physics.exciter import Parameters
from vibropipe.solve.branch.problem import is_symmetric

REFERENCES = json.loads((REFERENCE / "housing.json").read_text())["steady"]
STUCK = vp.Exciter(
    l=1.0, nu=0.5, f=1.5, h=0.1, R1=0.7, R2=0.7, mass_ratio=0.5, housing_friction_1=0.3,
    housing_friction_2=0.35, friction=0.4, load=0.02,
)  # fmt: skip
RESTS = {
    "resting": RESTING,
    "stopped": STOPPED,
    "stopped and rubbed": replace(STOPPED, friction=0.04, friction_ratio=1.5),
    "mirrored rests": replace(
        SYMMETRIC, l=0.5, nu=0.4, housing_friction_1=0.05, housing_friction_2=0.05
    ),
}
EXCITERS = {
    **{f"reference {i}": exciter_of(entry) for i, entry in enumerate(REFERENCES)},
    "symmetric": SYMMETRIC,
    "rubbed": RUBBED,
    "stuck": STUCK,
    "free": FREE,
    **RESTS,
}


@pytest.fixture(scope="module")
def marcher():
    return Marcher(Effects(soft=1, friction=1, housing=1, second_harmonic=1))


def orbit_of(name, marcher, along="nu", low=0.2, high=4.0):
    """Return the branch of the law of a steady state, what was read of that, the parameters, and its section."""
    exciter = EXCITERS[name]
    start = vp.steady_state(exciter)
    p = exciter.parameters()
    state = np.array([float(start[each]) for each in SECTION]) - [exciter.load, 0.0, 0.0]
    read = marcher.law_of(p, state, int(start.period_multiple), is_symmetric(exciter))
    index = Parameters._fields.index(along)
    problem = Problem(
        np.array(p), index, low, high, (), is_symmetric(exciter), 0.02, marcher.effects
    )
    size = float(start.displacement_amplitude.max())
    return LawCurve(problem, read.law, Scales(size, 1.0), marcher), read, p, state, start


@pytest.mark.parametrize("i", range(len(REFERENCES)))
def test_newton_converges_to_the_reference_with_the_square_of_its_error(i, marcher):
    entry = REFERENCES[i]
    exciter = EXCITERS[f"reference {i}"]
    p = exciter.parameters()
    expected = np.array([float(entry[each]) for each in ("x", "v", "housing_velocity")])
    read = marcher.law_of(p, expected, 1, False)
    problem = Problem(np.array(p), 0, 0.2, 5.0, (), False, 0.02, marcher.effects)
    curve = LawCurve(problem, read.law, Scales(0.5, 1.0), marcher)
    u = read.u.T.ravel()
    noise = np.random.default_rng(3).standard_normal(u.size)
    disturbed = np.append(u * (1.0 + 1e-4 * noise), p.nu)
    curve.work.border[:] = 0.0
    curve.work.border[-1] = 1.0
    sizes = []
    for _ in range(4):
        step = curve.step(disturbed, p.nu)
        sizes.append(float(np.abs(step * curve.weights).max()))
        disturbed = disturbed - step
    assert sizes[2] < 1e3 * sizes[1] ** 2 + 1e-13
    assert sizes[3] < 1e-13
    point = curve.settle(disturbed)
    np.testing.assert_allclose(curve.state_at(point), expected, atol=2e-15)


@pytest.mark.parametrize("name", EXCITERS)
def test_newton_returns_to_the_orbit_that_was_marched(name, marcher):
    curve, read, p, state, _start = orbit_of(name, marcher)
    assert read.law.codes[:, WAY].any()
    u = read.u.T.ravel()
    noise = np.random.default_rng(3).standard_normal(u.size)
    point = curve.settle(np.append(u * (1.0 + 1e-5 * noise), p.nu))
    assert point is not None
    np.testing.assert_allclose(point.u[:-1], u, atol=5e-12)
    np.testing.assert_allclose(curve.state_at(point), state, atol=5e-12)


@pytest.mark.parametrize("name", EXCITERS)
def test_derivatives_of_the_equations_are_those_of_differences(name, marcher):
    _curve, (law, u), p, _state, _start = orbit_of(name, marcher)
    for by, own, slope in slopes(marcher.effects, p, law, u):
        if not isinstance(by, str) and u[by] == 0.0 and not slope.any():
            # An event without this number: an equation of its own says so, and nothing else.
            assert np.sort(np.abs(own).ravel())[-2:].tolist() == [0.0, 1.0]
            continue
        scale = max(1.0, np.abs(slope).max()) if isinstance(by, str) else np.abs(own).max()
        np.testing.assert_allclose(slope, own, atol=2e-7 * scale, err_msg=str(by))


@pytest.mark.parametrize("name", EXCITERS)
def test_multipliers_are_those_of_the_marched_return_map(name, marcher):
    _curve, (law, u), p, _state, start = orbit_of(name, marcher)
    blocks = new_blocks(len(u), 0, 1)
    fill_blocks(marcher.effects, p, law, u, np.zeros(0, np.int64), blocks)
    matrix, minors, determinant = return_map_of_three(blocks.before, blocks.at)
    found = np.linalg.eigvals(matrix) ** (1 + law.mirrored)
    for each in start.floquet_multiplier.values:
        assert np.abs(found - each).min() < 1e-10
    one, two, three = np.linalg.eigvals(matrix)
    assert minors == pytest.approx((one * two + one * three + two * three).real, abs=1e-12)
    assert determinant == pytest.approx((one * two * three).real, abs=1e-12)


@pytest.mark.parametrize("name", EXCITERS)
def test_events_without_frames_give_the_law_again(name, marcher):
    _curve, (law, u), p, _state, _start = orbit_of(name, marcher)
    made = law_from(happenings(law, p, u), p, law.span, law.mirrored)
    assert made is not None
    np.testing.assert_array_equal(made[0].codes, law.codes)
    np.testing.assert_allclose(made[1], u, atol=1e-15)


def test_a_return_map_of_random_blocks_has_the_invariants_of_the_product():
    rng = np.random.default_rng(7)
    before, at = rng.standard_normal((2, 5, 3, 3))
    matrix, minors, determinant = return_map_of_three(before, at)
    product = np.eye(3)
    for i in (1, 2, 3, 4, 0):
        product = -np.linalg.solve(at[i], before[i] @ product)
    np.testing.assert_allclose(matrix, product, rtol=1e-9)
    values = np.linalg.eigvals(product)
    expected = (np.sum(values) ** 2 - np.sum(values**2)).real / 2.0
    assert minors == pytest.approx(expected, rel=1e-8)
    assert determinant == pytest.approx(np.prod(values).real, rel=1e-8)


@pytest.mark.parametrize("angle", [0.3, 1.4, 2.9])
@pytest.mark.parametrize("third", [-0.7, 0.0, 0.4])
def test_a_pair_on_the_unit_circle_is_a_zero(angle, third):
    def share(radius):
        values = np.array([radius * np.exp(1j * angle), radius * np.exp(-1j * angle), third])
        minors = (np.sum(values) ** 2 - np.sum(values**2)).real / 2.0
        return pair_share(np.sum(values).real, minors, np.prod(values).real)

    assert share(1.0) == pytest.approx(0.0, abs=1e-15)
    assert share(0.99) > 0.0 > share(1.01)


@pytest.mark.parametrize("order", [1, 2])
def test_the_equation_of_a_short_slide_is_divided_by_its_time(order, marcher):
    """The quotient by powers is that of the difference, at spans where both keep digits; below it stays regular."""
    _curve, (law, u), p, _state, _start = orbit_of("reference 2", marcher)
    kinds = law.codes[:, CAUSE]
    begun = HOUSING_SLIP if order == 2 else HOUSING_STOP
    i = next(i for i in range(1, len(kinds)) if kinds[i] == HOUSING_STOP and kinds[i - 1] == begun)
    blocks, none = new_blocks(len(u), 0, 1), np.zeros(0, np.int64)
    period = 2.0 * np.pi / p.nu

    def equation(turns):
        v = u.copy()
        v[i, 0] = v[i - 1, 0] + turns
        fill_blocks(marcher.effects, p, law, v, none, blocks)
        return blocks.rest[i, 2]

    # Below and above the time from which on powers are summed: one smooth function.
    turns = np.linspace(0.01, 0.12, 45)
    values = np.array([equation(each) for each in turns])
    smooth = np.polynomial.Polynomial.fit(turns, values, 14)
    np.testing.assert_allclose(values, smooth(turns), atol=1e-10 * np.abs(values).max())
    tiny = np.array([equation(each) for each in (1e-6, 1e-9, 1e-12, 0.0)])
    np.testing.assert_allclose(tiny, tiny[-1], atol=1e-4 * np.abs(values).max() * period)
    assert np.isfinite(tiny).all()
    assert tiny[-1] != 0.0


@pytest.mark.parametrize(
    "name", ["reference 0", "reference 2", "symmetric", "rubbed", "free", *RESTS]
)
@pytest.mark.parametrize("way", [1, -1])
def test_orbits_of_all_laws_of_a_branch_return_when_marched(name, way, marcher):
    """A march from each orbit, stable or not, meets the events of its law and returns, but for rounding that grows."""
    nu = EXCITERS[name].nu
    curve, read, p, _state, _start = orbit_of(name, marcher, low=0.8 * nu, high=1.25 * nu)
    start = curve.settle(np.append(read.u.T.ravel(), p.nu))
    path = follow_laws(curve, start if way > 0 else start.reversed(), False)
    for point in path.points[:: max(1, len(path.points) // 60)]:
        own, at = point.curve, point.curve.parameters(point.value)
        state = own.state_at(point)
        returned = marcher.after(at, state, float(own.sequence.m))
        growth = 1.0 + np.abs(point.tests[6]) ** (2 if own.sequence.mirrored else 1)
        # At a touch without velocity growth is infinite, or not known.
        assert np.isfinite(growth) or abs(point.tests[SPEED]) < 1e-12
        atol = 1e-10 * growth if np.isfinite(growth) else 1e-6
        np.testing.assert_allclose(returned, state, atol=atol)


def test_a_chatter_that_pushes_a_held_housing_off_is_not_read(marcher):
    """Each of its impacts moves the housing, which stops again: events without end, left to the march."""
    exciter = replace(SYMMETRIC, l=0.5, nu=0.3, housing_friction_1=0.5, housing_friction_2=0.5)
    start = vp.steady_state(exciter)
    assert float(start.rests_per_orbit.sum()) > 0.0
    state = np.array([float(start[each]) for each in SECTION])
    assert marcher.law_of(exciter.parameters(), state, int(start.period_multiple), True) is None


@pytest.mark.parametrize("name", RESTS)
def test_margins_of_an_orbit_that_rests_are_positive(name, marcher):
    curve, read, p, _state, _start = orbit_of(name, marcher)
    assert REST_BEGINS in read.law.codes[:, CAUSE]
    assert curve.settle(np.append(read.u.T.ravel(), p.nu)) is not None
    assert (curve.system.margins[: of.KINDS, of.VALUE] > 0.0).all()


def test_a_branch_of_orbits_that_rest_meets_steady_states_of_its_points():
    """Settled motions of exciters of the branch are its points, through rests that begin, stop and end."""
    branch = vp.branch(STOPPED, "nu", (0.35, 0.52), at=np.linspace(0.36, 0.51, 7))
    compared = 0
    for nu in np.linspace(0.36, 0.51, 7):
        points = branch.isel(point=np.flatnonzero((branch.nu == nu) & (branch.stable == 1)))
        settled = vp.steady_state(replace(STOPPED, nu=float(nu)))
        for k in range(points.sizes["point"]):
            point = points.isel(point=k)
            if abs(float(point.displacement_strobe - settled.displacement_strobe)) > 1e-3:
                continue  # another attractor
            compared += 1
            np.testing.assert_array_equal(point.rests_per_orbit, settled.rests_per_orbit)
            for each in (*SECTION, "housing_velocity_mean"):
                assert float(point[each]) == pytest.approx(float(settled[each]), abs=1e-12)
    assert compared >= 5
    assert (branch.rests_per_orbit.sum("support") > 0.0).any()
