"""Text with units as numbers in SI, and what is refused."""

import contextlib
import math
import subprocess
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vibropipe.words.units import DIMENSIONS, UnitError, plain_units, tidy, to_si

LB, INCH = 0.45359237, 0.0254


@pytest.mark.parametrize(
    ("text", "dimension", "expected"),
    [
        ("8 mm", "length", 0.008),
        ("8mm", "length", 0.008),
        ("-0.5 µm", "length", -5e-7),
        ("3 in", "length", 0.0762),
        ("2 kg", "mass", 2.0),
        ("8 N/mm", "stiffness", 8000.0),
        ("40 N s/m", "damping", 40.0),
        ("40 N·s/m", "damping", 40.0),
        ("40 kg/s", "damping", 40.0),
        ("0.12 kN", "force", 120.0),
        ("10 lbf", "force", 10 * LB * 9.80665),
        ("1 lbf/in", "stiffness", LB * 9.80665 / INCH),
        ("0.3 m/s", "velocity", 0.3),
        ("2 ms", "time", 0.002),
        ("5 mJ", "energy", 0.005),
        ("50 N mm", "torque", 0.05),
        ("55 rad/s", "frequency", 55.0),
        ("9 Hz", "frequency", 18 * math.pi),
        ("0.009 kHz", "frequency", 18 * math.pi),
        ("9 cycle/s", "frequency", 18 * math.pi),
        ("60 rpm", "frequency", 2 * math.pi),
        ("180 deg/s", "frequency", math.pi),
    ],
)
def test_text_is_a_number_in_si(text: str, dimension: str, expected: float) -> None:
    assert to_si(text, dimension) == pytest.approx(expected, rel=1e-15)


def test_every_example_is_of_its_dimension() -> None:
    for name, dimension in DIMENSIONS.items():
        assert to_si(dimension.example, name) > 0
        assert to_si(f"2 {dimension.plain}", name) == 2.0


@pytest.mark.parametrize(
    ("value", "dimension", "hint"),
    [
        ("8 mmm", "length", "'mmm' is no unit that is known"),
        ("8 N", "length", "N is no unit of length"),
        ("8 J", "force", "J is no unit of force"),
        ("8", "length", "it has no unit"),
        (8, "length", "it has no unit"),
        ("0,5 mm", "length", "write 0.5 mm, with a point"),
        ("9 1/s", "frequency", "1/s may count radians or cycles: write rad/s, Hz or rpm"),
        ("9 rad", "frequency", "rad is no unit of frequency"),
        ("1 m**999999999", "length", "'m**999999999' is no unit that is known"),
        ("8 (mm", "length", "'(mm' is no unit that is known"),
        ("mm", "length", ""),
        ("", "length", ""),
        ("nan mm", "length", ""),
        ("1e400 mm", "length", ""),
        (None, "length", ""),
        (True, "length", ""),
        (math.nan, "length", "it has no unit"),
        ([8], "length", ""),
    ],
)
def test_what_is_no_quantity_is_refused_in_words(value: object, dimension: str, hint: str) -> None:
    with pytest.raises(UnitError) as caught:
        to_si(value, dimension)
    assert caught.value.hint == hint
    assert caught.value.allowed.startswith(f"{DIMENSIONS[dimension].noun} with its unit, such as ")


@given(unit=st.text(st.sampled_from("mNskgradHz/*^()·² -+12e°µ.%\"'[]{}_\\#$!\tabc"), max_size=12))
def test_any_text_is_a_number_or_a_unit_error(unit: str) -> None:
    with contextlib.suppress(UnitError):
        assert math.isfinite(to_si(f"1 {unit}", "length"))


def test_numbers_are_in_si_where_they_are_taken_and_zero_needs_no_unit() -> None:
    assert to_si(8, "length", numbers=True) == 8.0
    assert to_si(0, "length") == to_si(0.0, "force") == 0.0


def test_quantities_of_any_registry_are_taken() -> None:
    pint = pytest.importorskip("pint")
    registry = pint.UnitRegistry()
    assert to_si(registry.Quantity(8, "mm"), "length") == 0.008
    assert to_si(registry.Quantity(9, "Hz"), "frequency") == pytest.approx(18 * math.pi, rel=1e-15)
    with pytest.raises(UnitError):
        to_si(registry.Quantity(8, "N"), "length")


@given(number=st.integers(1, 999_999).map(lambda n: n / 1000), p=st.floats(1e-3, 1e6))
def test_a_short_number_comes_back_from_a_conversion(number: float, p: float) -> None:
    assert tidy(number / p * p) == number


@given(number=st.floats(allow_nan=False, allow_infinity=False))
def test_tidy_moves_a_number_by_rounding_only(number: float) -> None:
    assert abs(tidy(number) - number) <= 4 * math.ulp(number)


def test_units_are_written_by_hand_and_by_cf() -> None:
    assert [plain_units(units) for units in ("m", "m s-1", "N s m-1", "rad s-1", "s-1", "1")] == [
        "m", "m/s", "N s/m", "rad/s", "1/s", "1",
    ]  # fmt: skip


def test_numbers_do_not_load_pint() -> None:
    code = (
        "import sys, vibropipe as vp, vibropipe.words.vocabulary\n"
        "vp.Exciter.from_physical(m=2, C=8000, H=40, F=120, omega=55, l=0.008)\n"
        "assert 'pint' not in sys.modules\n"
        "vp.Exciter.from_physical(m=2, C=8000, H=40, F=120, omega=55, l='8 mm')\n"
        "assert 'pint' in sys.modules\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
