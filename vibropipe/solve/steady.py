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
    """The law of motion of eqs. (5), (6) that settles from (x0, v0) at tau = 0.

    Returns a dataset (non-dimensional): `regime` (no_impact, one_sided_1, one_sided_2, two_sided, with_rest,
    aperiodic, unbounded, unresolved), `status`, `period_multiple` m, `base_frequency` nu/m,
    `impacts_per_orbit, rests_per_orbit` over `support`, `displacement_mean`,
    `displacement_amplitude, displacement_phase` over `harmonic` (multiples of nu/m from 1; x = mean + sum of
    amplitude cos(k nu tau/m + phase)), the same for velocity; `impact_phase` (fraction of a forcing period
    after sin(nu tau) = 0 rising), `impact_period`, `impact_support, impact_velocity` over `impact`;
    `floquet_multiplier` over `multiplier` (complex, larger first), `stable`, `residual` of the return map
    relative to the motion's size, energies per orbit. A motion without an orbit is labelled so, and its
    harmonics and impacts are means over `window_periods` forcing periods.
    x0: left out, the equilibrium, or the support nearest to it where that lies beyond; within 4 ulps of a support
    it lies on it.
    accuracy: adds `error`, shared by all quantities (`vibropipe.solve.accuracy.row_errors`); a larger one than that has
    status `inaccurate`. effects: what the kernel has, patience: before a motion counts
    as chaotic, both as for `sweep`.
    Raises ParameterError for a start outside the supports or a value outside what is allowed.
    """
    exciter.check_start(x0, v0)
    over = {"nu": [exciter.nu]}
    asked: dict[str, Any] = {"x0": x0, "v0": v0, "harmonics": harmonics, "outputs": OF_STEADY_STATE}
    asked |= {"accuracy": accuracy, "effects": effects, "patience": patience}
    shard = solve_shard(exciter, over, 0, 1, **asked)
    return assemble([shard], over).isel(nu=0).drop_vars("row_size")
