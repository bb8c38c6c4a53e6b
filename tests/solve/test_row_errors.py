"""Error estimates of rows: against the true orbit, and over random exciters against long arithmetic."""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from typing import Any

import mpmath
import numpy as np
import pytest
from comparisons import parameters_of, reference
from oracles import Oracle
from textbook import Parameters, digits
from true_rows import draw_exciters, error_ratios, orbits

import vibropipe as vp
from vibropipe.solve.sweep.blocks import assemble, solve_shard
from vibropipe.solve.sweep.sweep import grid_of
from vibropipe.words.status import Status

NUDGE = mpmath.mpf("1e-18")


def distance_to_orbit(p: Parameters, ds: Any) -> float:
    """Return the distance of the strobe to the orbit of the oracle: (1 - J)^-1 times the residual of the return map."""
    context = digits(p, 45)
    span = 2 * context.pi / context.mpf(p.nu) * int(ds.period_multiple)

    def returned(x: Any, v: Any) -> Any:
        motion = Oracle(p, context).run(span, x, v)
        return context.matrix([motion.displacement_end, motion.velocity_end])

    start = [context.mpf(float(ds[name])) for name in ("displacement_strobe", "velocity_strobe")]
    nudge = context.mpf(NUDGE)
    base = returned(*start)
    columns = [
        (returned(start[0] + nudge, start[1]) - base) / nudge,
        (returned(start[0], start[1] + nudge) - base) / nudge,
    ]
    matrix = context.matrix(2)
    for j in (0, 1):
        for i in (0, 1):
            matrix[i, j] = (i == j) - columns[j][i]
    away = context.lu_solve(matrix, base - context.matrix(start))
    return max(abs(float(value)) for value in away)


def test_the_error_of_a_row_holds_against_the_true_orbit() -> None:
    draw = np.random.default_rng(31)
    n_compared = 0
    for _ in range(30):
        p = Parameters(
            nu=draw.uniform(0.5, 3), f=draw.uniform(0.2, 3), h=draw.uniform(0.02, 0.5), l=0.5,
            delta=draw.uniform(-0.3, 0.3), R1=draw.uniform(0.3, 0.9), R2=draw.uniform(0.3, 0.9),
        )  # fmt: skip
        ds = vp.steady_state(vp.Exciter(**p._asdict()), accuracy=1e-9)
        if ds.period_multiple == 0 or ds.sizes["impact"] == 0 or ds.rests_per_orbit.sum() > 0:
            continue
        n_compared += 1
        assert distance_to_orbit(p, ds) <= 3 * float(ds.error), p
        assert float(ds.error) < 1e-9 or int(ds.status) == Status.INACCURATE
    assert n_compared >= 10


@pytest.mark.parametrize("name", sorted(reference("steady")))
def test_the_error_holds_for_harmonics_and_impacts_of_the_references(name: str) -> None:
    entry = reference("steady")[name]
    ds = vp.steady_state(vp.Exciter(**parameters_of(entry)._asdict()), accuracy=1e-10)
    tolerance = 3 * float(ds.error) + 2e-16
    assert tolerance < 1e-12
    for k in range(6):
        assert (
            abs(float(ds.displacement_amplitude[k]) - float(entry["x_amplitude"][k])) <= tolerance
        )
        assert abs(float(ds.velocity_amplitude[k]) - float(entry["v_amplitude"][k])) <= tolerance
    assert int(ds.status) == Status.OK


def test_a_sweep_to_an_accuracy_is_cut_and_joined_like_any_other() -> None:
    exciter = vp.Exciter(l=0.5, h=0.2, R1=0.7, R2=0.7)
    over = {"f": [0.2, 1.0], "nu": [0.8, 1.0, 1.2]}
    whole = vp.sweep(exciter, over, accuracy=1e-8)
    grid = grid_of(exciter, over)
    parts = [solve_shard(grid, *cut, accuracy=1e-8) for cut in ((0, 2), (2, 6))]
    assert whole.identical(assemble(parts, grid))
    assert whole.error.dims == ("f", "nu")
    assert (whole.error < 1e-12).all()
    assert not vp.sweep(exciter, over).variables.keys() & {"error"}


def test_a_row_that_misses_the_accuracy_says_so() -> None:
    ds = vp.steady_state(vp.Exciter(l=0.5, nu=1.0, f=-1, h=0.2, R1=0.7, R2=0.7), accuracy=1e-15)
    assert float(ds.error) > 1e-15
    assert int(ds.status) == Status.INACCURATE


@pytest.mark.parametrize("bad", [0.0, 0.2, math.inf, "fine"])
def test_an_accuracy_that_is_none_is_refused(bad: Any) -> None:
    with pytest.raises(vp.ParameterError, match="accuracy"):
        vp.sweep(vp.Exciter(l=0.5), {"nu": [1.0]}, accuracy=bad)


def test_a_chaotic_row_has_no_finite_error() -> None:
    exciter = vp.Exciter(l=0.5, h=0.2, nu=1.0, f=1.4, delta=0.01, R1=0.7, R2=0.7)
    ds = vp.sweep(exciter, {"nu": [1.2]}, accuracy=1e-6)
    assert ds.error.item() == math.inf
    assert np.isnan(ds.displacement_strobe_error.item())
    assert ds.status.item() != Status.OK


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
