"""The exciter, eqs. (1)-(6): each parameter and each effect once, as a record that all other modules read.

Stored numbers depend on `facts` of these records alone; their texts may change without a new result.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from vibropipe.words.records import (
    FINITE,
    FRACTION,
    NOT_NEGATIVE,
    POSITIVE,
    Effect,
    Parameter,
    Physical,
    Range,
    effect_record,
    one_of,
    parameter_record,
)

CONTACTS = one_of("pull", "no_pull")


class OfEffects:
    """Each effect by name: its record here, in kernels 1 or None where it is present or absent (`physics.effects`)."""

    # fmt: off
    damping: int | None = effect_record("h = 0", ("h",), is_common=True, calls=("h",))
    forcing: int | None = effect_record("f = 0", ("f",), is_common=True, calls=("f", "f2"))
    support_1: int | None = effect_record(is_common=True)
    support_2: int | None = effect_record(is_common=True)
    restitution: int | None = effect_record("R = 1 on the supports included", ("R1", "R2"), is_common=True)
    rest: int | None = effect_record("|f| < {pull}", ("f",), is_common=True)
    load: int | None = effect_record(
        "load = 0", ("load",), calls=("load",), is_marched=False,
        sentence="a constant load acts",
    )
    soft: int | None = effect_record(
        "k = 0 on the supports included", ("k1", "k2"), calls=("k1", "k2"),
        refusal="soft supports are", sentence="soft supports push with a spring and a damper",
        occurs="a support is soft",
    )
    friction: int | None = effect_record(
        "friction = 0", ("friction",), calls=("friction",),
        refusal="dry friction is", sentence="dry friction acts against the velocity",
        occurs="friction is above 0",
    )
    second_harmonic: int | None = effect_record("f2 = 0", ("f2",), calls=("f2",))
    housing: int | None = effect_record(
        "mass_ratio = 0", ("mass_ratio",), calls=("mass_ratio",),
        refusal="a housing that slides is",
        sentence="the housing that carries the supports slides against dry friction",
        occurs="mass_ratio is above 0",
    )
    no_pull: int | None = effect_record(
        "contact = pull on the supports included", ("contact_1", "contact_2"),
        calls=("contact_1", "contact_2"), sentence="a soft support lets go of the mass before it would pull",
    )
    shaker: int | None = effect_record(
        "shaker = 0", ("shaker",), calls=("shaker",), is_marched=False,
        sentence="an unbalance or a shaken frame adds a force that grows with the square of the frequency",
    )
    # fmt: on


EFFECTS: list[Effect] = [each for each in vars(OfEffects).values() if isinstance(each, Effect)]
"""The order of effects in kernels, studies and files."""


@dataclass(frozen=True)
class OfExciter:
    """Each parameter by name: its record here, its value in an exciter and in a row (`physics.exciter`)."""

    # fmt: off
    nu: float = parameter_record(
        POSITIVE, 1.0, r"$\nu$", "ν", "frequency of excitation", "frequency of excitation",
        "Excitation frequency divided by the eigenfrequency", "frequency",
        Physical(
            "omega", r"$\omega$", "ω", "angular frequency of excitation",
            "Angular frequency of the excitation; in Hz it counts cycles: 9 Hz is 2 pi 9 rad/s",
        ),
        effect="forcing", follows=True,
    )
    f: float = parameter_record(
        FINITE, 0.0, "$f$", "f", "amplitude of excitation", "amplitude of excitation",
        "Amplitude of the excitation", "force", Physical("F", "$F$", "F"),
        effect="forcing", sign=-1,
    )
    h: float = parameter_record(
        NOT_NEGATIVE, 0.0, "$h$", "h", "damping", "damping",
        "Viscous damping", "damping", Physical("H", "$H$", "H"), effect="damping",
    )
    l: float = parameter_record(  # noqa: E741
        POSITIVE, None, "$l$", "l", "half distance between the supports", "half distance",
        "Half the distance between the supports", "length", Physical("l"),
    )
    delta: float = parameter_record(
        FINITE, 0.0, r"$\delta$", "δ", "offset of the equilibrium", "offset",
        "Offset of the equilibrium: support 1 at l + delta, support 2 at -(l - delta)", "length",
        Physical("delta", key="Offset of the equilibrium"), sign=-1,
    )
    R1: float = parameter_record(
        FRACTION, 1.0, "$R_1$", "R₁", "restitution of support 1", "restitution of support 1",
        "Coefficient of restitution of support 1", effect="restitution", twin="R2",
    )
    R2: float = parameter_record(
        FRACTION, 1.0, "$R_2$", "R₂", "restitution of support 2", "restitution of support 2",
        "Coefficient of restitution of support 2", effect="restitution", twin="R1",
    )
    k1: float = parameter_record(
        NOT_NEGATIVE, 0.0, "$k_1$", "k₁", "stiffness of support 1, 0 if rigid",
        "stiffness of support 1", "Stiffness of support 1; a support without it is rigid",
        "stiffness", Physical("C1", "$C_1$", "C₁"), effect="soft", twin="k2",
    )
    k2: float = parameter_record(
        NOT_NEGATIVE, 0.0, "$k_2$", "k₂", "stiffness of support 2, 0 if rigid",
        "stiffness of support 2", "Stiffness of support 2",
        "stiffness", Physical("C2", "$C_2$", "C₂"), effect="soft", twin="k1",
    )
    h1: float = parameter_record(
        NOT_NEGATIVE, 0.0, "$h_1$", "h₁", "damping of support 1", "damping of support 1",
        "Damping of support 1, for k1 > 0", "damping",
        Physical("H1", "$H_1$", "H₁", key="Damping of support 1, for C1 > 0"),
        effect="soft", twin="h2", follows=True,
    )
    h2: float = parameter_record(
        NOT_NEGATIVE, 0.0, "$h_2$", "h₂", "damping of support 2", "damping of support 2",
        "Damping of support 2, for k2 > 0", "damping",
        Physical("H2", "$H_2$", "H₂", key="Damping of support 2, for C2 > 0"),
        effect="soft", twin="h1", follows=True,
    )
    contact_1: float = parameter_record(
        CONTACTS, 0.0, "$c_1$", "c₁", "whether soft support 1 may pull, 0, or lets go before, 1",
        "end of a contact with support 1",
        "Whether support 1, if soft and damped, pulls at the end of a contact, or lets go where its force is zero",
        effect="no_pull", twin="contact_2",
    )
    contact_2: float = parameter_record(
        CONTACTS, 0.0, "$c_2$", "c₂", "whether soft support 2 may pull, 0, or lets go before, 1",
        "end of a contact with support 2",
        "Whether support 2, if soft and damped, pulls at the end of a contact, or lets go where its force is zero",
        effect="no_pull", twin="contact_1",
    )
    load: float = parameter_record(
        FINITE, 0.0, "$q$", "q", "constant force", "constant force",
        "Constant force", "force", Physical("load"), effect="load", sign=-1,
    )
    friction: float = parameter_record(
        NOT_NEGATIVE, 0.0, "$d$", "d", "dry friction", "dry friction",
        "Dry friction", "force", Physical("friction"), effect="friction",
    )
    friction_ratio: float = parameter_record(
        Range(1), 1.0, "$r$", "r", "static over kinetic friction", "static over kinetic friction",
        "Largest force that holds a mass without velocity over dry friction, for friction > 0",
        effect="friction",
    )
    f2: float = parameter_record(
        FINITE, 0.0, "$f_2$", "f₂", "amplitude of the second harmonic of excitation",
        "second harmonic", "Amplitude of the second harmonic of the excitation", "force",
        Physical("F2", "$F_2$", "F₂"), effect="second_harmonic", sign=-1,
    )
    phi2: float = parameter_record(
        FINITE, 0.0, r"$\varphi_2$", "φ₂", "phase of the second harmonic of excitation",
        "its phase", "Phase of the second harmonic, f2 sin(2 nu tau + phi2), in radians", "angle",
        Physical("phi2", key="Phase of the second harmonic, F2 sin(2 omega t + phi2)"),
        effect="second_harmonic", units="rad",
    )
    mass_ratio: float = parameter_record(
        NOT_NEGATIVE, 0.0, r"$\kappa$", "κ", "ratio of the mass to that of the housing, 0 if that is fixed",
        "mass ratio m/M",
        "Ratio of the mass to the mass of the housing that carries the supports; without it the housing is fixed",
        physical=Physical(
            "M", "$M$", "M", "mass of the housing",
            "Mass of the housing that carries the supports; without it the housing is fixed", "mass", POSITIVE,
        ),
        effect="housing",
    )
    housing_friction_1: float = parameter_record(
        NOT_NEGATIVE, 0.0, "$d_1$", "d₁", "dry friction of the housing that slides along x",
        "housing friction along x",
        "Dry friction against a housing that slides in the direction of x, for mass_ratio > 0", "force",
        Physical("D1", "$D_1$", "D₁"), effect="housing", twin="housing_friction_2",
    )
    housing_friction_2: float = parameter_record(
        NOT_NEGATIVE, 0.0, "$d_2$", "d₂", "dry friction of the housing that slides against x",
        "housing friction against x",
        "Dry friction against a housing that slides against x, for mass_ratio > 0", "force",
        Physical("D2", "$D_2$", "D₂"), effect="housing", twin="housing_friction_1",
    )
    housing_load: float = parameter_record(
        FINITE, 0.0, "$q_h$", "qₕ", "constant force on the housing", "force on the housing",
        "Constant force on the housing, for mass_ratio > 0", "force",
        Physical("P", "$P$", "P"), effect="housing", sign=-1,
    )
    shaker: float = parameter_record(
        FINITE, 0.0, "$u$", "u", "amplitude of a shaker, or of an unbalance", "shaker, or mₑe/m",
        "Amplitude of a frame that is shaken, or of an unbalance its mass times its radius over the mass: adds "
        "shaker nu^2 to f", "length",
        Physical("shaker", key="Amplitude of a frame that is shaken: adds m shaker omega^2 to F"),
        effect="shaker", sign=-1, acts={"f": "f + shaker * nu * nu"},
    )
    wear_exponent: float = parameter_record(
        Range(0, 10), 0.0, "$n$", "n", "exponent of wear", "exponent of wear",
        "Exponent of the speed in wear_rate of the output frame; it acts on no motion", acts={},
    )
    # fmt: on


PARAMETERS: list[Parameter] = [
    each for each in vars(OfExciter).values() if isinstance(each, Parameter)
]
"""The order of parameters in rows of numbers, tables and files."""


def source_of(function: Callable[..., Any] | None) -> str:
    """Return the source of a function of a record, "" without one."""
    return "" if function is None else inspect.getsource(function)


def facts() -> str:
    """Return what stored numbers depend on in the records: all but texts."""
    effects = [(each.name, each.is_common, each.calls, each.is_marched) for each in EFFECTS]
    parameters = [
        (
            *(each.name, each.range, each.default, each.effect, each.sign, each.twin, each.follows),
            *(each.physical and each.physical.name, each.dimension, each.acts),
        )
        for each in PARAMETERS
    ]
    return repr((effects, parameters))
