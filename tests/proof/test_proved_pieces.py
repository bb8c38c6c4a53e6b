"""Orbits with soft supports and friction are proved; what is stored, and known to 20 digits, lies within the bounds."""

from __future__ import annotations

import itertools
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from proved_rows import shares_of_error

import vibropipe as vp
from vibropipe.proof import equations, values
from vibropipe.proof import law as laws
from vibropipe.proof.balls import BITS, arb, ctx
from vibropipe.proof.equations import Flight, conditions, end_of
from vibropipe.proof.flights import Flights
from vibropipe.proof.given import Given, given_orbit
from vibropipe.proof.law import Event, Kind, Law, Piece
from vibropipe.proof.statement import prove_orbit
from vibropipe.words.bifurcations import Bifurcation
from vibropipe.words.proofs import BOXED, Proved, Why

MOTIONS = json.loads((Path(__file__).parents[1] / "reference/effects.json").read_text())
OF_REFERENCE = {"d": "friction", "q": "load"}
KINDS = {"": Kind.IMPACT, "in": Kind.ENTERS, "out": Kind.LEAVES, "turn": Kind.TURNS}
KINDS |= {"stick": Kind.STICKS, "slip": Kind.SLIPS}
# It turns, and turns back at once; it sticks and slips; it is stopped by friction within a soft contact.
TURNS = vp.Exciter(l=0.5, nu=1.0, f=-1.0, h=0.2, delta=0.02, k1=200.0, h1=3.0, R2=0.7, friction=0.1)
STICKS = vp.Exciter(l=0.5, nu=1.0, f=-1.0, h=0.2, delta=0.02, R1=0.7, R2=0.7, friction=0.1)
SOFT = vp.Exciter(l=0.5, nu=1.4, f=-1.0, h=0.2, delta=0.02, k1=200.0, h1=8.0, R2=0.7)
MAX_SHARE = 3.0
# Multipliers and velocities nearer to 1 and 0 belong to orbits about to bifurcate.
AT_BIFURCATION = 1e-6


def draw(rng):
    """Return a random exciter with soft supports, friction or both."""
    nu, f, h, R1, R2 = rng.uniform([0.5, 0.2, 0.02, 0.4, 0.4], [2.5, 1.5, 0.4, 0.9, 0.9])
    given = {"l": 0.5, "nu": nu, "f": f, "h": h, "R1": R1, "R2": R2}
    given["delta"] = rng.uniform(-0.3, 0.3)
    kind = rng.integers(1, 4)
    if kind & 1:
        given |= {f"k{n}": 10.0 ** rng.uniform(1.0, 4.0) for n in (1, 2)[: rng.integers(1, 3)]}
    if kind & 2:
        given["friction"] = 10.0 ** rng.uniform(-2.5, -0.7)
    if rng.random() < 0.3:
        given |= {"f2": 0.3, "phi2": 0.4, "load": rng.uniform(-0.1, 0.1)}
    return vp.Exciter(**given)


def random_rows(seed):
    """Yield the orbits of random exciters with pieces, those with impacts and without rests."""
    rng = np.random.default_rng(seed)
    while True:
        row = vp.steady_state(draw(rng))
        if (
            row.period_multiple > 0
            and row.impacts_per_orbit.any()
            and not row.rests_per_orbit.any()
        ):
            yield row


def check_rows(rows, n):
    """Prove rows, compare what is stored with the bounds, and return the events that occurred."""
    happened = set()
    for row in itertools.islice(rows, n):
        proof = vp.prove(row)
        modulus = abs(row.floquet_multiplier.values).max()
        if proof.proved != Proved.PROVED:
            slowest = abs(row.impact_velocity.values).min()
            assert min(abs(modulus - 1.0), slowest) < AT_BIFURCATION, (proof.statement, row)
            continue
        assert max(shares_of_error(row, proof)) < MAX_SHARE, row
        low, high = float(proof.spectral_radius_low), float(proof.spectral_radius_high)
        assert low - 1e-6 < modulus < high + 1e-6
        happened |= {each.split(" ")[0] for each in proof.events.split(", ")}
    return happened


