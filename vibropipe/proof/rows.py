"""Proofs of all rows of a sweep, or of all points of a branch: of each stored orbit on its own."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from vibropipe.physics.effects import all_effects
from vibropipe.physics.exciter import ParameterError
from vibropipe.proof.bifurcation import KINDS
from vibropipe.proof.given import given_orbit
from vibropipe.proof.statement import prove_critical, prove_orbit
from vibropipe.solve.rebuild import exciter_of
from vibropipe.words.bifurcations import Bifurcation
from vibropipe.words.progress import Progress
from vibropipe.words.proofs import BOXED, Proved, ProvedStable, Why
from vibropipe.words.vocabulary import describe
from vibropipe.words.wording import count, share

# What a row tells of its proof.
TOLD = ("proved", "why", "proved_stable")


def dims_of_rows(orbit: Any) -> tuple[str, ...]:
    """Return the dimensions of the rows of a dataset; none of one row, or of what is no dataset."""
    if not isinstance(orbit, xr.Dataset) or "period_multiple" not in orbit:
        return ()
    return tuple(str(name) for name in orbit["period_multiple"].dims)


def prove_rows(rows: xr.Dataset, progress: Progress | None) -> xr.Dataset:
    """Return the dataset of `prove` for several rows, over their dimensions.

    Raises
    ------
    ParameterError
        If a row has an effect that is not proved.
    """
    dims = dims_of_rows(rows)
    shape = tuple(rows.sizes[name] for name in dims)
    codes = {name: np.zeros(shape, np.int8) for name in TOLD}
    # Impacts are marched again from the section of each row: their lists are ragged.
    whole = rows.drop_dims([name for name in ("impact",) if name in rows.dims])
    total = int(np.prod(shape))
    attrs: Mapping[str, Any] = {}
    for done, index in enumerate(np.ndindex(*shape)):
        row = whole.isel(dict(zip(dims, index, strict=True)))
        all_effects(vars(exciter_of(row)))
        proved, why, stable = Proved.UNDECIDED, Why.NOT_TRIED, ProvedStable.UNDECIDED
        try:
            given = given_orbit(row)
        except ParameterError:
            given = None
        if given is not None:
            proof = prove_orbit(given, None, 1, 1, False, 0)
            proved, why = Proved(int(proof["proved"])), Why(int(proof["why"]))
            stable, attrs = ProvedStable(int(proof["proved_stable"])), proof.attrs
        for name, code in zip(TOLD, (proved, why, stable), strict=True):
            codes[name][index] = code
        if progress is not None:
            progress(done + 1, total)
    at: Any = rows["bifurcation_point"].values if "bifurcation_point" in rows else []
    # Orbits at a bifurcation are about to end, by rounding on either side: they are not counted.
    counted = {name: np.delete(values, at) for name, values in codes.items()}
    total = counted["why"].size
    tried = int((counted["why"] != Why.NOT_TRIED).sum())
    amount = int((counted["proved"] == Proved.PROVED).sum())
    statement = f"{share(amount, tried, 'orbit')} proved"
    if tried < total:
        statement += (
            f"; {count(total - tried, 'row')} {'was' if total - tried == 1 else 'were'} not tried"
        )
    if "bifurcation" in rows.dims:
        found = proved_bifurcations(rows)
        verdicts = found["bifurcation_proved"][1]
        attempts = int(np.isin(rows["bifurcation_kind"], [*KINDS.values()]).sum())
        proofs = int((verdicts == Proved.PROVED).sum())
        kinds = count(attempts, "fold, flip or grazing", "folds, flips and grazings")
        statement += f"; {proofs:,} of {kinds} are proved"
    kept = {str(name): coord for name, coord in rows.coords.items() if {*coord.dims} <= {*dims}}
    variables: dict[str, Any] = {name: (dims, values) for name, values in codes.items()}
    variables |= found if "bifurcation" in rows.dims else {}
    told = {key: value for key, value in attrs.items() if key in ("method", "version")}
    return describe(xr.Dataset(variables, kept, {**told, "statement": f"{statement}."}))


def proved_bifurcations(branch: xr.Dataset) -> dict[str, Any]:
    """Return which folds, flips and grazings of a branch are proved, and bounds of the parameter, NaN unless proved."""
    prefix = "bifurcation_"
    along = next(name for name in BOXED if prefix + name in branch.coords)
    kinds, n = branch["bifurcation_kind"].values, branch.sizes["bifurcation"]
    proved, ends = np.zeros(n, np.int8), np.full((2, n), np.nan)
    whole = branch.drop_dims([name for name in ("impact", "bifurcation") if name in branch.dims])
    for k, point in enumerate(branch["bifurcation_point"].values):
        if kinds[k] not in KINDS.values():
            continue
        try:
            given = given_orbit(whole.isel(point=int(point)))
        except ParameterError:
            continue
        proof = prove_critical(given, Bifurcation(int(kinds[k])), along)
        proved[k] = int(proof["proved"])
        ends[:, k] = [float(proof[f"{along}_{end}"]) for end in ("low", "high")]
    names = [f"{prefix}{along}_{end}" for end in ("low", "high")]
    over = {name: ("bifurcation", values) for name, values in zip(names, ends, strict=True)}
    return {"bifurcation_proved": ("bifurcation", proved), **over}
