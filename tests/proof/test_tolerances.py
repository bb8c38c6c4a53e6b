"""Orbits over tolerances: bounds beside samples, disproofs beside branches, bad input in words."""

from __future__ import annotations

import numpy as np
import pytest
from command_line import printed

import vibropipe as vp
from vibropipe.words.bifurcations import Bifurcation
from vibropipe.words.proofs import Proved, ProvedStable, Why

PAPER = vp.Exciter(l=0.5, nu=1.0, f=-1.0, h=0.2, delta=0.01, R1=0.7, R2=0.7)
OTHER = vp.Exciter(l=0.5, nu=2.0, f=0.8, h=0.15, delta=0.05, R1=0.7, R2=0.6)
WORKSHOP = {"R1": 0.01, "R2": 0.01, "delta": 0.002}


@pytest.mark.parametrize("exciter", [PAPER, OTHER], ids=["paper", "other"])
def test_bounds_hold_all_samples_and_are_not_much_wider(exciter):
    proof = vp.prove(exciter, WORKSHOP)
    assert proof.proved == Proved.PROVED
    assert proof.proved_stable == ProvedStable.STABLE
    assert proof.largest == 1.0
    rng = np.random.default_rng(4)
    corners = np.array(np.meshgrid(*[[-1, 1]] * 3)).reshape(3, -1).T
    moves = np.vstack([corners, rng.uniform(-1, 1, (12, 3))])
    seen = []
    for move in moves:
        parts = {
            n: getattr(exciter, n) + m * d for (n, d), m in zip(WORKSHOP.items(), move, strict=True)
        }
        row = vp.steady_state(vp.Exciter(**{**exciter.stated(), **parts}))
        assert row.impact_support.values.tolist() == proof.impact_support.values.tolist()
        seen.append([*row.impact_velocity.values, row.displacement_mean.item(),
                     *row.displacement_amplitude.values[:3], abs(row.floquet_multiplier.values).max()])  # fmt: skip
    names = ("impact_velocity", "displacement_mean", "displacement_amplitude", "spectral_radius")
    low, high = (
        np.concatenate([np.ravel(proof[f"{name}_{end}"].values) for name in names])
        for end in ("low", "high")
    )
    assert (low <= np.min(seen, axis=0)).all()
    assert (high >= np.max(seen, axis=0)).all()
    # velocities and mean; of the others the parts are too few for narrow bounds
    assert ((high - low)[:3] < 2.0 * np.ptp(seen, axis=0)[:3]).all()


def test_a_tolerance_that_is_too_wide_is_disproved_where_the_branch_ends():
    proof = vp.prove(PAPER, {"R1": 0.24}, largest=True)
    branch = vp.branch(PAPER, "R1", 1.0)
    events = branch.bifurcation_R1.values[branch.bifurcation_kind.values == Bifurcation.GRAZING]
    end = events.min()
    assert 0.7 + 0.24 * float(proof.largest) < end < 0.7 + 0.24 * 1.06 * float(proof.largest)
    beyond = vp.prove(PAPER, {"R1": 1.1 * (end - 0.7)})
    assert (beyond.proved, beyond.why) == (Proved.DISPROVED, Why.MOTION)
    assert end < beyond.counterexample.sel(parameter="R1") <= 0.7 + 1.1 * (end - 0.7)
    assert beyond.statement.endswith("leaves the supports.")
    assert np.isnan(beyond.largest)
    assert np.isnan(beyond.impact_velocity_low).all()


def test_a_lost_stability_is_disproved_by_a_flip_or_pitchfork():
    proof = vp.prove(OTHER, {"delta": 0.24})
    assert (proof.proved, proof.why) == (Proved.DISPROVED, Why.STABILITY)
    exciter = vp.Exciter(**{**OTHER.stated(), "delta": float(proof.counterexample[0])})
    branch = vp.branch(OTHER, "delta", float(proof.counterexample[0]), at=[exciter.delta])
    (at,) = np.flatnonzero(branch.delta.values == exciter.delta)
    assert branch.stable.values[at] == 0


