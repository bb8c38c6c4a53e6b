"""The symmetric and one-sided orbits in closed form, and the forces at which they begin, end or change."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.physics import closed_orbits as closed
from vibropipe.physics.exciter import Exciter, ParameterError
from vibropipe.physics.stated import check_untied
from vibropipe.solve.boundary.closed_flights import Family, fly, one_sided_family, symmetric_family
from vibropipe.solve.equilibrium import displaced
from vibropipe.solve.motion.conservative import finite_values
from vibropipe.solve.origin_attrs import origin_attrs
from vibropipe.words.vocabulary import describe

if TYPE_CHECKING:
    import xarray as xr


def symmetric_orbit(exciter: Exciter, m: int = 1) -> xr.Dataset:
    """Compute the symmetric orbits (m; 1, 1) in closed form, stable or not.

    One impact on each support, half an orbit apart, with x(tau + m T/2) = -x(tau) and T the forcing period. The impact
    velocity is a root of a quadratic; docs/closed-forms.md derives it.

    Parameters
    ----------
    exciter : Exciter
        With delta = load, R1 = R2 and f other than 0.
    m : int
        Period multiple, odd, up to 999.

    Returns
    -------
    xarray.Dataset
        That of `one_sided_orbit`, with two impacts and `pitchfork_condition` in place of `flip_condition`: the motion
        over half an orbit, mirrored, has the derivative N, and `floquet_multiplier` are the squares of its eigenvalues.
        No such orbit has a flip.

    Raises
    ------
    ParameterError
        If the exciter is not mirror-symmetric or not forced, or has soft supports, friction, a second harmonic or a
        housing that slides, or m is not odd and from 1 to 999.

    References
    ----------
    S. F. Masri, T. K. Caughey, "On the stability of the impact damper", Journal of Applied Mechanics 33 (1966) 586-592.
    """
    return _orbits(symmetric_family(exciter, m))


def one_sided_orbit(exciter: Exciter, support: int = 1, m: int = 1) -> xr.Dataset:
    """Compute the orbits (m; 1, 0) or (m; 0, 1) in closed form, stable or not: one impact in m forcing periods.

    The impact velocity is a root of a quadratic; docs/closed-forms.md derives it. The other support is left out of the
    equations; `admissible` is 0 where the flight reaches it.

    Parameters
    ----------
    exciter : Exciter
        With f other than 0.
    support : int
        The support struck, 1 or 2.
    m : int
        Period multiple, up to 1,000.

    Returns
    -------
    xarray.Dataset
        Over `solution`, the two roots, the larger impact velocity first; NaN where a root is not real and > 0.

        impact_phase, impact_period, impact_support, impact_velocity (solution, impact)
            As of `steady_state`.
        displacement_strobe, velocity_strobe (solution)
            State at the start of the orbit, tau = 0; NaN where it is not admissible.
        floquet_multiplier (solution, multiplier), stable (solution)
            Complex, the larger modulus first; whether both moduli are below 1.
        fold_condition, flip_condition (solution)
            det(I - N) and det(I + N) of the derivative N of the motion over the flight: they change sign at a fold and
            at a flip. The first is negative on the second solution, which is never stable.
        clearance (solution)
            Least distance by which the flight turns back before a support (negative: beyond it); it changes sign at a
            grazing. NaN if the flight turns nowhere towards a support.
        admissible (solution)
            Whether the flight, marched from the impact with certified event location, reaches no support before the
            next impact.
        period_multiple, impacts_per_orbit (support), impacts_per_period (support)

    Raises
    ------
    ParameterError
        If the exciter is not forced, or has soft supports, friction, a second harmonic or a housing that slides,
        `support` is not 1 or 2, m is not from 1 to 1,000, or a flight takes more than 1e8 steps.

    References
    ----------
    S. W. Shaw, P. J. Holmes, "A periodically forced piecewise linear oscillator", Journal of Sound and Vibration 90
    (1983) 129-155.
    """
    return _orbits(one_sided_family(exciter, support, m))


def _orbits(family: Family) -> xr.Dataset:
    """Return both solutions of a family."""
    import xarray as xr

    e, (terms, r) = family.exciter, family.solve()
    v = np.array(closed.impact_velocities(e.f, e.upper, r))
    phase = closed.impact_phase(e.f, closed.forcing_at_impact(e.upper, v, r))
    flights_per_orbit = 2 if family.is_symmetric else 1
    multipliers = np.stack(
        closed.flight_multipliers(e.nu, e.upper, e.R1, v, terms, r, flights_per_orbit), axis=1
    )
    multipliers[np.isnan(v)] = np.nan
    flights = [fly(family, *start) for start in zip(phase, v, strict=True)]
    strobe = family.sign * np.array([flight.strobe for flight in flights])
    arguments = e.nu, e.upper, e.R1, v, terms, r
    name = "pitchfork_condition" if family.is_symmetric else "flip_condition"
    of_solution = {
        "displacement_strobe": displaced(family.given, strobe[:, 0]),
        "velocity_strobe": strobe[:, 1],
        "stable": (abs(multipliers) < 1).all(axis=1).astype(np.int8),
        "fold_condition": closed.fold_condition(*arguments),
        name: closed.flip_condition(*arguments),
        "clearance": np.array([flight.clearance for flight in flights]),
        "admissible": np.array([flight.admissible for flight in flights], np.int8),
    }
    variables: dict[str, Any] = {
        **_impacts(family, phase, v),
        "floquet_multiplier": (("solution", "multiplier"), multipliers),
        **{name: ("solution", values) for name, values in of_solution.items()},
    }
    coords = {
        **{name: ((), value) for name, value in family.given.stated().items()},
        "solution": [1, 2],
        "support": np.array([1, 2], np.int8),
        "multiplier": [1, 2],
    }
    attrs = origin_attrs(family.effects, "none: closed form")
    return describe(xr.Dataset(variables, coords, attrs))


def _impacts(family: Family, phase: np.ndarray, v: np.ndarray) -> dict[str, Any]:
    """Return the impacts of both solutions in order of time from the start of the orbit, and their numbers."""
    struck = 1 if family.sign > 0 else 2
    shares, speeds, supports = phase[:, None], family.sign * v[:, None], np.full((2, 1), struck)
    counts, multiple = [0, 0], family.n // 2
    counts[struck - 1] = 1
    if family.is_symmetric:
        counts, multiple = [1, 1], family.n
        shares = np.stack([phase, (phase + 0.5 * multiple) % multiple], axis=1)
        speeds, supports = np.stack([v, -v], axis=1), np.array([[1, 2], [1, 2]])
        order = np.argsort(shares, axis=1, kind="stable")
        shares, speeds, supports = (
            np.take_along_axis(values, order, axis=1) for values in (shares, speeds, supports)
        )
    dims = ("solution", "impact")
    return {
        "impact_phase": (dims, shares % 1.0),
        "impact_period": (dims, np.floor(np.nan_to_num(shares)).astype(np.int64)),
        "impact_support": (dims, supports.astype(np.int8)),
        "impact_velocity": (dims, speeds),
        "period_multiple": ((), multiple),
        "impacts_per_orbit": ("support", np.array(counts, float)),
        "impacts_per_period": ("support", np.array(counts, float) / multiple),
    }


def symmetric_orbit_boundaries(exciter: Exciter, nu: Any, m: int = 1) -> xr.Dataset:
    """Compute the forces at which the symmetric orbits (m; 1, 1) begin, end or lose their symmetry, over nu.

    Parameters
    ----------
    exciter : Exciter
        With delta = load and R1 = R2; its own nu and f are not used.
    nu : array_like
        Frequencies of excitation, > 0.
    m : int
        Period multiple, odd, up to 999.

    Returns
    -------
    xarray.Dataset
        That of `one_sided_orbit_boundaries`, with the pitchfork in place of the flip.

    Raises
    ------
    ParameterError
        If the exciter is not mirror-symmetric, or has soft supports, friction, a second harmonic, a shaker or a housing
        that slides, or an argument is out of range.

    Notes
    -----
    The first impact is eq. (C13), the fold (C18) and the pitchfork (C19) of docs/closed-forms.md.

    References
    ----------
    S. F. Masri, T. K. Caughey, "On the stability of the impact damper", Journal of Applied Mechanics 33 (1966) 586-592.
    """
    return _boundaries(symmetric_family(_with_unit_force(exciter), m), nu)


def one_sided_orbit_boundaries(
    exciter: Exciter, nu: Any, support: int = 1, m: int = 1
) -> xr.Dataset:
    """Compute the forces at which the orbits (m; 1, 0) or (m; 0, 1) begin, end or double their period, over nu.

    Parameters
    ----------
    exciter : Exciter
        Its own nu and f are not used.
    nu : array_like
        Frequencies of excitation, > 0.
    support : int
        The support struck, 1 or 2.
    m : int
        Period multiple, up to 1,000.

    Returns
    -------
    xarray.Dataset
        Over `nu`; NaN where there is no such force.

        first_impact_f
            Amplitude of the force from which on the linear motion reaches the support; at it an impact velocity is 0.
        fold_f, fold_velocity, fold_admissible
            Amplitude at which both roots meet, their impact velocity, and whether the orbit there is admissible. With
            less force there is no such orbit.
        flip_f, flip_velocity, flip_admissible
            The same of the flip.

    Raises
    ------
    ParameterError
        If an argument is out of range, or the exciter has soft supports, friction, a second harmonic, a shaker or a
        housing that slides.

    Notes
    -----
    The first impact is eq. (C13), the fold (C18) and the flip (C19) of docs/closed-forms.md.

    References
    ----------
    S. W. Shaw, P. J. Holmes, "A periodically forced piecewise linear oscillator", Journal of Sound and Vibration 90
    (1983) 129-155.
    """
    return _boundaries(one_sided_family(_with_unit_force(exciter), support, m), nu)


def _with_unit_force(exciter: Exciter) -> Exciter:
    """Return an exciter with f = nu = 1; ParameterError if its force grows with the frequency, since f is sought."""
    if exciter.shaker != 0.0:
        must = "must be 0: the whole amplitude of the force is sought (at nu it is f + shaker nu^2)"
        raise ParameterError("shaker", exciter.shaker, must=must)
    check_untied(exciter, "nu", ["nu"])
    check_untied(exciter, "exciter", ["f"])
    return dataclasses.replace(exciter, f=1.0, nu=1.0)


def _is_admissible(family: Family, nu: float, f: float, phase: float, v: float) -> bool:
    """Return whether the orbit of a family at other nu and f, with an impact at a phase, is admissible."""
    if not (np.isfinite(v) and f > 0.0):
        return False
    exciter = dataclasses.replace(family.exciter, nu=float(nu), f=float(f))
    return fly(family._replace(exciter=exciter), float(phase), float(v)).admissible


def _boundaries(family: Family, nu: Any) -> xr.Dataset:
    """Return the boundaries of a family over nu."""
    import xarray as xr

    values = finite_values("nu", nu, "a list of finite numbers > 0", 0.0)
    e = family.exciter
    terms = closed.flight_terms(values, e.h, family.n)
    r = closed.response(values, e.h, e.R1, terms)
    velocities = {
        "fold": closed.fold_velocity(e.upper, r),
        "pitchfork" if family.is_symmetric else "flip": closed.flip_velocity(
            values, e.upper, e.R1, terms, r
        ),
    }
    variables = {"first_impact_f": closed.first_impact_force(e.upper, r)}
    for name, v in velocities.items():
        forcing = closed.forcing_at_impact(e.upper, v, r)
        force = np.where(np.isfinite(v), abs(forcing), np.nan)
        phase = closed.impact_phase(1.0, forcing)
        admissible = [
            _is_admissible(family, *point) for point in zip(values, force, phase, v, strict=True)
        ]
        variables[f"{name}_f"], variables[f"{name}_velocity"] = force, v
        variables[f"{name}_admissible"] = np.array(admissible, np.int8)
    coords: dict[str, Any] = {
        name: ((), value)
        for name, value in family.given.stated().items()
        if name not in ("nu", "f")
    }
    attrs = origin_attrs(family.effects, "none: closed form")
    every = {name: ("nu", numbers) for name, numbers in variables.items()}
    return describe(xr.Dataset(every, {**coords, "nu": values}, attrs))
