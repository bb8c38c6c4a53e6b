"""What is proved as labelled datasets, with a sentence that states it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from vibropipe.physics.exciter import Exciter
from vibropipe.proof.balls import BITS, Box, arb, ctx, round_down, round_up
from vibropipe.proof.bifurcation import BOTH, bifurcation_near
from vibropipe.proof.certificate import (
    MAX_MOVED_BY_ROUNDING,
    Certificate,
    Claim,
    Part,
    examine,
    largest_factor,
)
from vibropipe.proof.every import all_orbits
from vibropipe.proof.given import Given, balls_of, first_out_of_range
from vibropipe.proof.motion import displacement_bounds
from vibropipe.proof.outcome import (
    Outcome,
    critical_statement,
    described,
    every_statement,
    proved_scalars,
    statement,
)
from vibropipe.proof.three import three_impacts
from vibropipe.proof.values import amplitudes, spectral_radius, stability
from vibropipe.words.bifurcations import Bifurcation
from vibropipe.words.progress import Progress
from vibropipe.words.proofs import Proved, ProvedStable, Why
from vibropipe.words.vocabulary import describe

# Quantities with bounds, and their dimensions.
BOUNDED: Mapping[str, tuple[str, ...]] = {
    "impact_phase": ("impact",),
    "impact_velocity": ("impact",),
    "displacement_mean": (),
    "displacement_strobe": (),
    "velocity_strobe": (),
    "displacement_amplitude": ("harmonic",),
    "trace": (),
    "determinant": (),
    "spectral_radius": (),
}
AMPLITUDE = ("displacement_amplitude_low", "displacement_amplitude_high")


def prove_orbit(
    given: Given,
    within: Mapping[str, float] | None,
    harmonics: int,
    limit: int,
    seek_largest: bool,
    stretches: int,
    narrows: bool = True,
) -> xr.Dataset:
    """Return the dataset of `prove`; arguments are checked. narrows : whether its bounds matter."""
    with ctx.workprec(BITS):
        nominal = balls_of(given.exciter)
        claim = Claim(given.law, None, harmonics)
        guess = [*given.times, *given.frees]
        start = examine(Box(nominal), claim, guess, MAX_MOVED_BY_ROUNDING)
        if start.why is Why.NONE and start.values is not None:
            outcome = Outcome(Proved.PROVED, Why.NONE, parts=[start])
            claim.is_stable = stability(start.values)
            if within:
                box = _Tolerances(given.exciter, nominal, within, claim, start, limit, narrows)
                outcome = box.outcome(seek_largest)
        else:
            known = {name: getattr(given.exciter, name) for name in within or ()}
            is_refuted = start.refuted
            verdict = Proved.DISPROVED if is_refuted else Proved.UNDECIDED
            outcome = Outcome(verdict, start.why, counterexample=known if is_refuted else {})
        tubes = [displacement_bounds(part.orbit, stretches) for part in outcome.parts]
        dataset = _orbit_dataset(given, within, harmonics, claim, outcome)
        return _with_tube(dataset, tubes, stretches) if stretches else dataset


def _with_tube(
    dataset: xr.Dataset, tubes: Sequence[tuple[list[float], list[float]]], stretches: int
) -> xr.Dataset:
    """Add bounds of the displacement, those of all parts, over stretches of the orbit."""
    nothing = np.full(stretches, np.nan)
    low, high = zip(*tubes, strict=True) if tubes else ([nothing], [nothing])
    tube = {
        "displacement_low": ("phase", np.min(low, axis=0)),
        "displacement_high": ("phase", np.max(high, axis=0)),
    }
    phases = {"phase": np.arange(stretches) / stretches}
    return describe(dataset.assign(tube).assign_coords(phases))


def prove_critical(given: Given, kind: Bifurcation, along: str) -> xr.Dataset:
    """Return the dataset of `prove_bifurcation`; arguments are checked."""
    law, n = given.law, len(given.law.events)
    with ctx.workprec(BITS):
        guess = [*given.times, *given.frees]
        found = bifurcation_near(balls_of(given.exciter), law, guess, kind, along)
        is_proved = found.why is Why.NONE
        tube = found.tube if is_proved else [arb.nan()] * (2 * n)
        value = found.parameter if is_proved else arb.nan()
        periods = np.floor(given.times).astype(np.int64)[law.strikes]
        struck = [(tube[i], tube[n + i]) for i in law.strikes]
        phases = [t - int(period) for (t, _v), period in zip(struck, periods, strict=True)]
        variables: dict[str, Any] = {
            "impact_support": ("impact", np.array(law.supports, np.int8)),
            "impact_period": ("impact", periods),
            "bifurcation_kind": ((), np.int8(kind)),
            "grazing_support": ((), np.int8(found.touched)),
        }
        for end, rounded in (("low", round_down), ("high", round_up)):
            variables |= {
                f"impact_phase_{end}": ("impact", [rounded(a) for a in phases]),
                f"impact_velocity_{end}": ("impact", [rounded(v) for _t, v in struck]),
                f"{along}_{end}": ((), rounded(value)),
            }
    counts = [law.supports.count(support) for support in (1, 2)]
    verdict = Proved.PROVED if is_proved else Proved.UNDECIDED
    variables |= proved_scalars(verdict, found.why, 1, (law.m, *counts))
    del variables["parts"]
    ends = [float(variables[f"{along}_{end}"][1]) for end in ("low", "high")]
    attrs = {"statement": critical_statement(given, kind, along, ends, found)}
    dataset = described(given.exciter, variables, 0, attrs).drop_vars([along, "harmonic"])
    dataset["grazing_support"].attrs |= {
        "flag_values": np.array([0, 1, 2, BOTH], np.int8),
        "flag_meanings": "none support_1 support_2 both",
    }
    return dataset


@dataclass
class _Tolerances:
    """The box of an exciter within tolerances, and all larger and smaller ones of its shape."""

    exciter: Exciter
    nominal: Mapping[str, Any]
    within: Mapping[str, float]
    claim: Claim
    start: Part
    limit: int
    narrows: bool

    def attempt(self, factor: float) -> Certificate:
        """Try to prove the claim over a box."""
        off = {name: arb(most) * arb(factor) for name, most in self.within.items()}
        certificate = Certificate(
            self.nominal,
            off,
            self.claim,
            self.start.orbit,
            self.limit,
            narrows=self.narrows and factor == 1.0,
        )
        certificate.prove()
        return certificate

    def proves(self, factor: float) -> bool:
        """Return whether the claim is proved over a box, all of whose exciters exist."""
        is_in_range = not first_out_of_range(self.exciter, self.within, factor)
        return is_in_range and self.attempt(factor).tree is not None

    def outcome(self, seek_largest: bool) -> Outcome:
        """Return how the proof over the box ended."""
        tried = self.attempt(1.0)
        outcome = Outcome(Proved.UNDECIDED, tried.why, tried.examined)
        if tried.tree is not None:
            outcome.proved, outcome.largest = Proved.PROVED, 1.0
            outcome.parts = tried.tree.leaves()
        elif tried.counterexample is not None:
            outcome.proved, outcome.counterexample = Proved.DISPROVED, tried.counterexample
        if seek_largest:
            outcome.largest = largest_factor(self.proves, tried.tree is not None)
        return outcome


def prove_every(
    exciter: Exciter,
    law: tuple[int, int, int],
    harmonics: int,
    limit: int,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Return the dataset of `prove_all`; arguments are checked."""
    with ctx.workprec(BITS):
        nominal = balls_of(exciter)
        if law[1] + law[2] == 3:
            found = three_impacts(nominal, law, harmonics, limit, progress)
        else:
            found = all_orbits(nominal, law, harmonics, limit)
        orbits = [_of_orbit(part, nominal["l"]) for part in found.parts]
    n = law[1] + law[2]
    sizes = {"orbit": len(orbits), "impact": n, "harmonic": harmonics}
    dims: dict[str, tuple[str, ...]] = {"impact_support": ("impact",), "impact_period": ("impact",)}
    dims |= {f"{name}_{end}": of for name, of in BOUNDED.items() for end in ("low", "high")}
    dims |= {"proved_stable": (), "uniqueness_radius": ()}
    variables: dict[str, Any] = {}
    for name, inner in dims.items():
        shape = [sizes[dim] for dim in ("orbit", *inner)]
        values = np.array([each[name] for each in orbits]).reshape(shape)
        kind = np.int8 if name in ("impact_support", "proved_stable") else None
        variables[name] = (("orbit", *inner), values.astype(kind) if kind else values)
    verdict = Proved.PROVED if found.why is Why.NONE else Proved.UNDECIDED
    variables |= proved_scalars(verdict, found.why, found.looked, law)
    attrs = {"statement": every_statement(law, found)}
    return described(exciter, variables, harmonics, attrs, orbit=np.arange(len(orbits)))


