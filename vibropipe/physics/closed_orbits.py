"""Orbits whose impacts repeat every n half forcing periods, eqs. (C1)-(C19) of docs/closed-forms.md, in closed form.

x(tau + t) = (-1)^n x(tau) with t = n pi/nu, and one impact in each t: with n = 2m the one-sided orbits (m; 1, 0) and
(m; 0, 1), with odd n = m the symmetric orbit (m; 1, 1), whose impacts alternate between the supports. All functions
broadcast arrays; the position b, in the direction of the impact, is that of the support struck.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


class FlightTerms(NamedTuple):
    """The free flow E over the time t between two impacts, in the combinations that the closed forms need.

    duration : t = n pi/nu
    decay : det E = exp(-h t), eq. (C3)
    shear : s E_12 with s = (-1)^n, eq. (C4)
    determinant : D = det(I - s E), eq. (C5); zero only where h = 0 and t is a multiple of the free period (s = 1), or
        an odd one of its half (s = -1)
    """

    duration: Array
    decay: Array
    shear: Array
    determinant: Array


class Response(NamedTuple):
    """What the impacts and the force do to the motion at the impact, eqs. (C7)-(C9).

    stiffness : P = 1 - nu^2 + i h nu
    impulses : Z; the linear motion at an impact of velocity v is i b + v Z
    impact : W = P Z, finite at the resonance h = 0, nu = 1; infinite at the other zeros of D, where no orbit exists
    """

    stiffness: Complex
    impulses: Complex
    impact: Complex


def flight_terms(nu: Any, h: Any, n: Any) -> FlightTerms:
    """Return the terms of the free flow over n half forcing periods, eqs. (C3)-(C5).

    They are written in the angle by which n omega/nu half turns differ from whole ones: near a resonance their relative
    error stays at rounding.
    """
    nu, h, n = (np.asarray(value, float) for value in (nu, h, n))
    b, t = 0.5 * h, n * np.pi / nu
    square = (1.0 - b) * (1.0 + b)
    with np.errstate(all="ignore"):
        shear, determinant = np.where(
            square > 0.0, _oscillating(nu, b, n, t, square), _creeping(n, b, t, -square)
        )
    return FlightTerms(t, np.exp(-h * t), shear, determinant)


def _oscillating(nu: Array, b: Array, n: Array, t: Array, square: Array) -> tuple[Array, Array]:
    """Return s E_12 and D for h < 2; square = omega^2."""
    omega, decay = np.sqrt(np.maximum(square, 0.0)), np.exp(-b * t)
    half_turns = np.rint(n * omega / nu)
    # 1 - omega and n - half_turns nu without cancellation: near nu = 1 both are small.
    excess = (n - half_turns) + half_turns * (1.0 - nu) - n * b * b / (1.0 + omega)
    angle = np.pi * np.where(half_turns == 0.0, n * omega, excess) / nu
    same = (n - half_turns) % 2.0 == 0.0
    shear = np.where(same, 1.0, -1.0) * decay * np.sin(angle) / omega
    half_angle = np.where(same, np.sin(0.5 * angle), np.cos(0.5 * angle))
    return shear, np.expm1(-b * t) ** 2 + 4.0 * decay * half_angle**2


def _creeping(n: Array, b: Array, t: Array, square: Array) -> tuple[Array, Array]:
    """Return s E_12 and D for h >= 2; square = b^2 - 1."""
    root = np.sqrt(np.maximum(square, 0.0))
    # The slow rate b - root cancels for strong damping; the product of both rates is 1.
    slow, fast = 1.0 / (b + root), b + root
    even = n % 2.0 == 0.0
    shear = np.exp(-slow * t) * np.where(root > 0.0, -np.expm1(-2.0 * root * t) / (2.0 * root), t)
    alternating = (1.0 + np.exp(-slow * t)) * (1.0 + np.exp(-fast * t))
    repeating = np.expm1(-slow * t) * np.expm1(-fast * t)
    return np.where(even, shear, -shear), np.where(even, repeating, alternating)


def response(nu: Any, h: Any, R: Any, terms: FlightTerms) -> Response:
    """Return P, Z and W of eqs. (C7)-(C9)."""
    nu, h, R = (np.asarray(value, float) for value in (nu, h, R))
    stiffness = (1.0 - nu) * (1.0 + nu) + 1j * h * nu
    with np.errstate(all="ignore"):
        position = terms.shear / terms.determinant
        velocity = (-np.expm1(-h * terms.duration) - h * terms.shear) / (2.0 * terms.determinant)
        impulses = (0.5 * (1.0 - R) + (1.0 + R) * velocity) / nu + 1j * (1.0 + R) * position
        impact = stiffness * impulses
    is_finite = terms.determinant > 0.0
    # At the resonance of the force both P and D vanish; this is the limit of P Z, eq. (C10).
    resonant = np.where(stiffness == 0.0, 2j * (1.0 + R) / terms.duration, np.inf)
    return Response(
        stiffness, np.where(is_finite, impulses, 0.0), np.where(is_finite, impact, resonant)
    )


def impact_velocities(f: Any, b: Any, r: Response) -> tuple[Array, Array]:
    """Return the two speeds v before the impact, eqs. (C11), (C12); NaN where a root is not real and > 0.

    f, b : amplitude of the force, not zero, and position of the support

    Returns the root of the larger speed, and the other one.
    """
    f, b = abs(np.asarray(f, float)), np.asarray(b, float)
    square, size = abs(r.stiffness) ** 2, abs(r.impact)
    with np.errstate(all="ignore"):
        bound = abs(b * square * r.impulses.real)
        # In factors, so that the fold, where the root vanishes, is sharp.
        root = np.sqrt((size * f - bound) * (size * f + bound))
        middle = b * square * r.impulses.imag
        below = (abs(b * r.stiffness) - f) * (abs(b * r.stiffness) + f)
        # Of each root the form that does not cancel; their product is below/|W|^2.
        upper = np.where(middle > 0.0, -below / (root + middle), (root - middle) / size**2)
        lower = np.where(middle < 0.0, below / (root - middle), -(root + middle) / size**2)
        exists = np.isfinite(size)
        upper, lower = (np.where(exists & (v > 0.0), v, np.nan) for v in (upper, lower))
    return upper, lower


def forcing_at_impact(b: Any, v: Any, r: Response) -> Complex:
    """Return f exp(i phi) of the orbit that strikes the support at b with the speed v, eq. (C9)."""
    with np.errstate(all="ignore"):
        forcing: Complex = 1j * b * r.stiffness + v * r.impact
    return forcing


def impact_phase(f: Any, forcing: Complex) -> Array:
    """Return the phase phi of an impact, in turns from 0 to below 1, from f exp(i phi)."""
    turns = np.angle(np.where(np.asarray(f) < 0.0, -forcing, forcing)) / (2.0 * np.pi) % 1.0
    return np.where(turns >= 1.0, 0.0, turns)


def _shear_terms(nu: Any, b: Any, R: Any, terms: FlightTerms, r: Response) -> tuple[Array, Array]:
    """Return (c, d) of the part c - d/v of the trace that the impact shears into it, eq. (C14)."""
    shear = (1.0 + np.asarray(R, float)) * terms.shear
    return shear * r.impact.imag, shear * np.square(nu) * b


def flight_multipliers(
    nu: Any, b: Any, R: Any, v: Any, terms: FlightTerms, r: Response, flights: int = 1
) -> tuple[Complex, Complex]:
    """Return the multipliers over one flight with its impact or two, eq. (C15).

    Those of the one-sided orbit repeat after one flight, those of the symmetric orbit after two. The larger modulus
    comes first, of a conjugate pair the upper one.
    """
    with np.errstate(all="ignore"):
        constant, singular = _shear_terms(nu, b, R, terms, r)
        trace = constant - singular / v - R * (1.0 + terms.decay - terms.determinant)
        half, product = 0.5 * trace + 0j, np.square(R) * terms.decay
        root = np.sqrt(half**2 - product)
        larger = half + np.where(half.real < 0.0, -root, root)
        # The other one from the product, which does not cancel.
        smaller = np.where(abs(larger) > 1e-300, product / larger, 0j)
        larger, smaller = larger**flights, smaller**flights
    turned = larger.imag < 0.0
    return np.where(turned, smaller, larger), np.where(turned, larger, smaller)


def fold_condition(nu: Any, b: Any, R: Any, v: Any, terms: FlightTerms, r: Response) -> Array:
    """Return det(I - N) of the derivative N over one flight, eq. (C16): 0 at a fold, < 0 on the lower root."""
    with np.errstate(all="ignore"):
        singular = _shear_terms(nu, b, R, terms, r)[1]
        regular = terms.determinant * (nu * abs(r.impulses)) ** 2
        # The limit at the resonance, where D vanishes and Z is infinite.
        regular = np.where(terms.determinant > 0.0, regular, np.square(1.0 + np.asarray(R, float)))
        condition: Array = regular + singular / v
    return condition


def _flip_terms(nu: Any, b: Any, R: Any, terms: FlightTerms, r: Response) -> tuple[Array, Array]:
    """Return (c, d) of the flip condition c - d/v, eq. (C17), as a sum of terms that vanish without loss."""
    constant, singular = _shear_terms(nu, b, R, terms, r)
    R = np.asarray(R, float)
    return (1.0 - R) * (1.0 - R * terms.decay) + R * terms.determinant + constant, singular


def flip_condition(nu: Any, b: Any, R: Any, v: Any, terms: FlightTerms, r: Response) -> Array:
    """Return det(I + N), eq. (C17): 0 at a flip of a one-sided orbit, at a pitchfork of a symmetric one."""
    with np.errstate(all="ignore"):
        constant, singular = _flip_terms(nu, b, R, terms, r)
        condition: Array = constant - singular / v
    return condition


def first_impact_force(b: Any, r: Response) -> Array:
    """Return the force from which on the linear motion reaches the support, eq. (C13); NaN for b <= 0."""
    force: Array = np.where(np.asarray(b) > 0.0, b * abs(r.stiffness), np.nan)
    return force


def fold_velocity(b: Any, r: Response) -> Array:
    """Return the impact velocity at which both roots meet, eq. (C18); NaN where they do not for v > 0."""
    with np.errstate(all="ignore"):
        v = -b * abs(r.stiffness) ** 2 * r.impulses.imag / abs(r.impact) ** 2
        velocity: Array = np.where(v > 0.0, v, np.nan)
    return velocity


def flip_velocity(nu: Any, b: Any, R: Any, terms: FlightTerms, r: Response) -> Array:
    """Return the impact velocity of the flip, or pitchfork, eq. (C19); NaN where there is none for v > 0."""
    with np.errstate(all="ignore"):
        constant, singular = _flip_terms(nu, b, R, terms, r)
        v = singular / constant
        velocity: Array = np.where(np.isfinite(r.impact) & (v > 0.0), v, np.nan)
    return velocity
