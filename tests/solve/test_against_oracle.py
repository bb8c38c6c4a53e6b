"""Agreement with the arbitrary-precision oracle over random exciters, with corner cases favoured."""

from __future__ import annotations

import math
import random
from typing import NamedTuple

import pytest
from comparisons import disagreements, judge
from sampling import sampled
from textbook import Parameters

import vibropipe as vp


class Case(NamedTuple):
    p: Parameters
    tau_end: float
    x0: float
    v0: float


def log_uniform(rng: random.Random, low: float, high: float) -> float:
    return float(10 ** rng.uniform(low, high))


def random_exciter(rng: random.Random) -> Parameters:
    def restitution() -> float:
        return rng.choice([0.0, 1.0, rng.random(), rng.random(), 1 - log_uniform(rng, -1.3, 0)])

    length = log_uniform(rng, -1, 1)
    p = Parameters(
        nu=rng.choice([1.0, *(log_uniform(rng, -1.5, 1.5) for _ in range(5))]),
        f=rng.choice([0.0, *(rng.choice([-1, 1]) * log_uniform(rng, -2, 1.5) for _ in range(8))]),
        h=rng.choice([0.0, 2.0, *(log_uniform(rng, -3, 1.5) for _ in range(4))]),
        l=length,
        delta=rng.choice([0.0, length, -length, *(length * rng.uniform(-1.6, 1.6) for _ in "12")]),
        R1=restitution(),
        R2=restitution(),
    )
    # Pressed by spring or force, a damped mass strikes an ideal support at an ever higher rate.
    if p.h > 0 and p.R1 == 1 and p.upper <= abs(p.f):
        p = p._replace(R1=0.9)
    if p.h > 0 and p.R2 == 1 and -p.lower <= abs(p.f):
        p = p._replace(R2=0.9)
    return p


def random_case(seed: int) -> Case:
    """Draw an exciter, a start, and a horizon of about a hundred impacts."""
    rng = random.Random(seed)
    p = random_exciter(rng)
    inside = p.lower + rng.random() * (p.upper - p.lower)
    x0 = rng.choice([p.upper, p.lower, inside, inside, inside])
    v0 = rng.choice([0.0, rng.choice([-1, 1]) * log_uniform(rng, -2, 0.7)])
    force = abs(p.f) + max(abs(p.upper), abs(p.lower))
    crossing = min(math.sqrt(2 * p.l / force), 2 * p.l / max(abs(v0), 1e-9))
    tau_end = min(rng.uniform(1, 8) * 2 * math.pi / p.nu, 60.0, 50 * crossing)
    return Case(p, tau_end, min(max(x0, p.lower), p.upper), v0)


def check(seed: int) -> None:
    """Compare every event and the end state to the tolerance that one ulp of the input implies."""
    case = random_case(seed)
    start = {"x0": case.x0, "v0": case.v0}
    ds = vp.simulate(
        vp.Exciter(**case.p._asdict()), tau_end=case.tau_end, samples_per_period=0, **start
    )
    expected = judge(case.p, case.tau_end, **start)
    if math.isinf(expected.wobble_end[0]):
        pytest.fail(f"{case}: one ulp changes its events, choose another seed")
    differences = disagreements(case.p, ds, expected, case.tau_end)
    assert not differences, f"{case}\n" + "\n".join(differences[:6])


@pytest.mark.parametrize("seed", sampled(range(10), 0, 1, 2, 3, 5, 7))
def test_exact_agrees_with_the_twin(seed: int) -> None:
    check(seed)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(1000, 2000))
def test_exact_agrees_with_the_twin_at_length(seed: int) -> None:
    check(seed)
