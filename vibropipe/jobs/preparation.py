"""What is done before the jobs of a run: results are locked, folders and datasets checked, leftovers removed."""

from __future__ import annotations

import atexit
import os
import shutil
import tempfile
from collections.abc import Collection, Iterable
from contextlib import suppress
from pathlib import Path

from vibropipe.jobs.earlier import drop_earlier, earlier_file
from vibropipe.jobs.solving import scene_before
from vibropipe.scenes.costs import PlanError
from vibropipe.store import NotWrittenError, StoreError, atomic_file, check_intact, remove_leftovers
from vibropipe.store.atomic import host_name
from vibropipe.store.files import ENDING
from vibropipe.study import Study

# Folders in which a run writes, whatever the folder of results, if they exist.
WORKING_FOLDERS = (".", ".snakemake", "logs")
# Names host and process of the run that makes results, beside them; that process holds a lock on it, which the system
# frees however the process ends.
LOCK = ".run"


def lock_results(results: str, studies: Iterable[str]) -> None:
    """Lock the results of studies until this process ends; raise PlanError if another run makes them.

    The lock of a process of this host that has ended counts no more.
    """
    for path in (Path(results, study, LOCK) for study in studies):
        path.parent.mkdir(parents=True, exist_ok=True)
        descriptor = _locked(path)
        atexit.register(path.unlink, missing_ok=True)
        os.ftruncate(descriptor, 0)
        os.pwrite(descriptor, f"{host_name()} {os.getpid()}".encode(), 0)


def _locked(path: Path) -> int:
    """Return the descriptor of a lock that this process holds now."""
    while True:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT)
        is_free = _lock(descriptor)
        host, _, process = os.read(descriptor, 1000).decode().partition(" ")
        if not is_free or host not in ("", host_name()):
            os.close(descriptor)
            remedy = f"if it was killed there, delete {path} and give the same command again"
            raise PlanError(
                f"{path.parent}: another run makes it (process {process or 'unknown'} on {host or 'this host'}): wait"
                f" until it has ended{'' if host in ('', host_name()) else f'; {remedy}'}"
            )
        # a run that ends removes its lock
        if path.exists() and os.path.samestat(os.fstat(descriptor), path.stat()):
            return descriptor
        os.close(descriptor)


def _lock(descriptor: int) -> bool:
    """Lock an open file; return whether no other process has locked it, also where nothing can be locked."""
    try:
        import fcntl

        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except (ImportError, OSError):
        return True
    return True


def check_working_folder() -> None:
    """Raise NotWrittenError unless the working folder, where snakemake keeps records and logs, can be written."""
    for folder in filter(Path.is_dir, map(Path, WORKING_FOLDERS)):
        try:
            with tempfile.TemporaryFile(dir=folder):
                pass
        except OSError as error:
            raise NotWrittenError(
                f"{folder.absolute()}: cannot be written ({error.strerror}), but the records and logs of a run are kept"
                " there: call it in another folder, or change the permissions of this one"
            ) from None


def check_writable(results: str, studies: Iterable[str] = ()) -> None:
    """Create the folders of results of studies, and raise NotWrittenError unless files can be written there."""
    for folder in (Path(results), *(Path(results, study) for study in studies)):
        try:
            folder.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryFile(dir=folder):
                pass
        except OSError as error:
            raise NotWrittenError(
                f"{folder}: cannot be written ({error.strerror}): change its permissions, free disk space, or name"
                " another folder of results, by --results or under `results` in config/config.yaml"
            ) from None


def check_whole(paths: Iterable[str]) -> None:
    """Raise StoreError if a dataset is truncated. Snakemake deletes what a job makes before the job can find it out."""
    for path in dict.fromkeys(paths):
        if Path(path).suffix == ENDING and Path(path).is_file():
            check_intact(path, every_byte=False)


def keep_earlier(results: str, study: Study, stale: Collection[str]) -> None:
    """Keep the dataset of each scene that is made again because values were added to its grids, under a second name.

    Snakemake deletes what a job makes before the job could read it. The job that completes the new dataset removes the
    earlier one; that of a dataset that is up to date is removed here.
    """
    folder = Path(results, study.name)
    for kept in folder.glob("shards/*/earlier.nc"):
        path = folder / f"{kept.parent.name}.nc"
        if str(path) not in stale:
            drop_earlier(path)
    for name, scene in study.scenes.items():
        path = folder / f"{name}.nc"
        if str(path) in stale and path.is_file():
            with suppress(StoreError):
                scene_before(study, scene, path)
                kept = earlier_file(path)
                kept.parent.mkdir(parents=True, exist_ok=True)
                with atomic_file(kept) as temporary:
                    temporary.unlink()
                    try:
                        os.link(path, temporary)
                    except OSError:  # a file system without hard links
                        shutil.copyfile(path, temporary)


def clear_leftovers(paths: Iterable[str]) -> None:
    """Remove the hidden files that killed writers of these files left; the caller holds the locks of the files."""
    by_folder: dict[Path, set[str]] = {}
    for path in map(Path, paths):
        by_folder.setdefault(path.parent, set()).add(path.name)
    for folder, names in by_folder.items():
        # all files here belong to one sweep, which may have been cut into another number of shards
        remove_leftovers(folder, None if folder.parent.name == "shards" else names)
