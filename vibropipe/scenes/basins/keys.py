"""Keys of basins scenes."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from vibropipe.physics.effects import all_effect_names
from vibropipe.physics.exciter import Exciter, ParameterError
from vibropipe.physics.start import start_room
from vibropipe.scenes.costs import HEAD_BYTES, Work, grid_size, slowness, steady_bytes
from vibropipe.scenes.keys.base import BaseScene, EachOnce, Harmonics
from vibropipe.scenes.keys.checks import (
    EXCITER,
    EXCITER_CHECK,
    SUPPORTS,
    TIES,
    TOGETHER,
    Check,
    between_supports,
    check_exciter,
    check_named,
    check_rows,
    check_swept,
    check_varied_supports,
    corners,
)
from vibropipe.scenes.keys.grids import A_GRID, Grid, RangeGrid, ValueGrid
from vibropipe.scenes.keys.parts import FigureOptions, SweptName, figure_key
from vibropipe.scenes.keys.problems import Problem, required
from vibropipe.scenes.keys.proofs import check_covered
from vibropipe.scenes.keys.ties import TiedScene
from vibropipe.scenes.keys.values import NameRule, NumberRange
from vibropipe.solve.checks import LEFT_OUT
from vibropipe.words.outputs import OF_STEADY_STATE
from vibropipe.words.parameters import PARAMETERS, STARTS

# A start costs the transient, here some thirty forcing periods, and is stored in nine bytes.
SECONDS_PER_START, BYTES_PER_START = 3e-5, 9
# Seconds that the proof of the knocks of a motion takes.
PROOF_SECONDS = 10.0
# Seconds and bytes of attractors, beside the starts that look for them: of usual ones, with states at the section.
SEARCH_SECONDS, ATTRACTORS, SECTION_BYTES = 0.05, 3, 2 * 8 * 1024


class BasinsFigure(FigureOptions):
    """Options of the pictures of basins."""

    pictures: EachOnce[Literal["basins", "shares", "maps"]] = Field(
        default=[],
        description="Pictures: the map of the starts (`basins`); with a parameter in `over` the shares over it, or "
        "maps at up to six of its values (default: basins or shares, as fits).",
    )

    show: EachOnce[Literal["attractor", "periods_to_attractor"]] = Field(
        default=[],
        description="Maps: the attractor of each start (default), and the forcing periods until it settles.",
    )
    branches: Annotated[str | None, NameRule()] = Field(
        default=None,
        description="Scene of kind `branch` along the parameter in `over`, drawn under the amplitudes.",
    )


class BasinsScene(TiedScene):
    """Coexisting motions of one exciter, and which of them each start of a grid settles on."""

    kind: Literal["basins"] = Field(
        description="Coexisting motions, and the starts that settle on them."
    )
    COMPUTES_PIECES = True
    COMPUTES_HOUSING = True
    figure: BasinsFigure = figure_key(BasinsFigure, "picture")
    over: dict[SweptName, Grid] = Field(
        description="Grids of the starts, `x0` (not beyond a rigid support) and `v0`, and of one parameter or none."
    )
    phase: Annotated[float, NumberRange(0, 1)] = Field(
        default=0.0,
        description="Phase of the force at the start, as a fraction of a forcing period.",
    )
    harmonics: Harmonics = Field(default=6, description="Number of harmonics of each motion.")
    starts: Annotated[int, NumberRange(1, 10**7, whole=True)] = Field(
        default=4096, description="Scattered starts that look for motions beside the grid."
    )
    prove: bool = Field(
        default=False,
        description="Prove how hard each motion may be hit: `knock_low` and `knock_impulse_low` (docs/proof.md).",
    )

    def grids(self) -> dict[str, ValueGrid | RangeGrid]:  # noqa: D102 - as BaseScene
        return {str(name): self.over[name] for name in self._names()}

    def _names(self) -> list[SweptName]:
        """Return the swept names in the order of the dimensions: the parameter, x0, v0."""
        return sorted(self.over, key=lambda name: (str(name) in STARTS, str(name) == "v0"))

    @property
    def swept(self) -> str | None:
        """The parameter beside the starts, or None."""
        return next((str(name) for name in self.over if name in PARAMETERS), None)

    def resolved_exciter(self) -> dict[str, float]:  # noqa: D102 - as BaseScene
        swept = {str(name): grid.low for name, grid in self.over.items() if name in PARAMETERS}
        return {**super().resolved_exciter(), **swept}

    def called_effects(self) -> tuple[str, ...]:
        """Return all effects: which of them occur depends on the start."""
        return all_effect_names(self.resolved_exciter(), pieces=True, housing=True)


def _housing(scene: BasinsScene) -> Iterator[Problem]:
    """Check that a scene with a housing that slides asks for nothing that is not computed for one."""
    if not np.any(scene.extent().get("mass_ratio", 0.0)):
        return
    if scene.phase % 1.0:
        yield Problem(("phase",), repr(scene.phase), must=LEFT_OUT)
    if scene.swept:
        yield Problem(("over", scene.swept), "", must=LEFT_OUT)


def _prove(scene: BasinsScene) -> Iterator[Problem]:
    """Check that proofs are asked of one exciter, and of effects that can be proved."""
    if not scene.prove:
        return
    values = scene.resolved_exciter()
    if scene.swept:
        must = f"must be left out with {scene.as_written(scene.swept)} in over: the knocks of one exciter are proved"
        yield Problem(("prove",), "true", must=must)
    elif values.get("friction", 0.0) != 0.0:
        must = "must be left out: the friction of the exciter is beyond what can be proved"
        yield Problem(("prove",), "true", must=must)
    else:
        yield from check_covered(values, "true")


def _over(scene: BasinsScene) -> Iterator[Problem]:
    """Check that both parts of the start have grids, and at most one parameter beside them."""
    for name in STARTS:
        if name not in scene.over:
            yield required(("over", name), A_GRID)
    names = [str(name) for name in scene.over if name in PARAMETERS]
    if len(names) > 1:
        must = "must have at most one parameter beside x0 and v0"
        yield Problem(("over",), ", ".join(names), must=must)
    yield from check_swept(scene)


def _starts(scene: BasinsScene) -> Iterator[Problem]:
    """Check that no displacement lies beyond a rigid support, at all values of the parameter."""
    if not scene.has_l() or "x0" not in scene.over:
        return
    try:
        exciters = [Exciter(**corner) for corner in corners(scene)]
    except ParameterError:
        return  # reported by `EXCITER_CHECK`
    grid = scene.over["x0"]
    for value in dict.fromkeys((grid.low, grid.high)):
        rooms = [start_room(exciter) for exciter in exciters]
        if not all(least <= value <= most for least, most in rooms):
            lower = max(exciter.lower for exciter in exciters)
            upper = min(exciter.upper for exciter in exciters)
            allowed = f"numbers {between_supports(scene, lower, upper)}"
            yield Problem(("over", "x0"), repr(value), allowed)
            return


def _supports(scene: BasinsScene) -> Iterator[Problem]:
    """Check that the parameter in `over` goes with the others of its support."""
    if scene.swept and scene.has_l() and not any(check_exciter(scene)):
        yield from check_varied_supports(
            scene, "over", {scene.swept: scene.grids()[scene.swept].low}
        )


def _figure(scene: BasinsScene) -> Iterator[Problem]:
    """Check that the options of the picture fit what is drawn: maps, or shares over a parameter."""
    if scene.swept and scene.figure.show:
        must = f"must be left out, since shares over {scene.as_written(scene.swept)} are drawn"
        yield Problem(("figure", "show"), ", ".join(scene.figure.show), must=must)
    fits = {"shares", "maps"} if scene.swept else {"basins"}
    for name in scene.figure.pictures:
        if name not in fits:
            must = f"must be chosen {'without' if scene.swept else 'with'} a parameter in `over`"
            yield Problem(("figure", "pictures"), repr(name), must=must)
    if not scene.swept and scene.figure.branches is not None:
        must = "must be left out unless `over` has a parameter"
        yield Problem(("figure", "branches"), repr(scene.figure.branches), must=must)


def check_branches(
    scene: BasinsScene, scenes: Mapping[str, BaseScene], broken: Collection[str]
) -> Iterator[Problem]:
    """Check that the branches drawn under the amplitudes are followed along the parameter of the shares."""
    if scene.swept is None:
        return
    fits = [name for name, each in scenes.items() if getattr(each, "followed", "") == scene.swept]
    yield from check_named(scene, "branches", f"a branch scene along {scene.swept}", fits, broken)


CHECKS = (
    TIES,
    TOGETHER,
    EXCITER_CHECK,
    Check((), _over),
    Check((*SUPPORTS, ("over", "x0")), _starts),
    Check((("over",),), lambda scene: check_rows(scene, ("over",))),
    Check((*SUPPORTS, ("over",)), _supports),
    Check((("figure",), ("over",)), _figure),
    Check((*EXCITER, ("over",), ("phase",)), _housing),
    Check((*EXCITER, ("over",), ("prove",)), _prove),
)


def plan(scene: BasinsScene) -> Work:
    """Return the work of a basins scene, from its number of starts."""
    attractor = steady_bytes(OF_STEADY_STATE, scene.harmonics) + SECTION_BYTES
    n_values = next((grid.size for name, grid in scene.grids().items() if name == scene.swept), 1)
    starts = scene.row_count + n_values * scene.starts
    return Work(
        size=grid_size(scene),
        rows=scene.row_count,
        outputs=OF_STEADY_STATE,
        seconds=(n_values * SEARCH_SECONDS + starts * SECONDS_PER_START) * slowness(scene)
        + scene.prove * ATTRACTORS * PROOF_SECONDS,
        bytes=HEAD_BYTES + scene.row_count * BYTES_PER_START + n_values * ATTRACTORS * attractor,
        pieces=most_shards(scene),
        is_parallel=True,
        is_foreseen=False,
    )


def most_shards(scene: BasinsScene) -> int:
    """Return the largest number of shards: each looks for attractors itself, and has as many starts of its own."""
    if scene.resolved_exciter().get("mass_ratio", 0.0) > 0.0:
        return 1
    return max(1, scene.row_count // scene.starts)
