"""Answers of a sweep: how the mass moves, where that changes, what is an exception, how hard supports are struck.

A line of a sweep runs along the parameter with the finest grid, at fixed values of the others. Many lines are a map.
"""

from __future__ import annotations

import re

import numpy as np
import xarray as xr

from vibropipe.figures.claims import between_text, rising_text
from vibropipe.figures.motion_words import way_of
from vibropipe.figures.regime_words import reasons_text
from vibropipe.report.findings import largest, point_text, value_text
from vibropipe.report.parts import MAX_ANSWERS, Answer
from vibropipe.scenes.certificate_page import proof_answer
from vibropipe.scenes.sweep.laws import share_text
from vibropipe.scenes.sweep.moves import fills_answer, moves_answer
from vibropipe.scenes.sweep.neighbours import (
    doubling_answer,
    is_followed,
    jumps_of,
    together_answer,
)
from vibropipe.scenes.sweep.quantities import SURE, Series, exponent_ends, of_orbits
from vibropipe.scenes.sweep.sweep_rows import axis_of, is_from_rest, is_map, lines_of, n_lines
from vibropipe.words.regimes import Regime
from vibropipe.words.wording import capitalised, count, series, share

MAX_LINES = 12  # lines whose jumps are told
MANY = 0.05  # share of rows from which chaos is told before impacts
UNKNOWN = 0.01  # share of rows without a result from which they are told before other answers
SAYS_LEAST = re.compile(" occur (in all rows|up to both ends) ")
DIGITS = 3


def sweep_answers(dataset: xr.Dataset) -> list[Answer]:
    """Return the answers of one sweep, at most three: the most useful first, the limit of what is known last."""
    aperiodic = float((dataset["regime"] == Regime.APERIODIC).mean())
    is_line = not is_map(dataset)
    chaos, hardest = aperiodic_answer(dataset), hardest_answer(dataset)
    moves = None
    if aperiodic < 1.0:  # else what is known of chaos says it
        moves = moves_answer(dataset) if is_line else fills_answer(dataset)
    together = together_answer(dataset, axis_of(dataset))
    found = [
        proof_answer(dataset),
        progress_answer(dataset),
        cost_answer(dataset),
        doubling_answer(dataset, axis_of(dataset)),
        exponent_answer(dataset) if is_line else None,
        # of several lines, where impacts are says least
        *([together, moves] if is_line and n_lines(dataset) > 1 else [moves, together]),
        *([chaos, hardest] if aperiodic >= MANY else [hardest, chaos]),
        jumps_answer(dataset) if n_lines(dataset) <= MAX_LINES else None,
        mean_answer(dataset),
    ]
    told, unresolved = [each for each in found if each is not None], unresolved_answer(dataset)
    told.sort(key=lambda answer: bool(SAYS_LEAST.search(answer.lead)))
    if (dataset["regime"] == Regime.UNBOUNDED).all():
        unresolved = None  # how the mass moves says it
    if unresolved is not None:  # few stand under the methods, where there is more to say
        is_many = float((dataset["regime"] >= Regime.UNBOUNDED).mean()) >= UNKNOWN
        told.insert(MAX_ANSWERS - 1 if is_many else MAX_ANSWERS, unresolved)
    return told[:MAX_ANSWERS]


def hardest_answer(dataset: xr.Dataset) -> Answer | None:
    """Return the largest force of a soft support, else the hardest impact of an orbit, and the harder one of chaos."""
    name, words = "support_force_max", "largest force on a soft support"
    top = largest(of_orbits(dataset, Series(name))) if name in dataset else None
    if top is None:
        name, words = "impact_velocity_max", "hardest impact of an orbit"
        if name not in dataset:
            return None
        top = largest(of_orbits(dataset, Series(name)))
    if top is None or not float(top):
        struck, known = largest(dataset[name]), dataset["regime"] < Regime.UNBOUNDED
        if not bool(known.any()) or (struck is not None and float(struck)):
            return None
        if bool((dataset["regime"] == Regime.NO_IMPACT).all()):
            return None  # how the mass moves says it
        whole = bool(known.all())
        return Answer(
            "No support is struck." if whole else "No row with a result strikes a support."
        )
    values = of_orbits(dataset, Series(name))
    support, where = int(top["support"]), ""
    alike = abs(values) >= abs(float(top)) * (1.0 - 1e-9)
    place = f"support {support}"
    if alike.sizes["support"] == 2 and bool(alike.sel(support=3 - support).any()):
        place = "both supports" if bool(alike.all("support").any()) else "one support or the other"
    start = "From rest, the" if is_from_rest(dataset) else "The"
    lead = f"{start} {words} is {value_text(top, top, DIGITS)}, on {place}."
    chaos = largest(dataset[name].where(dataset["regime"] == Regime.APERIODIC))
    if chaos is not None and float(chaos) > float(top):
        where = f"Aperiodic motion reaches {value_text(top, chaos, DIGITS)} within its window."
    else:
        where = place_sentence(dataset, values, top, alike.any("support"))
    return Answer(lead, where)


