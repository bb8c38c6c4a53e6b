"""What all datasets of proofs have."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from vibropipe.physics.effects import all_effect_names
from vibropipe.physics.exciter import Exciter
from vibropipe.proof.balls import BITS
from vibropipe.solve.origin_attrs import origin_attrs
from vibropipe.words.proofs import Proved, Why
from vibropipe.words.vocabulary import describe


def proved_scalars(proved: Proved, why: Why, examined: int, law: Sequence[int]) -> dict[str, Any]:
    """Return the variables that all proofs have."""
    m, *impacts = law
    return {
        "proved": ((), np.int8(proved)),
        "why": ((), np.int8(why)),
        "parts": ((), examined),
        "period_multiple": ((), m),
        "impacts_per_orbit": ("support", np.array(impacts, float)),
    }


def described(
    exciter: Exciter,
    variables: Mapping[str, Any],
    harmonics: int,
    attrs: Mapping[str, str],
    **coords: Any,
) -> xr.Dataset:
    """Return variables as a dataset with the parameters of the exciter and the words of all quantities."""
    from flint import __version__ as flint_version

    scalars = {name: ((), value) for name, value in exciter.stated().items()}
    index = {"support": np.array([1, 2], np.int8), "harmonic": np.arange(1, harmonics + 1)}
    origin = origin_attrs(all_effect_names(vars(exciter), pieces=True), "none: proved by balls")
    origin["method"] = f"balls of {BITS} bits (python-flint {flint_version})"
    dataset = xr.Dataset(dict(variables), {**scalars, **index, **coords}, {**origin, **attrs})
    return describe(dataset)
