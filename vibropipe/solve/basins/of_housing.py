"""The motions that an exciter with a housing that slides settles on: steady states, told apart by what they show.

The section map has three dimensions then, and starts lie in a plane of it, with a housing at rest. Each start is solved
as a row by itself; no neighbourhood of an orbit is known that no motion leaves.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.physics.effects import all_effects, has_soft_support
from vibropipe.physics.exciter import Exciter
from vibropipe.solve.rows.label import label_rows
from vibropipe.solve.rows.many import RowLimits, Rows, solve_rows
from vibropipe.solve.threads import row_blocks
from vibropipe.words.progress import Progress
from vibropipe.words.regimes import Regime
from vibropipe.words.status import Status

if TYPE_CHECKING:
    from collections.abc import Mapping

OUTPUTS = ("harmonics", "impacts", "stability")
HARMONICS, LIMITS = 3, RowLimits(5000, 200)
# Orbits are the same where all that is compared differs by less than this share of l, or of l nu.
SAME = 1e-6
# An orbit attracts if its largest multiplier is below 1 by more than rounding.
NEUTRAL = 1e-9
NONE = -1


def settle_rows(
    exciter: Exciter, starts: np.ndarray, progress: Progress | None = None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return which motion each start settles on, forcing periods until it has, and a start of each motion.

    Orbits are one where period multiple, impacts, mean displacement, amplitudes, impact velocities and the progression
    of the housing agree, motions without an orbit where the housing goes the same way.

    exciter : with a housing that slides
    starts : (n, 2), displacements and velocities at tau = 0, with the housing at rest
    progress : called as progress(done, total), in starts
    Returns the number (n,) of each motion, orbits first, by period multiple and then by progression, -1 where none was
    found.
    """
    row = np.array([exciter.parameters()])
    values = exciter.stated()
    effects = all_effects(values, pieces=True, housing=True)

    def parameters(begin: int, stop: int) -> list[np.ndarray]:
        return [np.repeat(row, stop - begin, axis=0)]

    def start_of(begin: int, stop: int) -> tuple[np.ndarray, np.ndarray]:
        return starts[begin:stop, 0], starts[begin:stop, 1]

    blocks = solve_rows(
        row_blocks(len(starts)), Rows(parameters, start_of), LIMITS, HARMONICS, OUTPUTS, progress,
        effects, has_soft_support(values),
    )  # fmt: skip
    ((_stop, (solved,)),) = blocks
    labelled = label_rows(solved, np.repeat(row, len(starts), axis=0), OUTPUTS)
    shown = {name: array for name, (dims, array) in labelled.items() if dims[0] == "row"}
    owner, first = same_motions(shown, exciter.l, exciter.l * exciter.nu)
    return owner, shown["periods_to_settle"], starts[first]


def same_motions(
    shown: Mapping[str, np.ndarray], length: float, velocity: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the number of the motion of each row, -1 for none, and the first row of each motion.

    shown : quantities of the rows by name; length, velocity : of what a difference is a share
    """
    m, speed = shown["period_multiple"], shown["housing_velocity_mean"]
    is_orbit = (shown["status"] == Status.OK) & (m > 0)
    attracts = np.abs(shown["floquet_multiplier"]).max(axis=1) < 1.0 - NEUTRAL
    # How many impacts of a chatter are counted is decided by rounding.
    impacts = np.where(shown["rests_per_orbit"] > 0, 0.0, shown["impacts_per_orbit"])
    counts = [m, impacts, shown["rests_per_orbit"]]
    lengths = [shown["displacement_mean"], shown["displacement_amplitude"]]
    velocities = [speed, np.nan_to_num(shown["impact_velocity_max"])]
    compared = np.column_stack(
        [*counts, *(each / length for each in lengths), *(each / velocity for each in velocities)]
    )
    way = np.where(np.abs(speed) > SAME * shown["housing_velocity_max"], np.sign(speed), 0.0)
    found: list[tuple[Any, np.ndarray]] = []
    left = np.flatnonzero(is_orbit & attracts)
    while left.size:
        is_same = (np.abs(compared[left] - compared[left[0]]) < SAME).all(axis=1)
        found.append(((int(m[left[0]]), float(speed[left[0]])), left[is_same]))
        left = left[~is_same]
    for sign in (-1.0, 0.0, 1.0):
        rows = np.flatnonzero((shown["regime"] == Regime.APERIODIC) & (way == sign))
        if rows.size:
            found.append(((np.inf, sign), rows))
    found.sort(key=lambda each: each[0])
    owner = np.full(m.size, NONE)
    for number, (_key, rows) in enumerate(found):
        owner[rows] = number
    return owner, np.array([rows[0] for _key, rows in found], int)
