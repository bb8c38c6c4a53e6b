"""Answers on a map of basins and the table of its motions, written from its data."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping

import numpy as np
import xarray as xr

from vibropipe.figures.claims import at_least, outwards
from vibropipe.figures.motion_words import PROGRESSION, number_word, progression_of, way_of
from vibropipe.figures.text import digits, format_number, in_brackets, modulus_text, with_units
from vibropipe.report.parts import DASH, MAX_ANSWERS, Answer, Table, head_and_rows
from vibropipe.scenes.basins.attractors import (
    KNOCK,
    at_rest,
    attractor_words,
    beyond_map,
    images_of,
    knocks_of,
    letters_of,
    named,
    ordered,
    step_of,
)
from vibropipe.scenes.basins.text import HELD, has_friction, percent, start_text
from vibropipe.words.proofs import REFUSED
from vibropipe.words.wording import series

MAX_TOLD = 3  # motions whose speeds are told
MANY = 0.1  # share of border starts above which they are many
ALIKE = 0.05  # relative difference of knocks that are about equal
PROVED = "knock_impulse_low"  # what a table tells of a proof
NOT_FOUND = "No isolated motion was found on which the starts settle"


def knock_when(dataset: xr.Dataset) -> str:
    """Write when in the forcing period a knock acts: at the section, whenever the motions start."""
    return start_text(dataset.assign(start_phase=0.0))


def basin_answers(dataset: xr.Dataset) -> list[Answer]:
    """Return which motions coexist, what starts at rest and next to a border do, and which motion is lost first."""
    indices = ordered(dataset)
    if not indices:
        return [not_found(dataset)]
    shares = {index: percent(float(dataset["basin_share"][index])) for index in indices}
    first, *others = indices
    if not others:
        words = attractor_words(dataset, first)
        whole = float(dataset["basin_share"][first]) == 1.0
        lead = "All starts settle on one motion." if whole else "One motion was found."
        rest = f"It is this: {words}." if whole else f"{shares[first]} of the starts settle on it."
        return [Answer(lead, rest)]
    lead = f"At least {number_word(len(indices))} motions coexist."
    rest = (
        f"{shares[first]} of the starts settle on {named(dataset, first)}, "
        f"{shares[others[0]]} on {named(dataset, others[0])}."
    )
    answers = [Answer(lead, rest), *progression_answers(dataset), border_answer(dataset)]
    return [*answers, *knock_answers(dataset)][:MAX_ANSWERS]


def not_found(dataset: xr.Dataset) -> Answer:
    """Return that no motion was found, and that friction may leave many."""
    return Answer(f"{NOT_FOUND}.", f"{HELD}." if has_friction(dataset) else "")


def progression_answers(dataset: xr.Dataset) -> list[Answer]:
    """Write how fast a housing progresses in each motion, and which way; nothing where it is fixed."""
    if "housing_velocity_mean" not in dataset:
        return []
    motions = dataset.sel(attractor_id=ordered(dataset))
    speeds, letters = motions["housing_velocity_mean"], letters_of(dataset)
    ways = [
        way_of(float(mean), float(most))
        for mean, most in zip(speeds, motions["housing_velocity_max"], strict=True)
    ]
    known = [n for n in range(speeds.size) if np.isfinite(speeds.values[n])][:MAX_TOLD]
    moving = [n for n in known if ways[n] is not None]
    if not moving:
        on = series([letters[int(speeds["attractor_id"][n])] for n in known])
        return [Answer(f"On {on} the housing does not progress.")] if known else []
    told = [
        f"at {with_units(speeds[n], digits(abs(float(speeds[n]))))} {ways[n]} on "
        f"{letters[int(speeds['attractor_id'][n])]}"
        for n in moving
    ]
    return [Answer(f"The housing progresses {series(told)}.")]


def border_answer(dataset: xr.Dataset) -> Answer:
    """Write where starts at rest lead, and how many starts have a neighbour that settles elsewhere."""
    border = float(dataset["border"].mean())
    index, is_start = at_rest(dataset)
    near = f"{percent(border)} of the starts have a neighbour in the map that settles elsewhere."
    if index is not None:
        where = "From rest it settles on" if is_start else "Starts near rest settle on"
        return Answer(f"{where} {named(dataset, index)}.", near)
    many = "The start must be known well." if border >= MANY else "Few starts lie at a border."
    return Answer(many, near)


def steps_text(dataset: xr.Dataset) -> str:
    """Write how far neighbours in a map are from each other; empty where the steps differ."""
    found = []
    for name in ("x0", "v0"):
        steps = np.diff(np.sort(dataset[name].values))
        if not steps.size:
            continue
        if np.ptp(steps) > 1e-6 * steps.max():
            return ""
        found.append(with_units(dataset[name], format_number(float(steps.max()), 2)))
    return f"Neighbours in the map are {' or '.join(found)} apart. " if found else ""


def knock_answers(dataset: xr.Dataset) -> list[Answer]:
    """Write which motions survive the smallest knock, among those of which it is known, and when they are hit."""
    knocks = {index: knock for index, knock in knocks_of(dataset).items() if not math.isnan(knock)}
    beyond = beyond_map(dataset)
    ended = {index: knock for index, knock in knocks.items() if index not in beyond}
    if not ended:
        return []
    n = dataset.sizes["attractor_id"]
    least, step, letters = min(ended.values()), step_of(dataset), letters_of(dataset)
    # By a map a knock is known to a step of it.
    limit = step if least < step else least + max(step, ALIKE * least)
    lost = sorted(letters[index] for index, knock in ended.items() if knock < limit)
    # Up to the end of the map a motion may survive more than it shows.
    are_known = len(knocks) == n and all(knocks[index] >= limit for index in knocks.keys() - ended)
    who, are = (f"motion {lost[0]}", "is") if len(lost) == 1 else (f"motions {series(lost)}", "are")
    when = knock_when(dataset)
    lead = f"A knock{when} may end {who}."
    if are_known:
        how = "about equally" if len(lost) == n else "most"
        lead = f"Knocked{when}, {who} {are} lost {how} easily."
    if KNOCK in dataset:
        least_text = with_units(dataset[KNOCK], knock_text(least, step, ends=True))
        which = "it" if len(lost) == 1 else "one of them"
        rest = f"Of the impulses tried, the least that ended {which} is {least_text}."
        return [Answer(lead, rest)]
    steps = f"steps of {with_units(dataset['v0'], format_number(step, 3))}"
    if least < step:
        whose = "its" if len(lost) == 1 else "their"
        rest = f"Beside {whose} states, the map ({steps} in velocity) has starts that settle elsewhere."
        return [Answer(lead, rest)]
    knock = with_units(dataset["v0"], knock_text(least, step))
    survive = "it survives" if len(lost) == 1 else "they survive"
    rest = f"By the map, {survive} knocks up to at least {knock} in velocity ({steps})."
    return [Answer(lead, rest)]


def safety_table(scene: str, dataset: xr.Dataset) -> Table | None:
    """Return the table of the attractors of a map: shares, multipliers, hardest impacts, knocks."""
    if not dataset.sizes["attractor_id"]:
        return None
    indices = ordered(dataset)
    rows = [dataset.sel(attractor_id=index) for index in indices]
    columns = {
        "": [*letters_of(dataset).values()],
        "motion": [attractor_words(dataset, index) for index in indices],
    }
    if "housing_velocity_mean" in dataset:
        head = in_brackets("progression", dataset["housing_velocity_mean"])
        columns[head] = [digits(progression_of(row)) for row in rows]
    columns["share of the starts"] = [share_text(row) for row in rows]
    columns["multiplier"] = [
        modulus_text(float(np.abs(row["floquet_multiplier"].values).max())) for row in rows
    ]
    is_soft = "support_force_max" in dataset
    hardest = "support_force_max" if is_soft else "impact_velocity_max"
    head = "largest force" if is_soft else "hardest impact"
    head = in_brackets(head, dataset[hardest]) if hardest in dataset else head
    columns[head] = [largest_text(row, hardest) for row in rows]
    knocks, beyond = knocks_of(dataset), beyond_map(dataset)
    if any(map(math.isfinite, knocks.values())):  # none is known of one motion alone
        step = step_of(dataset)
        head = "least impulse that ends it" if KNOCK in dataset else "knock survived"
        columns[in_brackets(head, dataset[KNOCK if KNOCK in dataset else "v0"])] = [
            "≥\u00a0" * (index in beyond) + knock_text(knocks[index], step, KNOCK in dataset)
            for index in indices
        ]
    if PROVED in dataset:
        head = in_brackets("proved impulse", dataset[PROVED])
        columns[head] = [at_least(float(row[PROVED])) for row in rows]
    note = safety_note(dataset, knocks, beyond)
    if any(DASH in cells for cells in columns.values()):
        note += " A dash: none, or not known."
    title = "How safe each motion is"
    return Table(*head_and_rows(columns), note, left=2, title=title, scene=scene)


def safety_note(dataset: xr.Dataset, knocks: Mapping[int, float], beyond: Collection[int]) -> str:
    """Write what the numbers of a table of attractors are, with `knocks_of` and `beyond_map` of the dataset."""
    note = f"{PROGRESSION}. " * ("housing_velocity_mean" in dataset)
    if "x0" in dataset.dims and dataset.sizes["attractor_id"] > 1:
        note = steps_text(dataset) + note
    note += (
        "Share with its 95 % interval for as many random starts. Multiplier: factor by which a small deviation changes "
        "in a period of the motion, in the long run."
    )
    if any(map(math.isfinite, knocks.values())):
        if KNOCK in dataset:
            note += f" Impulse{knock_when(dataset)}, of those tried, rounded up."
        else:
            note += (
                f" Knock: change of velocity{knock_when(dataset)} within which all starts of the map beside the states "
                "of the motion lead back, rounded down, 0 for less than a step of the map, "
                f"{with_units(dataset['v0'], format_number(step_of(dataset), 3))}."
            )
        if beyond:
            note += " With ≥: to the end of the map."
        if any(len(images_of(dataset, index)) > 1 for index in knocks):
            note += (
                " Mirror images have one knock, the smaller: each is the other half a period later."
            )
    if PROVED in dataset:
        note += (
            " Proved impulse: at the start of a forcing period, below which all motions certainly lead back, rounded "
            "down."
        )
    if REFUSED in dataset.attrs:
        note += f" Nothing was proved: {dataset.attrs[REFUSED]}."
    return note


def share_text(row: xr.Dataset) -> str:
    """Write the share of the starts that settle on a motion, with its interval."""
    low, high = (100 * float(row[f"basin_share_{end}"]) for end in ("low", "high"))
    low_text, high_text = outwards(low, high, 3)
    return f"{percent(float(row['basin_share']))} ({low_text} … {high_text})"


def knock_text(knock: float, step: float, ends: bool = False) -> str:
    """Write a knock to two digits: 0 if it is less than a step of the map, a dash if it is not known.

    One that a motion survives is rounded down, one that `ends` it up.

    >>> knock_text(0.0576, 0.01), knock_text(476.0, 33.0), knock_text(0.009, 0.01)
    ('0.057', '470', '0')
    >>> knock_text(0.0571, 0.01, ends=True)
    '0.058'
    """
    if math.isnan(knock):
        return DASH
    if knock < step or knock == 0.0:
        return "0"
    unit = 10.0 ** (math.floor(math.log10(knock)) - 1)
    units = knock / unit
    units = math.ceil(units * (1 - 1e-12)) if ends else math.floor(units * (1 + 1e-12))
    return format_number(unit * units)


def largest_text(row: xr.Dataset, name: str) -> str:
    """Write the larger of the values of both supports, without unit; a dash without one."""
    values = row[name].values if name in row else np.empty(0)
    known = values[np.isfinite(values)]
    return digits(float(known.max())) if known.size else DASH
