"""Steps of motions by pieces on a ramp, by Taylor polynomials; what else they do is that of `march.pieces`."""

from __future__ import annotations

from vibropipe.compiler import jit, jit_inline
from vibropipe.march.grid import phase_at
from vibropipe.march.log import POLYNOMIALS
from vibropipe.march.piece_events import ANY, MAX_PARTS, piece_at
from vibropipe.march.piece_housing import is_held_a_step
from vibropipe.march.piece_step import PieceStep, finish_step, span_until
from vibropipe.march.piece_still import step_end
from vibropipe.physics.contact import frame_at
from vibropipe.physics.ramp import parts_on_ramp, piece_taylor_on_ramp
from vibropipe.words.status import Status

MAX_STEPS = int(Status.MAX_STEPS)


@jit
def fill_on_ramp(e, p, grid, frame, piece, state, dt, c) -> None:
    """Fill c with the motion on a piece from a state, in t/dt."""
    scale, second = frame.sigma * piece.factor, e.second_harmonic
    moment = phase_at(grid, state)
    piece_taylor_on_ramp(c, state.y, state.w, p, moment, scale, piece, dt, second)
    # The derivatives that the mode declares zero are set to zero, without rounding.
    if piece.velocity_power >= 2:
        c[2] = 0.0
    if piece.velocity_power >= 3:
        c[3] = 0.0


@jit_inline
def advance_on_ramp(e, p, grid, state, end, log, samples, c):
    """March a moving state to its next event, or by a step without one: `pieces.advance_piece` on a `RampGrid`."""
    frame = frame_at(e, p, state.home, state.housing)
    piece = piece_at(e, p, frame, state)
    parts = 1.0
    if piece.in_contact or piece.factor > 1.0:
        parts = parts_on_ramp(piece, grid.dt)
    if not parts <= MAX_PARTS:
        return state, MAX_STEPS, False
    fill_on_ramp(e, p, grid, frame, piece, state, grid.dt / parts, c)
    log.counts[POLYNOMIALS] += 1
    goal = step_end(grid, state, end) if is_held_a_step(state.housing) else end
    left, span, is_whole = span_until(grid, state, goal, parts)
    step = PieceStep(frame, piece, parts, ANY, goal, left, span, is_whole)
    return finish_step(e, p, grid, state, step, end, log, samples, c)
