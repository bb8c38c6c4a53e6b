"""The equation of the momentum beside a sliding housing, the third of a piece; where that stops, its velocity."""

from __future__ import annotations

from vibropipe.compiler import jit
from vibropipe.march.piece_log import CAUSE, HOME, HOUSING_STOP
from vibropipe.orbits.law.law import WAY
from vibropipe.orbits.law.sliding import pull_by, pull_of, way_of
from vibropipe.orbits.law.states import momentum_after, momentum_before, sign_of


@jit
def momentum_rate(p, law, i) -> float:
    """Return the rate of q during piece i, beside a housing that slides, in its frame."""
    return sign_of(law.codes[i, HOME]) * pull_of(p, way_of(law, i))


@jit
def momentum_rest(e, p, law, i, u, time, sign, w, pulls):
    """Return the third residual of row i, and its slope by the time of its piece; zeros where the housing is held.

    time : of the piece, in tau
    sign : of the next state in the frame of the piece
    w, pulls : velocity at the end of the piece, and its rate
    """
    last = (i - 1) % law.codes.shape[0]
    if law.codes[last, WAY] == 0:
        return 0.0, 0.0
    rate = momentum_rate(p, law, last)
    ahead = momentum_after(e, p, law, last, u).q + rate * time
    if law.codes[i, CAUSE] == HOUSING_STOP:
        return ahead - w, rate - pulls
    return ahead - sign * momentum_before(e, p, law, i, u).q, rate


@jit
def fill_momentum(e, p, law, i, u, time, sign, columns, blocks) -> None:
    """Fill the derivatives of the third equation of row i at a fixed time, in tau, from those of the second."""
    before, at, by, _rest, _c = blocks
    last = (i - 1) % law.codes.shape[0]
    for c in range(3):
        before[i, 2, c], at[i, 2, c] = 0.0, 0.0
    for j in range(columns.size):
        by[i, 2, j] = 0.0
    if law.codes[last, WAY] == 0:
        at[i, 2, 2] = 1.0
        return
    sigma, way = sign_of(law.codes[last, HOME]), way_of(law, last)
    start = momentum_after(e, p, law, last, u)
    before[i, 2, 1], before[i, 2, 2] = start.q_1, start.q_2
    for j in range(columns.size):
        by[i, 2, j] = sigma * pull_by(way, columns[j]) * time
    if law.codes[i, CAUSE] == HOUSING_STOP:
        for c in range(3):
            before[i, 2, c] -= before[i, 1, c]
        for j in range(columns.size):
            by[i, 2, j] -= by[i, 1, j]
        return
    end = momentum_before(e, p, law, i, u)
    at[i, 2, 1], at[i, 2, 2] = -sign * end.q_1, -sign * end.q_2
