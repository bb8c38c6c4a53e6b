"""Part of the report on identifications: how good the fit is, the parameters found, and which are not determined."""

from __future__ import annotations

import numpy as np
import xarray as xr

from vibropipe.figures.claims import at_most
from vibropipe.figures.text import format_number, parameter_names, plain_symbol_of, with_units
from vibropipe.report.parts import DASH, Answer, Datasets, Row, Side, Table, of_each, tables_of_each
from vibropipe.scenes.identify.pictures import (
    Column,
    columns,
    noise_text,
    results,
    sensor_texts,
    twin_texts,
    value_text,
    with_deviation,
)
from vibropipe.scenes.kind import ReportPart
from vibropipe.words.designs import FitResult, FoundResult
from vibropipe.words.wording import part_text, series

# Correlation above which two parameters are told apart badly.
ALIKE = 0.95
# Parameters whose correlations a table has room for, and scenes beside the exciter.
MOST_CORRELATIONS, MOST_SCENES = 4, 3
# A parameter belongs to a direction that is not determined by at least this part of it.
PART = 0.1
STATES = {
    FoundResult.DETERMINED: "determined",
    FoundResult.AT_RANGE: "ended at its range",
    FoundResult.UNDETERMINED: "not determined",
}


def answers_of_scene(dataset: xr.Dataset) -> list[Answer]:
    """Return the answers of one scene."""
    found = [verdict(dataset)]
    if twins := twin_texts(dataset):
        found.append(Answer(f"{twins[0]}.", " ".join(f"{text}." for text in twins[1:])))
    if blind := undetermined_texts(dataset):
        found.append(Answer(blind[0], " ".join(blind[1:])))
    ended = [
        plain_symbol_of(dataset[name])
        for name, result in results(dataset).items()
        if result == FoundResult.AT_RANGE
    ]
    if ended:
        whose = "its range: widen it" if len(ended) == 1 else "their ranges: widen them"
        lead = f"{series(ended)} ended at {whose}, unless nothing beyond is possible."
        found.append(Answer(lead))
    if int(dataset["fit_result"]) == FitResult.EXPLAINED:
        found += [Answer(f"{pair} are told apart badly.") for pair in alike(dataset)[:1]]
        found += [Answer(text) for text in least_and_best_known(dataset)]
    return found[:3]


def verdict(dataset: xr.Dataset) -> Answer:
    """Return whether the measurements are explained, in words and numbers."""
    result = FitResult(int(dataset["fit_result"]))
    if result == FitResult.EXPLAINED:
        lead = "The measurements are explained within their noise."
        return Answer(lead, fit_text(dataset))
    lead = "The measurements are not explained."
    if result == FitResult.BEYOND_NOISE:
        lead = "No parameters were found that explain the measurements."
        samples = int(dataset.attrs.get("samples", 0))
        more = f" Searched from {samples:,} samples: more may find others." if samples else ""
        return Answer(lead, f"{fit_text(dataset)}{more}")
    if result == FitResult.CONSTANT:
        return Answer(lead, constant_text(dataset))
    if result == FitResult.ABSENT:
        lost = max(columns(dataset), key=missing)
        rest = f"The nearest motion has no {lost.words} at {part_text(missing(lost), lost.fitted.size, 'measurement')}."
        return Answer(lead, rest)
    return Answer(
        "Whether the measurements are explained is not known.",
        "There are too few of them for more than a rough estimate of their noise: give it.",
    )


def missing(part: Column) -> int:
    """Return at how many measurements the nearest motion has no such quantity."""
    return int((~np.isfinite(part.fitted.values)).sum())


def least_and_best_known(dataset: xr.Dataset) -> list[str]:
    """Write the parameters that are known least and best, by their standard deviations over their ranges."""
    shares = {
        name: float(dataset[f"{name}_std"])
        / float(dataset[f"{name}_upper"] - dataset[f"{name}_lower"])
        for name, result in results(dataset).items()
        if result == FoundResult.DETERMINED
        and f"{name}_upper" in dataset
        and not has_other_values(dataset, name)
    }
    order = sorted(shares, key=lambda name: -shares[name])
    if len(order) == 1:
        return [f"{symbol_with_deviation(dataset, order[0])}."]
    words = {order[0]: "least", order[-1]: "best"} if order else {}
    if len(order) < dataset.sizes["parameter"]:
        # Another one is known less, or not at all.
        words = {order[-1]: "best"} if order else {}
    return [
        f"{symbol_with_deviation(dataset, name)} is known {word}, relative to its range."
        for name, word in words.items()
    ]


