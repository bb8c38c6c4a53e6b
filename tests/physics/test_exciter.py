"""The exciter: checks of its parameters, and its conversion by eqs. (2)-(4)."""

from __future__ import annotations

import copy
import inspect
import math
import pickle
import re
import warnings
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

import vibropipe as vp
from vibropipe.words.parameters import PARAMETERS

GOOD = {"l": 0.5, "nu": 1.0, "f": -1.0, "h": 0.2, "delta": 0.01, "R1": 0.6, "R2": 0.8}


@pytest.mark.parametrize(
    ("name", "value"),
    [
        *((name, value) for name in GOOD for value in (math.nan, math.inf, -math.inf)),
        ("l", 0.0), ("l", -0.5), ("nu", 0.0), ("nu", -1.0), ("h", -1e-9), ("R1", -0.1), ("R1", 1.0000001),
        ("R2", 2.0), ("R2", -1e-300), ("h", "0.2"), ("f", "strong"), ("f", None), ("nu", True),
    ],
)  # fmt: skip
def test_a_bad_value_is_named_with_what_is_allowed(name: str, value: object) -> None:
    with pytest.raises(vp.ParameterError) as error:
        vp.Exciter(**{**GOOD, name: value})
    message = str(error.value)
    assert message == f"{name}: must be {PARAMETERS[name].range.text}, got {value!r}"
    assert isinstance(error.value, ValueError)


def test_defaults_mean_that_an_effect_is_absent() -> None:
    e = vp.Exciter(l=2.0)
    assert (e.nu, e.f, e.h, e.delta, e.R1, e.R2) == (1.0, 0.0, 0.0, 0.0, 1.0, 1.0)
    assert (e.upper, e.lower, e.period) == (2.0, -2.0, 2 * math.pi)


@pytest.mark.parametrize("name", ["m", "C", "l"])
def test_what_is_missing_is_told_with_what_it_takes(name: str) -> None:
    given = {key: value for key, value in PHYSICAL.items() if key != name}
    for left_out in (given, {**given, name: None}):
        with pytest.raises(
            vp.ParameterError, match=f"^{name}: is required \\(a number in .*such as"
        ):
            vp.Exciter.from_physical(**left_out)
    with pytest.raises(vp.ParameterError, match=r"^l: is required \(a finite number > 0\)$"):
        vp.Exciter(nu=1.0)  # type: ignore[call-arg]


@pytest.mark.parametrize(
    ("name", "dimensionless", "physical"),
    [
        ("zeta", "h = 2 zeta", "H = 2 zeta sqrt(m C)"),
        ("zeta2", "h2 = 2 zeta sqrt(k2)", "H2 = 2 zeta sqrt(m C2)"),
    ],
)
def test_damping_ratios_are_told_as_damping(name: str, dimensionless: str, physical: str) -> None:
    told = f"{name}: is an unknown parameter; must be one of .* \\(a damping ratio is written as "
    with pytest.raises(vp.ParameterError, match=f"^{told}{re.escape(dimensionless)}\\)$"):
        vp.Exciter(l=1.0, **{name: 0.1})
    with pytest.raises(vp.ParameterError, match=f"^{told}{re.escape(physical)}\\)$"):
        vp.Exciter.from_physical(m=1, C=1, l=1, **{name: 0.1})


@pytest.mark.parametrize(
    ("name", "meant"), [("delta1", "delta"), ("omega", "nu"), ("Delta", "delta"), ("r1", "R1")]
)
def test_unknown_keywords_are_told_with_what_they_may_mean(name: str, meant: str) -> None:
    told = (
        rf"^{name}: is an unknown parameter; must be one of nu, f, .* \(did you mean '{meant}'\?\)$"
    )
    e = vp.Exciter(l=1.0)
    with pytest.raises(vp.ParameterError, match=told):
        vp.Exciter(l=1.0, **{name: 0.1})
    with pytest.raises(vp.ParameterError, match=told):
        replace(e, **{name: 0.1})
    assert list(inspect.signature(vp.Exciter).parameters)[:2] == ["l", "nu"]
    assert pickle.loads(pickle.dumps(e)) == e == copy.copy(e)


