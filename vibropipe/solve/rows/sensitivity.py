"""Derivatives of labelled quantities by the parameters, from those of amplitudes, impacts and sections."""

from __future__ import annotations

import math
from itertools import product
from typing import Any

import numpy as np

from vibropipe.compiler import jit, jit_nogil
from vibropipe.orbits.housing import GROUND, LOADS, MEAN
from vibropipe.orbits.results import RowResults
from vibropipe.orbits.sensitivity.law_housing import MEAN as DRIFT
from vibropipe.physics.derivatives import NU, differentiated_by
from vibropipe.physics.exciter import Parameters
from vibropipe.physics.restitution import SUPPORTS, damping_derivatives, is_contact_damping
from vibropipe.physics.ties import Ties
from vibropipe.solve.rows.power import TWO_PI, known_on_frame, per_time
from vibropipe.solve.rows.row_results import columns_of
from vibropipe.words.parameters import THROUGH_OTHERS, slopes_of_acted
from vibropipe.words.vocabulary import PARAMETER, SENSITIVITY_SUFFIX, row_dims

# Quantities of a housing that have derivatives, by the columns of `RowResults.d_housing`.
OF_HOUSING = ("housing_velocity_strobe", "housing_velocity_mean", "housing_slip_share")
# Share of the largest amplitude, or of its derivative, below which an amplitude, or a derivative, is rounding.
ROUNDING = 1e-13
Variables = dict[str, tuple[tuple[str, ...], np.ndarray]]

# Parameters of derivatives by their number: those of every combination of effects differ in it.
NAMES = {
    len(names): names
    for names in (differentiated_by(*effects) for effects in product((False, True), repeat=3))
}


def differentiated(variables: Variables) -> tuple[str, ...]:
    """Return the parameters by which labelled rows are differentiated; none without the output `sensitivity`."""
    for dims, values in variables.values():
        if dims[-1] == PARAMETER:
            return NAMES[values.shape[-1]]
    return ()


def label_derivatives(rows: RowResults, parameters: np.ndarray) -> Variables:
    """Label the derivatives of compacted results: `<name>_sensitivity` over the dimensions of `<name>` and `parameter`.

    rows : with arrays `d_*`; those without entries are left out
    parameters : (rows, n_parameters). Where restitution and stiffness give the damping of a soft support, it follows
        both
    """
    nu = parameters[:, Parameters._fields.index("nu")]
    values = {"displacement_strobe": rows.d_section[:, 0], "velocity_strobe": rows.d_section[:, 1]}
    if rows.d_amplitudes.size > 0:
        values |= _harmonics(rows.amplitudes, rows.d_amplitudes, nu)
        if rows.forces.size > 0:
            on_frame = _frame_forces(rows, values, nu)
            is_known = known_on_frame(parameters)[:, None, None]
            values |= {name: is_known * slopes for name, slopes in on_frame.items()}
    if rows.d_multipliers.size > 0:
        values["floquet_multiplier"] = rows.d_multipliers
    if rows.impact_count.size > 0:
        values["impact_phase"] = rows.d_impacts[:, 0]
        values["impact_velocity"] = rows.d_impacts[:, 1]
        values["impact_velocity_max"] = rows.d_velocity_max
    if rows.d_energy.size > 0:
        # Per forcing period, as the energies.
        energy = rows.d_energy / np.maximum(rows.period_multiple, 1)[:, None, None]
        values["energy_input"] = energy[:, 0]
        values["energy_damping"] = energy[:, 1]
        values["energy_impact"] = energy[:, 2:4]
        if energy.shape[1] > 4:
            values["energy_friction"] = energy[:, 4]
        if energy.shape[1] > GROUND:
            values["energy_housing_friction"] = energy[:, GROUND]
            values["energy_housing_load"] = energy[:, LOADS]
        if rows.forces.size > 0:
            values |= _powers(rows, values, nu)
    if rows.d_subharmonics.size > 0:
        amplitude, phase = _polar(rows.subharmonics[:, 1:], rows.d_subharmonics[:, 1:])
        values["subharmonic_displacement_amplitude"] = amplitude
        values["subharmonic_displacement_phase"] = phase
    if rows.d_housing.size > 0:
        for column, name in enumerate(OF_HOUSING):
            values[name] = rows.d_housing[:, column]
    if rows.d_exponent.size > 0:
        values["lyapunov_exponent"] = rows.d_exponent
    derivatives: Variables = {
        name + SENSITIVITY_SUFFIX: ((*row_dims(name), PARAMETER), array)
        for name, array in values.items()
    }
    through = _through_others(derivatives, parameters, rows.impact_count)
    return _with_dampings(through, parameters, rows.impact_count)


