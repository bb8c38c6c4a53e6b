"""Tables of quantities, parameters, outputs, effects and methods: complete, each name once, refused names."""

import math
import re
import tomllib
from dataclasses import MISSING, fields
from pathlib import Path
from typing import get_args

import numpy as np
import pytest
import xarray as xr
from matplotlib.mathtext import MathTextParser

import vibropipe as vp
from vibropipe.physics.effects import BY_PARAMETER, Effects
from vibropipe.physics.exciter import Parameters
from vibropipe.scenes.keys.parts import ExciterKeys, Solver
from vibropipe.words import vocabulary
from vibropipe.words.methods import METHODS
from vibropipe.words.outputs import (
    MOTION_DEFAULT,
    OF_MOTION,
    OF_ORBIT,
    OF_STEADY_STATE,
    OUTPUTS,
    SWEEP_DEFAULT,
)
from vibropipe.words.parameters import CONTINUOUS, DEFAULTS, EFFECT_NAMES, PARAMETERS, ParameterName
from vibropipe.words.quantities import REGIMES
from vibropipe.words.records import Range
from vibropipe.words.status import Status
from vibropipe.words.units import DIMENSIONS
from vibropipe.words.vocabulary import (
    PHYSICAL_NAMES,
    VOCABULARY,
    attributes,
    describe,
    label,
    quantity,
)

QUANTITIES = Path(vocabulary.__file__).with_name("quantities.toml")
REQUIRED = """
nu f h l delta R1 R2 tau displacement velocity force impact_tau impact_support impact_velocity
impact_velocity_after rest_start rest_end rest_support grazing_tau grazing_support
displacement_end velocity_end status displacement_exact velocity_exact orbit_impact_phase
orbit_impact_support orbit_impact_velocity regime period_multiple support impacts_per_orbit
impacts_per_period rests_per_orbit base_frequency residual periods_to_settle displacement_strobe velocity_strobe
window_periods chaos harmonic displacement_mean velocity_mean displacement_amplitude displacement_phase
velocity_amplitude velocity_phase impact_phase impact_period row_size impact_velocity_max
floquet_multiplier stable phase energy_input energy_damping energy_residual energy_impact
delta_over_l tau_bar velocity_over_l omega_bar simulated_tau_bar simulated_velocity_over_l
amplitude eigenfrequency row
subharmonic subharmonic_displacement_amplitude subharmonic_displacement_phase visit
poincare_displacement poincare_velocity lyapunov_exponent
"""


@pytest.mark.parametrize("name", REQUIRED.split())
def test_every_name_is_in_the_table(name):
    assert name in VOCABULARY


def test_parameters_are_scalars_of_the_table():
    assert all(VOCABULARY[name].dims == () for name in PARAMETERS)


@pytest.mark.parametrize("name", VOCABULARY)
def test_entries_are_well_formed(name):
    entry = VOCABULARY[name]
    si = {dimension.units for dimension in DIMENSIONS.values()}
    assert entry.units in {"1", "rad", "ns", "ms", "byte", "MB", "MB s-1"} | si
    assert entry.long_name
    assert entry.long_name == entry.long_name.strip()
    assert all(dim in VOCABULARY for dim in entry.dims)
    assert entry.symbol.count("$") in (0, 2)


def test_each_quantity_stands_once_with_a_known_dimension():
    table = tomllib.loads(QUANTITIES.read_text(encoding="utf-8"))
    of_subjects = [name for entries in table.values() for name in entries]
    assert len({*of_subjects}) == len(of_subjects)
    entries = [entry for subject in table.values() for entry in subject.values()]
    assert {entry["dimension"] for entry in entries if "dimension" in entry} <= {*DIMENSIONS}
    assert {*PHYSICAL_NAMES} <= {*VOCABULARY}


def test_every_symbol_is_mathtext():
    parser = MathTextParser("path")
    for entry in VOCABULARY.values():
        parser.parse(entry.symbol)
    with pytest.raises(ValueError, match="Unknown symbol"):
        parser.parse(r"$\nosuchsymbol$")


def test_labels_tell_units_only_where_there_are_any():
    assert label("displacement") == r"displacement $x$"
    assert label("nu") == r"frequency of excitation $\nu$"
    assert label("velocity_phase").endswith("(rad)")


def test_labels_are_unambiguous_among_harmonics():
    names = [f"{of}_{part}" for of in ("displacement", "velocity") for part in ("mean", "phase")]
    assert len({label(name) for name in names}) == len(names)


def test_flags_of_regimes_are_the_contract():
    assert list(REGIMES.values()) == list(range(8))
    assert " ".join(REGIMES) == (
        "no_impact one_sided_1 one_sided_2 two_sided with_rest aperiodic unbounded unresolved"
    )
    attrs = attributes("regime")
    assert attrs["flag_values"].dtype == np.int8
    assert attrs["flag_meanings"].split()[3] == "two_sided"


@pytest.mark.parametrize(
    ("name", "words"),
    [
        (
            "status",
            "ok max_impacts max_periods root_bound not_finite short_flights log_full inaccurate "
            "support_reached max_steps",
        ),
        ("outcome", "ok missed_impact fell_through did_not_end not_tried not_installed"),
        ("passed", "not_passed passed not_asked"),
        ("stable", "unstable stable"),
    ],
)
def test_flags_of_files_are_the_contract(name, words):
    attrs = attributes(name)
    assert attrs["flag_meanings"] == words
    assert attrs["flag_values"].tolist() == list(range(len(words.split())))


