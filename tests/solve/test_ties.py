"""Ties: rows are those of exciters whose parameters are computed by hand, derivatives follow the chain rule."""

from __future__ import annotations

import ast
import itertools
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.text import Text

import vibropipe as vp
from vibropipe.physics.ties import Ties
from vibropipe.solve.sweep.blocks import assemble, solve_shard
from vibropipe.solve.sweep.sweep import grid_of

ROOT = Path(__file__).parents[2]
EXCITER = vp.Exciter(l=1.0, delta=0.1)
TIES = {"R2": "R1", "f": "me * nu**2", "h": "2 * zeta", "me": 0.5}
OVER = {"zeta": [0.05, 0.01], "nu": [0.9, 1.2], "R1": [0.6, 0.7]}
OUTPUTS = ("harmonics", "impacts", "stability", "energy", "sensitivity")


@pytest.fixture(scope="module")
def rows() -> xr.Dataset:
    return vp.sweep(EXCITER, OVER, outputs=OUTPUTS, ties=TIES)


def by_hand(zeta: float, nu: float, R1: float) -> vp.Exciter:
    return vp.Exciter(l=1.0, delta=0.1, nu=nu, R1=R1, R2=R1, f=0.5 * nu**2, h=2 * zeta)


def test_each_row_is_the_steady_state_of_the_exciter_by_hand(rows: xr.Dataset) -> None:
    assert rows.displacement_mean.dims == ("zeta", "nu", "R1")
    for point in itertools.product(*OVER.values()):
        row = rows.sel(dict(zip(OVER, point, strict=True)))
        exciter = by_hand(*point)
        alone = vp.sweep(exciter, {"nu": [exciter.nu]}, outputs=OUTPUTS[:-1]).isel(nu=0)
        for name in alone.data_vars:
            if "impact" not in alone[name].dims and name != "row_size":
                np.testing.assert_array_equal(row[name], alone[name], err_msg=f"{name} {point}")
        for name in ("f", "h", "R2"):
            assert float(row[name]) == getattr(exciter, name)


def test_the_dataset_says_how_it_was_made(rows: xr.Dataset) -> None:
    assert rows.attrs["ties"] == "R2 = R1; f = me * nu**2; h = 2 * zeta; me = 0.5"
    assert rows.zeta.attrs == {"units": "1", "long_name": "zeta", "symbol": "zeta"}
    assert "me" not in rows.variables
    assert "ties" not in vp.sweep(EXCITER, {"nu": [0.9]}).attrs


def test_proofs_tables_and_figures_take_tied_rows(rows: xr.Dataset) -> None:
    table = vp.table(rows)
    np.testing.assert_array_equal(table["h"], 2 * table["zeta"])
    drawn = {text.get_text() for text in vp.plot(rows.isel(R1=0)).findobj(Text)}
    assert any("zeta" in text for text in drawn), drawn
    pytest.importorskip("flint")
    proof = vp.prove(rows)
    assert proof.zeta.attrs == rows.zeta.attrs
    for point in ((0.05, 0.9, 0.6), (0.01, 1.2, 0.7)):
        one = vp.prove(by_hand(*point))
        assert int(proof.proved.sel(dict(zip(OVER, point, strict=True)))) == int(one.proved) == 1


def test_a_parameter_tied_to_nothing_that_is_swept_is_the_same_in_every_row() -> None:
    rows = vp.sweep(
        vp.Exciter(l=1.0, R1=0.7, f=0.5), {"nu": [0.9, 1.1]}, ties={"R2": "R1", "h": "2 * 0.05"}
    )
    assert rows.R2.shape == rows.h.shape == ()
    expected = vp.sweep(vp.Exciter(l=1.0, R1=0.7, R2=0.7, f=0.5, h=0.1), {"nu": [0.9, 1.1]})
    xr.testing.assert_identical(rows.drop_attrs(), expected.drop_attrs())


def test_ties_and_cuts_and_following_do_not_meet() -> None:
    over = {"nu": [0.7, 0.9, 1.1, 1.3], "zeta": [0.02, 0.05]}
    ties = {"f": "0.5 * nu**2", "h": "2 * zeta"}
    whole = vp.sweep(EXCITER, over, follow=("nu", "both"), ties=ties)
    grid = grid_of(EXCITER, over, ("nu", "both"), ties)
    shards = [solve_shard(grid, *cut) for cut in ((8, 16), (0, 4), (4, 8))]
    xr.testing.assert_identical(assemble(shards, grid), whole)
    for zeta in over["zeta"]:
        alone = vp.sweep(
            EXCITER, {"nu": over["nu"]}, follow=("nu", "both"), ties={**ties, "zeta": zeta}
        )
        np.testing.assert_array_equal(
            whole.displacement_mean.sel(zeta=zeta), alone.displacement_mean
        )


