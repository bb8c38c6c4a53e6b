"""The first touch of the motion without impacts, between rows of a sweep in any units."""

import math
from dataclasses import replace

import numpy as np
import pytest

import vibropipe as vp
from vibropipe.figures.units import display_units
from vibropipe.scenes.sweep.answers import sweep_answers
from vibropipe.scenes.sweep.neighbours import first_touch

EXCITER = vp.Exciter(l=0.5, nu=0.8, f=0.1, h=0.15, delta=0.05, load=0.02, R1=0.7, R2=0.6)
GRIDS = {
    "nu": (np.linspace(0.5, 0.95, 19), 2),
    "f": (np.linspace(0.05, 0.4, 15), 2),
    "l": (np.linspace(0.2, 0.6, 9), 2),
    "delta": (np.linspace(-0.1, 0.45, 12), 2),
}


def line_of(name: str, **changes: float):
    return vp.sweep(
        replace(EXCITER, **changes), over={name: GRIDS[name][0]}, outputs=("harmonics",)
    )


def border(line, name: str) -> tuple[float, float]:
    """Return both values of the parameter between which the motion without impacts ends."""
    first = np.flatnonzero(np.diff((line.regime.values == 0).astype(int)))[0]
    return float(line[name][first]), float(line[name][first + 1])


@pytest.mark.parametrize("name", GRIDS)
def test_there_the_linear_amplitude_is_the_gap(name: str) -> None:
    line = line_of(name)
    low, high = border(line, name)
    place = first_touch(line, name, low, high)
    assert place is not None
    assert low < place < high
    e = replace(EXCITER, **{name: place})
    size = math.hypot(1 - e.nu**2, e.h * e.nu)
    assert abs(e.f) / size == pytest.approx(e.l - abs(e.delta - e.load), rel=1e-12)


def test_it_is_the_same_in_the_units_that_are_shown() -> None:
    plain = line_of("nu")
    m, C = 0.35, 6000.0
    shown = display_units({"line": vp.to_physical(plain, m, C)})["line"]
    low, high = border(plain, "nu")
    p = math.sqrt(C / m)
    place = first_touch(shown, "omega", low * p, high * p)
    assert place == pytest.approx(first_touch(plain, "nu", low, high) * p, rel=1e-12)


def test_none_is_told_where_there_is_no_such_form() -> None:
    line = line_of("f")
    low, high = border(line, "f")
    assert first_touch(line, "f", 0.05, low) is None
    assert first_touch(line.assign_coords(friction=0.1), "f", low, high) is None
    assert first_touch(line.assign_coords(f2=0.1), "f", low, high) is None
    assert first_touch(line.drop_vars("nu"), "f", low, high) is None


def test_a_finding_tells_it_with_more_digits_than_the_step() -> None:
    line = line_of("f")
    place = first_touch(line, "f", *border(line, "f"))
    assert (
        f"The motion without impacts touches a support at f = {place:.5g}"[:-2]
        in sweep_answers(line)[0].rest
    )