def test_supports_on_one_number_are_refused() -> None:
    told = r"l: must be at least 1e-15 \|delta\| so that .*, got l = 1e-09, delta = 1000000000\.0$"
    with pytest.raises(vp.ParameterError, match=told) as error:
        vp.Exciter(l=1e-9, delta=1e9)
    assert (error.value.name, error.value.value) == ("l", 1e-9)


def test_an_error_has_its_parts_as_attributes_and_goes_to_other_processes() -> None:
    plain = vp.ParameterError("nu", -1.0, "a finite number > 0")
    assert (plain.name, plain.value, plain.allowed) == ("nu", -1.0, "a finite number > 0")
    assert str(plain) == "nu: must be a finite number > 0, got -1.0"
    full = vp.ParameterError("x", 1, must="must be left out", got="")
    assert (full.must, full.allowed, str(full)) == ("must be left out",) * 2 + (
        "x: must be left out",
    )
    for error in (plain, full):
        copy = pickle.loads(pickle.dumps(error))
        assert (str(copy), copy.value, copy.must) == (str(error), error.value, error.must)


@pytest.mark.filterwarnings("ignore:l. the nearer support")
@given(
    m=st.floats(1e-3, 1e3), C=st.floats(1e-3, 1e3), H=st.floats(0, 1e2), F=st.floats(-1e3, 1e3),
    omega=st.floats(1e-2, 1e2),
)  # fmt: skip
def test_from_physical_is_equations_2_to_4(
    m: float, C: float, H: float, F: float, omega: float
) -> None:
    e = vp.Exciter.from_physical(m=m, C=C, H=H, F=F, omega=omega, l=0.3, delta=0.1, R1=0.5, R2=0.9)
    # The same motion in physical time: m x'' + H x' + C x = F sin(omega t), with tau = p t.
    eigenfrequency = math.sqrt(C / m)
    assert e.nu * eigenfrequency == pytest.approx(omega, rel=1e-14)
    assert e.h * eigenfrequency * m == pytest.approx(H, rel=1e-13, abs=1e-300)
    assert e.f * C == pytest.approx(F, rel=1e-14)
    assert (e.l, e.delta, e.R1, e.R2) == (0.3, 0.1, 0.5, 0.9)


@pytest.mark.parametrize(
    ("name", "value"), [("m", 0.0), ("C", -1.0), ("H", math.nan), ("omega", math.inf)]
)
def test_from_physical_names_a_bad_value(name: str, value: float) -> None:
    good = {"m": 1.0, "C": 1.0, "H": 0.0, "F": 0.0, "omega": 1.0, "l": 1.0}
    with pytest.raises(vp.ParameterError, match=f"^{name}: must be .*, got {value!r}$"):
        vp.Exciter.from_physical(**{**good, name: value})


PHYSICAL = {"m": 2, "C": 8000, "H": 40, "F": 120, "omega": 55, "l": 0.008}


def test_from_physical_takes_text_with_units() -> None:
    texts = {
        "m": "2000 g", "C": "8 N/mm", "H": "40 N s/m", "F": "0.12 kN", "omega": "55 rad/s", "l": "8 mm",
    }  # fmt: skip
    assert vp.Exciter.from_physical(**texts) == vp.Exciter.from_physical(**PHYSICAL)
    hertz = vp.Exciter.from_physical(**{**PHYSICAL, "omega": "9 Hz"})
    assert hertz.nu == pytest.approx(2 * math.pi * 9 / math.sqrt(4000), rel=1e-15)


@pytest.mark.parametrize(
    ("name", "value", "text"),
    [
        ("l", "8 N", "l: must be a number in m or a length with its unit, such as 8 mm, got '8 N' (N is no unit of"),
        ("l", "8 mmm", "got '8 mmm' ('mmm' is no unit that is known)"),
        ("l", "8", "got '8' (it has no unit)"),
        ("l", "-8 mm", "l: must be a finite number > 0, got '-8 mm'"),
        ("omega", "9 1/s", "got '9 1/s' (1/s may count radians or cycles: write rad/s, Hz or rpm)"),
        ("H", "-1 N s/m", "H: must be a finite number >= 0, got '-1 N s/m'"),
    ],
)  # fmt: skip
def test_wrong_units_are_refused_in_words(name: str, value: str, text: str) -> None:
    with pytest.raises(vp.ParameterError) as caught:
        vp.Exciter.from_physical(**{**PHYSICAL, name: value})
    assert caught.value.name == name
    assert text in str(caught.value)


