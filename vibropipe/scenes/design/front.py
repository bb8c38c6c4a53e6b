"""Pictures of a front of two quantities, and of the spread of a design: bars and shares of each parameter."""

from __future__ import annotations

import string
import textwrap
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from matplotlib.transforms import Bbox

from vibropipe.figures.canvas import (
    SMALL,
    WIDE,
    EvenTicks,
    axes,
    colour_bar,
    new_canvas,
    panel,
    zero_line,
)
from vibropipe.figures.claims import percent
from vibropipe.figures.palette import EXACT, INK, METHODS, SIGNED, shades
from vibropipe.figures.style import LINE_MARKERS
from vibropipe.figures.text import format_number, plain_symbol_of, sentences, symbol_of, with_units
from vibropipe.scenes.design.data import (
    Part,
    beating,
    ends_of,
    half_distance,
    has_spread,
    is_nothing,
    spread_parts,
    struck_texts,
    swept,
    wanted_text,
)
from vibropipe.scenes.kind import Picture
from vibropipe.solve.design.tolerance import WORST
from vibropipe.solve.rows.named import OF_CONTACTS
from vibropipe.words.wording import series

NO_SPREAD = "No deviations of parameters are given: add tolerance"
# Quantities of the map beside the wanted ones.
MAPPED = (
    Part("displacement_mean"),
    Part("displacement_amplitude", "harmonic", 1),
    Part("displacement_amplitude", "harmonic", 2),
    Part("impact_velocity_max", "support", 1),
    Part("impact_velocity_max", "support", 2),
    Part("support_force_max", "support", 1),
    Part("support_force_max", "support", 2),
    Part("energy_input"),
)
BELOW, ABOVE = METHODS["crude"].colour, EXACT
# Centimetres: two panels in a line, a bar, and what stands beside and below them.
PANEL, BAR, LEFT, FOOT, HEAD = 5.6, 0.62, 2.2, 1.0, 0.6
ROW, WORDS, SCALE = 0.75, 6.3, 2.1  # of the map: a line, its words, its scale


