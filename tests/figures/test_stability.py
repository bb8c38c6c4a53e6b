"""Orbits whose perturbations neither grow nor decay are neither stable nor unstable."""

import numpy as np
import pytest
import xarray as xr

import vibropipe as vp
from vibropipe.figures.motion_words import is_unstable, stability_text
from vibropipe.scenes.sweep.captions import row_kinds_text
from vibropipe.scenes.sweep.sweep_rows import row_kinds
from vibropipe.solve.multipliers import decay
from vibropipe.store.table import is_neutral
from vibropipe.words.bifurcations import Bifurcation

FREE = vp.Exciter(l=0.5)
RUBBED = vp.Exciter(l=0.5, nu=1.0, f=0.5, h=0.1, R1=0.8, R2=0.8)


@pytest.fixture(scope="module")
def free() -> xr.Dataset:
    """Return motions without losses, within the gap and beyond."""
    return vp.sweep(FREE, {"v0": [0.1, 0.4, 1.0]}, outputs=("stability",))


@pytest.fixture(scope="module")
def rubbed() -> xr.Dataset:
    """Return motions of a mass that friction lets move, and holds."""
    return vp.sweep(RUBBED, {"friction": [0.1, 0.45, 0.6, 0.8]})


def test_motions_without_losses_are_neutral(free):
    assert is_neutral(free).all()
    assert not is_unstable(free).any()
    assert stability_text(free.isel(v0=0)) == "neutral"


def test_tables_call_neutral_orbits_so(free, rubbed):
    assert (vp.table(free)["stable"] == "neutral").all()
    assert list(vp.table(rubbed)["stable"]) == ["stable", "stable", "neutral", "neutral"]


def test_a_mass_held_by_friction_is_neutral(rubbed):
    np.testing.assert_array_equal(is_neutral(rubbed), [False, False, True, True])
    words = [stability_text(rubbed.isel(friction=n)) for n in range(4)]
    assert words == ["stable", "stable", "neutral", "neutral"]


def test_an_unstable_orbit_is_unstable():
    branch = vp.branch(vp.Exciter(l=0.5, nu=1.0, f=0.25, h=0.1, R1=0.7, R2=0.7), "nu", (0.7, 1.5))
    assert (branch.stable.values == 0).any()
    np.testing.assert_array_equal(is_unstable(branch) | is_neutral(branch), branch.stable == 0)
    moduli = np.abs(branch.floquet_multiplier.values).max(axis=-1)
    assert (moduli[is_unstable(branch)] > 1).all()


def test_an_orbit_at_its_grazing_is_unstable_however_large_the_error():
    exciter = vp.Exciter(l=0.5, nu=1.3, f=0.5, h=0.1, R1=0.7, R2=0.7)
    branch = vp.branch(exciter, "delta", (-0.45, 0.45), switch=["pitchfork", "flip"])
    at = branch.bifurcation_point.values[branch.bifurcation_kind.values == Bifurcation.GRAZING]
    moduli = np.abs(branch.floquet_multiplier.values[at]).max(axis=-1)
    errors = branch.floquet_multiplier_error.values[at].max(axis=-1)
    assert ((moduli > 1e9) & (errors > moduli)).any()
    assert is_unstable(branch)[at].all()


@pytest.mark.parametrize(
    ("f", "R", "delta", "nu", "kind"),
    [
        (0.72, (0.8, 0.7), 0.18, 1.07, Bifurcation.FOLD),
        (0.59, (0.8, 0.7), 0.22, 2.33, Bifurcation.FLIP),
        (0.25, (0.7, 0.7), 0.0, 1.0, Bifurcation.PITCHFORK),
    ],
)
def test_an_orbit_at_its_bifurcation_is_neither_stable_nor_unstable(f, R, delta, nu, kind):
    exciter = vp.Exciter(l=0.5, nu=nu, f=f, h=0.1, R1=R[0], R2=R[1], delta=delta)
    branch = vp.branch(exciter, "nu", (0.5, 4.0))
    at = branch.bifurcation_point.values[branch.bifurcation_kind.values == kind]
    assert len(at) > 0
    assert not branch.stable.values[at].any()
    assert is_neutral(branch)[at].all()


def test_what_is_less_than_its_error_below_1_is_not_called_stable():
    multipliers = np.array([[1 - 1e-6, 0.1], [1 - 1e-6, 0.1], [0.5, 0.5j], [1 - 1e-10, 0.1]])
    error = np.array([[1e-7, 1.0], [2e-6, 0.0], [1e-9, 1e-9], [np.nan, np.nan]], np.float32)
    assert (decay(multipliers, error) > 0).tolist() == [True, False, True, False]
    assert (decay(multipliers) > 0).tolist() == [True, True, True, False]
    assert decay(1 / multipliers[:1], error[:1])[0] == pytest.approx(-9.0)


def test_neutral_rows_are_counted_in_the_caption(free, rubbed):
    assert "Of 3 rows, 3 are neutral" in row_kinds_text(free)
    assert "Of 4 rows, 2 are neutral" in row_kinds_text(rubbed)
    assert "neutral" not in row_kinds_text(rubbed.isel(friction=[0, 1]))
    assert "unstable" not in row_kinds_text(rubbed)


def test_neutral_rows_are_marked_as_orbits_are(rubbed):
    assert not row_kinds(rubbed)["unstable"].any()


def test_without_multipliers_no_orbit_is_neutral(free):
    bare = free.drop_vars("floquet_multiplier")
    assert is_unstable(bare).all()
