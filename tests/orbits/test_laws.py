"""Orbits by their laws: the equations against differences and marches, the elimination against a dense solution."""

from __future__ import annotations

import numpy as np
import pytest
from law_slopes import slopes

import vibropipe as vp
from vibropipe.march.piece_log import CAUSE, CONTACT, FORM, HOME, SLIP, STICK, TURN
from vibropipe.orbits.law import least as of
from vibropipe.orbits.law.beyond import has_passed
from vibropipe.orbits.law.curve import LawCurve
from vibropipe.orbits.law.elimination import Border, no_border, solve_columns, solve_cyclic
from vibropipe.orbits.law.flights import state_within
from vibropipe.orbits.law.following import follow_laws
from vibropipe.orbits.law.happenings import happenings, law_from
from vibropipe.orbits.law.marching import Marcher
from vibropipe.orbits.law.problem import Problem, Scales
from vibropipe.physics.effects import Effects
from vibropipe.physics.exciter import Parameters

SOFT = {"l": 0.5, "nu": 1.0, "f": 1.0, "h": 0.4, "k1": 100, "k2": 100, "h1": 3, "h2": 3}
EXCITERS = {
    "soft": SOFT,
    "soft and rigid": {"l": 0.5, "nu": 1.1, "f": 1.0, "h": 0.2, "k1": 200, "R2": 0.6, "delta": 0.03},
    "friction": {"l": 0.5, "nu": 1.0, "f": 1.0, "h": 0.2, "R1": 0.7, "R2": 0.7, "friction": 0.05},
    "stick": {"l": 1.0, "nu": 0.5, "f": 1.5, "h": 0.1, "R1": 0.7, "R2": 0.7, "friction": 0.4},
    "stick in contact": {"l": 1.0, "nu": 0.4, "f": 1.2, "h": 0.1, "k1": 50, "k2": 50, "friction": 0.5},
    "static": {"l": 1.0, "nu": 0.5, "f": 1.5, "h": 0.1, "R1": 0.7, "R2": 0.6, "friction": 0.3, "friction_ratio": 2},
    "static rest": {"l": 0.5, "nu": 0.3, "f": 0.9, "R1": 0.5, "R2": 0.4, "friction": 0.03, "friction_ratio": 2},
    "no pull": {"l": 0.5, "nu": 1.5, "f": 1.2, "h": 0.1, "k1": 200, "k2": 90, "h1": 4, "h2": 7, "friction": 0.1,
                "contact_1": 1, "contact_2": 1},
    "reload": {"l": 0.5, "nu": 2.25, "f": 0.5, "h": 0.2, "delta": 0.9, "k1": 20, "k2": 4, "h1": 5, "h2": 9, "f2": -1.9,
               "contact_2": 1},
    "no contact": {"l": 5.0, "nu": 0.6, "f": 0.5, "h": 0.1, "friction": 0.2},
    "rest": {"l": 0.5, "nu": 0.3, "f": 0.9, "h": 0.1, "R1": 0.6, "R2": 0.5, "friction": 0.03},
    "two harmonics": {"l": 0.5, "nu": 0.9, "f": 0.9, "h": 0.3, "k1": 80, "h1": 2, "R2": 0.6, "f2": 0.2, "phi2": 0.4},
}  # fmt: skip


@pytest.fixture(scope="module")
def marcher():
    return Marcher(Effects(soft=1, friction=1, second_harmonic=1, no_pull=1))


def point_of(name, marcher, along="nu", low=0.2, high=2.5):
    exciter = vp.Exciter(**EXCITERS[name])
    start = vp.steady_state(exciter)
    p = exciter.parameters()
    state = np.array([float(start.displacement_strobe), float(start.velocity_strobe)])
    symmetric = "R1" not in EXCITERS[name] or EXCITERS[name]["R1"] == EXCITERS[name].get("R2")
    symmetric = symmetric and not {"delta", "f2"} & set(EXCITERS[name])
    symmetric = symmetric and EXCITERS[name].get("k1") == EXCITERS[name].get("k2")
    read = marcher.law_of(p, state, int(start.period_multiple), symmetric)
    index = Parameters._fields.index(along)
    problem = Problem(np.array(p), index, low, high, (), symmetric, 0.02)
    curve = LawCurve(
        problem, read.law, Scales(float(start.displacement_amplitude.max()), 1.0), marcher
    )
    return curve, read, p, state


