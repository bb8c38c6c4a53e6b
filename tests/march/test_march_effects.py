"""Kernels without an absent effect give the results of the full ones, and hold no code for it."""

from __future__ import annotations

import os
import re
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import printed
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from sampling import sampled

import vibropipe as vp
from vibropipe.march.grid import Instant, exact_grid
from vibropipe.march.log import new_log
from vibropipe.march.loop import march
from vibropipe.march.state import State, departure_mode, initial_state
from vibropipe.physics.effects import (
    ALL_EFFECTS,
    Effects,
    effects_from_names,
    effects_of,
    kernel_effects,
)
from vibropipe.physics.flow import DEGREE
from vibropipe.words.parameters import COMMON_EFFECTS

# name of the absent effects: parameters, start (x0, v0), effects present
FORCED = {"l": 0.5, "nu": 1.1, "f": 0.45, "h": 0.1, "delta": 0.01, "R1": 0.6, "R2": 0.8}
FREE = {**FORCED, "f": 0.0}
CASES: dict[str, tuple[dict[str, float], tuple[float, float], tuple[str, ...]]] = {
    "forcing": (FREE, (0.1, 3.0), ("damping", "support_1", "support_2", "restitution", "rest")),
    "damping": ({**FORCED, "h": 0.0}, (0.0, 0.3), tuple(set(COMMON_EFFECTS) - {"damping"})),
    "support 1": (
        {**FORCED, "l": 60.0, "delta": 59.8},
        (0.0, 1.0),
        tuple(set(COMMON_EFFECTS) - {"support_1"}),
    ),
    "support 2": (
        {**FORCED, "l": 60.0, "delta": -59.8},
        (0.0, 1.0),
        tuple(set(COMMON_EFFECTS) - {"support_2"}),
    ),
}
QUANTITIES = (
    "displacement", "velocity", "displacement_end", "velocity_end", "impact_tau", "impact_support",
    "impact_velocity", "impact_velocity_after", "rest_start", "rest_end", "rest_support", "status",
)  # fmt: skip
METHODS: list[dict[str, Any]] = [{}, {"method": "newmark", "steps_per_period": 40}]


def motions(absent: str, method: dict[str, Any], samples: int = 16) -> tuple[Any, Any]:
    """Return one motion by the full kernel, whose effect is present but null, and by the kernel without it."""
    parameters, (x0, v0), effects = CASES[absent]
    exciter = vp.Exciter(**parameters)
    options = {"tau_end": 20.0, "x0": x0, "v0": v0, "samples_per_period": samples, **method}
    return vp.simulate(exciter, **options), vp.simulate(exciter, effects=effects, **options)


def compare_all() -> None:
    """Compare every case by both methods bit for bit, uncompiled, since their kernels take long to compile."""
    for absent in CASES:
        for method in METHODS:
            if method and absent.startswith("support"):
                continue  # watched, not left out
            full, without = motions(absent, method, samples=4)
            assert full.impact_tau.size > 2, absent
            for name in QUANTITIES:
                assert np.array_equal(full[name].values, without[name].values), (absent, name)


def test_null_effects_change_no_bit_of_the_formulas() -> None:
    code = "import test_march_effects; test_march_effects.compare_all(); print('same')"
    path = os.pathsep.join([str(Path(__file__).parent), *filter(None, sys.path)])
    assert printed(code, PYTHONPATH=path, NUMBA_DISABLE_JIT="1") == "same\n"


@pytest.mark.parametrize("absent", sampled(["forcing", "support 1", "support 2"]))
def test_null_effects_change_no_bit_of_compiled_kernels(absent: str) -> None:
    full, without = motions(absent, {}, samples=4)
    assert full.impact_tau.size > 2
    for name in QUANTITIES:
        np.testing.assert_array_equal(full[name].values, without[name].values, err_msg=name)


@given(
    h=st.floats(0, 1.5), width=st.floats(0.05, 2), share=st.floats(-0.9, 0.9), R1=st.floats(0.3, 1),
    R2=st.floats(0.3, 1), x=st.floats(-0.99, 0.99), v=st.floats(-4, 4), tau_end=st.floats(0, 40),
)  # fmt: skip
@example(h=0.005, width=0.5, share=0.0, R1=0.99, R2=0.99, x=0.0, v=2.0, tau_end=20.0)
@example(h=0.0, width=0.5, share=0.0, R1=1.0, R2=1.0, x=0.0, v=4.0, tau_end=40.0)
@settings(max_examples=60, deadline=None)
def test_unforced_motions_are_those_of_the_full_kernel(
    h: float, width: float, share: float, R1: float, R2: float, x: float, v: float, tau_end: float
) -> None:
    """Unforced steps begin at each impact instead of on a grid of phases, so only rounding differs."""
    exciter = vp.Exciter(l=width, f=0.0, h=h, delta=share * width, R1=R1, R2=R2)
    options = {"tau_end": tau_end, "x0": (share + x) * width, "v0": v, "samples_per_period": 0}
    full = vp.simulate(exciter, **options)
    without = vp.simulate(exciter, effects=CASES["forcing"][2], **options)
    # Nearly grazing impacts amplify rounding; others by no more than the ratio of speeds.
    speeds = np.abs(full.impact_velocity.values)
    assume(speeds.size == 0 or speeds.min() > 1e-3)
    np.testing.assert_array_equal(full.impact_support.values, without.impact_support.values)
    for name in ("impact_tau", "impact_velocity", "displacement_end", "velocity_end"):
        np.testing.assert_allclose(without[name], full[name], rtol=0, atol=1e-10, err_msg=name)


