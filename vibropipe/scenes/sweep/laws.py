"""Laws of motion of the rows of a sweep: orbits (m; p1, p2), and the regions of maps with the share of their points.

An orbit (m; p1, p2) repeats after m forcing periods and strikes support 1 p1 times and support 2 p2 times.
"""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from vibropipe.figures.motion_words import number_word, orbit_text, slides_away, times_word
from vibropipe.figures.palette import PROOF_STYLES, REGIME_STYLES, RegimeStyle, shaded
from vibropipe.figures.regime_words import REGIME_TEXT, regime_name, regime_text
from vibropipe.words.regimes import Regime

# Code of orbits that strike both supports, but not each of them once a forcing period.
MORE = max(Regime) + 1
FEW_POINTS, EXACT_POINTS = 50, 1000  # shares of fewer points are amounts, or have no decimal
WORDS = {
    "no_impact": ("no impact", "strikes no support"),
    "one_sided_1": ("only support 1 struck", "strikes support 1 alone"),
    "one_sided_2": ("only support 2 struck", "strikes support 2 alone"),
    "two_sided": ("both supports struck", "strikes both supports"),
    "with_rest": ("rest on a support", "comes to rest on a support"),
    "aperiodic": ("aperiodic", "moves without repetition"),
    "unbounded": ("unbounded", "moves without bound"),
    "unresolved": ("no result", "has no result"),
}
AWAY = ("housing slides away", "slides away with its housing")
STILL = ("no motion", "does not move")
ONCE = ("each support struck once a period", "strikes each support once a period")
# Of orbits that strike both supports, but not each of them once a period: more often all, most or not even these.
MORE_OFTEN = (
    ("both supports struck, more often", "strikes both supports, more than twice a period in all"),
    ("both supports struck, mostly more often", "strikes both supports, mostly more than twice a period in all"),
    ("both supports struck, other orbits", "strikes both supports, in other orbits than once a period each"),
)  # fmt: skip
MAX_LAWS = 12  # laws with a look of their own; further ones of a regime share one
MIN_SHARE = 0.002  # share of the rows that a law needs for a look of its own
CODE = 1 << 20  # above any number of impacts or of periods that is told apart
OTHER = -1  # of m, in the law of all further orbits of a regime
# Of the laws of a regime after the first: towards white (> 0) or black (< 0), and hatch.
SHADES = (
    (0.55, "///"),
    (-0.35, "..."),
    (0.3, "\\\\\\"),
    (0.75, "xxx"),
    (-0.15, "++"),
    (0.45, "oo"),
)
OTHER_LOOK = (0.65, "---")


@dataclass(frozen=True)
class Law:
    """Regime with its orbit (m; p1, p2); m is 0 without an orbit, OTHER for the remaining orbits."""

    regime: int
    m: int
    p1: int
    p2: int
    colour: str = ""
    hatch: str = ""

    @property
    def short(self) -> str:
        """Text in a region of a map."""
        name = regime_name(self.regime)
        if self.m == OTHER:
            return f"other {REGIME_TEXT[name].partition(',')[0]}"
        if self.m == 0 or (name == "no_impact" and self.m == 1):
            return REGIME_TEXT[name].replace(", support", "")
        return orbit_text(self.m, self.p1, self.p2)

    @property
    def words(self) -> str:
        """Words for captions: how often the supports are struck, and in how many periods."""
        name = regime_name(self.regime)
        if self.m == OTHER or self.m == 0 or name == "no_impact":
            return self.short
        within = "a period" if self.m == 1 else f"in {number_word(self.m)} periods"
        if name.startswith("one_sided"):
            support, hits = (1, self.p1) if self.p1 else (2, self.p2)
            return f"support {support} {times_word(hits)} {within}"
        if self.p1 == self.p2:
            return f"each support {times_word(self.p1)} {within}"
        return f"support 1 {times_word(self.p1)}, support 2 {times_word(self.p2)} {within}"

    @property
    def text(self) -> str:
        """Text in a legend: the regime with the orbit."""
        words = regime_text(self.regime)
        if self.m == OTHER:
            return f"{words}, other"
        return words if words.replace(", support", "") == self.short else f"{words} {self.short}"


def laws_of(dataset: xr.Dataset) -> tuple[xr.DataArray, list[Law]]:
    """Return the number of the law of each row, and the laws by number, the most frequent first.

    Rows that stick to a support are one law, whatever the number of impacts before.
    """
    regime = dataset["regime"]
    m, p1, p2 = (part.values for part in orbit_numbers(dataset))
    keys = np.stack([regime.values.astype(np.int64), m, p1, p2], axis=-1).reshape(-1, 4)
    packed = ((keys[:, 0] * CODE + keys[:, 1]) * CODE + keys[:, 2]) * 4096 + keys[:, 3]
    _, first, inverse, amounts = np.unique(
        packed, return_index=True, return_inverse=True, return_counts=True
    )
    order = np.argsort(-amounts, kind="stable")
    laws: dict[Law, int] = {}
    number = np.empty(order.size, np.int64)
    for rank, index in enumerate(order):
        regime_code, periods, first_hits, second_hits = map(int, keys[first[index]])
        law = Law(regime_code, periods, first_hits, second_hits)
        has_look = rank < MAX_LAWS and amounts[index] >= MIN_SHARE * regime.size
        is_divided = any(known.regime == law.regime for known in laws)
        if law.m > 0 and not has_look and is_divided:  # the next ones of its regime are `other`
            law = Law(law.regime, OTHER, 0, 0)
        number[index] = laws.setdefault(law, len(laws))
    codes = regime.copy(data=number[inverse.reshape(-1)].reshape(regime.shape)).drop_attrs(
        deep=False
    )
    return codes.rename("law"), with_looks(list(laws))