def place_sentence(
    dataset: xr.Dataset, values: xr.DataArray, top: xr.DataArray, rows: xr.DataArray
) -> str:
    """Write at which value of the axis alone a largest value occurs, in `rows`, and where it still rises."""
    dims, axis = dataset["regime"].dims, axis_of(dataset)
    rises = rising_text(values, top, dims)
    others = [dim for dim in rows.dims if dim != axis]
    is_one = not is_map(dataset) and int(rows.any(others).sum()) == 1 < dataset.sizes[axis]
    if not is_one or rising_text(values, top, [axis]):
        return f"{capitalised(rises)}." if rises else ""
    if len(dims) == 1:
        return f"It occurs in the row {point_text(top, dims)}."
    also = f" and {rises.removeprefix('it ')}" if rises else ""
    return f"It occurs at {point_text(top, [axis])}{also}."


def aperiodic_answer(dataset: xr.Dataset) -> Answer | None:
    """Return the share of aperiodic rows, and the window in which they are known."""
    is_aperiodic = dataset["regime"].values == Regime.APERIODIC
    if not is_aperiodic.any():
        return None
    lead = f"The motion does not repeat itself {of_rows(dataset, int(is_aperiodic.sum()))}."
    if is_aperiodic.all():
        where = (
            "" if is_aperiodic.size == 1 else " at any point" if is_map(dataset) else " in any row"
        )
        lead = f"The motion does not repeat itself{where}."
    if "window_periods" not in dataset:
        return Answer(lead)
    windows = dataset["window_periods"].transpose(*dataset["regime"].dims).values[is_aperiodic]
    least = "at least " if np.ptp(windows) else ""
    periods = count(int(windows.min()), "forcing period")
    return Answer(
        lead, f"That is so in a window of {least}{periods}; whether it settles later is not known."
    )


def of_rows(dataset: xr.Dataset, amount: int) -> str:
    """Write at which share of the rows of a line, or of the points of a map, something is so."""
    at, unit = ("at", "points") if is_map(dataset) else ("in", "rows")
    total = dataset["regime"].size
    if amount == total:
        return f"{at} all {unit}"
    share = share_text(amount, total)
    return f"{at} {share} of the {unit}" if "%" in share else f"{at} {share} {unit}"


def exponent_answer(dataset: xr.Dataset) -> Answer | None:
    """Return at how many rows perturbations grow exponentially, and the largest Lyapunov exponent."""
    if "lyapunov_exponent" not in dataset:
        return None
    exponent, (low, high) = dataset["lyapunov_exponent"], exponent_ends(dataset)
    grows = low > 0.0
    if not bool(exponent.notnull().any()):
        return None
    if not bool(grows.any()):
        rest = "Perturbations grow exponentially in no row." if bool((high <= 0.0).all()) else ""
        return Answer(f"No Lyapunov exponent is positive beyond {SURE} times its error.", rest)
    top = largest(exponent.where(grows))
    assert top is not None
    return Answer(
        f"The largest Lyapunov exponent is positive {of_rows(dataset, int(grows.sum()))}.",
        f"There perturbations grow exponentially; the exponent reaches {value_text(top, top, 2)}.",
    )


def mean_answer(dataset: xr.Dataset) -> Answer | None:
    """Return the largest mean displacement of the orbits and its row; none if it is rounding."""
    if "displacement_mean" not in dataset:
        return None
    mean = of_orbits(dataset, Series("displacement_mean"))
    top = largest(mean)
    if top is None:
        return None
    scale = None
    if "displacement_amplitude" in dataset:
        scale = largest(of_orbits(dataset, Series("displacement_amplitude", "harmonic", 0)))
    if scale is not None and abs(float(top)) <= 1e-9 * abs(float(scale)):
        return Answer("The mean displacement of every orbit is zero.")
    rises = rising_text(mean, top, dataset["regime"].dims)
    lead = f"The mean displacement reaches {value_text(top, top, DIGITS)}."
    if rises:
        return Answer(lead, f"Its size {rises.removeprefix('it ')}.")
    alike = abs(mean) >= abs(float(top)) * (1.0 - 1e-9)
    if dataset["regime"].ndim == 1 < alike.size and int(alike.sum()) == 1:
        return Answer(lead, f"That is in the row {point_text(top, dataset['regime'].dims)}.")
    return Answer(lead)


