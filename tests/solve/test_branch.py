"""Branches: bifurcations against the sign of their test functions, sweeps, mirrored and reversed branches."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import vibropipe as vp
from vibropipe.words.bifurcations import Bifurcation, BranchEnd
from vibropipe.words.regimes import Regime
from vibropipe.words.status import Status

SYMMETRIC = vp.Exciter(l=0.5, nu=1.0, f=1.0, h=0.1, R1=0.8, R2=0.8)
SKEW = vp.Exciter(l=0.5, nu=2.0, f=1.0, h=0.1, delta=0.2, R1=0.8, R2=0.7)
FOLD, FLIP, PITCHFORK, GRAZING, END = list(Bifurcation)[:5]
KINDS = ("flip", "pitchfork", "grazing")


@pytest.fixture(scope="module")
def symmetric():
    return vp.branch(SYMMETRIC, "nu", (0.3, 3.0), at=[1.25, 2.0], switch=["pitchfork"])


@pytest.fixture(scope="module")
def skew():
    return vp.branch(SKEW, "nu", (0.3, 5.0), switch=["grazing"])


def bifurcations(branch, along="nu"):
    """(kind, parameter, reason) of every bifurcation."""
    values = branch[f"bifurcation_{along}"].values
    return [
        (Bifurcation(int(kind)), value, BranchEnd(int(reason)))
        for kind, value, reason in zip(
            branch.bifurcation_kind.values, values, branch.end_reason.values, strict=True
        )
    ]


def moduli(branch):
    return np.abs(branch.floquet_multiplier.values)


def test_every_point_is_an_orbit_with_balanced_energy(symmetric, skew) -> None:
    for branch in (symmetric, skew):
        assert (branch.status == Status.OK).all()
        assert branch.residual.max() < 1e-12
        assert abs(branch.energy_residual).max() < 1e-11
        assert branch.row_size.sum() == branch.sizes["impact"]


def test_the_origin_is_that_of_other_datasets(symmetric) -> None:
    sweep = vp.sweep(SYMMETRIC, {"nu": [2.0, 2.1]}, follow=("nu", "up"))
    assert set(symmetric.attrs) - {"switch"} == set(sweep.attrs)
    assert symmetric.attrs["version"] == vp.__version__


def test_stable_points_are_steady_states(symmetric, skew) -> None:
    for branch, exciter in ((symmetric, SYMMETRIC), (skew, SKEW)):
        stable = np.flatnonzero((moduli(branch)[:, 0] < 0.9) & (branch.regime != Regime.NO_IMPACT))
        # At a grazing rounding decides whether the mass is struck.
        stable = np.setdiff1d(stable, branch.bifurcation_point.values)
        for i in stable[:: max(1, stable.size // 12)]:
            point = branch.isel(point=int(i))
            moved = vp.Exciter(**{**vars(exciter), "nu": float(point.nu)})
            x0, v0 = float(point.displacement_strobe), float(point.velocity_strobe)
            state = vp.steady_state(moved, x0, v0)
            names = [
                "displacement_amplitude",
                "impacts_per_orbit",
                "impact_velocity_max",
                "energy_input",
            ]
            if point.period_multiple == 1:  # else the section may be that of another period
                names += ["displacement_strobe", "velocity_strobe"]
            for name in names:
                assert point[name].values == pytest.approx(
                    state[name].values, abs=1e-11, nan_ok=True
                )
            # Multipliers amplify rounding where an impact is slow.
            assert np.sum(point.floquet_multiplier.values) == pytest.approx(
                np.sum(state.floquet_multiplier.values), abs=1e-9
            )


def test_multipliers_are_those_of_differences_of_the_return_map(symmetric) -> None:
    unstable = np.flatnonzero((moduli(symmetric)[:, 0] > 1.05) & (moduli(symmetric)[:, 0] < 5))
    for i in unstable[:: max(1, unstable.size // 6)]:
        point = symmetric.isel(point=int(i))
        moved = vp.Exciter(**{**vars(SYMMETRIC), "nu": float(point.nu)})
        section = np.array([point.displacement_strobe.item(), point.velocity_strobe.item()])

        def end(state, exciter=moved):
            motion = vp.simulate(
                exciter, tau_end=exciter.period, x0=state[0], v0=state[1], samples_per_period=1
            )
            return np.array([motion.displacement_end.item(), motion.velocity_end.item()])

        assert end(section) == pytest.approx(section, abs=1e-12)
        steps = 1e-6 * np.eye(2)
        jacobian = np.transpose([(end(section + s) - end(section - s)) / 2e-6 for s in steps])
        assert np.trace(jacobian) == pytest.approx(
            point.floquet_multiplier.values.sum().real, abs=1e-6
        )


def test_pitchforks_of_the_symmetric_exciter(symmetric) -> None:
    found = [value for kind, value, _reason in bifurcations(symmetric) if kind == PITCHFORK]
    assert found == pytest.approx([1.0376425831299, 1.5299072088081], abs=1e-12)
    # Between them the symmetric orbit is unstable, and two asymmetric ones begin at each.
    first = symmetric.isel(point=symmetric.branch_id.values == 0)
    between = (first.nu > found[0] + 1e-9) & (first.nu < found[1] - 1e-9)
    outside = (first.nu < found[0] - 1e-9) | (first.nu > found[1] + 1e-9)
    assert (first.stable.values == 0)[between].all()
    assert (first.stable.values == 1)[outside].all()
    assert set(symmetric.branch_id.values) == {0, 1, 2, 3, 4}
    for one, other in ((1, 2), (3, 4)):
        a, b = (symmetric.isel(point=symmetric.branch_id.values == k) for k in (one, other))
        assert a.nu.values == pytest.approx(b.nu.values, abs=1e-9)
        assert a.displacement_mean.values == pytest.approx(-b.displacement_mean.values, abs=1e-7)
        assert abs(a.displacement_mean).max() > 1e-2


def test_wanted_values_and_limits_are_points(symmetric) -> None:
    values = symmetric.nu.values[symmetric.branch_id.values == 0]
    assert {1.25, 2.0, 3.0} <= set(values)
    assert (np.diff(values) > 0).all()


@pytest.mark.parametrize(
    ("exciter", "along", "to"),
    [
        (SYMMETRIC, "nu", (0.3, 3.0)),
        (SYMMETRIC, "f", (0.02, 3.0)),
        (SKEW, "nu", (0.3, 5.0)),
        (SKEW, "delta", (-0.4, 0.4)),
        (SKEW, "R1", (0.1, 1.0)),
        (SKEW, "l", (0.2, 1.0)),
        (SKEW, "h", (0.0, 0.5)),
        # An isolated branch, which returns to its start.
        (vp.Exciter(l=0.5, nu=1.1651029112605555, f=1.8578868962140231, R1=0.6254640460767307,
                    R2=0.6254640460767307), "delta", (-0.4, 0.4)),
    ],
)  # fmt: skip
def test_halved_steps_find_the_same(exciter, along: str, to: tuple[float, float]) -> None:
    once = bifurcations(vp.branch(exciter, along, to), along)
    twice = bifurcations(vp.branch(exciter, along, to, max_step=0.01), along)
    assert [each[::2] for each in once] == [each[::2] for each in twice]
    assert [each[1] for each in once] == pytest.approx([each[1] for each in twice], abs=1e-10)


def test_halved_steps_switch_to_the_same() -> None:
    lists = []
    for step in (0.02, 0.01):
        exciter = vp.Exciter(**{**vars(SYMMETRIC), "nu": 0.65})
        branch = vp.branch(
            exciter, "nu", (0.6, 0.75), switch=("pitchfork", "grazing"), max_step=step
        )
        lists.append(sorted((int(kind), value) for kind, value, _reason in bifurcations(branch)))
    assert [kind for kind, _value in lists[0]] == [kind for kind, _value in lists[1]]
    assert np.array(lists[0]) == pytest.approx(np.array(lists[1]), abs=1e-9)


def test_test_functions_change_their_sign_at_bifurcations(symmetric, skew) -> None:
    every = vp.branch(SKEW, "nu", (0.3, 5.0), switch=KINDS[:1] + KINDS[2:])
    for branch in (symmetric, skew, every):
        multipliers = branch.floquet_multiplier.values.copy()
        multipliers[np.isinf(multipliers).any(axis=1)] = np.nan  # impacts without velocity
        trace, product = multipliers.sum(axis=1).real, multipliers.prod(axis=1).real
        for (kind, _value, reason), i in zip(
            bifurcations(branch), branch.bifurcation_point.values, strict=True
        ):
            if kind == FOLD:
                back, ahead = np.diff(branch.nu.values[i - 1 : i + 2])
                # Where a flip follows closely, nu there is the same to rounding.
                assert back * ahead < 0 or min(abs(back), abs(ahead)) < 1e-15
                fold = 1 - trace + product
                assert fold[i - 1] * fold[i + 1] < 0
                # The parameter changes with the square of the distance from the fold.
                assert abs(fold[i]) < 1e-5 * abs(fold[i + 1] - fold[i - 1])
            if kind == FLIP and reason == BranchEnd.GOES_ON:
                doubling, nu = 1 + trace + product, branch.nu.values
                assert doubling[i - 1] * doubling[i + 1] < 0
                # The error of the parameter: at a flip of an orbit of many impacts the function is steep.
                slope = (doubling[i + 1] - doubling[i - 1]) / (nu[i + 1] - nu[i - 1])
                assert abs(doubling[i] / slope) < 1e-10
            if kind == PITCHFORK:
                assert 1 - trace[i] + product[i] == pytest.approx(0.0, abs=1e-10)


def test_grazing_flights_touch_and_grazing_impacts_have_no_velocity(skew) -> None:
    ends = {"impact": 0, "flight": 0}
    for (kind, nu, _reason), i in zip(
        bifurcations(skew), skew.bifurcation_point.values, strict=True
    ):
        if kind != GRAZING:
            continue
        state = skew.isel(point=int(i))
        rows = slice(*np.cumsum([0, *skew.row_size.values])[[i, i + 1]])
        velocities = skew.impact_velocity.values[rows]
        if velocities.size and abs(velocities).min() < 1e-10:
            ends["impact"] += 1
            continue
        ends["flight"] += 1
        moved = vp.Exciter(**{**vars(SKEW), "nu": nu})
        if state.regime == Regime.NO_IMPACT:
            amplitude = state.displacement_amplitude.values[0]
            assert amplitude == pytest.approx(moved.l - abs(moved.delta), abs=1e-13)
            continue
        motion = vp.simulate(
            moved, tau_end=moved.period * int(state.period_multiple), samples_per_period=20_000,
            x0=float(state.displacement_strobe), v0=float(state.velocity_strobe),
        )  # fmt: skip
        x, v = motion.displacement.values, motion.velocity.values
        turns = np.flatnonzero((v[1:] * v[:-1] < 0) & (np.abs(np.diff(v)) < 0.01))
        gaps = np.where(v[turns] > 0, moved.upper - x[turns], x[turns] - moved.lower)
        assert gaps.min() == pytest.approx(0.0, abs=1e-6)
    assert min(ends.values()) >= 2


def test_a_branch_traced_backwards_has_the_same_bifurcations_and_points() -> None:
    there = vp.branch(SYMMETRIC, "nu", 2.5, at=[1.1, 1.4, 2.2])
    last = there.isel(point=-1)
    exciter = vp.Exciter(**{**vars(SYMMETRIC), "nu": 2.5})
    back = vp.branch(
        exciter, "nu", 1.0, float(last.displacement_strobe), float(last.velocity_strobe),
        at=[1.1, 1.4, 2.2],
    )  # fmt: skip
    assert [each[1] for each in bifurcations(there)] == pytest.approx(
        [each[1] for each in bifurcations(back)][::-1], abs=1e-12
    )
    for nu in (1.1, 1.4, 2.2):
        a, b = (each.isel(point=int(np.flatnonzero(each.nu == nu)[0])) for each in (there, back))
        for name in ("displacement_strobe", "velocity_strobe", "displacement_amplitude"):
            assert a[name].values == pytest.approx(b[name].values, abs=1e-12)


def test_mirrored_exciters_have_mirrored_branches(skew) -> None:
    mirrored = vp.branch(SKEW.mirrored(), "nu", (0.3, 5.0), switch=["grazing"])
    assert bifurcations(mirrored)[0][1] == pytest.approx(bifurcations(skew)[0][1], abs=1e-10)
    assert sorted(each[1] for each in bifurcations(mirrored)) == pytest.approx(
        sorted(each[1] for each in bifurcations(skew)), abs=1e-9
    )
    assert mirrored.sizes["point"] == skew.sizes["point"]
    assert mirrored.displacement_strobe.values == pytest.approx(
        -skew.displacement_strobe.values, abs=1e-7
    )
    assert mirrored.impacts_per_orbit.values == pytest.approx(
        skew.impacts_per_orbit.values[:, ::-1]
    )


def test_sweeps_lie_on_the_branch_and_jump_at_its_bifurcations() -> None:
    nu = np.linspace(2.2, 5.0, 141)
    up, down = (vp.sweep(SKEW, {"nu": nu}, follow=("nu", way)) for way in ("up", "down"))
    start = vp.Exciter(**{**vars(SKEW), "nu": 2.2})
    branch = vp.branch(
        start,
        "nu",
        5.0,
        *(float(up[f"{n}_strobe"][0]) for n in ("displacement", "velocity")),
        at=nu,
    )
    found = bifurcations(branch)
    assert found[0][0] == FOLD
    two_sided = up.regime.values == Regime.TWO_SIDED
    # Up to the fold what settles is on the branch; beyond it the motion has fallen off.
    assert nu[two_sided].max() < found[0][1] < nu[two_sided].max() + 0.021
    for k in np.flatnonzero(two_sided):
        at = np.flatnonzero((branch.nu.values == nu[k]) & (branch.stable.values == 1))
        near = abs(branch.displacement_strobe.values[at] - up.displacement_strobe.values[k])
        assert near.min() < 1e-9
        assert abs(branch.velocity_strobe.values[at] - up.velocity_strobe.values[k]).min() < 1e-9
    assert (down.regime.values == Regime.NO_IMPACT).any()


def test_the_linear_motion_grazes_where_its_amplitude_says() -> None:
    exciter = vp.Exciter(l=0.5, nu=2.5, f=0.3, h=0.15, delta=0.1, R1=0.7, R2=0.6)
    branch = vp.branch(exciter, "nu", (0.5, 3.0), switch=["grazing"])
    amplitude = exciter.l - abs(exciter.delta)
    # |f|^2 = amplitude^2 ((1 - nu^2)^2 + h^2 nu^2), a quadratic in nu^2
    b = 1 - exciter.h**2 / 2
    squares = b + np.sqrt(b * b - 1 + (exciter.f / amplitude) ** 2)
    grazings = [value for kind, value, _reason in bifurcations(branch) if kind == GRAZING]
    assert min(abs(np.array(grazings) - np.sqrt(squares))) < 1e-12
    assert branch.regime.values[branch.branch_id.values == 0].tolist().count(Regime.NO_IMPACT) > 10
    assert (branch.regime.values[branch.branch_id.values == 1] == Regime.ONE_SIDED_2).any()


def test_a_narrow_resonance_is_not_stepped_over() -> None:
    exciter = vp.Exciter(l=0.5, nu=0.5, f=1e-4, h=1e-5, R1=0.7, R2=0.7)
    branch = vp.branch(exciter, "nu", 2.0)
    ((kind, nu, _reason),) = bifurcations(branch)
    assert kind == GRAZING
    assert nu == pytest.approx(1 - 1e-4, abs=1e-5)


@pytest.mark.parametrize("R2", [0.7, 0.700001])
def test_an_exciter_that_is_nearly_symmetric_has_folds(R2: float) -> None:
    """At its folds the orbit is nearly its mirror image: that was taken for a pitchfork, and the branch ended."""
    exciter = vp.Exciter(l=0.5, nu=1.0, f=0.4, h=0.15, R1=0.7, R2=R2)
    (fold, nu, _reason), (grazing, at, _reason) = bifurcations(vp.branch(exciter, "nu", (1, 3)))
    assert (fold, grazing) == (FOLD, GRAZING)
    assert nu == pytest.approx(2.400784, abs=2e-6)
    # The linear motion touches both supports there, whatever their restitution: f^2 = l^2 |1 - nu^2 + i h nu|^2.
    assert abs(complex(1 - at * at, 0.15 * at)) == pytest.approx(0.4 / 0.5, rel=1e-12)


@pytest.mark.parametrize("delta", [1e-3, 1e-5, 1e-7])
def test_a_branch_does_not_change_to_one_that_is_next_to_it(delta: float) -> None:
    """Of an exciter that is nearly symmetric a branch goes past a pitchfork on one side, next to two others."""
    exciter = vp.Exciter(l=0.5, nu=1.26, f=1.0, h=0.2, delta=delta, R1=0.7, R2=0.7)
    branch = vp.branch(exciter, "nu", (0.9, 1.6))
    assert (branch.branch_id == 0).all()
    assert (np.diff(branch.nu) > 0).all()
    # The others are one closed branch with two folds, stable between them on one side.
    both = vp.branch(exciter, "nu", (0.9, 1.6), law=(1, 1, 1))
    assert np.unique(both.branch_id).size == 2
    assert [kind for kind, *_ in bifurcations(both) if kind != END] == [FOLD, FOLD]


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        (("tau", 2.0), "along: must be one of nu, f, .*, phi2, .*, got 'tau'"),
        (("nu", 1.0), "to: must differ from the exciter's own nu, got 1.0"),
        (("nu", (1.0, 1.0)), "to: must differ from the exciter's own nu, got .1.0, 1.0."),
        (("nu", (3.0, 2.0)), "to: must be a number, or two that enclose the exciter's own nu, 1.0"),
        (("R1", 1.2), "to: must be a number from 0 to 1, got 1.2"),
        (("nu", -1.0), "to: must be a finite number > 0, got -1.0"),
    ],
)
def test_bad_arguments_are_named(arguments, text: str) -> None:
    with pytest.raises(vp.ParameterError, match=text.replace("(", r"\(")):
        vp.branch(SYMMETRIC, *arguments)


def test_both_ends_may_come_in_any_order() -> None:
    up, down = (vp.branch(SYMMETRIC, "nu", ends) for ends in ((0.9, 1.1), (1.1, 0.9)))
    xr.testing.assert_identical(up, down)


def test_an_end_at_the_exciter_is_the_one_that_a_number_has() -> None:
    both, one = (vp.branch(SYMMETRIC, "nu", to) for to in ((1.0, 1.02), 1.02))
    xr.testing.assert_identical(both, one)


def test_a_stiffness_is_refused_at_zero_before_what_it_leaves() -> None:
    soft = vp.Exciter(l=0.5, nu=1.0, f=-1, h=0.2, R2=0.7, k1=40.0, h1=1.0)
    with pytest.raises(vp.ParameterError, match="along: must be above 0 where it varies"):
        vp.branch(soft, "k1", (0.0, 80.0))


def test_bad_options_are_named() -> None:
    with pytest.raises(
        vp.ParameterError, match="switch: must be a list of flip, pitchfork, grazing"
    ):
        vp.branch(SYMMETRIC, "nu", 2.0, switch=["fold"])
    with pytest.raises(vp.ParameterError, match=r"at: must be numbers from 1\.0 to 2\.0, got 3\.0"):
        vp.branch(SYMMETRIC, "nu", 2.0, at=[3.0])
    with pytest.raises(vp.ParameterError, match="max_step: must be a number above 0 up to 0"):
        vp.branch(SYMMETRIC, "nu", 2.0, max_step=1)
    with pytest.raises(vp.ParameterError, match="must lead from"):
        vp.branch(vp.Exciter(l=0.5), "nu", 2.0, 0.2)


@pytest.mark.slow
def test_branches_that_rounding_ends_are_the_same_at_halved_steps() -> None:
    R = 0.9197939505469324
    exciter = vp.Exciter(l=0.5, nu=1.8628806359687098, f=2.2281010446595615, h=0, R1=R, R2=R)
    once, twice = (
        vp.branch(exciter, "l", (0.2, 1.5), switch=KINDS, max_step=s) for s in (0.02, 0.01)
    )
    assert "incomplete" not in once.attrs
    a, b = bifurcations(once, "l"), bifurcations(twice, "l")
    assert [each[::2] for each in a] == [each[::2] for each in b]
    assert [each[1] for each in a] == pytest.approx([each[1] for each in b], abs=1e-10)
    reasons = set(once.end_reason.values)
    assert {BranchEnd.ROUNDING, BranchEnd.PERIOD_LIMIT} < reasons
    assert BranchEnd.LOST not in reasons
    # A branch ends where its fold and its flip have the same parameter to rounding.
    ends = once.isel(bifurcation=once.end_reason.values == BranchEnd.ROUNDING)
    assert (ends.bifurcation_kind == END).any()
    # Chatter whose hops are at rounding.
    exciter = vp.Exciter(l=0.5, nu=3.4179735817429377, f=1.8921064065031485, h=0.1465319954381256,
                         delta=0.24789632942519918, R1=0.14923774603770282, R2=0.5254561541279937)  # fmt: skip
    for step in (0.02, 0.01):
        branch = vp.branch(exciter, "nu", (0.3, 4.0), switch=KINDS, max_step=step)
        assert BranchEnd.LOST not in branch.end_reason.values


@pytest.mark.slow
def test_undamped_orbits_at_a_natural_period_are_a_continuum() -> None:
    from math import isclose

    generator = np.random.default_rng(1268)  # an exciter that was lost at nu = 2/3
    symmetric, R1 = generator.random() < 0.4, generator.uniform(0.1, 0.99)
    h = [0.0, generator.uniform(0.01, 0.6), 1.0][generator.choice(3, p=[0.35, 0.6, 0.05])]
    exciter = vp.Exciter(
        l=0.5, nu=generator.uniform(0.4, 3.5), f=generator.uniform(0.1, 2.5), h=h,
        delta=0.0 if symmetric else generator.uniform(-0.3, 0.3), R1=R1,
        R2=R1 if symmetric else generator.uniform(0.1, 0.99),
    )  # fmt: skip
    assert exciter.h == 0.0
    branch = vp.branch(exciter, "nu", (0.3, 4.0), switch=KINDS)
    found = bifurcations(branch)
    assert all(reason != BranchEnd.LOST for _kind, _nu, reason in found)
    continua = [nu for _kind, nu, reason in found if reason == BranchEnd.CONTINUUM]
    assert continua
    assert all(isclose(nu, 2 / 3, abs_tol=1e-12) for nu in continua)


def test_limits_are_named(monkeypatch) -> None:
    flips = vp.Exciter(l=2.0, nu=2.53, f=1.0, h=0.1, delta=-1.95, R1=0.8, R2=0.8)
    whole = vp.branch(flips, "nu", (2.52, 2.625), switch=["flip"])
    reasons = whole.end_reason.values.tolist()
    assert reasons.count(BranchEnd.PERIOD_LIMIT) == 1
    assert whole.period_multiple.max() == 32
    assert "incomplete" not in whole.attrs
    # With other limits the same branches are left.
    monkeypatch.setattr("vibropipe.orbits.branches.switching.MAX_SEQUENCE", 5)
    few = vp.branch(flips, "nu", (2.52, 2.625), switch=["flip"])
    assert few.end_reason.values.tolist().count(BranchEnd.IMPACT_LIMIT) == 1
    assert few.impacts_per_orbit.max() == 4
    monkeypatch.setattr("vibropipe.orbits.branches.tree.MAX_BRANCHES", 2)
    with pytest.warns(vp.UnsolvedWarning, match="2 branches are followed, the most of one call; 1"):
        left = vp.branch(flips, "nu", (2.52, 2.625), switch=["flip"])
    assert left.attrs["incomplete"].endswith("1 more begin at their bifurcations")
    assert left.branch_id.max() == 1


@pytest.mark.parametrize(
    ("exciter", "along", "to"),
    [
        # A fold and a flip of a period-4 orbit, closer to each other than a test function can be resolved.
        (vp.Exciter(l=0.5, nu=1.12190434123818, f=1.1072909251512346, delta=0.13541853125944942,
                    R1=0.3328668265852293, R2=0.3015108355917748), "l", (0.2, 1.5)),
        (vp.Exciter(l=0.5, nu=1.0379026495099584, f=2.1421626990199636, h=1.0,
                    delta=0.2823352578795743, R1=0.655086528014475, R2=0.6401265713289132),
         "R2", (0.05, 1.0)),
    ],
)  # fmt: skip
def test_no_branch_of_a_cascade_is_lost(exciter, along: str, to: tuple[float, float]) -> None:
    branch = vp.branch(exciter, along, to, switch=KINDS)
    assert BranchEnd.LOST not in branch.end_reason.values


def test_a_parent_of_two_flips_is_followed_once() -> None:
    """Orbits of eight periods lie between two flips of those of four, which are one branch and no two motions."""
    exciter = vp.Exciter(l=0.5, nu=2.4, f=1.2, h=0.1, delta=-0.45, R1=0.7, R2=0.7)
    ds = vp.branch(exciter, "nu", (1.2, 3.4), switch=["flip"])
    periods = [ds.period_multiple.values[ds.branch_id.values == number] for number in (0, 1)]
    assert [set(each.tolist()) for each in periods] == [{8}, {4}]
    assert ds.branch_id.max() == 1
    flips = [value for kind, value, _ in bifurcations(ds) if kind == FLIP]
    assert len(flips) == 3  # both ends of the doubled branch, and the one that its parent passes


def test_an_isola_ends_with_its_start() -> None:
    """It closes after two folds, within the range of the parameter."""
    exciter = vp.Exciter(
        nu=1.4887842456968716, f=1.0, h=0.1105434900727844, l=0.24910568978054132,
        delta=0.17896693412204812, R1=0.7420878101424426, R2=0.5657227200485793,
    )  # fmt: skip
    ds = vp.branch(exciter, "h", (0.0, 0.5), switch=())
    assert ds.end_reason.values.tolist()[-1] == BranchEnd.CLOSED
    assert ds.bifurcation_kind.values.tolist() == [
        Bifurcation.FOLD,
        Bifurcation.FOLD,
        Bifurcation.END,
    ]
    for name in ("h", "displacement_strobe", "velocity_strobe", "residual", "impact_velocity_max"):
        assert (ds[name][-1] == ds[name][0]).all()
    assert ds.residual.max() < 1e-13
    assert float(ds.h.min()) > 0.0
    assert float(ds.h.max()) < 0.5
