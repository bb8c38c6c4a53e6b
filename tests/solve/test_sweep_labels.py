"""The labels of a sweep against brute force: 5,000 forcing periods marched, then the section compared."""

from __future__ import annotations

import numpy as np
import pytest

import vibropipe as vp
from vibropipe.march.grid import exact_grid
from vibropipe.march.log import new_log
from vibropipe.march.state import initial_state
from vibropipe.orbits.outputs import count_contacts, regime_of
from vibropipe.orbits.return_map import at_period_zero, clear_log, march_periods, state_xv
from vibropipe.physics.effects import ALL_EFFECTS
from vibropipe.physics.flow import DEGREE
from vibropipe.solve.rows import solve_rows
from vibropipe.solve.sweep import MAX_PERIODS, PATIENCE
from vibropipe.solve.sweep_grid import row_blocks
from vibropipe.words.parameters import PARAMETERS
from vibropipe.words.regimes import Regime

PATIENT = 5000
MULTIPLES = 32
REPEATS = 1e-7


def patient(nu: float, f: float, patience: int) -> tuple[int, int]:
    """Return (regime, multiple) after `patience` periods; (aperiodic, 0) if the section does not repeat."""
    p = vp.Exciter(l=0.5, h=0.2, R1=0.7, R2=0.7, nu=nu, f=f).parameters()
    grid, log, c = exact_grid(ALL_EFFECTS, p), new_log(8192, 512), np.empty(DEGREE + 1)
    most = np.int64(10_000_000)
    state = initial_state(ALL_EFFECTS, p, grid, 0.0, 0.0, 0.0)
    state, _ = march_periods(ALL_EFFECTS, p, grid, state, np.int64(patience), log, c, most)
    sections, contacts = [state_xv(p, state)], []
    for _ in range(MULTIPLES):
        clear_log(log)
        start = at_period_zero(state)
        state, _ = march_periods(ALL_EFFECTS, p, grid, start, np.int64(1), log, c, most)
        sections.append(state_xv(p, state))
        impacts, rests = np.zeros(2), np.zeros(2)
        count_contacts(log, state, impacts, rests, np.zeros(2))
        contacts.append((impacts, rests))
    now = np.array(sections[-1])
    for m in range(1, MULTIPLES + 1):
        if np.abs(now - sections[-1 - m]).max() < REPEATS:
            impacts, rests = (sum(pair[i] for pair in contacts[-m:]) for i in (0, 1))
            return int(regime_of(impacts, rests)), m
    return int(Regime.APERIODIC), 0


def disagreements(points: int, patience: int, seed: int) -> list[tuple[float, ...]]:
    rng = np.random.default_rng(seed)
    nu, f = rng.uniform(0.3, 3, points), rng.uniform(0.05, 2, points)
    rows = np.zeros((points, len(PARAMETERS)))
    rows[:, 0], rows[:, 1], rows[:, 2], rows[:, 3] = nu, f, 0.2, 0.5
    rows[:, 5] = rows[:, 6] = 0.7
    limits = MAX_PERIODS, PATIENCE
    cut, start = row_blocks(points), (0.0, 0.0)
    ((_, (solved,)),) = solve_rows(cut, lambda a, b: [rows[a:b]], start, 1, *limits, 0, ())
    regimes, multiples = solved.regime, solved.period_multiple
    assert len(np.unique(regimes)) > 3
    differing = []
    for i in range(points):
        regime, m = patient(nu[i], f[i], patience)
        if (regime, m) != (regimes[i], multiples[i]):
            differing.append((nu[i], f[i], regime, m, regimes[i], multiples[i]))
    return differing


def test_labels_agree_with_patience() -> None:
    assert disagreements(100, 1000, seed=7) == []


@pytest.mark.slow
def test_labels_agree_with_patience_at_length() -> None:
    differing = disagreements(1000, PATIENT, seed=1)
    assert len(differing) <= 1, differing
