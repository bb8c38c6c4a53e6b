"""What keys of branch scenes must fulfil."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from vibropipe.physics.effects import all_effects
from vibropipe.physics.exciter import ParameterError
from vibropipe.scenes.branch.keys import BOTH, CURVE, LINE, BranchScene
from vibropipe.scenes.keys.checks import (
    TIES,
    TOGETHER,
    Check,
    check_changes,
    check_shown,
    check_varied_supports,
)
from vibropipe.scenes.keys.parts import MAX_LINES
from vibropipe.scenes.keys.problems import Problem, argument_path, refused, required
from vibropipe.scenes.keys.proofs import check_prove_rows
from vibropipe.scenes.keys.values import is_allowed
from vibropipe.words.bifurcations import BESIDE_LAW, without_slope
from vibropipe.words.parameters import DEFAULTS, PARAMETERS, RIGID_AT_ZERO, SOFT_ALONG
from vibropipe.words.records import FINITE


def _parameters(scene: BranchScene) -> Iterator[Problem]:
    """Check that followed and swept values are in range and that no parameter is given twice."""
    name = scene.followed
    stated = scene.exciter.explicit()
    yield from _law(scene)
    keyed = [("to", value) for value in scene.ends.to]
    keyed += [("within", value) for value in scene.ends.within or ()]
    keyed += [("from", scene.ends.begin)] if scene.ends.begin is not None else []
    for key, value in keyed:
        if name in PARAMETERS and not is_allowed(name, value):
            yield Problem(("along", name, key), repr(value), PARAMETERS[name].range.text)
    begin, to = scene.ends.begin, scene.ends.to
    if begin in to or len(set(to)) < len(to):
        must = "must differ from `from` and from each other"
        yield Problem(("along", name, "to"), "", must=must)
    elif begin is not None and len(to) == 2 and not min(to) < begin < max(to):
        yield Problem(("along", name, "to"), "", must="must have `from` between its two values")
    if name in RIGID_AT_ZERO and 0.0 in scene.ends.values:
        yield Problem(("along", name), "0", must=SOFT_ALONG)
    for swept, grid in scene.over.items():
        is_own = swept not in PARAMETERS
        if not (is_own or (is_allowed(swept, grid.low) and is_allowed(swept, grid.high))):
            yield Problem(("over", swept), repr(grid.low), PARAMETERS[swept].range.text)
        if grid.size > MAX_LINES:
            must = f"must have at most {MAX_LINES} values"
            yield Problem(("over", swept), f"{grid.size} values", must=must)
    if name in scene.over:
        yield Problem(("over", name), "", must=f"must be left out, since {name} is followed")
    for other in (name, *map(str, scene.over)):
        if other in stated:
            must = f"must be left out, since it stands in {'along' if other == name else 'over'}"
            yield Problem(("exciter", other), repr(stated[other]), must=must)


def _law(scene: BranchScene) -> Iterator[Problem]:
    """Check that a law stands beside a range and alone, and that a branch without one begins and ends somewhere."""
    name, ends = scene.followed, scene.ends
    stated = [
        key for key, value in (("from", ends.begin), ("to", ends.to or None)) if value is not None
    ]
    if scene.law is None:
        if ends.within is not None:
            must = "must be left out without law: write from and to"
            yield Problem(("along", name, "within"), "", must=must)
            return
        for key in ("from", "to"):
            if key not in stated:
                limits = PARAMETERS[name].range if name in PARAMETERS else FINITE
                yield required(("along", name, key), limits.text)
        if name not in PARAMETERS and len(ends.to) > 1:
            must = "must be one number: a name of one's own is followed one way"
            yield Problem(("along", name, "to"), "", must=must)
        return
    for key in stated:
        yield Problem(("along", name, key), "", must="must be left out beside law: write within")
    if ends.within is None:
        yield required(("along", name, "within"), "two increasing numbers")
    elif not ends.within[0] < ends.within[1]:
        yield Problem(("along", name, "within"), "", "two increasing numbers")
    for key in ("start", "switch"):
        if key in scene.model_fields_set:
            yield Problem((key,), "", must=BESIDE_LAW)


def _exciter(scene: BranchScene) -> Iterator[Problem]:
    """Check that the first orbits have supports and a start between them, and effects that can be computed."""
    varied: list[dict[str, float]] = [
        {str(name): value} for name, grid in scene.over.items() for value in (grid.low, grid.high)
    ] or [{}]
    changes = [
        {
            n: v
            for n, v in (each | scene.tied_at(scene.first_values() | each)).items()
            if n in PARAMETERS
        }
        for each in varied
    ]
    problems = list(check_changes(scene, [scene.followed], changes))
    problems = problems or list(_tied(scene))
    yield from problems
    if problems:
        return
    try:
        all_effects(scene.extent(), pieces=True, housing=True)
    except ParameterError as error:
        yield refused(("exciter", error.name), error)
        return
    varied_names = {scene.followed, *scene.tied().following([scene.followed])}
    lows = {name: np.min(v) for name, v in scene.extent().items() if name in varied_names}
    yield from check_varied_supports(scene, "along", lows)


def _tied(scene: BranchScene) -> Iterator[Problem]:
    """Check that what is tied is in range at all values of what varies."""
    values = {**DEFAULTS, **scene.resolved_exciter(), **scene.sampled()}
    try:
        scene.tied().checked(values)
    except ParameterError as error:
        yield refused(argument_path(error), error)


def _at(scene: BranchScene) -> Iterator[Problem]:
    """Check that points are wanted between the ends."""
    ends = scene.ends.values
    if scene.at is not None and not min(ends) <= scene.at.low <= scene.at.high <= max(ends):
        if scene.mass_and_stiffness is None:
            allowed = f"values from {min(ends)!r} to {max(ends)!r}"
            yield Problem(("at",), f"{scene.at.low!r} to {scene.at.high!r}", allowed)
        else:  # the numbers here are not those that were written
            yield Problem(("at",), "", must="must have values between the ends of `along`")


def _tolerance(scene: BranchScene) -> Iterator[Problem]:
    """Check that parameters scatter by which the place of a bifurcation has a derivative."""
    if not scene.has_l():
        return
    values = scene.extent()
    missing = without_slope(values, scene.followed)
    for name in scene.tolerance:
        if name in missing:
            yield Problem(("tolerance", name), "", must=missing[name])


def _yield(scene: BranchScene) -> Iterator[Problem]:
    """Check that bounds are of what each part has, as `vibropipe.branch` does."""
    if scene.subject_to is None:
        return
    from vibropipe.solve.branch.point_yields import check_bounds

    tolerance = {str(name): each for name, each in scene.tolerance.items()}
    varied = (scene.followed, *map(str, scene.over), *scene.tied().parameters)
    try:
        check_bounds(scene.resolved_exciter(), varied, scene.subject_to, tolerance)
    except ParameterError as error:
        is_own = error.name.split(".")[0] in ("subject_to", "tolerance")
        yield refused(argument_path(error) if is_own else ("exciter", error.name), error)


def _motor(scene: BranchScene) -> Iterator[Problem]:
    """Check that a motor has one torque at each speed, and drives branches along the frequency alone."""
    if scene.motor is None:
        if "motor" in scene.figure.pictures:
            must = "must leave out motor unless the scene has the key motor"
            yield Problem(("figure", "pictures"), "'motor'", must=must)
        return
    stated = [name for name in (*LINE, *CURVE) if getattr(scene.motor, name) is not None]
    if not stated:
        yield required(("motor",), BOTH)
        return
    own, others = (LINE, CURVE) if stated[0] in LINE else (CURVE, LINE)
    for name in own:
        if name not in stated:
            yield required(("motor", name), BOTH)
    for name in others:
        if name in stated:
            must = f"must be left out beside {stated[0]}: a motor has {BOTH}"
            yield Problem(("motor", name), "", must=must)
    speeds, torques = scene.motor.speed or [], scene.motor.torque or []
    if own == CURVE and len(stated) == len(own) and len(speeds) != len(torques):
        yield Problem(
            ("motor", "torque"), f"{len(torques)} values", f"{len(speeds)}, one for each speed"
        )
    if scene.followed != "nu":
        must = "must be left out unless the frequency is followed, which a motor turns with"
        yield Problem(("motor",), "", must=must)
    if scene.tolerance:
        must = "must be left out beside motor: speeds and jumps have no scatter"
        yield Problem(("tolerance",), "", must=must)


CHECKS = (
    TIES,
    TOGETHER,
    Check((("along",), ("over",), ("law",), ("start",), ("switch",)), _parameters),
    Check((("along",), ("over",), ("exciter",), ("start",)), _exciter),
    Check((("along",), ("at",)), _at),
    Check((("along",), ("tolerance",), ("motor",), ("figure", "pictures")), _motor),
    Check((("along",), ("over",), ("exciter",), ("tolerance",)), _tolerance),
    Check((("along",), ("over",), ("exciter",), ("tolerance",), ("subject_to",)), _yield),
    Check((("along",), ("over",), ("exciter",), ("prove",)), check_prove_rows),
    Check(
        (("along",), ("over",), ("exciter",), ("figure", "show")),
        lambda scene: check_shown(scene.figure.show, scene.extent()),
    ),
)
