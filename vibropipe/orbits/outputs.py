"""Each output of a row, written from a closed orbit whose contacts are in the log."""

from __future__ import annotations

import math

from vibropipe.compiler import jit, jit_inline
from vibropipe.march.log import GRAZINGS, IMPACTS, RESTS
from vibropipe.march.piece_log import PIECES
from vibropipe.march.state import REST
from vibropipe.orbits.forces import Integrals
from vibropipe.orbits.harmonics import ONE_PERIOD, add_support_forces, divide_by_stiffness
from vibropipe.orbits.housing import add_housing_energy
from vibropipe.orbits.pieces import add_energy_of_pieces, add_harmonics_of_pieces
from vibropipe.orbits.quadrature import add_energy, add_losses, replace_resonant_harmonics
from vibropipe.orbits.return_map import state_xv
from vibropipe.physics.linear import linear_exponent
from vibropipe.physics.load import forcing_period
from vibropipe.words.regimes import Regime

NO_IMPACT, ONE_SIDED_1, ONE_SIDED_2 = (
    int(Regime.NO_IMPACT),
    int(Regime.ONE_SIDED_1),
    int(Regime.ONE_SIDED_2),
)
TWO_SIDED, WITH_REST = int(Regime.TWO_SIDED), int(Regime.WITH_REST)
# Largest distance of one grazing from itself, in forcing periods: it is found within the root of rounding.
SAME_GRAZING = 1e-6


@jit_inline
def count_contacts(log, end, impacts, rests, largest) -> None:
    """Add the contacts of a log to the counts, and update the largest impact velocities.

    log : contacts of an orbit or a forcing period
    end : state at its end
    impacts, rests : (2,), counts for each support, increased in place
    largest : (2,), largest impact velocity on each support, updated in place
    """
    for i in range(min(log.counts[IMPACTS], log.position.size)):
        side = log.support[i] - 1
        if side >= 0:
            impacts[side] += 1.0
            largest[side] = max(largest[side], abs(log.velocity[i]))
    for i in range(min(log.counts[RESTS], log.rest_start.size)):
        rests[log.rest_support[i] - 1] += 1.0
    if end.mode == REST and end.rest_start <= 0.0:
        # The log holds only rests that have ended; this one lasts over the whole orbit.
        rests[end.home - 1] += 1.0


@jit
def count_grazings(log, m, grazings) -> None:
    """Add the grazings of the log of an orbit to `grazings`, (2,), for each support.

    m : its period multiple. One at the section is met at both ends of the log, and counts once.
    """
    n = min(log.counts[GRAZINGS], log.grazing.size)
    for i in range(n):
        grazings[log.grazing_support[i] - 1] += 1.0
    is_same = n > 1 and log.grazing_support[0] == log.grazing_support[n - 1]
    if is_same and log.grazing[n - 1] - log.grazing[0] > m - SAME_GRAZING:
        grazings[log.grazing_support[0] - 1] -= 1.0


@jit
def regime_of(impacts, rests) -> int:
    """Return the code of `regime` for an orbit; impacts, rests : (2,), on each support."""
    if rests[0] + rests[1] > 0.0:
        return WITH_REST
    if impacts[0] > 0.0 and impacts[1] > 0.0:
        return TWO_SIDED
    if impacts[0] > 0.0:
        return ONE_SIDED_1
    return ONE_SIDED_2 if impacts[1] > 0.0 else NO_IMPACT


# Each function below writes nothing to an array without entries, so that one compiled kernel serves every choice of
# outputs.


@jit
def write_amplitudes(e, p, steady, log, m, c, work, amplitudes, row) -> None:
    """Write the amplitudes X(k nu/m), k = 0, 1, ..., of a closed orbit.

    e, p, c : as for `march`
    steady : SteadyState, the orbit
    m : 1 for harmonics of the force, the period multiple of the orbit for all frequencies in it
    work : tuple of ndarray, room for harmonics and energies, `room.new_work`
    amplitudes : (rows, n) complex, zero on entry, or without entries
    """
    if amplitudes.size == 0:
        return
    of_row = amplitudes[row]
    if log.pieces is not None:
        add_harmonics_of_pieces(e, p, log.pieces, m, of_row, work[0])
        for k in range(of_row.size):
            of_row[k] *= 1.0 / steady.m
    else:
        end, length = steady.end, float(steady.m)
        resting = end.home if end.mode == REST else 0
        add_support_forces(p, log, resting, end.rest_start, m, length, of_row)
        if not divide_by_stiffness(p, m, length, of_row):
            replace_resonant_harmonics(e, p, steady, log, m, of_row, work, c)


