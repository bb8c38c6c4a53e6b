"""Growth of time and memory with the number of points of a study: `python tests/benchmarks/growth.py`.

The sweep nu x f over [0.3, 3] x [0.05, 2] (l = 0.5, h = 0.2, R = 0.7) is solved, joined and queried at 1e3 to 1e6
points, split into shards as in a workflow. Each shard, the join and the query run in a process of their own, whose peak
memory is recorded. Results: `results/growth/growth.nc`, `.svg`, `.pdf` and `.png`.
"""

from __future__ import annotations

import math
import multiprocessing
import os
import shutil
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

if TYPE_CHECKING:
    import xarray as xr

    from vibropipe.scenes.sweep.keys import SweepScene

MAX_POINTS = 10**8
POINTS = (1_000, 10_000, 100_000, 1_000_000)
THREADS = (1, 2)
PARAMETERS = {"l": 0.5, "h": 0.2, "R1": 0.7, "R2": 0.7}
SPAN = {"nu": (0.3, 3.0), "f": (0.05, 2.0)}
SCENE = "map"
# A short shard is solved repeatedly, up to this number of rows in all and this number of rounds.
ROWS_SOLVED, ROUNDS = 300_000, 20
MB = 1e6
# Units and long name of each quantity that is measured.
QUANTITIES = {
    "points": ("1", "number of points"),
    "threads": ("1", "number of threads"),
    "time_per_point": ("ms", "time per point by the clock"),
    "work_per_point": ("ms", "time per point of all threads together"),
    "storing_per_point": ("ms", "time per point with the results stored"),
    "solving_memory": ("MB", "largest memory of a job that solves"),
    "joining_memory": ("MB", "largest memory of the join"),
    "query_memory": ("MB", "largest memory of a query"),
    "slice_time": ("s", "time to open the joined file and query a slice"),
    "joining_rate": ("MB s-1", "rate of writing the joined file"),
    "copying_rate": ("MB s-1", "rate of copying the joined file"),
}


class Usage(NamedTuple):
    """Resources that a call used.

    `seconds` is wall time, `work` the CPU time of all threads (s), `memory` the peak memory of the process (bytes) and
    `storing` the wall time of solving and writing the results (s).
    """

    seconds: float
    work: float
    memory: float
    storing: float = 0.0


