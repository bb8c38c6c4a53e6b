"""The steady state of one exciter as a labelled dataset: the face `steady_state`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from vibropipe.physics.exciter import Exciter
from vibropipe.solve.sweep import MAX_PERIODS, assemble, solve_shard
from vibropipe.words.outputs import OF_STEADY_STATE

if TYPE_CHECKING:
    import xarray as xr


def steady_state(
    exciter: Exciter,
    x0: float | None = None,
    v0: float = 0.0,
    harmonics: int = 6,
    accuracy: float | None = None,
    effects: Sequence[str] | None = None,
    patience: int = MAX_PERIODS,
) -> xr.Dataset:
    """Find the law of motion of eqs. (5), (6) that settles from (x0, v0) at tau = 0.

    The motion is marched until its Poincaré section nearly repeats; shooting, Newton's method on the return map
    [1]_, then closes the orbit. The derivative of the return map is a product of free flows and saltation
    matrices [2]_, [3]_. Dimensions are those of `simulate`.

    Parameters
    ----------
    exciter : Exciter
    x0 : float, optional
        Displacement at tau = 0. Left out, it is the equilibrium, or the support nearest to the equilibrium where
        that lies beyond. Within 4 ulps of a support it lies on the support.
    v0 : float
        Velocity at tau = 0.
    harmonics : int
        Number of harmonics, from 1 to 1000.
    accuracy : float, optional
        Adds `error`, shared by all quantities (`vibropipe.solve.accuracy.row_errors`); where it is larger than
        this the status is `inaccurate`.
    effects : sequence of str, optional
        What the kernel has, as for `sweep`.
    patience : int
        Forcing periods before a motion counts as chaotic, as for `sweep`.

    Returns
    -------
    xarray.Dataset
        Every variable has the attribute `units`, which is "1", or "rad" for phases of harmonics.

        regime
            no_impact, one_sided_1, one_sided_2, two_sided, with_rest, aperiodic, unbounded or unresolved.
        status
            How the solution ended.
        period_multiple, base_frequency
            Forcing periods m of the orbit, 0 where there is none, and its frequency nu/m.
        impacts_per_orbit, rests_per_orbit (support)
        displacement_mean, velocity_mean
        displacement_amplitude, displacement_phase, velocity_amplitude, velocity_phase (harmonic)
            x = mean + sum over k of amplitude_k cos(k nu tau/m + phase_k), phases in radians.
        displacement_strobe, velocity_strobe
            State at the start of the orbit.
        impact_phase, impact_period, impact_support, impact_velocity (impact)
            Time as a fraction of a forcing period after sin(nu tau) = 0 rising, and the forcing period of the
            orbit it belongs to; support (1, 2); velocity before impact.
        impact_velocity_max (support)
            Largest speed before impact; nan where there is none.
        floquet_multiplier (multiplier), stable
            Complex, the larger modulus first.
        residual
            Distance by which the return map misses the orbit, as a share of the motion's size.
        energy_input, energy_damping, energy_impact (support), energy_residual
            Energies per orbit: work of the force, losses, and the first less the others.
        periods_to_settle
            Forcing periods marched; 0 of an orbit in closed form.
        window_periods
            A motion without an orbit is labelled so, and its harmonics and impacts are means over so many
            forcing periods.

    Raises
    ------
    ParameterError
        If the start lies outside the supports, or a value is not allowed.

    References
    ----------
    .. [1] T. S. Parker, L. O. Chua, Practical Numerical Algorithms for Chaotic Systems, Springer 1989.
    .. [2] P. C. Müller, Calculation of Lyapunov exponents for dynamic systems with discontinuities, Chaos, Solitons
       & Fractals 5 (1995) 1671.
    .. [3] R. I. Leine, H. Nijmeijer, Dynamics and Bifurcations of Non-Smooth Mechanical Systems, Springer 2004.
    """
    exciter.check_start(x0, v0)
    over = {"nu": [exciter.nu]}
    asked: dict[str, Any] = {"x0": x0, "v0": v0, "harmonics": harmonics, "outputs": OF_STEADY_STATE}
    asked |= {"accuracy": accuracy, "effects": effects, "patience": patience}
    shard = solve_shard(exciter, over, 0, 1, **asked)
    return assemble([shard], over).isel(nu=0).drop_vars("row_size")
