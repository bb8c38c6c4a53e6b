"""References for tests: closed forms, motions of the oracle with their sensitivity to rounding, long marches."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any, NamedTuple

import mpmath
import numpy as np
import pytest
from oracles import Motion, Oracle
from textbook import Parameters, digits

REFERENCE = Path(__file__).parents[1] / "reference"
ULP = 2.0**-52
SMALL = 1e-30  # relative perturbation that shows how far rounding of the input moves a motion
# the exact method, and Newmark's with coarse and fine steps
METHODS: list[dict[str, Any]] = [
    {},
    *({"method": "newmark", "steps_per_period": n} for n in (20, 97, 1000)),
]
methods = pytest.mark.parametrize(
    "method", METHODS, ids=lambda m: str(m.get("steps_per_period", "exact"))
)
NUDGE = (1.0, -0.9, 0.8, 0.9, -0.7, -1.0, 0.8)  # nu, f, h, support 1, support 2, R1, R2


def reference(name: str) -> dict[str, dict[str, Any]]:
    """Entries of reference/<name>.json by their names; numbers are text of 20 digits."""
    entries = json.loads((REFERENCE / f"{name}.json").read_text())
    return {entry["name"]: entry for entry in entries}


def parameters_of(entry: dict[str, Any]) -> Parameters:
    return Parameters(**{name: float(entry[name]) for name in Parameters._fields})


# -- closed forms ------------------------------------------------------------------------------


def linear_amplitude(p: Parameters) -> float:
    """Amplitude of the linear steady state, |f| / |1 - nu^2 + i h nu|."""
    return abs(p.f) / abs(complex((1 - p.nu) * (1 + p.nu), p.h * p.nu))


def determinant(p: Parameters, periods: float, struck: tuple[int, int]) -> float:
    """Determinant of the return map over `periods` forcing periods: exp(-h T) prod R_i^2."""
    duration = 2 * math.pi * periods / p.nu
    return math.exp(-p.h * duration) * p.R1 ** (2 * struck[0]) * p.R2 ** (2 * struck[1])


def energy(x: Any, v: Any) -> Any:
    """Energy of the spring and the mass."""
    return (x * x + v * v) / 2


def backbone_velocity(delta_over_l: float, tau_bar: float) -> float:
    """Equation (10): velocity at support 1 over l when the period is tau_bar."""
    cos, sin = math.cos(tau_bar / 2), math.sin(tau_bar / 2)
    return (1 - delta_over_l + (1 + delta_over_l) * cos) / sin


# -- how far roundings move a motion -----------------------------------------------------------


class Judged(NamedTuple):
    """A motion of the oracle, and its changes by one ulp in every input (inf: other events)."""

    motion: Motion
    wobble_end: tuple[float, float]
    wobble_tau: list[float]  # per impact
    wobble_velocity: list[float]
    wobble_rest: list[tuple[float, float]]  # start, end


def judge(
    p: Parameters, tau_end: float, x0: float = 0.0, v0: float = 0.0, tau_start: float = 0.0
) -> Judged:
    """Return a motion of the oracle with its changes by a perturbation of every input."""
    # at a distance of SMALL from resonance the closed form loses 60 digits
    context = digits(p, 110 if p.nu == 1 and p.h == 0 else 50)
    base = Oracle(p, context).run(tau_end, x0, v0, tau_start)
    small = context.mpf(SMALL)
    other = Oracle(p, context, [small * weight for weight in NUDGE])
    start = {p.upper: other.bound[1], p.lower: other.bound[2]}.get(x0, x0 * (1 - small))
    near = other.run(tau_end, start, v0 * (1 + small), tau_start)
    if not same_events(base, near):
        return Judged(base, (math.inf,) * 2, [], [], [])
    return Judged(
        base,
        (
            ulps(near.displacement_end - base.displacement_end),
            ulps(near.velocity_end - base.velocity_end),
        ),
        [ulps(a.tau - b.tau) for a, b in zip(base.impacts, near.impacts, strict=True)],
        [ulps(a.before - b.before) for a, b in zip(base.impacts, near.impacts, strict=True)],
        [
            (ulps(a.start - b.start), 0.0 if math.isinf(a.end) else ulps(a.end - b.end))
            for a, b in zip(base.rests, near.rests, strict=True)
        ],
    )


def same_events(one: Motion, two: Motion) -> bool:
    """Return whether two motions have the same sequence of impacts and of rests."""
    impacts = ([i.support for i in motion.impacts] for motion in (one, two))
    rests = ([r.support for r in motion.rests] for motion in (one, two))
    return all(first == second for first, second in (impacts, rests))


def ulps(difference: Any) -> float:
    """Return the change by one ulp from the change by a perturbation of SMALL."""
    return float(abs(difference) / mpmath.mpf(SMALL)) * ULP


# -- motions in datasets -----------------------------------------------------------------------


def impacts_of(ds: Any) -> list[tuple[float, int, float, float]]:
    """Impacts of a dataset as (tau, support, before, after)."""
    columns = ("impact_tau", "impact_support", "impact_velocity", "impact_velocity_after")
    return list(zip(*(ds[name].values.tolist() for name in columns), strict=True))


def rests_of(ds: Any) -> list[tuple[float, float, int]]:
    """Rests of a dataset as (start, end, support), without those of no duration."""
    columns = ("rest_start", "rest_end", "rest_support")
    rests = zip(*(ds[name].values.tolist() for name in columns), strict=True)
    return [rest for rest in rests if rest[1] > rest[0]]


def cut_off(p: Parameters, motion: Motion, least: float = 1e-6) -> float:
    """Return a speed that no impact is close to, about `least` of the largest speed of impacts or by the force."""
    speeds = [abs(float(impact.before)) for impact in motion.impacts]
    distance = max(abs(p.upper), abs(p.lower))
    speed = least * max([*speeds, math.sqrt((abs(p.f) + distance) * distance)])
    while any(abs(s / speed - 1) < 1e-3 for s in speeds):
        speed *= 1.01
    return speed


def disagreements(p: Parameters, ds: Any, judged: Judged, tau_end: float) -> list[str]:
    """Return the differences between a dataset of `vp.simulate` and the oracle's motion, as texts.

    Bound: 1e-12 of the size of the quantity plus 100 times its change by one ulp of the input; for velocities, also
    100 ulps of the displacements that they are computed from.
    """
    motion, differences = judged.motion, []
    starts = [motion.state(start) for start, _ in motion.pieces]
    sizes = [max(abs(float(state[k])) for state in starts) for k in (0, 1)]
    sizes[1] = max([sizes[1], *(abs(float(i.before)) for i in motion.impacts)])
    sizes[0] = max(sizes[0], abs(float(motion.displacement_end)))
    sizes[1] = max(sizes[1], abs(float(motion.velocity_end)))

    def compare(what: str, got: float, want: Any, size: float, wobble: float) -> None:
        bound = 1e-12 * size + 100 * wobble
        miss = abs(float(got - want)) if math.isfinite(got) else math.inf
        if not miss <= bound:
            text = mpmath.nstr(want, 18)
            differences.append(f"{what}: {got!r}, oracle {text}, off by {miss:.2e} > {bound:.2e}")

    least = cut_off(p, motion)
    rounding = sizes[0] * ULP
    computed = [i for i in impacts_of(ds) if abs(i[2]) > least]
    expected = [(k, i) for k, i in enumerate(motion.impacts) if abs(i.before) > least]
    if [i[1] for i in computed] != [i.support for _, i in expected]:
        differences.append(f"impacts: {len(computed)} above {least:.1e}, oracle {len(expected)}")
    for (tau, _, before, _), (k, impact) in zip(computed, expected, strict=False):
        compare(f"impact {k} tau", tau, impact.tau, tau_end, judged.wobble_tau[k])
        wobble = judged.wobble_velocity[k] + rounding
        compare(f"impact {k} velocity", before, impact.before, sizes[1], wobble)
    rests = rests_of(ds)
    if [r[2] for r in rests] != [r.support for r in motion.rests]:
        differences.append(f"rests: {rests}, oracle {[tuple(map(float, r)) for r in motion.rests]}")
    for k, (got, rest) in enumerate(zip(rests, motion.rests, strict=False)):
        start, end = judged.wobble_rest[k]
        compare(f"rest {k} start", got[0], rest.start, tau_end, start)
        if rest.end <= tau_end:
            compare(f"rest {k} end", got[1], rest.end, tau_end, end)
        elif not got[1] >= tau_end:
            differences.append(f"rest {k} ends at {got[1]}, oracle {float(rest.end)}")
    x, v = float(ds.displacement_end), float(ds.velocity_end)
    compare("displacement_end", x, motion.displacement_end, sizes[0], judged.wobble_end[0])
    compare("velocity_end", v, motion.velocity_end, sizes[1], judged.wobble_end[1] + rounding)
    return differences


# -- long marches ---------------------------------------------------------------------------


class Orbit(NamedTuple):
    """The end of a long march; period_multiple is 0 if nothing repeats."""

    period_multiple: int
    struck: tuple[float, float]  # impacts per orbit (per period if nothing repeats)
    strobe: tuple[float, float]


def brute_force_orbit(
    p: Parameters, x0: float = 0.0, v0: float = 0.0, patience: int = 3000, most: int = 64
) -> Orbit:
    """March `patience` periods in doubles, then find the period over 2 * `most` more.

    Every period starts at phase zero again, so that tau stays small and exact.
    """
    oracle, period = Oracle(p, mpmath.fp), 2 * math.pi / p.nu
    x, v = x0, v0
    strobes, counts = [], []
    for n in range(patience + 2 * most):
        motion = oracle.run(period, x, v)
        x, v = motion.displacement_end, motion.velocity_end
        x = min(max(x, p.lower), p.upper)
        if n >= patience:
            strobes.append((x, v))
            counts.append([sum(i.support == k for i in motion.impacts) for k in (1, 2)])
    states, struck = np.array(strobes), np.array(counts, dtype=float)
    for m in range(1, most + 1):
        if np.abs(states[m:] - states[:-m]).max() < 1e-7:
            total = struck[-m:].sum(axis=0)
            return Orbit(m, (total[0], total[1]), strobes[-1])
    mean = struck.mean(axis=0)
    return Orbit(0, (mean[0], mean[1]), strobes[-1])
