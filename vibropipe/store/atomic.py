"""Files that appear only when complete, and the check that they are intact.

A file is written under a temporary name in the same directory, flushed to the disk and renamed, so a reader finds the
old file, the new file or none. Data files end in a seal, one line of text with the SHA-256 of all bytes before it. HDF5
ignores what follows its own end, so any tool reads the file, and the seal detects a flipped byte anywhere (checksums of
HDF5 leave out headers and scalars), a truncated file and an empty one.
"""

from __future__ import annotations

import errno
import hashlib
import os
import re
import shutil
import socket
from collections.abc import Collection, Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

HDF5_SIGNATURE = b"\x89HDF\r\n\x1a\n"
SEAL_START = b"\nvibropipe sha256 "
SEAL_LENGTH = len(SEAL_START) + 64 + 1
FINGERPRINT = b" vibropipe fingerprint "
COMMENT_BYTES = 1 << 17
"""Bytes at the end of a figure or report that hold its comment, of at most 1000 names of scenes."""
TEMPORARY_ENDING = ".part"
TEMPORARY_NAME = r"\.(?P<name>.+?)\.(?P<host>[A-Za-z0-9-]*)\.(?P<process>\d{1,9})\.part"

# bytes read at once for a checksum
READ_BYTES = 1 << 20
# errors of a full disk and of an exceeded quota
FULL_DISK_ERRORS = {errno.ENOSPC, getattr(errno, "EDQUOT", errno.ENOSPC)}
MIN_FREE_BYTES = 2_000_000
"""Free bytes below which a disk counts as full: it has no space for two more chunks."""

AGAIN = "delete it and rerun; only missing files are recomputed"


class StoreError(OSError):
    """A dataset cannot be written, read or joined; the message names the file and the remedy."""


class NotWrittenError(StoreError):
    """A file cannot be written: the disk is full, or the folder is not writable."""


