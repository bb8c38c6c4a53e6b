"""The picture of a boundary scene."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

import numpy as np
import xarray as xr

from vibropipe.figures.motion_words import amount_text, number_word, times_word
from vibropipe.figures.text import flag_texts, plain_symbol_of, sentences
from vibropipe.report.parts import Answer
from vibropipe.scenes.boundary.curves import draw_boundaries, kinds_present, marks, of_kinds, plane
from vibropipe.scenes.boundary.keys import BoundaryFigure
from vibropipe.scenes.kind import Picture
from vibropipe.words.wording import series

PLURALS = {"grazing": "grazings", "fold": "folds", "flip": "flips", "pitchfork": "pitchforks"}


def title_boundaries(
    dataset: xr.Dataset, regimes: xr.Dataset | None = None, show: Collection[str] = ()
) -> str:
    """Return the title: which bifurcations part the motions; that of the scene without a curve."""
    kinds = series(PLURALS[name] for name in kinds_present(of_kinds(dataset, show)))
    return f"{kinds[0].upper()}{kinds[1:]} part the motions" if kinds else ""


def describe_boundaries(
    dataset: xr.Dataset, regimes: xr.Dataset | None = None, show: Collection[str] = ()
) -> str:
    """Return the caption: what is drawn, and which curves there are."""
    left_out = [name for name in kinds_present(dataset) if name not in (show or (name,))]
    dataset = of_kinds(dataset, show)
    x, y = (plain_symbol_of(dataset[name]) for name in plane(dataset))
    unstable = bool((dataset["stable"] == 0).any())
    return sentences(
        f"Curves of bifurcations of orbits over {x} and {y}"
        + ("; thin: of an unstable orbit" if unstable else ""),
        curves_text(dataset),
        f"Not drawn: {series(left_out)}" if left_out else "",
        "Circles: curves meet" if marks(dataset).any() else "",
        "Colours: the motions that settle; where they change without a curve, another orbit attracts the start"
        if regimes is not None
        else "",
        dataset.attrs.get("incomplete", ""),
    )


def curves_text(dataset: xr.Dataset) -> str:
    """Write how many curves of each kind there are."""
    ids, kinds = dataset["curve_id"].values, dataset["boundary_kind"].values
    numbers = {
        name: np.unique(ids[kinds == code]).size for name, code in kinds_present(dataset).items()
    }
    listed = series(f"{number_word(number)} of {name}" for name, number in numbers.items())
    sought = dataset.attrs.get("sought", "").split()
    none = f"No curve of {series(sought)} is found" if sought else "No curve is found"
    whole = amount_text(int(np.unique(ids).size), "curve")
    return f"{whole[0].upper()}{whole[1:]}: {listed}" if numbers else none


def boundary_answers(dataset: xr.Dataset) -> list[Answer]:
    """Return how many curves of which kind there are, and where they meet."""
    lead, _, kinds = curves_text(dataset).partition(": ")
    if not kinds:
        return [Answer(f"{lead} within the ranges that were searched.")]
    verb, they = ("parts", "It is") if lead.startswith("One ") else ("part", "They are")
    rest = f"{they} {kinds}." if "," not in kinds else f"Among them are {kinds.partition(',')[0]}."
    answers = [Answer(f"{lead} {verb} the motions.", rest)]
    if met := meetings_text(dataset):
        answers.append(Answer("Curves meet where two conditions hold at once.", met))
    return answers


def meetings_text(dataset: xr.Dataset) -> str:
    """Write which bifurcations meet most often, and how often; empty if none do."""
    codes = dataset["meeting_kind"].values[marks(dataset)]
    if not codes.size:
        return ""
    found, amounts = np.unique(codes, return_counts=True)
    name = meeting_name(flag_texts("meeting_kind")[int(found[amounts.argmax()])])
    among = "Among these is" if found.size > 1 else "This is"
    return f"{among} {name}, {times_word(int(amounts.max()))}."


def meeting_name(kind: str) -> str:
    """Write what meets: grazing and fold; double grazing."""
    return kind if kind.startswith(("double", "degenerate")) else kind.replace(" ", " and ")


def keywords(options: BoundaryFigure | None, others: Mapping[str, xr.Dataset]) -> dict[str, Any]:
    """Return the keywords of `draw_boundaries` and `describe_boundaries`."""
    options = options or BoundaryFigure()
    regimes = None if options.map is None else others[options.map]
    return {"regimes": regimes, "show": options.show}


PICTURES = (
    Picture(
        "boundaries",
        draw_boundaries,
        describe_boundaries,
        keywords=keywords,
        titled=title_boundaries,
    ),
)
