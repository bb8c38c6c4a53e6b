"""What a workshop reads of designs: yields, tolerances, and which of them cannot be held."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr

from vibropipe.figures.claims import at_least
from vibropipe.figures.text import format_number, in_brackets, plain_symbol, with_units
from vibropipe.report.parts import Answer
from vibropipe.report.table import DASH, Table, breakable
from vibropipe.scenes.design.data import (
    Part,
    has_spread,
    has_tolerances,
    has_yield,
    numbers,
    spread_parts,
    wanted_parts,
)
from vibropipe.words.designs import ToleranceResult
from vibropipe.words.wording import series

# A design of which so many parts keep all that is wanted, with 95 % confidence, can be made.
MADE = 0.95
MARK = "*"
# Significant digits of nominal values, and of tolerances and deviations.
NOMINAL_DIGITS, DIGITS = 5, 2
BOX = (
    "All parameters may be off by their tolerances at once, in any combination: at every corner the law of motion, the "
    "bounds and the targets within what is allowed hold."
)


def workshop_texts(dataset: xr.Dataset) -> list[str]:
    """Return what tables of tolerances mean, which designs have none and why, and which cannot be held."""
    if not has_tolerances(dataset):
        return []
    texts = [BOX]
    results = dataset["tolerance_result"].values
    for row, number in enumerate(numbers(dataset)):
        result = ToleranceResult(int(results[row]))
        if result == ToleranceResult.FOUND:
            continue
        reason = result.reason
        if result == ToleranceResult.ON_BOUND and (bound := nearest_bound(dataset, row)):
            reason += f" {bound}"
        texts.append(f"Design {number}, no tolerance: {reason}.")
    marked = [
        f"{series(plain_symbol(name) for name in names)} of design {number}"
        for row, number in enumerate(numbers(dataset))
        if (names := held_too_wide(dataset, row))
    ]
    if marked:
        texts.append(
            f"{MARK} A tolerance below the given standard deviation, which cannot be held: {'; '.join(marked)}."
        )
    return texts


def held_too_wide(dataset: xr.Dataset, row: int) -> list[str]:
    """Return the parameters of a design whose tolerance is below the deviation that is given for them."""
    if dataset.attrs.get("scatter") != "given":
        return []
    return [
        name
        for name in toleranced(dataset)
        if f"{name}_std" in dataset
        and float(dataset[f"{name}_tolerance"].values[row]) < float(dataset[f"{name}_std"])
    ]


def toleranced(dataset: xr.Dataset) -> list[str]:
    """Return the parameters that have tolerances."""
    return [str(name) for name in dataset.coords if f"{name}_tolerance" in dataset]


def nearest_bound(dataset: xr.Dataset, row: int) -> str:
    """Write the bound that a design is nearest to, relative to its size; empty if none is known."""
    found: list[tuple[float, str]] = []
    for part in wanted_parts(dataset):
        values = part.of(dataset)
        value = float(values.values[row])
        for end, sign in (("lower", ">"), ("upper", "<")):
            limit = part.end(dataset, end)
            if np.isfinite(limit):
                text = f"{part.name} {sign} {with_units(values, format_number(limit, 6))}"
                found.append((abs(value - limit) / max(abs(limit), 1e-300), text))
    return min(found)[1] if found else ""


def yields_table(scene: str, dataset: xr.Dataset) -> Table | None:
    """Return the yield and the tolerances of all designs of a scene."""
    if not has_yield(dataset):
        return None
    names = toleranced(dataset)
    head = ["design", "yield", "95 % interval", "deviations to the nearest limit"]
    head += [in_brackets(f"± {plain_symbol(name)}", dataset[name]) for name in names]
    rows = []
    if names:
        given = [
            format_number(float(dataset[f"{name}_std"]), 3) if f"{name}_std" in dataset else DASH
            for name in names
        ]
        rows.append([f"{dataset.attrs['scatter']} deviation", DASH, DASH, DASH, *given])
    for row, number in enumerate(numbers(dataset)):
        low, high = (float(dataset[f"yield_{end}"].values[row]) for end in ("low", "high"))
        marked = held_too_wide(dataset, row)
        rows.append(
            [
                str(number),
                percent(float(dataset["yield"].values[row])),
                f"{percent(low)} … {percent(high, up=True)}",
                at_least(float(dataset["reliability_index"].values[row]), DIGITS),
                *(shown_tolerance(dataset, name, row) + MARK * (name in marked) for name in names),
            ]
        )
    note = " ".join([f"Yield: {yield_words(dataset)}. All rounded down.", *workshop_texts(dataset)])
    title = "Yields and tolerances of all designs" if names else "Yields of all designs"
    return Table(head, rows, note, title=title, scene=scene)


def yield_words(dataset: xr.Dataset) -> str:
    """Write what the yield counts, and by which deviations parts scatter."""
    return f"share of 4,096 parts, scattered by the {scatter_words(dataset)}, that keep {kept_words(dataset)}"


def scatter_words(dataset: xr.Dataset) -> str:
    """Write which deviations parts scatter by."""
    if dataset.attrs["scatter"] == "given":
        return "given deviations"
    return "assumed deviations of 0.1 %"


def kept_words(dataset: xr.Dataset) -> str:
    """Write what a part that counts keeps."""
    kept = ["the law of motion"]
    kept += ["the bounds"] if "subject_to" in dataset.attrs else []
    if "allow" in dataset.attrs:
        kept.append("the targets within what is allowed")
    elif "target" in dataset.attrs:
        kept[-1] += " (targets do not count, since it is not said how far they may be off)"
    return series(kept)


def percent(share: float, up: bool = False) -> str:
    """Write a share in per cent to one decimal, rounded down or up: what is not all is never 100 %."""
    tenths = math.ceil(1000 * share - 1e-9) if up else math.floor(1000 * share + 1e-9)
    return f"{tenths / 10:g} %"


def makeable(dataset: xr.Dataset) -> Answer:
    """Return how many designs can be made."""
    low = dataset["yield_low"].values
    n, made = low.size, int((low >= MADE).sum())
    parts = f"at least {percent(MADE)} of the parts"
    keep = f"scattered by the {scatter_words(dataset)}, keep {kept_words(dataset)}."
    if (dataset["yield_high"].values < MADE).all():
        lead = f"None of {n} designs can be made." if n > 1 else "The design cannot be made."
        return Answer(lead, f"Fewer than {percent(MADE)} of the parts of each, {keep}")
    if not made:
        lead = f"Whether any of {n} designs can be made is not known."
        return Answer(lead, f"It is not shown of any that {parts}, {keep}")
    if made == n:
        lead = f"All {n} designs can be made." if n > 1 else "The design can be made."
    else:
        lead = f"{made} of {n} designs can be made."
    return Answer(lead, f"A{parts[1:]} of each, {keep}")


def nearest_limit_text(dataset: xr.Dataset) -> str:
    """Write how far the first design is from the nearest limit of a goal; empty if that is not known."""
    away = float(dataset["reliability_index"].values[0]) if has_yield(dataset) else np.inf
    if not np.isfinite(away):
        return ""
    return (
        f"Its nearest limit is {at_least(away, DIGITS)} standard deviations away, to first order."
    )


def lost_text(dataset: xr.Dataset) -> str:
    """Write which designs lose how many of their parts; empty if none loses many."""
    if not has_yield(dataset):
        return ""
    lost = np.flatnonzero(dataset["yield_high"].values < MADE)
    if not lost.size:
        return ""
    shares = dataset["yield"].values[lost]
    if lost.size == 1:
        return f"Design {numbers(dataset)[lost[0]]} loses {percent(1 - shares[0], up=True)} of its parts."
    which = series(str(number) for number in numbers(dataset)[lost])
    least, most = percent(1 - shares.max()), percent(1 - shares.min(), up=True)
    return f"Designs {which} lose {least.removesuffix(' %')} to {most} of their parts."


def parameters_table(scene: str, dataset: xr.Dataset) -> Table | None:
    """Return how tight each parameter of the first design must be, and what it does to the wanted quantities."""
    best = dataset.isel(design=0)
    limited = toleranced(dataset)
    of_spread = [str(name) for name in dataset["parameter"].values] if has_spread(dataset) else []
    names = [str(name) for name in dataset.coords if name in limited or name in of_spread]
    if not names:
        return None
    parts = spread_parts(dataset) if of_spread else []
    head = ["parameter", "nominal", *(["tolerance"] if limited else [])]
    head += (
        ["deviation", *(f"share of {breakable(part.name)}" for part in parts)] if of_spread else []
    )
    marked = held_too_wide(dataset, 0)
    rows = []
    for name in names:
        cells = [plain_symbol(name), nominal_text(dataset, name, 0)]
        if limited:
            text = shown_tolerance(dataset, name, 0) if name in limited else DASH
            cells.append(plus_minus(dataset, name, text) + MARK * (name in marked))
        if of_spread:
            given = float(dataset[f"{name}_std"]) if name in of_spread else np.nan
            cells.append(plus_minus(dataset, name, format_number(given, 3)))
            cells += [share_text(best, part, name) for part in parts]
        rows.append(cells)
    note = []
    if of_spread:
        low, high = (float(best[f"law_change_{end}"]) for end in ("low", "high"))
        note = [
            "Deviation: given, one standard deviation. Share: of the variance of a quantity.",
            f"The law of motion changes in {percent(low)} to {percent(high, up=True)} of the parts.",
        ]
    return Table(head, rows, " ".join(note), title="The parameters of design 1", scene=scene)


def nominal_text(dataset: xr.Dataset, name: str, row: int) -> str:
    """Write a nominal value with its unit."""
    return with_units(dataset[name], format_number(nominal(dataset, name, row), NOMINAL_DIGITS))


def nominal(dataset: xr.Dataset, name: str, row: int) -> float:
    """Return the value of a parameter of a design."""
    values = dataset[name].values
    return float(values[row] if values.ndim else values)


def shown_tolerance(dataset: xr.Dataset, name: str, row: int) -> str:
    """Write a tolerance, less what the nominal value is rounded by where it is shown, and rounded down."""
    value = nominal(dataset, name, row)
    rounding = abs(value - float(f"{value:.{NOMINAL_DIGITS}g}"))
    return at_least(float(dataset[f"{name}_tolerance"].values[row]) - rounding, DIGITS)


def plus_minus(dataset: xr.Dataset, name: str, text: str) -> str:
    """Write a tolerance or a deviation of a parameter with its unit; a dash if there is none."""
    return DASH if text == DASH else f"± {with_units(dataset[name], text)}"


def share_text(best: xr.Dataset, part: Part, name: str) -> str:
    """Write the share that a parameter has in the variance of a quantity."""
    if name not in best["parameter"].values:
        return DASH
    share = float(part.of(best, "_contribution").sel(parameter=name))
    return DASH if np.isnan(share) else f"{100 * share:.0f} %"
