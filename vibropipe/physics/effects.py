"""Physical effects of a scene, as types: the code of an absent effect is never compiled.

Each field of `Effects` is 1 (present) or None (absent). numba resolves `effects.forcing is not None` at compile time,
so an absent branch is not in the machine code. Each set of effects is cached on disk like any other signature.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from vibropipe.physics.bounds import ROUNDING, largest_force, state_norm_bound
from vibropipe.physics.exciter import ParameterError
from vibropipe.words.effects import EFFECT_NAMES

# Effects without machine code of their own, and their parameters: a load is an offset of the supports.
BY_PARAMETER = {"load": "load"}
# The bit of each support in `Effects.watched`.
WATCHED = {"support_1": 1, "support_2": 2}
# The stiffness of each support, 0 where it is rigid.
STIFFNESS = {"support_1": "k1", "support_2": "k2"}


class Effects(NamedTuple):
    """Presence of each physical effect: 1 or None.

    watched : supports that are left out although no bound keeps the motion from them: 1, 2 or 3 for both, None for
    none. They are marched as present, and the march stops where it meets one.
    """

    damping: int | None = 1
    forcing: int | None = 1
    support_1: int | None = 1
    support_2: int | None = 1
    restitution: int | None = 1
    rest: int | None = 1
    soft: int | None = None
    friction: int | None = None
    second_harmonic: int | None = None
    watched: int | None = None

    @property
    def has_pieces(self) -> bool:
        """Whether motions are marched by pieces: with soft supports or friction."""
        return self.soft is not None or self.friction is not None


# The effects of eqs. (5), (6).
ALL_EFFECTS = Effects()

# Parameters of soft supports and friction, whose motions are marched by pieces.
PIECES = ("k1", "k2", "h1", "h2", "friction")
# Those of them that call for pieces by themselves.
CALL_FOR_PIECES = ("k1", "k2", "friction")
# Parameters whose effect is not computed, by any call or by all but a few, and what it is.
NOT_COMPUTED = {
    **dict.fromkeys(("k1", "k2", "h1", "h2"), "soft supports are"),
    "friction": "dry friction is",
}


def occurs(value: Any) -> bool:
    """Return whether a parameter, a number or an array, is other than 0 anywhere; one motion has numbers."""
    return value != 0.0 if isinstance(value, float) else bool(np.any(value))


def has_soft_support(values: Mapping[str, Any]) -> bool:
    """Return whether a support is soft anywhere; kernels with friction may have the effect without one."""
    return any(occurs(values.get(name, 0.0)) for name in STIFFNESS.values())


def all_effects(values: Mapping[str, Any], *, pieces: bool = False) -> Effects:
    """Return all effects of eqs. (5), (6), and those beyond that parameters have.

    pieces : whether the caller computes soft supports and friction; both are then added where the parameters have one,
    so that one kernel serves all such exciters.

    Raises
    ------
    ParameterError
        If the parameters have an effect that is not computed.
    """
    for name, effect in NOT_COMPUTED.items():
        if not (pieces and name in PIECES) and occurs(values.get(name, 0.0)):
            largest = float(np.abs(values[name]).max())
            must = f"must be 0: {effect} not computed {'by this version' if pieces else 'here'}"
            raise ParameterError(name, values[name], must=must, got=repr(largest))
    further = ALL_EFFECTS._replace(second_harmonic=1 if occurs(values.get("f2", 0.0)) else None)
    if any(occurs(values.get(name, 0.0)) for name in CALL_FOR_PIECES):
        return further._replace(soft=1, friction=1)
    return further


def check_first_harmonic(values: Mapping[str, Any]) -> None:
    """Raise a ParameterError where a second harmonic acts alone: every orbit is then twice the same."""
    if occurs(values.get("f2", 0.0)) and not occurs(values.get("f", 0.0)):
        must = "must not be 0 beside f2: a second harmonic alone is a first one, with 2 nu and f2"
        raise ParameterError("f", 0.0, must=must)


def effect_names(effects: Effects, values: Mapping[str, Any] | None = None) -> tuple[str, ...]:
    """Return the names of the effects that are present, in the order of EFFECT_NAMES, without watched supports.

    Effects without machine code of their own (`BY_PARAMETER`) are present where the parameters `values` have them.
    """
    watched = effects.watched or 0
    of_parameters = {
        name for name, key in BY_PARAMETER.items() if occurs((values or {}).get(key, 0.0))
    }
    return tuple(
        name
        for name in EFFECT_NAMES
        if name in of_parameters
        or (getattr(effects, name, None) is not None and not watched & WATCHED.get(name, 0))
    )


def all_effect_names(values: Mapping[str, Any], *, pieces: bool = False) -> tuple[str, ...]:
    """Return the names of `all_effects`."""
    return effect_names(all_effects(values, pieces=pieces), values)


def effects_from_names(names: Iterable[str]) -> Effects:
    """Return effects by name, or raise a ParameterError for a name that is none of EFFECT_NAMES."""
    chosen = set(names)
    for name in chosen - set(EFFECT_NAMES):
        raise ParameterError(
            "effects", names, must=f"must be among {', '.join(EFFECT_NAMES)}", got=repr(name)
        )
    marched = [name for name in EFFECT_NAMES if name not in BY_PARAMETER]
    return Effects(**{name: 1 if name in chosen else None for name in marched})


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
    """Return the effects that exciters over a grid need, the union over all rows.

    Damping is needed where h > 0, forcing where f != 0, a support unless `state_norm_bound` keeps every motion from it,
    restitution where R < 1 on a support reached, rest where the force can press the mass on a support reached, or
    friction hold it there, |f| + friction >= its pull towards the equilibrium, soft where a support reached has k > 0,
    friction where it is > 0.

    Parameters
    ----------
    values : mapping of str to array_like
        Values of each parameter over the grid.
    x, v : float
        Start; x is the displacement from the equilibrium.
    span : float
        Duration of the motions in tau.
    exact : bool
        Whether the exact method solves them. The bounds are not proven for Newmark's, whose supports all count as
        reached.
    followed : bool
        Whether rows start from the steady state of a neighbour.
    left_out : sequence of str
        Supports that the user leaves out; they are watched where no bound keeps the motion from them.

    Returns
    -------
    Effects

    Raises
    ------
    ParameterError
        If the parameters have an effect that is not computed.
    """
    further = all_effects(values, pieces=True)
    p = {name: np.atleast_1d(np.asarray(array, float)) for name, array in values.items()}
    # A constant load moves the equilibrium, from which x and the supports count.
    load = p.pop("load", np.zeros(1))
    offset = {"low": p["delta"].min() - load.max(), "high": p["delta"].max() - load.min()}
    p["delta"] = np.array([*offset.values()])
    bound = state_norm_bound(p, x, v, span, followed) if exact else math.inf
    force = largest_force(p)
    # Smallest distance of each support from the equilibrium over the grid.
    distances = {
        "support_1": p["l"].min() + offset["low"],
        "support_2": p["l"].min() - offset["high"],
    }
    reached = {
        name for name, distance in distances.items() if not bound * (1 + ROUNDING) < distance
    }
    included = reached - set(left_out)
    lossy = {name for name, R in (("support_1", "R1"), ("support_2", "R2")) if (p[R] < 1).any()}
    friction = float(np.max(p.get("friction", 0.0)))
    pressed = {
        name
        for name, distance in distances.items()
        if not force + friction < distance * (1 - ROUNDING)
    }
    soft = {name for name, k in STIFFNESS.items() if np.any(p.get(k, 0.0))}
    present = ((p["h"] > 0).any(), force > 0, *(name in reached for name in distances))
    watched = sum(WATCHED[name] for name in reached - included)
    of_supports = included & lossy, included & pressed, included & soft
    called_for = (*present, *of_supports, friction > 0.0, further.second_harmonic)
    effects = Effects(*(1 if is_so else None for is_so in called_for))
    return effects._replace(watched=watched or None)


def resolve_effects(
    names: Sequence[str] | None, values: Mapping[str, Any], *at: Any, **how: Any
) -> Effects:
    """Return the effects to compute with.

    A support left out that may be reached is watched.

    Parameters
    ----------
    names : sequence of str or None
        Effects that the user states; None for all.
    values, *at, **how
        Arguments of `effects_of`.

    Raises
    ------
    ParameterError
        If another effect is left out that the parameters call for, or is not computed.
    """
    if names is None:
        return all_effects(values, pieces=True)
    stated = effects_from_names(names)
    missing = missing_effect(names, values, *at, **how)
    if missing is not None:
        must, got = missing
        raise ParameterError("effects", names, must=must, got=got)
    derived = effects_of(values, *at, **how, left_out=absent_supports(names))
    marched = {name: 1 for name, bit in WATCHED.items() if (derived.watched or 0) & bit}
    return stated._replace(watched=derived.watched, **marched)


def absent_supports(names: Sequence[str]) -> tuple[str, ...]:
    """Return the supports that are not among the names."""
    return tuple(name for name in WATCHED if name not in names)


def missing_effect(
    names: Sequence[str], values: Mapping[str, Any], *at: Any, **how: Any
) -> tuple[str, str] | None:
    """Return what must hold and what is the case where `names` leave out an effect that is called for, else None.

    Example: ("must include forcing unless f = 0", "damping with f = 1.0").
    """
    derived = effects_of(values, *at, **how, left_out=absent_supports(names))
    missing = [name for name in effect_names(derived, values) if name not in (*names, *WATCHED)]
    if not missing:
        return None

    effect = missing[0]
    pull = "l - |delta - load|" if np.any(values.get("load", 0.0)) else "l - |delta|"
    parameters, otherwise = {
        "damping": (["h"], "h = 0"),
        "forcing": (["f"], "f = 0"),
        "restitution": (["R1", "R2"], "R = 1 on the supports included"),
        "rest": (["f"], f"|f| < {pull}"),
        "load": (["load"], "load = 0"),
        "soft": (["k1", "k2"], "k = 0 on the supports included"),
        "friction": (["friction"], "friction = 0"),
        "second_harmonic": (["f2"], "f2 = 0"),
    }[effect]
    # what is farthest from an absent effect
    farthest = np.min if effect == "restitution" else np.max
    values_text = ", ".join(f"{q} = {float(farthest(np.abs(values[q])))!r}" for q in parameters)
    if effect == "rest":
        values_text = f"a force of {values_text} that can press the mass on a support"
    stated = ", ".join(names) or "no effects"
    return f"must include {effect} unless {otherwise}", f"{stated} with {values_text}"
