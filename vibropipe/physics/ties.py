"""Ties: parameters given by expressions of others, or of names of one's own, and their derivatives."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from copy import copy
from dataclasses import replace
from functools import cached_property
from graphlib import CycleError, TopologicalSorter
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.physics.parameter_error import ParameterError, number_within
from vibropipe.words.expressions import (
    ALLOWED,
    FUNCTIONS,
    NAME,
    RESERVED,
    Expression,
    ExpressionError,
)
from vibropipe.words.parameters import (
    FOLLOWED,
    FOLLOWING,
    PARAMETERS,
    PHYSICAL,
    STARTS,
    TiedValue,
    stated_value,
)
from vibropipe.words.records import FINITE
from vibropipe.words.spelling import did_you_mean, latin
from vibropipe.words.vocabulary import quantity

if TYPE_CHECKING:
    from vibropipe.physics.exciter import Exciter

A_TIE = f"a number or text with {ALLOWED}"
A_NAME = "a parameter, or a name of one's own of letters, digits and _ that begins with a letter"
TIED = "must be left out, since it is tied"
# Values of a parameter that is followed at which what is tied to it must be in range.
SAMPLES = 65


class Ties:
    """Expressions of parameters, and of names of one's own, in an order in which each can be computed.

    given : expression of each tied name. The names in them are parameters, other tied names, or names of one's own that
        the caller gives values
    expressions : in an order in which each can be computed
    texts : as they are written, in the order that is given

    Raises ParameterError if a name is none or has another meaning, an expression cannot be read, or ties go round in a
    circle.
    """

    def __init__(self, given: Mapping[str, Any] | None = None) -> None:
        if given is not None and not isinstance(given, Mapping):
            raise ParameterError("ties", given, "a mapping of names to expressions")
        read = {_name(name): _expression(name, text) for name, text in (given or {}).items()}
        if len(read) < len(given or {}):
            raise ParameterError("ties", given, must="must have each name once")
        for name, each in read.items():
            for used in each.names:
                check_own(f"ties.{name}", used)
                if used in STARTS:
                    must = f"must not use {used}: a start is no parameter"
                    raise ParameterError(f"ties.{name}", each.text, must=must)
        graph = {name: [used for used in each.names if used in read] for name, each in read.items()}
        try:
            order = [*TopologicalSorter(graph).static_order()]
        except CycleError as error:
            circle = " from ".join(reversed(error.args[1]))
            must = f"must not go round in a circle: {circle}"
            raise ParameterError(
                f"ties.{error.args[1][0]}", read[error.args[1][0]].text, must=must, got=""
            ) from None
        self.expressions = {name: read[name] for name in order}
        self.texts = {name: each.text for name, each in read.items()}

    def __bool__(self) -> bool:
        return bool(self.expressions)

    @property
    def parameters(self) -> list[str]:
        """The tied parameters, in the order of the parameters."""
        return [name for name in PARAMETERS if name in self.expressions]

    @cached_property
    def free(self) -> tuple[str, ...]:
        """Names in the expressions that are not tied: parameters, and names of one's own that need a value."""
        used = [name for each in self.expressions.values() for name in each.names]
        return tuple(dict.fromkeys(name for name in used if name not in self.expressions))

    @property
    def own(self) -> tuple[str, ...]:
        """Names of one's own that need a value."""
        return tuple(name for name in self.free if name not in PARAMETERS)

    @cached_property
    def roots(self) -> dict[str, tuple[str, ...]]:
        """The free names that each tied name depends on, directly or through others."""
        roots: dict[str, tuple[str, ...]] = {}
        for name, each in self.expressions.items():
            found = [root for used in each.names for root in roots.get(used, (used,))]
            roots[name] = tuple(dict.fromkeys(found))
        return roots

    @property
    def attrs(self) -> dict[str, str]:
        """The attribute of datasets that says what is tied, "R2 = R1; f = 0.02 * nu**2"; none without ties."""
        text = "; ".join(f"{name} = {text}" for name, text in self.texts.items())
        return {"ties": text} if self else {}

    def values(
        self, given: Mapping[str, Any], names: Collection[str] | None = None
    ) -> dict[str, Any]:
        """Return tied parameters at values of the free names that they depend on.

        given : arrays have one shape
        names : the tied parameters that are wanted (default: all)

        Returns numbers or arrays; nan where an expression has no finite real value.
        """
        known = dict(given)
        for name, each in self.expressions.items():
            if all(used in known for used in each.names):
                known[name] = _for_each(each.value, each.names, known)
        return {name: known[name] for name in (self.parameters if names is None else names)}

    def checked(
        self, given: Mapping[str, Any], names: Collection[str] | None = None
    ) -> dict[str, Any]:
        """Return the same, or some of it; ParameterError where one is no finite number, or not in its range."""
        tied = self.values(given, names)
        for name, values in tied.items():
            flat, within = np.ravel(values), PARAMETERS[name].range
            for n in np.flatnonzero([not within.contains(value) for value in flat.tolist()])[:1]:
                at = ", ".join(
                    f"{root} = {np.broadcast_to(given[root], np.shape(values)).ravel()[n].item()!r}"
                    for root in self.roots[name]
                )
                got = f"{flat[n].item()!r}" + (f" at {at}" if at else "")
                got += f" by {self.expressions[name].text}"
                raise ParameterError(f"ties.{name}", flat[n].item(), within.text, got=got)
        return tied

    def applied(self, exciter: Exciter, given: Mapping[str, float]) -> Exciter:
        """Return an exciter with the parameters among some names, and with what is tied; errors as of `checked`.

        given : values of parameters, and of names of one's own
        """
        tied = self.checked({**exciter.numbers()._asdict(), **given})
        changed = {name: value for name, value in {**given, **tied}.items() if name in PARAMETERS}
        return replace(exciter, **changed)

    def untied(self, exciter: Exciter) -> Exciter:
        """Return an exciter of the same values that does not state what is tied."""
        untied = copy(exciter)
        for name in self.parameters:
            own = float(stated_value(getattr(exciter, name)))
            object.__setattr__(untied, name, TiedValue(own))
        return untied

    def spans(
        self, given: Mapping[str, float], ranges: Mapping[str, tuple[float, float]]
    ) -> dict[str, tuple[float, float]]:
        """Return the least and the largest value of each parameter that is tied to what has a range.

        They are those at the ends and in the middles of the ranges; a parameter without a value there is left out.

        given : values of free names without a range
        """
        spans = {}
        for name in self.parameters:
            within = [root for root in self.roots[name] if root in ranges]
            thirds = [
                (low, (low + high) / 2, high) for low, high in (ranges[root] for root in within)
            ]
            grids = np.meshgrid(*thirds, indexing="ij")
            at = {root: given[root] for root in self.roots[name] if root not in within}
            values = np.ravel(self.values(at | dict(zip(within, grids, strict=True)), [name])[name])
            found = values[np.isfinite(values)]
            if within and found.size:
                spans[name] = (float(found.min()), float(found.max()))
        return spans

    def slopes(
        self, given: Mapping[str, float], by: Collection[str]
    ) -> dict[str, dict[str, float]]:
        """Return the derivatives of each tied parameter by those of some free names that it depends on.

        given : value of each free name
        """
        values = dict(given)
        slopes = {name: {name: 1.0} for name in self.free if name in by}
        for name, each in self.expressions.items():
            values[name], slopes[name] = each.with_slopes(values, slopes)
        return {name: slopes[name] for name in self.parameters}

    def following(self, names: Collection[str]) -> list[str]:
        """Return the parameters that are tied to some names, directly or through others."""
        return [each for each in self.parameters if not {*names}.isdisjoint(self.roots[each])]

    def followed(self, values: Mapping[str, Any], along: Collection[str]) -> dict[str, np.ndarray]:
        """Return what follows names along which orbits are followed, at values of all; errors as of `checked`."""
        following = self.following(along)
        for name in following:
            if name not in FOLLOWED:
                varied = " or ".join(along)
                must = f"must not depend on {varied}, since no orbit is followed along {name}"
                raise ParameterError(f"ties.{name}", self.texts[name], must=must, got="")
        return {name: np.asarray(each) for name, each in self.checked(values, following).items()}

    def chained(
        self,
        given: Mapping[str, float],
        names: Sequence[str],
        by: Collection[str],
        jacobian: np.ndarray,
    ) -> np.ndarray:
        """Return derivatives (q, by) by some free names from those (q, names) by each parameter alone.

        given : value of each free name
        names : parameters, those that follow among them
        jacobian : (q, names)
        """
        slopes = self.slopes(given, by)
        moves = np.array(
            [[slopes.get(each, {each: 1.0}).get(name, 0.0) for name in by] for each in names]
        )
        # An undefined derivative does not count where nothing acts through it.
        total: np.ndarray = np.where(moves == 0.0, 0.0, jacobian[:, :, None] * moves).sum(axis=1)
        return total

    def check(
        self, stated: Collection[str], varied: Iterable[str] = (), argument: str = ""
    ) -> None:
        """Raise a ParameterError for a name without a value, or one with two.

        stated : the parameters that are stated
        varied : names that the call gives values
        argument : the argument that does, if any
        """
        names = [*varied]
        for name in self.expressions:
            if name in names:
                raise ParameterError(f"{argument}.{name}", name, must=TIED, got="")
            if name in stated:
                raise ParameterError(name, name, must=TIED, got="")
        known = [*PARAMETERS, *self.expressions, *names]
        for name, each in self.expressions.items():
            for used in each.names:
                if used in self.expressions or used in names:
                    continue
                # Of others the default says that an effect is absent; these follow from what else is stated.
                if used in PARAMETERS and (used not in FOLLOWING or used in stated):
                    continue
                where = f"in {argument} or " if argument else ""
                must = f"must have a value for {used}: give it {where}by a tie"
                hint = "" if used in PARAMETERS else did_you_mean(used, known)
                got = repr(each.text) + (f" ({hint})" if hint else "")
                raise ParameterError(f"ties.{name}", each.text, must=must, got=got)


