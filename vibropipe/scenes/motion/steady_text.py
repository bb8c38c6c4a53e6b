"""The steady state of a motion in words: what it strikes, where it rests, its multipliers."""

from __future__ import annotations

import numpy as np
import xarray as xr

from vibropipe.figures.motion_words import slides_away
from vibropipe.figures.regime_words import regime_clause, regime_text
from vibropipe.figures.text import REST, format_number, is_forced, modulus_text, times
from vibropipe.report.parts import DASH
from vibropipe.words.regimes import Regime
from vibropipe.words.wording import count

DIGITS = 4  # significant digits
MAX_LISTED = 2  # velocities of a cell


def struck(dataset: xr.Dataset, support: int) -> list[float]:
    """Return the velocities before the impacts of the orbit on a support, in order; none without an orbit."""
    if "orbit_impact_velocity" not in dataset or not int(dataset["period_multiple"]):
        return []
    at = dataset["orbit_impact_support"].values == support
    return [float(v) for v in dataset["orbit_impact_velocity"].values[at]]


def is_steady(dataset: xr.Dataset) -> bool:
    """Return whether a motion has a label of its steady state."""
    return "regime" in dataset and not dataset["regime"].ndim


def struck_text(dataset: xr.Dataset, support: int) -> str:
    """Write the velocities before the impacts on a support, of many the largest; of those before a rest, too."""
    velocities = struck(dataset, support)
    largest = format_number(max(velocities, key=abs), DIGITS) if velocities else ""
    if "rests_per_orbit" in dataset and float(dataset["rests_per_orbit"].sel(support=support)):
        return f"{largest}, {REST}" if largest else REST
    if len(velocities) > MAX_LISTED:
        return f"{times(len(velocities))}, largest {largest}"
    return ", ".join(format_number(v, DIGITS) for v in velocities) or DASH


def multiplier_text(dataset: xr.Dataset) -> str:
    """Write the largest modulus of the multipliers; a dash without an orbit."""
    if "floquet_multiplier" not in dataset:
        return DASH
    return modulus_text(float(np.abs(dataset["floquet_multiplier"].values).max()))


def orbit_text(dataset: xr.Dataset) -> str:
    """Write what the steady state of a motion strikes, as a sentence without its full stop."""
    code, multiple = int(dataset["regime"]), int(dataset["period_multiple"])
    if code == Regime.APERIODIC:
        window = int(dataset["window_periods"]) if "window_periods" in dataset else 0
        span = f" in a window of {count(window, 'forcing period')}" if window else ""
        return f"The motion does not repeat{span}"
    if multiple == 0:
        grows = "The motion grows without bound"
        grows = "The mass slides away with its housing" if slides_away(dataset) else grows
        return grows if code == Regime.UNBOUNDED else "No steady state was found"
    rests = [s for s in (1, 2) if rests_on(dataset, s)]
    if rests:
        where = "both supports" if len(rests) == 2 else f"support {rests[0]}"
        return f"In the steady state the mass comes to rest on {where}"
    if "impacts_per_orbit" not in dataset:
        return f"The steady state {regime_clause(regime_text(code))}"
    struck = {s: round(float(dataset["impacts_per_orbit"].sel(support=s))) for s in (1, 2)}
    numbers = [n for n in struck.values() if n]
    if not numbers:
        return "In the steady state no support is struck"
    period = "in each forcing period" if is_forced(dataset) else "in each period"
    if is_forced(dataset) and multiple > 1:
        period = f"in {count(multiple, 'forcing period')}"
    if len(numbers) == 2:
        who = "both supports are struck"
        if numbers[0] != numbers[1]:
            return f"In the steady state {who}, {times(sum(numbers))} {period}"
        return f"In the steady state {who} {times(numbers[0])} {period}"
    support = next(s for s, n in struck.items() if n)
    return f"In the steady state only support {support} is struck, {times(numbers[0])} {period}"


def rests_on(dataset: xr.Dataset, support: int) -> bool:
    """Return whether the mass comes to rest on a support in each orbit."""
    return (
        "rests_per_orbit" in dataset and float(dataset["rests_per_orbit"].sel(support=support)) > 0
    )
