"""Pictures of hard cases: where common methods fail, and the share of its bound that each case takes."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibropipe.figures.canvas import BODY, axes, label, new_canvas, power, ticks
from vibropipe.figures.palette import BAND, EXACT, FAILED, INK, METHODS
from vibropipe.figures.text import sentences
from vibropipe.scenes.hard_cases.failures import FAILURES
from vibropipe.scenes.kind import Picture, showing
from vibropipe.words.measurements import Passed
from vibropipe.words.wording import capitalised, part_text, series

LEAST = 6e-8  # share below which a deviation is drawn as none
FIRST, STEP = 1.2e-8, 1.19  # place of the first mark without deviation, and from one to the next
EDGE = 8e-9
RIGHT = 3.0  # right end: what exceeds its bound is drawn at its middle
ROW_CM = 0.52
# Solver -> colour, marker and name.
SOLVERS = {
    "exact": (EXACT, "D", "exact"),
    "newmark 8": (METHODS["crude"].colour, "o", "Newmark, 8 steps"),
    "newmark 60": (METHODS["newmark"].colour, "s", "Newmark, 60 steps"),
    "newmark 2000": ("#1D5B8F", "^", "Newmark, 2000 steps"),
}
DRAWN = ("exact", "newmark 60")


def shares(dataset: xr.Dataset) -> np.ndarray:
    """Return measured/bound over (case, solver): 0 without deviation, nan where not applicable.

    A count that should be zero and is not gives inf, and so does a value that is not a number.
    """
    measured, bound = dataset["measured"].values, dataset["bound"].values
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.where(measured == 0.0, 0.0, measured / bound)
    share[np.isnan(share)] = np.inf
    return np.where(dataset["passed"].values != Passed.NOT_ASKED, share, np.nan)


def by_solvers(dataset: xr.Dataset, show: Collection[str]) -> xr.Dataset:
    """Return the results of the solvers to show (default: DRAWN), in the order of the data."""
    return dataset.isel(solver=np.isin(dataset["solver"].values, list(show or DRAWN)))


def draw_margins(dataset: xr.Dataset, show: Collection[str] = ()) -> Figure:
    """Draw deviation over bound on a log axis, a line for each group of cases and a mark for each case and solver."""
    dataset = by_solvers(dataset, show)
    groups = [str(group) for group in dataset["group"].values]
    solvers = [str(solver) for solver in dataset["solver"].values]
    height = len(groups) * ROW_CM
    figure = new_canvas(height + 1.6)
    ax = axes(figure, 4.6, 0.95, 11.2, height)
    ax.set(xscale="log", xlim=(EDGE, RIGHT), ylim=(len(groups) - 0.5, -0.5))
    ax.axvspan(1.0, RIGHT, color=BAND, lw=0)
    ax.axvspan(EDGE, LEAST, color="#F4F4F4", lw=0)
    ax.axvline(1.0, color=INK, lw=0.8)
    offsets = np.linspace(-0.18, 0.18, len(solvers)) if len(solvers) > 1 else np.zeros(1)
    share = shares(dataset)
    for row, group in enumerate(groups):
        ax.axhline(row, color=BAND, lw=0.5, zorder=0)
        own = dataset["case_group"].values == group
        for k, solver in enumerate(solvers):
            draw_shares(ax, np.sort(share[own, k]), row + offsets[k], solver)
    ax.set_yticks(range(len(groups)), groups, fontsize=BODY)
    ax.tick_params(axis="y", length=0)
    ax.spines["left"].set_visible(False)
    exponents = (-6, -4, -2)
    places = [2e-8, *(10.0**n for n in exponents), 1.0]
    ticks(ax, "x", places, ["none", *map(power, exponents), "1: bound"])
    ax.set_xlabel("deviation as a share of its bound")
    x = 1e-4
    for solver in solvers:
        colour, marker, name = SOLVERS[solver]
        top: dict[str, Any] = {"transform": ax.get_xaxis_transform(), "clip_on": False}
        ax.plot([x], [1 + 0.25 / height], marker, color=colour, ms=3.6, **top)
        options = {"va": "center", "transform": top["transform"]}
        drawn = label(ax, x * 1.4, 1 + 0.25 / height, name, colour, **options)
        x = ax.transData.inverted().transform((drawn.get_window_extent().x1, 0))[0] * 3.0
    return figure


def draw_shares(ax: Axes, share: np.ndarray, row: float, solver: str) -> None:
    """Draw the shares of one group by one solver: none beside each other at the left edge, the rest at their places."""
    colour, marker, _name = SOLVERS[solver]
    style: dict[str, Any] = {"ls": "none", "ms": 3.6, "zorder": 3}
    filled = {**style, "marker": marker, "color": colour, "mec": "white", "mew": 0.4}
    share = share[~np.isnan(share)]
    none = int((share <= LEAST).sum())
    ax.plot(FIRST * STEP ** np.arange(none), np.full(none, row), **filled)
    kept = share[(share > LEAST) & (share <= 1.0)]
    ax.plot(kept, np.full(kept.size, row), **filled)
    broken = int((share > 1.0).sum())
    ax.plot([np.sqrt(RIGHT)] * broken, [row] * broken, marker="x", color=FAILED, mew=1.0, **style)


def marks_text(dataset: xr.Dataset) -> str:
    """Write of how many cases a mark stands, by each method if they differ."""
    held = (dataset["passed"] != Passed.NOT_ASKED).sum("case")
    total, amounts = dataset.sizes["case"], zip(dataset["solver"].values, held.values, strict=True)
    fewer = series([f"{SOLVERS[str(each)][2]}, in {n}" for each, n in amounts if n < total])
    return "A mark for each case and method" + (f" ({fewer} of {total:,} cases)" if fewer else "")


def describe_margins(dataset: xr.Dataset, show: Collection[str] = ()) -> str:
    """Return the caption: what a mark is, and which cases do not pass by the solvers drawn."""
    dataset = by_solvers(dataset, show)
    failed = np.asarray((dataset["passed"].values == Passed.NOT_PASSED).any(axis=1))
    names = [str(name).replace("_", " ") for name in dataset["case"].values[failed]]
    verb = "exceeds its bound" if len(names) == 1 else "exceed their bounds"
    steps = any(solver != "exact" for solver in dataset["solver"].values)
    return sentences(
        marks_text(dataset),
        "“none”: no deviation, or less than 6 × 10⁻⁸ of the bound; questions of yes or no have only that",
        f"Cross: {series(names)} {verb}" if names else "",
        "Newmark's method is held to the square of its step where the truth is the exact motion, to its own discrete "
        "solution elsewhere"
        if steps
        else "",
    )


def title_of_margins(dataset: xr.Dataset, show: Collection[str] = ()) -> str:
    """Return what the picture shows, as a sentence: how many cases exceed their bounds."""
    share = shares(by_solvers(dataset, show))
    broken = int((share > 1.0).any(axis=1).sum())
    total = dataset.sizes["case"]
    if broken > 1:
        return f"{capitalised(part_text(broken, total, 'case'))} exceed their bounds"
    return f"{'No case' if not broken else 'One case'} of {total} exceeds its bound"


PICTURES = (
    FAILURES,
    Picture(
        "margins", draw_margins, describe_margins, keywords=showing, titled=title_of_margins,
        heading="Do all cases keep their bounds?",
    ),
)  # fmt: skip
