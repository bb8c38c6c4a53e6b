"""What rows hold of a housing that may slide, and its state at the section of an orbit."""

from __future__ import annotations

from vibropipe.compiler import jit
from vibropipe.march.piece_log import (
    AT,
    HOME,
    LARGEST,
    P_END,
    P_START,
    PIECES,
    SPAN,
    X_END,
    X_START,
    Y_END,
    Y,
)
from vibropipe.orbits.forces import Integrals
from vibropipe.orbits.harmonics import ONE_PERIOD
from vibropipe.orbits.pieces import end_of_piece, integral_of_piece, integrate_piece
from vibropipe.physics.contact import to_displacement
from vibropipe.physics.housing import (
    MOVES,
    STANDS,
    Housing,
    ground_friction,
    momentum_rate,
    momentum_share,
    stopped,
    total_load,
    velocity_of,
)
from vibropipe.physics.load import forcing_period
from vibropipe.physics.turns import TWO_PI, phase_factor, phase_integral

# Columns of `RowResults.housing`.
# The last is the momentum of both bodies at the start of a window.
STROBE, MEAN, LARGEST_SPEED, SLIP_SHARE, START, N_COLUMNS = range(6)
# Energies of a row: loss by friction of the ground, and work of the loads on the housing, after those of pieces.
GROUND, LOADS, N_ENERGIES = 5, 6, 8


@jit
def add_housing_period(pieces, p, start, end, totals) -> None:
    """Add a marched stretch to totals, (N_COLUMNS,), or without entries.

    Its displacement to `MEAN`, its forcing periods of sliding to `SLIP_SHARE`, and its largest speed.
    """
    if pieces is None:
        return
    add_slips(pieces.housing, pieces, p, start.housing, end.housing, totals)


@jit
def add_slips(log, pieces, p, start, end, totals) -> None:
    """Add what `add_housing_period` does; log : `pieces.housing`; start, end : `Housing` or None."""
    if log is None:
        return
    totals[MEAN] += end.displacement - start.displacement
    for i in range(pieces.counts[PIECES]):
        totals[LARGEST_SPEED] = max(totals[LARGEST_SPEED], log.values[i, LARGEST])
        if log.way[i] != STANDS:
            totals[SLIP_SHARE] += pieces.values[i, SPAN] / forcing_period(p)


@jit
def continue_housing(housing, row, chain_length) -> None:
    """Let the housing of a row within a chain start as that of the row before ends; housing : `RowResults.housing`."""
    if housing.size > 0 and row % chain_length > 0:
        housing[row, STROBE] = housing[row - 1, STROBE]


@jit
def write_housing(pieces, p, steady, housing, row) -> None:
    """Write what a closed orbit shows of its housing into housing[row], (rows, N_COLUMNS) or without entries."""
    if housing.size > 0:
        totals = housing[row]
        totals[MEAN], totals[LARGEST_SPEED], totals[SLIP_SHARE] = 0.0, 0.0, 0.0
        add_housing_period(pieces, p, steady.state, steady.end, totals)
        close_housing(p, steady.m, totals)


@jit
def add_housing_harmonics(pieces, e, p, out, direct) -> None:
    """Add the integrals of X'' exp(-i k nu tau) over all logged pieces, impacts included, to out[k].

    pieces : PieceLog or None
    out : (harmonics + 1,) complex, in units of X'' times forcing periods; or without entries
    direct : (harmonics + 1,) complex, work array
    """
    if pieces is not None and out.size > 0:
        add_accelerations(pieces.housing, pieces, e, p, out, direct)


@jit
def add_accelerations(log, pieces, e, p, out, direct) -> None:
    """Add what `add_housing_harmonics` does; log : `pieces.housing`.

    The integral is i k nu times the one of X' = P - c x', which is zero where the housing is held: the impulses of
    impacts are its jumps. By parts P needs its ends and its constant rate, x' its ends and the integral of x.
    """
    if log is None:
        return
    per_turn, share = p.nu / TWO_PI, momentum_share(p)
    for i in range(pieces.counts[PIECES]):
        if log.way[i] == STANDS:
            continue
        is_accurate = True
        for k in range(out.size):
            direct[k] = 0.0
            is_accurate = is_accurate and integral_of_piece(e, p, pieces, i, k, ONE_PERIOD)[1]
        if not is_accurate:
            sums = Integrals(pieces.energy, pieces.energy[:0], direct[: out.size], ONE_PERIOD)
            integrate_piece(e, p, pieces, i, sums)
        start, end = pieces.values[i, AT], end_of_piece(p, pieces, i)
        x_start = to_displacement(p, pieces.codes[i, HOME], pieces.values[i, Y])
        x_end = to_displacement(p, pieces.codes[i, HOME], pieces.values[i, Y_END])
        rate = momentum_rate(p, log.way[i])
        for k in range(out.size):
            first, last = phase_factor(k * start), phase_factor(k * end)
            whole, is_accurate = integral_of_piece(e, p, pieces, i, k, ONE_PERIOD)
            whole, w = whole if is_accurate else direct[k], k * p.nu
            out[k] += rate * phase_integral(k, start, end) + share * w * w * whole
            momentum = log.values[i, P_END] * last - log.values[i, P_START] * first
            moved = x_end * last - x_start * first
            out[k] -= (momentum + complex(0.0, share * w) * moved) * per_turn


@jit
def write_housing_harmonics(pieces, e, p, m, direct, harmonics, row) -> None:
    """Write those of X'' of a closed orbit of m periods into harmonics[row], (rows, n) or without entries."""
    if harmonics.size > 0:
        add_housing_harmonics(pieces, e, p, harmonics[row], direct)
        for k in range(harmonics.shape[1]):
            harmonics[row, k] *= 1.0 / m


@jit
def add_housing_energy(log, p, n, energy) -> None:
    """Add what n logged pieces lose and gain on the ground to `energy`; log : `HousingLog` or None."""
    if log is None:
        return
    for i in range(n):
        drift = log.values[i, X_END] - log.values[i, X_START]
        energy[GROUND] += ground_friction(p, log.way[i]) * drift
        energy[LOADS] += total_load(p) * drift


@jit
def momentum_of(housing) -> float:
    """Return the momentum of both bodies; 0 without a housing."""
    if housing is None:
        return 0.0
    return housing.momentum


@jit
def close_housing(p, periods, totals) -> None:
    """Convert sums over so many forcing periods to means."""
    totals[MEAN] /= periods * forcing_period(p)
    totals[SLIP_SHARE] = min(1.0, totals[SLIP_SHARE] / periods)  # it slides no longer than that


@jit
def strobe_of(p, state_housing, v) -> float:
    """Return the velocity of a `Housing` at the velocity v of x; 0 without one."""
    if state_housing is None:
        return 0.0
    return velocity_of(p, state_housing, v)


@jit
def momentum_difference(frame, after, before) -> float:
    """Return the difference of two momenta of `Housing` in a frame; 0 without one."""
    if before is None:
        return 0.0
    return frame.sigma * (after.momentum - before.momentum)


@jit
def shifted(p, frame, housing, after, v, dp):
    """Return a housing whose momentum is changed by dp in a frame, at the velocity v of x; None without one.

    One that is held, and is so again `after` the orbit, stays without velocity.
    """
    if housing is None:
        return housing
    if housing.way == STANDS and after.way == STANDS:
        return stopped(p, housing, v)
    momentum = housing.momentum + frame.sigma * dp
    velocity = momentum - momentum_share(p) * v
    way = 1 if velocity > 0.0 else -1 if velocity < 0.0 else STANDS
    return Housing(way, MOVES, momentum, housing.displacement)
