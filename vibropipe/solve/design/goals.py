"""What is wanted of a design: quantities that have given values, that keep to bounds, and that are least."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vibropipe.physics.exciter import ParameterError
from vibropipe.physics.parameter_error import as_float, number_within
from vibropipe.physics.ties import Ties
from vibropipe.solve.rows.named import STD, Named, named
from vibropipe.words.records import POSITIVE
from vibropipe.words.units import MINUS
from vibropipe.words.vocabulary import OF_SOFT, PLACES, STEADY

if TYPE_CHECKING:
    from vibropipe.solve.rows.points import Points

# A target is met, and a bound is kept, within this share of its scale.
MET = 1e-9
A_BOUND = 'a bound such as "< 0.8" or "> 0.1, < 0.8", or a pair of numbers'
_BOUND = re.compile(r"\s*([<>])=?\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*")
A_CURVE = "a table with a column of phases, in forcing periods, and one of displacements"
# Key of a target that is a curve; the objective of designs whose scattered parts keep all goals.
CURVE, YIELD = "displacement", "yield"


class Curve(NamedTuple):
    """Displacements (n,) at phases (n,), in forcing periods after a rising zero of sin(nu tau)."""

    phase: np.ndarray
    displacement: np.ndarray


def curve_of(argument: str, table: Any) -> Curve:
    """Return a curve from an array (n, 2) or a pandas.DataFrame of `phase` and `displacement`."""
    try:
        if hasattr(table, "columns"):
            table = table[["phase", "displacement"]]
        values = np.asarray(table, dtype=float)
    except (KeyError, TypeError, ValueError):
        values = np.empty(0)
    if values.ndim != 2 or values.shape[1] != 2 or not len(values) or not np.isfinite(values).all():
        raise ParameterError(argument, table, A_CURVE, got="another value")
    return Curve(values[:, 0], values[:, 1])


class Bound(NamedTuple):
    """Least and largest value of a quantity; both are the same for a target."""

    quantity: Named
    low: float
    high: float

    @property
    def is_target(self) -> bool:
        """Whether the quantity is to have one value."""
        return self.low == self.high

    @property
    def text(self) -> str:
        """The bound as it may be written, with digits enough for a number that gets a unit again."""
        if self.is_target:
            return f"{self.quantity.name} = {self.low:.12g}"
        ends = [(">", self.low), ("<", self.high)]
        signs = [f"{sign} {end:.12g}" for sign, end in ends if math.isfinite(end)]
        return f"{self.quantity.name} {', '.join(signs)}"

    def scale(self, half: float) -> float:
        """Return what misses are relative to: the bound's own size, or that of its kind if it is 0; half is l."""
        sizes = [abs(end) for end in (self.low, self.high) if math.isfinite(end)]
        return max(sizes) or self.quantity.scale(half)

    def kept_by(self, values: np.ndarray, half: float, room: float = 0.0) -> np.ndarray:
        """Return which values (n,) keep the bound, or are off by at most `room`; half is l. NaN keeps none."""
        room += MET * self.scale(half)
        kept = np.isfinite(values)
        if math.isfinite(self.high):  # a phase has no difference from infinity
            kept &= self.quantity.difference(values, self.high) <= room
        if math.isfinite(self.low):
            kept &= self.quantity.difference(values, self.low) >= -room
        return kept

    def kept_at(self, points: Points, half: float, room: float = 0.0) -> np.ndarray:
        """Return which points (n,) keep the bound, as `kept_by`; what never strikes exceeds no largest value."""
        values = self.quantity.values(points.variables, points.parameters)
        kept = self.kept_by(values, half, room)
        if not math.isfinite(self.low):
            kept |= self.quantity.is_without_contact(points.variables)
        return kept


class Objective(NamedTuple):
    """A quantity to be least, or most: sign -1."""

    quantity: Named
    sign: float

    @property
    def text(self) -> str:
        """The objective as it is written."""
        return ("-" if self.sign < 0 else "") + self.quantity.name


