"""Proofs of all rows of a sweep, or of all points of a branch: of each stored orbit on its own."""

from __future__ import annotations

import signal
from collections.abc import Callable, Generator, Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import closing
from functools import partial
from multiprocessing import get_all_start_methods, get_context
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from vibropipe.physics.exciter import ParameterError
from vibropipe.proof.bifurcation import KINDS, is_sought
from vibropipe.proof.given import Given, check_within, given_orbit
from vibropipe.proof.statement import prove_critical, prove_orbit
from vibropipe.solve.threads import watch_parent
from vibropipe.words.bifurcations import Bifurcation
from vibropipe.words.progress import Progress
from vibropipe.words.proofs import BOXED, Proved, ProvedStable, Why, tally
from vibropipe.words.vocabulary import describe
from vibropipe.words.wording import capitalised, count, series, share

# Rows that make another process worth while, and rows that it takes at once.
ROWS_PER_PROCESS, CHUNK = 32, 8
# What a row tells of its proof.
TOLD = ("proved", "why", "proved_stable")


def dims_of_rows(orbit: Any) -> tuple[str, ...]:
    """Return the dimensions of the rows of a dataset; none of one row, or of what is no dataset."""
    if not isinstance(orbit, xr.Dataset) or "period_multiple" not in orbit:
        return ()
    return tuple(str(name) for name in orbit["period_multiple"].dims)


def prove_rows(
    rows: xr.Dataset,
    progress: Progress | None,
    within: Mapping[str, float] | None = None,
    parts: int = 1,
) -> xr.Dataset:
    """Return the dataset of `prove` for several rows, over their dimensions.

    within, parts : as of `prove`, about the exciter of each row.

    Raises ParameterError if a row has an effect that is not proved.
    """
    dims = dims_of_rows(rows)
    shape = tuple(rows.sizes[name] for name in dims)
    codes = {name: np.zeros(shape, np.int8) for name in TOLD}
    # Impacts are marched again from the section of each row: their lists are ragged.
    whole = rows.drop_dims([name for name in ("impact",) if name in rows.dims])
    total = int(np.prod(shape))
    attrs: Mapping[str, Any] = {}
    indices = list(np.ndindex(*shape))
    each = (whole.isel(dict(zip(dims, index, strict=True))) for index in indices)
    prove_row = partial(_proved_row, within=within, parts=parts)
    with closing(_proved(prove_row, each, total)) as found_proofs:
        for done, (index, proof) in enumerate(zip(indices, found_proofs, strict=True)):
            for name, code in zip(TOLD, proof.codes, strict=True):
                codes[name][index] = code
            attrs = attrs or proof.attrs
            if progress is not None:
                progress(done + 1, total)
    found = tally(rows, codes["proved"], codes["why"])
    statement = f"{capitalised(share(found.proved, found.tried, 'orbit'))} proved"
    if within:
        statement += f" within {series(f'{name} +- {most:g}' for name, most in within.items())}"
    if others := found.not_tried:
        statement += f"; {count(others, 'row')} {'was' if others == 1 else 'were'} not tried"
    if "bifurcation" in rows.dims:
        enclosed = proved_bifurcations(rows)
        verdicts = enclosed["bifurcation_proved"][1]
        attempts = int(np.isin(rows["bifurcation_kind"], [*KINDS.values()]).sum())
        proofs = int((verdicts == Proved.PROVED).sum())
        kinds = ("fold, flip, pitchfork or grazing", "folds, flips, pitchforks and grazings")
        statement += f"; {share(proofs, attempts, *kinds)} proved"
    kept = {str(name): coord for name, coord in rows.coords.items() if {*coord.dims} <= {*dims}}
    variables: dict[str, Any] = {name: (dims, values) for name, values in codes.items()}
    variables |= enclosed if "bifurcation" in rows.dims else {}
    told = {key: value for key, value in attrs.items() if key in ("method", "version")}
    return describe(xr.Dataset(variables, kept, {**told, "statement": f"{statement}."}))


class _Proof(NamedTuple):
    """What a proof of a row tells: TOLD, and its attributes."""

    codes: Sequence[int]
    attrs: Mapping[str, Any]


def _proved(
    prove_row: Callable[[xr.Dataset], _Proof], rows: Iterable[xr.Dataset], n: int
) -> Generator[_Proof]:
    """Yield the proofs of n rows in turn, of many side by side on as many processes as numba has threads."""
    import numba

    processes = min(numba.get_num_threads(), n // ROWS_PER_PROCESS)
    if processes < 2 or "fork" not in get_all_start_methods():
        yield from map(prove_row, rows)
        return
    pool = ProcessPoolExecutor(processes, get_context("fork"), initializer=_begin)
    try:
        yield from pool.map(prove_row, rows, chunksize=CHUNK)
    finally:
        pool.shutdown(wait=False, cancel_futures=True)


def _begin() -> None:
    """Begin a process of a pool: Ctrl-C is for its parent, with which it ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    watch_parent()


def _proved_row(row: xr.Dataset, within: Mapping[str, float] | None, parts: int) -> _Proof:
    """Return what the proof of a row tells."""
    given = _orbit_of(row)
    if given is None:
        return _Proof((Proved.UNDECIDED, Why.NOT_TRIED, ProvedStable.UNDECIDED), {})
    tolerances = check_within(given.exciter, within) if within else None
    proof = prove_orbit(given, tolerances, 1, parts, False, 0, narrows=False)
    return _Proof([int(proof[name]) for name in TOLD], proof.attrs)


def _orbit_of(row: xr.Dataset) -> Given | None:
    """Return the orbit of a row; None if it has none that is tried."""
    try:
        return given_orbit(row)
    except ParameterError as error:
        if error.name != "orbit":
            raise
        return None


def proved_bifurcations(branch: xr.Dataset) -> dict[str, Any]:
    """Return which bifurcations of a branch are proved, and bounds of the parameter, NaN unless proved."""
    prefix = "bifurcation_"
    along = next(name for name in BOXED if prefix + name in branch.coords)
    kinds, n = branch["bifurcation_kind"].values, branch.sizes["bifurcation"]
    proved, ends = np.zeros(n, np.int8), np.full((2, n), np.nan)
    whole = branch.drop_dims("bifurcation")
    last = np.cumsum(branch["row_size"].values) if "impact" in branch.dims else None
    for k, point in enumerate(branch["bifurcation_point"].values):
        kind = Bifurcation(int(kinds[k]))
        if kind not in KINDS.values():
            continue
        row = whole.isel(point=int(point))
        if last is not None:  # marched again, an orbit may strike what it touches
            first = int(last[point] - row["row_size"])
            row = row.isel(impact=slice(first, int(last[point])))
        given = _orbit_of(row)
        if given is None or not is_sought(kind, given.law):
            continue
        proof = prove_critical(given, kind, along)
        proved[k] = int(proof["proved"])
        ends[:, k] = [float(proof[f"{along}_{end}"]) for end in ("low", "high")]
    names = [f"{prefix}{along}_{end}" for end in ("low", "high")]
    over = {name: ("bifurcation", values) for name, values in zip(names, ends, strict=True)}
    return {"bifurcation_proved": ("bifurcation", proved), **over}
