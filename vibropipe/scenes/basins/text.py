"""The caption of a map of basins, written from its data."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
import xarray as xr

from vibropipe.figures.motion_words import amount_text, aperiodic_text
from vibropipe.figures.text import format_number, is_forced, sentences
from vibropipe.words.wording import capitalised, count

MAX_BORDER = 0.25  # share of border starts above which lines between the basins would cover them
HELD = "Where friction holds the mass, it may come to rest in a whole range of places"


def percent(share: float) -> str:
    r"""Write a share in per cent, with three digits, or two below one per cent.

    >>> percent(0.15), percent(1.0), percent(0.0016)
    ('15.0\xa0%', '100\xa0%', '0.16\xa0%')
    """
    value = 100 * share
    text = format_number(value, 2) if value < 1 else f"{value:.{1 if value >= 10 else 2}f}"
    if share < 1.0 and float(text) >= 100.0:
        text = "99.9"
    return f"{'100' if share == 1.0 else text}\u00a0%"


def describe_basins(dataset: xr.Dataset, show: Collection[str] = ()) -> str:
    """Return the caption of the maps, or of those of `show`."""
    show = show or ("attractor",)
    has_map, has_times = "attractor" in show, "periods_to_attractor" in show
    times = "forcing periods until the motion from each start has settled"
    longest = count(int(dataset["periods_to_attractor"].max()), "forcing period")
    slowest = f"The slowest start takes {longest}" if dataset.sizes["attractor_id"] else ""
    if not has_map:
        return sentences(f"{capitalised(times)}{start_text(dataset)}", slowest)
    has_chaos = bool((dataset["period_multiple"] == 0).any())
    later = "; grey: later periods of one that does not repeat" if has_chaos else ""
    return sentences(
        f"{dataset.sizes['x0']} × {dataset.sizes['v0']} starts{start_text(dataset)}; colours: the motion on which "
        "they settle",
        *marks_texts(dataset),
        f"{'Below' if has_times else 'Right'}: displacement of the motions between the supports (hatched){later}"
        if dataset.sizes["attractor_id"]
        else "",
        missing_text(dataset),
        aperiodic_text(dataset),
        slowest if has_times else "",
    )


def start_text(dataset: xr.Dataset) -> str:
    """Write when in the forcing period the motions start."""
    if not is_forced(dataset):
        return ""
    phase = float(dataset["start_phase"])
    when = f"{format_number(phase)} of a forcing period" if phase else "the beginning of a period"
    return f" at {when}"


def marks_texts(dataset: xr.Dataset) -> tuple[str, ...]:
    """Write what the marks on a map are."""
    if float(dataset["start_phase"]) or not dataset.sizes["attractor_id"]:
        return ()
    has_chaos = bool((dataset["period_multiple"] == 0).any())
    dots = " (dots: of a motion that does not repeat)" if has_chaos else ""
    often = " once every forcing period" if is_forced(dataset) else ""
    states = f"White symbols: their states{often}{dots}"
    orbits = dataset.sizes.get("border_orbit", 0)
    if not orbits:
        return (states,)
    is_crowded = float(dataset["border"].mean()) > MAX_BORDER
    has_lines = not is_crowded and dataset.sizes.get("stable_set_point")
    where = "of those in the borders" if is_crowded else "on the borders"
    lines = f", and thin lines: the starts that approach {'it' if orbits == 1 else 'them'}"
    lines = lines if has_lines else ""
    amount = int(np.isfinite(dataset["border_point_displacement"].values).sum())
    return (
        states,
        f"Red cross{'es' * (amount != 1)}: {amount_text(orbits, 'unstable orbit')} {where}{lines}",
    )


def missing_text(dataset: xr.Dataset) -> str:
    """Write the share of starts for which no attractor was found, and that friction may leave many."""
    none = float((dataset["attractor"] < 0).mean())
    held = f". {HELD}" if has_friction(dataset) else ""
    return (
        f"Red: {percent(none)} of the starts, for which no motion was found{held}" if none else ""
    )


def has_friction(dataset: xr.Dataset) -> bool:
    """Return whether dry friction acts on the mass somewhere, which may hold it."""
    return bool((dataset.get("friction", xr.DataArray(0.0)) > 0.0).any())
