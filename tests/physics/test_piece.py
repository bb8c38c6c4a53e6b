"""A linear piece and its derivatives, against a matrix exponential and differences in 40 digits."""

from __future__ import annotations

import mpmath as mp
import pytest

from vibropipe.physics.load import Force
from vibropipe.physics.piece import (
    acceleration_of,
    by_damping,
    by_frequency,
    by_stiffness,
    flight_over,
    flown,
    force_at_end,
)
from vibropipe.physics.turns import TWO_PI

# stiffness, damping, frequency, turns
PIECES = {
    "free": (1.0, 0.2, 1.3, 0.37),
    "resonant, undamped": (1.0, 0.0, 1.0, 0.8),
    "close to resonance": (1.0, 1e-6, 1.0001, 2.3),
    "twice resonant": (1.0, 0.01, 0.5, 0.9),
    "critical": (1.0, 2.0, 0.7, 0.4),
    "nearly critical": (1.0, 2.0 + 1e-7, 0.7, 0.4),
    "overdamped": (1.0, 30.0, 0.7, 0.9),
    "soft contact": (101.0, 3.0, 1.3, 0.06),
    "stiff contact": (1e8, 4e3, 1.1, 4e-5),
    "stiff, critical": (1e8, 2e4, 1.1, 9e-4),
    "stiff, overdamped": (1e8, 1e6, 1.1, 1e-2),
    "short": (1.0, 0.2, 1.3, 1e-7),
    "backward": (1.0, 0.2, 1.3, -1e-3),
    "fast force": (1.0, 0.1, 400.0, 3.2),
}
LOAD, START, FORCE = -0.4, (0.3, -1.1), Force(0.5, -0.8, 0.15, 0.25)


def end(stiffness, damping, nu, turns):
    """Return the end (y, w) of the piece by a matrix exponential in 40 digits."""
    k, h, w = mp.mpf(stiffness), mp.mpf(damping), mp.mpf(nu)
    t = mp.mpf(turns) * 2 * mp.pi / w
    system = mp.zeros(7)
    system[0, 1], system[1, 0], system[1, 1], system[1, 2] = 1, -k, -h, 1
    system[1, 3] = system[1, 5] = 1
    system[3, 4], system[4, 3], system[5, 6], system[6, 5] = w, -w, 2 * w, -2 * w
    begin = mp.matrix([*START, LOAD, *FORCE])
    after = mp.expm(system * t, method="taylor") * begin
    return after[0], after[1]


def derivative(number, index, which):
    """Return the derivative of the end by one of its arguments, by a central difference in 40 digits."""
    step = mp.mpf(10) ** -18 * max(1, abs(mp.mpf(number[which])))
    ends = []
    for sign in (1, -1):
        moved = [mp.mpf(each) for each in number]
        moved[which] += sign * step
        ends.append(end(*moved)[index])
    return (ends[0] - ends[1]) / (2 * step)


@pytest.mark.parametrize("name", PIECES)
def test_piece_ends_where_a_matrix_exponential_does(name: str) -> None:
    stiffness, damping, nu, turns = PIECES[name]
    with mp.workdps(60):
        true = end(*PIECES[name])
        scale = [
            max(abs(START[0]), abs(true[0]), abs(turns) * TWO_PI / nu),
            abs(true[1]) + abs(START[1]),
        ]
    found = flown(flight_over(stiffness, damping, LOAD, FORCE, nu, turns, 1), *START)
    for one, other, size in zip(found, true, scale, strict=True):
        assert abs(one - other) < 2e-14 * size


@pytest.mark.parametrize("name", PIECES)
@pytest.mark.parametrize("by", ["stiffness", "damping", "frequency"])
def test_piece_has_the_derivatives_of_differences(name: str, by: str) -> None:
    stiffness, damping, nu, turns = PIECES[name]
    flight = flight_over(stiffness, damping, LOAD, FORCE, nu, turns, 1)
    if by == "frequency":
        end_y, end_w = flown(flight, *START)
        acceleration = acceleration_of(flight, force_at_end(flight), end_y, end_w)
        found = tuple(
            by - flight.t / nu * rate
            for by, rate in zip(by_frequency(flight), (end_w, acceleration), strict=True)
        )
    else:
        found = (by_stiffness if by == "stiffness" else by_damping)(flight, *START)
    which = {"stiffness": 0, "damping": 1, "frequency": 2}[by]
    with mp.workdps(60):
        for index in (0, 1):
            true = derivative(PIECES[name], index, which)
            rest = 1e-14 * abs(end(*PIECES[name])[index]) / max(PIECES[name][which], 1.0)
            assert abs(found[index] - true) < 1e-9 * abs(true) + rest
