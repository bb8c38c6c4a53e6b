"""How far, at the section, the mass may be off a stable orbit and certainly comes back to it.

First an ellipse about a state of the orbit at the section: over it the derivative of the return map is proved to
contract in some norm, so all motions from it settle on the orbit. Then cells of starts about all states of the orbit,
the nearest first: a cell comes back if all its motions are proved to meet the same events and to arrive, after some
periods, in the ellipse, or nearer to the orbit than any cell that is not proved yet. What is not proved is split.
"""

from __future__ import annotations

import heapq
import itertools
import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from vibropipe.physics.exciter import Exciter
from vibropipe.proof.balls import arb, arb_mat, magnitude, round_down, total
from vibropipe.proof.flights import Flights
from vibropipe.proof.given import balls_of
from vibropipe.proof.law import FREE, Event, Kind, Piece
from vibropipe.proof.start_box import Happening, Moved, image
from vibropipe.solve.basins.attractors import reachable_velocity
from vibropipe.solve.basins.neighbourhood import MAX_RADIUS, contracting_norm, spectral_radius
from vibropipe.solve.motion.simulate import simulate
from vibropipe.words.progress import Progress

# Radii of the ellipse that are tried: the first and the last as shares of l, the ratio of two, and the cells of a side.
FIRST, LAST, SHRINK, SIDE = 0.5, 1e-6, 0.6, 3
# Periods that a cell is followed for, and the share of what it has to reach that its centre may take.
PERIODS, REACHED = 64, 0.7
# Samples of a forcing period in which the end of a contact is sought that a motion begins in.
SAMPLES = 256
# What cells are larger than wanted, for no start to lie between two by rounding.
SLACK = 1e-12
# Half width of the cell in which the orbit passes the section.
TINY = 1e-13
# Half width of cells that are lines, and the least one of those that are split, as a share of the first.
THIN, SMALLEST = 1e-15, 2.0**-20


class Cell(NamedTuple):
    """Starts at the section: a centre (x, x') in doubles and half widths."""

    centre: tuple[float, float]
    half: tuple[float, float]

    def distance(self, state: Sequence[float]) -> float:
        """Return a lower bound of the distance from a state."""
        sides = zip(self.centre, self.half, state, strict=True)
        off = [max(abs(c - s) - h, 0.0) for c, h, s in sides]
        return math.hypot(*off) * (1.0 - 1e-12)

    def parts(self) -> list[Cell]:
        """Return its halves along each side that is not thin."""
        sides = [
            [(c, h)] if h <= THIN else [(c - h / 2, h / 2), (c + h / 2, h / 2)]
            for c, h in zip(self.centre, self.half, strict=True)
        ]
        return [Cell((x, v), (a, b)) for (x, a), (v, b) in itertools.product(*sides)]


class Seen(NamedTuple):
    """What the march finds from a start: the first piece, the events, and the states at the sections."""

    piece: Piece
    happened: list[Happening]
    states: np.ndarray


