"""Where a dataset comes from: attributes that are the same for the same work, wherever it is done.

What differs between two runs of the same work (times, hosts, threads) goes to a small JSON file
beside the dataset, so that equal datasets are equal bytes.
"""

from __future__ import annotations

import hashlib
import json
import os
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


def provenance(
    study_text: str,
    fingerprint: str,
    method: str,
    accuracy_asked: float | None = None,
    accuracy_reached: float | None = None,
    packages: tuple[str, ...] = (),
    **more: Any,
) -> dict[str, Any]:
    """Return the global attributes that say how to make a dataset again.

    ``study_text`` is the study as its author wrote it, ``fingerprint`` the hash of what this
    scene asks for, ``method`` the solver, accuracies are relative errors (None: none asked, none
    measured), ``packages`` what took part beside the usual ones; ``more`` is added as it is. No
    value names a machine, a place or a time. There is no seed, since nothing is drawn at random.
    """
    return {
        "source": f"vibropipe {_version('vibropipe')}",
        "method": method,
        "accuracy_asked": _number(accuracy_asked),
        "accuracy_reached": _number(accuracy_reached),
        "fingerprint": fingerprint,
        "kernel_hash": kernel_hash(),
        "study_hash": hashlib.sha256(study_text.encode()).hexdigest(),
        "study": study_text,
        "versions": _versions(packages),
        "git_commit": _git_commit(os.getcwd()),
        "machine": _machine(),
        **more,
    }


def expected_changes(attrs: Mapping[str, Any]) -> list[str]:
    """Return in words what of the origin in ``attrs`` is not so here, and can change numbers."""
    now = {"kernel_hash": kernel_hash(), "machine": _machine()}
    changes = [
        f"{name.replace('_', ' ')} was {_listed(attrs.get(name, UNKNOWN))}, here {here}"
        for name, here in now.items()
        if attrs.get(name) != here
    ]
    if "kernel_hash" in attrs and attrs["kernel_hash"] != now["kernel_hash"]:
        changes[0] += f" (git commit {_listed(attrs.get('git_commit', UNKNOWN))})"
    if attrs.get("versions") == _versions():
        return changes
    texts = _alternatives(attrs.get("versions", "{}"))
    for name in dict.fromkeys(name for text in texts for name in json.loads(text)):
        then = {str(json.loads(text).get(name, UNKNOWN)) for text in texts}
        here = json.loads(_versions()).get(name) or _version(name)
        if then != {here}:
            changes.append(f"{name} was {', '.join(sorted(then))}, here {here}")
    return changes


def _alternatives(value: Any) -> list[str]:
    """Return the values of an attribute: where shards differ, all that were found."""
    text = str(value)
    return [str(item) for item in json.loads(text)] if text.startswith("[") else [text]


def _listed(value: Any) -> str:
    return " and ".join(_alternatives(value))


def sidecar_path(path: str | PathLike[str]) -> Path:
    """Return the place of the sidecar of a dataset: the same name, ending in .json."""
    return Path(path).with_suffix(".json")


def write_sidecar(path: str | PathLike[str], seconds: float, threads: int, **more: Any) -> None:
    """Write what is of this run only beside the dataset ``path``: time taken, threads, host."""
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
    """Return the sidecar of the dataset ``path``; empty if it has none.

    Raises StoreError if there is one that is not a JSON object.
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


def _number(value: float | None) -> float | str:
    return "none" if value is None else float(value)


@cache
def _versions(more: tuple[str, ...] = ()) -> str:
    """Return the versions of what numbers can depend on, as JSON."""
    found = {name: _version(name) for name in (*PACKAGES, *more)}
    return json.dumps({"python": platform.python_version(), **found})


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return UNKNOWN


@cache
def _git_commit(folder: str) -> str:
    """Return the commit checked out in ``folder``, marked if tracked files were changed since."""
    command = ["git", "-C", folder, "describe", "--always", "--dirty", "--abbrev=40", "--exclude=*"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=20, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return UNKNOWN
    return done.stdout.strip() if done.returncode == 0 else UNKNOWN


@cache
def _machine() -> str:
    """Return the kind of machine: its architecture and its widest vector unit, where known."""
    kind = platform.machine() or UNKNOWN
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return kind
    lines = [line for line in text.splitlines() if line.lower().startswith(("flags", "features"))]
    words = set(lines[0].split()) if lines else set()
    widest = next((unit for unit in VECTOR_UNITS if unit in words), "")
    return f"{kind} {widest}".strip()