def symbol_with_deviation(dataset: xr.Dataset, name: str) -> str:
    """Write a parameter that was found with its symbol and standard deviation."""
    return f"{plain_symbol_of(dataset[name])} = {with_deviation(dataset, name)}"


def fit_text(dataset: xr.Dataset) -> str:
    """Write the misfit over the noise, and how large noise alone makes it."""
    chi, limit = (float(dataset[f"reduced_chi_square{end}"]) for end in ("", "_limit"))
    noise = "given" if dataset.attrs.get("noise") == "given" else "estimated"
    # With as many digits as tell on which side of the limit it is.
    digits = next((n for n in range(3, 9) if f"{chi:.{n}g}" != f"{limit:.{n}g}"), 9)
    text = (
        f"Chi-square per degree of freedom is {format_number(chi, digits)} with the {noise} noise"
    )
    if not np.isfinite(limit):
        return f"{text}, from too few measurements to judge it."
    most = format_number(limit, digits)
    return f"{text}; noise alone exceeds {most} in one case of a thousand."


def constant_text(dataset: xr.Dataset) -> str:
    """Write which measured values are all the same, or that they are no more than noise."""
    same = [
        part.words
        for part in columns(dataset)
        if np.ptp(part.measured.values[np.isfinite(part.measured)]) == 0
    ]
    if same:
        return f"All values of the {series(same)} are equal, as of a dead sensor."
    if dataset.attrs.get("noise") == "given":
        return "The measured values are no larger than their noise, as of a dead sensor."
    return "The measured values vary by no more than the noise that is estimated from the misfits."


def undetermined_texts(dataset: xr.Dataset) -> list[str]:
    """Write which parameters, or combinations of them, the measurements do not determine."""
    found = results(dataset)
    texts, told = [], set()
    for direction in (
        dataset["singular_vector"].transpose("direction_of_fit", "parameter").values[::-1]
    ):
        which = [n for n, part in zip(found, np.abs(direction), strict=True) if part > PART]
        left = [n for n in which if found[n] == FoundResult.UNDETERMINED and n not in told]
        if not left:
            continue
        told |= {*left}
        symbols = series(plain_symbol_of(dataset[name]) for name in which)
        if len(which) == 1:
            texts.append(f"The measurements do not determine {symbols}.")
        else:
            texts.append(f"The measurements do not determine {symbols} apart from each other.")
    return texts


def correlation(dataset: xr.Dataset) -> np.ndarray:
    """Return the correlation of the parameters found; NaN of those without a finite deviation."""
    covariance = dataset["parameter_covariance"].values
    with np.errstate(invalid="ignore", divide="ignore"):
        sigma = np.sqrt(np.diag(covariance))
        sigma = np.where(np.isfinite(sigma) & (sigma > 0), sigma, np.nan)
        return np.asarray(covariance / sigma / sigma[:, None])


def correlation_text(value: float) -> str:
    """Write a correlation with two decimals; none of −0.00.

    >>> correlation_text(-0.004), correlation_text(-0.826)
    ('0.00', '−0.83')
    """
    return f"{round(value, 2) + 0.0:.2f}".replace("-", "−")


def alike(dataset: xr.Dataset) -> list[str]:
    """Write the pairs of parameters that are told apart badly."""
    names, close = dataset["parameter"].values, np.abs(correlation(dataset)) > ALIKE
    return [
        f"{plain_symbol_of(dataset[str(names[i])])} and {plain_symbol_of(dataset[str(names[j])])}"
        for i, j in np.argwhere(np.triu(close, 1))
    ]


