"""Quantities of steady states by name with index, as columns of tables have them: `impact_velocity_max_1`."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vibropipe.physics import limits
from vibropipe.physics.exciter import ParameterError, Parameters
from vibropipe.words.outputs import OUTPUTS
from vibropipe.words.quantities import Quantity
from vibropipe.words.vocabulary import GOALS, PLACES, POWERS, SENSITIVITY_SUFFIX, STEADY, quantity

if TYPE_CHECKING:
    from vibropipe.solve.rows.label import Variables

# Quantities that a design may take, those that depend smoothly on the parameters first, and those of the law of motion.
SMOOTH = tuple(name for name, entry in STEADY.items() if entry.goal == "smooth")
OF_LAW = tuple(name for name, entry in STEADY.items() if entry.goal == "law")
# What is derived from a quantity: its standard deviation, or its derivative by a parameter.
STD, SENSITIVITY = "std", "sensitivity"
# The largest index of each dimension.
SIZES = {"support": 2, "multiplier": 2, "harmonic": limits.HARMONICS[1], "subharmonic": 1000}
# Powers of a length that a quantity of a physical dimension has without units, eqs. (2)-(4).
LENGTHS = dict.fromkeys(("length", "velocity", "force", "impulse"), 1) | dict.fromkeys(
    ("energy", "torque", "power"), 2
)


# Largest values over the contacts of a support: a motion that never strikes it has none.
OF_CONTACTS = (
    "impact_velocity_max",
    "contact_duration_max",
    "support_force_max",
    "support_depth_max",
)


class Named(NamedTuple):
    """A number of a steady state.

    name : as it is written
    variable : the quantity, or a parameter of the exciter
    number : of its part, counted from 1; None of a scalar
    part : "re" or "im" of a complex quantity
    derived : "", "std" or "sensitivity"
    parameter : that of the sensitivity
    """

    name: str
    variable: str
    number: int | None = None
    part: str = ""
    derived: str = ""
    parameter: str = ""

    @property
    def is_parameter(self) -> bool:
        """Whether it is a parameter of the exciter."""
        return self.variable in Parameters._fields

    @property
    def entry(self) -> Quantity:
        """The record of the quantity."""
        return quantity(self.variable)

    @property
    def dimension(self) -> str:
        """Its physical dimension; "" of a pure number, and of derivatives, which are given without units."""
        if self.derived == SENSITIVITY:
            return ""
        return "angle" if self.entry.units == "rad" else self.entry.dimension

    @property
    def is_never_negative(self) -> bool:
        """Whether it, or its standard deviation, is never negative."""
        return self.derived == STD or not (
            self.is_parameter or self.derived or self.entry.is_signed
        )

    @property
    def is_place(self) -> bool:
        """Whether it is the place of a bifurcation, which the motion alone does not tell."""
        return self.variable in PLACES

    @property
    def is_of_law(self) -> bool:
        """Whether it belongs to the law of motion, so that it has no derivative."""
        return self.variable in OF_LAW

    def plain(self) -> Named:
        """Return the quantity that a derived one is derived from."""
        return self._replace(derived="", parameter="")

    def has_slopes(self, variables: Variables) -> bool:
        """Return whether rows have its derivatives, which contacts and effects that no row has are without."""
        return self.variable + SENSITIVITY_SUFFIX in variables

    def values(self, variables: Variables, parameters: np.ndarray) -> np.ndarray:
        """Return its values (rows,) from labelled rows and their parameters (rows, n)."""
        if self.is_parameter:
            return parameters[:, Parameters._fields.index(self.variable)]
        if self.variable not in variables and self.entry.is_loss:
            given = "power_input" if self.variable in POWERS else "energy_input"
            return np.where(np.isfinite(variables[given][1]), 0.0, np.nan)
        if self.variable not in variables and self.entry.effect:
            return np.full(
                len(parameters), np.nan
            )  # all supports are rigid, or the housing is held
        values = variables[self.variable][1]
        column = values if self.number is None else values[:, self.number - 1]
        real: np.ndarray = column.imag if self.part == "im" else column.real
        return real.astype(float)

    def is_without_contact(self, variables: Variables) -> np.ndarray:
        """Return in which rows (rows,) the motion never strikes the support over whose contacts it is the largest."""
        struck = variables["impacts_per_period"][1]
        if self.variable not in OF_CONTACTS or self.number is None or self.derived:
            return np.zeros(len(struck), bool)
        is_struck_never: np.ndarray = struck[:, self.number - 1] == 0.0
        return is_struck_never

    def slopes(self, variables: Variables, parameter: int) -> np.ndarray:
        """Return its derivatives (rows,) by one of the parameters of the output `sensitivity`."""
        slopes = variables[self.variable + SENSITIVITY_SUFFIX][1][..., parameter]
        column = slopes if self.number is None else slopes[:, self.number - 1]
        real: np.ndarray = column.imag if self.part == "im" else column.real
        return real.astype(float)

    def difference(self, one: Any, two: Any) -> Any:
        """Return one - two, of phases between -pi and pi."""
        difference = np.asarray(one) - np.asarray(two)
        if self.entry.units == "rad" and not (self.is_parameter or self.derived):
            return np.remainder(difference + np.pi, 2 * np.pi) - np.pi
        return difference

    def scale(self, half: float) -> float:
        """Return the size to which its errors are relative if it is zero; half is l."""
        return float(half ** LENGTHS.get(self.entry.dimension, 0))


def named(name: Any, argument: str) -> Named:
    """Return the quantity of a name, or raise a ParameterError naming the argument and what is near."""
    if not isinstance(name, str):
        raise ParameterError(argument, name, "names of quantities of a steady state")
    if name in Parameters._fields:
        return Named(name, name)
    stem, part = name, ""
    if name.endswith(("_re", "_im")):
        stem, part = name[:-3], name[-2:]
    for variable in sorted((*SMOOTH, *OF_LAW, *PLACES), key=len, reverse=True):
        tail = _tail(stem, variable)
        if tail is None:
            continue
        derived, parameter = "", ""
        if match := re.fullmatch(r"_(std|sensitivity)(_\d+)?(?:_([A-Za-z]\w*))?", tail):
            derived, tail, parameter = match[1], match[2] or "", match[3] or ""
            has_derivative = GOALS[variable].has_derivative or GOALS[variable].goal == "law"
            if (derived == SENSITIVITY) != (parameter in Parameters._fields) or not has_derivative:
                break
        index = _index(name, variable, tail, argument)
        if GOALS[variable].is_complex != bool(part):
            break
        return Named(name, variable, index, part, derived, parameter)
    raise _unknown(name, argument)


def _tail(stem: str, variable: str) -> str | None:
    """Return what follows a variable in a name, None if the name is of another one."""
    tail = stem.removeprefix(variable)
    follows = re.fullmatch(r"(_(std|sensitivity)(_\w+)?|_-?\d+)?", tail)
    return tail if stem.startswith(variable) and follows else None


def _index(name: str, variable: str, tail: str, argument: str) -> int | None:
    """Return the number at the end of a name, which a vector must have and a scalar must not."""
    dims = quantity(variable).dims
    if not dims:
        if tail:
            raise ParameterError(argument, name, must=f"must have no number after {variable}")
        return None
    size = SIZES[dims[0]]
    if not tail or not 1 <= int(tail[1:]) <= size:
        names = ", ".join(f"{variable}_{n}" for n in range(1, min(size, 3) + 1))
        raise ParameterError(argument, name, f"one of {names}" + (" and so on" if size > 3 else ""))
    return int(tail[1:])


def _unknown(name: str, argument: str) -> ParameterError:
    choices = [label for variable in (*SMOOTH, *OF_LAW, *PLACES) for label in labels(variable)]
    near = difflib.get_close_matches(name, [*choices, *Parameters._fields], n=2, cutoff=0.5)
    hint = f" (did you mean {' or '.join(map(repr, near))}?)" if near else ""
    known = STEADY.get(re.sub(r"_\d+$", "", name))
    if known is not None and not known.goal:
        must = "must be a quantity that can have a goal or a bound, such as impact_velocity_max_1"
        got = f"{name!r}, which only datasets have{hint}"
        return ParameterError(argument, name, must=must, got=got)
    allowed = "a quantity of a steady state, such as displacement_mean or impact_velocity_max_1"
    return ParameterError(argument, name, allowed, got=repr(name) + hint)


def labels(variable: str, harmonics: int = 3) -> list[str]:
    """Return the names with index of all parts of a quantity."""
    dims = quantity(variable).dims
    parts = ("_re", "_im") if GOALS[variable].is_complex else ("",)
    sizes = {**SIZES, "harmonic": harmonics, "subharmonic": harmonics}
    ends = [f"_{n}" for n in range(1, sizes[dims[0]] + 1)] if dims else [""]
    return [variable + end + part for end in ends for part in parts]


def outputs_of(names: Iterable[Named]) -> tuple[str, ...]:
    """Return the outputs that have some quantities, and stability."""
    of_names = [*names]
    wanted = {STEADY[name.variable].output for name in of_names if name.variable in STEADY}
    wanted |= {"harmonics", "impacts"} if any(name.is_place for name in of_names) else set()
    wanted.add("stability")
    return tuple(name for name in OUTPUTS if name in wanted)


def harmonics_of(names: Iterable[Named], least: int = 1) -> int:
    """Return the number of harmonics that some quantities need."""
    dims = {"harmonic": 1, "subharmonic": 4}
    needed = [
        -(-(name.number or 1) // dims[dim])
        for name in names
        if not name.is_parameter
        for dim in quantity(name.variable).dims
        if dim in dims
    ]
    return max([least, *needed])


def gathered(
    names: Sequence[Named], values: np.ndarray, suffix: str, dims: tuple[str, ...]
) -> Variables:
    """Return columns (q, ...) of quantities as variables, the parts of a vector over its dimension, then `dims`."""
    variables = {}
    for variable in dict.fromkeys(name.variable for name in names):
        part = values[[n for n, name in enumerate(names) if name.variable == variable]]
        inner = quantity(variable).dims
        variables[f"{variable}_{suffix}"] = ((*inner, *dims), part if inner else part[0])
    return variables