@pytest.mark.parametrize("name", EXCITERS)
def test_newton_returns_to_the_orbit_that_was_marched(name, marcher):
    curve, read, p, state = point_of(name, marcher)
    rng = np.random.default_rng(3)
    u = read.u.T.ravel()
    free = (np.abs(u) > 0.0) * (1.0 + 1e-4 * rng.standard_normal(u.size))
    point = curve.settle(np.append(u * free, p.nu))
    assert point is not None
    np.testing.assert_allclose(point.u[:-1], u, atol=2e-13)
    np.testing.assert_allclose(curve.state_at(point), state, atol=1e-12)


@pytest.mark.parametrize("name", EXCITERS)
def test_derivatives_of_the_equations_are_those_of_differences(name, marcher):
    _curve, (law, u), p, _state = point_of(name, marcher)
    for by, own, slope in slopes(marcher.effects, p, law, u):
        is_parameter = isinstance(by, str)
        if by == "friction_ratio" and p.friction_ratio == 1.0:
            continue  # a slip without a jump is divided by another power of its span
        if not is_parameter and by[1] == 1 and law.codes[by[0], CAUSE] in (SLIP, 8):
            continue  # has no second unknown
        scale = 1.0 if is_parameter else np.abs(own).max()
        np.testing.assert_allclose(slope, own, atol=1e-7 * scale, err_msg=str(by))


# Unknowns of an event without and with a housing, the effect of that, and the digits that are kept.
WIDTHS = [(2, None, 1e-9), (3, 1, 1e-8)]


def dense_of(before, at, wrap=1.0):
    """Return the matrix of cyclic blocks; the last event acts on the first by `wrap` times its block."""
    n, width = len(at), at.shape[1]
    dense = np.zeros((n, width, n, width))
    for i in range(n):
        dense[i, :, i] += at[i]
        dense[i, :, i - 1] += before[i] * (wrap if i == 0 else 1.0)
    return dense.reshape(width * n, width * n)


@pytest.mark.parametrize("n", [1, 2, 3, 16])
@pytest.mark.parametrize("k", [0, 1, 2])
@pytest.mark.parametrize(("width", "housing", "rtol"), WIDTHS)
def test_elimination_is_the_dense_solution(n, k, width, housing, rtol):
    rng, size = np.random.default_rng(n + 10 * k), width * n
    before, at = rng.standard_normal((2, n, width, width))
    by, rest = rng.standard_normal((n, width, k)), rng.standard_normal((n, width))
    borders, corner = rng.standard_normal((k, n, width)), rng.standard_normal((k, k))
    target, x, q = rng.standard_normal(k), np.empty((n, width)), np.empty(k)
    for wrap in (1.0, -1.0):
        dense = np.zeros((size + k, size + k))
        dense[:size, :size] = dense_of(before, at, wrap)
        dense[:size, size:] = by.reshape(size, k)
        dense[size:, :size], dense[size:, size:] = borders.reshape(k, size), corner
        further = Border(by, borders, corner, target)
        sign, log = solve_cyclic(before, at, rest, wrap, further, x, q, housing)
        solution = np.linalg.solve(dense, np.append(rest.ravel(), target))
        np.testing.assert_allclose(np.append(x.ravel(), q), solution, rtol=rtol, atol=rtol / 100)
        assert (sign, log) == pytest.approx(np.linalg.slogdet(dense), abs=1e-9)


