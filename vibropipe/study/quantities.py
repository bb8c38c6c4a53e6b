"""Quantities with units in a study, as numbers without, and their faults."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from typing import Any

from vibropipe.physics.exciter import ParameterError
from vibropipe.physics.si import eigenfrequency, non_dimensional, unit_factors
from vibropipe.scenes.keys.problems import KeyPath, Problem, describe, refused
from vibropipe.scenes.keys.values import DECIMAL_COMMA, UnitRule, as_number
from vibropipe.solve.design.goals import CURVE
from vibropipe.solve.rows.named import named
from vibropipe.study.tables import PHASE
from vibropipe.words.parameters import PARAMETERS, PHYSICAL
from vibropipe.words.records import FINITE, NOT_NEGATIVE, POSITIVE, Range
from vibropipe.words.sensors import RECORD, TAU, TIME
from vibropipe.words.spelling import did_you_mean
from vibropipe.words.units import MINUS, UnitError, to_si
from vibropipe.words.vocabulary import PLACES_IN_SI

# Parameters by their names with units -> without, and back.
NAMES = {name: entry.non_dimensional for name, entry in PHYSICAL.items() if entry.non_dimensional}
WRITTEN = {name: written for written, name in NAMES.items()}
# Keys of `physical` beside m and C.
TAKEN = PHYSICAL.keys() - {"m", "C"}
# Keys of `physical` that share in the pull of gravity.
OF_GRAVITY = {"slope", "gravity", "load", "P", "M"}
OF_UNBALANCE = {"m_e", "e", "shaker"}
# What of `physical` gives a parameter together: keys that stand in different places, by one that calls for it.
TOGETHER = {
    "slope": (OF_GRAVITY, ("load", "housing_load")),
    "m_e": (OF_UNBALANCE, ("shaker",)),
    "e": (OF_UNBALANCE, ("shaker",)),
}
# Keys that stand for a parameter that varies.
HIDDEN = {"shaker": {"m_e", "e"}}
# What may not vary on a slope, and why.
ON_SLOPE = {
    "M": "must be left out beside slope: gravity pulls at the housing in proportion to M",
    **dict.fromkeys(
        ("load", "P"),
        "must be left out beside slope, whose share it has: with `slope: 0 deg` in `physical` of this scene it is the "
        "whole force",
    ),
}
# Keys of scenes that take a quantity: dimension and range.
KEYS: dict[str, tuple[str, Range]] = {
    **{name: PHYSICAL[name][:2] for name in NAMES},
    "x0": ("length", FINITE),
    "v0": ("velocity", FINITE),
    "tau_end": ("time", POSITIVE),
    "tau_bar": ("time", POSITIVE),
    "amplitude": ("length", POSITIVE),
    "steady_from": ("time", FINITE),
    "blanking": ("time", NOT_NEGATIVE),
    "no_load": ("frequency", POSITIVE),
    "stall": ("torque", POSITIVE),
    "speed": ("frequency", FINITE),
    "torque": ("torque", FINITE),
}
# Keys whose bare numbers are in SI, and parts of a grid that are quantities; of others the models say what is wrong.
BARE, QUANTITIES = (
    ("tau_end", "steady_from", "blanking"),
    ("start", "stop", "values", "from", "to", "within"),
)
# Keys of a scene without quantities beneath; `exciter` and `physical` are read together.
OTHERS = ("exciter", "physical", "ties", "figure", "solver", "title", "caption", "kind")
SWEPT = [*NAMES, *(name for name in PARAMETERS if name not in WRITTEN)]
RAMP = "ramp"
# Mappings by parameter: grids, where a branch begins and ends, ranges, standard deviations, and limits of a proof.
VARIES = ("over", "along", "vary")
VARIED = (*VARIES, "tolerance", "within", RAMP)
# Mappings by quantity of a steady state.
MEASURED = "measured"
COLUMNS = {**NAMES, TIME: TAU}
GOALS = ("target", "subject_to", "allow", MEASURED, "noise")
# A list of mappings by quantity, and of other entries.
LEVELS = "of"
STAND_IN = 1.0  # for a quantity that is reported, so that the keys around it are checked
STAND_INS: dict[str, Any] = {
    "over": [STAND_IN],
    "along": {"from": STAND_IN, "to": STAND_IN},
    "vary": [STAND_IN, 2 * STAND_IN],
    "tolerance": STAND_IN,
    "within": STAND_IN,
    RAMP: {"from": STAND_IN, "to": 2 * STAND_IN, "within": STAND_IN},
}

_BOUND = re.compile(r"([<>])=?([^<>,]+)")
_CUT = re.compile(r"\d+\s*[^\W\d]")


def last_key(path: KeyPath) -> str:
    """Return the key at the end of a path; empty at its start, and for the name of a scene or a motion."""
    return "" if path[-2:-1] in ((), ("scenes",), ("motions",)) else str(path[-1])


class QuantityReader:
    """Reads quantities of one study, whose `physical` has m and C, and lists their faults."""

    def __init__(self, tree: dict[str, Any]) -> None:
        self.problems: list[Problem] = []
        physical = tree["physical"]
        self.units = {name: si_of(name, physical.get(name)) or STAND_IN for name in ("m", "C")}

    def refuse(
        self, path: KeyPath, value: Any, allowed: str = "", hint: str = "", must: str = ""
    ) -> None:
        """List the fault of a value: what is allowed, or what must hold."""
        self.problems.append(Problem(path, describe(value), allowed, hint, must=must))

    def quantity(self, key: str, value: Any, path: KeyPath) -> Any:
        """Return the number or the grid of a key without units."""
        is_grid, of = isinstance(value, (dict, list)), last_key(path[:-1])
        if (
            key == "M" and of == "over" and isinstance(value, dict)
        ):  # no grid of the ratio m/M is even
            self.refuse(path, value, "a list of values: [0.5 kg, 1 kg]")
            return [STAND_IN, 2 * STAND_IN]
        if of in ("over", "vary") and not is_grid:
            return value  # the model says which lists are taken
        n_problems = len(self.problems)
        numbers = self.numbers(key, value, path)
        if len(self.problems) == n_problems or of in ("along", RAMP):
            return numbers
        n_values = len(value) if isinstance(value, list) and of != "vary" else 2
        return [STAND_IN * (n + 1) for n in range(n_values)] if is_grid else STAND_IN

    def numbers(self, key: str, value: Any, path: KeyPath, hint: str = "") -> Any:
        """Return numbers without units, in their lists and mappings; `hint` goes before others of a fault."""
        if isinstance(value, dict):
            # beside the ends of a ramp, `within` is its length
            lengths = {"within": "tau_end"} if last_key(path[:-1]) == RAMP else {}
            return {
                part: self.numbers(lengths.get(part, key), inner, (*path, part))
                if part in QUANTITIES
                else inner
                for part, inner in value.items()
            }
        if isinstance(value, list):
            after = [*value[1:], None]
            numbers = [
                self.numbers(key, inner, (*path, n), comma_hint(inner, after[n]))
                for n, inner in enumerate(value)
            ]
            # The ratio to a mass falls where the mass rises.
            return numbers[::-1] if KEYS[key][0] == "mass" else numbers
        dimension, within = KEYS[key]
        rule = UnitRule(key, dimension, within, numbers=key in BARE)
        try:
            si = to_si(value, dimension, numbers=key in BARE)
        except UnitError as error:
            self.refuse(path, value, rule.allowed, hint or error.hint)
            return STAND_IN
        if not within.contains(si):
            self.refuse(path, value, rule.allowed)
        if key in NAMES:
            return non_dimensional({**self.units, key: si})[NAMES[key]]
        if dimension == "time":
            return si * eigenfrequency(**self.units)
        return si / unit_factors(**self.units).get(dimension, 1.0)

    def goal(self, name: str, value: Any, path: KeyPath) -> Any:
        """Return a target, a bound, an allowance or a column without units."""
        if path[-2] == MEASURED and isinstance(value, list):
            if name in NAMES:
                before = len(self.problems)
                numbers = self.quantity(name, value, path)
                # a unit stands in the head of a column, for all of it
                del self.problems[before + 1 :]
                return numbers
            return [self.goal(name, entry, path) for entry in value]
        if name == CURVE and isinstance(value, list):
            pairs = [pair if isinstance(pair, list) else [pair] for pair in value]
            return [[*pair[:1], *(self.goal(name, x, path) for x in pair[1:])] for pair in pairs]
        dimension = self.goal_dimension(name, path)
        if not dimension:
            return value
        value = value.replace(MINUS, "-") if isinstance(value, str) else value
        has_comma = isinstance(value, str) and DECIMAL_COMMA.search(value)
        if isinstance(value, str) and not has_comma and (bounds := _BOUND.findall(value)):
            numbers = [(sign, self.pure(end.strip(), dimension, path)) for sign, end in bounds]
            ends = dict(numbers)
            if len(numbers) == len(ends) == 2 and not ends[">"] < ends["<"]:
                must = "must have its lower bound below the upper one"
                self.refuse(path, value, must=must)
            return ", ".join(f"{sign} {number!r}" for sign, number in numbers)
        # of bounds the model says what is wrong
        return value if path[-2] == "subject_to" else self.pure(value, dimension, path)

    def level(self, name: str, value: Any, path: KeyPath) -> Any:
        """Return the value of a quantity whose curve is sought without units."""
        n_problems = len(self.problems)
        number = self.goal(name, value, path)
        return number if len(self.problems) == n_problems else STAND_IN

    def pure(self, value: Any, dimension: str, path: KeyPath) -> Any:
        """Return a value of a dimension without its units; an angle may be a number, in radians."""
        if dimension == "angle" and (radians := as_number(value)) is not None:
            return radians
        try:
            number = to_si(value, dimension)
        except UnitError as error:
            self.refuse(path, value, error.allowed, error.hint)
            return STAND_IN
        return number / unit_factors(**self.units).get(dimension, 1.0)

    def goal_dimension(self, name: str, path: KeyPath) -> str:
        """Return the physical dimension of a quantity with index; "" of a pure number and of an unknown name."""
        if name in RECORD and path[-2] in (MEASURED, "noise"):
            return RECORD[name]
        if name == CURVE:
            return "length"
        if name == PHASE and path[-2] == MEASURED:
            return ""
        try:
            goal = named(PLACES_IN_SI.get(name, name), str(path[-2]))
        except ParameterError as error:
            problem = refused(path, error)
            if path[-2] == MEASURED and (hint := did_you_mean(name, (*NAMES, *RECORD))):
                found = problem.found.partition(" (did you mean")[0]
                problem = replace(problem, found=found, hint=hint)
            self.problems.append(problem)
            return ""
        return goal.dimension


def comma_hint(value: Any, after: Any) -> str:
    """Return a hint for a number that was cut by a comma in a list: [0.5 mm, 1,5 mm]."""
    is_cut = isinstance(value, int) and isinstance(after, str) and _CUT.match(after)
    return f"if {value}.{after} is meant, write it with a point" if is_cut else ""


def si_of(name: str, value: Any) -> float | None:
    """Return an entry of `physical` in SI, None if it is none; the models report it."""
    try:
        number = to_si(value, PHYSICAL[name].dimension)
    except UnitError:
        return None
    return number if PHYSICAL[name].range.contains(number) and math.isfinite(number) else None