class Returns:
    """Starts at the section that are proved to settle on a stable orbit.

    exciter : without friction
    states : (m, 2), its states at the section, in doubles
    off : how far these may be off
    norm, radius : (2, 2) and a number, of the ellipse about the first state: |norm (z - state)| <= radius. No ellipse
        if that is 0
    near : all starts nearer than this to any state of the orbit settle on it
    examined : cells that were examined
    """

    def __init__(self, exciter: Exciter, states: np.ndarray, off: float) -> None:
        self.exciter, self.model, self.states, self.off = (
            exciter,
            Flights(balls_of(exciter)),
            states,
            off,
        )
        self.norm, self.radius, self.near, self.examined = np.eye(2), 0.0, 0.0, 0

    def contract(self) -> None:
        """Find the ellipse."""
        m = len(self.states)
        found = self._image(tuple(self.states[0]), TINY * np.eye(2), m)
        if found is None:
            return
        jacobian = np.array([[float(a.mid()) for a in each.slopes] for each in found]) / TINY
        if not spectral_radius(jacobian) < MAX_RADIUS:
            return
        shape, _factor = contracting_norm(jacobian, np.ones(2))
        norm = np.linalg.cholesky(shape / np.linalg.eigvalsh(shape).max()).T
        radius = FIRST
        while radius > LAST:
            size = radius * self.exciter.l
            if self._contracts(norm, size):
                # the orbit itself lies beside the doubles of its state
                self.norm, self.radius = norm, size * (1.0 - SLACK) - 2.0 * self.off
                if m == 1:
                    self.near = self.radius
                return
            radius *= SHRINK

    def _contracts(self, norm: np.ndarray, radius: float) -> bool:
        """Return whether the derivative of the return map contracts in a norm over a square about the first state."""
        axes = np.linalg.inv(norm) * (radius / SIDE * (1.0 + SLACK))
        to_offsets = (arb_mat(norm.tolist()) * arb_mat(axes.tolist())).inv()
        places = np.arange(1 - SIDE, SIDE, 2)
        for place in itertools.product(places, places):
            centre = tuple(self.states[0] + axes @ place)
            is_between = self._room(2) < centre[0] < self._room(1)
            found = self._image(centre, axes, len(self.states)) if is_between else None
            if found is None:
                return False
            slopes = arb_mat([list(each.slopes) for each in found])
            moved = (arb_mat(norm.tolist()) * slopes * to_offsets).tolist()
            (a, b), (c, d) = moved
            # squares of both singular values: their sum and their product
            both, product = a * a + b * b + c * c + d * d, (a * d - b * c) ** 2
            if not (both < 2 and both < 1 + product):
                return False
        return True

    def settle_within(self, impulses: bool, cells: int, progress: Progress | None = None) -> float:
        """Return how far all starts are proved to settle on the orbit.

        impulses : whether velocities alone are changed; cells : examined at most.
        """
        largest, n, heap = reachable_velocity(self.exciter), itertools.count(), list[Any]()
        most, begun = largest, self.examined

        def add(cell: Cell, about: int) -> None:
            away = cell.distance(self.states[about])
            heapq.heappush(heap, (away, next(n), cell, about))

        for about, (x, v) in enumerate(self.states.tolist()):
            low, high = x - THIN, x + THIN
            if not impulses:
                low, high = max(x - largest, self._room(2)), min(x + largest, self._room(1))
            # motions begin on one piece: no cell lies on both sides of a support
            ends = [b for b in (self.exciter.lower, self.exciter.upper) if low < b < high]
            for left, right in itertools.pairwise([low, *ends, high]):
                add(Cell(((left + right) / 2, v), ((right - left) / 2, largest)), about)
        while heap:
            away, _n, cell, about = heapq.heappop(heap)
            if not impulses:
                self.near = max(self.near, away - self.off)
            if self.examined - begun >= cells or max(cell.half) < SMALLEST * largest:
                most = away
                break
            self.examined += 1
            if progress is not None:
                progress(self.examined - begun, cells)
            if not self._comes_back(cell):
                for part in cell.parts():
                    add(part, about)
        return max(most - self.off, self.near, 0.0)

    def _room(self, support: int) -> float:
        """Return where a rigid support lies; beyond a soft one the mass may be."""
        side, k = (1, self.exciter.k1) if support == 1 else (-1, self.exciter.k2)
        return (
            side * math.inf if k > 0.0 else (self.exciter.upper if side > 0 else self.exciter.lower)
        )

    def _comes_back(self, cell: Cell) -> bool:
        """Return whether all motions from a cell are proved to settle on the orbit."""
        if any(self._is_near(cell.centre, cell.half, state) for state in self.states):
            return True
        seen = self._march(cell.centre, PERIODS)
        reached = self._reached(seen.states)
        if not reached.any():
            return False
        periods = 1 + int(np.argmax(reached))
        half = [a * (1.0 + SLACK) + THIN for a in cell.half]
        found = self._image(cell.centre, np.diag(half), periods, seen)
        if found is None:
            return False
        return self._is_inside(*found)

    def _is_near(self, centre: Sequence[float], half: Sequence[float], state: np.ndarray) -> bool:
        """Return whether all of a cell is nearer to a state than what is proved."""
        far = [abs(c - s) + h for c, h, s in zip(centre, half, state.tolist(), strict=True)]
        return math.hypot(*far) * (1.0 + 1e-12) + self.off < self.near

    def _reached(self, states: np.ndarray) -> np.ndarray:
        """Return at which sections after the first a motion is well within what is proved."""
        later = states[1:]
        inside = (
            np.linalg.norm((later - self.states[0]) @ self.norm.T, axis=1) < REACHED * self.radius
        )
        away = np.linalg.norm(later[:, None] - self.states, axis=2).min(axis=1)
        is_within: np.ndarray = inside | (away < REACHED * self.near)
        return is_within

    def _is_inside(self, x: Moved, v: Moved) -> bool:
        """Return whether states at the section lie within what is proved."""
        moves = [*zip(x.slopes, v.slopes, strict=True)]
        for norm, radius, states in (
            (self.norm, self.radius, self.states[:1]),
            (np.eye(2), self.near - self.off, self.states),
        ):
            (a, b), (c, d) = norm.tolist()

            def size(p: Any, q: Any, a: Any = a, b: Any = b, c: Any = c, d: Any = d) -> Any:
                return ((p * a + q * b) ** 2 + (p * c + q * d) ** 2).sqrt()

            spread = total(size(*move) for move in moves)
            for s, w in states.tolist():
                if size(x.centre - s, v.centre - w) + spread < radius:
                    return True
        return False

    def _march(self, centre: tuple[float, float], periods: int) -> Seen:
        """March from a start at the section."""
        exciter, period = self.exciter, self.exciter.period
        x, v = centre
        motion = simulate(exciter, periods * period, x, v, samples_per_period=1)
        soft = {1: exciter.k1 > 0.0, 2: exciter.k2 > 0.0}
        taus, supports = motion["impact_tau"].values, motion["impact_support"].values.tolist()
        lasts = motion["contact_duration"].values if "contact_duration" in motion else taus * np.nan
        found: list[Happening] = []
        for tau, support, duration in zip(taus, supports, lasts, strict=True):
            if not soft[support]:
                found.append(Happening(tau / period, Event(Kind.IMPACT, support, FREE)))
                continue
            found.append(Happening(tau / period, Event(Kind.ENTERS, support, Piece(support))))
            if math.isfinite(duration):
                end = (tau + duration) / period
                found.append(Happening(end, Event(Kind.LEAVES, support, FREE)))
        contact = 1 if x > exciter.upper else 2 if x < exciter.lower else 0
        if contact:
            found.append(Happening(self._leaves(x, v, contact), Event(Kind.LEAVES, contact, FREE)))
        states = np.column_stack([motion["displacement"].values, motion["velocity"].values])
        return Seen(Piece(contact), sorted(found, key=lambda each: each.time), states)

    def _leaves(self, x: float, v: float, contact: int) -> float:
        """Return about when a contact with a soft support ends in which a motion begins, in forcing periods."""
        exciter, period = self.exciter, self.exciter.period
        motion = simulate(exciter, period, x, v, samples_per_period=SAMPLES)
        over = motion["displacement"].values - (exciter.upper if contact == 1 else exciter.lower)
        beyond = over > 0.0 if contact == 1 else over < 0.0
        n = int(np.argmin(beyond))
        # a contact that lasts longer is not proved to end there
        return (n - over[n] / (over[n] - over[n - 1])) / SAMPLES if n else 0.0

    def _image(
        self, centre: tuple[float, float], axes: np.ndarray, periods: int, seen: Seen | None = None
    ) -> tuple[Moved, Moved] | None:
        """Return the states after some periods of all starts centre + axes c, -1 <= c <= 1; None if not proved."""
        seen = self._march(centre, periods) if seen is None else seen
        happened = [each for each in seen.happened if each.time < periods]
        load = arb(self.exciter.load)
        at = arb(centre[0]) - load, arb(centre[1])
        columns = [[arb(a) for a in column] for column in axes.T.tolist()]
        found = image(self.model, at, columns, seen.piece, happened, periods)
        if found is None:
            return None
        x, v = found
        return Moved(x.centre + load, x.ball + load, x.slopes), v


def returns_to(exciter: Exciter, strobe: Sequence[Any], m: int) -> Returns | None:
    """Return what is proved of the starts about an orbit; None if that is nothing.

    strobe : balls of x, x' at the section; m : its forcing periods
    """
    first = [float(a.mid()) for a in strobe]
    orbit = Returns(exciter, np.array([first]), 0.0)
    states, off = [], 0.0
    for periods in range(m):
        found = strobe
        if periods:
            balls = orbit._image((first[0], first[1]), TINY * np.eye(2), periods)
            if balls is None:
                return None
            found = [each.ball for each in balls]
        states.append([float(a.mid()) for a in found])
        away = [magnitude(a - b) for a, b in zip(found, states[-1], strict=True)]
        off = max(off, *(-round_down(-a) for a in away))
    if not all(magnitude(a - b) < TINY for a, b in zip(strobe, first, strict=True)):
        return None
    # of both coordinates
    orbit = Returns(exciter, np.array(states), 1.5 * off)
    orbit.contract()
    return orbit if orbit.radius > 0.0 else None
