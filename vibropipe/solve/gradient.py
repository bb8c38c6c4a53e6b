"""Values and derivatives of quantities of a stable orbit by parameters."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from vibropipe.physics.exciter import Parameters
from vibropipe.solve.points import Points, clipped

# Steps of central differences over the size of a parameter: orbits are known to some 1e-13, and the error of a
# difference is least near the cube root.
STEP = 3e-5
Solve = Callable[[np.ndarray, np.ndarray], Points]
Read = Callable[[Points], np.ndarray]


def parameter_steps(parameters: np.ndarray, columns: Sequence[int], step: float) -> np.ndarray:
    """Return steps (columns,) of differences, relative to a parameter or, if it is small, to its scale."""
    half = parameters[Parameters._fields.index("l")]
    scales = np.array(
        [half if Parameters._fields[column] in ("f", "delta", "l") else 1.0 for column in columns]
    )
    return step * np.maximum(np.abs(parameters[list(columns)]), 0.1 * scales)


def values_and_jacobian(
    parameters: np.ndarray,
    state: np.ndarray,
    columns: Sequence[int],
    solve: Solve,
    read: Read,
    difference: Callable[[np.ndarray, np.ndarray], np.ndarray],
    step: float = STEP,
) -> tuple[Points, np.ndarray, np.ndarray]:
    """Return the solved point, its quantities (q,), and their derivatives (q, columns) by central differences.

    Parameters
    ----------
    parameters : (p,) array
    state : (2,) array
        Start near the orbit.
    columns : sequence of int
        Parameters by which the derivatives are taken.
    solve, read : callable
        Solve points (n, p) from starts (n, 2); return the quantities (n, q) of solved points.
    difference : callable
        Returns the difference of two rows of quantities.
    step : float
        Of the differences, over the size of a parameter.

    Notes
    -----
    A neighbour with another law of motion is left out: its derivative is one-sided, or 0 with none on either side.
    """
    k = len(columns)
    rows = np.tile(parameters, (1 + 2 * k, 1))
    steps = parameter_steps(parameters, columns, step)
    for n, column in enumerate(columns):
        rows[1 + 2 * n, column] -= steps[n]
        rows[2 + 2 * n, column] += steps[n]
    rows = clipped(rows)
    points = solve(rows, np.tile(state, (len(rows), 1)))
    values = read(points)
    is_same = (points.laws == points.laws[0]).all(axis=1) & points.is_stable
    jacobian = np.zeros((values.shape[1], k))
    for n, column in enumerate(columns):
        low, high = (row if is_same[row] else 0 for row in (1 + 2 * n, 2 + 2 * n))
        width = rows[high, column] - rows[low, column]
        if width > 0:
            jacobian[:, n] = difference(values[high], values[low]) / width
    return points.take(slice(0, 1)), values[0], jacobian