def test_derivatives_are_those_of_differences_of_the_tied_sweep(rows: xr.Dataset) -> None:
    assert list(rows.parameter.values) == ["nu", "l", "delta", "R1", "load", "zeta"]
    names = ("displacement_mean", "displacement_amplitude", "impact_velocity_max", "energy_input")
    for n, by in enumerate(OVER):
        step, points = 1e-6, []
        for sign in (-1, 1):
            moved = {
                name: np.array(values) + sign * step * (name == by) for name, values in OVER.items()
            }
            points.append(vp.sweep(EXCITER, moved, outputs=OUTPUTS[:-1], ties=TIES))
        for name in names:
            differences = (points[1][name].values - points[0][name].values) / (2 * step)
            exact = rows[f"{name}_sensitivity"].sel(parameter=by).values
            is_smooth = np.isfinite(exact)
            assert is_smooth.mean() > 0.5
            np.testing.assert_allclose(
                differences[is_smooth],
                exact[is_smooth],
                rtol=2e-4,
                atol=1e-6,
                err_msg=f"{n} {name}",
            )


def test_impacts_have_derivatives_by_what_is_free() -> None:
    over, step = {"zeta": [0.05], "R1": [0.6, 0.7]}, 1e-6
    exciter = vp.Exciter(l=1.0, delta=0.1, nu=0.9)
    exact, low, high = (
        vp.sweep(exciter, {**over, "zeta": [0.05 + move]}, outputs=OUTPUTS, ties=TIES)
        for move in (0, -step, step)
    )
    differences = (high.impact_velocity - low.impact_velocity).values / (2 * step)
    np.testing.assert_allclose(
        exact.impact_velocity_sensitivity.sel(parameter="zeta"), differences, rtol=1e-4
    )


def test_a_damping_follows_a_restitution_that_is_tied() -> None:
    exciter = vp.Exciter(l=1.0, f=1.5, nu=0.8, h=0.05, k1=50.0)
    rows = vp.sweep(exciter, {"R2": [0.6, 0.8]}, ties={"R1": "R2", "k2": "k1"})
    for R in (0.6, 0.8):
        alone = vp.sweep(
            vp.Exciter(l=1.0, f=1.5, h=0.05, k1=50.0, k2=50.0, R1=R, R2=R), {"nu": [0.8]}
        ).isel(nu=0)
        row = rows.sel(R2=R)
        for name in ("h1", "h2", "displacement_mean", "contact_force_max_1"):
            if name in alone:
                np.testing.assert_array_equal(row[name], alone[name])


def test_units_stay_beside_ties() -> None:
    """The expressions are of parameters without units; lengths are then in metres."""
    exciter = vp.Exciter.from_physical(m="2 kg", C="8 N/mm", l="8 mm", R1=0.7)
    over = {"omega": np.array([50.0, 60.0]), "zeta": [0.02, 0.05]}
    ties = {"R2": "R1", "f": "0.004 * nu**2", "h": "2 * zeta"}
    rows = vp.sweep(
        exciter, {**over, "omega": ["50 rad/s", "60 rad/s"]}, ties=ties, outputs=OUTPUTS
    )
    p = math.sqrt(8000 / 2)
    for omega, zeta in itertools.product(over["omega"], over["zeta"]):
        nu = omega / p
        alone = vp.sweep(
            vp.Exciter(l=0.008, R1=0.7, R2=0.7, f=0.004 * nu**2, h=2 * zeta),
            {"nu": [nu]},
            outputs=OUTPUTS[:-1],
        ).isel(nu=0)
        row = rows.sel(omega=omega, zeta=zeta)
        np.testing.assert_array_equal(row.displacement_amplitude, alone.displacement_amplitude)
        assert float(row.F) == pytest.approx(8000 * 0.004 * nu**2, rel=1e-14)
    assert list(rows.parameter.values) == ["omega", "l", "delta", "R1", "load", "zeta"]
    step = 1e-6
    moved = vp.sweep(exciter, {"omega": [50.0 * 1], "zeta": [0.02 - step, 0.02 + step]}, ties=ties)
    difference = np.diff(moved.displacement_mean.values[0])[0] / (2 * step)
    exact = float(rows.displacement_mean_sensitivity.sel(omega=50.0, zeta=0.02, parameter="zeta"))
    assert difference == pytest.approx(exact, rel=1e-4, abs=1e-9)


def test_supports_are_checked_wherever_tied_ones_meet_others() -> None:
    """delta - l follows l: no corner of both alone says whether the start lies between the supports."""
    good = {"l": [0.5, 1.0, 2.0]}
    rows = vp.sweep(vp.Exciter(l=1.0, nu=1.2, f=0.5), good, x0=0.3, ties={"delta": "l - 0.5"})
    np.testing.assert_array_equal(rows.delta, [0.0, 0.5, 1.5])
    with pytest.raises(vp.ParameterError, match=r"x0: must be .* from -0.25"):
        vp.sweep(vp.Exciter(l=1.0, nu=1.2, f=0.5), {"l": [0.5, 0.75, 2.0]}, x0=-0.3,
                 ties={"delta": "(l - 0.5) * (2 - l) * 1.6"})  # fmt: skip


