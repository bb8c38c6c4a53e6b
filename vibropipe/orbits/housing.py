"""What rows hold of a housing that may slide, and its state at the section of an orbit."""

from __future__ import annotations

from vibropipe.compiler import jit
from vibropipe.march.piece_log import (
    LARGEST,
    PIECES,
    SPAN,
    X_END,
    X_START,
)
from vibropipe.physics.housing import (
    MOVES,
    STANDS,
    Housing,
    ground_friction,
    momentum_share,
    stopped,
    total_load,
    velocity_of,
)
from vibropipe.physics.load import forcing_period

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
