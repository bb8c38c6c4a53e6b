"""Captions, answers and the table of work-precision data."""

from __future__ import annotations

from collections.abc import Collection, Iterable

import numpy as np
import xarray as xr

from vibropipe.figures.canvas import power
from vibropipe.figures.text import format_number, sentences
from vibropipe.report.parts import DASH, Answer, Table
from vibropipe.scenes.accuracy.summary import (
    NAMES,
    STYLES,
    capital,
    curve,
    error_text,
    errors_in,
    failed,
    motion_subject,
    motion_title,
    multiple_text,
    of_errors,
    price_of_digit,
    succeeded,
    time_text,
    times_to_errors,
)
from vibropipe.words.measurements import OWN_METHODS, Outcome
from vibropipe.words.parameters import FORCES
from vibropipe.words.vocabulary import quantity
from vibropipe.words.wording import count, part_text, series

# Errors of the table of times.
WANTED = (1e-2, 1e-4, 1e-8, 1e-12)
TEN_DIGITS = 1e-10
# How the methods of other packages are used.
OF_SCIPY = ("RK45", "DOP853", "Radau")
PACKAGES = {
    "`scipy`: `solve_ivp` with a terminal event for each support and a restart after it": OF_SCIPY,
    "`heyoka`: the same with its own events": ("heyoka",),
    "`solve_nivp`: trapezoidal steps with both supports as constraints on the velocity": (
        "solve_nivp",
    ),
}


def left_out_text(dataset: xr.Dataset, show: Collection[str]) -> str:
    """Write which motions have no error that is drawn."""
    drawn = of_errors(dataset, show)["motion"].values
    names = [motion_title(name) for name in dataset["motion"].values if name not in drawn]
    return f"Left out, without this error: {series(names)}" if names else ""


def describe_work_precision(dataset: xr.Dataset, show: Collection[str] = ()) -> str:
    """Return the caption: what is drawn."""
    left_out = left_out_text(dataset, show)
    shown = of_errors(dataset, show)
    texts = [quantity(name).short for name in errors_in(shown)]
    of = "of" if len(texts) == 1 else "the largest of"
    error = f"Error: {of} {series(texts)}, against a solution of 40 digits"
    if shown.sizes["motion"] == 1:
        periods = count(int(shown["periods_run"][0]), "forcing period")
        has_own = any(method in OWN_METHODS for method in shown["method"].values.tolist())
        called = "Times of this program are without the checks and labels of a call"
        motion = motion_subject(shown["motion"].values[0])
        return sentences(
            f"{motion}, {periods} for every method; each point is a step or a tolerance",
            error, steps_text(shown), undrawn_text(shown.isel(motion=0)),
            called if has_own else "", left_out,
        )  # fmt: skip
    return sentences(
        "Every method runs the same number of periods of a motion, and every motion strikes"
        if bool((shown["impacts_per_period"] > 0).all())
        else "Every method runs the same number of periods of a motion",
        "In the grey band, hollow and with a cross: runs that miss an impact, pass through a support, or leave an "
        "error as large as the motion, at the time that they took"
        if (failed(shown) & np.isfinite(shown["time_per_period"])).any()
        else "",
        closed_text(shown),
        error, left_out,
    )  # fmt: skip


def undrawn_text(one: xr.Dataset) -> str:
    """Write which runs on one motion have no point, since they failed or were stopped."""
    texts = []
    for method in one["method"].values[failed(one).any("setting").values]:
        row = one.sel({"method": method})
        settings = row["setting_value"].values[failed(row).values]
        values = series(format_number(value, 6) for value in settings if np.isfinite(value))
        texts.append(STYLES[str(method)].label + (f" at {values}" if values else ""))
    return f"Without a point, since failed or stopped: {'; '.join(texts)}" if texts else ""


def closed_text(dataset: xr.Dataset) -> str:
    """Write why the exact method takes longer on a motion in closed form over few periods, if there is one."""
    known = ("f", "h", "R1", "R2")
    if "exact" not in dataset["method"].values or any(name not in dataset for name in known):
        return ""
    none = {"h": 0.0, "R1": 1.0, "R2": 1.0} | {name: 0.0 for name in FORCES if name in dataset}
    is_closed = np.all([dataset[name].values == value for name, value in none.items()], axis=0)
    if not is_closed.any():
        return ""
    return (
        "Without losses and force the exact method evaluates a closed form; its preparation is spread over the "
        "periods of a motion"
    )


