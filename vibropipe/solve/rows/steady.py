"""The function `steady_state`: the steady state of one exciter as a labelled dataset."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from vibropipe.physics.exciter import Exciter
from vibropipe.physics.stated import ties_of_call
from vibropipe.solve.physical import to_physical
from vibropipe.solve.sweep.blocks import MAX_PERIODS, assemble, solve_shard
from vibropipe.solve.sweep.sweep import check_solver
from vibropipe.solve.sweep.sweep_grid import SweepGrid
from vibropipe.solve.warn import warn_unsolved
from vibropipe.solve.with_units import are_with_units, plain_values
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
    outputs: Sequence[str] = OF_STEADY_STATE,
) -> xr.Dataset:
    """Find the steady state of eqs. (5), (6) that the motion from (x0, v0) at tau = 0 settles on.

    The motion is marched until its stroboscopic section nearly repeats; shooting, Newton's method on the return map
    [1]_, then closes the orbit. The Jacobian of the return map is a product of flow and saltation matrices [2]_, [3]_.
    Dimensions are those of `simulate`.

    Parameters
    ----------
    exciter : Exciter
    x0 : float, optional
        Displacement at tau = 0. The default is the equilibrium or, if the equilibrium lies beyond a support, that
        support. A value within 4 ulps of a support is moved onto it.
    v0 : float
        Velocity at tau = 0. Of an exciter of `from_physical` the start may have units, as text or quantities of pint;
        the dataset is then in SI.
    harmonics : int
        Number of harmonics, from 1 to 1000.
    accuracy : float, optional
        Adds `error`, one error estimate for all quantities (`vibropipe.solve.accuracy.orbit_errors`); if it exceeds
        `accuracy`, the status is `inaccurate`.
    effects : sequence of str, optional
        Effects of the kernel, as for `sweep`.
    patience : int
        Forcing periods, from 128 to 1,000, after which a chaotic motion is given up, as for `sweep`.
    outputs : sequence of str
        Any of harmonics, impacts, motion, stability, energy, power, frame, subharmonics, poincare, lyapunov,
        sensitivity; others are not computed.

    Returns
    -------
    xarray.Dataset
        Every variable has the attribute `units`, which is "1", or "rad" for phases of harmonics.

        regime
            no_impact, one_sided_1, one_sided_2, two_sided, with_rest, aperiodic, unbounded or unresolved.
        status
            Outcome of the run.
        period_multiple, base_frequency
            Forcing periods m of the orbit, 0 without an orbit, and its frequency nu/m.
        impacts_per_period (support)
            Impacts per forcing period, periodic or not; NaN if the motion is not solved.
        impacts_per_orbit, rests_per_orbit (support)
            Impacts before a rest are those that were computed one by one: a chatter has infinitely many.
        grazings_per_orbit (support)
            Contacts slower than 1e-9 of the largest speed or displacement of the orbit. They are no impacts: the regime
            and the multipliers are those of the motion without them. 0 without an orbit.
        displacement_mean, velocity_mean
        displacement_amplitude, displacement_phase, velocity_amplitude, velocity_phase (harmonic)
            Sum of amplitude_k cos(k nu tau + phase_k), phases in radians: with the mean the motion itself if m = 1,
            the part of it that repeats every forcing period if m > 1. A conservative motion has multiples of its own
            frequency.
        subharmonic_displacement_amplitude, subharmonic_displacement_phase (subharmonic)
            The rest of an orbit with m > 1: sum of amplitude_j cos(j nu tau/m + phase_j), j = 1, 2, ... up to four
            times the number of harmonics. NaN where j is a multiple of m, which is a harmonic, and without an orbit.
        displacement_strobe, velocity_strobe
            State at the start of the orbit; without an orbit, the last state at the section.
        housing_velocity_strobe, housing_velocity_mean, housing_velocity_max, housing_slip_share
            Of a housing that slides: its velocity at the start of the orbit, the mean and the largest one, and the
            share of time in which it slides. Of an unbounded motion the mean and the largest are NaN.
        poincare_displacement, poincare_velocity (visit)
            States at the section, once each forcing period: 64 from the start of the orbit, or the last 64.
        impact_phase, impact_period, impact_support, impact_velocity (impact)
            Time as a fraction of a forcing period after a rising zero of sin(nu tau), index of the forcing period in
            the orbit, support (1, 2), and velocity before impact. Without an orbit: of the last 64 forcing periods (of
            `window_periods` if fewer), 0 to 63, or of as many whole periods at their end as have 8192 impacts.
        impact_velocity_max (support)
            Largest speed before impact; NaN without an impact.
        impact_velocity_after, contact_duration, contact_force_max, contact_depth_max (impact)
            With soft supports, as `simulate` has them: velocity on leaving, duration of the contact, largest force of
            the support and largest depth. An impact on a rigid support has the velocity after it, and NaN else.
        contact_duration_max, support_force_max, support_depth_max (support)
            With soft supports: the largest of these contacts; NaN where the support is rigid or without an impact.
        floquet_multiplier (multiplier), stable
            Complex, the larger modulus first; whether both moduli are below 1 by more than their errors.
        lyapunov_exponent, lyapunov_exponent_error
            Largest Lyapunov exponent per unit of tau, and its standard error. Of an orbit log|multiplier| / (m T), T
            the forcing period, with error 0; -inf where a rest erases every perturbation. Without an orbit: the mean
            growth of a perturbation [4]_ over the last 70 forcing periods, with the error from blocks of 5 of them.
        <name>_error
            Error estimate (float32) of the state at the start of the orbit, the harmonics of displacement, multipliers,
            and impacts: rounding and residual, carried through the inverse that closes the orbit. NaN without an orbit.
        <name>_sensitivity (..., parameter)
            With the output sensitivity: the derivative, by each parameter, of the state at the start of the orbit and
            of the quantities of harmonics, impacts, stability, energy, mean power, subharmonics, lyapunov and harmonics
            of the force on the frame that are requested beside it, exact by the implicit function theorem. NaN where
            there is none: without an orbit, or with one that is not isolated, at a grazing, a fold or a pitchfork. With
            a second harmonic also by f2 and phi2; with soft supports or friction by k1, k2, h1, h2, friction and
            friction_ratio: NaN by the stiffness of a rigid support, and by a friction of 0; with a housing also by its
            mass ratio, frictions and load. A damping that a restitution gives follows it and the stiffness.
        residual
            Residual of the return map, relative to the norm of the motion.
        displacement, velocity (phase)
            With the output motion: an orbit, sampled over the fraction `phase` of it.
        energy_input, energy_damping, energy_impact (support), energy_friction, energy_change, energy_residual
        energy_housing_friction, energy_housing_load
            Energies per forcing period, of a motion without an orbit the means over its window: work of the force,
            losses (by friction if there is any), change of the stored energy (0 of an orbit), and the residual of the
            balance; of a housing that slides the loss on the ground and the work of the constant forces.
        power_input, power_damping, power_impact (support), power_friction, power_change, power_residual
            With the output power: the same per unit of time.
        power_input_max, drive_force_max, power_struck (support)
            Largest power and force of the drive, and the kinetic energy before impacts per unit of time.
        power_housing_friction, power_housing_load, efficiency, work_per_distance
            With the output power, of a housing that slides: what the ground takes and the constant forces do; power
            against these forces over that of the force, and its work per distance.
        frame_force_mean, frame_force_rms, frame_force_max
        frame_force_amplitude, frame_force_phase (harmonic)
            With the output frame: the force on the frame between impacts on rigid supports, load - x'', and the
            harmonics of the whole force, impacts included.
        impulse_per_period, wear_rate (support), impact_impulse (impact)
            With the output frame: impulses that a support takes, per forcing period and, with the output impacts, of
            each impact; the sum of |v|^wear_exponent over impacts per unit of time.
        chaos
            none, transient or in_window. Transient: a motion that settled after more than 64 forcing periods had
            amplified its rounding to 1e-4 of its size, so that rounding may have decided on which of several attractors
            it did. In_window: perturbations grew e^6-fold in the last periods before the motion was left, and whether
            they do for ever is not known: it may settle later. An aperiodic motion without chaos is a transient, on an
            orbit of more than 256 forcing periods, or one of several frequencies, without losses.
        periods_to_settle
            Forcing periods marched; 0 for an orbit in closed form.
        window_periods
            Length of the window, in forcing periods, over which harmonics, impacts and energies of a motion without an
            orbit are averaged; 0 with an orbit.

    Raises
    ------
    ParameterError
        If the start lies beyond a rigid support, or an argument is out of range.

    Warns
    -----
    UnsolvedWarning
        If the status is not `ok`, with the remedy.

    References
    ----------
    .. [1] T. S. Parker, L. O. Chua, Practical Numerical Algorithms for Chaotic Systems, Springer 1989.
    .. [2] P. C. Müller, Calculation of Lyapunov exponents for dynamic systems with discontinuities, Chaos, Solitons
       & Fractals 5 (1995) 1671.
    .. [3] R. I. Leine, H. Nijmeijer, Dynamics and Bifurcations of Non-Smooth Mechanical Systems, Springer 2004.
    .. [4] G. Benettin, L. Galgani, A. Giorgilli, J.-M. Strelcyn, Lyapunov characteristic exponents for smooth dynamical
       systems, Meccanica 15 (1980) 9.
    """
    if are_with_units(exciter, x0, v0):
        x, v = (plain_values(exciter, name, each) for name, each in (("x0", x0), ("v0", v0)))
        found = steady_state(exciter, x, v, harmonics, accuracy, effects, patience, outputs)
        return to_physical(found, exciter)
    exciter.check_start(x0, v0)
    exciter.check_frequency()
    exciter, ties = ties_of_call(exciter, None)
    grid = SweepGrid({}, None, exciter.stated(), ties)
    start = None if x0 is None else float(x0), float(v0)
    solver = check_solver(harmonics, outputs, accuracy, patience)
    shard = solve_shard(grid, 0, 1, start=start, effects=effects, **solver)
    return warn_unsolved(assemble([shard], grid).drop_vars("row_size", errors="ignore"))
