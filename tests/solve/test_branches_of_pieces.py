"""Branches of orbits with soft supports or friction: against steady states, motions, other cases and closed forms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from orbit_motions import motion_of

import vibropipe as vp
from vibropipe.words.bifurcations import Bifurcation, BranchEnd

SOFT = vp.Exciter(l=0.5, nu=0.4, f=0.6, h=0.1, k1=50.0, h1=1.0, k2=800.0, h2=0.5, load=0.05)
SYMMETRIC = vp.Exciter(l=0.5, nu=0.4, f=0.3, h=0.1, k1=50.0, h1=1.0, k2=50.0, h2=1.0)
SLIDING = vp.Exciter(l=0.5, nu=0.6, f=0.6, h=0.1, R1=0.6, R2=0.6, friction=0.1)
RUBBED = vp.Exciter(l=0.5, nu=1.3, f=1.2, h=0.1, delta=0.05, R1=0.6, k2=300.0, h2=2.0, friction=0.1)
STRUCK = vp.Exciter(l=0.5, nu=1.0, f=-1.0, h=0.2, R1=0.7, R2=0.7, delta=0.01, friction=0.05)
FORCED_TWICE = vp.Exciter(
    l=0.5, nu=1.0, f=-1.0, h=0.2, R1=1.0, R2=0.7, k1=80.0, h1=2.0, friction=0.07, load=0.05, f2=0.3, phi2=0.7
)  # fmt: skip
OUTPUTS = ("harmonics", "impacts", "stability", "energy", "sensitivity")


@pytest.fixture(scope="module")
def branches():
    return {
        "soft": vp.branch(SOFT, "nu", 0.7, outputs=OUTPUTS, harmonics=3),
        "symmetric": vp.branch(SYMMETRIC, "nu", 0.9),
        "sliding": vp.branch(SLIDING, "nu", 1.0),
        "rubbed": vp.branch(RUBBED, "friction", (0.0, 0.4)),
        "forced": vp.branch(RUBBED, "f", 0.2),
    }


CASES = {
    "soft": (SOFT, "nu"),
    "symmetric": (SYMMETRIC, "nu"),
    "sliding": (SLIDING, "nu"),
    "rubbed": (RUBBED, "friction"),
    "forced": (RUBBED, "f"),
}


def kinds(branch):
    return [Bifurcation(int(kind)).name for kind in branch.bifurcation_kind]


def sampled_points(branch, mask, n=4):
    found = np.flatnonzero(mask)
    return found[np.linspace(0, found.size - 1, n).astype(int)] if found.size else found


def at_point(case, branch, i):
    exciter, along = CASES[case]
    return replace(exciter, **{along: float(branch[along][i])})


@pytest.mark.parametrize("case", CASES)
def test_stable_points_are_steady_states(branches, case):
    branch = branches[case]
    for i in sampled_points(branch, branch.stable.values == 1):
        x, v = float(branch.displacement_strobe[i]), float(branch.velocity_strobe[i])
        steady = vp.steady_state(at_point(case, branch, i), x0=x, v0=v, harmonics=1)
        multipliers = branch.floquet_multiplier[i].values
        assert int(steady.period_multiple) == int(branch.period_multiple[i])
        assert float(steady.displacement_strobe) == pytest.approx(x, abs=1e-9)
        assert float(steady.velocity_strobe) == pytest.approx(v, abs=1e-9)
        assert float(steady.displacement_amplitude[0]) == pytest.approx(
            float(branch.displacement_amplitude[i, 0]), abs=1e-9
        )
        close = 1e-4 * max(1.0, np.abs(multipliers).max())
        found = steady.floquet_multiplier.values
        # Which of a complex pair comes first is decided by rounding.
        np.testing.assert_allclose(np.sort(found.real), np.sort(multipliers.real), atol=close)
        np.testing.assert_allclose(np.sort(found.imag), np.sort(multipliers.imag), atol=close)


@pytest.mark.parametrize("case", CASES)
def test_points_are_orbits_stable_or_not(branches, case):
    branch = branches[case]
    tame = np.abs(branch.floquet_multiplier.values).max(axis=1) < 100
    points = np.concatenate(
        [sampled_points(branch, tame & (branch.stable.values == stable)) for stable in (0, 1)]
    )
    for i in points:
        exciter = at_point(case, branch, i)
        x, v = float(branch.displacement_strobe[i]), float(branch.velocity_strobe[i])
        tau_end = int(branch.period_multiple[i]) * exciter.period
        motion = vp.simulate(exciter, tau_end=tau_end, x0=x, v0=v, samples_per_period=1)
        assert float(motion.displacement[-1]) == pytest.approx(x, abs=1e-9)
        assert float(motion.velocity[-1]) == pytest.approx(v, abs=1e-8)


@pytest.mark.parametrize(
    ("exciter", "along", "to"),
    [(FORCED_TWICE, "load", 1.0), (RUBBED, "friction", 0.4), (RUBBED, "f", 0.2)],
)
def test_points_next_to_a_grazing_return_but_for_rounding(exciter, along, to):
    """Rounding is carried on by a derivative of up to 1e7 at phase 0; points that were no orbits missed it by 1e-5."""
    branch = vp.branch(exciter, along, to, harmonics=1, outputs=["stability"])
    assert np.abs(branch.floquet_multiplier.values).max() > 1e3
    assert (branch.residual.values < 1e-7).all()
    assert (branch.status.values == 0).all()


def test_multipliers_of_unstable_points_are_those_of_differences(branches):
    branch = branches["soft"]
    unstable = branch.stable.values == 0
    assert unstable.sum() > 10
    for i in sampled_points(branch, unstable, 3):
        exciter = at_point("soft", branch, i)
        x, v = float(branch.displacement_strobe[i]), float(branch.velocity_strobe[i])
        columns = []
        for step in ((1e-7, 0.0), (0.0, 1e-7)):
            ends = [
                vp.simulate(
                    exciter,
                    tau_end=exciter.period,
                    x0=x + s * step[0],
                    v0=v + s * step[1],
                    samples_per_period=1,
                )
                for s in (1, -1)
            ]
            columns.append(
                [
                    float((ends[0][name][-1] - ends[1][name][-1]) / 2e-7)
                    for name in ("displacement", "velocity")
                ]
            )
        expected = sorted(np.linalg.eigvals(np.array(columns).T), key=abs, reverse=True)
        found = branch.floquet_multiplier[i].values
        np.testing.assert_allclose(found, expected, rtol=1e-3, atol=1e-4)


def test_a_branch_turns_at_folds_and_loses_its_stability(branches):
    branch = branches["soft"]
    folds = branch.bifurcation_point.values[np.array(kinds(branch)) == "FOLD"]
    assert folds.size >= 3
    for i in folds:
        assert branch.floquet_multiplier[i, 0].values == pytest.approx(1.0, abs=1e-5)
        beside = np.sign(np.diff(branch.nu.values[i - 1 : i + 2]))
        assert beside[0] == -beside[1]


def test_a_branch_turns_back_where_other_pieces_lead_back():
    """At a contact that begins in a stick, the orbits with one more impact lead back to a fold, and then on."""
    branch = vp.branch(FORCED_TWICE, "h1", (0.0, 30.0), harmonics=1)
    assert branch.h1.values[[0, -1]].tolist() == [0.0, 30.0]
    assert (branch.end_reason.values == BranchEnd.GOES_ON).all()
    fold = branch.bifurcation_h1.values[kinds(branch).index("FOLD")]
    turns = np.flatnonzero(np.diff(branch.h1.values) < 0.0)
    assert branch.h1.values[turns[0]] - fold == pytest.approx(8.0e-6, rel=0.01)
    # At the first of them the orbit only touches the support.
    around = [turns[0] - 1, turns[-1]]
    assert branch.impacts_per_orbit.values[around].tolist() == [[1, 1], [2, 1]]
    beyond = int(np.flatnonzero(branch.h1.values > 8.6)[0])
    x, v = float(branch.displacement_strobe[beyond]), float(branch.velocity_strobe[beyond])
    steady = vp.steady_state(replace(FORCED_TWICE, h1=float(branch.h1[beyond])), x0=x, v0=v)
    assert float(steady.displacement_strobe) == pytest.approx(x, abs=1e-9)
    assert steady.impacts_per_orbit.values.tolist() == [2, 1]


def test_a_branch_goes_through_first_contacts_with_soft_supports(branches):
    """Before the first contact it is the motion in closed form, which ends where its amplitude is l."""
    branch = branches["symmetric"]
    assert kinds(branch)[:2] == ["CHANGE", "PITCHFORK"]
    touch = float(branch.bifurcation_nu[0])
    free = branch.nu.values < touch
    nu = branch.nu.values[free]
    amplitude = 0.3 / np.hypot(1 - nu**2, 0.1 * nu)
    np.testing.assert_allclose(branch.displacement_amplitude.values[free, 0], amplitude, rtol=1e-9)
    assert 0.3 / np.hypot(1 - touch**2, 0.1 * touch) == pytest.approx(0.5, abs=1e-9)
    assert (branch.impacts_per_orbit.values[~free][5:] > 0).all()


def test_sticks_end_where_steady_states_have_none(branches):
    branch = branches["sliding"]
    assert kinds(branch) == ["CHANGE", "CHANGE"]
    assert (branch.end_reason.values == BranchEnd.GOES_ON).all()
    for at in branch.bifurcation_nu.values:
        ranks = []
        for beside in (at - 1e-5, at + 1e-5):
            steady = vp.steady_state(replace(SLIDING, nu=beside))
            motion = vp.simulate(
                replace(SLIDING, nu=beside), tau_end=2 * np.pi / beside,
                x0=float(steady.displacement_strobe), v0=float(steady.velocity_strobe),
            )  # fmt: skip
            ranks.append((motion.sizes.get("turn", 0), motion.sizes.get("stick", 0)))
        assert ranks[0] != ranks[1]


def test_a_branch_over_friction_ends_without_it(branches):
    branch = branches["rubbed"]
    assert branch.friction.values[0] == 0.0
    free = vp.steady_state(replace(RUBBED, friction=0.0))
    assert float(branch.displacement_strobe[0]) == pytest.approx(
        float(free.displacement_strobe), abs=1e-9
    )
    assert branch.friction.values[-1] == pytest.approx(0.4, abs=1e-12)


@pytest.mark.parametrize(("exciter", "high"), [(STRUCK, 0.6), (FORCED_TWICE, 1.0)])
def test_a_branch_over_friction_with_turns_ends_where_these_do(exciter, high):
    """The turns between impacts end with the friction, to which the branch leads without a change."""
    branch = vp.branch(exciter, "friction", (0.0, high))
    low = branch.friction.values < 0.07
    assert branch.friction.values[0] == 0.0
    assert (np.diff(branch.friction.values[low]) > 0.0).all()
    assert (branch.bifurcation_friction.values > 1e-3).all()
    assert BranchEnd.CLOSED not in branch.end_reason.values
    assert (branch.residual.values[low] < 1e-12).all()
    x, v = float(branch.displacement_strobe[0]), float(branch.velocity_strobe[0])
    free = vp.steady_state(replace(exciter, friction=0.0), x0=x, v0=v)
    assert float(free.displacement_strobe) == pytest.approx(x, abs=1e-9)
    assert float(free.velocity_strobe) == pytest.approx(v, abs=1e-9)


def test_doubled_orbits_are_followed_from_a_flip():
    branch = vp.branch(RUBBED, "friction", 0.29, switch=["flip"])
    doubled = branch.branch_id.values == 1
    flip = float(branch.bifurcation_friction[kinds(branch).index("FLIP")])
    assert (branch.period_multiple.values[doubled] == 2).all()
    assert np.abs(branch.friction.values[doubled] - flip).min() < 1e-6
    stable = np.flatnonzero(doubled & (branch.stable.values == 1))
    i = int(stable[stable.size // 2])
    x, v = float(branch.displacement_strobe[i]), float(branch.velocity_strobe[i])
    exciter = replace(RUBBED, friction=float(branch.friction[i]))
    steady = vp.steady_state(exciter, x0=x, v0=v)
    assert int(steady.period_multiple) == 2
    assert float(steady.displacement_strobe) == pytest.approx(x, abs=1e-9)


def test_asymmetric_orbits_are_mirror_images_from_a_pitchfork():
    branch = vp.branch(SYMMETRIC, "nu", 0.8, switch=["pitchfork"])
    sides = [branch.branch_id.values == side for side in (1, 2)]
    means = [branch.displacement_mean.values[side] for side in sides]
    assert min(side.sum() for side in sides) > 5
    assert np.abs(means[0]).max() > 1e-3
    # Each point of one side has its mirror image close to a point of the other, whose points lie elsewhere.
    curves = [
        np.stack([branch.nu.values[side], mean], axis=1)
        for side, mean in zip(sides, means, strict=True)
    ]
    mirrored = curves[1] * [1.0, -1.0]
    for point in curves[0]:
        assert np.abs(mirrored - point).max(axis=1).min() < 0.01


def test_a_pitchfork_lies_at_one_place_along_every_parameter():
    # friction, as the frequency, the force, the damping and the gap, leaves a symmetric exciter symmetric
    exciter = vp.Exciter(l=0.5, nu=1.8, f=1.0, h=0.05, R1=0.8, R2=0.8, friction=0.02)
    over_nu = vp.branch(exciter, "nu", (1.5, 2.0), v0=1.0, harmonics=1)
    assert kinds(over_nu) == ["PITCHFORK"]
    nu = over_nu.bifurcation_nu.item()
    strobe = over_nu.isel(point=int(np.abs(over_nu.nu.values - nu).argmin()))
    start = {"x0": strobe.displacement_strobe.item(), "v0": strobe.velocity_strobe.item()}
    for along, value in {"friction": 0.02, "h": 0.05, "f": 1.0}.items():
        near = replace(exciter, nu=nu, **{along: 1.02 * value})
        found = vp.branch(near, along, (0.9 * value, 1.1 * value), harmonics=1, **start)
        assert kinds(found) == ["PITCHFORK"]
        assert found[f"bifurcation_{along}"].item() == pytest.approx(value, rel=1e-9)
    curve = vp.boundary(
        replace(exciter, nu=nu),
        "pitchfork",
        ("nu", "friction"),
        ((1.4, 1.7), (0.01, 0.03)),
        lines=3,
    )
    order = np.argsort(curve.friction.values)
    at = np.interp(0.02, curve.friction.values[order], curve.nu.values[order])
    assert at == pytest.approx(nu, abs=1e-5)


def test_folds_tend_to_those_of_a_rigid_exciter():
    rigid = vp.Exciter(l=0.5, nu=0.45, f=0.6, h=0.1, R1=1.0, R2=0.6)
    at = []
    for exciter in (rigid, *(replace(rigid, k1=k) for k in (1e6, 1e8))):
        branch = vp.branch(exciter, "nu", 0.9)
        at.append(float(branch.bifurcation_nu[kinds(branch).index("FOLD")]))
    errors = [abs(each - at[0]) for each in at[1:]]
    # towards the rigid support as 1/sqrt(k)
    assert errors[1] == pytest.approx(0.1 * errors[0], rel=0.2)
    assert errors[1] < 1e-3


def test_sensitivities_are_slopes_of_the_branch(branches):
    branch = branches["soft"]
    middle = slice(3, 8)
    nu, amplitude = branch.nu.values[middle], branch.displacement_amplitude.values[middle, 0]
    slope = branch.displacement_amplitude_sensitivity.sel(parameter="nu").values[middle, 0]
    by_points = np.gradient(amplitude, nu)
    assert slope[2] == pytest.approx(by_points[2], rel=0.02)


def test_wanted_values_are_points(branches):
    branch = vp.branch(SOFT, "nu", 0.42, at=[0.405, 0.4125])
    assert {0.405, 0.4125} <= set(branch.nu.values.tolist())


def test_errors_are_stated(branches):
    branch = branches["soft"]
    # Close to a fold an orbit is hardly isolated.
    tame = np.abs(branch.floquet_multiplier.values).max(axis=1) < 0.9
    # An orbit that only touches has no derivative.
    tame[branch.bifurcation_point.values] = False
    error = branch.displacement_strobe_error.values[tame]
    assert tame.sum() > 100
    assert (error < 1e-11).all()


def test_a_branch_over_a_stiffness_does_not_end_at_a_rigid_support():
    with pytest.raises(vp.ParameterError, match="0 stands for a rigid support"):
        vp.branch(replace(SOFT, h1=0.0), "k1", 0.0)
    with pytest.raises(vp.ParameterError, match="0 stands for a rigid support"):
        vp.branch(replace(SOFT, k1=0.0, h1=0.0), "k1", 10.0)


def test_a_branch_over_friction_begins_without_it():
    free = replace(RUBBED, friction=0.0)
    branch = vp.branch(free, "friction", 0.2)
    steady = vp.steady_state(RUBBED)
    at = np.abs(branch.friction.values - 0.1).argmin()
    assert branch.friction.values[[0, -1]].tolist() == [0.0, 0.2]
    assert kinds(branch) == []
    assert float(branch.displacement_amplitude[at, 0]) == pytest.approx(
        float(steady.displacement_amplitude[0]), abs=0.01
    )


def test_what_does_not_repeat_is_refused():
    with pytest.raises(vp.ParameterError, match="must lead from"):
        vp.branch(replace(SOFT, h=0.0, h1=0.0, h2=0.0, f=0.0), "nu", 0.7, x0=0.2)


def test_orbits_of_two_periods_end_where_their_halves_agree():
    exciter = vp.Exciter(
        l=0.5, nu=0.894, f=0.78125, h=0.237, R2=0.6, k1=100, h1=2.37, load=-0.0524, friction=0.03125
    )
    branch = vp.branch(exciter, "nu", (0.88, 1.1))
    assert (branch.period_multiple == 2).all()
    # The orbits of one period beyond solve the same equations, and were taken for orbits of two.
    assert branch.nu.max() < 1.03
    assert vp.steady_state(replace(exciter, nu=1.05)).period_multiple == 1
    for n in range(0, branch.sizes["point"], 8):
        point = branch.isel(point=n)
        at, start = replace(exciter, nu=float(point.nu)), float(point.displacement_strobe)
        motion = vp.simulate(at, at.period, x0=start, v0=float(point.velocity_strobe))
        assert abs(float(motion.displacement_end) - start) > 1e-6


@pytest.mark.parametrize(
    ("exciter", "laws"),
    [
        (vp.Exciter(l=0.5214, nu=2.1928, f=0.99266, h=0.20554, delta=0.14669, k1=44.25131, h1=0.75633,
                    k2=44.25131, h2=0.75633, friction=0.09576), {(0, 1), (1, 1)}),
        (vp.Exciter(l=0.5552, nu=1.68232, f=0.35079, h=0.16008, delta=-0.07813, k1=161.24821, h1=1.07281,
                    k2=161.24821, h2=1.07281, friction=0.1455), {(0, 0), (1, 0), (1, 1)}),
        (vp.Exciter(l=0.42256, nu=1.93247, f=0.81992, h=0.09679, delta=-0.01956, k1=4485.05109, h1=14.24276,
                    k2=4485.05109, h2=14.24276, friction=0.10952), {(2, 1), (2, 2)}),
    ],
)  # fmt: skip
def test_branches_go_on_where_a_mass_turns_against_friction_as_it_touches_a_soft_support(
    exciter, laws
):
    """There are four ways to enter and to leave with the signs of both speeds free, of which one is a motion."""
    branch = vp.branch(exciter, "nu", (0.6, 2.2), harmonics=1, outputs=["impacts", "stability"])
    assert set(branch.nu.values[[0, -1]].tolist()) <= {0.6, 2.2}
    assert (branch.end_reason.values == BranchEnd.GOES_ON).all()
    assert laws <= set(map(tuple, branch.impacts_per_orbit.values.astype(int).tolist()))
    for i in range(0, branch.sizes["point"], 7):
        if np.abs(branch.floquet_multiplier.values[i]).max() > 100:
            continue  # rounding of the start grows as much
        there = replace(exciter, nu=float(branch.nu[i]))
        x, v = float(branch.displacement_strobe[i]), float(branch.velocity_strobe[i])
        span = int(branch.period_multiple[i]) * there.period
        motion = vp.simulate(there, tau_end=span, x0=x, v0=v)
        assert float(motion.displacement_end) == pytest.approx(x, abs=1e-9)
        assert float(motion.velocity_end) == pytest.approx(v, abs=1e-8)


@pytest.mark.parametrize(
    ("exciter", "parent"),
    [
        (vp.Exciter(l=0.45505, nu=1.11686, f=0.3502, h=0.25408, delta=-0.03617, R1=0.88937, R2=0.695,
                    friction=0.09471), [1, 0]),
        (vp.Exciter(l=0.61898, nu=1.10195, f=1.06281, h=0.24928, delta=-0.11126, R1=0.78343, R2=0.84131,
                    friction=0.03762), [1, 1]),
    ],
)  # fmt: skip
def test_orbits_of_two_periods_that_graze_end_at_those_of_one(exciter, parent):
    """One touch in two periods is lost; what is left repeats after one."""
    branch = vp.branch(exciter, "nu", (0.6, 2.2), harmonics=1)
    changes = branch.bifurcation_kind.values == Bifurcation.CHANGE
    (end,) = np.flatnonzero(changes & (branch.end_reason.values == BranchEnd.PARENT))
    point = branch.isel(point=int(branch.bifurcation_point[end]))
    there = replace(exciter, nu=float(point.nu))
    assert int(point.period_multiple) == 2
    motion = motion_of(there, point.assign(period_multiple=1))
    assert float(motion.displacement_end) == pytest.approx(
        float(point.displacement_strobe), abs=1e-7
    )
    hard = np.abs(motion.impact_velocity.values) > 1e-6
    assert [(motion.impact_support.values[hard] == s).sum() for s in (1, 2)] == parent


def random_exciter(rng, kind):
    """Return an exciter with soft supports, friction, or both."""
    low = {"l": 0.3, "nu": 0.6, "f": 0.2, "h": 0.05, "delta": -0.15}
    high = {"l": 0.7, "nu": 2.2, "f": 1.2, "h": 0.3, "delta": 0.15}
    values = dict(zip(low, rng.uniform([*low.values()], [*high.values()]), strict=True))
    if kind == "friction":
        values |= dict(zip(("R1", "R2"), rng.uniform(0.4, 0.9, 2), strict=True))
    else:
        k, z = 10 ** rng.uniform(1, 4), rng.uniform(0.02, 0.25)
        values |= {"k1": k, "k2": k, "h1": 2 * z * np.sqrt(k), "h2": 2 * z * np.sqrt(k)}
    if kind != "soft":
        values["friction"] = rng.uniform(0.01, 0.15)
    return vp.Exciter(**values)


def drawn(seed, number):
    """Return one of the random exciters of `test_all_ends_of_laws_are_passed`."""
    rng = np.random.default_rng(seed)
    made = [random_exciter(rng, ("soft", "friction", "both")[n % 3]) for n in range(number + 1)]
    return made[number]


@pytest.mark.parametrize(
    ("seed", "number", "ends"),
    [
        # a chatter with friction, whose laws follow each other ever faster until it rests
        (8, 13, []),
        # the stick of a doubled orbit vanishes where it becomes its parent
        (10, 4, [BranchEnd.PARENT] * 2),
        # a contact against friction that begins with a cusp
        (11, 32, []),
    ],
)
def test_rare_ends_of_laws_are_passed(seed, number, ends):
    exciter = drawn(seed, number)
    branch = vp.branch(exciter, "nu", (0.6, 2.2), switch=("grazing", "pitchfork"), harmonics=1)
    reasons = branch.end_reason.values
    assert reasons[reasons != 0].tolist() == ends
    for point in range(0, branch.sizes["point"], 5):
        row = branch.isel(point=point)
        there = replace(exciter, nu=float(row.nu))
        motion = motion_of(there, row)
        assert float(motion.displacement_end) == pytest.approx(
            float(row.displacement_strobe), abs=1e-7
        )
        assert float(motion.velocity_end) == pytest.approx(float(row.velocity_strobe), abs=1e-7)


@pytest.mark.slow
def test_all_ends_of_laws_are_passed():
    tried, left = 0, 0
    for seed in range(7, 12):
        rng = np.random.default_rng(seed)
        for number in range(40):
            exciter = random_exciter(rng, ("soft", "friction", "both")[number % 3])
            try:
                branch = vp.branch(
                    exciter, "nu", (0.6, 2.2), switch=("grazing", "pitchfork"), harmonics=1
                )
            except vp.ParameterError:  # the motion does not repeat
                continue
            tried += 1
            left += np.isin(
                branch.end_reason.values, [BranchEnd.OTHER_SEQUENCE, BranchEnd.LOST]
            ).any()
    assert tried == 195
    assert left == 0


def test_a_branch_between_two_flips_is_followed_once() -> None:
    """Orbits of 16 periods lead from one flip to another of the same orbits, through changes of their law."""
    exciter = vp.Exciter(l=0.5, nu=1.6, f=0.9, h=0.05, delta=0.05, R1=0.8, R2=0.75, friction=0.05)
    found = vp.branch(exciter, "nu", (1.2, 1.7), switch=("flip",))
    ends = []
    for number in np.unique(found.branch_id):
        nu = found.nu.values[found.branch_id.values == number]
        ends.append(tuple(sorted((round(float(nu[0]), 7), round(float(nu[-1]), 7)))))
    assert (1.2219825, 1.2379721) in ends
    assert len(set(ends)) == len(ends)


def test_a_branch_ends_where_its_orbits_are_those_of_a_period_wherever_it_begins() -> None:
    """Orbits of four periods end as an orbit of one period touches support 2, where others of four begin."""
    exciter = vp.Exciter(
        l=0.5, nu=0.966, f=1.056, h=0.221, delta=-0.06, R2=0.86, k1=48.5, h1=0.574, contact_1="no_pull"
    )  # fmt: skip
    of_one = vp.branch(replace(exciter, delta=0.09), "delta", (-0.1, 0.1), harmonics=1)
    expected = float(of_one.bifurcation_delta[kinds(of_one).index("CHANGE")])
    for x0, v0 in ((-0.52, -0.0416), (-0.52015542, -0.04163645)):
        branch = vp.branch(exciter, "delta", (-0.1, -0.05), x0=x0, v0=v0, harmonics=1)
        assert (branch.period_multiple == 4).all()
        assert kinds(branch) == ["CHANGE", "FLIP", "CHANGE", "FLIP", "FOLD", "CHANGE"]
        assert branch.bifurcation_delta.values[[0, -1]] == pytest.approx(expected, abs=1e-9)
        assert set(branch.end_reason.values[[0, -1]]) == {BranchEnd.PARENT}
