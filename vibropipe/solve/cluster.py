"""A sweep spread over a dask cluster: its shards are futures, the scheduler is dask's own.

A shard lost with its worker is solved again by another one: `distributed` does that by itself, up to
`distributed.scheduler.allowed-failures` times (3, unless configured).
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.compiler import kernel_hash
from vibropipe.physics.exciter import ParameterError
from vibropipe.solve.sweep_grid import SweepGrid

if TYPE_CHECKING:
    import xarray as xr

SHARDS_PER_THREAD = 8
MAX_ROWS = 8192
CLIENT = "a dask.distributed.Client that is not asynchronous"
INSTALL = "pip install 'vibropipe[dask]'"

# Not every threading layer of numba bears two parallel regions at once: tasks of a worker take turns,
# each on all of its threads.
_solve_lock = threading.Lock()


def solve_on_cluster(
    client: Any, solve: Callable[[int, int], xr.Dataset], grid: SweepGrid
) -> list[xr.Dataset]:
    """Shards of a sweep, each `solve(row_start, row_stop)` on some worker of the dask cluster behind client.

    Raises ParameterError where client is no dask client, RuntimeError where a worker has another version of
    the kernels or was lost too often with the same shard.
    """
    check_client(client)
    from distributed import KilledWorker

    cuts = _cuts(grid, sum(client.nthreads().values()))
    futures = client.map(
        _solve, cuts[:-1], cuts[1:], solve=solve, expected=kernel_hash(), pure=False
    )
    try:
        return list(client.gather(futures))
    except KilledWorker as error:
        raise RuntimeError(
            f"shard abandoned: every worker that ran it was lost ({error}). See the worker logs; the usual cause "
            "is too little memory"
        ) from error
    finally:
        client.cancel(futures)


def computed_values(client: Any, over: Mapping[str, Any]) -> dict[str, Any]:
    """The swept values, those that are dask collections computed on the cluster that may hold them."""
    check_client(client)
    from dask.base import is_dask_collection

    return {
        name: client.compute(values, sync=True) if is_dask_collection(values) else values
        for name, values in over.items()
    }


def check_client(client: Any) -> None:
    """Raise ParameterError unless client is a dask client whose calls return when they are done."""
    try:
        from distributed import Client
    except ImportError as error:
        got = f"{client!r}; dask.distributed is not installed: {INSTALL}"
        raise ParameterError("client", client, CLIENT, got=got) from error
    if not isinstance(client, Client) or client.asynchronous:
        raise ParameterError("client", client, CLIENT)


def _cuts(grid: SweepGrid, threads: int) -> list[int]:
    """Ends of shards: some for each thread, so that a slow or lost worker holds up little."""
    most = max(1, MAX_ROWS // grid.chain_length)
    return grid.cuts(
        min(grid.chains, max(SHARDS_PER_THREAD * max(1, threads), -(-grid.chains // most)))
    )


def _solve(
    row_start: int, row_stop: int, solve: Callable[[int, int], xr.Dataset], expected: str
) -> xr.Dataset:
    """One shard, on a worker and on as many threads as the worker has."""
    import numba
    from distributed import get_worker

    worker = get_worker()
    if kernel_hash() != expected:
        raise RuntimeError(
            f"worker {worker.address} has other kernels ({kernel_hash()}) than the client ({expected}): "
            "install the same version of vibropipe on both"
        )
    with _solve_lock:
        there_are = int(numba.config.NUMBA_NUM_THREADS)  # type: ignore[attr-defined]
        numba.set_num_threads(int(np.clip(worker.state.nthreads, 1, there_are)))
        return solve(row_start, row_stop)
