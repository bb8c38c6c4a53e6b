"""Part of the report on identifications: how good the fit is, the parameters found, and which are not determined."""

from __future__ import annotations

import numpy as np
import xarray as xr

from vibropipe.figures.claims import at_most
from vibropipe.figures.text import format_number, plain_symbol, with_units
from vibropipe.report.parts import Answer, Answers
from vibropipe.report.table import DASH, Datasets, Table
from vibropipe.scenes.identify.pictures import columns, found_text, results
from vibropipe.scenes.kind import ReportPart
from vibropipe.words.designs import FitResult, FoundResult
from vibropipe.words.wording import series

# Correlation above which two parameters are told apart badly.
ALIKE = 0.95
# A parameter belongs to a direction that is not determined by at least this part of it.
PART = 0.1
STATES = {
    FoundResult.DETERMINED: "determined",
    FoundResult.AT_RANGE: "ended at its range",
    FoundResult.UNDETERMINED: "not determined",
}


def tables(datasets: Datasets) -> list[Table]:
    """Return a table of the parameters of each scene."""
    return [found_table(name, dataset) for name, dataset in datasets.items()]


def answers(datasets: Datasets) -> Answers:
    """Return what page 1 says: whether the measurements are explained, and which parameters they do not determine."""
    return {name: answers_of_scene(dataset) for name, dataset in datasets.items()}


def answers_of_scene(dataset: xr.Dataset) -> list[Answer]:
    """Return the answers of one scene."""
    found = [verdict(dataset)]
    if blind := undetermined_texts(dataset):
        found.append(Answer(blind[0], " ".join(blind[1:])))
    ended = [
        plain_symbol(str(name))
        for name, result in zip(dataset["parameter"].values, results(dataset), strict=True)
        if result == FoundResult.AT_RANGE
    ]
    if ended:
        whose = "its range: widen it" if len(ended) == 1 else "their ranges: widen them"
        found.append(
            Answer(f"{series(ended)} ended at {whose}, unless nothing beyond is possible.")
        )
    return found


def verdict(dataset: xr.Dataset) -> Answer:
    """Return whether the measurements are explained, in words and numbers."""
    result = FitResult(int(dataset["fit_result"]))
    nearest = f"Nearest are {'; '.join(found_text(dataset, with_deviation=False))}."
    if result == FitResult.EXPLAINED:
        return Answer(
            f"The measurements are explained within their noise by {'; '.join(found_text(dataset))}.",
            fit_text(dataset),
        )
    lead = "The measurements are not explained."
    if result == FitResult.BEYOND_NOISE:
        return Answer(lead, f"{fit_text(dataset)} {nearest}")
    if result == FitResult.CONSTANT:
        return Answer(lead, f"{constant_text(dataset)} {nearest}")
    if result == FitResult.ABSENT:
        lost = [
            f"{part.name} at {int((~np.isfinite(part.fitted.values)).sum())} of {part.fitted.size} measurements"
            for part in columns(dataset)
            if not np.isfinite(part.fitted.values).all()
        ]
        return Answer(lead, f"The nearest motion has no {series(lost)}. {nearest}")
    return Answer(
        "Whether the measurements are explained is not known.",
        f"There are too few of them to estimate their noise: give it. {nearest}",
    )


def fit_text(dataset: xr.Dataset) -> str:
    """Write the misfit over the noise, and how large noise alone makes it."""
    chi, limit = (float(dataset[f"reduced_chi_square{end}"]) for end in ("", "_limit"))
    noise = "given" if dataset.attrs.get("noise") == "given" else "estimated"
    text = f"Chi-square per degree of freedom is {at_most(chi)} with the {noise} noise"
    if not np.isfinite(limit):
        return f"{text}, from too few measurements to judge it."
    return f"{text}; noise alone gives at most {at_most(limit)} in 999 of 1000 cases."


def constant_text(dataset: xr.Dataset) -> str:
    """Write which measured values are all the same, or that they are no larger than the noise."""
    same = [
        part.name
        for part in columns(dataset)
        if np.ptp(part.measured.values[np.isfinite(part.measured)]) == 0
    ]
    if same:
        return f"All values of {series(same)} are equal, as of a dead sensor."
    return "The measured values are no larger than their noise, as of a dead sensor."


def undetermined_texts(dataset: xr.Dataset) -> list[str]:
    """Write which parameters, or combinations of them, the measurements do not determine."""
    names = [str(name) for name in dataset["parameter"].values]
    open_names = [
        name for name, result in zip(names, results(dataset), strict=True)
        if result == FoundResult.UNDETERMINED
    ]  # fmt: skip
    texts, told = [], set()
    for direction in (
        dataset["singular_vector"].transpose("direction_of_fit", "parameter").values[::-1]
    ):
        which = [n for n, part in zip(names, np.abs(direction), strict=True) if part > PART]
        left = [name for name in which if name in open_names and name not in told]
        if not left:
            continue
        told |= {*left}
        symbols = series(plain_symbol(name) for name in which)
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


def found_table(scene: str, dataset: xr.Dataset) -> Table:
    """Return the parameters of a scene, with standard deviations and correlations."""
    names = [str(name) for name in dataset["parameter"].values]
    head = [
        "parameter",
        "found",
        "standard deviation",
        "by the measurements",
        *(f"correlation with {plain_symbol(n)}" for n in names),
    ]
    rows = [
        [
            plain_symbol(name),
            with_units(dataset[name], format_number(float(dataset[name]), 6)),
            with_units(dataset[name], at_most(float(dataset[f"{name}_std"]), 2)),
            STATES[result],
            *(DASH if np.isnan(value) else f"{value:.2f}" for value in shares),
        ]
        for name, result, shares in zip(names, results(dataset), correlation(dataset), strict=True)
    ]
    return Table(
        head, rows, note_text(dataset), title="Parameters nearest to what was measured", scene=scene
    )


def note_text(dataset: xr.Dataset) -> str:
    """Write number and noise of the measurements, what deviations hold for, and what is told apart badly."""
    noise = series(
        f"{part.name} {with_units(part.measured, format_number(float(part.noise), 2))}"
        for part in columns(dataset)
    )
    how = "given" if dataset.attrs.get("noise") == "given" else "estimated"
    text = (
        f"{dataset.sizes['measurement']} measurements, {how} noise of {noise}. {fit_text(dataset)}"
    )
    if int(dataset["fit_result"]) != FitResult.EXPLAINED:
        text += " Deviations hold only where the misfit is noise, which it is not shown to be."
    names, alike = dataset["parameter"].values, np.abs(correlation(dataset)) > ALIKE
    pairs = [
        f"{plain_symbol(names[i])} and {plain_symbol(names[j])}"
        for i, j in np.argwhere(np.triu(alike, 1))
    ]
    return text + (f" Told apart badly: {series(pairs)}." if pairs else "")


REPORT = ReportPart(
    "Identification",
    "Which parameters explain what was measured?",
    answers,
    tables,
)