def test_flags_of_status_are_its_members():
    assert quantity("status").flags == {member.name.lower(): member.value for member in Status}
    attrs = attributes("status")
    assert attrs["flag_meanings"].split()[0] == "ok"
    assert len(attrs["flag_values"]) == len(Status)


def test_flag_meanings_are_single_words():
    for name in VOCABULARY:
        for word in quantity(name).flags or {}:
            assert re.fullmatch(r"[a-z][a-z0-9_]*", word)


def test_an_error_estimate_has_the_units_of_its_quantity():
    entry = quantity("displacement_phase_error")
    assert entry.units == "rad"
    assert entry.long_name == "error estimate of harmonic phase of displacement"


@pytest.mark.parametrize("name", ["speed", "_error", "speed_error", ""])
def test_names_outside_the_table_are_refused(name):
    with pytest.raises(KeyError, match="not in the vocabulary"):
        quantity(name)


def test_a_sensitivity_in_si_says_that_its_units_depend_on_the_parameter():
    words = vocabulary.physical_attributes("displacement_mean_sensitivity")
    assert words["units"] == "m/(unit of parameter)"
    assert vocabulary.physical_attributes("displacement_mean")["units"] == "m"
    assert vocabulary.attributes("displacement_mean_sensitivity")["units"] == "1"


def test_describe_sets_attributes_and_keeps_those_of_others():
    dataset = xr.Dataset(
        {
            "regime": ("nu", np.zeros(2, np.int8)),
            "row_size": ("nu", [1, 2], {"note": "kept"}),
            "impact_support": ("impact", np.array([1, 2, 1], np.int16)),
            "stable": ("nu", [True, False]),
        },
        coords={"nu": [0.5, 1.0]},
    )
    assert describe(dataset) is dataset
    assert dataset["nu"].attrs["long_name"] == "frequency of excitation"
    assert dataset["row_size"].attrs["sample_dimension"] == "impact"
    assert dataset["row_size"].attrs["note"] == "kept"
    assert dataset["impact_support"].attrs["flag_values"].dtype == np.int16
    assert dataset["stable"].attrs["flag_values"].tolist() == [0, 1]
    assert dataset["stable"].attrs["flag_values"].dtype == np.int8


def test_describe_refuses_a_name_outside_the_table():
    with pytest.raises(KeyError, match="'speed'"):
        describe(xr.Dataset({"speed": 1.0}))


def test_the_steady_state_of_a_motion_has_the_words_of_its_quantities():
    entry, base = quantity("orbit_impact_velocity"), quantity("impact_velocity")
    assert (entry.dims, entry.dimension) == (("orbit_impact",), base.dimension)
    assert entry.long_name == "velocity before impact in the orbit"
    assert entry.output is None


TINY = math.ulp(0.0)


@pytest.mark.parametrize(
    ("within", "text", "inside", "outside"),
    [
        (Range(), "a finite number", (-1e308, 0.0, 1e308), ()),
        (Range(0), "a finite number >= 0", (0.0, -0.0, 1e308), (-TINY,)),
        (Range(0, above=True), "a finite number > 0", (TINY, 1e308), (0.0, -1.0)),
        (Range(0, 1), "a number from 0 to 1", (0.0, 0.5, 1.0), (-TINY, math.nextafter(1.0, 2.0))),
        (Range(-0.5, 2, True), "a number above -0.5 up to 2", (-0.25, 2.0), (-0.5, 2.5)),
        (Range(1, 1e8, whole=True), "a whole number from 1 to 1e8", (1.0, 1e8), (0.0, 1.5)),
    ],
)
def test_text_of_a_range_and_its_numbers(within, text, inside, outside):
    assert within.text == text
    assert all(within.contains(value) for value in inside)
    assert not any(within.contains(value) for value in (*outside, math.nan, math.inf, -math.inf))


def test_parameters_stand_in_one_order():
    assert (*PARAMETERS,) == Parameters._fields
    assert get_args(ParameterName) == CONTINUOUS
    assert set(PARAMETERS) == {field.name for field in fields(vp.Exciter)}
    assert set(PARAMETERS) == set(ExciterKeys.model_fields)


def test_defaults_are_those_of_an_exciter():
    needed = [field.name for field in fields(vp.Exciter) if field.default is MISSING]
    assert [name for name in PARAMETERS if name not in DEFAULTS] == needed == ["l"]
    assert vars(vp.Exciter(l=0.5)) == {**DEFAULTS, "l": 0.5}
    for name, value in DEFAULTS.items():
        assert PARAMETERS[name].range.contains(value)
        description = ExciterKeys.model_fields[name].description or ""
        words = PARAMETERS[name].range.words
        assert f"({words[0] if words else f'{value:g}'})." in description


def test_effects_are_the_fields_that_kernels_read():
    marched = [name for name in EFFECT_NAMES if name not in BY_PARAMETER]
    assert Effects._fields == (*marched, "watched")


def test_a_study_takes_the_methods_of_a_motion():
    assert get_args(Solver.model_fields["method"].annotation) == METHODS == ("exact", "newmark")


def test_outputs_of_each_face_are_among_all():
    assert (
        *("harmonics", "impacts", "motion", "stability", "energy", "power"),
        *("frame", "subharmonics", "poincare", "lyapunov", "sensitivity"),
    ) == OUTPUTS
    for some in (SWEEP_DEFAULT, MOTION_DEFAULT, OF_MOTION, OF_STEADY_STATE, OF_ORBIT):
        assert set(some) <= set(OUTPUTS)
    assert set(OUTPUTS) - {"impacts", "motion"} == OF_ORBIT
