"""Files that appear only when whole, and the proof that they still are.

A file is written under a temporary name beside its place, flushed to the disk, and renamed: a
reader finds the old file, the new file, or none. Data files end in a seal, one line of text with
the SHA-256 of all bytes before it. HDF5 ignores what follows its own end, so any tool reads the
file, and yet one flipped byte anywhere in it (HDF5's own checksums leave out headers and
scalars), a lost tail or an empty file is found.
"""

from __future__ import annotations

import errno
import hashlib
import os
import re
import shutil
import socket
from collections.abc import Collection, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

HDF5_SIGNATURE = b"\x89HDF\r\n\x1a\n"
SEAL_START = b"\nvibropipe sha256 "
SEAL_LENGTH = len(SEAL_START) + 64 + 1
TEMPORARY_ENDING = ".part"
SCRATCH = ".rows"
TEMPORARY_NAME = r"\.(?P<name>.+?)(\.rows)?\.(?P<host>[A-Za-z0-9-]*)\.(?P<process>\d{1,9})\.part"

READ_AT_ONCE = 1 << 20
# what a full disk, or a quota where there are any, answers
FULL = {errno.ENOSPC, getattr(errno, "EDQUOT", errno.ENOSPC)}
FULL_BELOW = 2_000_000
"""A disk with fewer free bytes than this is called full: it cannot take two more chunks."""

AGAIN = "delete it and rerun; only missing files are recomputed"


class StoreError(OSError):
    """A dataset cannot be written, read or joined; the message names the file and the remedy."""


class NotWrittenError(StoreError):
    """A file cannot be written: the disk is full, or the folder is write-protected."""


