"""Checks that involve several keys of a scene, shared by the kinds of scenes.

Each check lists the keys that it reads, so that it is left out where one of those is
already reported: a fault that only follows from another one is not listed.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import suppress
from typing import Any, NamedTuple

import numpy as np

from vibropipe.physics.effects import all_effects, has_effect
from vibropipe.physics.exciter import Exciter, ParameterError
from vibropipe.physics.restitution import SUPPORTS as PAIRED
from vibropipe.physics.si import TWICE_DAMPED
from vibropipe.physics.start import start_room
from vibropipe.scenes.keys.base import BaseScene
from vibropipe.scenes.keys.effects import ForcedScene, check_effects
from vibropipe.scenes.keys.grids import MAX_ROWS, ValueGrid, comma_hint
from vibropipe.scenes.keys.problems import KeyPath, Problem, argument_path, refused, required
from vibropipe.scenes.keys.ties import check_ties
from vibropipe.scenes.keys.values import is_allowed
from vibropipe.solve.checks import LEFT_OUT, check_varied
from vibropipe.solve.sweep.sweep_starts import corners as corners_of_grid
from vibropipe.words.exciter import EFFECTS as RECORDS
from vibropipe.words.parameters import FORCES, PARAMETERS
from vibropipe.words.quantities import QUANTITIES
from vibropipe.words.spelling import did_you_mean

EXCITER: tuple[KeyPath, ...] = tuple(("exciter", name) for name in PARAMETERS)
OF_SUPPORTS = ("l", "delta", "k1", "k2", "h1", "h2")
SUPPORTS: tuple[KeyPath, ...] = tuple(
    (owner, name) for owner in ("exciter", "over") for name in OF_SUPPORTS
)


class Check(NamedTuple):
    """A check: the keys that it reads, and a function that yields problems with paths within the scene."""

    reads: tuple[KeyPath, ...]
    problems: Callable[[Any], Iterator[Problem]]


L_REQUIRED = required(
    ("exciter", "l"), PARAMETERS["l"].range.text, ", in the scene or in the study"
)


def check_shown(show: Collection[str], values: Mapping[str, Any]) -> Iterator[Problem]:
    """Check that pictures show quantities of an effect only where parameters, with all their values, have it."""
    for name in show:
        effect = next((each for each in RECORDS if each.name == QUANTITIES[name].effect), None)
        if effect is not None and not has_effect(effect, values):
            must = f"must leave out {name} unless {effect.occurs}"
            yield Problem(("figure", "show"), repr(str(name)), must=must)


def check_exciter(scene: BaseScene) -> Iterator[Problem]:
    """Check that l is given and that the supports are possible."""
    if not scene.has_l():
        yield L_REQUIRED
        return
    grids = scene.over_arrays()
    try:
        for corner in corners(scene):
            if not all(is_allowed(name, value) for name, value in corner.items()):
                return  # reported at that parameter
            Exciter(**corner)
        all_effects({**scene.resolved_exciter(), **grids}, **scene.computed())
    except ParameterError as error:
        yield refused(("over" if error.name in grids else "exciter", error.name), error)


def check_together(scene: BaseScene) -> Iterator[Problem]:
    """Check that a force has a frequency, and that no damping of 0 stands beside a restitution that gives another."""
    given, varied = scene.given_exciter(), scene.varied_names()
    names = given.keys() | varied
    grids, changed = scene.over_arrays(), varied | getattr(scene, "tolerance", {}).keys()
    is_forced = any(
        grids[name].any() if name in grids else name in changed or given.get(name, 0.0) != 0.0
        for name in FORCES
    )
    # a ramp has a frequency of its own, and says if it lacks one
    if is_forced and "nu" not in names and not getattr(scene, "ramp", {}):
        yield frequency_required(("exciter", "nu"))
    for R, k, h in PAIRED:
        has_loss = R in varied or given.get(R, 1.0) < 1.0
        is_soft = k in varied or given.get(k, 0.0) > 0.0
        if has_loss and is_soft and given.get(h) == 0.0 and h not in varied:
            must = TWICE_DAMPED.format(R=R, k=k, h=h)
            yield Problem(("exciter", h), repr(given[h]), must=must)


def frequency_required(path: KeyPath) -> Problem:
    """Return the fault of a force without a frequency."""
    return required(path, PARAMETERS["nu"].range.text, ", since there is a force")


def corners(scene: BaseScene, fixed: dict[str, float] | None = None) -> list[dict[str, float]]:
    """Return parameters at the corners of the swept parameters of supports; those in `fixed` have one value.

    Where parameters are tied, at all corners and wherever tied ones meet others.
    """
    if scene.tied() and scene.has_l():
        with suppress(ParameterError):  # reported by `check_ties`
            points = [*corners_of_grid(scene.row_grid())]
            at = [p for p in points if all(p.get(n, v) == v for n, v in (fixed or {}).items())]
            return [{n: v for n, v in point.items() if n in PARAMETERS} for point in at or points]
    ends: dict[str, tuple[float, ...]] = {
        name: (grid.low, grid.high)
        for name, grid in scene.grids().items()
        if name in (*OF_SUPPORTS, "R1", "R2")
    }
    ends |= {name: (value,) for name, value in (fixed or {}).items() if name in ends}
    base = scene.resolved_exciter() if scene.has_l() else {**scene.given_exciter(), "l": 1.0}
    return [
        {**base, **dict(zip(ends, values, strict=True))}
        for values in itertools.product(*ends.values())
    ]


def check_start(scene: ForcedScene, fixed: dict[str, float] | None = None) -> Iterator[Problem]:
    """Check that a stated start lies between the supports in every row."""
    if not scene.has_l():
        return
    try:
        exciters = [Exciter(**corner) for corner in corners(scene, fixed)]
    except ParameterError:
        return  # reported by `check_exciter`
    lower = max(exciter.lower for exciter in exciters)
    upper = min(exciter.upper for exciter in exciters)
    x0 = scene.start.x0
    rooms = [start_room(exciter) for exciter in exciters]
    if x0 is None or all(least <= x0 <= most for least, most in rooms):
        return
    if lower > upper:
        must = "must lie between the supports in every row, but no value does on this grid; split the sweep"
        yield Problem(("start", "x0"), "", must=must)
        return
    yield Problem(("start", "x0"), repr(x0), f"a number {between_supports(scene, lower, upper)}")


def shown_length(scene: BaseScene) -> tuple[float, str]:
    """Return the number of a unit length and its unit in messages: millimetres where the study has units."""
    return (1.0, "") if scene.mass_and_stiffness is None else (1e3, " mm")


def between_supports(scene: BaseScene, lower: float, upper: float) -> str:
    """Return the displacements between the supports in words."""
    size, unit = shown_length(scene)
    return f"from {size * lower:.10g} to {size * upper:.10g}{unit} (between the supports)"


def check_rows(scene: BaseScene, path: KeyPath = ()) -> Iterator[Problem]:
    """Check that a scene has at most MAX_ROWS rows."""
    if scene.row_count > MAX_ROWS:
        sizes = [grid.size for grid in scene.grids().values()]
        directions = scene.row_count // math.prod(sizes)
        text = " x ".join(map(str, sizes if directions == 1 else [directions, *sizes]))
        yield Problem(path, f"{text} rows", must="must give at most 1e8 rows in a scene")


def check_swept(scene: Any) -> Iterator[Problem]:
    """Check that the values of swept parameters are in range, and that none is both swept and set."""
    for name, grid in scene.over.items():
        if name not in PARAMETERS:
            continue
        for value in dict.fromkeys((grid.low, grid.high)):
            if not is_allowed(name, value):
                hint = comma_hint(grid.values) if isinstance(grid, ValueGrid) else ""
                yield Problem(("over", name), repr(value), PARAMETERS[name].range.text, hint)
                break
        if name in scene.exciter.explicit():
            must = f"must be left out, since {name} is swept"
            yield Problem(("exciter", name), repr(scene.exciter.explicit()[name]), must=must)


def check_solver(scene: ForcedScene) -> Iterator[Problem]:
    """Check that newmark has a step, exact has none, and an accuracy excludes both keys."""
    solver, given = scene.solver, scene.solver.model_fields_set
    if "accuracy" in given and len(given) > 1:
        others = ", ".join(sorted(given - {"accuracy"}))
        must = "must have accuracy alone, which selects method and steps_per_period"
        yield Problem(("solver",), f"accuracy with {others}", must=must)
    elif solver.method == "newmark" and "steps_per_period" not in given:
        field = type(solver).model_fields["steps_per_period"]
        allowed = field.metadata[0].allowed
        yield required(("solver", "steps_per_period"), allowed, ", since method is newmark")
    elif solver.method == "exact" and "steps_per_period" in given:
        must = "must be left out unless method is newmark"
        yield Problem(("solver", "steps_per_period"), repr(solver.steps_per_period), must=must)


def check_vary(scene: Any) -> Iterator[Problem]:
    """Check that the ends of varied parameters are in range, and that none is both varied and set."""
    yield from check_numbers(scene, "vary", scene.vary)


def check_numbers(
    scene: Any, key: str, numbers: Mapping[Any, Collection[float]]
) -> Iterator[Problem]:
    """Check that the numbers of parameters under a key are in range, and that no such parameter is set beside."""
    stated = scene.exciter.explicit()
    for name, values in numbers.items():
        for value in values:
            if name in PARAMETERS and not is_allowed(name, value):
                yield Problem((key, name), repr(value), PARAMETERS[name].range.text)
                break
        if name in stated:
            must = f"must be left out, since {name} stands in {key}"
            yield Problem(("exciter", name), repr(stated[name]), must=must)


def check_vary_corners(scene: Any) -> Iterator[Problem]:
    """Check that l is given, and that every corner of the ranges has supports and a start between them."""
    varied = {str(name): ends for name, ends in scene.vary.items() if name in OF_SUPPORTS}
    corners = itertools.product(*varied.values())
    at_corners = [dict(zip(varied, corner, strict=True)) for corner in corners]
    changes = [change | scene.tied_at(scene.first_values() | change) for change in at_corners]
    problems = list(check_changes(scene, scene.vary, changes))
    yield from problems
    if not problems:
        yield from check_varied_supports(scene, "vary", {n: e[0] for n, e in scene.ends().items()})
        ends = {name: np.array(ends) for name, ends in scene.ends().items()}
        try:
            all_effects({**scene.resolved_exciter(), **ends}, **scene.computed())
        except ParameterError as error:
            yield refused(("vary" if error.name in ends else "exciter", error.name), error)


def check_varied_supports(
    scene: BaseScene, key: str, lows: Mapping[Any, float]
) -> Iterator[Problem]:
    """Check that parameters of a support that vary, from `lows` on, go together."""
    ends = {str(name): low for name, low in lows.items()}
    try:
        check_varied(key, Exciter(**scene.resolved_exciter()), ends, ends)
    except ParameterError as error:
        path = argument_path(error)
        yield refused(path if len(path) > 1 else ("exciter", *path), error)


def check_changes(
    scene: Any, varied: Collection[str], changes: list[dict[str, float]]
) -> Iterator[Problem]:
    """Check that l is given or varied, and that each changed exciter has supports and a start between them."""
    if not (scene.has_l() or "l" in varied):
        yield L_REQUIRED
        return
    for change in changes:
        try:
            exciter = Exciter(**{**scene.resolved_exciter(), **change})
        except ParameterError as error:
            yield refused(("exciter", error.name), error)
            return
        x0, (least, most) = scene.start.x0, start_room(exciter)
        if not (x0 is None or least <= x0 <= most):
            allowed = f"a number {between_supports(scene, exciter.lower, exciter.upper)}"
            yield Problem(("start", "x0"), repr(x0), allowed)
            return


def check_housing(scene: Any) -> Iterator[Problem]:
    """Check that a scene with a housing that slides asks for nothing that is not computed for one."""
    if not np.any(scene.extent().get("mass_ratio", 0.0)):
        return
    if scene.accuracy_asked() is not None:
        yield Problem(("solver", "accuracy"), repr(scene.accuracy_asked()), must=LEFT_OUT)


def no_exciter(scene: BaseScene, why: str, allowed: tuple[str, ...] = ()) -> Iterator[Problem]:
    """See that a scene is given no parameters but those allowed; `why` is the reason, a clause."""
    for name, value in scene.exciter.explicit().items():
        if name not in allowed:
            yield Problem(("exciter", name), repr(value), must=f"must be left out, since {why}")


TOGETHER = Check(
    (*EXCITER, ("over",), ("along",), ("vary",), ("measured",), ("ramp",)), check_together
)
TIES = Check((*EXCITER, ("ties",), ("over",), ("along",), ("vary",)), check_ties)
# Checks of scenes that begin at a start.
EFFECTS = Check((*EXCITER, ("start",), ("solver",), ("effects",)), check_effects)
HOUSING = Check((*EXCITER, ("over",), ("outputs",), ("solver",)), check_housing)
SOLVER = Check((("solver",),), check_solver)
EXCITER_CHECK = Check(SUPPORTS, check_exciter)


def check_named(
    scene: Any, key: str, what: str, fits: Collection[str], broken: Collection[str]
) -> Iterator[Problem]:
    """Check that a key of the picture names a scene that fits, or a broken one; `what` says which scenes fit."""
    wanted = getattr(scene.figure, key)
    if wanted is not None and wanted not in (*fits, *broken):
        allowed = f"{what} ({', '.join(fits) or 'the study has none'})"
        yield Problem(("figure", key), repr(wanted), allowed, did_you_mean(wanted, fits))


def check_drawn_together(
    scene: Any,
    scenes: Mapping[str, BaseScene],
    broken: Collection[str],
    what: str,
    fits: Callable[[Any], bool],
) -> Iterator[Problem]:
    """Check that scenes drawn together with one fit, or are broken; `what` says which do."""
    found = [
        n for n, other in scenes.items() if other is not scene and n not in broken and fits(other)
    ]
    for number, wanted in enumerate(scene.figure.together):
        if wanted not in (*found, *broken):
            allowed = f"{what} ({', '.join(found) or 'the study has none'})"
            path = ("figure", "together", number)
            yield Problem(path, repr(wanted), allowed, did_you_mean(wanted, found))


def check_backbone(
    scene: Any, scenes: Mapping[str, BaseScene], broken: Collection[str]
) -> Iterator[Problem]:
    """Check that the backbone drawn under a picture is a backbone scene over amplitude."""
    fits = [name for name, other in scenes.items() if other.gives_backbone]
    yield from check_named(scene, "backbone", "a backbone scene over amplitude", fits, broken)
