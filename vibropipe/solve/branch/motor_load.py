"""The torque that the force takes from a motor, along a branch, and that which the motor gives."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibropipe.orbits.branches.tree import follow_tree
from vibropipe.physics.exciter import Exciter, ParameterError
from vibropipe.physics.ties import Ties
from vibropipe.solve.branch.branch_dataset import branch_dataset
from vibropipe.solve.branch.problem import problem_of, seed_of_steady_state, with_rests
from vibropipe.solve.motion.simulate import simulate
from vibropipe.solve.multipliers import decay
from vibropipe.solve.physical import to_physical
from vibropipe.solve.rebuild import (
    exciter_of,
    mass_and_stiffness,
    section_of,
    tied_again,
    ties_of,
    without_units,
)
from vibropipe.words.bifurcations import Bifurcation
from vibropipe.words.outputs import Output
from vibropipe.words.vocabulary import held_name

if TYPE_CHECKING:
    import xarray as xr

OUTPUTS: tuple[Output, ...] = ("stability", "power", "sensitivity")
# Length of a step where an orbit is followed from a point of its branch to a speed before the next.
STEP = 0.1
# Distance from a point without derivative, as a share of that to its neighbour, at which the derivative is taken.
INSIDE = 1e-3
# Relative difference of frequencies that are one.
SAME = 1e-12


class Torque(NamedTuple):
    """Torque of a motor: straight lines between points (increasing speeds); of a line also beyond them."""

    speeds: np.ndarray
    torques: np.ndarray
    is_line: bool

    def at(self, speed: float) -> float:
        """Return the torque at a speed; NaN where none is stated."""
        if self.is_line:
            stall, no_load = self.torques[0], self.speeds[1]
            return float(stall * (1.0 - speed / no_load))
        return float(np.interp(speed, self.speeds, self.torques, np.nan, np.nan))

    def corners(self, low: float, high: float) -> list[float]:
        """Return the speeds strictly between two where the line bends or ends."""
        if self.is_line:
            return []
        return [float(speed) for speed in self.speeds if low < speed < high]


class MotorLoad:
    """The torque of the load over that of the motor, at the points of a branch and between them.

    branch : along nu, or omega in SI, with the outputs stability, power and sensitivity
    torque : in its units
    """

    def __init__(self, branch: xr.Dataset, torque: Torque) -> None:
        self.branch, self.torque = branch, torque
        self.name = held_name(branch, "nu")
        self._found: dict[tuple[int, float], xr.Dataset] = {}

    @cached_property
    def speeds(self) -> np.ndarray:
        """The speeds of the points."""
        return self.branch[self.name].values

    @cached_property
    def decay(self) -> np.ndarray:
        """By how much the largest modulus of the multipliers of each point is below 1; 0 where rounding decides."""
        error = self.branch.get("floquet_multiplier_error")
        return decay(
            self.branch["floquet_multiplier"].values, None if error is None else error.values
        )

    @cached_property
    def events(self) -> dict[int, Bifurcation]:
        """The points at bifurcations, and the kinds of these."""
        points, kinds = (self.branch[f"bifurcation_{each}"].values for each in ("point", "kind"))
        return {int(point): Bifurcation(kind) for point, kind in zip(points, kinds, strict=True)}

    def has_all_beside(self, one: int, speed: float) -> bool:
        """Return whether all orbits that meet at the bifurcation at a point or the next are on the branch."""
        kinds = {
            self.events[n] for n in (one, one + 1) if n in self.events and speed == self.speeds[n]
        }
        followed = [
            Bifurcation[kind.upper()] for kind in str(self.branch.attrs.get("switch", "")).split()
        ]
        known = {Bifurcation.FOLD, Bifurcation.CHANGE, *followed}
        return "law" not in self.branch.attrs and kinds <= known

    def torque_of_row(self, row: xr.Dataset) -> float:
        """Return the mean torque that the force takes."""
        return float(row["power_input"]) / float(row[self.name])

    def excess(self, one: int, speed: float) -> float:
        """Return the torque of the load less that of the motor, between a point and the next of its branch."""
        return self.torque_of_row(self.row(one, speed)) - self.torque.at(speed)

    def slope(self, one: int, speed: float, towards: float | None = None) -> float:
        """Return the derivative of the torque of the load by the speed.

        one : as for `excess`; the error, too
        towards : at a bifurcation the derivative is that a little closer to this speed, NaN where there is none
        """
        if towards is not None and self.is_event(one, speed):
            speed += INSIDE * (towards - speed)
        try:
            row = self.row(one, speed)
        except ParameterError:
            if towards is None:
                raise
            return np.nan
        by = float(row["power_input_sensitivity"].sel(parameter=self.name))
        return (by - self.torque_of_row(row)) / speed

    def is_event(self, one: int, speed: float) -> bool:
        """Return whether a speed is that of a bifurcation at a point or the next."""
        return any(speed == self.speeds[end] and end in self.events for end in (one, one + 1))

    def row(self, one: int, speed: float) -> xr.Dataset:
        """Return the orbit at a speed between a point and the next, as a dataset without `point`.

        Raises ParameterError if the orbit at neither point can be followed to it.
        """
        ends = sorted((one, one + 1), key=lambda end: end in self.events)
        for end in ends:
            if speed == self.speeds[end]:
                return self.branch.isel(point=end)
        key = (one, speed)
        for end in ends:
            if key not in self._found and (found := self._followed(end, speed)) is not None:
                self._found[key] = found
        if key not in self._found:
            got = f"one whose orbits beside {self.name} = {speed:g} cannot be followed to it"
            must = "must have orbits that can be followed from point to point"
            raise ParameterError("branch", self.branch, must=must, got=got)
        return self._found[key]

    def _followed(self, point: int, speed: float) -> xr.Dataset | None:
        """Follow the orbit of a point to a speed; None where it does not reach it."""
        row = self.branch.isel(point=point)
        exciter, si, ties = exciter_of(row), mass_and_stiffness(row), ties_of(row)
        nu = speed if si is None else exciter.nu * (speed / self.speeds[point])
        found = _branch_to(tied_again(row, exciter) if ties else exciter, nu, row, ties)
        if found is None:
            return None
        near = np.flatnonzero(np.abs(found["nu"].values - nu) <= SAME * nu)
        if not len(near):
            return None
        found = found.isel(point=int(near[0]))
        return found if si is None else to_physical(found, si["m"], si["C"])


def _branch_to(exciter: Exciter, nu: float, row: xr.Dataset, ties: Ties) -> xr.Dataset | None:
    """Return the branch from an orbit, stable or not, towards a frequency; None where it has no equations."""
    import xarray as xr

    x, v = section_of(row, exciter)
    problem, signs = problem_of(exciter, "nu", nu, (), STEP, ties)
    problem = with_rests(problem, row)
    m = int(row["period_multiple"])
    if problem.effects.has_pieces:
        held = {"displacement_strobe": x, "velocity_strobe": v, "displacement_amplitude": exciter.l}
        if "housing_velocity_strobe" in row:
            held["housing_velocity_strobe"] = without_units(row, "housing_velocity_strobe")
        start = xr.Dataset(held | {"period_multiple": m})
    else:
        motion = simulate(exciter, m * exciter.period, x, v, samples_per_period=0)
        start = xr.Dataset(
            {
                "period_multiple": m,
                "impact_phase": ("impact", motion["impact_tau"].values / exciter.period),
                "impact_period": ("impact", np.zeros(motion.sizes["impact"])),
                "impact_velocity": ("impact", motion["impact_velocity"].values),
                "impact_support": ("impact", motion["impact_support"].values),
            }
        )
    seed = seed_of_steady_state(exciter, problem, signs, start)
    if seed is None:
        return None
    tree = follow_tree(problem, seed, ())
    return branch_dataset(problem, tree.branches, 1, {}, OUTPUTS)
