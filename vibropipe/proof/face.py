"""The functions `prove`, `prove_bifurcation`, `prove_all`, `prove_knock`: theorems on orbits, as labelled datasets."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from vibropipe.physics.effects import all_effects
from vibropipe.physics.exciter import Exciter, ParameterError
from vibropipe.physics.limits import HARMONICS
from vibropipe.physics.stated import check_untied
from vibropipe.solve.checks import check_whole
from vibropipe.words.progress import Progress
from vibropipe.words.proofs import BOXED

if TYPE_CHECKING:
    import xarray as xr

# Parts of a box, or intervals, that are examined at most.
PARTS, PARTS_LIMITS = 2000, (1, 10**7)
INTERVALS = 100_000
# Cells of starts about an orbit.
CELLS = 1000
STRETCHES = 0, 10_000
MAX_MULTIPLE = 100
# Impacts on either support of the laws of which all orbits can be found.
IMPACTS = (1, 1), (1, 0), (0, 1), (2, 1), (1, 2)


def prove(
    orbit: Exciter | xr.Dataset,
    within: Mapping[str, float] | None = None,
    harmonics: int = 3,
    parts: int = PARTS,
    largest: bool = False,
    stretches: int = 0,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Prove that an orbit exists, is the only one nearby and is a motion, for every exciter within tolerances.

    Balls, which certainly contain a number, take the place of numbers (python-flint, the extra `proof`). What is proved
    holds of the equations of motion and not only of their rounding; docs/proof.md tells how. Supports are rigid or
    soft, with or without dry friction.

    Parameters
    ----------
    orbit : Exciter or xarray.Dataset
        An exciter, whose motion from rest settles on the orbit; or one row of a steady state, a sweep, a branch or an
        orbit in closed form, stable or not. Of a whole sweep or branch each row is proved on its own, the exciters
        `within` tolerances about its own.
    within : mapping of str to float, optional
        How far parameters may be off, either way, all at once: any of nu, f, h, l, delta, R1, R2, load, f2, phi2,
        shaker and, where they act, k1, h1, k2, h2, friction. Without it the exciter alone is meant, its parameters
        exact doubles.
    harmonics : int
        Number of harmonics, from 1 to 1,000.
    parts : int
        Parts of the box, and exciters in it, that are examined at most.
    largest : bool
        Also seek how much larger, or smaller, `within` may be. Takes some ten times as long.
    stretches : int
        Equal stretches of the orbit, up to 10,000, on each of which the displacement gets bounds; 0 for none.
    progress : callable, optional
        Called as progress(done, total), in rows.

    Returns
    -------
    xarray.Dataset
        proved, why
            proved: each exciter within the tolerances has exactly one orbit of this law nearby, which depends
            continuously on the parameters; nothing but the events of the law happens: no flight leaves the supports,
            and friction lets go, turns or holds the mass there alone; it has no shorter period; and its stability is
            `proved_stable` throughout. disproved: `counterexample` is an exciter within the tolerances whose orbit of
            the same family leaves the supports or its law, or has the other stability. undecided: neither. `why` names
            what is not proved, or disproved.
        proved_stable
            stable (both multipliers within the unit circle), unstable or undecided.
        <name>_low, <name>_high
            Bounds over all these exciters, rounded outwards to the last digit, NaN unless proved: impact_phase,
            impact_velocity (impact), displacement_mean, displacement_strobe, velocity_strobe, displacement_amplitude
            (harmonic), trace and determinant of the derivative of the return map, spectral_radius; with `stretches`
            displacement (phase), from each fraction of the orbit to the next. A phase of an impact may lie below 0 or
            above 1, counted from the start of `impact_period`. An amplitude at resonance without damping, which the
            impacts do not determine, is only bounded by 4 l/pi.
        uniqueness_radius
            No exciter has another orbit of this law all of whose events are nearer than this: their phases in forcing
            periods, velocities in shares of the largest one, displacements where friction acts in shares of l.
        period_multiple, impacts_per_orbit (support), impact_support, impact_period (impact)
            The law.
        parts
            Parts and exciters examined.
        within, counterexample (parameter)
            The tolerances, and the parameters of the counterexample, NaN if there is none. Only with `within`.
        largest
            With `largest`, the largest factor of `within` found for which all is proved, to 5 %; else 1, or NaN if it
            is not proved.

        The attribute `statement` is what was found, as a sentence; `events` names the events of the law in turn.

        Of several rows `proved`, `why` and `proved_stable` alone, over their dimensions; `not_tried` are those without
        an orbit, with rests, without impacts or with more than 100. Of a branch also `bifurcation_proved` and bounds
        bifurcation_<along>_low, bifurcation_<along>_high of its folds, flips, pitchforks and grazings.

    Raises
    ------
    ParameterError
        If the motion is no orbit, or has rests or no impacts, or the exciter has a housing that slides, a support
        that only pushes (`contact_1`) or a static friction above the kinetic one, or an argument is out of range.
    ModuleNotFoundError
        If python-flint is not installed.

    References
    ----------
    R. Krawczyk, Newton-Algorithmen zur Bestimmung von Nullstellen mit Fehlerschranken, Computing 4 (1969) 187-201.
    W. Tucker, Validated Numerics, Princeton University Press 2011.
    F. Johansson, Arb: efficient arbitrary-precision midpoint-radius interval arithmetic, IEEE Transactions on Computers
    66 (2017) 1281-1292.
    """
    from vibropipe.proof.given import check_within, given_orbit
    from vibropipe.proof.rows import dims_of_rows, prove_rows
    from vibropipe.proof.statement import prove_orbit

    check_whole("harmonics", harmonics, HARMONICS)
    check_whole("parts", parts, PARTS_LIMITS)
    check_whole("stretches", stretches, STRETCHES)
    if not isinstance(orbit, Exciter) and dims_of_rows(orbit):
        if largest or stretches:
            must = "must be left out with several rows: select one, as with .isel(point=0)"
            raise ParameterError("largest" if largest else "stretches", None, must=must, got="")
        return prove_rows(orbit, progress, within, parts)
    given = given_orbit(orbit)
    tolerances = None if within is None else check_within(given.exciter, within)
    if isinstance(orbit, Exciter):
        check_untied(orbit, "within", within or ())
    return prove_orbit(given, tolerances, harmonics, parts, largest, stretches)


