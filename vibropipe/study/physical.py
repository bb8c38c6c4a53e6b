"""Studies with units: `physical` and every quantity with a unit, replaced by the numbers without units of eqs. (2)-(4).

What follows reads, checks and solves non-dimensional studies only. `as_written` gives later faults the paths and values
of the file again.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable
from dataclasses import replace
from typing import Any

from vibropipe.physics.si import BESIDE, NO_HOUSING, WITHIN_MASS, WITHOUT_MASS, non_dimensional
from vibropipe.scenes.keys.problems import KeyPath, Problem, describe, one_of, unknown
from vibropipe.scenes.keys.ties import own_names
from vibropipe.scenes.keys.values import UnitRule
from vibropipe.solve.with_units import plain_objectives
from vibropipe.study.key_text import entry, quoted
from vibropipe.study.quantities import (
    COLUMNS,
    GOALS,
    HIDDEN,
    KEYS,
    LEVELS,
    MEASURED,
    NAMES,
    ON_SLOPE,
    OTHERS,
    QUANTITIES,
    RAMP,
    STAND_IN,
    STAND_INS,
    SWEPT,
    TAKEN,
    TOGETHER,
    VARIED,
    VARIES,
    WRITTEN,
    QuantityReader,
    last_key,
    si_of,
)
from vibropipe.words.parameters import PARAMETERS, PHYSICAL, STARTS
from vibropipe.words.records import POSITIVE
from vibropipe.words.spelling import nearest
from vibropipe.words.vocabulary import PHYSICAL_NAMES, PLACES, PLACES_IN_SI

# Parameters in messages: those that are no other word, and a list of all.
_NAMES = re.compile(r"\b(?:[kh][12]|mass_ratio)\b|\bnu(?: or \w+)+")
# Keys of `physical` that call for others, or that some kinds of scenes refuse.
OF_HOUSING = ("M", "D1", "D2", "P")
OF_OTHERS = ("H1", "H2", *OF_HOUSING)


def without_units(tree: dict[str, Any]) -> tuple[dict[str, Any], list[Problem]]:
    """Return a study's tree without units, and the faults of its quantities; one without `physical` is unchanged.

    `physical` itself stays as it is: the models check it.
    """
    scenes = tree.get("scenes")
    named = scenes if isinstance(scenes, dict) else {}
    if not is_physical(tree):
        must = "must be left out, since the study has no physical with m and C"
        paths: list[KeyPath] = [("units",)] if "units" in tree else []
        paths += [
            ("scenes", name, "physical")
            for name, scene in named.items()
            if isinstance(scene, dict) and "physical" in scene
        ]
        return tree, [Problem(path, "", must=must) for path in paths if "physical" not in tree]
    reader = _Reader(tree)
    plain = {**tree, "exciter": reader.exciter(tree, ())}
    if named:
        plain["scenes"] = {
            name: reader.scene(scene, ("scenes", name)) if isinstance(scene, dict) else scene
            for name, scene in named.items()
        }
    return plain, reader.problems


def is_physical(tree: dict[str, Any]) -> bool:
    """Return whether a study's tree has a mapping `physical`."""
    return isinstance(tree.get("physical"), dict)


def _varied_by(scene: dict[str, Any], name: str) -> list[str]:
    """Return the keys of a scene under which a parameter varies."""
    return [key for key in VARIES if isinstance(scene.get(key), dict) and name in scene[key]]


