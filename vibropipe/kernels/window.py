"""What a motion without an orbit shows over a window of forcing periods."""

from __future__ import annotations

import math

from vibropipe.jit import jit, jit_allocating
from vibropipe.kernels.harmonics import RESONANT, add_contacts, admittance, close
from vibropipe.kernels.march import OK
from vibropipe.kernels.orbit import LOG_FULL, at_period_zero, clear, periods, section
from vibropipe.kernels.outputs import count_contacts
from vibropipe.kernels.state import REST
from vibropipe.kernels.steady import EVENTS_PER_PERIOD, ONE
from vibropipe.physics.forcing import TWO_PI

WINDOW = 256


@jit
def _add_to_window(p, log, state, amplitudes, row) -> None:
    if amplitudes is not None:
        resting = state.home if state.order == REST else 0
        add_contacts(p, log, resting, state.rest_start, 1, 1.0, amplitudes[row])


@jit
def _close_window(p, dx, dv, amplitudes, row) -> None:
    """Amplitudes at multiples of nu from WINDOW periods over which x and x' changed by dx, dv."""
    if amplitudes is not None:
        for k in range(amplitudes.shape[1]):
            # The ends of the window do not meet: the boundary terms of the partial integration stay.
            amplitudes[row, k] -= (dv + complex(p.h, k * p.nu) * dx) * p.nu / TWO_PI
        close(p, 1, float(WINDOW), amplitudes[row])
        for k in range(amplitudes.shape[1]):
            if abs(admittance(p, k, 1)) < RESONANT:
                amplitudes[row, k] = complex(math.nan, math.nan)


@jit_allocating
def measure_window(e, p, grid, state, log, c, amplitudes, row, impacts, rests, largest):
    """What a motion without an orbit shows over WINDOW forcing periods: means per period, and amplitudes at
    multiples of nu; returns its last state."""
    x0, v0 = section(p, state)
    for _ in range(WINDOW):
        state = at_period_zero(state)
        clear(log)
        state, status = periods(e, p, grid, state, ONE, log, c, EVENTS_PER_PERIOD)
        if status != OK and status != LOG_FULL:
            break
        count_contacts(log, state, impacts, rests, largest)
        _add_to_window(p, log, state, amplitudes, row)
    for side in range(2):
        impacts[side] /= WINDOW
        rests[side] /= WINDOW
    x, v = section(p, state)
    _close_window(p, x - x0, v - v0, amplitudes, row)
    return state
