"""Progress of long work: a bar on a terminal, plain lines in a log."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from functools import partial
from typing import TextIO

from vibropipe.words.progress import Progress
from vibropipe.words.wording import count

# Seconds between two drawings of the bar: one takes about a millisecond, so the share stays far below 1 %.
BAR_SECONDS = 0.5
# Seconds until the first line of a log, and the largest interval; the intervals double in between.
FIRST_LINE, MAX_LINE_INTERVAL = 5.0, 300.0


@contextmanager
def show_progress(
    title: str, unit: str = "rows", stream: TextIO | None = None
) -> Iterator[Progress]:
    """Show the progress of the work done inside this context, as a bar on a terminal, else in lines.

    title : text before each line or bar
    stream : where it is shown (default: stderr)
    Yields the callback of the work. A call that shows nothing is cheap; nothing is shown before the first call.
    """
    stream = sys.stderr if stream is None else stream
    on_terminal = stream.isatty()
    begin, due = time.perf_counter(), 0.0 if on_terminal else FIRST_LINE
    with _bar(title, stream) if on_terminal else nullcontext() as bar:

        def on_progress(done: int, total: int) -> None:
            nonlocal due
            elapsed = time.perf_counter() - begin
            if elapsed < due and (done < total or not total):
                return
            text = progress_text(done, total, elapsed, unit)
            if bar is None:
                due = elapsed + min(elapsed, MAX_LINE_INTERVAL)
                print(f"{title}: {text}", file=stream, flush=True)
            else:
                due = elapsed + BAR_SECONDS
                bar(completed=done, total=total or None, text=text, visible=True, refresh=True)

        yield on_progress


@contextmanager
def _bar(title: str, stream: TextIO) -> Iterator[Callable[..., None]]:
    """Yield a function that draws the bar. It starts no thread of its own, because the kernels use all of them."""
    from rich.console import Console
    from rich.progress import BarColumn, TextColumn
    from rich.progress import Progress as Bar

    columns = (
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        TextColumn("{task.fields[text]}"),
    )
    with Bar(*columns, console=Console(file=stream), auto_refresh=False) as bar:
        yield partial(bar.update, bar.add_task(title, total=None, text="", visible=False))


def progress_text(done: int, total: int, elapsed: float, unit: str) -> str:
    """Return the points done, the rate, and the time left at this rate.

    done, total : points done, and all points; `total` is 0 where it is unknown
    elapsed : seconds so far
    """
    rate = done / elapsed
    speed = f"{rate:,.0f} {unit}/s" if rate >= 100 else f"{rate:.3g} {unit}/s"
    one = unit.removesuffix("es") if unit.endswith("ches") else unit.removesuffix("s")
    if not total:
        return f"{count(done, one, unit)}, {speed}"
    if done >= total:
        return f"{count(total, one, unit)} in {_span(elapsed)}, {speed}"
    time_left = f", {_span((total - done) / rate)} left" if done else ""
    return f"{done:,} of {count(total, one, unit)}, {speed}{time_left}"


def _span(seconds: float) -> str:
    """Return a duration as text: seconds, minutes with seconds, or hours with minutes."""
    if seconds < 60:
        return f"{seconds:.0f} s" if seconds >= 9.5 else f"{seconds:.1f} s"
    minutes, seconds_left = divmod(round(seconds), 60)
    if minutes < 60:
        return f"{minutes} min {seconds_left:02d} s"
    return f"{minutes // 60} h {minutes % 60:02d} min"
