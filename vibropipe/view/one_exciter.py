"""One exciter in place of a study: its starts and what they settle on, solved when the page opens."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from vibropipe.physics.exciter import Exciter
from vibropipe.scenes.keys.problems import Problem, StudyError
from vibropipe.solve.basins.attractors import reachable_velocity
from vibropipe.solve.basins.basins import basins
from vibropipe.solve.physical import stored
from vibropipe.study import parse_study
from vibropipe.study.yaml_reader import read_file
from vibropipe.view.plane import Floats
from vibropipe.view.results import STUDY_ENDINGS, Results
from vibropipe.words.parameters import PHYSICAL
from vibropipe.words.progress import Progress
from vibropipe.words.spelling import latin
from vibropipe.words.units import MINUS

# Three motions coexist, one of them chaotic: what the page opens with where nothing is named.
EXAMPLE = "l=0.5 nu=3.48 f=0.7 h=0.1 delta=0.1 R1=0.8 R2=0.8"
SCENE, OPTION = "starts", "--exciter"
# Starts along each axis; with a housing that slides a start is solved by itself, which takes longer.
STARTS, STARTS_OF_HOUSING = 48, 24
_PAIR = re.compile(r"\s*,?\s*(\w+)\s*=\s*")


def tree_of_text(text: str) -> dict[str, Any]:
    """Return `name=value name=value ...` as a study's tree: with m and C what has units is under `physical`.

    Raises StudyError if the text has no such form, or a name twice.
    """
    before, *parts = _PAIR.split(text)
    names, values = [latin(name) for name in parts[::2]], [value.strip() for value in parts[1::2]]
    if before.strip() or not names or not all(values):
        allowed = f"names and values as in {EXAMPLE!r}"
        raise StudyError(OPTION, [Problem((), repr(text), allowed)])
    if len({*names}) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise StudyError(OPTION, [Problem((twice,), "", must="must be given once")])
    given = dict(zip(names, map(_value, values), strict=True))
    has_units = {"m", "C"} <= given.keys()
    physical = {name: value for name, value in given.items() if has_units and name in PHYSICAL}
    exciter = {name: value for name, value in given.items() if name not in physical}
    return {"title": text} | {
        key: part for key, part in (("physical", physical), ("exciter", exciter)) if part
    }


def _value(text: str) -> Any:
    try:
        return float(text.replace(MINUS, "-"))
    except ValueError:
        return text


def tree_of_file(path: Path) -> dict[str, Any] | None:
    """Return the tree of a YAML file that has an exciter and no scenes; None for any other path."""
    if path.suffix not in STUDY_ENDINGS or not path.is_file():
        return None
    tree, problems = read_file(path)
    if problems or not isinstance(tree, dict) or "scenes" in tree:
        return None  # the reader of studies says what is wrong
    return {"title": path.stem, **tree} if tree.keys() & {"exciter", "physical"} else None


def exciter_results(tree: dict[str, Any], source: str, progress: Progress | None = None) -> Results:
    """Solve the basins of the exciter of a tree without scenes, in the units of the tree.

    source : the option or the file, in messages
    progress : called as progress(done, total), in starts
    Raises StudyError with every fault of the exciter.
    """
    # the scene lends its rules to the exciter, and nothing else
    study = parse_study({**tree, "scenes": {SCENE: {"kind": "motion"}}}, "exciter", source)
    scene = study.scene(SCENE)
    values, ties = scene.resolved_exciter(), scene.tied()
    exciter = Exciter(**values)
    exciter = replace(exciter, **ties.checked(exciter.numbers()._asdict()))
    n = STARTS if exciter.mass_ratio == 0.0 else STARTS_OF_HOUSING
    x0, v0 = grid_of_starts(exciter, n, n)
    dataset = basins(exciter, x0, v0, progress=progress)
    if ties.texts:
        tied = "; ".join(f"{name} = {text}" for name, text in ties.texts.items())
        dataset = dataset.assign_attrs(ties=tied)
    dataset = stored(dataset, scene.mass_and_stiffness)
    return Results(study.title, study.shown({SCENE: dataset}, False), SCENE)


def grid_of_starts(exciter: Exciter, n_x: int, n_v: int) -> tuple[Floats, Floats]:
    """Return displacements from support to support, and velocities up to what the mass can reach."""
    velocity = reachable_velocity(exciter)
    return (np.linspace(exciter.lower, exciter.upper, n_x), np.linspace(-velocity, velocity, n_v))
