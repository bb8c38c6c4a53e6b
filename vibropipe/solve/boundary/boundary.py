"""The function `boundary`: curves of bifurcations and levels in two parameters, as a labelled dataset."""

from __future__ import annotations

import warnings
from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.orbits.boundaries.curve import Box
from vibropipe.orbits.law.marching import Marcher
from vibropipe.orbits.law.tied import Tied
from vibropipe.physics import limits
from vibropipe.physics.effects import all_effects, check_first_harmonic, effect_names
from vibropipe.physics.exciter import Exciter, ParameterError, Parameters
from vibropipe.physics.parameter_error import as_float
from vibropipe.physics.stated import stated_names, ties_of_call
from vibropipe.physics.ties import SAMPLES, Ties
from vibropipe.solve.boundary.boundary_dataset import Quantities, boundary_dataset
from vibropipe.solve.boundary.boundary_points import boundaries_of_rows
from vibropipe.solve.boundary.sought import check_levels, kinds_and_levels
from vibropipe.solve.branch.problem import KEEP_SYMMETRY, check_ground, is_symmetric
from vibropipe.solve.checks import check_law, check_varied, check_whole, with_frequency
from vibropipe.solve.physical import to_physical
from vibropipe.solve.sweep.blocks import LIMITS, solve_shard
from vibropipe.solve.sweep.sweep import grid_of
from vibropipe.solve.with_units import are_with_units, plain_levels, plain_name, plain_values
from vibropipe.words.parameters import FOLLOWED, PARAMETERS, RIGID_AT_ZERO, SOFT_ALONG
from vibropipe.words.records import FINITE
from vibropipe.words.status import UnsolvedWarning

if TYPE_CHECKING:
    import xarray as xr


