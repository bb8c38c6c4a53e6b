"""The map of what is proved of the rows of a sweep."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from vibropipe.figures.text import parameters_text, sentences
from vibropipe.scenes.certificate_page import rows_within_text
from vibropipe.scenes.kind import Picture
from vibropipe.scenes.sweep.captions import combinations_text, points_text, shares_text
from vibropipe.scenes.sweep.laws import Region, by_amount
from vibropipe.scenes.sweep.map_layout import map_axes
from vibropipe.scenes.sweep.maps import MAX_MAPS, draw_region_map
from vibropipe.scenes.sweep.sweep_rows import swept
from vibropipe.words.proofs import Proved, ProvedStable, Why, tally
from vibropipe.words.wording import capitalised, share

PROVED = "proved"
# Codes of regions: what is proved of an orbit, or how its proof ended.
STABLE, UNSTABLE, DISPROVED, UNDECIDED, NOT_TRIED = range(5)
WORDS = (
    ("proved_stable", "proved, stable"),
    ("proved_unstable", "proved, unstable"),
    ("disproved", "disproved"),
    ("undecided", "not decided"),
    ("not_tried", "no orbit with impacts alone"),
)
NOT_TRIED_TEXT = "A row without impacts, with rests or without an orbit is not tried"


def proof_regions(dataset: xr.Dataset) -> tuple[xr.DataArray, list[Region]]:
    """Return the code of what is proved of each row, and the regions that occur, the most frequent first."""
    proved, stable = dataset["proved"], dataset["proved_stable"]
    codes = xr.full_like(proved, UNDECIDED, dtype=np.int64)
    codes = codes.where(dataset["why"] != Why.NOT_TRIED, NOT_TRIED)
    codes = codes.where(proved != Proved.DISPROVED, DISPROVED)
    is_stable = xr.where(stable == ProvedStable.STABLE, STABLE, UNSTABLE)
    codes = codes.where(proved != Proved.PROVED, is_stable).rename("region").drop_attrs(deep=False)
    found = by_amount(codes)
    return codes, [Region(code, *WORDS[code], "", n, codes.size) for code, n in found]


def draw_proof_map(dataset: xr.Dataset) -> Figure:
    """Draw the map of what is proved over the two finest grids."""
    return draw_region_map(dataset, *proof_regions(dataset))


def proof_title(dataset: xr.Dataset) -> str:
    """Return how many orbits are proved."""
    found = tally(dataset, dataset["proved"].values, dataset["why"].values)
    if found.tried == 0:
        return "No row has an orbit with impacts alone, which could be proved"
    within = rows_within_text(dataset)
    where = f" within {within}" if within else ""
    return f"{capitalised(share(found.proved, found.tried, 'orbit'))} proved{where}"


def describe_proofs(dataset: xr.Dataset) -> str:
    """Return the caption: what is proved of a row, and what is not tried."""
    codes, regions = proof_regions(dataset)
    return sentences(
        points_text(dataset),
        "Each orbit is proved on its own, in balls that contain all roundings: it exists, is the only one of its law "
        "nearby, is a motion, and has the stability that is named (docs/proof.md)",
        shares_text(dataset, regions),
        NOT_TRIED_TEXT if (codes == NOT_TRIED).any() else "",
        combinations_text(dataset, map_axes(dataset)[2], MAX_MAPS),
        parameters_text(dataset),
    )


PROOFS = Picture(
    PROVED,
    draw_proof_map,
    describe_proofs,
    lambda dataset: "proved" in dataset and len(swept(dataset)) > 1,
    titled=proof_title,
)