def prove_bifurcation(orbit: Exciter | xr.Dataset, kind: str, along: str) -> xr.Dataset:
    """Prove that an orbit has a bifurcation near it, and enclose the value of a parameter at which it has.

    Parameters
    ----------
    orbit : Exciter or xarray.Dataset
        An orbit near the bifurcation, as of `prove`; of a branch the row `bifurcation_point`.
    kind : str
        fold: its orbits turn back, two on one side and none on the other. flip: a multiplier passes -1, and orbits of
        twice the period begin. pitchfork: an orbit that is its own mirror image half an orbit later has a multiplier
        that passes 1, and a pair of orbits that mirror each other begins. grazing: it touches a support between its
        impacts, and strikes it on one side; both supports if it is its own mirror image. Pitchforks and grazings are
        those between rigid supports without friction.
    along : str
        The parameter that varies, as in `within` of `prove`; the others are exact doubles.

    Returns
    -------
    xarray.Dataset
        proved, why
            proved: exactly one such bifurcation of the law lies nearby (at a pitchfork or a touch of both supports: of
            its symmetric orbits), it is regular (what is said of its kind holds, with non-zero speed in the parameter),
            and no flight leaves the supports there. undecided: `why` names what is not proved.
        <along>_low, <along>_high
            Bounds of the parameter, rounded outwards to the last digit, NaN unless proved; so are those of
            impact_phase and impact_velocity (impact).
        bifurcation_kind, grazing_support
            The kind, and the support that is touched (0: none, 3: both).
        period_multiple, impacts_per_orbit (support), impact_support, impact_period (impact)
            The law.

        The attribute `statement` is what was found, as a sentence.

    Raises
    ------
    ParameterError
        If the motion is no orbit that `prove` takes, or an argument is none of those above.
    ModuleNotFoundError
        If python-flint is not installed.

    References
    ----------
    Yu. A. Kuznetsov, Elements of Applied Bifurcation Theory, Springer 2004.
    R. Krawczyk, Newton-Algorithmen zur Bestimmung von Nullstellen mit Fehlerschranken, Computing 4 (1969) 187-201.
    """
    from vibropipe.proof.bifurcation import KINDS, is_sought
    from vibropipe.proof.given import check_varies, given_orbit
    from vibropipe.proof.statement import prove_critical

    if kind not in KINDS:
        raise ParameterError("kind", kind, f"one of {', '.join(KINDS)}")
    if along not in BOXED:
        raise ParameterError("along", along, f"one of {', '.join(BOXED)}")
    if isinstance(orbit, Exciter):
        check_untied(orbit, "along", [along])
    given = given_orbit(orbit)
    check_varies(given.exciter, along, "along")
    if not is_sought(KINDS[kind], given.law):
        must = "must be fold or flip with soft supports or friction"
        raise ParameterError("kind", kind, must=must, got=repr(kind))
    return prove_critical(given, KINDS[kind], along)