def _through_others(
    derivatives: Variables, parameters: np.ndarray, impact_count: np.ndarray
) -> Variables:
    """Return derivatives by what kernels see of parameters that others act on as those by all parameters."""
    names, own = differentiated(derivatives), columns_of(parameters)
    if not any(acts and own[name].any() for name, acts in THROUGH_OTHERS.items()):
        return derivatives
    shares = [
        (target, parameter, slope - (parameter == target))
        for target, by in slopes_of_acted(own).items()
        for parameter, slope in by.items()
        if parameter in names
    ]
    through = {}
    for name, (dims, values) in derivatives.items():
        changed, owner = values.copy(), _owner_of(dims, len(parameters), impact_count)
        for target, parameter, share in shares:
            seen = values[..., names.index(target)]
            own_share = share[owner].reshape(-1, *(1,) * (seen.ndim - 1))
            changed[..., names.index(parameter)] += seen * own_share
        through[name] = (dims, changed)
    return through


def through_ties(
    variables: Variables, ties: Ties, free: np.ndarray
) -> tuple[Variables, tuple[str, ...]]:
    """Return labelled rows with derivatives by the names that are free, with what they do to tied parameters.

    variables : with derivatives by each parameter alone; `row_size` of impacts, if there are any
    free : (rows, free), values of the free names of the ties
    Returns also the names by which the derivatives are: parameters that are not tied, and names of one's own. A name
    that a parameter is tied to by which there are no derivatives is left out.
    """
    names = differentiated(variables)
    lost = {root for name in ties.parameters if name not in names for root in ties.roots[name]}
    by = [name for name in (*names, *ties.own) if name not in ties.expressions and name not in lost]
    shares = np.zeros((len(free), len(names), len(by)))
    for name in {*by} & {*names}:
        shares[:, names.index(name), by.index(name)] = 1.0
    for row, values in enumerate(free.tolist()):
        for tied, slopes in ties.slopes(dict(zip(ties.free, values, strict=True)), by).items():
            for name, slope in slopes.items():
                shares[row, names.index(tied), by.index(name)] = slope
    changed = dict(variables)
    for name, (dims, values) in variables.items():
        if dims[-1] == PARAMETER:
            counts = variables["row_size"][1] if dims[0] != "row" else np.empty(0)
            owner, inner = _owner_of(dims, len(free), counts), (1,) * (values.ndim - 2)
            share = shares[owner].reshape(len(values), *inner, *shares.shape[1:])
            # A derivative that is undefined does not count where nothing acts through it.
            parts = np.where(share == 0.0, 0.0, values[..., None] * share)
            changed[name] = (dims, parts.sum(axis=-2))
    return changed, tuple(by)


def _owner_of(dims: tuple[str, ...], rows: int, impact_count: np.ndarray) -> np.ndarray:
    """Return the row of each entry of a variable over rows, or over their impacts."""
    owner = np.arange(rows)
    return owner if dims[0] == "row" else np.repeat(owner, impact_count)


def _with_dampings(
    derivatives: Variables, parameters: np.ndarray, impact_count: np.ndarray
) -> Variables:
    """Return derivatives by restitution and stiffness with what they do to a damping that they give."""
    names = differentiated(derivatives)
    for support in SUPPORTS:
        if not {*support} <= {*names}:
            continue
        R, k, h = (parameters[:, Parameters._fields.index(name)] for name in support)
        follows = (k > 0.0) & (R > 0.0) & is_contact_damping(h, R, k)
        if not follows.any():
            continue
        by = np.zeros((len(R), 2))
        by[follows] = np.transpose(damping_derivatives(R[follows], k[follows]))
        *columns, h_column = map(names.index, support)
        for name, (dims, values) in derivatives.items():
            owner = _owner_of(dims, len(R), impact_count)
            moved = follows[owner]
            by_h = values[moved, ..., h_column]
            values = values.copy()  # some variables share their array
            for column, share in zip(columns, by[owner[moved]].T, strict=True):
                values[moved, ..., column] += by_h * share.reshape(-1, *(1,) * (by_h.ndim - 1))
            derivatives[name] = (dims, values)
    return derivatives


def _harmonics(
    amplitudes: np.ndarray, derivatives: np.ndarray, nu: np.ndarray
) -> dict[str, np.ndarray]:
    """Return the derivatives of means, amplitudes and phases of displacement and velocity."""
    mean = derivatives[:, 0].real
    amplitude, phase = _polar(amplitudes[:, 1:], derivatives[:, 1:])
    multiples = np.arange(1, amplitudes.shape[1])[None, :, None]
    rate = (multiples * nu[:, None, None]) * amplitude
    rate[:, :, NU] += multiples[:, :, 0] * 2 * np.abs(amplitudes[:, 1:])
    return {
        "displacement_mean": mean,
        "displacement_amplitude": amplitude,
        "displacement_phase": phase,
        "velocity_mean": 0.0 * mean,
        "velocity_amplitude": rate,
        "velocity_phase": phase,
    }


