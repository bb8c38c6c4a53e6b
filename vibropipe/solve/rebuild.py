"""The motion of a stored row, marched on from its stored section: never from rest, which may settle elsewhere."""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from vibropipe.physics.exciter import Exciter
from vibropipe.physics.restitution import SUPPORTS, is_contact_damping
from vibropipe.physics.start import start_at
from vibropipe.solve.motion import simulate
from vibropipe.solve.physical import convert, is_physical, to_physical
from vibropipe.words.parameters import PARAMETERS, PHYSICAL
from vibropipe.words.status import UnsolvedWarning
from vibropipe.words.vocabulary import held_name, physical_name

# Forcing periods that are drawn of a motion without an orbit, and those whose sections are.
SHOWN_PERIODS, SECTION_PERIODS = 8, 400
SAMPLES = 256


@dataclass(frozen=True)
class Motion:
    """A motion as it is drawn.

    Parameters
    ----------
    row : xarray.Dataset
        The steady state.
    plain : xarray.Dataset
        Its motion, as of `simulate`, without units.
    length : float
        Length of the motion in tau.
    section : (visits, 2) array
        Displacement and velocity once every forcing period.
    exciter : Exciter
    """

    row: xr.Dataset
    plain: xr.Dataset
    length: float
    section: NDArray[np.float64]
    exciter: Exciter

    @property
    def is_orbit(self) -> bool:
        """Whether the motion repeats."""
        return int(self.row["period_multiple"]) > 0

    @cached_property
    def curves(self) -> xr.Dataset:
        """The motion in the units of the row."""
        si = mass_and_stiffness(self.row)
        return self.plain if si is None else to_physical(self.plain, **si)

    @property
    def period(self) -> float:
        """The forcing period, in the units of the row."""
        si = mass_and_stiffness(self.row)
        return self.exciter.period * (1.0 if si is None else float(convert("tau", 1.0, si)))

    @property
    def soft(self) -> tuple[int, ...]:
        """The supports that yield: their contacts last, and no velocity jumps."""
        return tuple(n for n, k in enumerate((self.exciter.k1, self.exciter.k2), 1) if k > 0.0)

    @property
    def walls(self) -> dict[int, float]:
        """Positions of the supports."""
        return {1: self.exciter.upper, 2: self.exciter.lower}


def exciter_of(row: xr.Dataset) -> Exciter:
    """Return the exciter of a row, or of the first row of a grid, which may be in SI.

    A damping that a restitution gives is left out, so that it follows in copies.
    """
    names = [name for name in (*PHYSICAL, *PARAMETERS) if name in row.variables]
    values = {name: float(np.ravel(row[name].values)[0]) for name in names}
    if is_physical(row):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of far supports
            exciter = Exciter.from_physical(**values)
    else:
        exciter = Exciter(**values)
    follow = {
        h: None
        for R, k, h in SUPPORTS
        if is_contact_damping(*(getattr(exciter, name) for name in (h, R, k)))
    }
    return Exciter(**{**vars(exciter), **follow})


def changed_row(row: xr.Dataset, changed: dict[str, float]) -> xr.Dataset:
    """Return a row or a grid with other parameters; without a damping that a restitution gives, which follows them."""
    exciter, si = exciter_of(row), is_physical(row)
    held = {h: physical_name(h) if si else h for _R, _k, h in SUPPORTS}
    follow = [held[h] for h in held if not exciter.states(h) and held[h] not in changed]
    return row.drop_vars(follow, errors="ignore").assign_coords(changed)


def mass_and_stiffness(row: xr.Dataset) -> dict[str, float] | None:
    """Return m and C of a dataset in SI."""
    return {name: float(row[name]) for name in ("m", "C")} if is_physical(row) else None


def without_units(row: xr.Dataset, name: str, value: float | None = None) -> float:
    """Return a value of a quantity (default: that of the row), which may be in SI, without units."""
    si = mass_and_stiffness(row)
    number = float(row[held_name(row, name)]) if value is None else value
    return number if si is None else number / float(convert(name, 1.0, si))


def section_of(row: xr.Dataset, exciter: Exciter) -> tuple[float, float]:
    """Return the stored state at the section without units, moved by rounding onto a support that it is on."""
    x, v = (without_units(row, f"{name}_strobe") for name in ("displacement", "velocity"))
    x = min(max(x, exciter.lower), exciter.upper)
    return float(start_at(exciter.l, exciter.delta, x, v)), v


def motion_of(row: xr.Dataset) -> Motion | None:
    """Return the motion of a row from its stored section on; None if the row has none.

    An orbit is drawn once; of a motion without one, SHOWN_PERIODS forcing periods, and its section for SECTION_PERIODS.
    """
    exciter = exciter_of(row)
    x, v = section_of(row, exciter)
    if not (math.isfinite(x) and math.isfinite(v)):
        return None
    multiple = int(row["period_multiple"])
    length = SHOWN_PERIODS * exciter.period
    if multiple > 0:
        length = 2.0 * math.pi / without_units(row, "base_frequency")
    plain = _marched(exciter, length, x, v, SAMPLES)
    if multiple > 0:
        visits = plain.isel(tau=slice(None, None, SAMPLES)).isel(tau=slice(0, multiple))
    else:
        visits = _marched(exciter, SECTION_PERIODS * exciter.period, x, v, 1)
    si = mass_and_stiffness(row)
    visits = visits if si is None else to_physical(visits, **si)
    section = np.stack([visits["displacement"].values, visits["velocity"].values], axis=1)
    return Motion(row, plain, length, section, exciter)


def _marched(exciter: Exciter, length: float, x: float, v: float, samples: int) -> xr.Dataset:
    """March a motion; its status is part of it."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UnsolvedWarning)
        return simulate(exciter, tau_end=length, x0=x, v0=v, samples_per_period=samples)
