"""Part of the report on designs: whether they can be made, their numbers, and how far parameters may be off."""

from __future__ import annotations

import numpy as np
import xarray as xr

from vibropipe.figures.claims import at_least
from vibropipe.figures.text import (
    format_number,
    in_brackets,
    is_forced,
    measured,
    parameter_names,
    plain_symbol_of,
    with_units,
)
from vibropipe.report.parts import (
    DASH,
    MAX_ANSWERS,
    MAX_ROWS,
    Answer,
    Datasets,
    Row,
    Side,
    Table,
    of_each,
    tables_of_each,
    told_once,
)
from vibropipe.scenes.certificate import proof_of
from vibropipe.scenes.certificate_page import bounds_of, bounds_table, certificate_answer, is_proved
from vibropipe.scenes.design.data import (
    Part,
    ends_of,
    from_rest_texts,
    goals,
    has_spread,
    has_yield,
    is_front,
    is_met,
    numbers,
    objectives,
    off_allowed,
    part_of,
    start_words,
    struck_texts,
    varied,
    wanted_parts,
)
from vibropipe.scenes.design.nominal import nominal, nominal_numbers, nominal_text, tolerance_of
from vibropipe.scenes.design.ranking import (
    MOST_PARAMETERS,
    NEAREST,
    NONE_FOUND,
    away_text,
    least_miss,
    shown_parts,
)
from vibropipe.scenes.design.spread import leading
from vibropipe.scenes.design.workshop import (
    limit_cells,
    lost_answer,
    makeable,
    nearest_limit_text,
    sorting_table,
    tolerances_table,
)
from vibropipe.scenes.kind import ReportPart
from vibropipe.words.designs import DesignResult
from vibropipe.words.wording import series

MOST_QUANTITIES = 3  # of a table
NEAR = 0.01  # of the ranges: a change of the law that few workshops keep away from
AT_END = 1e-6  # of a range: as near to its end counts as there
USUAL_MM, USUAL_HZ = 8.0, 9.0  # an exciter in whose units a design is shown
LENGTH_DIGITS = 4
STRUCK = "impacts in a period, at 1 + 2"


def designs_table(scene: str, dataset: xr.Dataset) -> Table | None:
    """Return the designs of a scene, one per row; None of one alone or of more than a table has room for."""
    if not 1 < dataset.sizes["design"] <= MAX_ROWS:
        return None
    names = varied(dataset)
    parts = shown_parts(dataset)[:MOST_QUANTITIES]
    head = [
        "design",
        *(in_brackets(plain_symbol_of(dataset[name]), dataset[name]) for name in names),
    ]
    limits = ["nearest limit", "away"] * has_yield(dataset)
    head += [*(part.label_text(dataset) for part in parts), *limits, "margin (%)", STRUCK]
    struck, columns = struck_texts(dataset), [nominal_numbers(dataset, name) for name in names]
    rows = [
        [
            str(number),
            *(column[row] for column in columns),
            *(measured(float(part.of(dataset).values[row])) for part in parts),
            *limit_cells(dataset, row),
            margin_text(dataset, row),
            struck[row],
        ]
        for row, number in enumerate(numbers(dataset))
    ]
    note = (
        "Margin: distance to the nearest change of the law of motion that was found, in shares of the ranges, rounded "
        "down."
    )
    if not (dataset["law_margin"] < NONE_FOUND).all():
        note += " A dash: none was found within the widths of the ranges."
    if limits:
        note = f"Away: from the nearest limit of a goal, in standard deviations of its quantity, to first order. {note}"
    widths = ("auto",) * (1 + len(names)) + ("1fr",) * len(parts) + ("1fr", "auto")[: len(limits)]
    widths += ("1.5cm", "2.4cm")
    if texts := from_rest_texts(dataset):
        head, widths = [*head, "from rest"], (*widths, "1.2cm")
        rows = [[*row, text] for row, text in zip(rows, texts, strict=True)]
        note += " From rest: whether the mass settles on this motion if it starts at rest."
    repeated = [*head[1 : 1 + len(names[:MOST_PARAMETERS])], STRUCK], "designs"
    title = "The designs in numbers"
    table = Table(head, rows, note, widths, title=title, scene=scene, repeated=repeated)
    return told_once(table, "all designs")


