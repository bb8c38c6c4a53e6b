"""Cost of scenes, planned from their keys."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from vibropipe.physics.effects import ALL_EFFECTS, Effects
from vibropipe.scenes.keys.base import BaseScene
from vibropipe.solve.in_si import convert
from vibropipe.words.vocabulary import STEADY, VOCABULARY, physical_quantity

# Bytes of the error of a number.
ERROR_BYTES = 4
# Usual sizes of dimensions of a row; subharmonics are counted per harmonic.
SIZES = {"support": 2, "multiplier": 2, "tau": 256, "visit": 64}
USUAL_IMPACTS, SUBHARMONICS = 4, 4
# Impacts of a row of a sweep over two parameters, on average: one in ten rows has no orbit, and then some 200.
SWEPT_IMPACTS = 25
# Bytes of an impact.
IMPACT_BYTES = sum(
    each.bytes
    for each in STEADY.values()
    if each.dims == ("impact",) and each.output == "impacts" and not each.effect
)
# Bytes of the headers of some thirty variables, most of a small file.
HEAD_BYTES = 9e4
# Effects with which a motion is marched by pieces, and how many times as long that takes, roughly.
OF_PIECES, SLOWER = ("soft", "friction"), 15.0


class PlanError(ValueError):
    """A scene cannot be cut into shards as requested, or a run has a wrong setting."""


@dataclass(frozen=True)
class Work:
    """Planned work of a scene, from its keys alone, so that every machine cuts it into the same shards.

    Attributes
    ----------
    size : str
        Grids of the scene as text.
    rows : int
        Number of steady states or of points of a curve; 1 for a motion.
    seconds : float
        Rough seconds on one core.
    bytes : float
        Bytes of the dataset before compression.
    method : str
        Method by name.
    outputs : tuple of str
        Stored outputs.
    pieces : int
        Largest number of shards.
    is_parallel : bool
        Whether threads share the work.
    is_foreseen : bool
        Whether the keys tell the work; else it depends on what is found, and is that of a usual scene.
    of_rests : str
        Module whose kernels are needed only if a motion is found that rests; "" if the keys tell all kernels.
    """

    size: str
    rows: int
    seconds: float
    bytes: float
    method: str = "exact"
    outputs: tuple[str, ...] = ()
    pieces: int = 1
    is_parallel: bool = False
    is_foreseen: bool = True
    of_rests: str = ""


def slowness(scene: BaseScene) -> float:
    """Return how many times as long as motions without pieces those of a scene take, roughly."""
    return SLOWER if set(OF_PIECES) & set(scene.called_effects()) else 1.0


def grid_size(scene: BaseScene) -> str:
    """Write the sizes of the grids as a product: 200 nu x 3 f."""
    return " x ".join(
        f"{grid.size} {scene.as_written(name)}" for name, grid in scene.grids().items()
    )


def stored_values(scene: BaseScene, name: str, values: Iterable[float]) -> tuple[list[str], str]:
    """Return values of a parameter in the units of the study, as texts, and the unit with a blank before it."""
    numbers, unit = np.array([*values]), "1"
    if scene.mass_and_stiffness is not None and name in VOCABULARY:
        m, C = scene.mass_and_stiffness
        numbers = convert(name, numbers, {"m": m, "C": C})
        unit = physical_quantity(name).units
    return scene.units_shown.texts(scene.as_written(name), numbers, unit)


def steady_bytes(
    outputs: Iterable[str],
    harmonics: int,
    impacts: float = USUAL_IMPACTS,
    effects: Effects = ALL_EFFECTS,
) -> float:
    """Return the bytes of one steady state with some outputs and a number of impacts.

    effects : those that the scene calls for, of which some have more numbers and derivatives
    """
    requested = {"", *outputs}
    sizes = {
        **SIZES,
        **{"harmonic": harmonics, "subharmonic": SUBHARMONICS * harmonics, "impact": impacts},
    }
    by = 0
    if "sensitivity" in requested:
        # here, since it imports numba, which a command that only reads studies does not need
        from vibropipe.physics.derivatives import differentiated_by

        has_second, has_housing = (
            each is not None for each in (effects.second_harmonic, effects.housing)
        )
        by = len(differentiated_by(effects.has_pieces, has_second, has_housing))
    size = 0.0
    for entry in STEADY.values():
        is_present = not entry.effect or getattr(effects, entry.effect) is not None
        if entry.output in requested and is_present:
            numbers = math.prod(sizes[dim] for dim in entry.dims)
            parts = 2 if entry.is_complex else 1
            size += numbers * (parts * entry.bytes + ERROR_BYTES * entry.has_error)
            size += numbers * parts * 8 * by * entry.has_derivative
    return size
