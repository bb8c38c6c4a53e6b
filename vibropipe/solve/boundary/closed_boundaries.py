"""Where the orbits in closed form begin, end or change: the forces of first impact, fold, flip and pitchfork."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.physics import closed_orbits as closed
from vibropipe.physics.exciter import Exciter, ParameterError
from vibropipe.physics.stated import check_untied
from vibropipe.solve.boundary.closed_flights import Family, fly, one_sided_family, symmetric_family
from vibropipe.solve.motion.conservative import finite_values
from vibropipe.solve.origin_attrs import origin_attrs
from vibropipe.words.vocabulary import describe

if TYPE_CHECKING:
    import xarray as xr


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
