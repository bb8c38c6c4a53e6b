"""Balls of flights hold what long arithmetic and random exciters of a box have, and their derivatives."""

from __future__ import annotations

import math

import mpmath as mp
import numpy as np
import pytest
from long_orbits import _fly

from vibropipe.proof.balls import BITS, Jet, arb, ctx, entire, round_down, round_up, seed, sinhc
from vibropipe.proof.flights import Flights
from vibropipe.words.proofs import BOXED

EXCITER = {"nu": 1.3, "f": 0.7, "h": 0.2, "l": 0.5, "delta": 0.1, "R1": 0.7, "R2": 0.6}
EXCITER |= {"load": 0.05, "f2": 0.3, "phi2": 0.4, "shaker": 0.2}
SPECIAL = [
    {}, {"h": 0.0}, {"h": 0.0, "nu": 1.0}, {"h": 0.0, "nu": 0.5}, {"h": 1e-9, "nu": 1.0}, {"h": 2.0},
    {"h": 1.99}, {"h": 2.01}, {"h": 2.2}, {"h": 30.0}, {"nu": 40.0}, {"nu": 0.05},
]  # fmt: skip


@pytest.fixture(autouse=True)
def _precision():
    with ctx.workprec(BITS):
        yield


def balls(values):
    return {name: arb(values.get(name, 0.0)) for name in BOXED}


def integrated(values, start, turns, x, v):
    """The flight by Taylor steps in long arithmetic, which knows no closed form; x from the equilibrium."""
    p = {name: mp.mpf(value) for name, value in values.items()}

    def rate(t, y):
        first = p["f"] + p["shaker"] * p["nu"] ** 2
        force = first * mp.sin(p["nu"] * t) + p["f2"] * mp.sin(2 * p["nu"] * t + p["phi2"])
        return [y[1], force - y[0] - p["h"] * y[1]]

    period = 2 * mp.pi / p["nu"]
    solve = mp.odefun(rate, start * period, [mp.mpf(x), mp.mpf(v)])
    return solve((mp.mpf(start) + turns) * period)


def as_mp(ball):
    """Return the ends of a ball as numbers of mpmath."""
    return [mp.mpf(end.str(45, radius=False)) for end in (ball.lower(), ball.upper())]


@pytest.mark.parametrize("other", [{}, {"h": 0.0, "nu": 1.0}, {"h": 2.0}, {"h": 2.2}], ids=str)
def test_a_flight_is_that_of_an_integration(other):
    values = EXCITER | other
    with mp.workdps(25):
        true = integrated(values, 0.3, 0.25, 0.2, -0.4)
        ends = Flights(balls(values)).fly(arb(0.3), arb(0.25), arb(0.2), arb(-0.4))
        for ball, exact in zip(ends, true, strict=True):
            low, high = as_mp(ball)
            assert low - mp.mpf("1e-22") < exact < high + mp.mpf("1e-22")
            assert high - low < 1e-30


@pytest.mark.parametrize("other", SPECIAL, ids=str)
def test_a_flight_is_that_of_its_steady_and_free_motion(other):
    values = EXCITER | other
    with mp.workdps(120):  # near a resonance, and at a double root, both parts are large
        nudge = {"h": mp.mpf(values["h"]) + mp.mpf("1e-45"), "load": mp.mpf(0)}
        p = {**{name: mp.mpf(value) for name, value in values.items()}, **nudge}
        p["f"] += p.pop("shaker") * p["nu"] ** 2
        true = _fly(p, mp.mpf(0.3), mp.mpf(0.3) + mp.mpf(0.8), mp.mpf(0.2), mp.mpf(-0.4))
        ends = Flights(balls(values)).fly(arb(0.3), arb(0.8), arb(0.2), arb(-0.4))
        for ball, exact in zip(ends, true, strict=True):
            low, high = as_mp(ball)
            assert low - mp.mpf("1e-34") < exact < high + mp.mpf("1e-34")
            assert high - low < 1e-28


