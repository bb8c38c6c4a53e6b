"""Solution of branch scenes: branches at each value of the further parameter, one after the other."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from vibropipe.physics.exciter import Exciter, ParameterError
from vibropipe.scenes.certificate import with_row_proofs
from vibropipe.solve.branch.branch import branch
from vibropipe.solve.branch.from_rest import reached_from_rest
from vibropipe.solve.branch.motor import motor, torque_of
from vibropipe.solve.branch.problem import MUST_REPEAT
from vibropipe.solve.in_si import convert
from vibropipe.solve.physical import stored
from vibropipe.words.outputs import OF_STEADY_STATE
from vibropipe.words.parameters import DEFAULTS, PARAMETERS
from vibropipe.words.vocabulary import (
    PARAMETER,
    SENSITIVITY_SUFFIX,
    attributes,
    attributes_of_dimension,
    describe,
    own_attributes,
    physical_attributes,
    physical_name,
)

# Lists of what a motor does.
OF_SPEEDS = ("crossing", "jump")
OF_MOTOR = (*OF_STEADY_STATE, "power", "sensitivity")

if TYPE_CHECKING:
    from vibropipe.scenes.branch.keys import BranchScene
    from vibropipe.words.progress import Progress


def solve(scene: BranchScene, progress: Progress | None = None) -> xr.Dataset:
    """Follow the branches of a scene in memory."""
    name, grid = next(iter(scene.over_arrays().items()), ("", np.array([])))
    changes = [{name: value} for value in grid.tolist()] or [{}]
    parts, absent = [], list[ParameterError]()
    for change in changes:
        try:
            parts.append(_followed(scene, change))
        except ParameterError as error:
            if error.name != "law":
                raise
            absent.append(error)  # the law has no orbits there
        if progress is not None:
            progress(len(parts) + len(absent), len(changes))
    if not parts:
        raise absent[0]
    whole = joined(parts, name, scene.mass_and_stiffness) if name else parts[0]
    if absent:
        whole.attrs["without_law"] = len(absent)
    reached = "point", reached_from_rest(whole), attributes("from_rest")
    whole = whole.assign(from_rest=reached)
    whole = with_row_proofs(whole, scene.prove) if scene.prove else whole
    return stored(whole, scene.mass_and_stiffness)


def _followed(scene: BranchScene, change: dict[str, float]) -> xr.Dataset:
    """Follow the branches at a value of the further parameter, or name of one's own, which is then tied to it."""
    stated = {name: value for name, value in change.items() if name in PARAMETERS}
    own = {name: value for name, value in change.items() if name not in PARAMETERS}
    ties = scene.tied()
    exciter = Exciter(**{**scene.untied_exciter(), **stated})
    branches = _branches(scene, exciter, {**ties.texts, **own})
    if scene.motor is not None:
        try:
            branches = with_motor(branches, scene.motor.given())
        except ParameterError as error:
            if error.name != "branch":
                raise
            got = f"{error.got}: follow a shorter range, or leave out a kind of switch"
            raise ParameterError("motor", error.value, must=error.must, got=got) from error
    coords = {name: ((), value, own_attributes(name)) for name, value in own.items()}
    return branches.assign_coords(coords).assign_attrs(ties.attrs)


def _branches(scene: BranchScene, exciter: Exciter, ties: dict[str, Any]) -> xr.Dataset:
    """Follow the branches of one exciter; an exciter without an orbit to begin with is refused with a remedy."""
    try:
        tolerance = {str(name): sigma for name, sigma in scene.tolerance.items()} or None
        at = [] if scene.at is None else scene.at.array().tolist()
        outputs = OF_STEADY_STATE if scene.motor is None else OF_MOTOR
        if scene.law is not None:
            ends = scene.ends.values
            return branch(
                exciter, scene.followed, ends, at=at, harmonics=scene.harmonics, law=scene.law,
                outputs=outputs, tolerance=tolerance, ties=ties, subject_to=scene.subject_to,
            )  # fmt: skip
        to = scene.ends.to if scene.followed in PARAMETERS else scene.ends.values
        return branch(
            exciter,
            scene.followed,
            to[0] if len(to) == 1 else to,
            x0=scene.start.x0,
            v0=scene.start.v0,
            at=at,
            switch=scene.switch,
            harmonics=scene.harmonics,
            outputs=outputs,
            tolerance=tolerance,
            ties=ties,
            subject_to=scene.subject_to,
        )
    except ParameterError as error:
        name = scene.as_written(scene.followed)
        if error.name == "law":
            must = f"must have orbits in the range of {name}"
            raise ParameterError("law", error.value, must=must, got=error.got) from error
        if error.must != MUST_REPEAT:
            raise
        remedy = f"begin at another value (along.{name}.from) or from another start"
        got = f"{error.got}: {remedy}"
        raise ParameterError(error.name, error.value, must=error.must, got=got) from error