def units_table(scene: str, dataset: xr.Dataset) -> Table | None:
    """Return design 1 in units for an exciter of usual size; None if the study has units, no force or a front."""
    has_units = "C" in dataset.coords or not is_forced(dataset)
    if has_units or is_front(dataset) or not is_met(dataset)[0]:
        return None
    size = USUAL_MM / nominal(dataset, "l", 0)
    speed = 1e-3 * size * 2 * np.pi * USUAL_HZ / nominal(dataset, "nu", 0)
    velocities = dataset["impact_velocity_max"].isel(design=0).transpose("support").values
    struck = [(n + 1, speed * v) for n, v in enumerate(velocities) if np.isfinite(v)]
    head = ["", "half distance l (mm)", "offset δ (mm)"]
    head += [f"struck at support {n} (m/s)" for n, _ in struck]
    lengths = np.array([size * nominal(dataset, name, 0) for name in ("l", "delta")])
    shown = [measured(length, LENGTH_DIGITS) for length in lengths]
    rows = [["value", *shown, *(measured(v) for _, v in struck)]]
    rounding = [abs(v - float(f"{v:.{LENGTH_DIGITS}g}")) for v in lengths]
    off = size * np.array([tolerance_of(dataset, name, 0) for name in ("l", "delta")]) - rounding
    if (off > 0.0).all():
        rows.append(["may be off by", *(f"± {at_least(w, 2)}" for w in off), *[DASH] * len(struck)])
    note = (
        f"Lengths times {format_number(size, 4)} mm, velocities times {format_number(speed, 4)} m/s. A study with the "
        "key `physical` is solved and reported in its own units."
    )
    title = f"Design 1 in units, for an exciter of l = {USUAL_MM:g} mm at {USUAL_HZ:g} Hz"
    return Table(head, rows, note, title=title, scene=scene)


def margin_text(dataset: xr.Dataset, row: int) -> str:
    """Write the margin of a design in per cent."""
    margin = float(dataset["law_margin"].values[row])
    if not margin < NONE_FOUND:
        return DASH
    return at_least(100 * margin, 2) if margin >= NEAREST else f"< {100 * NEAREST:g}"


def answers_of_scene(dataset: xr.Dataset) -> list[Answer]:
    """Return the answers of one scene."""
    if not is_met(dataset).any():
        return [missed(dataset)]
    if is_front(dataset):
        return answers_of_front(dataset)
    return with_rest(dataset, answers_of_designs(dataset))


def with_rest(dataset: xr.Dataset, found: list[Answer]) -> list[Answer]:
    """Return answers with whether the first motion settles from rest, in an answer of its own if it does not."""
    first, *others = found
    row = int(np.argmax(is_met(dataset)))
    which = f"design {row + 1}" if dataset.sizes["design"] > 1 else "the design"
    text = (from_rest_texts(dataset) or [""] * (row + 1))[row]
    if text == "yes":
        rest = f"{first.rest} The mass settles on this motion from rest.".strip()
        return [Answer(first.lead, rest), *others]
    if text == "no":
        start = start_words(dataset)
        rest = f"Start it at {start}, at the zero phase of the force." if start else ""
        another = Answer(f"From rest, {which} settles on another motion.", rest)
        return [first, another, *others][:MAX_ANSWERS]
    return found


def answers_of_designs(dataset: xr.Dataset) -> list[Answer]:
    """Return the answers of designs that are no front: the best of them, how many can be made, and what is proved."""
    found = [best_design(dataset)]
    if has_yield(dataset):
        found.append(makeable(dataset))
    elif (amount := int(is_met(dataset).sum())) > 1:
        found.append(Answer(f"{amount} designs keep all that is wanted."))
    if (told := certificate(dataset)) is not None:
        found.append(told)
    if lost := lost_answer(dataset):
        found.append(Answer(lost))
    elif limit := nearest_limit_text(dataset):
        found.append(Answer(limit))
    if has_spread(dataset) and (texts := leading(dataset)):
        found.append(Answer(f"Most of the spread of {texts[0]}."))
    return found[:MAX_ANSWERS]


def best_design(dataset: xr.Dataset) -> Answer:
    """Return the free parameters of the first design that keeps all that is wanted, and what it reaches."""
    row = int(np.argmax(is_met(dataset)))
    which = f"Design {row + 1}" if dataset.sizes["design"] > 1 else "The design found"
    values = series(
        f"{plain_symbol_of(dataset[name])} = {nominal_text(dataset, name, row)}"
        for name in varied(dataset)
    )
    words = {part: part.words(dataset) for part in chief_parts(dataset)} | {Part("yield"): "yield"}
    reached = [f"{words[p]} = {p.value_text(dataset, row)}" for p in chief_parts(dataset)]
    margin = float(dataset["law_margin"].values[row])
    near = f" Another law of motion begins {away_text(margin)} away." if margin < NEAR else ""
    return Answer(f"{which} has {values}.", f"It reaches {series(reached)}.{near}")


def chief_parts(dataset: xr.Dataset) -> list[Part]:
    """Return at most two wanted quantities: what is least, else a target and a bound."""
    parts = wanted_parts(dataset)
    sought = [part_of(dataset, name.removeprefix("-")) for name in objectives(dataset)]
    least = [part for part in sought if part is not None]
    targets = [part for part in parts if np.isfinite(part.end(dataset, "target"))]
    bounded = [part for part in parts if part not in (*targets, *least)]
    return [*least, *targets[:1], *bounded, *targets[1:]][:2]


