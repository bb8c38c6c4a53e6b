"""Keys of sweep scenes."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from itertools import islice
from typing import Annotated, Any, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import BeforeValidator, Field, model_validator

from vibropipe.physics.exciter import ParameterError
from vibropipe.physics.limits import PATIENCE
from vibropipe.scenes.costs import HEAD_BYTES, SWEPT_IMPACTS, Work, slowness, steady_bytes
from vibropipe.scenes.keys.base import Harmonics, Outputs, plain
from vibropipe.scenes.keys.checks import (
    EFFECTS,
    EXCITER,
    EXCITER_CHECK,
    HOUSING,
    SOLVER,
    SUPPORTS,
    TIES,
    TOGETHER,
    Check,
    check_rows,
    check_start,
    check_swept,
)
from vibropipe.scenes.keys.effects import EFFECTS_TEXT, ForcedScene, StatedEffects
from vibropipe.scenes.keys.grids import Grid, RangeGrid, ValueGrid, words_as_numbers
from vibropipe.scenes.keys.parts import MAX_LINES, Follow, OverName, Solver, Start, figure_key
from vibropipe.scenes.keys.problems import Problem
from vibropipe.scenes.keys.proofs import ROWS_TEXT, ProveRows, check_prove_rows, row_seconds
from vibropipe.scenes.keys.ties import TiedScene
from vibropipe.scenes.keys.values import NotNull, NumberRange
from vibropipe.scenes.sweep.figure_keys import SweepFigure, check_figure
from vibropipe.solve.sweep.sweep_grid import DIRECTIONS, SweepGrid
from vibropipe.words.outputs import SWEEP_DEFAULT
from vibropipe.words.parameters import STARTS

SECONDS_PER_ROW = 4e-5
# Largest number of rows in memory at once, and largest number of their bytes.
BLOCK_ROWS, BLOCK_BYTES = 4096, 12e6
# Impacts of a row without an orbit: it lists those of 64 forcing periods, about one on each support in each of them.
APERIODIC_IMPACTS = 128
# Largest number of impacts that an orbit can list. The mass comes to rest by chatter if nu is below SLOW or the
# spring presses it on a support. CHATTER: impact velocities at which a chatter begins and at which it is completed.
MAX_IMPACTS_KEPT = 8192
SLOW = 1.0
CHATTER = 1.0, 1e-7


class SweepScene(TiedScene, ForcedScene):
    """Steady states over all combinations of swept parameters."""

    COMPUTES_PIECES = True
    COMPUTES_HOUSING = True
    FOLLOWS_TIES = True
    kind: Literal["sweep"] = Field(description="Steady states over swept parameters.")
    figure: SweepFigure = figure_key(SweepFigure)
    over: Annotated[
        dict[OverName, Grid], BeforeValidator(words_as_numbers), Field(min_length=1)
    ] = Field(
        description="Grid of each swept parameter, or of x0 and v0 of the start, in the order of the dimensions."
    )
    start: Start = Field(
        default_factory=Start, description="Start of every row; excludes `follow`."
    )
    follow: Annotated[Follow | None, NotNull] = Field(
        default=None,
        description="Start each row from the steady state of its neighbour; excludes `start`.",
    )
    harmonics: Harmonics = Field(default=3, description="Number of harmonics.")
    outputs: Outputs = Field(
        default=list(SWEEP_DEFAULT), description="Quantities to compute and store."
    )
    solver: Solver = Field(
        default_factory=Solver,
        description="The exact method, or an accuracy: adds an error estimate to each row.",
    )
    patience: Annotated[int, NumberRange(*PATIENCE, whole=True)] = Field(
        default=200,
        description="Forcing periods after which a row with growing perturbations may be labelled aperiodic.",
    )
    effects: StatedEffects = Field(default=None, description=EFFECTS_TEXT)
    prove: ProveRows = Field(default=None, description=ROWS_TEXT.format("rows"))

    @model_validator(mode="after")
    def _choose_pictures(self) -> Self:
        """Draw how the mass moves over two fine grids, and quantities over them, unless the study chooses."""
        others = sorted(grid.size for grid in self.over.values())[:-1]
        if not self.figure.pictures and others and others[-1] > MAX_LINES:
            has_maps = self.figure.show or {"harmonics", "impacts"} & {*self.outputs}
            pictures = ["map", *(["quantities"] if has_maps else [])]
            pictures += ["proved"] if self.prove else []
            object.__setattr__(
                self, "figure", self.figure.model_copy(update={"pictures": pictures})
            )
        return self

    def grids(self) -> dict[str, ValueGrid | RangeGrid]:  # noqa: D102 - as BaseScene
        return {str(name): grid for name, grid in self.over.items()}

    def row_grid(self) -> SweepGrid:  # noqa: D102 - as BaseScene
        values = {name: grid.array() for name, grid in self.grids().items()}
        return SweepGrid(values, self.follow_pair(), self.untied_exciter(), self.tied())

    def over_arrays(self) -> dict[str, NDArray[np.float64]]:
        """Return all values of each name that is swept, and of each parameter that is tied to one."""
        try:
            return self.row_grid().varied
        except ParameterError:  # reported by `check_ties`
            return super().over_arrays()

    def data_keys(self) -> dict[str, Any]:  # noqa: D102 - as BaseScene
        keys = super().data_keys()
        # As a list, since their order is the order of the dimensions.
        return {**keys, "over": list(keys["over"].items())}

    def row_keys(self) -> dict[str, Any] | None:  # noqa: D102 - as BaseScene
        # A proof depends on the version of python-flint, too, which datasets do not hold.
        if self.follow is not None or self.prove:
            return None
        return {**self.data_keys(), "over": list(self.over), "start": plain(self.start)}

    @property
    def row_count(self) -> int:  # noqa: D102 - as BaseScene
        directions = len(DIRECTIONS[self.follow.direction]) if self.follow else 1
        return directions * super().row_count

    def follow_pair(self) -> tuple[str, str] | None:  # noqa: D102 - as BaseScene
        return (self.follow.along, self.follow.direction) if self.follow else None

    def effect_bounds(self) -> tuple[float, dict[str, Any]]:  # noqa: D102 - as ForcedScene
        return math.inf, {"followed": self.follow is not None}


def _start(scene: SweepScene) -> Iterator[Problem]:
    """Check that the start lies between the supports of every row that begins there."""
    follow, fixed = scene.follow, {}
    if follow and follow.along in scene.over:
        grid = scene.over[follow.along]
        ends = {"up": grid.low, "down": grid.high}
        # Chains in both directions begin at both ends, as all corners of the grid do.
        fixed = {str(follow.along): ends[follow.direction]} if follow.direction in ends else {}
    yield from check_start(scene, fixed)
    if "x0" in scene.over:
        for x0 in (scene.over["x0"].low, scene.over["x0"].high):
            moved = scene.model_copy(update={"start": Start(x0=x0)})
            for problem in islice(check_start(moved), 1):
                yield replace(problem, path=("over", "x0"))
                return


def _swept(scene: SweepScene) -> Iterator[Problem]:
    """Check that swept values are in range and that no parameter is both swept and set."""
    for name in STARTS:
        if name in scene.over and name in scene.start.model_fields_set:
            found, must = getattr(scene.start, name), f"must be left out, since {name} is swept"
            yield Problem(("start", name), repr(found), must=must)
    yield from check_swept(scene)


def _follow(scene: SweepScene) -> Iterator[Problem]:
    if scene.follow is None:
        return
    for name in STARTS:
        if name in scene.over:
            must = f"must be left out when {name} is swept, since a followed row starts from its neighbour"
            yield Problem(("follow",), "", must=must)
    if "start" in scene.model_fields_set:
        yield Problem(("start",), "", must="must be left out when follow is given")
    if scene.follow.along not in scene.over:
        allowed = f"a swept parameter ({', '.join(scene.over)})"
        yield Problem(("follow", "along"), repr(scene.follow.along), allowed)


def _solver(scene: SweepScene) -> Iterator[Problem]:
    """Check the solver, which must not be newmark."""
    given = scene.solver.model_fields_set
    if scene.solver.method == "newmark" and "accuracy" not in given:
        must = "must be exact, or left out for an accuracy, since steady states are found in closed form"
        yield Problem(("solver", "method"), "'newmark'", must=must)
    else:
        yield from SOLVER.problems(scene)


CHECKS = (
    TIES,
    TOGETHER,
    EXCITER_CHECK,
    Check((*SUPPORTS, ("start",), ("follow",), ("over", "x0")), _start),
    Check((), _swept),
    Check((("over",), ("follow",)), _follow),
    Check((("over",),), lambda scene: check_rows(scene, ("over",))),
    Check((("solver",),), _solver),
    HOUSING,
    Check((*EXCITER, ("over",), ("prove",)), check_prove_rows),
    Check((*EFFECTS.reads, ("over",), ("follow",)), EFFECTS.problems),
    Check((*SUPPORTS, ("figure",), ("over",), ("outputs",), ("exciter", "friction")), check_figure),
)


def plan(scene: SweepScene) -> Work:
    """Return the work of a sweep, from its number of rows."""
    grid = scene.row_grid()
    dims = [scene.as_written(name) for name in grid.dims]
    pair = scene.follow_pair()
    followed = [f"{scene.as_written(pair[0])} {pair[1]}"] if pair else []
    return Work(
        size=" x ".join(f"{size} {name}" for name, size in zip(dims, grid.shape, strict=True)),
        rows=scene.row_count,
        method=", ".join(["exact", *followed]),
        outputs=tuple(scene.outputs),
        seconds=scene.row_count * (SECONDS_PER_ROW * slowness(scene) + row_seconds(scene.prove)),
        bytes=HEAD_BYTES
        + scene.row_count
        * steady_bytes(scene.outputs, scene.harmonics, SWEPT_IMPACTS, scene.all_effects()),
        pieces=grid.chains,
        is_parallel=True,
    )


def block_rows(scene: SweepScene) -> int:
    """Return the number of rows that are solved before they are written."""
    return max(1, min(BLOCK_ROWS, int(BLOCK_BYTES / row_memory(scene))))


def row_memory(scene: SweepScene) -> float:
    """Return the bytes of the largest row in memory; a requested accuracy needs it twice."""
    passes = 1 if scene.solver.arguments().get("accuracy") is None else 2
    outputs, harmonics = scene.outputs, scene.harmonics
    return passes * steady_bytes(outputs, harmonics, max_impacts(scene), scene.all_effects())


def max_impacts(scene: SweepScene) -> float:
    """Return roughly the largest number of impacts of a row: without an orbit, or with rest that of two chatters."""
    swept, exciter = scene.over_arrays(), scene.resolved_exciter()
    values = {name: swept.get(name, np.array([value])) for name, value in exciter.items()}
    restitution = np.concatenate([values["R1"], values["R2"]])
    lossy = restitution[(restitution > 0) & (restitution < 1)]
    is_slow = values["nu"].min() < SLOW
    load = np.abs(values.get("load", np.zeros(1))).max()
    is_pressed = np.abs(values["delta"]).max() + load >= values["l"].min()
    if "rest" not in scene.called_effects() or not lossy.size or not (is_slow or is_pressed):
        return APERIODIC_IMPACTS
    first, last = CHATTER
    chatters = 2 * math.log(first / last) / math.log(1 / lossy.max())
    return min(max(APERIODIC_IMPACTS, chatters), MAX_IMPACTS_KEPT)
