"""Rules that tie keys of a study together; a rule is skipped if a key that it reads is already reported."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from vibropipe.scenes.keys.problems import KeyPath, Problem
from vibropipe.scenes.registry import kind_of
from vibropipe.study.models import Study


def check_study(study: Study, broken: frozenset[KeyPath]) -> Iterator[Problem]:
    """Check the rules of all scenes.

    Parameters
    ----------
    study : Study
        A study whose single keys are valid.
    broken : frozenset of KeyPath
        Paths of keys that are already reported.

    Yields
    ------
    Problem
        Every further fault.
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
            yield replace(problem, path=("scenes", name, *problem.path))


def _meets(path: KeyPath, keys: KeyPath) -> bool:
    """Return whether one of two paths contains the other."""
    length = min(len(path), len(keys))
    return path[:length] == keys[:length]
