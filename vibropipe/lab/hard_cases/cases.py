"""Table of hard cases: description, known property, measure and bound; and their groups, with the reason of each bound.

A bound is the rounding of a double, 2e-16, times what a case multiplies it by, rounded up to a power of ten.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import NamedTuple

from vibropipe.lab.hard_cases import contacts, labels, pieces, smooth
from vibropipe.lab.hard_cases.case import Bound, Case, flight_check


class Group(NamedTuple):
    """A group of cases: its title, what is known of its motions, and the reason of the bound of each case."""

    title: str
    known: str
    reasons: Mapping[str, str]


# Of a case that counts wrong answers: none is allowed.
YES_OR_NO = "yes or no"
GROWTH = "rounding of each event, which grows along the motion"

GROUPS = (
    Group("grazing", "struck or not, 10⁻⁴ to 10⁻¹² beyond or short of a support", {
        "grazing_free": YES_OR_NO, "grazing_forced": YES_OR_NO, "soft_grazing": YES_OR_NO,
        "friction_turn_at_support": YES_OR_NO,
    }),
    Group("starts, ends, releases", "whether the mass enters, leaves or stays on a support", {
        "start_on_support": YES_OR_NO, "end_on_impact": YES_OR_NO, "impact_at_release": YES_OR_NO,
        "soft_start": YES_OR_NO, "friction_edge_of_slip": YES_OR_NO, "friction_edge_of_stick": YES_OR_NO,
        "friction_for_ever": YES_OR_NO, "friction_release": "phase of a force, from an arcsine",
    }),
    Group("chatter, plastic supports", "sums of half turns; release where forces balance", {
        "chatter_complete": "thousands of flights, each rounded", "chatter_cut": "twelve flights, each rounded",
        "chatter_released": "phase of a release, up to τ = 200", "plastic": "phase of a release, up to τ = 60",
        "plastic_for_ever": "one impact time, rounded",
    }),
    Group("many impacts or periods", "energy; phase of the steady motion; equal intervals", {
        "ideal_free": "10⁶ impacts, evaluated one by one", "ideal_marched": "10⁶ impacts, each rounded",
        "million_periods": "10⁶ periods: rounding of the time", "growth_impacts": "1000 impacts, each rounded",
        "supports_together": "100 flights of 10⁻¹², counted from the start",
    }),
    Group("resonance, critical damping", "closed form; powers of a matrix exponential", {
        "growth_resonance": "growth over 50 periods", "near_resonance": "growth over 6 periods",
        "near_critical": "terms that nearly cancel",
    }),
    Group("extreme parameters", "each flight anew, by a matrix exponential", {
        "damping": "stiffest flight, h = 10⁴", "extremes": "fastest force, ν = 10⁴",
        "slow_force": "longest flights, ν = 10⁻⁴", "offset": "flights between rests",
        "chatter_interrupted": "shortest flights of a chatter",
    }),
    Group("energy balance", "work of the force = losses + stored", {
        "energy_of_motions": "sum over a motion", "energy_of_orbits": "sum over an orbit",
        "pieces_energy": "sum over an orbit",
    }),
    Group("labels, splitting, scaling", "law of the motion; the same motion in parts, scaled, mirrored", {
        "unbounded": YES_OR_NO, "period_multiples": YES_OR_NO, "coexisting": YES_OR_NO, "mirrored": YES_OR_NO,
        "refused": YES_OR_NO, "scale_of_length": "powers of two, but for underflow",
        "split": "two marches, whose difference grows", "weakly_stable": "multiplier 0.9999: rounding times 10⁴",
        "slow_drift": "1 − R = 10⁻⁴: rounding times 10⁴",
    }),
    Group("soft supports", "energy; load over stiffness; solutions of 40 digits", {
        "soft_shallow": "depth from a difference of energies",
        "soft_without_loss": "hundreds of contacts, each rounded",
        "soft_stiff": GROWTH, "soft_overdamped": GROWTH, "soft_to_rigid": "next order in 1/√k",
        "soft_pressed": "depth from a difference of displacements", "soft_bounces": GROWTH, "soft_together": GROWTH,
        "soft_and_rigid": GROWTH,
    }),
    Group("friction, load, second harmonic", "turning points; solutions of 40 digits", {
        "friction_decay": "500 turns, each rounded", "friction_chatter": GROWTH, "friction_plastic": GROWTH,
        "friction_sticks": GROWTH, "friction_in_support": GROWTH, "friction_resonance": GROWTH,
        "friction_fast_force": GROWTH, "friction_to_zero": "friction moves a motion by at most 10⁴ of itself",
        "second_alone": GROWTH, "load_pressed": GROWTH,
    }),
)  # fmt: skip

GROUP_OF = {name: group for group in GROUPS for name in group.reasons}


STRIKES_AS_IT_IS = "impact above, none below the method's own peak"
FLIGHTS = (
    "exact: each flight is the closed form from impact to impact; newmark: inside, reset by eq. (6)"
)
PROPAGATED = "end by the matrix exponential; newmark: powers of its one-step matrix"

DIGITS = "times and velocities of all events, and the end, to 40 digits"


def by_digits(name: str, description: str, tasks: Sequence[pieces.Task]) -> Case:
    """Return a case of further effects that is compared with motions of 40 digits, by the exact method."""
    measure = partial(pieces.agrees_with_reference, tasks=tasks)
    return Case(name, description, DIGITS, measure, Bound(1e-11, None))


CASES = (
    Case("grazing_free", "free motion, peak 1e-4, 1e-6, ..., 1e-12 beyond a support or short of it; both supports",
         f"{STRIKES_AS_IT_IS}; wrong answers of 20", contacts.grazes_free, Bound(0.0, 0.0)),
    Case("grazing_forced", "forced, damped motion, the same depths",
         f"{STRIKES_AS_IT_IS}; wrong answers of 10", contacts.grazes_forced, Bound(0.0, 0.0)),
    Case("start_on_support", "start on a support moving out, at rest, in; pressed, pulled, balanced",
         "one impact if it moves in, else none; sticks if not pulled; wrong of 18",
         contacts.starts, Bound(0.0, 0.0)),
    Case("end_on_impact", "impact and end at one instant, and 1e-9 apart; R = 0 and 0.6",
         "an impact at the end is counted; wrong of 12", contacts.ends_on_impact, Bound(0.0, 0.0)),
    Case("impact_at_release", "R = 0, reached at the release time, and 1e-9 before and after",
         "one impact, then off the support; wrong of 6", contacts.strikes_at_release, Bound(0.0, 0.0)),
    Case("supports_together", "100 ideal impacts, l = 1e-3 to 1e-12",
         "strikes in turn, every 2 arcsin l", contacts.supports_together, Bound(1e-10, 1e-4)),
    Case("chatter_complete", "complete chatter, R = 0.05 to 0.99, pressed permanently",
         "accumulation at the sum of its half turns; sticks to the end; bounded impacts",
         contacts.chatter_ends, Bound(1e-12, 0.1, 2)),
    Case("chatter_cut", "chatter ended by the end, or by a period's end, after 12 impacts; R = 0.5, 0.8, 0.95",
         "exact: impact 12 by the sum of half turns; newmark: inside, reset by eq. (6)",
         contacts.chatter_cut, Bound(1e-12, 0.0)),
    Case("chatter_released", "complete chatter, R = 0.05 to 0.9, ended by release",
         "released where f sin(nu tau) = x of the support, whatever the method",
         contacts.chatter_released, Bound(1e-12, 1e-12)),
    Case("chatter_interrupted", "chatter interrupted by release, R = 0.9 to 0.99",
         FLIGHTS, partial(flight_check, tasks=contacts.INTERRUPTED), Bound(1e-12, 0.0)),
    Case("plastic", "R = 0 on either or both supports",
         "sticks from the impact on; released where the force equals the spring's",
         contacts.plastic, Bound(1e-12, 1e-12)),
    Case("plastic_for_ever", "R = 0, pressed permanently",
         "one impact at arccos(2/3), then sticking to the end", contacts.plastic_for_ever, Bound(1e-14, 0.1, 2)),
    Case("ideal_free", "R = 1, h = 0, f = 0 over 1e6 impacts from x = 0, x' = -0.51; newmark: from a higher speed",
         "x^2 + x'^2 is constant, without drift", partial(smooth.keeps_energy, f=0.0), Bound(1e-10, 1e-8)),
    Case("ideal_marched", "the same with f = 1e-300: time marching from impact to impact",
         "x^2 + x'^2 is constant, but for roundings of a step, which add up to 1e-15 an impact at most",
         partial(smooth.keeps_energy, f=1e-300), Bound(1e-9, 1e-8)),
    Case("growth_resonance", "resonance without loss, 50 periods",
         "x = (sin tau - tau cos tau)/2; newmark: powers of its one-step matrix",
         smooth.grows_at_resonance, Bound(1e-12, 1e-10)),
    Case("growth_impacts", "resonance of the struck mass: R = 1, h = 0, nu = 2, support at the equilibrium",
         "impact n at 4n/3; exact 1000 of them, newmark 20", smooth.grows_by_impacts, Bound(1e-12, 0.5, 2)),
    Case("near_resonance", "h = 0, nu = 1 and 1 +- 1e-6, 1e-9, 1e-12; 6 periods",
         PROPAGATED, partial(smooth.linear_check, exciters=smooth.NEUTRAL, periods=6), Bound(1e-12, 1e-11)),
    Case("near_critical", "h = 2 and 2 +- 1e-6, 1e-12; 2 periods",
         PROPAGATED, partial(smooth.linear_check, exciters=smooth.CRITICAL, periods=2), Bound(1e-12, 1e-11)),
    Case("damping", "h = 0, 1e-12, 2, 2 + 1e-12, 50, 1e4, with impacts",
         FLIGHTS, partial(flight_check, tasks=smooth.DAMPED), Bound(1e-10, 0.0)),
    Case("extremes", "nu = 1e4; f = 0, 1e-300, 1e6, 1e8; l = 1e-9, 1e9",
         FLIGHTS, partial(flight_check, tasks=smooth.EXTREME), Bound(1e-10, 0.0)),
    Case("slow_force", "nu = 1e-4 over two periods",
         FLIGHTS, partial(flight_check, tasks=smooth.SLOW), Bound(1e-9, 0.0)),
    Case("offset", "delta = l, -l, and beyond both",
         FLIGHTS, partial(flight_check, tasks=smooth.OFFSET), Bound(1e-12, 0.0)),
    Case("scale_of_length", "l, f, delta times 2^-1000 to 2^500",
         "the same motion, scaled", smooth.scales, Bound(1e-12, 1e-12)),
    Case("million_periods", "1e6 periods, nu = 0.7, 1, 3^(1/2); newmark as many as 1e8 steps are",
         "phase of the steady motion; newmark's own by its transfer function",
         smooth.holds_phase, Bound(1e-9, 1e-8)),
    Case("energy_of_motions", "five motions, with impacts, chatter, rest, without damping, without impacts",
         "work of the force = damping + losses at the supports + stored; newmark: over its own steps",
         smooth.balance, Bound(1e-12, 1e-12)),
    Case("energy_of_orbits", "three orbits, with impacts and rest",
         "work of the force = damping + losses at the supports, per forcing period",
         smooth.balance_of_orbits, Bound(1e-11, None)),
    Case("unbounded", "resonance at R = 1, h = 0: unbounded growth",
         "labelled unbounded, with and without impacts; newmark: at its own resonance; wrong of 2",
         labels.unbounded, Bound(0.0, 0.0)),
    Case("period_multiples", "orbits of 1, 2, 3, 4, 5, 8, 16, 32 periods",
         "struck once in m periods, nu = 2m, stable; wrong of 8", labels.multiples, Bound(0.0, 0.0)),
    Case("weakly_stable", "multipliers 0.9 to 0.9999, started far off",
         "amplitude |f|/|1 - nu^2 + i h nu| and multiplier; newmark: its own steady motion",
         labels.weakly_stable, Bound(1e-10, 1e-5)),
    Case("slow_drift", "struck mass that covers 1 - R of its remaining distance in a period, R = 0.9 to 0.9999",
         "impact velocity (4/3)/(1 - R), or labelled as not settled; newmark: no drift once settled",
         labels.drifts, Bound(1e-9, 1e-5)),
    Case("coexisting", "two attractors of one exciter",
         "no impact from its own orbit, two-sided if started fast; wrong of 2",
         labels.coexisting, Bound(0.0, 0.0)),
    Case("mirrored", "five exciters and their mirror images",
         "bitwise mirrored; number of differing values", labels.mirrored, Bound(0.0, 0.0)),
    Case("split", "motions split in two",
         "the end of the unsplit motion", labels.split, Bound(1e-9, 1e-9)),
    Case("refused", "nan, inf, negative h or l, R outside [0, 1], nu < 0, start outside the supports",
         f"rejected by name; wrong of {len(labels.BAD)}", labels.rejects_bad_input, Bound(0.0, 0.0)),
    Case("soft_grazing", "soft support, peak 1e-4, 1e-6, ..., 1e-12 beyond it or short of it",
         "touched from above, not from below; wrong answers of 10", pieces.grazes_soft, Bound(0.0, None)),
    Case("soft_shallow", "soft support, free contacts of an energy of 1e-2 to 1e-8",
         "depth by the energy", pieces.shallow_contacts, Bound(1e-7, None)),
    Case("soft_without_loss", "soft supports without damping, k = 1 to 1e8, 40 units of time",
         "the same speed at every contact", pieces.keeps_energy, Bound(1e-12, None)),
    by_digits("soft_stiff", "damped soft supports, k = 1e5, 1e6, 1e8", pieces.STIFF),
    by_digits("soft_overdamped", "soft supports of critical damping, a little more and 8 times it", pieces.OVERDAMPED),
    Case("soft_to_rigid", "k = 1e4, 1e6, 1e8 with a fifth of critical damping",
         "restitution exp(-pi z/sqrt(1 - z^2)) but for 1/sqrt(k): distance of the order from 1/2",
         pieces.tends_to_rigid, Bound(0.02, None)),
    Case("soft_start", "start on a soft support moving in, at rest, out; pressed and pulled",
         "in contact if it moves in or is pressed; wrong of 6", pieces.starts_on_soft, Bound(0.0, 0.0)),
    Case("soft_pressed", "pressed on a soft support for ever, k = 10 to 1e4",
         "load over stiffness, to rounding of x", pieces.sinks_in, Bound(1e-11, None)),
    by_digits("soft_bounces", "bounces on a soft support that end in contact for ever", pieces.BOUNCES),
    by_digits("soft_together", "soft supports 2e-2 to 2e-6 apart, struck in turn", pieces.TOGETHER),
    by_digits("soft_and_rigid", "one soft support and one rigid", pieces.ONE_SOFT),
    Case("friction_decay", "free motion against friction of 0.1 to 1e-3: 5 to 500 turns",
         "turns at n pi, each 2 d nearer", pieces.decays_by_friction, Bound(1e-12, None)),
    Case("friction_edge_of_slip", "held, the largest force being the friction, or 1e-12 more or less",
         "slips if it is more; wrong of 12", pieces.edge_of_slipping, Bound(0.0, None)),
    Case("friction_edge_of_stick", "at rest where the spring pulls as much as the friction, or 1e-12 more or less",
         "moves if it is more; wrong of 18", pieces.edge_of_sticking, Bound(0.0, None)),
    Case("friction_turn_at_support", "turning point on a rigid or soft support, and 1e-9 before and beyond",
         "struck if beyond; wrong of 6", pieces.turns_at_support, Bound(0.0, None)),
    by_digits("friction_chatter", "chatter, R = 0.5 to 1, friction up to 98 % of the pull", pieces.CHATTER),
    Case("friction_release", "at rest on a support, released against friction",
         "where the force is the pull and the friction", pieces.released_late, Bound(1e-12, None)),
    by_digits("friction_plastic", "R = 0 with friction: held on a support that does not press", pieces.PLASTIC),
    by_digits("friction_sticks", "sticks between impacts, with slow and fast forces", pieces.STICKS),
    by_digits("friction_in_support", "turns and sticks while in contact with a soft support", pieces.STUCK_IN_SUPPORT),
    by_digits("friction_resonance", "resonance without damping, held down by friction", pieces.RESONANT),
    by_digits("friction_fast_force", "nu = 40: friction, and damped supports of k = 1e5", pieces.FAST),
    Case("friction_to_zero", "friction of 1e-6 to 1e-12 against none",
         "motions that differ by no more than 1e4 of it", pieces.frictionless_limit, Bound(1.0, None)),
    Case("friction_for_ever", "held by friction for ever",
         "an orbit where it starts; wrong of 3", pieces.held_for_ever, Bound(0.0, None)),
    by_digits("second_alone", "second harmonic alone: struck, slow with rests, with friction, on soft supports",
              pieces.SECOND_ALONE),
    by_digits("load_pressed", "a load presses the mass on a rigid support, a soft one, or short of one; with friction",
              pieces.PRESSED),
    Case("pieces_energy", "orbits with soft contacts, turns and sticks",
         "work of the force = all losses", pieces.orbit_balances, Bound(1e-12, None)),
)  # fmt: skip
