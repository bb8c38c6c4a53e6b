"""Provenance of a dataset: attributes that are equal for equal work, on any host and at any time.

What differs between two runs of the same work (times, hosts, threads) goes to a small JSON file beside the dataset, so
that equal datasets are equal bytes.
"""

from __future__ import annotations

import hashlib
import json
import platform
import socket
import subprocess
from collections.abc import Mapping
from datetime import UTC, datetime
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from os import PathLike
from pathlib import Path
from typing import Any

from vibropipe.compiler import kernel_hash
from vibropipe.store.atomic import StoreError, atomic_file

PACKAGES = ("vibropipe", "numpy", "numba", "llvmlite", "xarray", "netCDF4")
VECTOR_UNITS = ("avx512f", "avx2", "avx", "sse4_2", "sve", "asimd")
UNKNOWN = "unknown"
SOURCES = Path(__file__).resolve().parents[1]  # of the package, which a clone has at its top


def provenance(
    study_text: str,
    fingerprint: str,
    method: str,
    accuracy_asked: float | None = None,
    packages: tuple[str, ...] = (),
) -> dict[str, Any]:
    """Return the global attributes from which a dataset can be recomputed.

    study_text : study as its author wrote it
    fingerprint : hash of what the scene computes
    accuracy_asked : requested relative error; None if not requested. The error reached is that of the dataset, if it
        has one
    packages : packages that took part, in addition to PACKAGES
    No value names a host, a folder or a time. There is no seed, since nothing is random.
    """
    return {
        "source": f"vibropipe {_version('vibropipe')}",
        "version": _version("vibropipe"),
        "method": method,
        "accuracy_asked": "none" if accuracy_asked is None else float(accuracy_asked),
        "accuracy_reached": "none",
        "fingerprint": fingerprint,
        "kernel_hash": kernel_hash(),
        "study_hash": hashlib.sha256(study_text.encode()).hexdigest(),
        "study": study_text,
        "versions": _versions(packages),
        "git_commit": _commit_of(SOURCES),
        "machine": _machine(),
    }


def expected_changes(attrs: Mapping[str, Any]) -> list[str]:
    """Return, as texts, the differences of provenance between `attrs` and here that can change numbers.

    They are those of kernel hash, machine and package versions.
    """
    current_values = {"kernel_hash": kernel_hash(), "machine": _machine()}
    changes = [
        f"{name.replace('_', ' ')} was {_listed(attrs.get(name, UNKNOWN))}, here {current}"
        for name, current in current_values.items()
        if attrs.get(name) != current
    ]
    if "kernel_hash" in attrs and attrs["kernel_hash"] != current_values["kernel_hash"]:
        changes[0] += f" (git commit {_listed(attrs.get('git_commit', UNKNOWN))})"
    if attrs.get("versions") == _versions():
        return changes
    texts = _alternatives(attrs.get("versions", "{}"))
    for name in dict.fromkeys(name for text in texts for name in json.loads(text)):
        stored = {str(json.loads(text).get(name, UNKNOWN)) for text in texts}
        current = json.loads(_versions()).get(name) or _version(name)
        if stored != {current}:
            changes.append(f"{name} was {', '.join(sorted(stored))}, here {current}")
    return changes


def _alternatives(value: Any) -> list[str]:
    """Return the values of an attribute: several where the joined shards differed."""
    text = str(value)
    return [str(item) for item in json.loads(text)] if text.startswith("[") else [text]


def _listed(value: Any) -> str:
    """Return the values of an attribute, joined as text."""
    return " and ".join(_alternatives(value))


def sidecar_path(path: str | PathLike[str]) -> Path:
    """Return the path of the sidecar of a dataset: the same name with the suffix .json."""
    return Path(path).with_suffix(".json")


def write_sidecar(path: str | PathLike[str], seconds: float, threads: int, **more: Any) -> None:
    """Write what belongs to this run only (time taken, threads, host) beside the dataset `path`."""
    record = {
        "seconds": seconds,
        "threads": threads,
        "host": socket.gethostname(),
        "finished": datetime.now(UTC).isoformat(timespec="seconds"),
        **more,
    }
    with atomic_file(sidecar_path(path)) as temporary:
        temporary.write_text(json.dumps(record, indent=2) + "\n", encoding="utf-8")


def read_sidecar(path: str | PathLike[str]) -> dict[str, Any]:
    """Return the sidecar of the dataset `path`; empty if there is none.

    Raises StoreError if it is not a JSON object.
    """
    place = sidecar_path(path)
    try:
        record = json.loads(place.read_text(encoding="utf-8"))
    except FileNotFoundError:
        return {}
    except (OSError, ValueError) as error:
        raise StoreError(f"{place}: cannot be read ({error}): delete it") from error
    if not isinstance(record, dict):
        raise StoreError(f"{place}: is not a JSON object: delete it")
    return record


@cache
def _versions(more: tuple[str, ...] = ()) -> str:
    """Return the versions of the packages that numbers can depend on, as JSON."""
    versions = {name: _version(name) for name in (*PACKAGES, *more)}
    return json.dumps({"python": platform.python_version(), **versions})


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return UNKNOWN


def _commit_of(sources: Path) -> str:
    """Return the commit of the program's sources if they are in a clone of their own; unknown if installed.

    git is only called in a clone: elsewhere it would find the repository around the study or the environment.
    """
    clone = sources.parent
    return _git_commit(str(clone)) if (clone / ".git").exists() else UNKNOWN


@cache
def _git_commit(folder: str) -> str:
    """Return the commit checked out in `folder`, marked if tracked files were changed."""
    command = ["git", "-C", folder, "describe", "--always", "--dirty", "--abbrev=40", "--exclude=*"]
    try:
        process = subprocess.run(command, capture_output=True, text=True, timeout=20, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return UNKNOWN
    return process.stdout.strip() if process.returncode == 0 else UNKNOWN


@cache
def _machine() -> str:
    """Return the architecture of the machine and its widest vector unit, where known."""
    architecture = platform.machine() or UNKNOWN
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return architecture
    lines = [line for line in text.splitlines() if line.lower().startswith(("flags", "features"))]
    features = set(lines[0].split()) if lines else set()
    widest = next((unit for unit in VECTOR_UNITS if unit in features), "")
    return f"{architecture} {widest}".strip()
