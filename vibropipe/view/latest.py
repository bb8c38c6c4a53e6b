"""Work beside the page: only the newest request is answered, as a slider that moves asks faster than it is solved."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from functools import partial
from typing import Any

Background = Callable[[Callable[[], None]], None]
Later = Callable[[Callable[[], None]], Any]


def in_thread(work: Callable[[], None]) -> None:
    """Do work beside the page."""
    threading.Thread(target=work, daemon=True).start()


class Latest:
    """One worker: while it works, the newest request waits, and older ones are forgotten.

    background : takes work to do beside the page
    later : takes work to do on the page, from any thread
    rest : seconds without another request before work begins
    """

    def __init__(self, background: Background, later: Later, rest: float = 0.0) -> None:
        self._background, self._later, self._rest = background, later, rest
        self._wanted: tuple[Callable[[], Any], Callable[[Any], None]] | None = None
        self._is_busy = False
        # of the last work, so that a page can say beforehand that the next one takes long
        self.seconds = 0.0

    def request(self, work: Callable[[], Any], answer: Callable[[Any], None]) -> None:
        """Have work done; `answer` is called on the page with its result, or with the exception that it raised."""
        self._wanted = work, answer
        if not self._is_busy:
            self._begin()

    def drop(self) -> None:
        """Forget what was requested and is not answered."""
        self._wanted = None

    def _begin(self) -> None:
        self._is_busy, wanted = True, self._wanted

        def run() -> None:
            result: Any = None
            if self._rest:
                time.sleep(self._rest)
            if wanted is not None and wanted is self._wanted:
                begun = time.monotonic()
                try:
                    result = wanted[0]()
                except Exception as error:  # told on the page: nobody else waits for this work
                    result = error
                self.seconds = time.monotonic() - begun
            self._later(partial(self._end, wanted, result))

        self._background(run)

    def _end(self, wanted: Any, result: Any) -> None:
        self._is_busy = False
        if self._wanted is None:
            return
        if wanted is not self._wanted:
            self._begin()
            return
        self._wanted = None
        wanted[1](result)
