"""Derivatives of solved rows: each orbit by its impacts, as they are listed or marched once more."""

from __future__ import annotations

import numpy as np

from vibropipe.compiler import jit_allocating, jit_nogil
from vibropipe.march.grid import exact_grid, grid_time
from vibropipe.march.log import GRAZINGS, RESTS, SAMPLES, new_log
from vibropipe.march.loop import OK, march
from vibropipe.march.state import initial_state
from vibropipe.orbits.outputs import RowResults, write_impacts
from vibropipe.orbits.return_map import clear_log
from vibropipe.orbits.row import row_parameters
from vibropipe.orbits.sensitivity.flights import Contacts
from vibropipe.orbits.sensitivity.linear import write_held, write_linear
from vibropipe.orbits.sensitivity.outputs import new_differentiation, write_sensitivity
from vibropipe.physics.conservative import is_conservative
from vibropipe.physics.contact import support_position
from vibropipe.physics.derivatives import LOAD, N_PARAMETERS, is_differentiated
from vibropipe.physics.flow import DEGREE

# Limit of contacts of an orbit that is marched once more.
MAX_EVENTS = 10_000_000


def new_derivatives(
    n: int, harmonics: int, subharmonics: int, outputs: tuple[str, ...]
) -> dict[str, np.ndarray]:
    """Return the arrays of `RowResults` for derivatives: NaN, or without entries unless `sensitivity` is requested.

    A quantity has derivatives if its own output is requested as well. Those of impacts begin without entries.

    Parameters
    ----------
    n : int
        Number of rows.
    harmonics, subharmonics : int
        Numbers of harmonics and subharmonics.
    outputs : tuple of str
        Requested outputs.
    """

    def unknown(when: str, *shape: int, dtype: type = float) -> np.ndarray:
        wanted = "sensitivity" in outputs and (when == "" or when in outputs)
        return np.full((n if wanted else 0, *shape, N_PARAMETERS), np.nan, dtype)

    return {
        "grazes": np.zeros(n if "sensitivity" in outputs else 0, np.int8),
        "d_section": unknown("", 2),
        "d_amplitudes": unknown("harmonics", harmonics + 1, dtype=complex),
        "d_subharmonics": unknown("subharmonics", subharmonics + 1, dtype=complex),
        "d_multipliers": unknown("stability", 2, dtype=complex),
        "d_exponent": unknown("lyapunov"),
        "d_energy": unknown("energy", 4),
        "d_velocity_max": unknown("impacts", 2),
        "d_impacts": np.empty((0, 2, N_PARAMETERS)),
    }


def with_impact_derivatives(rows: RowResults) -> RowResults:
    """Return compacted results with room for the derivatives of their impacts, NaN, if impacts are requested."""
    if rows.d_velocity_max.size == 0:
        return rows
    shape = (rows.impact_position.size, *rows.d_impacts.shape[1:])
    return rows._replace(d_impacts=np.full(shape, np.nan))


@jit_allocating
def stored_impacts(out, row, first, rest_end, rest_support):
    """Return the `Contacts` of a row whose impacts are listed in `out`, with some rests."""
    last = first + out.impact_count[row]
    return Contacts(
        out.impact_position[first:last],
        out.impact_velocity[first:last],
        out.impact_support[first:last],
        rest_end,
        rest_support,
    )


@jit_allocating
def march_contacts(e, p, x, v, m, log, c, room):
    """March an orbit once more; return whether it succeeds without grazing, and its `Contacts`, views of the room."""
    grid = exact_grid(e, p)
    clear_log(log)
    log.counts[SAMPLES] = 0
    state, until = initial_state(e, p, grid, 0.0, x, v), grid_time(float(m), grid.steps)
    _end, status = march(e, p, grid, state, until, log, None, c, MAX_EVENTS)
    own, count = room.contacts, np.zeros(1, np.int64)
    write_impacts(log, m, count, own.position, own.velocity, own.support, 0, 0)
    n, rests = count[0], min(log.counts[RESTS], log.rest_end.size)
    for r in range(rests):
        own.rest_end[r], own.rest_support[r] = log.rest_end[r], log.rest_support[r]
    is_smooth = status == OK and log.counts[GRAZINGS] == 0
    return is_smooth, Contacts(
        own.position[:n],
        own.velocity[:n],
        own.support[:n],
        own.rest_end[:rests],
        own.rest_support[:rests],
    )


@jit_nogil
def differentiate_rows(e, parameters, out, impacts, rests) -> None:
    """Write the derivatives of solved rows.

    Parameters
    ----------
    e : Effects
    parameters : (rows, N_PARAMETERS) float
    out : RowResults
        Compacted results of the rows. An orbit whose impacts are not listed, or with a rest, is marched once more.
    impacts, rests : int
        Capacity for contacts of an orbit.
    """
    log, c = new_log(impacts, rests), np.empty(DEGREE + 1)
    room, first = new_differentiation(out, impacts, rests), 0
    none = room.contacts.rest_end[:0], room.contacts.rest_support[:0]
    for row in range(parameters.shape[0]):
        m, p = out.period_multiple[row], row_parameters(parameters, row)
        x, v = out.section[row, 0], out.section[row, 1]
        if not is_differentiated(p):
            m = 0
        if m > 0 and out.impacts[row, 0] + out.impacts[row, 1] == 0.0:
            if out.rests[row, 0] + out.rests[row, 1] > 0.0:
                write_held(1 if x == support_position(p, 1) else 2, out, row)
            elif p.h > 0.0:
                write_linear(p, out, row)
        elif m > 0 and not is_conservative(p, x, v):
            if out.impact_count.size > 0 and out.rests[row, 0] + out.rests[row, 1] == 0.0:
                contacts = stored_impacts(out, row, first, none[0], none[1])
                is_smooth = out.grazes[row] == 0
            else:
                is_smooth, contacts = march_contacts(e, p, x, v, m, log, c, room)
            is_same = contacts.position.size == int(out.impacts[row, 0] + out.impacts[row, 1])
            if is_smooth and is_same:
                write_sensitivity(p, contacts, m, room, out, row, first)
        # Kernels count displacements from the equilibrium, which the load moves.
        out.d_section[row, 0, LOAD] += 1.0
        if out.d_amplitudes.size > 0:
            out.d_amplitudes[row, 0, LOAD] += 1.0
        if out.impact_count.size > 0:
            first += out.impact_count[row]
