"""Keys of boundary scenes."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import AfterValidator, Field

from vibropipe.physics.effects import all_effects, check_first_harmonic, effect_names, effects_of
from vibropipe.physics.exciter import Exciter, ParameterError
from vibropipe.physics.limits import BOUNDARY_LINES
from vibropipe.physics.ties import SAMPLES
from vibropipe.scenes.costs import HEAD_BYTES, Work, slowness, stored_values
from vibropipe.scenes.keys.base import BaseScene, EachOnce, each_once
from vibropipe.scenes.keys.checks import (
    L_REQUIRED,
    TIES,
    TOGETHER,
    Check,
    check_named,
    check_numbers,
    check_varied_supports,
)
from vibropipe.scenes.keys.parts import FigureOptions, Law, VariedName, figure_key
from vibropipe.scenes.keys.problems import Problem, argument_path, describe, refused
from vibropipe.scenes.keys.ties import TiedScene
from vibropipe.scenes.keys.values import (
    Interval,
    NameRule,
    NumberOrUnit,
    NumberRange,
    Rule,
    as_number,
    number_hint,
    refuse,
)
from vibropipe.solve.boundary.sought import BOUNDARIES, check_levels, level_of
from vibropipe.words.parameters import DEFAULTS, PARAMETERS, RIGID_AT_ZERO, SOFT_ALONG
from vibropipe.words.records import FINITE

# Curves of a kind that some lines find, points of a curve, and the seconds and bytes of a point, as usual.
USUAL_LINES, USUAL_CURVES, USUAL_POINTS, SECONDS_PER_POINT, POINT_BYTES = 12, 4, 300, 2e-4, 120
# Seconds of a point of a level curve, whose quantity is computed as those of steady states are.
SECONDS_PER_LEVEL_POINT = 1e-2
CurveKinds = EachOnce[Literal["grazing", "fold", "flip", "pitchfork", "level"]]


@dataclass(frozen=True)
class SoughtRule(Rule):
    """A kind of bifurcation, or quantities with the values whose curves are sought."""

    allowed = (
        f"{', '.join(BOUNDARIES)} or a quantity with its value ({{impact_velocity_max_1: 0.8}})"
    )

    @property
    def schema(self) -> dict[str, Any]:  # noqa: D102 - as Rule
        level = {"additionalProperties": NumberOrUnit().schema, "minProperties": 1}
        return {"anyOf": [{"enum": [*BOUNDARIES]}, {"type": "object", **level}]}

    def convert(self, value: Any) -> str | dict[str, float]:  # noqa: D102
        if isinstance(value, str) and value in BOUNDARIES:
            return value
        if not isinstance(value, dict) or not value:
            refuse(self.allowed)
        return {str(name): _level(str(name), number) for name, number in value.items()}


def _level(name: str, value: Any) -> float:
    """Return the value of a quantity whose curve is sought, or refuse it."""
    number = as_number(value)
    if number is None or not FINITE.contains(number):
        refuse(f"{FINITE.text} for {name}", describe(value), number_hint(value))
    return number


class BoundaryFigure(FigureOptions):
    """Options of the picture of boundaries."""

    show: CurveKinds = Field(
        default=[],
        description="Kinds of curves that are drawn, level curves as `level` (default: all of `of`).",
    )
    map: Annotated[str | None, NameRule()] = Field(
        default=None,
        description="Sweep over the same two parameters, whose regimes are drawn under the curves.",
    )


class BoundaryScene(TiedScene):
    """Curves of bifurcations, and of values of quantities, in two parameters."""

    FOLLOWS_TIES = True
    kind: Literal["boundary"] = Field(
        description="Curves of bifurcations, and of values of quantities, in two parameters."
    )
    figure: BoundaryFigure = figure_key(BoundaryFigure, "picture")
    of: Annotated[
        list[Annotated[Any, SoughtRule()]], AfterValidator(each_once), Field(min_length=1)
    ] = Field(
        description="Kinds of bifurcations, and quantities with their values, named as columns of tables are: "
        "`{impact_velocity_max_1: 0.8}`; with `physical` `{impact_velocity_max_1: 0.8 m/s}`."
    )
    over: Annotated[dict[VariedName, Interval], Field(min_length=2, max_length=2)] = Field(
        description="Ends of both parameters, or names of one's own in `ties`, in the order of the axes."
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
    def sought(self) -> list[str | dict[str, float]]:
        """What is sought, in an order that that of the study does not change."""
        return sorted(self.of, key=str)

    @property
    def bifurcations(self) -> list[str]:
        """The kinds of bifurcations that are sought."""
        return [each for each in self.sought if isinstance(each, str)]

    @property
    def row_count(self) -> int:  # noqa: D102 - as BaseScene
        return len(self.of)

    def first_values(self) -> dict[str, float]:  # noqa: D102 - as TiedScene
        return {str(name): ends[0] for name, ends in self.over.items()}

    def data_keys(self) -> dict[str, Any]:  # noqa: D102 - as BaseScene
        keys = super().data_keys()
        # As a list, since the order is that of the axes.
        return {**keys, "over": list(keys["over"].items()), "of": sorted(keys["of"], key=str)}

    def extent(self) -> dict[str, Any]:
        """Return each parameter with the ends of its values; what is tied with those at samples of the box."""
        ends = {str(name): np.array(ends) for name, ends in self.over.items()}
        if self.tied():
            ends |= self.tied_at(self.sampled())
        known = {name: each for name, each in ends.items() if name in PARAMETERS}
        return {**self.resolved_exciter(), **known}

    def sampled(self) -> dict[str, Any]:
        """Return what varies at samples of the box, in rows."""
        ranges = [np.linspace(low, high, SAMPLES) for low, high in self.over.values()]
        grids = np.meshgrid(*ranges)
        return {str(name): grid.ravel() for name, grid in zip(self.over, grids, strict=True)}

    def called_effects(self) -> tuple[str, ...]:
        """Return the effects that orbits within the box may need."""
        values = self.extent()
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
        yield L_REQUIRED
        return
    try:
        values = scene.extent()
        at = {**DEFAULTS, **values, **scene.sampled()}
        followed = scene.tied().followed(at, scene.along)
        Exciter(**scene.resolved_exciter())
        check_first_harmonic(values)
        all_effects(values, pieces=True, housing=True)
    except ParameterError as error:
        path = argument_path(error)
        yield refused(path if len(path) > 1 else ("exciter", *path), error)
        return
    lows = {name: ends[0] for name, ends in scene.over.items() if name in PARAMETERS}
    lows |= {name: float(np.min(each)) for name, each in followed.items()}
    yield from check_varied_supports(scene, "over", lows)


def _levels(scene: BoundaryScene) -> Iterator[Problem]:
    """Check the quantities whose values are sought, as `vibropipe.boundary` does."""
    largest = {name: np.max(each) for name, each in scene.extent().items()}
    for n, each in enumerate(scene.of):
        for name, value in each.items() if isinstance(each, dict) else ():
            try:
                level = level_of(name, value)
            except ParameterError as error:
                yield refused(("of", n, name), error)
                continue
            try:
                check_levels(largest, [level])
            except ParameterError as error:
                yield refused(("exciter", error.name), error)


def _figure(scene: BoundaryScene) -> Iterator[Problem]:
    """Check that the kinds to show are among those that are sought."""
    kinds = list(dict.fromkeys(each if isinstance(each, str) else "level" for each in scene.of))
    for name in scene.figure.show:
        if name not in kinds:
            allowed = f"a kind of curve that `of` has ({', '.join(kinds)})"
            yield Problem(("figure", "show"), repr(str(name)), allowed)


CHECKS = (
    TIES,
    TOGETHER,
    Check((("over",),), _parameters),
    Check((("over",), ("exciter",)), _exciter),
    Check((("of",), ("over",), ("exciter",)), _levels),
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
    usual = USUAL_CURVES * USUAL_POINTS * scene.lines / USUAL_LINES
    points, levels = len(scene.of) * usual, len(scene.of) - len(scene.bifurcations)
    seconds = points * SECONDS_PER_POINT + levels * usual * SECONDS_PER_LEVEL_POINT
    return Work(
        size=" x ".join(_range_text(scene, str(name), ends) for name, ends in scene.over.items()),
        rows=scene.row_count,
        seconds=seconds * slowness(scene),
        bytes=HEAD_BYTES + points * POINT_BYTES,
        is_foreseen=False,
    )


def _range_text(scene: BoundaryScene, name: str, ends: Sequence[float]) -> str:
    (first, last), unit = stored_values(scene, name, ends)
    return f"{scene.as_written(name)} {first} to {last}{unit}"
