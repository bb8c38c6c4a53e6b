"""A frequency that changes linearly in time, and the instants of a force with it.

Functions of a force take its phase in turns or, on a ramp, a `Moment`: of which both is known when they are compiled.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from numba import types
from numba.extending import overload

from vibropipe.compiler import jit_inline
from vibropipe.physics.turns import TWO_PI


class Ramp(NamedTuple):
    """A frequency that changes linearly, from `nu` at s = 0, and the force with it.

    nu, change : frequency at s = 0, and its change per unit of time
    turn : phase at s = 0, in turns
    f, shaker : the first harmonic is f sin(phase) - shaker (sin(phase))''
    """

    nu: float
    change: float
    turn: float
    f: float = 0.0
    shaker: float = 0.0
    span: float = 0.0


class Moment(NamedTuple):
    """A time s after the start of a ramp; waits from it are counted in `unit`."""

    ramp: Ramp
    s: float
    unit: float


@jit_inline
def frequency_at(ramp, s):
    """Return the frequency at a time s after the start."""
    return ramp.nu + ramp.change * s


@jit_inline
def turn_at(ramp, s):
    """Return the phase, in turns, at a time s after the start."""
    return ramp.turn + s * (ramp.nu + 0.5 * ramp.change * s) / TWO_PI


def ramp_of(grid: Any) -> Ramp | None:
    """Return the ramp of a grid; None of one that has a forcing period."""
    return getattr(grid, "ramp", None)


@overload(ramp_of)
def _compiled_ramp(grid):
    if "ramp" in getattr(grid, "fields", ()):
        return lambda grid: grid.ramp
    return lambda grid: None


def moment_of(phase: Any) -> Moment | None:
    """Return a phase that is a `Moment`; None of one in turns."""
    return phase if isinstance(phase, Moment) else None


@overload(moment_of)
def _compiled_moment(phase):
    if isinstance(phase, types.NamedTuple) and phase.instance_class is Moment:
        return lambda phase: phase
    return lambda phase: None
