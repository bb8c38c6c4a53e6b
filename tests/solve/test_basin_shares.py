"""Basins over a parameter, against single maps, branches of orbits and sweeps that are followed."""

import numpy as np
import pytest

import vibropipe as vp
from vibropipe.lab.bench_items import limit_threads
from vibropipe.solve.basins.attractor_families import carry
from vibropipe.solve.basins.attractor_set import AttractorSet
from vibropipe.solve.basins.attractors import scattered_starts
from vibropipe.words.quantities import FLAGS
from vibropipe.words.regimes import Regime

PAPER = vp.Exciter(l=0.5, nu=1.0, f=-1.0, h=0.2, R1=0.7, R2=0.7)
CASCADE = vp.Exciter(l=0.5, nu=1.0, f=1.67, h=0.1, delta=0.1, R1=0.8, R2=0.8)
STARTS = np.linspace(-0.5, 0.5, 12), np.linspace(-2, 2, 12)


@pytest.fixture(scope="module")
def jumps():
    return vp.basins(PAPER, *STARTS, starts=64, over={"nu": np.linspace(1.5, 3.8, 24)})


@pytest.mark.parametrize("index", [pytest.param(3, marks=pytest.mark.slow), 10, 23])
def test_each_value_has_the_basins_of_its_exciter(jumps, index):
    at = jumps.isel(nu=index)
    exciter = vp.Exciter(**{**vars(PAPER), "nu": float(at.nu)})
    alone = vp.basins(exciter, *STARTS, starts=64)
    present = at.basin_share.notnull().values
    assert present.sum() == alone.sizes["attractor_id"]
    for name in ("periods_to_attractor", "border"):
        np.testing.assert_array_equal(at[name], alone[name])
    own = at.isel(attractor_id=present)
    order = np.argsort(own.displacement_strobe.values)
    other = np.argsort(alone.displacement_strobe.values)
    for name in ("basin_share", "basin_share_high", "displacement_amplitude", "floquet_multiplier",
                 "regime", "impact_velocity_max"):  # fmt: skip
        np.testing.assert_array_equal(own[name].values[order], alone[name].values[other])


def test_attractors_vanish_at_the_folds_and_grazings_of_branches(jumps):
    """Found by marching motions there, and by continuation of the equations of orbits here."""
    start = vp.Exciter(**{**vars(PAPER), "nu": 1.6})
    branches = vp.branch(start, "nu", (1.5, 3.8), switch=["grazing"])
    expected = branches.bifurcation_nu.values
    located = jumps.bifurcation_nu.values
    step = float(jumps.nu[1] - jumps.nu[0])
    # Beside a fold the motion settles ever more slowly.
    for value in (1.7234, 3.6508):
        own = located[np.abs(located - value).argmin()]
        assert np.abs(expected - own).min() < 2e-3 * step
    vanishes = jumps.attractor_change.values == FLAGS["attractor_change"]["vanishes"]
    assert vanishes.sum() == 1
    assert jumps.changed_attractor.values[vanishes] != jumps.other_attractor.values[vanishes]


def test_a_motion_that_is_followed_jumps_where_its_attractor_vanishes(jumps):
    both = vp.sweep(PAPER, over={"nu": jumps.nu.values}, follow=("nu", "both"))
    amplitude = jumps.displacement_amplitude.sel(harmonic=1)
    for way in ("up", "down"):
        own = both.displacement_amplitude.sel(harmonic=1, direction=way)
        nearest = np.abs(amplitude - own).min("attractor_id")
        assert float(nearest.max()) < 1e-9
    up, down = (
        both.displacement_amplitude.sel(harmonic=1, direction=way) for way in ("up", "down")
    )
    # Where both ways differ, two attractors coexist.
    differ = np.abs(up - down) > 0.01
    assert (jumps.basin_share.count("attractor_id").values[differ.values] >= 2).all()


def test_numbers_are_absent_where_the_attractor_is(jumps):
    absent = jumps.basin_share.isnull()
    assert absent.any()
    assert (jumps.regime.where(absent, Regime.UNRESOLVED) == Regime.UNRESOLVED).all()
    assert jumps.row_size.sum() == jumps.sizes["impact"]
    assert (jumps.row_size.where(absent, 0) == 0).all()
    for name in ("displacement_mean", "poincare_displacement", "floquet_multiplier"):
        assert jumps[name].isnull().where(absent, True).all()
        assert jumps[name].notnull().where(~absent, True).all()
    np.testing.assert_allclose(jumps.basin_share.sum("attractor_id"), 1.0)