@contextmanager
def atomic_file(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield a temporary path beside `path` and rename it to `path` when the block completes.

    Missing folders are created. If the block is left early (an error, Ctrl-C), these folders and the temporary file are
    removed, and `path` is as before.

    Raises NotWrittenError if the disk is full or the folder is not writable; the message names the remedy.
    """
    path = Path(path)
    temporary = _temporary(path)
    new_folders: list[Path] = []
    try:
        new_folders += [folder for folder in path.parents if not folder.exists()]
        path.parent.mkdir(parents=True, exist_ok=True)
        for leftover in _leftovers(path.parent, [path.name], foreign=False):
            leftover.unlink(missing_ok=True)
        temporary.touch()
        yield temporary
        _flush(temporary)
        os.replace(temporary, path)
        _flush(path.parent)
    except StoreError:
        raise
    except (OSError, RuntimeError) as error:  # netCDF4 raises RuntimeError when HDF5 fails
        raise NotWrittenError(_explain(path, error)) from error
    finally:
        with suppress(OSError):
            temporary.unlink()
            # remove folders created for a file that was not written; others are not empty
            for folder in new_folders:
                folder.rmdir()


def seal(path: Path) -> None:
    """Append the seal to a finished file."""
    digest = _digest(path, path.stat().st_size)
    with path.open("ab") as file:
        file.write(SEAL_START + digest + b"\n")


def seal_of(path: str | os.PathLike[str]) -> str:
    """Return the checksum in the seal of a file, which stands for all its bytes; empty without file or seal."""
    end = _last_bytes(Path(path), SEAL_LENGTH)
    match = re.fullmatch(re.escape(SEAL_START) + rb"([0-9a-f]{64})\n", end)
    return match[1].decode() if match else ""


def with_fingerprint(
    content: bytes, fingerprint: str, scenes: Iterable[str] = (), units: str = ""
) -> bytes:
    """Return a PDF or SVG file with a comment at its end: a fingerprint of what it was made from, scenes, and units."""
    is_pdf = content.startswith(b"%PDF-")
    begin, end, mark = (b"%", b"\n", b"startxref") if is_pdf else (b"<!--", b" -->\n", b"</svg>")
    place = content.rindex(mark)
    comment = (
        FINGERPRINT + " ".join([fingerprint, *scenes, *([f"| {units}"] if units else [])]).encode()
    )
    return content[:place] + begin + comment + end + content[place:]


def fingerprint_of(path: str | os.PathLike[str]) -> str:
    """Return the fingerprint that `with_fingerprint` wrote into a file; empty without file or fingerprint."""
    return _comment_of(path)[0].partition(" ")[0]


def scenes_of(path: str | os.PathLike[str]) -> list[str]:
    """Return the scenes that `with_fingerprint` wrote into a file; none without file or scenes."""
    return _comment_of(path)[0].split()[1:]


def units_in(path: str | os.PathLike[str]) -> str:
    """Return the units that `with_fingerprint` wrote into a file; empty without file or units."""
    return _comment_of(path)[1]


def _comment_of(path: str | os.PathLike[str]) -> tuple[str, str]:
    """Return fingerprint with scenes, and units, that `with_fingerprint` wrote; empty without them or the end."""
    end = _last_bytes(Path(path), COMMENT_BYTES)
    match = re.search(FINGERPRINT + rb"([0-9a-f]{64}(?: [a-z]\w*)*)(?: \| ([^\n]*))?", end)
    is_whole = end.rstrip().endswith((b"%%EOF", b"</svg>"))
    return (match[1].decode(), (match[2] or b"").decode()) if match and is_whole else ("", "")


def _last_bytes(path: Path, count: int) -> bytes:
    """Return the last bytes of a file; none if it cannot be read."""
    try:
        with path.open("rb") as file:
            file.seek(max(0, path.stat().st_size - count))
            return file.read()
    except OSError:
        return b""


def check_intact(path: str | os.PathLike[str], every_byte: bool = True) -> None:
    """Check that a file is as it was written.

    every_byte : verify the checksum. Otherwise only the two ends are read, which detects a missing, empty, truncated
        or foreign file of any size, but no flipped byte
    Raises StoreError if the file is not intact.
    """
    path = Path(path)
    if path.is_dir():
        raise StoreError(f"{path}: must be a file, got a folder: name a .nc file in it")
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
    """Return the SHA-256 of the first `length` bytes, in hexadecimal."""
    digest = hashlib.sha256()
    with path.open("rb") as file:
        while length > 0:
            block = file.read(min(READ_BYTES, length))
            if not block:
                break
            digest.update(block)
            length -= len(block)
    return digest.hexdigest().encode()


def _flush(path: Path) -> None:
    """Wait until a file, or the entries of a folder where it can be opened, are on the disk."""
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
    """Remove temporary files of writers that were killed.

    names : names of the files whose writers are meant; all by default
    Call it only if no other machine writes these files: a writer of this machine that still runs is left alone, one
    of another machine counts as ended.
    """
    if Path(folder).is_dir():
        for leftover in _leftovers(Path(folder), names, foreign=True):
            leftover.unlink(missing_ok=True)


def host_name() -> str:
    """Return the host name with characters that a temporary name allows."""
    return re.sub(r"[^A-Za-z0-9-]", "-", socket.gethostname())


def _temporary(path: Path) -> Path:
    """Return the temporary name of a file: it names host and process of the writer."""
    return path.with_name(f".{path.name}.{host_name()}.{os.getpid()}{TEMPORARY_ENDING}")


def _leftovers(folder: Path, names: Collection[str] | None, foreign: bool) -> list[Path]:
    """Return temporary files in a folder whose writers do not run here; those of other machines if `foreign`."""
    leftovers = []
    for path in folder.iterdir():
        match = re.fullmatch(TEMPORARY_NAME, path.name)
        if match is not None and (names is None or match["name"] in names):
            is_local = match["host"] == host_name()
            if not _is_running(int(match["process"])) if is_local else foreign:
                leftovers.append(path)
    return leftovers


def _is_running(process_id: int) -> bool:
    """Return whether a process of this machine runs."""
    if os.name == "nt":  # os.kill would end the process
        return True
    try:
        os.kill(process_id, 0)
    except ProcessLookupError:
        return False
    except OSError:
        return True
    return True


def _explain(path: Path, error: OSError | RuntimeError) -> str:
    """Return the message that says why `path` was not written and what to do."""
    number = getattr(error, "errno", None)
    folder = path.parent
    while not folder.is_dir() and folder != folder.parent:
        folder = folder.parent
    free = shutil.disk_usage(folder).free
    if number in FULL_DISK_ERRORS or free < MIN_FREE_BYTES:
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
