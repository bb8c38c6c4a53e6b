"""Caption of the picture of branches, written from its data."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr

from vibropipe.figures.text import format_number, sentences
from vibropipe.scenes.branch.curves import followed, kinds_present
from vibropipe.words.vocabulary import quantity
from vibropipe.words.wording import count, series

# Bifurcations of a kind that a caption lists.
MAX_LISTED = 6


def describe_branches(
    dataset: xr.Dataset, show: Sequence[str], backbone: xr.Dataset | None = None
) -> str:
    """Return the caption: what is drawn, and where the bifurcations are."""
    along = followed(dataset)
    return sentences(
        f"Orbits along {quantity(along).plain}; solid: stable, dotted: unstable",
        bifurcations_text(dataset),
        "Wide grey line: conservative exciter" if backbone is not None else "",
    )


def bifurcations_text(dataset: xr.Dataset) -> str:
    """Write where each kind of bifurcation is found."""
    along = followed(dataset)
    clauses = []
    for name, mask in kinds_present(dataset).items():
        at = np.sort(dataset[f"bifurcation_{along}"].values[mask])
        listed = series(format_number(float(value)) for value in at)
        where = f" at {quantity(along).plain} = {listed}" if at.size <= MAX_LISTED else ""
        clauses.append(f"{count(at.size, name)}{where}")
    return series(clauses)
