"""What a motion without an orbit shows over a window of forcing periods."""

from __future__ import annotations

import numpy as np

from vibropipe.jit import jit, jit_allocating
from vibropipe.kernels.harmonics import RESONANT, add_contacts, admittance, close
from vibropipe.kernels.march import OK
from vibropipe.kernels.orbit import LOG_FULL, at_period_zero, clear, periods, section
from vibropipe.kernels.outputs import count_contacts
from vibropipe.kernels.quadrature import along
from vibropipe.kernels.state import REST
from vibropipe.kernels.steady import EVENTS_PER_PERIOD, ONE
from vibropipe.physics.forcing import TWO_PI

WINDOW = 256


@jit
def _is_resonant(p, amplitudes) -> bool:
    if amplitudes.size == 0:
        return False
    nearest = 1.0
    for k in range(amplitudes.shape[1]):
        nearest = min(nearest, abs(admittance(p, k, 1)))
    return nearest < RESONANT


@jit
def _add_to_window(p, log, state, amplitudes, row) -> None:
    if amplitudes.size > 0:
        resting = state.home if state.order == REST else 0
        add_contacts(p, log, resting, state.rest_start, 1, 1.0, amplitudes[row])


@jit
def _add_direct(e, p, start, end, log, direct, energy, c) -> None:
    x, v = section(p, start)
    along(e, p, x, v, 0.0, 1.0, end, log, 1, direct, energy, c)


@jit
def _close_window(p, dx, dv, direct, amplitudes, row) -> None:
    """Amplitudes at multiples of nu from WINDOW periods over which x and x' changed by dx, dv; where the
    closed form would divide by nothing, those of the quadrature `direct`."""
    if amplitudes.size > 0:
        for k in range(amplitudes.shape[1]):
            # The ends of the window do not meet: the boundary terms of the partial integration stay.
            amplitudes[row, k] -= (dv + complex(p.h, k * p.nu) * dx) * p.nu / TWO_PI
        close(p, 1, float(WINDOW), amplitudes[row])
        for k in range(amplitudes.shape[1]):
            if abs(admittance(p, k, 1)) < RESONANT:
                amplitudes[row, k] = direct[k] / WINDOW


@jit_allocating
def measure_window(e, p, grid, state, log, c, amplitudes, row, impacts, rests, largest):
    """What a motion without an orbit shows over WINDOW forcing periods: means per period, and amplitudes at
    multiples of nu; returns its last state."""
    x0, v0 = section(p, state)
    resonant = _is_resonant(p, amplitudes)
    direct, energy = np.zeros(amplitudes.shape[1], np.complex128), np.zeros(2)
    for _ in range(WINDOW):
        state = at_period_zero(state)
        start = state
        clear(log)
        state, status = periods(e, p, grid, state, ONE, log, c, EVENTS_PER_PERIOD)
        if status not in (OK, LOG_FULL):
            break
        count_contacts(log, state, impacts, rests, largest)
        _add_to_window(p, log, state, amplitudes, row)
        if resonant:
            _add_direct(e, p, start, state, log, direct, energy, c)
    for side in range(2):
        impacts[side] /= WINDOW
        rests[side] /= WINDOW
    x, v = section(p, state)
    _close_window(p, x - x0, v - v0, direct, amplitudes, row)
    return state
