"""The functions `backbone` and `amplitude_frequency`: the conservative exciter as labelled datasets."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.compiler import jit
from vibropipe.physics.conservative import Arc, arc, arc_harmonic, backbone_velocity, top_support
from vibropipe.physics.effects import WATCHED, Effects, all_effects, effect_names
from vibropipe.physics.exciter import Exciter, ParameterError, Parameters
from vibropipe.physics.limits import HARMONICS
from vibropipe.solve.checks import check_whole
from vibropipe.solve.equilibrium import about_equilibrium
from vibropipe.solve.origin_attrs import origin_attrs
from vibropipe.words.parameters import without_absent
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
    """Fill frequencies, contacts and Fourier coefficients of the free motions of each amplitude.

    amplitude : (n,) float, values of sqrt(x^2 + x'^2)
    frequency : (n,) float, output: eigenfrequencies
    meets : (n, 2) int, output: for each support 1 if it is struck, 2 if it is grazed, else 0
    coefficients : (n, harmonics + 1) float, output: of exp(i k w tau), real since tau = 0 is an end of the motion
    """
    for i in range(amplitude.size):
        a = arc(p, 0.0, amplitude[i])
        # tau = 0 at the end towards support 1, which is the lower one of a mirrored motion.
        from_top = 0.0 if top_support(a) == 1 else a.half
        a = Arc(a.sign, a.amplitude, a.top, a.half, from_top, a.meets_top, a.meets_bottom)
        frequency[i] = math.pi / a.half
        meets[i, top_support(a) - 1], meets[i, 2 - top_support(a)] = a.meets_top, a.meets_bottom
        for k in range(harmonics + 1):
            coefficients[i, k] = arc_harmonic(a, k).real


def finite_values(name: str, values: Any, allowed: str, least: float) -> np.ndarray:
    """Return values as a one-dimensional array of finite floats > `least`, or raise a ParameterError."""
    try:
        array = np.atleast_1d(np.asarray(values, dtype=float))
    except (TypeError, ValueError):
        raise ParameterError(name, values, allowed) from None
    if array.ndim != 1 or array.size == 0 or not (np.isfinite(array) & (array > least)).all():
        raise ParameterError(name, values, allowed)
    return array


def backbone(delta_over_l: Any, tau_bar: Any) -> xr.Dataset:
    """Compute the backbone of the conservative exciter (h = f = 0, R1 = R2 = 1) striking both supports, eq. (10).

    It relates the impact velocity on support 1 to the period of the free vibration [1]_.

    Parameters
    ----------
    delta_over_l : float or array_like
        Relative offset delta/l of the equilibrium; at most one-dimensional, finite.
    tau_bar : float or array_like
        Period of the free vibration, in units of 1/p; at most one-dimensional, finite, > 0.

    Returns
    -------
    xarray.Dataset
        velocity_over_l (delta_over_l, tau_bar)
            Velocity before the impact on support 1 over l, in units of p = sqrt(C/m); NaN where no motion of that
            period strikes both supports.
        omega_bar (tau_bar)
            Frequency 2 pi/tau_bar, in units of p.

    Raises
    ------
    ParameterError
        If an argument is empty, has more than one dimension or is out of range.

    References
    ----------
    .. [1] V. I. Babitsky, Theory of Vibro-Impact Systems and Applications, Springer 1998.
    """
    import xarray as xr

    offsets = finite_values("delta_over_l", delta_over_l, "a list of finite numbers", -np.inf)
    periods = finite_values("tau_bar", tau_bar, "a list of finite numbers > 0", 0.0)
    velocity = backbone_velocity(offsets[:, None], periods[None, :])
    return describe(
        xr.Dataset(
            {
                "velocity_over_l": (("delta_over_l", "tau_bar"), velocity),
                "omega_bar": ("tau_bar", 2 * np.pi / periods),
            },
            {"delta_over_l": offsets, "tau_bar": periods},
            origin_attrs(WATCHED, "free vibration"),
        )
    )


def amplitude_frequency(exciter: Exciter, amplitude: Any, harmonics: int = 3) -> xr.Dataset:
    """Compute the free motions of the conservative exciter (h = f = 0, R1 = R2 = 1) in closed form [1]_.

    Parameters
    ----------
    exciter : Exciter
        Only its supports and load are used; damping, force and restitution are ignored.
    amplitude : float or array_like
        Values of sqrt((x - load)^2 + x'^2), in the unit of l; at most one-dimensional, > 0. If the equilibrium lies
        beyond a support, each value exceeds the distance to that support.
    harmonics : int
        Number of multiples of the eigenfrequency, from 1 to 1000.

    Returns
    -------
    xarray.Dataset
        Non-dimensional as for `simulate`; tau = 0 at the end of the motion towards support 1.

        eigenfrequency, regime (amplitude)
            The regime is no_impact, one_sided_1, one_sided_2 or two_sided. A support that is only grazed is not
            struck.
        displacement_mean, velocity_mean (amplitude)
        displacement_amplitude, displacement_phase, velocity_amplitude, velocity_phase (amplitude, harmonic)
            Phases in radians.
        impact_velocity_max (amplitude, support)
            Velocity before impact by the conservation of energy, as in eq. (10); NaN on a support that is not struck.

    Raises
    ------
    ParameterError
        If an argument is out of range, or the exciter has soft supports, friction or a second harmonic.

    References
    ----------
    .. [1] V. I. Babitsky, Theory of Vibro-Impact Systems and Applications, Springer 1998.
    """
    import xarray as xr

    all_effects(vars(exciter))
    about = about_equilibrium(exciter)
    lower, upper = about.lower, about.upper
    least = max(0.0, lower, -upper)
    amplitudes = finite_values(
        "amplitude", amplitude, f"a list of finite numbers > {least!r}", least
    )
    harmonics = check_whole("harmonics", harmonics, HARMONICS)
    frequency, meets = np.empty(amplitudes.size), np.empty((amplitudes.size, 2), np.int64)
    coefficients = np.empty((amplitudes.size, harmonics + 1))
    _arcs(about.parameters(), amplitudes, harmonics, frequency, meets, coefficients)
    order = np.arange(1, harmonics + 1)
    # The velocity is -sum c_k k w sin(k w tau) = sum c_k k w cos(k w tau + pi/2).
    dims = ("amplitude", "harmonic")
    x_amplitudes = 2 * coefficients[:, 1:]
    v_amplitudes = x_amplitudes * order * frequency[:, None]
    strikes_1, strikes_2 = meets[:, 0] == 1, meets[:, 1] == 1
    regime = np.select(
        [strikes_1 & strikes_2, strikes_1, strikes_2],
        [Regime.TWO_SIDED, Regime.ONE_SIDED_1, Regime.ONE_SIDED_2],
        Regime.NO_IMPACT,
    )
    x_phases = np.where(x_amplitudes < 0, np.pi, 0.0)
    reach = np.array([upper, -lower])
    energy = (amplitudes[:, None] - reach) * (amplitudes[:, None] + reach)
    speeds = np.sqrt(np.where(meets == 1, energy, np.nan))
    variables = {
        "eigenfrequency": ("amplitude", frequency),
        "regime": ("amplitude", regime.astype(np.int8)),
        "displacement_mean": ("amplitude", coefficients[:, 0] + exciter.load),
        "displacement_amplitude": (dims, np.abs(x_amplitudes)),
        "displacement_phase": (dims, x_phases),
        "velocity_mean": ("amplitude", np.zeros(amplitudes.size)),
        "velocity_amplitude": (dims, np.abs(v_amplitudes)),
        "velocity_phase": (dims, np.where(x_amplitudes < 0, -0.5 * np.pi, 0.5 * np.pi)),
        "impact_velocity_max": (("amplitude", "support"), speeds),
    }
    used = without_absent({name: getattr(exciter, name) for name in ("l", "delta", "load")})
    coords = {"amplitude": amplitudes, "harmonic": order, "support": [1, 2], **used}
    effects = effect_names(Effects(None, None, restitution=None, rest=None), used)
    attrs = origin_attrs(effects, "free vibration, tau = 0 at its end towards support 1")
    return describe(xr.Dataset(variables, coords, attrs))
