"""Columns of a record over time: what sensors measure, what tells the phase of the force, and heads with units."""

from __future__ import annotations

import re

# Names of the columns of a record and their physical dimensions; of a trigger, any number that rises.
SENSORS = {"displacement": "length", "velocity": "velocity", "acceleration": "acceleration"}
TRIGGERS = {"force": "force", "trigger": ""}
RECORD = {"time": "time", **SENSORS, **TRIGGERS}
TIME, TAU = "time", "tau"
# A name, and its unit in brackets or behind a stroke.
_HEAD = re.compile(r"\s*([^\s(\[/]+)\s*(?:/?\s*[(\[]\s*([^)\]]+?)\s*[)\]]|/\s*([^\s(\[]+))?\s*")


def name_and_unit(head: str) -> tuple[str, str]:
    """Return the name in the head of a column, and its unit; both empty if it cannot be read."""
    match = _HEAD.fullmatch(head)
    return (match[1], match[2] or match[3] or "") if match else ("", "")
