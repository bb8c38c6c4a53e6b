"""Title of a map of basins: what the start decides, written from its data."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
import xarray as xr

from vibropipe.figures.claims import at_most
from vibropipe.figures.motion_words import number_word, way_of
from vibropipe.scenes.basins.attractors import letters_of, ordered
from vibropipe.scenes.basins.text import NOT_FOUND
from vibropipe.words.regimes import Regime
from vibropipe.words.wording import series

RARE, MAX_RARE = 0.02, 3  # share of the starts of a rare motion, and how many of them are named


def title_basins(dataset: xr.Dataset, show: Collection[str] = ()) -> str:
    """Return the title of the map: what the start decides, or which motions few starts settle on."""
    if show and "attractor" not in show:
        return ""
    indices = ordered(dataset)
    shares = [float(dataset["basin_share"][index]) for index in indices]
    if not shares:
        return NOT_FOUND
    if len(shares) == 1:
        whole = shares[0] == 1.0
        return "All starts settle on one motion" if whole else "One motion was found"
    if decided := decided_text(dataset):
        return f"The start decides {decided}"
    if float(dataset["border"].mean()) > 0.5:
        return "Most starts have a neighbour that settles elsewhere"
    rare = [n for n, share in enumerate(shares) if share < RARE]
    if rare and len(rare) <= MAX_RARE:
        letters = series(letters_of(dataset)[indices[n]] for n in rare)
        most, each = at_most(100 * max(shares[n] for n in rare), 1), " on each" * (len(rare) > 1)
        return f"Few starts settle on {letters}, at most {most}\u00a0%{each}"
    return f"The start decides which of {number_word(len(shares))} motions settles"


def decided_text(dataset: xr.Dataset) -> str:
    """Write in what motions differ most: which way a housing creeps, whether the mass strikes, or repeats itself."""
    if "housing_velocity_mean" in dataset:
        speeds = dataset["housing_velocity_mean"].values, dataset["housing_velocity_max"].values
        if {"along x", "against x"} <= {way_of(*each) for each in zip(*speeds, strict=True)}:
            return "which way the housing creeps"
    regime = dataset["regime"].values
    strikes = dataset["impacts_per_orbit"].sum("support").values > 0
    is_quiet = regime == Regime.NO_IMPACT
    if is_quiet.any() and not is_quiet.all() and (strikes | is_quiet).all():
        return "whether the mass strikes a support"
    is_aperiodic = regime == Regime.APERIODIC
    if is_aperiodic.any() and np.any(regime < Regime.APERIODIC):
        return "whether the motion repeats itself"
    return ""