def test_an_unstable_orbit_is_proved_unstable():
    every = vp.prove_all(OTHER)
    assert every.proved_stable.values.tolist() == [1, 0]
    orbits = vp.branch(OTHER, "nu", 3.5)
    unstable = np.flatnonzero(orbits.stable.values == 0)
    if unstable.size:
        proof = vp.prove(orbits.isel(point=unstable[len(unstable) // 2]))
        assert proof.proved_stable == ProvedStable.UNSTABLE


def test_few_parts_leave_it_undecided():
    proof = vp.prove(PAPER, {"R1": 0.24}, parts=3)
    assert (proof.proved, proof.why) == (Proved.UNDECIDED, Why.PARTS)
    assert proof.statement == "Undecided: not proved with the parts that were allowed."


def test_a_dataset_with_units_has_tolerances_in_units():
    with_units = vp.Exciter.from_physical(
        m=2.0, C=8000.0, H=20.0, l=0.008, F=60.0, omega=60.0, R1=0.7, R2=0.6
    )
    proof = vp.prove(with_units, {"l": 1e-5, "nu": 1e-4})
    si = vp.to_physical(proof, with_units)
    assert si.parameter.values.tolist() == ["l", "omega"]
    p = np.sqrt(8000.0 / 2.0)
    assert si.within.values == pytest.approx([1e-5, 1e-4 * p])
    assert si.impact_velocity_low.values == pytest.approx(proof.impact_velocity_low.values * p)
    row = vp.to_physical(vp.steady_state(with_units), with_units)
    assert vp.prove(row).proved == Proved.PROVED


SWEEP = {"nu": [1.0, 1.1]}


@pytest.mark.parametrize(
    ("orbit", "within", "message"),
    [
        (1.0, None, "orbit: must be an exciter, or one row of"),
        (vp.Exciter(l=0.5, nu=1.0, f=1.0, mass_ratio=0.2), None, "mass_ratio: must be 0: a housing that slides is"),
        (vp.Exciter(l=5.0, nu=2.0, f=1.0, h=0.1), None, "orbit: must strike a support"),
        (vp.Exciter(l=0.5, nu=0.3, f=1.0, h=0.2, R1=0.2, R2=0.2), None, "orbit: must not rest on a support"),
        (PAPER, {"R3": 0.1}, "within: must have keys among nu, f,"),
        (PAPER, {"k1": 0.1}, "within.k1: must be left out: support 1 is rigid"),
        (PAPER, {"R1": 0.0}, "within.R1: must be a finite number > 0"),
        (PAPER, {"R1": 0.4}, "within.R1: must keep R1 a number from 0 to 1, got 0.7 +- 0.4"),
        (PAPER, {"l": 0.5}, "within.l: must keep l a finite number > 0, got 0.5 +- 0.5"),
    ],
)  # fmt: skip
def test_what_is_not_covered_is_refused_in_words(orbit, within, message):
    with pytest.raises(vp.ParameterError) as error:
        vp.prove(orbit, within)
    assert str(error.value).startswith(message)


def test_a_grid_is_refused_with_the_remedy():
    grid = vp.sweep(PAPER, SWEEP)
    with pytest.raises(vp.ParameterError, match=r"select one, as with .isel\(point=0\)"):
        vp.prove(grid, stretches=8)
    with pytest.raises(vp.ParameterError, match=r"select it, as with .isel\(point=0\)"):
        vp.prove_bifurcation(grid, "fold", "nu")
    assert vp.prove(grid.isel(nu=1)).proved == Proved.PROVED


def without_flint(code: str) -> str:
    """Return what code prints where python-flint cannot be imported."""
    return printed("import sys; sys.modules['flint'] = None\nimport vibropipe as vp\n" + code)


def test_a_missing_library_is_told_with_the_command():
    told = without_flint(
        "try: vp.prove_all(vp.Exciter(l=0.5, nu=1.0, f=1.0))\n"
        "except ModuleNotFoundError as error: print(error)\n"
    )
    assert told.endswith("not installed: pip install 'vibropipe[proof]'\n")


def test_rows_of_a_scene_say_that_the_library_is_missing():
    told = without_flint(
        "from vibropipe.scenes.certificate import with_row_proofs\n"
        "from vibropipe.scenes.certificate_page import proof_answer\n"
        "rows = vp.sweep(vp.Exciter(l=0.5, nu=1.0, f=1.0, R1=0.7), {'nu': [0.9, 1.0]})\n"
        "from vibropipe.scenes.keys.proofs import Prove\n"
        "print(proof_answer(with_row_proofs(rows, Prove())).rest)\n"
    )
    assert told.endswith("not installed: pip install 'vibropipe[proof]'.\n")
