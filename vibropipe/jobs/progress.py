"""How far long work has come: a bar on a terminal, plain lines in a log."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TextIO

__all__ = ["Progress", "shown", "words"]

Progress = Callable[[int, int], None]
"""Is told (points done, points in all) again and again; 0 in all where that is not known."""

# A drawing of the bar takes about a millisecond: at most one in so many seconds stays far below 1 %.
BAR_SECONDS = 0.5
# Lines of a log: the first after so many seconds, the next ones ever later, at most so far apart.
FIRST_LINE, FURTHEST_LINES = 5.0, 300.0


@contextmanager
def shown(title: str, unit: str = "rows", stream: TextIO | None = None) -> Iterator[Progress]:
    """Show the progress of the work done inside this on ``stream`` (stderr if left out).

    Nothing is shown before the first word of it. Yields what is to be told; a call costs next to
    nothing unless it is time to show something again.
    """
    stream = sys.stderr if stream is None else stream
    with _bar(title, unit, stream) if stream.isatty() else _lines(title, unit, stream) as told:
        yield told


@contextmanager
def _lines(title: str, unit: str, stream: TextIO) -> Iterator[Progress]:
    """Write lines, and a last one when all is done."""
    begin, due = time.perf_counter(), FIRST_LINE

    def told(done: int, total: int) -> None:
        nonlocal due
        elapsed = time.perf_counter() - begin
        if elapsed < due and (done < total or not total):
            return
        due = elapsed + min(elapsed, FURTHEST_LINES)
        print(f"{title}: {words(done, total, elapsed, unit)}", file=stream, flush=True)

    yield told


@contextmanager
def _bar(title: str, unit: str, stream: TextIO) -> Iterator[Progress]:
    """Draw a bar; no thread of its own, the kernels have all of them."""
    from rich.console import Console
    from rich.progress import BarColumn, TextColumn
    from rich.progress import Progress as Bar

    columns = (
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        TextColumn("{task.fields[said]}"),
    )
    with Bar(*columns, console=Console(file=stream), auto_refresh=False) as bar:
        task = bar.add_task(title, total=None, said="", visible=False)
        begin, due = time.perf_counter(), 0.0

        def told(done: int, total: int) -> None:
            nonlocal due
            elapsed = time.perf_counter() - begin
            if elapsed < due and (done < total or not total):
                return
            due = elapsed + BAR_SECONDS
            said = words(done, total, elapsed, unit)
            known = total or None  # a bar that only moves
            bar.update(task, completed=done, total=known, said=said, visible=True, refresh=True)

        yield told


def words(done: int, total: int, elapsed: float, unit: str) -> str:
    """Return how much is done, how fast, and the time left if the rest goes as fast."""
    rate = done / elapsed
    speed = f"{rate:,.0f} {unit}/s" if rate >= 100 else f"{rate:.3g} {unit}/s"
    if not total:
        return f"{done:,} {unit}, {speed}"
    if done >= total:
        return f"{total:,} {unit} in {_span(elapsed)}, {speed}"
    left = f", {_span((total - done) / rate)} left" if done else ""
    return f"{done:,} of {total:,} {unit}, {speed}{left}"


def _span(seconds: float) -> str:
    """Return a length of time as people say it."""
    if seconds < 60:
        return f"{seconds:.0f} s" if seconds >= 9.5 else f"{seconds:.1f} s"
    minutes, rest = divmod(round(seconds), 60)
    if minutes < 60:
        return f"{minutes} min {rest:02d} s"
    return f"{minutes // 60} h {minutes % 60:02d} min"
