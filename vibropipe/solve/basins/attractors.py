"""The function `attractors`: the motions of one exciter that scattered starts settle on, as a labelled dataset."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.physics.bounds import ultimate_bound
from vibropipe.physics.exciter import Exciter
from vibropipe.physics.start import within_room
from vibropipe.solve.basins.attractor_set import Attractor, AttractorSet
from vibropipe.solve.basins.knocks import knocks_of
from vibropipe.solve.basins.of_housing import settle_rows
from vibropipe.solve.checks import check_whole
from vibropipe.solve.equilibrium import about_equilibrium
from vibropipe.solve.rows.steady import steady_state
from vibropipe.words.vocabulary import describe

if TYPE_CHECKING:
    import xarray as xr

# Scattered starts by default, which find an attractor of a basin share of 0.2 % as good as surely, and their limits.
STARTS, STARTS_LIMITS = 4096, (1, 10**7)
# The same with a housing that slides, whose motions take longer.
STARTS_OF_HOUSING = 512
# States at the section stored for each attractor.
VISITS = 1024
# Quantile of the normal distribution of a two-sided confidence level of 95 %.
QUANTILE_95 = 1.959963984540054


def attractors(exciter: Exciter, starts: int | None = None, harmonics: int = 6) -> xr.Dataset:
    """Find the motions that eqs. (5), (6) settle on from starts scattered over the states that the mass can reach.

    Each start is marched until its motion enters a neighbourhood of a known attractor that no motion leaves, or is
    solved as a steady state, which may be a new one. Attractors are told apart by their states at the stroboscopic
    section, not by their labels. This is the method of [1]_ with neighbourhoods in place of recurrences: an orbit is
    certain once its neighbourhood is entered. One without an orbit is recognised by the cells that it visits.

    Parameters
    ----------
    exciter : Exciter
    starts : int
        Number of starts, up to 1e7, a Halton sequence [2]_ of displacements between the supports and velocities up to
        `reachable_velocity`, at tau = 0 (default: 4,096; 512 with a housing that slides, which is at rest then).
    harmonics : int
        Number of harmonics, from 1 to 1000.

    Returns
    -------
    xarray.Dataset
        Over `attractor_id`, orbits first, by `period_multiple` and then by displacement at the section; empty if no
        start settles, as without damping and loss:

        knock, knock_impulse
            Least distance, sqrt(dx^2 + dv^2), and least change of velocity (in SI an impulse, N s) at the section after
            which the motion is another: all smaller ones that were tried, 64 of equal steps along 24 directions and up
            and down, lead back. A tongue of another basin that is narrower than a step may be missed; `prove_knock`
            proves lower bounds. NaN where none tried up to `reachable_velocity` does not lead back, without an orbit,
            and of an orbit of more than 32 forcing periods. Not with a housing that slides.
        basin_share, basin_share_low, basin_share_high
            Share of the starts that settle on it, and the 95 % confidence interval [3]_ for as many random starts.
        poincare_displacement, poincare_velocity (visit)
            States at the section one after the other.

        and all that `steady_state` returns; `impact_*` as a contiguous ragged array with `row_size`.

    Raises
    ------
    ParameterError
        If an argument is out of range.

    Notes
    -----
    With a housing that slides each start is solved as a steady state, and motions are told apart by what they show:
    orbits by period multiple, impacts, displacement and progression, motions without an orbit by the way of the housing
    alone.

    References
    ----------
    .. [1] G. Datseris, A. Wagemakers, Effortless estimation of basins of attraction, Chaos 32 (2022) 023104.
    .. [2] J. H. Halton, On the efficiency of certain quasi-random sequences of points in evaluating
       multi-dimensional integrals, Numerische Mathematik 2 (1960) 84.
    .. [3] E. B. Wilson, Probable inference, the law of succession, and statistical inference, Journal of the American
       Statistical Association 22 (1927) 209.
    """
    if starts is None:
        starts = STARTS if exciter.mass_ratio == 0.0 else STARTS_OF_HOUSING
    check_whole("starts", starts, STARTS_LIMITS)
    if exciter.mass_ratio > 0.0:
        scattered = scattered_starts(exciter, starts)
        owner, _periods, first = settle_rows(exciter, scattered)
        return motions_dataset(exciter, owner, first, harmonics, f"{starts} scattered")
    attractor_set = AttractorSet(exciter)
    owner, _periods = attractor_set.settle(scattered_starts(exciter, starts))
    text = f"{starts} scattered, |v0| <= {reachable_velocity(exciter):g}"
    dataset, _numbers = attractor_dataset(attractor_set, owner, harmonics, text)
    return dataset


def reachable_velocity(exciter: Exciter) -> float:
    """Return a bound of |x'| within a forcing period after a start at rest, and ever if damping gives a lower one.

    Energy of the start and of the force bounds the first; `ultimate_bound` is the second, which needs the equilibrium
    between rigid supports, and no friction.
    """
    exciter = about_equilibrium(exciter)
    is_linear = exciter.k1 == 0.0 and exciter.k2 == 0.0 and exciter.friction == 0.0
    farthest = max(abs(exciter.upper), abs(exciter.lower))
    force = abs(exciter.f) + abs(exciter.f2)
    bound = farthest + force * exciter.period
    if is_linear and exciter.h > 0 and exciter.lower <= 0 <= exciter.upper:
        bound = min(bound, float(ultimate_bound(exciter.h, force, farthest)))
    return bound


def scattered_starts(exciter: Exciter, n: int) -> np.ndarray:
    """Return n starts (n, 2) of low discrepancy between the supports, up to `reachable_velocity`."""
    from scipy.stats import qmc

    # The first point of the sequence is a corner.
    points = qmc.Halton(2, scramble=False).random(n + 1)[1:]
    velocity = reachable_velocity(exciter)
    scaled: np.ndarray = qmc.scale(points, [exciter.lower, -velocity], [exciter.upper, velocity])
    return scaled


def attractor_dataset(
    attractor_set: AttractorSet, owner: np.ndarray, harmonics: int, start: str
) -> tuple[xr.Dataset, np.ndarray]:
    """Return the dataset of the attractors found, and the number of the attractor of each start.

    owner : (n,), index of the attractor of each start in the order in which they were found, or negative
    start : the starts, for the attributes
    Returns the number as `attractor_id` (n,); -1 for none.
    """
    import xarray as xr

    ids = attractor_ids(attractor_set)
    numbers = ids[np.maximum(owner, -1)]
    numbered = [attractor_set.known[index] for index in np.argsort(ids[:-1])]
    states = np.array([states_at_section(each) for each in numbered]).reshape(-1, VISITS, 2)
    exciter = attractor_set.section.exciter
    velocity = reachable_velocity(exciter)
    each_knock = [
        knocks_of(attractor_set, attractor_set.known[index], int(index), velocity)
        for index in np.argsort(ids[:-1])
    ]
    knocks = np.array(each_knock).reshape(-1, 2)
    sections = [each.sections[0 if each.period_multiple else -1] for each in numbered]
    pairs = [(float(within_room(exciter, float(x))), float(v)) for x, v in sections]
    dataset = steady_states(exciter, pairs, harmonics)
    dataset = dataset.assign_attrs(start=start).assign_coords(
        attractor_id=np.arange(len(numbered), dtype=np.int32)
    )
    variables: dict[str, Any] = {
        **share_variables(numbers, len(numbered)),
        "knock": ("attractor_id", knocks[:, 0]),
        "knock_impulse": ("attractor_id", knocks[:, 1]),
        "poincare_displacement": (("attractor_id", "visit"), states[:, :, 0]),
        "poincare_velocity": (("attractor_id", "visit"), states[:, :, 1]),
    }
    return describe(xr.Dataset(variables, attrs=dataset.attrs).merge(dataset)), numbers


def motions_dataset(
    exciter: Exciter, owner: np.ndarray, first: np.ndarray, harmonics: int, start: str
) -> xr.Dataset:
    """Return the dataset of the motions that starts settle on, from those of `of_housing.settle_rows`."""
    import xarray as xr

    pairs = [(float(x), float(v)) for x, v in first]
    dataset = steady_states(exciter, pairs, harmonics).assign_attrs(start=start)
    dataset = dataset.assign_coords(attractor_id=np.arange(len(first), dtype=np.int32))
    sections = [_poincare(exciter, *pair) for pair in pairs]
    states = np.array(sections) if sections else np.empty((0, 2, 0))
    variables: dict[str, Any] = {
        **share_variables(owner, len(first)),
        "poincare_displacement": (("attractor_id", "visit"), states[:, 0]),
        "poincare_velocity": (("attractor_id", "visit"), states[:, 1]),
    }
    return describe(xr.Dataset(variables, attrs=dataset.attrs).merge(dataset))


def _poincare(exciter: Exciter, x0: float, v0: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the states at the section that the motion from a start settles on."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="status max_periods")
        row = steady_state(exciter, x0=x0, v0=v0, outputs=("poincare",))
    return row["poincare_displacement"].values, row["poincare_velocity"].values


def attractor_ids(attractor_set: AttractorSet) -> np.ndarray:
    """Return the `attractor_id` of each attractor of a set, and at the end -1, for none."""
    order = sorted(
        range(len(attractor_set.known)), key=lambda index: attractor_set.known[index].sort_key()
    )
    ids = np.full(len(order) + 1, -1, np.int32)
    ids[order] = np.arange(len(order))
    return ids


def shares(counts: np.ndarray, n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return shares counts/n with their 95 % confidence intervals (low, high) by Wilson's score.

    counts : (k,)
    n : number of starts, > 0
    """
    share, z2 = counts / n, QUANTILE_95**2 / n
    centre = (share + 0.5 * z2) / (1 + z2)
    half = QUANTILE_95 * np.sqrt(share * (1 - share) / n + 0.25 * z2 / n) / (1 + z2)
    # None, or all, of the starts leave 0, or 1, possible: not to rounding.
    low, high = np.where(counts == 0, 0.0, centre - half), np.where(counts == n, 1.0, centre + half)
    return share, low, high


