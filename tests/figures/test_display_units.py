"""Datasets in the units that a study wrote or chose."""

import math

import numpy as np
import pytest
import xarray as xr

import vibropipe as vp
from vibropipe.figures.text import axis_label, plain_value, value_text
from vibropipe.figures.units import display_units, unit_text
from vibropipe.solve.shown_units import dimension_of, in_si, shown_unit

M, C = 2.0, 8000.0
P = math.sqrt(C / M)
UNITS = "frequency: Hz; length: mm; velocity: mm/s; stiffness: N/mm; force: N; F: kN"


def physical(**quantities) -> xr.Dataset:
    """A dataset in SI of quantities without units, lengths in metres."""
    from vibropipe.words.vocabulary import describe

    coords = {"nu": np.linspace(3, 30, 541) * 2 * math.pi / P, "f": 120.0 / C, "l": 0.008}
    return vp.to_physical(describe(xr.Dataset(quantities, coords)), M, C)


def shown(dataset: xr.Dataset, units: str = UNITS, **options) -> xr.Dataset:
    return display_units({"": dataset.assign_attrs(display_units=units)}, **options)[""]


def test_numbers_come_back_as_they_were_written():
    dataset = shown(physical())
    assert dataset["omega"].values.tolist() == [round(3 + 0.05 * n, 2) for n in range(541)]
    assert [float(dataset[name]) for name in ("l", "C", "F")] == [8.0, 8.0, 0.12]
    assert [dataset[n].attrs["units"] for n in ("omega", "C", "F")] == ["Hz", "N/mm", "kN"]


def test_frequencies_in_cycles_have_the_symbol_of_cycles():
    omega = shown(physical())["omega"]
    assert axis_label(omega) == r"frequency of excitation $\omega/2\pi$ (Hz)"
    assert value_text(omega[120]) == r"$\omega/2\pi$ = 9 Hz"
    assert plain_value(omega[120]) == "ω/2π = 9 Hz"
    assert plain_value(physical()["omega"][0]) == "ω = 18.85 rad/s"


@pytest.mark.parametrize(
    ("unit", "dimension"),
    [("J", "energy"), ("mJ", "energy"), ("kWh", "energy"), ("N m", "torque"), ("N mm", "torque")],
)
def test_a_force_times_a_length_is_written_for_torques_alone(unit: str, dimension: str):
    assert dimension_of(unit) == dimension


def test_all_units_of_a_dataset_are_converted_once():
    stored = physical(
        velocity_strobe=("nu", np.full(541, 0.01)), displacement_strobe=("nu", np.full(541, 0.002))
    )
    dataset = shown(stored)
    assert dataset["velocity_strobe"].values == pytest.approx(0.01 * P * 1e3)
    assert dataset["displacement_strobe"].values == pytest.approx(2.0)
    assert display_units({"": dataset})[""] is dataset
    for name, variable in stored.variables.items():
        np.testing.assert_allclose(in_si(dataset[name]), variable.values, rtol=1e-14)
    assert shown_unit(dataset, "m s-1") == ("mm/s", pytest.approx(1e3))
    assert stored["omega"].attrs["units"] == "rad s-1"


def test_a_table_keeps_si_where_nothing_is_written():
    stored = physical(displacement_strobe=("nu", np.full(541, 0.002)))
    units = [shown(stored, "frequency: Hz", prefixes=each)["l"].attrs["units"] for each in (True, False)]  # fmt: skip
    assert units == ["mm", "m"]


def test_derivatives_are_per_shown_unit_of_each_parameter():
    value = np.array([[2.0, 3.0]] * 541)
    stored = physical(displacement_mean_sensitivity=(("nu", "parameter"), value))
    stored = stored.assign_coords(parameter=["omega", "F"])
    stored["displacement_mean_sensitivity"].attrs["units"] = "m/(unit of parameter)"
    derivative = shown(stored)["displacement_mean_sensitivity"]
    # mm over Hz is 1000 m over 1/(2 pi) rad/s, mm over kN 1000 m over 1000 N
    assert derivative.values[0] == pytest.approx([2e3 * 2 * math.pi, 3e6])
    assert derivative.attrs["units"] == "mm/(unit of parameter)"


@pytest.mark.parametrize(
    ("units", "text"),
    [
        ("N s/mm", "N·s/mm"), ("m/s^2", "m/s²"), ("um", "µm"), ("uN s/um", "µN·s/µm"), ("us", "µs"),
        ("N m-1", "N/m"), ("Hz", "Hz"), ("u", "u"), ("1", ""),
    ],
)  # fmt: skip
def test_units_are_written_as_by_hand(units, text):
    assert unit_text(units) == text
