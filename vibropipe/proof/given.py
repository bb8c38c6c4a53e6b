"""The orbit that a proof is about, from an exciter or from a row of a dataset, and the box around its exciter."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from vibropipe.physics.effects import all_effects
from vibropipe.physics.exciter import Exciter, ParameterError
from vibropipe.physics.parameter_error import check_keys, number_within
from vibropipe.solve.motion.simulate import simulate
from vibropipe.solve.physical import is_physical
from vibropipe.solve.rebuild import exciter_of, section_of
from vibropipe.solve.rows.steady import steady_state
from vibropipe.words.parameters import PARAMETERS
from vibropipe.words.proofs import BOXED
from vibropipe.words.records import POSITIVE

# The time of a proof grows with the cube of the impacts in the end; 28 took half a second.
MAX_IMPACTS = 100
KNOWN = "an exciter, or one row of a steady state, a sweep, a branch or an orbit in closed form"


class Given(NamedTuple):
    """An orbit: forcing periods m, supports struck in turn, times (in forcing periods) and velocities of impacts."""

    exciter: Exciter
    m: int
    supports: tuple[int, ...]
    times: np.ndarray
    velocities: np.ndarray


def given_orbit(orbit: Any) -> Given:
    """Return the settled orbit of an exciter, or the orbit of a row.

    Raises
    ------
    ParameterError
        If it is none of both, has an effect that is not proved, or no orbit with impacts and without rests.
    """
    if not isinstance(orbit, (Exciter, xr.Dataset)):
        raise ParameterError("orbit", orbit, KNOWN, got=type(orbit).__name__)
    exciter = orbit if isinstance(orbit, Exciter) else _exciter_of_row(orbit)
    all_effects(vars(exciter))
    row = steady_state(exciter, outputs=("impacts",)) if isinstance(orbit, Exciter) else orbit
    m = int(row["period_multiple"])
    if m == 0:
        must = "must have an orbit: its motion repeats after no number of forcing periods that was tried"
        raise ParameterError("orbit", orbit, must=must, got="")
    if "rests_per_orbit" in row and bool((row["rests_per_orbit"] != 0).any()):
        raise ParameterError("orbit", orbit, must="must not rest on a support", got="")
    n = int(row["impacts_per_orbit"].sum())
    if n > MAX_IMPACTS:
        raise ParameterError(
            "orbit", orbit, must=f"must have at most {MAX_IMPACTS} impacts", got=str(n)
        )
    if n == 0:
        must = "must strike a support: a motion without impacts is known in closed form"
        raise ParameterError("orbit", orbit, must=must, got="")
    times, supports, velocities = _impacts(row, exciter, m, n)
    if not (np.isfinite(times).all() and np.isfinite(velocities).all()):
        raise ParameterError("orbit", orbit, must="must exist", got="one without numbers")
    return Given(exciter, m, tuple(int(each) for each in supports), times, velocities)


def _exciter_of_row(row: xr.Dataset) -> Exciter:
    """Return the exciter of a dataset that has one orbit."""
    missing = [name for name in ("period_multiple", "impacts_per_orbit", "l") if name not in row]
    if missing or row["impacts_per_orbit"].dims != ("support",):
        must = f"must be {KNOWN}: select it, as with .isel(point=0)"
        got = (
            f"a dataset without {missing[0]}"
            if missing
            else f"one over {row['impacts_per_orbit'].dims}"
        )
        raise ParameterError("orbit", row, must=must, got=got)
    exciter = exciter_of(row)
    exciter.check_frequency()
    return exciter


def _impacts(row: xr.Dataset, exciter: Exciter, m: int, n: int) -> tuple[Any, Any, Any]:
    """Return times, supports and velocities of the n impacts: as stored, or marched from the section."""
    is_stored = "impact_phase" in row and row["impact_phase"].shape == (n,)
    if is_stored and not is_physical(row):
        times = (row["impact_phase"] + row["impact_period"]).values
        return times, row["impact_support"].values, row["impact_velocity"].values
    x, v = section_of(row, exciter)
    motion = simulate(exciter, m * exciter.period, x, v, samples_per_period=0)
    if motion.sizes["impact"] != n:
        must = f"must have its {n} impacts: of a branch or a sweep select also them, by row_size"
        raise ParameterError(
            "orbit", row, must=must, got=f"a row from whose section {motion.sizes['impact']} follow"
        )
    times = motion["impact_tau"].values / exciter.period
    return times, motion["impact_support"].values, motion["impact_velocity"].values


def check_within(exciter: Exciter, within: Mapping[str, float]) -> dict[str, float]:
    """Return how far parameters may be off, or raise a ParameterError."""
    check_keys("within", within, BOXED)
    checked = {name: number_within(f"within.{name}", within[name], POSITIVE) for name in within}
    name = first_out_of_range(exciter, checked)
    if name:
        range_ = PARAMETERS[name].range
        must = f"must keep {name} {range_.text}"
        got = f"{getattr(exciter, name)!r} +- {checked[name]!r}"
        raise ParameterError(f"within.{name}", checked[name], must=must, got=got)
    return checked


def first_out_of_range(exciter: Exciter, within: Mapping[str, float], factor: float = 1.0) -> str:
    """Return the first parameter that may leave its range; "" if none may."""
    for name, most in within.items():
        value, off = getattr(exciter, name), most * factor
        if not all(PARAMETERS[name].range.contains(end) for end in (value - off, value + off)):
            return name
    return ""
