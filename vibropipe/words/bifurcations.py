"""Bifurcations of branches, why a branch ends, and what a boundary meets: the integers that datasets hold."""

from __future__ import annotations

from collections.abc import Mapping
from enum import IntEnum
from typing import Any

from vibropipe.words.parameters import PARAMETERS, THROUGH_OTHERS, occurs


class Meeting(IntEnum):
    """What a boundary meets, or why it ends.

    BOX: a side of the box. CUSP: two folds. GRAZING_FOLD, GRAZING_FLIP, GRAZING_PITCHFORK: the orbit of that
    bifurcation touches a support. DOUBLE_GRAZING: an orbit touches twice. DEGENERATE_FLIP, DEGENERATE_PITCHFORK: the
    bifurcation changes its direction, and a fold of the orbits that it creates begins. CHATTER, REST: the force
    presses the mass on the support that it touches. LOST: no further point was found. POINTS: there are too many.
    CHANGE: turns, sticks or slips of the orbit begin or end. On a level curve FOLD, FLIP, PITCHFORK, GRAZING: its orbit
    is that bifurcation.
    """

    BOX = 0
    CUSP = 1
    GRAZING_FOLD = 2
    GRAZING_FLIP = 3
    GRAZING_PITCHFORK = 4
    DOUBLE_GRAZING = 5
    DEGENERATE_FLIP = 6
    DEGENERATE_PITCHFORK = 7
    CHATTER = 8
    REST = 9
    LOST = 10
    POINTS = 11
    CHANGE = 12
    FOLD = 13
    FLIP = 14
    PITCHFORK = 15
    GRAZING = 16


class Bifurcation(IntEnum):
    """Where a branch turns, doubles its period, loses its symmetry, touches a support, or ends.

    CHANGE: on a branch that begins with rests, soft supports, friction or a housing, where contacts, turns, sticks,
    rests or slips of the orbit begin or end. NEIMARK_SACKER: with a housing, where a pair of multipliers meets the unit
    circle.
    """

    FOLD = 0
    FLIP = 1
    PITCHFORK = 2
    GRAZING = 3
    END = 4
    CHANGE = 5
    NEIMARK_SACKER = 6


class BranchEnd(IntEnum):
    """Why a branch does not go on beyond a bifurcation.

    GOES_ON: it does. OTHER_SEQUENCE: the impact sequence changes at a grazing, or that of other events, and no orbit
    goes on. PARENT: the branch of orbits of half the period, or symmetric, is reached. CHATTER: an impact loses its
    speed where the force presses the mass on its support. REST: the mass sticks. CLOSED: the branch returns to its
    start. LOST: no further point was found. POINTS: it has too many. ROUNDING: a bifurcation is so steep that rounding
    hides what begins there. IMPACT_LIMIT and PERIOD_LIMIT: the orbits that begin there have more impacts or periods
    than are followed. With one of the last three at a flip or pitchfork the branch itself goes on. CONTINUUM: orbits
    are not isolated there (without damping, at a multiple of the natural period): all have the same parameter.
    """

    GOES_ON = 0
    OTHER_SEQUENCE = 1
    PARENT = 2
    CHATTER = 3
    REST = 4
    CLOSED = 5
    LOST = 6
    POINTS = 7
    ROUNDING = 8
    IMPACT_LIMIT = 9
    PERIOD_LIMIT = 10
    CONTINUUM = 11


BESIDE_LAW = "must be left out beside law, whose stretches are sought from many starts"
# Why parameters of an absent effect have none.
WITHOUT = {
    "soft": "the support is rigid", "friction": "there is no friction",
    "second_harmonic": "the force has no second harmonic", "housing": "the housing is fixed",
}  # fmt: skip


def without_slope(values: Mapping[str, Any], along: str) -> dict[str, str]:
    """Return the parameters by which the place of a bifurcation has no derivative, and what must hold of each.

    values : of the exciter, those that vary with all their values
    """
    refused = {along: "must be left out: it is followed"}
    for name, entry in PARAMETERS.items():
        support = f"k{name[1]}" if entry.effect == "soft" else ""
        needs = {"soft": support, "friction": "friction", "second_harmonic": "f2"}
        needs |= {"housing": "mass_ratio"}
        if THROUGH_OTHERS.get(name) == {}:
            refused[name] = "must be left out: it acts on no motion"
        elif entry.effect in needs and not occurs(values.get(needs[entry.effect], 0.0)):
            refused[name] = f"must be left out: {WITHOUT[entry.effect]}"
        elif name == "friction_ratio" and not occurs(values.get(name, 1.0) - 1.0):
            refused[name] = "must be left out: static friction is that against sliding"
    return refused
