"""What hard cases will cost."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import TYPE_CHECKING

from vibropipe.scenes.costs import Estimate, Sampler, Work, planned
from vibropipe.words.wording import count

if TYPE_CHECKING:
    from vibropipe.scenes.hard_cases.keys import HardCasesScene

# Hard cases that are made of very many motions or impacts, and all others.
SECONDS_OF_CASES = {
    "grazing_free": 1.0,
    "ideal_free": 1.8,
    "ideal_marched": 2.0,
    "million_periods": 2.0,
}
SECONDS_PER_CASE, USUAL_CASES = 0.03, 30
HARD_CASES_BYTES = 40e3
# A hard case of many motions, and the seconds it took where plans were made.
REFERENCE_CASE = ("energy_of_motions", 0.08)


def plan(scene: HardCasesScene) -> Work:
    """Return the work of hard cases: what each took once."""
    cases = len(scene.cases)
    return Work(
        size=count(cases, "case") if cases else "all cases",
        rows=max(1, cases),
        method="exact, newmark",
        outputs=(),
        seconds=case_seconds(scene.cases),
        bytes=HARD_CASES_BYTES,
    )


def case_seconds(names: Sequence[str]) -> float:
    """Return the rough seconds of hard cases by name; of all of them if none is named."""
    if not names:
        return sum(SECONDS_OF_CASES.values()) + USUAL_CASES * SECONDS_PER_CASE
    return sum(SECONDS_OF_CASES.get(name, SECONDS_PER_CASE) for name in names)


def estimate(scene: HardCasesScene, sampler: Sampler) -> Estimate:
    """Estimate hard cases by how many times longer than planned one of them takes here."""
    from vibropipe.scenes.hard_cases.solve import solve

    name, seconds = REFERENCE_CASE
    sample = scene.model_copy(update={"cases": [name]})
    solve(sample)  # loads
    begin = time.thread_time()
    solve(sample)
    slowdown = (time.thread_time() - begin) / seconds
    work = plan(scene)
    return planned(work, work.seconds * slowdown)
