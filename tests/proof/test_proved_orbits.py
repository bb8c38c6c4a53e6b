"""Random orbits and their knocks are proved; what is stored or known to 50 digits lies within the bounds."""

from __future__ import annotations

import itertools

import mpmath as mp
import numpy as np
import pytest
from proved_rows import random_designs, random_points, random_rows, shares_of_error
from true_rows import draw_exciters, orbits, true_quantities

import vibropipe as vp
from vibropipe.proof import equations, values
from vibropipe.proof.balls import BITS, arb, ctx
from vibropipe.proof.flights import Flights
from vibropipe.proof.knock import with_proved_knocks
from vibropipe.proof.returns import Returns
from vibropipe.words.proofs import Proved, ProvedStable, Why

PAPER = vp.Exciter(l=0.5, nu=1.0, f=-1.0, h=0.2, delta=0.01, R1=0.7, R2=0.7)
SECOND = {"nu": 1.7, "f": 1.5, "h": 0.1, "delta": 0.1, "R1": 0.6, "R2": 0.5}
SECOND |= {"load": 0.05, "f2": 0.3, "phi2": 0.4}
# Stored values may lie beyond the bounds by so many stated errors, as docs/numerics.md says; one in a hundred more.
MAX_SHARE = 3.0
# ||mu| - 1| within which a stability may be undecided, and multiples of |mu| - 1 of a stored row at a bifurcation.
AT_BIFURCATION = 1e-9


def count_proved(rows):
    """Count rows, those proved, and collect shares of errors; no row far from a bifurcation may stay unproved."""
    n, proved, shares = 0, 0, []
    for row in rows:
        proof = vp.prove(row)
        n += 1
        modulus = abs(row.floquet_multiplier.values).max()
        if proof.proved == Proved.PROVED:
            proved += 1
            shares += shares_of_error(row, proof)
            if abs(modulus - 1.0) > AT_BIFURCATION:
                assert bool(proof.proved_stable == ProvedStable.STABLE) == bool(row.stable)
            radius = float(proof.spectral_radius_low), float(proof.spectral_radius_high)
            # at a grazing the stored multiplier is known to no digit
            off = max(1e-6 * (1 + modulus), row.floquet_multiplier_error.values.max())
            assert radius[0] - off < modulus < radius[1] + off
            continue
        assert is_at_bifurcation(row), (proof.statement, row)
    return n, proved, np.array(shares)


def is_at_bifurcation(row):
    """Whether a row is at a bifurcation, or beside one on its branch: what is true of it may not be of its doubles."""
    slowest = abs(row.impact_velocity.values).min() / abs(row.impact_velocity.values).max()
    nearest = abs(abs(row.floquet_multiplier.values) - 1.0).min()
    return bool(row.get("beside", False)) or slowest < 1e-6 or nearest < 1e-6


def test_random_rows_are_proved():
    n, proved, shares = count_proved(itertools.islice(random_rows(11, 200), 50))
    assert n == 50
    assert proved == 50
    assert shares.max() < MAX_SHARE


def test_random_points_of_branches_are_proved():
    n, proved, shares = count_proved(itertools.islice(random_points(3, 12), 0, 400, 10))
    assert n >= 25
    assert proved >= 0.85 * n
    assert shares.max() < MAX_SHARE


def test_random_designs_are_proved():
    n, proved, shares = count_proved(random_designs(5, 4))
    assert n >= 4
    assert proved == n
    assert shares.max() < MAX_SHARE


@pytest.mark.slow
def test_two_thousand_rows_points_and_designs_are_proved():
    rows = itertools.chain(
        random_designs(6, 100),
        random_rows(1, 4000),
        random_points(2, 60),
        random_points(4, 30, "f"),
    )
    n, proved, shares = count_proved(itertools.islice(rows, 2000))
    assert n == 2000
    assert proved >= 0.93 * n
    assert (shares > MAX_SHARE).mean() <= 0.01


def test_bounds_hold_what_is_known_to_fifty_digits():
    checked = 0
    for sort, p, row in orbits(draw_exciters(7, 30)):
        if sort != "struck":
            continue
        proof = vp.prove(row)
        assert proof.proved == Proved.PROVED
        with mp.workdps(50):
            true = true_quantities(sort, p, row)
            times = [
                t - n for t, n in zip(true["impact_phase"], row.impact_period.values, strict=True)
            ]
            for name, exact in (true | {"impact_phase": times}).items():
                if f"{name}_low" not in proof:
                    continue
                low, high = (proof[f"{name}_{end}"].values.ravel() for end in ("low", "high"))
                for a, b, value in zip(low, high, exact, strict=False):
                    assert mp.mpf(a) <= value <= mp.mpf(b), name
                    assert np.nextafter(a, np.inf) >= b
                    checked += 1
            trace = mp.re(sum(true["floquet_multiplier"]))
            assert float(proof.trace_low) - 1e-9 < trace < float(proof.trace_high) + 1e-9
    assert checked > 100


