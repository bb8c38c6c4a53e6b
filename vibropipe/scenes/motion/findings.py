"""Answers of motions: their steady states, hardest impacts, mean displacements and exponents."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping

import numpy as np
import xarray as xr

from vibropipe.figures.motion_words import slides_away, stability_text, way_of
from vibropipe.figures.style import ROUNDING
from vibropipe.report.findings import value_text
from vibropipe.report.parts import MAX_ANSWERS, Answer, Answers, Datasets
from vibropipe.scenes.certificate_page import certificate_answer
from vibropipe.scenes.motion.captions import seen_text
from vibropipe.scenes.motion.steady_text import is_steady, orbit_text
from vibropipe.words.quantities import FLAGS
from vibropipe.words.vocabulary import held_name
from vibropipe.words.wording import count, series

SAME = FLAGS["settled_same"]
OF_LAW = ("regime", "period_multiple", "impacts_per_orbit", "rests_per_orbit")


MAX_NAMED = 4  # scenes that a sentence names


def answers(datasets: Datasets) -> Answers:
    """Return the answers on one motion, or on all motions together."""
    if len(datasets) == 1:
        ((name, dataset),) = datasets.items()
        found = [
            ramp_answer(dataset) or motion_answer(dataset),
            progression_answer(dataset),
            certificate_answer(dataset),
            *exponent_answers(datasets),
            hardest_answer(datasets),
        ]
        return {name: [answer for answer in found if answer][:MAX_ANSWERS]}
    found = [
        steady_answer(datasets),
        *ramp_answers(datasets),
        *map(certificate_answer, datasets.values()),
        *exponent_answers(datasets),
        hardest_answer(datasets),
        mean_answer(datasets),
    ]
    return {"": [answer for answer in found if answer][:MAX_ANSWERS]}


def motion_answer(dataset: xr.Dataset) -> Answer | None:
    """Return what one motion does: its steady state, else what its record shows."""
    if not is_steady(dataset):
        text = seen_text(dataset).partition(",")[0].partition(";")[0]
        text = text.replace("Supports 1 and 2", "Both supports")
        return Answer(f"{text} in the record.") if text else None
    if slides_away(dataset):
        return None  # which `progression_answer` says
    tail = []
    text = orbit_text(dataset)
    has_room = len(re.findall(r"\d+ (?:times|forcing)", text)) < 2  # of two numbers in an answer
    if word := stability_text(dataset):
        tail.append(f"The motion is {word}")
    if has_room and (mean := mean_text(dataset)) is not None:
        tail.append(f"{'its' if tail else 'Its'} mean displacement is {mean}")
    return Answer(f"{text}.", f"{series(tail)}." if tail else "")


def progression_answer(dataset: xr.Dataset) -> Answer | None:
    """Return how fast a housing progresses in the steady state, and which way; none where it is fixed or not known."""
    if "housing_velocity_mean" not in dataset or dataset["housing_velocity_mean"].ndim:
        return None
    if slides_away(dataset):
        return Answer(
            "The housing slides away.",
            "The constant forces exceed its friction: it becomes ever faster, and has no progression.",
        )
    mean, most = (dataset[f"housing_velocity_{name}"] for name in ("mean", "max"))
    if not np.isfinite(float(mean)):
        return None
    way = way_of(float(mean), float(most))
    if way is None:
        return Answer("The housing does not progress.")
    return Answer(
        f"The housing progresses {way}.",
        f"Its progression, the mean velocity, is {value_text(mean, mean, 3)}.",
    )


def ramp_headline(dataset: xr.Dataset) -> str:
    """Write whether a ramp ends in the motion that starts from rest, as a sentence without its full stop."""
    same = int(dataset["settled_same"])
    if same == SAME["unknown"]:
        return "The ramp and the start from rest do not both end in an orbit"
    if same == SAME["same"]:
        return "The ramp ends in the motion that starts from rest at the same frequency"
    law = [dataset[f"settled_{name}"].values for name in OF_LAW]
    if all((each[0] == each[1]).all() for each in law):
        return "The ramp ends in another motion than from rest, which strikes as often"
    return "The ramp ends in another motion than the one from rest at the same frequency"


def ramp_answer(dataset: xr.Dataset) -> Answer | None:
    """Return what a ramp ends in, held at its last frequency, beside what starts from rest there."""
    if "settled_same" not in dataset:
        return None
    after, rest = (settled_text(dataset, n) for n in (0, 1))
    end = dataset[held_name(dataset, "nu_end")]
    held = f"Held at {value_text(end, end)} after the ramp, {after}"
    return Answer(
        f"{ramp_headline(dataset)}.",
        f"{held}." if after == rest else f"{held}; from rest there, {rest}.",
    )


def ramp_answers(datasets: Datasets) -> list[Answer]:
    """Return the ramps of several motions that end in another motion than from rest."""
    ramps = {name: data for name, data in datasets.items() if "settled_same" in data}
    if not ramps:
        return []
    other = [name for name, data in ramps.items() if int(data["settled_same"]) == SAME["other"]]
    if not other:
        return [Answer("No ramp is known to end in another motion than the one from rest.")]
    return [Answer(f"A ramp ends in another motion than the one from rest in {names_text(other)}.")]


def settled_text(dataset: xr.Dataset, number: int) -> str:
    """Write what the motion settles on after a ramp (0) or from rest (1), as a clause."""
    one = dataset.isel(settled_from=number)
    names = {f"settled_{name}": name for name in OF_LAW}
    text = orbit_text(one.drop_vars([*OF_LAW, "window_periods"], errors="ignore").rename(names))
    text = text.removeprefix("In the steady state ")
    return text[:1].lower() + text[1:]


def steady_answer(datasets: Datasets) -> Answer | None:
    """Return which steady states the motions have; those that are the same share a clause."""
    steady = {name: data for name, data in datasets.items() if is_steady(data)}
    by_text: dict[str, list[str]] = {}
    for name, data in steady.items():
        by_text.setdefault(orbit_text(data), []).append(name)
    if not by_text:
        return None
    (text, first), *others = sorted(by_text.items(), key=lambda item: -len(item[1]))
    if others:
        rest = f"{text}: {names_text(first)}; others stand in the table."
        known = {orbit_text(data) for data in steady.values() if int(data["period_multiple"]) > 0}
        differ = "The motions have different steady states."
        return Answer(differ if len(known) > 1 else "Not all motions have one steady state.", rest)
    if len(steady) < len(datasets):
        return Answer(f"{text}.", f"It was computed for {names_text(steady)}.")
    words = {stability_text(data) for data in steady.values()}
    word = words.pop() if len(words) == 1 else ""
    return Answer(f"{text}.", f"All motions are {word}." if word else "")


def hardest_answer(datasets: Datasets) -> Answer | None:
    """Return the largest impact velocity of the motions, and on which support it is."""
    tops = {
        name: int(np.abs(data["impact_velocity"].values).argmax())
        for name, data in datasets.items()
        if data.sizes.get("impact") and "impact_velocity" in data and "impact_support" in data
    }
    sizes = {n: abs(float(datasets[n]["impact_velocity"][index])) for n, index in tops.items()}
    if not sizes or max(sizes.values()) == 0.0:
        is_stored = len(datasets) > 1 and all("impact_support" in d for d in datasets.values())
        return Answer("No support is struck.") if is_stored else None
    name = max(sizes, key=lambda key: sizes[key])
    data = datasets[name]
    top = value_text(data["impact_velocity"], sizes[name])
    alike = [each for each, size in sizes.items() if size >= (1 - 1e-6) * sizes[name]]
    where = f" in {motion_text(name)}" if len(datasets) > 1 else ""
    if len(alike) > 1:
        lead = f"The hardest impacts recorded have the velocity {top}."
        return Answer(lead, f"They are in {names_text(alike)}.")
    on = f"on support {int(data['impact_support'][tops[name]])}"
    speeds = np.abs(data["impact_velocity"].values)
    both = {int(s) for s in data["impact_support"].values[speeds >= (1 - 1e-6) * sizes[name]]}
    on = "on both supports" if len(both) == 2 else on
    return Answer(f"The hardest impact recorded is {on}{where}.", f"Its velocity is {top}.")


def mean_answer(datasets: Datasets) -> Answer | None:
    """Return the largest mean displacement of the steady states."""
    texts = {name: text for name, data in datasets.items() if (text := mean_text(data)) is not None}
    if not texts:
        return None
    mean = of_computed("mean displacement", texts, datasets)
    if set(texts.values()) == {ZERO}:
        return Answer(f"{mean} is zero.")
    sizes = {key: abs(float(datasets[key]["displacement_mean"])) for key in texts}
    name = max(sizes, key=lambda key: sizes[key])
    alike = [key for key, size in sizes.items() if size >= (1 - 1e-6) * sizes[name]]
    if len(alike) > 1:
        return Answer(f"{mean} is largest in size in {names_text(alike)}.")
    lead = f"{mean} is largest in size in {motion_text(name)}."
    if len(texts) == 1:
        lead = f"The mean displacement is not zero in {motion_text(name)}."
    return Answer(lead, f"It is {texts[name]}.")


def of_computed(quantity: str, known: Collection[str], datasets: Datasets) -> str:
    """Write a quantity as the subject of a sentence on all motions that have it: of the others nothing is known."""
    return f"The {quantity}" if len(known) == len(datasets) else f"Where computed, the {quantity}"


ZERO = "zero"


def mean_text(dataset: xr.Dataset) -> str | None:
    """Write the mean displacement of a steady state; None if it is not known."""
    if "displacement_mean" not in dataset or not np.isfinite(float(dataset["displacement_mean"])):
        return None
    mean = dataset["displacement_mean"]
    if abs(float(mean)) <= ROUNDING * float(np.nanmax(np.abs(dataset["displacement_amplitude"]))):
        return ZERO
    return value_text(mean, mean, 3)


def exponent_answers(datasets: Datasets) -> list[Answer]:
    """Return the largest Lyapunov exponent of those that were asked for, with its error; all stand in the table."""
    known = {
        name: data["lyapunov_exponent"]
        for name, data in datasets.items()
        if "lyapunov_exponent" in data and not data["lyapunov_exponent"].ndim
    }
    if not known:
        return []
    finite = {name: value for name, value in known.items() if np.isfinite(float(value))}
    if not finite:
        return [Answer("The Lyapunov exponent is not known.")]
    name = max(finite, key=lambda key: float(finite[key]))
    value, error = finite[name], datasets[name]["lyapunov_exponent_error"]
    tail = f", with an error of {value_text(error, error, 2)}" if float(error) > 0.0 else ""
    size = f"is {value_text(value, value, 3)}{tail}"
    if len(known) == 1:
        where = f" of {motion_text(name)}" if len(datasets) > 1 else ""
        return [Answer(f"The Lyapunov exponent{where} {size}.")]
    exponent = of_computed("Lyapunov exponent", finite, datasets)
    errors = {key: float(datasets[key]["lyapunov_exponent_error"].fillna(0.0)) for key in finite}
    below = {key: float(value - each) - errors[key] - errors[name] for key, each in finite.items()}
    alike = [key for key, distance in below.items() if distance <= 1e-6 * abs(float(value))]
    if len(alike) > 1:  # within their errors, and rounding
        rest = f"In {motion_text(name)} it {size}."
        return [Answer(f"{exponent} is largest in {names_text(alike)}.", rest)]
    return [Answer(f"{exponent} is largest in {motion_text(name)}.", f"It {size}.")]


def names_text(names: Iterable[str] | Mapping[str, object]) -> str:
    """Write labels of scenes; beyond MAX_NAMED, their number."""
    listed = list(names)
    if len(listed) > MAX_NAMED:
        return count(len(listed), "motion")
    return series(quoted(name) for name in listed)


def motion_text(name: str) -> str:
    """Write the label of a motion in a sentence: the motion “soft”."""
    return name if quoted(name) == name else f"the motion {quoted(name)}"


def quoted(name: str) -> str:
    """Write a label in quotation marks, unless it has an article."""
    return name if name.startswith("the ") else f"“{name}”"