@pytest.mark.parametrize("n", [1, 2, 3, 16])
@pytest.mark.parametrize(("width", "housing", "rtol"), WIDTHS)
def test_elimination_of_several_right_hand_sides_is_that_of_each(n, width, housing, rtol):
    rng, size = np.random.default_rng(n), width * n
    before, at = rng.standard_normal((2, n, width, width))
    rest, x = rng.standard_normal((n, width, 5)), np.empty((n, width, 5))
    solve_columns(before, at, rest, x, housing)
    expected = np.linalg.solve(dense_of(before, at), rest.reshape(size, 5))
    np.testing.assert_allclose(x.reshape(size, 5), expected, rtol=rtol, atol=rtol / 100)


def test_elimination_keeps_digits_of_what_grows_along_an_orbit():
    """A growth of 1e12 over 40 blocks, whose product of transfers has no digit of the start left."""
    n = 40
    before = np.tile(np.diag([-2.0, -0.5]), (n, 1, 1))
    at = np.tile(np.eye(2), (n, 1, 1))
    expected = np.random.default_rng(5).standard_normal((n, 2))
    rest = np.array([before[i] @ expected[i - 1] + at[i] @ expected[i] for i in range(n)])
    x = np.empty((n, 2))
    solve_cyclic(before, at, rest, 1.0, no_border(n, 2), x, np.zeros(0))
    np.testing.assert_allclose(x, expected, atol=1e-14)


@pytest.mark.parametrize("name", EXCITERS)
def test_events_without_frames_give_the_law_again(name, marcher):
    _curve, read, p, _state = point_of(name, marcher)
    law, u = read
    if name == "no contact":
        assert set(law.codes[:, CAUSE].tolist()) <= {int(TURN), int(STICK), int(SLIP)}
    made = law_from(happenings(law, p, u), p, law.span, law.mirrored)
    assert made is not None
    np.testing.assert_array_equal(made[0].codes[:, :3], law.codes[:, :3])
    np.testing.assert_allclose(made[1], u, atol=1e-15)