def prove_knock(
    orbit: Exciter | xr.Dataset, cells: int = CELLS, progress: Progress | None = None
) -> xr.Dataset:
    """Prove how hard a stable orbit may be hit: within which distance all motions settle on it.

    Balls, as of `prove`, enclose all motions that begin in a cell of states: their impacts, what is between them, and
    where they are after some periods. docs/proof.md tells how. Supports are rigid or soft, without friction.

    Parameters
    ----------
    orbit : Exciter or xarray.Dataset
        As of `prove`; it may have no impacts.
    cells : int
        Cells that are examined at most, for each of both knocks, from 1 to 1e7; more of them prove more, and 1,000 take
        some 5 s.
    progress : callable, optional
        Called as progress(done, total), in cells, for each of both.

    Returns
    -------
    xarray.Dataset
        knock_low, knock_impulse_low
            All motions settle on the orbit that begin at the section, tau = 0, at a state nearer than `knock_low` to
            one of the orbit there, sqrt(dx^2 + dv^2), between the supports; or at its displacement, with a velocity
            less than `knock_impulse_low` off. Lower bounds of `knock` and `knock_impulse` of `attractors`, which are
            sought by marching. NaN if nothing is proved.
        proved, why
            proved, or undecided: `why` names what is not proved.
        parts
            Cells examined.
        period_multiple, impacts_per_orbit (support)
            The law.

        The attribute `statement` is what was found, as a sentence.

    Raises
    ------
    ParameterError
        If the motion is no orbit that `prove` takes, or not stable, or there is friction, or an argument is out of
        range.
    ModuleNotFoundError
        If python-flint is not installed.

    References
    ----------
    W. Tucker, Validated Numerics, Princeton University Press 2011.
    """
    from vibropipe.proof.knock import prove_knocks

    return prove_knocks(orbit, check_whole("cells", cells, PARTS_LIMITS), progress)


def prove_all(
    exciter: Exciter,
    law: Sequence[int] = (1, 1, 1),
    harmonics: int = 3,
    parts: int = INTERVALS,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Prove which orbits of a law an exciter has: exactly these, stable or not.

    The length of one flight decides, of three impacts those of two: the equations are linear in all else. Branch and
    bound over all of their values leaves out none [1]_; docs/proof.md tells how. Needs python-flint, the extra `proof`.

    Parameters
    ----------
    exciter : Exciter
        With rigid supports, f other than 0 and f2 = 0; its parameters are exact doubles.
    law : sequence of int
        (m, p1, p2): forcing periods, up to 100, and impacts on each support: (m, 1, 1), (m, 1, 0) or (m, 0, 1); with
        three impacts, (m, 2, 1) or (m, 1, 2), it takes up to a minute.
    harmonics : int
        Number of harmonics, from 1 to 1,000.
    parts : int
        Intervals, or boxes of two lengths, that are examined at most.
    progress : callable, optional
        Called as progress(done, total) with three impacts.

    Returns
    -------
    xarray.Dataset
        Over `orbit`, what `prove` returns of each; orbits that differ by whole forcing periods are one.

        proved, why
            proved: these are all orbits of the law. undecided: these orbits exist, and there may be others.

        The attribute `statement` is what was found, as a sentence. It says nothing of other laws, of rests and chatter.

    Raises
    ------
    ParameterError
        If the law or the exciter is none of those above.
    ModuleNotFoundError
        If python-flint is not installed.

    References
    ----------
    .. [1] R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, SIAM 2009.
    """
    from vibropipe.proof.statement import prove_every

    check_whole("harmonics", harmonics, HARMONICS)
    check_whole("parts", parts, PARTS_LIMITS)
    exciter.check_frequency()
    all_effects(vars(exciter))
    if exciter.f == 0.0:
        raise ParameterError(
            "f", exciter.f, must="must not be 0: the orbits have the period of the force"
        )
    if exciter.f2 != 0.0:
        raise ParameterError("f2", exciter.f2, must="must be 0: the force must have one harmonic")
    return prove_every(exciter, _check_law(law), harmonics, parts, progress)


def _check_law(law: Any) -> tuple[int, int, int]:
    """Return a law (m, p1, p2) that is known, or raise a ParameterError."""
    known = ", ".join(f"(m, {p1}, {p2})" for p1, p2 in IMPACTS)
    allowed = f"one of {known} with a whole number m of forcing periods"
    try:
        m, p1, p2 = law
    except (TypeError, ValueError):
        raise ParameterError("law", law, allowed) from None
    check_whole("law", m, (1, MAX_MULTIPLE))
    if (p1, p2) not in IMPACTS:
        raise ParameterError("law", law, allowed)
    return int(m), int(p1), int(p2)