def found_table(scene: str, dataset: xr.Dataset) -> Table:
    """Return the parameters of a scene, with ranges and, where the fit explains, deviations and correlations."""
    found = results(dataset)
    is_found = int(dataset["fit_result"]) == FitResult.EXPLAINED
    shown = [*found] if is_found and 1 < len(found) <= MOST_CORRELATIONS else []
    head = ["parameter", "found", "standard deviation", "range", "by the measurements"]
    head += [f"with {plain_symbol_of(dataset[name])}" for name in shown]
    rows = []
    for (name, result), shares in zip(found.items(), correlation(dataset), strict=True):
        cells = [plain_symbol_of(dataset[name]), value_text(dataset, name)]
        deviation = with_units(dataset[name], at_most(float(dataset[f"{name}_std"]), 2))
        is_told = is_found or result != FoundResult.DETERMINED
        cells.append(deviation if is_found else DASH)
        cells += [range_text(dataset, name), state_text(dataset, name) if is_told else DASH]
        texts = [DASH if np.isnan(value) else correlation_text(value) for value in shares]
        rows.append([*cells, *(texts if shown else [])])
    title = "The parameters found" if is_found else "The parameters nearest to what was measured"
    return Table(head, rows, note_text(dataset, bool(shown)), title=title, scene=scene)


def state_text(dataset: xr.Dataset, name: str) -> str:
    """Write whether the measurements determine a parameter, or leave several values of it."""
    result = results(dataset)[name]
    text = STATES[result]
    return f"{text} up to twins" if has_other_values(dataset, name) else text


def has_other_values(dataset: xr.Dataset, name: str) -> bool:
    """Return whether a parameter that is determined has another value where others fit as well, beyond its error."""
    if "twin" not in dataset.dims or results(dataset)[name] != FoundResult.DETERMINED:
        return False
    change = np.abs(dataset[f"{name}_twin"].values - float(dataset[name]))
    return bool((change > 2.0 * float(dataset[f"{name}_std"])).any())


def range_text(dataset: xr.Dataset, name: str) -> str:
    """Write the range in which a parameter was sought."""
    if f"{name}_lower" not in dataset:
        return DASH
    ends = (format_number(float(dataset[f"{name}_{end}"])) for end in ("lower", "upper"))
    return with_units(dataset[name], " … ".join(ends))


def note_text(dataset: xr.Dataset, has_correlations: bool) -> str:
    """Write number and noise of the measurements, and what deviations and correlations stand for."""
    number, quantities = dataset.sizes["measurement"], len(columns(dataset))
    of = "" if quantities == 1 else f" of {quantities} quantities"
    text = f"{number:,} measurements{of}, {noise_text(dataset)}."
    text += "".join(f" {sentence}." for sentence in sensor_texts(dataset))
    if has_correlations:
        first = plain_symbol_of(dataset[str(dataset["parameter"].values[0])])
        text += f" Under “with {first}”: correlation with it."
    if int(dataset["fit_result"]) != FitResult.EXPLAINED:
        return text + " Without deviations, since the misfit is not shown to be noise."
    pairs = alike(dataset)
    return text + (f" Told apart badly: {series(pairs)}." if pairs else "")


def side(datasets: Datasets) -> Side:
    """Return what was found in each of the first scenes, and what is given in all of them, below the exciter."""
    rows = []
    for label, dataset in list(datasets.items())[:MOST_SCENES]:
        is_found = int(dataset["fit_result"]) == FitResult.EXPLAINED
        head = "Found" if is_found else "Nearest"
        rows.append(Row(f"{head}: {label}" if len(datasets) > 1 else head))
        for name, result in results(dataset).items():
            if result == FoundResult.UNDETERMINED:
                rows.append(Row(plain_symbol_of(dataset[name]), "not determined"))
                continue
            is_known = is_found and result == FoundResult.DETERMINED
            text = (with_deviation if is_known else value_text)(dataset, name)
            rows.append(Row(plain_symbol_of(dataset[name]), text))
    first = next(iter(datasets.values()))
    given = [
        Row(plain_symbol_of(first[n]), with_units(first[n], format_number(float(first[n]))))
        for n in parameter_names(first)
        if all(is_given(each, n, float(first[n].values.flat[0])) for each in datasets.values())
    ]
    return Side([*rows, *([Row("Given"), *given] if given else [])])


def is_given(dataset: xr.Dataset, name: str, value: float) -> bool:
    """Return whether a parameter has a value for all measurements, and is not one that was found."""
    is_same = name in dataset.variables and dataset[name].ndim == 0 and dataset[name] == value
    return bool(is_same) and name not in dataset["parameter"].values


answers, tables = of_each(answers_of_scene), tables_of_each(found_table)
REPORT = ReportPart(
    "Identification",
    "Which parameters explain what was measured, and how well are they known?",
    answers,
    tables,
    side=side,
)
