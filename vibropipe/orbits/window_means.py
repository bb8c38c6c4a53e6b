"""What the sums over a window become: means, amplitudes, the change of the stored energy, the Lyapunov exponent."""

from __future__ import annotations

from vibropipe.compiler import jit
from vibropipe.orbits.growth import mean_growth
from vibropipe.orbits.harmonics import ONE_PERIOD, RESONANT, divide_by_stiffness, dynamic_stiffness
from vibropipe.orbits.housing import START, close_housing, momentum_of
from vibropipe.orbits.return_map import state_xv
from vibropipe.physics.housing import kinetic_change
from vibropipe.physics.load import forcing_period
from vibropipe.physics.quotient import divide
from vibropipe.physics.stiffness import energy_in_supports
from vibropipe.physics.turns import TWO_PI


@jit
def _stored_energy(e, p, x, v, x_0, v_0):
    """Return the energy stored between the states (x_0, v_0) and (x, v), in the spring, in motion and in supports."""
    # The product form of a difference of squares cancels less.
    motion = (v - v_0) * (v + v_0)
    if e.housing is not None:
        motion /= 1.0 + p.mass_ratio
    stored = 0.5 * ((x - x_0) * (x + x_0) + motion)
    return stored + energy_in_supports(e, p, x) - energy_in_supports(e, p, x_0)


@jit
def write_exponent(p, window, sums) -> None:
    """Write the Lyapunov exponent and its standard error, from the growth of a perturbation (`GrowthSums`)."""
    if window.exponent.size > 0:
        mean, error = mean_growth(sums)
        window.exponent[window.row, 0] = mean / forcing_period(p)
        window.exponent[window.row, 1] = error / forcing_period(p)


@jit
def close_window(pieces, e, p, window, end, growth) -> None:
    """Convert the sums of a window to means per forcing period and amplitudes at the multiples of nu.

    Energies stay sums. Harmonics near resonance are taken from the quadrature.

    pieces : PieceLog or None, `log.pieces`: the sums are then those of the motion itself
    end : state at the end of the window
    growth : GrowthSums, growth of a perturbation up to there
    """
    write_exponent(p, window, growth)
    periods = window.start[2]
    for side in range(2):
        window.impacts[side] /= periods
        window.rests[side] /= periods
    if window.housing.size > 0:
        close_housing(p, periods, window.housing[window.row])
    if window.housing_harmonics.size > 0:
        for k in range(window.housing_harmonics.shape[1]):
            window.housing_harmonics[window.row, k] *= 1.0 / periods
    x, v = state_xv(p, end)
    if window.energies.size > 0:
        change = _stored_energy(e, p, x, v, window.start[0], window.start[1])
        if window.housing.size > 0:
            before = window.housing[window.row, START]
            change += kinetic_change(p, before, momentum_of(end.housing))
        window.energies[window.row, window.energies.shape[1] - 1] = change
    if pieces is not None:
        if window.amplitudes.size > 0:
            amplitudes = window.amplitudes[window.row]
            for k in range(amplitudes.size):
                amplitudes[k] = divide(amplitudes[k], complex(periods, 0.0))
    elif window.amplitudes.size > 0:
        amplitudes = window.amplitudes[window.row]
        dx, dv = x - window.start[0], v - window.start[1]
        for k in range(amplitudes.size):
            # The motion is not periodic over the window, so the boundary terms of the partial integration remain.
            boundary = (dv + complex(p.h, k * p.nu) * dx) * p.nu
            amplitudes[k] -= divide(boundary, complex(TWO_PI, 0.0))
        divide_by_stiffness(p, ONE_PERIOD, periods, amplitudes)
        for k in range(amplitudes.size):
            if abs(dynamic_stiffness(p, k, ONE_PERIOD)) < RESONANT:
                amplitudes[k] = divide(window.direct[k], complex(periods, 0.0))
