"""What a pendulum will cost."""

from vibropipe.scenes.costs import Work, grid_size


def plan(scene):
    rows = scene.row_count
    return Work(grid_size(scene), rows, "exact", ("period",), seconds=1e-6 * rows, bytes=16 * rows)
