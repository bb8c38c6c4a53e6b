"""Attractors and basins, against marches of every start far beyond its transient, and by symmetries."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sampling import sampled
from scipy.stats import binomtest

import vibropipe as vp
from vibropipe.lab.bench_items import limit_threads
from vibropipe.orbits.basins import LINES
from vibropipe.solve.basins.attractor_set import SAME_ORBIT, AttractorSet, visited_cells
from vibropipe.solve.basins.attractors import reachable_velocity, scattered_starts, shares
from vibropipe.solve.basins.basins import border_starts
from vibropipe.solve.basins.neighbourhood import trapping_ellipse
from vibropipe.solve.basins.section_map import SectionMap
from vibropipe.words.regimes import Regime

PERIODS = 3000
THREE = vp.Exciter(l=0.5, nu=3.48, f=0.7, h=0.1, delta=0.1, R1=0.8, R2=0.8)
SYMMETRIC = vp.Exciter(l=0.5, nu=1.61, f=1.66, h=0.02, R1=0.8, R2=0.8)
CHAOS = vp.Exciter(l=0.5, nu=0.8, f=1.67, h=0.1, delta=0.1, R1=0.8, R2=0.8)
TWO_CHAOTIC = vp.Exciter(l=0.5, nu=1.57, f=1.79, h=0.0688, R1=0.4447, R2=0.4447)
RARE = vp.Exciter(l=0.5, nu=1.15, f=0.4, h=0.05, R1=0.8, R2=0.8)
# The law of motion depends on the start in a fractal way: transients are chaotic.
FRACTAL = vp.Exciter(l=0.5, nu=1.24, f=1.29, h=0.05, R1=0.9, R2=0.9)
# The attractors of each by period multiple, 0 without an orbit.
MULTIPLES = {THREE: [1, 1, 3], SYMMETRIC: [1, 1, 2, 2], CHAOS: [2, 0], RARE: [1, 3]}


def grid_of(exciter, n, velocity=3.0):
    """Return displacements and velocities of a grid, which the supports bound."""
    return np.linspace(exciter.lower, exciter.upper, n), np.linspace(-velocity, velocity, n)


def state_after(exciter, x, v, periods, phase=0.0):
    """Return the state at the section so many periods later, by marching the motion to it."""
    begin, end = phase * exciter.period, periods * exciter.period
    motion = vp.simulate(exciter, tau_start=begin, tau_end=end, x0=x, v0=v, samples_per_period=0)
    return np.array([motion.displacement_end.item(), motion.velocity_end.item()])


def distances(basins, state):
    """Return the distance of a state from the states of each attractor at the section."""
    dx = np.abs(basins.poincare_displacement.values - state[0])
    dv = np.abs(basins.poincare_velocity.values - state[1])
    return np.maximum(dx, dv).min(axis=1)


def wrong_starts(basins, exciter, chosen, phase=0.0):
    """Return the starts whose motion, marched on, ends elsewhere than on their attractor."""
    wrong = []
    for i, j in chosen:
        x, v = basins.x0.values[i], basins.v0.values[j]
        own = int(basins.attractor[i, j])
        away = distances(basins, state_after(exciter, x, v, PERIODS, phase))
        # An attractor without an orbit has no point that returns: none of the orbits may be near.
        orbits = basins.period_multiple.values > 0
        on_orbit = own >= 0 and orbits[own] and away[own] < 1e-6
        in_chaos = own >= 0 and not orbits[own] and (away[orbits] > 1e-6).all()
        if not (on_orbit or in_chaos):
            wrong.append((x, v, own, away))
    return wrong


@pytest.mark.parametrize("exciter", sampled(MULTIPLES, THREE, CHAOS))
def test_starts_settle_on_their_attractor(exciter):
    basins = vp.basins(exciter, *grid_of(exciter, 40))
    assert basins.period_multiple.values.tolist() == MULTIPLES[exciter]
    chosen = np.random.default_rng(1).integers(0, 40, (60, 2))
    assert not wrong_starts(basins, exciter, chosen)
    # Beside borders a start is most easily taken for another one.
    at_border = np.argwhere(basins.border.values)
    assert not wrong_starts(basins, exciter, at_border[:: max(1, len(at_border) // 60)])


def test_phase_of_the_start():
    basins = vp.basins(THREE, *grid_of(THREE, 15), phase=0.3)
    assert basins.start_phase == 0.3
    chosen = np.argwhere(np.ones((15, 15)))[::5]
    assert not wrong_starts(basins, THREE, chosen, phase=0.3)


@pytest.mark.slow
def test_half_a_period_later_a_symmetric_exciter_is_its_mirror():
    """x -> -x and tau -> tau + T/2 map motions to motions; attractors that are not their own mirrors change places."""
    xs, vs = grid_of(SYMMETRIC, 40)
    now = vp.basins(SYMMETRIC, xs, vs)
    later = vp.basins(SYMMETRIC, -xs[::-1], -vs[::-1], phase=0.5)
    np.testing.assert_array_equal(
        later.period_multiple.values[later.attractor.values[::-1, ::-1]],
        now.period_multiple.values[now.attractor.values],
    )
    same = later.attractor.values[::-1, ::-1] == now.attractor.values
    doubled = now.period_multiple.values[now.attractor.values] == 2
    assert doubled.sum() > 500
    # The one with three impacts on support 1 settles where its mirror does later, and the other way round.
    strikes = [each.impacts_per_orbit.values for each in (now, later)]
    first, second = (
        count[each.attractor.values] for count, each in zip(strikes, (now, later), strict=True)
    )
    np.testing.assert_array_equal(first, second[::-1, ::-1][..., ::-1])
    assert not same[doubled].all()


@pytest.mark.parametrize("exciter", sampled([THREE, SYMMETRIC]))
def test_a_mirrored_exciter_has_mirrored_basins(exciter):
    xs, vs = grid_of(exciter, 40)
    basins = vp.basins(exciter, xs, vs)
    mirror = vp.basins(exciter.mirrored(), -xs[::-1], -vs[::-1])
    counts = [each.impacts_per_orbit.values[each.attractor.values] for each in (basins, mirror)]
    np.testing.assert_array_equal(counts[0], counts[1][::-1, ::-1][..., ::-1])
    np.testing.assert_array_equal(basins.border, mirror.border[::-1, ::-1])
    np.testing.assert_allclose(sorted(basins.basin_share), sorted(mirror.basin_share))


@pytest.mark.parametrize("exciter", sampled([THREE, CHAOS]))
def test_a_refined_grid_keeps_its_starts(exciter):
    xs, vs = grid_of(exciter, 41)
    fine, coarse = vp.basins(exciter, xs, vs), vp.basins(exciter, xs[::4], vs[::4])
    np.testing.assert_array_equal(fine.attractor[::4, ::4], coarse.attractor)
    np.testing.assert_array_equal(fine.periods_to_attractor[::4, ::4], coarse.periods_to_attractor)


def test_threads_change_nothing():
    with limit_threads(1):
        alone = vp.basins(SYMMETRIC, *grid_of(SYMMETRIC, 40))
    assert alone.identical(vp.basins(SYMMETRIC, *grid_of(SYMMETRIC, 40)))


def test_starts_on_a_support():
    """Leaving it, pressed into it, and at rest on it, where the force holds the mass or not."""
    xs, vs = np.array([CHAOS.lower, CHAOS.upper]), np.array([-1.0, 0.0, 1.0])
    basins = vp.basins(CHAOS, xs, vs)
    assert (basins.attractor >= 0).all()
    basins = vp.basins(THREE, [THREE.lower, 0.0, THREE.upper], vs)
    assert not wrong_starts(basins, THREE, [(i, j) for i in range(3) for j in range(3)])
    nearly = np.nextafter(THREE.upper, 1.0)
    assert vp.basins(THREE, [nearly], [0.0]).attractor.item() == basins.attractor[2, 1]


@pytest.mark.parametrize(
    ("name", "value", "must"),
    [
        ("x0", [0.0, 0.7], "between the supports"),
        ("x0", [-0.5, 0.0], "between the supports"),
        ("x0", [np.inf], "increasing finite numbers"),
        ("x0", [], "increasing finite numbers"),
        ("x0", ["a"], "increasing finite numbers"),
        ("v0", [0.0, np.nan], "increasing finite numbers"),
        ("v0", [1.0, 0.0], "increasing finite numbers"),
        ("v0", [1.0, 1.0], "increasing finite numbers"),
        ("v0", [[1.0], [2.0]], "increasing finite numbers"),
        ("phase", 1.5, "from 0 to 1"),
        ("starts", 0, "a whole number from 1"),
        ("harmonics", 0, "a whole number from 1"),
    ],
)
def test_bad_arguments_are_refused(name, value, must):
    arguments = {"x0": [0.0], "v0": [0.0], name: value}
    with pytest.raises(vp.ParameterError, match=must) as refused:
        vp.basins(THREE, **arguments)
    assert refused.value.name == name


@pytest.mark.parametrize("exciter", sampled([THREE, SYMMETRIC]))
def test_attractors_are_the_steady_states_of_their_section_points(exciter):
    found = vp.attractors(exciter)
    assert found.period_multiple.values.tolist() == MULTIPLES[exciter]
    first = 0
    for index in found.attractor_id.values:
        row = found.isel(attractor_id=index)
        x, v = (
            row[f"poincare_{name}"].values[-row.period_multiple.item()]
            for name in ("displacement", "velocity")
        )
        alone = vp.steady_state(exciter, x0=x, v0=v)
        for name in ("displacement_amplitude", "floquet_multiplier", "impacts_per_orbit", "regime"):
            np.testing.assert_allclose(row[name], alone[name], rtol=1e-9, atol=1e-12)
        stop = first + row.row_size.item()
        np.testing.assert_allclose(found.impact_velocity[first:stop], alone.impact_velocity)
        first = stop
    assert first == found.sizes["impact"]
    assert found.basin_share.sum() == pytest.approx(1)
    assert (abs(found.floquet_multiplier) < 1).all()


def test_a_linear_motion_is_the_only_attractor():
    exciter = vp.Exciter(l=0.5, nu=2.0, f=0.3, h=0.15, R1=0.7, R2=0.6)
    basins = vp.basins(exciter, *grid_of(exciter, 10))
    amplitude = abs(exciter.f / (1 - exciter.nu**2 + 1j * exciter.h * exciter.nu))
    own = basins.displacement_amplitude.sel(harmonic=1).values
    assert own[basins.regime.values == Regime.NO_IMPACT] == pytest.approx(amplitude, rel=1e-12)


@pytest.mark.parametrize(("delta", "place"), [(0.0, 0.0), (0.2, 0.0), (0.8, 0.3), (-0.8, -0.3)])
def test_without_force_the_mass_comes_to_its_equilibrium(delta, place):
    """Or to the support that keeps it from there."""
    found = vp.attractors(vp.Exciter(l=0.5, h=0.1, delta=delta, R1=0.6, R2=0.6), starts=64)
    assert found.basin_share.values.tolist() == [1.0]
    assert found.poincare_displacement.values[0, 0] == pytest.approx(place, abs=1e-12)


def test_without_loss_nothing_is_an_attractor():
    found = vp.attractors(vp.Exciter(l=0.5, f=0.3, nu=1.3), starts=32)
    assert found.sizes["attractor_id"] == 0
    starts = [0.0, 0.1], [0.0, 1.0]
    basins = vp.basins(vp.Exciter(l=0.5), *starts, starts=32)
    assert (basins.attractor == -1).all()
    assert vp.table(found).empty
    # What there is of attractors elsewhere is there too, and as large as nothing.
    over = {"nu": [1.0, 1.1]}
    for one, other in (
        (basins, vp.basins(SYMMETRIC, *starts, starts=32)),
        (
            vp.basins(vp.Exciter(l=0.5), *starts, starts=32, over=over),
            vp.basins(SYMMETRIC, *starts, starts=32, over=over),
        ),
    ):
        assert one.sizes["attractor_id"] == 0 < other.sizes["attractor_id"]
        assert {name: one[name].dims for name in one} == {name: other[name].dims for name in other}


def test_chaos_is_one_attractor():
    """Told apart from its mirror and from orbits by the cells that it visits."""
    found = AttractorSet(TWO_CHAOTIC)
    starts = scattered_starts(TWO_CHAOTIC, 256)
    owner, _periods = found.settle(starts)
    chaotic = [i for i, each in enumerate(found.known) if each.period_multiple == 0]
    assert len(chaotic) == 2
    means = [found.known[i].sections.mean(axis=0) for i in chaotic]
    assert np.abs(means[0] - means[1]).max() > 0.1
    for i in chaotic:
        for start in starts[owner == i][:5]:
            late = found.section.sections(start, 2 * PERIODS)[PERIODS:]
            # What a motion visits has the mean of its own attractor.
            away = [np.abs(late.mean(axis=0) - mean).max() for mean in means]
            assert np.argmin(away) == chaotic.index(i)


def test_cells_of_chaos_lie_in_its_bands_only():
    """An orbit of sixteen periods lies between the bands of a chaotic attractor, which larger cells would cover."""
    exciter = vp.Exciter(
        l=0.5, nu=4.166748372224837, f=0.5001451024297454, h=0.01187763906691566,
        delta=0.14085167901685774, R1=0.5700537667234751, R2=0.5707369748637972,
    )  # fmt: skip
    basins = vp.basins(exciter, *grid_of(exciter, 20), starts=512)
    assert basins.period_multiple.values.tolist() == [1, 16, 0]
    shares = basins.basin_share.values
    assert 0.5 < shares[1] / shares[2] < 2
    assert not wrong_starts(basins, exciter, np.argwhere(basins.attractor.values > 0)[::4])


def test_visited_cells_are_as_fine_as_their_number_allows():
    generator = np.random.default_rng(3)
    sections = np.concatenate([generator.normal(at, 1e-4, (30000, 2)) for at in (-1.0, 0.3)])
    cells, corner, scale = visited_cells(sections)
    assert 500 < cells.size <= 2048
    column, line = ((sections - corner) * scale).astype(np.int64).T
    np.testing.assert_array_equal(np.unique(column * LINES + line), cells)


def test_a_fractal_border():
    """Half the starts lie at a border, as many on a grid three times as fine."""
    coarse, fine = (
        vp.basins(FRACTAL, np.linspace(-0.4, -0.3, n), np.linspace(0, 0.1, n)) for n in (10, 30)
    )
    assert coarse.period_multiple.values.tolist() == [1, 1]
    assert coarse.border.mean() > 0.5
    assert fine.border.mean() > 0.5


@given(
    nu=st.floats(1.5, 5.0), f=st.floats(0.1, 2.5), h=st.floats(0.03, 0.3),
    delta=st.floats(-0.2, 0.2), R1=st.floats(0.3, 0.9), R2=st.floats(0.3, 0.9),
)  # fmt: skip
@settings(max_examples=5, deadline=None)
def test_no_start_of_random_exciters_is_mistaken(nu, f, h, delta, R1, R2):
    exciter = vp.Exciter(l=0.5, nu=nu, f=f, h=h, delta=delta, R1=R1, R2=R2)
    basins = vp.basins(exciter, *grid_of(exciter, 12), starts=64)
    chosen = np.argwhere(basins.periods_to_attractor.values < 1000)[::9]
    assert not wrong_starts(basins, exciter, chosen)


@pytest.mark.parametrize("exciter", sampled([THREE, SYMMETRIC, RARE], RARE))
def test_motions_in_a_neighbourhood_stay_and_settle(exciter):
    section = SectionMap(exciter)
    found = AttractorSet(exciter)
    found.settle(scattered_starts(exciter, 64))
    generator = np.random.default_rng(2)
    for attractor in found.known:
        m = attractor.period_multiple
        for point in attractor.sections:
            ellipse = trapping_ellipse(section, point, m)
            axes = np.linalg.inv(np.linalg.cholesky(ellipse.shape))
            inside = generator.normal(size=(500, 2))
            inside *= (generator.random(500) ** 0.5 / np.linalg.norm(inside, axis=1))[:, None]
            states = point + inside @ axes
            for _ in range(40):
                states, _contacts = section.images(states, m)
                offsets = states - point
                assert (np.einsum("ni,ij,nj->n", offsets, ellipse.shape, offsets) <= 1).all()
            assert np.abs(offsets / section.scale).max() < 0.1


def test_orbits_found_twice_are_one():
    found = AttractorSet(THREE)
    found.settle(scattered_starts(THREE, 64))
    n = len(found.known)
    for index, attractor in enumerate(found.known):
        for point in attractor.sections:
            assert found._orbit(point * (1 + 1e-3 * SAME_ORBIT), attractor.period_multiple) == index
    assert len(found.known) == n


def test_shares_have_wilson_intervals():
    counts = np.array([0, 3, 50, 97, 100])
    share, low, high = shares(counts, 100)
    for k, values in zip(counts, zip(share, low, high, strict=True), strict=True):
        interval = binomtest(int(k), 100).proportion_ci(method="wilson")
        np.testing.assert_allclose(values, (k / 100, *interval), rtol=1e-12, atol=1e-15)


def test_borders_lie_on_both_sides():
    attractor = np.array([[0, 0, 1], [0, 0, 0], [2, 0, 0]])
    expected = [[0, 1, 1], [1, 0, 1], [1, 1, 0]]
    np.testing.assert_array_equal(border_starts(attractor), expected)


def test_scattered_starts_fill_the_reachable_states():
    starts = scattered_starts(THREE, 256)
    velocity = reachable_velocity(THREE)
    scaled = (starts - [THREE.lower, -velocity]) / [2 * THREE.l, 2 * velocity]
    counts, *_edges = np.histogram2d(*scaled.T, bins=8, range=[[0, 1], [0, 1]])
    assert counts.sum() == 256
    assert counts.min() >= 2


def test_velocities_within_a_period_stay_below_the_reachable_one():
    motion = vp.simulate(THREE, tau_end=THREE.period, x0=THREE.upper)
    assert abs(motion.velocity).max() <= reachable_velocity(THREE)
