"""Marches of motions by pieces, whose logs give laws."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np

from vibropipe.compiler import jit
from vibropipe.march.grid import exact_steps, grid_in_room, grid_time, new_grid_room
from vibropipe.march.log import allow_work, clear_log, limit_work, new_log, work_left
from vibropipe.march.loop import OK, march
from vibropipe.march.piece_log import HOME, P_END, PIECES, W_END, Y_END, piece_log_of
from vibropipe.march.piece_state import start_state
from vibropipe.orbits.law.reading import Read, law_of
from vibropipe.physics.contact import to_displacement, to_velocity
from vibropipe.physics.effects import Effects
from vibropipe.physics.flow import DEGREE
from vibropipe.physics.housing import momentum_share
from vibropipe.physics.limits import MAX_CALL_WORK, MAX_ROW_WORK

# Capacities of the log of an orbit, in contacts and pieces.
CAPACITY = 4096
# Pieces for which equations are filled in one call that looks at `is_spent`: some 15 s of a core.
MAX_ROWS = 3_000_000


@jit
def march_orbit(e, p, turns, x, v, velocity, m, march_room):
    """Log the motion of m periods from a state at a phase; return its first and last `State`, and the status.

    velocity : of a housing that may slide; march_room : log, work array of `march`, and `new_grid_room`
    """
    log, c, grid_room = march_room
    grid = grid_in_room(e, p, exact_steps(e, p), grid_room)
    clear_log(log)
    begun = start_state(log.pieces, e, p, grid, turns, x, v, velocity)
    allow_work(log, MAX_ROW_WORK)
    end = grid_time(turns + m, grid.steps)
    end_state, status = march(e, p, grid, begun, end, log, None, c, 10_000_000)
    return begun, end_state, status


@jit
def march_pieces(e, p, turns, state, m, march_room) -> bool:
    """Log the motion of m periods from a state at a phase; return whether it could be marched.

    state : (2,) or (3,) float
        (x, x') and, of a housing that may slide, its velocity.
    """
    velocity = 0.0
    if e.housing is not None:
        velocity = state[2]
    return march_orbit(e, p, turns, state[0], state[1], velocity, m, march_room)[2] == OK


class Marcher:
    """Marches motions of exciters with some effects, one after another.

    effects : with pieces: of soft supports, friction or a housing, absent or not
    work : work of all marches, in steps: they fail when it is done
    rows : how many pieces the equations of laws have been filled for, which callers count and `is_spent` limits
    """

    def __init__(self, effects: Effects, work: int = MAX_CALL_WORK) -> None:
        self.effects, self.rows, self._work = effects, 0, work

    @cached_property
    def room(self) -> Any:
        """Log, polynomial and room of a grid, for `march_pieces`."""
        pieces = piece_log_of(self.effects, CAPACITY)
        log = new_log(CAPACITY, CAPACITY, *pieces)
        limit_work(log, 0, self._work)
        return log, np.empty(DEGREE + 1), new_grid_room(self.effects)

    @property
    def is_spent(self) -> bool:
        """Whether all work is done."""
        return work_left(self.room[0]) <= 0 or self.rows > MAX_ROWS

    @property
    def pieces(self) -> Any:
        """The log of the last march."""
        return self.room[0].pieces

    def after(
        self, p: Any, state: np.ndarray, periods: float, at: float = 0.0
    ) -> np.ndarray | None:
        """Return the state some periods after one at a time in periods, as `march_pieces`; None if the march fails."""
        if not march_pieces(self.effects, p, at, state, periods, self.room):
            return None
        pieces = self.pieces
        last = int(pieces.counts[PIECES]) - 1
        home = int(pieces.codes[last, HOME])
        y, w = float(pieces.values[last, Y_END]), float(pieces.values[last, W_END])
        x, v = to_displacement(p, home, y), to_velocity(home, w)
        log = pieces.housing
        if log is None:
            return np.array([x, v])
        slides = int(log.way[last]) != 0
        speed = float(log.values[last, P_END]) - momentum_share(p) * v if slides else 0.0
        return np.array([x, v, speed])

    def law_of(
        self, p: Any, state: np.ndarray, m: int, symmetric: bool, slow: float = 0.0
    ) -> Read | None:
        """Return the law of the orbit of m periods from a state at phase 0; None if there is none."""
        if not march_pieces(self.effects, p, 0.0, state, 2.0 * m, self.room):
            return None
        return law_of(self.effects, self.pieces, p, m, symmetric, slow)