@dataclass(frozen=True)
class Goals:
    """All that is wanted."""

    bounds: tuple[Bound, ...]
    objectives: tuple[Objective, ...]
    curve: Curve | None = None

    @property
    def names(self) -> list[Named]:
        """All quantities, each once."""
        wanted = [bound.quantity for bound in self.bounds]
        return list(dict.fromkeys([*wanted, *(each.quantity for each in self.objectives)]))

    @property
    def of_yield(self) -> bool:
        """Whether the yield is to be largest."""
        return any(each.quantity.derived == YIELD for each in self.objectives)

    @property
    def texts(self) -> dict[str, str]:
        """What is wanted, as the attributes of a dataset have it."""
        kept = [bound.text for bound in self.bounds if not bound.is_target]
        targets = [bound.text for bound in self.bounds if bound.is_target]
        curve = [f"{CURVE} at {self.curve.phase.size} phases"] if self.curve else []
        least = [each.text for each in self.objectives]
        words = {"target": targets + curve, "subject_to": kept, "minimise": least}
        return {key: "; ".join(texts) for key, texts in words.items() if texts}


def goals_of(
    target: Mapping[str, Any] | None,
    subject_to: Mapping[str, Any] | None,
    minimise: str | Sequence[str] | None,
    tolerance: Mapping[str, float] | None,
) -> Goals:
    """Return the goals of a design; ParameterError for unknown names, wrong bounds and contradictions."""
    wanted = dict(target or {})
    curve = curve_of(f"target.{CURVE}", wanted.pop(CURVE)) if CURVE in wanted else None
    bounds = [target_of("target", name, value) for name, value in wanted.items()]
    bounds += [_bound(name, value) for name, value in (subject_to or {}).items()]
    _check_contradictions(bounds)
    listed = [minimise] if isinstance(minimise, str) else list(minimise or ())
    objectives = tuple(_objective(name) for name in listed)
    if len(objectives) > 2:
        raise ParameterError("minimise", minimise, "one quantity or two")
    if len({each.quantity for each in objectives}) < len(objectives):
        raise ParameterError("minimise", minimise, "quantities that differ from each other")
    if not bounds and not objectives and curve is None:
        must = "must have a target, a bound or a quantity to minimise"
        raise ParameterError("target", target, must=must)
    if curve is not None and objectives:
        must = f"must be left out with the target {CURVE}, whose misfit is least"
        raise ParameterError("minimise", minimise, must=must)
    goals = Goals(tuple(bounds), objectives, curve)
    if goals.of_yield and len(objectives) > 1:
        raise ParameterError("minimise", minimise, must=f"must have -{YIELD} alone")
    for quantity in goals.names:
        if quantity.derived in (STD, YIELD) and not tolerance:
            must = f"is required, since {quantity.name} is wanted"
            raise ParameterError("tolerance", tolerance, must=must, got="")
    return goals


def target_of(key: str, name: str, value: Any) -> Bound:
    """Return the value that a quantity is to have, or raise a ParameterError; key : the argument that it stands in."""
    argument = f"{key}.{name}"
    quantity = named(name, key)
    number = as_float(argument, value, "a finite number")
    if not math.isfinite(number):
        raise ParameterError(argument, value, "a finite number")
    _check_sign(argument, quantity, number)
    return Bound(quantity, number, number)


def _bound(name: str, value: Any) -> Bound:
    argument = f"subject_to.{name}"
    quantity = named(name, "subject_to")
    low, high = _ends(argument, value)
    if not low < high:
        raise ParameterError(argument, value, must="must have its lower bound below the upper one")
    _check_sign(argument, quantity, high)
    return Bound(quantity, low, high)


def _ends(argument: str, value: Any) -> tuple[float, float]:
    """Return the ends of a bound, infinite where it has none."""
    if isinstance(value, str):
        ends = {">": -math.inf, "<": math.inf}
        for part in value.replace(MINUS, "-").split(","):
            match = _BOUND.fullmatch(part)
            if match is None or math.isfinite(ends[match[1]]):
                raise ParameterError(argument, value, A_BOUND)
            ends[match[1]] = float(match[2])
        return ends[">"], ends["<"]
    if np.shape(value) != (2,):
        raise ParameterError(argument, value, A_BOUND)
    low, high = (as_float(argument, end, A_BOUND) for end in value)
    return low, high


