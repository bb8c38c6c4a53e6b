"""Tables in files of their own: CSV files that scenes name are read into the study, beside which they lie.

What follows knows tables only: a change of a file is one of the scene. The text of a study in a dataset has the files
that were read at its end, as comments.
"""

from __future__ import annotations

import csv
import errno
import math
import os
import re
from pathlib import Path
from typing import Any

from vibropipe.scenes.keys.problems import KeyPath, Problem, describe
from vibropipe.scenes.keys.values import as_number
from vibropipe.solve.design.goals import CURVE
from vibropipe.words.sensors import RECORD, TAU, TIME, name_and_unit
from vibropipe.words.spelling import latin
from vibropipe.words.units import UnitError, to_si

PHASE = "phase"
# Heads of a column of times, which a phase stands in for in a wanted curve, and of a phase in other words.
TIMES = (TIME, "t", TAU)
_PHASES = re.compile(r"(?:phase|angle|phi|theta)(?![^\W_]).*", re.IGNORECASE)
# Begins a file at the end of a study's text.
MARK = "# file "
MAX_LINES = 100_000


class Files:
    """Text files by their paths: those in a folder, or those at the end of a study's text.

    whole : the text that has them at its end; empty of those in a folder
    read : texts of the files that were read
    """

    def __init__(self, folder: Path | None, text: str = "") -> None:
        self.folder, self.whole, self.read = folder, text, dict[str, str]()
        self.given: dict[str, list[str]] = {}
        name = None
        for line in text.splitlines():
            if line.startswith(MARK):
                name = line.removeprefix(MARK)
                self.given[name] = []
            elif name is not None:
                self.given[name].append(line.removeprefix("# "))

    def text(self, name: str) -> str:
        """Return the text of a file; OSError or UnicodeDecodeError if it cannot be read."""
        if self.folder is not None:
            self.read[name] = (self.folder / name).read_text(encoding="utf-8-sig")
        elif name in self.given:
            self.read[name] = "\n".join(self.given[name])
        else:
            raise OSError(errno.ENOENT, os.strerror(errno.ENOENT))
        return self.read[name]

    def after(self, text: str) -> str:
        """Return the text of a study with the files that were read at its end."""
        for name, content in self.read.items():
            lines = [f"# {line}" for line in content.splitlines()]
            text = "\n".join([text.rstrip("\n"), MARK + name, *lines, ""])
        return text


def with_tables(tree: dict[str, Any], files: Files) -> tuple[dict[str, Any], list[Problem]]:
    """Return a study's tree, keys in Latin letters, with the tables of its CSV files, and the faults of these."""
    scenes, problems = tree.get("scenes"), list[Problem]()
    if not isinstance(scenes, dict):
        return tree, problems
    read: dict[str, Any] = {}
    for name, scene in scenes.items():
        read[name] = scene
        if not isinstance(scene, dict):
            continue
        read[name] = scene = dict(scene)
        if isinstance(scene.get("measured"), str):
            table = _read(files, scene["measured"], ("scenes", name, "measured"), problems)
            scene["measured"] = table
        target = scene.get("target")
        if isinstance(target, dict) and isinstance(target.get(CURVE), str):
            path = ("scenes", name, "target", CURVE)
            table = _read(files, target[CURVE], path, problems, (PHASE, CURVE))
            pairs = zip(table.get(PHASE, []), table.get(CURVE, []), strict=True)
            scene["target"] = {**target, CURVE: [list(pair) for pair in pairs]}
    return {**tree, "scenes": read}, problems


def _read(
    files: Files, name: str, path: KeyPath, problems: list[Problem], wanted: tuple[str, ...] = ()
) -> dict[str, list[Any]]:
    """Return the columns of a CSV file, numbers or, under a head with a unit, text with that unit; {} with faults."""
    try:
        lines = files.text(name).splitlines()
    except (OSError, UnicodeDecodeError, ValueError) as error:
        why = error.strerror if isinstance(error, OSError) and error.strerror else "no UTF-8 text"
        must = "must be a table, or the path of a CSV file from the folder of the study"
        problems.append(Problem(path, describe(name), hint=why, must=must))
        return {}
    kept = [n for n, line in enumerate(lines) if line.strip() and not line.startswith("#")]
    head = lines[kept[0]] if kept else ""
    mark = next((mark for mark in ";\t" if mark in head), ",")
    rows = list(csv.reader([lines[n] for n in kept], delimiter=mark))
    heads = [name_and_unit(cell) for cell in rows[0]] if rows else []
    names, units = [_column(name) for name, _unit in heads], [unit for _name, unit in heads]
    parts = zip(names, units, rows[0] if rows else (), strict=True)
    faults = [text for each in parts if (text := _head_fault(*each, bool(wanted)))]
    if faults:
        problems.append(Problem(path, f"{head!r} in {name}", must=faults[0]))
        return {}
    missing = [column for column in wanted if column not in names]
    if not 2 <= len(rows) <= MAX_LINES or "" in names or len({*names}) < len(names) or missing:
        columns = " and ".join(wanted) or "a name each"
        must = f"must have a line with the names of its columns ({columns}), then 1 to {MAX_LINES - 1} lines of numbers"
        found = f"{head!r} in {name}" if head else f"nothing in {name}"
        problems.append(Problem(path, found, must=must))
        return {}
    table: dict[str, list[Any]] = {column: [] for column in names}
    # A quoted cell may run over several lines: then lines and rows are not the same.
    for n, row in zip(kept[1:], rows[1:], strict=False):
        cells = [as_number(cell.strip()) for cell in row]
        if len(cells) != len(names) or None in cells:
            must = (
                f"must have {len(names)} numbers with a point in each line, separated by {mark!r}"
            )
            problems.append(
                Problem(path, f"{mark.join(row)!r} in line {n + 1} of {name}", must=must)
            )
            return {}
        for column, unit, cell in zip(names, units, cells, strict=True):
            if column == PHASE:
                table[column].append(_in_periods(cell, unit))
            else:
                table[column].append(f"{cell!r} {unit}" if unit else cell)
    return table


def _column(head: str) -> str:
    """Return the name of a column; phase, time and what sensors measure may have capitals, t is a time."""
    name = head.lower()
    if name == "t":
        return TIME
    return name if name in (PHASE, TAU, *RECORD) else str(latin(head))


def _head_fault(name: str, unit: str, head: str, is_curve: bool) -> str:
    """Return what must hold of the head of a column that cannot be read; empty if it can."""
    if name.lower() in TIMES and is_curve:
        return (
            f"must have {PHASE}, in forcing periods, in place of {name}: {name} after a rising zero of the force, over "
            "the forcing period"
        )
    try:
        is_phase = name == PHASE and _in_periods(0.0, unit) == 0.0
    except UnitError:
        is_phase = False
    if is_phase or not _PHASES.fullmatch(str(latin(head.strip()))):
        return ""
    return (
        f"must have {PHASE} in forcing periods, without a unit, or {PHASE} (deg) or {PHASE} (rad)"
    )


def _in_periods(value: float | None, unit: str) -> float:
    """Return a phase in forcing periods from one in an angle, or without a unit."""
    if unit.lower() in ("", "1", "-", "period", "periods"):
        return value or 0.0
    return to_si(f"{value!r} {unit}", "angle") / (2.0 * math.pi)
