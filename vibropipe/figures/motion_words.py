"""How a motion strikes the supports, in words: `both supports, once a period`, `support 2, every third period`."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from vibropipe.figures.text import REST
from vibropipe.solve.shown_units import in_si
from vibropipe.store.table import is_neutral
from vibropipe.words.regimes import Regime
from vibropipe.words.vocabulary import physical_name
from vibropipe.words.wording import count

# Of the largest speed of a housing: a mean that is rounding.
NO_PROGRESS = 1e-9


PROGRESSION = "Progression: mean velocity of the housing"


def way_of(mean: float, largest: float) -> str | None:
    """Return which way a housing of some mean and largest speed progresses; None if it does not, or that is not known.

    >>> way_of(0.1, 0.4), way_of(-0.1, 0.4), way_of(-1e-17, 0.4), way_of(0.0, 0.0)
    ('along x', 'against x', None, None)
    """
    if not abs(mean) > NO_PROGRESS * largest:
        return None
    return "along x" if mean > 0 else "against x"


def progression_of(dataset: xr.Dataset) -> float:
    """Return the mean velocity of a housing, 0 where it is rounding; NaN where it is fixed, or not known."""
    if "housing_velocity_mean" not in dataset:
        return math.nan
    mean, most = (float(dataset[f"housing_velocity_{name}"]) for name in ("mean", "max"))
    return 0.0 if abs(mean) <= NO_PROGRESS * most else mean


def slides_away(dataset: xr.Dataset) -> xr.DataArray:
    """Return in which rows the constant forces exceed the friction of a housing, as `physics.housing.runs_away`."""

    def of(name: str) -> xr.DataArray:
        held = name if name in dataset.variables else physical_name(name)
        if held not in dataset.variables:
            return xr.DataArray(0.0)
        return dataset[held].copy(data=in_si(dataset[held]))

    force = of("load") + of("housing_load")
    too_large = (force > of("housing_friction_1")) | (force < -of("housing_friction_2"))
    return (of("mass_ratio") > 0.0) & too_large & xr.ones_like(dataset["regime"], bool)


def is_unstable(dataset: xr.Dataset) -> NDArray[np.bool_]:
    """Return where perturbations of orbits grow, in the shape of `stable`; a motion without an orbit has none."""
    unstable: NDArray[np.bool_] = (dataset["stable"].values == 0) & ~is_neutral(dataset)
    return unstable & has_orbit(dataset)


def has_orbit(dataset: xr.Dataset) -> NDArray[np.bool_]:
    """Return where there is an orbit whose stability is known, in the shape of `stable`."""
    known = np.ones(dataset["stable"].shape, bool)
    if "period_multiple" in dataset:
        known &= dataset["period_multiple"].transpose(*dataset["stable"].dims).values > 0
    if "floquet_multiplier" in dataset:
        multipliers = dataset["floquet_multiplier"].transpose(*dataset["stable"].dims, "multiplier")
        known &= ~np.isnan(multipliers.values).any(axis=-1)
    return known


def stability_text(dataset: xr.Dataset) -> str:
    """Return the stability of one orbit in a word; empty without an orbit."""
    if not has_orbit(dataset):
        return ""
    if int(dataset["stable"]):
        return "stable"
    return "neutral" if is_neutral(dataset) else "unstable"


UNITS = (
    "no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve",
    "thirteen", "fourteen", "fifteen", "sixteen", "seventeen", "eighteen", "nineteen",
)  # fmt: skip
TENS = ("", "", "twenty", "thirty", "forty", "fifty", "sixty", "seventy", "eighty", "ninety")
TIMES = {1: "once", 2: "twice"}
EVERY = {2: "other", 3: "third", 4: "fourth", 5: "fifth", 6: "sixth", 8: "eighth"}
WITHOUT_COUNTS = {
    Regime.NO_IMPACT: "no impact",
    Regime.APERIODIC: "aperiodic",
    Regime.UNBOUNDED: "unbounded",
    Regime.UNRESOLVED: "no result",
}


def number_word(amount: int) -> str:
    """Write a small number in letters.

    >>> number_word(0), number_word(12), number_word(29), number_word(100)
    ('no', 'twelve', 'twenty-nine', '100')
    """
    if amount < len(UNITS):
        return UNITS[amount]
    tens, units = divmod(amount, 10)
    if tens >= len(TENS):
        return str(amount)
    return f"{TENS[tens]}-{UNITS[units]}" if units else TENS[tens]


def amount_text(amount: int, noun: str, plural: str | None = None) -> str:
    """Write an amount in letters with its noun: `one fold`, `three folds`."""
    return f"{number_word(amount)} {noun if amount == 1 else plural or noun + 's'}"


def times_word(amount: int) -> str:
    """Write how often in letters: once, twice, three times."""
    return TIMES.get(amount, f"{number_word(amount)} times")


# What of an orbit may begin or end at a change of its law, beside contacts, by the parameters with which it does.
CHANGING = {("friction",): ["turn", "stick"], ("mass_ratio", "M"): ["slip"]}


def changing_text(dataset: xr.Dataset) -> str:
    """Write what a change of an orbit is by its rests and the effects that it has.

    >>> changing_text(xr.Dataset({"friction": 0.1, "mass_ratio": 0.5}))
    'a contact, turn, stick or slip begins or ends'
    """
    has = {*dataset.variables}
    others = [word for names, words in CHANGING.items() if has & {*names} for word in words]
    if "rests_per_orbit" in has and bool((dataset["rests_per_orbit"] > 0.0).any()):
        others.insert(0, "rest")
    *first, last = ["contact", *others]
    return f"a {' or '.join(filter(None, [', '.join(first), last]))} begins or ends"


def motion_words(regime: int, m: int, impacts: Sequence[float], rests: Sequence[float]) -> str:
    """Write a motion in words.

    m : forcing periods of the orbit, 0 without one
    impacts, rests : on each support in m forcing periods

    >>> motion_words(Regime.TWO_SIDED, 1, (1, 1), (0, 0))
    'both supports, once a period'
    >>> motion_words(Regime.ONE_SIDED_2, 3, (0, 1), (0, 0))
    'support 2, every third period'
    >>> motion_words(Regime.TWO_SIDED, 2, (3, 2), (0, 0))
    'support 1 three times, support 2 twice, in two periods'
    """
    if regime in WITHOUT_COUNTS:
        return WITHOUT_COUNTS[Regime(regime)]
    if regime == Regime.WITH_REST:
        return rest_words(m, impacts, rests)
    first, second = (round(float(p)) for p in impacts)
    if regime == Regime.TWO_SIDED and first != second:
        each = f"support 1 {times_word(first)}, support 2 {times_word(second)}"
        return f"{each}, in {number_word(m)} periods" if m > 1 else f"{each} a period"
    number = max(first, second)
    who = "both supports" if regime == Regime.TWO_SIDED else f"support {int(regime)}"
    if number == 1 and m in EVERY:
        return f"{who}, every {EVERY[m]} period"
    if m > 1:
        return f"{who}, {times_word(number)} in {number_word(m)} periods"
    return f"{who}, {times_word(number)} a period"


def rest_words(m: int, impacts: Sequence[float], rests: Sequence[float]) -> str:
    """Write a motion that rests, with its impacts on a support on which it does not; arguments as of `motion_words`.

    >>> rest_words(1, (19, 0), (1, 0)), rest_words(1, (9, 9), (1, 1))
    ('rest on support 1', 'rest on both supports')
    >>> rest_words(1, (2, 7), (0, 1))
    'rest on support 2, support 1 twice a period'
    >>> rest_words(2, (19, 3), (2, 0))
    'rest on support 1 twice, support 2 three times, in two periods'
    """
    if not max(rests):
        return "rest on a support"
    if rests[0] == rests[1]:
        parts = {"rest on both supports": rests[0]}
    else:
        both = list(enumerate(zip(impacts, rests, strict=True), 1))
        parts = {f"rest on support {n}": rest for n, (_impacts, rest) in both if rest > 0}
        parts |= {f"support {n}": hits for n, (hits, rest) in both if hits > 0 and rest == 0}
    texts = [f"{who} {times_word(round(number))}" for who, number in parts.items()]
    if m <= 1 and max(rests) == 1:
        texts[0] = next(iter(parts))  # one rest a period goes without saying
        if len(texts) == 1:
            return texts[0]
    within = f"{',' * (len(texts) > 1)} in {number_word(m)} periods" if m > 1 else " a period"
    return f"{', '.join(texts)}{within}"


def regime_by(impacts: Sequence[float]) -> Regime:
    """Return the regime of an orbit without rests by its impacts on each support."""
    struck = tuple(n for n, amount in enumerate(impacts, 1) if amount > 0)
    alone = {(): Regime.NO_IMPACT, (1,): Regime.ONE_SIDED_1, (2,): Regime.ONE_SIDED_2}
    return alone.get(struck, Regime.TWO_SIDED)


def words_of(row: xr.Dataset) -> str:
    """Write the motion of one row of a dataset in words."""
    impacts = row["impacts_per_orbit"]
    rests = rests_of(row, impacts)
    counts = (np.nan_to_num(array.values).tolist() for array in (impacts, rests))
    return motion_words(int(row["regime"]), int(row["period_multiple"]), *counts)


def orbit_text(m: int, p1: float | str, p2: float | str) -> str:
    """Write an orbit as (m; p1, p2): impacts on each support in m forcing periods, or `rest`."""
    counts = (p if isinstance(p, str) else f"{p:g}" for p in (p1, p2))
    return f"({m}; {', '.join(counts)})"


def rests_of(dataset: xr.Dataset, impacts: xr.DataArray) -> xr.DataArray:
    """Return the rests on each support in the shape of `impacts`; where they are not stored none."""
    return dataset["rests_per_orbit"] if "rests_per_orbit" in dataset else xr.zeros_like(impacts)


def orbit_texts(dataset: xr.Dataset, dim: str) -> list[str]:
    """Return the orbit (m; p1, p2) at each point or of each design of a dataset."""
    impacts = dataset["impacts_per_orbit"].transpose(dim, "support")
    rests = rests_of(dataset, impacts).transpose(dim, "support").values
    multiples = dataset["period_multiple"].values
    # Impacts of orbits are whole numbers, which are written in full.
    return [
        orbit_text(int(m), *(REST if rest > 0 else float(p) for p, rest in zip(*each, strict=True)))
        for m, *each in zip(multiples, impacts.values, rests, strict=True)
    ]


def window_text(row: xr.Dataset) -> str:
    """Write over how long a motion without an orbit is known; whether it is a transient is not."""
    periods = int(row["window_periods"]) if "window_periods" in row else 0
    return f"in a window of {count(periods, 'forcing period')}" if periods else ""


def aperiodic_text(dataset: xr.Dataset) -> str:
    """Write in how long a window motions are aperiodic; empty if none is."""
    aperiodic = dataset["regime"].values == Regime.APERIODIC
    if not aperiodic.any() or "window_periods" not in dataset:
        return ""
    periods = dataset["window_periods"].transpose(*dataset["regime"].dims).values[aperiodic].min()
    return f"Aperiodic: without repetition in a window of at least {count(int(periods), 'forcing period')}"