def test_random_rows_are_proved():
    happened = check_rows(random_rows(3), 25)
    assert happened == {"impact", "contact", "off", "turn", "stuck", "slip"}


@pytest.mark.slow
def test_a_thousand_rows_are_proved():
    check_rows(random_rows(4), 1000)


def event_of(text, velocity, has_friction, piece, push):
    """Return an event of the reference; push : the acceleration of the mass at rest, without friction."""
    name = text.rstrip("12")
    support = int(text[len(name) :] or 0)
    kind = KINDS[name]
    contact = {Kind.IMPACT: 0, Kind.ENTERS: support, Kind.LEAVES: 0}.get(kind, piece.contact)
    way = 0
    if has_friction and kind is not Kind.STICKS:
        leaving = push if not support else -velocity if kind is Kind.IMPACT else velocity
        way = 1 if leaving > 0.0 else -1
    return Event(kind, support, Piece(contact, way, kind is Kind.STICKS))


@pytest.mark.parametrize("motion", MOTIONS, ids=[each["name"] for each in MOTIONS])
def test_pieces_lead_through_motions_known_to_20_digits(motion):
    """Each flight begins with the known velocity, and meets the next event where and as fast as is known."""
    numbers = (key for key in motion if key not in ("name", "events"))
    met, seen = [], set()
    with ctx.workprec(BITS):
        given = {OF_REFERENCE.get(key, key): arb(motion[key]) for key in numbers}
        model = Flights({name: given.get(name, arb(0)) for name in BOXED})
        first = next(i for i, e in enumerate(motion["events"]) if e["kind"][-1] in "12")
        event = start = free = None
        for each in motion["events"][first:]:
            end, velocity = arb(each["tau"]) / model.period, arb(each["velocity_before"])
            piece, push = Piece() if event is None else event.after, 0.0
            if event is not None:
                x, v = end_of(model, Flight(event, event, start, end, free, end - start))
                push = float(model.on(Piece(piece.contact)).acceleration(end, x).mid())
                met.append(v - velocity)
            known = float(velocity.mid())
            after = event_of(each["kind"], known, motion["d"] != "0", piece, push)
            if event is not None:
                off, free = conditions(
                    model, Flight(event, after, start, end, free, end - start), x, v
                )
                met.append(off)
                seen.add((event.kind, after.kind))
            event, start, free = after, end, velocity if after.support else free
    assert max(abs(float(each.mid())) for each in met) < 1e-16
    assert len(met) > 20
    assert len(seen) > 3 or motion["name"] in (
        "load",
        "second_harmonic",
        "soft_both",
        "soft_damped",
    )


@pytest.mark.parametrize(
    "exciter",
    [pytest.param(e, marks=pytest.mark.slow) for e in (SOFT, TURNS)] + [STICKS],
    ids=["soft", "turns", "sticks"],
)
def test_all_exciters_within_tolerances_lie_within_the_bounds(exciter):
    of_all = {"R2": 0.002, "delta": 0.0005}
    own = {"k1": 0.5, "h1": 0.02} if exciter.k1 else {}
    own |= {"friction": 0.001} if exciter.friction else {}
    within = of_all | own
    proof = vp.prove(exciter, within)
    assert proof.proved == Proved.PROVED, proof.statement
    rng, names = np.random.default_rng(1), list(within)
    for signs in [
        *itertools.islice(itertools.product((-1, 1), repeat=len(names)), 6),
        *rng.uniform(-1, 1, (6, len(names))),
    ]:
        other = replace(
            exciter,
            **{n: getattr(exciter, n) + s * within[n] for n, s in zip(names, signs, strict=True)},
        )
        row = vp.steady_state(other)
        for name in ("impact_velocity", "impact_phase", "displacement_mean", "velocity_strobe"):
            low, high = proof[f"{name}_low"].values, proof[f"{name}_high"].values
            assert (row[name].values >= low - 1e-13).all()
            assert (row[name].values <= high + 1e-13).all()
    widest = (proof.impact_velocity_high - proof.impact_velocity_low).max()
    assert 1e-4 < widest < 0.2


