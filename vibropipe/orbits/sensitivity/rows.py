"""Derivatives of solved rows: each orbit by its impacts, as they are listed."""

from __future__ import annotations

import numpy as np

from vibropipe.compiler import jit_inline, jit_nogil
from vibropipe.orbits.results import RowResults
from vibropipe.orbits.row import row_parameters
from vibropipe.orbits.sensitivity.flights import Contacts
from vibropipe.orbits.sensitivity.linear import write_held, write_linear
from vibropipe.orbits.sensitivity.outputs import new_differentiation, write_sensitivity
from vibropipe.physics.conservative import is_conservative
from vibropipe.physics.contact import support_position
from vibropipe.physics.derivatives import LOAD, N_OF_PIECES, n_parameters


def new_derivatives(
    n: int,
    harmonics: int,
    subharmonics: int,
    outputs: tuple[str, ...],
    pieces: bool,
    second: int | None,
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
    pieces : bool
        Whether motions have soft supports or friction: derivatives by more parameters, and of one more energy.
    second : int or None
        The effect `second_harmonic`.
    """
    parameters = N_OF_PIECES if pieces else n_parameters(second)

    def unknown(when: str, *shape: int, dtype: type = float) -> np.ndarray:
        wanted = "sensitivity" in outputs and (when == "" or when in outputs)
        return np.full((n if wanted else 0, *shape, parameters), np.nan, dtype)

    return {
        "releases": np.full((n if "sensitivity" in outputs else 0, 2), np.nan),
        "grazes": np.zeros(n if "sensitivity" in outputs else 0, np.int8),
        "d_section": unknown("", 2),
        "d_amplitudes": unknown("harmonics", harmonics + 1, dtype=complex),
        "d_subharmonics": unknown("subharmonics", subharmonics + 1, dtype=complex),
        "d_multipliers": unknown("stability", 2, dtype=complex),
        "d_exponent": unknown("lyapunov"),
        "d_energy": unknown("energy", 5 if pieces else 4),
        "d_velocity_max": unknown("impacts", 2),
        "d_impacts": np.empty((0, 2, parameters)),
    }


def with_impact_derivatives(rows: RowResults) -> RowResults:
    """Return compacted results with room for the derivatives of their impacts, NaN, if impacts are requested."""
    if rows.d_velocity_max.size == 0:
        return rows
    shape = (rows.impact_position.size, *rows.d_impacts.shape[1:])
    return rows._replace(d_impacts=np.full(shape, np.nan))


@jit_inline
def differentiate_row(p, out, row, first, room, second) -> None:
    """Write the derivatives of a row, whose impacts begin at `first`; arguments as for `differentiate_rows`."""
    m, x, v = out.period_multiple[row], out.section[row, 0], out.section[row, 1]
    n, last = int(out.impacts[row, 0] + out.impacts[row, 1]), first + out.impact_count[row]
    if m == 0:
        return
    if n == 0 and out.rests[row, 0] + out.rests[row, 1] > 0.0:
        write_held(1 if x == support_position(p, 1) else 2, out, row)
    elif n == 0 and p.h > 0.0:
        write_linear(p, out, row)
    elif n > 0 and n == last - first and out.grazes[row] == 0 and not is_conservative(p, x, v):
        contacts = Contacts(
            out.impact_position[first:last],
            out.impact_velocity[first:last],
            out.impact_support[first:last],
            out.releases[row],
        )
        write_sensitivity(p, contacts, m, room, out, row, first, second)


@jit_nogil
def differentiate_rows(parameters, out, impacts, second) -> None:
    """Write the derivatives of solved rows.

    Parameters
    ----------
    parameters : (rows, parameters) float
    out : RowResults
        Compacted results of the rows, with their impacts.
    impacts : int
        Capacity for the impacts of an orbit.
    second : int or None
        The effect `second_harmonic`.
    """
    room, first = new_differentiation(out, impacts, second), 0
    for row in range(parameters.shape[0]):
        differentiate_row(row_parameters(parameters, row), out, row, first, room, second)
        # Kernels count displacements from the equilibrium, which the load moves.
        out.d_section[row, 0, LOAD] += 1.0
        if out.d_amplitudes.size > 0:
            out.d_amplitudes[row, 0, LOAD] += 1.0
        first += out.impact_count[row]
