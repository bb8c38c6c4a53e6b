"""Caption, findings and tables of basins over a parameter, written from their data."""

from __future__ import annotations

import numpy as np
import xarray as xr

from vibropipe.figures.claims import between_text
from vibropipe.figures.text import format_number, sentences
from vibropipe.report.findings import symbol_text, value_text
from vibropipe.report.table import DASH, Table, breakable
from vibropipe.scenes.basins.laws import (
    Change,
    changes_of,
    laws_text,
    place_text,
    presence,
    swept_name,
)
from vibropipe.words.wording import count, series

# Changes that a sentence lists.
MAX_LISTED = 4
# The value at which a range ends, or the two between which it does; None at an end of the values.
Border = tuple[float, ...] | None


def describe_shares(dataset: xr.Dataset, branches: xr.Dataset | None = None) -> str:
    """Return the caption of the shares over a parameter."""
    axis = dataset[swept_name(dataset)]
    n_starts = count(dataset.sizes["x0"] * dataset.sizes["v0"], "start")
    phase = float(dataset["start_phase"])
    return sentences(
        "Above: first harmonic of the attractors"
        + (" over branches of stable and unstable orbits" if branches is not None else "")
        + f"; below: share of {n_starts} that settle on each"
        + (f", started at {format_number(phase)} of a forcing period" if phase else ""),
        "Upright bars: 95 % intervals of the lines between bands, for as many random starts",
        f"Broken lines: values of {symbol_text(axis)} at which an attractor appears or vanishes",
        missing_text(dataset),
    )


def describe_share_maps(dataset: xr.Dataset) -> str:
    """Return the caption of the maps at some values of the parameter."""
    axis = dataset[swept_name(dataset)]
    phase = float(dataset["start_phase"])
    started = f"The motions start at {format_number(phase)} of a forcing period" if phase else ""
    return sentences(
        f"Attractor that the motion from each start settles on, at some values of {symbol_text(axis)}",
        started or "Markers show the states of the attractors at the section",
        missing_text(dataset),
    )


def missing_text(dataset: xr.Dataset) -> str:
    """Write the share of starts for which no attractor was found."""
    none = float((dataset["attractor"] < 0).mean())
    return f"{format_number(100 * none, 3)} % of the starts settle on none of them" if none else ""


def together_text(dataset: xr.Dataset) -> str:
    """Write where several attractors coexist: the widest range, between the values where an attractor changes."""
    axis = dataset[str(swept_name(dataset))]
    ranges = together_ranges(dataset)
    if not ranges:
        return f"At no value of {symbol_text(axis)} do the starts settle on two motions"
    texts = [
        f"{way} {place}"
        for way, place in zip(("from", "to"), (_place(axis, end) for end in ranges[0]), strict=True)
        if place
    ]
    where = " ".join(texts) or f"at all values of {symbol_text(axis)}"
    more = ", and elsewhere" if len(ranges) > 1 else ""
    return (
        f"Among the motions followed here, at least two coexist {where}{more}: there the start decides which of them "
        "settles"
    )


def together_ranges(dataset: xr.Dataset) -> list[tuple[Border, Border]]:
    """Return the ranges of the parameter in which several attractors coexist, the widest first."""
    values = dataset[str(swept_name(dataset))].values
    order = np.argsort(values)
    values, several = (
        values[order],
        (dataset["basin_share"].count("attractor_id").values > 1)[order],
    )
    starts = np.flatnonzero(several & ~np.concatenate([[False], several[:-1]]))
    ends = np.flatnonzero(several & ~np.concatenate([several[1:], [False]]))
    places = np.array([change.value for change in changes_of(dataset)])
    found = [
        (
            _border(places, values, first - 1) if first > 0 else None,
            _border(places, values, last) if last < values.size - 1 else None,
        )
        for first, last in zip(starts.tolist(), ends.tolist(), strict=True)
    ]
    widths = values[ends] - values[starts]
    return [found[n] for n in np.argsort(-widths, kind="stable")]