def test_a_tolerance_that_is_too_wide_has_a_counterexample_of_another_law():
    proof = vp.prove(STICKS, {"friction": 0.09}, largest=True)
    assert proof.proved == Proved.DISPROVED
    assert proof.statement.endswith("does not do what its law says.")
    wrong = replace(STICKS, friction=float(proof.counterexample[0]))
    assert abs(wrong.friction - STICKS.friction) <= 0.09
    counts = [(s.sizes["turn"], s.sizes["stick"]) for s in map(one_orbit, (STICKS, wrong))]
    assert counts[0] != counts[1]
    inside = replace(STICKS, friction=STICKS.friction + 0.9 * float(proof.largest) * 0.09)
    same = one_orbit(inside)
    assert (same.sizes["turn"], same.sizes["stick"]) == counts[0]


def one_orbit(exciter):
    """Return the motion over one settled orbit."""
    row = vp.steady_state(exciter)
    section = float(row.displacement_strobe), float(row.velocity_strobe)
    span = int(row.period_multiple) * exciter.period
    return vp.simulate(exciter, span, *section, samples_per_period=0)


def test_a_law_that_is_told_wrong_is_no_motion():
    """A mass that would stick is said to turn, and one that turns to stick: the forces say otherwise."""
    given = given_orbit(STICKS)
    kinds = [event.kind for event in given.law.events]
    i = kinds.index(Kind.STICKS)
    events = list(given.law.events)
    way = events[i - 1].after.way
    events[i] = Event(Kind.TURNS, 0, Piece(way=-way))
    wrong = given._replace(law=Law(given.law.m, tuple(events)))
    assert prove_orbit(wrong, None, 1, 1, False, 0).proved != Proved.PROVED


def test_an_orbit_that_passes_through_a_support_is_none():
    """Of the same unknowns, a support that is left out of the law is passed: the contact is a flight."""
    given = given_orbit(SOFT)
    events = [e._replace(after=Piece()) for e in given.law.events]
    wrong = Given(given.exciter, Law(given.law.m, tuple(events)), given.times, given.frees)
    proof = prove_orbit(wrong, None, 1, 1, False, 0)
    assert proof.proved != Proved.PROVED


def push_mutated(function):
    def mutated(self, p, piece=laws.FREE):
        function(self, p, piece)
        self.push = self.push * (1 + arb(1e-10))

    return mutated


def damping_mutated(function):
    def mutated(self, p, piece=laws.FREE):
        p = {**p, "h1": p["h1"] * (1 + arb(1e-10))}
        function(self, p, piece)

    return mutated


@pytest.mark.parametrize(
    ("mutation", "exciter"),
    [(push_mutated, SOFT), (push_mutated, TURNS), (push_mutated, STICKS), (damping_mutated, SOFT)],
)
def test_a_mutation_of_a_piece_is_found(monkeypatch, mutation, exciter):
    row = vp.steady_state(exciter)
    monkeypatch.setattr(Flights, "__init__", mutation(Flights.__init__))
    assert max(shares_of_error(row, vp.prove(row))) > 30


def test_a_mutation_of_an_event_is_found(monkeypatch):
    row, own = vp.steady_state(TURNS), values.saltation

    def mutated(model, flight, before):
        x, shear, v = own(model, flight, before)
        return x, shear, v * (1 + arb(1e-6)) if flight.event.kind is Kind.TURNS else v

    monkeypatch.setattr(values, "saltation", mutated)
    proof, modulus = vp.prove(row), abs(row.floquet_multiplier.values).max()
    assert (
        not float(proof.spectral_radius_low) - 1e-9
        < modulus
        < float(proof.spectral_radius_high) + 1e-9
    )


