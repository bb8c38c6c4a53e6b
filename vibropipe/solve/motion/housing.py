"""What a motion shows of a housing that may slide: its slips, its samples and its end."""

from __future__ import annotations

import numpy as np

from vibropipe.march.log import Samples
from vibropipe.march.state import State
from vibropipe.physics.exciter import Parameters
from vibropipe.physics.housing import velocity_of


def slips_of(start: np.ndarray, way: np.ndarray) -> dict[str, np.ndarray]:
    """Return the slips of a housing, each one way, from the starts of pieces (n,) and its ways in them (n,)."""
    begins = np.flatnonzero(np.append(True, way[1:] != way[:-1])) if way.size else np.empty(0, int)
    ends = np.append(start[begins[1:]], np.inf)[: begins.size]
    slides = way[begins] != 0
    return {
        "housing_slip_start": start[begins][slides],
        "housing_slip_end": ends[slides],
        "housing_slip_direction": way[begins][slides],
    }


def housing_of(
    p: Parameters, state: State, v: float, samples: Samples | None, velocity: float
) -> np.ndarray | None:
    """Return what a motion from a velocity of its housing, which ends in a state, shows of that (`MotionResult`)."""
    if state.housing is None:
        return None
    # nan where the motion was stopped
    end = velocity_of(p, state.housing, v) + 0.0 * v, state.housing.displacement + 0.0 * v
    recorded = np.empty((0, 2))
    if samples is not None and samples.housing is not None:
        recorded = samples.housing
    if len(recorded) > 0:
        # As of the mass, the first sample is the start that was asked for.
        recorded[0] = velocity, 0.0
    return np.vstack([recorded, [end]])
