"""Large steps, of flights and of pieces: a certificate holds no event that a search finds."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

import vibropipe as vp
from vibropipe.lab.work_precision_methods import BenchmarkMotion, March, effects_of_motion
from vibropipe.march.grid import exact_grid, force_at_step, grid_time, stays_between
from vibropipe.march.log import COUNTS, EVALUATIONS, POLYNOMIALS, STEPS
from vibropipe.march.loop import march_repeatedly
from vibropipe.march.piece_crossing import crossing, largest_value
from vibropipe.march.piece_log import PIECES, ROWS
from vibropipe.march.piece_path import MAP, MARGIN_FORCE, MARGIN_W, MARGIN_Y, SECOND_MAP, fill_flow
from vibropipe.march.roots import CROSSING, first_root
from vibropipe.physics.contact import Frame
from vibropipe.physics.effects import ALL_EFFECTS
from vibropipe.physics.exciter import Parameters
from vibropipe.physics.flow import DEGREE, combine
from vibropipe.physics.load import Force
from vibropipe.physics.stiffness import piece_flow, piece_rate
from vibropipe.physics.turns import TWO_PI
from vibropipe.words.status import Status

SOFT = {"k1": 300.0, "h1": 4.0, "R1": 1.0, "k2": 1e6, "h2": 300.0, "R2": 1.0}
ONLY_PUSHES = SOFT | {"contact_1": "no_pull", "contact_2": "no_pull"}
SLIDES = {"mass_ratio": 0.5, "housing_friction_1": 0.1, "housing_friction_2": 0.3}
EXCITERS: dict[str, dict[str, Any]] = {
    "friction": {"friction": 0.1},
    "soft": SOFT,
    "soft with friction": SOFT | {"friction": 0.2},
    "only pushes": ONLY_PUSHES,
    "stiff": SOFT | {"k1": 1e8, "h1": 2e3, "friction": 0.05},
    "second harmonic": SOFT | {"f2": 0.4, "phi2": 0.7},
    "housing": SLIDES,
    "soft in a housing": SLIDES | ONLY_PUSHES | {"friction": 0.05, "f2": 0.3},
}


def polynomials(rng: np.random.Generator, n: int) -> np.ndarray:
    """Random polynomials, (n, DEGREE + 1), whose terms fall as those of a motion over its time scale or half of it."""
    falls = np.array([1.0 / math.factorial(k) for k in range(DEGREE + 1)])
    return rng.normal(size=(n, DEGREE + 1)) * rng.uniform(0.5, 1.0, (n, 1)) ** np.arange(16) * falls


@pytest.mark.parametrize("power", [0, 1, 2])
def test_a_crossing_is_the_first_root_of_a_search(power: int) -> None:
    """Most need none: a search counts each evaluation, of which it takes several, a certified root one."""
    rng, counts = np.random.default_rng(power), np.zeros(COUNTS, np.int64)
    searched, found, unsearched = np.zeros(COUNTS, np.int64), 0, 0
    for c in polynomials(rng, 12000):
        offset = rng.normal() if power == 0 else 0.0
        sign, span = rng.choice([-1.0, 1.0]), rng.uniform(0.01, 1.0)
        if not offset + sign * c[power] > 1e-3:
            continue
        before = counts[EVALUATIONS]
        theta, kind = crossing(c, power, sign, offset, 0.1, span, counts)
        unsearched += kind == CROSSING and counts[EVALUATIONS] == before + 1
        expected, expected_kind = first_root(c, power, sign, offset, 0.1, span, searched)
        assert kind == expected_kind
        slope = np.polyval(np.polyder(c[: power - 1 if power else None : -1]), expected)
        assert theta == pytest.approx(expected, abs=1e-14 + 1e-14 / abs(slope))
        found += kind == CROSSING
    assert unsearched > 0.7 * found
    assert found > 100


def test_the_largest_value_is_that_of_many() -> None:
    rng, at = np.random.default_rng(3), np.linspace(0.0, 1.0, 2001)
    for c in polynomials(rng, 300):
        sign, theta = rng.choice([-1.0, 1.0]), rng.uniform(0.05, 1.0)
        values = sign * np.polyval(c[::-1], theta * at)
        if np.count_nonzero(np.diff(np.sign(np.diff(values)))) > 1:
            continue  # it has more than one extremum
        assert largest_value(c, sign, theta) == pytest.approx(values.max(), abs=2e-6)


@pytest.mark.parametrize("stiffness", [1.0, 31.0, 1e8])
@pytest.mark.parametrize("damping", [0.0, 0.7, 3.0, 40.0])
def test_a_step_is_within_its_margin_of_the_cubic_through_its_ends(
    stiffness: float, damping: float
) -> None:
    """The map of the step is the flow in closed form; value, slope and curvature are within the margins used."""
    root = np.sqrt(stiffness)
    p = vp.Exciter(l=0.5, nu=0.9, f=1.3, h=0.2).parameters()
    dt = 0.5 / max(piece_rate(stiffness, damping * root), p.nu)
    flow = np.zeros((ROWS, DEGREE + 1))
    fill_flow(flow, p, stiffness, damping * root, dt, None)
    free = flow[MAP, [4, 5, 9, 10]]
    assert free == pytest.approx(piece_flow(stiffness, damping * root, dt), rel=1e-14, abs=1e-300)
    rng, at = np.random.default_rng(5), np.linspace(0.0, 1.0, 201)
    for _ in range(200):
        y, w, load = rng.normal(), rng.normal() * root, rng.normal() * stiffness
        angle = rng.uniform(0.0, 2.0 * np.pi)
        state = np.array([y, w, load, p.f * np.sin(angle), p.f * np.cos(angle)])
        c = (state @ flow[:5])[::-1]
        margin = flow[MAP, MARGIN_Y] * abs(y - load / stiffness) + flow[MAP, MARGIN_W] * abs(w)
        margin += flow[SECOND_MAP, MARGIN_FORCE] * p.f
        slope, bend = np.polyder(c), np.polyder(c, 2)
        rise = np.polyval(c, 1.0) - c[-1]
        ends = slope[-1], np.polyval(slope, 1.0)
        cubic = np.array([ends[0] + ends[1] - 2 * rise, 3 * rise - 2 * ends[0] - ends[1]])
        cubic = np.array([*cubic, ends[0], c[-1]])
        rounding = 1e-14 * np.abs(c).max()
        for order, factor in ((c, 1.0), (slope, 3.1), (bend, 32.0)):
            off = np.polyval(order, at) - np.polyval(cubic, at)
            assert np.abs(off).max() <= factor * margin + 100 * rounding
            cubic = np.polyder(cubic)


def pieces_of(exciter: vp.Exciter, marches_per_period: int) -> tuple[np.ndarray, ...]:
    """Pieces of a motion over 12 periods, marched in so many marches per period, and the counts of the log."""
    motion = BenchmarkMotion(exciter, 0.1, 0.2, 12)
    march = March(motion, exact_grid(effects_of_motion(motion), exciter.parameters()))
    log, state = march.log, march.start
    values, codes = [], []
    for turn in range(1, 12 * marches_per_period + 1):
        end = grid_time(turn / marches_per_period, march.grid.steps)
        arguments = march.grid, state, end, log, None, march.scratch, 10**6, 1
        state, status = march_repeatedly(march.effects, march.parameters, *arguments)
        assert status == Status.OK
        n = log.pieces.counts[PIECES]
        values.append(log.pieces.values[:n].copy())
        codes.append(log.pieces.codes[:n].copy())
    return np.concatenate(values), np.concatenate(codes), log.counts


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=pytest.mark.slow) if name == "soft in a housing" else name
        for name in EXCITERS
    ],
)
def test_a_motion_in_large_steps_has_the_events_of_one_in_short_marches(name: str) -> None:
    """A march that is shorter than a step takes none without looking for each event: an obvious slower twin."""
    values = {"l": 0.5, "nu": 1.0, "f": -1.0, "h": 0.2, "R1": 0.7, "R2": 0.7} | EXCITERS[name]
    exciter = vp.Exciter(**values)
    large, codes, counts = pieces_of(exciter, 1)
    short, short_codes, short_counts = pieces_of(exciter, 113)
    begins, short_begins = codes[:, 0] != 0, short_codes[:, 0] != 0
    assert codes[begins].tolist() == short_codes[short_begins].tolist()
    assert large[begins, 0] == pytest.approx(short[short_begins, 0], abs=1e-11)
    assert large[begins, 3] == pytest.approx(short[short_begins, 3], abs=1e-10)
    assert short_counts[POLYNOMIALS] > 2 * counts[POLYNOMIALS]
    assert counts[STEPS] > counts[POLYNOMIALS]


NU, F, H = st.floats(0.1, 5), st.floats(-3, 3), st.floats(0, 4)
SAMPLES = np.linspace(0, 1, 501)


@given(
    nu=NU, f=F, h=H, y=st.floats(-1, 1), w=st.floats(-4, 4), load=st.floats(-1, 1),
    step=st.integers(0, 7), steps=st.sampled_from([1, 2]), sigma=st.sampled_from([-1.0, 1.0]),
    near=st.floats(-1.5, 0), width=st.floats(0.01, 4), departs=st.booleans(),
)  # fmt: skip
@example(1.0, 1.0, 0.6, 0.2, -0.5, 0.5, 0, 2, 1.0, 0.0, 9.0, False)
@example(1.0, 1.0, 0.6, 0.0, 1.0, -0.5, 3, 2, -1.0, 0.0, 9.0, True)
def test_a_certified_motion_touches_no_support(
    nu: float, f: float, h: float, y: float, w: float, load: float, step: int, steps: int,
    sigma: float, near: float, width: float, departs: bool,
) -> None:  # fmt: skip
    """Compare with samples of the exact polynomial of each step."""
    grid = exact_grid(ALL_EFFECTS, Parameters(nu, f, h, 1.0, 0.0, 0.7, 0.7))
    if departs:
        y, near, w = 0.0, 0.0, abs(w)
    end_y, end_w, motion, c = y, w, [], np.empty(DEGREE + 1)
    for k in range(step, step + steps):
        phase = TWO_PI * k / grid.steps
        force = Force(sigma * f * np.sin(phase), sigma * f * np.cos(phase))
        combine(ALL_EFFECTS, grid.basis, c, end_y, end_w, load, force)
        motion.append(np.polyval(c[::-1], SAMPLES))
        force_y, force_w = force_at_step(grid, k % grid.steps)
        end_y, end_w = (
            grid.a11 * end_y + grid.a12 * end_w + sigma * force_y + grid.b1 * load,
            grid.a21 * end_y + grid.a22 * end_w + sigma * force_w + grid.b2 * load,
        )
    far, displacement = near + width, np.concatenate(motion)
    stays_above, stays_below = (
        stays_between(
            grid,
            Frame(0, sigma, load, near, far, *reachable),
            int(departs),
            y,
            w,
            end_y,
            end_w,
            float(steps),
        )
        for reachable in ((True, False), (False, True))
    )
    if stays_above:
        assert (displacement[1:] > near).all()
    if stays_below:
        assert (displacement < far).all()


def test_flights_off_the_supports_are_certified() -> None:
    """A certificate that rejects everything would be safe too: this one accepts motions 0.2 off the support."""
    grid = exact_grid(ALL_EFFECTS, Parameters(1.0, 1.0, 0.6, 1.0, 0.0, 0.7, 0.7))
    force = np.array([force_at_step(grid, k) for k in range(grid.steps)])
    passed = 0
    for k in range(grid.steps):
        y, w = 0.5, 0.3
        first = grid.a11 * y + grid.a12 * w + force[k, 0], grid.a21 * y + grid.a22 * w + force[k, 1]
        after = force[(k + 1) % grid.steps]
        y2 = grid.a11 * first[0] + grid.a12 * first[1] + after[0]
        w2 = grid.a21 * first[0] + grid.a22 * first[1] + after[1]
        passed += stays_between(
            grid, Frame(0, 1.0, 0.0, min(y, y2) - 0.2, 9.0, True, True), 0, y, w, y2, w2, 2.0
        )
    assert passed == grid.steps