def _frame_forces(
    rows: RowResults, of: dict[str, np.ndarray], nu: np.ndarray
) -> dict[str, np.ndarray]:
    """Return the derivatives of the harmonics of the force on the frame from those of the displacement."""
    amplitudes, phase = rows.amplitudes[:, 1:], of["displacement_phase"]
    w = np.arange(1, amplitudes.shape[1] + 1) * nu[:, None]
    if rows.d_housing_harmonics.size > 0:
        changes = w[:, :, None] ** 2 * rows.d_amplitudes[:, 1:] - rows.d_housing_harmonics[:, 1:]
        changes[:, :, NU] += 2.0 * w**2 / nu[:, None] * amplitudes
        amplitude, phase = _polar(w**2 * amplitudes - rows.housing_harmonics[:, 1:], changes)
    else:
        amplitude = w[:, :, None] ** 2 * of["displacement_amplitude"]
        amplitude[:, :, NU] += 2.0 * w**2 / nu[:, None] * (2.0 * np.abs(amplitudes))
    return {"frame_force_amplitude": amplitude, "frame_force_phase": phase}


def _powers(rows: RowResults, of: dict[str, np.ndarray], nu: np.ndarray) -> dict[str, np.ndarray]:
    """Return the derivatives of powers from those of the energies per forcing period."""
    periods = np.maximum(rows.period_multiple, 1)[:, None]
    columns: dict[str, Any] = {"input": 0, "damping": 1, "impact": slice(2, 4), "friction": 4}
    columns |= {"housing_friction": GROUND, "housing_load": LOADS}
    powers = {}
    for name, column in columns.items():
        if (slopes := of.get(f"energy_{name}")) is not None:
            power = per_time(slopes, nu)
            power[..., NU] += rows.energy[:, column].reshape(power[..., NU].shape) / (
                TWO_PI * periods.reshape(-1, *(1,) * (power.ndim - 2))
            )
            powers[f"power_{name}"] = power
    if rows.d_housing.size > 0:
        powers |= _creeping(rows, powers, nu)
    return powers


def _creeping(rows: RowResults, of: dict[str, np.ndarray], nu: np.ndarray) -> dict[str, np.ndarray]:
    """Return the derivatives of what a housing that creeps costs, from those of powers; NaN where there is none."""
    periods = np.maximum(rows.period_multiple, 1)
    work, loads = (per_time(rows.energy[:, n] / periods, nu)[:, None] for n in (0, LOADS))
    speed = rows.housing[:, MEAN, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        efficiency = loads * of["power_input"] / work**2 - of["power_housing_load"] / work
        per_distance = of["power_input"] / np.abs(speed)
        per_distance -= work / np.abs(speed) / speed * rows.d_housing[:, DRIFT]
    return {
        "efficiency": np.where((loads < 0.0) & (work > 0.0), efficiency, np.nan),
        "work_per_distance": np.where(speed != 0.0, per_distance, np.nan),
    }


def _polar(values: np.ndarray, derivatives: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the derivatives of 2 |X| and arg X, from X (rows, n) and its derivatives (rows, n, parameters)."""
    amplitude, phase = np.empty(derivatives.shape), np.empty(derivatives.shape)
    polar_derivatives(values, derivatives, amplitude, phase)
    return amplitude, phase


@jit
def largest_modulus(values: np.ndarray) -> float:
    """Return the largest modulus of complex values (n,), without regard to NaN."""
    largest = 0.0
    for value in values:
        size = abs(value)
        largest = size if size > largest else largest
    return largest


@jit_nogil
def polar_derivatives(
    values: np.ndarray, derivatives: np.ndarray, amplitude: np.ndarray, phase: np.ndarray
) -> None:
    """Fill the derivatives of 2 |X| and arg X.

    Where X is zero within rounding the phase has no derivative, and the amplitude one only if that of X is zero.

    values : (rows, n) complex, X
    derivatives : (rows, n, parameters) complex, of X
    amplitude, phase : (rows, n, parameters) float, filled
    """
    for row in range(values.shape[0]):
        rounding = ROUNDING * largest_modulus(values[row])
        for q in range(values.shape[1]):
            x = values[row, q]
            size = abs(x)
            for k in range(derivatives.shape[2]):
                d = derivatives[row, q, k]
                if size <= rounding:
                    steepest = largest_modulus(derivatives[row, :, k])
                    stays = abs(d) <= ROUNDING * steepest
                    amplitude[row, q, k], phase[row, q, k] = 0.0 if stays else math.nan, math.nan
                else:
                    turned = x.conjugate() * d
                    amplitude[row, q, k] = 2.0 * turned.real / size
                    phase[row, q, k] = turned.imag / (size * size)
