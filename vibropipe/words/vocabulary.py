"""One table of every quantity a dataset can hold: name -> dimensions, units, long name, symbol.

Datasets, figures, reports and documents read their words here, so that a quantity is spelled in
one way everywhere. Lengths are in the length that was chosen for ``l``, times in ``1/p`` with
``p = sqrt(C/m)`` (eqs. (2)-(4)): everything is non-dimensional, except phases of harmonics.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from vibropipe.words.regimes import Regime
from vibropipe.words.status import Status

if TYPE_CHECKING:
    import xarray as xr

    Described = TypeVar("Described", bound=xr.Dataset)

PARAMETERS = ("nu", "f", "h", "l", "delta", "R1", "R2")
ERROR_SUFFIX = "_error"


class Outcome(IntEnum):
    """How a method got through a motion it was timed on."""

    OK = 0
    MISSED_IMPACT = 1
    FELL_THROUGH = 2
    DID_NOT_END = 3
    NOT_TRIED = 4
    NOT_INSTALLED = 5


OUTCOMES: Mapping[str, int] = {member.name.lower(): int(member) for member in Outcome}
REGIMES: Mapping[str, int] = {member.name.lower(): int(member) for member in Regime}
SUPPORTS: Mapping[str, int] = {"support_1": 1, "support_2": 2}
STABLE: Mapping[str, int] = {"unstable": 0, "stable": 1}
PASSED: Mapping[str, int] = {"not_passed": 0, "passed": 1, "not_asked": 2}


@dataclass(frozen=True)
class Quantity:
    """What is known of a name.

    ``dims`` are the dimensions it has in the smallest dataset that holds it; swept dimensions
    (or ``row`` in a shard) stand in front of them, and a motion over one orbit runs over
    ``phase`` in place of ``tau``. ``symbol`` is matplotlib mathtext. ``flags`` are the names of
    its integer values, or None. A count per row names the dimension of what it counts (CF).
    """

    dims: tuple[str, ...]
    units: str
    long_name: str
    symbol: str
    flags: Mapping[str, int] | None = None
    sample_dimension: str | None = None


def _number(dims: str, long_name: str, symbol: str, **more: Any) -> Quantity:
    """Build a quantity without dimension (units "1"); ``dims`` parted by spaces."""
    return Quantity(tuple(dims.split()), "1", long_name, symbol, **more)


def _radians(dims: str, long_name: str, symbol: str) -> Quantity:
    return Quantity(tuple(dims.split()), "rad", long_name, symbol)


_RACE, _TRIAL = "motion method setting", "motion kernel"


def _nanoseconds(long_name: str, dims: str = _RACE) -> Quantity:
    return Quantity(tuple(dims.split()), "ns", long_name, r"$t$")


def _megabytes(long_name: str) -> Quantity:
    return Quantity(("points",), "MB", long_name, r"$M$")


VOCABULARY: dict[str, Quantity] = {
    # the exciter, eqs. (1)-(6)
    "nu": _number("", "frequency of excitation", r"$\nu$"),
    "f": _number("", "amplitude of excitation", r"$f$"),
    "h": _number("", "damping", r"$h$"),
    "l": _number("", "half distance between the supports", r"$l$"),
    "delta": _number("", "offset of the equilibrium", r"$\delta$"),
    "R1": _number("", "restitution of support 1", r"$R_1$"),
    "R2": _number("", "restitution of support 2", r"$R_2$"),
    # motion
    "tau": _number("tau", "time", r"$\tau$"),
    "phase": _number("phase", "fraction of the orbit", r"$\tau/T$"),
    "displacement": _number("tau", "displacement", r"$x$"),
    "velocity": _number("tau", "velocity", r"$\dot{x}$"),
    "force": _number("tau", "force", r"$\bar{f}$"),
    "displacement_exact": _number("tau", "displacement of the exact motion", r"$x_{exact}$"),
    "velocity_exact": _number("tau", "velocity of the exact motion", r"$\dot{x}_{exact}$"),
    "displacement_end": _number("", "displacement at the end", r"$x_{end}$"),
    "velocity_end": _number("", "velocity at the end", r"$\dot{x}_{end}$"),
    "impact": _number("impact", "number of the impact", r"$i$"),
    "impact_tau": _number("impact", "time of impact", r"$\tau_i$"),
    "impact_support": _number("impact", "support struck", r"$s_i$", flags=SUPPORTS),
    "impact_velocity": _number("impact", "velocity before impact", r"$\dot{x}^-$"),
    "impact_velocity_after": _number("impact", "velocity after impact", r"$\dot{x}^+$"),
    "rest": _number("rest", "number of the rest", r"$j$"),
    "rest_start": _number("rest", "start of rest", r"$\tau_{rest}$"),
    "rest_end": _number("rest", "release from rest, inf if never released", r"$\tau_{release}$"),
    "rest_support": _number("rest", "support rested on", r"$s_{rest}$", flags=SUPPORTS),
    "grazing": _number("grazing", "number of the grazing", r"$g$"),
    "grazing_tau": _number("grazing", "time of grazing", r"$\tau_g$"),
    "grazing_support": _number("grazing", "support grazed", r"$s_g$", flags=SUPPORTS),
    # steady state
    "regime": _number("", "regime of motion", "regime", flags=REGIMES),
    "status": _number("", "how the solution ended", "status"),
    "error": _number("", "error estimate, absolute or relative to the size", r"$e$"),
    "orbit_error": _number("", "error estimate of the orbit", r"$e$"),
    "period_multiple": _number("", "forcing periods per orbit, 0 if no orbit was found", r"$m$"),
    "support": _number("support", "support", r"$s$", flags=SUPPORTS),
    "impacts_per_orbit": _number(
        "support", "impacts per orbit, or per forcing period if aperiodic", r"$p_s$"
    ),
    "rests_per_orbit": _number(
        "support", "rests per orbit, or per forcing period if aperiodic", r"$r_s$"
    ),
    "base_frequency": _number("", "base frequency of the orbit", r"$\omega_0$"),
    "residual": _number("", "distance by which the orbit fails to close", r"$\varepsilon$"),
    "periods_to_settle": _number("", "forcing periods marched until settled", r"$n_{settle}$"),
    "displacement_strobe": _number("", "displacement at the start of the orbit", r"$x_0$"),
    "velocity_strobe": _number("", "velocity at the start of the orbit", r"$\dot{x}_0$"),
    "window_periods": _number(
        "", "forcing periods averaged over if aperiodic, 0 if periodic", r"$n_{window}$"
    ),
    # harmonics: x = mean + sum of amplitude_k cos(k omega_0 tau + phase_k)
    "harmonic": _number("harmonic", "harmonic of the base frequency", r"$k$"),
    "displacement_mean": _number("", "constant part of displacement", r"$\bar{x}$"),
    "velocity_mean": _number("", "constant part of velocity", r"$\bar{\dot{x}}$"),
    "displacement_amplitude": _number("harmonic", "harmonic amplitude of displacement", r"$A_k$"),
    "displacement_phase": _radians("harmonic", "harmonic phase of displacement", r"$\varphi_k$"),
    "velocity_amplitude": _number("harmonic", "harmonic amplitude of velocity", r"$B_k$"),
    "velocity_phase": _radians("harmonic", "harmonic phase of velocity", r"$\psi_k$"),
    # impacts of the orbit
    "impact_phase": _number(
        "impact", "fraction of the forcing period at impact", r"$\nu\tau_i/2\pi$"
    ),
    "impact_period": _number("impact", "forcing period of the orbit at impact", r"$n_i$"),
    "impact_velocity_max": _number(
        "support", "largest velocity before impact", r"$\max|\dot{x}^-|$"
    ),
    "row_size": _number("", "impacts of the row", r"$p$", sample_dimension="impact"),
    "row_rests": _number("", "rests of the row", r"$r$", sample_dimension="rest"),
    "orbit_impact": _number("orbit_impact", "number of the impact in the orbit", r"$i$"),
    "orbit_impact_phase": _number(
        "orbit_impact", "fraction of the forcing period at impact of the orbit", r"$\nu\tau_i/2\pi$"
    ),
    "orbit_impact_support": _number(
        "orbit_impact", "support struck in the orbit", r"$s_i$", flags=SUPPORTS
    ),
    "orbit_impact_velocity": _number(
        "orbit_impact", "velocity before impact of the orbit", r"$\dot{x}^-$"
    ),
    "orbit_impact_period": _number(
        "orbit_impact", "forcing period of the orbit at impact of the orbit", r"$n_i$"
    ),
    "orbit_energy_input": _number("", "work of the force per orbit", r"$W_f$"),
    "orbit_energy_damping": _number("", "energy lost by damping per orbit", r"$W_h$"),
    "orbit_energy_impact": _number("support", "energy lost at the support per orbit", r"$W_s$"),
    "orbit_energy_residual": _number("", "gap in the energy balance per orbit", r"$\Delta W$"),
    # stability
    "multiplier": _number("multiplier", "number of the Floquet multiplier", r"$j$"),
    "floquet_multiplier": _number("multiplier", "Floquet multiplier", r"$\mu_j$"),
    "stable": _number("", "stability of the orbit", "stability", flags=STABLE),
    # energy per orbit, or of a motion from its start to its end
    "energy_input": _number("", "work of the force", r"$W_f$"),
    "energy_damping": _number("", "energy lost by damping", r"$W_h$"),
    "energy_impact": _number("support", "energy lost at the support", r"$W_s$"),
    "energy_change": _number("", "energy stored", r"$\Delta E$"),
    "energy_residual": _number("", "gap in the energy balance", r"$\Delta W$"),
    # backbone, eq. (10)
    "delta_over_l": _number("delta_over_l", "relative offset of the equilibrium", r"$\delta/l$"),
    "tau_bar": _number("tau_bar", "period of free vibration", r"$\bar{\tau}$"),
    "omega_bar": _number("tau_bar", "frequency of free vibration", r"$\bar{\omega}$"),
    "velocity_over_l": _number(
        "delta_over_l tau_bar", "relative velocity before impact on support 1", r"$\dot{x}_1^-/l$"
    ),
    "point": _number("point", "number of the simulated motion", r"$n$"),
    "simulated_tau_bar": _number(
        "delta_over_l point", "period of the simulated free vibration", r"$\bar{\tau}$"
    ),
    "simulated_velocity_over_l": _number(
        "delta_over_l point",
        "relative velocity before impact on support 1, simulated",
        r"$\dot{x}_1^-/l$",
    ),
    # amplitude-frequency characteristics of the conservative exciter
    "amplitude": _number("amplitude", "linear amplitude of the free motion", r"$A$"),
    "eigenfrequency": _number("amplitude", "eigenfrequency", r"$\bar{\omega}$"),
    # hard cases
    "case": _number("case", "hard case", "case"),
    "solver": _number("solver", "method, with its steps per forcing period", "solver"),
    "asked": _number("case", "what was asked", "asked"),
    "known": _number("case", "what is conserved or known", "known"),
    "measured": _number("case solver", "distance from what is known", r"$e$"),
    "bound": _number("case solver", "how large it may be", r"$e_{max}$"),
    "passed": _number("case solver", "whether the case is passed", "passed", flags=PASSED),
    "worst_status": _number("case solver", "worst status of the motions", "status"),
    "motions": _number("case solver", "motions solved", r"$n$"),
    "impacts": _number("case solver", "impacts in the motions", r"$p$"),
    "short_flight_motions": _number(
        "case solver", "motions with flights shorter than a step", r"$n_{short}$"
    ),
    # what accuracy costs
    "motion": _number("motion", "motion", "motion"),
    "method": _number("method", "method", "method"),
    "setting": _number("setting", "number of the setting", "$i$"),
    "setting_value": _number("method setting", "steps per forcing period, or tolerance", r"$n$"),
    "displacement_start": _number("motion", "displacement at the start", r"$x(0)$"),
    "velocity_start": _number("motion", "velocity at the start", r"$\dot{x}(0)$"),
    "error_end": _number(_RACE, "relative error of the end state", r"$e$"),
    "error_impact_tau": _number(
        _RACE, "error of impact times over the forcing period", r"$e_\tau$"
    ),
    "error_impact_velocity": _number(_RACE, "relative error of impact velocities", r"$e_v$"),
    "error_harmonics": _number(_RACE, "relative error of harmonics of displacement", r"$e_A$"),
    "work_steps": _number(_RACE, "steps per forcing period", r"$n$"),
    "work_evaluations": _number(_RACE, "evaluations per forcing period", r"$n_f$"),
    "work_iterations": _number(_RACE, "iterations for impacts per forcing period", r"$n_r$"),
    "time_per_period": _nanoseconds("median time per forcing period"),
    "time_per_period_low": _nanoseconds("lower quartile of time per forcing period"),
    "time_per_period_high": _nanoseconds("upper quartile of time per forcing period"),
    "outcome": _number(_RACE, "how the method got through", "outcome", flags=OUTCOMES),
    "periods_run": _number("motion method", "forcing periods run", r"$n_T$"),
    "accuracy": _number("accuracy", "error to reach", r"$e$"),
    "time_to_reach": Quantity(
        ("motion", "method", "accuracy"),
        "ns",
        "least time per forcing period for the error",
        r"$t$",
    ),
    "order": _number("motion method", "order of convergence", r"$p$"),
    # what effects and outputs cost
    "kernel": _number("kernel", "kernel, and whose motion it solves", "kernel"),
    "kernel_time": _nanoseconds("median time per forcing period", _TRIAL),
    "kernel_time_low": _nanoseconds("lower quartile of time per forcing period", _TRIAL),
    "kernel_time_high": _nanoseconds("upper quartile of time per forcing period", _TRIAL),
    "time_ratio": _number(_TRIAL, "median time of the own kernel over each", r"$t/t_k$"),
    "time_ratio_low": _number(_TRIAL, "lower quartile of the ratio of times", r"$t/t_k$"),
    "time_ratio_high": _number(_TRIAL, "upper quartile of the ratio of times", r"$t/t_k$"),
    "bytes_per_row": Quantity(
        tuple(_TRIAL.split()),
        "byte",
        "bytes stored for a row, or for a forcing period of a motion",
        "$b$",
    ),
    "bytes_ratio": _number(_TRIAL, "bytes of a row over those of each", "$b/b_k$"),
    "target_ratio": _number("motion", "median time over that of what the target is about", "$q$"),
    "target_ratio_low": _number("motion", "lower quartile of the ratio of the target", "$q$"),
    "target_ratio_high": _number("motion", "upper quartile of the ratio of the target", "$q$"),
    "target": _number("motion", "largest ratio aimed at, nan for none", r"$q_{max}$"),
    "target_met": _number("motion", "whether the target is met", "met", flags=PASSED),
    "target_against": _number("motion", "whose time is the 1 of the target", "against"),
    "periods_timed": _number(_TRIAL, "forcing periods that the time is divided by", "$n_T$"),
    "impacts_per_period": _number(_TRIAL, "impacts per forcing period", "$p$"),
    "rests_per_period": _number(_TRIAL, "rests per forcing period", "$r$"),
    "effects_present": _number("motion", "effects that the motion calls for", "effects"),
    "outputs_asked": _number("motion", "outputs that are asked for", "outputs"),
    # growth: what studies of more and more points take
    "points": _number("points", "number of points", r"$N$"),
    "threads": _number("threads", "number of threads", r"$p$"),
    "time_per_point": Quantity(
        ("points", "threads"), "ms", "time per point by the clock", r"$t/N$"
    ),
    "work_per_point": Quantity(
        ("points", "threads"), "ms", "time per point of all threads together", r"$w/N$"
    ),
    "storing_per_point": Quantity(
        ("points", "threads"), "ms", "time per point with the results stored", r"$t_s/N$"
    ),
    "peak_memory": Quantity((), "MB", "largest memory of a process", r"$M$"),
    "solving_memory": _megabytes("largest memory of a job that solves"),
    "joining_memory": _megabytes("largest memory of the join"),
    "query_memory": _megabytes("largest memory of a query"),
    "joining_rate": Quantity(("points",), "MB s-1", "rate of writing the joined file", r"$r$"),
    "copying_rate": Quantity(("points",), "MB s-1", "rate of copying the joined file", r"$r_c$"),
    # shards of a sweep
    "row": _number("row", "row of the swept grid", r"$n$"),
}


def quantity(name: str) -> Quantity:
    """Look up ``name``; ``<name>_error`` is the error estimate of ``<name>``.

    Raises KeyError naming a quantity that is not in the table.
    """
    found = VOCABULARY.get(name)
    if found is not None:
        return found
    base = VOCABULARY.get(name.removesuffix(ERROR_SUFFIX))
    if base is None:
        raise KeyError(f"{name!r} is not in the vocabulary (vibropipe/vocabulary.py)")
    return Quantity(base.dims, base.units, f"error estimate of {base.long_name}", base.symbol)


def label(name: str) -> str:
    """Return what an axis says: long name, symbol, and units where there are any."""
    entry = quantity(name)
    units = "" if entry.units == "1" else f" ({entry.units})"
    return f"{entry.long_name} {entry.symbol}{units}"


def flags(name: str) -> Mapping[str, int] | None:
    """Return the names of the integer values of ``name``, or None if its values are numbers."""
    if name in ("status", "worst_status"):
        return {member.name.lower(): int(member) for member in Status}
    return quantity(name).flags


def attributes(name: str) -> dict[str, Any]:
    """Return the CF attributes of ``name``: units, long_name, symbol, and flags if it has any."""
    entry = quantity(name)
    attrs: dict[str, Any] = {
        "units": entry.units,
        "long_name": entry.long_name,
        "symbol": entry.symbol,
    }
    if entry.sample_dimension is not None:
        attrs["sample_dimension"] = entry.sample_dimension
    named = flags(name)
    if named is not None:
        attrs["flag_values"] = np.array(list(named.values()), dtype=np.int8)
        attrs["flag_meanings"] = " ".join(named)
    return attrs


def describe(dataset: Described) -> Described:
    """Set the attributes of every variable of ``dataset`` in place, and return it.

    Attributes that are not of the vocabulary stay. ``flag_values`` take the type of the variable,
    as CF asks. Raises KeyError on a name that is not in the table.
    """
    for name, variable in dataset.variables.items():
        attrs = attributes(str(name))
        if "flag_values" in attrs:
            # truth values lie on disk as int8
            dtype = variable.dtype if variable.dtype.kind in "iu" else np.int8
            attrs["flag_values"] = attrs["flag_values"].astype(dtype)
        variable.attrs.update(attrs)
    return dataset
