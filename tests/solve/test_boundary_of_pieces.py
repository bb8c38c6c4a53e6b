"""Boundaries of orbits in closed form and of orbits by pieces, against motions on both sides."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

import vibropipe as vp
from vibropipe.orbits.boundaries import search
from vibropipe.words.bifurcations import Bifurcation, Meeting

SOFT = vp.Exciter(l=0.5, h=0.1, nu=1.0, f=0.5, k1=50.0, k2=50.0, h1=1.0, h2=1.0)
RUBBED = vp.Exciter(l=0.5, h=0.1, nu=1.0, f=0.5, R1=0.7, R2=0.7, friction=0.1)
BOX = ((0.5, 1.5), (0.1, 1.0))
ALL = ("fold", "flip", "pitchfork", "grazing")


@pytest.fixture(scope="module", params=["soft", "rubbed"])
def found(request):
    exciter = {"soft": SOFT, "rubbed": RUBBED}[request.param]
    return exciter, vp.boundary(exciter, ALL, within=BOX, lines=3)


def at_point(exciter, dataset, n, **changed):
    """Return the exciter at a point, and the orbit's state at the section."""
    values = {name: float(dataset[name][n]) for name in ("nu", "f")}
    state = np.array([float(dataset[f"{name}_strobe"][n]) for name in ("displacement", "velocity")])
    return dataclasses.replace(exciter, **{**values, **changed}), state


def end_of(exciter, state, m):
    """Return (x, x') after m periods, by a march."""
    motion = vp.simulate(exciter, m * exciter.period, *state, samples_per_period=0)
    return np.array([float(motion["displacement_end"]), float(motion["velocity_end"])])


def points_of(dataset, kinds, count):
    """Return some points of some kinds, away from where curves end."""
    code = [Bifurcation[kind.upper()] for kind in kinds]
    away = np.hypot(
        dataset["nu"].values[:, None] - dataset["meeting_nu"].values,
        dataset["f"].values[:, None] - dataset["meeting_f"].values,
    ).min(axis=1, initial=1.0)
    candidates = np.flatnonzero(np.isin(dataset["boundary_kind"].values, code) & (away > 0.03))
    return np.random.default_rng(1).choice(candidates, count, replace=False)


def test_orbits_have_the_multiplier_of_their_bifurcation(found):
    """Fourth-order differences of marched motions know nothing of saltation matrices, nor of given events."""
    exciter, borders = found
    for n in points_of(borders, ("fold", "flip", "pitchfork"), 12):
        there, state = at_point(exciter, borders, n)
        m, derivative = int(borders["period_multiple"][n]), np.empty((2, 2))
        assert np.abs(end_of(there, state, m) - state).max() < 1e-8
        for column in range(2):
            step = np.zeros(2)
            step[column] = 1e-7  # next to slow contacts derivatives change within 1e-6
            derivative[:, column] = sum(
                factor * end_of(there, state + k * step, m)
                for k, factor in ((1, 8.0), (-1, -8.0), (2, -1.0), (-2, 1.0))
            ) / (12.0 * step[column])
        trace, determinant = np.trace(derivative), np.linalg.det(derivative)
        is_flip = int(borders["boundary_kind"][n]) == Bifurcation.FLIP
        condition = 1.0 + determinant + (trace if is_flip else -trace)
        assert abs(condition) < 1e-5 * (1.0 + abs(trace) + abs(determinant))
        multipliers = np.linalg.eigvals(derivative)
        stored = borders["floquet_multiplier"].transpose("point", "multiplier").values[n]
        # A double multiplier has half of the digits.
        assert np.abs(multipliers.sum() - stored.sum()) < 1e-5 * (1.0 + abs(trace))


def test_an_orbit_at_a_grazing_turns_on_a_support(found):
    """Of a sampled motion, one extreme is on a support, and no impact is there."""
    exciter, borders = found
    for n in points_of(borders, ("grazing",), 16):
        there, state = at_point(exciter, borders, n)
        m = int(borders["period_multiple"][n])
        motion = vp.simulate(there, m * there.period, *state, samples_per_period=4000)
        x = np.abs(motion["displacement"].values)
        k = 1 + np.flatnonzero((x[1:-1] >= x[:-2]) & (x[1:-1] > x[2:]))
        tops = x[k] + (x[k - 1] - x[k + 1]) ** 2 / (8.0 * (2.0 * x[k] - x[k - 1] - x[k + 1]))
        assert np.abs(tops - exciter.l).min() < 3e-7  # friction jumps there
        stated = borders["impacts_per_orbit"].transpose("point", "support").values[n].sum()
        assert (np.abs(motion["impact_velocity"].values) > 1e-3).sum() == stated