def _orbit_dataset(
    given: Given, within: Mapping[str, float] | None, harmonics: int, claim: Claim, outcome: Outcome
) -> xr.Dataset:
    """Return the dataset of `prove`."""
    half_width = arb(given.exciter.l)
    if within:
        half_width = half_width + arb(within.get("l", 0.0))
    parts = [_of_orbit(part, half_width) for part in outcome.parts]
    supports, n = np.array(given.law.supports, np.int8), len(given.law.supports)
    sizes = {"impact": n, "harmonic": harmonics}
    variables: dict[str, Any] = {
        "impact_support": ("impact", supports),
        "impact_period": ("impact", np.floor(given.times).astype(np.int64)[given.law.strikes]),
    }
    for name, dims in BOUNDED.items():
        nothing = np.full([sizes[dim] for dim in dims], np.nan)
        for end, pick in (("low", np.min), ("high", np.max)):
            values = [part[f"{name}_{end}"] for part in parts]
            variables[f"{name}_{end}"] = (dims, pick(values, axis=0) if parts else nothing)
    radius = min((part["uniqueness_radius"] for part in parts), default=math.nan)
    counts = [int((supports == support).sum()) for support in (1, 2)]
    variables |= {
        "proved_stable": ((), np.int8(_stable_code(claim.is_stable))),
        "uniqueness_radius": ((), radius),
        **proved_scalars(outcome.proved, outcome.why, outcome.examined, (given.law.m, *counts)),
    }
    coords = {}
    if within:
        coords["parameter"] = list(within)
        wrong = [outcome.counterexample.get(name, math.nan) for name in within]
        variables |= {
            "within": ("parameter", list(within.values())),
            "counterexample": ("parameter", wrong),
            "largest": ((), outcome.largest),
        }
    told = statement(within, claim, counts, outcome)
    attrs = {"statement": told, "events": given.law.text}
    return described(given.exciter, variables, harmonics, attrs, **coords)


