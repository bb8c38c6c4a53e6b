"""What all datasets of proofs have, and what is proved as a sentence."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import xarray as xr

from vibropipe.physics.effects import all_effect_names
from vibropipe.physics.exciter import Exciter
from vibropipe.proof.balls import BITS
from vibropipe.proof.bifurcation import BOTH, Critical
from vibropipe.proof.certificate import Claim, Part
from vibropipe.proof.every import Found
from vibropipe.proof.given import Given
from vibropipe.proof.values import stability
from vibropipe.solve.origin_attrs import origin_attrs
from vibropipe.words.bifurcations import Bifurcation
from vibropipe.words.proofs import Proved, Why
from vibropipe.words.vocabulary import describe
from vibropipe.words.wording import series

# Numbers in a sentence have so many digits.
DIGITS = 6


@dataclass
class Outcome:
    """How the proof of an orbit ended; the arguments are those of the dataset of `prove`."""

    proved: Proved
    why: Why
    examined: int = 1
    parts: list[Part] = field(default_factory=list)
    counterexample: Mapping[str, float] = field(default_factory=dict)
    largest: float = math.nan


def critical_statement(
    given: Given, kind: Bifurcation, along: str, ends: Sequence[float], found: Critical
) -> str:
    """Return what was found of a bifurcation as a sentence."""
    counts = ", ".join(str(given.law.supports.count(support)) for support in (1, 2))
    name = f"The orbit ({given.law.m}; {counts})"
    if found.why is not Why.NONE:
        return f"Undecided: not proved {found.why.reason}."
    support = "both supports" if found.touched == BOTH else f"support {found.touched}"
    what = {
        Bifurcation.FOLD: "turns back at a fold",
        Bifurcation.FLIP: "has a multiplier that passes -1, a flip,",
        Bifurcation.PITCHFORK: "loses its symmetry at a pitchfork",
        Bifurcation.GRAZING: f"touches {support}, a grazing,",
    }[kind]
    return f"{name} {what} at one {along} between {ends[0]!r} and {ends[1]!r}."


def statement(
    within: Mapping[str, float] | None, claim: Claim, counts: Sequence[int], outcome: Outcome
) -> str:
    """Return what was found of an orbit as a sentence."""
    name = f"orbit ({claim.law.m}; {counts[0]}, {counts[1]})"
    box = series([f"{key} +- {most:g}" for key, most in (within or {}).items()])
    who = f"Every exciter with {box}" if box else "This exciter"
    if outcome.proved is Proved.PROVED:
        word = "a stable motion" if claim.is_stable else "an unstable motion"
        return f"{who} has exactly one {name} nearby, and it is {word}."
    if outcome.proved is Proved.DISPROVED:
        places = series(
            [f"{key} = {value:.{DIGITS}g}" for key, value in outcome.counterexample.items()]
        )
        where = f"of the exciter with {places}" if places else "of this exciter"
        what = {
            Why.MOTION: "leaves the supports"
            if claim.law.is_of_impacts
            else "does not do what its law says",
            Why.STABILITY: f"is {'unstable' if claim.is_stable else 'stable'}",
            Why.PERIOD: "has a shorter period",
        }[outcome.why]
        return f"The {name} {where} {what}."
    return f"Undecided: not proved {outcome.why.reason}."


def every_statement(law: tuple[int, int, int], found: Found) -> str:
    """Return what was found of all orbits of a law as a sentence."""
    m, p1, p2 = law
    stable = sum(stability(part.values) is True for part in found.parts if part.values is not None)
    name, n = f"({m}; {p1}, {p2})", len(found.parts)
    how_many = f"{n} orbits {name}" if n > 1 else f"{'one' if n else 'no'} orbit {name}"
    which = (
        f", {'stable' if stable else 'unstable'}"
        if n == 1
        else f", {stable} of them stable"
        if n
        else ""
    )
    if found.why is Why.NONE:
        return f"This exciter has {'exactly ' if n else ''}{how_many}{which}."
    least = f"at least {how_many}{which}" if n else f"{how_many} that was found"
    return f"This exciter has {least}; not proved {found.why.reason}."


def proved_scalars(proved: Proved, why: Why, examined: int, law: Sequence[int]) -> dict[str, Any]:
    """Return the variables that all proofs have."""
    m, *impacts = law
    return {
        "proved": ((), np.int8(proved)),
        "why": ((), np.int8(why)),
        "parts": ((), examined),
        "period_multiple": ((), m),
        "impacts_per_orbit": ("support", np.array(impacts, float)),
    }


def described(
    exciter: Exciter,
    variables: Mapping[str, Any],
    harmonics: int,
    attrs: Mapping[str, str],
    **coords: Any,
) -> xr.Dataset:
    """Return variables as a dataset with the parameters of the exciter and the words of all quantities."""
    from flint import __version__ as flint_version

    scalars = {name: ((), value) for name, value in exciter.stated().items()}
    index = {"support": np.array([1, 2], np.int8), "harmonic": np.arange(1, harmonics + 1)}
    origin = origin_attrs(all_effect_names(vars(exciter), pieces=True), "none: proved by balls")
    origin["method"] = f"balls of {BITS} bits (python-flint {flint_version})"
    dataset = xr.Dataset(dict(variables), {**scalars, **index, **coords}, {**origin, **attrs})
    return describe(dataset)
