"""The tolerances that a design needs: how far its parameters may be off so that all that is wanted still holds."""

from __future__ import annotations

import numpy as np

from vibropipe.physics.exciter import Parameters
from vibropipe.solve.design.problem import Problem
from vibropipe.solve.points import clipped
from vibropipe.solve.tolerance import box
from vibropipe.words.parameters import DEFAULTS

# Largest tolerance, as a share of a parameter (of l, of a length near 0); a box that fails shrinks by a factor.
LARGEST, SHRINK, MAX_TRIES = 0.2, 0.8, 60


def needed_tolerances(problem: Problem, parameters: np.ndarray, state: np.ndarray) -> np.ndarray:
    """Return how far each parameter (p,) may be off, up or down, all at once; NaN of absent effects.

    To first order each parameter takes an equal part of what the tightest goal leaves. At all corners and at the ends
    of the axes of this box the motion from the start is then marched: where a goal is missed or the law changes, the
    box shrinks. A target may be off by what `allow` gives.

    Parameters
    ----------
    problem : Problem
    parameters : (p,) array
        The design.
    state : (2,) array
        Its settled state.
    """
    columns = [
        column
        for column, name in enumerate(Parameters._fields)
        if name in ("nu", *problem.vary) or parameters[column] != DEFAULTS.get(name)
    ]
    _, values, slopes = problem.linearised(parameters, state, columns)
    widths = LARGEST * np.abs(parameters[columns])
    half = parameters[Parameters._fields.index("l")]
    widths = np.where(widths > 0, widths, LARGEST * half)
    for column, room in rooms(problem, values):
        with np.errstate(divide="ignore"):
            widths = np.minimum(widths, room / (len(columns) * np.abs(slopes[column])))
    tolerances = np.full(len(parameters), np.nan)
    corners = box(len(columns), 1.0)
    for _ in range(MAX_TRIES):
        rows = np.tile(parameters, (len(corners) + 1, 1))
        rows[1:, columns] += corners * widths
        if holds(problem, clipped(rows)):
            tolerances[columns] = widths
            break
        widths = widths * SHRINK
    return tolerances


def rooms(problem: Problem, values: np.ndarray) -> list[tuple[int, float]]:
    """Return, for each goal on a smooth quantity, its column and how far the quantity may be off."""
    distances = []
    for n in problem.smooth:
        bound = problem.goals.bounds[n]
        column = problem.names.index(bound.quantity)
        if bound.is_target:
            distances.append((column, problem.allow[bound.quantity.name]))
        else:
            distances.append((column, min(values[column] - bound.low, bound.high - values[column])))
    return distances


def holds(problem: Problem, rows: np.ndarray) -> bool:
    """Return whether the motions from the start have the law of the first of the rows, and keep to all goals."""
    points = problem.from_start(rows)
    values = problem.read(points)
    kept = problem.is_valid(points, values) & (points.laws == points.laws[0]).all(axis=1)
    for n in problem.smooth:
        bound = problem.goals.bounds[n]
        column = values[:, problem.names.index(bound.quantity)]
        room = problem.allow[bound.quantity.name] if bound.is_target else 0.0
        kept &= bound.quantity.difference(column, bound.high) <= room
        kept &= bound.quantity.difference(column, bound.low) >= -room
    return bool(kept.all())
