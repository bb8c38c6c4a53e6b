"""The motion of a stored row, marched on from its stored section: never from rest, which may settle elsewhere."""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from vibropipe.physics.exciter import Exciter
from vibropipe.physics.restitution import SUPPORTS, is_contact_damping
from vibropipe.physics.start import row_starts, within_room
from vibropipe.physics.ties import Ties
from vibropipe.solve.in_si import convert
from vibropipe.solve.motion.simulate import simulate
from vibropipe.solve.physical import is_physical, to_physical
from vibropipe.solve.shown_units import in_si, shown_factor, shown_in
from vibropipe.words.parameters import PARAMETERS, PHYSICAL
from vibropipe.words.status import UnsolvedWarning
from vibropipe.words.units import DIMENSIONS
from vibropipe.words.vocabulary import VOCABULARY, held_name, physical_name, physical_quantity

# Forcing periods that are drawn of a motion without an orbit, and those whose sections are.
SHOWN_PERIODS, SECTION_PERIODS = 8, 400
SAMPLES = 256


@dataclass(frozen=True)
class Motion:
    """A motion as it is drawn.

    row : the steady state
    plain : its motion, as of `simulate`, without units
    length : of the motion, in tau
    section : (visits, 2), displacement and velocity once every forcing period
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
        return in_units_of(self.row, self.plain)

    @property
    def period(self) -> float:
        """The forcing period, in the units of the row."""
        return self.exciter.period * unit_of_row(self.row, "tau")

    @property
    def soft(self) -> tuple[int, ...]:
        """The supports that yield: their contacts last, and no velocity jumps."""
        return tuple(n for n, k in enumerate((self.exciter.k1, self.exciter.k2), 1) if k > 0.0)

    @property
    def walls(self) -> dict[int, float]:
        """Positions of the supports, in the units of the row."""
        length = unit_of_row(self.row, "displacement")
        return {1: self.exciter.upper * length, 2: self.exciter.lower * length}


def exciter_of(row: xr.Dataset) -> Exciter:
    """Return the exciter of a row, or of the first row of a grid, which may be in SI.

    A damping that a restitution gives is left out, so that it follows in copies.
    """
    names = [name for name in (*PHYSICAL, *PARAMETERS) if name in row.variables]
    values = {name: float(np.ravel(in_si(row[name]))[0]) for name in names}
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


def ties_of(dataset: xr.Dataset) -> Ties:
    """Return the ties of the parameters of a dataset."""
    parts = str(dataset.attrs.get("ties", "")).split("; ")
    return Ties(dict(part.split(" = ", 1) for part in parts if part))


def tied_again(row: xr.Dataset, exciter: Exciter) -> Exciter:
    """Return an exciter whose tied parameters follow its others, and the names of one's own of a row, by its ties."""
    ties = ties_of(row)
    own = {name: float(row[name]) for name in ties.own}
    return ties.applied(exciter, own)


def changed_row(row: xr.Dataset, changed: dict[str, float]) -> xr.Dataset:
    """Return a row or a grid with other parameters; without a damping that a restitution gives, which follows them."""
    exciter, si = exciter_of(row), is_physical(row)
    held = {h: physical_name(h) if si else h for _R, _k, h in SUPPORTS}
    follow = [held[h] for h in held if not exciter.states(h) and held[h] not in changed]
    units = shown_in(row)

    def attrs(name: str) -> dict[str, Any]:
        if name in row.coords or not si:
            return dict(row[name].attrs) if name in row.coords else {}
        stored = DIMENSIONS[PHYSICAL[name].dimension].units
        return {"units": units.unit(name, stored)}

    coords = {name: ((), value, attrs(name)) for name, value in changed.items()}
    return row.drop_vars(follow, errors="ignore").assign_coords(coords)


def mass_and_stiffness(row: xr.Dataset) -> dict[str, float] | None:
    """Return m and C, in SI, of a dataset with units."""
    return {name: float(in_si(row[name])) for name in ("m", "C")} if is_physical(row) else None


def unit_of_row(row: xr.Dataset, name: str) -> float:
    """Return the value, in the units of a row, of a quantity that is 1 without units."""
    si = mass_and_stiffness(row)
    if si is None or name not in VOCABULARY:
        return 1.0
    unit = shown_in(row).unit(physical_name(name), physical_quantity(name).units)
    return float(convert(name, 1.0, si)) * shown_factor(unit)


def in_units_of(row: xr.Dataset, plain: xr.Dataset) -> xr.Dataset:
    """Return a dataset without units in the units of a row."""
    si = mass_and_stiffness(row)
    return plain if si is None else shown_in(row).dataset(to_physical(plain, si["m"], si["C"]))


def without_units(row: xr.Dataset, name: str, value: float | None = None) -> float:
    """Return a value of a quantity (default: that of the row), which may have units, without them."""
    number = float(row[held_name(row, name)]) if value is None else value
    return number / unit_of_row(row, name)


def section_of(row: xr.Dataset, exciter: Exciter) -> tuple[float, float]:
    """Return the stored state at the section without units, moved by rounding onto a rigid support that it is on."""
    x, v = (without_units(row, f"{name}_strobe") for name in ("displacement", "velocity"))
    parameters = np.array([exciter.parameters()])
    return float(row_starts(parameters, within_room(exciter, x), v)[0, 0]), v


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
    visits = in_units_of(row, visits)
    section = np.stack([visits["displacement"].values, visits["velocity"].values], axis=1)
    return Motion(row, plain, length, section, exciter)


def _marched(exciter: Exciter, length: float, x: float, v: float, samples: int) -> xr.Dataset:
    """March a motion; its status is part of it."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UnsolvedWarning)
        return simulate(exciter, tau_end=length, x0=x, v0=v, samples_per_period=samples)