def with_motor(branches: xr.Dataset, torque: Any) -> xr.Dataset:
    """Return branches along nu with the speeds that a motor keeps, its jumps, and its torque at each point."""
    found, given = motor(branches, torque), torque_of(torque)
    of_motor = ("crossing_point", "motor_torque", "speed_is_stable")
    names = [*of_motor, *(str(name) for name in found.data_vars if found[name].dims == ("jump",))]
    available = [given.at(speed) for speed in branches["nu"].values.tolist()]
    own = {name: found[name].variable for name in names}
    own["crossing_nu"] = xr.Variable("crossing", found["nu"].values)
    load = branches["power_input"].values / branches["nu"].values
    own["load_torque"] = xr.Variable("point", load)
    own["available_torque"] = xr.Variable("point", available)
    derived = [name for name in branches.variables if str(name).endswith(SENSITIVITY_SUFFIX)]
    return describe(branches.drop_vars([*derived, PARAMETER]).assign(own))


def joined(
    parts: Sequence[xr.Dataset], name: str, mass_and_stiffness: tuple[float, float] | None
) -> xr.Dataset:
    """Join the branches at several values of a parameter, which then varies over `point`, as does what follows it.

    parts : branches at each value, `name` as a scalar coordinate
    """
    shifted, points, branches = [], 0, 0
    # What follows it, by ties or as a damping that a restitution gives; absent where it has its default.
    held = {str(each) for part in parts for each, value in part.coords.items() if not value.dims}
    values = {
        key: [float(part.get(key, DEFAULTS.get(key, 0.0))) for part in parts]
        for key in sorted(held)
    }
    varied = [name, *(key for key in values if key != name and len({*values[key]}) > 1)]
    for n, part in enumerate(parts):
        size = part.sizes["point"]
        swept = {
            key: xr.full_like(part["branch_id"], values[key][n], dtype=float).assign_attrs(
                attributes_of_dimension(key)
            )
            for key in varied
        }
        numbers: dict[str, Any] = {
            each: part[each] + points
            for each in ("bifurcation_point", "crossing_point") if each in part
        }  # fmt: skip
        numbered = part.assign(branch_id=part["branch_id"] + branches, **numbers)
        for dim in OF_SPEEDS:
            if dim in part.dims:
                there = f"{dim}_{name}"
                own = np.full(part.sizes[dim], values[name][n])
                swept[there] = xr.DataArray(own, dims=dim, attrs=attributes_of_dimension(there))
        shifted.append(numbered.assign_coords(swept))
        points, branches = points + size, branches + int(part["branch_id"].max()) + 1
    dims = ("point", "impact", "bifurcation", *OF_SPEEDS)
    by_dim = [
        xr.concat([part[names_over(part, dim)] for part in shifted], dim)
        for dim in dims
        if dim in parts[0].dims
    ]
    rest = shifted[0].drop_dims(dims, errors="ignore")
    merged = xr.merge([rest, *by_dim], combine_attrs="override")
    incomplete = [
        f"{stated_text(name, float(part[name]), mass_and_stiffness)}: {part.attrs['incomplete']}"
        for part in parts
        if "incomplete" in part.attrs
    ]
    merged.attrs.pop("incomplete", None)
    return merged.assign_attrs({"incomplete": "; ".join(incomplete)} if incomplete else {})


def stated_text(name: str, value: float, mass_and_stiffness: tuple[float, float] | None) -> str:
    """Write a value of a parameter, in SI where the study has units."""
    if mass_and_stiffness is None or name not in PARAMETERS:
        return f"{name} = {value:g}"
    m, C = mass_and_stiffness
    unit = physical_attributes(name)["units"].removeprefix("1")
    text = f"{physical_name(name)} = {float(convert(name, value, {'m': m, 'C': C})):g} {unit}"
    return text.rstrip()


def names_over(dataset: xr.Dataset, dim: str) -> list[str]:
    """Return the names of the variables over a dimension."""
    return [str(name) for name, values in dataset.variables.items() if dim in values.dims]
