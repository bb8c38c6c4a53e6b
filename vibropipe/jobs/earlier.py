"""The earlier dataset of a scene that is made again: its file, and words on the rows that are taken from it."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

from vibropipe.words.wording import part_text

# Entries of sidecars: how many rows are those of the earlier result, or why none is.
TAKEN, NOT_TAKEN = "taken", "not_taken"
NONE_TAKEN = "no row taken from the earlier result"


def taken_text(taken: int, rows: int) -> str:
    """Write how many rows of a scene are those of its earlier dataset."""
    return f"{part_text(taken, rows, 'row')} taken from the earlier result" if taken else NONE_TAKEN


def earlier_file(path: Path) -> Path:
    """Return the file that keeps the earlier dataset of a scene while that of `path` is made again."""
    return path.parent / "shards" / path.stem / "earlier.nc"


def drop_earlier(path: Path) -> None:
    """Remove the earlier dataset of a scene, and its folder if nothing else is in it."""
    file = earlier_file(path)
    if file.exists():
        file.unlink()
        with suppress(OSError):  # shards are there
            file.parent.rmdir()
            file.parent.parent.rmdir()
