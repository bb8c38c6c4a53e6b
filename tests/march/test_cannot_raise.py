"""No kernel can raise.

The exceptions that compiled code can raise are read from it, for all functions that solve rows and motions.
"""

from __future__ import annotations

import pickle
import re
import sys
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numba
import pytest
from numba.core.dispatcher import Dispatcher

import vibropipe as vp
from vibropipe.compiler import jit
from vibropipe.solve.rows.many import solve_piece
from vibropipe.words.outputs import OUTPUTS

# Exceptions of allocation. Arrays are created once per row or motion and their sizes are bounded by constants, so only
# a machine without memory raises these; numba checks the size of every array.
OF_ALLOCATION = {
    (MemoryError, "Allocation failed (probably too large)."),
    (ValueError, "negative dimensions not allowed"),
    (
        ValueError,
        "array is too big; `arr.size * arr.dtype.itemsize` is larger than the maximum possible size.",
    ),
}
CONSTANT = re.compile(
    r'^@(\S*pickledata\S*) = .*constant \[\d+ x i8\] c"(.*?)"(?:, align \d+)?$', re.M
)
ESCAPE = re.compile(rb"\\([0-9A-Fa-f]{2})")
EXCITER = vp.Exciter(l=0.5, nu=0.9, f=1.0, h=0.2, R1=0.7, R2=0.7)


def raised_by(dispatcher: Any) -> Iterator[tuple[type, str]]:
    """Yield (exception, message) of all that the compiled code of a function and its callees can raise.

    numba stores each as a pickle among the constants of the module; optimised code keeps those that are reachable.
    """
    for compiled in dispatcher.overloads.values():
        text = str(compiled.library._get_module_for_linking())
        for _name, escaped in CONSTANT.findall(text):
            raw = ESCAPE.sub(lambda m: bytes([int(m[1], 16)]), escaped.encode("latin1"))
            try:
                kept = pickle.loads(raw)
            except Exception:  # the hash stored with it
                continue
            if isinstance(kept, tuple) and isinstance(kept[0], type):
                yield kept[0], " ".join(map(str, kept[1] or ()))


def compiled_functions() -> dict[str, Any]:
    """Return all functions of the package that are compiled for some arguments, by name."""
    return {
        f"{name}.{key}": value
        for name, module in list(sys.modules.items())
        if name.startswith("vibropipe.") and not name.startswith("vibropipe.lab.bench")
        for key, value in vars(module).items()
        if isinstance(value, Dispatcher) and value.py_func.__module__ == name and value.overloads
    }


@pytest.fixture(scope="module")
def functions() -> dict[str, Any]:
    """Return compiled functions, after problems of every kind were solved."""
    vp.sweep(EXCITER, {"nu": [0.9]}, outputs=OUTPUTS)
    of_pieces = tuple(each for each in OUTPUTS if each != "sensitivity")
    vp.sweep(replace(EXCITER, k1=50.0, k2=80.0, friction=0.1), {"nu": [0.9]}, outputs=of_pieces)
    of_housing = {"mass_ratio": 0.5, "housing_friction_1": 0.1, "housing_friction_2": 0.2}
    slides = replace(EXCITER, k1=50.0, friction=0.1, **of_housing)
    vp.sweep(replace(slides, f2=0.2), {"nu": [0.9]}, outputs=OUTPUTS)
    vp.simulate(slides, 20.0, energy=True)
    vp.simulate(slides, 20.0, method="newmark", steps_per_period=64)
    vp.simulate(EXCITER, 20.0, energy=True)
    vp.simulate(EXCITER, 20.0, method="newmark", steps_per_period=64, energy=True)
    vp.simulate(EXCITER, 2.0, accuracy=1e-6)
    vp.simulate(vp.Exciter(l=0.5), 20.0, x0=0.4, v0=1.0)
    vp.simulate(vp.Exciter(l=5.0, nu=1.0, f=0.1, h=0.2), 20.0)
    symmetric = vp.Exciter(l=0.5, nu=1.0, f=1.0, h=0.1, R1=0.8, R2=0.8)
    vp.branch(symmetric, "nu", (0.9, 1.2), switch=["pitchfork"])
    return compiled_functions()


def test_no_solver_can_raise(functions: dict[str, Any]) -> None:
    for needed in (
        "solve.rows.many.solve_piece", "solve.rows.many._sample",
        "march.loop.march_repeatedly",
        "march.grid.exact_grid", "march.grid.newmark_grid", "orbits.quadrature.add_energy",
        "solve.motion.closed_motion._sample", "solve.motion.closed_motion._sample_linear", "physics.conservative.arc",
        "orbits.law.steps.solve",
        "continuation.newton.predict", "orbits.branches.rows.write_points",
    ):  # fmt: skip
        assert f"vibropipe.{needed}" in functions
    exceptions = {
        name: set(raised_by(function)) - OF_ALLOCATION for name, function in functions.items()
    }
    assert not {name: raised for name, raised in exceptions.items() if raised}


def test_exceptions_are_detected() -> None:
    @jit
    def divided(a: complex, b: complex) -> complex:
        return a / b

    @numba.njit
    def refused(a: int) -> int:
        if a > 3:
            raise KeyError("too many")
        return a // (a - 1)

    divided(1j, 2j)
    refused(2)
    assert (ZeroDivisionError, "complex division by zero") in set(raised_by(divided))
    assert {kind for kind, _message in raised_by(refused)} == {KeyError, ZeroDivisionError}


def test_drivers_raise_on_allocation_only(functions: dict[str, Any]) -> None:
    """The list of accepted exceptions is no longer than necessary."""
    assert set(raised_by(solve_piece)) == OF_ALLOCATION
