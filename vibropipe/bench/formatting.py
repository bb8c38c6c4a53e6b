"""Benchmark results as text tables or as JSON."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Sequence
from typing import Any

from vibropipe.bench.measurement import Candidate, Item, Target
from vibropipe.words.wording import aligned

UNITS = (("ms", 1e6), ("us", 1e3), ("ns", 1.0))


def as_text(items: Sequence[Item]) -> str:
    """Return a table of times for each item, followed by its ratios and whether they meet their targets."""
    return "\n\n".join(item_text(item) for item in items)


def item_text(item: Item) -> str:
    """Return the table and the ratios of one item."""
    head = ("", f"time per {item.unit}", "quartiles", "error", "first call")
    lines = aligned([head, *(table_row(candidate) for candidate in item.candidates)])
    targets = [target_text(item, target) for target in item.targets]
    return "\n".join([f"{item.name}: {item.what}", *lines, *targets])


def table_row(candidate: Candidate) -> tuple[str, ...]:
    """Return the cells of one candidate."""
    if candidate.why_not is not None:
        return candidate.name, candidate.why_not, "", "", ""
    median, low, high = candidate.quartiles()
    error = "" if math.isnan(candidate.error) else f"{candidate.error:.0e}"
    spread = f"{time_text(low)} to {time_text(high)}"
    return candidate.name, time_text(median), spread, error, f"{candidate.first_seconds:.1f} s"


def target_text(item: Item, target: Target) -> str:
    """Return a ratio, its target and whether the target is met, as one sentence."""
    ratio, low, high = item.ratios(target)
    if target.times < 1.0:
        return slower_text(target, ratio, low, high)
    target_ratio = f"target {target.times:,g}"
    if math.isnan(ratio):
        return f"{target.ours} against {target.peer}: not measured, {target_ratio}"
    outcome = "met" if ratio >= target.times else "not met"
    return (
        f"{target.ours} against {target.peer}: {times_text(ratio)} times faster"
        f" (quartiles {times_text(low)} to {times_text(high)}), {target_ratio}: {outcome}"
    )


def slower_text(target: Target, ratio: float, low: float, high: float) -> str:
    """Return the ratio of a target below 1: how many times slower ours is, and may be."""
    head = f"{target.ours} against {target.peer}"
    limit = f"limit {1.0 / target.times:,g}"
    if math.isnan(ratio):
        return f"{head}: not measured, {limit}"
    outcome = "met" if ratio >= target.times else "not met"
    return (
        f"{head}: {times_text(1.0 / ratio)} times slower"
        f" (quartiles {times_text(1.0 / high)} to {times_text(1.0 / low)}), {limit}: {outcome}"
    )


def times_text(ratio: float) -> str:
    """Return a ratio with at least three digits."""
    return f"{ratio:,.0f}" if ratio >= 100 else f"{ratio:.3g}"


def time_text(nanoseconds: float) -> str:
    """Return a time in the largest unit in which it is at least 1."""
    unit, size = next((u for u in UNITS if nanoseconds >= 0.9995 * u[1]), UNITS[-1])
    return f"{nanoseconds / size:.3g} {unit}"


def as_json(items: Sequence[Item]) -> str:
    """Return all numbers as JSON, times in ns; null stands for a missing number."""
    return json.dumps(
        {"cores": os.cpu_count(), "items": [item_as_dict(item) for item in items]}, indent=1
    )


def item_as_dict(item: Item) -> dict[str, Any]:
    """Return one item as a dict for JSON."""
    return {
        "name": item.name,
        "what": item.what,
        "unit": item.unit,
        "contestants": [
            {
                "name": candidate.name,
                "why_not": candidate.why_not,
                "nanoseconds": numbers_or_none(candidate.quartiles())[0],
                "quartiles": numbers_or_none(candidate.quartiles())[1:],
                "rounds": candidate.times,
                "error": numbers_or_none([candidate.error])[0],
                "first_call_seconds": numbers_or_none([candidate.first_seconds])[0],
            }
            for candidate in item.candidates
        ],
        "targets": [
            {
                **target._asdict(),
                "ratio": numbers_or_none(item.ratios(target))[0],
                "ratio_quartiles": numbers_or_none(item.ratios(target))[1:],
                "reached": bool(item.ratios(target)[0] >= target.times),
            }
            for target in item.targets
        ],
    }


def numbers_or_none(values: Sequence[float]) -> list[float | None]:
    """Return the numbers, None in place of nan."""
    return [None if math.isnan(value) else value for value in values]
