"""Locks of snakemake: which results another run in this folder is making."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

from vibropipe.scenes.costs import PlanError

# Where a run of snakemake lists the files that it reads and makes, until it ends.
LOCKS = ".snakemake/locks"


def check_unlocked(results: str, studies: Iterable[str]) -> None:
    """Raise PlanError if another run in the working folder makes results of a study; a killed run leaves its locks."""
    locked = locked_files()
    for name in studies:
        folder = f"{results}/{name}/"
        if any(path.startswith(folder) for path in locked):
            raise PlanError(
                f"{Path.cwd()}: another run is at work in this folder, on {folder}: wait until it has ended; if it was"
                f" killed, delete {LOCKS} and give the same command again"
            )


def locked_files() -> list[str]:
    """Return the files that runs in the working folder have locked."""
    files: list[str] = []
    for lock in sorted(Path(LOCKS).glob("*.lock")):
        with suppress(OSError):  # the other run may have ended
            files += lock.read_text(encoding="utf-8").splitlines()
    return files
