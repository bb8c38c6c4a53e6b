"""A sweep on a dask cluster equals the local sweep bit for bit, even if workers are lost."""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from collections.abc import Iterator
from typing import Any

import dask.array as da
import numpy as np
import pytest
import xarray as xr
from distributed import Client, LocalCluster

import vibropipe as vp
from vibropipe.solve.sweep import cluster
from vibropipe.solve.sweep.sweep_grid import SweepGrid

EXCITER = vp.Exciter(l=0.5, h=0.2, R1=0.7, R2=0.7)
OVER = {"f": np.linspace(0.2, 2.0, 40), "nu": np.linspace(0.4, 1.4, 100)}


@pytest.fixture(scope="module")
def client() -> Iterator[Client]:
    """Return a client of two worker processes of one thread each; a lost one is restarted."""
    with (
        LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as workers,
        Client(workers) as connected,
    ):
        yield connected


def identical(one: xr.Dataset, other: xr.Dataset) -> None:
    """Assert that names, attributes and bytes are the same."""
    xr.testing.assert_identical(one, other)
    for name, variable in one.variables.items():
        assert variable.values.tobytes() == other.variables[name].values.tobytes(), name


def shards_done(dask_scheduler: Any) -> int:
    return sum(
        task.state == "memory" and str(key).startswith("_solve")
        for key, task in dask_scheduler.tasks.items()
    )


def kill_one(client: Client, killed: list[int]) -> None:
    """Wait until some shards are solved, then kill the worker that holds most of them."""
    while client.run_on_scheduler(shards_done) < 4:
        time.sleep(0.02)
    held = client.has_what()
    address = max(held, key=lambda worker: len(held[worker]))
    process = client.run(os.getpid, workers=[address])[address]
    killed.append(client.run_on_scheduler(shards_done))
    os.kill(process, signal.SIGKILL)


@pytest.mark.slow
def test_a_worker_killed_half_way_changes_nothing(client: Client) -> None:
    local = vp.sweep(EXCITER, OVER)
    killed: list[int] = []
    with Client(client.scheduler.address) as watching:
        killer = threading.Thread(target=kill_one, args=(watching, killed))
        killer.start()
        spread = vp.sweep(EXCITER, OVER, client=client)
        killer.join()
    shards = len(cluster._cuts(SweepGrid(OVER), 2)) - 1
    assert 4 <= killed[0] < shards  # the sweep was under way
    identical(local, spread)


@pytest.mark.slow
def test_dask_arrays_and_followed_chains(client: Client) -> None:
    over = {"nu": OVER["nu"][:9], "f": OVER["f"][:5]}
    options = {"follow": ("nu", "down"), "outputs": ("harmonics", "energy"), "harmonics": 2}
    local = vp.sweep(EXCITER, over, 0.1, -0.2, **options)
    arrays = {name: da.from_array(values, chunks=4) for name, values in over.items()}
    identical(local, vp.sweep(EXCITER, arrays, 0.1, -0.2, **options))
    identical(local, vp.sweep(EXCITER, arrays, 0.1, -0.2, **options, client=client))
    arrays["nu"] = client.persist(arrays["nu"])
    options["follow"] = ("nu", "both")
    local = vp.sweep(EXCITER, over, 0.1, -0.2, **options)
    identical(local, vp.sweep(EXCITER, arrays, 0.1, -0.2, **options, client=client))


@pytest.mark.parametrize(
    "over",
    [pytest.param(None, marks=pytest.mark.slow), {"nu": [1.2, 3.48]}],
    ids=["one exciter", "over nu"],
)
def test_basins(client: Client, over: dict[str, list[float]] | None) -> None:
    exciter = vp.Exciter(l=0.5, nu=3.48, f=0.7, h=0.05, R1=0.8, R2=0.8)
    x0, v0 = np.linspace(-0.5, 0.5, 19), np.linspace(-2, 2, 23)
    local = vp.basins(exciter, x0, v0, 0.3, starts=40, over=over)
    lazy = da.from_array(v0, chunks=4)
    identical(local, vp.basins(exciter, x0, lazy, 0.3, starts=40, over=over, client=client))


def test_a_mistake_is_named_as_without_a_cluster(client: Client) -> None:
    with pytest.raises(vp.ParameterError, match=r"R1: must be .*, got 1\.5"):
        vp.sweep(EXCITER, {"R1": [0.5, 1.5]}, client=client)


def test_a_worker_with_other_kernels_is_refused(client: Client) -> None:
    futures = client.map(cluster._solve, [0], [1], solve=int, expected="0123", pure=False)
    with pytest.raises(RuntimeError, match=r"has other kernels .* install the same version"):
        client.gather(futures)


def test_what_is_no_client_is_refused() -> None:
    with pytest.raises(
        vp.ParameterError, match=r"client: must be a dask\.distributed\.Client .*, got 'tcp://"
    ):
        vp.sweep(EXCITER, OVER, client="tcp://127.0.0.1:8786")


def test_without_distributed_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(vp.ParameterError, match=r"not installed: pip install 'vibropipe\[dask\]'"):
        vp.sweep(EXCITER, OVER, client=object())


@pytest.mark.parametrize("rows", [1, 7, 100, 100_000])
@pytest.mark.parametrize("chain", [1, 5, 20_000])
def test_cuts_are_of_whole_chains_and_of_bounded_length(rows: int, chain: int) -> None:
    rows *= chain
    over = {"nu": np.arange(chain), "f": np.arange(rows // chain)}
    cuts = cluster._cuts(SweepGrid(over, ("nu", "up")), 2)
    assert cuts[0] == 0
    assert cuts[-1] == rows
    sizes = np.diff(cuts)
    assert (sizes > 0).all()
    assert (sizes % chain == 0).all()
    assert sizes.max() <= max(cluster.MAX_ROWS, chain)
