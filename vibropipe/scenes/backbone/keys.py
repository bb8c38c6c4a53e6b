"""Keys of backbone scenes: free motion without losses, in closed form."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping
from contextlib import suppress
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from pydantic import Field

from vibropipe.physics.exciter import Exciter, ParameterError
from vibropipe.scenes.costs import HEAD_BYTES, Work, grid_size
from vibropipe.scenes.keys.base import BaseScene, EachOnce, Harmonics
from vibropipe.scenes.keys.checks import (
    SUPPORTS,
    Check,
    check_drawn_together,
    check_exciter,
    check_rows,
    no_exciter,
    shown_length,
)
from vibropipe.scenes.keys.grids import Grid, RangeGrid, ValueGrid
from vibropipe.scenes.keys.parts import FigureOptions, figure_key
from vibropipe.scenes.keys.problems import KeyPath, Problem, one_of, required
from vibropipe.scenes.keys.values import Name, NotNull, NumberRange
from vibropipe.words.parameters import DEFAULTS, without_absent
from vibropipe.words.vocabulary import drawn_by

if TYPE_CHECKING:
    Shown = str
else:
    Shown = Literal[drawn_by("backbone")]

SECONDS_PER_POINT = 20e-6


class BackboneFigure(FigureOptions):
    """Options of the picture of a backbone."""

    together: EachOnce[Name] = Field(
        default=[],
        description="Other scenes of this study that are drawn over the harmonics of this one, and not by themselves: "
        "backbones over amplitude, and sweeps of the frequency with harmonics.",
    )
    show: EachOnce[Shown] = Field(
        default=[],
        description="Quantities over the eigenfrequency, or abscissae of the curves of eq. (10) (default: all).",
    )  # fmt: skip


class BackboneScene(BaseScene):
    """Free motion without losses: eq. (10) over the period, or the eigenfrequency over the amplitude."""

    GRIDS: ClassVar[tuple[str, ...]] = ("delta_over_l", "tau_bar", "amplitude")

    kind: Literal["backbone"] = Field(description="Free motion without force and losses.")
    figure: BackboneFigure = figure_key(BackboneFigure, "picture")
    delta_over_l: Annotated[Grid | None, NotNull] = Field(
        default=None, description="Relative offsets of the curves of eq. (10), within (-1, 1)."
    )
    tau_bar: Annotated[Grid | None, NotNull] = Field(
        default=None, description="Periods of the curves, above 0; required with `delta_over_l`."
    )
    check_points: Annotated[int, NumberRange(0, 1000, whole=True)] = Field(
        default=6, description="Number of simulated motions on each curve."
    )
    amplitude: Annotated[Grid | None, NotNull] = Field(
        default=None,
        description="Amplitudes of the free motion, above 0; in place of the two grids above.",
    )
    harmonics: Harmonics = Field(default=3, description="Number of harmonics over `amplitude`.")

    @property
    def over_amplitude(self) -> bool:
        """Whether the scene runs over `amplitude` instead of eq. (10)."""
        return "amplitude" in self.model_fields_set

    @property
    def gives_backbone(self) -> bool:  # noqa: D102 - as BaseScene
        return self.over_amplitude

    def grids(self) -> dict[str, ValueGrid | RangeGrid]:  # noqa: D102 - as BaseScene
        return {name: getattr(self, name) for name in self.GRIDS if name in self.model_fields_set}

    def resolved_exciter(self) -> dict[str, float]:
        """Return the parameters of the free motion; for eq. (10), l is the unit of length."""
        if not self.over_amplitude:
            return without_absent({**DEFAULTS, "l": 1.0})
        values = super().resolved_exciter()
        return without_absent({**DEFAULTS, "l": values["l"], "delta": values["delta"]})

    def data_exciter(self) -> dict[str, float]:  # noqa: D102 - as BaseScene
        return self.resolved_exciter() if self.over_amplitude else {}

    def called_effects(self) -> tuple[str, ...]:
        """Return the effects of free motion without losses: the two supports."""
        return ("support_1", "support_2")


def _form(scene: BackboneScene) -> Iterator[Problem]:
    """Check that the grids are delta_over_l and tau_bar, or amplitude, without keys of the other form."""
    given = scene.model_fields_set
    other = ("delta_over_l", "tau_bar", "check_points") if scene.over_amplitude else ("harmonics",)
    form = "amplitude" if scene.over_amplitude else "delta_over_l and tau_bar"
    if not given & set(scene.GRIDS):
        must = "must have the grids delta_over_l and tau_bar, or amplitude"
        yield Problem((), "no grid", must=must)
        return
    for name in other:
        if name in given:
            yield Problem((name,), "", must=f"must not be combined with {form}")
    if not scene.over_amplitude:
        for name in ("delta_over_l", "tau_bar"):
            if name not in given:
                yield required((name,), "a grid", ", unless amplitude is given")


def _ranges(scene: BackboneScene) -> Iterator[Problem]:
    for name in ("tau_bar", "amplitude"):
        grid: ValueGrid | RangeGrid | None = getattr(scene, name)
        if grid is not None and grid.low <= 0:
            yield Problem((name,), repr(grid.low), "numbers above 0")
        elif grid is not None and name == "amplitude" and scene.has_l():
            yield from _reaches(scene, grid.low)
    offsets = scene.delta_over_l
    if offsets is not None:
        for value in dict.fromkeys((offsets.low, offsets.high)):
            if not -1 < value < 1:
                yield Problem(("delta_over_l",), repr(value), "numbers between -1 and 1")
                break


def _reaches(scene: BackboneScene, amplitude: float) -> Iterator[Problem]:
    """Check that motions about an equilibrium beyond a support reach between the supports."""
    with suppress(ParameterError):  # reported by `_supports`
        exciter = Exciter(**scene.resolved_exciter())
        least = max(exciter.lower, -exciter.upper)
        if amplitude <= least:
            size, unit = shown_length(scene)
            allowed = (
                f"numbers above {size * least:.10g}{unit} (the equilibrium lies beyond a support)"
            )
            yield Problem(("amplitude",), f"{size * amplitude:.10g}{unit}", allowed)


def _exciter(scene: BackboneScene) -> Iterator[Problem]:
    """Check that only parameters of the supports are stated."""
    if scene.over_amplitude:
        why = "free motion has neither force nor loss (l and delta are allowed)"
        yield from no_exciter(scene, why, ("l", "delta"))
        return
    why = "the curves depend on delta_over_l and tau_bar alone"
    yield from no_exciter(scene, why)


def _supports(scene: BackboneScene) -> Iterator[Problem]:
    if scene.over_amplitude:
        yield from check_exciter(scene)


def _figure(scene: BackboneScene) -> Iterator[Problem]:
    """Check that the quantities to show are of the form of the scene."""
    curves = ("tau_bar", "omega_bar")
    for name in scene.figure.show:
        if (name in curves) == scene.over_amplitude:
            of_amplitude = (each for each in drawn_by("backbone") if each not in curves)
            form = "over amplitude" if scene.over_amplitude else "of eq. (10)"
            names = one_of(of_amplitude if scene.over_amplitude else curves)
            must = f"must name quantities of a backbone {form} ({names})"
            yield Problem(("figure", "show"), repr(str(name)), must=must)


MAX_LINES_TOGETHER = 8  # of a sweep over the frequency


def check_scenes_together(
    scene: BackboneScene, scenes: Mapping[str, BaseScene], broken: Collection[str]
) -> Iterator[Problem]:
    """Check that the scenes drawn over harmonics are backbones over amplitude, or sweeps of the frequency."""
    what = "a backbone over amplitude, or a sweep of the frequency and at most one more parameter, with harmonics"
    yield from check_drawn_together(scene, scenes, broken, what, fits_together)
    if scene.figure.together and not scene.over_amplitude:
        must = "must be left out unless the scene runs over amplitude"
        yield Problem(("figure", "together"), ", ".join(scene.figure.together), must=must)


def fits_together(scene: Any) -> bool:
    """Return whether a scene is a backbone over amplitude, or a sweep whose lines over the frequency can be drawn."""
    if scene.kind != "sweep":
        return bool(scene.gives_backbone)
    others = [grid.size for name, grid in scene.grids().items() if name != "nu"]
    has_lines = (
        "nu" in scene.grids() and len(others) <= 1 and math.prod(others) <= MAX_LINES_TOGETHER
    )
    return has_lines and "harmonics" in scene.outputs


_GRIDS: tuple[KeyPath, ...] = tuple((name,) for name in BackboneScene.GRIDS)
CHECKS = (
    Check((*SUPPORTS, ("amplitude",)), _supports),
    Check(_GRIDS, check_rows),
    Check((*_GRIDS, ("check_points",), ("harmonics",)), _form),
    Check((), _ranges),
    Check((("amplitude",),), _exciter),
    Check((("figure",), *_GRIDS), _figure),
)


def plan(scene: BackboneScene) -> Work:
    """Return the work of a backbone, from its number of points."""
    each = 8 + 1 + 2 * 8 + 4 * 8 * scene.harmonics if scene.over_amplitude else 8
    return Work(
        size=grid_size(scene),
        rows=scene.row_count,
        outputs=("harmonics",) if scene.over_amplitude else (),
        seconds=scene.row_count * SECONDS_PER_POINT,
        bytes=HEAD_BYTES + scene.row_count * each,
    )
