"""What boundaries are sought: kinds of bifurcations, and values of quantities."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any

from vibropipe.physics.exciter import ParameterError
from vibropipe.solve.design.goals import Bound, Goals, check_presence, target_of
from vibropipe.words.outputs import OF_BRANCH
from vibropipe.words.vocabulary import STEADY

# Kinds of bifurcations that have boundaries.
BOUNDARIES = ("fold", "flip", "pitchfork", "grazing")
ALLOWED = (
    f"one or some of {', '.join(BOUNDARIES)}, and of quantities with their values, such as "
    '{"impact_velocity_max_1": 0.8}'
)


def kinds_and_levels(
    of: str | Mapping[str, float] | Collection[str | Mapping[str, float]],
) -> tuple[tuple[str, ...], tuple[Bound, ...]]:
    """Return the kinds of bifurcations and the levels that are sought, or raise a ParameterError."""
    listed = [of] if isinstance(of, (str, Mapping)) or not isinstance(of, Collection) else [*of]
    kinds: list[str] = []
    levels: list[Bound] = []
    for each in listed:
        if isinstance(each, Mapping) and each:
            levels += [level_of(name, value) for name, value in each.items()]
        elif isinstance(each, str) and each in BOUNDARIES:
            kinds.append(each)
        else:
            raise ParameterError("of", of, ALLOWED)
    if not listed:
        raise ParameterError("of", of, ALLOWED)
    return tuple(kinds), tuple(dict.fromkeys(levels))


def level_of(name: str, value: Any) -> Bound:
    """Return the value of a quantity whose curve is sought, or raise a ParameterError."""
    level = target_of("of", name, value)
    quantity, argument = level.quantity, f"of.{name}"
    if quantity.is_parameter or quantity.derived or quantity.is_place:
        must = (
            "must be a quantity of the motion, such as displacement_mean or impact_velocity_max_1"
        )
        raise ParameterError("of", name, must=must, got=name)
    if quantity.is_of_law:
        must = "must depend continuously on the parameters: where the law of motion changes is the kind grazing"
        raise ParameterError("of", name, must=must, got=name)
    if STEADY[quantity.variable].output not in ("", *OF_BRANCH):
        must = "must be a quantity that points of branches have"
        raise ParameterError("of", name, must=must, got=name)
    if quantity.is_never_negative and level.low == 0.0:
        raise ParameterError(argument, value, must=f"must be > 0, since {name} is never negative")
    return level


def check_levels(values: Mapping[str, Any], levels: Sequence[Bound]) -> None:
    """Raise a ParameterError where a level is that of a part which no exciter has.

    values : of the exciter, of parameters that vary the largest
    """
    check_presence(values, Goals(tuple(levels), ()))
