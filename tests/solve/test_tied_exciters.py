"""Exciters with ties: calls follow them, copies compute them again, and what is not followed is refused."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import xarray as xr

import vibropipe as vp

TIES = {"R2": "R1", "f": "me * nu**2", "me": "0.5", "h": "2 * zeta", "zeta": "0.05"}
PLAIN = vp.Exciter(l=1.0, nu=0.98, delta=0.1, R1=0.7)
TIED = vp.Exciter(l=1.0, nu=0.98, delta=0.1, R1=0.7, ties=TIES)
MEASURED = {"nu": np.array([0.9, 1.0, 1.1]), "displacement_mean": np.array([0.05, 0.04, 0.03])}
FIT: dict[str, Any] = {"noise": {"displacement_mean": 0.01}, "samples": 16}
CALLS: dict[str, Callable[..., xr.Dataset]] = {
    "sweep": lambda e, **given: vp.sweep(e, {"nu": [0.9, 1.2], "R1": [0.6, 0.7]}, **given),
    "branch": lambda e, **given: vp.branch(e, "nu", 1.05, v0=0.1, **given),
    "boundary": lambda e, **given: vp.boundary(
        e, "fold", ("nu", "R1"), [(0.9, 1.0), (0.6, 0.7)], lines=2, **given
    ),
    "design": lambda e, **given: vp.design(
        e, {"R1": (0.6, 0.7)}, {"displacement_mean": 0.05}, samples=16, **given
    ),
    "tolerance": lambda e, **given: vp.tolerance(e, {"R1": 1e-3, "zeta": 1e-4}, samples=16, **given),
    "identify": lambda e, **given: vp.identify(e, MEASURED, {"R1": (0.5, 0.8)}, **FIT, **given),
}  # fmt: skip


@pytest.mark.parametrize("call", CALLS)
def test_calls_follow_them_as_ties_of_their_own(call: str) -> None:
    own, given = CALLS[call](TIED), CALLS[call](PLAIN, ties=TIES)
    xr.testing.assert_identical(own, given)
    assert own.attrs["ties"] == "; ".join(f"{name} = {text}" for name, text in TIES.items())


def test_ties_of_a_call_take_precedence() -> None:
    over = {"nu": [0.9, 1.2]}
    rows = vp.sweep(TIED, over, ties={"f": "0.4", "me": "0.3"})
    xr.testing.assert_identical(rows, vp.sweep(PLAIN, over, ties={**TIES, "f": "0.4", "me": "0.3"}))


def test_a_name_of_ones_own_varies_from_its_number() -> None:
    rows = vp.sweep(TIED, {"zeta": [0.05, 0.08]})
    np.testing.assert_array_equal(rows.h, [0.1, 0.16])
    at_own = vp.steady_state(TIED).displacement_mean
    np.testing.assert_array_equal(rows.displacement_mean[0], at_own)
    branch = vp.branch(TIED, "zeta", 0.06, v0=0.1)
    assert (float(branch.zeta.min()), float(branch.zeta.max())) == (0.05, 0.06)
    np.testing.assert_array_equal(branch.h, 2 * branch.zeta)


def test_a_steady_state_has_derivatives_by_what_is_free() -> None:
    outputs = ("harmonics", "impacts", "sensitivity")
    tied, swept = (
        vp.steady_state(TIED, outputs=outputs),
        vp.sweep(TIED, {"nu": [0.98]}, outputs=outputs).isel(nu=0),
    )
    assert "R2" not in tied.parameter.values
    assert tied.attrs["ties"] == swept.attrs["ties"]
    step = 1e-6
    for name in ("nu", "R1"):
        ends = (replace(TIED, **{name: getattr(TIED, name) + sign * step}) for sign in (-1.0, 1.0))
        low, high = (float(vp.steady_state(end).displacement_mean) for end in ends)
        exact = float(tied.displacement_mean_sensitivity.sel(parameter=name))
        assert (high - low) / (2 * step) == pytest.approx(exact, rel=1e-6)
        assert exact == float(swept.displacement_mean_sensitivity.sel(parameter=name))


def test_copies_compute_what_is_tied_again() -> None:
    assert (TIED.R2, TIED.f, TIED.h) == (0.7, 0.5 * 0.98**2, 0.1)
    moved = replace(TIED, R1=0.6, nu=1.2)
    assert (moved.R2, moved.f, moved.ties) == (0.6, 0.5 * 1.2**2, TIES)
    assert pickle.loads(pickle.dumps(TIED)).ties == TIED.ties == TIES
    stated = replace(TIED, R2=0.4)
    assert stated.R2 == 0.4
    assert stated.ties == {name: text for name, text in TIES.items() if name != "R2"}
    assert replace(TIED, ties={**TIED.ties, "zeta": "0.1"}).h == 0.2
    released = replace(TIED, ties={"h": "0.3"})
    assert (released.R2, released.f, released.h, released.ties) == (0.7, TIED.f, 0.3, {"h": "0.3"})
    mirrored = TIED.mirrored()
    assert (mirrored.delta, mirrored.ties, mirrored.R1) == (-0.1, {}, 0.7)
    assert "R1=0.7" in repr(TIED)
    assert "R2=" not in repr(TIED)
    assert repr(TIED).endswith(f"ties={TIES!r})")
    assert vp.Exciter(delta=0.1, ties={"l": "2 * delta"}).l == 0.2


def test_what_acts_through_a_tied_parameter_is_kept_apart() -> None:
    exciter = vp.Exciter(l=1.0, nu=2.0, shaker=0.1, ties={"f": "0.3 * nu"})
    plain = exciter.without_ties()
    assert exciter.f == plain.f == 0.3 * 2.0 + 0.1 * 4.0
    assert plain.ties == {}
    assert replace(exciter, nu=1.0).f == 0.3 + 0.1
    assert replace(plain, nu=1.0).f == 0.6 + 0.1


def test_lengths_are_in_metres_beside_units() -> None:
    given: dict[str, Any] = {"m": "0.35 kg", "C": "6 N/mm", "l": "4 mm", "omega": "130 rad/s", "F": "12 N"}  # fmt: skip
    ties = {"R2": "R1", "delta": "0.1 * l"}
    exciter = vp.Exciter.from_physical(**given, R1=0.6, ties=ties)
    assert (exciter.R2, exciter.delta) == (0.6, 0.1 * exciter.l)
    rows = vp.sweep(exciter, {"omega": ["120 rad/s", "130 rad/s"], "l": ["4 mm", "5 mm"]})
    np.testing.assert_allclose(rows.delta, [[4e-4, 5e-4]] * 2, rtol=1e-15)
    assert rows.delta.attrs["units"] == rows.l.attrs["units"] == "m"


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"R2": 0.5, "ties": {"R2": "R1"}}, "^R2: must be left out, since it is tied"),
        ({"ties": {"h": "2 * zeta"}}, "ties.h: must have a value for zeta: give it by a tie"),
        ({"ties": {"R2": "R1 * 2"}}, "ties.R2: must be a number from 0 to 1, got 2.0 at R1 = 1.0"),
        ({"ties": {"R2": "R1", "R1": "R2"}}, "must not go round in a circle"),
        ({"ties": {"h2": "h1"}}, "ties.h2: must have a value for h1"),
        ({"ties": "R2 = R1"}, "ties: must be a mapping of names to expressions"),
        ({"R3": 0.5, "ties": {"R2": "R1"}}, "R3: is an unknown parameter"),
    ],
)
def test_a_tie_that_cannot_hold_is_refused(given: dict[str, Any], message: str) -> None:
    with pytest.raises(vp.ParameterError, match=message):
        vp.Exciter(l=1.0, **given)


def test_l_is_required_unless_it_is_tied() -> None:
    with pytest.raises(vp.ParameterError, match=r"^l: is required"):
        vp.Exciter(ties={"R2": "R1"})  # type: ignore[call-arg]


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: vp.sweep(TIED, {"R2": [0.5]}), "over.R2: must be left out, since it is tied"),
        (lambda: vp.design(TIED, None, {"displacement_mean": 0.1}), "vary: must be a mapping of names to values"),
        (lambda: vp.simulate(TIED, 10.0, nu_end=1.1), "nu_end: must leave nu as it is: f is tied to it"),
        (lambda: vp.basins(TIED, [0.0], [0.0], over={"R1": [0.6, 0.7]}), "over.R1: must leave R1 as it is"),
        (lambda: vp.basins(TIED, [0.0], [0.0], over={"R2": [0.6, 0.7]}), "over.R2: must be left out"),
        (lambda: vp.one_sided_orbit_boundaries(TIED, [0.9]), "nu: must leave nu as it is"),
        (lambda: vp.steady_state(vp.Exciter(l=1.0, ties={"f": "0.5 * nu**2"})), "nu: is required beside f"),
    ],
)  # fmt: skip
def test_what_is_not_followed_is_refused(call: Callable[[], Any], message: str) -> None:
    with pytest.raises(vp.ParameterError, match=message):
        call()


@pytest.mark.parametrize("varied", [{"within": {"R1": 0.001}}, {"kind": "fold", "along": "nu"}])
def test_proofs_refuse_what_others_are_tied_to(varied: dict[str, Any]) -> None:
    pytest.importorskip("flint")
    call = vp.prove_bifurcation if "kind" in varied else vp.prove
    with pytest.raises(vp.ParameterError, match=r"as it is: .* is tied to it"):
        call(TIED, **varied)
