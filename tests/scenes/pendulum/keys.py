"""The keys of a pendulum."""

from typing import Annotated, Literal

from pydantic import Field

from vibropipe.scenes.costs import Work, grid_size
from vibropipe.scenes.keys.base import BaseScene
from vibropipe.scenes.keys.checks import Check, no_exciter
from vibropipe.scenes.keys.grids import Grid
from vibropipe.scenes.keys.values import NumberRange


class PendulumScene(BaseScene):
    """The period of a pendulum over its amplitude."""

    kind: Literal["pendulum"] = Field(description="A pendulum.")
    amplitude: Grid = Field(description="Amplitudes in radians.")
    gravity: Annotated[float, NumberRange(0, 100, above=True)] = Field(
        default=9.81, description="In metres per second squared."
    )

    def grids(self):
        return {"amplitude": self.amplitude}

    def called_effects(self):
        return ()


CHECKS = (Check((), lambda scene: no_exciter(scene, "a pendulum has no exciter")),)


def plan(scene):
    rows = scene.row_count
    return Work(grid_size(scene), rows, 1e-6 * rows, 16 * rows, outputs=("period",))