def test_the_first_grazing_is_that_of_the_linear_motion():
    borders = vp.boundary(SOFT, "grazing", within=BOX, lines=2)
    linear = borders["impacts_per_orbit"].sum("support").values == 0
    nu, f = borders["nu"].values[linear], borders["f"].values[linear]
    assert nu.size > 30
    np.testing.assert_allclose(f, SOFT.l * np.hypot(1.0 - nu**2, SOFT.h * nu), rtol=1e-12)


def test_curves_beyond_the_most_of_a_call_are_told(monkeypatch):
    task = SOFT, ("grazing", "fold"), ("nu", "f"), BOX
    whole = vp.boundary(*task, lines=2)
    assert "incomplete" not in whole.attrs
    monkeypatch.setattr(search, "MAX_BOUNDARIES", 1)
    with pytest.warns(vp.UnsolvedWarning, match="1 curves are followed"):
        part = vp.boundary(*task, lines=2)
    assert "there are more" in part.attrs["incomplete"]
    assert np.unique(part["curve_id"]).size == 1 < np.unique(whole["curve_id"]).size


def test_friction_holds_the_first_grazing_off():
    """Sliding all the time, Den Hartog's amplitude is the distance of the supports."""
    borders = vp.boundary(RUBBED, "grazing", within=BOX, lines=2)
    linear = borders["impacts_per_orbit"].sum("support").values == 0
    assert linear.sum() > 30
    for n in np.flatnonzero(linear)[::8]:
        nu, f = float(borders["nu"][n]), float(borders["f"][n])
        assert f == pytest.approx(sliding_force(RUBBED, nu), rel=1e-9)


def sliding_force(exciter, nu):
    """Return the force whose motion with two turns a period has the amplitude l, by Den Hartog's closed form.

    Half a period from x = l, x' = 0 to x = -l, x' = 0 with the friction forwards: the free part of the motion is the
    difference of that state and the forced part, which is linear in the phase and size of the force.
    """
    h, d = exciter.h, exciter.friction
    omega, t = np.sqrt(1.0 - h * h / 4.0), np.pi / nu
    decay, c, s = np.exp(-h * t / 2.0), np.cos(omega * t), np.sin(omega * t)
    flow = decay * np.array(
        [[c + h / 2.0 * s / omega, s / omega], [-s / omega, c - h / 2.0 * s / omega]]
    )
    # z = flow (z0 - d e - g) + d e - g with z = -z0 and the forced part -g half a period after g.
    e, z0 = np.array([1.0, 0.0]), np.array([exciter.l, 0.0])
    g = np.linalg.solve(np.eye(2) + flow, z0 + flow @ (z0 - d * e) + d * e)
    # Amplitude of the forced displacement g[0] = a cos, g[1] = a nu sin.
    amplitude = np.hypot(g[0], g[1] / nu)
    return amplitude * np.hypot(1.0 - nu**2, h * nu)


def test_curves_end_at_the_box_or_where_others_begin(found):
    _exciter, borders = found
    ends = borders["meeting_kind"].values[borders["meeting_ends"].values == 1]
    assert not np.isin(ends, [Meeting.LOST, Meeting.POINTS]).any()
    # Each curve once.
    firsts = borders.isel(point=np.flatnonzero(np.diff(borders["curve_id"].values, prepend=-1)))
    names = ("boundary_kind", "nu", "f")
    ways = zip(*(firsts[name].values.round(6).tolist() for name in names), strict=True)
    assert len(set(ways)) == firsts.sizes["point"]


def test_little_friction_changes_a_curve_in_proportion():
    ends = []
    for friction in (0.0, 1e-3, 1e-4):
        rubbed = dataclasses.replace(RUBBED, friction=friction)
        borders = vp.boundary(rubbed, "pitchfork", within=((1.05, 1.5), (0.6, 1.2)), lines=2)
        at_side = (borders["meeting_kind"] == Meeting.BOX) & (borders["meeting_nu"] == 1.5)
        ends.append(float(borders["meeting_f"][at_side.values].item()))
    more, less = abs(ends[1] - ends[0]), abs(ends[2] - ends[0])
    assert more < 1e-3
    assert less == pytest.approx(0.1 * more, rel=0.1)


TWO_SIDED = vp.Exciter(l=0.5, nu=1.6, f=1.0, h=0.1, R1=0.7, R2=0.7)
ONE_SIDED = vp.Exciter(l=0.5, delta=-0.2, nu=1.2, f=0.2, h=0.1, R1=0.8, R2=0.6)
# Its one-sided orbit doubles its period at nu = 2.66.
NEAR_FLIP = vp.Exciter(l=50.0, delta=-50.0, nu=2.5, f=1.0, h=0.1, R1=0.8, R2=0.8)


