"""Pictures of a basins scene."""

from vibropipe.scenes.basins.basin_map import draw_basins
from vibropipe.scenes.basins.keys import BasinsFigure
from vibropipe.scenes.basins.text import describe_basins
from vibropipe.scenes.kind import Picture


def shown(options: BasinsFigure | None) -> tuple[str, ...]:
    """Return the quantities to show."""
    return tuple((options or BasinsFigure()).show)


PICTURES = (
    Picture(
        "basins",
        lambda dataset: True,
        lambda dataset, options, _: draw_basins(dataset, shown(options)),
        lambda dataset, options, _: describe_basins(dataset, shown(options)),
    ),
)