def share_variables(owner: np.ndarray, n: int) -> dict[str, Any]:
    """Return the shares of starts that settle on each of n attractors, and the ends of their confidence intervals."""
    counts = np.bincount(owner[owner >= 0], minlength=n)
    names = ("basin_share", "basin_share_low", "basin_share_high")
    each = zip(names, shares(counts, owner.size), strict=True)
    return {name: ("attractor_id", values) for name, values in each}


def states_at_section(attractor: Attractor, visits: int = VISITS) -> np.ndarray:
    """Return some states (visits, 2) of an attractor at the section, one after the other."""
    n = len(attractor.sections)
    last: np.ndarray = attractor.sections[np.arange(n - visits, n) % n]
    return last


def steady_states(
    exciter: Exciter, starts: Sequence[tuple[float | None, float]], harmonics: int
) -> xr.Dataset:
    """Return the steady states from some starts over `attractor_id`; `impact` is ragged.

    Without starts, the variables are those of one motion, over dimensions without entries.
    """
    import xarray as xr

    each = []
    for x0, v0 in starts or ((None, 0.0),):
        with warnings.catch_warnings():
            # An attractor without an orbit is no failure, nor is a motion that is left out.
            warnings.filterwarnings("ignore", message="status max_periods" if starts else "")
            each.append(steady_state(exciter, x0=x0, v0=v0, harmonics=harmonics))
    impacts = [dataset[list(_over_impacts(dataset))] for dataset in each]
    # VISITS states at the section are stored in place of those that a steady state may have.
    rows = [dataset.drop_dims(["impact", "visit"], errors="ignore") for dataset in each]
    for row, dataset in zip(rows, impacts, strict=True):
        row["row_size"] = dataset.sizes["impact"]
    kwargs: Any = {"coords": "minimal", "compat": "override", "combine_attrs": "override"}
    joined = xr.concat(rows, "attractor_id", data_vars="all", **kwargs)
    flat = xr.concat(impacts, "impact", data_vars="minimal", **kwargs)
    merged = joined.merge(flat.drop_vars(joined.coords, errors="ignore"))
    return merged if starts else merged.isel(attractor_id=slice(0), impact=slice(0))


def _over_impacts(dataset: xr.Dataset) -> list[str]:
    return [str(name) for name, variable in dataset.data_vars.items() if "impact" in variable.dims]
