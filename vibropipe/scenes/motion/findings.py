"""Findings of motions: their steady states, impact velocities and constant parts, and which did not end as asked."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import xarray as xr

from vibropipe.figures.stability import stability_text
from vibropipe.figures.text import REGIME_TEXT, is_forced, regime_name, window_text
from vibropipe.report.findings import Finding, value_text
from vibropipe.report.table import Datasets, breakable
from vibropipe.words.regimes import Regime
from vibropipe.words.status import Status
from vibropipe.words.wording import count, series

MAX_NAMED = 6  # scenes that a sentence names


def findings(datasets: Datasets) -> list[Finding]:
    """Return one finding on all motions of a study."""
    return [
        Finding(
            (
                steady_text(datasets),
                exponent_text(datasets),
                velocity_text(datasets),
                mean_text(datasets),
                status_text(datasets),
            ),
            next(iter(datasets)) if len(datasets) == 1 else "",
        )
    ]


def steady_text(datasets: Datasets) -> str:
    """Write which steady states the motions have, with the scenes of each."""
    by_text: dict[str, list[str]] = {}
    for name, data in datasets.items():
        if "regime" in data and not data["regime"].ndim:
            by_text.setdefault(orbit_text(data), []).append(name)
    if len(datasets) == 1:
        return f"The steady state is {next(iter(by_text))}" if by_text else ""
    texts = [f"{text} ({names_text(names)})" for text, names in by_text.items()]
    return f"The steady states of the motions are {series(texts)}" if texts else ""


def orbit_text(dataset: xr.Dataset) -> str:
    """Write regime, period and stability of the steady state of a motion."""
    code = int(dataset["regime"])
    text = REGIME_TEXT[regime_name(code)]
    if code >= Regime.APERIODIC:
        return f"{text} {window_text(dataset)}".strip() if code == Regime.APERIODIC else text
    multiple = int(dataset["period_multiple"])
    stability = ""
    if "stable" in dataset:
        stability = f", {stability_text(dataset)}"
    period = f", of {count(multiple, 'forcing period')}" if is_forced(dataset) else ""
    return f"{text}{period}{stability}"


def names_text(names: Iterable[str]) -> str:
    """Write names of scenes; beyond MAX_NAMED, their number."""
    listed = [breakable(name) for name in names]
    return count(len(listed), "scene") if len(listed) > MAX_NAMED else series(listed)


def velocity_text(datasets: Datasets) -> str:
    """Write the largest impact velocity of the motions: its support, scene and time."""
    tops = {
        name: int(np.abs(data["impact_velocity"].values).argmax())
        for name, data in datasets.items()
        if data.sizes.get("impact") and "impact_velocity" in data and "impact_support" in data
    }
    if not tops:
        struck = any("impact_velocity" in data for data in datasets.values())
        return "No support is struck" if struck else ""
    sizes = {n: abs(float(datasets[n]["impact_velocity"][index])) for n, index in tops.items()}
    name = max(sizes, key=lambda key: sizes[key])
    if sizes[name] == 0.0:
        return "No support is struck with a velocity"
    data = datasets[name]
    where = f", in {breakable(name)}" if len(datasets) > 1 else ""
    return (
        f"The largest impact velocity is {value_text(data['impact_velocity'], sizes[name])}, "
        f"on support {int(data['impact_support'][tops[name]])}{where}"
    )


def mean_text(datasets: Datasets) -> str:
    """Write the largest constant part of displacement of the steady states."""
    means = {
        name: data["displacement_mean"]
        for name, data in datasets.items()
        if "displacement_mean" in data and np.isfinite(float(data["displacement_mean"]))
    }
    if not means:
        return ""
    name = max(means, key=lambda key: abs(float(means[key])))
    value, data = means[name], datasets[name]
    if abs(float(value)) <= 1e-9 * float(np.abs(data["displacement_amplitude"]).max()):
        return "The constant part of displacement is zero"
    where = f", in {breakable(name)}" if len(means) > 1 else ""
    return f"The largest constant part of displacement is {value_text(value, value)}{where}"


def exponent_text(datasets: Datasets) -> str:
    """Write the Lyapunov exponents that were asked for, each with its error and its scene."""
    texts = []
    for name, data in datasets.items():
        if "lyapunov_exponent" not in data or data["lyapunov_exponent"].ndim:
            continue
        exponent, error = (data[f"lyapunov_exponent{end}"] for end in ("", "_error"))
        text = value_text(exponent, exponent) if not np.isnan(exponent) else "not known"
        if np.isfinite(exponent) and float(error) > 0.0:
            text += f" with an error of {value_text(exponent, error, 2)}"
        texts.append(f"{text} ({breakable(name)})" if len(datasets) > 1 else text)
    if not texts:
        return ""
    several = len(texts) > 1
    return f"The Lyapunov exponent{'s are' if several else ' is'} {series(texts)}"


def status_text(datasets: Datasets) -> str:
    """Write which motions did not end as requested."""
    texts = [
        f"{breakable(name)} ({Status(int(data['status'])).name.lower()})"
        for name, data in datasets.items()
        if "status" in data and not data["status"].ndim and int(data["status"]) != Status.OK
    ]
    verb = "has" if len(texts) == 1 else "have"
    return f"{series(texts)} {verb} a status other than ok (see below)" if texts else ""
