"""Derivatives of the equations of a law, beside central differences."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from vibropipe.orbits.law.equations import fill_blocks, new_blocks
from vibropipe.physics.derivatives import ALL_DIFFERENTIATED

STEP = 1e-6


def slopes(e: Any, p: Any, law: Any, u: np.ndarray) -> Iterator[tuple[Any, Any, Any]]:
    """Yield each unknown (event, number) and each parameter, with the derivative by it and the difference.

    Stiffnesses of supports that are rigid are left out: with another value they are those of another exciter.
    """
    n, columns = len(u), np.arange(len(ALL_DIFFERENTIATED))
    exact, beside = new_blocks(n, columns.size, e.housing), new_blocks(n, 0, e.housing)
    fill_blocks(e, p, law, u, columns, exact)

    def rests(q: Any, v: np.ndarray) -> Any:
        fill_blocks(e, q, law, v, np.zeros(0, np.int64), beside)
        return beside.rest.copy()

    for i, j in np.ndindex(u.shape):
        up, down = u.copy(), u.copy()
        up[i, j] += STEP
        down[i, j] -= STEP
        own = np.zeros(u.shape)
        own[i] += exact.at[i, :, j]
        own[(i + 1) % n] += exact.before[(i + 1) % n, :, j]
        yield (i, j), own, (rests(p, up) - rests(p, down)) / (2.0 * STEP)
    for k, name in enumerate(ALL_DIFFERENTIATED):
        value = getattr(p, name)
        if name not in ("k1", "k2") or value != 0.0:
            ends = [rests(p._replace(**{name: value + off}), u) for off in (STEP, -STEP)]
            yield name, exact.by[:, :, k], (ends[0] - ends[1]) / (2.0 * STEP)
