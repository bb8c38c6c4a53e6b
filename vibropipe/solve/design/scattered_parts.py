"""Rows of parameters around others: scattered parts, and the ends and corners of the worst case; what scatters."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from vibropipe.physics.exciter import Exciter, ParameterError, Parameters
from vibropipe.physics.parameter_error import check_keys, number_within
from vibropipe.physics.stated import stated_names
from vibropipe.physics.ties import Ties
from vibropipe.solve.checks import check_varied
from vibropipe.solve.rows.points import clipped
from vibropipe.words.parameters import CONTINUOUS
from vibropipe.words.records import POSITIVE

# Corners of the worst case are tried as long as there are at most so many parameters.
MAX_CORNERS = 10


class Tied(NamedTuple):
    """Ties that scattered parts keep, and the values of those of their own names that scatter."""

    ties: Ties
    own: Mapping[str, float]

    def values(self, base: np.ndarray) -> dict[str, Any]:
        """Return all values of parameters (p,) or rows of them (p, n) and of own names, by name."""
        return dict(zip(Parameters._fields, base, strict=True)) | dict(self.own)


UNTIED = Tied(Ties(), {})


def moved_rows(
    base: np.ndarray, sigma: Mapping[str, float], n: int, reach: float, tied: Tied = UNTIED
) -> np.ndarray:
    """Return rows of parameters around one (p,): n scattered ones, then the ends and corners of the worst case.

    Raises ParameterError where a tie has no value.
    """
    deviations = np.array(list(sigma.values()))
    moves = np.vstack([scattered(len(sigma), n), box(len(sigma), reach)]) * deviations
    rows = np.tile(base, (len(moves), 1))
    own = {name: np.full(len(moves), value) for name, value in tied.own.items()}
    for name, move in zip(sigma, moves.T, strict=True):
        if name in own:
            own[name] += move
        else:
            rows[:, Parameters._fields.index(name)] += move
    rows = clipped(rows)
    following = tied.ties.following(sigma)
    values = tied.ties.values(tied.values(rows.T) | own, following) if following else {}
    for name, column in values.items():
        if not np.isfinite(column).all():
            must = "must have a finite value at all scattered parts"
            text = tied.ties.expressions[name].text
            raise ParameterError(f"ties.{name}", text, must=must)
        rows[:, Parameters._fields.index(name)] = column
    return clipped(rows)


def scattered(k: int, n: int) -> np.ndarray:
    """Return n normal deviates (n, k) of low discrepancy."""
    from scipy.special import ndtri
    from scipy.stats import qmc

    sequence = qmc.Sobol(k, scramble=False)
    # The first point of the sequence is a corner, at minus infinity.
    sequence.fast_forward(1)
    deviates: np.ndarray = ndtri(sequence.random(n))
    return deviates


def box(k: int, reach: float) -> np.ndarray:
    """Return the ends of each axis (below and above in turn) and the corners of a box, (n, k)."""
    axes = np.repeat(np.eye(k), 2, axis=0) * np.tile([-1.0, 1.0], k)[:, None]
    if 1 < k <= MAX_CORNERS:
        axes = np.vstack([axes, np.array(list(itertools.product((-1.0, 1.0), repeat=k)))])
    return reach * axes


ARGUMENT = "tolerances"  # of `vibropipe.tolerance`


def check_tied(
    exciter: Exciter, tolerances: Mapping[str, float], ties: Ties
) -> tuple[Exciter, Tied, dict[str, float]]:
    """Return the exciter with what is tied, the ties that parts keep, and standard deviations of what is free.

    Raises ParameterError for what is tied and scatters, and for a name of one's own without a value.
    """
    own = {
        name: float(each.value({})) for name, each in ties.expressions.items()
        if name in tolerances and name not in Parameters._fields and not each.names
    }  # fmt: skip
    kept = Ties({name: text for name, text in ties.texts.items() if name not in own})
    kept.check(stated_names(exciter), tolerances, ARGUMENT)
    for name in kept.own:
        if name in tolerances and name not in own:
            must = "must have its value as a tie, since it scatters"
            raise ParameterError(f"ties.{name}", None, must=must, got="")
    tied = Tied(kept, own)
    numbers = np.array(exciter.numbers())
    exciter = replace(exciter, **kept.checked(tied.values(numbers))) if kept else exciter
    of_parameters = {name: each for name, each in tolerances.items() if name not in own}
    sigma = check_tolerances(exciter, of_parameters, ARGUMENT) if of_parameters or not own else {}
    return (
        exciter,
        tied,
        sigma
        | {name: number_within(f"{ARGUMENT}.{name}", tolerances[name], POSITIVE) for name in own},
    )


def check_tolerances(
    exciter: Exciter, tolerances: Mapping[str, float], argument: str = "tolerance"
) -> dict[str, float]:
    """Return standard deviations in the order of the parameters, or raise a ParameterError naming the argument."""
    if not tolerances:
        raise ParameterError(argument, tolerances, must="must have at least one parameter")
    check_keys(argument, tolerances, CONTINUOUS)
    check_varied(argument, exciter, tolerances, {})
    return {
        name: number_within(f"{argument}.{name}", tolerances[name], POSITIVE)
        for name in Parameters._fields
        if name in tolerances
    }
