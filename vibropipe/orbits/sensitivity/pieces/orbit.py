"""Variations along an orbit: its pieces, marched once more from its section, and the events between them."""

from __future__ import annotations

import numpy as np

from vibropipe.compiler import jit
from vibropipe.march.grid import exact_steps, grid_in_room, grid_time
from vibropipe.march.log import GRAZINGS, allow_work, clear_log
from vibropipe.march.loop import OK, march
from vibropipe.march.piece_log import (
    AT,
    BEGIN,
    CAUSE,
    CONTACT,
    FORM,
    HELD,
    HOME,
    PIECES,
    RESTING,
    SPAN,
    W_END,
    Y_END,
    W,
    Y,
)
from vibropipe.march.piece_state import coefficients, start_state
from vibropipe.orbits.piece_terms import load_of_piece
from vibropipe.orbits.sensitivity.errors import SAMPLES, ULP, random_sign
from vibropipe.orbits.sensitivity.pieces.columns import PARAMETER, SAMPLE, columns_of
from vibropipe.orbits.sensitivity.pieces.events import (
    begin_variations,
    change_frame,
    pass_event,
    sign_of,
)
from vibropipe.orbits.sensitivity.pieces.variation import vary_piece
from vibropipe.physics.limits import MAX_ROW_WORK
from vibropipe.physics.load import forcing_period, largest_force
from vibropipe.physics.stiffness import piece_rate


@jit
def march_orbit(e, p, turns, x, v, m, march_room) -> bool:
    """Log the orbit of m periods that begins at (x, v); return whether it could be marched and grazes nothing.

    turns : time of the start, in forcing periods; march_room : log, work array of `march`, and `new_grid_room`
    """
    log, c, grid_room = march_room
    grid = grid_in_room(e, p, exact_steps(e, p), grid_room)
    clear_log(log)
    state = start_state(log.pieces, e, p, grid, turns, x, v)
    end = grid_time(turns + float(m), grid.steps)
    allow_work(log, MAX_ROW_WORK)
    _end, status = march(e, p, grid, state, end, log, None, c, 10_000_000)
    return status == OK and log.counts[GRAZINGS] == 0


@jit
def add_rounding(e, p, pieces, i, ends) -> None:
    """Add what piece i, and the event that ends it, round to the samples of `ends`."""
    home, form, values = pieces.codes[i, HOME], pieces.codes[i, FORM], pieces.values
    if form in (HELD, RESTING):
        return
    stiffness, damping = coefficients(e, p, home, form == CONTACT)
    _sigma, load = load_of_piece(e, p, pieces, i)
    y, w = abs(values[i, Y]) + abs(values[i, Y_END]), abs(values[i, W]) + abs(values[i, W_END])
    span, rate = values[i, SPAN], piece_rate(stiffness, damping)
    short = min(span, 1.0 / rate)
    push = abs(load) + largest_force(p) + stiffness * y
    # The phase of the end is rounded with the phase itself.
    late = 0.5 * ULP * (0.5 + abs(values[i, AT])) * forcing_period(p)
    last_y, last_w = abs(values[i, Y_END]), abs(values[i, W_END])
    last_push = abs(load) + largest_force(p) + stiffness * last_y + damping * last_w
    by_y = ULP * (y + short * (w + short * push)) + late * last_w
    by_w = ULP * (w + short * push) + late * last_push
    for s in range(SAMPLES):
        k = 2 * (SAMPLES * i + s)
        ends[0, SAMPLE + s] += random_sign(k) * by_y
        ends[1, SAMPLE + s] += random_sign(k + 1) * by_w


@jit
def note_state(home, ends, state) -> None:
    """Note the variations of (x, x') by start and rounding, in (2, PARAMETER)."""
    for v in range(PARAMETER):
        state[0, v], state[1, v] = sign_of(home) * ends[0, v], sign_of(home) * ends[1, v]


@jit
def vary_pieces(e, p, pieces, m, by, out) -> bool:
    """Carry the variations along the logged pieces of an orbit of m periods, the start held.

    On return `out.ends` has those of (x, x') at the end. Returns False where the orbit is not smooth in its start.
    """
    n, ends, columns = pieces.counts[PIECES], out.ends, columns_of(by)
    out.counts[0] = 0
    out.amplitudes[:] = 0.0
    out.subharmonics[:] = 0.0
    out.energy[:] = 0.0
    if pieces.codes[0, CAUSE] != BEGIN:
        return False
    begin_variations(pieces.codes[0, HOME], columns, ends)
    form = pieces.codes[0, FORM]
    if form in (HELD, RESTING):
        for v in range(columns):
            ends[1, v] = 0.0
            if form == RESTING:
                ends[0, v] = 0.0
    for i in range(n):
        if i > 0 and not pass_event(e, p, pieces, i, by, out):
            return False
        vary_piece(e, p, pieces, i, m, by, out)
        add_rounding(e, p, pieces, i, ends)
        note_state(pieces.codes[i, HOME], ends, out.states[i])
    change_frame(pieces.codes[n - 1, HOME], np.int8(0), columns, ends)
    return True
