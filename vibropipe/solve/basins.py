"""The function `basins`: which attractor each start of a grid settles on."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.physics.exciter import Exciter, ParameterError, number_within
from vibropipe.physics.start import start_at
from vibropipe.solve.attractor_set import AttractorSet
from vibropipe.solve.attractors import (
    STARTS,
    STARTS_LIMITS,
    attractor_dataset,
    scattered_starts,
)
from vibropipe.solve.checks import check_whole
from vibropipe.words.parameters import FRACTION
from vibropipe.words.vocabulary import describe

if TYPE_CHECKING:
    import xarray as xr


def basins(
    exciter: Exciter,
    x0: Any,
    v0: Any,
    phase: float = 0.0,
    harmonics: int = 6,
    starts: int = STARTS,
    progress: Callable[[int], None] | None = None,
) -> xr.Dataset:
    """Find the attractor of eqs. (5), (6) that the motion from each start of a grid settles on.

    The attractors are those of `attractors` and all that a start of the grid shows to be missing. Each start is
    marched by itself until it enters a neighbourhood of an orbit that no motion leaves [1]_, so the result does not
    depend on the number of threads.

    Parameters
    ----------
    exciter : Exciter
    x0, v0 : array_like
        Displacements, between the supports or on one, and velocities of the starts: increasing, one-dimensional. A
        start at rest within 4 ulps of a support is moved onto it.
    phase : float
        Phase of the force at the start, from 0 to 1, as a fraction of a forcing period: the motion starts at
        tau = phase * 2 pi/nu.
    harmonics : int
        Number of harmonics, from 1 to 1000.
    starts : int
        Number of scattered starts that look for attractors first, as for `attractors`.
    progress : callable, optional
        Called as progress(starts assigned).

    Returns
    -------
    xarray.Dataset
        attractor (x0, v0)
            `attractor_id` of the attractor, or -1: none was found.
        periods_to_attractor (x0, v0)
            Forcing periods until the motion was assigned to it.
        border (x0, v0)
            Whether one of the four neighbours settles on another attractor.
        basin_share, basin_share_low, basin_share_high (attractor_id)
            Share of the starts of the grid, with the 95 % confidence interval for as many random starts.

        and over `attractor_id` all that `attractors` returns.

    Raises
    ------
    ParameterError
        If a start is not finite or lies outside the supports, or an argument is out of range.

    Notes
    -----
    A start whose motion is chaotic before it settles reaches an attractor that depends on rounding; such starts have
    large `periods_to_attractor`.

    References
    ----------
    .. [1] G. Datseris, A. Wagemakers, Effortless estimation of basins of attraction, Chaos 32 (2022) 023104.
    """
    check_whole("starts", starts, STARTS_LIMITS)
    turn = number_within("phase", phase, FRACTION) % 1.0
    xs, vs = check_starts(exciter, x0, v0)
    found = AttractorSet(exciter)
    found.settle(scattered_starts(exciter, starts))
    grid = grid_starts(exciter, xs, vs)
    owner, periods = found.settle(grid, turn, progress)
    text = f"{xs.size} x {vs.size} starts (x0, v0) at {turn:g} of a forcing period"
    dataset, numbers = attractor_dataset(found, owner, harmonics, text)
    shape, dims = (xs.size, vs.size), ("x0", "v0")
    attractor = numbers.reshape(shape)
    variables = {
        "attractor": (dims, attractor),
        "periods_to_attractor": (dims, periods.reshape(shape).astype(np.int32)),
        "border": (dims, border_starts(attractor).astype(np.int8)),
    }
    parameters = {name: ((), value) for name, value in exciter.stated().items()}
    coords = {**parameters, "start_phase": ((), turn), "x0": xs, "v0": vs}
    return describe(dataset.assign_coords(coords).assign(variables))


def check_starts(exciter: Exciter, x0: Any, v0: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return the displacements and velocities of a grid of starts as arrays, or raise a ParameterError."""
    arrays = []
    for name, values in (("x0", x0), ("v0", v0)):
        try:
            array = np.atleast_1d(np.asarray(values, dtype=float))
        except (TypeError, ValueError):
            array = np.empty(0)
        is_list = array.ndim == 1 and array.size > 0
        if not is_list or not np.isfinite(array).all() or not (np.diff(array) > 0).all():
            raise ParameterError(name, values, "a non-empty list of increasing finite numbers")
        arrays.append(array)
    for end in (arrays[0][0], arrays[0][-1]):
        exciter.check_start(end, 0.0)
    return arrays[0], arrays[1]


def grid_starts(exciter: Exciter, xs: Any, vs: Any) -> np.ndarray:
    """Return the starts (n, 2) of a grid, v0 running fastest; those within rounding of a support lie on it."""
    displacement = np.stack([start_at(exciter.l, exciter.delta, xs, v) for v in vs], axis=1)
    return np.stack([displacement, np.broadcast_to(vs, displacement.shape)], axis=2).reshape(-1, 2)


def border_starts(attractor: np.ndarray) -> np.ndarray:
    """Return which starts (x0, v0) have a neighbour in the grid with another attractor."""
    border = np.zeros(attractor.shape, bool)
    for axis in (0, 1):
        ahead = np.moveaxis(attractor, axis, 0)
        differs = ahead[1:] != ahead[:-1]
        on_axis = np.moveaxis(border, axis, 0)  # a view
        on_axis[1:] |= differs
        on_axis[:-1] |= differs
    return border
