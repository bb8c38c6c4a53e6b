"""What a motion without an orbit shows over a window of forcing periods: sums while it is marched, means after."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from vibropipe.compiler import jit, jit_allocating, jit_inline
from vibropipe.march.state import REST
from vibropipe.orbits.harmonics import (
    ONE_PERIOD,
    RESONANT,
    add_support_forces,
    divide_by_stiffness,
    dynamic_stiffness,
)
from vibropipe.orbits.outputs import count_contacts
from vibropipe.orbits.quadrature import integrate_along
from vibropipe.orbits.return_map import state_xv
from vibropipe.physics.limits import PATIENCE
from vibropipe.physics.load import TWO_PI
from vibropipe.physics.quotient import divide

WINDOW = PATIENCE[0]


class Window(NamedTuple):
    """Sums over the window of a row: amplitudes (rows, harmonics + 1) of which `row` is its own, or none; impacts,
    rests and largest impact velocities (2,) of both supports; direct (harmonics + 1,) and energy (2,) by
    quadrature, where a harmonic is `resonant`; begun (3,): the section it began with, and the periods summed."""

    amplitudes: np.ndarray
    row: int
    impacts: np.ndarray
    rests: np.ndarray
    largest: np.ndarray
    direct: np.ndarray
    energy: np.ndarray
    resonant: bool
    start: np.ndarray


@jit
def _is_resonant(p, amplitudes) -> bool:
    if amplitudes.size == 0:
        return False
    nearest = 1.0
    for k in range(amplitudes.shape[1]):
        nearest = min(nearest, abs(dynamic_stiffness(p, k, ONE_PERIOD)))
    return nearest < RESONANT


@jit_allocating
def new_window(p, amplitudes, row, impacts, rests):
    """The window of a row; impacts, rests (2,) and its row of amplitudes are its results."""
    resonant = _is_resonant(p, amplitudes)
    direct = np.empty(amplitudes.shape[1], np.complex128)
    return Window(
        amplitudes, row, impacts, rests, np.zeros(2), direct, np.empty(2), resonant, np.empty(3)
    )


@jit
def clear_window(window) -> None:
    """Nothing summed yet."""
    window.start[2] = 0.0
    for side in range(2):
        window.impacts[side] = 0.0
        window.rests[side] = 0.0
        window.largest[side] = 0.0
        window.energy[side] = 0.0
    for k in range(window.direct.size):
        window.direct[k] = 0.0
        if window.amplitudes.size > 0:
            window.amplitudes[window.row, k] = 0.0


@jit
def open_window(p, window, state) -> None:
    """Begin the window at a state."""
    clear_window(window)
    window.start[0], window.start[1] = state_xv(p, state)


@jit_inline
def add_period(e, p, window, start, end, log, c) -> None:
    """Add a marched forcing period, its contacts in the log."""
    window.start[2] += 1.0
    count_contacts(log, end, window.impacts, window.rests, window.largest)
    if window.amplitudes.size > 0:
        resting = end.home if end.mode == REST else 0
        add_support_forces(
            p, log, resting, end.rest_start, ONE_PERIOD, 1.0, window.amplitudes[window.row]
        )
        if window.resonant:
            x, v = state_xv(p, start)
            integrate_along(
                e, p, x, v, 0.0, 1.0, end, log, ONE_PERIOD, window.direct, window.energy, c
            )


@jit
def close_window(p, window, end) -> None:
    """Means per forcing period, and amplitudes at multiples of nu; where the closed form would divide by nothing,
    those by quadrature."""
    periods = window.start[2]
    for side in range(2):
        window.impacts[side] /= periods
        window.rests[side] /= periods
    if window.amplitudes.size > 0:
        amplitudes = window.amplitudes[window.row]
        x, v = state_xv(p, end)
        dx, dv = x - window.start[0], v - window.start[1]
        for k in range(amplitudes.size):
            # The ends of the window do not meet: the boundary terms of the partial integration stay.
            boundary = (dv + complex(p.h, k * p.nu) * dx) * p.nu
            amplitudes[k] -= divide(boundary, complex(TWO_PI, 0.0))
        divide_by_stiffness(p, ONE_PERIOD, periods, amplitudes)
        for k in range(amplitudes.size):
            if abs(dynamic_stiffness(p, k, ONE_PERIOD)) < RESONANT:
                amplitudes[k] = divide(window.direct[k], complex(periods, 0.0))
