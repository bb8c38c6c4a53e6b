"""Registry of the kinds of scenes."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from vibropipe.scenes import (
    accuracy,
    backbone,
    basins,
    boundary,
    branch,
    design,
    effects,
    hard_cases,
    identify,
    motion,
    sweep,
)
from vibropipe.scenes.keys.base import BaseScene
from vibropipe.scenes.kind import Kind

if TYPE_CHECKING:
    import xarray as xr

_KINDS = {
    kind.name: kind
    for kind in (
        motion.KIND,
        sweep.KIND,
        branch.KIND,
        boundary.KIND,
        basins.KIND,
        design.KIND,
        identify.KIND,
        backbone.KIND,
        hard_cases.KIND,
        accuracy.KIND,
        effects.KIND,
    )
}


def kinds() -> dict[str, Kind]:
    """Return all kinds by name, in the order of the documentation."""
    return dict(_KINDS)


def kind_of(scene: BaseScene) -> Kind:
    """Return the kind of a scene."""
    return _KINDS[scene.kind]


def kind_of_dataset(dataset: xr.Dataset) -> Kind | None:
    """Return the kind of a dataset: the one that it states, else by what it holds; None if it is of none."""
    named = _KINDS.get(str(dataset.attrs.get("kind", "")))
    return named or next((kind for kind in _KINDS.values() if kind.holds(dataset)), None)


@contextmanager
def registered(kind: Kind) -> Iterator[None]:
    """Register a further kind of scene inside this context; raises ValueError for a name in use."""
    if kind.name in _KINDS:
        raise ValueError(f"there is a kind {kind.name!r} already")
    _KINDS[kind.name] = kind
    try:
        yield
    finally:
        del _KINDS[kind.name]
