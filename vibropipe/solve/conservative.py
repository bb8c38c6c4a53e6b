"""The conservative exciter as labelled datasets: the faces `backbone` and `amplitude_frequency`."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.compiler import jit
from vibropipe.physics.conservative import Arc, arc, arc_harmonic, backbone_velocity, top_support
from vibropipe.physics.exciter import Exciter, ParameterError, Parameters
from vibropipe.words.regimes import Regime
from vibropipe.words.vocabulary import describe

if TYPE_CHECKING:
    import xarray as xr


@jit
def _arcs(
    p: Parameters,
    amplitude: np.ndarray,
    harmonics: int,
    frequency: np.ndarray,
    meets: np.ndarray,
    coefficients: np.ndarray,
) -> None:
    """Free motions of each amplitude, tau = 0 at their upper end."""
    for i in range(amplitude.size):
        a = arc(p, 0.0, amplitude[i])
        # From the end towards support 1: the upper one, or the lower one of a mirrored motion.
        since = 0.0 if top_support(a) == 1 else a.half
        a = Arc(a.sign, a.amplitude, a.top, a.half, since, a.meets_top, a.meets_bottom)
        frequency[i] = math.pi / a.half
        meets[i, top_support(a) - 1], meets[i, 2 - top_support(a)] = a.meets_top, a.meets_bottom
        for k in range(harmonics + 1):
            coefficients[i, k] = arc_harmonic(a, k).real


def _values(name: str, values: Any, allowed: str, least: float) -> np.ndarray:
    try:
        array = np.atleast_1d(np.asarray(values, dtype=float))
    except (TypeError, ValueError):
        raise ParameterError(name, values, allowed) from None
    if array.ndim != 1 or array.size == 0 or not (np.isfinite(array) & (array > least)).all():
        raise ParameterError(name, values, allowed)
    return array


def backbone(delta_over_l: Any, tau_bar: Any) -> xr.Dataset:
    """Compute the backbone curve, eq. (10): impact velocity on support 1 against the period of free vibration.

    The exciter has no damping, no force and ideal supports (h = f = 0, R1 = R2 = 1) [1]_.

    Parameters
    ----------
    delta_over_l : float or array_like
        Offsets of the equilibrium as shares of l; one dimension, finite.
    tau_bar : float or array_like
        Periods of free vibration in tau; one dimension, greater than 0.

    Returns
    -------
    xarray.Dataset
        velocity_over_l (delta_over_l, tau_bar)
            Velocity before impact over l, in units of p = sqrt(C/m); nan where not both supports are struck.
        omega_bar (tau_bar)
            Frequency 2 pi/tau_bar, in units of p.

    Raises
    ------
    ParameterError
        If a value is not allowed.

    References
    ----------
    .. [1] V. I. Babitsky, Theory of Vibro-Impact Systems and Applications, Springer 1998.
    """
    import xarray as xr

    offsets = _values("delta_over_l", delta_over_l, "a list of finite numbers", -np.inf)
    periods = _values("tau_bar", tau_bar, "a list of finite numbers > 0", 0.0)
    velocity = backbone_velocity(offsets[:, None], periods[None, :])
    return describe(
        xr.Dataset(
            {
                "velocity_over_l": (("delta_over_l", "tau_bar"), velocity),
                "omega_bar": ("tau_bar", 2 * np.pi / periods),
            },
            {"delta_over_l": offsets, "tau_bar": periods},
        )
    )


def amplitude_frequency(exciter: Exciter, amplitude: Any, harmonics: int = 3) -> xr.Dataset:
    """Compute the free motions of the conservative exciter (h = f = 0, R1 = R2 = 1) in closed form [1]_.

    Parameters
    ----------
    exciter : Exciter
        Its supports count; damping, force and restitution are left out.
    amplitude : float or array_like
        Values of sqrt(x^2 + x'^2), in the length of l; one dimension. The mass must find room between the supports
        at each: greater than 0 and than the distance from the equilibrium to a nearest support beyond it.
    harmonics : int
        Multiples of the eigenfrequency, from 1 to 1000.

    Returns
    -------
    xarray.Dataset
        Non-dimensional as for `simulate`; tau = 0 at the end of the motion towards support 1.

        eigenfrequency, regime (amplitude)
            The regime is no_impact, one_sided_1, one_sided_2 or two_sided. A motion that only grazes a support
            does not strike it.
        displacement_mean, velocity_mean (amplitude)
        displacement_amplitude, displacement_phase, velocity_amplitude, velocity_phase (amplitude, harmonic)
            Phases in radians.

    Raises
    ------
    ParameterError
        If a value is not allowed.

    References
    ----------
    .. [1] V. I. Babitsky, Theory of Vibro-Impact Systems and Applications, Springer 1998.
    """
    import xarray as xr

    lower, upper = exciter.lower, exciter.upper
    least = max(0.0, lower, -upper)
    sizes = _values("amplitude", amplitude, f"a list of finite numbers > {least!r}", least)
    if not isinstance(harmonics, (int, np.integer)) or not 1 <= harmonics <= 1000:
        raise ParameterError("harmonics", harmonics, "a whole number from 1 to 1000")
    frequency, meets = np.empty(sizes.size), np.empty((sizes.size, 2), np.int64)
    coefficients = np.empty((sizes.size, harmonics + 1))
    _arcs(exciter.parameters(), sizes, int(harmonics), frequency, meets, coefficients)
    orders = np.arange(1, harmonics + 1)
    # The velocity is -sum c_k k w sin(k w tau) = sum c_k k w cos(k w tau + pi/2).
    over = ("amplitude", "harmonic")
    parts = 2 * coefficients[:, 1:]
    rates = parts * orders * frequency[:, None]
    strikes_1, strikes_2 = meets[:, 0] == 1, meets[:, 1] == 1
    regime = np.select(
        [strikes_1 & strikes_2, strikes_1, strikes_2],
        [Regime.TWO_SIDED, Regime.ONE_SIDED_1, Regime.ONE_SIDED_2],
        Regime.NO_IMPACT,
    )
    turned = np.where(parts < 0, np.pi, 0.0)
    variables = {
        "eigenfrequency": ("amplitude", frequency),
        "regime": ("amplitude", regime.astype(np.int8)),
        "displacement_mean": ("amplitude", coefficients[:, 0]),
        "displacement_amplitude": (over, np.abs(parts)),
        "displacement_phase": (over, turned),
        "velocity_mean": ("amplitude", np.zeros(sizes.size)),
        "velocity_amplitude": (over, np.abs(rates)),
        "velocity_phase": (over, np.where(parts < 0, -0.5 * np.pi, 0.5 * np.pi)),
    }
    coords = {"amplitude": sizes, "harmonic": orders, "l": exciter.l, "delta": exciter.delta}
    return describe(xr.Dataset(variables, coords))