def _border(places: np.ndarray, values: np.ndarray, n: int) -> tuple[float, ...]:
    """Return the one change between values n and n + 1, which is the border there; else both values."""
    inside = places[(places >= values[n]) & (places <= values[n + 1])]
    return (float(inside[0]),) if inside.size == 1 else (float(values[n]), float(values[n + 1]))


def _place(axis: xr.DataArray, border: Border) -> str:
    """Write a border that is located, or between which values it lies; empty at an end of the range."""
    if border is None:
        return ""
    if len(border) == 1:
        return f"{symbol_text(axis)} = {value_text(axis, border[0])}"
    return between_text(axis, *border)


def changes_text(dataset: xr.Dataset) -> str:
    """Write where attractors vanish, with increasing and with decreasing parameter, and what follows them."""
    axis = dataset[swept_name(dataset)]
    clauses = []
    for way, appears in (("increasing", False), ("decreasing", True)):
        changes = [change for change in changes_of(dataset) if change.appears == appears]
        if appears:
            changes.reverse()
        if changes:
            listed = series(change_text(axis, change) for change in changes[:MAX_LISTED])
            rest = len(changes) - MAX_LISTED
            more = f" (and {rest} more, in the table)" if rest > 0 else ""
            clauses.append(f"with {way} {symbol_text(axis)}, {listed}{more}")
    if not clauses:
        return "No attractor appears or vanishes"
    text = "; ".join(clauses)
    return f"{text[0].upper()}{text[1:]}"


def change_text(axis: xr.DataArray, change: Change) -> str:
    """Write where an attractor vanishes that is followed to where it is not, and the one that follows it."""
    beyond = f" and {change.other} follows" if change.other >= 0 else ""
    return f"attractor {change.attractor} vanishes at {value_text(axis, change.value)}{beyond}"


def rare_text(dataset: xr.Dataset) -> str:
    """Write which attractor the fewest starts settle on, and where, if they are few."""
    share = dataset["basin_share"]
    least = share.min()
    if not float(least) < 0.02:
        return ""
    name = str(swept_name(dataset))
    row, index = np.argwhere(share.transpose(name, "attractor_id").values == float(least))[0]
    at = float(dataset[name][row])
    return (
        f"The smallest basin is that of attractor {index} at {place_text(dataset, at)}: "
        f"{format_number(100 * float(least), 3)} % of the starts"
    )


def share_texts(dataset: xr.Dataset) -> tuple[str, ...]:
    """Return what shares over a parameter show, a sentence each."""
    if dataset.sizes["attractor_id"] == 0:
        return ("No attractor was found",)
    return together_text(dataset), changes_text(dataset), rare_text(dataset)


def family_table(name: str, dataset: xr.Dataset) -> Table:
    """Return the table of the attractors of a scene over a parameter."""
    axis = dataset[swept_name(dataset)]
    changes = {(change.attractor, change.appears): change for change in changes_of(dataset)}
    rows = []
    for index in dataset["attractor_id"].values.tolist():
        present = presence(dataset, index)
        share = dataset["basin_share"].sel(attractor_id=index).values[present]
        least, most = (format_number(100 * float(end), 3) for end in (share.min(), share.max()))
        span = f"{least} to {most} %" if most != least else f"{least} %"
        ends = [_end_text(axis, changes.get((index, appears))) for appears in (True, False)]
        rows.append([str(index), laws_text(dataset, index), *ends, span])
    caption = (
        f"Attractors of {breakable(name)} over {symbol_text(axis)}: laws of motion, where each appears and vanishes "
        "with increasing value, in brackets the attractor that its motion settles on beyond, and its share of the "
        "starts."
    )
    return Table(["attractor", "laws", "from", "to", "share"], rows, caption, left=2)


def _end_text(axis: xr.DataArray, change: Change | None) -> str:
    """Write where an attractor begins or ends; a dash where it does so beyond the values."""
    if change is None:
        return DASH
    other = f" ({change.other})" if change.other >= 0 else ""
    return f"{value_text(axis, change.value)}{other}"