@pytest.mark.parametrize(
    ("other", "text"),
    [
        ({"l": "8 m"}, "l: the nearer support is 8 m away, but the mass swings by"),
        (
            {"C": "8 N/m"},
            "F: the force holds the spring 15 m from its equilibrium, 1.88e+03 times l: ",
        ),
        (
            {"F": "120 kN"},
            "F: the force holds the spring 15 m from its equilibrium, 1.88e+03 times l: ",
        ),
        ({"F2": "120 kN"}, "F2: the second harmonic of the force holds the spring 15 m from its"),
        ({"load": "-120 kN"}, "load: the constant force holds the spring 15 m from its"),
        ({"friction": "120 kN"}, "friction: dry friction holds the spring 15 m from its"),
        (
            {"delta": "-1 m"},
            "delta: the equilibrium lies 1 m from the middle between the supports, 125 times",
        ),
    ],
)
def test_lengths_that_cannot_be_meant_warn(other: dict[str, str], text: str) -> None:
    with pytest.warns(UserWarning, match=f"^{re.escape(text)}.*check the units of"):
        vp.Exciter.from_physical(**{**PHYSICAL, **other})


def test_millimetres_beside_newtons_per_metre_warn() -> None:
    with pytest.warns(UserWarning, match=r"^l: .* 8 m away, .* write l='8 mm'") as caught:
        vp.Exciter.from_physical(**{**PHYSICAL, "l": 8})
    assert caught[0].filename == __file__


@pytest.mark.parametrize("other", [{}, {"l": 8, "F": 0}, {"l": 0.9}])
def test_a_support_within_reach_does_not_warn(other: dict[str, object]) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        vp.Exciter.from_physical(**{**PHYSICAL, **other})


def test_the_mirror_of_the_mirror_is_the_exciter() -> None:
    e = vp.Exciter(**GOOD)
    m = e.mirrored()
    assert (m.f, m.delta, m.R1, m.R2) == (1.0, -0.01, 0.8, 0.6)
    assert (m.upper, m.lower) == (-e.lower, -e.upper)
    assert m.mirrored() == e


@pytest.mark.parametrize(
    ("exciter", "text"),
    [
        (vp.Exciter(l=0.5), "Exciter(l=0.5)"),
        (vp.Exciter(l=0.5, nu=1.0, f=1.0).mirrored(), "Exciter(l=0.5, nu=1.0, f=-1.0)"),
        (
            vp.Exciter(l=0.5, nu=2.0, k1=3.0, R1=0.6, contact_1="no_pull").mirrored(),
            "Exciter(l=0.5, nu=2.0, R2=0.6, k2=3.0, contact_2='no_pull')",
        ),
        (vp.Exciter(l=0.5, nu=2.0, k1=3.0, h1=0.0), "Exciter(l=0.5, nu=2.0, k1=3.0, h1=0.0)"),
        (vp.Exciter(l=0.5, nu=2.0, f=1.0, shaker=0.1), "Exciter(l=0.5, nu=2.0, f=1.0, shaker=0.1)"),
    ],
)
def test_an_exciter_is_shown_as_a_call_that_makes_it(exciter: vp.Exciter, text: str) -> None:
    assert repr(exciter) == text
    again = eval(text, {"Exciter": vp.Exciter})
    assert vars(again) == vars(exciter)
    assert [again.states(name) for name in ("nu", "h1", "h2")] == [
        exciter.states(name) for name in ("nu", "h1", "h2")
    ]
    assert not any(math.copysign(1.0, value) < 0 for value in vars(again).values() if value == 0)


@pytest.mark.parametrize("x0", [0.52, -0.491, math.nan, "0"])
def test_a_start_outside_the_supports_is_named(x0: object) -> None:
    with pytest.raises(vp.ParameterError, match=r"^x0: must be .*between the supports.*, got "):
        vp.Exciter(**GOOD).check_start(x0, 0.0)  # type: ignore[arg-type]
