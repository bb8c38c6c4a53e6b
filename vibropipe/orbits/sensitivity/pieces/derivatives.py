"""Derivatives of section, contacts, amplitudes and energies of an orbit of linear pieces."""

from __future__ import annotations

import math

from vibropipe.compiler import jit
from vibropipe.orbits.sensitivity.pieces.columns import PARAMETER
from vibropipe.physics.derivatives import FRICTION, K1, K2, N_OF_PIECES
from vibropipe.physics.stiffness import stiffness_of


@jit
def is_by(p, k) -> bool:
    """Return whether a motion has a derivative by parameter k: none by the stiffness of a rigid support.

    By a friction that is absent it has one to one side only.
    """
    if k in (K1, K2):
        return stiffness_of(p, k - K1 + 1) > 0.0
    return k != FRICTION or p.friction > 0.0


@jit
def fill_missing(p, derivatives) -> None:
    """Replace the derivatives (n, N_OF_PIECES) that there are not by NaN."""
    for k in range(N_OF_PIECES):
        if not is_by(p, k):
            derivatives[:, k] = math.nan


@jit
def write_contact_derivatives(p, room, out, row, first) -> None:
    """Write the derivatives of phases and velocities of contacts, and of the largest velocity on each support."""
    n = room.counts[0]
    if out.impact_count[row] != n:
        return
    for j in range(n):
        for k in range(N_OF_PIECES):
            out.d_impacts[first + j, 0, k] = room.contacts[j, 0, PARAMETER + k]
            out.d_impacts[first + j, 1, k] = room.contacts[j, 1, PARAMETER + k]
        fill_missing(p, out.d_impacts[first + j])
    for side in range(2):
        fastest = -1
        for j in range(first, first + n):
            speed = abs(out.impact_velocity[j])
            if out.impact_support[j] == side + 1 and (
                fastest < 0 or speed > abs(out.impact_velocity[fastest])
            ):
                fastest = j
        if fastest >= 0:
            sign = 1.0 if out.impact_velocity[fastest] > 0.0 else -1.0
            for k in range(N_OF_PIECES):
                out.d_velocity_max[row, side, k] = sign * out.d_impacts[fastest, 1, k]


@jit
def write_derivatives(p, starts, room, out, row, first) -> None:
    """Write the derivatives of a row but those of its multipliers; its variations are closed (`write_errors`)."""
    for k in range(N_OF_PIECES):
        out.d_section[row, 0, k] = starts[0, PARAMETER + k]
        out.d_section[row, 1, k] = starts[1, PARAMETER + k]
        for n in range(room.amplitudes.shape[0]):
            out.d_amplitudes[row, n, k] = room.amplitudes[n, PARAMETER + k]
        for n in range(room.subharmonics.shape[0]):
            out.d_subharmonics[row, n, k] = room.subharmonics[n, PARAMETER + k]
        for n in range(room.energy.shape[0]):
            out.d_energy[row, n, k] = room.energy[n, PARAMETER + k]
    fill_missing(p, out.d_section[row])
    if room.amplitudes.shape[0] > 0:
        fill_missing(p, out.d_amplitudes[row])
    if room.subharmonics.shape[0] > 0:
        fill_missing(p, out.d_subharmonics[row])
    if room.energy.shape[0] > 0:
        fill_missing(p, out.d_energy[row])
    if out.d_impacts.size > 0:
        write_contact_derivatives(p, room, out, row, first)