def draw_tornado(dataset: xr.Dataset) -> Figure:
    """Draw, for the first design, the deviation of each wanted quantity if one parameter alone is off."""
    if not has_spread(dataset):
        return empty(NO_SPREAD)
    best = dataset.isel(design=0)
    parts = spread_parts(dataset)
    high = BAR * best.sizes["parameter"]
    lines = -(-len(parts) // 2)
    step = HEAD + high + FOOT
    figure = new_canvas(lines * step + 0.4)
    for n, part in enumerate(parts):
        left = LEFT + (n % 2) * (PANEL + LEFT + 0.1)
        ax = axes(figure, left, 0.4 + (lines - 1 - n // 2) * step + FOOT, PANEL, high)
        draw_bars(ax, best, part)
        if len(parts) > 1:
            panel(ax, string.ascii_lowercase[n], indent=-LEFT)
    return figure


def draw_bars(ax: Axes, best: xr.Dataset, part: Part) -> None:
    """Draw the bars of one quantity, the most important parameter on top, zero in the middle."""
    moved = part.of(best, "_deviation").transpose("parameter", "side").values
    share = part.of(best, "_contribution").values
    std = first_order_std(best, part)
    first = WORST * np.sqrt(np.nan_to_num(share)) * std
    order = np.argsort(np.nan_to_num(np.abs(moved)).max(axis=1), kind="stable")
    place = np.arange(order.size)
    style: dict[str, Any] = {"edgecolor": INK, "linewidth": 0.4, "height": 0.36}
    ax.barh(place + 0.19, moved[order, 0], color=BELOW, hatch="////", **style)
    ax.barh(place - 0.19, moved[order, 1], color=ABOVE, **style)
    for sign in (-1, 1):
        for width, colour in ((2.4, "white"), (1.0, INK)):
            ax.plot(
                sign * first[order], place, "|", color=colour, markersize=11, markeredgewidth=width
            )
    zero_line(ax, axis="x")
    names = [str(best["parameter"].values[n]) for n in order]
    ax.set_yticks(place, [deviation_text(best, name, WORST) for name in names], fontsize=8)
    ax.tick_params(axis="y", length=0)
    ax.spines["left"].set_visible(False)
    ax.xaxis.set_major_locator(MaxNLocator(4, steps=[1, 2, 5, 10]))
    ax.xaxis.set_major_formatter(EvenTicks())
    most = 1.05 * np.nanmax(np.abs([*moved.ravel(), *first]), initial=0.0) or 1.0
    if is_nothing(best, part, most):
        most = VANISHING * half_distance(best)
    ax.set_xlim(-most, most)
    ax.set_xlabel("\n".join(textwrap.wrap(f"deviation of {part.label_text(best)}", 44)))


def deviation_text(dataset: xr.Dataset, name: str, times: float = 1.0) -> str:
    """Write a parameter with its standard deviation, or some times that."""
    return f"{symbol_of(dataset[name])} ± {std_text(dataset, name, times)}"


def std_text(dataset: xr.Dataset, name: str, times: float = 1.0) -> str:
    """Write the standard deviation of a parameter, or some times that, with its unit."""
    return with_units(dataset[name], format_number(times * float(dataset[f"{name}_std"]), 2))


def draw_sensitivities(dataset: xr.Dataset) -> Figure:
    """Draw, for the first design, the signed share that each parameter has in the spread of each quantity."""
    if not has_spread(dataset):
        return empty(NO_SPREAD)
    best = dataset.isel(design=0)
    held = [part for part in MAPPED if f"{part.variable}_contribution" in dataset]
    parts = list(dict.fromkeys([*spread_parts(dataset), *held]))
    signed = np.array([shares_of(best, part) for part in parts])
    names = [str(name) for name in best["parameter"].values]
    height = ROW * len(parts)
    figure = new_canvas(height + 1.2)
    ax = axes(figure, WORDS, 1.0, WIDE - WORDS - SCALE, height)
    image = ax.imshow(signed, cmap=SIGNED, vmin=-1, vmax=1, aspect="auto")
    for row, column in np.ndindex(signed.shape):
        value = signed[row, column]
        text = "–" if np.isnan(value) else f"{100 * value:+.0f} %".replace("-", "−")
        text = "0 %" if abs(value) < 0.005 else text
        colour = "white" if abs(value) > 0.6 else INK
        ax.text(column, row, text, ha="center", va="center", color=colour)
    few = len(names) <= 4
    ticks = [deviation_text(best, n) if few else symbol_of(best[n]) for n in names]
    ax.set_xticks(range(len(names)), ticks, fontsize=8)
    ax.set_yticks(range(len(parts)), [row_text(best, part) for part in parts], fontsize=8)
    ax.tick_params(which="both", length=0)
    for side in ax.spines.values():
        side.set_visible(False)
    title = "share of the variance, with\nthe sign of the derivative"
    colour_bar(figure, image, WIDE - SCALE + 0.35, 1.0, 0.3, height, title)
    return figure


def shares_of(best: xr.Dataset, part: Part) -> np.ndarray:
    """Return the share of the variance that each parameter has, with the sign of its effect."""
    moved = part.of(best, "_deviation").sel(side="above").values
    return np.sign(moved) * part.of(best, "_contribution").values


def first_order_std(best: xr.Dataset, part: Part) -> float:
    """Return the standard deviation of a quantity, to first order."""
    return float(part.of(best, "_std").sel(estimate="first_order"))


def row_text(best: xr.Dataset, part: Part) -> str:
    """Write a quantity with its standard deviation."""
    std = first_order_std(best, part)
    std = 0.0 if is_nothing(best, part, std) else std
    return f"{part.words(best)}\n± {with_units(best[part.variable], format_number(std, 2))}"


def empty(text: str) -> Figure:
    """Return a figure that says why there is nothing to show."""
    figure = new_canvas(1.2)
    ax = axes(figure, 0, 0, WIDE, 1.2)
    ax.set_axis_off()
    ax.text(0.5, 0.5, text, ha="center", va="center")
    return figure


def leading(dataset: xr.Dataset) -> list[str]:
    """Write, for each wanted quantity, which parameter matters most for its spread."""
    best = dataset.isel(design=0)
    texts = []
    for part in spread_parts(dataset):
        share = part.of(best, "_contribution")
        if is_nothing(best, part, first_order_std(best, part)):
            continue
        most = int(share.fillna(-1).argmax("parameter"))
        if float(share[most]) > 0.5:
            name = plain_symbol_of(best[str(best["parameter"].values[most])])
            words = f"the {part.words(dataset)}"
            texts.append(f"{words} comes from {name} ({percent(float(share[most]))})")
    return texts


# Relative difference of deviations that are one.
SAME_MOVE = 1e-6
VANISHING = 0.05  # of half the distance: the scale of deviations that are rounding


def title_tornado(dataset: xr.Dataset) -> str:
    """Return the title of the bars: which parameter moves each quantity most, or only the first one."""
    if not has_spread(dataset) or not (parts := spread_parts(dataset)):
        return "What each parameter alone does is not known"
    best = dataset.isel(design=0)
    names = [strongest(best, part) for part in parts]
    if is_nothing(best, parts[0], float(abs(parts[0].of(best, "_deviation")).max())):
        return f"No parameter alone moves the {parts[0].words(dataset)}"
    if not names[0]:
        return f"How each parameter moves the {parts[0].words(dataset)}"
    moved = f"the {parts[0].words(dataset)}"
    if len(parts) > 1 and names == names[:1] * len(parts):
        moved = "both quantities" if len(parts) == 2 else "each quantity"
    return f"{series(names[0])} {'moves' if len(names[0]) == 1 else 'move'} {moved} most"


def strongest(best: xr.Dataset, part: Part) -> list[str]:
    """Return the symbols of the parameters that move a quantity most; none where that is not known."""
    deviations = abs(part.of(best, "_deviation"))
    moved = deviations.fillna(0.0).max("side")
    if not float(moved.max()) > 0.0 or bool(deviations.isnull().any()):
        return []
    most = moved.values >= (1.0 - SAME_MOVE) * float(moved.max())
    return [plain_symbol_of(best[str(name)]) for name in best["parameter"].values[most]]


def describe_tornado(dataset: xr.Dataset) -> str:
    """Return the caption of the bars of each parameter."""
    if not has_spread(dataset):
        return sentences(NO_SPREAD)
    return sentences(
        "Design 1, solved anew with one parameter off by three standard deviations; hatched: below its value, dark: "
        "above; ticks: to first order"
    )


def title_sensitivities(dataset: xr.Dataset) -> str:
    """Return the title of the map of shares."""
    if not has_spread(dataset):
        return "The shares of the parameters in the spread are not known"
    return "Share of each parameter in the spread of design 1"


def describe_sensitivities(dataset: xr.Dataset) -> str:
    """Return the caption of the map of shares."""
    if not has_spread(dataset):
        return sentences(NO_SPREAD)
    std = series(
        f"{plain_symbol_of(dataset[name])} ± {std_text(dataset, name)}"
        for name in map(str, dataset["parameter"].values)
    )
    return sentences(
        f"Share in the variance of each quantity to first order, for deviations {std}; under a quantity: its standard "
        "deviation; minus: the quantity falls where the parameter rises"
    )


HEIGHT = 8.8
CLOUD = "#9C9C9C"
MARKER = 5.0  # pt


def draw_front(dataset: xr.Dataset) -> Figure:
    """Draw the second quantity over the first: the front, and the motions of the sweep behind it."""
    (first, _), (second, _) = ends_of(dataset)
    figure = new_canvas(HEIGHT)
    ax = axes(figure, 1.5, 1.2, 11.6, HEIGHT - 1.6)
    cloud = swept(dataset)
    ax.plot(
        *cloud.T, ".", color=CLOUD, markersize=2.4, markeredgewidth=0, zorder=0, rasterized=True
    )
    x, y = first.of(dataset).values, second.of(dataset).values
    ax.plot(x, y, color=INK, linewidth=0.6, zorder=1)
    laws = struck_texts(dataset)
    kinds = list(dict.fromkeys(laws))
    for n, (law, colour) in enumerate(zip(kinds, shades(len(kinds)), strict=True)):
        chosen = np.array([each == law for each in laws])
        marker = LINE_MARKERS[n % len(LINE_MARKERS)]
        style: dict[str, Any] = {"color": colour, "markeredgecolor": EXACT, "markeredgewidth": 0.5}
        label = law.removesuffix(" periods")
        ax.plot(x[chosen], y[chosen], marker, markersize=MARKER, label=label, **style)
    number(ax, dataset, x, y)
    ax.set_xlabel(axis_text(dataset, 0))
    ax.set_ylabel(axis_text(dataset, 1))
    ax.margins(0.05)
    ax.legend(
        title="impacts, support 1 +\nsupport 2, in a period\nor in several", loc="upper left", fontsize=SMALL,
        bbox_to_anchor=(1.02, 1.0), borderaxespad=0.0, frameon=False, title_fontsize=SMALL, alignment="left",
    )  # fmt: skip
    return figure


def number(ax: Axes, dataset: xr.Dataset, x: np.ndarray, y: np.ndarray) -> None:
    """Write the numbers of designs on the side of the front where nothing else can lie, or else beside that.

    Those of the ends come first; one without room is left out, since the designs are numbered along the front.
    """
    signs = [sign for _, sign in ends_of(dataset)]
    ha, va = "right" if signs[0] > 0 else "left", "top" if signs[1] > 0 else "bottom"
    other = "left" if ha == "right" else "right"
    places = ((-3.0, -2.0, ha), (0.0, -4.0, "center"), (3.0, -2.0, other))
    ax.autoscale_view()  # matplotlib puts it off until the limits are asked for
    at, half = ax.transData.transform(np.column_stack([x, y])), 0.4 * MARKER / 72 * ax.figure.dpi
    boxes = [Bbox([point - half, point + half]) for point in at]
    last = x.size - 1
    for n in sorted(range(x.size), key=lambda n: (n not in (0, last), n)):
        for right, up, side in places:
            text = ax.annotate(
                str(n + 1), (x[n], y[n]), (right * signs[0], up * signs[1]), textcoords="offset points",
                fontsize=SMALL, ha=side, va=va,
            )  # fmt: skip
            box = text.get_window_extent()
            if not any(box.overlaps(each) for each in boxes):
                boxes.append(box)
                break
            text.remove()


def axis_text(dataset: xr.Dataset, which: int) -> str:
    """Write what an axis shows, and in which direction it is better."""
    part, sign = ends_of(dataset)[which]
    text = part.label_text(dataset)
    return f"← better   {text}" if sign > 0 else f"{text}   better →"


def title_front(dataset: xr.Dataset) -> str:
    """Return the title of the front: whether a motion of the sweep beats it."""
    amount = len(swept(dataset))
    if not amount:
        return "What is better in one quantity is worse in the other"
    motions = "swept motions with impacts" if has_contacts(dataset) else "swept motions"
    if better := beating(dataset):
        beat = "beats" if better == 1 else "beat"
        return f"{better:,} of {amount:,} {motions} {beat} a design of the front"
    return f"None of {amount:,} {motions} beats a design of the front"


def has_contacts(dataset: xr.Dataset) -> bool:
    """Return whether a quantity of the front is one of contacts: a motion without any has none."""
    return any(part.variable in OF_CONTACTS for part, _ in ends_of(dataset))


def describe_front(dataset: xr.Dataset) -> str:
    """Return the caption of the front."""
    others = wanted_text(dataset, [part.words(dataset) for part, _ in ends_of(dataset)])
    dots = "Grey: motions of a grid over the ranges"
    dots += " that keep to the bounds" * ("subject_to" in dataset.attrs)
    if has_contacts(dataset):
        dots += "; those that do not strike the support are left out"
    return sentences(
        f"Wanted: {others}" if others else "",
        dots if len(swept(dataset)) else "",
        "Markers: designs, in the order of the first quantity; between them the front is not followed",
    )


MATTERS = "Which parameter matters most?"
TORNADO = Picture("tornado", draw_tornado, describe_tornado, titled=title_tornado, heading=MATTERS)
SENSITIVITIES = Picture(
    "sensitivities",
    draw_sensitivities,
    describe_sensitivities,
    titled=title_sensitivities,
    heading=MATTERS,
)
