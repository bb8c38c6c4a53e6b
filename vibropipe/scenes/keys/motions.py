"""Scenes of several motions, each with its own exciter and start."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import Field

from vibropipe.physics.effects import all_effect_names, all_effects
from vibropipe.physics.exciter import Exciter, ParameterError
from vibropipe.physics.limits import MAX_TAU
from vibropipe.scenes.keys.base import BaseScene, resolved_start
from vibropipe.scenes.keys.checks import frequency_required
from vibropipe.scenes.keys.grids import StudyModel
from vibropipe.scenes.keys.parts import ExciterKeys, PhysicalKeys, Start
from vibropipe.scenes.keys.problems import Problem, refused, required
from vibropipe.scenes.keys.values import NotNull, NumberRange
from vibropipe.words.parameters import FORCES, FURTHER, PARAMETERS, or_default


class MotionKeys(StudyModel):
    """One motion of a scene of several."""

    exciter: ExciterKeys = Field(
        default_factory=ExciterKeys,
        description="Parameters of this motion, in place of the scene's.",
    )
    physical: Annotated[PhysicalKeys | None, NotNull] = Field(
        default=None,
        description="Parameters of this motion with units; for a study with `physical`.",
    )
    start: Start = Field(default_factory=Start, description="State at tau = 0.")
    periods: Annotated[int, NumberRange(1, 10**6, whole=True)] = Field(
        default=20, description="Length of the motion, in forcing periods."
    )


class SetOfMotions(BaseScene):
    """A scene of several motions, each with its own exciter."""

    if TYPE_CHECKING:  # each kind describes this key itself
        motions: Mapping[str, MotionKeys]

    def exciter_of(self, motion: str) -> dict[str, float]:
        """Return the parameters of one motion: its own, else the scene's, else the study's."""
        return {**self.resolved_exciter(), **self.motions[motion].exciter.explicit()}

    def starts(self) -> dict[str, tuple[Exciter, float, float, int]]:
        """Return exciter, x0, v0 and forcing periods of each motion."""
        return {
            name: (exciter, *exciter.check_start(of.start.x0, of.start.v0), of.periods)
            for name, of in self.motions.items()
            for exciter in [Exciter(**self.exciter_of(name))]
        }

    def extent(self) -> dict[str, Any]:  # noqa: D102 - as BaseScene
        exciters = [self.exciter_of(name) for name in self.motions]
        names = dict.fromkeys(name for each in exciters for name in each)
        return {name: [or_default(each, name) for each in exciters] for name in names}

    def called_effects(self) -> tuple[str, ...]:
        """Return all effects, since the motions compare them."""
        exciters = [self.exciter_of(name) for name in self.motions]
        further = {name: [or_default(each, name) for each in exciters] for name in FURTHER}
        return all_effect_names(further, **self.computed())

    def data_keys(self) -> dict[str, Any]:  # noqa: D102 - as BaseScene
        keys = super().data_keys()
        for name, motion in keys["motions"].items():
            del motion["physical"]  # its exciter has them without units
            own = motion["exciter"].items()
            motion["exciter"] = {n: v for n, v in own if n not in FURTHER or v is not None}
            motion["start"] = resolved_start(motion["start"], self.exciter_of(name))
        return keys


def check_motions(scene: SetOfMotions) -> Iterator[Problem]:
    """Check that each motion has distinct supports, a start between them, and an end within MAX_TAU."""
    shared = scene.given_exciter()
    for name, motion in scene.motions.items():
        path = ("motions", name)
        if "l" not in shared and "l" not in motion.exciter.explicit():
            where = ", in the motion, in the scene or in the study"
            yield required((*path, "exciter", "l"), PARAMETERS["l"].range.text, where)
            continue
        own = {**shared, **motion.exciter.explicit()}
        if "nu" not in own and any(own.get(force, 0.0) != 0.0 for force in FORCES):
            yield frequency_required((*path, "exciter", "nu"))
            continue
        try:
            exciter = Exciter(**scene.exciter_of(name))
            all_effects(vars(exciter), **scene.computed())
        except ParameterError as error:
            yield refused((*path, "exciter", error.name), error)
            continue
        try:
            exciter.check_start(motion.start.x0, motion.start.v0)
        except ParameterError as error:
            yield refused((*path, "start", "x0"), error)
        if motion.periods * exciter.period > MAX_TAU:
            found = f"tau = {motion.periods * exciter.period:.10g}"
            must = f"must end the motion at tau = {MAX_TAU:g} or before"
            yield Problem((*path, "periods"), found, must=must)
