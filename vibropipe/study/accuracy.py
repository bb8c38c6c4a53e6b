"""Scenes that show what accuracy costs: motions, each by several methods at several settings."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Annotated, Literal, Protocol

from pydantic import AfterValidator, Field

from vibropipe.physics.exciter import ALLOWED, Exciter, ParameterError
from vibropipe.physics.limits import MAX_TAU, STEPS_PER_PERIOD
from vibropipe.study.base import BaseScene, each_once
from vibropipe.study.grids import Keys
from vibropipe.study.parts import ExciterKeys, Start
from vibropipe.study.problems import Problem
from vibropipe.study.values import Name, Within

Method = Literal["crude", "newmark", "exact", "RK45", "DOP853", "Radau", "heyoka"]
METHODS: tuple[Method, ...] = ("crude", "newmark", "exact", "RK45", "DOP853", "Radau", "heyoka")
PEERS = METHODS[3:]


Methods = Annotated[list[Method], Field(min_length=1), AfterValidator(each_once)]
Steps = Annotated[int, Within(*STEPS_PER_PERIOD, whole=True)]
Tolerance = Annotated[float, Within(1e-14, 0.1)]


class RacedMotion(Keys):
    """One motion on which methods are compared."""

    exciter: ExciterKeys = Field(
        default_factory=ExciterKeys, description="Parameters that differ from the scene's."
    )
    start: Start = Field(default_factory=Start, description="Start of the motion at tau = 0.")
    periods: Annotated[int, Within(1, 10**6, whole=True)] = Field(
        default=20, description="How long it is, in forcing periods."
    )


class AccuracyScene(BaseScene):
    """Error against time of several methods, on several motions."""

    kind: Literal["accuracy"] = Field(description="Error against time of several methods.")
    motions: Annotated[dict[Name, RacedMotion], Field(min_length=1, max_length=24)] = Field(
        description="The motions by name, each with `exciter`, `start` and `periods`."
    )
    methods: Methods = Field(
        default=list(METHODS), description="What is compared; the last four are other packages."
    )
    steps_per_period: Annotated[list[Steps], Field(min_length=1)] = Field(
        default=[16, 64, 256, 1024, 4096, 16384],
        description="Settings of crude and newmark: steps in a forcing period.",
    )
    tolerances: Annotated[list[Tolerance], Field(min_length=1)] = Field(
        default=[1e-4, 1e-7, 1e-10], description="Settings of the other packages."
    )
    peer_periods: Annotated[int, Within(1, 10**6, whole=True)] = Field(
        default=4, description="Forcing periods that the other packages run over at most."
    )
    repeats: Annotated[int, Within(1, 1000, whole=True)] = Field(
        default=7, description="How often each time is taken."
    )

    @property
    def row_count(self) -> int:
        """Number of races: a motion by a method at a setting."""
        return len(self.motions) * sum(len(self.settings(method)) for method in self.methods)

    def settings(self, method: Method) -> list[float]:
        """Return the settings of a method; the exact one has nothing to set."""
        if method == "exact":
            return [0.0]
        return [*(self.steps_per_period if method in METHODS[:2] else self.tolerances)]

    def exciter_of(self, motion: str) -> dict[str, float]:
        """Return the parameters of one motion: its own, else the scene's, else the study's."""
        return {**self.resolved_exciter(), **self.motions[motion].exciter.given()}


class WithMotions(Protocol):
    """A scene whose exciters stand with its motions."""

    _shared: dict[str, float]
    exciter: ExciterKeys

    @property
    def motions(self) -> Mapping[str, RacedMotion]:
        """The motions by name."""

    def exciter_of(self, motion: str) -> dict[str, float]:
        """Return the parameters of one motion."""


def raced_problems(scene: WithMotions) -> Iterator[Problem]:
    """See that each motion has supports with room between them, a start in that room, and an end."""
    shared = {**scene._shared, **scene.exciter.given()}
    for name, motion in scene.motions.items():
        path = ("motions", name)
        if "l" not in shared and "l" not in motion.exciter.given():
            hint = "in the motion, in the scene or in the study's exciter"
            yield Problem((*path, "exciter", "l"), "nothing", ALLOWED["l"], hint)
            continue
        try:
            exciter = Exciter(**scene.exciter_of(name))
        except ParameterError as error:
            found, _, allowed = str(error).partition("allowed is ")
            yield Problem((*path, "exciter", "l"), found.rstrip(" :;"), allowed)
            continue
        try:
            exciter.check_start(motion.start.x0, motion.start.v0)
        except ParameterError:
            words = f"a number from {exciter.lower!r} to {exciter.upper!r} (between the supports)"
            yield Problem((*path, "start", "x0"), repr(motion.start.x0), words)
        if motion.periods * exciter.period > MAX_TAU:
            found = f"a motion until tau = {motion.periods * exciter.period:g}"
            yield Problem((*path, "periods"), found, f"at most tau = {MAX_TAU:g}")
