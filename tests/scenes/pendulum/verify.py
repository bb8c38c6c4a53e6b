"""A pendulum computed again."""

from pendulum.solve import solve
from vibropipe.scenes.recompute import Recomputed
from vibropipe.store import compare


def recompute(path, scene, rows, generator):
    return Recomputed("all of it", compare(path, solve(scene)))