def check_own(argument: str, name: str) -> None:
    """Raise a ParameterError for a name of one's own that has another meaning."""
    if name in PARAMETERS or name in STARTS or not (meaning := _meaning(name)):
        return
    must = (
        f"must not have {name} as a name of one's own, since {meaning}: take another, as own_{name}"
    )
    raise ParameterError(argument, name, must=must, got="")


def _meaning(name: str) -> str:
    """Return what a name means elsewhere; empty if it means nothing."""
    if name in RESERVED:
        return f"it is what expressions call {'a function' if name in FUNCTIONS else 'a constant'}"
    if name in PHYSICAL:
        plain = PHYSICAL[name].non_dimensional
        return f"it is a parameter with units{plain and f' ({plain} has none)'}"
    try:
        quantity(name)
    except KeyError:
        return ""
    return "datasets have a quantity of this name"


def _name(name: Any) -> str:
    """Return a tied name in Latin letters, or raise a ParameterError if it is none."""
    spelled = latin(name)
    if not isinstance(spelled, str) or not NAME.fullmatch(spelled) or spelled in STARTS:
        raise ParameterError("ties", name, must=f"must have keys that are each {A_NAME}")
    check_own("ties", spelled)
    return spelled


def _expression(name: Any, text: Any) -> Expression:
    """Return an expression, or raise a ParameterError naming the tie that it is of."""
    try:
        written = (
            text if isinstance(text, str) else repr(number_within(f"ties.{name}", text, FINITE))
        )
        return Expression(written)
    except ExpressionError as error:
        raise ParameterError(f"ties.{name}", text, A_TIE, got=f"{text!r}, with {error}") from None


def _for_each(function: Any, names: tuple[str, ...], known: Mapping[str, Any]) -> Any:
    """Return the values of a function of named numbers at numbers or arrays."""
    columns = [known[name] for name in names]
    if all(np.ndim(column) == 0 for column in columns):
        return function({name: float(known[name]) for name in names})
    arrays = np.broadcast_arrays(*columns)
    rows = zip(*(array.ravel().tolist() for array in arrays), strict=True)
    values = [function(dict(zip(names, row, strict=True))) for row in rows]
    return np.array(values).reshape(arrays[0].shape)