def test_an_attractor_keeps_its_number_through_a_cascade():
    """One, two and four periods, then chaos: its states change continuously."""
    cascade = vp.basins(
        CASCADE, [0.0, 0.3], [0.0, 1.0], starts=32, over={"nu": [0.804, 0.809, 0.82, 0.83]}
    )
    multiples = cascade.period_multiple.sel(attractor_id=0).values.tolist()
    assert multiples[0] == 0
    assert multiples[1:] == [4, 2, 1]


def test_mirrored_attractors_merge_at_the_pitchforks_of_the_branch():
    start = vp.Exciter(**{**vars(PAPER), "nu": 1.0})
    pitchforks = np.unique(vp.branch(start, "nu", (0.9, 1.6)).bifurcation_nu.values.round(9))
    over = {"nu": np.linspace(1.0, 1.5, 6)}
    basins = vp.basins(PAPER, *STARTS, starts=64, over=over)
    assert basins.attractor_change.values.tolist() == [1, 0]
    assert (basins.changed_attractor == basins.changed_attractor[0]).all()
    for value in basins.bifurcation_nu.values:
        assert np.abs(pitchforks - value).min() < 2e-3 * 0.1


def test_an_impact_that_passes_the_section_is_no_jump():
    """At 3.64 an impact is at the phase of the section, where the velocity changes its sign."""
    exciters = [vp.Exciter(**{**vars(PAPER), "nu": nu}) for nu in (3.63, 3.645)]
    sets = [AttractorSet(each) for each in exciters]
    for each in sets:
        each.settle(scattered_starts(each.section.exciter, 64))
    two_sided = int(np.argmax([abs(each.sections[0, 1]) for each in sets[0].known]))
    link = carry(sets[0], two_sided, sets[1], "nu")
    assert link.jump is None
    states = [
        each.known[i].sections[0] for each, i in zip(sets, (two_sided, link.target), strict=True)
    ]
    assert states[0][1] * states[1][1] < 0


def test_threads_and_the_order_of_values_change_nothing():
    over = {"nu": [1.7, 1.9, 2.1]}
    with limit_threads(1):
        alone = vp.basins(PAPER, *STARTS, starts=64, over=over)
    assert alone.identical(vp.basins(PAPER, *STARTS, starts=64, over=over))


@pytest.mark.slow
def test_another_process_of_dask_finds_the_same():
    delayed = pytest.importorskip("dask").delayed
    arguments = {"starts": 64, "over": {"nu": [1.7, 1.9]}}
    there = delayed(vp.basins)(PAPER, *STARTS, **arguments)
    assert there.compute(scheduler="processes", num_workers=1).identical(
        vp.basins(PAPER, *STARTS, **arguments)
    )


def test_a_parameter_that_moves_the_supports():
    over = {"delta": [-0.1, 0.0, 0.1]}
    starts = np.linspace(-0.4, 0.4, 8), np.linspace(-2, 2, 8)
    at = vp.Exciter(**{**vars(PAPER), "nu": 2.5})
    basins = vp.basins(at, *starts, starts=64, over=over)
    # delta and -delta are mirror images, half a period apart.
    later = vp.basins(at, -starts[0][::-1], -starts[1][::-1], starts=64, over=over, phase=0.5)
    first, last = (
        np.sort(each.basin_share.isel(delta=k).fillna(0.0).values)
        for each, k in ((basins, 0), (later, 2))
    )
    np.testing.assert_allclose(first, last)


@pytest.mark.parametrize(
    ("over", "name", "must"),
    [
        ({"nu": [1.0, 1.0]}, "over.nu", "differ from each other"),
        ({"nu": [2.0, 1.0]}, "over.nu", "increasing numbers"),
        ({"nu": []}, "over.nu", "non-empty"),
        ({"nu": [1.0, np.inf]}, "over.nu", "finite"),
        ({"nu": [0.0, 1.0]}, "nu", "> 0"),
        ({"nu": [1.0], "f": [1.0]}, "over", "one key"),
        ({"x0": [0.0]}, "over", "one key"),
        ({}, "over", "at least one parameter"),
        ({"delta": [0.0, 0.1]}, "x0", "between the supports"),
    ],
)  # fmt: skip
def test_bad_values_are_refused(over, name, must):
    with pytest.raises(vp.ParameterError, match=must) as refused:
        vp.basins(PAPER, x0=[-0.45, 0.45], v0=[0.0], starts=8, over=over)
    assert refused.value.name == name
