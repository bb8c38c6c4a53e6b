"""Branches of random exciters: orbits whose energies balance, the same at halved steps and for the mirrored exciter."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

import vibropipe as vp
from vibropipe.words.bifurcations import Bifurcation
from vibropipe.words.regimes import Regime

# With R = 1 and no damping an impact loses nothing: orbits need not be isolated there.
RANGES = {
    "nu": (0.3, 4.0), "f": (0.05, 3.0), "h": (0.0, 1.0), "l": (0.2, 1.5), "delta": (-0.4, 0.4),
    "R1": (0.05, 0.99), "R2": (0.05, 0.99),
}  # fmt: skip


@st.composite
def exciters(draw: Any) -> vp.Exciter:
    R1 = draw(st.floats(0.1, 0.98))
    symmetric = draw(st.booleans())
    return vp.Exciter(
        l=0.5,
        nu=draw(st.one_of(st.just(1.0), st.floats(0.4, 3.5))),
        f=draw(st.floats(0.1, 2.5)),
        h=draw(st.one_of(st.sampled_from([0.0, 1.0, 2.0]), st.floats(0.01, 0.6))),
        delta=0.0 if symmetric else draw(st.floats(-0.3, 0.3)),
        R1=R1,
        R2=R1 if symmetric else draw(st.floats(0.1, 0.98)),
    )


def branch_of(exciter: vp.Exciter, along: str, **options: Any) -> Any:
    """The branch over the range of a parameter; none of aperiodic motions, and of those with rests (marched)."""
    low, high = RANGES[along]
    assume(low < getattr(exciter, along) < high)
    state = vp.steady_state(exciter, harmonics=1)
    assume(state.period_multiple > 0)
    assume(state.regime != Regime.WITH_REST)
    return vp.branch(exciter, along, (low, high), **options)


def same_bifurcations(first: Any, second: Any, along: str) -> None:
    a, b = (np.sort(each[f"bifurcation_{along}"].values) for each in (first, second))
    assert np.sort(first.bifurcation_kind).tolist() == np.sort(second.bifurcation_kind).tolist()
    assert a == pytest.approx(b, abs=1e-10 * (1 + RANGES[along][1]))


@settings(max_examples=12)
@given(exciter=exciters(), along=st.sampled_from(sorted(RANGES)))
@example(vp.Exciter(l=0.5, nu=1.0, f=1.0, h=0.0, delta=0.0, R1=0.7, R2=0.7), "nu")
def test_points_are_orbits_and_halved_steps_find_the_same(exciter: vp.Exciter, along: str) -> None:
    branch = branch_of(exciter, along)
    assert branch.residual.max() < 1e-11
    assert abs(branch.energy_residual).max() < 1e-10
    product = branch.floquet_multiplier.values.prod(axis=1).real
    p1, p2 = branch.impacts_per_orbit.values.T
    length = branch.period_multiple.values * 2 * np.pi / branch.nu.values
    loss = branch.R1.values ** (2 * p1) * branch.R2.values ** (2 * p2)
    expected = np.exp(-branch.h.values * length) * loss
    assert product == pytest.approx(expected, rel=1e-9, abs=1e-300)
    same_bifurcations(branch, branch_of(exciter, along, max_step=0.01), along)


# Doubled orbits of 20 and 92 impacts that reach their parent, each with a last flip at 4e-7 and 2.5e-8 before it.
LAST_FLIPS = [
    (
        vp.Exciter(
            l=0.5, nu=3.2702638971007594, f=0.8721523882784922, delta=0.2589431900376549,
            R1=0.7728709822381215, R2=0.9480919260669047,
        ), "nu", (1.312005722635769, 1.3120061281559552),
    ),
    (
        vp.Exciter(
            l=0.5, nu=0.8247606054783052, f=2.1291411362459507, h=0.09517537973544762,
            R1=0.6662601005609288, R2=0.6662601005609288,
        ), "R2", (0.6103661940980794, 0.6103661690031996),
    ),
]  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize(("exciter", "along", "flips"), LAST_FLIPS, ids=["nu", "R2"])
def test_no_step_passes_the_parent_of_doubled_orbits(
    exciter: vp.Exciter, along: str, flips: tuple[float, float]
) -> None:
    first, *others = (
        branch_of(exciter, along, max_step=step, switch=["flip", "pitchfork", "grazing"])
        for step in (0.02, 0.01, 0.005)
    )
    values = first[f"bifurcation_{along}"].values[first.bifurcation_kind == Bifurcation.FLIP]
    for flip in flips:
        assert abs(values - flip).min() < 1e-11
    for other in others:
        same_bifurcations(first, other, along)


@settings(max_examples=4)
@given(exciter=exciters(), along=st.sampled_from(["nu", "f", "h", "l"]))
def test_the_mirrored_exciter_has_the_mirrored_branch(exciter: vp.Exciter, along: str) -> None:
    branch = branch_of(exciter, along)
    low, high = RANGES[along]
    ends = (-high, -low) if along == "f" else (low, high)
    mirrored = vp.branch(exciter.mirrored(), along, ends)
    sign = -1 if along == "f" else 1
    a = np.sort(branch[f"bifurcation_{along}"].values)
    b = np.sort(sign * mirrored[f"bifurcation_{along}"].values)
    assert a == pytest.approx(b, abs=1e-9)
    assert np.sort(branch.bifurcation_kind).tolist() == np.sort(mirrored.bifurcation_kind).tolist()


@settings(max_examples=4)
@given(exciter=exciters(), along=st.sampled_from(sorted(RANGES)), share=st.floats(0.2, 0.8))
def test_a_branch_traced_from_one_of_its_points_is_the_same(
    exciter: vp.Exciter, along: str, share: float
) -> None:
    branch = branch_of(exciter, along)
    stable = np.flatnonzero(branch.stable.values & (branch.period_multiple.values == 1))
    assume(stable.size > 4)
    i = int(stable[int(share * (stable.size - 1))])
    assume(i not in branch.bifurcation_point.values)
    point = branch.isel(point=i)
    moved = vp.Exciter(**{**vars(exciter), along: float(point[along])})
    x0, v0 = float(point.displacement_strobe), float(point.velocity_strobe)
    x0 = min(max(x0, moved.lower), moved.upper)
    state = vp.steady_state(moved, x0, v0)
    assume(abs(state.displacement_strobe - x0) + abs(state.velocity_strobe - v0) < 1e-7)
    again = vp.branch(moved, along, RANGES[along], x0, v0)
    if not (branch.bifurcation_kind == Bifurcation.END).any():
        same_bifurcations(branch, again, along)