@pytest.mark.parametrize(
    ("name", "way"),
    [("soft", 1), ("soft", -1), ("soft and rigid", 1), ("soft and rigid", -1), ("stick", 1), ("stick in contact", 1)],
)  # fmt: skip
def test_orbits_of_all_laws_of_a_branch_return_when_marched(name, way, marcher):
    """A march from each orbit, stable or not, meets the events of its law and returns, but for rounding that grows."""
    curve, read, p, _state = point_of(name, marcher, low=0.3)
    start = curve.settle(np.append(read.u.T.ravel(), p.nu))
    path = follow_laws(curve, start if way > 0 else start.reversed(), False)
    assert sum(event.kind == "change" for event in path.events) >= 1
    # Along one branch contacts accumulate: laws of 39 to 44 events lie within 1e-8 of nu. Which of them comes next
    # depends on rounding, which differs between processors, and so does whether the path returns to a law it has had.
    assert path.end == "limit" or (name, way, path.end) == ("soft and rigid", -1, "closed")
    for point in path.points[:: max(1, len(path.points) // 60)]:
        own, at = point.curve, point.curve.parameters(point.value)
        state = own.state_at(point)
        returned = marcher.after(at, state, float(own.sequence.m))
        growth = 1.0 + np.abs(point.tests[4]) ** (2 if own.sequence.mirrored else 1)
        np.testing.assert_allclose(returned, state, atol=1e-11 * growth)


def test_only_an_orbit_met_the_other_way_is_passed(marcher):
    """A branch that comes to its start in the same direction is closed, and goes on as before."""
    curve, read, p, _state = point_of("soft and rigid", marcher, low=0.9)
    path = follow_laws(curve, curve.settle(np.append(read.u.T.ravel(), p.nu)).reversed(), False)
    assert len({point.curve for point in path.points}) > 1
    for n in (3, len(path.points) // 2, len(path.points) - 4):
        point = path.points[n]
        assert not has_passed(path.points, point)
        assert has_passed(path.points, point.reversed())
        assert not has_passed(path.points[: n - 1], point.reversed())


def turns_within(curve, point, i, end, n=40_001):
    """Return the displacements at which a piece turns, in its frame, and whether from upwards, by dense samples."""
    p, u = curve.parameters_of(point.u), curve.events_of(point.u)
    times = np.linspace(u[i, 0], end, n)
    y, w = np.array(
        [state_within(curve.effects, p, curve.sequence, i, u, time) for time in times[1:-1]]
    ).T
    at = np.flatnonzero(w[:-1] * w[1:] < 0.0)
    return [(max(y[k : k + 2]) if w[k] > 0.0 else min(y[k : k + 2]), w[k] > 0.0) for k in at]


@pytest.mark.parametrize("h1", [1e2, 1e4, 1e6, 1e7])
def test_margins_of_contacts_far_slower_than_their_rates_are_those_of_samples(h1, marcher):
    """A contact whose fastest rate is h1 lasts half a period, and its depth turns twice in it."""
    exciter = vp.Exciter(l=0.5, nu=0.3, f=1.0, h=0.3, k1=0.7, h1=h1, R2=0.6, f2=2.5, phi2=0.4)
    start = vp.steady_state(exciter)
    p = exciter.parameters()
    state = np.array([float(start.displacement_strobe), float(start.velocity_strobe)])
    read = marcher.law_of(p, state, int(start.period_multiple), False)
    problem = Problem(np.array(p), Parameters._fields.index("nu"), 0.2, 0.4, (), False, 0.02)
    curve = LawCurve(problem, read.law, Scales(1.0, 1.0), marcher)
    point = curve.settle(np.append(read.u.T.ravel(), p.nu))
    codes, ends = (
        read.law.codes,
        np.append(point.u[1 : len(read.law.codes)], point.u[0] + read.law.span),
    )
    least = np.inf
    for i, end in enumerate(ends):
        home, in_contact = codes[i, HOME], codes[i, FORM] == CONTACT
        for y, was_rising in turns_within(curve, point, i, end):
            if in_contact:
                least = min(least, -y if was_rising else np.inf)
            elif home == 0:
                least = min(least, 0.5 - y if was_rising else y + 0.5)
            else:
                least = min(least, 1.0 - y if was_rising else y)
    assert curve.system.margins[of.GAP, of.VALUE] == pytest.approx(least, rel=1e-6)


@pytest.mark.parametrize(
    ("load", "f", "nu"),
    [(1.3, 1.5, 0.27), (1.0, -1.2, 0.3)],
    ids=["phase 0 in the chatter", "phase 0 in the rest"],
)
def test_an_orbit_that_rests_has_its_section_there(load, f, nu):
    exciter = vp.Exciter(l=0.5, nu=nu, f=f, h=0.1, R1=0.6, R2=0.5, friction=0.03, load=load)
    branch = vp.branch(exciter, "nu", (0.9 * nu, 1.1 * nu), at=(nu,))
    marched = vp.steady_state(exciter)
    point = branch.isel(point=int(np.abs(branch.nu.values - nu).argmin()))
    assert float(point.nu) == nu
    for name in ("displacement_strobe", "velocity_strobe"):
        assert float(point[name]) == pytest.approx(float(marched[name]), abs=1e-12)
    np.testing.assert_array_equal(branch.rests_per_orbit[:, 0], 1)


def test_impacts_that_are_counted_of_a_chatter_are_no_change():
    """Towards the border of its rests more impacts of a chatter are counted, 3, 9 and 10, of one motion."""
    exciter = vp.Exciter(l=0.5, nu=0.3, f=0.9, h=0.1, R1=0.6, R2=0.5, friction=0.03)
    branch = vp.branch(exciter, "nu", (0.25, 0.3734))
    assert branch.sizes["bifurcation"] == 0
    assert np.ptp(branch.nu.values) == pytest.approx(0.1234)
    np.testing.assert_array_equal(branch.rests_per_orbit, 1)
    beyond = vp.branch(exciter, "nu", (0.25, 0.38))
    assert beyond.sizes["bifurcation"] > 0
