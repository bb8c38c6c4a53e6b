"""Rules of a study that tie several keys together.

Each check says which keys of the scene it reads, so that it is left out where one of those is
already reported: ten faults are told as ten, without an eleventh that only follows from them.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator
from typing import Any

from vibropipe.physics.exciter import ALLOWED, Exciter, ParameterError
from vibropipe.physics.limits import MAX_MARCH_STEPS, MAX_SAMPLES, MAX_TAU
from vibropipe.physics.start import start_room
from vibropipe.study.accuracy import AccuracyScene, raced_problems
from vibropipe.study.base import BaseScene
from vibropipe.study.effect_costs import EffectsScene, timed_problems
from vibropipe.study.effects import check_effects
from vibropipe.study.grids import MAX_ROWS, RangeGrid, ValueGrid, comma_hint
from vibropipe.study.models import (
    BackboneScene,
    HardCasesScene,
    MotionScene,
    Study,
    SweepScene,
)
from vibropipe.study.problems import Path, Problem, did_you_mean
from vibropipe.study.spelling import PARAMETERS
from vibropipe.study.values import takes

Check = Callable[[Any], Iterator[Problem]]


def check_study(study: Study, broken: frozenset[Path]) -> Iterator[Problem]:
    """Yield every fault of the scenes; `broken` are paths of the study already reported."""
    shared = {path[1:] for path in broken if path[:1] == ("exciter",) and len(path) > 1}
    for name, scene in study.scenes.items():
        own = {path[2:] for path in broken if path[:2] == ("scenes", name)}
        own |= {("exciter", *path) for path in shared if path[0] not in scene.exciter.given()}
        for kind, reads, check in CHECKS:
            touched = any(_meets(path, keys) for path in own for keys in reads)
            if isinstance(scene, kind) and not touched:
                for problem in check(scene):
                    where = ("scenes", name, *problem.path)
                    yield Problem(where, problem.found, problem.allowed, problem.hint)
        beside = scene.figure.beside
        if beside is not None and ("scenes", beside) not in broken:
            yield from _beside(study, scene, beside)


def _meets(path: Path, keys: Path) -> bool:
    length = min(len(path), len(keys))
    return path[:length] == keys[:length]


def _beside(study: Study, scene: BaseScene, beside: str) -> Iterator[Problem]:
    fits = [
        name
        for name, other in study.scenes.items()
        if isinstance(other, BackboneScene) and other.over_amplitude
    ]
    path = ("scenes", scene.name, "figure", "beside")
    if not isinstance(scene, SweepScene):
        yield Problem(path, repr(beside), "this key in sweep scenes only")
    elif beside not in fits:
        allowed = f"a backbone scene over amplitude ({', '.join(fits) or 'the study has none'})"
        yield Problem(path, repr(beside), allowed, did_you_mean(beside, fits))


def _exciter(scene: BaseScene) -> Iterator[Problem]:
    """See that l is there and that all parameters together leave room between the supports."""
    if isinstance(scene, BackboneScene) and not scene.over_amplitude:
        return
    if isinstance(scene, HardCasesScene):
        return
    if isinstance(scene, AccuracyScene | EffectsScene):
        return  # said motion by motion
    if not has_l(scene):
        hint = "in the scene or, for all scenes, in the study's exciter"
        yield Problem(("exciter", "l"), "nothing", ALLOWED["l"], hint)
        return
    for corner in corners(scene):
        if not all(takes(name, value) for name, value in corner.items()):
            return  # said where that one parameter stands
        try:
            Exciter(**corner)
        except ParameterError as error:
            found, _, allowed = str(error).partition("allowed is ")
            yield Problem(("exciter", "l"), found.rstrip(" :;"), allowed)
            return


def has_l(scene: BaseScene) -> bool:
    """Tell whether the scene's l is given: by itself, by the study or by its grid."""
    return "l" in scene.exciter.given() or "l" in scene._shared or "l" in scene.grids()


def corners(scene: BaseScene, *, followed: bool = False) -> list[dict[str, float]]:
    """Return the exciters at the corners of what a scene sweeps of l and delta.

    With `followed`, a parameter that is followed stands at the end where its rows begin.
    """
    ends: dict[str, tuple[float, ...]] = {}
    for name, grid in scene.grids().items():
        if name in ("l", "delta"):
            ends[name] = (grid.low, grid.high)
    follow = scene.follow if isinstance(scene, SweepScene) and followed else None
    if follow and follow.along in ends:
        ends[follow.along] = (ends[follow.along][0 if follow.direction == "up" else 1],)
    given = scene._shared | scene.exciter.given()
    base = scene.resolved_exciter() if has_l(scene) else {**given, "l": 1.0}
    return [
        {**base, **dict(zip(ends, values, strict=True))}
        for values in itertools.product(*ends.values())
    ]


