"""The labels of a sweep against brute force: 5,000 forcing periods marched, then the section compared."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from vibropipe.march.grid import exact_grid
from vibropipe.march.log import clear_log, new_log
from vibropipe.march.state import initial_state
from vibropipe.orbits.outputs import count_contacts, regime_of
from vibropipe.orbits.recurrence import MAX_LONG_MULTIPLE
from vibropipe.orbits.return_map import at_period_zero, march_periods, state_xv
from vibropipe.physics.effects import ALL_EFFECTS
from vibropipe.physics.exciter import Parameters
from vibropipe.physics.flow import DEGREE
from vibropipe.solve.rows.many import Rows, solve_rows
from vibropipe.solve.sweep.blocks import LIMITS
from vibropipe.solve.threads import row_blocks
from vibropipe.words.regimes import Chaos, Regime

PATIENT = 5000
REPEATS = 1e-7


def patient(p: Parameters, patience: int) -> tuple[int, int]:
    """Return (regime, multiple) after `patience` periods; (aperiodic, 0) if the section does not repeat."""
    grid, log, c = exact_grid(ALL_EFFECTS, p), new_log(8192, 512), np.empty(DEGREE + 1)
    most = np.int64(10_000_000)
    state = initial_state(ALL_EFFECTS, p, grid, 0.0, 0.0, 0.0, None)
    state, _ = march_periods(ALL_EFFECTS, p, grid, state, np.int64(patience), log, c, most)
    sections, contacts = [state_xv(p, state)], []
    for _ in range(MAX_LONG_MULTIPLE):
        clear_log(log)
        start = at_period_zero(state)
        state, _ = march_periods(ALL_EFFECTS, p, grid, start, np.int64(1), log, c, most)
        sections.append(state_xv(p, state))
        impacts, rests = np.zeros(2), np.zeros(2)
        count_contacts(log, state, impacts, rests, np.zeros(2))
        contacts.append((impacts, rests))
    changes = np.abs(np.subtract(sections[-2::-1], sections[-1])).max(axis=1)
    if changes.min() >= REPEATS:
        return int(Regime.APERIODIC), 0
    m = int(np.argmax(changes < REPEATS)) + 1
    impacts, rests = (sum(pair[i] for pair in contacts[-m:]) for i in (0, 1))
    return int(regime_of(impacts, rests)), m


def reference_rows(points: int, seed: int) -> np.ndarray:
    """Rows of the reference sweep."""
    rng = np.random.default_rng(seed)
    nu, f = rng.uniform(0.3, 3, points), rng.uniform(0.05, 2, points)
    return np.array(
        [Parameters(*point, 0.2, 0.5, 0.0, 0.7, 0.7) for point in zip(nu, f, strict=True)]
    )


def random_rows(points: int, seed: int) -> np.ndarray:
    """Rows from a wide range of all parameters; half of them are unsymmetric."""
    rng = np.random.default_rng(seed)
    low, high = [0.5, -3.0, 0.01, 0.5, -0.4, 0.3, 0.3], [5.0, 3.0, 1.0, 0.5, 0.4, 0.95, 0.95]
    rows = rng.uniform(low, high, (points, 7))
    rows[::2, 4], rows[::2, 6] = 0.0, rows[::2, 5]
    return np.array([Parameters(*row) for row in rows])


def weakly_damped_rows(points: int, seed: int) -> np.ndarray:
    """The same with hardly any loss, where chaos lasts longest before it ends."""
    rows, rng = random_rows(points, seed), np.random.default_rng(seed + 100)
    rows[:, 2] = 10 ** rng.uniform(-2.7, -2, points)
    rows[:, 5:7] = rng.uniform(0.9, 0.98, (points, 2))
    rows[::2, 6] = rows[::2, 5]
    return rows


def disagreements(rows: np.ndarray, patience: int) -> list[tuple[object, ...]]:
    """Return (row, expected, found, code of chaos) of rows with another label after `patience` periods.

    A march that has not come close to the orbit by then is continued.
    """
    alone = Rows(lambda a, b: [rows[a:b]], (0.0, 0.0))
    ((_, (solved,)),) = solve_rows(row_blocks(len(rows)), alone, LIMITS, 0, ())
    labels = list(zip(solved.regime.tolist(), solved.period_multiple.tolist(), strict=True))
    assert len(np.unique(solved.regime)) > 3
    differing: list[tuple[object, ...]] = []
    for row, label, chaos in zip(rows, labels, solved.chaos.tolist(), strict=True):
        expected = patient(Parameters(*row), patience)
        if expected != label and patient(Parameters(*row), 20 * patience) != label:
            differing.append((row.tolist(), expected, label, chaos))
    return differing


def test_labels_agree_with_patience() -> None:
    assert disagreements(reference_rows(100, seed=7), PATIENT) == []


def test_labels_of_random_rows_agree_with_patience() -> None:
    assert disagreements(random_rows(100, seed=9), PATIENT) == []


@pytest.mark.slow
@pytest.mark.parametrize(
    ("draw", "per_draw"), [(reference_rows, 2.0), (random_rows, 1.0), (weakly_damped_rows, 12.0)]
)
def test_labels_agree_with_patience_at_length(
    draw: Callable[[int, int], np.ndarray], per_draw: float
) -> None:
    """Of draws of 1,000 rows. Chaos may last longer than it is followed; no other label differs."""
    draws = [disagreements(draw(1000, seed), PATIENT) for seed in (1, 2, 3)]
    regular = [each for draw in draws for each in draw if each[-1] != Chaos.IN_WINDOW]
    assert not regular, regular
    assert sum(map(len, draws)) <= 3 * per_draw, draws
