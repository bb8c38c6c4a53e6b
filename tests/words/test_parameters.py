"""Parameters, outputs, effects and methods: each name once, and the code that spells them out agrees."""

import math
from dataclasses import MISSING, fields
from typing import get_args

import pytest

import vibropipe as vp
from vibropipe.physics.effects import BY_PARAMETER, Effects
from vibropipe.physics.exciter import Parameters
from vibropipe.scenes.keys.parts import ExciterKeys, Solver
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
from vibropipe.words.records import Range

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
