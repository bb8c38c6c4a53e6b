"""How long a study will take on this machine and how much it will write, found by solving samples of it.

A sweep is sampled at rows spread over its grid, a long motion at its beginning; what takes next to no
time is solved whole. Of races, hard cases and measured effects pieces are taken (`expected_set`). Findings are
kept beside the compiled kernels, so that a later job can set them against the time it took.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray

from vibropipe.compiler.cache import cache_root
from vibropipe.jobs.estimates import Expected, keep
from vibropipe.jobs.plan import plan_scene
from vibropipe.scenes import race_of, solve
from vibropipe.scenes.motion import exciter_of
from vibropipe.store import write
from vibropipe.study import (
    AccuracyScene,
    BackboneScene,
    EffectsScene,
    HardCasesScene,
    MotionScene,
    Scene,
    Study,
    SweepScene,
    fingerprint,
    scene_effects,
)
from vibropipe.study.grids import ValueGrid

Sampled = MotionScene | SweepScene | BackboneScene

# Seconds of one core that the samples of a whole study may take, and those of one scene at least.
BUDGET, LEAST_BUDGET = 1.0, 0.05
# Seconds in which a job loads libraries and compiled kernels, at least.
USUAL_LOAD = 0.7
FIRST_SAMPLE, GROWTH = 64, 4
# A hard case of many motions, and the seconds it took where plans were made.
YARDSTICK = ("energy_of_motions", 0.08)
# Rows in a row along a followed parameter: enough that the first, which has no neighbour, weighs little.
SEGMENT = 32


def calibrate(study: Study) -> dict[str, Expected]:
    """Expectations by scene; they are kept for the jobs that solve the scenes."""
    found = expectations(study)
    keep({fingerprint(study, name): value for name, value in found.items()})
    return found


def expectations(study: Study) -> dict[str, Expected]:
    """Expectations by scene."""
    budget = max(LEAST_BUDGET, BUDGET / len(study.scenes))
    loads: dict[str, float] = {}
    return {name: expected(scene, budget, loads) for name, scene in study.scenes.items()}


def compiled() -> int:
    """How many kernels of this version lie compiled on this machine."""
    return sum(1 for _ in cache_root().rglob("*.nbc"))


def expected(scene: Scene, budget: float, loads: dict[str, float]) -> Expected:
    """Expectation of one scene; `loads` are seconds to load kernels, by the work they do."""
    plan = plan_scene(scene)
    if not isinstance(scene, MotionScene | SweepScene | BackboneScene):
        return expected_set(scene)
    with one_thread(), TemporaryDirectory(prefix="vibropipe-sample-") as folder:
        file = Path(folder) / "sample.nc"

        def solved(sample: Scene) -> float:
            # Of this process alone: others may work on the machine just now.
            begin = time.process_time()
            write(solve(sample), file)
            return time.process_time() - begin

        small, known = miniature(scene), compiled()
        first, again = solved(small), solved(small)
        # What had to be compiled will be there for the jobs; what was loaded for a scene before, will not.
        load = max(first - again if compiled() == known else 0.0, USUAL_LOAD)
        load = loads.setdefault(kernels_of(scene), load)
        if isinstance(scene, SweepScene):
            # What every job has to do is in the small sample as in the large one.
            base, least, spent = file.stat().st_size, small.row_count, 0.0
            for sample in samples(scene):
                taken = solved(sample)
                spent += taken
                if spent > budget:
                    break
            more = max(1, sample.row_count - least)
            rate, each = max(0.0, taken - again) / more, (file.stat().st_size - base) / more
            rest = scene.row_count - least
            return Expected(again + rate * rest, load, base + each * rest, True, plan.method)
        part, share = beginning(scene, plan.seconds, budget)
        core = solved(part) / share
        return Expected(core, load, file.stat().st_size / share, False, method_of(scene))


def expected_set(scene: HardCasesScene | AccuracyScene | EffectsScene) -> Expected:
    """Expectation of a scene of many motions of its own: a race by pieces of it and by what is installed, hard
    cases by the speed of one of them; measured effects bound their own time."""
    plan = plan_scene(scene)
    core = plan.seconds
    if isinstance(scene, AccuracyScene):
        from vibropipe.lab.work_precision_cost import race_seconds

        core = race_seconds(**race_of(scene))
    if isinstance(scene, HardCasesScene):
        core *= slowness(scene)
    return Expected(core, USUAL_LOAD, plan.bytes, False, plan.method)


def slowness(scene: HardCasesScene) -> float:
    """How many times longer than planned a hard case takes here."""
    name, planned = YARDSTICK
    sample = scene.model_copy(update={"cases": [name]})
    solve(sample)  # loads
    begin = time.thread_time()
    solve(sample)
    return (time.thread_time() - begin) / planned


def samples(scene: SweepScene) -> Iterator[SweepScene]:
    """Yield the sweep on ever larger parts of its grid, spread over it, at last on all of it.

    Of a parameter that is followed a segment is taken, since rows are quick where the one before is near.
    """
    arrays = scene.over_arrays()
    followed: str | None = scene.follow.along if scene.follow else None
    others = [name for name in arrays if name != followed]
    wanted = FIRST_SAMPLE
    while True:
        part: dict[str, NDArray[np.float64]] = {}
        left = wanted
        if followed is not None:
            along = np.sort(arrays[followed])
            length = min(along.size, max(SEGMENT, wanted // SEGMENT))
            first = (along.size - length) // 2
            part[followed] = along[first : first + length]
            left = max(1, wanted // length)
        for place, name in enumerate(others):
            each = int(np.ceil(left ** (1 / (len(others) - place))))
            part[name] = spread(arrays[name], each)
            left = max(1, left // part[name].size)
        grids = {name: ValueGrid(values=part[name].tolist()) for name in arrays}
        # A part of a grid may call for less than the whole: the sample runs on the scene's own kernel.
        yield scene.model_copy(update={"over": grids, "effects": list(scene_effects(scene))})
        if all(part[name].size == arrays[name].size for name in arrays):
            return
        wanted *= GROWTH


def spread(values: NDArray[np.float64], count: int) -> NDArray[np.float64]:
    """About `count` of the values, each from the middle of its share of them."""
    count = min(count, values.size)
    return values[((np.arange(count) + 0.5) * values.size / count).astype(int)]


def beginning(scene: Scene, rough: float, budget: float) -> tuple[Scene, float]:
    """A scene short enough to be solved now, and which share of the whole it is."""
    if rough <= budget or not isinstance(scene, MotionScene):
        return scene, 1.0
    share = budget / rough
    short = {
        "tau_end": scene.tau_end * share,
        "settle_periods": int(scene.settle_periods * share),
        "effects": list(scene_effects(scene)),
    }
    return scene.model_copy(update=short), share


def method_of(scene: Scene) -> str:
    """Name the method of a scene, chosen on its very exciter where an accuracy was asked."""
    if not isinstance(scene, MotionScene) or "accuracy" not in scene.solver.arguments():
        return plan_scene(scene).method
    from vibropipe.solve.accuracy.method_choice import choose

    _begin, end = scene.tau_span()
    choice = choose(
        exciter_of(scene), end, scene.start.x0, scene.start.v0, scene.solver.arguments()["accuracy"]
    )
    steps = f", {choice.steps_per_period} steps" if choice.steps_per_period is not None else ""
    return f"{choice.method}{steps} for {scene.solver.accuracy:g}"


def kernels_of(scene: Sampled) -> str:
    """Name what is loaded for a scene; scenes of one name call the same kernels."""
    if isinstance(scene, SweepScene):
        return " ".join([scene.kind, *sorted(scene.outputs), *sorted(scene_effects(scene))])
    if isinstance(scene, BackboneScene):
        return f"{scene.kind} over {'amplitude' if scene.over_amplitude else 'period'}"
    sampled = ["sampled"] if scene.samples_per_period else []
    settled = ["settled"] if scene.settle_periods else []
    solver = scene.solver.arguments()
    words = [str(solver.get("method", "accuracy")), *sampled, *settled]
    words += [*sorted(scene.outputs), *sorted(scene_effects(scene))]
    return " ".join([scene.kind, *words])


def miniature(scene: Sampled) -> Sampled:
    """Return a scene that calls the same kernels, with grids of a few values or a short motion."""
    if isinstance(scene, MotionScene):
        settle = min(scene.settle_periods, 1)
        short = {"settle_periods": settle, "tau_end": min(scene.tau_end, 6)}
        return scene.model_copy(update={**short, "effects": list(scene_effects(scene))})
    # along eq. (10) some values must lie where both supports are struck
    most = 2 if isinstance(scene, SweepScene) or scene.over_amplitude else 50
    grids = {name: thinned(grid.array(), most) for name, grid in scene.grids().items()}
    if isinstance(scene, SweepScene):
        # a small part of a grid may call for less than the whole of it
        return scene.model_copy(update={"over": grids, "effects": list(scene_effects(scene))})
    return scene.model_copy(update=grids)


def thinned(values: NDArray[np.float64], most: int) -> ValueGrid:
    """Return at most `most` of the values, the first and the last among them."""
    places = np.unique(np.linspace(0, values.size - 1, most).round().astype(int))
    return ValueGrid(values=values[places].tolist())


@contextmanager
def one_thread() -> Iterator[None]:
    """Let kernels use one thread inside this."""
    import numba

    before = numba.get_num_threads()
    numba.set_num_threads(1)
    try:
        yield
    finally:
        numba.set_num_threads(before)
