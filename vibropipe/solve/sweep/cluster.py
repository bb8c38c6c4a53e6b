"""A sweep on a dask cluster: its shards are futures, scheduled by dask.

`distributed` solves a shard that is lost with its worker on another one, up to
`distributed.scheduler.allowed-failures` times (3 by default).
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.compiler import kernel_hash
from vibropipe.physics.exciter import ParameterError
from vibropipe.solve.sweep.sweep_grid import SweepGrid

if TYPE_CHECKING:
    import xarray as xr

# Shards for each thread of the cluster: a slow or lost worker delays an eighth of its share.
SHARDS_PER_THREAD = 8
# Rows of a shard: bounds the memory of a worker and the work lost with it. A longer chain is not divided.
MAX_ROWS = 8192
CLIENT = "a dask.distributed.Client that is not asynchronous"
INSTALL = "pip install 'vibropipe[dask]'"

# Not every threading layer of numba supports concurrent parallel regions: the tasks of a worker run one after the
# other, each on all of its threads.
_solve_lock = threading.Lock()


def solve_on_cluster(
    client: Any, solve: Callable[[int, int], xr.Dataset], grid: SweepGrid
) -> list[xr.Dataset]:
    """Solve the shards of a sweep on the workers of a dask cluster, and return them in order.

    client : dask.distributed.Client, checked by `check_client`
    solve : solve(row_start, row_stop) returns the dataset of a shard; it runs on a worker
    Raises RuntimeError if a worker has other kernels, or a shard was lost too often with its worker.
    """
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
    """Return the swept values with dask collections computed on the cluster, which may hold them."""
    check_client(client)
    from dask.base import is_dask_collection

    return {
        name: client.compute(values, sync=True) if is_dask_collection(values) else values
        for name, values in over.items()
    }


def check_client(client: Any) -> None:
    """Raise a ParameterError unless `client` is a synchronous dask client."""
    try:
        from distributed import Client
    except ImportError as error:
        got = f"{client!r}; dask.distributed is not installed: {INSTALL}"
        raise ParameterError("client", client, CLIENT, got=got) from error
    if not isinstance(client, Client) or client.asynchronous:
        raise ParameterError("client", client, CLIENT)


def _cuts(grid: SweepGrid, threads: int) -> list[int]:
    """Return the ends of shards: several for each thread, none longer than MAX_ROWS unless a chain is."""
    max_chains = max(1, MAX_ROWS // grid.chain_length)
    return grid.cuts(
        min(grid.chains, max(SHARDS_PER_THREAD * max(1, threads), -(-grid.chains // max_chains)))
    )


def _solve(
    row_start: int, row_stop: int, solve: Callable[[int, int], xr.Dataset], expected: str
) -> xr.Dataset:
    """Solve one shard, on a worker and on as many threads as the worker has."""
    import numba
    from distributed import get_worker

    worker = get_worker()
    if kernel_hash() != expected:
        raise RuntimeError(
            f"worker {worker.address} has other kernels ({kernel_hash()}) than the client ({expected}): "
            "install the same version of vibropipe on both"
        )
    with _solve_lock:
        available = int(numba.config.NUMBA_NUM_THREADS)  # type: ignore[attr-defined]
        numba.set_num_threads(int(np.clip(worker.state.nthreads, 1, available)))
        return solve(row_start, row_stop)
