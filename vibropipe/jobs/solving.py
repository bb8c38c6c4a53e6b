"""Solve a scene of a study, or a shard of it, into a dataset with its provenance."""

from __future__ import annotations

import sys
import time
from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vibropipe.compiler.cache import compile_seconds
from vibropipe.compiler.sources import kernel_hash
from vibropipe.jobs.earlier import (
    NONE_TAKEN,
    NOT_TAKEN,
    TAKEN,
    drop_earlier,
    earlier_file,
    taken_text,
)
from vibropipe.jobs.plan import as_cut, check_cut, plan_scene, record
from vibropipe.jobs.processes import reported, side_by_side
from vibropipe.jobs.progress import show_progress
from vibropipe.jobs.verify import ForeignError, study_and_scene
from vibropipe.physics.exciter import ParameterError
from vibropipe.scenes.costs import PlanError
from vibropipe.scenes.keys.base import BaseScene
from vibropipe.scenes.kind import Kind
from vibropipe.scenes.registry import kind_of
from vibropipe.scenes.rows import with_origin
from vibropipe.store import (
    NotTakenError,
    NotWrittenError,
    StoreError,
    check_intact,
    count_equal,
    expected_changes,
    provenance,
    read_sidecar,
    save,
    selected_attributes,
    write_sidecar,
)
from vibropipe.store.atomic import AGAIN
from vibropipe.store.opening import SCENES
from vibropipe.store.shards import ROW_RANGE_ATTRS
from vibropipe.study import Study, StudyError, fingerprint
from vibropipe.words.progress import Progress
from vibropipe.words.proofs import MISSING, REFUSED
from vibropipe.words.regimes import Regime

if TYPE_CHECKING:
    import xarray as xr

# Entry of the sidecar of a shard: which it is of how many.
CUT = "cut"
# Attributes that a dataset is made again from.
ORIGIN = ("study", "study_hash", "machine", "versions", "git_commit")
# An attribute that only shards have.
FIRST_ROW = ROW_RANGE_ATTRS[0]
# Attributes of the process that solves; a join keeps those of its shards.
SOLVER_ATTRS = ("kernel_hash", "kind_hash", "version", "versions", "git_commit", "machine")


def solve_to_file(
    study: Study,
    name: str,
    path: Path,
    shard: tuple[int, int] | None,
    threads: int,
    progress: Progress | None = None,
    earlier: Path | None = None,
) -> None:
    """Solve a scene or a shard into a file, and write its sidecar: time taken, unresolved rows, hashes.

    path : the dataset; its folder is created if needed. The sidecar is beside it, with the suffix `.json`
    shard : (I, N) for shard I of N, counted from 1; None for the whole scene
    threads : number of threads that the kernels use, recorded in the sidecar
    progress : called as `progress(done, total)`, in units of the kind of scene
    earlier : dataset of the scene before its study was changed; rows of it that are still the same are not solved
    Raises StudyError if the study has no such scene, or PlanError if the scene cannot be cut so, or cannot be solved
    with its parameters.
    """
    begin, begin_work, n_compiled = time.perf_counter(), time.process_time(), len(compile_seconds)
    scene = study.scene(name)
    kind = kind_of(scene)
    check_cut(scene, shard)
    entries: dict[str, Any] = {} if shard is None else {CUT: cut_text(*shard)}
    try:
        if not kind.can_be_cut:
            save(solve_scene(study, name, progress), path)
        elif earlier is None:
            kind.cut.store(scene, path, origin(study, scene), shard, progress)
        else:
            entries |= _store_with_earlier(study, scene, path, shard, progress, earlier)
    except ParameterError as error:
        raise PlanError(f"scenes.{name}.{error}") from error
    elapsed = time.perf_counter() - begin
    worked = time.process_time() - begin_work - sum(compile_seconds[n_compiled:])
    if not entries.get(TAKEN):
        share, own = share_of(scene, shard), fingerprint(study, scene)
        record(plan_scene(scene), share, worked, path.stat().st_size, own)
    write_sidecar(path, elapsed, threads, unresolved=count_unresolved(path), **entries)
    if shard is None:
        drop_earlier(path)