def orbit_numbers(dataset: xr.Dataset) -> tuple[xr.DataArray, xr.DataArray, xr.DataArray]:
    """Return m, p1 and p2 of each row as integers; 0 where no orbit was found or it sticks to a support."""
    regime = dataset["regime"]
    whole = (regime < Regime.APERIODIC) & (regime != Regime.WITH_REST)
    multiple = dataset.get("period_multiple", xr.ones_like(regime)).astype(np.int64)
    if "impacts_per_orbit" in dataset:
        per_orbit = dataset["impacts_per_orbit"]
    elif "impacts_per_period" in dataset:
        per_orbit = dataset["impacts_per_period"] * multiple
    else:
        zero = xr.zeros_like(multiple)
        return multiple.where(whole, 0), zero, zero
    counts = per_orbit.transpose(*regime.dims, "support").fillna(0).round().astype(np.int64)
    p1, p2 = (counts.isel(support=n, drop=True).clip(0, 4095).where(whole, 0) for n in (0, 1))
    return multiple.where(whole, 0), p1, p2


def with_looks(laws: list[Law]) -> list[Law]:
    """Return laws with colour and hatch: the first of a regime has its colour, the next ones shades and hatches."""
    seen: dict[Hashable, int] = {}
    looks = []
    for law in laws:
        rank = seen.get(law.regime, 0)
        seen[law.regime] = rank + (law.m != OTHER)
        base = REGIME_STYLES[regime_name(law.regime)].colour
        # all that is no orbit keeps the hatch of its regime
        shade, hatch = 0.0, REGIME_STYLES[regime_name(law.regime)].hatch if law.m == 0 else ""
        if law.m == OTHER:
            shade, hatch = OTHER_LOOK
        elif rank:
            shade, hatch = SHADES[(rank - 1) % len(SHADES)]
        looks.append(Law(law.regime, law.m, law.p1, law.p2, shaded(base, shade), hatch))
    return looks


def chosen_rows(dataset: xr.Dataset, most: int) -> list[tuple[int, Law]]:
    """Return one row for each of the most frequent laws: its flat index, in the middle of the law's longest run."""
    codes, laws = laws_of(dataset)
    flat: NDArray[np.int64] = codes.values.reshape(-1)
    rows = []
    for number, law in enumerate(laws):
        if regime_name(law.regime) in ("unresolved", "unbounded"):
            continue
        padded = np.concatenate([[0], flat == number, [0]]).astype(np.int8)
        starts, stops = np.flatnonzero(np.diff(padded) == 1), np.flatnonzero(np.diff(padded) == -1)
        longest = int(np.argmax(stops - starts))
        rows.append((int(starts[longest] + stops[longest]) // 2, law))
    return rows[:most]


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
        """Colour and hatch."""
        return REGIME_STYLES.get(self.name) or PROOF_STYLES[self.name]

    @property
    def share(self) -> str:
        """Its share of the points, as text."""
        return share_text(self.amount, self.total)


def regions_of(dataset: xr.Dataset) -> tuple[xr.DataArray, list[Region]]:
    """Return the code of the region of each row, and the regions that occur, the most frequent first."""
    regime = dataset["regime"]
    has_impacts = "impacts_per_orbit" in dataset or "impacts_per_period" in dataset
    m, p1, p2 = orbit_numbers(dataset)
    is_other = (regime == Regime.TWO_SIDED) & ~((m == 1) & (p1 == 1) & (p2 == 1))
    codes = regime.astype(np.int64).where(~(is_other & has_impacts), MORE).rename("region")
    busy = float((p1 + p2 > 2 * m).where(is_other).mean())
    more = MORE_OFTEN[0 if busy == 1.0 else 1 if busy > 0.5 else 2]
    found = []
    for code, amount in by_amount(codes):
        name = "two_sided_more" if code == MORE else regime_name(code)
        words = WORDS.get(name, more)
        words = ONCE if name == "two_sided" and has_impacts else words
        is_away = code == Regime.UNBOUNDED and bool(
            slides_away(dataset).where(codes == code, True).all()
        )
        words = AWAY if is_away else words
        words = STILL if code == Regime.NO_IMPACT and is_still(dataset, codes == code) else words
        found.append(Region(code, name, *words, amount, codes.size))
    return codes, found


def is_still(dataset: xr.Dataset, rows: xr.DataArray) -> bool:
    """Return whether the mass moves in none of some rows, as far as the harmonics tell: friction may hold it."""
    if "displacement_amplitude" not in dataset:
        return False
    return bool((dataset["displacement_amplitude"].where(rows, 0.0) == 0.0).all())


def by_amount(codes: xr.DataArray) -> list[tuple[int, int]]:
    """Return each code with the number of points that have it, the most frequent first."""
    values, amounts = np.unique(codes.values, return_counts=True)
    return [(int(values[n]), int(amounts[n])) for n in np.argsort(-amounts, kind="stable")]


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
