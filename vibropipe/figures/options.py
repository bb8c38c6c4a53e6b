"""What a study may say about the picture of one scene (its key ``figure``)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import xarray as xr


@dataclass(frozen=True)
class Options:
    """The options of one picture.

    periods: a motion shows its last ``periods`` forcing periods; None shows all of it.
    beside: the dataset of the scene whose curve is drawn under this one, or None.
    """

    periods: float | None = None
    beside: xr.Dataset | None = None


def options_of(figure: Any, others: Mapping[str, xr.Dataset]) -> Options:
    """Read a scene's ``figure`` (a mapping or a model of one, or None).

    ``others`` are the datasets of the study by scene. Raises KeyError if ``beside`` is none of
    them.
    """

    def given(key: str) -> Any:
        return figure.get(key) if isinstance(figure, Mapping) else getattr(figure, key, None)

    periods, beside = given("periods"), given("beside")
    if beside is not None and beside not in others:
        known = ", ".join(sorted(others)) or "none"
        raise KeyError(f"figure.beside: no scene {beside!r}; the scenes at hand are: {known}")
    return Options(
        periods=None if periods is None else float(periods),
        beside=None if beside is None else others[beside],
    )
