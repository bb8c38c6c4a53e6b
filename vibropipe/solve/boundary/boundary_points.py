"""Boundaries of orbits by their laws: from settled orbits, and their points as variables."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from vibropipe.continuation.curve import Point
from vibropipe.orbits.boundaries.curve import GRAZINGS, Box
from vibropipe.orbits.boundaries.law_curve import LawBoundary
from vibropipe.orbits.boundaries.level_curve import Level
from vibropipe.orbits.boundaries.search import Boundary, Settled, find_boundaries, is_spent
from vibropipe.orbits.boundaries.seeds import MAX_CONTACTS
from vibropipe.orbits.housing_jacobian import eigenvalues_of_cubic
from vibropipe.orbits.law.marching import Marcher
from vibropipe.orbits.law.steps import DETERMINANT, GAP, MINORS, SPEED, TRACE
from vibropipe.orbits.return_map import floquet_multipliers
from vibropipe.physics.exciter import Parameters
from vibropipe.physics.limits import MAX_CALL_WORK, START_WORK
from vibropipe.solve.branch.branch_of_pieces import MIN_SIZE
from vibropipe.solve.rows.label import Variables
from vibropipe.words.parameters import DEFAULTS

if TYPE_CHECKING:
    import xarray as xr

L, LOAD = Parameters._fields.index("l"), Parameters._fields.index("load")
# Margin, weighted, of an orbit with which its law ends.
NO_MARGIN = 1e-10


def boundaries_of_rows(
    box: Box, rows: list[xr.Dataset], of: tuple[str, ...], levels: Sequence[Level] = ()
) -> tuple[list[Boundary], str]:
    """Return the boundaries that are reached from solved rows, and what may be missing, "" if nothing.

    rows : steady states with their first harmonic and impacts, over `row`
    of : kinds
    """
    orbits = [orbit for each in rows for orbit in _orbits_of(each, box)]
    n = sum(each.sizes["row"] for each in rows)
    # An orbit of impacts alone has no rests.
    effects = box.effects if box.effects.has_pieces else box.effects._replace(rest=None)
    marcher = Marcher(effects, MAX_CALL_WORK + 2 * START_WORK * n)
    boundaries, is_complete = find_boundaries(box, orbits, of, marcher, levels)
    if is_spent(marcher):
        return boundaries, "found in the steps of one call; there may be more"
    return boundaries, "" if is_complete else "followed, the most of one call; there are more"


def _orbits_of(rows: xr.Dataset, box: Box) -> Iterator[Settled]:
    """Yield the orbits of solved rows of a box; between rigid supports those that are followed by their impacts."""
    multiples, parameters = rows["period_multiple"].values, values_of(rows, box)
    x = rows["displacement_strobe"].values - parameters[LOAD]
    v = rows["velocity_strobe"].values
    states = [x, v]
    if "housing_velocity_strobe" in rows:
        states.append(rows["housing_velocity_strobe"].values)
    amplitude = rows["displacement_amplitude"].max("harmonic").values
    size = np.maximum(np.maximum(amplitude, np.abs(x)), MIN_SIZE * parameters[L])
    speed = np.maximum(parameters[0] * size, np.abs(v))
    sizes, rests = rows["row_size"].values, rows["rests_per_orbit"].sum("support").values
    times = (rows["impact_phase"] + rows["impact_period"]).values
    ends = np.cumsum(sizes)
    for row in np.flatnonzero(multiples > 0):
        struck = None
        if not box.effects.has_pieces:
            if rests[row] or sizes[row] > MAX_CONTACTS:
                continue
            part = slice(ends[row] - sizes[row], ends[row])
            supports = rows["impact_support"].values[part].astype(np.int8)
            struck = supports, np.append(times[part], rows["impact_velocity"].values[part])
        yield Settled(
            parameters[:, row].copy(), int(multiples[row]), np.array([each[row] for each in states]),
            float(size[row]), float(speed[row]), struck,
        )  # fmt: skip


def values_of(rows: xr.Dataset, box: Box) -> np.ndarray:
    """Return the values (names, rows) of solved rows of a box; what the dataset leaves out is tied, or absent."""
    shape, tied = rows["period_multiple"].shape, box.tied
    values = np.array(
        [
            np.broadcast_to(
                rows[name].values if name in rows.coords else DEFAULTS.get(name, math.nan), shape
            )
            for name in (Parameters._fields if tied is None else tied.names)
        ],
        float,
    )
    if tied is not None:
        for column in values.T:
            tied.fill(column)
    return values


def multipliers_at(curve: LawBoundary, point: Point) -> np.ndarray:
    """Return the Floquet multipliers (w,) of an orbit on a boundary, the largest modulus first.

    Where its law ends, what is read off the orbit is rounding divided by the speed of an impact, or the length of a
    rest, that vanishes. There one of two is that of the bifurcation, and the other follows; of three they are NaN.
    """
    trace, determinant = point.tests[TRACE], point.tests[DETERMINANT]
    minors = point.tests[MINORS] if curve.width > 2 else determinant
    if curve.kind != GRAZINGS and point.tests[[SPEED, GAP]].min() < NO_MARGIN:
        if curve.width > 2:
            return np.full(curve.width, math.nan, complex)
        trace = curve.wrap * (1.0 + determinant)
    if curve.sequence.mirrored:
        # Of the whole orbit, which is the map to the mirror image twice.
        trace, minors, determinant = (
            trace * trace - 2.0 * minors,
            minors * minors - 2.0 * trace * determinant,
            determinant * determinant,
        )
    if curve.width > 2:
        return np.array(eigenvalues_of_cubic(trace, minors, determinant))
    return np.array(floquet_multipliers(trace, -determinant, 1.0, 0.0))


def _without_unit(multipliers: np.ndarray) -> np.ndarray:
    """Return multipliers (n, 3) without the one of each that is 1 or -1, (n, 2)."""
    away = np.minimum(np.abs(multipliers - 1.0), np.abs(multipliers + 1.0))
    at = away.argmin(axis=1)
    return np.array([np.delete(row, unit) for row, unit in zip(multipliers, at, strict=True)])


def label_points(boundary: Boundary) -> Variables:
    """Return the quantities of the points of a boundary, named and shaped as those of solved rows."""
    curve, points = boundary.curve, boundary.points
    assert isinstance(curve, LawBoundary)
    n = len(points)
    multipliers, fastest = np.empty((n, curve.width), complex), np.empty((n, 2))
    strobe, loads = np.empty((n, curve.width)), np.empty(n)
    for i, point in enumerate(points):
        multipliers[i] = multipliers_at(curve, point)
        strobe[i] = curve.state_at(point)
        fastest[i] = curve.fastest(point)
        loads[i] = curve.parameters_of(point.u).load
    first, second = curve.contacts()
    largest = np.abs(multipliers).max(axis=1)
    if curve.kind != GRAZINGS:
        # One multiplier is 1 or -1, and the product of both, the determinant, is the other's modulus.
        with np.errstate(invalid="ignore"):  # infinite times unknown where an impact has no speed
            largest = np.abs(multipliers.prod(axis=1))
        if curve.width > 2:
            largest = np.abs(_without_unit(multipliers)).max(axis=1)
    for i in np.flatnonzero(np.isnan(largest)).tolist():
        largest[i] = largest[min(1, n - 1) if i == 0 else i - 1]
    of_housing = {"housing_velocity_strobe": (("row",), strobe[:, 2])} if curve.width > 2 else {}
    return {
        **of_housing,
        "period_multiple": (("row",), np.full(n, curve.sequence.m, np.int32)),
        "impacts_per_orbit": (("row", "support"), np.tile([float(first), float(second)], (n, 1))),
        "impact_velocity_max": (("row", "support"), fastest),
        "displacement_strobe": (("row",), strobe[:, 0] + loads),
        "velocity_strobe": (("row",), strobe[:, 1]),
        "floquet_multiplier": (("row", "multiplier"), multipliers),
        "stable": (("row",), (largest < 1.0).astype(np.int8)),
    }
