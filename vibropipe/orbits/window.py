"""Means of a motion without an orbit over a window of forcing periods."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from vibropipe.compiler import jit, jit_inline
from vibropipe.march.log import IMPACTS
from vibropipe.march.state import REST
from vibropipe.orbits.forces import Integrals
from vibropipe.orbits.harmonics import ONE_PERIOD, RESONANT, add_support_forces, dynamic_stiffness
from vibropipe.orbits.housing import (
    LARGEST_SPEED,
    MEAN,
    SLIP_SHARE,
    START,
    add_housing_harmonics,
    add_housing_period,
    momentum_of,
)
from vibropipe.orbits.outputs import add_energies, count_contacts
from vibropipe.orbits.pieces import add_harmonics_of_pieces
from vibropipe.orbits.quadrature import add_energy, integrate_along
from vibropipe.orbits.recurrence import HISTORY_OFFSET
from vibropipe.orbits.return_map import state_xv
from vibropipe.physics.limits import PATIENCE

# Length of the window in forcing periods: the least patience, so that every given-up motion fills it.
WINDOW = PATIENCE[0]
# Forcing periods at its end whose impacts and sections are listed; not more than HISTORY_OFFSET.
LISTED_PERIODS = 64


class Window(NamedTuple):
    """Sums over the window of a row.

    amplitudes : (rows, harmonics + 1) complex, sums of support forces, or without entries
    impacts, rests, largest : (2,), counts and largest impact velocities for each support
    direct : (harmonics + 1,) complex, harmonics by quadrature, if `resonant`
    energy : (2,), energies by quadrature, which `integrate_along` adds up; not an output
    resonant : whether a harmonic is too near resonance for the closed form
    start : (3,), section (x, x') at the start of the window, and the number of periods summed
    first : index of the first impact of the row
    impact_count, impact_position, impact_velocity, impact_support : impacts of the last LISTED_PERIODS (`RowResults`),
        or without entries
    poincare : (rows, 2, LISTED_PERIODS), sections (x, x') at the end of these periods, or without entries
    exponent : (rows, 2), Lyapunov exponent per unit of tau and its standard error, or without entries
    energies : (rows, 5) or (rows, 6), sums of the energies (`RowResults`), or without entries
    forces : (rows, FORCES) or (rows, 0), sums of the forces (`RowResults`)
    housing : (rows, N_COLUMNS), sums of a housing that may slide, or without entries
    housing_harmonics : (rows, harmonics + 1) complex, sums of its acceleration, or without entries
    """

    amplitudes: np.ndarray
    row: int
    impacts: np.ndarray
    rests: np.ndarray
    largest: np.ndarray
    direct: np.ndarray
    energy: np.ndarray
    resonant: bool
    start: np.ndarray
    first: int
    is_listed: bool
    impact_count: np.ndarray
    impact_position: np.ndarray
    impact_velocity: np.ndarray
    impact_support: np.ndarray
    poincare: np.ndarray
    exponent: np.ndarray
    energies: np.ndarray
    forces: np.ndarray
    housing: np.ndarray
    housing_harmonics: np.ndarray


@jit
def _is_resonant(p, amplitudes) -> bool:
    """Return whether a harmonic is too near resonance for the closed form."""
    if amplitudes.size == 0:
        return False
    nearest = 1.0
    for k in range(amplitudes.shape[1]):
        nearest = min(nearest, abs(dynamic_stiffness(p, k, ONE_PERIOD)))
    return nearest < RESONANT


@jit
def window_of(p, out, row, first, sums, work):
    """Return the window of a row.

    first : index of the first impact of the row
    sums, work : tuple of ndarray, work space, `room.new_sums` and `room.new_work`
    """
    (largest, start), (direct, energy) = sums, work
    return Window(
        out.amplitudes,
        row,
        out.impacts[row],
        out.rests[row],
        largest,
        direct[: out.amplitudes.shape[1]],
        energy,
        _is_resonant(p, out.amplitudes),
        start,
        first,
        # Lists that only the errors of orbits need do not include motions without an orbit.
        out.impact_velocity_max.size > 0,
        out.impact_count,
        out.impact_position,
        out.impact_velocity,
        out.impact_support,
        out.poincare,
        out.exponent,
        out.energy,
        out.forces,
        out.housing,
        out.housing_harmonics,
    )


@jit
def clear_window(window) -> None:
    """Set all sums of a window to zero."""
    window.start[2] = 0.0
    for side in range(2):
        window.impacts[side] = 0.0
        window.rests[side] = 0.0
        window.largest[side] = 0.0
        window.energy[side] = 0.0
    if window.energies.size > 0:
        window.energies[window.row] = 0.0
        window.forces[window.row] = 0.0
    if window.housing.size > 0:
        for column in (MEAN, LARGEST_SPEED, SLIP_SHARE):
            window.housing[window.row, column] = 0.0
    for k in range(window.direct.size):
        window.direct[k] = 0.0
        if window.amplitudes.size > 0:
            window.amplitudes[window.row, k] = 0.0
        if window.housing_harmonics.size > 0:
            window.housing_harmonics[window.row, k] = 0.0


@jit
def open_window(p, window, state) -> None:
    """Start a window at a state."""
    clear_window(window)
    window.start[0], window.start[1] = state_xv(p, state)
    if window.housing.size > 0:
        window.housing[window.row, START] = momentum_of(state.housing)


@jit_inline
def add_period(e, p, window, start, end, log, c) -> None:
    """Add a marched forcing period to a window.

    e, p, c : as for `march`
    start, end : states before and after the period
    log : contacts of the period
    """
    window.start[2] += 1.0
    count_contacts(log, end, window.impacts, window.rests, window.largest)
    if window.amplitudes.size > 0:
        add_to_window(e, p, window, start, end, log, c)
    if window.housing.size > 0:
        add_housing_period(log.pieces, p, start, end, window.housing[window.row])
    if window.housing_harmonics.size > 0:
        harmonics = window.housing_harmonics[window.row]
        add_housing_harmonics(log.pieces, e, p, harmonics, window.direct)
    if window.energies.size > 0:
        add_energies_to_window(e, p, window, start, end, log, c)


@jit_inline
def add_to_window(e, p, window, start, end, log, c) -> None:
    """Add a period to the amplitudes of a window."""
    if log.pieces is not None:
        add_harmonics_of_pieces(
            e, p, log.pieces, ONE_PERIOD, window.amplitudes[window.row], window.direct
        )
    else:
        resting = end.home if end.mode == REST else 0
        add_support_forces(
            p, log, resting, end.rest_start, ONE_PERIOD, 1.0, window.amplitudes[window.row]
        )
        if window.resonant:
            x, v = state_xv(p, start)
            sums = Integrals(window.energy, window.energy[:0], window.direct, ONE_PERIOD)
            integrate_along(e, p, x, v, 0.0, 1.0, end, log, sums, c)


@jit
def add_energies_to_window(e, p, window, start, end, log, c) -> None:
    """Add a period to the energies and forces of a window."""
    row, none = window.row, window.direct[:0]
    sums = Integrals(window.energies[row], window.forces[row], none, ONE_PERIOD)
    if log.pieces is not None:
        add_energies(e, p, log, sums)
    else:
        x, v = state_xv(p, start)
        add_energy(e, p, x, v, 0.0, 1.0, end, log, sums, c)


@jit
def list_impacts(window, log, period) -> None:
    """Append the impacts of a forcing period to the list of a row.

    A list as long as the log begins anew with this period: it holds whole periods, and always the last.

    log : contacts of the period
    period : its index among the listed ones; 0 empties the list
    """
    first, count = window.first, window.impact_count
    if window.is_listed:
        logged = min(log.counts[IMPACTS], log.position.size)
        n = first
        if period > 0 and count[window.row] + logged <= log.position.size:
            n += count[window.row]
        for i in range(logged):
            position = period + log.position[i]
            # An impact at the end of the last period belongs to the next one, which is not listed.
            if log.support[i] > 0 and position < LISTED_PERIODS:
                window.impact_position[n] = position
                window.impact_velocity[n] = log.velocity[i]
                window.impact_support[n] = log.support[i]
                n += 1
        count[window.row] = n - first


@jit_inline
def record_period(e, p, window, start, end, log, c, k, first, last) -> None:
    """Add a marched forcing period to a window that it lies in.

    e, p, window, start, end, log, c : as for `add_period`
    k : the period that ends, counted from 1
    first, last : first and last period of the window
    """
    if k == first:
        open_window(p, window, start)
    add_period(e, p, window, start, end, log, c)
    list_first = max(first, last + 1 - LISTED_PERIODS)
    if k >= list_first:
        list_impacts(window, log, k - list_first)


@jit
def write_sections(window, xs, vs, k) -> None:
    """Write the sections at the ends of the last periods up to k.

    xs, vs : (HISTORY_OFFSET + n,), section (x, x') at the periods 0 to k, from HISTORY_OFFSET on
    k : last period
    """
    if window.poincare.size > 0:
        first = HISTORY_OFFSET + k + 1 - LISTED_PERIODS
        for i in range(LISTED_PERIODS):
            window.poincare[window.row, 0, i] = xs[first + i]
            window.poincare[window.row, 1, i] = vs[first + i]