def test_the_second_solution_is_a_saddle_that_meets_the_first_at_the_fold() -> None:
    for orbits, boundaries, e in (
        (vp.symmetric_orbit, vp.symmetric_orbit_boundaries, dataclasses.replace(TWO_SIDED, nu=1.3)),
        (vp.one_sided_orbit, vp.one_sided_orbit_boundaries, ONE_SIDED),
    ):
        limits = boundaries(e, e.nu).isel(nu=0)
        fold, first = limits.fold_f.item(), limits.first_impact_f.item()
        assert limits.fold_admissible == 1
        between = orbits(dataclasses.replace(e, f=0.5 * (fold + first)))
        assert between.fold_condition.values[0] > 0 > between.fold_condition.values[1]
        assert between.floquet_multiplier.values[1, 0].real > 1
        assert between.admissible.values.tolist() == [1, 1]
        assert between.stable.values.tolist() == [1, 0]
        below, at = (orbits(dataclasses.replace(e, f=fold * s)) for s in (1 - 1e-9, 1 + 1e-12))
        assert np.isnan(below.impact_velocity).all()
        assert below.admissible.values.tolist() == [0, 0]
        np.testing.assert_allclose(abs(at.impact_velocity), limits.fold_velocity, rtol=1e-5)
        assert at.floquet_multiplier.values[0, 0] == pytest.approx(1, abs=1e-4)
        beyond = orbits(dataclasses.replace(e, f=first * (1 + 1e-9)))
        assert np.isfinite(beyond.impact_velocity.values[:, 0]).tolist() == [True, False]


def root(function: Any, low: float, high: float) -> float:
    """Return a zero by bisection."""
    sign = function(low) > 0
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if (function(middle) > 0) == sign else (low, middle)
    return 0.5 * (low + high)


@pytest.mark.parametrize(("low", "high", "stable_side"), [(1.03, 1.06, -1), (1.4, 1.7, 1)])
def test_a_pitchfork_is_where_the_symmetry_breaks(
    low: float, high: float, stable_side: int
) -> None:
    e = vp.Exciter(l=0.5, nu=1.5, f=1.0, h=0.1, R1=0.8, R2=0.8)

    def excess(nu: float) -> float:
        return vp.symmetric_orbit_boundaries(e, nu).pitchfork_f.item() - e.f

    nu = root(excess, low, high)
    at = vp.symmetric_orbit(dataclasses.replace(e, nu=nu)).isel(solution=0)
    assert at.admissible == 1
    assert at.floquet_multiplier.values[0] == pytest.approx(1, abs=1e-10)
    for side, symmetric in ((-stable_side, False), (stable_side, True)):
        near = dataclasses.replace(e, nu=nu + 1e-3 * side)
        orbit = vp.symmetric_orbit(near).isel(solution=0)
        assert (orbit.pitchfork_condition > 0) == (orbit.stable == 1) == symmetric
        # beside the unstable symmetric orbit a motion settles on another one, or on none
        x0, v0 = orbit.displacement_strobe.item(), orbit.velocity_strobe.item() + 1e-3
        settled = vp.steady_state(near, x0, v0)
        returns = settled.period_multiple.item() == 1
        speeds = abs(settled.impact_velocity.values)
        assert (returns and abs(speeds[0] - speeds[-1]) < 1e-9) == symmetric


def test_the_flip_is_where_the_period_doubles() -> None:
    e = NEAR_FLIP

    def condition(nu: float) -> float:
        return vp.one_sided_orbit(dataclasses.replace(e, nu=nu)).flip_condition.values[0]

    nu = root(condition, 2.5, 2.7)
    for side, multiple in ((-1e-2, 1), (1e-2, 2)):
        near = dataclasses.replace(e, nu=nu + side)
        assert vp.steady_state(near).period_multiple == multiple
        assert vp.one_sided_orbit(near).stable.values[0] == (multiple == 1)
    # without an offset, b = 0, nothing depends on the force; else the boundary names it
    offset = vp.Exciter(l=0.5, delta=-0.2, nu=0.8, h=0.1, R1=0.8, R2=0.8)
    limits = vp.one_sided_orbit_boundaries(offset, 0.8).isel(nu=0)
    at = vp.one_sided_orbit(dataclasses.replace(offset, f=limits.flip_f.item())).isel(solution=0)
    assert limits.flip_admissible == at.admissible == 1
    assert at.impact_velocity.values[0] == pytest.approx(limits.flip_velocity.item(), rel=1e-10)
    assert abs(at.floquet_multiplier.values + 1).min() < 1e-10


def test_a_grazing_of_the_flight_changes_the_sign_of_the_clearance() -> None:
    e = dataclasses.replace(ONE_SIDED, delta=-0.2)

    def clearance(f: float) -> float:
        return vp.one_sided_orbit(dataclasses.replace(e, f=f)).clearance.values[0]

    f = root(clearance, 0.1, 1.0)
    inside, outside = (
        vp.one_sided_orbit(dataclasses.replace(e, f=f * s)) for s in (1 - 1e-6, 1 + 1e-6)
    )
    assert inside.admissible.values[0] == 1
    assert outside.admissible.values[0] == 0
    assert inside.clearance.values[0] > 0 > outside.clearance.values[0]
    assert np.isnan(outside.displacement_strobe.values[0])
