"""Work space of rows that are solved one after another.

Nothing is allocated for a row. A kernel that creates arrays counts their users, atomically, in every call that passes
results and a log, which takes as long as six forcing periods.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from vibropipe.compiler import jit_allocating
from vibropipe.march.grid import new_grid_room
from vibropipe.march.log import Log
from vibropipe.orbits.recurrence import HISTORY_OFFSET
from vibropipe.orbits.verdict import PURSUIT
from vibropipe.physics.flow import DEGREE


class RowRoom(NamedTuple):
    """A log, the work array c of `march`, and results of `new_grid_room`, `new_sections`, `new_sums`, `new_work`."""

    log: Log
    c: np.ndarray
    grid: tuple[np.ndarray, np.ndarray, np.ndarray]
    sections: tuple[np.ndarray, np.ndarray, np.ndarray]
    sums: tuple[np.ndarray, np.ndarray]
    work: tuple[np.ndarray, np.ndarray]


@jit_allocating
def new_room(e, log, max_periods, out):
    """Return a `RowRoom`; e : Effects; log : Log; max_periods : limit of forcing periods; out : RowResults."""
    sections = new_sections(e, max_periods)
    return RowRoom(log, np.empty(DEGREE + 1), new_grid_room(e), sections, new_sums(), new_work(out))


@jit_allocating
def new_sections(e, max_periods):
    """Return arrays for the sections (x, x', X') of a march with a limit of forcing periods (`recurrence`)."""
    n = HISTORY_OFFSET + PURSUIT * max_periods + 1
    return np.empty(n), np.empty(n), np.empty(0 if e.housing is None else n)


@jit_allocating
def new_sums():
    """Return the arrays `largest` and `start` of a `Window`."""
    return np.zeros(2), np.empty(3)


@jit_allocating
def new_work(out):
    """Return room for the harmonics of a row by quadrature and for energies: `direct` and `energy` of a `Window`."""
    terms = max(out.amplitudes.shape[1], out.subharmonics.shape[1])
    return np.empty(terms, np.complex128), np.zeros(2)
