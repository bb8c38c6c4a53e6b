"""The orbit that a proof is about, from an exciter or from a row of a dataset, and the box around its exciter."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from vibropipe.physics.effects import all_effects
from vibropipe.physics.exciter import Exciter, ParameterError
from vibropipe.physics.parameter_error import check_keys, number_within
from vibropipe.proof.balls import BITS, arb, ctx
from vibropipe.proof.equations import Flight, end_of
from vibropipe.proof.flights import Flights
from vibropipe.proof.law import Event, Kind, Law, Piece
from vibropipe.solve.motion.simulate import simulate
from vibropipe.solve.physical import is_physical
from vibropipe.solve.rebuild import exciter_of, section_of
from vibropipe.solve.rows.steady import steady_state
from vibropipe.words.parameters import stated_value
from vibropipe.words.proofs import BOXED, holds_by_more, kept_from_boxes, range_in_boxes
from vibropipe.words.records import POSITIVE

# The time of a proof grows with the cube of the impacts in the end; 28 took half a second.
MAX_IMPACTS = 100
# Events within this share of an orbit of its end are those of its start.
NEAR = 1e-9
KNOWN = "an exciter, or one row of a steady state, a sweep, a branch or an orbit in closed form"


class Given(NamedTuple):
    """An orbit: its law, the times of its events (in forcing periods) and what each leaves free (`proof.equations`)."""

    exciter: Exciter
    law: Law
    times: np.ndarray
    frees: np.ndarray


def given_orbit(orbit: Any, strikes: bool = True) -> Given:
    """Return the settled orbit of an exciter, or the orbit of a row; strikes : whether it has to strike a support.

    Raises ParameterError if it is none of both, has an effect that is not proved, or no orbit with impacts and without
    rests.
    """
    if not isinstance(orbit, (Exciter, xr.Dataset)):
        raise ParameterError("orbit", orbit, KNOWN, got=type(orbit).__name__)
    exciter = orbit if isinstance(orbit, Exciter) else _exciter_of_row(orbit)
    effects = all_effects(vars(exciter), pieces=True)
    if effects.no_pull is not None:
        name = next(f"contact_{n}" for n in (1, 2) if getattr(exciter, f"contact_{n}"))
        must = "must be pull: a support that lets go sooner is not proved"
        raise ParameterError(name, getattr(exciter, name), must=must, got="no_pull")
    if holds_by_more(vars(exciter)):
        must = "must be 1 beside friction: a static friction above the kinetic one is not proved"
        raise ParameterError("friction_ratio", exciter.friction_ratio, must=must)
    row = steady_state(exciter, outputs=("impacts",)) if isinstance(orbit, Exciter) else orbit
    m = int(row["period_multiple"])
    if m == 0:
        must = "must have an orbit: its motion repeats after no number of forcing periods that was tried"
        raise ParameterError("orbit", orbit, must=must, got="")
    if "rests_per_orbit" in row and bool((row["rests_per_orbit"] != 0).any()):
        raise ParameterError("orbit", orbit, must="must not rest on a support", got="")
    n = int(row["impacts_per_orbit"].sum())
    if n > MAX_IMPACTS:
        raise ParameterError(
            "orbit", orbit, must=f"must have at most {MAX_IMPACTS} impacts", got=str(n)
        )
    if n == 0 and not strikes:
        return Given(exciter, Law(m, ()), np.empty(0), np.empty(0))
    if n == 0:
        why = (
            "is known in closed form" if exciter.friction == 0.0 else "is not proved with friction"
        )
        must = f"must strike a support: a motion without impacts {why}"
        raise ParameterError("orbit", orbit, must=must, got="")
    given = (
        orbit_of_events(row, exciter, m)
        if effects.has_pieces
        else _orbit_of_impacts(row, exciter, m, n)
    )
    if not (np.isfinite(given.times).all() and np.isfinite(given.frees).all()):
        raise ParameterError("orbit", orbit, must="must exist", got="one without numbers")
    return given


def _exciter_of_row(row: xr.Dataset) -> Exciter:
    """Return the exciter of a dataset that has one orbit."""
    missing = [name for name in ("period_multiple", "impacts_per_orbit", "l") if name not in row]
    if missing or row["impacts_per_orbit"].dims != ("support",):
        must = f"must be {KNOWN}: select it, as with .isel(point=0)"
        got = (
            f"a dataset without {missing[0]}"
            if missing
            else f"one over {row['impacts_per_orbit'].dims}"
        )
        raise ParameterError("orbit", row, must=must, got=got)
    exciter = exciter_of(row)
    exciter.check_frequency()
    return exciter


def _orbit_of_impacts(row: xr.Dataset, exciter: Exciter, m: int, n: int) -> Given:
    """Return the orbit of n impacts on rigid supports: as stored, or marched from the section."""
    is_stored = "impact_phase" in row and row["impact_phase"].shape == (n,)
    if is_stored and not is_physical(row):
        times = (row["impact_phase"] + row["impact_period"]).values
        supports, velocities = row["impact_support"].values, row["impact_velocity"].values
    else:
        motion = _marched(row, exciter, m)
        if motion.sizes["impact"] != n:
            must = (
                f"must have its {n} impacts: of a branch or a sweep select also them, by row_size"
            )
            got = f"a row from whose section {motion.sizes['impact']} follow"
            raise ParameterError("orbit", row, must=must, got=got)
        times = motion["impact_tau"].values / exciter.period
        supports, velocities = motion["impact_support"].values, motion["impact_velocity"].values
    return Given(exciter, Law.of_impacts(m, [int(each) for each in supports]), times, velocities)


def _marched(row: xr.Dataset, exciter: Exciter, periods: float) -> xr.Dataset:
    """Return the motion from the section of a row."""
    x, v = section_of(row, exciter)
    if not (math.isfinite(x) and math.isfinite(v)):
        raise ParameterError("orbit", row, must="must exist", got="one without numbers")
    return simulate(exciter, periods * exciter.period, x, v, samples_per_period=0)


def orbit_of_events(row: xr.Dataset, exciter: Exciter, m: int) -> Given:
    """Return the orbit of a row with soft supports or friction: its events, marched from the section.

    Raises ParameterError if contacts and pieces do not follow each other as those of an orbit.
    """
    motion = _marched(row, exciter, 2 * m)
    period, is_soft = exciter.period, {1: exciter.k1 > 0.0, 2: exciter.k2 > 0.0}
    happened: list[tuple[float, Kind, int, float]] = []
    soft = "contact_duration" in motion
    for i in range(motion.sizes["impact"]):
        tau, support = float(motion["impact_tau"][i]), int(motion["impact_support"][i])
        kind = Kind.ENTERS if is_soft[support] else Kind.IMPACT
        happened.append((tau, kind, support, float(motion["impact_velocity"][i])))
        if soft and is_soft[support]:
            duration, after = motion["contact_duration"][i], motion["impact_velocity_after"][i]
            happened.append((tau + float(duration), Kind.LEAVES, support, float(after)))
    if "turn_tau" in motion:
        sticks = {*map(float, motion["stick_start"].values)}
        for tau in map(float, motion["turn_tau"].values):
            kind = Kind.STICKS if tau in sticks else Kind.TURNS
            happened.append((tau, kind, 0, math.nan))
        happened += [(float(tau), Kind.SLIPS, 0, math.nan) for tau in motion["stick_end"].values]
    happened = sorted((each for each in happened if math.isfinite(each[0])), key=lambda e: e[0])
    first = next((i for i, each in enumerate(happened) if each[1].is_strike), len(happened))
    span = m * period
    within = [each for each in happened[first:] if each[0] < happened[first][0] + (1 - NEAR) * span]
    turns = [(tau / period, kind, support, v) for tau, kind, support, v in within]
    return _followed(exciter, m, turns, row)


def _followed(
    exciter: Exciter, m: int, happened: Sequence[tuple[float, Kind, int, float]], row: xr.Dataset
) -> Given:
    """Return the orbit of events, the first of them a strike: with the pieces after them, and where the mass turns."""
    with ctx.workprec(BITS):
        model = Flights(balls_of(exciter))
        has_friction, contact, way = exciter.friction > 0.0, 0, 0
        events, frees = list[Event](), list[float]()
        for k, (time, kind, support, free) in enumerate(happened):
            if kind.is_at_support:
                contact = support if kind is Kind.ENTERS else 0
                towards = free > 0.0
                way = (1 if towards != (kind is Kind.IMPACT) else -1) if has_friction else 0
            else:
                start, end = arb(happened[k - 1][0]), arb(time)
                flight = Flight(events[-1], events[-1], start, end, arb(frees[-1]), end - start)
                free = float(end_of(model, flight)[0].mid())
                at_rest = model.on(Piece(contact)).acceleration(arb(time), arb(free))
                way = 0 if kind is Kind.STICKS else 1 if float(at_rest.mid()) > 0.0 else -1
            events.append(Event(kind, support, Piece(contact, way, kind is Kind.STICKS)))
            frees.append(free)
    times = np.array([time for time, *_ in happened])
    late = times >= m
    order = np.argsort(times - m * late, kind="stable")
    law = Law(m, tuple(events[i] for i in order))
    if sum(event.kind.is_strike for event in events) != int(row["impacts_per_orbit"].sum()):
        must = "must have its impacts: the motion from its section has others"
        raise ParameterError("orbit", row, must=must, got=f"{len(law.strikes)}")
    return Given(exciter, law, (times - m * late)[order], np.array(frees)[order])


def balls_of(exciter: Exciter) -> dict[str, Any]:
    """Return the parameters of an exciter, which are exact doubles."""
    return {name: arb(float(stated_value(getattr(exciter, name)))) for name in BOXED}


def check_within(exciter: Exciter, within: Mapping[str, float]) -> dict[str, float]:
    """Return how far parameters may be off, or raise a ParameterError."""
    check_keys("within", within, BOXED)
    checked = {name: number_within(f"within.{name}", within[name], POSITIVE) for name in within}
    for name in checked:
        check_varies(exciter, name, f"within.{name}")
    name = first_out_of_range(exciter, checked)
    if name:
        must = f"must keep {name} {range_in_boxes(name).text}"
        got = f"{getattr(exciter, name)!r} +- {checked[name]!r}"
        raise ParameterError(f"within.{name}", checked[name], must=must, got=got)
    return checked


def check_varies(exciter: Exciter, name: str, where: str) -> None:
    """Raise a ParameterError, of the argument `where`, for a parameter that may not vary in a proof."""
    reason = kept_from_boxes(name, vars(exciter), exciter.states)
    if reason is not None:
        must = f"must be {'another parameter' if where == 'along' else 'left out'}: {reason}"
        raise ParameterError(where, getattr(exciter, name), must=must, got="")


def first_out_of_range(exciter: Exciter, within: Mapping[str, float], factor: float = 1.0) -> str:
    """Return the first parameter that may leave its range; "" if none may."""
    for name, most in within.items():
        value, off = getattr(exciter, name), most * factor
        if not all(range_in_boxes(name).contains(end) for end in (value - off, value + off)):
            return name
    return ""
