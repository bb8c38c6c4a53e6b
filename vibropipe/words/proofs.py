"""What a proof is about, and how it ended."""

from __future__ import annotations

from enum import IntEnum

import numpy as np

from vibropipe.words.designs import Reasoned

BOXED = ("nu", "f", "h", "l", "delta", "R1", "R2", "load", "f2", "phi2")
"""The parameters on which a motion between rigid supports depends, those of the boxes of a proof."""
PREFIX = "proof_"
"""Of what a certificate adds to the dataset of a scene: `proof_<name>` is `<name>` of the proof."""
REFUSED = f"{PREFIX}refused"
"""Attribute: why nothing was tried to prove."""
MISSING = "python-flint: is required for proofs and not installed"


class Proved(IntEnum):
    """Whether a statement is proved, or disproved by a counterexample."""

    UNDECIDED = 0
    PROVED = 1
    DISPROVED = 2


class ProvedStable(IntEnum):
    """Which stability of an orbit is proved."""

    UNDECIDED = -1
    UNSTABLE = 0
    STABLE = 1


class Why(Reasoned):
    """What of a statement is not proved, or is disproved."""

    NONE = 0, "nothing"
    EXISTENCE = 1, "that the orbit exists and is the only one nearby"
    MOTION = 2, "that no flight leaves the supports"
    PERIOD = 3, "that the orbit has no shorter period"
    STABILITY = 4, "on which side of the unit circle the multipliers lie"
    FAMILY = 5, "that the orbits of all parts are one family"
    PARTS = 6, "with the parts that were allowed"
    NOT_TRIED = 7, "since only orbits that strike a support and do not rest on one are tried"


def tally(proved: np.ndarray, why: np.ndarray, left_out: np.ndarray) -> tuple[int, int, int]:
    """Return how many rows are proved, were tried and were not tried, without those that are left out.

    Orbits at a bifurcation are about to end, by rounding on either side: they are to be left out.
    """
    proved, why = (np.delete(codes, left_out) for codes in (proved, why))
    tried = int((why != Why.NOT_TRIED).sum())
    return int((proved == Proved.PROVED).sum()), tried, why.size - tried
