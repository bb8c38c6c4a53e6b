"""A perturbation propagated period by period agrees with the Jacobian over all periods."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vibropipe.march.grid import exact_grid
from vibropipe.march.log import RESTS, clear_log, new_log
from vibropipe.march.state import initial_state
from vibropipe.orbits.growth import period_jacobian, perturbation_growth
from vibropipe.orbits.housing_jacobian import no_coupling
from vibropipe.orbits.return_map import at_period_zero, march_periods, return_map_jacobian
from vibropipe.physics.effects import ALL_EFFECTS
from vibropipe.physics.exciter import Parameters
from vibropipe.physics.flow import DEGREE

FORCED = Parameters(1.0, -1.0, 0.2, 0.5, 0.01, 0.6, 0.8)
CHATTER = Parameters(0.3, 1.5, 0.2, 0.5, 0.0, 0.7, 0.7)
MAX_EVENTS = np.int64(10**6)
ALONE = no_coupling()


def test_growth_adds_up_to_that_of_the_return_map() -> None:
    grid, c = exact_grid(ALL_EFFECTS, FORCED), np.empty(DEGREE + 1)
    start = state = initial_state(ALL_EFFECTS, FORCED, grid, 0.0, 0.1, -0.2, None)
    log, total, (a, b) = new_log(2000, 100), 0.0, (1.0, 0.0)
    for _ in range(5):
        clear_log(log)
        before = at_period_zero(state)
        state, _status = march_periods(
            ALL_EFFECTS, FORCED, grid, before, np.int64(1), log, c, MAX_EVENTS
        )
        jacobian = period_jacobian(ALL_EFFECTS, FORCED, log, True, before, state)
        a, b, rest, growth = perturbation_growth(jacobian, ALONE, a, b, 0.0)
        assert rest == 0.0
        assert math.hypot(a, b) == pytest.approx(1)
        total += growth
    whole = new_log(2000, 100)
    end, _status = march_periods(
        ALL_EFFECTS, FORCED, grid, start, np.int64(5), whole, c, MAX_EVENTS
    )
    carried = np.reshape(return_map_jacobian(ALL_EFFECTS, FORCED, whole, start, end, 5), (2, 2))[
        :, 0
    ]
    assert total == pytest.approx(math.log(np.hypot(*carried)), abs=1e-9)
    np.testing.assert_allclose((a, b), carried / np.hypot(*carried), atol=1e-9)


def test_what_a_rest_forgets_has_not_grown() -> None:
    grid, log = exact_grid(ALL_EFFECTS, CHATTER), new_log(2000, 100)
    start = initial_state(ALL_EFFECTS, CHATTER, grid, 0.0, 0.0, 0.0, None)
    end, _status = march_periods(
        ALL_EFFECTS, CHATTER, grid, start, np.int64(1), log, np.empty(DEGREE + 1), MAX_EVENTS
    )
    assert log.counts[RESTS] >= 1
    jacobian = period_jacobian(ALL_EFFECTS, CHATTER, log, True, start, end)
    assert perturbation_growth(jacobian, ALONE, 0.6, 0.8, 0.0) == (1.0, 0.0, 0.0, -math.inf)


def test_a_log_that_is_not_whole_tells_nothing() -> None:
    grid, log = exact_grid(ALL_EFFECTS, FORCED), new_log(2000, 100)
    start = initial_state(ALL_EFFECTS, FORCED, grid, 0.0, 0.1, -0.2, None)
    jacobian = period_jacobian(ALL_EFFECTS, FORCED, log, False, start, start)
    assert np.isnan(jacobian).all()
    assert math.isnan(perturbation_growth(jacobian, ALONE, 0.6, 0.8, 0.0)[3])