def sweep_of(points: int) -> SweepScene:
    """Return the scene of a sweep with this number of points.

    Points lie in the middles of equal cells, so that every number of points samples the same mixture of motions.
    """
    from vibropipe.study import parse_study

    rows = next(n for n in range(math.isqrt(points), 0, -1) if points % n == 0)
    over = {
        name: (low + (np.arange(count) + 0.5) / count * (high - low)).tolist()
        for (name, (low, high)), count in zip(SPAN.items(), (rows, points // rows), strict=True)
    }
    scenes = {SCENE: {"kind": "sweep", "over": over}}
    study = {"title": f"{points} points", "exciter": PARAMETERS, "scenes": scenes}
    scene: SweepScene = parse_study(study).scene(SCENE)
    return scene


def measure_growth(
    folder: Path,
    points: Sequence[int] = POINTS,
    threads: Sequence[int] = THREADS,
    on_progress: Callable[[str], None] | None = None,
) -> xr.Dataset:
    """Solve, join and query sweeps of increasing size.

    Parameters
    ----------
    folder : Path
        Directory for temporary files.
    points : sequence of int
        Numbers of points.
    threads : sequence of int
        Numbers of threads that solve each sweep.
    on_progress : callable, optional
        Called with a line of text after each sweep.

    Returns
    -------
    xarray.Dataset
        `time_per_point`, `work_per_point` and `storing_per_point` (ms) over (points, threads); `solving_memory`,
        `joining_memory`, `query_memory` (MB), `slice_time` (s), `joining_rate` and `copying_rate` (MB/s) over points.
        Times exclude starting processes and loading kernels.
    """
    import xarray as xr

    table: dict[str, list[Any]] = {}
    for count in points:
        directory = folder / str(count)
        solved = _solve_all(directory, count, threads)
        joined, size = run_in_subprocess(join_shards, directory, count)
        copied = run_in_subprocess(copy_file, directory)
        jobs = np.array(solved)  # (threads, shards, fields of Usage)
        times = 1e3 * jobs.sum(axis=1) / count
        values = {
            "time_per_point": times[:, 0],
            "work_per_point": times[:, 1],
            "storing_per_point": times[:, 3],
            "solving_memory": jobs[..., 2].max() / MB,
            "joining_memory": joined.memory / MB,
            "query_memory": run_in_subprocess(query, directory).memory / MB,
            "slice_time": run_in_subprocess(query_slice, directory).seconds,
            "joining_rate": size / joined.seconds / MB,
            "copying_rate": size / copied.seconds / MB,
        }
        for name, value in values.items():
            table.setdefault(name, []).append(value)
        if on_progress is not None:
            on_progress(
                f"{count} points: " + ", ".join(f"{k} {np.round(v, 3)}" for k, v in values.items())
            )
        shutil.rmtree(directory)
    dims = ("points", "threads")
    measured = xr.Dataset(
        {name: (dims[: np.ndim(values)], values) for name, values in table.items()},
        {"points": np.asarray(points), "threads": np.asarray(threads)},
    )
    for name, variable in measured.variables.items():
        units, text = QUANTITIES[str(name)]
        variable.attrs |= {"units": units, "long_name": text}
    return measured


def _solve_all(directory: Path, points: int, threads: Sequence[int]) -> list[list[Usage]]:
    """Return the usage of each shard for each number of threads, alternating so that conditions are equal."""
    from vibropipe.jobs.plan import plan_scene

    usages: list[list[Usage]] = [[] for _ in threads]
    shards = plan_scene(sweep_of(points)).shards
    for shard in range(1, shards + 1):
        for count, jobs in zip(threads, usages, strict=True):
            jobs.append(run_in_subprocess(solve_shard, directory, points, shard, shards, count))
    return usages


def solve_shard(directory: Path, points: int, shard: int, shards: int, threads: int) -> Usage:
    """Solve one shard, then solve and store it; short shards repeatedly, of which the fastest round counts.

    A study of one shard is stored on its grid by the job that solves it.
    """
    import numba

    from vibropipe.scenes.sweep.cut import row_range, store
    from vibropipe.scenes.sweep.keys import block_rows
    from vibropipe.scenes.sweep.solve import solve_in_blocks

    numba.set_num_threads(threads)
    scene, path = sweep_of(points), directory / "shards" / f"{shard:04d}.nc"
    start, stop = row_range(scene, shard, shards)
    # load kernels and libraries before the clock starts
    store(sweep_of(4), path, {}, (1, 1))
    rounds = range(max(1, min(ROUNDS, ROWS_SOLVED // (stop - start))))

    def solve_all() -> None:
        for _block in solve_in_blocks(scene, range(start, stop), block_rows(scene)):
            pass

    target, cut = (directory / "whole.nc", None) if shards == 1 else (path, (shard, shards))
    storing = [_timed(partial(store, scene, target, {}, cut)) for _ in rounds]
    solving = [_timed(solve_all) for _ in rounds]
    if shards == 1:
        store(scene, path, {}, (1, 1))
    # a job solves and stores once: memory that further rounds leave behind is no part of it
    stored = min(usage.seconds for usage in storing)
    return min(solving)._replace(memory=storing[0].memory, storing=stored)


def join_shards(directory: Path, points: int) -> tuple[Usage, int]:
    """Join all shards; return the usage and the size of the file in bytes."""
    import netCDF4  # noqa: F401 (load it before the clock starts)

    from vibropipe.store import join

    target, grid = directory / "joined" / f"{SCENE}.nc", sweep_of(points).row_grid()
    usage = _timed(lambda: join(sorted((directory / "shards").iterdir()), target, grid))
    return usage, target.stat().st_size


def copy_file(directory: Path) -> Usage:
    """Copy the joined file to the disk: a lower bound of the time to write it."""

    def copy() -> None:
        joined = directory / "joined" / f"{SCENE}.nc"
        with joined.open("rb") as source, (directory / "copy").open("wb") as target:
            shutil.copyfileobj(source, target, 1 << 20)
            target.flush()
            os.fsync(target.fileno())

    return _timed(copy)


def query(directory: Path) -> Usage:
    """Query the joined file: a slice, a maximum, and the lowest f with a period-2 orbit."""
    from vibropipe.store import open_study

    def run_queries() -> None:
        with open_study(directory / "joined") as tree:
            rows = tree[SCENE]
            amplitude = rows["displacement_amplitude"].sel(f=1.0, method="nearest")
            amplitude.sel(harmonic=1).max().compute()
            struck_once = (rows["impacts_per_orbit"] == 1).all("support")
            wanted = (rows["period_multiple"] == 1) & struck_once & (rows["stable"] == 1)
            rows["impact_velocity_max"].max("support").where(wanted).max().compute()
            rows["f"].where(rows["period_multiple"] == 2).min("f").compute()

    return _timed(run_queries)


def query_slice(directory: Path) -> Usage:
    """Open the joined file and find the largest amplitude of a slice."""
    from vibropipe.store import open_study

    def run_query() -> None:
        with open_study(directory / "joined") as tree:
            amplitude = tree[SCENE]["displacement_amplitude"].sel(f=1.0, method="nearest")
            amplitude.sel(harmonic=1).max().compute()

    run_query()  # loads libraries; the file itself is in the memory of the machine
    return _timed(run_query)


def _timed(call: Callable[[], object]) -> Usage:
    """Call a function and return its usage."""
    start, start_work = time.perf_counter(), time.process_time()
    call()
    return Usage(time.perf_counter() - start, time.process_time() - start_work, peak_memory())


def peak_memory() -> float:
    """Return the peak memory of this process in bytes."""
    try:
        text = Path("/proc/self/status").read_text(encoding="ascii")
    except OSError:
        import resource

        unit = 1 if sys.platform == "darwin" else 1024
        return float(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit)
    # getrusage would include the peak of the parent process before the fork
    return 1024.0 * next(int(line.split()[1]) for line in text.splitlines() if "VmHWM" in line)


def run_in_subprocess(function: Callable[..., Any], *arguments: Any) -> Any:
    """Call a function in a process of its own and return its result."""
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        return pool.apply(function, arguments)


def main(points: Sequence[int], output: Path) -> None:
    """Measure, print each result, and draw the figure."""
    from growth_figure import draw_growth

    from vibropipe.figures.style import house_style, save, save_as
    from vibropipe.store import save as save_dataset

    with tempfile.TemporaryDirectory() as scratch:
        measured = measure_growth(Path(scratch), points, on_progress=print)
    save_dataset(measured, output / "growth.nc")
    with house_style():
        figure = draw_growth(measured)
        save(figure, output, "growth")
        save_as(figure, output / "growth.png")


def parse_points(arguments: Sequence[str]) -> Sequence[int]:
    """Return the numbers of points given on the command line, such as 1e4; raise SystemExit if one is invalid."""
    try:
        points = [int(float(word)) for word in arguments]
    except (ValueError, OverflowError):
        points = [0]
    if not all(1 <= count <= MAX_POINTS for count in points):
        text = " ".join(arguments)
        raise SystemExit(f"points: must be numbers from 1 to {MAX_POINTS:.0e}, got {text}")
    return points or POINTS


if __name__ == "__main__":
    main(parse_points(sys.argv[1:]), Path("results/growth"))
