"""The key `ramp` of motions: the frequency changes linearly through the record."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any

from pydantic import Field

from vibropipe.physics.effects import all_effects
from vibropipe.physics.exciter import Exciter
from vibropipe.physics.limits import MAX_PIECE_STEPS, MAX_TAU
from vibropipe.scenes.keys.checks import EXCITER, Check
from vibropipe.scenes.keys.grids import StudyModel
from vibropipe.scenes.keys.parts import ParameterName
from vibropipe.scenes.keys.problems import Problem, describe, required
from vibropipe.scenes.keys.values import NotNull, NumberOrUnit
from vibropipe.words.outputs import MOTION_DEFAULT

Frequency = Annotated[float, NumberOrUnit(0, 1e9, above=True)]
OF_PERIODS = ("section",)  # pictures that one forcing period underlies


class RampEnds(StudyModel):
    """The ends of a ramp, and its length."""

    begin: Annotated[Frequency | None, NotNull] = Field(
        default=None, alias="from", description="Frequency at the start (default: of the exciter)."
    )
    to: Frequency = Field(description="Frequency at the end; it may be the lower one.")
    within: Annotated[float, NumberOrUnit(0, MAX_TAU, above=True)] = Field(
        description="Length of the ramp, in tau; with `physical` in s or with a unit."
    )


RampKey = Annotated[dict[ParameterName, RampEnds], Field(max_length=1)]


def check_ramp(scene: Any) -> Iterator[Problem]:
    """Check that a ramp is one of the frequency, has two ends, and goes with the other keys."""
    if not scene.ramp:
        if "ramp" in scene.figure.pictures:
            must = "must leave out ramp unless the scene has the key ramp"
            yield Problem(("figure", "pictures"), "'ramp'", must=must)
        return
    name, ends = str(next(iter(scene.ramp))), scene.ramp_ends
    if name != "nu":
        must = "must name the frequency, which alone has a ramp"
        yield Problem(("ramp",), scene.as_written(name), must=must)
        return
    if "nu" not in scene.given_exciter():
        where = ", since the exciter has none"
        yield required(("ramp", name, "from"), "the frequency at the start", where)
        return
    nu = scene.resolved_exciter()["nu"]
    if ends.to == nu:
        must = "must differ from the frequency at the start; leave out ramp for one that stays"
        yield Problem(("ramp", name, "to"), describe(ends.to), must=must)
        return
    yield from _beside(scene)
    if scene.tied_at({"nu": nu}) != scene.tied_at({"nu": ends.to}):
        must = "must not follow nu beside ramp: only the frequency changes on a ramp"
        yield Problem(("ties",), ", ".join(scene.tied().parameters), must=must)
    yield from _covered(scene, abs(ends.to - nu) / ends.within)


def _beside(scene: Any) -> Iterator[Problem]:
    """Check that no key stands beside a ramp that has no meaning there."""
    why = "must be left out beside ramp"
    given, figure = scene.model_fields_set, scene.figure
    reasons = {
        "tau_end": "its within is the length of the record",
        "solver": "it is marched by the exact method",
        "effects": "it has those of the parameters",
        "prove": "a proof is one of a steady state",
    }
    for key, reason in reasons.items():
        if key in given and (value := getattr(scene, key)) is not None:
            if key == "solver" and scene.solver.arguments() == {"method": "exact"}:
                continue
            found = describe(value) if isinstance(value, float | list) else ""
            yield Problem((key,), found, must=f"{why}: {reason}")
    for output in scene.outputs:
        if output not in MOTION_DEFAULT:
            reason = "it is one of a steady state or of a balance"
            must = f"must leave out {output} beside ramp: {reason}"
            yield Problem(("outputs",), repr(str(output)), must=must)
    of_periods = "forcing periods change their length on it"
    for key in ("periods", "together"):
        if value := getattr(figure, key):
            yield Problem(("figure", key), describe(value), must=f"{why}: {of_periods}")
    for picture in figure.pictures:
        if picture in OF_PERIODS:
            must = f"must leave out {picture} beside ramp: {of_periods}"
            yield Problem(("figure", "pictures"), repr(str(picture)), must=must)


def _covered(scene: Any, change: float) -> Iterator[Problem]:
    """Check that a ramp is not too long."""
    values = scene.resolved_exciter()
    if values.get("mass_ratio", 0.0) != 0.0:
        # What settles after the ramp would begin without the velocity of the housing.
        must = "must be left out: the mass_ratio of the exciter is not computed on a ramp"
        yield Problem(("ramp",), "", must=must)
        return
    effects = all_effects(values, pieces=True)
    if not scene.has_l():
        return
    # kernels, which a study without a ramp does not load
    from vibropipe.physics.ramp import longest_step

    p = Exciter(**{**values, "nu": scene.highest}).parameters()
    steps = scene.ramp_ends.within / longest_step(effects, p, change)
    if steps > MAX_PIECE_STEPS:
        must = f"must give at most {MAX_PIECE_STEPS:g} steps of the march"
        yield Problem(("ramp", "nu", "within"), f"{steps:.3g} steps", must=must)


_READ = ("ramp", "ties", "tau_end", "solver", "effects", "outputs", "figure", "prove")
RAMP = Check((*EXCITER, *((key,) for key in _READ)), check_ramp)
