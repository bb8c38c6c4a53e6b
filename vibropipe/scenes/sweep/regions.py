"""Regions of the maps of a sweep: how the mass moves, in words, with the share of the points of each."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr

from vibropipe.figures.palette import REGIME_STYLES, RegimeStyle
from vibropipe.scenes.sweep.laws import orbit_numbers
from vibropipe.words.regimes import Regime

MORE = (
    max(Regime) + 1
)  # of orbits that strike both supports, but not each of them once a forcing period
FEW_POINTS, EXACT_POINTS = 50, 1000  # shares of fewer points are amounts, or have no decimal


@dataclass(frozen=True)
class Region:
    """A way to move: `words` on a map, `does` after "the mass"; `amount` of the `total` points."""

    code: int
    name: str
    words: str
    does: str
    amount: int
    total: int

    @property
    def style(self) -> RegimeStyle:
        """Colour, hatch and line style."""
        return REGIME_STYLES[self.name]

    @property
    def share(self) -> str:
        """Its share of the points, as text."""
        return share_text(self.amount, self.total)


WORDS = {
    "no_impact": ("no impact", "strikes no support"),
    "one_sided_1": ("only support 1 struck", "strikes support 1 alone"),
    "one_sided_2": ("only support 2 struck", "strikes support 2 alone"),
    "two_sided": ("both supports struck", "strikes both supports"),
    "with_rest": ("rest on a support", "comes to rest on a support"),
    "aperiodic": ("aperiodic", "does not repeat its motion"),
    "unbounded": ("unbounded", "moves without bound"),
    "unresolved": ("no result", "has no result"),
}
ONCE = ("each support struck once a period", "strikes each support once a period")
# Of orbits that strike both supports, but not each of them once a period: more often all, most or not even these.
MORE_OFTEN = (
    ("both supports struck, more often", "strikes both supports, more than twice a period in all"),
    ("both supports struck, mostly more often", "strikes both supports, mostly more than twice a period in all"),
    ("both supports struck, other orbits", "strikes both supports, but not once a period each"),
)  # fmt: skip


def regions_of(dataset: xr.Dataset) -> tuple[xr.DataArray, list[Region]]:
    """Return the code of the region of each row, and the regions that occur, the most frequent first."""
    regime = dataset["regime"]
    has_impacts = "impacts_per_orbit" in dataset or "impacts_per_period" in dataset
    m, p1, p2 = orbit_numbers(dataset)
    is_other = (regime == Regime.TWO_SIDED) & ~((m == 1) & (p1 == 1) & (p2 == 1))
    codes = regime.astype(np.int64).where(~(is_other & has_impacts), MORE).rename("region")
    values, amounts = np.unique(codes.values, return_counts=True)
    busy = float((p1 + p2 > 2 * m).where(is_other).mean())
    more = MORE_OFTEN[0 if busy == 1.0 else 1 if busy > 0.5 else 2]
    found = []
    for n in np.argsort(-amounts, kind="stable"):
        code = int(values[n])
        name = "two_sided_more" if code == MORE else Regime(code).name.lower()
        words = WORDS.get(name, more)
        words = ONCE if name == "two_sided" and has_impacts else words
        found.append(Region(code, name, *words, int(amounts[n]), codes.size))
    return codes, found


def share_text(amount: int, total: int) -> str:
    """Write a share with the digits that it has: `46.2 %`, of few points `46 %` or `5 of 12`.

    >>> share_text(457, 1000), share_text(46, 100), share_text(5, 12), share_text(1, 40000)
    ('45.7 %', '46 %', '5 of 12', 'under 0.1 %')
    """
    if total < FEW_POINTS:
        return f"{amount} of {total}"
    decimals = 1 if total >= EXACT_POINTS else 0
    least = 10.0**-decimals
    percent = round(100.0 * amount / total, decimals)
    if amount and percent < least:
        return f"under {least:g} %"
    if amount < total and percent > 100.0 - least:
        return f"over {100.0 - least:g} %"
    return f"{percent:.{decimals}f} %"
