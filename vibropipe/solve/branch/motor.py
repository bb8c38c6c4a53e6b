"""The function `motor`: speeds that a motor of limited power keeps, and where it jumps to another."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.physics.exciter import ParameterError
from vibropipe.solve.branch.motor_load import MotorLoad, Torque
from vibropipe.solve.branch.motor_speeds import (
    Stretch,
    jumps_of,
    speed_at,
    stretches_of,
    without_images,
)
from vibropipe.solve.physical import is_physical
from vibropipe.solve.rebuild import ties_of
from vibropipe.solve.with_units import si_of_dimension
from vibropipe.words.vocabulary import describe, held_name, physical_attributes

if TYPE_CHECKING:
    import xarray as xr

LINE = ("no_load", "stall")
TAKES = "{no_load: speed, stall: torque}, or two or more pairs (speed, torque) of increasing speed"
# Of the branch, what a crossing has.
KEPT = ("regime", "period_multiple", "impacts_per_period", "stable", "power_input")
NEEDS = ("stable", "power_input", "power_input_sensitivity")


def motor(branch: xr.Dataset, torque: Mapping[str, Any] | Sequence[Any]) -> xr.Dataset:
    """Find the speeds at which a motor drives an exciter, and Sommerfeld's jumps, from the torques of its branches.

    The motor turns once in a forcing period, and the force takes the mean torque power_input/nu from it. The flywheel
    is heavy, so that the speed changes slowly and the motion stays on its orbit: the quasi-static answer [1]_. The
    speed is kept where the torques are equal, the orbit is stable, and the torque of the load rises over that of the
    motor with the speed.

    Parameters
    ----------
    branch : xarray.Dataset
        `vp.branch` along nu (or omega, in SI) with the outputs stability, power and sensitivity. The amplitude f is
        the same at all speeds, as of a crank that moves a spring or of an electric drive, unless it is tied to nu; that
        of an unbalanced rotor, which grows with nu^2, is the parameter shaker, or tied by {"f": "me * nu**2"}. It
        is that of one exciter; it may have the argument `law`.
    torque : mapping or sequence
        What the motor gives: `{"no_load": nu, "stall": torque}` is the straight line from the torque at rest to the
        speed without torque, and beyond. Pairs (nu, torque) are joined by straight lines; there is none beyond. Units
        are those of the branch: torques are power over nu; in SI N m over rad/s, or text as "3 N m", "600 rpm".

    Returns
    -------
    xarray.Dataset
        Over `crossing`, sorted by the speed, each solved on the branch and not interpolated; of orbits that are mirror
        images of each other, as beyond a pitchfork, the one of the first branch:

        nu, motor_torque
            Speed, and torque of both; unstable orbits that cannot be followed, beside a grazing, are left out.
        speed_is_stable
            Whether the motor keeps that speed.
        branch_id, stable, power_input, regime, period_multiple, impacts_per_period (support)
            The orbit there, as in the branch.
        crossing_point
            Number of the point of the branch before it.

        Over `jump`, where a stable speed is lost while a torque that is the same at all speeds is added slowly to that
        of the motor (of a straight line it raises the no-load speed too, as the voltage does):

        jump_torque
            The torque added, negative where the motor gives less.
        jump_way
            Whether the speed is lost as the torque is raised or lowered.
        jump_nu, jump_to_nu
            The speed that is lost, and the next one that is kept with this torque. It is NaN where the range of the
            branch ends before, or where stable orbits end and not exactly one of the others at that frequency can
            follow. It is also NaN where orbits begin that are not on the branch, one of which may keep the speed: at
            the kinds of bifurcation that `switch` leaves out, where a law ends, and of branches with the argument `law`
            at each bifurcation; and where the speed hunts, back to the one that is lost.

    Raises
    ------
    ParameterError
        If the branch is none along nu, lacks an output or has orbits that cannot be followed from one point to the
        next, or torque is not of this form.

    Notes
    -----
    Crossings and jumps are found between neighbouring points of the branch, which has a point at each fold; two that
    lie between two points of it are separated by the derivative of the torque, more are not.

    References
    ----------
    .. [1] V. O. Kononenko, Vibrating Systems with a Limited Power Supply, Iliffe 1969.
    """
    import xarray as xr

    _check_branch(branch)
    load = MotorLoad(branch, torque_of(torque, is_physical(branch)))
    stretches = stretches_of(load)
    at = sorted(
        ((speed_at(load, each, 0.0), each) for each in stretches if each.s[0] * each.s[1] < 0.0),
        key=lambda found: found[0],
    )
    at = without_images(load, at)
    speeds = np.array([speed for speed, _each in at])
    torques, kept = _orbits_at(load, at)
    jumps = jumps_of(load, stretches)
    columns = np.array(jumps, float).reshape(-1, 4).T
    variables: dict[str, Any] = {
        "motor_torque": ("crossing", torques),
        "speed_is_stable": (
            "crossing",
            np.array([each.is_stable and each.rises for _speed, each in at], np.int8),
        ),
        **kept,
        "jump_torque": ("jump", columns[0]),
        "jump_way": ("jump", columns[1].astype(np.int8)),
        f"jump_{load.name}": ("jump", columns[2]),
        f"jump_to_{load.name}": ("jump", columns[3]),
    }
    coords = {name: each for name, each in branch.coords.items() if not each.dims}
    coords[load.name] = ("crossing", speeds)
    attrs = {
        name: branch.attrs[name]
        for name in ("method", "effects", "version", "display_units")
        if name in branch.attrs
    }
    dataset = xr.Dataset(variables, coords | {"support": [1, 2]}, attrs)
    return _in_words(dataset, branch)


def _check_branch(branch: Any) -> None:
    """Raise a ParameterError unless this is a branch along the frequency with what a motor needs."""
    import xarray as xr

    must = "must be a dataset of vp.branch along nu or omega"
    if not isinstance(branch, xr.Dataset):
        raise ParameterError("branch", branch, must=must, got=type(branch).__name__)
    name = held_name(branch, "nu")
    if "branch_id" not in branch or branch.get(name, branch["branch_id"]).dims != ("point",):
        raise ParameterError("branch", branch, must=must, got="another dataset")
    if f"bifurcation_{name}" not in branch:
        raise ParameterError("branch", branch, must=must, got="one along another parameter")
    tied = [held_name(branch, each) for each in ties_of(branch).parameters]
    for other, values in branch.coords.items():
        is_other = values.dims == ("point",) and other not in (name, *tied)
        if is_other and np.unique(values).size > 1:
            must = f"must be of one exciter: select the points and bifurcations of one {other}"
            raise ParameterError("branch", branch, must=must, got=f"one with several {other}")
    if any(each not in branch for each in NEEDS):
        must = "must have the outputs stability, power and sensitivity"
        lacks = ", ".join(each for each in NEEDS if each not in branch)
        raise ParameterError("branch", branch, must=must, got=f"one without {lacks}")


def torque_of(torque: Any, si: bool = False) -> Torque:
    """Return the torque of a motor over its speed, or raise a ParameterError."""

    def number(name: str, value: Any, dimension: str) -> float:
        if si:
            return si_of_dimension(name, value, dimension)
        try:
            found = float(value)
        except (TypeError, ValueError):
            found = np.nan
        if isinstance(value, (str, bool)) or not np.isfinite(found):
            raise ParameterError(name, value, "a finite number, as the branch has no units")
        return found

    if isinstance(torque, Mapping):
        if set(torque) != set(LINE):
            raise ParameterError("torque", torque, TAKES)
        ends = (("no_load", "frequency"), ("stall", "torque"))
        no_load, stall = (number(f"torque.{each}", torque[each], of) for each, of in ends)
        for name, value in zip(LINE, (no_load, stall), strict=True):
            if value <= 0.0:
                raise ParameterError(f"torque.{name}", torque[name], "above 0")
        return Torque(np.array([0.0, no_load]), np.array([stall, 0.0]), is_line=True)
    try:
        pairs = [(pair[0], pair[1]) for pair in torque if len(pair) == 2]
        is_whole = len(pairs) == len(torque) >= 2 and not isinstance(torque, str)
    except (TypeError, KeyError, IndexError):
        is_whole = False
    if not is_whole:
        raise ParameterError("torque", torque, TAKES)
    speeds = np.array([number("torque", speed, "frequency") for speed, _torque in pairs])
    torques = np.array([number("torque", each, "torque") for _speed, each in pairs])
    if not (np.diff(speeds) > 0.0).all():
        raise ParameterError("torque", torque, TAKES)
    return Torque(speeds, torques, is_line=False)


def _orbits_at(
    load: MotorLoad, at: Sequence[tuple[float, Stretch]]
) -> tuple[np.ndarray, dict[str, Any]]:
    """Return the torques of the load at crossings, and variables of its orbits there."""
    rows = [load.row(each.start, speed) for speed, each in at]
    kept: dict[str, Any] = {}
    for name in (each for each in KEPT if each in load.branch):
        variable = load.branch[name]
        shape = (0, *variable.shape[1:])
        values = [row[name].values for row in rows]
        data = np.array(values, variable.dtype) if rows else np.zeros(shape, variable.dtype)
        kept[name] = (("crossing", *variable.dims[1:]), data)
    ids = load.branch["branch_id"].values
    points = np.array([each.start for _speed, each in at], np.int64)
    kept["crossing_point"] = ("crossing", points)
    kept["branch_id"] = ("crossing", ids[points].astype(np.int64))
    torques = np.array([load.torque_of_row(row) for row in rows])
    return torques, kept


def _in_words(dataset: xr.Dataset, branch: xr.Dataset) -> xr.Dataset:
    """Return a dataset whose variables have their attributes, in SI those there."""
    if not is_physical(branch):
        return describe(dataset)
    plain = {f"{start}omega": f"{start}nu" for start in ("", "jump_", "jump_to_")}
    for name in dataset.variables:
        if name in branch.variables and name != "omega":
            dataset[name].attrs = branch[name].attrs
        else:
            dataset[name].attrs = dict(physical_attributes(plain.get(str(name), str(name))))
    return dataset
