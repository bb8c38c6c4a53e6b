"""A motor that drives the exciter of a branch: the picture of both torques, answers and tables."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from vibropipe.figures.canvas import arrow, axes, legend_above, noted_canvas, panel
from vibropipe.figures.claims import from_to
from vibropipe.figures.line_names import Named
from vibropipe.figures.motion_words import amount_text, number_word, words_of
from vibropipe.figures.palette import GREY, INK
from vibropipe.figures.text import (
    axis_label,
    format_number,
    in_brackets,
    parameter_line,
    sentences,
    ties_text,
    with_units,
)
from vibropipe.report.findings import equal_text, symbol_text, value_text
from vibropipe.report.parts import DASH, MAX_ROWS, Answer, Table
from vibropipe.scenes.branch.curves import (
    BETWEEN,
    KEPT,
    LEFT,
    LOW,
    SPEED,
    STABLE,
    TOP,
    UNSTABLE,
    WIDTH,
    colours_of,
    draw_pieces,
    draw_speeds,
    stabilities,
)
from vibropipe.scenes.branch.lines import followed, has_points, pieces_of, swept, with_values_beside
from vibropipe.scenes.branch.names import line_names, write_names
from vibropipe.store.table import is_neutral

HIGH = 6.5  # cm
MOTOR: dict[str, Any] = {"color": GREY, "linewidth": 2.2, "zorder": 1}
CROSSING: dict[str, Any] = {**SPEED, "zorder": 6}
WAYS = ("lowered", "raised")  # by `jump_way`
SAME, NEAR = 1e-9, 0.3  # of a speed that is lost; of the range of torques, at neighbouring points
MAX_LISTED = 3  # speeds of an answer


def has_motor(dataset: xr.Dataset) -> bool:
    """Return whether a motor drives the exciter."""
    return "speed_is_stable" in dataset


def question_of(datasets: Mapping[str, xr.Dataset]) -> str:
    """Return the question that the report answers."""
    if all(map(has_motor, datasets.values())):
        return "Which speeds does the motor keep, and where does it jump?"
    return "Which orbits are there, stable or not, and where do they change?"


def draw_motor(dataset: xr.Dataset, **options: Any) -> Figure:
    """Draw the torques of load and motor over the speed, the speeds at which they are equal, and the jumps."""
    if not has_points(dataset):
        return draw_speeds(dataset)
    note = parameter_line(dataset)
    figure = noted_canvas(LOW + HIGH + TOP + BETWEEN, note, LEFT)
    ax = axes(figure, LEFT, LOW, WIDTH, HIGH)
    speeds, load = dataset[followed(dataset)], dataset["load_torque"].values
    order = np.argsort(speeds.values)
    at, given = speeds.values[order], dataset["available_torque"].values[order]
    ax.plot(at, given, **MOTOR)
    pieces = list(pieces_of(dataset))
    colours = colours_of(dataset, pieces)
    draw_pieces(ax, speeds.values, load[:, None], pieces, colours)
    kept = dataset["speed_is_stable"].values == 1
    crossings = crossing_speeds(dataset).values, dataset["motor_torque"].values
    for is_kept, (_text, colour) in KEPT.items():
        own = kept == is_kept
        ax.plot(*(values[own] for values in crossings), markerfacecolor=colour, **CROSSING)
    for lost, reached, torque in zip(*jumps_of(dataset), strict=True):
        ends = [(speed, np.interp(speed, at, given) + torque) for speed in (lost, reached)]
        ax.plot(*ends[0], marker="|", markersize=9, color=INK, zorder=6)
        if np.isfinite(reached):
            arrow(ax, ends[0], ends[1], INK, linestyle=(0, (2, 1.2)), lw=0.8)
    ax.set_xlim(float(at[0]), float(at[-1]))
    ax.margins(y=0.1)
    points = zip(*(each[:, None] for each in crossings), strict=True)
    motor = Named(at, given, "motor", GREY, breaks=[])
    names = line_names(dataset, pieces)
    write_names(ax, speeds.values, load[:, None], pieces, names, colours, points, motor)
    panel(ax, title=in_brackets("torque of load and motor", dataset["motor_torque"]))
    ax.set_xlabel(axis_label(speeds))
    loads = {
        "stable": {**STABLE, "label": "load, stable motion"},
        "unstable": {**UNSTABLE, "label": "load, unstable motion"},
    }
    handles = [
        *(Line2D([], [], color=INK, **loads[name]) for name in stabilities(dataset)),
        Line2D([], [], **MOTOR, label="motor"),
        *(
            Line2D([], [], markerfacecolor=colour, label=text, **CROSSING)
            for is_kept, (text, colour) in KEPT.items()
            if (kept == is_kept).any()
        ),
    ]
    legend_above(figure, handles, LEFT)
    return figure


def describe_motor(dataset: xr.Dataset, **options: Any) -> str:
    """Return the caption."""
    jumps, ties = dataset.sizes["jump"], ties_text(dataset)
    what = "motions followed here end or a speed" if may_be_kept(dataset).any() else "a speed"
    arrows = f"Bars: where {what} is lost as the motor gives more or less torque"
    arrows += ", with an arrow to the next one that is kept where it is known"
    return sentences(
        f"Mean torque of the motions followed along {symbol_text(dataset[followed(dataset)])}, and of the motor",
        arrows if jumps else "",
        f"Tied: {ties}" if ties else "",
        dataset.attrs.get("incomplete", ""),
    )


def title_motor(dataset: xr.Dataset, **options: Any) -> str:
    """Return the title: how many speeds are kept."""
    if over := swept(dataset):
        values = dataset[f"crossing_{over}"].values[dataset["speed_is_stable"].values == 1]
        kept_at, n = np.unique(values).size, np.unique(dataset[over].values).size
        which = f"{number_word(kept_at) if kept_at else 'none'} of {amount_text(n, 'value')}"
        which = f"each of {amount_text(n, 'value')}" if kept_at == n > 1 else which
        keeps = "the motor keeps" if kept_at else "does the motor keep"
        return f"At {which} of {symbol_text(dataset[over])} {keeps} a speed followed here"
    number, kept = dataset.sizes["crossing"], int((dataset["speed_is_stable"] == 1).sum())
    if not number:
        return "The torque of the motor is that of the load at no speed followed here"
    speeds = amount_text(number, "speed")
    which = f"keeps {number_word(kept)} of {speeds}" if kept else f"keeps none of {speeds}"
    if number == 1:
        which = "keeps the one speed" if kept else "does not keep the one speed"
    elif kept == number:
        which = f"keeps {'both speeds' if number == 2 else f'all {speeds}'}"
    return f"The motor {which} at which its torque is that of the load"


def motor_answer(dataset: xr.Dataset) -> Answer | None:
    """Write which speeds the motor keeps, and its jump at the smallest change of torque; None without a motor."""
    if not has_motor(dataset):
        return None
    speeds = crossing_speeds(dataset)
    kept = speeds.values[dataset["speed_is_stable"].values == 1]
    symbol, over = symbol_text(dataset[followed(dataset)]), swept(dataset)
    if over and kept.size:
        # One speed of all values differs by its rounding.
        is_one = np.ptp(kept) <= SAME * kept.max()
        span = with_units(speeds, from_to(kept.min(), kept.min() if is_one else kept.max()))
        rest = f"They lie at {symbol} = {span}." if kept.size > 1 else f"It is {symbol} = {span}."
        return Answer(
            f"{title_motor(dataset)}.", " ".join(filter(None, [rest, jump_text(dataset)]))
        )
    if not kept.size:
        lead = "The motor keeps the speed of none of the motions followed here."
    else:
        values = [with_units(speeds, format_number(float(value))) for value in kept[:MAX_LISTED]]
        others = f" or {kept.size - MAX_LISTED} more" if kept.size > MAX_LISTED else ""
        which = "that" if kept.size == 1 else "those"
        lead = f"Of the motions followed here the motor keeps {which} at {symbol} = {' or '.join(values)}{others}."
    return Answer(lead, jump_text(dataset) if kept.size else "")


def jump_text(dataset: xr.Dataset) -> str:
    """Write the jump that the least change of torque brings about; empty without one."""
    torques, (lost, reached, changes) = dataset["jump_torque"], jumps_of(dataset)
    ahead = [n for n in range(torques.size) if is_ahead(dataset, n)]
    if not ahead:
        return ""
    n = min(ahead, key=lambda each: abs(changes[each]))
    speeds = dataset[followed(dataset)]
    change = with_units(torques, format_number(abs(float(changes[n])), 3))
    which = "more" if changes[n] > 0 else "less"
    text = f"With {change} {which} torque a speed is lost at {value_text(speeds, float(lost[n]))}"
    if over := swept(dataset):
        at = float(dataset[f"jump_{over}"][n])
        text += f", where {equal_text(dataset[over], at)},"
    if may_be_kept(dataset)[n]:
        return f"{text.rstrip(',')}, unless a motion that is not followed here keeps it."
    if not np.isfinite(reached[n]):
        return f"{text.rstrip(',')}; what follows is not among these motions."
    return f"{text} for {with_units(speeds, format_number(float(reached[n])))}."


def speed_table(scene: str, dataset: xr.Dataset) -> Table | None:
    """Return the table of the speeds at which both torques are equal; None without one."""
    if not has_motor(dataset) or not dataset.sizes["crossing"]:
        return None
    speeds, torques = crossing_speeds(dataset), dataset["motor_torque"]
    rows = [
        [
            words_of(dataset.isel(point=int(point))), format_number(float(speed), 5),
            format_number(float(torque)), "yes" if is_kept else "no",
        ]
        for point, speed, torque, is_kept in zip(
            dataset["crossing_point"].values, speeds.values, torques.values,
            dataset["speed_is_stable"].values == 1, strict=True,
        )
    ]  # fmt: skip
    head = ["motion", in_brackets("speed", speeds), in_brackets("torque", torques), "kept"]
    note = "A speed is kept where the motion is stable and the torque of the load rises over that of the motor."
    title = "At which speeds the torques of motor and load are equal"
    table = Table(head, rows, note, title=title, scene=scene, picture="motor")
    return with_values_beside(table, dataset, beside_at(dataset, "crossing", range(len(rows))))


def beside_at(dataset: xr.Dataset, dim: str, indices: Iterable[int]) -> list[float]:
    """Return the further parameter at crossings or jumps; nothing without one."""
    over = swept(dataset)
    return [float(dataset[f"{dim}_{over}"][n]) for n in indices] if over else []


def jump_table(scene: str, dataset: xr.Dataset) -> Table | None:
    """Return the table of the jumps; None without one."""
    if not has_motor(dataset) or not dataset.sizes["jump"]:
        return None
    speeds, torques = dataset[followed(dataset)], dataset["jump_torque"]
    lost, reached, torque = jumps_of(dataset)
    order = np.arange(len(torque))
    if len(torque) > MAX_ROWS:
        # Those that a kept speed meets first, and of the others those next to the torque as it is.
        order = np.lexsort([np.abs(torque), [not is_ahead(dataset, n) for n in order.tolist()]])
    rows = [
        [
            format_number(float(torque[n]), 3), WAYS[int(dataset["jump_way"][n])],
            format_number(float(lost[n]), 5), format_number(float(reached[n]), 5),
        ]
        for n in order.tolist()
    ]  # fmt: skip
    head = [
        in_brackets("torque added", torques), "as it is",
        in_brackets("speed lost", speeds), in_brackets("next speed", speeds),
    ]  # fmt: skip
    note = (
        "Torque added to that of the motor at all speeds (negative: taken away), at which a speed is lost as it is "
        "slowly raised or lowered."
    )
    is_open = may_be_kept(dataset).any()
    if any(DASH in row for row in rows):
        note += " A dash: what follows is not among the motions followed here"
        note += ", and may keep the speed." if is_open else "."
    title = "Where the speed jumps" + (", or motions followed here end" if is_open else "")
    left = 0 if swept(dataset) else 1
    table = Table(head, rows, note, left=left, title=title, scene=scene, picture="motor")
    return with_values_beside(table, dataset, beside_at(dataset, "jump", order))


def crossing_speeds(dataset: xr.Dataset) -> xr.DataArray:
    """Return the speeds at which both torques are equal."""
    return dataset[f"crossing_{followed(dataset)}"]


def is_ahead(dataset: xr.Dataset, n: int) -> bool:
    """Return whether a jump is the next one of a speed that is kept, as torque is added or taken away.

    From that speed its branch is stable up to the speed that is lost.
    """
    is_up = int(dataset["jump_way"][n]) == 1
    if (float(dataset["jump_torque"][n]) > 0.0) != is_up:
        return False
    over, sign = swept(dataset), 1.0 if is_up else -1.0
    speeds, ids = dataset[followed(dataset)].values, dataset["branch_id"].values
    steady = dataset["stable"].values == 1
    steady |= is_neutral(dataset)
    steady[dataset["bifurcation_point"].values] = True
    excess = dataset["load_torque"].values - dataset["available_torque"].values
    lost = sign * float(dataset[f"jump_{followed(dataset)}"][n])
    if over:
        ids = np.where(dataset[over].values == float(dataset[f"jump_{over}"][n]), ids, -1)
    kept = dataset["crossing_point"].values[dataset["speed_is_stable"].values == 1]
    for point in kept[ids[kept] >= 0].tolist():
        step = 1 if sign * (speeds[point + 1] - speeds[point]) > 0.0 else -1
        at = point + (step > 0)
        while 0 <= at < len(speeds) and ids[at] == ids[point] and steady[at]:
            if sign * speeds[at] >= lost - SAME * abs(lost):
                torque = float(dataset["jump_torque"][n])
                return bool(
                    np.abs(excess[[at, at - step]] - torque).min()
                    <= NEAR * np.nanmax(np.abs(excess))
                )
            after = at + step
            if not (0 <= after < len(speeds) and sign * (speeds[after] - speeds[at]) > 0.0):
                break
            at = after
    return False


def may_be_kept(dataset: xr.Dataset) -> np.ndarray:
    """Return of each jump whether a motion that is not followed may keep the speed, as at a bifurcation it may."""
    lost, reached, _torques = jumps_of(dataset)
    places = dataset[f"bifurcation_{followed(dataset)}"].values
    return np.isnan(reached) & np.isclose(lost[:, None], places, 1e-9, 0.0).any(axis=1)


def jumps_of(dataset: xr.Dataset) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return of each jump the speed that is lost, the next one, and the torque that is added."""
    name = followed(dataset)
    lost, reached = (dataset[f"{start}_{name}"].values for start in ("jump", "jump_to"))
    return lost, reached, dataset["jump_torque"].values