def steps_text(dataset: xr.Dataset) -> str:
    """Write why some runs of step methods are drawn apart, if there are any."""
    limit = dataset.attrs.get("tabulated_steps")
    names = [m for m in ("crude", "newmark") if m in dataset["method"].values]
    settings = dataset["setting_value"].sel({"method": names}).values if names else np.empty(0)
    if limit is None or not (settings > limit).any():
        return ""
    return (
        f"Hollow (*): above {limit:,} steps a period a step costs more, since its force is computed in each and not "
        "read from a table"
    )


def answers(dataset: xr.Dataset) -> list[Answer]:
    """Return the answers of one scene."""
    has_exact = "exact" in dataset["method"].values
    if dataset.sizes["motion"] == 1:
        one = dataset.isel(motion=0)
        found = one_motion(one) if has_exact else [least_error(one)]
    else:
        # of several motions the title says who is accurate
        found = [Answer(lost_text(dataset))]
        found += [Answer(exact_times_text(dataset))] if has_exact else []
    return [answer for answer in found if answer.lead]


def one_motion(one: xr.Dataset) -> list[Answer]:
    """Return what accuracy costs on one motion: by the exact method, by steps, by other packages."""
    error, time = curve(one, "exact")
    if not error.size:
        return [Answer("The exact method does not solve this motion.")]
    lead = f"Exact: {time_text(time[0])} a period, whatever the error."
    return [
        Answer(lead, in_that_time(one, time[0])),
        price_of_steps(one),
        price_of_packages(one, float(time[0])),
    ]


def least_error(one: xr.Dataset) -> Answer:
    """Return which method leaves the least error on one motion, and the time of that run."""
    curves = {str(method): curve(one, str(method)) for method in one["method"].values}
    best = min(
        ((e, t, method) for method, pair in curves.items() for e, t in zip(*pair, strict=True)),
        default=None,
    )
    if best is None:
        return Answer("No method solves this motion.")
    error, time, method = best
    lead = f"{capital(NAMES[method])} leaves the least error: {error_text(error)}."
    return Answer(lead, f"That run takes {time_text(time)} a period.")


def in_that_time(one: xr.Dataset, time: float) -> str:
    """Write what the crude method leaves in a time: the error of its finest run that takes no longer."""
    if "crude" not in one["method"].values:
        return ""
    error, times = curve(one, "crude")
    within = np.flatnonzero(times <= time)
    if not within.size:
        return ""
    return f"In that time, {NAMES['crude']} leaves an error of {error_text(error[within[-1]])}."


def price_of_steps(one: xr.Dataset) -> Answer:
    """Return what one more digit takes by Newmark's method, while its force is read from a table."""
    if "newmark" not in one["method"].values:
        return Answer("")
    limit = one.attrs.get("tabulated_steps", np.inf)
    cheap = one.isel(setting=~(one["setting_value"].sel({"method": "newmark"}).values > limit))
    error, time = curve(cheap, "newmark")
    factor = price_of_digit(error, time)
    if not np.isfinite(factor):
        return Answer("")
    has_more = cheap.sizes["setting"] < one.sizes["setting"]
    which = " with a tabulated force" if has_more else ""
    lead = f"Newmark's method: {multiple_text(factor)} times the time for one more digit."
    rest = f"This holds near its most accurate run{which}, which leaves {error_text(error.min())}."
    return Answer(lead, rest)


def price_of_packages(one: xr.Dataset, exact_time: float) -> Answer:
    """Return how many times as long the fastest run of another package takes, and the error that it leaves."""
    runs = {
        str(m): min(zip(*reversed(curve(one, str(m))), strict=True))
        for m in one["method"].values
        if m not in OWN_METHODS and curve(one, str(m))[1].size
    }
    if not runs:
        return Answer("")
    name, (time, error) = min(runs.items(), key=lambda item: item[1])
    lead = f"{capital(NAMES[name])}: at least {multiple_text(time / exact_time, np.floor)} times as long."
    others = [m for m in runs if m != name]
    tail = f"; no run of {names_text(others)} is faster" if others else ""
    return Answer(lead, f"Its fastest run leaves an error of {error_text(error)}{tail}.")


def names_text(methods: Iterable[str]) -> str:
    """Write the names of packages, of which none does something: scipy's once, for all its methods."""
    names = [NAMES[m] for m in methods]
    first = next((name for name in names if name.startswith("scipy's ")), "")
    return series((n if n == first else n.removeprefix("scipy's ") for n in names), "or")


