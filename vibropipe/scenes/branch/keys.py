"""Keys of branch scenes."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from pydantic import AfterValidator, BeforeValidator, Field, WithJsonSchema

from vibropipe.physics.effects import effect_names, effects_of
from vibropipe.physics.start import largest_start
from vibropipe.physics.ties import SAMPLES
from vibropipe.scenes.costs import (
    HEAD_BYTES,
    OF_PIECES,
    Work,
    slowness,
    steady_bytes,
    stored_values,
)
from vibropipe.scenes.design.keys import BoundRule, Text
from vibropipe.scenes.keys.base import EachOnce, Harmonics
from vibropipe.scenes.keys.grids import Grid, RangeGrid, StudyModel, ValueGrid
from vibropipe.scenes.keys.parts import (
    FigureOptions,
    Law,
    ParameterName,
    Start,
    VariedName,
    figure_key,
)
from vibropipe.scenes.keys.proofs import ROWS_TEXT, ProveRows, row_seconds
from vibropipe.scenes.keys.ties import TiedScene
from vibropipe.scenes.keys.values import (
    Measured,
    NameRule,
    NotNull,
    Number,
    NumberOrUnit,
    Sigma,
    refuse,
)
from vibropipe.words.outputs import OF_STEADY_STATE
from vibropipe.words.parameters import PARAMETERS
from vibropipe.words.vocabulary import drawn_by

# Points of a branch that its steps usually need, and seconds per point.
USUAL_POINTS, SECONDS_PER_POINT = 400, 1e-4
# Kernels of motions by pieces, as those that rest between rigid supports are followed.
PIECES = "vibropipe.orbits.law.marching"
# Points that parts are scattered at, parts of each, and seconds per part.
MAX_POINTS, PARTS, SECONDS_PER_PART = 32, 1024, 1.5e-4
# The same of all stretches of a law, with what is followed to find them.
LAW_POINTS = 10_000
Switch = Literal["flip", "pitchfork", "grazing"]
_NUMBER = {"type": "number"}
ENDS_SCHEMA = {
    "anyOf": [_NUMBER, {"type": "array", "items": _NUMBER, "minItems": 1, "maxItems": 2}]
}


def _as_list(value: Any) -> Any:
    return value if isinstance(value, list) else [value]


def _one_or_two(ends: list[float]) -> list[float]:
    if not 1 <= len(ends) <= 2:
        refuse("a number or a list of two", f"a list of {len(ends)}")
    return ends


class Along(StudyModel):
    """Where a branch begins, and how far it is followed; or the range in which a law is sought."""

    begin: Number | None = Field(
        default=None,
        alias="from",
        description="Value at which the first orbit settles; required without `law`.",
    )
    to: Annotated[
        list[Number],
        BeforeValidator(_as_list),
        AfterValidator(_one_or_two),
        WithJsonSchema(ENDS_SCHEMA),
    ] = Field(
        default=[],
        description="Value up to which the branch is followed; a list of two for both ways; required without `law`.",
    )
    within: Annotated[list[Number], Field(min_length=2, max_length=2)] | None = Field(
        default=None, description="Beside `law`, in place of both: the range in which it is sought."
    )

    @property
    def first(self) -> float:
        """The value at which the exciter is known."""
        return next(v for v in (self.begin, *(self.within or ()), *self.to, 1.0) if v is not None)

    @property
    def values(self) -> list[float]:
        """Where branches begin and end."""
        return [self.first, *self.to] if self.within is None else [*self.within]


Positive = Annotated[float, NumberOrUnit(0, above=True)]
LINE, CURVE = ("no_load", "stall"), ("speed", "torque")
BOTH = "no_load and stall, or speed and torque"


def _rising(values: list[float]) -> list[float]:
    if not all(one < other for one, other in pairwise(values)):
        refuse("increasing numbers")
    return values


class MotorKeys(StudyModel):
    """What torque a motor gives over its speed: a straight line, or straight lines between points."""

    no_load: Annotated[Positive | None, NotNull] = Field(
        default=None, description="Speed without torque, where the straight line ends (as nu)."
    )
    stall: Annotated[Positive | None, NotNull] = Field(
        default=None, description="Torque at rest, where the straight line begins (power over nu)."
    )
    speed: Annotated[list[Measured], Field(min_length=2), AfterValidator(_rising)] | None = Field(
        default=None, description="Speeds of points that straight lines join, in place of both."
    )
    torque: Annotated[list[Measured], Field(min_length=2)] | None = Field(
        default=None, description="Torques at these speeds; there is none beyond them."
    )

    def given(self) -> Any:
        """Return the torque as `vp.motor` takes it."""
        if self.speed is not None and self.torque is not None:
            return list(zip(self.speed, self.torque, strict=True))
        return {name: getattr(self, name) for name in LINE}


if TYPE_CHECKING:
    Shown = str
else:
    Shown = Literal[drawn_by("branch")]


class BranchFigure(FigureOptions):
    """Options of the pictures of branches."""

    pictures: EachOnce[Literal["motor", "branches"]] = Field(
        default=[],
        description="Pictures to draw (default: `motor` beside the key `motor`, else `branches`).",
    )
    show: EachOnce[Shown] = Field(
        default=["displacement_amplitude", "impact_velocity_max"],
        description="Quantities of the panels.",
    )
    backbone: Annotated[str | None, NameRule()] = Field(
        default=None, description="Backbone scene over `amplitude`, drawn under the branches."
    )


class BranchScene(TiedScene):
    """Orbits followed along a parameter, stable or not, with their bifurcations."""

    COMPUTES_PIECES = True
    COMPUTES_HOUSING = True
    FOLLOWS_TIES = True
    kind: Literal["branch"] = Field(description="Orbits followed along a parameter, stable or not.")
    figure: BranchFigure = figure_key(BranchFigure)
    along: Annotated[dict[VariedName, Along], Field(min_length=1, max_length=1)] = Field(
        description="The parameter, or name of one's own in `ties`, along which orbits are followed."
    )
    over: Annotated[dict[VariedName, Grid], Field(max_length=1)] = Field(
        default={}, description="A further parameter; a branch is followed at each of its values."
    )
    start: Start = Field(
        default_factory=Start, description="Start of the motion that settles on the first orbit."
    )
    at: Grid | None = Field(
        default=None, description="Values of the followed parameter with a point each."
    )
    switch: EachOnce[Switch] = Field(
        default=[], description="Bifurcations at which the branches that begin there are followed."
    )
    law: Law | None = Field(
        default=None,
        description="Period multiple and impacts on each support: all stretches of this law `within` a range are "
        "sought, stable or not, and nothing else is stored.",
    )
    tolerance: dict[ParameterName, Sigma] = Field(
        default={},
        description="Standard deviations of parameters, for the scatter of each bifurcation: "
        "`bifurcation_<parameter>_std`.",
    )
    subject_to: Annotated[dict[Text, Annotated[str, BoundRule(200)]] | None, NotNull] = Field(
        default=None,
        description='Bounds that parts are to keep, `"< 0.8"`, beside `tolerance`: the yield at the stable points of '
        "`at`, or at up to 32 of them; `{}` for that of the law of motion alone.",
    )
    motor: Annotated[MotorKeys | None, NotNull] = Field(
        default=None,
        description="Torque of a motor of limited power over its speed, as `vp.motor` takes it: the speeds that it "
        "keeps, and Sommerfeld's jumps, at each value of `over`.",
    )
    harmonics: Harmonics = Field(default=3, description="Number of harmonics.")
    prove: ProveRows = Field(default=None, description=ROWS_TEXT.format("points"))

    @property
    def followed(self) -> str:
        """The parameter along which orbits are followed."""
        return str(next(iter(self.along)))

    @property
    def ends(self) -> Along:
        """Where branches begin and end."""
        return next(iter(self.along.values()))

    def grids(self) -> dict[str, ValueGrid | RangeGrid]:  # noqa: D102 - as BaseScene
        return {str(name): grid for name, grid in self.over.items()}

    def first_values(self) -> dict[str, float]:  # noqa: D102 - as TiedScene
        swept = {str(name): grid.low for name, grid in self.over.items()}
        return {self.followed: self.ends.first, **swept}

    def data_exciter(self) -> dict[str, float]:  # noqa: D102 - as BaseScene
        values = self.resolved_exciter()
        return {name: value for name, value in values.items() if name not in self.over}

    def extent(self) -> dict[str, Any]:
        """Return each parameter with all the values it may take; of what is tied those at samples of the range."""
        own = {**self.over_arrays(), self.followed: np.array(self.ends.values)}
        if self.tied():
            own |= self.sampled()
            own |= self.tied_at(own)
        known = {name: each for name, each in own.items() if name in PARAMETERS}
        return {**self.resolved_exciter(), **known}

    def sampled(self) -> dict[str, Any]:
        """Return what varies at all values of the further parameter and samples of the followed one, in rows."""
        ends = self.ends.values
        arrays = self.over_arrays() | {self.followed: np.linspace(min(ends), max(ends), SAMPLES)}
        grids = np.meshgrid(*arrays.values(), indexing="ij")
        return {name: grid.ravel() for name, grid in zip(arrays, grids, strict=True)}

    def called_effects(self) -> tuple[str, ...]:
        """Return the effects that orbits between the ends may need."""
        values = self.extent()
        start = largest_start(values, self.start.x0)
        effects = effects_of(values, start, self.start.v0, math.inf, followed=True)
        return effect_names(effects, values)


def plan(scene: BranchScene) -> Work:
    """Return the work of branches of the usual length; how many follow from their bifurcations is not known before."""
    ends, at = len(scene.ends.to), 0 if scene.at is None else scene.at.size
    points = scene.row_count * (ends * USUAL_POINTS + at) * (1 + len(scene.switch))
    if scene.law is not None:
        points = scene.row_count * LAW_POINTS
    parts = scene.row_count * (at or MAX_POINTS) * PARTS * (scene.subject_to is not None)
    return Work(
        size=_size_text(scene),
        rows=scene.row_count,
        outputs=OF_STEADY_STATE,
        seconds=(points * SECONDS_PER_POINT + parts * SECONDS_PER_PART) * slowness(scene)
        + points * row_seconds(scene.prove),
        bytes=HEAD_BYTES + points * steady_bytes(OF_STEADY_STATE, scene.harmonics),
        is_foreseen=False,
        of_rests="" if set(OF_PIECES) & set(scene.called_effects()) else PIECES,
    )


def _size_text(scene: BranchScene) -> str:
    """Write how far branches are followed and at how many values of a further parameter."""
    name = scene.followed
    (begin, *ends), unit = stored_values(scene, name, scene.ends.values)
    swept = [f"{grid.size} {scene.as_written(str(other))}" for other, grid in scene.over.items()]
    followed = f"{scene.as_written(name)} from {begin} to {', '.join(ends)}{unit}"
    return ", ".join([followed, *swept])
