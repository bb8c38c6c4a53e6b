"""The exciter: every parameter of eqs. (1)-(6) of the paper, checked once, here."""

from __future__ import annotations

import math
import warnings
from collections.abc import Collection
from dataclasses import MISSING, dataclass, field, make_dataclass, replace
from typing import TYPE_CHECKING, Any

from vibropipe.physics.parameter_error import ParameterError as ParameterError
from vibropipe.physics.parameter_error import check_keywords, number_within, si_value
from vibropipe.physics.plausible import unit_warning
from vibropipe.physics.restitution import SUPPORTS, contact_damping, is_contact_damping
from vibropipe.physics.si import (
    FREQUENCY_REQUIRED,
    NO_DAMPING,
    NO_HOUSING,
    NO_SHAKER,
    TWICE_DAMPED,
    WRITTEN_FORCES,
    check_together,
    non_dimensional,
)
from vibropipe.physics.start import checked_start, support_positions
from vibropipe.physics.stated import Unstated, Written, telling_keywords
from vibropipe.words.parameters import (
    DEFAULTS,
    FOLLOWING,
    FORCES,
    MIRRORED,
    PARAMETERS,
    PHYSICAL,
    THROUGH_OTHERS,
    WITHOUT_UNITS,
    Acted,
    TiedValue,
    acting,
    of_effect,
    stated_value,
    without_absent,
)
from vibropipe.words.parameters import Parameters as Parameters

if TYPE_CHECKING:
    from vibropipe.words.exciter import OfExciter


def _fields() -> list[Any]:
    """Return the fields of an exciter: the required parameter first; those left out are numbers once it is made."""
    defaults = {**DEFAULTS, **dict.fromkeys(FOLLOWING)}
    names = sorted(PARAMETERS, key=defaults.__contains__)
    return [(name, float, field(default=defaults.get(name, MISSING))) for name in names]


if TYPE_CHECKING:
    _OfRecords = OfExciter
else:
    _OfRecords = make_dataclass("_OfRecords", _fields(), frozen=True)