def _start(scene: MotionScene | SweepScene) -> Iterator[Problem]:
    """See that a start that is given lies between the supports, for every combination of a sweep."""
    if not has_l(scene):
        return
    try:
        exciters = [Exciter(**corner) for corner in corners(scene, followed=True)]
    except ParameterError:
        return  # said by the check of the exciter
    lower = max(exciter.lower for exciter in exciters)
    upper = min(exciter.upper for exciter in exciters)
    x0 = scene.start.x0
    rooms = [start_room(exciter.l, exciter.delta) for exciter in exciters]
    if x0 is None or all(least <= x0 <= most for least, most in rooms):
        return
    allowed = f"a number from {lower!r} to {upper!r} (between the supports)"
    if lower > upper:
        allowed = "supports that share a place for one start, in every row (split the sweep)"
    yield Problem(("start", "x0"), repr(x0), allowed)


def _swept(scene: SweepScene) -> Iterator[Problem]:
    """See that swept values are allowed and that no parameter is both swept and set."""
    for name, grid in scene.over.items():
        for value in dict.fromkeys((grid.low, grid.high)):
            if not takes(name, value):
                hint = comma_hint(grid.values) if isinstance(grid, ValueGrid) else ""
                yield Problem(("over", name), repr(value), ALLOWED[name], hint)
                break
        if name in scene.exciter.given():
            allowed = "it left out here, since it is swept"
            yield Problem(("exciter", name), repr(scene.exciter.given()[name]), allowed)


def _follow(scene: SweepScene) -> Iterator[Problem]:
    if scene.follow is None:
        return
    if "start" in scene.model_fields_set:
        yield Problem(("start",), "it beside follow", "either start or follow")
    if scene.follow.along not in scene.over:
        known = list(scene.over)
        yield Problem(("follow", "along"), repr(scene.follow.along), " or ".join(known))


def _rows(scene: BaseScene) -> Iterator[Problem]:
    if scene.row_count > MAX_ROWS:
        sizes = " x ".join(str(grid.size) for grid in scene.grids().values())
        path: Path = ("over",) if isinstance(scene, SweepScene) else ()
        yield Problem(path, f"{sizes} rows", "at most 1e8 rows in a scene")


def _solver(scene: MotionScene | SweepScene) -> Iterator[Problem]:
    solver, given = scene.solver, scene.solver.model_fields_set
    if "accuracy" in given and len(given) > 1:
        yield Problem(("solver",), "accuracy beside other keys", "either a method or an accuracy")
    elif solver.method == "newmark" and isinstance(scene, SweepScene):
        allowed = "exact (steady states are found in closed form) or an accuracy"
        yield Problem(("solver", "method"), "'newmark'", allowed)
    elif solver.method == "newmark" and "steps_per_period" not in given:
        field = type(solver).model_fields["steps_per_period"]
        allowed = f"{field.metadata[0].allowed}, which newmark needs"
        yield Problem(("solver", "steps_per_period"), "nothing", allowed)
    elif solver.method == "exact" and "steps_per_period" in given:
        allowed = "it with `method: newmark` only"
        yield Problem(("solver", "steps_per_period"), repr(solver.steps_per_period), allowed)


def _length(scene: MotionScene) -> Iterator[Problem]:
    """See that a motion ends within bounded work and memory."""
    begin, end = scene.tau_span()
    period = 2 * math.pi / scene.resolved_exciter()["nu"]
    if end > MAX_TAU:
        path = ("settle_periods",) if begin > scene.tau_end else ("tau_end",)
        yield Problem(path, f"a motion until tau = {end:g}", f"at most tau = {MAX_TAU:g}")
        return
    samples = scene.tau_end / period * scene.samples_per_period
    if samples > MAX_SAMPLES:
        allowed = f"at most {MAX_SAMPLES:g} samples in a record"
        yield Problem(("samples_per_period",), f"{samples:.3g} samples", allowed)
    steps = end / period * (scene.solver.steps_per_period or 0)
    if steps > MAX_MARCH_STEPS:
        allowed = f"at most {MAX_MARCH_STEPS:g} steps"
        yield Problem(("solver", "steps_per_period"), f"{steps:.3g} steps", allowed)


def _effects(scene: MotionScene | SweepScene) -> Iterator[Problem]:
    if has_l(scene):
        yield from check_effects(scene)


