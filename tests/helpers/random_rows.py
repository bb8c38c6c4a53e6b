"""Random rows of parameters from the whole space, corners favoured, and their steady states."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from vibropipe.orbits.window import WINDOW
from vibropipe.physics.exciter import Parameters
from vibropipe.solve.rows.label import coordinates, label_rows
from vibropipe.solve.rows.many import RowLimits, Rows, solve_rows
from vibropipe.solve.sweep.blocks import MAX_PERIODS
from vibropipe.solve.threads import row_blocks
from vibropipe.words.outputs import OUTPUTS
from vibropipe.words.parameters import DEFAULTS, PARAMETERS

HARMONICS = 3


def draw_rows(seed: int, rows: int) -> np.ndarray:
    """Parameters (rows, 7) of eqs. (5), (6) in the order of `Parameters`.

    Few rows have the lowest nu, where a forcing period takes 100 times the steps of one at nu = 1.
    """
    rng = np.random.default_rng(seed)

    def choice(values: list[Any], weights: list[float]) -> np.ndarray:
        """One of `values` for each row; each is a number or an array (rows,)."""
        columns = np.stack([np.broadcast_to(value, rows) for value in values])
        return columns[rng.choice(len(values), rows, p=weights), np.arange(rows)]

    def log(low: float, high: float) -> np.ndarray:
        return 10 ** rng.uniform(low, high, rows)

    def restitution() -> np.ndarray:
        return choice([0.0, 1.0, rng.uniform(0, 1, rows), 1 - log(-12, -1)], [0.2, 0.25, 0.5, 0.05])

    half = choice([0.5, log(-3, 3)], [0.7, 0.3])
    offsets = [0.0, half, -half, half * rng.uniform(-1, 1, rows), half * rng.uniform(-2, 2, rows)]
    nu = [1.0, 2.0, rng.uniform(0.2, 4, rows), log(-1, 1), log(1, 4), log(-2, -1)]
    sign = rng.choice([-1.0, 1.0], rows)
    return np.stack(
        [
            choice(nu, [0.03, 0.02, 0.75, 0.1, 0.09, 0.01]),
            choice([0.0, sign * rng.uniform(0, 3, rows), sign * log(-6, 3)], [0.1, 0.7, 0.2]),
            choice([0.0, rng.uniform(0, 1, rows), log(-6, 2), 2.0], [0.2, 0.5, 0.28, 0.02]),
            half,
            choice(offsets, [0.25, 0.1, 0.1, 0.35, 0.2]),
            restitution(),
            restitution(),
        ],
        axis=1,
    )


def solve_drawn(parameters: np.ndarray, start: tuple[float, float] = (0.0, 0.0)) -> xr.Dataset:
    """Return the steady states of rows with all outputs over `row`, with the parameters as coordinates.

    Parameters (rows, 7) have no effect beyond eqs. (5), (6).
    """
    absent = [DEFAULTS[name] for name in [*PARAMETERS][parameters.shape[1] :]]
    parameters = np.hstack([parameters, np.tile(absent, (len(parameters), 1))])
    ((_stop, (solved,)),) = solve_rows(
        row_blocks(len(parameters)),
        Rows(lambda first, stop: [parameters[first:stop]], start),
        RowLimits(MAX_PERIODS, WINDOW),
        HARMONICS,
        OUTPUTS,
    )
    variables = label_rows(solved, parameters)
    coords = {name: ("row", parameters[:, i]) for i, name in enumerate(Parameters._fields)}
    return xr.Dataset(variables, coordinates(variables, HARMONICS)).assign_coords(coords)
