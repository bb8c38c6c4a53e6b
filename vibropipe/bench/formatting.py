"""What was measured, as tables for a terminal or as JSON."""

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
    """A table of times for each item, and under it every ratio that is asked, reached or not."""
    return "\n\n".join(item_text(item) for item in items)


def item_text(item: Item) -> str:
    """The table of one item."""
    head = ("", f"time per {item.unit}", "quartiles", "error", "first call")
    lines = aligned([head, *(line(one) for one in item.contestants)])
    targets = [target_text(item, target) for target in item.targets]
    return "\n".join([f"{item.name}: {item.what}", *lines, *targets])


def line(one: Candidate) -> tuple[str, ...]:
    """One contestant as a line of the table."""
    if one.why_not is not None:
        return one.name, one.why_not, "", "", ""
    median, low, high = one.quartiles()
    error = "" if math.isnan(one.error) else f"{one.error:.0e}"
    spread = f"{time_text(low)} to {time_text(high)}"
    return one.name, time_text(median), spread, error, f"{one.first_seconds:.1f} s"


def target_text(item: Item, target: Target) -> str:
    """A ratio, what was asked and whether it is reached."""
    ratio, low, high = item.ratios(target)
    target_ratio = f"asked {target.times:,g}"
    if math.isnan(ratio):
        return f"{target.ours} against {target.peer}: not measured, {target_ratio}"
    outcome = "reached" if ratio >= target.times else "not reached"
    return (
        f"{target.ours} against {target.peer}: {times_text(ratio)} times cheaper"
        f" ({times_text(low)} to {times_text(high)}), {target_ratio}: {outcome}"
    )


def times_text(ratio: float) -> str:
    """A ratio with three digits at least."""
    return f"{ratio:,.0f}" if ratio >= 100 else f"{ratio:.3g}"


def time_text(nanoseconds: float) -> str:
    """A time with a unit that suits it."""
    unit, size = next((u for u in UNITS if nanoseconds >= 0.9995 * u[1]), UNITS[-1])
    return f"{nanoseconds / size:.3g} {unit}"


def as_json(items: Sequence[Item]) -> str:
    """The same with all numbers, times in nanoseconds; null where there is none."""
    return json.dumps(
        {"cores": os.cpu_count(), "items": [item_as_dict(item) for item in items]}, indent=1
    )


def item_as_dict(item: Item) -> dict[str, Any]:
    """One item as JSON can hold it."""
    return {
        "name": item.name,
        "what": item.what,
        "unit": item.unit,
        "contestants": [
            {
                "name": one.name,
                "why_not": one.why_not,
                "nanoseconds": numbers(one.quartiles())[0],
                "quartiles": numbers(one.quartiles())[1:],
                "rounds": one.times,
                "error": numbers([one.error])[0],
                "first_call_seconds": numbers([one.first_seconds])[0],
            }
            for one in item.contestants
        ],
        "targets": [
            {
                **target._asdict(),
                "ratio": numbers(item.ratios(target))[0],
                "ratio_quartiles": numbers(item.ratios(target))[1:],
                "reached": bool(item.ratios(target)[0] >= target.times),
            }
            for target in item.targets
        ],
    }


def numbers(values: Sequence[float]) -> list[float | None]:
    """Numbers, and None where there is none."""
    return [None if math.isnan(value) else value for value in values]
