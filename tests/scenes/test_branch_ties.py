"""Sentences on branches whose largest or least value several places share: none names one of them alone."""

from __future__ import annotations

from test_branch_sentences import mirrored

import vibropipe as vp
from vibropipe.scenes.branch.answers import velocity_answer
from vibropipe.scenes.branch.yields import yield_answer


def test_an_unstable_orbit_at_its_grazing_is_not_the_hardest_stable_one() -> None:
    exciter = vp.Exciter(l=0.5, nu=1.3, f=0.5, h=0.1, R1=0.7, R2=0.7)
    branch = vp.branch(exciter, "delta", (-0.45, 0.45), switch=["pitchfork", "flip"])
    stable = branch.stable.values == 1
    hardest = float(branch.impact_velocity_max.max("support").values[stable].max())
    told = velocity_answer(branch)
    assert told is not None
    # The stable orbits end at the flips at -0.1517 and 0.1517, the unstable ones at grazings at -0.1698 and 0.1698.
    assert (
        told.lead == "Stable motions followed here strike hardest at δ = −0.1517 and at δ = 0.1517."
    )
    assert told.rest == "The velocity before that impact, on one support, is 0.993."
    assert hardest < 0.993249 < branch.impact_velocity_max.max()


def test_a_velocity_that_is_the_same_everywhere_is_hardest_nowhere() -> None:
    exciter = vp.Exciter(l=1.0, delta=-0.95, nu=2.0, f=0.4, h=0.1, R1=0.7, R2=0.7)
    branch = vp.branch(exciter, "R2", (0.2, 0.9))  # which is not struck
    told = velocity_answer(branch)
    assert told is not None
    assert told.lead == "All stable motions followed here that strike a support do so equally hard."
    several = mirrored()
    several["impact_velocity_max"][:] = 1.0
    several["impact_velocity_max"][[1, 3, 10]] = 2.0
    told = velocity_answer(several)
    assert told is not None
    assert told.lead == "Stable motions followed here strike hardest in several places."


def test_several_points_with_the_fewest_good_parts_are_counted() -> None:
    branch = mirrored().isel(point=slice(0, 4), bifurcation=slice(0, 0))
    shares = {"yield": [1.0, 0.0, 0.5, 0.0], "yield_low": [0.99, 0.0, 0.4, 0.0]}
    told = yield_answer(branch.assign({name: ("point", v) for name, v in shares.items()}))
    assert told is not None
    assert told.rest == "The fewest, 0 % of 1,024 parts, do at 2 of these points."
    shares["yield"][1] = 0.1
    told = yield_answer(branch.assign({name: ("point", v) for name, v in shares.items()}))
    assert told is not None
    assert told.rest.startswith("The fewest, 0 % of 1,024 parts, do at ν = ")