@telling_keywords
@dataclass(frozen=True)
class Exciter(_OfRecords, Written):
    """One set of parameters of eqs. (5), (6), all non-dimensional; the defaults mean "effect absent".

    Parameters
    ----------
    l : float
        Half the distance between the supports, > 0.
    nu : float
        Frequency of excitation over the eigenfrequency, > 0; required beside a force by every call that does not vary
        it. Without a force it may be left out, and forcing periods are those of nu = 1.
    f : float
        Amplitude of excitation.
    h : float
        Damping, >= 0.
    delta : float
        Offset of the equilibrium: support 1 stands at x = l + delta and support 2 at x = -(l - delta).
    R1, R2 : float
        Coefficients of restitution of the supports, from 0 to 1.
    k1, k2, h1, h2 : float
        Stiffness and damping of soft supports, >= 0: beyond support i, at x = b, the force ki (x - b) + hi x' acts on
        the mass. A support with ki = 0 is rigid and has hi = 0. Beside ki > 0, a hi that is left out (None) is what Ri
        gives (`physics.restitution`): hi = 2 z sqrt(ki), z = -ln Ri / sqrt(pi^2 + ln^2 Ri), which is 0 for Ri = 1.
    contact_1, contact_2 : "pull" or "no_pull"
        Whether a soft support acts until its gap opens, so that its damper pulls at the end of a contact, or lets go
        where its force is zero and pushes again where it rises from zero. Held as the number 0 or 1. A rigid support,
        or one without damping, never pulls.
    load : float
        Constant force; it moves the equilibrium to x = load.
    friction : float
        Dry friction (Coulomb) against a mass that slides, >= 0.
    friction_ratio : float
        Static over kinetic friction, >= 1: a mass without velocity is held by a force up to friction_ratio friction.
    f2, phi2 : float
        Amplitude and phase of the second harmonic of the force, f sin(nu tau) + f2 sin(2 nu tau + phi2).
    mass_ratio : float
        Mass over that of the housing, >= 0; 0 for a housing that is fixed. Above 0 the housing may slide, x is the
        displacement of the mass in it, and the load acts on the mass (`physics.housing`).
    housing_friction_1, housing_friction_2 : float
        Dry friction of the housing that slides along x and against it, >= 0; 0 where mass_ratio = 0.
    housing_load : float
        Constant force on the housing; 0 where mass_ratio = 0.
    shaker : float
        Amplitude of a frame that is shaken as sin(nu tau), x then counted from it, or of an unbalance m_e e / m: adds
        shaker nu^2 to f. The attribute f is then the force that acts, with it; copies, `numbers` and datasets have the
        f that was given.
    wear_exponent : float
        Exponent, from 0 to 10, of speeds in `wear_rate` (output frame); it acts on no motion.
    ties : mapping of str to str or float, optional
        Parameters by expressions of others, or of names of one's own that have a number here, too: `{"R2": "R1", "f":
        "me * nu**2", "me": 0.02}` (`docs/theory.md`, Ties). They hold in calls that vary what others are tied to, as
        if the call had these ties, and in copies with other parameters (`dataclasses.replace`). What is tied is not
        stated; a frequency that a call varies may be left out.

    Attributes
    ----------
    ties : mapping of str to str
        The same as text; empty without ties.

    Raises
    ------
    ParameterError
        If a keyword is unknown, a value is out of range (`vibropipe.words.parameters`), the supports coincide in
        floating point, a rigid support has damping, a soft one has a damping beside Ri < 1 that is not the one Ri
        gives, a fixed housing has friction or a load, one that may slide a shaker, or a tie cannot be read or computed.
    """

    if TYPE_CHECKING:

        def __init__(self, l: float = ..., nu: float | None = None, **others: Any) -> None:  # noqa: E741
            ...

    def __post_init__(self) -> None:
        following = {name: getattr(self, name) for name in FOLLOWING}
        left_out = [
            name
            for name, value in following.items()
            if value is None or isinstance(value, Unstated)
        ]
        for name in left_out:
            object.__setattr__(self, name, DEFAULTS[name])
        for name, entry in PARAMETERS.items():
            own = stated_value(getattr(self, name))
            number = number_within(name, own, entry.range)
            if isinstance(own, TiedValue):
                number = TiedValue(number, own.ties)
            object.__setattr__(self, name, number)
        if not (self.lower < self.upper and self.lower - self.load < self.upper - self.load):
            distinct = "so that the supports are distinct floating-point numbers"
            allowed = f"at least 1e-15 |delta| {distinct}"
            got = f"l = {self.l!r}, delta = {self.delta!r}"
            if self.load:
                allowed = allowed.replace("|delta|", "|delta - load|")
                got = f"{got}, load = {self.load!r}"
            raise ParameterError("l", self.l, allowed, got=got)
        if "nu" in left_out:
            object.__setattr__(self, "nu", Unstated(self.nu))
        for R, k, h in SUPPORTS:
            self._set_damping(R, k, h, h in left_out)
        for name in of_effect("housing") if self.mass_ratio == 0.0 else ():
            if getattr(self, name) != 0.0:
                raise ParameterError(name, getattr(self, name), must=NO_HOUSING)
        if self.shaker != 0.0 and self.mass_ratio != 0.0:
            raise ParameterError("shaker", self.shaker, must=NO_SHAKER)
        for name, value in acting(vars(self)).items() if THROUGH_OTHERS else ():
            own = getattr(self, name)
            if value != own and name not in THROUGH_OTHERS:
                object.__setattr__(self, name, Acted(value, own))

    def __repr__(self) -> str:
        """Return a call that makes it, without defaults; of a parameter that others act on its own value."""
        stated = {
            name: stated_value(value)
            for name, value in vars(self).items()
            if not (name in self.ties or isinstance(value, Unstated))
        }
        given = [
            f"{name}={PARAMETERS[name].range.shown(value)!r}"
            for name, value in stated.items()
            if name in FOLLOWING or value != DEFAULTS.get(name)
        ]
        ties = f", ties={dict(self.ties)!r}" if self.ties else ""
        return f"Exciter({', '.join(given)}{ties})"

    def _set_damping(self, R: str, k: str, h: str, is_left_out: bool) -> None:
        """Set the damping of a support that is left out, or raise a ParameterError if a stated one cannot be."""
        restitution, stiffness, damping = (getattr(self, name) for name in (R, k, h))
        if is_left_out:
            object.__setattr__(self, h, Unstated(contact_damping(restitution, stiffness)))
        elif damping > 0.0 and stiffness == 0.0:
            raise ParameterError(h, damping, must=NO_DAMPING.format(k))
        elif restitution < 1.0 and not is_contact_damping(damping, restitution, stiffness):
            raise ParameterError(h, damping, must=TWICE_DAMPED.format(R=R, k=k, h=h))

    @classmethod
    def from_physical(
        cls,
        *,
        m: Any = None,
        C: Any = None,
        l: Any = None,  # noqa: E741
        H: Any = DEFAULTS["h"],
        F: Any = DEFAULTS["f"],
        omega: Any = None,
        delta: Any = DEFAULTS["delta"],
        R1: float = DEFAULTS["R1"],
        R2: float = DEFAULTS["R2"],
        ties: Any = None,
        **further: Any,
    ) -> Exciter:
        """Return the exciter of a mass m, stiffness C, viscous damping H and force F sin(omega t), by eqs. (2)-(4).

        p = sqrt(C/m), h = H/sqrt(m C), f = F/C, nu = omega/p. Lengths, f included, are then in metres, and times in
        1/p; `vibropipe.to_physical` converts results back, into the units that are given here.

        Parameters
        ----------
        m, C, l, H, F, omega, delta : number, str or pint.Quantity
            Mass and stiffness, > 0, and half the distance between the supports, > 0, all three required; damping, >= 0;
            amplitude and angular frequency (> 0; beside a force, required by every call that does not vary it) of the
            force; offset of the equilibrium.
            Numbers are in SI: kg, N/m, m, N s/m, N, rad/s. Text has a number and a unit: "8 mm", "8 N/mm", "55 rad/s";
            a frequency in Hz counts cycles, "9 Hz" is 2 pi 9 rad/s.
        R1, R2 : float
            As in `Exciter`.
        ties : mapping of str to str or float, optional
            As in `Exciter`: of parameters without units, lengths in metres.
        **further : number, str or pint.Quantity
            Any of C1, C2, H1, H2 (N/m, N s/m: stiffness and damping of soft supports), load (N: a constant force),
            slope (rad: the angle at which x rises) with gravity (default 9.80665 m/s^2), which add -m gravity
            sin(slope) to the load, friction (N: dry friction), F2 and phi2 (N, rad: second harmonic of the force), M
            (kg: mass of a housing that may slide), D1, D2 and P (N: its dry friction either way, and a force on it),
            shaker (m: amplitude of a frame that is shaken as sin(omega t); x is then counted from it), m_e and e (kg,
            m: a mass, part of m, that turns at a radius with omega). Both add to F: m shaker omega^2, m_e e omega^2.

        Raises
        ------
        ParameterError
            If a keyword is unknown, or a value is out of range, has an unknown unit or one of another dimension, or
            lacks the one it needs.

        Warns
        -----
        UserWarning
            If the nearer support is more than 100 times as far away as the mass swings without supports, as with l=8
            for 8 mm, or a force, friction or delta is more than 100 l (`physics.plausible`).
        """
        check_keywords(further, (*PHYSICAL, *WITHOUT_UNITS))
        numbers = {name: value for name, value in further.items() if name in WITHOUT_UNITS}
        further = {name: value for name, value in further.items() if name not in numbers}
        given = {"m": m, "C": C, "l": l, "H": H, "F": F, "omega": omega, "delta": delta, **further}
        needed = ("m", "C", "l")
        given = {
            name: value for name, value in given.items() if name in needed or value is not None
        }
        si = {name: si_value(name, value) for name, value in given.items()}
        check_together(given, si, {"R1": R1, "R2": R2})
        exciter = cls(R1=R1, R2=R2, **numbers, **non_dimensional(si), ties=ties)
        object.__setattr__(exciter, "_written", given)
        odd = unit_warning(exciter.numbers()._asdict())
        if odd:
            is_number = not (isinstance(l, str) or hasattr(l, "units"))
            metres = "; numbers are in metres: write l='8 mm' for millimetres" if is_number else ""
            warnings.warn(odd + metres, stacklevel=2)
        return exciter

    def states(self, name: str) -> bool:
        """Return whether nu, h1 or h2 is stated, and does not only count periods or follow from a restitution."""
        return not isinstance(getattr(self, name), Unstated)

    def check_frequency(self, varied: Collection[str] = ()) -> None:
        """Raise a ParameterError if there is a force, stated or `varied`, and no frequency."""
        forces = (name for name in FORCES if name in varied or getattr(self, name) != 0.0)
        force = None if self.states("nu") or "nu" in varied else next(forces, None)
        if force is not None:
            name, allowed = "nu", PARAMETERS["nu"].range.text
            if self.written:
                name, allowed = "omega", "an angular frequency in rad/s, or text with its unit"
                own = (name for name in WRITTEN_FORCES if si_value(name, self.written.get(name, 0)))
                others = (name for name, plain in WRITTEN_FORCES.items() if plain == force)
                force = next(own, None) or next(others)
            must = FREQUENCY_REQUIRED.format(force, allowed)
            raise ParameterError(name, None, allowed, must=must, got="")

    @property
    def upper(self) -> float:
        """Position of support 1, x = l + delta, eq. (1)."""
        return support_positions(self.l, self.delta)[0]

    @property
    def lower(self) -> float:
        """Position of support 2, x = -(l - delta), eq. (1)."""
        return support_positions(self.l, self.delta)[1]

    @property
    def period(self) -> float:
        """Forcing period 2 pi / nu in tau."""
        return 2 * math.pi / self.nu

    def mirrored(self) -> Exciter:
        """Return the mirrored exciter, x -> -x: forces and delta change sign, the supports are exchanged."""
        plain = self.without_ties()
        values = {name: stated_value(getattr(plain, of)) for name, (of, _sign) in MIRRORED.items()}
        negated = {name: 0.0 - values[name] for name, (_of, sign) in MIRRORED.items() if sign < 0}
        return replace(plain, **{**values, **negated})

    def parameters(self) -> Parameters:
        """Return the parameters as kernels read them; ParameterError for a force without a frequency."""
        self.check_frequency()
        numbers = {name: float(value) for name, value in vars(self).items()}
        absent = [name for name, acts in THROUGH_OTHERS.items() if acts]
        return Parameters(**{**numbers, **dict.fromkeys(absent, 0.0)})

    def numbers(self) -> Parameters:
        """Return the parameters as they are stated."""
        return Parameters(
            **{name: float(stated_value(value)) for name, value in vars(self).items()}
        )

    def stated(self) -> dict[str, float]:
        """Return the parameters that datasets hold: those of further effects only where the effect is present."""
        return without_absent(self.numbers()._asdict())

    def check_start(self, x0: float | None, v0: float) -> tuple[float, float]:
        """Return a start as floats, on a support that it is within rounding of (`start_at`).

        x0 : displacement; None is the equilibrium, or the support nearest to it where that lies beyond

        Returns displacement and velocity.
        Raises ParameterError if the start is not finite or lies beyond a rigid support.
        """
        return checked_start(self, x0, v0)