def _backbone_form(scene: BackboneScene) -> Iterator[Problem]:
    """See that delta_over_l and tau_bar are there, or amplitude, and no key of the other form."""
    given = scene.model_fields_set
    other = ("delta_over_l", "tau_bar", "check_points") if scene.over_amplitude else ("harmonics",)
    form = "amplitude" if scene.over_amplitude else "delta_over_l and tau_bar"
    if not given & set(scene.GRIDS):
        yield Problem((), "no grid", "delta_over_l and tau_bar, or amplitude")
        return
    for name in other:
        if name in given:
            yield Problem(
                (name,), f"it beside {form}", "one form: delta_over_l and tau_bar, or amplitude"
            )
    if not scene.over_amplitude:
        for name in ("delta_over_l", "tau_bar"):
            if name not in given:
                yield Problem((name,), "nothing", "a grid, or amplitude instead of both")


def _backbone_ranges(scene: BackboneScene) -> Iterator[Problem]:
    for name in ("tau_bar", "amplitude"):
        grid: ValueGrid | RangeGrid | None = getattr(scene, name)
        if grid is not None and grid.low <= 0:
            yield Problem((name,), repr(grid.low), "numbers above 0")
    offsets = scene.delta_over_l
    if offsets is not None:
        for value in dict.fromkeys((offsets.low, offsets.high)):
            if not -1 < value < 1:
                yield Problem(("delta_over_l",), repr(value), "numbers between -1 and 1")
                break


def _backbone_exciter(scene: BackboneScene) -> Iterator[Problem]:
    """See that free motion is given no other parameters than those of its supports."""
    allowed = ("l", "delta") if scene.over_amplitude else ()
    for name, value in scene.exciter.given().items():
        if name not in allowed:
            words = "l and delta only: free motion has neither force nor loss"
            if not allowed:
                words = "no exciter: the curves depend on delta_over_l and tau_bar alone"
            yield Problem(("exciter", name), repr(value), words)


def _hard_cases(scene: HardCasesScene) -> Iterator[Problem]:
    """See that the cases exist, and that the scene is given no exciter: each case has its own."""
    for name, value in scene.exciter.given().items():
        yield Problem(("exciter", name), repr(value), "no exciter: each case has its own")
    if scene.cases:
        from vibropipe.lab.hard_cases import CASES

        known = [case.name for case in CASES]
        for place, name in enumerate(scene.cases):
            if name not in known:
                hint = did_you_mean(name, known)
                yield Problem(("cases", place), repr(name), ", ".join(known), hint)


def _figure(scene: BaseScene) -> Iterator[Problem]:
    if scene.figure.periods is not None and not isinstance(scene, MotionScene):
        allowed = "this key in motion scenes only"
        yield Problem(("figure", "periods"), repr(scene.figure.periods), allowed)


_EXCITER: tuple[Path, ...] = tuple(("exciter", name) for name in PARAMETERS)
_SUPPORTS: tuple[Path, ...] = (
    ("exciter", "l"),
    ("exciter", "delta"),
    ("over", "l"),
    ("over", "delta"),
)
_CALLING: tuple[Path, ...] = (("start",), ("solver",), ("effects",))
_GRIDS: tuple[Path, ...] = tuple((name,) for name in BackboneScene.GRIDS)

# kind of scene, the keys that the check reads, the check
CHECKS: tuple[tuple[type[BaseScene], tuple[Path, ...], Check], ...] = (
    (BaseScene, (*_SUPPORTS, ("amplitude",)), _exciter),
    (MotionScene, (*_SUPPORTS, ("start", "x0")), _start),
    (SweepScene, (*_SUPPORTS, ("start",), ("follow",)), _start),
    (SweepScene, (), _swept),
    (SweepScene, (("over",), ("follow",)), _follow),
    (BaseScene, (("over",), *_GRIDS), _rows),
    (MotionScene, (("solver",),), _solver),
    (SweepScene, (("solver",),), _solver),
    (
        MotionScene,
        (*_EXCITER, ("tau_end",), ("settle_periods",), ("samples_per_period",), ("solver",)),
        _length,
    ),
    (AccuracyScene, (*_EXCITER, ("motions",)), raced_problems),
    (EffectsScene, (*_EXCITER, ("motions",)), timed_problems),
    (MotionScene, (*_EXCITER, *_CALLING, ("tau_end",), ("settle_periods",)), _effects),
    (SweepScene, (*_EXCITER, *_CALLING, ("over",), ("follow",)), _effects),
    (BackboneScene, (*_GRIDS, ("check_points",), ("harmonics",)), _backbone_form),
    (BackboneScene, (), _backbone_ranges),
    (BackboneScene, (("amplitude",),), _backbone_exciter),
    (HardCasesScene, (("cases",),), _hard_cases),
    (BaseScene, (("figure",),), _figure),
)
