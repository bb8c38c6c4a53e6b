"""Keys of motion scenes."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, Field, model_validator

from vibropipe.physics.limits import MAX_SAMPLES, MAX_TAU, SAMPLES_PER_PERIOD, max_march_steps
from vibropipe.scenes.costs import (
    HEAD_BYTES,
    IMPACT_BYTES,
    USUAL_IMPACTS,
    Work,
    slowness,
    steady_bytes,
    stored_values,
)
from vibropipe.scenes.keys.base import BaseScene, EachOnce, Harmonics, Outputs, each_once
from vibropipe.scenes.keys.checks import (
    EFFECTS,
    EXCITER,
    EXCITER_CHECK,
    HOUSING,
    SOLVER,
    SUPPORTS,
    TIES,
    TOGETHER,
    Check,
    check_drawn_together,
    check_start,
)
from vibropipe.scenes.keys.effects import EFFECTS_TEXT, ForcedScene, StatedEffects
from vibropipe.scenes.keys.parts import FigureOptions, Solver, Start, figure_key
from vibropipe.scenes.keys.problems import KeyPath, Problem
from vibropipe.scenes.keys.proofs import PROVE, ProveKey, proof_seconds, prove_key, with_picture
from vibropipe.scenes.keys.ties import TiedScene
from vibropipe.scenes.keys.values import Name, NumberOrUnit, NumberRange, TextRule
from vibropipe.scenes.motion.ramp_keys import RAMP, RampEnds, RampKey
from vibropipe.words.outputs import MOTION_DEFAULT, OF_ORBIT

SECONDS_PER_STEP = 10e-9
SECONDS_PER_PERIOD = 1e-6


class MotionFigure(FigureOptions):
    """Options of the pictures of a motion."""

    pictures: EachOnce[
        Literal[
            "panels", "impacts", "ramp", "portrait", "section", "spectrum", "energy", "certificate"
        ]
    ] = Field(
        default=[],
        description="Pictures: curves over tau, impact velocities over tau, displacements over the frequency of a "
        "ramp, the phase portrait, the Poincaré section, the spectrum, the energy or the certificate (default: curves "
        "or impact velocities, as fits; with `ramp` the ramp; with `prove` the certificate, too).",
    )
    together: Annotated[list[Name], Field(max_length=5), AfterValidator(each_once)] = Field(
        default=[],
        description="Up to five other motions, which are drawn beside this one on common axes, and not by themselves.",
    )
    heads: Annotated[list[Annotated[str, TextRule(20)]], Field(max_length=6)] = Field(
        default=[],
        description="What stands above the motions on common axes, this one first (default: the names of the scenes).",
    )
    show: EachOnce[Literal["force", "displacement", "velocity"]] = Field(
        default=[], description="Panels of the curves (default: all that differ from zero)."
    )
    periods: Annotated[float | None, NumberRange(0, 10**6, above=True)] = Field(
        default=None,
        description="Forcing periods to draw, up to the end of the record (default: all).",
    )


class MotionScene(TiedScene, ForcedScene):
    """One motion from a given start."""

    COMPUTES_PIECES = True
    COMPUTES_HOUSING = True
    kind: Literal["motion"] = Field(description="One motion from a given start.")
    figure: MotionFigure = figure_key(MotionFigure)
    tau_end: Annotated[float, NumberOrUnit(0, MAX_TAU, above=True)] = Field(
        default=60.0,
        description="Length of the record, after the transient, in tau; with `physical` in s or with a unit, and left "
        "out 60 sqrt(m/C), which is tau = 60.",
    )
    settle_periods: Annotated[int, NumberRange(0, 10**9, whole=True)] = Field(
        default=0,
        description="Transient left out of the record, in forcing periods; tau counts from the start.",
    )
    start: Start = Field(default_factory=Start, description="State at tau = 0.")
    ramp: RampKey = Field(
        default={},
        description="Change the frequency linearly through the record, whose length is `within` in place of `tau_end`: "
        "`{nu: {from: 0.6, to: 1.6, within: 600}}`; without a housing that slides. What "
        "the motion settles on when held at the last frequency is compared to what starts from rest there.",
    )
    solver: Solver = Field(
        default_factory=Solver, description="Method and step size, or an accuracy."
    )
    samples_per_period: Annotated[int, NumberRange(*SAMPLES_PER_PERIOD, whole=True)] = Field(
        default=256, description="Recorded samples per forcing period; 0 records none."
    )
    harmonics: Harmonics = Field(default=6, description="Number of harmonics.")
    outputs: Outputs = Field(
        default=list(MOTION_DEFAULT), description="Quantities to compute and store."
    )
    effects: StatedEffects = Field(default=None, description=EFFECTS_TEXT)
    prove: ProveKey = prove_key("the steady state")

    @model_validator(mode="after")
    def _draw_certificate(self) -> Self:
        with_picture(self, "panels" if has_samples(self) else "impacts")
        if (ends := self.ramp_ends) is not None and "tau_end" not in self.model_fields_set:
            object.__setattr__(self, "tau_end", ends.within)
        return self

    @property
    def ramp_ends(self) -> RampEnds | None:
        """The ends of the ramp of nu; None without one."""
        return next(iter(self.ramp.values()), None)

    @property
    def highest(self) -> float:
        """The highest frequency in the record."""
        nu, ends = self.resolved_exciter()["nu"], self.ramp_ends
        return nu if ends is None else max(nu, ends.to)

    def given_exciter(self) -> dict[str, float]:  # noqa: D102 - as BaseScene
        given, ends = super().given_exciter(), self.ramp_ends
        return given if ends is None or ends.begin is None else {**given, "nu": ends.begin}

    def tau_span(self) -> tuple[float, float]:
        """Return tau at the start and at the end of the record."""
        begin = self.settle_periods * (2 * math.pi / self.resolved_exciter()["nu"])
        return begin, begin + self.tau_end

    def effect_bounds(self) -> tuple[float, dict[str, Any]]:  # noqa: D102 - as ForcedScene
        # The steady state is found by marching beyond the end of the record.
        span = math.inf if OF_ORBIT & set(self.outputs) else self.tau_span()[1]
        return span, {"exact": self.solver.arguments().get("method") == "exact"}


def _length(scene: MotionScene) -> Iterator[Problem]:
    """Check the end of the motion and the numbers of samples and steps."""
    begin, end = scene.tau_span()
    period = 2 * math.pi / scene.highest
    if end > MAX_TAU:
        path: KeyPath = ("settle_periods",) if begin > scene.tau_end else ("tau_end",)
        must = f"must end the motion at tau = {MAX_TAU:g} or before"
        yield Problem(path, f"tau = {end:.10g}", must=must)
        return
    samples = scene.tau_end / period * scene.samples_per_period
    if samples > MAX_SAMPLES:
        must = f"must give at most {MAX_SAMPLES:g} samples in a record"
        yield Problem(("samples_per_period",), f"{samples:.3g} samples", must=must)
    per_period = scene.solver.steps_per_period or 0
    steps, most = end / period * per_period, max_march_steps(per_period)
    if steps > most:
        must = f"must give at most {most:g} steps"
        yield Problem(("solver", "steps_per_period"), f"{steps:.3g} steps", must=must)


# Outputs that pictures need; one of them suffices.
PICTURE_NEEDS = {
    "panels": ("motion",),
    "ramp": ("motion",),
    "portrait": ("motion",),
    "section": ("motion", "impacts"),
    "spectrum": ("harmonics",),
    "energy": ("energy",),
}


OF_CURVES = "must be left out unless pictures have panels, of a motion with samples"


def _figure(scene: MotionScene) -> Iterator[Problem]:
    """Check that outputs hold what the chosen pictures need, and that samples are recorded for curves."""
    outputs, is_sampled = set(scene.outputs), has_samples(scene)
    if scene.figure.show and not draws_curves(scene):
        yield Problem(("figure", "show"), ", ".join(scene.figure.show), must=OF_CURVES)
    for picture in scene.figure.pictures:
        needed = PICTURE_NEEDS.get(picture, ())
        if needed == ("motion",) and not is_sampled:
            must = f"must leave out {picture} unless outputs have motion and samples_per_period is above 0"
            yield Problem(
                ("figure", "pictures"), f"{picture} of a motion without samples", must=must
            )
        elif needed and not outputs & set(needed):
            must = f"must leave out {picture} unless outputs have {' or '.join(needed)}"
            yield Problem(("figure", "pictures"), repr(str(picture)), must=must)


def draws_curves(scene: MotionScene) -> bool:
    """Return whether the panels of a motion with samples are drawn."""
    chosen = scene.figure.pictures
    return has_samples(scene) and ("panels" in chosen or not (chosen or scene.ramp))


def has_samples(scene: Any) -> bool:
    """Return whether a scene is a motion whose displacement and velocity are stored."""
    is_motion = scene.kind == "motion"
    return is_motion and "motion" in scene.outputs and scene.samples_per_period > 0


def check_motions_together(
    scene: MotionScene, scenes: Mapping[str, BaseScene], broken: Collection[str]
) -> Iterator[Problem]:
    """Check that the motions on common axes have samples."""
    what = "another motion with samples, not a ramp"
    yield from check_drawn_together(
        scene, scenes, broken, what, lambda other: has_samples(other) and not other.ramp
    )
    if scene.figure.together and not scene.ramp and not draws_curves(scene):
        yield Problem(("figure", "together"), ", ".join(scene.figure.together), must=OF_CURVES)


CHECKS = (
    TIES,
    TOGETHER,
    EXCITER_CHECK,
    Check((*SUPPORTS, ("start", "x0")), check_start),
    SOLVER,
    HOUSING,
    Check(
        (*EXCITER, ("tau_end",), ("settle_periods",), ("samples_per_period",), ("solver",)), _length
    ),
    Check((*EFFECTS.reads, ("tau_end",), ("settle_periods",)), EFFECTS.problems),
    Check((("figure",), ("outputs",), ("samples_per_period",)), _figure),
    PROVE,
    RAMP,
)


def plan(scene: MotionScene) -> Work:
    """Return the work of a motion, from its periods and the steps of Newmark's method."""
    recorded = scene.tau_end * scene.highest / (2 * math.pi)
    periods = scene.settle_periods + recorded
    steps = scene.solver.arguments().get("steps_per_period", 0)
    stored = HEAD_BYTES + USUAL_IMPACTS * recorded * IMPACT_BYTES
    if "motion" in scene.outputs:
        # Variables of a sample: tau, displacement, velocity, force; with newmark also the two of the exact motion.
        stored += scene.samples_per_period * recorded * 8 * (6 if steps else 4)
    if OF_ORBIT & set(scene.outputs):
        stored += steady_bytes(scene.outputs, scene.harmonics, effects=scene.all_effects())
    (end,), unit = stored_values(scene, "tau", [scene.tau_end])
    return Work(
        size=f"{scene.as_written('tau')} {end}{unit}",
        rows=1,
        method=_method(scene),
        outputs=tuple(scene.outputs),
        seconds=periods * (SECONDS_PER_PERIOD + steps * SECONDS_PER_STEP) * slowness(scene)
        + proof_seconds(scene.prove),
        bytes=stored,
    )


def _method(scene: MotionScene) -> str:
    solver = scene.solver.arguments()
    if "accuracy" in solver:
        return f"accuracy {solver['accuracy']:g}"
    steps = solver.get("steps_per_period")
    return f"{solver['method']}, {steps} steps" if steps else str(solver["method"])
