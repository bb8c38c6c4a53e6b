"""Cost of scenes: planned from their keys, and estimated from samples solved on this machine."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vibropipe.compiler.cache import cache_root
from vibropipe.physics.effects import ALL_EFFECTS, Effects
from vibropipe.scenes.keys.base import BaseScene
from vibropipe.scenes.keys.grids import ValueGrid
from vibropipe.solve.physical import convert
from vibropipe.words.vocabulary import physical_name, physical_quantity

# Least seconds in which a job loads libraries and compiled kernels.
MIN_LOAD_SECONDS = 0.7
# Bytes of a row without outputs, of an impact, and of the error of a number; usual impacts and samples of an orbit.
ROW_BYTES = 96
IMPACT_BYTES = 21
ERROR_BYTES = 4
# Numbers of a contact with a soft support; a row has the largest of each but the velocity after it.
CONTACT_NUMBERS = 4
USUAL_IMPACTS = 4
PHASE_SAMPLES = 256
# Subharmonics per harmonic, and sections of a row.
SUBHARMONICS = 4
VISITS = 64
# Bytes of the headers of some thirty variables, most of a small file.
HEAD_BYTES = 9e4


class PlanError(ValueError):
    """A scene cannot be cut into shards as requested, or a run has a wrong setting."""


@dataclass(frozen=True)
class Work:
    """Planned work of a scene, from its keys alone, so that every machine cuts it into the same shards.

    Attributes
    ----------
    size : str
        Grids of the scene as text.
    rows : int
        Number of steady states or of points of a curve; 1 for a motion.
    method : str
        Method by name.
    outputs : tuple of str
        Stored outputs.
    seconds : float
        Rough seconds on one core.
    bytes : float
        Bytes of the dataset before compression.
    pieces : int
        Largest number of shards.
    is_parallel : bool
        Whether threads share the work.
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
    """Estimated work of a scene on this machine.

    Attributes
    ----------
    core_seconds, load_seconds : float
        Seconds on one core, and seconds in which each job loads the kernels.
    bytes : float
        Bytes on disk.
    parallel : bool
        Whether threads share the work.
    method : str
        Method by name, as selected if the scene requests an accuracy.
    """

    core_seconds: float
    load_seconds: float
    bytes: float
    parallel: bool
    method: str

    def seconds(self, threads: int = 1, share: float = 1.0) -> float:
        """Return the seconds of a job that solves a share of the scene on some threads."""
        return self.load_seconds + share * self.core_seconds / (threads if self.parallel else 1)


@dataclass
class Sampler:
    """Solves samples of scenes on one thread and measures their seconds and bytes.

    Attributes
    ----------
    budget : float
        Seconds that the samples of a scene may take.
    file : Path
        Dataset of the last sample.
    solve_to_file : callable
        Called as `solve_to_file(scene, file)`.
    loads : dict
        Seconds to load kernels, by name of the set of kernels.
    """

    budget: float
    file: Path
    solve_to_file: Callable[[Any, Path], None]
    loads: dict[str, float] = field(default_factory=dict)

    def solved(self, sample: BaseScene) -> float:
        """Solve a sample into a file and return the CPU seconds of this process, since others may run beside it."""
        begin = time.process_time()
        self.solve_to_file(sample, self.file)
        return time.process_time() - begin

    def warm(self, small: BaseScene, kernels: str) -> tuple[float, float]:
        """Solve a small sample twice and return the seconds of the second run and of loading its kernels.

        `kernels` names the set of kernels; scenes with the same name load the same set.
        """
        compiled = compiled_kernels()
        first, again = self.solved(small), self.solved(small)
        # Jobs load kernels from the cache, so seconds of compiling do not count.
        measured = first - again if compiled_kernels() == compiled else 0.0
        return again, self.loads.setdefault(kernels, max(measured, MIN_LOAD_SECONDS))

    @property
    def bytes(self) -> int:
        """Size of the file of the last sample."""
        return self.file.stat().st_size


@contextmanager
def sampling(solve_to_file: Callable[[Any, Path], None]) -> Iterator[Sampler]:
    """Yield a sampler; kernels run on one thread inside."""
    import numba

    before = numba.get_num_threads()
    numba.set_num_threads(1)
    try:
        with TemporaryDirectory(prefix="vibropipe-sample-") as folder:
            yield Sampler(0.0, Path(folder) / "sample.nc", solve_to_file)
    finally:
        numba.set_num_threads(before)


