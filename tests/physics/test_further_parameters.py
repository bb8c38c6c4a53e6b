"""Parameters of effects beyond eqs. (5), (6): ranges, units, mirror image, and that none is silently ignored."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

import vibropipe as vp
from vibropipe.orbits.row import row_parameters
from vibropipe.physics.effects import NOT_COMPUTED, OF_HOUSING
from vibropipe.study import StudyError, study_of_text
from vibropipe.words.parameters import DEFAULTS, FURTHER, PARAMETERS

BASE = {"l": 0.5, "nu": 1.0, "f": -1.0, "h": 0.2, "R1": 1.0, "R2": 1.0}
ALL = {
    "k1": 200.0, "k2": 30.0, "h1": 2.0, "h2": 1.0, "load": 0.1, "friction": 0.08, "f2": 0.3, "phi2": 1.2,
}  # fmt: skip
PHYSICAL = {
    "m": "2 kg",
    "C": "8 N/mm",
    "H": "40 N s/m",
    "F": "120 N",
    "omega": "55 rad/s",
    "l": "8 mm",
}


def test_defaults_mean_that_the_effect_is_absent() -> None:
    e = vp.Exciter(**BASE)
    assert {name: getattr(e, name) for name in FURTHER} == {
        name: DEFAULTS[name] for name in FURTHER
    }
    assert not set(FURTHER) & set(e.stated())
    assert vp.Exciter(**BASE, **ALL).stated().items() >= ALL.items()


@pytest.mark.parametrize("name", ["k1", "k2", "h1", "h2", "friction"])
def test_what_must_not_be_negative(name: str) -> None:
    with pytest.raises(vp.ParameterError, match=f"^{name}: must be a finite number >= 0, got -0.1"):
        vp.Exciter(**BASE, **{**ALL, name: -0.1})


@pytest.mark.parametrize(("k", "h"), [("k1", "h1"), ("k2", "h2")])
def test_a_rigid_support_has_no_damping(k: str, h: str) -> None:
    with pytest.raises(vp.ParameterError, match=f"^{h}: must be 0 where {k} = 0: .* got "):
        vp.Exciter(**BASE, **{**ALL, k: 0.0})


def test_the_mirror_image_of_the_mirror_image_is_the_exciter() -> None:
    e = vp.Exciter(**BASE, **ALL, delta=0.1)
    mirrored = e.mirrored()
    assert (mirrored.k1, mirrored.h1, mirrored.load, mirrored.f2) == (30.0, 1.0, -0.1, -0.3)
    assert (mirrored.friction, mirrored.phi2) == (0.08, 1.2)
    assert mirrored.mirrored() == e


def test_a_kernel_reads_the_parameters_in_their_order() -> None:
    e = vp.Exciter(**BASE, **ALL)
    row = row_parameters(np.array([e.parameters()]), 0)
    assert row == e.parameters()
    assert row._fields == tuple(PARAMETERS)


def test_from_physical_knows_them_with_units() -> None:
    e = vp.Exciter.from_physical(
        **PHYSICAL, C1="1600 N/mm", C2="240 N/mm", H1="4e3 N s/m", H2=50, friction="12 N", F2="30 N",
        phi2="90 deg", load="-16 N",
    )  # fmt: skip
    root = math.sqrt(2 * 8000)
    expected = {
        "k1": 200, "k2": 30, "h1": 4000 / root, "h2": 50 / root, "friction": 12 / 8000, "f2": 30 / 8000,
        "phi2": math.pi / 2, "load": -16 / 8000,
    }  # fmt: skip
    assert {name: getattr(e, name) for name in expected} == pytest.approx(expected, rel=1e-15)


def test_gravity_pulls_back_along_the_slope() -> None:
    plain = vp.Exciter.from_physical(**PHYSICAL, load="3 N", slope="30 deg")
    assert plain.load * 8000 == pytest.approx(3 - 2 * 9.80665 / 2, rel=1e-14)
    moon = vp.Exciter.from_physical(**PHYSICAL, slope=-math.pi / 2, gravity="1.62 m/s^2")
    assert moon.load * 8000 == pytest.approx(2 * 1.62, rel=1e-14)
    robot = vp.Exciter.from_physical(**PHYSICAL, M="5 kg", P="1 N", slope="30 deg")
    assert robot.housing_load * 8000 == pytest.approx(1 - 5 * 9.80665 / 2, rel=1e-14)
    with pytest.raises(
        vp.ParameterError, match=r"^lode: is an unknown .*\(did you mean 'load'\?\)$"
    ):
        vp.Exciter.from_physical(**PHYSICAL, lode=1)


@pytest.mark.parametrize(
    ("key", "value", "text"),
    [
        ("slope", "0.5 mm/m", "mm/m is no unit of angle"),
        ("gravity", "9.81 m/s", "m/s is no unit of acceleration"),
        ("C1", "-1 N/m", "C1: must be a finite number >= 0, got '-1 N/m'"),
        ("friction", "3 mm", "mm is no unit of force"),
    ],
)
def test_wrong_units_of_further_parameters(key: str, value: str, text: str) -> None:
    with pytest.raises(vp.ParameterError) as caught:
        vp.Exciter.from_physical(**PHYSICAL, **{key: value})
    assert text in str(caught.value)


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ({"gravity": 10}, "gravity: must be left out unless slope stands beside it, got 10"),
        (
            {"H1": 50},
            "H1: must be 0 where C1 = 0: a rigid support has a restitution, no damping, got 50",
        ),
        ({"C1": 1e6, "H2": "50 N s/m"}, "H2: must be 0 where C2 = 0: .*, got '50 N s/m'"),
    ],
)
def test_what_needs_another_parameter_is_refused_in_the_words_of_the_call(given, text) -> None:
    with pytest.raises(vp.ParameterError, match=text):
        vp.Exciter.from_physical(**PHYSICAL, **given)


def test_damping_of_a_rigid_support_is_refused_in_the_words_of_the_study() -> None:
    for text in (
        STUDY.replace("omega: 55 rad/s}", "omega: 55 rad/s, H1: 30 N s/m}"),
        STUDY.replace("0.5 s}", "0.5 s, physical: {H1: 30 N s/m}}"),
    ):
        with pytest.raises(StudyError, match=r"H1: must be 0 where C1 = 0: .*, got '30 N s/m'"):
            study_of_text(text, "s")


STUDY = """
title: With units
physical: {m: 2 kg, C: 8 N/mm, H: 40 N s/m, l: 8 mm, F: 120 N, omega: 55 rad/s}
scenes:
  motion: {kind: motion, tau_end: 0.5 s}
