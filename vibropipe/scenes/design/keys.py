"""Keys of design scenes."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, WithJsonSchema, model_validator

from vibropipe.physics.exciter import ParameterError
from vibropipe.scenes.costs import HEAD_BYTES, Work, slowness, steady_bytes
from vibropipe.scenes.keys.base import EachOnce
from vibropipe.scenes.keys.checks import (
    EXCITER,
    TIES,
    TOGETHER,
    Check,
    check_vary,
    check_vary_corners,
)
from vibropipe.scenes.keys.effects import VariedScene
from vibropipe.scenes.keys.parts import FigureOptions, ParameterName, Start, VariedName, figure_key
from vibropipe.scenes.keys.problems import Problem, argument_path, refused
from vibropipe.scenes.keys.proofs import PROVE, ProveKey, proof_seconds, prove_key, with_picture
from vibropipe.scenes.keys.values import (
    DECIMAL_COMMA,
    Interval,
    NumberOrUnit,
    NumberRange,
    Sigma,
    TextRule,
    as_number,
    refuse,
)
from vibropipe.words.designs import DESIGN_SAMPLES, DESIGNS
from vibropipe.words.outputs import OF_STEADY_STATE
from vibropipe.words.units import MINUS
from vibropipe.words.vocabulary import PLACES

# Seconds of a sample, of a search from one, of the margin of a design, of its scattered parts; searches of a front and
# samples of the sweeps that it is sought by; seconds of the place of a bifurcation, which the trials of a search need.
PLACE_SECONDS, TRIALS = 3e-3, 30
SAMPLE_SECONDS, SEARCH_SECONDS, DESIGN_SECONDS, YIELD_SECONDS = 1e-4, 0.15, 0.1, 0.3
SEARCHES, FRONT_SEARCHES, FRONT_SAMPLES = 12, 20, 35_000
Text = Annotated[str, TextRule(200)]
NAMES_SCHEMA = {
    "anyOf": [{"type": "string"}, {"type": "array", "items": {"type": "string"}, "maxItems": 2}]
}


@dataclass(frozen=True)
class TargetRule(NumberOrUnit):
    """A number, or a curve: a list of pairs of phase, in forcing periods, and displacement."""

    allowed = "a finite number or, of displacement, a list of pairs [phase, displacement]"

    @property
    def schema(self) -> dict[str, Any]:  # noqa: D102
        pair = {"type": "array", "items": super().schema, "minItems": 2, "maxItems": 2}
        return {"anyOf": [super().schema, {"type": "array", "items": pair, "minItems": 1}]}

    def convert(self, value: Any) -> Any:  # noqa: D102
        if not isinstance(value, list):
            return super().convert(value)
        pairs = [[as_number(part) for part in pair] for pair in value if isinstance(pair, list)]
        complete = all(len(pair) == 2 and None not in pair for pair in pairs)
        if len(pairs) != len(value) or not pairs or not complete:
            refuse(self.allowed, f"a list of {len(value)}")
        return pairs


@dataclass(frozen=True)
class BoundRule(TextRule):
    """Bounds of a quantity, as text."""

    allowed = 'bounds in quotes, such as "< 0.8" or "> 0.1, < 0.8"; with units "< 0.8 m/s"'

    def convert(self, value: Any) -> str:  # noqa: D102
        if not isinstance(value, str) or not any(sign in value for sign in "<>"):
            refuse(self.allowed)
        value = value.replace(MINUS, "-")
        if DECIMAL_COMMA.search(value):
            pointed = re.sub(r"(?<=\d),(?=\d)", ".", value)
            refuse(self.allowed, hint=f'write "{pointed}", with a point')
        return super().convert(value)


def _as_list(value: Any) -> Any:
    if isinstance(value, list) and len(value) > 2:
        refuse("a quantity or a list of two", f"a list of {len(value)}")
    return [value] if isinstance(value, str) else value


class DesignFigure(FigureOptions):
    """Options of the pictures of designs."""

    pictures: EachOnce[
        Literal["sketch", "designs", "front", "tornado", "sensitivities", "certificate"]
    ] = Field(
        default=[],
        description="Pictures: design 1 to scale, all designs beside each other, the Pareto front, what each parameter "
        "alone does within its tolerance, the share that each has in the spread, or the certificate (default: sketch "
        "and designs; front and designs of two quantities to be least; of a scene with `prove` the certificate, too).",
    )


class DesignScene(VariedScene):
    """Parameters that give a wanted law of motion."""

    COMPUTES_PIECES = True
    COMPUTES_HOUSING = True
    kind: Literal["design"] = Field(description="Parameters that give a wanted law of motion.")
    figure: DesignFigure = figure_key(DesignFigure)
    vary: Annotated[dict[VariedName, Interval], Field(min_length=1)] = Field(
        description="Ends of each parameter that may be varied."
    )
    target: dict[Text, Annotated[float, TargetRule()]] = Field(
        default={},
        description="Values of quantities, named as columns of tables are: `impact_velocity_max_1`; of `displacement` "
        "a curve, a list of [phase, displacement]; of `fold_omega_up` and the like the place of a bifurcation.",
    )
    subject_to: dict[Text, Annotated[str, BoundRule(200)]] = Field(
        default={}, description='Bounds of quantities: `"< 0.8"`, `"> 0.1, < 0.8"`.'
    )
    minimise: Annotated[
        list[Text], BeforeValidator(_as_list), Field(max_length=2), WithJsonSchema(NAMES_SCHEMA)
    ] = Field(
        default=[],
        description="A quantity to be least, or a list of two for a Pareto front; `-name` for largest. `-yield`: "
        "designs of which most scattered parts keep all goals.",
    )
    tolerance: dict[ParameterName, Sigma] = Field(
        default={},
        description="Standard deviations of parameters, for the yield and spread of each design.",
    )
    allow: dict[Text, Sigma] = Field(
        default={},
        description="How far each target may be off; asks for the yield and the tolerances that the parameters need.",
    )
    start: Start = Field(default_factory=Start, description="Start of every motion.")
    samples: Annotated[int, NumberRange(*DESIGN_SAMPLES, whole=True)] = Field(
        default=512, description="Samples of a round."
    )
    designs: Annotated[int, NumberRange(*DESIGNS, whole=True)] = Field(
        default=8, description="Largest number of designs; a front has up to 16."
    )
    prove: ProveKey = prove_key("design 1")

    @model_validator(mode="after")
    def _with_pictures(self) -> Self:
        if not self.figure.pictures:
            first: Literal["front", "sketch"] = "front" if len(self.minimise) == 2 else "sketch"
            self.figure.pictures.extend((first, "designs"))
        with_picture(self, "sketch")
        return self

    @property
    def row_count(self) -> int:  # noqa: D102 - as BaseScene
        return self.samples

    def arguments(self) -> dict[str, Any]:
        """Return the keyword arguments of `vibropipe.design` other than the exciter."""
        return {
            "vary": self.ranges(),
            "target": dict(self.target),
            "subject_to": dict(self.subject_to),
            "minimise": list(self.minimise),
            "x0": self.start.x0,
            "v0": self.start.v0,
            "tolerance": {str(name): value for name, value in self.tolerance.items()} or None,
            "allow": dict(self.allow) or None,
            "samples": self.samples,
            "designs": self.designs,
            "ties": self.tied().texts,
        }


_GOALS = ("target", "subject_to", "minimise", "tolerance")


def _goals(scene: DesignScene) -> Iterator[Problem]:
    """Check names, bounds and contradictions of what is wanted, as `vibropipe.design` does."""
    from vibropipe.solve.design.goals import check_allow, check_placed, check_presence, goals_of

    arguments = scene.arguments()
    try:
        goals = goals_of(*(arguments[key] for key in _GOALS))
        check_allow(goals, arguments["allow"])
        check_placed(goals, scene.tied())
    except ParameterError as error:
        yield refused(argument_path(error), error)
        return
    try:
        check_presence(scene.resolved_exciter(), goals)
    except ParameterError as error:
        yield refused(("exciter", error.name), error)


CHECKS = (
    TIES,
    TOGETHER,
    Check((("vary",),), check_vary),
    Check((*EXCITER, ("vary",), ("start",)), check_vary_corners),
    Check((*EXCITER, ("vary",), *((key,) for key in _GOALS), ("allow",)), _goals),
    PROVE,
)


def plan(scene: DesignScene) -> Work:
    """Return the work of a search of usual length, which is not known before."""
    is_front = len(scene.minimise) == 2
    searches = SEARCHES + is_front * FRONT_SEARCHES
    seconds = (scene.samples + is_front * FRONT_SAMPLES) * SAMPLE_SECONDS
    seconds += searches * SEARCH_SECONDS * (1 + len(scene.minimise))
    wanted = {*scene.target, *scene.subject_to, *(name.lstrip("-") for name in scene.minimise)}
    if not wanted.isdisjoint(PLACES):
        seconds += (scene.samples + is_front * FRONT_SAMPLES + searches * TRIALS) * PLACE_SECONDS
    if scene.tolerance or scene.allow:
        # Moving inside bounds takes another search for each.
        seconds += SEARCHES * (YIELD_SECONDS + SEARCH_SECONDS)
    names = ", ".join(scene.as_written(str(name)) for name in scene.vary)
    return Work(
        size=f"{scene.samples} samples over {names}",
        rows=scene.row_count,
        outputs=OF_STEADY_STATE,
        seconds=(seconds + scene.designs * DESIGN_SECONDS) * slowness(scene)
        + proof_seconds(scene.prove),
        bytes=HEAD_BYTES + scene.designs * steady_bytes(OF_STEADY_STATE, 3),
        is_foreseen=False,
    )
