"""Keys of boundary scenes."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import AfterValidator, Field

from vibropipe.physics.effects import all_effects, check_first_harmonic, effect_names, effects_of
from vibropipe.physics.exciter import Exciter, ParameterError
from vibropipe.physics.limits import BOUNDARY_LINES
from vibropipe.scenes.costs import HEAD_BYTES, Work, slowness, stored_name, stored_values
from vibropipe.scenes.keys.base import BaseScene, each_once
from vibropipe.scenes.keys.checks import (
    TOGETHER,
    Check,
    check_named,
    check_numbers,
    check_varied_supports,
)
from vibropipe.scenes.keys.parts import FigureOptions, Law, ParameterName, figure_key
from vibropipe.scenes.keys.problems import Problem, refused, required
from vibropipe.scenes.keys.values import Interval, NameRule, NumberRange
from vibropipe.words.parameters import PARAMETERS, RIGID_AT_ZERO, SOFT_ALONG

# Curves of a kind that some lines find, points of a curve, and the seconds and bytes of a point, as usual.
USUAL_LINES, USUAL_CURVES, USUAL_POINTS, SECONDS_PER_POINT, POINT_BYTES = 12, 4, 300, 2e-4, 120
BoundaryKinds = Annotated[
    list[Literal["grazing", "fold", "flip", "pitchfork"]], AfterValidator(each_once)
]


class BoundaryFigure(FigureOptions):
    """Options of the picture of boundaries."""

    show: BoundaryKinds = Field(
        default=[], description="Kinds of bifurcations that are drawn (default: all of `of`)."
    )
    map: Annotated[str | None, NameRule()] = Field(
        default=None,
        description="Sweep over the same two parameters, whose regimes are drawn under the curves.",
    )


class BoundaryScene(BaseScene):
    """Curves of bifurcations in two parameters."""

    kind: Literal["boundary"] = Field(description="Curves of bifurcations in two parameters.")
    figure: BoundaryFigure = figure_key(BoundaryFigure, "picture")
    of: Annotated[BoundaryKinds, Field(min_length=1)] = Field(description="Kinds of bifurcations.")
    over: Annotated[dict[ParameterName, Interval], Field(min_length=2, max_length=2)] = Field(
        description="Ends of both parameters, in the order of the axes."
    )
    law: Law | None = Field(
        default=None,
        description="Period multiple and impacts on each support: only curves of orbits of this law, and the "
        "grazings at which they begin, are stored.",
    )
    lines: Annotated[int, NumberRange(*BOUNDARY_LINES, whole=True)] = Field(
        default=12, description="Lines along each parameter from which curves are sought."
    )

    @property
    def along(self) -> tuple[str, str]:
        """The two parameters."""
        first, second = map(str, self.over)
        return first, second

    @property
    def within(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Their ends."""
        (a, b), (c, d) = self.over.values()
        return (a, b), (c, d)

    @property
    def row_count(self) -> int:  # noqa: D102 - as BaseScene
        return len(self.of)

    def resolved_exciter(self) -> dict[str, float]:  # noqa: D102 - as BaseScene
        return {
            **super().resolved_exciter(),
            **{str(name): ends[0] for name, ends in self.over.items()},
        }

    def data_keys(self) -> dict[str, Any]:  # noqa: D102 - as BaseScene
        keys = super().data_keys()
        # As a list, since the order is that of the axes.
        return {**keys, "over": list(keys["over"].items()), "of": sorted(keys["of"])}

    def values(self) -> dict[str, Any]:
        """Return each parameter with the ends of its values."""
        ends = {str(name): np.array(ends) for name, ends in self.over.items()}
        return {**self.resolved_exciter(), **ends}

    def extent(self) -> dict[str, Any]:  # noqa: D102 - as BaseScene
        return self.values()

    def called_effects(self) -> tuple[str, ...]:
        """Return the effects that orbits within the box may need."""
        values = self.values()
        return effect_names(effects_of(values, 0.0, 0.0, math.inf, followed=True), values)


def _parameters(scene: BoundaryScene) -> Iterator[Problem]:
    """Check that the box is in range and that no parameter is given twice."""
    yield from check_numbers(scene, "over", scene.over)
    for name, ends in scene.over.items():
        if name in RIGID_AT_ZERO and 0.0 in ends:
            yield Problem(("over", name), "0", must=SOFT_ALONG)


def _exciter(scene: BoundaryScene) -> Iterator[Problem]:
    """Check that l is given and that the supports are distinct."""
    if not (scene.has_l() or "l" in scene.over):
        where = ", in the scene or in the study"
        yield required(("exciter", "l"), PARAMETERS["l"].range.text, where)
        return
    try:
        Exciter(**scene.resolved_exciter())
        all_effects(scene.values(), pieces=True, housing=True)
        check_first_harmonic(scene.values())
    except ParameterError as error:
        yield refused(("exciter", error.name), error)
        return
    lows = {name: ends[0] for name, ends in scene.over.items()}
    yield from check_varied_supports(scene, "over", lows)


def _figure(scene: BoundaryScene) -> Iterator[Problem]:
    """Check that the kinds to show are among those that are sought."""
    for name in scene.figure.show:
        if name not in scene.of:
            allowed = f"a kind of bifurcation that `of` has ({', '.join(scene.of)})"
            yield Problem(("figure", "show"), repr(str(name)), allowed)


CHECKS = (
    TOGETHER,
    Check((("over",),), _parameters),
    Check((("over",), ("exciter",)), _exciter),
    Check((("of",), ("figure",)), _figure),
)


def check_map(
    scene: BoundaryScene, scenes: Mapping[str, BaseScene], broken: Collection[str]
) -> Iterator[Problem]:
    """Check that the map drawn under the curves is a scene over the same two parameters."""
    fits = [name for name, other in scenes.items() if set(other.grids()) == set(scene.over)]
    what = f"a sweep over {' and '.join(scene.over)}"
    yield from check_named(scene, "map", what, fits, broken)


def plan(scene: BoundaryScene) -> Work:
    """Return the work of curves of the usual number and length, which are not known before."""
    points = len(scene.of) * USUAL_CURVES * USUAL_POINTS * scene.lines / USUAL_LINES
    return Work(
        size=" x ".join(_range_text(scene, str(name), ends) for name, ends in scene.over.items()),
        rows=scene.row_count,
        method="exact",
        outputs=(),
        seconds=points * SECONDS_PER_POINT * slowness(scene),
        bytes=HEAD_BYTES + points * POINT_BYTES,
        is_foreseen=False,
    )


def _range_text(scene: BoundaryScene, name: str, ends: Sequence[float]) -> str:
    (first, last), unit = stored_values(scene, name, ends)
    return f"{stored_name(scene, name)} {first} to {last}{unit}"
