"""What a boundary meets: the integers that datasets hold."""

from __future__ import annotations

from enum import IntEnum


class Meeting(IntEnum):
    """What a boundary meets, or why it ends.

    BOX: a side of the box. CUSP: two folds. GRAZING_FOLD, GRAZING_FLIP, GRAZING_PITCHFORK: the orbit of that
    bifurcation touches a support. DOUBLE_GRAZING: an orbit touches twice. DEGENERATE_FLIP, DEGENERATE_PITCHFORK: the
    bifurcation changes its direction, and a fold of the orbits that it creates begins. CHATTER, REST: the force
    presses the mass on the support that it touches. LOST: no further point was found. POINTS: there are too many.
    CHANGE: turns or sticks of the orbit begin or end.
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
