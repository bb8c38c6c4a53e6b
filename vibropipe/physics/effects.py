"""Effects: what of the physics a scene calls for, as types, so that an absent branch is never compiled.

Each field is 1 (present) or None (absent). numba types None at compile time, so `if effects.forcing is not
None` costs nothing where forcing is absent: the branch is not in the machine code, and every set of effects
is cached on disk like any other signature.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from vibropipe.physics.bounds import ROUNDING, largest_force, state_norm_bound
from vibropipe.physics.exciter import ParameterError
from vibropipe.words.effects import EFFECT_NAMES

# The bit of each support in `Effects.watched`.
WATCHED = {"support_1": 1, "support_2": 2}


class Effects(NamedTuple):
    """Presence of each physical effect: 1 or None.

    watched: supports that were left out though nothing proves them out of reach, 1, 2 or 3 for both; they
    are marched as present, and the march stops where it meets one. None where there are none.
    """

    damping: int | None = 1
    forcing: int | None = 1
    support_1: int | None = 1
    support_2: int | None = 1
    restitution: int | None = 1
    rest: int | None = 1
    watched: int | None = None


ALL_EFFECTS = Effects()


def effect_names(effects: Effects) -> tuple[str, ...]:
    """Return the names of the effects that are present, in the order of EFFECT_NAMES; watched supports are not."""
    watched = effects.watched or 0
    return tuple(
        name
        for name in EFFECT_NAMES
        if getattr(effects, name) is not None and not watched & WATCHED.get(name, 0)
    )


def effects_from_names(names: Iterable[str]) -> Effects:
    """Return effects by name, or raise a ParameterError for a name that is none of EFFECT_NAMES."""
    chosen = set(names)
    for name in chosen - set(EFFECT_NAMES):
        raise ParameterError(
            "effects", names, must=f"must be among {', '.join(EFFECT_NAMES)}", got=repr(name)
        )
    return Effects(*(1 if name in chosen else None for name in EFFECT_NAMES))


def effects_of(
    values: Mapping[str, Any],
    x: float,
    v: float,
    span: float = math.inf,
    *,
    exact: bool = True,
    followed: bool = False,
    left_out: Sequence[str] = (),
) -> Effects:
    """What the exciters over the grid of `values` (parameter name -> its values) call for, from (x, v).

    span: how long the motions last; exact: solved by the exact method (the bounds are not proven for
    Newmark's, whose supports all count as reached); followed: rows start where their neighbours settled;
    left_out: supports that a user leaves out: they are watched where nothing keeps the motion from them.

    The union over all rows: damping where h > 0, forcing where f != 0, a support unless `state_norm_bound`
    keeps every motion from it, restitution where R < 1 on a support reached, rest where the force can
    press the mass on a support reached, |f| >= its pull towards the equilibrium.
    """
    p = {name: np.atleast_1d(np.asarray(array, float)) for name, array in values.items()}
    size = state_norm_bound(p, x, v, span, followed) if exact else math.inf
    force = largest_force(p)
    # Where the supports stand from the equilibrium, each at its nearest over the grid.
    places = {
        "support_1": p["l"].min() + p["delta"].min(),
        "support_2": p["l"].min() - p["delta"].max(),
    }
    met = {name for name, place in places.items() if not size * (1 + ROUNDING) < place}
    there = met - set(left_out)
    lossy = {name for name, R in (("support_1", "R1"), ("support_2", "R2")) if (p[R] < 1).any()}
    pressed = {name for name, place in places.items() if not force < place * (1 - ROUNDING)}
    present = ((p["h"] > 0).any(), force > 0, *(name in met for name in places))
    watched = sum(WATCHED[name] for name in met - there)
    called_for = (*present, there & lossy, there & pressed)
    effects = Effects(*(1 if is_so else None for is_so in called_for))
    return effects._replace(watched=watched or None)


def resolve_effects(
    names: Sequence[str] | None, values: Mapping[str, Any], *at: Any, **how: Any
) -> Effects:
    """The effects to compute with where a user states `names` of a grid of `values` (and what else
    `effects_of` takes); all effects where nothing is stated.

    A support left out that may be reached is watched. Raises ParameterError where the parameters call for
    another effect that was left out.
    """
    if names is None:
        return ALL_EFFECTS
    stated = effects_from_names(names)
    missing = missing_effect(names, values, *at, **how)
    if missing is not None:
        must, got = missing
        raise ParameterError("effects", names, must=must, got=got)
    derived = effects_of(values, *at, **how, left_out=absent_supports(names))
    marched = {name: 1 for name, bit in WATCHED.items() if (derived.watched or 0) & bit}
    return stated._replace(watched=derived.watched, **marched)


def absent_supports(names: Sequence[str]) -> tuple[str, ...]:
    """The supports that are not among the names."""
    return tuple(name for name in WATCHED if name not in names)


def missing_effect(
    names: Sequence[str], values: Mapping[str, Any], *at: Any, **how: Any
) -> tuple[str, str] | None:
    """Return what must hold and what is the case where `names` leave out an effect that is called for, else None.

    Example: ("must include forcing unless f = 0", "damping with f = 1.0").
    """
    derived = effects_of(values, *at, **how, left_out=absent_supports(names))
    called_for = [name for name in EFFECT_NAMES if getattr(derived, name) is not None]
    missing = [name for name in called_for if name not in (*names, *WATCHED)]
    if not missing:
        return None

    effect = missing[0]
    parameters, otherwise = {
        "damping": (["h"], "h = 0"),
        "forcing": (["f"], "f = 0"),
        "restitution": (["R1", "R2"], "R = 1 on the supports included"),
        "rest": (["f"], "|f| < l - |delta|"),
    }[effect]
    # what is farthest from an absent effect
    farthest = np.min if effect == "restitution" else np.max
    values_text = ", ".join(f"{q} = {float(farthest(np.abs(values[q])))!r}" for q in parameters)
    if effect == "rest":
        values_text = f"a force of {values_text} that can press the mass on a support"
    stated = ", ".join(names) or "no effects"
    return f"must include {effect} unless {otherwise}", f"{stated} with {values_text}"
