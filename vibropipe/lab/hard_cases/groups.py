"""Groups of hard cases: what is hard, what is known independently, and why each bound is as large as it is.

A bound is the rounding of a double, 2e-16, times what a case multiplies it by, rounded up to a power of ten.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple


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
    Group("starts, ends, releases", "who moves in, moves off or is held", {
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
