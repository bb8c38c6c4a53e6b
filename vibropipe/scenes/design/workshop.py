"""What a workshop reads of designs: yields, tolerances, and which of them cannot be held."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr

from vibropipe.figures.claims import at_least, percent, rounded_down
from vibropipe.figures.text import format_number, in_brackets, plain_symbol_of, with_units
from vibropipe.report.parts import DASH, Answer, Table, told_once
from vibropipe.scenes.design.data import (
    Part,
    has_tolerances,
    has_yield,
    numbers,
    off_allowed,
    wanted_parts,
)
from vibropipe.scenes.design.nominal import (
    DIGITS,
    held_too_wide,
    hold_at_once,
    kept_tolerance,
    shown_tolerance,
    toleranced,
)
from vibropipe.scenes.design.sorting_words import Sorting, sorting_of, sorting_text
from vibropipe.words.designs import ToleranceResult
from vibropipe.words.wording import capitalised, series

# A design of which so many sampled exciters keep all that is wanted, with 95 % confidence, can be made.
MADE = 0.95
SAMPLED = "4,096"  # exciters of each design
MARK = "*"
# Relative difference of tolerances that are one times a factor.
SAME_RATIO = 1e-6
# Relative difference of one distance, by sensitivities and by the deviations of a dataset.
SAME_DISTANCE = 1e-6
FAR = 1e6  # standard deviations from which on the spread is rounding, as where symmetry lets it vanish
HOLD = "the law of motion, the bounds and the targets within what is allowed hold"
BOX = f"All parameters may be off at once: at each combination of their ends {HOLD}."
AXES = (
    f"At each end of each tolerance alone {HOLD}; with all parameters off at once the bounds and the targets do to "
    "first order."
)


def workshop_texts(dataset: xr.Dataset) -> list[str]:
    """Return what tables of tolerances mean, which designs have none and why, and which cannot be held."""
    if not has_tolerances(dataset):
        return []
    texts, rows = [BOX if hold_at_once(dataset) else AXES], range(numbers(dataset).size)
    reasons = {row: reason for row in rows if (reason := no_tolerance(dataset, row))}
    for reason in dict.fromkeys(reasons.values()):
        texts.append(f"{no_tolerance_text([n for n in reasons if reasons[n] == reason], reason)}.")
    wide: dict[tuple[str, ...], list[int]] = {}
    for row in rows:
        wide.setdefault(tuple(held_too_wide(dataset, row)), []).append(row)
    marked = [
        f"{series(plain_symbol_of(dataset[name]) for name in names)} of {designs_text(which).lower()}"
        for names, which in wide.items()
        if names
    ]
    if marked:
        texts.append(
            f"{MARK} A tolerance below the given standard deviation, which cannot be held: {'; '.join(marked)}."
        )
    return texts


def no_tolerance(dataset: xr.Dataset, row: int) -> str:
    """Write why a design has no tolerances; empty if it has some."""
    result = ToleranceResult(int(dataset["tolerance_result"].values[row]))
    if result == ToleranceResult.FOUND:
        return ""
    is_on_bound = result == ToleranceResult.ON_BOUND
    bound = nearest_bound(dataset, row) if is_on_bound else None
    return f"{result.reason} {bound}" if bound else result.reason


def no_tolerance_text(rows: Sequence[int], reason: str) -> str:
    """Write which designs have no tolerances, and why."""
    return f"{designs_text(rows)} {'has' if len(rows) == 1 else 'have'} no tolerance: {reason}"


def designs_text(rows: Sequence[int]) -> str:
    """Write the numbers of designs: Design 1, Designs 1 and 3, Designs 2 to 4."""
    if len(rows) == 1:
        return f"Design {rows[0] + 1}"
    is_run = len(rows) > 2 and rows[-1] - rows[0] == len(rows) - 1
    which = f"{rows[0] + 1} to {rows[-1] + 1}" if is_run else series(str(row + 1) for row in rows)
    return f"Designs {which}"


def nearest_bound(dataset: xr.Dataset, row: int) -> str:
    """Write the bound that a design is nearest to, relative to its size; empty if none is known."""
    found: list[tuple[float, str]] = []
    for part in wanted_parts(dataset):
        values = part.of(dataset)
        value = float(values.values[row])
        for end, sign in (("lower", ">"), ("upper", "<")):
            limit = part.end(dataset, end)
            if np.isfinite(limit):
                text = f"of the {part.words(dataset)} {sign} {with_units(values, format_number(limit, 6))}"
                found.append((abs(value - limit) / max(abs(limit), 1e-300), text))
    return min(found)[1] if found else ""


def tolerances_table(scene: str, dataset: xr.Dataset) -> Table | None:
    """Return the tolerances of all designs of a scene; None if none were asked for or there is one design alone."""
    names = toleranced(dataset)
    if not names or dataset.sizes["design"] == 1:
        return None
    shares = shares_of_first(dataset, names)
    head = [in_brackets(f"± {plain_symbol_of(dataset[name])}", dataset[name]) for name in names]
    given = [
        format_number(float(dataset[f"{name}_std"]), 3) if f"{name}_std" in dataset else DASH
        for name in names
    ]
    rows = [[f"{dataset.attrs['scatter']} deviation", *given]]
    for row, number in enumerate(numbers(dataset)[: 1 if shares else None]):
        marked = held_too_wide(dataset, row)
        cells = [shown_tolerance(dataset, n, row) + MARK * (n in marked) for n in names]
        rows.append([f"{'design ' * bool(shares)}{number}", *cells])
    note = " ".join(["Rounded down.", *shares, *workshop_texts(dataset)])
    title = "How far the parameters of each design may be off"
    return Table(["design", *head], rows, note, title=title, scene=scene)


def shares_of_first(dataset: xr.Dataset, names: list[str]) -> list[str]:
    """Write the tolerances of all designs as shares of those of design 1; nothing where one factor is not enough."""
    all_of = np.array([dataset[f"{name}_tolerance"].values for name in names])
    with np.errstate(divide="ignore", invalid="ignore"):
        factors = all_of / all_of[:, :1]
    if not np.isfinite(factors).all() or (np.ptp(factors, axis=0) > SAME_RATIO).any():
        return []
    first = [rounded_down(kept_tolerance(dataset, name, 0), DIGITS) for name in names]
    texts = []
    for row, number in enumerate(numbers(dataset).tolist()[1:], start=1):
        kept = [kept_tolerance(dataset, name, row) for name in names]
        texts.append(f"{at_least(min(np.divide(kept, first)), DIGITS)} (design {number})")
    return [f"Those of the other designs are those of design 1 times {series(texts)}."]


def yield_words(dataset: xr.Dataset) -> str:
    """Write what the yield counts, and with which deviations exciters are sampled."""
    return f"share of {SAMPLED} exciters, sampled {scatter_words(dataset)}, that keep {kept_words(dataset)}"


def scatter_words(dataset: xr.Dataset) -> str:
    """Write which deviations sampled exciters have."""
    if dataset.attrs["scatter"] == "given":
        return "with the given deviations"
    return "with assumed deviations of 0.1 %"


def kept_words(dataset: xr.Dataset) -> str:
    """Write what a sampled exciter that counts keeps."""
    kept = ["the law of motion"]
    kept += ["the bounds"] if "subject_to" in dataset.attrs else []
    if "allow" in dataset.attrs:
        kept.append("the targets")
    elif "target" in dataset.attrs:
        kept[-1] += " (targets do not count, since it is not said how far they may be off)"
    return series(kept)


def makeable(dataset: xr.Dataset) -> Answer:
    """Return how many designs can be made."""
    low, n = dataset["yield_low"].values, dataset.sizes["design"]
    made = int((low >= MADE).sum())
    who = f"exciters sampled {scatter_words(dataset)} keep {kept_words(dataset)}."
    enough = f"at least {percent(MADE)} of the {who}"
    of_each = "Of each, " if n > 1 else ""
    if (dataset["yield_high"].values < MADE).all():
        lead = f"None of {n} designs can be made." if n > 1 else "The design cannot be made."
        text = f"{of_each}fewer than {percent(MADE)} of the {who}"
    elif not made:
        which, of_any = (f"any of {n} designs", "of any ") if n > 1 else ("the design", "")
        lead = f"Whether {which} can be made is not known."
        text = f"It is not shown {of_any}that {enough}"
    elif made < n:
        lead, text = f"{made} of {n} designs can be made.", f"Of these, {enough}"
    else:
        lead = f"All {n} designs can be made." if n > 1 else "The design can be made."
        is_whole = (dataset["yield"].values == 1.0).all()
        text = of_each + (f"all {SAMPLED} {who}" if is_whole else enough)
    return Answer(lead, " ".join(filter(None, [capitalised(text), sorting_text(dataset)])))


def sorting_table(scene: str, dataset: xr.Dataset) -> Table | None:
    """Return of each of several designs the yield, and what foretells which exciters are good; None if none fails."""
    if dataset.sizes["design"] == 1 or not has_yield(dataset) or (dataset["yield"] == 1.0).all():
        return None
    yields = dataset["yield"].values.tolist()
    rules = [sorting_of(dataset, row) for row in range(len(yields))]
    has_rule = any(rule is not None for rule in rules)
    sorting = ["good are those whose", "is", "sorted wrongly"] * has_rule
    rows = [
        [str(n), percent(share), *sorting_cells(rule, share)[: len(sorting)]]
        for n, share, rule in zip(numbers(dataset), yields, rules, strict=True)
    ]
    note, title = (
        f"Yield: {yield_words(dataset)}.",
        "How many sampled exciters of each design are good",
    )
    if has_rule:
        note += " Sorted wrongly: between which shares of all, with 95 % confidence."
        title += ", and what they are told by"
    table = Table(
        ["design", "yield", *sorting],
        rows,
        note,
        ("auto", "auto", *("1fr", "auto", "auto")[: len(sorting)]),
        title=title,
        scene=scene,
        repeated=(["yield"] * (not has_rule and yields_differ(dataset)), "designs"),
    )
    return told_once(table, "all designs")


def limit_cells(dataset: xr.Dataset, row: int) -> list[str]:
    """Return the nearest limit of a goal of a design, and how many standard deviations it is away, if that is known."""
    if not has_yield(dataset):
        return []
    part, away = nearest_limit(dataset, row)
    return [
        DASH if part is None else part.words(dataset),
        at_least(away, DIGITS) if np.isfinite(away) else DASH,
    ]


def sorting_cells(rule: Sorting | None, share: float) -> list[str]:
    """Return the cells of a sorting rule: the quantity, on which side of which value, the share sorted wrongly.

    `share` is the yield, by which there may be too few good or bad exciters for a rule.
    """
    if rule is None:
        few = "too few fail" if share >= 0.5 else "too few are good"
        return [{1.0: "none fails", 0.0: "none is good"}.get(share, few), DASH, DASH]
    return [*rule] if rule.words else ["no single quantity", DASH, DASH]


def nearest_limit(dataset: xr.Dataset, row: int) -> tuple[Part | None, float]:
    """Return the quantity whose limit a design is nearest to, None if not known, and how far; infinite without one."""
    away = float(dataset["reliability_index"].values[row]) if has_yield(dataset) else np.inf
    away = away if away < FAR else np.inf
    found = [
        part
        for part in wanted_parts(dataset)
        if np.isclose(away, distances_to_ends(dataset, part, row), rtol=SAME_DISTANCE).any()
    ]
    return (found[0] if len(found) == 1 and np.isfinite(away) else None), away


def nearest_limit_text(dataset: xr.Dataset) -> str:
    """Write which limit of a goal the first design is nearest to, and how far; empty if that is not known."""
    part, away = nearest_limit(dataset, 0)
    if not np.isfinite(away):
        return ""
    goal = f", of the {part.words(dataset)}," if part is not None else ""
    which = " of design 1" if dataset.sizes["design"] > 1 else ""
    away_text = f"{at_least(away, DIGITS)} standard deviations away, to first order."
    return f"The nearest limit{which}{goal} is {away_text}"


def distances_to_ends(dataset: xr.Dataset, part: Part, row: int) -> np.ndarray:
    """Return how far a quantity of a design is from the ends of its goal (2,), in standard deviations."""
    if f"{part.variable}_std" not in dataset:
        return np.full(2, np.nan)
    value = float(part.of(dataset).values[row])
    std = float(part.of(dataset, "_std").sel(estimate="first_order").values[row])
    target, off = part.end(dataset, "target"), off_allowed(dataset, part)
    low = np.fmax(part.end(dataset, "lower"), target - off if off else np.nan)
    high = np.fmin(part.end(dataset, "upper"), target + off if off else np.nan)
    return np.array([value - low, high - value]) / std


def yields_differ(dataset: xr.Dataset) -> bool:
    """Return whether yields are drawn: one that all designs have is told in a sentence."""
    return has_yield(dataset) and bool(np.ptp(dataset["yield"].values) > 0.0)


def is_lost(dataset: xr.Dataset) -> np.ndarray:
    """Return of each design whether it is shown to lose more parts than one that can be made."""
    return dataset["yield_high"].values < MADE


def lost_text(dataset: xr.Dataset) -> str:
    """Write which designs lose how many of their sampled exciters; empty if none loses many."""
    lost = np.flatnonzero(is_lost(dataset)) if has_yield(dataset) else np.empty(0, int)
    if not lost.size:
        return ""
    shares, which = dataset["yield"].values[lost], designs_text(lost.tolist())
    if lost.size == 1:
        return f"{which} loses {percent(1 - shares[0], up=True)} of its sampled exciters."
    least, most = percent(1 - shares.max()), percent(1 - shares.min(), up=True)
    return f"{which} lose {least.removesuffix(' %')} to {most} of their sampled exciters."


def lost_answer(dataset: xr.Dataset) -> str:
    """Write how many designs lose how many of their sampled exciters at most; empty if none loses many."""
    lost = int(is_lost(dataset).sum()) if has_yield(dataset) else 0
    if lost < 2:
        return lost_text(dataset)
    most = percent(1 - float(dataset["yield"].values.min()), up=True)
    return f"{lost} designs lose up to {most} of their sampled exciters."