def boundary(
    exciter: Exciter,
    of: str | Mapping[str, Any] | Collection[str | Mapping[str, Any]],
    along: tuple[str, str] = ("nu", "f"),
    within: Sequence[Sequence[float]] = ((0.3, 3.0), (0.05, 2.0)),
    lines: int = 12,
    max_step: float = 0.02,
    law: Sequence[int] | None = None,
    ties: Mapping[str, Any] | None = None,
) -> xr.Dataset:
    """Follow the curves of bifurcations, and of values of quantities, in two parameters through a box.

    An orbit by its impacts, as in `branch`, and one condition more are solved for both parameters: det(D - 1) = 0 of
    the derivative D of the return map (fold), det(D + 1) = 0 (flip; of the map to the mirror image of a symmetric
    orbit pitchfork), or a turning point on a support (grazing [2]_), which is the same curve as that on which the
    impact begins without velocity. Pseudo-arclength continuation [1]_ follows each curve to both ends. Points are
    admissible orbits, stable or not: no flight leaves the supports. With soft supports, friction or a housing that
    slides an orbit is flown through its law, a sequence of contacts, turns, sticks and slips, as in `branch`.

    On a level curve the condition is that a quantity of the orbit has a value: "struck at 0.8", or "does not progress".
    The quantity is computed from the unknowns as that of a steady state is. A level curve passes folds, flips and
    pitchforks of its orbit. It ends where the orbit touches a support, which begins another law, and that of doubled or
    asymmetric orbits on the flip or pitchfork that creates them.

    Curves are found from orbits that settle at the crossings of a grid of `lines` lines along each parameter, in
    the middle of equal cells: from (0, 0) and from their neighbours of both sides. Where supports are rigid and
    nothing else acts, these are orbits without rests and with at most 24 impacts. Each orbit is followed along both
    of its lines, round folds; so are the branches that begin at the bifurcations met. A level curve begins where a
    quantity passes its value between two points of a branch; of a mirror-symmetric exciter also that of the mirror
    image. What is smaller than a cell and touched by none of these branches may be missed.

    Parameters
    ----------
    exciter : Exciter
        Its own values of the two parameters are not used.
    of : str, mapping, or collection of these
        Kinds: fold, flip, pitchfork, grazing. Only an exciter that is mirror-symmetric in the whole box has
        pitchforks. And quantities with their values, named as columns of tables are: `{"impact_velocity_max_1": 0.8}`;
        any that a branch has and that depends continuously on the parameters. Of an exciter of `from_physical` a value
        may be text or a quantity of pint; then, and where one of `along` or `within` has a unit, bare numbers are in
        SI, and so is the dataset.
    along : (str, str)
        Any two parameters of an exciter but contact_1, contact_2 and wear_exponent; `k1` and `k2` only above 0, for 0
        is a rigid support. Of an exciter of
        `from_physical` also those with units, as omega and F: `within` is then in SI, text or quantities of pint, and
        the dataset is in SI.
    within : ((float, float), (float, float))
        Range of each.
    lines : int
        Number of lines along each parameter from which curves are sought, from 1 to 200.
    max_step : float
        Largest distance of neighbouring points, up to 0.1, where 1 is the range of a parameter, a forcing period, or
        the largest impact velocity of the first orbit of the curve.
    law : (int, int, int), optional
        Period multiple, up to 32, and impacts on each support, up to 64: only curves of orbits of this law, and the
        grazings at which its orbits begin, found as all others. Where mirror images are given once, either side may
        have the first number of impacts.
    ties : mapping of str to str or float, optional
        Parameters by expressions of others, as for `sweep`: what is tied to a parameter that varies varies with it, and
        so do names of one's own, which `along` may have. Curves of rigid supports then take some ten times as long.

    Returns
    -------
    xarray.Dataset
        Over `point`, in order along each curve, both parameters under their own names, what is tied to them, and

        curve_id
            Number of the curve.
        boundary_kind
            fold, flip, pitchfork, grazing or level.
        level_of
            If levels are sought, the number of the level, from 0, in the attribute `levels`, which lists quantities
            with their values; -1 at a bifurcation.
        period_multiple, impacts_per_orbit (support)
            The law of motion (m; p1, p2); at a grazing without the impact that begins.
        impact_velocity_max (support), displacement_strobe, velocity_strobe, floquet_multiplier (multiplier)
            As for `steady_state`; with a housing that slides, housing_velocity_strobe, and three multipliers, NaN where
            a curve ends with the law of its orbits.
        stable
            Whether the orbit is stable: but for the multiplier 1 or -1 of a bifurcation; as next to it where NaN.

        Over `meeting`, what a curve meets:

        meeting_kind
            box (a side of it), cusp, grazing_fold, grazing_flip, grazing_pitchfork, double_grazing, degenerate_flip,
            degenerate_pitchfork, chatter, rest, lost, points or, with friction or a housing, change: turns, sticks or
            slips begin or end. On a level curve also fold, flip, pitchfork and grazing: its orbit is that bifurcation.
        meeting_<parameter>, meeting_point, meeting_ends
            Both parameters, the index of the point, and whether the curve ends there.

        A curve without an end is closed. Mirror images of one another are given once, on level curves the one that has
        the value. The attribute `incomplete` says so if 64 curves with soft supports, friction or a housing, or as many
        steps as a call may take, do not suffice.

    Warns
    -----
    UnsolvedWarning
        If curves are left.

    Raises
    ------
    ParameterError
        If an argument is out of range, a second harmonic acts without a first one (f = 0), or a quantity is unknown or
        not one of these exciters.

    References
    ----------
    .. [1] H. B. Keller, Numerical solution of bifurcation and nonlinear eigenvalue problems, in: Applications of
       Bifurcation Theory, Academic Press 1977, 359-384.
    .. [2] A. B. Nordmark, Non-periodic motion caused by grazing incidence in an impact oscillator, Journal of Sound
       and Vibration 145 (1991) 279-297.
    """
    if isinstance(along, Mapping | set | frozenset):
        must = 'must be two names in their order, such as ("nu", "f"); their ranges are those of within'
        raise ParameterError("along", along, must=must)
    listed = of if isinstance(of, (list, tuple)) else [of]
    wanted_levels = [each for each in listed if isinstance(each, Mapping)]
    if isinstance(along, (list, tuple)) and are_with_units(
        exciter, dict.fromkeys(along), within, *wanted_levels
    ):
        dataset = boundary(
            exciter,
            plain_levels(exciter, of),
            tuple(map(plain_name, along)),  # type: ignore[arg-type]
            [plain_values(exciter, *each) for each in zip(along, within, strict=False)],
            lines,
            max_step,
            law,
            ties,
        )
        return to_physical(dataset, exciter)
    (kinds, levels), wanted = kinds_and_levels(of), None if law is None else check_law(law)
    exciter, tied = ties_of_call(exciter, ties, along)
    names = _check_along(along, tied)
    tied.check(stated_names(exciter), names, "along")
    given = exciter
    low, high, reached = _check_box(exciter, names, within, tied)
    lows = {name: float(np.min(values)) for name, values in reached.items()}
    exciter = with_frequency(exciter, lows)
    check_whole("lines", lines, limits.BOUNDARY_LINES)
    length = as_float("max_step", max_step, "a number above 0 up to 0.1")
    if not 0.0 < length <= 0.1:
        raise ParameterError("max_step", max_step, "a number above 0 up to 0.1")
    effects = all_effects({**vars(exciter), **reached}, pieces=True, housing=True)
    names_of_effects = effect_names(effects, {**vars(exciter), **reached})
    check_ground(exciter, effects, lows)
    highs = {name: float(np.max(values)) for name, values in reached.items()}
    check_levels({**vars(exciter), **highs}, levels)
    exciter = tied.applied(exciter, dict(zip(names, low.tolist(), strict=True)) if tied else {})
    follows = Tied(tied, names) if tied else None
    known = Parameters._fields if follows is None else follows.names
    own = [float(low[names.index(name)]) for name in known[len(Parameters._fields) :]]
    box = Box(
        np.array([*exciter.numbers(), *own]), np.array([known.index(name) for name in names], np.int64),
        low, high, _stays_symmetric(exciter, names, reached, tied), length, effects, follows,
    )  # fmt: skip
    rows = _settled(given, names, box, lines, tied)
    quantities = Quantities(Marcher(effects))
    sought = quantities.levels(levels, exciter.l)
    curves, missing = boundaries_of_rows(box, rows, kinds, sought)
    dataset = boundary_dataset(box, curves, wanted, levels, quantities, names_of_effects)
    if missing:
        dataset.attrs["incomplete"] = f"{len(curves)} curves are {missing}"
        remedy = "Choose a smaller box, or fewer kinds of bifurcation."
        warnings.warn(f"{dataset.attrs['incomplete']}. {remedy}", UnsolvedWarning, stacklevel=3)
    return dataset


