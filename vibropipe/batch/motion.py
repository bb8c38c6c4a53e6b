"""One motion as a labelled dataset: the face `simulate`."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vibropipe.batch.free import contacts, positions
from vibropipe.kernels.grid import Grid, exact_grid, locate, newmark_grid
from vibropipe.kernels.march import march
from vibropipe.kernels.record import (
    GRAZINGS,
    IMPACTS,
    RESTS,
    SHORT_FLIGHTS,
    Samples,
    new_log,
)
from vibropipe.kernels.state import REST, begin
from vibropipe.physics.conservative import arc, is_free
from vibropipe.physics.contact import to_displacement, to_velocity
from vibropipe.physics.effects import ALL_EFFECTS
from vibropipe.physics.exciter import Exciter, ParameterError, number
from vibropipe.physics.flow import ORDER
from vibropipe.status import Status
from vibropipe.vocabulary import describe

if TYPE_CHECKING:
    import xarray as xr

METHODS = ("exact", "newmark")
LOG_ROOM = 1024
MAX_SAMPLES = 200_000_000


def simulate(
    exciter: Exciter,
    tau_end: float = 60.0,
    x0: float = 0.0,
    v0: float = 0.0,
    method: str = "exact",
    steps_per_period: int | None = None,
    samples_per_period: int = 256,
    *,
    tau_start: float = 0.0,
    max_impacts: int = 10_000_000,
) -> xr.Dataset:
    """The motion of eqs. (5), (6) from (x0, v0) at tau_start to tau_end.

    method: "exact" (first impacts certified, errors of rounding only) or "newmark" (constant average
    acceleration with `steps_per_period` steps, impacts located inside the step).
    samples_per_period: samples of the motion per forcing period 2 pi / nu; 0 records none.

    Returns a dataset (all non-dimensional): `displacement, velocity, force` over `tau` (from tau_start, the
    last sample exactly tau_end); `impact_tau, impact_support, impact_velocity` (before, signed),
    `impact_velocity_after` over `impact`; `rest_start, rest_end` (inf if not released before tau_end),
    `rest_support` over `rest`; `grazing_tau, grazing_support` over `grazing`; `displacement_end, velocity_end`
    (after an impact at tau_end itself); `status`: `short_flights` when Newmark flights were shorter than a
    step, `max_impacts` when more contacts happen than allowed (then the motion is nan from there on).
    Raises ParameterError for a value outside what is allowed.
    """
    x, v = exciter.check_start(x0, v0)
    turns = _turns(exciter, tau_start, tau_end)
    _check_samples(samples_per_period)
    p = exciter.parameters()
    if method == "exact" and steps_per_period is None and is_free(p, x, v):
        run = _free(
            exciter, tau_start, tau_end - tau_start, x, v, _sample_times(turns, samples_per_period)
        )
    else:
        grid = _grid(exciter, method, steps_per_period)
        samples = _samples(grid, turns, samples_per_period)
        state = begin(ALL_EFFECTS, p, grid, turns[0], x, v)
        run = _march(p, grid, state, turns[1], samples, max_impacts)
    return _dataset(exciter, tau_start, tau_end, turns, samples_per_period, run)


class _Run(NamedTuple):
    """What a motion left: Status, contacts by name of variable, samples before the end, (x, v) at the end."""

    status: Status
    contacts: dict[str, np.ndarray]
    displacement: np.ndarray
    velocity: np.ndarray
    end: tuple[float, float]


def _free(
    exciter: Exciter, tau_start: float, span: float, x: float, v: float, turns: np.ndarray
) -> _Run:
    """A conservative motion, in closed form; turns: times of samples after the start, in forcing periods."""
    a = arc(exciter.parameters(), x, v)
    times = np.append(turns * exciter.period, span)
    xs, vs = positions(a, times)
    # The start as it was given, on a support before the impact.
    xs[0], vs[0] = (x, v) if times[0] == 0.0 and times.size > 1 else (xs[0], vs[0])
    struck = contacts(a, span, x, v, exciter.upper, exciter.lower)
    for name in ("impact_tau", "grazing_tau"):
        struck[name] += tau_start
    return _Run(Status.OK, struck, xs[:-1], vs[:-1], (float(xs[-1]), float(vs[-1])))


def _turns(exciter: Exciter, tau_start: float, tau_end: float) -> tuple[float, float]:
    start = number("tau_start", tau_start, "a finite number >= 0")
    end = number("tau_end", tau_end, "a finite number >= tau_start")
    if not (math.isfinite(start) and start >= 0):
        raise ParameterError(f"tau_start = {start!r}: allowed is a finite number >= 0")
    if not (math.isfinite(end) and end >= start):
        raise ParameterError(f"tau_end = {end!r}: allowed is a finite number >= {start!r}")
    turns = (start * exciter.nu / (2 * math.pi), end * exciter.nu / (2 * math.pi))
    if turns[1] > 2**52:
        raise ParameterError(f"tau_end = {end!r}: allowed are at most 2**52 forcing periods")
    return turns


def _grid(exciter: Exciter, method: str, steps_per_period: int | None) -> Grid:
    if method not in METHODS:
        raise ParameterError(f"method = {method!r}: allowed is one of {', '.join(METHODS)}")
    if method == "exact":
        if steps_per_period is not None:
            raise ParameterError(
                f"steps_per_period = {steps_per_period!r}: allowed with method 'newmark' only; "
                "the exact method has no step to choose"
            )
        return exact_grid(ALL_EFFECTS, exciter.parameters())
    return newmark_grid(ALL_EFFECTS, exciter.parameters(), check_steps(steps_per_period))


def check_steps(steps_per_period: Any) -> int:
    """A number of Newmark steps per forcing period, or a ParameterError."""
    whole = isinstance(steps_per_period, (int, np.integer)) and not isinstance(
        steps_per_period, bool
    )
    if not whole or not 1 <= steps_per_period <= 10**8:
        raise ParameterError(
            f"steps_per_period = {steps_per_period!r}: allowed is a whole number from 1 to 10**8 "
            "(method 'newmark' needs it)"
        )
    return int(steps_per_period)


def _check_samples(per_period: Any) -> None:
    whole = isinstance(per_period, (int, np.integer)) and not isinstance(per_period, bool)
    if not whole or per_period < 0:
        raise ParameterError(f"samples_per_period = {per_period!r}: allowed is a whole number >= 0")


def _sample_times(turns: tuple[float, float], per_period: int) -> np.ndarray:
    """Times of the samples before the end, in forcing periods after the start."""
    span = (turns[1] - turns[0]) * per_period
    # A regular sample within rounding of tau_end would stand beside the one at tau_end itself.
    count = max(1, math.ceil(span - 1e-6)) if span > 0 else 0
    if count > MAX_SAMPLES:
        raise ParameterError(
            f"samples_per_period = {per_period!r}: {count} samples up to tau_end; allowed are {MAX_SAMPLES}"
        )
    return np.arange(count) / max(per_period, 1)


def _samples(grid: Grid, turns: tuple[float, float], per_period: int) -> Samples | None:
    if per_period == 0:
        return None
    count = _sample_times(turns, per_period).size
    period, step, theta = locate(turns[0], grid.steps)
    empty = np.full(count, np.nan), np.full(count, np.nan)
    return Samples(*empty, 1, int(per_period), period * grid.steps + step, theta)


def _march(p, grid, state, turns_end, samples, max_impacts) -> _Run:
    """March to the end, emptying the log whenever it is full."""
    log = new_log(LOG_ROOM, LOG_ROOM)
    work = np.empty(3 if grid.exact is None else ORDER + 1)
    end = locate(turns_end, grid.steps)
    pieces: list[dict[str, np.ndarray]] = []
    events = 0
    while True:
        state, status = march(
            ALL_EFFECTS, p, grid, state, *end, log, samples, work, max_impacts - events
        )
        pieces.append(_take(log))
        events += len(pieces[-1]["position"]) + len(pieces[-1]["rest_start"])
        if events > max_impacts:
            status = Status.MAX_IMPACTS
        if status != Status.LOG_FULL:
            break
    if grid.exact is None and status == Status.OK and log.counts[SHORT_FLIGHTS] > 0:
        status = Status.SHORT_FLIGHTS
    if state.order == REST:
        ended = {"rest_start": state.rest_start, "rest_end": math.inf, "rest_support": state.home}
        pieces.append({name: np.array([value]) for name, value in ended.items()})
    columns = {name: np.concatenate([q[name] for q in pieces if name in q]) for name in pieces[0]}
    place = (to_displacement(p, state.home, state.y), to_velocity(state.home, state.w))
    finished = status in (Status.OK, Status.SHORT_FLIGHTS)
    none = np.empty(0)
    return _Run(
        Status(status),
        _contacts(columns, 2 * math.pi / p.nu),
        none if samples is None else samples.displacement,
        none if samples is None else samples.velocity,
        place if finished else (math.nan, math.nan),
    )


def _contacts(columns: dict[str, np.ndarray], period: float) -> dict[str, np.ndarray]:
    """Columns of a log by the names of a dataset, in tau."""
    struck = columns["support"] > 0
    before = columns["velocity"][struck]
    return {
        "impact_tau": columns["position"][struck] * period,
        "impact_support": columns["support"][struck],
        "impact_velocity": before,
        "impact_velocity_after": before + columns["impulse"][struck],
        "rest_start": columns["rest_start"] * period,
        "rest_end": columns["rest_end"] * period,
        "rest_support": columns["rest_support"].astype(np.int8),
        "grazing_tau": columns["grazing"] * period,
        "grazing_support": columns["grazing_support"],
    }


def _take(log) -> dict[str, np.ndarray]:
    """Copy the entries of a log and empty it."""
    n, rests, grazings = (int(log.counts[k]) for k in (IMPACTS, RESTS, GRAZINGS))
    taken = {
        name: getattr(log, name)[:n].copy()
        for name in ("position", "velocity", "impulse", "support")
    }
    taken |= {
        name: getattr(log, name)[:rests].copy()
        for name in ("rest_start", "rest_end", "rest_support")
    }
    taken |= {name: getattr(log, name)[:grazings].copy() for name in ("grazing", "grazing_support")}
    log.counts[[IMPACTS, RESTS, GRAZINGS]] = 0
    return taken


def _dataset(exciter, tau_start, tau_end, turns, per_period, run: _Run) -> xr.Dataset:
    import xarray as xr

    variables: dict[str, Any] = {
        name: (name.split("_")[0], values) for name, values in run.contacts.items()
    }
    variables["displacement_end"] = ((), run.end[0])
    variables["velocity_end"] = ((), run.end[1])
    variables["status"] = ((), np.int8(run.status))
    coords: dict[str, Any] = {
        name: ((), value) for name, value in exciter.parameters()._asdict().items()
    }
    if per_period > 0:
        offsets = _sample_times(turns, per_period)
        coords["tau"] = ("tau", np.append(tau_start + offsets * exciter.period, tau_end))
        phase = np.append((turns[0] % 1.0 + offsets) % 1.0, turns[1] % 1.0)
        variables["displacement"] = ("tau", np.append(run.displacement, run.end[0]))
        variables["velocity"] = ("tau", np.append(run.velocity, run.end[1]))
        variables["force"] = ("tau", exciter.f * np.sin(2 * math.pi * phase))
    return describe(xr.Dataset(variables, coords))
