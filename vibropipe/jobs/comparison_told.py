"""What differs between two datasets, told: as lines of text, a table, and a picture."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from vibropipe.jobs.comparison import (
    SHARE,
    Change,
    Comparison,
    changed_laws,
    common_rows,
    difference,
)
from vibropipe.physics.exciter import ParameterError
from vibropipe.words.wording import aligned, count

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

MAX_LINES = 40  # of each kind


def as_lines(found: Comparison) -> list[str]:
    """Write a comparison as lines of text, at most MAX_LINES of each kind."""
    lines = []
    if found.settings:
        lines += aligned([("setting", "A", "B"), *found.settings])
    if found.study:
        lines += ["", "study (- A, + B)", *cut(found.study)]
    over = f" over {', '.join(found.over)}" if found.over else ""
    rows = f"{count(found.rows, 'row')}{over} in both"
    lines += ["", f"{rows}, {found.only[0]:,} in A alone, {found.only[1]:,} in B alone"]
    if found.laws is not None:
        differ = "differs" if 1 in (len(found.laws), found.rows) else "differ"
        lines.append(f"law of motion: {len(found.laws):,} of {count(found.rows, 'row')} {differ}")
        lines += cut([f"  {law}" for law in found.laws])
    if found.changes:
        head = ("quantity", "rows", "largest difference", "of largest value", "at")
        cells = [
            (each.name, f"{each.rows:,}", *sizes_of(each), each.where)
            for each in found.changes
        ]  # fmt: skip
        lines += ["", *aligned([head, *cells])]
    lines += [
        "",
        f"{count(found.same, 'quantity', 'quantities')} agree within errors and {SHARE:g}",
    ]
    if found.left_out:
        lines.append(f"not compared, in one alone or in another shape: {', '.join(found.left_out)}")
    return lines


def sizes_of(change: Change) -> tuple[str, str]:
    """Write how much a quantity differs, and its share of the largest value; of codes that they are others."""
    if math.isnan(change.relative):
        return "another code", ""
    return f"{change.largest:.3g} {change.unit}".strip(), f"{change.relative:.2g}"


def cut(lines: list[str]) -> list[str]:
    """Return the first lines, and how many more there are."""
    more = len(lines) - MAX_LINES
    return [*lines[:MAX_LINES], f"  and {more:,} more"] if more > 0 else lines


def as_table(found: Comparison) -> pd.DataFrame:
    """Return the quantities that differ as a table."""
    import pandas as pd

    return pd.DataFrame(found.changes, columns=list(Change._fields))


def draw(one: xr.Dataset, two: xr.Dataset, found: Comparison) -> Any:
    """Draw where laws differ, and the difference of the quantity that differs most, of a sweep over one or two.

    Raises ParameterError if the datasets are no such sweeps.
    """
    from vibropipe.figures.comparison import draw_curve, draw_map
    from vibropipe.figures.style import in_style

    first, second, dims = common_rows(one, two)
    has_axes = all(dim in one.indexes and one[dim].dtype.kind in "iuf" for dim in dims)
    if len(dims) not in (1, 2) or not has_axes:
        must = "must be a table, .csv: pictures are of sweeps over one or two parameters"
        raise ParameterError("output", "", must=must, got="")
    scalars = [
        each.name for each in found.changes
        if not math.isnan(each.relative) and {*first[each.name].dims} <= {*dims, "support"}
        and {*dims} <= {*first[each.name].dims}
    ]  # fmt: skip
    moved = None
    if scalars:
        moved = abs(difference(first, second, scalars[0])[0]).assign_attrs(first[scalars[0]].attrs)
        moved = moved.max("support", keep_attrs=True) if "support" in moved.dims else moved
    drawn = draw_map if len(dims) == 2 else draw_curve
    return in_style(lambda: drawn(changed_laws(first, second), moved, found.rows))
