"""Complex division gives the bits of Python's and raises nothing."""

from __future__ import annotations

import cmath
import math

import numpy as np
import pytest

from vibropipe.compiler import jit
from vibropipe.physics.quotient import divide

TINY = 5e-324


@jit
def quotient(a: complex, b: complex) -> complex:
    return divide(a, b)


def test_quotients_equal_those_of_python() -> None:
    rng = np.random.default_rng(1)
    a, b = (
        (rng.normal(size=2000) + 1j * rng.normal(size=2000)) * 10.0 ** rng.integers(-140, 140, 2000)
        for _ in range(2)
    )
    for one, two in zip(a.tolist(), b.tolist(), strict=True):
        assert quotient(one, two) == pytest.approx(one / two, rel=4e-16)


@pytest.mark.parametrize("a", [0j, 1 + 2j, complex(math.inf, 0.0)])
@pytest.mark.parametrize("b", [0j, complex(-0.0, 0.0), complex(0.0, -0.0)])
def test_a_zero_divisor_gives_nan(a: complex, b: complex) -> None:
    assert cmath.isnan(quotient(a, b))


@pytest.mark.parametrize("b", [complex(TINY, 0.0), complex(0.0, -TINY), complex(math.nan, 1.0)])
def test_tiny_and_nan_divisors_do_not_raise(b: complex) -> None:
    assert not cmath.isfinite(quotient(1 + 1j, b))
