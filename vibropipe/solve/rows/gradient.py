"""Values and derivatives of quantities of a stable orbit by parameters."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol

import numpy as np

from vibropipe.physics.exciter import Parameters
from vibropipe.solve.rows.named import LENGTHS, Named
from vibropipe.solve.rows.points import Points, clipped
from vibropipe.solve.rows.row_results import columns_of
from vibropipe.solve.rows.sensitivity import differentiated
from vibropipe.words.parameters import PARAMETERS, THROUGH_OTHERS, slopes_of_acted

# Steps of central differences over the size of a parameter: orbits are known to some 1e-13, and the error of a
# difference is least near the cube root.
STEP = 3e-5
Read = Callable[[Points], np.ndarray]
Difference = Callable[[np.ndarray, np.ndarray], np.ndarray]


class Solve(Protocol):
    """Solves points (n, p) from starts (n, 3), with the output `sensitivity` if it is asked for."""

    def __call__(
        self, parameters: np.ndarray, states: np.ndarray, sensitivity: bool = False
    ) -> Points:
        """Return the solved points."""


def parameter_steps(parameters: np.ndarray, columns: Sequence[int]) -> np.ndarray:
    """Return steps (columns,) of differences, relative to a parameter or, if it is small, to its scale."""
    half, records = parameters[Parameters._fields.index("l")], [*PARAMETERS.values()]
    scales = np.array([half ** LENGTHS.get(records[n].dimension, 0) for n in columns])
    return STEP * np.maximum(np.abs(parameters[list(columns)]), 0.1 * scales)


def values_and_jacobian(
    parameters: np.ndarray,
    state: np.ndarray,
    columns: Sequence[int],
    solve: Solve,
    read: Read,
    difference: Difference,
    names: Sequence[Named] | None = None,
) -> tuple[Points, np.ndarray, np.ndarray]:
    """Return the solved point, its quantities (q,), and their derivatives (q, columns).

    parameters : (p,)
    state : (3,), start near the orbit
    columns : parameters by which the derivatives are taken
    read : returns the quantities (n, q) of solved points
    difference : returns the difference of two rows of quantities
    names : the quantities that `read` returns, if they have exact derivatives. Those that are undefined, as of an
        amplitude that vanishes, and all without names are central differences
    """
    if names is None:
        return by_differences(parameters, state, columns, solve, read, difference)
    point = solve(parameters[None], state[None], sensitivity=True)
    values, jacobian = read(point)[0], exact_slopes(point, names, columns)[0]
    missing = np.isnan(jacobian) & np.isfinite(values)[:, None]
    if missing.any() and point.is_stable[0]:
        _, _, differences = by_differences(parameters, state, columns, solve, read, difference)
        jacobian = np.where(missing, differences, jacobian)
    return point, values, jacobian


def exact_slopes(points: Points, names: Sequence[Named], columns: Sequence[int]) -> np.ndarray:
    """Return the derivatives (n, names, columns) of quantities by parameters; NaN where there is none."""
    slopes = np.full((len(points.parameters), len(names), len(columns)), np.nan)
    differentiable = differentiated(points.variables)
    for row, name in enumerate(names):
        for k, column in enumerate(columns):
            parameter = Parameters._fields[column]
            if name.is_parameter:
                slopes[:, row, k] = float(name.variable == parameter)
            elif name.is_of_law:
                slopes[:, row, k] = 0.0
            elif name.is_place:
                if name.has_slopes(points.variables):
                    slopes[:, row, k] = name.slopes(points.variables, column)
            elif parameter in differentiable and name.has_slopes(points.variables):
                slopes[:, row, k] = name.slopes(points.variables, differentiable.index(parameter))
            elif THROUGH_OTHERS.get(parameter) and name.has_slopes(points.variables):
                slopes[:, row, k] = _through_others(points, name, parameter, differentiable)
    return slopes


def _through_others(
    points: Points, name: Named, parameter: str, differentiable: Sequence[str]
) -> np.ndarray:
    """Return the derivative (n,) of a quantity by a parameter that acts through others; NaN where it hides them."""
    by = slopes_of_acted(columns_of(points.parameters))
    total = np.zeros(len(points.parameters))
    for target in THROUGH_OTHERS[parameter]:
        slope = name.slopes(points.variables, differentiable.index(target))
        with np.errstate(divide="ignore", invalid="ignore"):
            total += slope * by[target][parameter] / by[target][target]
    return np.where(np.isfinite(total), total, np.nan)


def by_differences(
    parameters: np.ndarray,
    state: np.ndarray,
    columns: Sequence[int],
    solve: Solve,
    read: Read,
    difference: Difference,
) -> tuple[Points, np.ndarray, np.ndarray]:
    """Return the same as `values_and_jacobian` by central differences.

    A neighbour with another law of motion is left out: its derivative is one-sided, or 0 with none on either side.
    """
    k = len(columns)
    rows = np.tile(parameters, (1 + 2 * k, 1))
    steps = parameter_steps(parameters, columns)
    for n, column in enumerate(columns):
        rows[1 + 2 * n, column] -= steps[n]
        rows[2 + 2 * n, column] += steps[n]
    rows = clipped(rows)
    points = solve(rows, np.tile(state, (len(rows), 1)))
    values = read(points)
    is_same = points.has_law(points.laws[0])
    jacobian = np.zeros((values.shape[1], k))
    for n, column in enumerate(columns):
        low, high = (row if is_same[row] else 0 for row in (1 + 2 * n, 2 + 2 * n))
        width = rows[high, column] - rows[low, column]
        if width > 0:
            jacobian[:, n] = difference(values[high], values[low]) / width
    return points.take(slice(0, 1)), values[0], jacobian
