"""Text with units as numbers in SI, and amounts with their nouns."""

import contextlib
import math

import numpy as np
import pytest
import xarray as xr
from command_line import printed
from hypothesis import given
from hypothesis import strategies as st

from vibropipe.jobs.plan import plan_scene
from vibropipe.jobs.terminal_tables import plan_text
from vibropipe.jobs.verify import Verdict
from vibropipe.scenes.costs import PlanError
from vibropipe.scenes.hard_cases.report import on_cases
from vibropipe.scenes.sweep.captions import row_kinds_text
from vibropipe.scenes.sweep.cut import row_range
from vibropipe.store.atomic import StoreError
from vibropipe.store.shards import _check_cover
from vibropipe.study import parse_study
from vibropipe.words.quantities import REGIMES
from vibropipe.words.units import DIMENSIONS, UnitError, plain_units, tidy, to_si
from vibropipe.words.wording import aligned, count, part_text, series, share

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
    printed(code)


def study_with(**scenes):
    return parse_study({"title": "T", "exciter": {"l": 0.5}, "scenes": scenes})


def test_counts_and_series():
    assert [count(1, "row"), count(3, "row"), count(0, "row")] == ["1 row", "3 rows", "0 rows"]
    assert count(2, "analysis", "analyses") == "2 analyses"
    shares = [
        share(1, 1, "check"),
        share(2, 3, "check"),
        share(103, 103, "check"),
        share(0, 1, "check"),
        share(0, 0, "check"),
    ]
    assert shares == [
        "the only check is",
        "2 of 3 checks are",
        "all 103 checks are",
        "0 of 1 check is",
        "0 of 0 checks are",
    ]
    assert [series([]), series("a"), series("abc")] == ["", "a", "a, b and c"]


def test_a_plan_of_one_scene_and_one_row():
    one = plan_text(study_with(only={"kind": "motion"}))
    assert "\n1 scene, 1 row, roughly" in one
    two = plan_text(study_with(a={"kind": "motion"}, b={"kind": "sweep", "over": {"nu": [1, 2]}}))
    assert "\n2 scenes, 3 rows, roughly" in two


def test_sizes_of_scenes():
    study = study_with(
        case={"kind": "hard_cases", "cases": ["ideal_free"]},
        race={"kind": "accuracy", "motions": {"m": {}}},
    )
    assert [plan_scene(scene).size for scene in study.scenes.values()] == ["1 case", "1 motion"]


def test_a_cut_into_one_shard_too_many():
    scene = study_with(s={"kind": "sweep", "over": {"nu": [1, 2]}}).scenes["s"]
    with pytest.raises(PlanError, match=r"^scenes\.s: must be cut into 1 to 2 shards, got 3$"):
        row_range(scene, 1, 3)


def test_verdicts():
    assert str(Verdict("s", faults=["x"])).startswith("s: 1 fault\n")
    assert str(Verdict("s", faults=["x", "y"])).startswith("s: 2 faults\n")
    parts = [part_text(1, 1, "row"), part_text(3, 3, "row"), part_text(1, 12000, "row")]
    assert parts == ["the only row", "all 3 rows", "1 of 12,000 rows"]


def test_rows_that_no_shard_holds():
    class Held:
        start, stop = 0, 1

    with pytest.raises(StoreError, match="rows 1 to 2 of 3 are not in the only shard"):
        _check_cover([Held], 3)


def test_one_row_of_a_sweep_has_no_orbit():
    codes = [REGIMES["two_sided"], REGIMES["aperiodic"]]
    one = xr.Dataset({"regime": ("nu", np.array(codes, np.int8))})
    assert row_kinds_text(one, are_drawn=False).startswith(
        "Of 2 rows, 1 has no periodic orbit that was found;"
    )


def test_one_case_and_one_bound():
    passed = xr.Dataset({"passed": (("case", "solver"), np.array([[1]], np.int8))})
    assert on_cases(passed).lead == "1 case: every bound is kept."
    assert on_cases(passed * 0).lead == "1 case: 1 bound exceeded."


def test_columns_are_as_wide_as_their_widest_cell():
    assert aligned([("a", "bb", "c"), ("long", "b", "")]) == ["a     bb  c", "long  b"]


def test_an_accent_takes_no_column():
    dotted = "x\u0307"
    assert aligned([(dotted, "1"), ("xy", "2")]) == [f"{dotted}   1", "xy  2"]
