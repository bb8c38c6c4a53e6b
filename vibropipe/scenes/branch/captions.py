"""Caption of the picture of branches, written from its data."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr

from vibropipe.figures.text import sentences, with_units
from vibropipe.report.findings import symbol_text
from vibropipe.scenes.branch.curves import followed, kinds_present
from vibropipe.scenes.branch.findings import distinct_texts
from vibropipe.scenes.branch.places import PLURALS, places_of
from vibropipe.words.wording import count, series

# Bifurcations of a kind that a caption lists.
MAX_LISTED = 6
CHANGES = "Changes: contacts, turns or sticks of the orbit begin or end"


def describe_branches(
    dataset: xr.Dataset, show: Sequence[str], backbone: xr.Dataset | None = None
) -> str:
    """Return the caption: what is drawn, and where the bifurcations are."""
    return sentences(
        f"Orbits along {symbol_text(dataset[followed(dataset)])}; solid: stable, dotted: unstable",
        bifurcations_text(dataset),
        CHANGES if "change" in kinds_present(dataset) else "",
        "Wide grey line: conservative exciter" if backbone is not None else "",
        dataset.attrs.get("incomplete", ""),
    )


def bifurcations_text(dataset: xr.Dataset) -> str:
    """Write where each kind of bifurcation is found."""
    axis = dataset[followed(dataset)]
    clauses = []
    for name, at in places_of(dataset).items():
        listed = with_units(axis, series(distinct_texts(np.unique(at))))
        where = f" at {symbol_text(axis)} = {listed}" if at.size <= MAX_LISTED else ""
        clauses.append(f"{count(at.size, name, PLURALS.get(name))}{where}")
    return series(clauses)
