"""How long work reports how far it has come."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

Progress = Callable[[int, int], None]
"""Called as `progress(done, total)`; `total` is 0 while it is unknown."""


@dataclass
class WorkCount:
    """Counts the steps of some work for its progress.

    total : all steps, or 0 if that is unknown
    progress : called whenever steps are added
    """

    total: int
    progress: Progress | None = None
    done: int = 0

    def add(self, n: int = 1) -> None:
        """Count n steps more, at most up to the total."""
        self.done = min(self.done + n, self.total) if self.total else self.done + n
        if self.progress is not None:
            self.progress(self.done, self.total)


def part_of(progress: Progress | None, before: int, total: int) -> Progress | None:
    """Return the callback of a part of some work, which reports the progress of all of it; None without one.

    progress : the callback of all the work
    before : what is done before the part begins
    total : all the work, or 0 if that is unknown
    """
    if progress is None:
        return None

    def on_part(done: int, _total: int) -> None:
        done += before
        progress(min(done, total) if total else done, total)

    return on_part
