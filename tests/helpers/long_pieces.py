"""Orbits with soft supports and friction in 40 digits: Newton's method on the motions of `lab.reference_solver`."""

from __future__ import annotations

from dataclasses import dataclass
from decimal import Context, Decimal, localcontext
from typing import Any

import mpmath as mp
import numpy as np

import vibropipe as vp
from vibropipe.lab.power_series import DIGITS, Series, period_of, value_at
from vibropipe.lab.reference_solver import ReferenceSolver

# Step of the differences that give the derivative of the return map, to half the digits.
STEP = Decimal(10) ** -18
NODES = 16


def gauss_nodes() -> list[tuple[Decimal, Decimal]]:
    """Return nodes and weights of Gauss quadrature on [0, 1]."""
    with mp.workdps(DIGITS):
        starts = np.polynomial.legendre.leggauss(NODES)[0]
        roots = [mp.findroot(lambda x: mp.legendre(NODES, x), mp.mpf(float(x))) for x in starts]
        slopes = [mp.diff(lambda x: mp.legendre(NODES, x), root) for root in roots]
        return [
            (Decimal(mp.nstr((1 + x) / 2, DIGITS)), Decimal(mp.nstr(1 / ((1 - x * x) * d * d), DIGITS)))
            for x, d in zip(roots, slopes, strict=True)
        ]  # fmt: skip


class Integrating(ReferenceSolver):
    """The solver, which also integrates x exp(-i k nu tau)."""

    def __init__(self, exciter: vp.Exciter, harmonics: int) -> None:
        super().__init__(exciter)
        self.nodes, self.sums = gauss_nodes(), np.zeros(harmonics + 1, complex)

    def pass_time(self, span: Decimal, x: Series) -> None:
        stop = min(self.times_left[0] - self.tau, span) if self.times_left else Decimal(0)
        if stop > 0:
            for node, weight in self.nodes:
                t = node * stop
                turn = float((self.nu * (self.tau + t)) % (2 * Decimal(mp.nstr(mp.pi, DIGITS))))
                value = float(weight * stop * value_at(x, t))
                self.sums += value * np.exp(-1j * turn * np.arange(len(self.sums)))
        super().pass_time(span, x)


@dataclass
class TrueOrbit:
    """An orbit: section, (tau, velocity) of its contacts, amplitudes, and Floquet multipliers."""

    section: tuple[Decimal, Decimal]
    contacts: list[tuple[Decimal, Decimal]]
    amplitudes: np.ndarray
    multipliers: np.ndarray


def solve_orbit(exciter: vp.Exciter, x: float, v: float, m: int, harmonics: int) -> TrueOrbit:
    """Return the orbit of m periods near a section."""
    with localcontext(Context(prec=DIGITS)):
        end = period_of(exciter.nu) * m

        def after(at: tuple[Decimal, Decimal]) -> np.ndarray:
            state: Any = ReferenceSolver(exciter).run(*at, [end]).states[0]
            return np.array(state)

        section = Decimal(x), Decimal(v)
        matrix = np.empty((2, 2), object)
        for _ in range(3):
            here = after(section)
            matrix[:, 0] = (after((section[0] + STEP, section[1])) - here) / STEP
            matrix[:, 1] = (after((section[0], section[1] + STEP)) - here) / STEP
            dx, dv = here[0] - section[0], here[1] - section[1]
            a, b, c, d = 1 - matrix[0, 0], -matrix[0, 1], -matrix[1, 0], 1 - matrix[1, 1]
            det = a * d - b * c
            section = section[0] + (d * dx - b * dv) / det, section[1] + (a * dv - c * dx) / det
        solver = Integrating(exciter, harmonics)
        motion = solver.run(*section, [end])
    found = [(e[0], e[3]) for e in motion.events if e[1] in ("in", "impact")]
    return TrueOrbit(section, found, solver.sums / float(end), eigenvalues(matrix))


def eigenvalues(matrix: np.ndarray) -> np.ndarray:
    """Return the eigenvalues of a matrix (2, 2) of Decimal, whose determinant may vanish."""
    with mp.workdps(DIGITS):
        a, b, c, d = (mp.mpf(str(each)) for each in matrix.ravel())
        half = (a + d) / 2
        root = mp.sqrt(half**2 - (a * d - b * c))
        return np.array([complex(half + root), complex(half - root)])
