"""The key `prove` of scenes, which asks for a certificate of an orbit, and its checks."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Annotated, Any

from pydantic import BeforeValidator, Field, WithJsonSchema

from vibropipe.physics.effects import all_effects
from vibropipe.physics.exciter import ParameterError
from vibropipe.scenes.keys.checks import EXCITER, Check
from vibropipe.scenes.keys.grids import StudyModel
from vibropipe.scenes.keys.parts import ParameterName
from vibropipe.scenes.keys.problems import Problem, describe
from vibropipe.scenes.keys.values import NotNull, Sigma, refuse
from vibropipe.words.parameters import DEFAULTS
from vibropipe.words.proofs import BOXED, holds_by_more, kept_from_boxes, range_in_boxes

CERTIFICATE = "certificate"  # its picture
ONE_SECONDS, BOX_SECONDS = 0.1, 0.4  # of an exciter, and of each parameter that may be off
ROW_SECONDS = 0.03  # of a row of a sweep, or of a point of a branch


class Prove(StudyModel):
    """A certificate: whether all exciters within limits keep the orbit."""

    within: dict[ParameterName, Sigma] = Field(
        default={},
        description="How far each parameter may be off, either way, all at once (default: the exciter alone).",
    )

    def limits(self) -> dict[str, float]:
        """Return how far each parameter may be off."""
        return {str(name): off for name, off in self.within.items()}


def prove_key(of: str) -> Any:
    """Return the key `prove` of a kind of scenes; `of` says whose orbit is proved."""
    text = f"Prove the orbit of {of}, and add a certificate to the report (docs/proof.md)."
    return Field(default=None, description=text)


ProveKey = Annotated[Prove | None, NotNull]


def _as_mapping(value: Any) -> Any:
    """Return true as no tolerances, and false as no proof."""
    if isinstance(value, bool):
        return {} if value else None
    if not isinstance(value, (Prove, Mapping)):
        refuse("true, false, or a mapping with the key within")
    return value


ROWS_TEXT = (
    "Prove each orbit on its own: `proved`, `why` and `proved_stable` of {}; with `within` of all exciters that are "
    "off by so much from its own (docs/proof.md)."
)
ProveRows = Annotated[
    Prove | None,
    BeforeValidator(_as_mapping),
    WithJsonSchema({"anyOf": [{"type": "boolean"}, Prove.model_json_schema()]}),
]


def check_prove(scene: Any) -> Iterator[Problem]:
    """Check that a proof is asked for of what can be proved."""
    if scene.prove is None:
        if CERTIFICATE in scene.figure.pictures:
            must = f"must leave out {CERTIFICATE} unless the scene has the key prove"
            yield Problem(("figure", "pictures"), repr(CERTIFICATE), must=must)
        return
    yield from check_limits(scene)
    yield from check_covered(scene.extent(), describe(scene.prove.limits()))


def check_limits(scene: Any) -> Iterator[Problem]:
    """Check how far parameters may be off."""
    for name, off in scene.prove.limits().items():
        path = ("prove", "within", name)
        if name not in BOXED:
            must = f"must be one of {', '.join(BOXED)}"
            yield Problem(path[:2], name, must=must)
        elif name not in scene.varied_names():
            value = scene.resolved_exciter().get(name, DEFAULTS[name])
            allowed = range_in_boxes(name)
            kept = kept_from_boxes(name, scene.extent(), scene.given_exciter().__contains__)
            if kept is not None:
                yield Problem(path, f"{off:.6g}", must=f"must be left out: {kept}")
            elif not (allowed.contains(value - off) and allowed.contains(value + off)):
                must = f"must keep {name} {allowed.text}"
                yield Problem(path, f"{value:.6g} +- {off:.6g}", must=must)


def check_prove_rows(scene: Any) -> Iterator[Problem]:
    """Check that proofs of rows are asked of what can be proved."""
    if scene.prove:
        yield from check_limits(scene)
        yield from check_covered(scene.extent(), "true")


def check_covered(values: Mapping[str, Any], found: str) -> Iterator[Problem]:
    """Check that exciters have no effect that cannot be proved."""
    try:
        effects = all_effects(values, pieces=True)
        beyond = "contact" if effects.no_pull is not None else ""
        beyond = "friction_ratio" if holds_by_more(values) else beyond
    except ParameterError as error:
        beyond = error.name
    if beyond:
        must = f"must be left out: the {beyond} of the exciter is beyond what can be proved"
        yield Problem(("prove",), found, must=must)


def proof_seconds(prove: Prove | None) -> float:
    """Return the usual time of a proof, which grows with the number of parameters of its box."""
    return 0.0 if prove is None else ONE_SECONDS + BOX_SECONDS * len(prove.within)


def row_seconds(prove: Prove | None) -> float:
    """Return the usual time of the proof of a row."""
    return 0.0 if prove is None else ROW_SECONDS + BOX_SECONDS * len(prove.within)


def with_picture(scene: Any, first: str) -> None:
    """Let a scene that asks for a certificate draw it, after its own pictures; `first` is drawn if it chose none."""
    chosen = [*scene.figure.pictures]
    if scene.prove is not None and CERTIFICATE not in chosen:
        pictures = [*(chosen or [first]), CERTIFICATE]
        object.__setattr__(scene, "figure", scene.figure.model_copy(update={"pictures": pictures}))


PROVE = Check((*EXCITER, ("prove",), ("figure",)), check_prove)