def _store_with_earlier(
    study: Study,
    scene: BaseScene,
    path: Path,
    shard: tuple[int, int] | None,
    progress: Progress | None,
    earlier: Path,
) -> dict[str, Any]:
    """Solve the rows of a scene or a shard that an earlier dataset does not have, and write all of them.

    Return the entries of the sidecar: how many rows were taken, or why none. Both are printed.
    """
    store, attrs = kind_of(scene).cut.store, origin(study, scene)
    try:
        # a shard relies on the checksums of the chunks that it reads: each would else read all of a large file
        check_intact(earlier, every_byte=shard is None)
        old = scene_before(study, scene, earlier)
        rows = kind_of(scene).cut.earlier_rows(scene, old, earlier, shard)
        print(
            f"{scene.name}: {taken_text(rows.n_taken, len(rows.rows))}", file=sys.stderr, flush=True
        )
        store(scene, path, attrs, shard, progress, rows if rows.n_taken else None)
    except NotWrittenError:
        raise
    except StoreError as error:
        reason = f"{NONE_TAKEN}: {str(error).removesuffix(f': {AGAIN}')}"
        print(f"{scene.name}: {reason}", file=sys.stderr, flush=True)
        store(scene, path, attrs, shard, progress)
        return {NOT_TAKEN: reason}
    return {TAKEN: rows.n_taken} if rows.n_taken else {}


def scene_before(study: Study, scene: BaseScene, path: Path) -> BaseScene:
    """Return a scene as it was when its dataset was made, if rows with the same values would be the same now.

    Raises NotTakenError with the reason if they might differ, or StoreError if the dataset cannot be read.
    """
    kept = {key: text for key, text in identity(study, scene).items() if key != "fingerprint"}
    attrs = selected_attributes(path, [*kept, "fingerprint", *ORIGIN])
    changes = expected_changes(attrs)
    if changes or any(attrs.get(key) != text for key, text in kept.items()):
        text = "; ".join(changes) or "another version of the program made it"
        raise NotTakenError(f"{path}: {text}")
    try:
        _, old = study_and_scene(attrs)
    except (StudyError, ForeignError, KeyError) as error:
        raise NotTakenError(f"{path}: {error}") from error
    if old.fingerprint() != attrs.get("fingerprint"):
        raise NotTakenError(f"{path}: its study means something else to this version")
    if scene.row_keys() is None or scene.row_keys() != old.row_keys():
        raise NotTakenError(f"{path}: more than the values of its grids has changed")
    return old


