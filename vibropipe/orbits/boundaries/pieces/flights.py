"""The march of an orbit that was replayed, and where its flights come closest to a support."""

from __future__ import annotations

import numpy as np

from vibropipe.compiler import jit
from vibropipe.march.piece_log import AT, CAUSE, FORM, FREE, HOME, SPAN, STICK, TURN
from vibropipe.orbits.boundaries.pieces.replay import gap_to, state_within
from vibropipe.physics.contact import to_displacement, to_velocity
from vibropipe.physics.load import forcing_period

# Samples of a flight in the search for its least gap.
SAMPLES = 64


@jit
def motion_within(e, p, pieces, i, span):
    """Return (x, x') of piece i after a time span."""
    y, w = state_within(e, p, pieces, i, span)
    home = pieces.codes[i, HOME]
    return to_displacement(p, home, y), to_velocity(home, w)


@jit
def nearest_touch(e, p, pieces, touch) -> None:
    """Fill touch (4,) with the least gap at which a flight turns, the piece, the support, and the phase.

    The gap is infinite where no flight turns towards a support.
    """
    touch[0], touch[1], touch[2], touch[3] = np.inf, 0.0, 0.0, 0.0
    n = pieces.values.shape[0] - 1
    for i in range(1, n + 1):
        if pieces.codes[i, FORM] != FREE:
            continue
        home, span = pieces.codes[i, HOME], pieces.values[i, SPAN]
        follows = pieces.codes[i + 1 if i < n else 1, CAUSE]
        begin, period = pieces.values[i, AT], forcing_period(p)
        for side in (1, 2):
            before, here = np.inf, np.inf
            for k in range(SAMPLES + 1):
                y, _w = state_within(e, p, pieces, i, span * k / SAMPLES)
                gap = gap_to(p, home, y, side)
                lowest = here < before and here <= gap
                at = k - 1
                if k == SAMPLES and gap < here and follows in (TURN, STICK):
                    lowest, at, here = True, k, gap
                if lowest and at > 0 and abs(here) < abs(touch[0]):
                    touch[0], touch[1], touch[2] = here, i, side
                    touch[3] = begin + span * at / SAMPLES / period
                before, here = here, gap
