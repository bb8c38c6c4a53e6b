"""Errors stated by rows of random exciters against long arithmetic: linear motions, orbits with impacts, with rests."""

from __future__ import annotations

from collections import Counter, defaultdict

import numpy as np
import pytest
from true_rows import draw_exciters, error_ratios, orbits


def compare_rows(seed: int, n: int) -> tuple[Counter[str], dict[tuple[str, str], np.ndarray]]:
    """Return the number of rows of each sort, and true over stated errors by sort and quantity."""
    count, ratios = Counter[str](), defaultdict(list)
    for sort, p, row in orbits(draw_exciters(seed, n)):
        count[sort] += 1
        for name, ratio in error_ratios(sort, p, row).items():
            ratios[sort, name].append(ratio)
    return count, {key: np.array(values) for key, values in ratios.items()}


def test_stated_errors_hold_for_a_few_exciters() -> None:
    count, ratios = compare_rows(5, 40)
    assert min(count["linear"], count["struck"], count["resting"]) >= 2
    assert len(ratios) == 6 + 9 + 8
    for key, values in ratios.items():
        # One in a hundred may be larger; none of these is.
        assert values.max() < 3.0, key


@pytest.mark.slow
def test_stated_errors_hold_for_two_thousand_exciters() -> None:
    count, ratios = compare_rows(2, 2300)
    assert count.total() >= 2000
    assert min(count["linear"], count["resting"]) >= 150
    for key, values in ratios.items():
        assert (values > 3.0).mean() <= 0.01, key
        assert values.max() < 30.0, key
        # An error that is always far too large would pass as well.
        assert np.median(values) > 0.005 or values.max() == 0.0, key
