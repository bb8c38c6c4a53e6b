"""A motion or a row that did not end as requested warns in Python, where it was called, with its remedy."""

from __future__ import annotations

import warnings
from collections.abc import Callable

import numpy as np
import pytest
import xarray as xr

import vibropipe as vp
from vibropipe.words.status import Status

CHAOTIC = vp.Exciter(l=0.5, nu=0.6, f=1.0, h=0.1, R1=0.9, R2=0.9)
ORBIT = vp.Exciter(l=0.5, nu=1.0, f=1.0, h=0.2, R1=0.7, R2=0.7)


def warned(call: Callable[[], xr.Dataset]) -> tuple[xr.Dataset, list[str]]:
    """Return a result and the texts of its warnings, which must name this file."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        dataset = call()
    assert {warning.category for warning in caught} <= {vp.UnsolvedWarning}
    assert {warning.filename for warning in caught} <= {__file__}
    return dataset, [str(warning.message) for warning in caught]


def test_what_ends_as_requested_is_silent() -> None:
    over = {"nu": [0.9, 1.0]}
    assert warned(lambda: vp.simulate(ORBIT, 9.0))[1] == []
    assert warned(lambda: vp.simulate(ORBIT, 9.0, accuracy=1e-6))[1] == []
    assert warned(lambda: vp.steady_state(ORBIT))[1] == []
    assert warned(lambda: vp.sweep(ORBIT, over))[1] == []


@pytest.mark.parametrize(
    ("call", "status"),
    [
        (lambda: vp.simulate(ORBIT, 90.0, max_impacts=3), Status.MAX_IMPACTS),
        (lambda: vp.simulate(CHAOTIC, 900.0, accuracy=1e-12), Status.INACCURATE),
        (lambda: vp.steady_state(CHAOTIC), Status.MAX_PERIODS),
    ],
)
def test_a_motion_warns_with_its_remedy(call: Callable[[], xr.Dataset], status: Status) -> None:
    dataset, texts = warned(call)
    assert int(dataset.status) == status
    assert texts == [f"status {status.name.lower()}. {status.remedy}"]


@pytest.mark.parametrize(
    "effects",
    [
        None,
        # compiles a kernel of its own
        pytest.param(
            ["damping", "forcing", "support_1", "restitution", "rest"], marks=pytest.mark.slow
        ),
    ],
)
def test_a_sweep_warns_once_for_each_status_with_its_rows(effects: list[str] | None) -> None:
    over = {"nu": np.linspace(0.5, 0.8, 4), "f": [0.01, 1.0]}
    dataset, texts = warned(lambda: vp.sweep(CHAOTIC, over, effects=effects))
    expected = [
        f"{count} of 8 rows: status {Status(code).name.lower()}. {Status(code).remedy}"
        for code, count in zip(*np.unique(dataset.status, return_counts=True), strict=True)
        if code != Status.OK
    ]
    assert expected
    assert texts == expected
    assert Status.OK in dataset.status.values
