"""Results of many rows: their arrays, cut, joined, and counted from x = 0."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vibropipe.orbits.contacts import CONTACT_COLUMNS
from vibropipe.orbits.forces import FORCES
from vibropipe.orbits.housing import N_COLUMNS, N_ENERGIES
from vibropipe.orbits.results import RowResults
from vibropipe.orbits.sensitivity.errors import COLUMNS
from vibropipe.orbits.sensitivity.rows import new_derivatives
from vibropipe.orbits.window import LISTED_PERIODS
from vibropipe.physics.effects import ALL_EFFECTS, Effects
from vibropipe.physics.exciter import Parameters
from vibropipe.words.outputs import OUTPUTS, computed
from vibropipe.words.parameters import ACTED, acting

# Samples of an orbit of the output `motion`.
PHASES = 256
# Multiples of nu/m of the output `subharmonics`, for each harmonic.
SUBHARMONICS_PER_HARMONIC = 4
# Largest number of impacts, and of rests, in an orbit; a row with more is unresolved. The impacts suffice for 32
# forcing periods of 256 impacts each, or for the 64 listed periods of a motion without an orbit at 128 each. Memory
# for them is reserved for every row, but only the pages that are written to are used.
ORBIT_LOG_CAPACITY = 8192
ORBIT_REST_CAPACITY = 512


class ImpactBuffer(NamedTuple):
    """Impacts of rows, one row after the other, each array (rows * ORBIT_LOG_CAPACITY,)."""

    position: np.ndarray
    velocity: np.ndarray
    support: np.ndarray


def new_impact_buffer(rows: int) -> ImpactBuffer:
    """Return a buffer for ORBIT_LOG_CAPACITY impacts of each row."""
    n = rows * ORBIT_LOG_CAPACITY
    return ImpactBuffer(np.empty(n), np.empty(n), np.empty(n, np.int8))


def new_rows(
    n: int,
    harmonics: int,
    outputs: tuple[str, ...],
    buffer: ImpactBuffer | None = None,
    effects: Effects = ALL_EFFECTS,
) -> RowResults:
    """Return empty results of n rows.

    outputs : those that are requested; the arrays of others have no entries, unless requested ones follow from them
    buffer : for the impacts of at least n rows; without one none are listed. Those of motions without an orbit are
        listed if the output is requested
    effects : soft supports or friction have one more term of the energy balance and, as a second harmonic has,
        derivatives by more parameters. A housing that may slide has quantities of its own and one more multiplier
    """
    pieces, second = effects.has_pieces, effects.second_harmonic
    outputs = computed(outputs)
    energies = N_ENERGIES if effects.housing is not None else 6 if pieces else 5
    requested = {name: name in outputs for name in OUTPUTS}
    sliding = n if effects.housing is not None else 0
    has_forces = requested["power"] or requested["frame"]

    def zeros(*shape: int, dtype: type = float, when: str | None = None) -> np.ndarray:
        return np.zeros((n if when is None or requested[when] else 0, *shape), dtype)

    impacts = new_impact_buffer(0) if buffer is None else buffer
    return RowResults(
        regime=np.zeros(n, np.int8),
        frequency=np.zeros(n),
        status=np.zeros(n, np.int8),
        period_multiple=np.zeros(n, np.int32),
        settled_after=np.zeros(n, np.int32),
        window_periods=np.zeros(n, np.int32),
        chaos=np.zeros(n, np.int8),
        residual=np.full(n, np.nan),
        section=np.zeros((n, 2)),
        impacts=np.zeros((n, 2)),
        rests=np.zeros((n, 2)),
        grazings=np.zeros((n, 2)),
        amplitudes=zeros(harmonics + 1, dtype=complex, when="harmonics"),
        multipliers=zeros(2 if effects.housing is None else 3, dtype=complex, when="stability"),
        impact_count=np.zeros(0 if buffer is None else n, np.int64),
        impact_position=impacts.position,
        impact_velocity=impacts.velocity,
        impact_support=impacts.support,
        impact_velocity_max=zeros(2, when="impacts"),
        energy=zeros(energies, when="energy"),
        forces=np.zeros((n, FORCES if has_forces else 0)),
        motion=zeros(2, PHASES, when="motion"),
        subharmonics=np.full_like(
            zeros(SUBHARMONICS_PER_HARMONIC * harmonics + 1, dtype=complex, when="subharmonics"),
            np.nan,
        ),
        poincare=zeros(2, LISTED_PERIODS, when="poincare"),
        exponent=zeros(2, when="lyapunov"),
        e_row=np.empty((0, COLUMNS)),
        e_impacts=np.empty((0, 2)),
        contacts=np.empty((0, 0)),
        housing=np.zeros((sliding, N_COLUMNS)),
        housing_harmonics=np.zeros((sliding if requested["frame"] else 0, harmonics + 1), complex),
        **new_derivatives(
            n,
            harmonics,
            SUBHARMONICS_PER_HARMONIC * harmonics,
            outputs,
            pieces,
            second,
            effects.housing,
        ),
    )


def contact_columns(outputs: Sequence[str]) -> int:
    """Return the columns of contacts with soft supports for some outputs: with `frame`, the impulse beside others."""
    return CONTACT_COLUMNS + ("frame" in outputs) if "impacts" in outputs else 0


def columns_of(parameters: np.ndarray) -> dict[str, np.ndarray]:
    """Return parameters (rows, parameters) by name, as `physics.effects` takes them."""
    return dict(zip(Parameters._fields, parameters.T, strict=True))


def acting_rows(parameters: np.ndarray) -> np.ndarray:
    """Return parameters (rows, parameters) as kernels see them."""
    if not ACTED:
        return parameters
    return np.column_stack([*acting(columns_of(parameters)).values()])


def from_equilibrium(states: np.ndarray, load: np.ndarray) -> np.ndarray:
    """Return states (rows, 2) as kernels count them, from the equilibrium at x = load (rows,)."""
    return states - np.column_stack([load, np.zeros_like(load)]) if load.any() else states


def add_load(rows: RowResults, load: np.ndarray) -> None:
    """Count the displacements of results from x = 0 instead of the equilibrium at x = load (rows,), in place."""
    if not load.any():
        return
    rows.section[:, 0] += load
    for means in (rows.amplitudes[:, :1], rows.motion[:, 0], rows.poincare[:, 0]):
        if means.size > 0:
            means += load[:, None]


def concatenate_solutions(parts: Sequence[Sequence[RowResults]]) -> list[RowResults]:
    """Join the solutions of the parts of a block, in order."""
    return [
        RowResults(*map(np.concatenate, zip(*each, strict=True)))
        for each in zip(*parts, strict=True)
    ]


def without_impacts(rows: RowResults) -> RowResults:
    """Return the results without what the output `impacts` adds."""
    names = (
        *("impact_count", "impact_position", "impact_velocity", "impact_support"),
        *("impact_velocity_max", "d_velocity_max", "d_impacts", "e_impacts", "contacts"),
    )
    return rows._replace(**{name: getattr(rows, name)[:0] for name in names})


def compact_impacts(out: RowResults) -> RowResults:
    """Return the results with copies of the impacts, without the unused capacity (contiguous ragged arrays)."""
    n = int(out.impact_count.sum())
    return out._replace(
        impact_position=out.impact_position[:n].copy(),
        impact_velocity=out.impact_velocity[:n].copy(),
        impact_support=out.impact_support[:n].copy(),
    )
