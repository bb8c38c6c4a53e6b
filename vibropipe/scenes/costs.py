"""Cost of scenes, planned from their keys."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from vibropipe.physics.effects import ALL_EFFECTS, Effects
from vibropipe.scenes.keys.base import BaseScene
from vibropipe.solve.physical import convert
from vibropipe.words.vocabulary import physical_name, physical_quantity

# Bytes of a row without outputs, of an impact, and of the error of a number; usual impacts and samples of an orbit.
ROW_BYTES = 96
IMPACT_BYTES = 21
ERROR_BYTES = 4
# Numbers of a contact with a soft support; a row has the largest of each but the velocity after it.
CONTACT_NUMBERS = 4
USUAL_IMPACTS = 4
PHASE_SAMPLES = 256
# Subharmonics per harmonic, and sections of a row.
SUBHARMONICS = 4
VISITS = 64
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
    method : str
        Method by name.
    outputs : tuple of str
        Stored outputs.
    seconds : float
        Rough seconds on one core.
    bytes : float
        Bytes of the dataset before compression.
    pieces : int
        Largest number of shards.
    is_parallel : bool
        Whether threads share the work.
    """

    size: str
    rows: int
    method: str
    outputs: tuple[str, ...]
    seconds: float
    bytes: float
    pieces: int = 1
    is_parallel: bool = False


def slowness(scene: BaseScene) -> float:
    """Return how many times as long as motions without pieces those of a scene take, roughly."""
    return SLOWER if set(OF_PIECES) & set(scene.called_effects()) else 1.0


def grid_size(scene: BaseScene) -> str:
    """Write the sizes of the grids as a product: 200 nu x 3 f."""
    return " x ".join(
        f"{grid.size} {stored_name(scene, name)}" for name, grid in scene.grids().items()
    )


def stored_name(scene: BaseScene, name: str) -> str:
    """Return the name of a parameter in the data of a scene, which are in SI if its study has units."""
    return name if scene.mass_and_stiffness is None else physical_name(name)


def stored_values(scene: BaseScene, name: str, values: Iterable[float]) -> tuple[list[str], str]:
    """Return values of a parameter in the units of the study, as texts, and the unit with a blank before it."""
    numbers, unit = np.array([*values]), "1"
    if scene.mass_and_stiffness is not None:
        m, C = scene.mass_and_stiffness
        numbers = convert(name, numbers, {"m": m, "C": C})
        unit = physical_quantity(name).units
    return scene.units_shown.texts(stored_name(scene, name), numbers, unit)


def steady_bytes(
    outputs: Iterable[str],
    harmonics: int,
    impacts: float = USUAL_IMPACTS,
    effects: Effects = ALL_EFFECTS,
) -> float:
    """Return the bytes of one steady state with some outputs and a number of impacts.

    effects : those that the scene calls for, of which some have more numbers and derivatives
    """
    costs = {
        "harmonics": 2 * 8 + 4 * 8 * harmonics + ERROR_BYTES * (1 + 2 * harmonics),
        "impacts": 4 + 2 * (8 + ERROR_BYTES) + impacts * (IMPACT_BYTES + 2 * ERROR_BYTES),
        "stability": 2 * 16 + 1 + 2 * ERROR_BYTES,
        "motion": 2 * 8 * PHASE_SAMPLES,
        "energy": 6 * 8,
        "subharmonics": 2 * 8 * SUBHARMONICS * harmonics,
        "poincare": 2 * 8 * VISITS,
        "lyapunov": 2 * 8,
    }
    if effects.soft is not None:
        costs["impacts"] += CONTACT_NUMBERS * 8 * impacts + 2 * 8 * (CONTACT_NUMBERS - 1)
    requested = list(outputs)
    size = (
        ROW_BYTES
        + 2 * ERROR_BYTES
        + sum(costs[output] for output in requested if output != "sensitivity")
    )
    if "sensitivity" in requested:
        # here, since it imports numba, which a command that only reads studies does not need
        from vibropipe.physics.derivatives import differentiated_by

        # A derivative by each parameter beside every number that has one.
        numbers = {
            "harmonics": 2 + 4 * harmonics,
            "impacts": 2 + 2 * impacts,
            "stability": 4,
            "energy": 4,
            "subharmonics": 2 * SUBHARMONICS * harmonics,
            "lyapunov": 1,
        }
        own = 2 + sum(numbers.get(output, 0) for output in requested)
        by = differentiated_by(effects.has_pieces, effects.second_harmonic is not None)
        size += 8 * len(by) * own
    return size