def restitution_mutated(model, flight):
    leaving = -(model.restitution[flight.event.support] * flight.free * (1 + arb(1e-10)))
    return model.fly(flight.start, flight.turns, model.position[flight.event.support], leaving)


def test_a_mutation_of_the_restitution_is_found(monkeypatch):
    row = vp.steady_state(PAPER)
    monkeypatch.setattr(equations, "end_of", restitution_mutated)
    assert max(shares_of_error(row, vp.prove(row))) > 100


@pytest.mark.parametrize("slot", range(4))
def test_a_mutation_of_the_flow_is_found(monkeypatch, slot):
    row, flow = vp.steady_state(PAPER), Flights.flow

    def mutated(self, turns):
        parts = list(flow(self, turns))
        parts[slot] = parts[slot] * (1 + arb(1e-10))
        return type(flow(self, turns))(*parts)

    monkeypatch.setattr(Flights, "flow", mutated)
    proof = vp.prove(row)
    assert proof.proved != Proved.PROVED or max(shares_of_error(row, proof)) > 100


def test_a_mutation_of_the_saltation_is_found(monkeypatch):
    row, derivative = vp.steady_state(PAPER), values.trace_and_determinant

    def mutated(model, law, u, **given):
        model.force = lambda time: Flights.force(model, time) * (1 + arb(1e-9))
        return derivative(model, law, u, **given)

    monkeypatch.setattr(values, "trace_and_determinant", mutated)
    trace = row.floquet_multiplier.values.sum().real
    proof = vp.prove(row)
    error = 3 * row.floquet_multiplier_error.values.max()
    assert not float(proof.trace_low) - error <= trace <= float(proof.trace_high) + error


def test_a_mutation_of_the_harmonics_is_found(monkeypatch):
    row, pulses = vp.steady_state(PAPER), values._pulses

    def mutated(model, flight):
        for pulse in pulses(model, flight):
            yield lambda k, of=pulse: of(k) * (1 + arb(1e-11))

    monkeypatch.setattr(values, "_pulses", mutated)
    assert max(shares_of_error(row, vp.prove(row))) > 100


def test_an_orbit_that_leaves_the_supports_is_disproved():
    exciter = vp.Exciter(l=0.5, nu=0.5, f=1.5, h=0.1, R1=0.8, R2=0.8)
    solutions = vp.one_sided_orbit(exciter, 1, 1)
    unreal = solutions.isel(solution=int(np.flatnonzero(solutions.admissible.values == 0)[0]))
    proof = vp.prove(unreal)
    assert (proof.proved, proof.why) == (Proved.DISPROVED, Why.MOTION)
    assert proof.statement == "The orbit (1; 1, 0) of this exciter leaves the supports."
    assert np.isnan(proof.impact_velocity_low).all()


def test_an_orbit_that_is_told_twice_has_a_shorter_period():
    once = vp.steady_state(PAPER)
    names = ["impact_phase", "impact_support", "impact_velocity"]
    twice = once[names].isel(impact=[0, 1, 0, 1])
    twice["impact_period"] = ("impact", [0, 0, 1, 1])
    twice["period_multiple"] = 2
    twice["impacts_per_orbit"] = 2 * once.impacts_per_orbit
    proof = vp.prove(twice)
    assert (proof.proved, proof.why) == (Proved.DISPROVED, Why.PERIOD)


def test_a_doubled_orbit_has_no_shorter_period():
    row = vp.steady_state(vp.Exciter(l=0.5, nu=1.5, f=0.6, h=0.02, delta=0.2, R1=0.9, R2=0.9))
    assert row.period_multiple > 1
    assert vp.prove(row).proved == Proved.PROVED


@pytest.mark.parametrize(
    "values",
    [
        {"nu": 1.0, "f": 0.5, "h": 0.0, "delta": 0.1, "R1": 0.8, "R2": 0.8},
        {"nu": 1.2, "f": 2.5, "h": 2.0, "delta": 0.1, "R1": 0.8, "R2": 0.8},
        {"nu": 1.2, "f": 2.5, "h": 3.0, "delta": 0.1, "R1": 0.8, "R2": 0.7},
        {"nu": 1.4, "f": 0.9, "h": 0.1, "R1": 0.7, "R2": 0.7},
        SECOND,
        {"nu": 1.5, "f": 0.6, "h": 0.1, "delta": 0.1, "R1": 0.0, "R2": 0.5},
    ],
    ids=["resonance", "h = 2", "h = 3", "symmetric", "second harmonic", "no restitution"],
)  # fmt: skip
def test_special_exciters_are_proved(values):
    exciter = vp.Exciter(l=0.5, **values)
    row = vp.steady_state(exciter)
    proof = vp.prove(row)
    assert proof.proved == Proved.PROVED, proof.statement
    shares = shares_of_error(row, proof)
    assert max(shares) < MAX_SHARE
    if exciter.h == 0.0:
        assert float(proof.displacement_amplitude_low[0]) == 0.0
        assert float(proof.displacement_amplitude_high[0]) == pytest.approx(2 / np.pi, rel=1e-8)


