"""Branches as a labelled dataset: the points of all of them in a row, and their bifurcations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.march.log import new_log
from vibropipe.march.piece_log import CAUSE, HOME
from vibropipe.orbits.branches.following import Branch
from vibropipe.orbits.branches.rows import write_points
from vibropipe.orbits.branches.symmetry import whole_orbit
from vibropipe.orbits.law.law import SECTION, Law
from vibropipe.orbits.law.problem import Problem
from vibropipe.orbits.results import RowResults
from vibropipe.orbits.row import LOAD
from vibropipe.orbits.sensitivity.errors import with_errors
from vibropipe.orbits.sensitivity.rows import differentiate_rows, with_impact_derivatives
from vibropipe.physics.effects import all_effects
from vibropipe.physics.exciter import Parameters
from vibropipe.physics.flow import DEGREE
from vibropipe.solve.branch.branch_of_pieces import solve_branch_of_pieces
from vibropipe.solve.branch.places import scattered_places, values_of
from vibropipe.solve.branch.problem import exciter_at
from vibropipe.solve.rows.label import Variables, concatenate, coordinates, label_rows
from vibropipe.solve.rows.row_results import (
    ImpactBuffer,
    add_load,
    columns_of,
    compact_impacts,
    new_rows,
    without_impacts,
)
from vibropipe.solve.rows.sensitivity import through_ties
from vibropipe.words.bifurcations import Bifurcation, BranchEnd
from vibropipe.words.outputs import OF_STEADY_STATE, computed
from vibropipe.words.parameters import without_absent
from vibropipe.words.vocabulary import PARAMETER, SENSITIVITY_SUFFIX, describe

if TYPE_CHECKING:
    import xarray as xr

# Bifurcations at which an orbit has no derivative by the parameters.
SINGULAR = ("fold", "pitchfork", "grazing")
# Kind of a bifurcation, why the branch ends there, and the index of its point.
LabelledEvent = tuple[str, BranchEnd, int]
# Why a branch ends, by the reason of its last event.
REASONS = {
    "": BranchEnd.GOES_ON,
    "gap": BranchEnd.OTHER_SEQUENCE,
    "speed": BranchEnd.OTHER_SEQUENCE,
    "doubled": BranchEnd.PARENT,
    "halved": BranchEnd.PARENT,
    "chatter": BranchEnd.CHATTER,
    "rest": BranchEnd.REST,
    "closed": BranchEnd.CLOSED,
    "lost": BranchEnd.LOST,
    "points": BranchEnd.POINTS,
    "rounding": BranchEnd.ROUNDING,
    "continuum": BranchEnd.CONTINUUM,
    "impacts": BranchEnd.IMPACT_LIMIT,
    "multiple": BranchEnd.PERIOD_LIMIT,
}


def branch_dataset(
    problem: Problem,
    branches: Sequence[Branch],
    harmonics: int,
    attrs: Mapping[str, Any],
    outputs: tuple[str, ...] = OF_STEADY_STATE,
    sigma: Mapping[str, float] | None = None,
) -> xr.Dataset:
    """Return branches as the dataset of `vp.branch`.

    outputs : any of `OF_BRANCH`
    sigma : standard deviations of parameters, for the scatter of the places of bifurcations
    """
    rows = concatenate([_label(problem, each, harmonics, outputs) for each in branches])
    sizes = [len(values_of(each)) for each in branches]
    values = np.concatenate([values_of(each) for each in branches])
    begins = np.cumsum([0, *sizes[:-1]])
    events: list[LabelledEvent] = [
        (event.kind, REASONS[event.reason], int(begin) + event.point)
        for begin, branch in zip(begins, branches, strict=True)
        for event in branch.events
    ]
    ids = np.repeat(np.arange(len(branches)), sizes)
    dataset = _to_dataset(problem, rows, values, ids, events, harmonics, attrs)
    return dataset if sigma is None else with_scatter(dataset, branches, sigma)


def with_scatter(
    dataset: xr.Dataset, branches: Sequence[Branch], sigma: Mapping[str, float]
) -> xr.Dataset:
    """Return a dataset of branches with the derivatives and the scatter of the places of its bifurcations."""
    place = f"bifurcation_{str(dataset.attrs['follow']).split()[0]}"
    slopes, deviations = scattered_places(branches, sigma)
    with np.errstate(invalid="ignore", divide="ignore"):
        shares = (slopes * np.array([*sigma.values()]) / deviations[:, None]) ** 2
    return describe(
        dataset.assign_coords({PARAMETER: [*sigma]}).assign(
            {
                f"{place}{SENSITIVITY_SUFFIX}": (("bifurcation", PARAMETER), slopes),
                f"{place}_std": (("bifurcation",), deviations),
                f"{place}_contribution": (("bifurcation", PARAMETER), shares),
            }
        )
    )


def _to_dataset(
    problem: Problem,
    rows: Variables,
    values: np.ndarray,
    ids: np.ndarray,
    events: Sequence[LabelledEvent],
    harmonics: int,
    attrs: Mapping[str, Any],
) -> xr.Dataset:
    """Return steady states over `row`, the parameter there, and bifurcations as a described dataset."""
    import xarray as xr

    name, tied, labels = problem.name, problem.tied, coordinates(rows, harmonics)
    at = np.array([problem.values_at(value) for value in values])
    if tied is not None and PARAMETER in labels:
        columns = [tied.names.index(each) for each in tied.ties.free]
        rows, by = through_ties(rows, tied.ties, at[:, columns])
        labels = labels.assign({PARAMETER: np.array(by)})
    variables: Variables = {
        key: (tuple("point" if dim == "row" else dim for dim in dims), numbers)
        for key, (dims, numbers) in rows.items()
    }
    points = np.array([point for _kind, _reason, point in events], np.int64)
    kinds = [Bifurcation[kind.upper()] for kind, _reason, _point in events]
    dim = ("bifurcation",)
    is_singular = np.zeros(len(values), bool)
    is_singular[[point for kind, _reason, point in events if kind in SINGULAR]] = True
    _mask_sensitivities(variables, is_singular)
    variables |= {
        "branch_id": (("point",), ids),
        name: (("point",), values),
        **{
            each: (("point",), at[:, Parameters._fields.index(each)]) for each in problem.varied[1:]
        },
        "bifurcation_kind": (dim, np.array(kinds, np.int8)),
        f"bifurcation_{name}": (dim, values[points]),
        "bifurcation_point": (dim, points),
        "end_reason": (dim, np.array([reason for _kind, reason, _point in events], np.int8)),
    }
    coords: dict[str, Any] = {
        other: ((), np.array(value))
        for other, value in without_absent(exciter_at(problem, problem.low)._asdict()).items()
        if other not in problem.varied
    }
    dataset = xr.Dataset(variables | coords, labels, attrs)
    return describe(dataset.set_coords([*coords, *problem.varied, f"bifurcation_{name}"]))


def _mask_sensitivities(variables: Variables, is_singular: np.ndarray) -> None:
    """Set the sensitivities of points at which there is no derivative to NaN."""
    for name, (dims, numbers) in variables.items():
        if name.endswith(SENSITIVITY_SUFFIX):
            rows = is_singular
            if dims[0] == "impact":
                rows = np.repeat(is_singular, variables["row_size"][1])
            variables[name] = (
                dims,
                np.where(rows[(..., *[None] * (numbers.ndim - 1))], np.nan, numbers),
            )


def _parameters(problem: Problem, values: np.ndarray) -> np.ndarray:
    """Return the parameters (points, parameters) at values of the one that varies."""
    return np.array([exciter_at(problem, value) for value in values])


def _label(problem: Problem, branch: Branch, harmonics: int, outputs: tuple[str, ...]) -> Variables:
    """Return the steady states of the points of a branch as variables over `row`."""
    parameters = _parameters(problem, np.array(values_of(branch)))
    if problem.effects.has_pieces:
        rows = solve_branch_of_pieces(problem.effects, branch, parameters, harmonics, outputs)
    else:
        law = None if branch.curve is None else branch.curve.sequence
        unknowns = np.array([point.u for point in branch.points])
        rows = solve_orbits(law, unknowns, parameters, harmonics, outputs)
    return label_rows(rows, parameters, outputs)


def solve_orbits(
    law: Law | None,
    unknowns: np.ndarray,
    parameters: np.ndarray,
    harmonics: int,
    outputs: tuple[str, ...] = OF_STEADY_STATE,
    is_image: bool = False,
) -> RowResults:
    """Return the compacted results of orbits of one law that strike rigid supports, or none.

    law : of impacts, of half an orbit if it is mirrored; None, or without events: of the motion without impacts
    unknowns : (points, 2n + 1), times and velocities of the impacts, and one more number
    parameters : (points, parameters)
    outputs : any of `OF_BRANCH`
    is_image : whether the mirror images of these orbits are meant
    """
    if law is None or law.codes[0, CAUSE] == SECTION:
        none = np.zeros(0, np.int8)
        return solve_points(1, none, parameters, parameters[:, :1], harmonics, outputs)
    wholes = [whole_orbit(law, each) for each in unknowns]
    whole, unknowns = wholes[0][0], np.array([each for _law, each in wholes])
    supports = whole.codes[:, HOME].copy()
    if is_image:
        n, supports = supports.size, (3 - supports).astype(np.int8)
        unknowns[:, :n] += 0.5
        unknowns[:, n:] *= -1.0
    return solve_points(whole.m, supports, parameters, unknowns, harmonics, outputs)


def solve_points(
    m: int,
    supports: np.ndarray,
    parameters: np.ndarray,
    unknowns: np.ndarray,
    harmonics: int,
    outputs: tuple[str, ...] = OF_STEADY_STATE,
) -> RowResults:
    """Return the compacted results of orbits of one impact sequence.

    m : period multiple
    supports : (n,) int8, supports struck in turn over the whole orbit
    parameters : (points, parameters)
    unknowns : (points, 2n + 1), times and velocities of the impacts, and one more number
    outputs : any of `OF_BRANCH`
    """
    n, rows, outputs = len(supports), len(parameters), computed(outputs)
    listed = ImpactBuffer(np.empty(n * rows), np.empty(n * rows), np.empty(n * rows, np.int8))
    # Derivatives follow from the impacts, requested or not.
    has_impacts = not {"impacts", "sensitivity"}.isdisjoint(outputs)
    e = all_effects(columns_of(parameters))
    out = new_rows(rows, harmonics, outputs, listed if has_impacts else None, e)
    log, c = new_log(max(n, 1), 1), np.empty(DEGREE + 1)
    write_points(
        e, parameters, m, supports, np.ascontiguousarray(unknowns), log, c,
        np.zeros(2), out,
    )  # fmt: skip
    if "impacts" in outputs:
        out = compact_impacts(out)
        out = with_errors(out, parameters, max(n, 1), e.second_harmonic)
    if "sensitivity" in outputs:
        out = with_impact_derivatives(out)
        differentiate_rows(parameters, out, max(n, 1), e.second_harmonic)
    add_load(out, parameters[:, LOAD])
    return out if "impacts" in outputs else without_impacts(out)
