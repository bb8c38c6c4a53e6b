"""Caption of the picture of boundaries, written from its data."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
import xarray as xr

from vibropipe.figures.text import flag_texts, plain_symbol, sentences
from vibropipe.scenes.boundary.curves import kinds_present, marks, of_kinds, plane
from vibropipe.words.wording import count, series


def describe_boundaries(
    dataset: xr.Dataset, regimes: xr.Dataset | None = None, show: Collection[str] = ()
) -> str:
    """Return the caption: what is drawn, and which curves there are."""
    left_out = [name for name in kinds_present(dataset) if name not in (show or (name,))]
    dataset = of_kinds(dataset, show)
    x, y = (plain_symbol(name) for name in plane(dataset))
    unstable = bool((dataset["stable"] == 0).any())
    return sentences(
        f"Curves of bifurcations of orbits over {x} and {y}"
        + ("; thin: of an unstable orbit" if unstable else ""),
        curves_text(dataset),
        f"Not drawn: {series(left_out)}" if left_out else "",
        meetings_text(dataset),
        "Colours: regimes that settle; where they change without a curve, another orbit attracts the start"
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
    listed = series(f"{number} of {name}" for name, number in numbers.items())
    sought = dataset.attrs.get("sought", "").split()
    none = f"No curve of {series(sought)} is found" if sought else "No curve is found"
    return f"{count(int(np.unique(ids).size), 'curve')}: {listed}" if numbers else none


def meetings_text(dataset: xr.Dataset) -> str:
    """Write which bifurcations meet."""
    codes = dataset["meeting_kind"].values[marks(dataset)]
    names = {
        code: text if text.startswith(("double", "degenerate")) else text.replace(" ", " and ")
        for code, text in flag_texts("meeting_kind").items()
    }
    listed = series(
        f"{names[int(code)]} ({int(n)})"
        for code, n in zip(*np.unique(codes, return_counts=True), strict=True)
    )
    return f"Marks show where curves meet: {listed}" if listed else ""
