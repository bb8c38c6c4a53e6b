"""Cascades of period doublings along a branch."""

from __future__ import annotations

import numpy as np
import xarray as xr

from vibropipe.scenes.branch.lines import followed, swept
from vibropipe.scenes.branch.places import SAME_PLACE
from vibropipe.words.bifurcations import Bifurcation

MIN_FLIPS = 3  # of a cascade: two steps, whose ratio is known


def cascade_of(dataset: xr.Dataset) -> list[float]:
    """Return the places of flips of an orbit, of that of twice the period, and so on, each step smaller than the last.

    The list is empty with fewer than MIN_FLIPS, with a further parameter, or where an orbit of one of these periods
    flips at several places.
    """
    if swept(dataset) is not None:
        return []
    is_flip = dataset["bifurcation_kind"].values == Bifurcation.FLIP
    points = dataset["bifurcation_point"].values[is_flip]
    at = dataset[f"bifurcation_{followed(dataset)}"].values[is_flip]
    multiples = dataset["period_multiple"].values[points]
    reach = SAME_PLACE * float(np.ptp(dataset[followed(dataset)].values))
    multiple, places = int(multiples.min(initial=1 << 30)), []
    while (own := at[multiples == multiple]).size and np.ptp(own) <= reach:
        places.append(float(own[0]))
        multiple *= 2
    steps = np.diff(places)
    shrinks = (
        steps.size and np.all(steps[1:] * steps[:-1] > 0) and np.all(np.diff(np.abs(steps)) < 0)
    )
    return places if len(places) >= MIN_FLIPS and shrinks else []
