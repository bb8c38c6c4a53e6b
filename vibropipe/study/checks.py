"""Rules that tie keys of a study together; a rule is skipped if a key that it reads is already reported."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import replace

from vibropipe.scenes.keys.base import drawn_by_others
from vibropipe.scenes.keys.problems import REQUIRED, KeyPath, Problem
from vibropipe.scenes.registry import kind_of
from vibropipe.study.models import Hero, ReportTable, Study
from vibropipe.words.spelling import did_you_mean
from vibropipe.words.wording import count


def check_study(study: Study, broken: frozenset[KeyPath]) -> Iterator[Problem]:
    """Check the rules of all scenes.

    study : a study whose single keys are valid
    broken : paths of keys that are already reported
    Yields every further fault.
    """
    shared = {path[1:] for path in broken if path[:1] == ("exciter",) and len(path) > 1}
    faulty = {str(path[1]) for path in broken if path[:1] == ("scenes",) and len(path) == 2}
    for name, scene in study.scenes.items():
        own = {path[2:] for path in broken if path[:2] == ("scenes", name)}
        own |= {("exciter", *path) for path in shared if path[0] not in scene.exciter.explicit()}
        kind = kind_of(scene)
        own_problems = [
            problem
            for reads, problems in kind.checks
            if not any(_meets(path, keys) for path in own for keys in reads)
            for problem in problems(scene)
        ]
        for problem in (*own_problems, *kind.check_among(scene, study.scenes, faulty)):
            is_there = any(path[: len(problem.path)] == problem.path for path in own)
            if not (is_there and problem.must.startswith(REQUIRED)):
                yield replace(problem, path=("scenes", name, *problem.path))
    if study.table is not None and not any(path[:1] == ("table",) for path in broken):
        yield from _check_table(study.table)
    if study.hero is not None and not any(path[:1] == ("hero",) for path in broken):
        yield from _check_hero(study, study.hero, faulty)


def _check_table(table: ReportTable) -> Iterator[Problem]:
    """Check that each row of a table has as many cells as its head."""
    for number, row in enumerate(table.rows):
        if len(row) != len(table.head):
            must = f"must have a text for each of the {count(len(table.head), 'column')}"
            yield Problem(("table", "rows", number), count(len(row), "text"), must=must)


def _check_hero(study: Study, hero: Hero, faulty: Collection[str]) -> Iterator[Problem]:
    """Check that the picture on page 1 is drawn by a scene of the study."""
    if hero.scene in faulty:
        return
    if hero.scene not in study.scenes:
        allowed = f"a scene of the study ({', '.join(study.scenes)})"
        hint = did_you_mean(hero.scene, study.scenes)
        yield Problem(("hero", "scene"), repr(hero.scene), allowed, hint)
        return
    if hero.scene in drawn_by_others(study.scenes):
        must = "must name a scene with a picture of its own, not one that another draws together with itself"
        yield Problem(("hero", "scene"), repr(hero.scene), must=must)
        return
    drawn = study.scenes[hero.scene].figure.chosen()
    if hero.picture is not None and hero.picture not in drawn:
        key = f"scenes.{hero.scene}.figure.pictures"
        found, hint = repr(hero.picture), did_you_mean(hero.picture, drawn)
        if drawn:
            allowed = f"one of the pictures in {key} ({', '.join(drawn)})"
            yield Problem(("hero", "picture"), found, allowed, hint)
        else:
            yield Problem(("hero", "picture"), found, must=f"must be left out, or in {key}")


def _meets(path: KeyPath, keys: KeyPath) -> bool:
    """Return whether one of two paths contains the other."""
    length = min(len(path), len(keys))
    return path[:length] == keys[:length]
