"""Neighbourhoods of a stable orbit that the return map takes into themselves.

A motion that enters one settles on the orbit: its march may end there.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from vibropipe.physics.limits import MAX_ROW_WORK
from vibropipe.physics.start import room
from vibropipe.solve.basins.section_map import SectionMap

# States on each ring of a neighbourhood whose images are checked, and the radii of the rings. Between two rings the
# nonlinear part of the map grows with the square of the distance, so it is no larger there.
RING_STATES, RINGS = 64, (1.0, 0.5, 0.25)
# Ratio of the radii that are tried one after the other, the largest radius in units of l, and the smallest.
SHRINK, MAX_ELLIPSE, MIN_ELLIPSE = 0.8, 4.0, 1e-10
# Share of the checked radius that is used: a line of grazing may cut the outermost ring between two of its states.
USED = 0.9
# Largest modulus of a multiplier of an attractor: closer to 1 rounding decides whether anything settles on the orbit,
# as on each of those that a motion without loss has beside each other.
MAX_RADIUS = 1.0 - 1e-9


class Ellipse(NamedTuple):
    """The states z with (z - center) shape (z - center)^T <= 1; shape: (2, 2) array."""

    center: np.ndarray
    shape: np.ndarray


def spectral_radius(jacobian: np.ndarray) -> float:
    """Return the largest modulus of the eigenvalues of a matrix."""
    return float(np.abs(np.linalg.eigvals(jacobian)).max())


def contracting_norm(jacobian: np.ndarray, scale: np.ndarray) -> tuple[np.ndarray, float]:
    """Return a norm in which a stable matrix contracts.

    S = sum of (A^T)^k Q A^k with A = jacobian/factor solves the discrete Lyapunov equation A^T S A = S - Q, so
    |A z| < |z| in its norm. The sum is doubled in each step [1]_.

    jacobian : (2, 2), matrix with a spectral radius rho up to MAX_RADIUS
    scale : (2,), unit of each component
    Returns S (2, 2) of the norm sqrt(z S z^T), and the bound (1 + rho)/2 of the norm of `jacobian`.

    References
    ----------
    .. [1] R. A. Smith, Matrix equation XA + BX = C, SIAM Journal on Applied Mathematics 16 (1968) 198.
    """
    factor = 0.5 * (1.0 + spectral_radius(jacobian))
    power, norm = jacobian / factor, np.diag(scale**-2.0)
    while True:
        growth = power.T @ norm @ power
        if not np.abs(growth).max() > 1e-17 * np.abs(norm).max():
            return norm, factor
        norm, power = norm + growth, power @ power


def trapping_ellipse(section: SectionMap, point: np.ndarray, m: int) -> Ellipse | None:
    """Return an ellipse around a section point of a stable orbit that the m-period return map takes into itself.

    In the norm of `contracting_norm` the linear part of the map contracts by `factor`. The radius is the largest of
    those tried for which the rest of the map, at RING_STATES states of each ring, is smaller than half of what is left
    to 1, and the motion has the contacts of the orbit. Then each ring is mapped well into itself, and by continuity
    what it encloses is.

    point : (2,), section point (x, x')
    m : period multiple
    Returns None if the orbit is not stable, has none of at least MIN_ELLIPSE, or the search takes more work than a row
    may.
    """
    jacobian = section.jacobian(point, m)
    if not spectral_radius(jacobian) < MAX_RADIUS:
        return None
    norm, factor = contracting_norm(jacobian, section.scale)
    angles = 2 * math.pi * np.arange(RING_STATES) / RING_STATES
    circle = np.column_stack([np.cos(angles), np.sin(angles)]) @ np.linalg.inv(
        np.linalg.cholesky(norm)
    )
    # After a rest the motion does not depend on its start, and nor on how many impacts led to the rest.
    same_contacts = jacobian.any()
    _images, sequence = section.images(point[None], m)
    radius, most = MAX_ELLIPSE, section.work + MAX_ROW_WORK
    while radius > MIN_ELLIPSE and section.work < most:
        if all(
            _contracts(section, point, m, jacobian, norm, factor, ring * radius * circle,
                       sequence[0] if same_contacts else None)
            for ring in RINGS
        ):  # fmt: skip
            return Ellipse(point, norm / (USED * radius) ** 2)
        radius *= SHRINK
    return None


def _contracts(
    section: SectionMap,
    point: np.ndarray,
    m: int,
    jacobian: np.ndarray,
    norm: np.ndarray,
    factor: float,
    ring: np.ndarray,
    sequence: int | None,
) -> bool:
    """Return whether the map takes the states of a ring around a point well into it; arguments as in the caller."""
    states = point + ring
    states[:, 0] = np.clip(states[:, 0], *room(section.exciter))
    images, sequences = section.images(states, m)
    if sequence is not None and (sequences != sequence).any():
        return False
    # The size of the ring itself also where it is cut off by a support.
    size = math.sqrt(ring[0] @ norm @ ring[0])
    rest = images - point - (states - point) @ jacobian.T
    deviation = np.sqrt(np.einsum("ni,ij,nj->n", rest, norm, rest))
    return bool((deviation <= 0.5 * (1.0 - factor) * size).all())
