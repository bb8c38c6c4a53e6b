"""Names of lines, written beside or on them where nothing else lies."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.text import Text
from numpy.typing import NDArray

from vibropipe.figures.canvas import CM_PER_INCH, TIGHT_GROUND, label, size_of

Floats = NDArray[np.float64]
NAME = "name of a line"
PLACES = 48  # that are tried along a line
MANY_PLACES = 400  # of a line whose points are few
MANY = 2000  # points above which a line is thinned for its labels
MOST_PLACES = 200  # that are looked at above and below a line
ENOUGH = 0.8  # cm of clearance beyond which a place is no better
MARGIN = 0.12  # cm around a label
CLEAR = 0.02  # cm to other lines that leave a place on a line free
BESIDE_CM = 0.1, 0.18, 0.27, 0.36  # cm from a line to a label beside it, more where it is steep
TIGHT = 0.08  # cm less around a label beside its line
AMPLE = 0.4  # cm of clearance beyond which a place beside a line is no better
NEARER = 0.1  # cm by which other lines are farther from a label beside its line
STEP_CM = 0.05  # cm between points of a line that labels avoid
JUMP_CM = 0.4  # cm to a next point that lies across a jump
ROUNDING_CM = 1e-6  # cm by which the ends of a line are off those of its axes
SHOWN_CM = 0.15  # cm of a line that are seen beside a label on it


@dataclass(frozen=True)
class Named:
    """A line with its name; points that are not finite are gaps.

    is_needed : whether the name stands left or right of the line, or on it, where it has no room above or below it;
        else it is left out there
    breaks : the points after which the line is broken, beside its gaps; None if long steps are jumps
    """

    x: Floats
    y: Floats
    text: str
    colour: str
    is_needed: bool = True
    breaks: Sequence[int] | None = None


def label_lines(
    ax: Axes, lines: Sequence[Named], obstacles: Iterable[tuple[Floats, Floats]] = ()
) -> list[Text]:
    """Write the name of each line above or below it, on the side without others, and return what is written.

    Where it has no room there, it stands left or right of its line, or on it, with white below, or is left out.

    ax : where the lines are drawn, with their scales and limits
    lines : the lines; the first ones choose first
    obstacles : other curves, from which names keep away
    """
    size = np.array(size_of(ax))
    ax.autoscale_view()  # matplotlib puts it off until the limits are asked for
    points = [_in_cm(ax, line.x, line.y, size) for line in lines]
    drawn = [_seen(_joined(shown)) for shown in points]
    none = np.empty((0, 2))
    others = [
        _seen(np.concatenate([none, *(_joined(_in_cm(ax, x, y, size)) for x, y in obstacles)]))
    ]
    boxes: list[Floats] = []
    written: list[Text] = []
    for number, (line, all_points) in enumerate(zip(lines, points, strict=True)):
        own = _evenly(_seen(all_points), MOST_PLACES)
        half = _half_size(ax, line.text)
        inside = own[((own > half) & (own < size - half)).all(axis=1)]
        if not own.size:
            continue
        rest = [
            *(p for n, p in enumerate(drawn) if n != number),
            *others,
            _seen(_jumps(ax, line, all_points, size)),
        ]
        path = drawn[number]
        for axis in (1, 0) if line.is_needed else (1,):  # of a steep line left or right of it
            tried = _beside(half - TIGHT, size, own, path, rest, axis)
            tried = tried[_is_free(tried, half - TIGHT, boxes)]
            if len(tried):
                break
        clearance = np.minimum(_distance(tried, half - TIGHT, rest), AMPLE)
        clearance -= 0.5 * _distance(tried, half - TIGHT, [path])  # better close to its line
        upright = "center"
        if not len(tried) and line.is_needed:
            upright = "center_baseline"  # letters without descenders are centred on their line
            tried = _evenly(inside, PLACES)
            tried = tried[_is_free(tried, half, boxes) & ~_hides(tried, half, own)]
            ends = _in_cm(ax, *_ends(line), size)
            goes_on = _distance(tried, half, [ends]) >= SHOWN_CM
            tried = tried[goes_on] if goes_on.any() else tried
            clearance = _distance(tried, half, rest)
            if not (clearance >= CLEAR).any():  # over as little of the others as can be
                clearance = -_covered(tried, half, rest)
        if not len(tried):
            continue
        middle = 0.02 * np.abs(tried - size / 2).sum(axis=1) / size.sum()
        at = tried[int(np.argmax(clearance - middle))]
        boxes.append(np.array([at - half, at + half]))
        x, y = at / size
        written.append(
            label(ax, x, y, line.text, line.colour, transform=ax.transAxes, ha="center", va=upright,
                  bbox=TIGHT_GROUND, zorder=6, gid=NAME)
        )  # fmt: skip
    return written


def with_places(values: Floats) -> Floats:
    """Return values along a line with others between them: its long steps are no jumps, and have room for names."""
    number = max(MANY_PLACES, values.size)
    return np.interp(np.linspace(0.0, values.size - 1.0, number), np.arange(values.size), values)


def _beside(
    half: Floats, size: Floats, own: Floats, path: Floats, rest: Sequence[Floats], axis: int
) -> Floats:
    """Return places on both sides of a line whose labels are clearly nearer to it than to others, and touch none.

    own, path : (n, 2) points of the line, without and with others between them
    axis : 0 for labels left and right of it, 1 for labels above and below
    """
    found = []
    for side in (sign * (half[axis] + gap) for gap in BESIDE_CM for sign in (1.0, -1.0)):
        places = own + side * np.eye(2)[axis]
        fits = ((places > half + TIGHT) & (places < size - half - TIGHT)).all(axis=1)
        to_own, to_rest = _distance(places, half, [path]), _distance(places, half, rest)
        found.append(places[fits & (to_own > CLEAR) & (to_rest > to_own + NEARER)])
    return np.concatenate(found)


def _ends(line: Named) -> tuple[Floats, Floats]:
    """Return the first and last points of all stretches of a line."""
    known = np.isfinite(line.x) & np.isfinite(line.y)
    joined = known[:-1] & known[1:]
    joined[list(line.breaks or ())] = False
    is_end = known & ~(np.append(joined, False) & np.insert(joined, 0, False))
    return line.x[is_end], line.y[is_end]


def _in_cm(ax: Axes, x: Floats, y: Floats, size: Floats) -> Floats:
    """Return the finite points of a line within its axes, in centimetres from their corner, (n, 2)."""
    kept = np.isfinite(x) & np.isfinite(y)
    points = np.stack([x[kept], y[kept]], axis=1)
    shown = ax.transAxes.inverted().transform(ax.transData.transform(points)) * size
    return shown[((shown >= -ROUNDING_CM) & (shown <= size + ROUNDING_CM)).all(axis=1)]


def _joined(points: Floats) -> Floats:
    """Return the points of a line with others between them, STEP_CM apart, so that none passes a label unseen."""
    steps = np.diff(points, axis=0)
    amount = np.ceil(np.hypot(*steps.T) / STEP_CM).astype(int)
    of_step = np.repeat(np.arange(amount.size), amount)
    number = np.arange(of_step.size) - (amount.cumsum() - amount)[of_step]
    between = points[of_step] + (number / amount[of_step])[:, None] * steps[of_step]
    return np.concatenate([between, points[-1:]])


def _evenly(points: Floats, most: int) -> Floats:
    """Return some points of a line, from end to end: all, if they are no more than that."""
    if len(points) <= most:
        return points
    return points[np.linspace(0, len(points) - 1, most).astype(int)]


def _seen(points: Floats) -> Floats:
    """Return the points of a line; of many, the first one in each cell of a step."""
    if len(points) <= MANY:
        return points
    cells = np.floor(points / STEP_CM).astype(int)
    return points[np.sort(np.unique(cells, axis=0, return_index=True)[1])]


def _jumps(ax: Axes, line: Named, points: Floats, size: Floats) -> Floats:
    """Return points on the jumps of a line, where arrows stand; `points` are those of the line, in centimetres."""
    if line.breaks is None:
        steps = np.hypot(*np.diff(points, axis=0).T)
        pairs = [points[n : n + 2] for n in np.flatnonzero(steps > JUMP_CM).tolist()]
    else:
        ends = (slice(n, n + 2) for n in line.breaks)
        pairs = [_in_cm(ax, line.x[each], line.y[each], size) for each in ends]
    return np.concatenate([np.empty((0, 2)), *(_joined(pair) for pair in pairs)])


def _half_size(ax: Axes, text: str) -> Floats:
    """Return half the width and height of a label in centimetres."""
    drawn = label(ax, 0.5, 0.5, text, transform=ax.transAxes)
    box = drawn.get_window_extent()
    drawn.remove()
    return np.array([box.width, box.height]) / ax.figure.dpi * CM_PER_INCH / 2 + MARGIN


def _distance(at: Floats, half: Floats, others: Sequence[Floats]) -> Floats:
    """Return how far the box of a label is from all points of other lines."""
    nearest = np.full(len(at), ENOUGH**2)
    for points in others:
        if len(points):
            x, y = (
                np.maximum(np.abs(at[:, k, None] - points[:, k]) - half[k], 0.0) for k in (0, 1)
            )
            nearest = np.minimum(nearest, (x * x + y * y).min(axis=1))
    return np.sqrt(nearest)


def _covered(at: Floats, half: Floats, others: Sequence[Floats]) -> Floats:
    """Return how many points of other lines a label covers."""
    found = np.zeros(len(at))
    for points in others:
        found += (np.abs(at[:, None] - points[None]) < half).all(axis=-1).sum(axis=1)
    return found


def _hides(at: Floats, half: Floats, own: Floats) -> NDArray[np.bool_]:
    """Return which labels would cover all points of a line."""
    return np.all(np.abs(at[:, None] - own[None]) < half, axis=(1, 2))


def _is_free(at: Floats, half: Floats, boxes: Sequence[Floats]) -> NDArray[np.bool_]:
    free = np.ones(len(at), np.bool_)
    for low, high in boxes:
        free &= ((at + half < low) | (at - half > high)).any(axis=1)
    return free
