"""Boundaries and level curves as a labelled dataset: the points of all in a row, and what they meet."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.orbits.boundaries.curve import GRAZINGS, Box
from vibropipe.orbits.boundaries.level_curve import Level, LevelCurve
from vibropipe.orbits.boundaries.search import Boundary
from vibropipe.orbits.law.curve import LawZeros
from vibropipe.orbits.law.marching import Marcher
from vibropipe.physics.effects import NOT_COMPUTED
from vibropipe.physics.exciter import Parameters
from vibropipe.solve.boundary.boundary_points import label_points
from vibropipe.solve.branch.branch_dataset import solve_orbits
from vibropipe.solve.branch.branch_of_pieces import solve_sections
from vibropipe.solve.design.goals import Bound
from vibropipe.solve.origin_attrs import origin_attrs
from vibropipe.solve.rows.label import Variables, concatenate, coordinates, label_rows
from vibropipe.solve.rows.named import harmonics_of, outputs_of
from vibropipe.words.bifurcations import Meeting
from vibropipe.words.parameters import without_absent
from vibropipe.words.vocabulary import describe

if TYPE_CHECKING:
    import xarray as xr


# Quantities of a steady state that a point of a boundary keeps.
KEPT = (
    "period_multiple", "impacts_per_orbit", "impact_velocity_max", "displacement_strobe",
    "velocity_strobe", "floquet_multiplier", "stable",
)  # fmt: skip

# The outputs that have them.
OUTPUTS_KEPT = ("impacts", "stability")
# Parameters that a motion without contacts and without friction does not know.
NOT_LINEAR = [Parameters._fields.index(name) for name in NOT_COMPUTED]


def boundary_dataset(
    box: Box,
    boundaries: Sequence[Boundary],
    law: tuple[int, int, int] | None,
    levels: Sequence[Bound],
    quantities: Quantities,
    effects: Sequence[str],
) -> xr.Dataset:
    """Return boundaries and level curves as the dataset of `vp.boundary`.

    law : the law of motion whose boundaries are kept; all if None
    levels : those that were sought
    quantities : what reads the points of level curves
    effects : names of those in the box
    """
    import xarray as xr

    parts = [_label(box, each, quantities) for each in boundaries]
    if law is not None:
        kept = [n for n, part in enumerate(parts) if law in _laws_of(box, boundaries[n], part)]
        boundaries, parts = [boundaries[n] for n in kept], [parts[n] for n in kept]
    sizes = [len(each.points) for each in boundaries]

    def of_curves(values: Iterable[int], dtype: type) -> tuple[tuple[str, ...], np.ndarray]:
        return ("point",), np.repeat(np.array([*values], dtype), sizes)

    curves = [each.curve for each in boundaries]
    variables: Variables = {
        key: (tuple("point" if dim == "row" else dim for dim in dims), numbers)
        for key, (dims, numbers) in concatenate(parts or [_empty(box)]).items()
    }
    variables["curve_id"] = of_curves(range(len(sizes)), int)
    variables["boundary_kind"] = of_curves((curve.kind for curve in curves), np.int8)
    variables |= _meetings(boundaries)
    if levels:
        numbers = (each.level.number if isinstance(each, LevelCurve) else -1 for each in curves)
        variables["level_of"] = of_curves(numbers, np.int32)
    varied = _parameters(box, boundaries)
    for name, values in varied.items():
        variables[name] = (("point",), values)
        if name in box.names:
            at_meetings = values[variables["meeting_point"][1]]
            variables[f"meeting_{name}"] = (("meeting",), at_meetings)
    own = Parameters(*box.values[: len(Parameters._fields)])._asdict()
    coords: dict[str, Any] = {
        name: ((), np.array(value))
        for name, value in without_absent(own).items()
        if name not in varied
    }
    attrs = origin_attrs(effects, "orbits that settle on a grid of lines")
    attrs["boundary"] = " ".join(box.names)
    if box.tied is not None:
        attrs |= box.tied.ties.attrs
    if levels:
        attrs["levels"] = "; ".join(level.text for level in levels)
    if law is not None:
        attrs["law"] = f"({law[0]}; {law[1]}, {law[2]})"
    dataset = xr.Dataset(variables | coords, coordinates(variables, 1), attrs)
    return describe(
        dataset.set_coords([*coords, *varied, *(f"meeting_{name}" for name in box.names)])
    )


def _meetings(boundaries: Sequence[Boundary]) -> Variables:
    """Return what boundaries meet, over `meeting`."""
    begins = np.cumsum([0, *(len(each.points) for each in boundaries)])
    kinds, points, ends = [], [], []
    for begin, each in zip(begins.tolist(), boundaries, strict=False):
        for met in each.meetings:
            kinds.append(Meeting[met.kind.upper()])
            points.append(begin + met.point)
            ends.append(bool(met.reason))
    return {
        "meeting_kind": (("meeting",), np.array(kinds, np.int8)),
        "meeting_point": (("meeting",), np.array(points, np.int64)),
        "meeting_ends": (("meeting",), np.array(ends, np.int8)),
    }


def _parameters(box: Box, boundaries: Sequence[Boundary]) -> dict[str, np.ndarray]:
    """Return both parameters, and what is tied to them, at the points of boundaries."""
    values = np.array([point.u[-2:] for each in boundaries for point in each.points]).reshape(-1, 2)
    rows = np.tile(box.values, (len(values), 1))
    rows[:, box.along] = values
    found = dict(zip(box.names, values.T, strict=True))
    if box.tied is not None:
        for row in rows:
            box.tied.fill(row)
        found |= {name: rows[:, Parameters._fields.index(name)] for name in box.tied.following}
    return found


def _laws_of(box: Box, boundary: Boundary, part: Variables) -> set[tuple[int, int, int]]:
    """Return the law of the orbits of a boundary, at a grazing also that with the impact that begins there.

    Those of their mirror images are among them where these are left out.
    """
    m = int(part["period_multiple"][1][0])
    first, second = (int(count) for count in part["impacts_per_orbit"][1][0])
    laws, curve = {(m, first, second)}, boundary.curve
    if isinstance(curve, LevelCurve):
        return laws  # those of their mirror images are curves of their own
    if curve.kind == GRAZINGS:
        side = int(curve.touched[1])
        begin = {(1, 0) if side == 1 else (0, 1)}
        if box.symmetric and (curve.sequence.mirrored or first + second == 0):
            begin = {(1, 1)} if first + second else {(1, 0), (0, 1), (1, 1)}
        laws |= {(m, first + one, second + two) for one, two in begin}
    return laws | {(m, two, one) for m, one, two in laws} if box.symmetric else laws


def _label(box: Box, boundary: Boundary, quantities: Quantities) -> Variables:
    """Return the steady states of the points of a boundary as variables over `row`."""
    curve, points = boundary.curve, boundary.points
    if isinstance(curve, LevelCurve):
        orbits = np.array([point.u for point in points])
        found, _parameters = quantities.of(curve, orbits, curve.is_image, OUTPUTS_KEPT, 1)
        of_housing = ["housing_velocity_strobe"] if curve.width > 2 else []
        return {name: found[name] for name in (*of_housing, *KEPT)}
    return label_points(boundary)


def _empty(box: Box) -> Variables:
    """Return the variables of no point."""
    parameters = box.values[np.newaxis, : len(Parameters._fields)].copy()
    parameters[:, NOT_LINEAR] = 0.0
    one = label_rows(solve_orbits(None, np.zeros((1, 1)), parameters, 1), parameters)
    return {name: (one[name][0], one[name][1][:0]) for name in KEPT}


class Quantities:
    """Quantities of orbits of laws, closed or on their way to it.

    marcher : of its own, since its work is counted anew for each call
    """

    def __init__(self, marcher: Marcher) -> None:
        self.marcher = marcher

    def levels(self, bounds: Sequence[Bound], half: float) -> list[Level]:
        """Return levels as they are sought; half is l."""
        return [
            Level(number, partial(self._missed, bound, bound.scale(half)))
            for number, bound in enumerate(bounds)
        ]

    def _missed(
        self, bound: Bound, scale: float, curve: LawZeros, orbits: np.ndarray, is_image: bool
    ) -> np.ndarray:
        """Return by how much orbits (k, size) miss a level, over its scale, as `level_curve.Misses`."""
        names = [bound.quantity]
        variables, parameters = self.of(
            curve, orbits, is_image, outputs_of(names), harmonics_of(names)
        )
        values = bound.quantity.values(variables, parameters)
        return np.asarray(bound.quantity.difference(values, bound.low) / scale)

    def of(
        self,
        curve: LawZeros,
        orbits: np.ndarray,
        is_image: bool,
        outputs: tuple[str, ...],
        harmonics: int,
    ) -> tuple[Variables, np.ndarray]:
        """Return the quantities of orbits over `row`, and their parameters.

        orbits : (k, size), its unknowns
        is_image : whether their mirror images are meant
        outputs : any of `OF_BRANCH`
        """
        law, k = curve.sequence, curve.n_free
        parameters = np.array([curve.stated(u[-k:]) for u in orbits])
        effects = self.marcher.effects
        if effects.has_pieces:
            sections = np.array([section_of(curve, u, is_image) for u in orbits])
            rows = solve_sections(
                effects, self.marcher, law.m, sections, parameters, harmonics, outputs
            )
        else:
            # Times and velocities, and a number in place of the parameter that ends the unknowns of a branch.
            ended = np.hstack([orbits[:, :-k], np.zeros((len(orbits), 1))])
            rows = solve_orbits(law, ended, parameters, harmonics, outputs, is_image)
        return label_rows(rows, parameters, outputs), parameters


def section_of(curve: LawZeros, u: np.ndarray, is_image: bool) -> np.ndarray:
    """Return the state of an orbit at the section; of its mirror image, which is half a forcing period behind."""
    point = curve.point(u, u, u)
    return -curve.state_at(point, 0.5) if is_image else curve.state_at(point)