"""


def test_a_study_with_units_knows_the_slope() -> None:
    text = STUDY.replace("0.5 s}", "0.5 s, physical: {gravity: 10 m/s^2}}")
    with pytest.raises(StudyError, match="gravity: must be left out unless slope stands beside it"):
        study_of_text(text, "s")
    swept = STUDY.replace("motion, tau_end: 0.5 s", "sweep, over: {load: [0 N, 5 N]}")
    for text in (
        swept.replace("5 N]}}", "5 N]}, physical: {slope: 30 deg}}"),
        swept.replace("}\nscenes", ", slope: 30 deg}\nscenes"),
    ):
        with pytest.raises(
            StudyError, match=r"over\.load: must be left out beside slope, whose share"
        ):
            study_of_text(text, "s")
    unbalance = swept.replace(
        "load: [0 N, 5 N]}}", "shaker: [1 mm]}, physical: {m_e: 1 g, e: 2 mm}}"
    )
    for text, keys in (
        (swept.replace("5 N]}}", "5 N]}, physical: {slope: 30 deg}}"), ["over.load"]),
        (unbalance, ["physical.e", "physical.m_e"]),
    ):
        with pytest.raises(StudyError) as error:
            study_of_text(text, "s")
        faults = str(error.value).splitlines()
        assert [fault.split(": ")[1] for fault in faults] == [
            f"scenes.motion.{key}" for key in keys
        ]
    level = swept.replace("}\nscenes", ", slope: 30 deg}\nscenes")
    level = level.replace("5 N]}}", "5 N]}, physical: {slope: 0 deg}}")
    assert study_of_text(level, "s").scenes["motion"].row_count == 2


def test_gravity_pulls_at_what_stands_in_a_study_or_in_its_scene() -> None:
    base = STUDY.replace("}\nscenes", ", M: 5 kg, load: 3 N, P: 1 N}\nscenes")

    def loads(text: str) -> list[float]:
        exciter = study_of_text(text, "s").scene("motion").resolved_exciter()
        return [exciter[name] * 8000 for name in ("load", "housing_load")]

    g = 9.80665 / 2
    for text in (
        base.replace("0.5 s}", "0.5 s, physical: {slope: 30 deg}}"),
        base.replace("P: 1 N", "P: 1 N, slope: 30 deg"),
        base.replace("P: 1 N", "P: 0 N, slope: 30 deg").replace(
            "0.5 s}", "0.5 s, physical: {P: 1 N}}"
        ),
    ):
        assert loads(text) == pytest.approx([3 - 2 * g, 1 - 5 * g], rel=1e-14)
    level = base.replace("P: 1 N", "P: 1 N, slope: 30 deg")
    assert loads(level.replace("0.5 s}", "0.5 s, physical: {slope: 0}}")) == pytest.approx([3, 1])
    heavier = level.replace("motion, tau_end: 0.5 s", "sweep, over: {M: [1 kg, 5 kg]}")
    with pytest.raises(StudyError, match="M: must be left out beside slope: gravity pulls"):
        study_of_text(heavier, "s")
    for keys in (
        "sweep, over: {P: [1 N, 5 N]}",
        "design, vary: {P: [1 N, 5 N]}, target: {displacement_mean: 0 mm}",
    ):
        with pytest.raises(StudyError, match="P: must be left out beside slope, whose share"):
            study_of_text(level.replace("motion, tau_end: 0.5 s", keys), "s")


def _faces(name: str, value: float) -> dict[str, Callable[[], object]]:
    """Return calls of the faces with a parameter that is not computed."""
    stiff = {f"k{name[1]}": 1.0} if name in ("h1", "h2") else {}
    if name in OF_HOUSING and name != "mass_ratio":
        stiff = {"mass_ratio": 1.0}
    e = vp.Exciter(**BASE, **{**stiff, name: value})
    base = vp.Exciter(**BASE, **stiff)
    grid = np.linspace(-0.3, 0.3, 3)
    return {
        "simulate": lambda: vp.simulate(e, 1.0),
        "newmark": lambda: vp.simulate(e, 1.0, method="newmark", steps_per_period=100),
        "steady_state": lambda: vp.steady_state(e),
        "sweep": lambda: vp.sweep(base, {name: [0.0, value]}),
        "boundary": lambda: vp.boundary(e, "fold", ("nu", "f"), ((1, 2), (0.1, 0.2))),
        "basins": lambda: vp.basins(e, grid, grid),
        "one_sided_orbit": lambda: vp.one_sided_orbit(e, 1, 1),
        "amplitude_frequency": lambda: vp.amplitude_frequency(e, 0.1),
    }


@pytest.mark.parametrize("name", NOT_COMPUTED)
def test_an_effect_that_is_not_computed_is_refused_by_every_face(name: str) -> None:
    computed = ["simulate", "newmark", "steady_state", "sweep", "boundary", "basins"]
    for face, call in _faces(name, 0.5).items():
        if face in computed:
            continue
        with pytest.raises(vp.ParameterError, match=r"must be 0: .* not computed"):
            call()


def test_greek_letters_of_the_second_phase() -> None:
    text = "title: T\nexciter: {l: 1, φ₂: 0}\nscenes: {s: {kind: motion}}"
    assert study_of_text(text, "s").scene("s").given_exciter()["phi2"] == 0.0
