"""Proved knocks of stable orbits, as labelled datasets."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import xarray as xr

from vibropipe.physics.exciter import ParameterError
from vibropipe.proof.balls import BITS, Box, arb, ctx
from vibropipe.proof.certificate import MAX_MOVED_BY_ROUNDING, Claim, examine
from vibropipe.proof.flights import Flights
from vibropipe.proof.given import Given, balls_of, given_orbit
from vibropipe.proof.outcome import described, proved_scalars
from vibropipe.proof.returns import returns_to
from vibropipe.proof.values import stability
from vibropipe.words.progress import Progress
from vibropipe.words.proofs import Proved, Why
from vibropipe.words.vocabulary import describe

KNOCKS = ("knock_low", "knock_impulse_low")


def prove_knocks(orbit: Any, cells: int, progress: Progress | None = None) -> xr.Dataset:
    """Return the dataset of `prove_knock`; `cells` is checked."""
    given = given_orbit(orbit, strikes=False)
    if given.exciter.friction != 0.0:
        must = "must be 0: of motions with friction it is not proved that they return"
        raise ParameterError("friction", given.exciter.friction, must=must)
    with ctx.workprec(BITS):
        why, strobe = _at_section(given)
        returns = None if why is not Why.NONE else returns_to(given.exciter, strobe, given.law.m)
        knocks = [math.nan, math.nan]
        if returns is not None:
            # The second search knows what the first has proved.
            knocks = [returns.settle_within(each, cells, progress) for each in (False, True)]
        elif why is Why.NONE:
            why = Why.RETURN
    supports = given.law.supports
    law = given.law.m, *(supports.count(support) for support in (1, 2))
    verdict = Proved.UNDECIDED if returns is None else Proved.PROVED
    variables: dict[str, Any] = {
        **{name: ((), value) for name, value in zip(KNOCKS, knocks, strict=True)},
        **proved_scalars(verdict, why, 0 if returns is None else returns.examined, law),
    }
    attrs = {"statement": _statement(why, knocks, law), "events": given.law.text}
    return described(given.exciter, variables, 0, attrs).drop_vars("harmonic")


def _at_section(given: Given) -> tuple[Why, tuple[Any, Any]]:
    """Return why no stable orbit is proved, and balls of its displacement and velocity at the section."""
    nothing = arb.nan(), arb.nan()
    if not given.law.events:
        model = Flights(balls_of(given.exciter))
        if not model.damping > 0:
            return Why.STABILITY, nothing
        moves = [(amplitude / model.resistance(k), model.nu * k) for k, amplitude in model.forces]
        x = sum((z.imag for z, _w in moves), model.p["load"])
        return Why.NONE, (x, sum((z.real * w for z, w in moves), arb(0)))
    guess = [*given.times, *given.frees]
    part = examine(
        Box(balls_of(given.exciter)), Claim(given.law, None, 1), guess, MAX_MOVED_BY_ROUNDING
    )
    if part.why is not Why.NONE or part.values is None:
        return part.why, nothing
    if not stability(part.values):
        must = "must be stable: from an unstable orbit any knock may lead away"
        raise ParameterError("orbit", None, must=must, got="an unstable one")
    return Why.NONE, (part.values.displacement, part.values.velocity)


def _statement(why: Why, knocks: list[float], law: tuple[int, ...]) -> str:
    """Return what was found as a sentence."""
    if why is not Why.NONE:
        return f"Undecided: not proved {why.reason}."
    name = f"({law[0]}; {law[1]}, {law[2]})"
    return (
        f"All motions settle on the orbit {name} that begin, at the section, nearer to it than {knocks[0]!r}, or with "
        f"its displacement and a velocity that differs by less than {knocks[1]!r}."
    )


def with_proved_knocks(dataset: xr.Dataset, cells: int) -> xr.Dataset:
    """Add to the attractors of one exciter what is proved of their knocks; NaN of those of which nothing is.

    dataset : as of `attractors`, without units; cells : as of `prove_knock`
    """
    found = np.full((2, dataset.sizes["attractor_id"]), np.nan)
    for n in range(found.shape[1]):
        row = dataset.drop_dims("impact", errors="ignore").isel(attractor_id=n)
        is_orbit = int(row["period_multiple"]) > 0 and not bool((row["rests_per_orbit"] != 0).any())
        if is_orbit:
            try:
                proved = prove_knocks(row, cells)
            except ParameterError:
                continue
            found[:, n] = [float(proved[name]) for name in KNOCKS]
    knocks = zip(KNOCKS, found, strict=True)
    return describe(dataset.assign({name: ("attractor_id", each) for name, each in knocks}))
