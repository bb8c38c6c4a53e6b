"""The models of a study: what each kind of scene may say, key by key.

Every key has a description: the JSON schema and the table of keys in `config/README.md` are made
from these classes. Rules that tie several keys together stand in `checks.py`. A new kind of scene
is a class (here, or in a file of its own), an entry in `Scene` and `KINDS`, and its rules there.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, ClassVar, Literal

from pydantic import AfterValidator, Discriminator, Field, PrivateAttr, Tag

from vibropipe.physics.limits import MAX_TAU, PATIENCE, SAMPLES_PER_PERIOD
from vibropipe.study.accuracy import AccuracyScene
from vibropipe.study.base import DEFAULTS, BaseScene, Harmonics, Outputs, Prose, Title, each_once
from vibropipe.study.effect_costs import EffectsScene
from vibropipe.study.grids import Grid, Keys, RangeGrid, ValueGrid
from vibropipe.study.parts import ExciterKeys, Follow, ParameterName, Solver, Start
from vibropipe.study.problems import Problem, StudyError, did_you_mean
from vibropipe.study.values import Name, Within, Written

Effect = Literal["damping", "forcing", "support_1", "support_2", "restitution", "rest"]
StatedEffects = Annotated[list[Effect] | None, AfterValidator(each_once), Written]
EFFECTS_WORDS = "Physics to compute with, nothing else; left out, what the scene calls for."


class MotionScene(BaseScene):
    """One motion from a given start."""

    kind: Literal["motion"] = Field(description="One motion from a given start.")
    tau_end: Annotated[float, Within(0, MAX_TAU, above=True)] = Field(
        default=60.0, description="How long the recorded motion is, after the settling."
    )
    settle_periods: Annotated[int, Within(0, 10**9, whole=True)] = Field(
        default=0, description="Forcing periods run before the record begins; tau is counted on."
    )
    start: Start = Field(default_factory=Start, description="Start of the motion at tau = 0.")
    solver: Solver = Field(default_factory=Solver, description="How it is computed.")
    samples_per_period: Annotated[int, Within(*SAMPLES_PER_PERIOD, whole=True)] = Field(
        default=256, description="Recorded samples in a forcing period; 0 records no motion."
    )
    harmonics: Harmonics = Field(
        default=6, description="How many harmonics, where they are asked for."
    )
    outputs: Outputs = Field(
        default=["motion", "impacts"], description="What is computed and stored, nothing else."
    )

    effects: StatedEffects = Field(default=None, description=EFFECTS_WORDS)

    def tau_span(self) -> tuple[float, float]:
        """Return tau at the beginning and at the end of the record."""
        begin = self.settle_periods * (2 * math.pi / self.resolved_exciter()["nu"])
        return begin, begin + self.tau_end


class SweepScene(BaseScene):
    """Steady states over every combination of some parameters."""

    kind: Literal["sweep"] = Field(description="Steady states over some parameters.")
    over: Annotated[dict[ParameterName, Grid], Field(min_length=1)] = Field(
        description="Grid of each swept parameter; their order is the order of the dimensions."
    )
    start: Start = Field(
        default_factory=Start, description="Start of every row; or else `follow`, never both."
    )
    follow: Annotated[Follow | None, Written] = Field(
        default=None, description="Start each row from its neighbour."
    )
    harmonics: Harmonics = Field(default=3, description="How many harmonics.")
    outputs: Outputs = Field(
        default=["harmonics", "impacts", "stability"],
        description="What is computed and stored, nothing else.",
    )
    solver: Solver = Field(
        default_factory=Solver, description="Exact, or an accuracy, which exact meets."
    )
    patience: Annotated[int, Within(*PATIENCE, whole=True)] = Field(
        default=300, description="Forcing periods after which a chaotic row is left as aperiodic."
    )
    effects: StatedEffects = Field(default=None, description=EFFECTS_WORDS)

    def grids(self) -> dict[str, ValueGrid | RangeGrid]:  # noqa: D102 - as BaseScene
        return {str(name): grid for name, grid in self.over.items()}

    def resolved_exciter(self) -> dict[str, float]:  # noqa: D102 - as BaseScene
        return {
            **super().resolved_exciter(),
            **{name: grid.low for name, grid in self.over.items()},
        }

    def follow_pair(self) -> tuple[str, str] | None:
        """Return `follow` as `vibropipe.sweep` takes it: ("nu", "up"), or None."""
        return (self.follow.along, self.follow.direction) if self.follow else None


class BackboneScene(BaseScene):
    """Free motion without loss: eq. (10) over the period, or eigenfrequency over amplitude."""

    GRIDS: ClassVar[tuple[str, ...]] = ("delta_over_l", "tau_bar", "amplitude")

    kind: Literal["backbone"] = Field(description="Free motion without force and loss.")
    delta_over_l: Annotated[Grid | None, Written] = Field(
        default=None, description="Offsets of the curves of eq. (10), within (-1, 1)."
    )
    tau_bar: Annotated[Grid | None, Written] = Field(
        default=None, description="Periods of the curves, above 0; with `delta_over_l`."
    )
    check_points: Annotated[int, Within(0, 1000, whole=True)] = Field(
        default=6, description="Simulated motions set on each curve."
    )
    amplitude: Annotated[Grid | None, Written] = Field(
        default=None,
        description="Amplitudes of the free motion, above 0; instead of the two above.",
    )
    harmonics: Harmonics = Field(default=3, description="How many harmonics over `amplitude`.")

    @property
    def over_amplitude(self) -> bool:
        """Whether the scene runs over `amplitude` rather than along eq. (10)."""
        return "amplitude" in self.model_fields_set

    def grids(self) -> dict[str, ValueGrid | RangeGrid]:  # noqa: D102 - as BaseScene
        return {name: getattr(self, name) for name in self.GRIDS if name in self.model_fields_set}

    def resolved_exciter(self) -> dict[str, float]:
        """Return the parameters of the free motion; along eq. (10) lengths are in units of l."""
        if not self.over_amplitude:
            return {**DEFAULTS, "l": 1.0}
        given = super().resolved_exciter()
        return {**DEFAULTS, "l": given["l"], "delta": given["delta"]}


class HardCasesScene(BaseScene):
    """Motions with known answers on which numerical methods fail, each by every method."""

    kind: Literal["hard_cases"] = Field(
        description="Known motions on which numerical methods fail, by every method."
    )
    cases: Annotated[list[Name], AfterValidator(each_once)] = Field(
        default=[], description="Names of the cases; all of them if left out."
    )

    def resolved_exciter(self) -> dict[str, float]:
        """Return nothing: each case has its own exciter."""
        return {}


KINDS: dict[str, type[BaseScene]] = {
    "motion": MotionScene,
    "sweep": SweepScene,
    "backbone": BackboneScene,
    "hard_cases": HardCasesScene,
    "accuracy": AccuracyScene,
    "effects": EffectsScene,
}


def _kind(value: Any) -> str | None:
    kind = value.get("kind") if isinstance(value, dict) else getattr(value, "kind", None)
    return f"<{kind}>" if isinstance(kind, str) else None


Scene = Annotated[
    Annotated[MotionScene, Tag("<motion>")]
    | Annotated[SweepScene, Tag("<sweep>")]
    | Annotated[BackboneScene, Tag("<backbone>")]
    | Annotated[HardCasesScene, Tag("<hard_cases>")]
    | Annotated[AccuracyScene, Tag("<accuracy>")]
    | Annotated[EffectsScene, Tag("<effects>")],
    Discriminator(_kind),
]


class Study(Keys):
    """A study: shared parameters and named scenes. `name` is the file's, without its ending."""

    title: Title = Field(description="Title of the study and of its report.")
    description: Prose = Field(default="", description="What the study is about; opens the report.")
    exciter: ExciterKeys = Field(
        default_factory=ExciterKeys, description="Parameters shared by all scenes."
    )
    scenes: Annotated[dict[Name, Scene], Field(min_length=1, max_length=1000)] = Field(
        description="The scenes by name; the name becomes the name of files."
    )
    _name: str = PrivateAttr("")
    _source: str = PrivateAttr("")

    def model_post_init(self, context: Any) -> None:
        """Tell each scene its name and the shared parameters."""
        for name, scene in self.scenes.items():
            scene._name = name
            scene._shared = self.exciter.given()

    @property
    def name(self) -> str:
        """The study's name: its results lie in `results/<name>`."""
        return self._name

    @property
    def source(self) -> str:
        """The file the study was read from, as messages name it."""
        return self._source

    @property
    def fingerprints(self) -> dict[str, str]:
        """What the data of each scene depend on, as its dataset keeps it."""
        from vibropipe.study.identity import fingerprint  # which knows the models

        return {name: fingerprint(self, name) for name in self.scenes}

    def scene(
        self, name: str
    ) -> MotionScene | SweepScene | BackboneScene | HardCasesScene | AccuracyScene | EffectsScene:
        """Return a scene by name; StudyError names the nearest one when there is none such."""
        if name not in self.scenes:
            known = ", ".join(self.scenes)
            problem = Problem(
                ("scenes",), f"no scene {name!r}", known, did_you_mean(name, self.scenes)
            )
            raise StudyError(self._source or "study", [problem])
        return self.scenes[name]
