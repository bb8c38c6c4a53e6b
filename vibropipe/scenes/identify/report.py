"""Part of the report on identifications: the parameters found, how precisely, and how they depend on each other."""

from __future__ import annotations

import numpy as np
import xarray as xr

from vibropipe.figures.text import format_number, plain_symbol, with_units
from vibropipe.report.findings import Finding
from vibropipe.report.parts import answers_of, tables_of
from vibropipe.report.section import Section
from vibropipe.report.table import Datasets, Table
from vibropipe.scenes.identify.pictures import columns, found_text
from vibropipe.scenes.kind import ReportPart
from vibropipe.words.wording import series

# Correlation above which two parameters are told apart badly.
ALIKE = 0.95


def sections(datasets: Datasets) -> list[Section]:
    """Return a section on the parameters that were found."""
    tables = [found_table(name, dataset) for name, dataset in datasets.items()]
    texts = [f"{name}: {fit_text(dataset)}." for name, dataset in datasets.items()]
    return [Section("Parameters found", texts, tables)] if tables else []


def correlation(dataset: xr.Dataset) -> np.ndarray:
    """Return the correlation of the parameters found."""
    covariance = dataset["parameter_covariance"].values
    sigma = np.sqrt(np.diag(covariance))
    return np.asarray(
        covariance / np.where(sigma > 0, sigma, 1.0) / np.where(sigma > 0, sigma, 1.0)[:, None]
    )


def found_table(scene: str, dataset: xr.Dataset) -> Table:
    """Return the parameters of a scene, with standard deviations and correlations."""
    names = [str(name) for name in dataset["parameter"].values]
    head = [
        "parameter",
        "found",
        "standard deviation",
        *(f"correlation with {plain_symbol(n)}" for n in names),
    ]
    rows = [
        [
            plain_symbol(name),
            with_units(dataset[name], format_number(float(dataset[name]), 6)),
            with_units(dataset[name], format_number(float(dataset[f"{name}_std"]), 2)),
            *(f"{value:.2f}" for value in shares),
        ]
        for name, shares in zip(names, correlation(dataset), strict=True)
    ]
    return Table(head, rows, f"Parameters of {scene} that explain what was measured.")


def fit_text(dataset: xr.Dataset) -> str:
    """Write how well the parameters explain the measurements, and which of them are told apart badly."""
    noise = series(
        f"{part.name} {with_units(part.measured, format_number(float(part.noise), 2))}"
        for part in columns(dataset)
    )
    text = f"{dataset.sizes['measurement']} measurements, noise of {noise}"
    if dataset.attrs.get("noise") == "given":
        chi = format_number(float(dataset["reduced_chi_square"]), 3)
        text += f"; sum of squares over degrees of freedom: {chi}, near 1 if that noise explains the misfit"
    names, alike = dataset["parameter"].values, np.abs(correlation(dataset)) > ALIKE
    pairs = [
        f"{plain_symbol(names[i])} and {plain_symbol(names[j])}"
        for i, j in np.argwhere(np.triu(alike, 1))
    ]
    return text + (f"; told apart badly: {series(pairs)}" if pairs else "")


def findings(datasets: Datasets) -> list[Finding]:
    """Return what the first page says: the parameters found."""
    return [
        Finding(
            (f"The measurements are explained by {series(found_text(data))}", fit_text(data)), name
        )
        for name, data in datasets.items()
    ]


REPORT = ReportPart(
    "Identification",
    "Which parameters explain what was measured?",
    answers_of(findings),
    tables_of(sections),
)