RIGID = vp.Exciter(l=0.5, nu=1.8, f=0.4, h=0.15, R1=0.7, R2=0.6)
SOFT = vp.Exciter(l=0.5, nu=2.2, f=0.5, h=0.1, k1=50, h1=1, k2=20, h2=0.5)


@pytest.fixture(
    scope="module",
    params=[RIGID, pytest.param(SOFT, marks=pytest.mark.slow)],
    ids=["rigid", "soft"],
)
def proved(request):
    found = vp.attractors(request.param, 512)
    return request.param, with_proved_knocks(found, 300)


def test_proved_knocks_are_below_the_marched_ones(proved):
    _exciter, motions = proved
    for name in ("knock", "knock_impulse"):
        low, marched = motions[f"{name}_low"].values, motions[name].values
        assert (low > 0.002).all()
        assert (low < marched).all()


@pytest.mark.slow
def test_a_proved_impulse_comes_near_the_marched_one():
    row = vp.attractors(RIGID, 512).drop_dims("impact").isel(attractor_id=0)
    found = vp.prove_knock(row, cells=1000)
    assert found["proved"] == Proved.PROVED
    marched = float(row["knock_impulse"])
    assert 0.99 * marched < float(found["knock_impulse_low"]) < marched
    assert repr(float(found["knock_low"])) in found.attrs["statement"]


def test_starts_within_a_proved_knock_settle_on_the_orbit(proved):
    exciter, motions = proved
    rng = np.random.default_rng(3)
    for n in range(motions.sizes["attractor_id"]):
        row = motions.isel(attractor_id=n)
        assert int(row["period_multiple"]) == 1
        state = np.array([float(row[f"{name}_strobe"]) for name in ("displacement", "velocity")])
        angles = rng.uniform(0.0, 2.0 * np.pi, 12)
        offs = float(row["knock_low"]) * np.column_stack([np.cos(angles), np.sin(angles)])
        kicks = float(row["knock_impulse_low"]) * np.array([[0.0, 1.0], [0.0, -1.0]])
        for off in (*offs, *kicks):
            x, v = state + 0.999 * off
            settled = vp.steady_state(exciter, x0=x, v0=v, outputs=("impacts",))
            there = [float(settled[f"{name}_strobe"]) for name in ("displacement", "velocity")]
            assert there == pytest.approx(state, abs=1e-9)


@pytest.mark.parametrize("exciter", [RIGID, SOFT], ids=["rigid", "soft"])
def test_the_image_of_a_cell_contains_those_of_its_starts(exciter):
    rng = np.random.default_rng(7)
    with ctx.workprec(BITS):
        returns = Returns(exciter, np.zeros((1, 2)), 0.0)
        found = 0
        for _ in range(60):
            centre = rng.uniform(-0.45, 0.45), rng.uniform(-1.0, 1.0)
            half = np.array([4e-3, 4e-3]) * rng.uniform(0.01, 1.0, 2)
            image = returns._image(centre, np.diag(half), 2)
            if image is None:
                continue
            found += 1
            for c in rng.uniform(-1.0, 1.0, (5, 2)):
                x0, v0 = np.array(centre) + half * c
                end = vp.simulate(exciter, 2 * exciter.period, x0, v0, samples_per_period=0)
                for moved, name in zip(image, ("displacement_end", "velocity_end"), strict=True):
                    value = float(end[name])
                    linear = moved.centre + sum(a * b for a, b in zip(moved.slopes, c, strict=True))
                    assert (moved.ball + arb(0, 1e-10)).contains(arb(value))
                    assert (linear + arb(0, 1e-10)).contains(arb(value))
        assert found > 20


def test_no_knock_is_proved_of_what_does_not_attract():
    found = vp.prove_knock(vp.Exciter(l=2.0, nu=1.7, f=0.4, h=0.0), cells=10)
    assert found["proved"] == Proved.UNDECIDED
    assert found["why"] == Why.STABILITY
    assert np.isnan(found["knock_low"])
    assert found.attrs["statement"].startswith("Undecided")


def test_an_unstable_orbit_and_effects_that_are_not_proved_are_refused():
    orbits = vp.symmetric_orbit(vp.Exciter(l=0.5, nu=1.3, f=1.0, h=0.2, R1=0.7, R2=0.7))
    (unstable,) = np.flatnonzero(orbits["admissible"].values & (orbits["stable"].values == 0))
    with pytest.raises(vp.ParameterError, match="must be stable"):
        vp.prove_knock(orbits.isel(solution=int(unstable)), cells=10)
    with pytest.raises(vp.ParameterError, match="friction: must be 0"):
        vp.prove_knock(vp.Exciter(l=0.5, nu=1.0, f=0.8, h=0.1, friction=0.05), cells=10)
    with pytest.raises(vp.ParameterError, match="cells"):
        vp.prove_knock(RIGID, cells=0)
    with pytest.raises(vp.ParameterError, match="mass_ratio"):
        vp.prove_knock(vp.Exciter(l=0.5, nu=1.8, f=0.4, h=0.15, mass_ratio=0.2), cells=10)
