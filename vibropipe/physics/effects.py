"""Physical effects of a scene, as types: the code of an absent effect is never compiled.

Each field of `Effects` is 1 (present) or None (absent). numba resolves `effects.forcing is not None` at compile time,
so an absent branch is not in the machine code. Each set of effects is cached on disk like any other signature.
"""

from __future__ import annotations

import math
from collections import namedtuple
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.physics.bounds import ROUNDING, largest_force, state_norm_bound
from vibropipe.physics.exciter import ParameterError
from vibropipe.words.exciter import EFFECTS
from vibropipe.words.parameters import (
    DEFAULTS,
    EFFECT_NAMES,
    THROUGH_OTHERS,
    acting,
    names_in,
    occurs,
    of_effect,
)
from vibropipe.words.records import Effect

if TYPE_CHECKING:
    from vibropipe.words.exciter import OfEffects
    from vibropipe.words.parameters import NamedFields

# Effects without machine code of their own.
BY_PARAMETER = {each.name: each for each in EFFECTS if not each.is_marched}
# The bit of each support in `Effects.watched`.
WATCHED = {"support_1": 1, "support_2": 2}
# The stiffness of each support, 0 where it is rigid.
STIFFNESS = {"support_1": "k1", "support_2": "k2"}


_MARCHED = [each for each in EFFECTS if each.is_marched]
if TYPE_CHECKING:

    class _Presence(NamedFields, OfEffects):
        watched: int | None

else:
    _Presence = namedtuple(
        "Effects",
        [*(each.name for each in _MARCHED), "watched"],
        defaults=[*(1 if each.is_common else None for each in _MARCHED), None],
    )


class Effects(_Presence):
    """Presence of each physical effect that is marched: 1 or None.

    watched : supports that are left out although no bound keeps the motion from them: 1, 2 or 3 for both, None for
    none. They are marched as present, and the march stops where it meets one.
    """

    __slots__ = ()

    @property
    def has_pieces(self) -> bool:
        """Whether motions are marched by pieces: with soft supports, friction or a housing that slides."""
        return any(each is not None for each in (self.soft, self.friction, self.housing))


# The effects of eqs. (5), (6).
ALL_EFFECTS = Effects()

_BY_PIECES = [each for each in EFFECTS if each.refusal]
# Parameters of effects that are marched by pieces, and what calls without them say of each.
NOT_COMPUTED = {
    name: each.refusal
    for each in _BY_PIECES
    for name in of_effect(each.name)
    if DEFAULTS[name] == 0.0
}
# Those of a housing, which fewer calls compute.
OF_HOUSING = of_effect("housing")
# Those of them that call for pieces by themselves.
CALL_FOR_PIECES = tuple(name for each in _BY_PIECES for name in each.calls)
# Further effects that all calls compute where parameters have them.
ALWAYS_COMPUTED = [each for each in _MARCHED if not (each.is_common or each.refusal)]


def has_effect(effect: Effect, values: Mapping[str, Any]) -> bool:
    """Return whether parameters call for an effect anywhere."""
    return any(occurs(values.get(name, 0.0)) for name in effect.calls)


def has_soft_support(values: Mapping[str, Any]) -> bool:
    """Return whether a support is soft anywhere; kernels with friction may have the effect without one."""
    return any(occurs(values.get(name, 0.0)) for name in STIFFNESS.values())


def all_effects(
    values: Mapping[str, Any], *, pieces: bool = False, housing: bool = False
) -> Effects:
    """Return all effects of eqs. (5), (6), and those beyond that parameters have.

    pieces : whether the caller computes soft supports and friction; both are then added where the parameters have one,
    so that one kernel serves all such exciters. housing : whether it computes a housing that slides, too, which is
    added where the parameters have one.

    Raises ParameterError if the parameters have an effect that is not computed.
    """
    values = _over_grid(values)
    for name, effect in NOT_COMPUTED.items():
        is_computed = housing if name in OF_HOUSING else pieces
        if not is_computed and occurs(values.get(name, 0.0)):
            largest = float(np.abs(values[name]).max())
            must = f"must be 0: {effect} not computed here"
            raise ParameterError(name, values[name], must=must, got=repr(largest))
    further = ALL_EFFECTS._replace(
        **{each.name: 1 if has_effect(each, values) else None for each in ALWAYS_COMPUTED}
    )
    if any(occurs(values.get(name, 0.0)) for name in CALL_FOR_PIECES if name not in OF_HOUSING):
        further = further._replace(soft=1, friction=1)
    return further._replace(housing=1) if occurs(values.get("mass_ratio", 0.0)) else further