@pytest.mark.slow
@given(
    nu=st.floats(0.3, 4), f=st.floats(-3, 3), h=st.floats(0.3, 1), distance=st.floats(-0.5, 1),
    R=st.floats(0.2, 0.9), x=st.floats(0.01, 1), v=st.floats(-2, 2), side=st.sampled_from([1, 2]),
)  # fmt: skip
@example(nu=1.0, f=1.0, h=0.6, distance=0.5, R=0.7, x=0.5, v=0.0, side=2)
@settings(max_examples=60, deadline=None)
def test_motions_off_one_support_are_those_of_the_full_kernel(
    nu: float, f: float, h: float, distance: float, R: float, x: float, v: float, side: int
) -> None:
    """Double steps change no impact; the other support is out of reach."""
    away = -1.0 if side == 1 else 1.0
    exciter = vp.Exciter(l=100.0, nu=nu, f=f, h=h, delta=away * (100.0 - distance), R1=R, R2=R)
    start = {"x0": away * (x - distance), "v0": v, "samples_per_period": 0}
    full = vp.simulate(exciter, tau_end=25.0, **start)
    without = vp.simulate(exciter, tau_end=25.0, effects=CASES[f"support {3 - side}"][2], **start)
    speeds = np.abs(full.impact_velocity.values)
    assume(speeds.size == 0 or speeds.min() > 1e-2)
    np.testing.assert_array_equal(full.impact_support.values, without.impact_support.values)
    for name in ("impact_tau", "impact_velocity", "displacement_end", "velocity_end"):
        np.testing.assert_allclose(without[name], full[name], rtol=0, atol=1e-9, err_msg=name)


def holds_a_sine(kernel: Any, e: Effects, f: float, *arguments: Any) -> bool:
    """Return whether the machine code of a kernel and its callees, as cached, contains a sine.

    That is a call of one, or a coefficient of the polynomial that computes one.
    """
    p = vp.Exciter(l=0.5, nu=1.0, f=f, h=0.1, R1=0.5, R2=0.5).parameters()
    grid = exact_grid(e, p)
    state = initial_state(e, p, grid, 0.0, 0.1, 2.0, None)
    call = [e, p, grid, *(state if a is State else a for a in arguments)]
    kernel(*call)
    signature = tuple(map(kernel.typeof_pyval, call))
    index = kernel._cache._cache_file._load_index()
    (name,) = [name for key, name in index.items() if key[0] == signature]
    code = (Path(kernel.stats.cache_path) / name).read_bytes()
    assert b"\x7fELF" in code
    coefficient = np.float64(1.58969099521155010221e-10).tobytes()
    called = re.search(rb"\0(sin|cos|sincos)\0|_ZN9vibropipe7physics4load12sincos_turns", code)
    return coefficient in code or called is not None


def test_one_kernel_serves_all_losses_at_supports() -> None:
    """With a support, restitution and rest are in every kernel; without one, in none that does not call for them."""
    calls = {
        "strong": {"f": 1.5}, "weak": {"f": 0.3}, "lossless": {"R1": 1.0, "R2": 1.0},
        "rubbed": {"friction": 0.1}, "soft": {"k1": 100.0, "h1": 1.0, "R1": 1.0}, "free": {"l": 50.0},
    }  # fmt: skip
    called = {
        name: effects_of({**FORCED, "delta": 0.0, **given}, 0.0, 0.0)
        for name, given in calls.items()
    }
    assert len({*called.values()}) == 6
    kernels = {name: kernel_effects(each) for name, each in called.items()}
    assert kernels["strong"] == kernels["weak"] == kernels["lossless"] == ALL_EFFECTS
    assert kernels["rubbed"] == ALL_EFFECTS._replace(friction=1)
    assert kernels["soft"] == ALL_EFFECTS._replace(soft=1)
    assert kernels["free"] == called["free"]
    assert called["free"].rest is None


def test_an_unforced_kernel_holds_no_sine() -> None:
    """The code of the whole unforced march holds neither a call nor the polynomial; the forced one does."""
    unforced = effects_from_names(["damping", "support_1", "support_2", "restitution", "rest"])
    end = (Instant(2, 0, 0.0), new_log(64, 64), None, np.empty(DEGREE + 1), 100)
    assert not holds_a_sine(march, unforced, 0.0, State, *end)
    assert holds_a_sine(march, ALL_EFFECTS, 1.0, State, *end)
    assert holds_a_sine(departure_mode, ALL_EFFECTS, 1.0, 1, 0.5, 0.1, None)
