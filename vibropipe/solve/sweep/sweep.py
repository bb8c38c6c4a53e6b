"""The function `sweep`: steady states over a grid of parameters, whole or in shards."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.physics import limits
from vibropipe.physics.exciter import Exciter
from vibropipe.physics.stated import stated_names, ties_of_call
from vibropipe.solve.accuracy.method_choice import check_accuracy
from vibropipe.solve.checks import (
    check_follow,
    check_outputs,
    check_over,
    check_whole,
    swept_dampings,
)
from vibropipe.solve.physical import to_physical
from vibropipe.solve.rows.many import RowLimits
from vibropipe.solve.sweep.blocks import MAX_PERIODS, PATIENCE, assemble, solve_shard
from vibropipe.solve.sweep.cluster import computed_values, solve_on_cluster
from vibropipe.solve.sweep.sweep_grid import Follow, SweepGrid
from vibropipe.solve.sweep.sweep_starts import check_corners, check_swept_start
from vibropipe.solve.warn import warn_unsolved
from vibropipe.solve.with_units import are_with_units, plain_mapping, plain_name, plain_values
from vibropipe.words.outputs import SWEEP_DEFAULT

if TYPE_CHECKING:
    import xarray as xr


def sweep(
    exciter: Exciter,
    over: Mapping[str, Any],
    x0: float | None = None,
    v0: float | None = None,
    harmonics: int = 3,
    follow: Follow = None,
    outputs: Sequence[str] = SWEEP_DEFAULT,
    accuracy: float | None = None,
    effects: Sequence[str] | None = None,
    client: Any = None,
    patience: int = PATIENCE,
    ties: Mapping[str, Any] | None = None,
) -> xr.Dataset:
    """Find the steady states (see `steady_state`) for every combination of the values in `over`.

    Parameters
    ----------
    exciter : Exciter
        The parameters that are the same in every row.
    over : mapping of str to array_like
        Values (an array, a dask array or a list; one-dimensional) of each swept parameter of the
        exciter, of a part of the start, x0 or v0, or of a name that `ties` use, in the order of the dimensions of the
        result. Of an exciter of `from_physical` also parameters with units: omega, F and so on, in SI, as text or as
        quantities of pint; the dataset then is in SI, as `to_physical` returns it.
    x0, v0 : float, optional
        Start of every row: displacement and velocity (default 0) at tau = 0. The default of x0 is the equilibrium or,
        if the equilibrium lies beyond a support, that support. A value within 4 ulps of a support is moved onto it.
        Each can be swept instead.
    harmonics : int
        Number of harmonics of displacement and velocity, from 1 to 1,000.
    follow : (str, str), optional
        A swept parameter and a direction, such as ("nu", "up"): each row starts from the steady state of its lower
        ("up") or upper ("down") neighbour, only the first from (x0, v0). This follows stable branches, and may leave
        one a step before it ends: each step starts a transient. With "both", to show hysteresis, the sweeps up and down
        lie along a first dimension `direction`. Excludes swept starts.
    outputs : sequence of str
        Any of harmonics, impacts, motion, stability, energy, power, frame, subharmonics, poincare, lyapunov,
        sensitivity; others are neither computed nor stored.
    accuracy : float, optional
        Maximum error of each row, relative to its size where that is above 1: adds `error`
        (`vibropipe.solve.accuracy.orbit_errors`); rows beyond it have status `inaccurate`.
    effects : sequence of str, optional
        Any of damping, forcing, support_1, support_2, restitution, rest, load, soft, friction, second_harmonic,
        housing, no_pull, shaker (default: the first six, and those of the others that the parameters have). A
        specialised kernel without the others, but with restitution and rest at any support, marches the rows; it is
        compiled on first use. A row that reaches a support left out has status `support_reached`.
    client : dask.distributed.Client, optional
        The workers of its cluster solve the rows; rows of a lost worker are solved by another one. On machines of the
        same kind the result is bitwise identical.
    patience : int
        Forcing periods, from 128 to 1,000, after which a damped row may be left as chaotic: if a perturbation grew by
        more than e^6 over the last 50 of them, unless areas of the section shrink slowly or a motion without impacts
        exists. Such rows, and all others, are marched for longer (docs/numerics.md). With 1,000 none is left before.
    ties : mapping of str to str or float, optional
        Parameters by expressions of others or of names of one's own, such as {"R2": "R1", "f": "0.02 * nu**2", "h":
        "2 * zeta"}: numbers, names, + - * / **, brackets, sqrt, exp, log, sin, cos, tan and pi (docs/theory.md). Names
        of one's own stand in `over` or have a tie themselves. Parameters are those of `Exciter`, without units.

    Returns
    -------
    xarray.Dataset
        Quantities over the names in `over` and then `support`, `harmonic`, `multiplier`, `phase` and so on, all
        non-dimensional as for `simulate`. `regime` and `status` label rows without a steady state. Impacts are a
        contiguous ragged array [1]_: `impact_*` over `impact`, with `row_size` of them for each row, in the order of
        the grid. The attributes `method`, `effects`, `start`, `follow`, `ties` and `version` say how it was made. Tied
        parameters are variables over the grid where they differ, and derivatives are by the names that are not tied,
        one's own included, with what they do to those that are.

    Raises
    ------
    ParameterError
        If an argument is out of range, a tie cannot be read, has no value or one that its parameter cannot have, goes
        round in a circle, or is of a parameter that is given as well, or `effects` leaves out an effect that the
        parameters have.
    RuntimeError
        If a worker of the cluster has other kernels, or was lost too often with the same rows.

    Warns
    -----
    UnsolvedWarning
        For each status of a row that is not `ok`, with the number of rows and the remedy.

    References
    ----------
    .. [1] CF Conventions, section 9.3.3, contiguous ragged array representation.
    """
    if isinstance(over, Mapping) and are_with_units(exciter, over, x0, v0):
        rows = sweep(
            exciter,
            plain_mapping(exciter, over),
            x0=plain_values(exciter, "x0", x0),
            v0=plain_values(exciter, "v0", v0),
            harmonics=harmonics,
            follow=follow and (plain_name(follow[0]), follow[1]),
            outputs=outputs,
            accuracy=accuracy,
            effects=effects,
            client=client,
            patience=patience,
            ties=ties,
        )
        return to_physical(rows, exciter)
    given = over if client is None else computed_values(client, over)
    grid = grid_of(exciter, given, follow, ties)
    check_swept_start(given, x0, v0)
    start = check_corners(grid, x0, 0.0 if v0 is None else v0)
    solver = check_solver(harmonics, outputs, accuracy, patience)
    solve: Any = partial(solve_shard, grid, start=start, effects=effects, **solver)
    shards = [solve(0, grid.rows)] if client is None else solve_on_cluster(client, solve, grid)
    return warn_unsolved(assemble(shards, grid))


def grid_of(
    exciter: Exciter,
    over: Mapping[str, Any],
    follow: Follow = None,
    ties: Mapping[str, Any] | None = None,
) -> SweepGrid:
    """Return the grid of a sweep; ParameterError if `over`, `follow` or `ties` is not valid."""
    exciter, tied = ties_of_call(exciter, ties, over)
    values, followed = check_over(over, (*tied.own, *tied.expressions)), check_follow(over, follow)
    tied.check(stated_names(exciter), values, "over")
    grid = SweepGrid(values, followed, exciter.stated(), tied)
    given = {**exciter.numbers()._asdict(), **grid.shared, **grid.varied}
    exciter.check_frequency(
        [name for name in tied.expressions.keys() | values.keys() if np.any(given.get(name, 0.0))]
    )
    dampings = swept_dampings(
        exciter, {name: np.atleast_1d(given[name]) for name in (*values, *tied.parameters)}
    )
    shared = {name: value for name, value in exciter.stated().items() if name not in dampings}
    return SweepGrid(values, followed, shared, tied) if dampings else grid


def check_solver(
    harmonics: int, outputs: Sequence[str], accuracy: float | None, patience: int
) -> dict[str, Any]:
    """Return these arguments of `sweep` as options of `solve_blocks`; ParameterError if one is not valid."""
    return {
        "harmonics": check_whole("harmonics", harmonics, limits.HARMONICS),
        "outputs": check_outputs(outputs),
        "accuracy": None if accuracy is None else check_accuracy(accuracy),
        "limits": RowLimits(MAX_PERIODS, check_whole("patience", patience, limits.PATIENCE)),
    }
