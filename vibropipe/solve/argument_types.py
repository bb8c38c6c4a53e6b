"""Names and types of the arguments of public calls, by their signatures."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from inspect import Signature
from os import PathLike
from typing import Any, NamedTuple

import numpy as np

from vibropipe.physics.parameter_error import ParameterError, check_keywords
from vibropipe.words.parameters import PARAMETERS, PHYSICAL


class Check(NamedTuple):
    """What holds of an argument of a right type, that in words, and whether it may be left out."""

    holds: list[Callable[[Any], bool]]
    allowed: str
    may_be_none: bool


def checks_of(signature: Signature) -> dict[str, Check]:
    """Return the check of each argument whose annotation is simple, by its name."""
    found = {}
    for name, parameter in signature.parameters.items():
        annotation = str(parameter.annotation)
        parts = annotation.split(" | ")
        kinds = [KINDS.get(part.partition("[")[0]) for part in parts if part != "None"]
        known = [kind for kind in kinds if kind is not None]
        if annotation not in OWN_CHECKS and len(known) == len(kinds):
            *texts, last = dict.fromkeys(text for _holds, text in known)
            allowed = " or ".join(filter(None, [", ".join(texts), last]))
            found[name] = Check([holds for holds, _text in known], allowed, "None" in parts)
    return found


def check_names(given: Collection[str], known: Collection[str]) -> None:
    """Raise a ParameterError for keywords that a call does not take; of parameters of an exciter it says so."""
    of_exciter = {*PARAMETERS, *PHYSICAL, "ties"}
    own = [name for name in given if name not in known and name in of_exciter]
    if "exciter" in known and own:
        has_units = any(name in PHYSICAL and name not in PARAMETERS for name in own)
        call = "vp.Exciter.from_physical" if has_units else "vp.Exciter"
        values = ", ".join(f"{name}=..." for name in own)
        must = f"must be given to the exciter, as {call}({values})"
        raise ParameterError(own[0], None, must=must, got="")
    check_keywords(given, known, "argument")


def check_types(checks: Mapping[str, Check], given: Mapping[str, Any]) -> None:
    """Raise a ParameterError for an argument of another type than it has; given : arguments by name."""
    for name, check in checks.items():
        value = given.get(name)
        if name not in given or (value is None and check.may_be_none):
            continue
        if not any(holds(value) for holds in check.holds):
            got = None if isinstance(value, SHORT) else type(value).__name__
            raise ParameterError(name, value, check.allowed, got=got)


def _is_exciter(value: Any) -> bool:
    from vibropipe.physics.exciter import Exciter

    return isinstance(value, Exciter)


def _is_dataset(value: Any) -> bool:
    import xarray as xr

    return isinstance(value, xr.Dataset)


def _is_tree(value: Any) -> bool:
    import xarray as xr

    return isinstance(value, xr.DataTree)


def _is_mapping(value: Any) -> bool:
    return hasattr(value, "items") and hasattr(value, "keys")


def _is_list(value: Any) -> bool:
    """Return whether a value can be taken one by one: text would be taken letter by letter."""
    if isinstance(value, (str, bytes, Mapping)):
        return False
    try:
        iter(value)
    except TypeError:
        return False
    return True


# Types whose values a message shows; of others it has the type.
SHORT = (str, int, float, list, tuple, dict, set, type(None))
Kind = tuple[Callable[[Any], bool], str]
A_LIST: Kind = _is_list, "a list"
A_TEXT: Kind = (lambda value: isinstance(value, str)), "text"
KINDS: Mapping[str, Kind] = {
    "Exciter": (_is_exciter, "an exciter, as vp.Exciter(l=0.5)"),
    "Mapping": (_is_mapping, "a mapping of names to values, as {name: value}"),
    "Sequence": A_LIST,
    "Collection": A_LIST,
    "str": A_TEXT,
    "PathLike": ((lambda value: isinstance(value, PathLike)), "a path"),
    "bool": ((lambda value: isinstance(value, (bool, np.bool_))), "True or False"),
    "xr.Dataset": (_is_dataset, "a dataset"),
    "xr.DataTree": (_is_tree, "a tree of datasets"),
}
"""Whether a value is of a type, and what is expected, by the beginning of its annotation."""

# What the calls check with more to say of it.
OWN_CHECKS = {
    "str",
    "str | None",
    "xr.Dataset",
    "Exciter | xr.Dataset",
    "Sequence[int]",
    "Sequence[int] | None",
    "Sequence[Sequence[float]]",
    "str | Mapping[str, Any] | Collection[str | Mapping[str, Any]]",
    "Mapping[str, Any] | Sequence[Any]",
}
