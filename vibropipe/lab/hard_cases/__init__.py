"""Hard cases: motions with known properties by both methods, and where common methods fail (`solve_hard_cases`)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.lab.hard_cases.case import Case, Measured, Motion, Solver, evaluate_case, solvers
from vibropipe.lab.hard_cases.cases import CASES, GROUP_OF, GROUPS, Group
from vibropipe.lab.hard_cases.failures import ENERGY_STEPS, STEPS, answer_questions
from vibropipe.words.measurements import Passed
from vibropipe.words.progress import Progress
from vibropipe.words.vocabulary import describe

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["CASES", "solve_hard_cases"]


def solve_hard_cases(
    cases: Sequence[Case] = CASES,
    by: Sequence[Solver] | None = None,
    questions: Sequence[str] = (),
    progress: Progress | None = None,
) -> xr.Dataset:
    """Measure each case by each solver: the exact method, and Newmark's with coarse to fine steps.

    by : solvers; default `solvers()`
    questions : questions of `failures` that are answered beside the cases: energy, grazing, chatter, step
    progress : called as `progress(done, total)` with the number of cases
    Over `case` and `solver`: `measured` deviation, its `bound`, `passed` (not_passed, passed, or not_asked
    where the case does not apply to the solver), `worst_status`, and the effort: different `motions` solved,
    `impacts` in them, and `short_flight_motions`, those with flights shorter than the step. Over `case`, as text:
    `asked`, the description, `known`, the known property, `case_group` and `reason`, that of the bound; over `group`:
    what is known. The attribute `distinct_motions` counts the motions of all cases by the exact method once. Of the
    questions: as of `failures`.
    """
    import xarray as xr

    by = solvers() if by is None else by
    rows, motions = [], set[Motion]()
    for case in cases:
        results = []
        for solver in by:
            results.append(evaluate_case(case, solver))
            motions.update(solver.runs if solver.steps is None else ())
        rows.append(
            [
                [Passed.NOT_ASKED if value is None else value for value in result]
                for result in results
            ]
        )
        if progress is not None:
            progress(len(rows), len(cases))
    table = np.array(rows, float)
    variables: dict[str, Any] = {
        "asked": ("case", np.array([case.description for case in cases])),
        "known": ("case", np.array([case.expected for case in cases])),
        "case_group": ("case", np.array([group_of(case.name).title for case in cases])),
        "reason": ("case", np.array([group_of(case.name).reasons[case.name] for case in cases])),
    }
    for index, name in enumerate(Measured._fields):
        is_code = name in ("passed", "worst_status")
        dtype = float if name in ("measured", "bound") else np.int8 if is_code else np.int64
        variables[name] = (("case", "solver"), table[..., index].astype(dtype))
    found, abscissae = answer_questions(questions)
    own = [group_of(case.name) for case in cases]
    order = [*GROUPS, *own]
    groups = {group.title: group.known for group in sorted(own, key=order.index)}
    variables |= {"group_known": ("group", np.array(list(groups.values()))), **found}
    coords = {
        "case": [case.name for case in cases],
        "solver": [solver.name for solver in by],
        "group": list(groups),
        **abscissae,
    }
    names = ", ".join(solver.name for solver in by)
    attrs = {
        "method": f"{names} steps per forcing period",
        "distinct_motions": len(motions),
        "energy_steps": ENERGY_STEPS,
        "steps": STEPS,
    }
    return describe(xr.Dataset(variables, coords, attrs))


def group_of(name: str) -> Group:
    """Return the group of a case; of a case of no group, one of its own without a reason."""
    return GROUP_OF.get(name) or Group("other", "", {name: ""})
