"""What a motion settles on after a ramp, beside what settles from rest at the frequency where it ends."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.physics.exciter import Exciter
from vibropipe.solve.motion.ramp import check_ramp, turns_on_ramp
from vibropipe.solve.motion.simulate import simulate
from vibropipe.solve.rows.steady import steady_state
from vibropipe.words.quantities import FLAGS
from vibropipe.words.status import Status
from vibropipe.words.vocabulary import describe

if TYPE_CHECKING:
    import xarray as xr

# Of the size of the orbit: orbits that are closed to rounding differ by far less, and others by more.
SAME_ORBIT = 1e-6
OUTPUTS = ("impacts", "poincare")
SETTLED = (
    "regime", "period_multiple", "impacts_per_orbit", "rests_per_orbit", "displacement_strobe", "velocity_strobe",
)  # fmt: skip
SAME = FLAGS["settled_same"]


def settled_after_ramp(
    exciter: Exciter, motion: xr.Dataset, tau_start: float, tau_end: float
) -> xr.Dataset:
    """Find the steady states after a ramp, held at its last frequency, and from rest at that frequency.

    exciter : with the frequency at the start of the ramp
    motion : on the ramp, as `simulate` returns it
    tau_start, tau_end : where the ramp begins and ends
    The dataset returned is empty if the motion did not come to its end. As of `steady_state` it has settled_regime,
    settled_period_multiple, settled_displacement_strobe and settled_velocity_strobe over `settled_from`, which is 0 for
    the ramp and 1 for rest, and settled_impacts_per_orbit and settled_rests_per_orbit over `support`, too. From rest
    the phase of the force is 0 at the start; after the ramp it goes on from that at its end. settled_same is 1 if both
    are one orbit, 0 if they are two, -1 if one of them is no orbit, so that this is not known.
    """
    import xarray as xr

    if int(motion["status"]) != Status.OK:
        return xr.Dataset()
    nu = float(motion["nu_end"])
    held = replace(exciter, nu=nu)
    ramp = check_ramp(exciter, tau_start, tau_end, nu)
    turn = turns_on_ramp(ramp, tau_end - tau_start) % 1.0
    # A steady state is sought from the phase 0, so the motion goes on to the next full turn.
    x, v = (float(motion[f"{name}_end"]) for name in ("displacement", "velocity"))
    end = simulate(held, held.period, x, v, tau_start=turn * held.period, samples_per_period=0)
    x, v = (float(end[f"{name}_end"]) for name in ("displacement", "velocity"))
    states = steady_state(held, x, v, outputs=OUTPUTS), steady_state(held, outputs=OUTPUTS)
    columns: dict[str, Any] = {
        f"settled_{name}": (
            ("settled_from", *states[0][name].dims),
            np.array([each[name].values for each in states]),
        )
        for name in SETTLED
    }
    columns["settled_same"] = ((), np.int8(_same(*states)))
    coords = {"settled_from": np.arange(2, dtype=np.int8), "support": states[0]["support"].values}
    return describe(xr.Dataset(columns, coords))


def _same(one: xr.Dataset, other: xr.Dataset) -> int:
    """Return whether two steady states are one orbit, as `settled_same`."""
    multiples = [int(each["period_multiple"]) for each in (one, other)]
    if not all(multiples):
        return SAME["unknown"]
    if multiples[0] != multiples[1]:
        return SAME["other"]
    names = "displacement", "velocity"
    first = np.array([float(one[f"{name}_strobe"]) for name in names])
    visits = np.stack([other[f"poincare_{name}"].values for name in names], axis=-1)
    size = np.abs(visits).max() or 1.0
    is_near = (np.abs(visits - first) <= SAME_ORBIT * size).all(axis=-1).any()
    return SAME["same" if is_near else "other"]
