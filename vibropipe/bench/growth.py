"""How time and memory grow with the number of points of a study: `python -m vibropipe.bench.growth`.

The sweep nu x f over [0.3, 3] x [0.05, 2] (l = 0.5, h = 0.2, R = 0.7) is solved, joined and queried at 1e3 to
1e6 points, as a workflow does it: cut as its plan says; each shard, the join and the query in a process of its
own, whose largest memory is read in the end. Writes `results/growth/growth.nc`, `.svg`, `.pdf` and `.png`.
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
# A shard is solved so often that it comes to so many rows, this often at most.
ROWS_SOLVED, ROUNDS = 300_000, 20
MB = 1e6


class Usage(NamedTuple):
    """What a process needed: seconds by the clock and of all its threads, its largest memory in bytes, and the
    seconds by the clock of doing it again with the results stored."""

    seconds: float
    work: float
    memory: float
    storing: float = 0.0


def sweep_of(points: int) -> SweepScene:
    """The sweep over so many points, in the middles of equal cells: every number of points then samples the
    same mixture of motions."""
    from vibropipe.study import parse_study

    fewer = next(n for n in range(math.isqrt(points), 0, -1) if points % n == 0)
    over = {
        name: (low + (np.arange(count) + 0.5) / count * (high - low)).tolist()
        for (name, (low, high)), count in zip(SPAN.items(), (fewer, points // fewer), strict=True)
    }
    scenes = {SCENE: {"kind": "sweep", "over": over}}
    study = {"title": f"{points} points", "exciter": PARAMETERS, "scenes": scenes}
    scene: SweepScene = parse_study(study).scene(SCENE)
    return scene


def measure_growth(
    folder: Path,
    points: Sequence[int] = POINTS,
    threads: Sequence[int] = THREADS,
    say: Callable[[str], None] | None = None,
) -> xr.Dataset:
    """Solve, join and query studies of so many points.

    Parameters
    ----------
    folder : Path
        Where the files of a study stand until it is measured.
    points : sequence of int
        Numbers of points of the studies.
    threads : sequence of int
        Numbers of threads that solve each.
    say : callable, optional
        Told a line of text after each study.

    Returns
    -------
    xarray.Dataset
        `time_per_point`, `work_per_point` and `storing_per_point` (ms) over (points, threads); `solving_memory`,
        `joining_memory`, `query_memory` (MB), `joining_rate` and `copying_rate` (MB/s) over points. Times leave out
        the start of a process and the loading of its kernels.
    """
    import xarray as xr

    from vibropipe.words.vocabulary import describe

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
            "joining_rate": size / joined.seconds / MB,
            "copying_rate": size / copied.seconds / MB,
        }
        for name, value in values.items():
            table.setdefault(name, []).append(value)
        if say is not None:
            say(f"{count} points: " + ", ".join(f"{k} {np.round(v, 3)}" for k, v in values.items()))
        shutil.rmtree(directory)
    dims = ("points", "threads")
    return describe(
        xr.Dataset(
            {name: (dims[: np.ndim(values)], values) for name, values in table.items()},
            {"points": np.asarray(points), "threads": np.asarray(threads)},
        )
    )


def _solve_all(directory: Path, points: int, threads: Sequence[int]) -> list[list[Usage]]:
    """What each shard took, for each number of threads; all in turn, under the same conditions."""
    from vibropipe.jobs.plan import plan_scene

    usages: list[list[Usage]] = [[] for _ in threads]
    shards = plan_scene(sweep_of(points)).shards
    for shard in range(1, shards + 1):
        for count, jobs in zip(threads, usages, strict=True):
            jobs.append(run_in_subprocess(solve_shard, directory, points, shard, shards, count))
    return usages


def solve_shard(directory: Path, points: int, shard: int, shards: int, threads: int) -> Usage:
    """Solve one shard of some, and again into its file; a short one some times, of which the shortest counts.

    A study of one shard is stored on its grid by the job that solves it.
    """
    import numba

    from vibropipe.scenes.sweep.cut import row_range, store
    from vibropipe.scenes.sweep.plan import block_rows
    from vibropipe.scenes.sweep.solve import solve_in_blocks

    numba.set_num_threads(threads)
    scene, path = sweep_of(points), directory / "shards" / f"{shard:04d}.nc"
    start, stop = row_range(scene, shard, shards)
    # kernels and libraries are loaded before the clock starts
    store(sweep_of(4), path, {}, (1, 1))
    rounds = range(max(1, min(ROUNDS, ROWS_SOLVED // (stop - start))))

    def solve_all() -> None:
        for _block in solve_in_blocks(scene, start, stop, block_rows(scene)):
            pass

    solving = [_timed(solve_all) for _ in rounds]
    target, cut = (directory / "whole.nc", None) if shards == 1 else (path, (shard, shards))
    storing = [_timed(partial(store, scene, target, {}, cut)).seconds for _ in rounds]
    memory = peak_memory()
    if shards == 1:
        store(scene, path, {}, (1, 1))
    return min(solving)._replace(memory=memory, storing=min(storing))


def join_shards(directory: Path, points: int) -> tuple[Usage, int]:
    """Join all shards; also returns the bytes of the file."""
    import netCDF4  # noqa: F401 (loaded before the clock starts)

    from vibropipe.scenes.sweep.plan import sweep_grid
    from vibropipe.store import join

    target, grid = directory / "joined" / f"{SCENE}.nc", sweep_grid(sweep_of(points))
    took = _timed(lambda: join(sorted((directory / "shards").iterdir()), target, grid))
    return took, target.stat().st_size


def copy_file(directory: Path) -> Usage:
    """Copy the joined file, to the disk: what writing so many bytes takes at least."""

    def copy() -> None:
        joined = directory / "joined" / f"{SCENE}.nc"
        with joined.open("rb") as source, (directory / "copy").open("wb") as target:
            shutil.copyfileobj(source, target, 1 << 20)
            target.flush()
            os.fsync(target.fileno())

    return _timed(copy)


def query(directory: Path) -> Usage:
    """Ask the joined file for a slice, a largest value and where period doubling begins."""
    from vibropipe.store import open_study

    def ask() -> None:
        with open_study(directory / "joined") as tree:
            rows = tree[SCENE]
            amplitude = rows["displacement_amplitude"].sel(f=1.0, method="nearest")
            amplitude.sel(harmonic=1).max().compute()
            struck_once = (rows["impacts_per_orbit"] == 1).all("support")
            wanted = (rows["period_multiple"] == 1) & struck_once & (rows["stable"] == 1)
            rows["impact_velocity_max"].max("support").where(wanted).max().compute()
            rows["f"].where(rows["period_multiple"] == 2).min("f").compute()

    return _timed(ask)


def _timed(call: Callable[[], object]) -> Usage:
    """Call a function; what this process needed for it."""
    begin, worked = time.perf_counter(), time.process_time()
    call()
    return Usage(time.perf_counter() - begin, time.process_time() - worked, peak_memory())


def peak_memory() -> float:
    """The largest memory this process has held, in bytes."""
    try:
        text = Path("/proc/self/status").read_text(encoding="ascii")
    except OSError:
        import resource

        unit = 1 if sys.platform == "darwin" else 1024
        return float(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit)
    # unlike getrusage it knows nothing of the process this one was forked from
    return 1024.0 * next(int(line.split()[1]) for line in text.splitlines() if "VmHWM" in line)


def run_in_subprocess(function: Callable[..., Any], *arguments: Any) -> Any:
    """Call a function in a process of its own."""
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        return pool.apply(function, arguments)


def main(points: Sequence[int], output: Path) -> None:
    """Measure, print the numbers as they come, and draw them."""
    from vibropipe.figures.growth import draw_growth
    from vibropipe.figures.style import house_style, save, save_as
    from vibropipe.store import write

    with tempfile.TemporaryDirectory() as scratch:
        measured = measure_growth(Path(scratch), points, say=print)
    write(measured, output / "growth.nc")
    with house_style():
        figure = draw_growth(measured)
        save(figure, output, "growth")
        save_as(figure, output / "growth.png")


def parse_points(words: Sequence[str]) -> Sequence[int]:
    """The numbers of points asked for on the command line, such as 1e4; SystemExit where one is none."""
    try:
        points = [int(float(word)) for word in words]
    except (ValueError, OverflowError):
        points = [0]
    if not all(1 <= count <= MAX_POINTS for count in points):
        must = f"must be numbers from 1 to {MAX_POINTS:.0e}"
        raise SystemExit(f"points: {must}, got {' '.join(words)}")
    return points or POINTS


if __name__ == "__main__":
    main(parse_points(sys.argv[1:]), Path("results/growth"))