@jit
def write_harmonics(e, p, steady, log, c, work, amplitudes, subharmonics, row) -> None:
    """Write the amplitudes of a closed orbit at the multiples of nu, and at those of nu/m between them.

    e, p, steady, log, c, work, row : as for `write_amplitudes`
    amplitudes : (rows, harmonics + 1) complex, X(k nu). Zero on entry, or without entries
    subharmonics : (rows, n) complex, X(j nu/m), NaN where j is a multiple of m. NaN on entry, or without entries
    """
    write_amplitudes(e, p, steady, log, ONE_PERIOD, c, work, amplitudes, row)
    if subharmonics.size > 0 and steady.m > 1:
        subharmonics[row] = 0.0
        write_amplitudes(e, p, steady, log, steady.m, c, work, subharmonics, row)
        for j in range(0, subharmonics.shape[1], steady.m):
            subharmonics[row, j] = complex(math.nan, math.nan)


@jit
def write_multipliers(first, second, multipliers, row, third=complex(0.0, 0.0)) -> None:
    """Write the Floquet multipliers into multipliers[row], (rows, 2 or 3) complex or without entries."""
    if multipliers.size > 0:
        multipliers[row, 0] = first
        multipliers[row, 1] = second
        if multipliers.shape[1] > 2:
            multipliers[row, 2] = third


@jit
def write_orbit_exponent(rate, exponent, row) -> None:
    """Write the Lyapunov exponent `rate` of an orbit, which has no error, into exponent[row] (`RowResults`)."""
    if exponent.size > 0:
        exponent[row, 0] = rate
        exponent[row, 1] = 0.0


@jit
def orbit_exponent(p, steady, impacts):
    """Return the Lyapunov exponent of a closed orbit, log|multiplier| / (m T), T the forcing period.

    steady : SteadyState, the orbit
    impacts : (2,), its impacts on each support

    Returns -inf if the multiplier is 0: a rest erases every perturbation.
    """
    size = abs(steady.first)
    if size > 0.0:
        return math.log(size) / (steady.m * forcing_period(p))
    # Without contacts the multiplier underflowed.
    is_free = impacts[0] + impacts[1] == 0.0 and steady.end.mode != REST
    return linear_exponent(p) if is_free else -math.inf


@jit
def write_energy(e, p, steady, log, c, work, out, row) -> None:
    """Write the energies of a closed orbit: work of the force, losses by damping, at both supports, by friction.

    And its forces, if they are requested.

    e, p, c : as for `march`
    steady : SteadyState, the orbit
    work : tuple of ndarray, as for `write_amplitudes`
    out : RowResults, `energy` and `forces`: zero on entry, or without entries. The change of the stored energy, last,
        stays zero
    """
    if out.energy.size == 0:
        return
    sums = Integrals(out.energy[row], out.forces[row], work[0][:0], ONE_PERIOD)
    if log.pieces is not None:
        add_energies(e, p, log, sums)
    else:
        x, v = state_xv(p, steady.state)
        add_energy(e, p, x, v, 0.0, float(steady.m), steady.end, log, sums, c)


@jit
def add_energies(e, p, log, sums) -> None:
    """Add the energies of logged pieces and impacts to `Integrals`: those of `write_energy`."""
    add_energy_of_pieces(e, p, log.pieces, sums)
    add_losses(p, log, sums)
    if e.housing is not None:
        add_housing_energy(log.pieces.housing, p, log.pieces.counts[PIECES], sums.energy)


@jit
def write_impacts(log, m, count, position, velocity, support, row, first) -> None:
    """Write the impacts of an orbit, in order of time and at positions in [0, m).

    log : contacts of the orbit
    count : (rows,) int, number of impacts, or without entries
    position, velocity, support : (capacity,), position in forcing periods, velocity before impact, and support
    first : index of the first impact of the row
    """
    if count.size > 0:
        n = first
        for at_end in range(1, -1, -1):
            for i in range(min(log.counts[IMPACTS], log.position.size)):
                # An impact at the end of the orbit is written as the one at its start.
                if log.support[i] > 0 and (log.position[i] >= m) == (at_end == 1):
                    position[n] = log.position[i] - at_end * m
                    velocity[n] = log.velocity[i]
                    support[n] = log.support[i]
                    n += 1
        count[row] = n - first


@jit
def write_smoothness(log, grazes, releases, row) -> None:
    """Write whether an orbit grazes and when its rests end, or nothing into arrays without entries.

    What comes after a release depends on its phase alone, and each support has one such phase: an orbit is released at
    most once from each.
    """
    if grazes.size > 0:
        grazes[row] = 1 if log.counts[GRAZINGS] > 0 else 0
        for r in range(min(log.counts[RESTS], log.rest_end.size)):
            releases[row, log.rest_support[r] - 1] = log.rest_end[r]


@jit
def write_largest(largest_seen, impacts, largest, row) -> None:
    """Write the largest impact velocity on each support; NaN on a support without impacts.

    largest_seen : (2,), largest impact velocity on each support
    impacts : (2,), on each support
    largest : (rows, 2), output, or without entries
    """
    if largest.size > 0:
        for side in range(2):
            largest[row, side] = largest_seen[side] if impacts[side] > 0.0 else math.nan
