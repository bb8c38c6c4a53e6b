"""Faults told in the words of the file: misspelt keys, and faults of a study with units."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable
from dataclasses import replace
from typing import Any

from vibropipe.physics.si import NO_HOUSING, WITHOUT_MASS
from vibropipe.scenes.keys.problems import KeyPath, Problem, describe, unknown
from vibropipe.scenes.keys.values import UnitRule
from vibropipe.study.key_text import entry, quoted
from vibropipe.study.quantities import (
    GOALS,
    KEYS,
    MEASURED,
    NAMES,
    QUANTITIES,
    RAMP,
    VARIED,
    WRITTEN,
)
from vibropipe.words.parameters import PARAMETERS
from vibropipe.words.records import POSITIVE
from vibropipe.words.spelling import nearest
from vibropipe.words.vocabulary import PHYSICAL_NAMES, PLACES


def without_slips(
    tree: dict[str, Any], known: Collection[str]
) -> tuple[dict[str, Any], list[Problem]]:
    """Return a tree under the keys that were meant, and the fault of each misspelt one.

    What follows then finds only faults that a misspelt key does not explain: without `physical`, every unit is one.
    """
    renamed = dict(tree)
    problems = []
    for key in tree:
        meant = None if key in known else nearest(key, known)
        if meant is not None and meant not in renamed:
            renamed[meant] = renamed.pop(key)
            problems.append(unknown((key,), list(known)))
    return renamed, problems


# Parameters in messages: those that are no other word, and a list of all.
_NAMES = re.compile(r"\b(?:[kh][12]|mass_ratio)\b|\bnu(?: or \w+)+")
# Keys of `physical` that call for others, or that some kinds of scenes refuse.
OF_HOUSING = ("M", "D1", "D2", "P")
OF_OTHERS = ("H1", "H2", *OF_HOUSING)


def both_paths(paths: Iterable[KeyPath]) -> frozenset[KeyPath]:
    """Return paths as in the file and as in the tree without units."""
    written = list(paths)
    return frozenset(
        [*written, *(_renamed(path, "physical", "exciter", NAMES) for path in written)]
    )


def as_written(problem: Problem, tree: dict[str, Any], plain: dict[str, Any]) -> Problem:
    """Return a fault of the tree without units, `plain`, as one of the tree of the file: its path and its values."""
    path = _renamed(problem.path, "exciter", "physical", WRITTEN)
    name, in_physical = str(path[-1]), path[-2:-1] == ("physical",)
    if in_physical and name in PARAMETERS.keys() - WRITTEN.keys():
        return replace(problem, path=path, hint=f"{name} has no units: it stands under exciter")
    is_quantity = len(path) > 1 and name in QUANTITIES and path[-2] in KEYS
    if is_quantity and problem.must.startswith("is required ("):
        of_ramp = path[-3:-2] == (RAMP,)
        key = "tau_end" if name == "within" and of_ramp else str(path[-2])
        allowed = UnitRule(key, *KEYS[key]).allowed
        both = "a pair [low, high], each " if name == "within" and not of_ramp else ""
        return replace(problem, path=path, must=f"is required ({both}{allowed})")
    if path[-2:-1] == ("exciter",) and name not in PARAMETERS:
        return unknown(path, [each for each in PARAMETERS if each not in WRITTEN])
    goal = entry(tree, path) if len(path) > 3 and path[2] in GOALS else None
    if problem.found and isinstance(goal, str):
        return replace(problem, path=path, found=describe(goal))
    found = quoted(problem.found, entry(plain, problem.path), entry(tree, path))
    problem = replace(problem, found=found)
    if path[-2:-1] == ("tolerance",) and name in NAMES and problem.allowed == POSITIVE.text:
        return replace(problem, path=path, allowed=UnitRule(name, KEYS[name][0], POSITIVE).allowed)
    if path == problem.path or not in_physical:
        return replace(problem, path=path, must=_NAMES.sub(_renamed_part, problem.must))
    number, quantity = PARAMETERS[NAMES[name]].range.text, UnitRule(name).allowed
    allowed, must = (text.replace(number, quantity) for text in (problem.allowed, problem.must))
    if name in OF_OTHERS:  # its value may be the study's
        given = entry(tree, path) or entry(tree, path[-2:])
        problem = replace(problem, found=describe(given) if given else problem.found)
    if name in OF_HOUSING:
        must = must.replace(NO_HOUSING, WITHOUT_MASS).replace("must be 0:", "must be left out:")
    return replace(problem, path=path, allowed=allowed, must=_NAMES.sub(_renamed_part, must))


def _renamed_part(match: re.Match[str]) -> str:
    """Return the parameters in a part of a message by their names with units."""
    return " or ".join(WRITTEN.get(name, name) for name in match[0].split(" or "))


def _renamed(path: KeyPath, owner: str, new_owner: str, names: dict[str, str]) -> KeyPath:
    """Return a path with the names of parameters changed beneath `owner`, which is renamed, `over` and `along`."""
    first = 2 if path[:1] == ("scenes",) else 0
    steps = list(path)
    for index in range(first, len(steps) - 1):
        step, key = steps[index], steps[index + 1]
        if step in GOALS and owner == "exciter":
            steps[index + 1] = PHYSICAL_NAMES[str(key)] if key in PLACES else key
        if step in (owner, *VARIED, MEASURED) and key in names:
            steps[index] = new_owner if step == owner else step
            steps[index + 1] = names[str(key)]
            break
    return tuple(steps)
