"""The picture of a branch scene."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from vibropipe.figures.motion_words import amount_text, changing_text
from vibropipe.figures.text import sentences, ties_text
from vibropipe.report.findings import symbol_text
from vibropipe.scenes.branch.curves import draw_branches, enlarged, is_reached, stabilities
from vibropipe.scenes.branch.jumps import arrows_of, jumps_of
from vibropipe.scenes.branch.keys import BranchFigure
from vibropipe.scenes.branch.lines import (
    cascade_of,
    followed,
    has_points,
    kinds_present,
    panels_of,
    places_of,
    stable_points,
    swept,
)
from vibropipe.scenes.branch.motor import describe_motor, draw_motor, has_motor, title_motor
from vibropipe.scenes.branch.stretches import coexistence, stretches_of
from vibropipe.scenes.kind import MAX_TITLE, Picture
from vibropipe.store.table import is_neutral
from vibropipe.words.wording import capitalised, series


def title_branches(
    dataset: xr.Dataset, show: Sequence[str], backbone: xr.Dataset | None = None
) -> str:
    """Return the title: a cascade, where several motions are stable, or what the orbits pass."""
    symbol = symbol_text(dataset[followed(dataset)])
    if places := cascade_of(dataset):
        return f"Each of {amount_text(len(places), 'flip')} along {symbol} doubles the period"
    together = coexistence(stretches_of(dataset))
    number = sum(len(intervals) for intervals in together.values())
    if not number:
        return _alone(dataset, symbol)
    if over := swept(dataset):
        is_each = len(together) == np.unique(dataset[over].values).size
        which = f"{'each' if is_each else 'some'} {symbol_text(dataset[over])}"
        return f"At {which}, several motions are stable in places along {symbol}"
    intervals = amount_text(number, "interval")
    return f"At least two of these motions are stable in {intervals} of {symbol}"


def _alone(dataset: xr.Dataset, symbol: str) -> str:
    """Return the title where no two orbits are stable at a time."""
    stable, neutral = stable_points(dataset), is_neutral(dataset)
    kinds = {"stable": stable, "neutral": neutral, "unstable": ~(stable | neutral)}
    for name, of_kind in kinds.items():
        if of_kind.all():
            return f"All orbits followed along {symbol} are {name}"
    if not stable.any():
        return f"No orbit followed along {symbol} is stable"
    passed = f"Orbits along {symbol} pass {bifurcations_text(dataset)}"
    if {*(places := places_of(dataset))} == {"change"}:
        values = amount_text(places["change"].size, "value")
        passed = capitalised(f"{changing_text(dataset)} at {values} of {symbol}")
    if kinds_present(dataset) and len(passed) <= MAX_TITLE:
        return passed
    return f"Stable and unstable orbits along {symbol}"


def describe_branches(
    dataset: xr.Dataset, show: Sequence[str], backbone: xr.Dataset | None = None
) -> str:
    """Return the caption: what is drawn, and how many bifurcations there are."""
    ties, stretches = ties_text(dataset), stretches_of(dataset)
    jumps = jumps_of(dataset, stretches)
    panels = panels_of(dataset, show, backbone)
    lines = {"stable": "solid: stable", "unstable": "dashed: unstable"}
    drawn = ", ".join(lines[name] for name in stabilities(dataset))
    return sentences(
        f"Orbits along {symbol_text(dataset[followed(dataset)])}; {drawn}"
        + (", wide: what the mass settles on from rest" if is_reached(dataset).any() else ""),
        f"Marks: {bifurcations_text(dataset)}{once_text(dataset)}"
        if kinds_present(dataset)
        else "",
        "Unstable orbits of many periods are not drawn" if enlarged(dataset) else "",
        "Arrows: jumps" if any(arrows_of(jumps, each.values) for each in panels) else "",
        "Bars below: where at least two of these motions are stable"
        if coexistence(stretches)
        else "",
        f"Change: {changing_text(dataset)}" if "change" in kinds_present(dataset) else "",
        "Wide grey line: conservative exciter" if backbone is not None else "",
        f"Tied: {ties}" if ties else "",
        dataset.attrs.get("incomplete", ""),
    )


def bifurcations_text(dataset: xr.Dataset) -> str:
    """Write how many bifurcations of each kind there are."""
    places = places_of(dataset)
    return series(amount_text(at.size, kind) for kind, at in places.items())


def once_text(dataset: xr.Dataset) -> str:
    """Write that bifurcations at one place count once, if several marks are there; after how many there are."""
    number = sum(at.size for at in places_of(dataset).values())
    is_several = number < dataset.sizes["bifurcation"]
    return (
        f"; several at one value of {symbol_text(dataset[followed(dataset)])} count once"
        if is_several
        else ""
    )


def keywords(options: BranchFigure | None, others: Mapping[str, xr.Dataset]) -> dict[str, Any]:
    """Return the keywords of `draw_branches` and `describe_branches`."""
    options = options or BranchFigure()
    backbone = None if options.backbone is None else others[options.backbone]
    return {"show": options.show, "backbone": backbone}


PICTURES = (
    Picture("motor", draw_motor, describe_motor, fits=has_motor, titled=title_motor),
    Picture(
        "branches",
        draw_branches,
        describe_branches,
        fits=has_points,
        keywords=keywords,
        titled=title_branches,
    ),
)