def _over_grid(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return parameters over a grid as kernels see them: those that others act on at all ends of what they depend on.

    Grids have lengths of their own, and an expression rises or falls with each of its parameters.
    """
    found = dict(values)
    for name, acts in THROUGH_OTHERS.items():
        used = {each for text in acts.values() for each in names_in(text)}
        varied = {n for n in used & found.keys() if np.size(found[n]) > 1}
        if len(varied) < 2 or not occurs(found.get(name, 0.0)):
            continue
        mesh = np.meshgrid(*([np.min(found[n]), np.max(found[n])] for n in varied))
        corners = dict(zip(varied, (each.ravel() for each in mesh), strict=True))
        seen = acting({**found, **corners})
        found |= {each: seen[each] for each in (name, *acts)}
    return acting(found)


def kernel_effects(effects: Effects) -> Effects:
    """Return the effects of the kernel that marches with some effects: with a support also restitution and rest.

    A march without their code is at most 4 % faster, and would be compiled apart, which takes half a minute.
    """
    if effects.support_1 is None and effects.support_2 is None:
        return effects
    return effects._replace(restitution=1, rest=1)


def grid_effects(effects: Effects) -> Effects:
    """Return the effects of the kernel that makes a grid, for marches with some effects: few kernels for all."""
    return ALL_EFFECTS._replace(second_harmonic=effects.second_harmonic)


def shared_effects(effects: Effects) -> Effects:
    """Return the effects of a kernel that runs once a motion or a row of some effects: few kernels for all."""
    fields = {name: getattr(effects, name) for name in ("second_harmonic", "housing", "no_pull")}
    by_pieces = {"soft": 1, "friction": 1} if effects.has_pieces else {}
    return ALL_EFFECTS._replace(**fields, **by_pieces)


def check_first_harmonic(values: Mapping[str, Any]) -> None:
    """Raise a ParameterError where a second harmonic acts alone: every orbit is then twice the same."""
    if occurs(values.get("f2", 0.0)) and not occurs(values.get("f", 0.0)):
        must = "must not be 0 beside f2: a second harmonic alone is a first one, with 2 nu and f2"
        raise ParameterError("f", 0.0, must=must)


def effect_names(effects: Effects, values: Mapping[str, Any] | None = None) -> tuple[str, ...]:
    """Return the names of the effects that are present, in the order of EFFECT_NAMES, without watched supports.

    Effects without machine code of their own (`BY_PARAMETER`) are present where the parameters `values` have them; so
    are those of pieces, whose kernels hold more than one. Without `values` a kernel's own are named.
    """
    watched, known = effects.watched or 0, values or {}
    of_parameters = {name for name, each in BY_PARAMETER.items() if has_effect(each, known)}
    idle = {each.name for each in _BY_PIECES if known and not has_effect(each, known)}
    return tuple(
        name
        for name in EFFECT_NAMES
        if name in of_parameters
        or (
            name not in idle
            and getattr(effects, name, None) is not None
            and not watched & WATCHED.get(name, 0)
        )
    )


def all_effect_names(
    values: Mapping[str, Any], *, pieces: bool = False, housing: bool = False
) -> tuple[str, ...]:
    """Return the names of `all_effects`."""
    return effect_names(all_effects(values, pieces=pieces, housing=housing), values)


def effects_from_names(names: Iterable[str]) -> Effects:
    """Return effects by name, or raise a ParameterError for a name that is none of EFFECT_NAMES."""
    chosen = set(names)
    for name in chosen - set(EFFECT_NAMES):
        raise ParameterError(
            "effects", names, must=f"must be among {', '.join(EFFECT_NAMES)}", got=repr(name)
        )
    return Effects(**{each.name: 1 if each.name in chosen else None for each in _MARCHED})


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
    friction hold it there, |f| + friction_ratio friction >= its pull towards the equilibrium, soft where a support
    reached has k > 0, friction where it is > 0.

    values : values of each parameter over the grid
    x, v : start; x is the displacement from the equilibrium
    span : duration of the motions in tau
    exact : whether the exact method solves them. The bounds are not proven for Newmark's, whose supports all count as
        reached
    followed : whether rows start from the steady state of a neighbour
    left_out : supports that the user leaves out; they are watched where no bound keeps the motion from them

    Raises ParameterError if the parameters have an effect that is not computed.
    """
    further = all_effects(values, pieces=True, housing=True)
    over = _over_grid(values).items()
    p = {name: np.atleast_1d(np.asarray(array, float)) for name, array in over}
    # A constant load moves the equilibrium, from which x and the supports count.
    load = p.pop("load", np.zeros(1))
    offset = {"low": p["delta"].min() - load.max(), "high": p["delta"].max() - load.min()}
    p["delta"] = np.array([*offset.values()])
    # A housing drives the mass by its acceleration: no bound is proven.
    is_bounded = exact and further.housing is None
    bound = state_norm_bound(p, x, v, span, followed) if is_bounded else math.inf
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
    hold = float(np.max(p.get("friction", 0.0) * p.get("friction_ratio", np.ones(1))))
    pressed = {
        name
        for name, distance in distances.items()
        if further.housing is not None or not force + hold < distance * (1 - ROUNDING)
    }
    soft = {name for name, k in STIFFNESS.items() if np.any(p.get(k, 0.0))}
    called_for = {
        **{each.name: has_effect(each, p) for each in _MARCHED if each.calls},
        **{name: name in reached for name in distances},
        "restitution": included & lossy,
        "rest": included & pressed,
        "soft": included & soft,
    }
    effects = further._replace(**{name: 1 if is_so else None for name, is_so in called_for.items()})
    watched = sum(WATCHED[name] for name in reached - included)
    return effects._replace(watched=watched or None)


def resolve_effects(
    names: Sequence[str] | None, values: Mapping[str, Any], *at: Any, **how: Any
) -> Effects:
    """Return the effects to compute with.

    A support left out that may be reached is watched.

    names : effects that the user states; None for all
    values, *at, **how : arguments of `effects_of`

    Raises ParameterError if another effect is left out that the parameters call for, or is not computed.
    """
    if names is None:
        return all_effects(values, pieces=True, housing=True)
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
    record = next(each for each in EFFECTS if each.name == effect)
    otherwise = record.unless.format(pull=pull)
    # what is farthest from an absent effect
    farthest = np.min if effect == "restitution" else np.max
    values_text = ", ".join(f"{q} = {float(farthest(np.abs(values[q])))!r}" for q in record.shown)
    if effect == "rest":
        values_text = f"a force of {values_text} that can press the mass on a support"
    stated = ", ".join(names) or "no effects"
    return f"must include {effect} unless {otherwise}", f"{stated} with {values_text}"