def certificate(dataset: xr.Dataset) -> Answer | None:
    """Return what is proved of design 1, and of its goals for all these exciters; None if that is not asked."""
    told, proof = certificate_answer(dataset), proof_of(dataset)
    if told is None or proof is None or not is_proved(proof):
        return told
    kept: dict[bool, list[str]] = {True: [], False: []}
    for part in wanted_parts(dataset):
        bounds = bounds_of(proof, part.variable, part.label)
        if bounds is None:
            continue
        target, off = part.end(dataset, "target"), off_allowed(dataset, part)
        ends = [part.end(dataset, "lower"), part.end(dataset, "upper")]
        if np.isfinite(target) and off > 0:
            ends = [np.fmax(ends[0], target - off), np.fmin(ends[1], target + off)]
        if np.isfinite(ends).any():
            is_kept = not (bounds[0] < ends[0] or bounds[1] > ends[1])
            kept[is_kept].append(part.words(dataset))
    texts = [f"All of them keep what is wanted of the {series(kept[True])}."] if kept[True] else []
    if kept[False]:
        texts.append(f"It is not proved that all keep what is wanted of the {series(kept[False])}.")
    return Answer(told.lead, " ".join([told.rest, *texts]))


def missed(dataset: xr.Dataset) -> Answer:
    """Return by how much the design misses that misses least, and why."""
    nearest = least_miss(dataset)
    miss = format_number(float(dataset["design_miss"].values[nearest]), 2)
    reason = DesignResult(int(dataset["design_result"].values[nearest])).reason
    which = "The one found misses"
    if dataset.sizes["design"] > 1:
        which = f"Of those found, design {nearest + 1} misses least,"
    rest = f"{which} by {miss} times what is wanted, or l where that is 0: {reason}."
    return Answer("No design was found that keeps all that is wanted.", rest)


def answers_of_front(dataset: xr.Dataset) -> list[Answer]:
    """Return what a front says: between which values its ends lie."""
    found = [makeable(dataset)] if has_yield(dataset) else []
    texts = [
        f"the {part.words(dataset)} goes from {part.value_text(dataset, 0)} to {part.value_text(dataset, -1)}"
        for part, _ in ends_of(dataset)
    ]
    found.append(Answer(f"Along the front {series(texts)}."))
    rests = from_rest_texts(dataset)
    if "no" in rests:
        from_rest = f"{rests.count('yes')} of {len(rests)} designs"
        found.append(Answer(f"From rest, the mass settles on {from_rest}."))
    return [*found, *answers_at_ends(dataset)][:MAX_ANSWERS]


def answers_at_ends(dataset: xr.Dataset) -> list[Answer]:
    """Return that most designs lie at an end of a range, which wider ranges would move; nothing if they do not."""
    at: dict[str, np.ndarray] = {}
    for name in (each for each in varied(dataset) if f"{each}_lower" in dataset):
        low, high = (float(dataset[f"{name}_{end}"]) for end in ("lower", "upper"))
        for end in (low, high):
            near = np.abs(dataset[name].values - end) <= AT_END * (high - low)
            text = with_units(dataset[name], format_number(end))
            at[f"{plain_symbol_of(dataset[name])} = {text}"] = near
    n_designs, n_at = dataset.sizes["design"], int(np.any([*at.values()], axis=0).sum())
    if 2 * n_at <= n_designs:
        return []
    place, near = max(at.items(), key=lambda item: item[1].sum())
    who = "Each design" if n_at == n_designs else "Most designs"
    lead = f"{who} of the front {'lies' if n_at == n_designs else 'lie'} at an end of a range."
    return [Answer(lead, f"{near.sum()} of them at {place}.")]


def side(datasets: Datasets) -> Side:
    """Return what is wanted, given and free in the first scene, whose designs are drawn on the page."""
    dataset = next(iter(datasets.values()))
    rows = [Row("Goals"), *(Row(goal.words, goal.text) for goal in goals(dataset)), Row("Given")]
    free = varied(dataset)
    rows += [
        Row(plain_symbol_of(dataset[name]), nominal_text(dataset, name))
        for name in parameter_names(dataset)
        if name not in free and dataset[name].ndim == 0
    ]
    rows.append(Row("Free"))
    return Side([*rows, *ranges(dataset, free)], has_drawing=False)


def ranges(dataset: xr.Dataset, free: list[str]) -> list[Row]:
    """Return the ranges of varied parameters; equal ones share a row."""
    texts: dict[str, list[str]] = {}
    for name in free:
        if f"{name}_lower" in dataset:
            ends = (float(dataset[f"{name}_{end}"]) for end in ("lower", "upper"))
            text = with_units(dataset[name], " … ".join(format_number(end) for end in ends))
            texts.setdefault(text, []).append(plain_symbol_of(dataset[name]))
    return [Row(", ".join(symbols), text) for text, symbols in texts.items()]


answers = of_each(answers_of_scene)
tables = tables_of_each(designs_table, tolerances_table, units_table, sorting_table, bounds_table)
REPORT = ReportPart(
    "Designs",
    "Which parameters give the wanted motion, and how far may they be off?",
    answers,
    tables,
    side=side,
)
