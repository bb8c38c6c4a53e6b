"""The linear motion of a logged piece."""

from __future__ import annotations

from typing import NamedTuple

from vibropipe.compiler import jit
from vibropipe.march.piece_log import CONTACT, DIRECTION, FORM, HOME
from vibropipe.march.piece_state import coefficients
from vibropipe.physics.contact import frame_at
from vibropipe.physics.friction import friction_of
from vibropipe.physics.housing import STANDS, momentum_rate


@jit
def load_of_piece(e, p, pieces, i):
    """Return (sigma, constant load) of a piece, friction included, with a housing that is held."""
    frame = frame_at(e, p, pieces.codes[i, HOME])
    return frame.sigma, frame.load - friction_of(e, p) * pieces.codes[i, DIRECTION]


class Terms(NamedTuple):
    """The motion y'' + damping y' + stiffness y = load + factor sigma F of a moving piece; load has its friction."""

    stiffness: float
    damping: float
    sigma: float
    load: float
    factor: float


@jit
def way_of(log, i) -> int:
    """Return the way of a housing in piece i; log : `PieceLog.housing`."""
    if log is None:
        return STANDS
    return int(log.way[i])


@jit
def terms_of(e, p, pieces, i) -> Terms:
    """Return the `Terms` of piece i."""
    home, way = pieces.codes[i, HOME], way_of(pieces.housing, i)
    stiffness, damping = coefficients(e, p, home, pieces.codes[i, FORM] == CONTACT)
    sigma, load = load_of_piece(e, p, pieces, i)
    if way == STANDS:
        return Terms(stiffness, damping, sigma, load, 1.0)
    factor = 1.0 + p.mass_ratio
    load = factor * (load - sigma * momentum_rate(p, way))
    return Terms(factor * stiffness, factor * damping, sigma, load, factor)