@contextmanager
def atomic_file(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield a temporary path beside ``path``; when the block ends well, it becomes ``path``.

    Missing folders are made. Whatever ends the block early (an error, Ctrl-C) removes them and the
    temporary file, and leaves what was at ``path``. Raises NotWrittenError, with what to do, when
    the disk is full or the folder cannot be written.
    """
    path = Path(path)
    with _file_beside(path) as temporary:
        yield temporary
        _flush(temporary)
        os.replace(temporary, path)
        _flush(path.parent)


@contextmanager
def scratch_file(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield the path of another file beside ``path`` for what goes into it; it is gone when the block ends.

    Folders are made and errors told as by :func:`atomic_file`.
    """
    with _file_beside(Path(path), SCRATCH) as scratch:
        yield scratch


@contextmanager
def _file_beside(path: Path, kind: str = "") -> Iterator[Path]:
    temporary = _temporary(path, kind)
    made: list[Path] = []
    try:
        made += [folder for folder in path.parents if not folder.exists()]
        path.parent.mkdir(parents=True, exist_ok=True)
        for found in _leftovers(path.parent, [path.name], foreign=False):
            found.unlink(missing_ok=True)
        temporary.touch()
        yield temporary
    except StoreError:
        raise
    except (OSError, RuntimeError) as error:  # netCDF4 raises RuntimeError when HDF5 fails
        raise NotWrittenError(_explain(path, error)) from error
    finally:
        with suppress(OSError):
            temporary.unlink()
            # a folder made for a file that did not come about is not left behind either; others are not empty
            for folder in made:
                folder.rmdir()


def seal(path: Path) -> None:
    """Append the seal to a finished file."""
    digest = _digest(path, path.stat().st_size)
    with path.open("ab") as file:
        file.write(SEAL_START + digest + b"\n")


def check_intact(path: str | os.PathLike[str], every_byte: bool = True) -> None:
    """Raise StoreError, naming the file, unless it is as it was written.

    ``every_byte=False`` looks at its two ends alone: a missing, empty, truncated or foreign file
    is found at once whatever its size, a flipped byte is not.
    """
    path = Path(path)
    try:
        size = path.stat().st_size
        with path.open("rb") as file:
            start = file.read(len(HDF5_SIGNATURE))
            file.seek(max(0, size - SEAL_LENGTH))
            end = file.read()
    except OSError as error:
        raise StoreError(f"{path}: cannot be read: {error.strerror}") from error
    if size == 0:
        raise StoreError(f"{path}: is empty: {AGAIN}")
    if start != HDF5_SIGNATURE and path.suffix not in (".nc", TEMPORARY_ENDING):
        raise StoreError(f"{path}: is no dataset (not a netCDF4 file): name a .nc file")
    if start != HDF5_SIGNATURE:
        raise StoreError(f"{path}: is damaged or is not a netCDF4 file: {AGAIN}")
    if not re.fullmatch(re.escape(SEAL_START) + rb"[0-9a-f]{64}\n", end):
        raise StoreError(f"{path}: is truncated or was changed since it was written: {AGAIN}")
    if every_byte and _digest(path, size - SEAL_LENGTH) != end[len(SEAL_START) : -1]:
        raise StoreError(f"{path}: is damaged (its checksum does not match): {AGAIN}")


def _digest(path: Path, length: int) -> bytes:
    """Return the SHA-256 of the first ``length`` bytes, in hexadecimal."""
    digest = hashlib.sha256()
    with path.open("rb") as file:
        while length > 0:
            block = file.read(min(READ_AT_ONCE, length))
            if not block:
                break
            digest.update(block)
            length -= len(block)
    return digest.hexdigest().encode()


def _flush(path: Path) -> None:
    """Wait until a file, or the names in a folder where one can be opened, are on the disk."""
    try:
        descriptor = os.open(path, os.O_RDWR if path.is_file() else os.O_RDONLY)
    except PermissionError:
        if path.is_file():
            raise
        return
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def remove_leftovers(folder: str | os.PathLike[str], names: Collection[str] | None = None) -> None:
    """Remove what killed writers of the files ``names`` (of any, if left out) left in ``folder``.

    For one who knows that nobody else writes these files. Whether a writer of this machine still
    runs can be asked, and it is left alone then; one of another machine counts as dead.
    """
    if Path(folder).is_dir():
        for found in _leftovers(Path(folder), names, foreign=True):
            found.unlink(missing_ok=True)


def _host() -> str:
    return re.sub(r"[^A-Za-z0-9-]", "-", socket.gethostname())


def _temporary(path: Path, kind: str = "") -> Path:
    return path.with_name(f".{path.name}{kind}.{_host()}.{os.getpid()}{TEMPORARY_ENDING}")


def _leftovers(folder: Path, names: Collection[str] | None, foreign: bool) -> list[Path]:
    """Temporary files in a folder whose writers do not run here; those of other machines if ``foreign``."""
    left = []
    for found in folder.iterdir():
        parts = re.fullmatch(TEMPORARY_NAME, found.name)
        if parts is not None and (names is None or parts["name"] in names):
            here = parts["host"] == _host()
            if not _is_running(int(parts["process"])) if here else foreign:
                left.append(found)
    return left


def _is_running(process: int) -> bool:
    if os.name == "nt":  # there, a signal of any number ends the process
        return True
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except OSError:
        return True
    return True


def _explain(path: Path, error: OSError | RuntimeError) -> str:
    """Return why ``path`` was not written, and the remedy."""
    number = getattr(error, "errno", None)
    folder = path.parent
    while not folder.is_dir() and folder != folder.parent:
        folder = folder.parent
    free = shutil.disk_usage(folder).free
    if number in FULL or free < FULL_BELOW:
        return (
            f"{path}: was not written: the disk is full ({free / 1e6:.1f} MB free in {folder}). "
            "Free disk space and rerun the command; completed files are kept"
        )
    if number in (errno.EACCES, errno.EPERM, errno.EROFS):
        return (
            f"{path}: was not written: {folder} does not allow it ({os.strerror(number)}). "
            "Change its permissions, or choose another folder for the results"
        )
    return f"{path}: was not written: {getattr(error, 'strerror', None) or error}"