@pytest.mark.parametrize("kind", [Kind.TURNS, Kind.ENTERS, Kind.LEAVES])
def test_a_mutation_of_what_an_event_asks_for_is_found(monkeypatch, kind):
    row, own = vp.steady_state(TURNS), equations.conditions

    def mutated(model, flight, x, v):
        met, free = own(model, flight, x, v)
        return (met + arb(1e-10), free) if flight.next_event.kind is kind else (met, free)

    monkeypatch.setattr(equations, "conditions", mutated)
    assert max(shares_of_error(row, vp.prove(row))) > 100


@pytest.mark.parametrize(
    ("exciter", "along", "ends", "kinds"),
    [
        (SOFT, "f", (-1.3, -0.9), {Bifurcation.FLIP}),
        pytest.param(
            replace(TURNS, nu=0.8),
            "nu",
            (0.742, 0.85),
            {Bifurcation.FLIP, Bifurcation.FOLD},
            marks=pytest.mark.slow,
        ),
    ],
    ids=["soft", "turns"],
)
def test_folds_and_flips_of_branches_lie_where_they_are_enclosed(exciter, along, ends, kinds):
    branch = vp.branch(exciter, along, ends)
    proof, found = vp.prove(branch), set()
    assert (proof.proved == Proved.PROVED).mean() > 0.95
    places = zip(branch.bifurcation_kind.values, branch[f"bifurcation_{along}"].values, strict=True)
    for k, (kind, where) in enumerate(places):
        if proof.bifurcation_proved[k] != Proved.PROVED:
            assert kind not in (Bifurcation.FLIP, Bifurcation.FOLD)
            continue
        low, high = (float(proof[f"bifurcation_{along}_{end}"][k]) for end in ("low", "high"))
        assert where == pytest.approx(low, rel=1e-10)
        assert high - low < 1e-12 * abs(where)
        found.add(Bifurcation(int(kind)))
    assert found == kinds


@pytest.mark.parametrize(
    ("exciter", "within", "message"),
    [
        (STICKS, {"k1": 1.0}, "within.k1: must be left out: support 1 is rigid"),
        (SOFT, {"friction": 0.1}, "within.friction: must be left out: there is no friction"),
        (SOFT, {"k1": 200.0}, "within.k1: must keep k1 a finite number > 0, got 200.0 +- 200.0"),
        (replace(SOFT, h1=None, R1=0.5), {"R1": 0.1}, "within.R1: must be left out: h1 is not stated and would"),
        (replace(STICKS, friction_ratio=1.5), None, "friction_ratio: must be 1 beside friction: a static friction"),
        (replace(SOFT, contact_1="no_pull"), None, "contact_1: must be pull: a support that lets go sooner"),
    ],
)  # fmt: skip
def test_what_is_not_covered_is_refused_in_words(exciter, within, message):
    with pytest.raises(vp.ParameterError) as error:
        vp.prove(exciter, within)
    assert str(error.value).startswith(message)


def test_grazings_and_pitchforks_are_of_rigid_supports():
    with pytest.raises(vp.ParameterError, match="kind: must be fold or flip with soft supports"):
        vp.prove_bifurcation(SOFT, "grazing", "f")
    with pytest.raises(vp.ParameterError, match="along: must be another parameter: there is no"):
        vp.prove_bifurcation(SOFT, "fold", "friction")


def test_the_tube_holds_the_motion_and_its_depth():
    proof, row = vp.prove(SOFT, stretches=64), vp.steady_state(SOFT)
    section = float(row.displacement_strobe), float(row.velocity_strobe)
    motion = vp.simulate(SOFT, SOFT.period, *section, samples_per_period=64)
    x = motion.displacement.values[:-1]
    assert (proof.displacement_low.values - 1e-12 <= x).all()
    assert (x <= proof.displacement_high.values + 1e-12).all()
    deepest = SOFT.upper + float(motion.contact_depth_max.max())
    assert proof.displacement_high.max() == pytest.approx(deepest, abs=0.05)
    assert deepest > SOFT.upper + 0.01
    assert Why(int(proof.why)) is Why.NONE