def _of_orbit(part: Part, half_width: Any) -> dict[str, Any]:
    """Return bounds of a proved orbit, its law and its radius of uniqueness."""
    orbit, values = part.orbit, part.values
    assert values is not None
    n, strikes = orbit.n, orbit.law.strikes
    periods = [math.floor(float(orbit.u[i].mid())) for i in strikes]
    balls = {
        "impact_phase": [orbit.tube[i] - k for i, k in zip(strikes, periods, strict=True)],
        "impact_velocity": [orbit.tube[n + i] for i in strikes],
        "displacement_mean": values.mean,
        "displacement_strobe": values.displacement,
        "velocity_strobe": values.velocity,
        "displacement_amplitude": amplitudes(values),
        "trace": values.trace,
        "determinant": values.determinant,
        "spectral_radius": spectral_radius(values),
    }
    bounds: dict[str, Any] = {
        "impact_support": list(orbit.law.supports),
        "impact_period": periods,
        "proved_stable": _stable_code(stability(values)),
        "uniqueness_radius": round_down(orbit.uniqueness_radius()),
    }
    for end, rounded in (("low", round_down), ("high", round_up)):
        for name, ball in balls.items():
            is_list = isinstance(ball, list)
            bounds[f"{name}_{end}"] = [rounded(a) for a in ball] if is_list else rounded(ball)
    # no motion between rigid supports has an amplitude above that of a square wave, 4 l/pi
    is_between = all(orbit.box.balls[k].is_zero() for k in ("k1", "k2"))
    most = round_up(4 * half_width / arb.pi()) if is_between else math.inf
    low, high = AMPLITUDE
    bounds[low] = [max(0.0, a) if a == a else 0.0 for a in bounds[low]]
    bounds[high] = [min(most, a) if a == a else most for a in bounds[high]]
    return bounds


def _stable_code(is_stable: bool | None) -> ProvedStable:
    return ProvedStable.UNDECIDED if is_stable is None else ProvedStable(int(is_stable))
