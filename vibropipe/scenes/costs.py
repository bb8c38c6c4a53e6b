"""What scenes cost: planned from their keys alone, estimated by samples solved on this machine."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray

from vibropipe.compiler.cache import cache_root
from vibropipe.scenes.keys.base import BaseScene
from vibropipe.scenes.keys.grids import ValueGrid

# Seconds in which a job loads libraries and compiled kernels, at least.
MIN_LOAD_SECONDS = 0.7
ROW_BYTES = 80
IMPACT_BYTES = 21
USUAL_IMPACTS = 4
PHASE_SAMPLES = 256
# Heads of some thirty variables are most of a small file.
HEAD_BYTES = 9e4


class PlanError(ValueError):
    """A scene cannot be cut into shards as requested, or a run has a wrong setting."""


@dataclass(frozen=True)
class Work:
    """What a scene comes to, by its keys alone, so that every machine cuts it alike.

    size: in words; rows: steady states, or points of a curve, or 1 for a motion; seconds: rough work of one
    core; bytes: in the dataset before compression; pieces: into how many parts it can be cut; is_parallel:
    whether threads share it.
    """

    size: str
    rows: int
    method: str
    outputs: tuple[str, ...]
    seconds: float
    bytes: float
    pieces: int = 1
    is_parallel: bool = False


@dataclass(frozen=True)
class Estimate:
    """What a scene will come to on this machine: seconds of one core, seconds to load the kernels once per job,
    bytes on disk, whether threads share the work, and the method chosen where an accuracy was asked."""

    core_seconds: float
    load_seconds: float
    bytes: float
    parallel: bool
    method: str

    def seconds(self, threads: int = 1, share: float = 1.0) -> float:
        """Seconds of one job with so many threads that does such a share of the scene."""
        return self.load_seconds + share * self.core_seconds / (threads if self.parallel else 1)


@dataclass
class Sampler:
    """Solves samples of scenes on one thread and measures their seconds and bytes.

    budget: seconds of one core that the samples of a scene may take; loads: seconds to load kernels, by what
    they do; file: the dataset of the sample solved last.
    """

    budget: float
    file: Path
    loads: dict[str, float] = field(default_factory=dict)

    def solved(self, sample: BaseScene) -> float:
        """Solve a sample into a file; return the seconds of this process alone: others may be at work."""
        from vibropipe.scenes.registry import kind_of
        from vibropipe.store import write

        begin = time.process_time()
        write(kind_of(sample).solve(sample), self.file)
        return time.process_time() - begin

    def warm(self, small: BaseScene, kernels: str) -> tuple[float, float]:
        """Solve a small sample twice; return the seconds of the second, and those to load what it calls.

        Scenes of one name in `kernels` load the same.
        """
        compiled = compiled_kernels()
        first, again = self.solved(small), self.solved(small)
        # What had to be compiled will be there for the jobs; what was loaded for a scene before, will not.
        measured = first - again if compiled_kernels() == compiled else 0.0
        return again, self.loads.setdefault(kernels, max(measured, MIN_LOAD_SECONDS))

    @property
    def bytes(self) -> int:
        """Size of the file of the sample solved last."""
        return self.file.stat().st_size


@contextmanager
def sampling() -> Iterator[Sampler]:
    """Give a sampler, with one thread for kernels inside this."""
    import numba

    before = numba.get_num_threads()
    numba.set_num_threads(1)
    try:
        with TemporaryDirectory(prefix="vibropipe-sample-") as folder:
            yield Sampler(0.0, Path(folder) / "sample.nc")
    finally:
        numba.set_num_threads(before)


def compiled_kernels() -> int:
    """How many kernels of this version lie compiled on this machine."""
    return sum(1 for _ in cache_root().rglob("*.nbc"))


def grid_size(scene: BaseScene) -> str:
    """Write the grids of a scene as a product: 200 nu x 3 f."""
    return " x ".join(f"{grid.size} {name}" for name, grid in scene.grids().items())


def steady_bytes(outputs: Iterable[str], harmonics: int, impacts: float = USUAL_IMPACTS) -> float:
    """Return the bytes of one steady state with these outputs and so many impacts."""
    costs = {
        "harmonics": 2 * 8 + 4 * 8 * harmonics,
        "impacts": 4 + 2 * 8 + impacts * IMPACT_BYTES,
        "stability": 2 * 16 + 1,
        "motion": 2 * 8 * PHASE_SAMPLES,
        "energy": 5 * 8,
    }
    return ROW_BYTES + sum(costs[output] for output in outputs)


def thinned(values: NDArray[np.float64], most: int) -> ValueGrid:
    """Return at most `most` of the values, the first and the last among them."""
    places = np.unique(np.linspace(0, values.size - 1, most).round().astype(int))
    return ValueGrid(values=values[places].tolist())


def planned(work: Work, core_seconds: float | None = None) -> Estimate:
    """Return an estimate by the plan of a scene, where no sample says more."""
    seconds = work.seconds if core_seconds is None else core_seconds
    return Estimate(seconds, MIN_LOAD_SECONDS, work.bytes, work.is_parallel, work.method)