def exact_times_text(dataset: xr.Dataset) -> str:
    """Write between which times of a period the exact method solves the motions."""
    curves = [curve(dataset.isel(motion=k), "exact")[1] for k in range(dataset.sizes["motion"])]
    times = [time[0] for time in curves if time.size]
    if not times:
        return "The exact method does not solve these motions."
    where = "on all motions" if len(times) == len(curves) else "on the motions that it solves"
    ends = list(dict.fromkeys(time_text(time) for time in (min(times), max(times))))
    return f"Exact: {' to '.join(ends)} a period {where}."


def accurate_text(dataset: xr.Dataset) -> str:
    """Write which methods reach ten digits on all motions."""
    amount, reach = dataset.sizes["motion"], []
    for method in map(str, dataset["method"].values):
        best = [curve(dataset.isel(motion=k), method)[0].min(initial=np.inf) for k in range(amount)]
        if max(best) <= TEN_DIGITS:
            reach.append(method)
    where = "on both motions" if amount == 2 else f"on all {amount} motions"
    if reach == ["exact"]:
        return f"Only the exact method reaches ten digits {where}"
    if not reach:
        return f"No method reaches ten digits {where}"
    names = capital(series(NAMES[m] for m in reach))
    return f"{names} {'reach' if len(reach) > 1 else 'reaches'} ten digits {where}"


def lost_text(dataset: xr.Dataset) -> str:
    """Write on how many motions no run of another package finishes."""
    peers = [str(m) for m in dataset["method"].values if m not in OWN_METHODS]
    if not peers:
        return ""
    outcome = dataset["outcome"].sel({"method": peers}).values
    tried = outcome != Outcome.NOT_TRIED
    has_ended = (tried & (outcome != Outcome.DID_NOT_END)).any(axis=(1, 2))
    lost = int((tried.any(axis=(1, 2)) & ~has_ended).sum())
    which = part_text(lost, dataset.sizes["motion"], "motion")
    return f"On {which}, no run of {names_text(peers)} finishes." if lost else ""


def packages_of(datasets: Iterable[xr.Dataset]) -> str:
    """Write how other packages are used, those that were run."""
    run = {str(m) for data in datasets for m in data["method"].values} - set(OWN_METHODS)
    texts = [text for text, names in PACKAGES.items() if run & {*names}]
    stop = "a run is stopped after 10,000 evaluations a period"
    return "; ".join([*texts, stop]) if texts else ""


def title_of(dataset: xr.Dataset, show: Collection[str] = ()) -> str:
    """Return what the picture shows, as a sentence."""
    if "exact" not in dataset["method"].values:
        return "Time over error"
    if dataset.sizes["motion"] > 1:
        return accurate_text(dataset)
    _error, time = curve(dataset.isel(motion=0), "exact")
    if not time.size:
        return "Time over error"
    return f"The exact method costs the same at every error: {time_text(time[0])} a period"


def times_table(scene: str, dataset: xr.Dataset) -> Table | None:
    """Return the times to errors as multiples of the exact method's time; None without it, or for several motions."""
    methods = dataset["method"].values
    if dataset.sizes["motion"] != 1 or methods.size < 2 or "exact" not in methods:
        return None
    one = dataset.isel(motion=0)
    _error, exact_time = curve(one, "exact")
    if not exact_time.size:
        return None
    rows = []
    found = times_to_errors(one, WANTED)
    for method, times in sorted(found.items(), key=lambda each: each[0] != "exact"):
        if bool(succeeded(one.sel({"method": method})).any()):
            texts = (multiple_text(t / exact_time[0]) if np.isfinite(t) else DASH for t in times)
            # to two digits in all columns, whatever else they hold
            cells = [f"{text}.0" if text.isdigit() and len(text) == 1 else text for text in texts]
            rows.append([capital(NAMES[method]), *cells])
    head = ["error at most", *(power(round(np.log10(error))) for error in WANTED)]
    note = f"Interpolated between settings, on logarithmic axes. {DASH}: reached by no setting that was tried."
    title = f"Time to an error, as multiples of {time_text(exact_time[0])}"
    widths = ("1fr", *["2.2cm"] * len(WANTED))
    return Table(head, rows, note, widths, title=title, scene=scene, picture="work_precision")