@pytest.mark.parametrize(
    "other", [{}, {"h": 0.0}, {"h": 0.005, "nu": 1.0}, {"h": 2.0}, {"h": 3.0}], ids=str
)
def test_flights_of_a_box_lie_in_its_balls_and_derivatives_in_theirs(other):
    values = EXCITER | other
    wide = {"nu": 1e-3, "h": 1e-3 if values["h"] > 0 else 0.0, "f": 1e-2, "phi2": 1e-2}
    box = balls(values) | {name: arb(values[name], r) for name, r in wide.items()}
    names = list(wide)
    jets = {
        name: seed(ball, names.index(name), len(names)) if name in names else ball
        for name, ball in box.items()
    }
    ends = Flights(jets).fly(arb(0.3), arb(0.6), arb(0.2), arb(-0.4))
    rng, step = np.random.default_rng(1), 1e-13
    for _ in range(20):
        inner = {name: 0.99 * r * rng.uniform(-1, 1) for name, r in wide.items()}

        def at(moved, inner=inner):
            point = {n: v + inner.get(n, 0.0) for n, v in values.items()}
            exact = balls(point) | ({moved[0]: arb(point[moved[0]]) + moved[1]} if moved else {})
            return Flights(exact).fly(arb(0.3), arb(0.6), arb(0.2), arb(-0.4))

        for ball, point in zip(ends, at(None), strict=True):
            assert ball.value.contains(point)
        for j, name in enumerate(names):
            if wide[name] == 0.0:
                continue
            pairs = zip(at((name, arb(step))), at((name, arb(-step))), strict=True)
            for ball, (up, down) in zip(ends, pairs, strict=True):
                slope = (up - down).mid() / (2 * step)
                assert abs(slope - ball.slopes[j].mid()) < ball.slopes[j].rad() + 1e-9


def test_derivatives_by_times_and_velocities_are_differences():
    model, step = Flights(balls(EXCITER)), arb(2.0**-40)
    at = [arb(0.3), arb(0.6), arb(0.2), arb(-0.4)]
    ends = model.fly(*(seed(a, i, 4) for i, a in enumerate(at)))
    for i in range(4):
        up, down = (
            model.fly(*(a + s * step * (i == k) for k, a in enumerate(at))) for s in (1, -1)
        )
        for end, high, low in zip(ends, up, down, strict=True):
            assert abs(float((high - low) / (2 * step) - end.slopes[i])) < 1e-20


def test_entire_functions_meet_their_elementary_forms():
    for q in (-9.0, -1e-3, 0.0, 1e-3, 4.0):
        root = mp.sqrt(mp.mpf(q)) if q else mp.mpf("1e-20")
        sine, cosine = entire(seed(arb(q), 0, 1))
        assert float(sine.value) == pytest.approx(float(mp.re(mp.sinh(root) / root)), rel=1e-14)
        assert float(cosine.value) == pytest.approx(float(mp.re(mp.cosh(root))), rel=1e-14)
        assert float(cosine.slopes[0]) == pytest.approx(float(sine.value) / 2, rel=1e-14)
    for z in (0.3 + 0.4j, 1.9, 2.1, 3 - 4j):
        value, slope = (
            sinhc(Jet(z_ball(z), [z_ball(1)])).value,
            sinhc(Jet(z_ball(z), [z_ball(1)])).slopes,
        )
        exact = mp.sinh(z) / z
        assert complex(value) == pytest.approx(complex(exact), rel=1e-14)
        assert complex(slope[0]) == pytest.approx(complex((mp.cosh(z) - exact) / z), rel=1e-13)


def z_ball(z):
    from vibropipe.proof.balls import acb

    return acb(complex(z).real, complex(z).imag)


@pytest.mark.parametrize("text", ["0.1", "-0.1", "1", "1e-330", "-1e-330", "1e308", "0"])
def test_doubles_are_rounded_outwards_by_at_most_a_digit(text):
    ball = arb(text)
    low, high = round_down(ball), round_up(ball)
    assert arb(low) <= ball.lower()
    assert arb(high) >= ball.upper()
    assert math.nextafter(low, math.inf) >= high or low == high


def test_what_is_not_finite_has_no_bounds():
    assert math.isnan(round_down(arb.nan()))
    assert math.isnan(round_up(arb.pos_inf()))