def jumps_answer(dataset: xr.Dataset) -> Answer | None:
    """Return between which rows the first harmonic jumps most; of followed rows nothing, which may jump early."""
    if is_followed(dataset):
        return None
    axis = axis_of(dataset)
    found = [(jump, line) for _, line in lines_of(dataset) for jump in jumps_of(line, axis)]
    if not found:
        return None
    jump, line = max(found, key=lambda each: each[0].size)
    where = between_text(line[axis], jump.before, jump.after)
    if len(found) == 1:
        return Answer(f"The first harmonic jumps {where}.")
    lead = "The first harmonic jumps in several places."
    return Answer(lead, f"The largest of these lies {where}.")


def unresolved_answer(dataset: xr.Dataset) -> Answer | None:
    """Return how many rows are unresolved and why, and how many grow without bound; none for none."""
    codes = dataset["regime"].values
    texts, reasons = [], ""
    for code in (Regime.UNRESOLVED, Regime.UNBOUNDED):
        mask = codes == code
        if mask.any():
            texts.append((int(mask.sum()), code.name.lower()))
            if code == Regime.UNRESOLVED and "status" in dataset:
                reasons = reasons_text(dataset["status"].values[mask])
    if not texts:
        return None
    both = len(texts) == 2  # a third number would be too many
    lead = f"{share(texts[0][0], codes.size, 'row')} {texts[0][1]}"
    if both:
        lead = series(f"{count(n, 'row')} {'is' if n == 1 else 'are'} {word}" for n, word in texts)
    reasons = re.sub(r" \([\d,]+\)", "", reasons)
    return Answer(f"{capitalised(lead)}.", f"Reason: {reasons}." if reasons else "")


def fastest(dataset: xr.Dataset) -> tuple[xr.DataArray, xr.DataArray | None, xr.DataArray | None]:
    """Return the mean velocities of the housing in orbits, the largest of them, and the largest velocity of any."""
    is_orbit = dataset["regime"] < Regime.APERIODIC
    mean = dataset["housing_velocity_mean"].where(is_orbit)
    return mean, largest(mean), largest(dataset["housing_velocity_max"].where(is_orbit))


def progress_answer(dataset: xr.Dataset) -> Answer | None:
    """Return how fast the housing progresses in orbits, and which way; none where it is fixed."""
    if "housing_velocity_mean" not in dataset:
        return None
    values, top, speed = fastest(dataset)
    if top is None or speed is None:
        return None
    way, dims = way_of(float(top), float(speed)), dataset["regime"].dims
    if way is None:
        return Answer("In no orbit does the housing progress.")
    orbits = "reached from rest" if is_from_rest(dataset) else "on which the starts settle"
    orbits = "that are followed" if is_followed(dataset) else orbits
    most = value_text(top, abs(top), DIGITS)
    lead = f"In the orbits {orbits}, the fastest progression of the housing is {most}, {way}."
    back = largest(values.where(values * float(top) < 0))
    rises = rising_text(values, top, dims)
    other = None if back is None else way_of(float(back), float(speed))
    rest = f"Its speed {rises.removeprefix('it ')}" if rises else ""
    if back is not None and other is not None:
        most = value_text(back, abs(back), DIGITS)
        rest = f"{rest}; {other} it reaches {most}" if rest else f"It reaches {most} {other}"
    return Answer(lead, f"{rest or f'That is at {point_text(top, dims)}'}.")


def cost_answer(dataset: xr.Dataset) -> Answer | None:
    """Return the power of the force in the orbit with the fastest progression; none where no housing progresses."""
    if "power_input" not in dataset or "housing_velocity_mean" not in dataset:
        return None
    _, top, speed = fastest(dataset)
    if top is None or speed is None or way_of(float(top), float(speed)) is None:
        return None
    power = dataset["power_input"].sel({name: top[name] for name in dataset["regime"].dims})
    most = value_text(power, power, DIGITS)
    return Answer(
        f"With the fastest progression of an orbit, the mean power of the force is {most}."
    )
