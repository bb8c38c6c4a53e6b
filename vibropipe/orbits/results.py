"""Results of rows: the arrays that kernels fill."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class RowResults(NamedTuple):
    """Arrays of results. An output that is not requested has no entries.

    The first dimension is the row, except for `impact_position`, `impact_velocity` and `impact_support`: the impacts of
    all rows, one row after the other. While rows are solved, their length is a capacity (`solve.row_results`). The last
    dimension of the derivatives `d_*` is the parameter; those of impacts have (position, velocity) before it. Errors of
    rows have the columns of `orbits.sensitivity.errors`, those of impacts (position, velocity). `releases` has the
    phases at which rests on supports 1 and 2 end, NaN without one. `contacts` has the columns of `march_contact`
    for each impact, and none where all supports are rigid. `energy` has sums over the orbit, or over the window of a
    motion without one: work of the force, losses by damping, at support 1 and 2, with soft supports or friction by
    friction, and the change of the stored energy. `forces` has the sums of `orbits.quadrature`, and `housing` the
    columns of `orbits.housing`, without entries where none may slide; `housing_harmonics` has the Fourier coefficients
    of its acceleration, impacts included, at the multiples of nu, and `d_housing` the derivatives of the velocity at
    the section, of the mean velocity, and of the share of sliding; `d_housing_harmonics` are those of its harmonics.
    """

    regime: np.ndarray
    frequency: np.ndarray
    status: np.ndarray
    period_multiple: np.ndarray
    settled_after: np.ndarray
    window_periods: np.ndarray
    chaos: np.ndarray
    residual: np.ndarray
    section: np.ndarray
    impacts: np.ndarray
    rests: np.ndarray
    grazings: np.ndarray
    amplitudes: np.ndarray
    multipliers: np.ndarray
    impact_count: np.ndarray
    impact_position: np.ndarray
    impact_velocity: np.ndarray
    impact_support: np.ndarray
    impact_velocity_max: np.ndarray
    energy: np.ndarray
    forces: np.ndarray
    motion: np.ndarray
    subharmonics: np.ndarray
    poincare: np.ndarray
    exponent: np.ndarray
    grazes: np.ndarray
    releases: np.ndarray
    d_section: np.ndarray
    d_amplitudes: np.ndarray
    d_subharmonics: np.ndarray
    d_multipliers: np.ndarray
    d_exponent: np.ndarray
    d_energy: np.ndarray
    d_velocity_max: np.ndarray
    d_impacts: np.ndarray
    e_row: np.ndarray
    e_impacts: np.ndarray
    contacts: np.ndarray
    housing: np.ndarray
    housing_harmonics: np.ndarray
    d_housing: np.ndarray
    d_housing_harmonics: np.ndarray
