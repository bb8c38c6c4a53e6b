"""The key `motor` of branches along the frequency: a motor of limited power drives the exciter."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Annotated, Any

from pydantic import AfterValidator, Field

from vibropipe.scenes.keys.grids import StudyModel
from vibropipe.scenes.keys.problems import Problem, required
from vibropipe.scenes.keys.values import Measured, NotNull, NumberOrUnit, refuse

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


def check_motor(scene: Any) -> Iterator[Problem]:
    """Check that a motor has one torque at each speed, and drives branches along the frequency alone."""
    if scene.motor is None:
        if "motor" in scene.figure.pictures:
            must = "must leave out motor unless the scene has the key motor"
            yield Problem(("figure", "pictures"), "'motor'", must=must)
        return
    stated = [name for name in (*LINE, *CURVE) if getattr(scene.motor, name) is not None]
    if not stated:
        yield required(("motor",), BOTH)
        return
    own, others = (LINE, CURVE) if stated[0] in LINE else (CURVE, LINE)
    for name in own:
        if name not in stated:
            yield required(("motor", name), BOTH)
    for name in others:
        if name in stated:
            must = f"must be left out beside {stated[0]}: a motor has {BOTH}"
            yield Problem(("motor", name), "", must=must)
    speeds, torques = scene.motor.speed or [], scene.motor.torque or []
    if own == CURVE and len(stated) == len(own) and len(speeds) != len(torques):
        yield Problem(
            ("motor", "torque"), f"{len(torques)} values", f"{len(speeds)}, one for each speed"
        )
    if scene.followed != "nu":
        must = "must be left out unless the frequency is followed, which a motor turns with"
        yield Problem(("motor",), "", must=must)
    if scene.tolerance:
        must = "must be left out beside motor: speeds and jumps have no scatter"
        yield Problem(("tolerance",), "", must=must)
