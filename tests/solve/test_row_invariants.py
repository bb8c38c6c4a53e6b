"""Labels and numbers of random rows are consistent, with corner cases favoured (`random_rows`, `row_checks`)."""

from __future__ import annotations

import numpy as np
import pytest
from random_rows import draw_rows, solve_drawn
from row_checks import broken_rows
from sampling import sampled

from vibropipe.physics.exciter import Parameters

PIECE = 20_000


# The first, of few rows, always run; on request ten million rows do.
SEEDS = [*((seed, PIECE // 4) for seed in range(8)), *((seed, PIECE) for seed in range(5, 505))]


@pytest.mark.parametrize(("seed", "n"), sampled(SEEDS))
def test_labels_and_numbers_of_rows_agree(seed: int, n: int) -> None:
    parameters = draw_rows(seed, n)
    broken = broken_rows(solve_drawn(parameters))
    examples = {
        name: [Parameters(*parameters[row].tolist()) for row in rows[:3]]
        for name, rows in broken.items()
    }
    assert not broken, f"seed {seed}: {examples}"


def test_corners_are_among_the_rows() -> None:
    nu, f, h, half, delta, one, two = draw_rows(0, PIECE).T
    for corner in (
        h == 0, one == 0, one == 1, two == 0, two == 1, delta == half, delta == -half, f == 0,
        np.abs(delta) > half, nu > 1000, nu < 0.05,
    ):  # fmt: skip
        assert corner.sum() > PIECE / 200