def solve_stale(
    study: Study, names: Sequence[str], folder: Path, logs: Path | None, threads: int
) -> list[str]:
    """Solve those of some scenes whose datasets are stale, several at once, and return the scenes that failed.

    logs : folder of a log for each scene (default: this process has the messages)
    threads : number of threads, shared by the scenes that are solved at once
    """
    stale = [n for n in names if not is_of(folder / f"{n}.nc", identity(study, study.scene(n)))]
    stale.sort(key=lambda name: -plan_scene(study.scene(name)).seconds)
    processes = max(min(threads, len(stale)), 1)

    def solve(number: int) -> None:
        name = stale[number]
        with reported(logs and logs / f"{name}.log"):
            own = use_threads(threads // processes)
            with show_progress(name, kind_of(study.scene(name)).unit) as progress:
                path = folder / f"{name}.nc"
                kept = (each for each in (earlier_file(path), path) if each.is_file())
                earlier = next(kept, None) if study.scene(name).row_keys() else None
                solve_to_file(study, name, path, None, own, progress, earlier)

    for name in stale:  # imported once for all processes
        _ = kind_of(study.scene(name)).solve
    side_by_side(solve, len(stale), processes)
    return [n for n in stale if not is_of(folder / f"{n}.nc", identity(study, study.scene(n)))]


def use_threads(threads: int | None) -> int:
    """Set the number of threads of the kernels, at most those of this machine; return the number set."""
    import numba

    if threads is not None:
        available = int(numba.config.NUMBA_NUM_THREADS)  # type: ignore[attr-defined]
        numba.set_num_threads(max(1, min(threads, available)))
    return int(numba.get_num_threads())


def solve_scene(study: Study, name: str, progress: Progress | None = None) -> xr.Dataset:
    """Return the dataset of a scene, solved in memory; raise StudyError if the study has no such scene."""
    scene = study.scene(name)
    dataset = kind_of(scene).solve(scene, progress)
    return with_origin(dataset, scene, origin(study, scene))


def join_to_file(
    study: Study, name: str, shards: Sequence[Path], path: Path, progress: Progress | None = None
) -> None:
    """Join all shards of a scene, in any order; the sidecar holds the time of all jobs together.

    shards : datasets of all shards, with their sidecars beside them
    progress : called as `progress(done, total)` with numbers of rows
    Raises StudyError if the study has no such scene, or PlanError if the scene cannot be cut into shards, or
    StoreError if the shards are not those of this scene.
    """
    scene = study.scene(name)
    kind = as_cut(scene)
    begin = time.perf_counter()
    attrs = {key: value for key, value in origin(study, scene).items() if key not in SOLVER_ATTRS}
    kind.cut.join(scene, shards, path, attrs, progress)
    sidecars = [read_sidecar(shard) for shard in shards]
    seconds = sum(float(sidecar.get("seconds", 0)) for sidecar in sidecars)
    threads = max(int(sidecar.get("threads", 1)) for sidecar in sidecars)
    seconds += time.perf_counter() - begin
    noted: dict[str, Any] = {}
    if taken := sum(int(sidecar.get(TAKEN, 0)) for sidecar in sidecars):
        noted[TAKEN] = taken
    for reason in {sidecar[NOT_TAKEN] for sidecar in sidecars if NOT_TAKEN in sidecar}:
        noted[NOT_TAKEN] = reason
    unresolved = count_unresolved(path)
    write_sidecar(path, seconds, threads, shards=len(shards), unresolved=unresolved, **noted)
    drop_earlier(path)


def identity(study: Study, scene: BaseScene) -> dict[str, str]:
    """Return the attributes by which a dataset says what it was made from: names, keys and code."""
    kind = kind_of(scene)
    return {
        "title": f"{study.name}: {scene.name}",
        "fingerprint": fingerprint(study, scene),
        "kernel_hash": kernel_hash(),
        hash_name(kind): kind.code_hash,
    }


def cut_text(number: int, count: int) -> str:
    """Return a shard as `I/N`, the option of `vibropipe solve`."""
    return f"{number}/{count}"


def hash_name(kind: Kind) -> str:
    """Return the name of the attribute with the hash of what a kind runs beside the kernels."""
    return "lab_hash" if kind.is_timed else "kind_hash"


def is_of(path: str | Path, wanted: Mapping[str, str], cut: str | None = None) -> bool:
    """Return whether a dataset, or a shard `I/N`, exists and says that it was made from what is wanted (`identity`).

    A damaged dataset counts as made from it: who reads it reports the damage.
    """
    if not Path(path).is_file():
        return False
    try:
        found = selected_attributes(path, [*wanted, FIRST_ROW, REFUSED])
        is_shard = found.pop(FIRST_ROW, None) is not None
        # what a proof needs may be there now
        lacked = MISSING in str(found.pop(REFUSED, "")) and find_spec("flint") is not None
        return (
            found == wanted
            and not lacked
            and is_shard == (cut is not None)
            and (cut == read_sidecar(path).get(CUT))
        )
    except StoreError:
        return True


def count_unresolved(path: Path) -> int:
    """Return the number of rows of a dataset without a reliable result; 0 if it has no rows.

    Rows of basins are starts: an attractor that is not there at a value of a parameter is not one of them.
    """
    return count_equal(path, {"attractor": -1, "regime": Regime.UNRESOLVED})


def share_of(scene: BaseScene, shard: tuple[int, int] | None) -> float:
    """Return the share of the rows of a scene that a shard has."""
    if shard is None:
        return 1.0
    first, last = as_cut(scene).cut.row_range(scene, *shard)
    return float(last - first) / scene.row_count


def origin(study: Study, scene: BaseScene) -> dict[str, Any]:
    """Return the global attributes of a dataset; titles of scenes are left out, since no data depend on them."""
    kind = kind_of(scene)
    return {
        "title": f"{study.name}: {scene.name}",
        "kind": scene.kind,
        SCENES: " ".join(study.scenes),
        **provenance(
            study.text,
            fingerprint(study, scene),
            scene.method_text(),
            scene.accuracy_asked(),
            packages=kind.packages,
        ),
        hash_name(kind): kind.code_hash,
        **study.units_attrs,
    }
