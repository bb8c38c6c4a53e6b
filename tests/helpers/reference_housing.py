"""Reference solutions with a housing that slides: those of `reference_solver` and its motion, to 40 digits."""

from __future__ import annotations

from collections.abc import Sequence
from decimal import Decimal

from vibropipe.lab.power_series import ONE, TWO, ZERO, Series, derivative, first_zero, value_at
from vibropipe.lab.reference_alone import ReferenceMotion
from vibropipe.lab.reference_solver import SIDE, ReferenceSolver
from vibropipe.physics.exciter import Exciter


class HousingReferenceSolver(ReferenceSolver):
    """Solver of one exciter whose housing may slide.

    way : the direction of sliding, 0 while it is held; order : power of time with which its velocity leaves zero.
    """

    def __init__(self, exciter: Exciter) -> None:
        super().__init__(exciter)
        self.kappa = Decimal(exciter.mass_ratio)
        self.ground = {
            1: Decimal(exciter.housing_friction_1),
            -1: -Decimal(exciter.housing_friction_2),
        }
        self.loads = Decimal(exciter.load) + Decimal(exciter.housing_load)
        self.own = self.h, self.friction

    def run_housing(
        self, x0: float, v0: float, velocity: float, times: Sequence[Decimal]
    ) -> tuple[ReferenceMotion, list[tuple[Decimal, Decimal]]]:
        """Return the motion of `run`, and velocity and displacement of the housing at its times."""
        self.start = Decimal(velocity)
        self.housing: list[tuple[Decimal, Decimal]] = []
        return self.run(x0, v0, times), self.housing

    def begin(self) -> None:
        """Start the housing."""
        self.velocity, self.displacement = self.start, ZERO
        self.slide(0 if not self.start else 1 if self.start > 0 else -1)

    def repeat_cycle(self, support: int) -> None:
        """Skip no cycles: the housing moves on in each."""

    def slide(self, way: int, order: int = 0) -> None:
        """Let the housing go a way: all forces on the mass then act on 1 + kappa times as little."""
        self.way, self.order = way, order
        factor = ONE + self.kappa if way else ONE
        self.h, self.friction = factor * self.own[0], factor * self.own[1]
        self.net = self.loads - self.ground[way] if way else ZERO

    def coefficients(self) -> tuple[Decimal, Decimal, Decimal]:
        """Return stiffness, damping and constant force of the piece, friction apart."""
        factor = ONE + self.kappa if self.way else ONE
        h = self.damping.get(self.pressed, ZERO)
        stiffness, damping, constant = super().coefficients()
        constant = factor * constant - self.kappa * self.net
        return factor * stiffness, damping + (factor - ONE) * h, constant

    def force_series(self, reach: Decimal) -> Series:
        """Return the series of the force on the mass."""
        factor = ONE + self.kappa if self.way else ONE
        return [factor * c for c in super().force_series(reach)]

    def force_at_rest(self) -> tuple[Decimal, Decimal]:
        """Return the force on the mass without velocity, friction apart, and its rate."""
        factor = ONE + self.kappa if self.way else ONE
        stiffness, _damping, constant = self.coefficients()
        value, rate = (sum((part[n] for part in self.parts), ZERO) for n in range(2))
        return factor * value + constant - stiffness * self.x, factor * rate

    def goes(self, direction: Decimal) -> tuple[int, int]:
        """Return the way of a housing without velocity, and the order in which it leaves it.

        direction : of the mass in it; 0 where it lies still.
        """
        way, order = self.way, self.order
        self.slide(0)
        force, rate = ZERO, ZERO
        if direction:
            stiffness, damping, _constant = self.coefficients()
            force, rate = self.force_at_rest()
            force -= damping * self.v + self.friction * direction
            rate -= stiffness * self.v + damping * force
        self.slide(way, order)
        push, rate = self.loads - force, -rate
        for side in (1, -1):
            excess = side * (push - self.ground[side])
            if excess > 0:
                return side, 1
            if excess == 0 and side * rate > 0:
                return side, 2
        return 0, 0

    def settle(self) -> None:
        """Let a housing without velocity go on beside a mass that moves."""
        if self.velocity == 0:
            self.slide(*self.goes(self.direction))

    def arrive(self) -> None:
        """Go on from a support just touched."""
        support = self.touched
        is_rigid = not self.stiffness[support] > 0
        if is_rigid and self.v == 0 and self.velocity == 0:
            for way in (1, -1, 0):
                self.slide(way)
                rests = SIDE[support] * self.force_at_rest()[0] >= -self.holds
                if self.goes(ZERO if rests else Decimal(-SIDE[support]))[0] == way:
                    break
            self.order = 1 if self.way else 0
        super().arrive()
        self.settle()

    def depart(self) -> None:
        """Go on from where the velocity of the mass is zero, or the start."""
        if self.v == 0 and self.velocity == 0:
            for way in (1, -1, 0):
                self.slide(way)
                value, rate = self.force_at_rest()
                moves = abs(value) > self.holds
                direction = ONE.copy_sign(value) if moves else ZERO
                if self.friction == value == 0 and rate != 0:
                    direction = ONE.copy_sign(rate)
                goes, order = self.goes(direction)
                if goes == way:
                    self.order = order
                    break
            super().depart()
            return
        super().depart()
        self.settle()

    def struck(self, before: Decimal) -> None:
        """Push the housing off: the momentum of both bodies stays."""
        share = self.kappa / (ONE + self.kappa)
        self.velocity += share * (before - self.v)
        self.slide((self.velocity > 0) - (self.velocity < 0))

    def goes_on(self, duration: Decimal) -> bool:
        """Return whether the housing keeps its way over a chatter."""
        if not self.way:
            return False
        share = self.kappa / (ONE + self.kappa)
        return abs(self.velocity) > TWO * share * abs(self.v) + share * abs(self.net) * duration

    def still_until(self) -> Decimal | None:
        """Return the time until the housing stops, if both bodies slide as one and it does."""
        if not self.way or self.velocity * self.net >= 0:
            return None
        return -self.velocity * (ONE + self.kappa) / (self.kappa * self.net)

    def changes(self, rests: bool) -> None:
        """Go on from the stop of both bodies."""
        self.velocity = ZERO
        self.slide(0)
        if rests:
            self.arrive()
        else:
            self.depart()

    def series_of_velocity(self, x: Series) -> Series:
        """Return the series of the velocity of a sliding housing."""
        share = self.kappa / (ONE + self.kappa)
        series = [self.velocity, *(-share * n * x[n] for n in range(2, len(x)))]
        series[1] += share * self.net
        return series

    def other_event(self, x: Series, span: Decimal) -> Decimal | None:
        """Return when the housing stops or slips, along a series of x."""
        if self.way:
            series = self.series_of_velocity(x)
            return first_zero([self.way * c for c in series[self.order :]], span, self.reach)
        found = None
        acceleration = derivative(derivative(x))
        for side in (1, -1):
            margin = [side * c for c in acceleration]
            margin[0] += side * (self.ground[side] - self.loads)
            if margin[0] > 0 or margin[1] > 0:
                t = first_zero(margin, span, self.reach)
                found, span = (found, span) if t is None else (t, t)
        return found

    def otherwise(self) -> None:
        """Go on from a stop, or a slip."""
        if self.way:
            self.velocity = ZERO
            self.slide(*self.goes(self.direction))
            return
        value, _rate = self.force_at_rest()
        _stiffness, damping, _constant = self.coefficients()
        force = value - damping * self.v - self.friction * self.direction
        middle = (self.ground[1] + self.ground[-1]) / 2
        self.slide(1 if self.loads - force > middle else -1, 2)

    def pass_time(self, span: Decimal, x: Series) -> None:
        """Advance, and record the housing at requested times."""
        times, first = list(self.times_left), self.tau
        super().pass_time(span, x)
        for time in times[: len(times) - len(self.times_left)]:
            self.housing.append(self.moved(time - first, x))
        self.velocity, self.displacement = self.moved(span, x)
        if span > 0 and self.way:
            self.order = 0

    def moved(self, span: Decimal, x: Series) -> tuple[Decimal, Decimal]:
        """Return velocity and displacement of the housing after a time along a series of x."""
        if not self.way:
            return ZERO, self.displacement
        share, v = self.kappa / (ONE + self.kappa), x[1] if len(x) > 1 else ZERO
        change = share * self.net * span
        velocity = self.velocity + change - share * (value_at(derivative(x), span) - v)
        drift = (self.velocity + share * v + change / 2) * span
        return velocity, self.displacement + drift - share * (value_at(x, span) - x[0])