def _check_sign(argument: str, quantity: Named, high: float) -> None:
    if quantity.is_never_negative and high < 0:
        must = f"must be >= 0, since {quantity.name} is never negative"
        raise ParameterError(argument, high, must=must)


def _check_contradictions(bounds: Sequence[Bound]) -> None:
    """Raise a ParameterError where a target lies outside the bounds of the same quantity."""
    targets = {bound.quantity: bound.low for bound in bounds if bound.is_target}
    for bound in bounds:
        value = targets.get(bound.quantity, bound.low)
        if (
            not bound.is_target
            and bound.quantity in targets
            and not bound.low <= value <= bound.high
        ):
            name = bound.quantity.name
            must = f"must agree with target.{name}"
            raise ParameterError(
                f"subject_to.{name}", bound.text.removeprefix(f"{name} "), must=must
            )


def _objective(name: Any) -> Objective:
    if not isinstance(name, str):
        raise ParameterError("minimise", name, "names of quantities of a steady state")
    if name.removeprefix("-").strip() == YIELD:
        if not name.startswith("-"):
            raise ParameterError("minimise", name, f"-{YIELD}, which makes it largest")
        return Objective(Named(YIELD, YIELD, derived=YIELD), -1.0)
    quantity = named(name.removeprefix("-").strip(), "minimise")
    if quantity.is_of_law:
        must = "must depend continuously on the parameters; give it in target or subject_to"
        raise ParameterError("minimise", name, must=must)
    return Objective(quantity, -1.0 if name.startswith("-") else 1.0)


def bounds_of_parts(subject_to: Mapping[str, Any]) -> tuple[Bound, ...]:
    """Return bounds that each finished part keeps or breaks; ParameterError for any others."""
    bounds = tuple(_bound(name, value) for name, value in subject_to.items())
    for bound in bounds:
        name = bound.quantity
        if name.derived or name.is_parameter:
            must = "must be a quantity of the motion, which each part has"
            raise ParameterError(f"subject_to.{name.name}", None, must=must, got="")
    return bounds


def check_allow(goals: Goals, allow: Mapping[str, float] | None) -> dict[str, float]:
    """Return how far targets may be off, or raise a ParameterError."""
    if allow is None:
        limits = [b for b in goals.bounds if not b.is_target and not b.quantity.derived]
        if goals.of_yield and not limits:
            must = f"is required, since -{YIELD} is wanted without a bound"
            raise ParameterError("allow", allow, must=must, got="")
        return {}
    targets = [
        bound.quantity.name
        for bound in goals.bounds
        if bound.is_target and not bound.quantity.is_of_law
    ]
    if {*allow} != {*targets}:
        must = f"must have the targets as keys ({', '.join(targets) or 'there are none'})"
        raise ParameterError("allow", allow, must=must, got=", ".join(allow))
    return {name: number_within(f"allow.{name}", allow[name], POSITIVE) for name in targets}


def check_placed(goals: Goals, ties: Ties) -> None:
    """Raise a ParameterError where a place is wanted along a parameter that is tied, or that others are tied to."""
    for name in goals.names:
        along = PLACES[name.variable][1] if name.is_place else ""
        if along and any(along in (tied, *ties.roots[tied]) for tied in ties.parameters):
            must = f"must leave out {along}, since {name.name} is wanted, along {along} alone"
            raise ParameterError("ties", ties.texts, must=must, got="")


def check_presence(values: Mapping[str, Any], goals: Goals) -> None:
    """Raise a ParameterError where something is wanted of a part that no exciter has.

    That is of contacts with a support whose stiffness among `values` is 0, and of a housing that is fixed.
    """
    for name in goals.names:
        stiffness = f"k{name.number}"
        if name.variable in OF_SOFT and not values.get(stiffness, 0.0):
            must = f"must be above 0, since {name.name} is wanted: a support with 0 is rigid"
            raise ParameterError(stiffness, 0.0, must=must)
        effect = STEADY[name.variable].effect if name.variable in STEADY else ""
        if effect == "housing" and not values.get("mass_ratio", 0.0):
            must = f"must be above 0, since {name.name} is wanted: a housing with 0 is fixed"
            raise ParameterError("mass_ratio", 0.0, must=must)
