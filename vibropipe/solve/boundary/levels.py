"""The quantities of orbits on their way to a level curve, and of its points."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from vibropipe.orbits.boundaries.level_curve import Level
from vibropipe.orbits.law.curve import LawZeros
from vibropipe.orbits.law.marching import Marcher
from vibropipe.solve.branch.branch_dataset import solve_orbits
from vibropipe.solve.branch.branch_of_pieces import solve_sections
from vibropipe.solve.design.goals import Bound
from vibropipe.solve.rows.label import Variables, label_rows
from vibropipe.solve.rows.named import harmonics_of, outputs_of


class Quantities:
    """Quantities of orbits of laws, closed or on their way to it.

    marcher : of its own, since its work is counted anew for each call
    """

    def __init__(self, marcher: Marcher) -> None:
        self.marcher = marcher

    def levels(self, bounds: Sequence[Bound], half: float) -> list[Level]:
        """Return levels as they are sought; half is l."""
        return [
            Level(number, partial(self._missed, bound, bound.scale(half)))
            for number, bound in enumerate(bounds)
        ]

    def _missed(
        self, bound: Bound, scale: float, curve: LawZeros, orbits: np.ndarray, is_image: bool
    ) -> np.ndarray:
        """Return by how much orbits (k, size) miss a level, over its scale, as `level_curve.Misses`."""
        names = [bound.quantity]
        variables, parameters = self.of(
            curve, orbits, is_image, outputs_of(names), harmonics_of(names)
        )
        values = bound.quantity.values(variables, parameters)
        return np.asarray(bound.quantity.difference(values, bound.low) / scale)

    def of(
        self,
        curve: LawZeros,
        orbits: np.ndarray,
        is_image: bool,
        outputs: tuple[str, ...],
        harmonics: int,
    ) -> tuple[Variables, np.ndarray]:
        """Return the quantities of orbits over `row`, and their parameters.

        orbits : (k, size), its unknowns
        is_image : whether their mirror images are meant
        outputs : any of `OF_BRANCH`
        """
        law, k = curve.sequence, curve.n_free
        parameters = np.array([curve.stated(u[-k:]) for u in orbits])
        effects = self.marcher.effects
        if effects.has_pieces:
            sections = np.array([section_of(curve, u, is_image) for u in orbits])
            rows = solve_sections(
                effects, self.marcher, law.m, sections, parameters, harmonics, outputs
            )
        else:
            # Times and velocities, and a number in place of the parameter that ends the unknowns of a branch.
            ended = np.hstack([orbits[:, :-k], np.zeros((len(orbits), 1))])
            rows = solve_orbits(law, ended, parameters, harmonics, outputs, is_image)
        return label_rows(rows, parameters, outputs), parameters


def section_of(curve: LawZeros, u: np.ndarray, is_image: bool) -> np.ndarray:
    """Return the state of an orbit at the section; of its mirror image, which is half a forcing period behind."""
    point = curve.point(u, u, u)
    return -curve.state_at(point, 0.5) if is_image else curve.state_at(point)