def _check_along(along: tuple[str, str], ties: Ties) -> tuple[str, str]:
    """Return the names of both parameters, or raise a ParameterError."""
    names = tuple(along) if isinstance(along, (list, tuple)) else ()
    known = (*FOLLOWED, *ties.own)
    if len(set(names)) != 2 or len(names) != 2 or not set(names) <= {*known}:
        raise ParameterError("along", along, f"two of {', '.join(known)}")
    return names[0], names[1]


def _check_box(
    exciter: Exciter, names: tuple[str, str], within: Any, ties: Ties
) -> tuple[np.ndarray, np.ndarray, dict[str, np.ndarray]]:
    """Return the ends of both parameters, and values of what varies over the box; ParameterError if one is not allowed.

    Of a box without ties the values are both ends of each.
    """
    allowed = "two pairs of increasing numbers"
    pairs = [list(ends) for ends in within] if np.ndim(within) == 2 else []
    if [len(pair) for pair in pairs] != [2, 2]:
        raise ParameterError("within", within, allowed)
    for name, pair in zip(names, pairs, strict=True):
        rule = PARAMETERS[name].range if name in PARAMETERS else FINITE
        for value in pair:
            if not rule.contains(as_float("within", value, rule.text)):
                raise ParameterError("within", value, f"{rule.text} for {name}")
        if not pair[0] < pair[1]:
            raise ParameterError("within", within, allowed)
        if name in RIGID_AT_ZERO and pair[0] == 0.0:
            raise ParameterError(name, 0.0, must=SOFT_ALONG)
    ends = np.array(pairs, float)
    reached = dict(zip(names, ends, strict=True))
    if ties:
        grids = np.meshgrid(*(np.linspace(low, high, SAMPLES) for low, high in ends))
        reached = {name: grid.ravel() for name, grid in zip(names, grids, strict=True)}
        reached |= ties.followed({**exciter.numbers()._asdict(), **reached}, names)
        reached = {name: values for name, values in reached.items() if name in PARAMETERS}
    lows = {name: float(values.min()) for name, values in reached.items()}
    check_varied("along", exciter, reached, lows)
    for first in pairs[0]:
        for second in pairs[1]:
            corner = ties.applied(exciter, {names[0]: first, names[1]: second})
            all_effects(vars(corner), pieces=True, housing=True)
    check_first_harmonic({**vars(exciter), **reached})
    return ends[:, 0], ends[:, 1], reached


def _stays_symmetric(
    exciter: Exciter, names: tuple[str, str], reached: Mapping[str, np.ndarray], ties: Ties
) -> bool:
    """Return whether an exciter is its own mirror image in the whole box; reached : values of what varies in it."""
    if not ties:
        return is_symmetric(exciter) and {*names} <= {*KEEP_SYMMETRY}
    own, rows = exciter.numbers(), zip(*(each.tolist() for each in reached.values()), strict=True)
    return all(is_symmetric(own._replace(**dict(zip(reached, row, strict=True)))) for row in rows)


def _settled(
    exciter: Exciter, names: tuple[str, str], box: Box, lines: int, ties: Ties
) -> list[xr.Dataset]:
    """Return what settles at the crossings of a grid of lines, from rest and from neighbours of each side."""
    middles = (np.arange(lines) + 0.5) / lines
    over = {
        name: low + middles * (high - low)
        for name, low, high in zip(names, box.low, box.high, strict=True)
    }
    follows = [None, *((name, way) for name in names for way in ("up", "down"))]
    grids = [grid_of(exciter, over, follow, ties.texts) for follow in follows]
    work = LIMITS._replace(row_work=limits.row_work(sum(grid.rows for grid in grids)))
    options = {"outputs": ("harmonics", "impacts"), "harmonics": 1, "limits": work}
    return [solve_shard(grid, 0, grid.rows, **options) for grid in grids]