@pytest.mark.parametrize(
    ("ties", "message"),
    [
        ([("R2", "R1")], "ties: must be a mapping"),
        ({"R2": "dellta"}, "ties.R2: must have a value for dellta: give it in over or by a tie, got .* 'delta'"),
        ({"h": "2 * zeta"}, "ties.h: must have a value for zeta: give it in over or by a tie, got .2 . zeta"),
        ({"R2": "h1"}, "ties.R2: must have a value for h1"),
        ({"R1": "R2", "R2": "R1"}, "ties.R.: must not go round in a circle: R. from R. from R."),
        ({"R1": "R1"}, "ties.R1: must not go round in a circle: R1 from R1"),
        ({"nu": "2"}, "over.nu: must be left out, since it is tied"),
        ({"delta": "0.2"}, "delta: must be left out, since it is tied"),
        ({"x0": "l"}, "ties: must have keys that are each a parameter, or a name"),
        ({"h": "x0"}, "ties.h: must not use x0"),
        ({"2h": "1"}, "ties: must have keys that are each a parameter, or a name"),
        ({"regime": "1", "h": "regime"}, "ties: must not have regime as a name of one's own, since datasets have a "
                                         "quantity of this name: take another, as own_regime$"),
        ({"h": "omega"}, "ties.h: must not have omega as a name of one's own, since it is a parameter with units "
                        r"\(nu has none\): take another, as own_omega$"),
        ({"f": "m_e", "m_e": 0.02}, "^ties: must not have m_e as a name of one's own, since it is a parameter "),
        ({"sin": "1"}, "ties: must not have sin as a name of one's own, since it is what expressions call a function"),
        ({"h": "nu^2"}, r"ties.h: must be a number or text with arithmetic .*, got 'nu\^2', with \^, which is written"),
        ({"h": None}, "ties.h: must be a finite number"),
        ({"h": math.nan}, "ties.h: must be a finite number, got nan"),
        ({"h": [1]}, "ties.h: must be a finite number"),
        ({"h": "nu - 1"}, r"ties.h: must be a finite number >= 0, got -0.09.* at nu = 0.9 by nu - 1"),
        ({"h": "1 / (nu - 0.9)"}, r"ties.h: must be a finite number >= 0, got nan at nu = 0.9 by 1 / "),
        ({"R2": "nu"}, r"ties.R2: must be a number from 0 to 1, got 1.2 at nu = 1.2 by nu"),
        ({"k2": 10, "h2": 5, "R2": 0.5}, "h2: must be left out"),
        ({"h1": 0.1}, "h1: must be 0 where k1 = 0"),
    ],
)  # fmt: skip
def test_a_tie_that_cannot_hold_is_refused(ties: Any, message: str) -> None:
    with pytest.raises(vp.ParameterError, match=message):
        vp.sweep(EXCITER, {"nu": [0.9, 1.2]}, ties=ties)


def test_the_ties_of_an_unbalance_in_the_documentation_hold() -> None:
    texts = [vp.Exciter.__doc__ or "", (ROOT / "docs/theory.md").read_text(encoding="utf-8")]
    for text, of in zip(texts, (r"`(\{[^`]*)`", r"ties=(\{[^`]*\})\)`"), strict=True):
        found = [each for each in re.findall(of, text) if "nu**2" in each]
        for given in found:
            ties = ast.literal_eval(" ".join(given.split()))
            own = [value for value in ties.values() if isinstance(value, float)]
            tied = vp.Exciter(l=1.0, nu=0.9, R1=0.7, ties=ties)
            assert tied.f == pytest.approx(math.prod(own) * 0.9**2, rel=1e-15)
        assert len(found) == (1 if text is texts[0] else 2)


@pytest.mark.parametrize(
    ("over", "ties", "message"),
    [
        ("zeta", {"h": "2 * eta", "eta": 1}, r"over: must have keys among .*, got 'zeta'"),
        (
            "zeta",
            {"h": "2 * zeta", "zeta": "0.1"},
            r"over.zeta: must be left out, since it is tied",
        ),
        ("zeta", {"f": "zeta"}, "nu: is required beside f"),
        ("R1", {"f": "nu"}, r"ties.f: must have a value for nu"),
    ],
)
def test_names_and_forces_that_lack_what_they_need_are_refused(over, ties, message) -> None:
    with pytest.raises(vp.ParameterError, match=message):
        vp.sweep(EXCITER, {over: [0.1]}, ties=ties)


def test_derivatives_of_ties_by_names_they_depend_on_through_others() -> None:
    ties = Ties({"h": "2 * zeta * sqrt(k1)", "k1": "c / a", "k2": "k1"})
    given = {"zeta": 0.1, "c": 8.0, "a": 2.0}
    slopes = ties.slopes(given, ["zeta", "a"])
    assert slopes["k2"] == slopes["k1"] == {"a": -2.0}
    assert slopes["h"] == pytest.approx({"zeta": 4.0, "a": -0.1})
    assert ties.values(given) == {"h": 0.4, "k1": 4.0, "k2": 4.0}
