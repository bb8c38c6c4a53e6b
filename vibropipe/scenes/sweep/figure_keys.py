"""The key `figure` of a sweep: its pictures, the quantities they show, and what these need of the data."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field

from vibropipe.scenes.keys.base import EachOnce
from vibropipe.scenes.keys.checks import check_shown
from vibropipe.scenes.keys.parts import MAX_LINES, FigureOptions
from vibropipe.scenes.keys.problems import Problem
from vibropipe.scenes.keys.values import NameRule
from vibropipe.words.vocabulary import STEADY, drawn_by

if TYPE_CHECKING:
    from vibropipe.scenes.sweep.keys import SweepScene

    Shown = str
else:
    Shown = Literal[drawn_by("sweep")]
# Outputs that pictures need; one of them suffices.
PICTURE_NEEDS: Mapping[str, tuple[str, ...]] = {
    "quantities": (*("harmonics", "impacts", "stability", "lyapunov", "energy", "power", "frame"),),
    "section": ("poincare",),
    "portrait": ("motion",),
    "spectrum": ("harmonics",),
    "energy": ("energy",),
}
# Quantities with several points for each row, which only the bifurcation diagram shows, and all that it shows.
POINTS = tuple(name for name in drawn_by("sweep") if {"impact", "visit"} & {*STEADY[name].dims})
IN_DIAGRAM = (*POINTS, "displacement_strobe", "lyapunov_exponent")


class SweepFigure(FigureOptions):
    """Options of the pictures of a sweep."""

    pictures: EachOnce[
        Literal[
            "curves",
            "map",
            "quantities",
            "proved",
            "bifurcation",
            "section",
            "portrait",
            "spectrum",
            "energy",
        ]
    ] = Field(
        default=[],
        description="Pictures: curves along the finest grid, a map of how the mass moves over two grids, maps of "
        "quantities over them or of what is proved, a bifurcation diagram, Poincaré sections, phase portraits or "
        "spectra of single rows, or the energy (default: curves, or map and quantities, as fits, and what is proved).",
    )
    show: EachOnce[Shown] = Field(
        default=[],
        description="Quantities of curves, maps and the bifurcation diagram (default: those in the data).",
    )
    backbone: Annotated[str | None, NameRule()] = Field(
        default=None,
        description="Backbone scene over `amplitude`, drawn under the curves (formerly `beside`).",
    )


def pictures_showing(name: str) -> set[str]:
    """Return the pictures that show a quantity where it is asked for."""
    shown_by = set() if name in POINTS else {"curves", "quantities"}
    if name in IN_DIAGRAM:
        shown_by.add("bifurcation")
    return shown_by | ({"spectrum"} if name.endswith("_amplitude") else set())


def check_figure(scene: SweepScene) -> Iterator[Problem]:
    """Check that the pictures fit the grids, and that outputs hold what they and the quantities need."""
    pictures, outputs = scene.figure.pictures, set(scene.outputs)
    if "proved" in pictures and not scene.prove:
        must = "must leave out proved unless the scene has prove: true"
        yield Problem(("figure", "pictures"), "'proved'", must=must)
    for picture in ("map", "quantities", "proved"):
        if picture in pictures and len(scene.over) < 2:
            must = f"must leave out {picture} unless two or more parameters are swept"
            yield Problem(("figure", "pictures"), "a map of one swept parameter", must=must)
    lines = sorted(grid.size for grid in scene.over.values())[:-1]
    if "curves" in pictures and any(size > MAX_LINES for size in lines):
        must = (
            f"must leave out curves unless all grids but the finest have at most {MAX_LINES} values"
        )
        yield Problem(("figure", "pictures"), f"curves for {max(lines)} values", must=must)
    for picture in pictures:
        needed = PICTURE_NEEDS.get(picture, ())
        if needed and not outputs & set(needed):
            must = f"must leave out {picture} unless outputs have {' or '.join(needed)}"
            yield Problem(("figure", "pictures"), repr(picture), must=must)
    yield from check_shown(scene.figure.show, scene.extent())
    for name in scene.figure.show:
        shown_by = pictures_showing(name)
        if not shown_by & {*pictures} and (pictures or shown_by == {"bifurcation"}):
            must = f"must leave out {name} unless pictures have {' or '.join(sorted(shown_by))}"
            yield Problem(("figure", "show"), repr(str(name)), must=must)
        output = STEADY[name].output
        if output and output not in outputs:
            must = f"must leave out {name} unless outputs have {output}"
            yield Problem(("figure", "show"), repr(str(name)), must=must)
