"""Answers of branches: where several motions are stable, where and why motions jump, where impacts are hardest."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import xarray as xr

from vibropipe.figures.motion_words import amount_text, changing_text
from vibropipe.figures.text import format_number, with_units
from vibropipe.report.findings import equal_text, symbol_text, value_text
from vibropipe.report.parts import MAX_ANSWERS, Answer
from vibropipe.scenes.branch.jumps import jumps_of
from vibropipe.scenes.branch.lines import (
    cascade_of,
    followed,
    is_symmetric,
    place_text,
    places_of,
    swept,
    values_beside,
)
from vibropipe.scenes.branch.motor import motor_answer
from vibropipe.scenes.branch.stretches import (
    SAME,
    Stretch,
    coexistence,
    common_intervals,
    group_words,
    image_groups,
    stable_words,
    stretches_of,
    united,
)
from vibropipe.scenes.branch.yields import yield_answer
from vibropipe.scenes.certificate_page import proof_answer
from vibropipe.store.table import is_neutral
from vibropipe.words.wording import series

# Ranges of a law that an answer lists.
MAX_RANGES = 3
MAX_NAMED = 2  # motions beyond a jump
PEAK = 3  # points of a peak that are equally high but for SAME


def branch_answers(dataset: xr.Dataset) -> list[Answer]:
    """Return the answers of one scene: coexistence, jumps or period doublings or else bifurcations, hardest impact."""
    stretches = stretches_of(dataset)
    changes = None
    if "law" not in dataset.attrs:
        changes = jump_answer(dataset, stretches) or cascade_answer(dataset)
        changes = changes or gap_answer(dataset, stretches)
    found = [
        law_answer(dataset, stretches),
        motor_answer(dataset),
        yield_answer(dataset),
        proof_answer(dataset),
        lopsided_answer(dataset, stretches) or together_answer(dataset, stretches),
        changes or kinds_answer(dataset),
        velocity_answer(dataset),
    ]
    return [answer for answer in found if answer is not None][:MAX_ANSWERS]


def law_answer(dataset: xr.Dataset, stretches: list[Stretch]) -> Answer | None:
    """Write where orbits of the law that was sought exist, and where they are stable; None without a law."""
    if "law" not in dataset.attrs:
        return None
    along, beside, over = dataset[followed(dataset)].values, values_beside(dataset), swept(dataset)
    ids = dataset["branch_id"].values
    found = {
        float(value): united(
            [
                (float(along[own].min()), float(along[own].max()))
                for own in ((ids == n) & (beside == value) for n in np.unique(ids))
                if own.any()
            ]
        )
        for value in np.unique(beside)
    }
    widest = max(found, key=lambda value: sum(high - low for low, high in found[value]))
    stable = united(
        [(float(s.values[0]), float(s.values[-1])) for s in stretches if s.over == widest]
    )
    is_where = ranges_text(dataset, stable)
    rest = f"They are stable {is_where}." if stable else "None of those found there is stable."
    absent = int(dataset.attrs.get("without_law", 0))
    if over and absent:
        values = amount_text(absent, "value")
        rest += f" At {values} of {symbol_text(dataset[over])} none is found."
    exist = f"exist{over_text(dataset, widest)} {ranges_text(dataset, found[widest])}"
    return Answer(f"Orbits {dataset.attrs['law']} {exist}.", rest)


def ranges_text(
    dataset: xr.Dataset,
    intervals: list[tuple[float, float]],
    beside: Sequence[tuple[float, float]] = (),
) -> str:
    """Write the widest of some intervals: from ν = 1 to 2 and from 3 to 4.

    beside : other intervals that are told of the same places: with fewer digits an end may lie within one of them
    """
    axis = dataset[followed(dataset)]
    shown = sorted(sorted(intervals, key=lambda each: each[0] - each[1])[:MAX_RANGES])
    texts: list[str] = []
    for first, last in distinct_texts(*shown, *beside)[: len(shown)]:
        texts.append(f"from {first if texts else f'{symbol_text(axis)} = {first}'} to {last}")
    text = with_units(axis, series(texts))
    left = len(intervals) - len(shown)
    return text + (f", and in {amount_text(left, 'narrower range')}" if left else "")


def at_text(dataset: xr.Dataset, value: float) -> str:
    """Write a value of the parameter that is followed: ν = 1.723."""
    axis = dataset[followed(dataset)]
    return equal_text(axis, value)


def over_text(dataset: xr.Dataset, value: float) -> str:
    """Write the value of the further parameter: at f = 1; empty without one."""
    over = swept(dataset)
    return f" at {equal_text(dataset[over], value)}" if over else ""


def together_answer(dataset: xr.Dataset, stretches: list[Stretch]) -> Answer | None:
    """Write between which values of the parameter several motions are stable: the widest interval."""
    found = [
        (high - low, low, high, value)
        for value, intervals in coexistence(stretches).items()
        for low, high in intervals
    ]
    if not found:
        return None
    _, low, high, value = max(found)
    axis = dataset[followed(dataset)]
    ((first, last),) = distinct_texts((low, high))
    symbol, last = symbol_text(axis), with_units(axis, last)
    more = ", and elsewhere" if len(found) > 1 else ""
    alike = [s for s in stretches if s.over == value]
    return Answer(
        f"The start decides which motion settles from {symbol} = {first} to {last}{over_text(dataset, value)}{more}.",
        f"Stable there: {stable_words(alike, low, high)}.",
    )


def lopsided_answer(dataset: xr.Dataset, stretches: list[Stretch]) -> Answer | None:
    """Write where lopsided motions are stable; None unless these pairs of mirror images are all that coexists."""
    together = common_intervals(stretches)
    if swept(dataset) or not together or not is_symmetric(dataset):
        return None
    found = []
    for low, high in together:
        middle = (low + high) / 2
        inside = [s for s in stretches if s.reaches(low) and s.reaches(high)]
        if (
            len(inside) != 2
            or sum(s.values[0] < high and s.values[-1] > low for s in stretches) > 2
        ):
            return None
        one, other = (float(np.interp(middle, s.values, s.means)) for s in inside)
        size = abs(one - other)
        if size <= SAME * inside[0].amplitude(middle) or abs(one + other) > np.sqrt(SAME) * size:
            return None
        found.append((low, high))
    return Answer(
        f"Lopsided motions are stable {ranges_text(dataset, found)}.",
        "Each is one of two mirror images; the start decides which.",
    )


def distinct_texts(*intervals: tuple[float, float]) -> list[tuple[str, str]]:
    """Write intervals with as many digits as tell the ends of each apart, at least 4."""
    for digits in range(4, 13):
        texts = [
            (format_number(low, digits), format_number(high, digits)) for low, high in intervals
        ]
        if all(low != high for low, high in texts):
            break
    return texts


def jump_answer(dataset: xr.Dataset, stretches: list[Stretch]) -> Answer | None:
    """Write where motions jump, and the hardest jump: why, and to which motion; small steps may be jumps as well."""
    jumps = jumps_of(dataset, stretches)
    if not jumps:
        return None
    largest, axis = jumps[0], dataset[followed(dataset)]
    places = len({(jump.stretch.over, round(jump.value, 9)) for jump in jumps})
    changes = f"where {changing_text(dataset)}"
    causes = {"fold": "at folds", "grazing": "at grazings", "change": changes}
    found = {jump.kind for jump in jumps}
    where = series(text for kind, text in causes.items() if kind in found)
    way = "grows" if largest.is_up else "falls"
    beyond = list(dict.fromkeys(group_words(alike) for alike in image_groups(largest.targets)))
    cause = changes if largest.kind == "change" else f"a {largest.kind}"
    alike = {
        (j.stretch.over, round(j.value, 9)) for j in jumps if j.size >= (1 - SAME) * largest.size
    }
    of = " of the impact velocity"  # by which jumps are compared
    which = "The jump" if places == 1 else f"The largest jump{of}"
    which = f"One of the largest jumps{of}" if len(alike) > 1 else which
    named = "; ".join(beyond[:MAX_NAMED] + ["others"] * (len(beyond) > MAX_NAMED))
    return Answer(
        f"Followed motions jump {where}, in at least {amount_text(places, 'place')}.",
        f"{which} leaves “{largest.stretch.words}” as {symbol_text(axis)} {way} past "
        f"{value_text(axis, largest.value)}{over_text(dataset, largest.stretch.over)}, {cause}; "
        + (f"stable beyond: {named}." if beyond else "no motion followed here is stable beyond."),
    )


def gap_answer(dataset: xr.Dataset, stretches: list[Stretch]) -> Answer | None:
    """Write the widest range between the ends of branches in which no orbit is stable; None without one."""
    steady = (dataset["stable"].values == 1) | is_neutral(dataset)
    if swept(dataset) or not stretches or not steady.any():
        return None
    axis = dataset[followed(dataset)]
    known = [(float(s.values[0]), float(s.values[-1])) for s in stretches]
    ends = [float(axis.min()), *(end for each in united(known) for end in each), float(axis.max())]
    gaps = [
        (low, high)
        for low, high in zip(ends[::2], ends[1::2], strict=True)
        if high - low > SAME * np.ptp(axis.values)
        and not (steady & (axis.values > low) & (axis.values < high)).any()
    ]
    if not gaps:
        return None
    return Answer(f"No orbit that is followed here is stable {ranges_text(dataset, gaps, known)}.")


def cascade_answer(dataset: xr.Dataset) -> Answer | None:
    """Write how often the period doubles, and by what ratio the steps shrink."""
    places = cascade_of(dataset)
    if not places:
        return None
    steps = np.abs(np.diff(places))
    return Answer(
        "From flip to flip the steps shrink.",
        f"The first flip is at {at_text(dataset, places[0])}; the last step is "
        f"{format_number(steps[-2] / steps[-1], 3)} times smaller than the one before.",
    )


def kinds_answer(dataset: xr.Dataset) -> Answer | None:
    """Write how many bifurcations of each kind there are, and what changes are; none of changes alone."""
    if not dataset.sizes["bifurcation"] and dataset.sizes["point"]:
        return Answer("No bifurcation is found on the branches.")
    places = {kind: at for kind, at in places_of(dataset).items() if kind != "end"}
    if not {*places} - {"change"}:
        return None
    texts = series(amount_text(at.size, kind) for kind, at in places.items())
    rest = f"At a change {changing_text(dataset)}." if "change" in places else ""
    return Answer(f"The branches have {texts}.", rest)


def peak_text(dataset: xr.Dataset, velocity: xr.DataArray, point: int) -> str:
    """Write where the largest velocity lies, in the digits that the stable points beside it leave, or at an end."""
    axis, largest = dataset[followed(dataset)], velocity.max("support").values
    value = float(axis.values[point])
    beside = [n for n in (point - 1, point + 1) if 0 <= n < largest.size and largest[n] > 0]
    is_one_branch = len({*dataset["branch_id"].values[[*beside, point]].tolist()}) == 1
    if len(beside) < 2 or not is_one_branch or value == 0.0:
        return f"at {at_text(dataset, value)}"
    reach = float(np.abs(axis.values[beside] - value).max())
    last = math.floor(math.log10(abs(value)))
    digits = next((n for n in (4, 3, 2) if reach <= 10.0 ** (last - n + 1)), 1)
    return f"near {equal_text(axis, value, digits)}"


def places_alike(dataset: xr.Dataset, velocity: xr.DataArray, point: int) -> str:
    """Write where the largest velocity lies if points that are no neighbours have it; empty of one peak."""
    most = np.nan_to_num(velocity.max("support").values)
    alike = np.flatnonzero(most >= (1.0 - SAME) * most[point])
    axis = dataset[followed(dataset)]
    ids = dataset["branch_id"].values
    runs = 1 + int(((np.diff(alike) > 1) | (np.diff(ids[alike]) != 0)).sum())
    ordered = alike[np.argsort(axis.values[alike], kind="stable")]
    texts = [*dict.fromkeys(place_text(dataset, n) for n in ordered)]
    if len(texts) == 1 or (runs == 1 and alike.size <= PEAK):
        return ""
    if len(texts) == 2:
        return f"at {' and at '.join(texts)}"
    return "in several places"


def end_text(dataset: xr.Dataset, value: float) -> str:
    """Write which bifurcation lies at an end of what is followed, or that it is an end; empty inside."""
    axis = dataset[followed(dataset)]
    if value not in (float(axis.min()), float(axis.max())):
        return ""
    reach = SAME * float(np.ptp(axis.values))
    kinds = {kind: at for kind, at in places_of(dataset).items() if kind != "end"}
    near = [kind for kind, at in kinds.items() if (np.abs(at - value) <= reach).any()]
    return f", a {near[0]}" if near else ", where the branch is followed no further"


def velocity_answer(dataset: xr.Dataset) -> Answer | None:
    """Write the largest impact velocity of the stable points and its place."""
    # An orbit at its bifurcation, of which rounding decides, is the end of stable ones.
    steady = (dataset["stable"].values == 1) | is_neutral(dataset)
    velocity = dataset["impact_velocity_max"].where(xr.DataArray(steady, dims="point"))
    if not bool((velocity > 0).any()):
        return None
    top = velocity.isel({str(k): int(v) for k, v in velocity.argmax(...).items()})
    axis = dataset[followed(dataset)]
    point = int(velocity.max("support").argmax("point"))
    value = float(axis.values[point])
    most = velocity.max("support").values
    if (most > (1.0 - SAME) * float(top)).sum() == (most > 0.0).sum() > 1:
        lead = "All stable motions followed here that strike a support do so equally hard."
        return Answer(
            lead, f"The largest velocity before impact is {value_text(top, float(top), 3)}."
        )
    where_else = places_alike(dataset, velocity, point)
    beside = over_text(dataset, values_beside(dataset)[point])
    end = end_text(dataset, value)
    both, most = velocity.isel(point=point).values, velocity.max("point").values
    where = f"support {int(top['support'])}"
    if np.ptp(most) <= SAME * most.max():  # of one orbit, or of mirror images
        where = "each support" if np.ptp(both) <= SAME * both.max() else "one support"
    place = where_else or f"{peak_text(dataset, velocity, point)}{beside}{end}"
    return Answer(
        f"Stable motions followed here strike hardest {place}.",
        f"The velocity before that impact, on {where}, is {value_text(top, float(top), 3)}.",
    )