class _Reader(QuantityReader):
    """Reads the quantities of one study and lists their faults."""

    def __init__(self, tree: dict[str, Any]) -> None:
        super().__init__(tree)
        self.tree, self.own = tree, own_names(tree)

    def exciter(self, owner: dict[str, Any], path: KeyPath) -> Any:
        """Return the exciter of a study, a scene or a motion: its pure numbers, and what `physical` gives."""
        numbers, physical = owner.get("exciter", {}), owner.get("physical", {})
        if not isinstance(numbers, dict) or not isinstance(physical, dict):
            return numbers
        for name in WRITTEN.keys() & numbers.keys():
            must = f"must be left out: give {WRITTEN[name]} with its unit in physical"
            self.refuse((*path, "exciter", name), numbers[name], must=must)
        if "gravity" in physical and "slope" not in physical:
            must = BESIDE.format("slope")
            self.refuse((*path, "physical", "gravity"), physical["gravity"], must=must)
        beside = {**self.above(path), **physical}
        for name, other in (("m_e", "e"), ("e", "m_e")):
            if name in physical and other not in beside:
                self.refuse((*path, "physical", name), physical[name], must=BESIDE.format(other))
        own, whole = si_of("m_e", physical.get("m_e")), si_of("m", self.tree["physical"].get("m"))
        if own is not None and whole is not None and own > whole:
            self.refuse((*path, "physical", "m_e"), physical["m_e"], must=WITHIN_MASS)
        read = {name: si_of(name, value) for name, value in physical.items() if name in TAKEN}
        si = {name: STAND_IN if value is None else value for name, value in read.items()}
        given = non_dimensional({**self.units, **si})
        above = self.above(path)
        for caller, (names, makes) in TOGETHER.items():
            if caller not in {**above, **physical} or names.isdisjoint(physical):
                continue
            # Gravity pulls at the masses, and beside the forces, that stand here or above.
            read = {name: si_of(name, above[name]) for name in names & above.keys()}
            others = {name: STAND_IN if value is None else value for name, value in read.items()}
            together = non_dimensional({**self.units, **others, **si})
            given |= {name: together[name] for name in makes if name in together}
        return {name: value for name, value in numbers.items() if name not in WRITTEN} | given

    def above(self, path: KeyPath) -> dict[str, Any]:
        """Return `physical` of all that a scene or a motion is within."""
        node: Any = self.tree
        physical = dict(self.tree["physical"]) if path else {}
        for key in path[:-1]:
            node = node[key]
            own = node.get("physical", {})
            physical |= own if isinstance(own, dict) else {}
        return physical

    def scene(self, scene: dict[str, Any], path: KeyPath) -> dict[str, Any]:
        """Return a scene without units."""
        over, physical, follow, along, vary, ramp = (
            scene.get(key) for key in ("over", "physical", "follow", "along", "vary", RAMP)
        )
        verbs = ((over, "swept"), (along, "followed"), (vary, "varied"), (ramp, "changed by ramp"))
        for varied, verb in verbs:
            if isinstance(varied, dict) and isinstance(physical, dict):
                by = {part: name for name in HIDDEN.keys() & varied.keys() for part in HIDDEN[name]}
                for name in sorted(physical.keys() & (varied.keys() | by.keys())):
                    must = f"must be left out, since {by.get(name, name)} is {verb}"
                    self.refuse((*path, "physical", name), physical[name], must=must)
        beside = {**self.above(path), **(physical if isinstance(physical, dict) else {})}
        for key in VARIED if "slope" in beside and si_of("slope", beside["slope"]) != 0.0 else ():
            varied = scene.get(key)
            if isinstance(varied, dict):
                refused = ON_SLOPE.keys() if key in VARIES else {"M"}
                for name in sorted(refused & varied.keys()):
                    self.refuse((*path, key, name), varied[name], must=ON_SLOPE[name])
        if isinstance(over, dict) and isinstance(follow, dict) and "along" in follow:
            swept = follow["along"]
            if swept not in over:
                allowed = f"a swept parameter ({', '.join(over)})"
                self.refuse((*path, "follow", "along"), swept, allowed)
        plain = self.mapping(scene, path)
        if isinstance(plain.get("exciter"), dict):
            # A slope or an unbalance beside what it is a share of is refused above, by its own name.
            told = {n for _, made in TOGETHER.values() for n in made if _varied_by(plain, n)}
            plain["exciter"] = {n: v for n, v in plain["exciter"].items() if n not in told}
        followed = next(iter(along), None) if isinstance(along, dict) else None
        if followed in KEYS and "at" in scene:
            plain["at"] = self.quantity(str(followed), scene["at"], (*path, "at"))
        return plain

    def mapping(self, node: dict[str, Any], path: KeyPath) -> dict[str, Any]:
        """Return a mapping without units; quantities are known by their keys."""
        plain: dict[str, Any] = {}
        for key, value in node.items():
            if key in GOALS and isinstance(value, dict):
                names = COLUMNS if key == MEASURED else PLACES_IN_SI
                plain[key] = {
                    names.get(name, name): self.goal(name, v, (*path, key, name))
                    for name, v in value.items()
                }
            elif key == "minimise":
                plain[key] = plain_objectives(value)
            elif key == LEVELS and isinstance(value, list):
                plain[key] = [
                    {name: self.level(name, v, (*path, key, n, name)) for name, v in each.items()}
                    if isinstance(each, dict)
                    else each
                    for n, each in enumerate(value)
                ]
            elif (own := last_key(path)) in VARIED and key not in (*SWEPT, *STARTS, *self.own):
                hint = f"with its unit, {key} is {WRITTEN[key]}" if key in WRITTEN else ""
                problem = unknown((*path, key), SWEPT)
                if key in PHYSICAL:
                    must = f"has one value, under `physical`, and does not vary; must be {one_of(SWEPT)}"
                    problem = replace(problem, must=must, hint="")
                self.problems.append(replace(problem, hint=hint or problem.hint))
                plain.setdefault("nu", STAND_INS[own])
            elif key in KEYS and key not in OTHERS:
                plain[NAMES.get(key, key)] = self.quantity(key, value, (*path, key))
                if key == "M" and own in ("tolerance", "within"):
                    plain[NAMES[key]] = self.deviation(plain[NAMES[key]], path)
            elif key == "along" and isinstance(value, str):
                plain[key] = NAMES.get(value, value)
            elif isinstance(value, dict) and key not in OTHERS:
                is_named = key == "motions"
                plain[key] = {
                    name: self.mapping(entry, (*path, key, name))
                    if isinstance(entry, dict)
                    else entry
                    for name, entry in value.items()
                } if is_named else self.mapping(value, (*path, key))  # fmt: skip
            else:
                plain[key] = value
        if "exciter" in node or "physical" in node:
            plain["exciter"] = self.exciter(node, path)
        return plain

    def deviation(self, ratio: float, path: KeyPath) -> float:
        """Return a small change of the ratio m/M, of first order, from m over the change of M."""
        scene: Any = self.tree
        for key in path[:-1]:
            scene = scene[key]
        varied = _varied_by(scene, "M")
        M = None if varied else si_of("M", self.above(path).get("M"))
        if M is None:
            beside = f"beside {varied[0]}.M" if varied else "without physical.M"
            must = f"must be left out {beside}: what M may be off is that of one M"
            self.refuse((*path, "M"), scene[path[-1]]["M"], must=must)
            return STAND_IN
        return (self.units["m"] / M) ** 2 / ratio


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
