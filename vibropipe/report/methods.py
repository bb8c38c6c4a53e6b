"""Methods and provenance of a study in a few lines: how it was solved, the model, the command and the data."""

from __future__ import annotations

import re
import shlex
from collections.abc import Mapping
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from vibropipe.figures.claims import at_most
from vibropipe.figures.text import format_number
from vibropipe.report.exciter import (
    drawing_of,
    has_value,
    is_of_many_exciters,
    of_calls,
    sentences_of,
)
from vibropipe.report.parts import Datasets, Line
from vibropipe.words.wording import count, series

Sidecars = Mapping[str, Mapping[str, Any]]

SHORT = 12  # digits of a commit
NAMED = 4  # files that are named


def solved_line(datasets: Datasets) -> Line:
    """Return the line on the methods of the scenes, requested and reached accuracy, and residuals of orbits."""
    methods = dict.fromkeys(
        str(data.attrs["method"]) for data in datasets.values() if "method" in data.attrs
    )
    parts = {method: {*re.split("; .*: |, ", method)} for method in methods}
    whole = [each for each in methods if not any(parts[each] < other for other in parts.values())]
    texts = [method_words("; ".join(whole))] if whole else []
    texts = ["the exact method" if text == "exact" else text for text in texts]
    asked = [value for data in datasets.values() if (value := number_of(data, "accuracy_asked"))]
    errors = [error for data in datasets.values() if (error := largest_error(data))]
    if asked:
        texts.append(f"accuracy asked: {format_number(min(asked), 2)}")
    if errors:
        texts.append(f"largest estimated error: {at_most(max(errors), 2)}")
    residuals = [r for data in datasets.values() if np.isfinite(r := largest_residual(data))]
    if residuals:
        texts.append(f"orbits close to {at_most(max(residuals), 2)}")
    return Line("Solved by", "; ".join(texts))


CRUDE = "Newmark's method with impacts at the ends of steps"


def method_words(text: str) -> str:
    """Write names of methods as words: Newmark's method with 8, with 60 steps per forcing period."""
    text = text.replace("crude", CRUDE)
    first, newmark, rest = text.partition("newmark")
    rest = re.sub(r"newmark,? (?=\d)", "with ", re.sub(r"^,? (?=\d)", " with ", rest))
    return f"{first}Newmark's method{rest}" if newmark else text


def number_of(dataset: xr.Dataset, name: str) -> float:
    """Return a numeric attribute, 0 without one."""
    value = dataset.attrs.get(name, "none")
    return 0.0 if isinstance(value, str) else float(value)


def largest_error(dataset: xr.Dataset) -> float:
    """Return the largest estimated error of a row with an orbit, or the reached accuracy; 0 without either."""
    if "error" not in dataset or "period_multiple" not in dataset:
        return number_of(dataset, "accuracy_reached")
    error = dataset["error"].values[dataset["period_multiple"].values > 0]
    return float(np.nanmax(error, initial=0.0))


def largest_residual(dataset: xr.Dataset) -> float:
    """Return the largest residual of a stable orbit, nan if there is none: a march off an unstable one grows."""
    if "residual" not in dataset:
        return float("nan")
    residual = dataset["residual"].values
    if "stable" in dataset and dataset["stable"].dims == dataset["residual"].dims:
        residual = residual[dataset["stable"].values == 1]
    closed = residual[np.isfinite(residual)]
    return float(closed.max()) if closed.size else float("nan")


def model_line(datasets: Datasets) -> Line:
    """Return the line on the model, with the effects that a scene of the study has."""
    drawing = drawing_of(datasets)
    symbols, rate = drawing["symbols"], "ẍ"
    if drawing["housing"]:
        rate = "(ẍ + Ẍ)"  # X of the housing
    left, force, second = f"{rate} + hẋ + x", "f sin ντ", "f₂ sin(2ντ + φ₂)"
    if symbols["stiffness"] == "C":
        left, force, second = f"m{rate} + Hẋ + Cx", "F sin ωt", "F₂ sin(2ωt + φ₂)"
    if any(has_value(name, datasets) for name in of_calls("second_harmonic")):
        force = f"{force} + {second}"
    if has_many := any(is_of_many_exciters(data) for data in datasets.values()):
        force = "f(τ)"
    text = f"{left} = {force if symbols['force'] or has_many else '0'} between the supports"
    is_rigid = any(not all(drawing_of({name: data})["soft"]) for name, data in datasets.items())
    ends = ["an impact turns the velocity and multiplies it by R"] if is_rigid else []
    ends += sentences_of(datasets)
    more = "an exciter may have further terms; " if has_many else ""
    return Line("Model", f"{'; '.join([text, *ends])}; {more}`docs/theory.md`")


def again_line(
    study: str, source: str, datasets: Datasets, sidecars: Sidecars, results: Path
) -> Line:
    """Return the line with the command, the files of data, the version and commit of the program, and the run time.

    Values in which datasets differ are all named.
    """
    names = list(datasets)
    few = series(f"`{name}.nc`" for name in names)
    files = few if len(names) <= NAMED else count(len(names), "file")
    folder = results.as_posix()
    chosen = f" --results {shlex.quote(folder)}" * (folder != "results")
    texts = [
        f"`vibropipe run {source or study + '.yaml'}{chosen}`",
        f"data: {files} in `{folder}/{study}`",
    ]
    versions = []
    for data in datasets.values():
        source, commit = (str(data.attrs.get(name, "")) for name in ("source", "git_commit"))
        versions.append(f"{source} {f'(commit {commit[:SHORT]})' if commit else ''}".strip())
    texts += [series(filter(None, dict.fromkeys(versions)))]
    seconds = [float(car["seconds"]) for car in sidecars.values() if car.get("seconds")]
    if seconds:
        texts.append(f"computed in {format_number(sum(seconds), 2)} s, compilation included")
    return Line("Again", "; ".join(filter(None, texts)))


def footer(study: str, datasets: Datasets, sidecars: Sidecars) -> str:
    """Write the program, the study and the day on which its last scene was computed."""
    sources = sorted({str(d.attrs["source"]) for d in datasets.values() if "source" in d.attrs})
    days = [str(car["finished"]) for car in sidecars.values() if car.get("finished")]
    day = datetime.fromisoformat(max(days)) if days else None
    date = f"{day.day} {day:%B %Y}" if day else ""
    return " · ".join(filter(None, [*sources, f"study {study.replace('_', ' ')}", date]))
