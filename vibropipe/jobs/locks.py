"""Locks of snakemake: which results another run in this folder is making, and which locks a killed run left.

Snakemake's locks do not say whose they are. Each run of the workflow therefore keeps a record beside them, named after
its host and process and itself locked by the operating system, which frees it when the process ends, however it ends.
"""

from __future__ import annotations

import atexit
import os
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

from vibropipe.scenes.costs import PlanError
from vibropipe.store.atomic import host_name

# Where a run of snakemake lists the files that it reads and makes, until it ends.
LOCKS = Path(".snakemake/locks")
# Suffix of the record of a run, <host>.<process>.run, which names its locks as soon as they are made.
RECORD = ".run"


class RunRecord:
    """The record of this run beside the locks of snakemake; it counts as long as the process runs."""

    def __init__(self) -> None:
        self.path = LOCKS / f"{host_name()}.{os.getpid()}{RECORD}"
        self.descriptor = -1

    def write(self) -> None:
        """Write the record with the locks that no other run has: once before snakemake makes them, and once after."""
        if self.descriptor < 0:
            atexit.register(self.path.unlink, missing_ok=True)
        else:
            os.close(self.descriptor)
        LOCKS.mkdir(parents=True, exist_ok=True)  # another run that ended has removed it
        self.descriptor = os.open(self.path, os.O_RDWR | os.O_CREAT)
        with suppress(ImportError, OSError):  # where nothing can be locked the run counts as alive
            import fcntl

            fcntl.flock(self.descriptor, fcntl.LOCK_EX)
        taken = {name for record in _records() if record != self.path for name in _lines(record)}
        own = [lock.name for lock in _locks() if lock.name not in taken]
        os.truncate(self.descriptor, 0)
        os.write(self.descriptor, "\n".join(own).encode())


def drop_dead_locks() -> None:
    """Remove the locks of runs on this host that have ended without removing them."""
    dead = [record for record in _records() if _is_dead(record)]
    alive = [record for record in _records() if record not in dead]
    for lock in _locks():
        if _owners(lock, dead) and not _owners(lock, alive):
            lock.unlink(missing_ok=True)
    for record in dead:
        record.unlink(missing_ok=True)


def check_unlocked(results: str, studies: Iterable[str]) -> None:
    """Raise PlanError if another run in the working folder makes results of a study."""
    for name in studies:
        folder = f"{results}/{name}/"
        for lock in _locks():
            if any(path.startswith(folder) for path in _lines(lock)):
                raise PlanError(
                    f"{Path.cwd()}: another run is at work in this folder, on {folder}{_remedy(lock)}"
                )


def _remedy(lock: Path) -> str:
    """Write whose a lock is, as far as known, and what to do."""
    owners = _owners(lock, _records())
    host, _, process = owners[0].stem.rpartition(".") if owners else ("", "", "")
    if host == host_name():
        return f" (process {process}): wait until it has ended"
    whose, there = (f" (process {process} on {host})", " there") if owners else ("", "")
    return f"{whose}: wait until it has ended; if it was killed{there}, delete {LOCKS} and give the same command again"


def _owners(lock: Path, records: Iterable[Path]) -> list[Path]:
    """Return the records that name a lock, and those without names, whose runs may have made it just now."""
    return [record for record in records if not (names := _lines(record)) or lock.name in names]


def _locks() -> list[Path]:
    return sorted(LOCKS.glob("*.lock"))


def _records() -> list[Path]:
    return sorted(LOCKS.glob(f"*{RECORD}"))


def _lines(path: Path) -> list[str]:
    with suppress(OSError):  # the other run may have ended
        return path.read_text(encoding="utf-8").splitlines()
    return []


def _is_dead(record: Path) -> bool:
    """Return whether a run was on this host and has ended."""
    if record.stem.rpartition(".")[0] != host_name():
        return False
    with (
        suppress(ImportError, OSError),
        record.open() as file,
    ):  # an error: the run holds its record
        import fcntl

        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        return True
    return False
