"""Part of the report on motions: their steady states in one table, a row for each."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import xarray as xr

from vibropipe.figures.claims import at_most
from vibropipe.figures.motion_words import PROGRESSION, progression_of, stability_text
from vibropipe.figures.regime_words import regime_clause, regime_text
from vibropipe.figures.style import ROUNDING
from vibropipe.figures.text import (
    departure,
    format_number,
    in_brackets,
    is_soft_without_restitution,
    plain_symbol_of,
    scalar_parameters,
    with_units,
)
from vibropipe.report.parts import DASH, Datasets, Line, Table, symbol, tables_of_each
from vibropipe.scenes.certificate_page import bounds_table
from vibropipe.scenes.kind import ReportPart
from vibropipe.scenes.motion.findings import answers
from vibropipe.scenes.motion.steady_text import DIGITS, is_steady, multiplier_text, struck_text
from vibropipe.solve.shown_units import shows_cycles
from vibropipe.words.parameters import or_default
from vibropipe.words.wording import count, series

# Columns that are left out and said below the table if all rows are the same.
COMMON = ("regime", "multiple", "stability", "rests")
MAX_PARAMETERS = 4  # in which the motions differ, as columns
# The columns that fit on a page beside the names, and what is left out first.
MAX_COLUMNS = 9
LEAST = ("rests", "multiple", "harmonic 2", "contact", "multiplier")
CONTACTS = (("force", "support_force_max"), ("contact", "contact_duration_max"))


def steady_tables(datasets: Datasets) -> list[Table]:
    """Return a table of the steady states that motions have, one row each; none without one."""
    steady = {name: data for name, data in datasets.items() if is_steady(data)}
    if not steady:
        return []
    columns = steady_columns(steady)
    common = {
        name: cells[0]
        for name, cells in columns.items()
        if name in COMMON and len(steady) > 1 and len({*cells}) == 1
    }
    shown = {
        name: cells
        for name, cells in columns.items()
        if name not in common and (name == "mean" or not {*cells} <= {DASH, "0"})
    }
    shown = fitting(shown, min(len(differing(steady)), MAX_PARAMETERS))
    title = "The steady state" if len(steady) == 1 else "Steady states of the motions"
    labels = [label.removeprefix("the motion of ").removeprefix("the ") for label in steady]
    rows = [list(cells) for cells in zip(labels, *shown.values(), strict=True)]
    # that of one motion stands beside its own picture
    own = next(iter(steady)) if len(steady) == 1 else ""
    return [Table(["motion", *shown], rows, note_text(shown, common), title=title, scene=own)]


def fitting(columns: dict[str, list[str]], n_parameters: int) -> dict[str, list[str]]:
    """Return at most MAX_COLUMNS columns, without those that matter least; the first ones are of parameters."""
    kept = dict(columns)
    others = [[name for name in columns if name.startswith(start)] for start in LEAST]
    parameters = [[name] for name in list(columns)[2:n_parameters]]
    for names in (*reversed(parameters), *others):
        for name in names:
            if len(kept) > MAX_COLUMNS:
                kept.pop(name, None)
    return kept


def note_text(shown: Sequence[str] | dict[str, list[str]], common: dict[str, str]) -> str:
    """Write what all motions share, and what the columns are."""
    told = {
        "regime": lambda text: regime_clause(text, plural=True),
        "multiple": lambda m: f"repeat after {count(int(m), 'forcing period')}",
        "stability": "are {}".format,
        "rests": lambda n: f"have {n} rest{'s' * (n != '1')} per orbit",
    }
    same = [told[name](value) for name, value in common.items() if value not in (DASH, "0")]
    texts = [f"All motions {series(same)}." if same else ""]
    struck = any(name.startswith("impacts_") for name in shown)
    texts.append("Struck: velocities before the impacts of the orbit." if struck else "")
    soft = any(name.startswith("force") for name in shown)
    both = "Force and contact" if any(name.startswith("contact") for name in shown) else "Force"
    texts.append(f"{both}: the largest of soft supports." if soft else "")
    progresses = any(name.startswith("progression") for name in shown)
    texts.append(f"{PROGRESSION}." if progresses else "")
    texts.append("Multiplier: largest modulus." if "multiplier" in shown else "")
    return " ".join(filter(None, texts))


def steady_columns(datasets: Datasets) -> dict[str, list[str]]:
    """Return the cells of the table by the heads of its columns."""
    scenes = list(datasets.values())
    columns: dict[str, list[str]] = {}
    alike: dict[tuple[float, ...], list[str]] = {}
    for name, values in differing(datasets).items():
        alike.setdefault(tuple(values), []).append(name)
    for numbers, names in list(alike.items())[:MAX_PARAMETERS]:
        # one column for what both supports share
        head = ", ".join(parameter_symbol(scenes, name) for name in names)
        columns[with_unit(head, scenes, names[0])] = [
            DASH if is_soft_without_restitution(data, names[0]) else format_number(v, DIGITS)
            for data, v in zip(scenes, numbers, strict=True)
        ]
    columns["regime"] = [regime_text(int(d["regime"])) for d in scenes]
    columns["multiple"] = [str(int(d["period_multiple"]) or DASH) for d in scenes]
    for support in (1, 2):
        head = with_unit(f"impacts_{support}", scenes, "orbit_impact_velocity")
        columns[head] = [struck_text(d, support) for d in scenes]
    columns |= contact_columns(scenes)
    columns["rests"] = [format_number(rests(d)) for d in scenes]
    columns[with_unit("mean", scenes, "displacement_mean")] = [
        format_number(mean(d), DIGITS) for d in scenes
    ]
    if any("housing_velocity_mean" in d for d in scenes):
        cells = [format_number(progression_of(d), DIGITS) for d in scenes]
        columns[with_unit("progression", scenes, "housing_velocity_mean")] = cells
    for k in (0, 1):
        head = with_unit(f"harmonic {k + 1}", scenes, "displacement_amplitude")
        columns[head] = [format_number(harmonic(d, k), DIGITS) for d in scenes]
    columns["exponent"] = [exponent_text(d) for d in scenes]
    columns["multiplier"] = [multiplier_text(d) for d in scenes]
    columns["stability"] = [(stability_text(d) if "stable" in d else "") or DASH for d in scenes]
    return columns


def contact_columns(scenes: Sequence[xr.Dataset]) -> dict[str, list[str]]:
    """Return the columns of the largest force and the longest contact of soft supports that are struck."""
    columns = {}
    for text, name in CONTACTS:
        values = [float(data[name].max()) if name in data else math.nan for data in scenes]
        if np.isfinite(values).any():
            columns[with_unit(text, scenes, name)] = [
                format_number(value, DIGITS) for value in values
            ]
    return columns


def parameter_symbol(scenes: Sequence[xr.Dataset], name: str) -> str:
    """Return the symbol of a parameter, of a frequency in cycles ω/2π."""
    in_cycles = [d[name] for d in scenes if name in d.variables and shows_cycles(d[name])]
    return plain_symbol_of(in_cycles[0]) if in_cycles else symbol(name)


def with_unit(text: str, scenes: Sequence[xr.Dataset], name: str = "") -> str:
    """Return the name of a column with the unit of a variable in brackets (default: of the variable of that name)."""
    found = [data[name or text] for data in scenes if (name or text) in data.variables]
    return in_brackets(text, found[0]) if found else text


def differing(datasets: Datasets) -> dict[str, list[float]]:
    """Return the parameters that differ between scenes, with their values."""
    by_scene = [scalar_parameters(dataset) for dataset in datasets.values()]
    # Parameters of further effects are stored where the effect is present.
    names = dict.fromkeys(name for values in by_scene for name in values)
    found = {name: [or_default(values, name) for values in by_scene] for name in names}
    return {name: values for name, values in found.items() if len({*values}) > 1}


def rests(dataset: xr.Dataset) -> float:
    """Return the number of rests of the orbit on both supports."""
    return float(dataset["rests_per_orbit"].sum()) if "rests_per_orbit" in dataset else 0.0


def harmonic(dataset: xr.Dataset, k: int) -> float:
    """Return the displacement amplitude at index `k` (0: first harmonic), nan if not stored."""
    if "displacement_amplitude" not in dataset or k >= dataset.sizes["harmonic"]:
        return math.nan
    return without_rounding(dataset, float(dataset["displacement_amplitude"].values[k]))


def mean(dataset: xr.Dataset) -> float:
    """Return the mean displacement, nan if not stored."""
    if "displacement_mean" not in dataset:
        return math.nan
    return without_rounding(dataset, float(dataset["displacement_mean"]))


def without_rounding(dataset: xr.Dataset, value: float) -> float:
    """Return a value, or 0 if it is a rounding error relative to the first harmonic."""
    first = abs(float(dataset["displacement_amplitude"].values[0]))
    return 0.0 if abs(value) <= ROUNDING * first else value


def exponent_text(dataset: xr.Dataset) -> str:
    """Write the Lyapunov exponent of a motion with its error; a dash if it was not asked for or is not known."""
    if "lyapunov_exponent" not in dataset or not np.isfinite(float(dataset["lyapunov_exponent"])):
        return DASH
    exponent, error = (dataset[f"lyapunov_exponent{end}"] for end in ("", "_error"))
    text = format_number(float(exponent), 3)
    if float(error) > 0.0:
        text = f"{text} ± {at_most(float(error), 2)}"
    return with_units(exponent, text)


def accuracy_lines(datasets: Datasets) -> list[Line]:
    """Return the line on the largest deviation of a stepping method from the exact motion."""
    departures = {n: departure(d) for n, d in datasets.items() if "displacement_exact" in d}
    if not departures:
        return []
    worst = max(departures, key=lambda name: departures[name])
    number = with_units(datasets[worst]["displacement"], at_most(departures[worst], 2))
    where = f", in {worst}" if len(departures) > 1 else ""
    text = f"the exact motion of the same start; displacements computed in steps differ by at most {number}{where}"
    return [Line("Compared with", text)]


def question(datasets: Datasets) -> str:
    """Return the question of motions."""
    if len(datasets) == 1:
        return "How does the mass move, and how hard does it strike?"
    return "How do these motions differ?"


def tables(datasets: Datasets) -> list[Table]:
    """Return the tables of motions: their steady states, and the bounds of proofs."""
    return [*steady_tables(datasets), *tables_of_each(bounds_table)(datasets)]


REPORT = ReportPart("Motions", question, answers, tables, accuracy_lines)
