"""The kernels as plain Python give the results of the compiled ones."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import printed
from comparisons import parameters_of, reference

import vibropipe as vp
from vibropipe.words.parameters import COMMON_EFFECTS
from vibropipe.words.status import Status

MOTIONS = list(reference("motions"))
NEWMARK = ["fig9_offset", "chatter_and_rest", "plastic_R0"]
ORBITS = ["fig6_symmetric", "plastic_R0", "one_sided_at_equilibrium"]
CONTACTS = ("impact_tau", "impact_velocity", "impact_support", "rest_start", "rest_end")
ENDS = ("displacement_end", "velocity_end", "energy_residual")
ORBIT = ("displacement_amplitude", "impact_velocity", "period_multiple", "regime", "energy_input")


def numbers() -> dict[str, list[float]]:
    """Return contacts, end states and orbits of the sample, by name."""
    values = {}
    for name in MOTIONS:
        entry = reference("motions")[name]
        exciter = vp.Exciter(**parameters_of(entry)._asdict())
        x0, v0 = float(entry["x0"]), float(entry["v0"])
        options = [{}, {"method": "newmark", "steps_per_period": 40}][: 1 + (name in NEWMARK)]
        for method in options:
            tau_end = min(float(entry["tau_end"]), 25.0)
            ds = vp.simulate(exciter, tau_end, x0, v0, samples_per_period=0, energy=True, **method)
            for quantity in (*CONTACTS, *ENDS):
                values[f"{name} {len(method)} {quantity}"] = np.ravel(ds[quantity].values).tolist()
        if name in ORBITS:
            orbit = vp.steady_state(exciter, x0, v0)
            for quantity in ORBIT:
                values[f"{name} orbit {quantity}"] = np.ravel(orbit[quantity].values).tolist()
    return values


def status_at_the_bound() -> int:
    """Return the status of a motion whose searches all reach the stride limit, which plain Python can lower."""
    import vibropipe.march.roots as roots

    roots.MAX_STRIDES = 0
    e = vp.Exciter(l=0.5, nu=0.3, f=1.5, h=0.2, R1=0.5, R2=0.5)
    ds = vp.simulate(e, 20.0, samples_per_period=0)
    assert np.isnan(float(ds.displacement_end))
    return int(ds.status)


# rows that strike both supports, except the first
LEFT_OUT = vp.Exciter(l=0.5, nu=1.0, f=1.0, h=0.2, R1=0.7, R2=0.7), {"f": [0.02, 1.0, 2.0]}


def rows_with_a_support_left_out() -> list[list[int]]:
    """Return status and regime of rows marched without support 1, which is watched.

    No other test needs these kernels, and their compilation would be the longest of all.
    """
    effects = [name for name in COMMON_EFFECTS if name != "support_1"]
    ds = vp.sweep(*LEFT_OUT, outputs=["impacts"], effects=effects)
    return [ds.status.values.tolist(), ds.regime.values.tolist()]


@pytest.fixture(scope="module")
def uncompiled() -> dict[str, Any]:
    path = os.pathsep.join([str(Path(__file__).parent), *filter(None, sys.path)])
    code = (
        "import json, test_uncompiled as t; found = t.numbers(); "
        "found['left out'] = t.rows_with_a_support_left_out(); "
        "found['bound'] = t.status_at_the_bound(); print(json.dumps(found))"
    )
    return json.loads(printed(code, PYTHONPATH=path, NUMBA_DISABLE_JIT="1"))


def test_a_search_that_reaches_its_limit_is_reported(uncompiled: dict[str, Any]) -> None:
    assert uncompiled["bound"] == Status.ROOT_BOUND


def test_rows_that_reach_a_support_left_out_have_a_status(uncompiled: dict[str, Any]) -> None:
    """Two of three rows reach the support; the bound of the first proves that it does not."""
    status, regime = uncompiled["left out"]
    assert status == [Status.OK, Status.SUPPORT_REACHED, Status.SUPPORT_REACHED]
    full = vp.sweep(*LEFT_OUT, outputs=["impacts"])
    assert regime[0] == int(full.regime[0])
    assert full.status.values.tolist() == [Status.OK] * 3


@pytest.mark.slow
def test_compiled_rows_that_reach_a_support_left_out_have_a_status(
    uncompiled: dict[str, Any],
) -> None:
    assert rows_with_a_support_left_out() == uncompiled["left out"]


def test_plain_python_has_the_bits_of_the_compiled_kernels(uncompiled: dict[str, Any]) -> None:
    compiled = numbers()
    assert {*compiled, "bound", "left out"} == uncompiled.keys()
    assert sum(len(values) for values in compiled.values()) > 2000
    for name, values in compiled.items():
        np.testing.assert_array_equal(uncompiled[name], values, err_msg=name)
