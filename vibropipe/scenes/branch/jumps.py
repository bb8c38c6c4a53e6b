"""Where motions jump from one stretch of a branch to another, and the arrows of jumps in a picture."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import xarray as xr

from vibropipe.scenes.branch.lines import followed
from vibropipe.scenes.branch.stretches import SAME, Stretch

CAUSES = ("fold", "grazing", "change")  # bifurcations at which a motion may jump
MIN_ARROW = 0.04  # of the heights of a panel: a shorter jump has no arrow


@dataclass(frozen=True)
class Jump:
    """Where a followed motion has no stable neighbour, the motions beyond, and the change of impact velocity."""

    stretch: Stretch
    is_up: bool
    targets: tuple[Stretch, ...]
    size: float

    @property
    def kind(self) -> str:
        """The bifurcation at which it jumps."""
        return self.stretch.ends[1 if self.is_up else 0]

    @property
    def value(self) -> float:
        """Where it jumps."""
        return float(self.stretch.values[-1 if self.is_up else 0])


def jumps_of(dataset: xr.Dataset, stretches: list[Stretch]) -> list[Jump]:
    """Return where motions jump that are followed upwards or downwards, the largest jumps first."""
    along = dataset[followed(dataset)].values
    gap = SAME * float(along.max() - along.min())
    found: dict[tuple[float, bool, str, float], Jump] = {}
    for stretch in stretches:
        for is_up, kind in ((False, stretch.ends[0]), (True, stretch.ends[1])):
            if kind not in CAUSES:
                continue
            value = float(stretch.values[-1 if is_up else 0])
            before = stretch.amplitude(value)
            beyond = value + (gap if is_up else -gap)
            others = [s for s in stretches if s.over == stretch.over and s.reaches(beyond)]
            steps = [abs(s.amplitude(beyond) - before) for s in others]
            # The amplitude changes as a square root beside a grazing: by the root of the gap.
            if steps and min(steps) <= np.sqrt(SAME) * 10 * max(before, gap):
                continue
            if not steps and kind != "fold":
                continue  # it may go on with another impact sequence
            speed = stretch.speed(value)
            size = min((abs(s.speed(beyond) - speed) for s in others), default=speed)
            jump = Jump(stretch, is_up, tuple(others), size)
            found.setdefault((stretch.over, is_up, stretch.law, round(value / gap)), jump)
    return sorted(found.values(), key=lambda jump: -jump.size)


class Arrow(NamedTuple):
    """A jump in a panel: the parameter, the heights between which it leads, and the motion that it leaves."""

    value: float
    start: float
    end: float
    stretch: Stretch


def arrows_of(jumps: Sequence[Jump], heights: np.ndarray) -> list[Arrow]:
    """Return the jumps in a panel of one height a point, (points, 1), that lead to one height."""
    if heights.shape[1] != 1 or not np.isfinite(heights).any():
        return []
    least = MIN_ARROW * float(np.nanmax(heights) - np.nanmin(heights))
    found = []
    for jump in jumps:
        start, *ends = (
            float(np.interp(jump.value, each.values, heights[each.points, 0]))
            for each in (jump.stretch, *jump.targets)
        )
        if ends and np.ptp(ends) < SAME * least and abs(ends[0] - start) > least:
            found.append(Arrow(jump.value, start, ends[0], jump.stretch))
    return found