def compiled_kernels() -> int:
    """Return the number of compiled kernels of this version in the cache."""
    return sum(1 for _ in cache_root().rglob("*.nbc"))


def grid_size(scene: BaseScene) -> str:
    """Write the sizes of the grids as a product: 200 nu x 3 f."""
    return " x ".join(
        f"{grid.size} {stored_name(scene, name)}" for name, grid in scene.grids().items()
    )


def stored_name(scene: BaseScene, name: str) -> str:
    """Return the name of a parameter in the data of a scene, which are in SI if its study has units."""
    return name if scene.mass_and_stiffness is None else physical_name(name)


def stored_values(scene: BaseScene, name: str, values: Iterable[float]) -> tuple[list[str], str]:
    """Return values of a parameter in the units of the study, as texts, and the unit with a blank before it."""
    numbers, unit = np.array([*values]), "1"
    if scene.mass_and_stiffness is not None:
        m, C = scene.mass_and_stiffness
        numbers = convert(name, numbers, {"m": m, "C": C})
        unit = physical_quantity(name).units
    return scene.units_shown.texts(stored_name(scene, name), numbers, unit)


def steady_bytes(
    outputs: Iterable[str],
    harmonics: int,
    impacts: float = USUAL_IMPACTS,
    effects: Effects = ALL_EFFECTS,
) -> float:
    """Return the bytes of one steady state with some outputs and a number of impacts.

    effects : those that the scene calls for, of which some have more numbers and derivatives
    """
    costs = {
        "harmonics": 2 * 8 + 4 * 8 * harmonics + ERROR_BYTES * (1 + 2 * harmonics),
        "impacts": 4 + 2 * (8 + ERROR_BYTES) + impacts * (IMPACT_BYTES + 2 * ERROR_BYTES),
        "stability": 2 * 16 + 1 + 2 * ERROR_BYTES,
        "motion": 2 * 8 * PHASE_SAMPLES,
        "energy": 6 * 8,
        "subharmonics": 2 * 8 * SUBHARMONICS * harmonics,
        "poincare": 2 * 8 * VISITS,
        "lyapunov": 2 * 8,
    }
    if effects.soft is not None:
        costs["impacts"] += CONTACT_NUMBERS * 8 * impacts + 2 * 8 * (CONTACT_NUMBERS - 1)
    requested = list(outputs)
    size = (
        ROW_BYTES
        + 2 * ERROR_BYTES
        + sum(costs[output] for output in requested if output != "sensitivity")
    )
    if "sensitivity" in requested:
        # here, since it imports numba, which a command that only reads studies does not need
        from vibropipe.physics.derivatives import differentiated_by

        # A derivative by each parameter beside every number that has one.
        numbers = {
            "harmonics": 2 + 4 * harmonics,
            "impacts": 2 + 2 * impacts,
            "stability": 4,
            "energy": 4,
            "subharmonics": 2 * SUBHARMONICS * harmonics,
            "lyapunov": 1,
        }
        own = 2 + sum(numbers.get(output, 0) for output in requested)
        by = differentiated_by(effects.has_pieces, effects.second_harmonic is not None)
        size += 8 * len(by) * own
    return size


def thinned(values: NDArray[np.float64], n_values: int) -> ValueGrid:
    """Return at most `n_values` of the values, including the first and the last."""
    indices = np.unique(np.linspace(0, values.size - 1, n_values).round().astype(int))
    return ValueGrid(values=values[indices].tolist())


def planned(work: Work, core_seconds: float | None = None) -> Estimate:
    """Return the plan as an estimate, with measured seconds if there are any."""
    seconds = work.seconds if core_seconds is None else core_seconds
    return Estimate(seconds, MIN_LOAD_SECONDS, work.bytes, work.is_parallel, work.method)


def by_plan(plan: Callable[[Any], Work]) -> Callable[[Any, Sampler], Estimate]:
    """Return the `estimate` of a kind of which no more is known than its plan."""
    return lambda scene, sampler: planned(plan(scene))
