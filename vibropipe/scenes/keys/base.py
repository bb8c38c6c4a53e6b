"""Keys and methods that scenes of every kind have, and types of values they share."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, TypeVar

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator, Field, PrivateAttr

from vibropipe.physics.effects import Effects, all_effects
from vibropipe.physics.limits import HARMONICS
from vibropipe.physics.plausible import unit_warning
from vibropipe.physics.start import largest_start
from vibropipe.physics.ties import Ties
from vibropipe.scenes.keys.grids import RangeGrid, StudyModel, ValueGrid
from vibropipe.scenes.keys.parts import ExciterKeys, FigureOptions, PhysicalKeys, figure_key
from vibropipe.scenes.keys.values import NotNull, NumberRange, TextRule, refuse
from vibropipe.solve.shown_units import Shown
from vibropipe.solve.sweep.sweep_grid import SweepGrid
from vibropipe.words.outputs import Output
from vibropipe.words.parameters import DEFAULTS, FORCES, without_absent
from vibropipe.words.vocabulary import dimensions_hash, physical_name

Title = Annotated[str, TextRule(200)]
Question = Annotated[str, TextRule(110)]  # a line of the report
Conclusion = Annotated[str, TextRule(250)]  # an answer of a report
Cell = Annotated[str, TextRule(120)]  # of a table of a report
Prose = Annotated[str, TextRule(4000, one_line=False)]
Harmonics = Annotated[int, NumberRange(*HARMONICS, whole=True)]

# Version of the meaning of the keys. Increase it when a meaning changes, so that older data are recomputed.
SEMANTICS_VERSION = 2
# Keys without influence on data; `data_exciter` gives the parameters that have some.
NO_DATA = ("title", "caption", "figure", "exciter", "physical")


def each_once(names: list[Any]) -> list[Any]:
    """Refuse a list that names something twice."""
    if len(set(map(str, names))) < len(names):
        refuse(found=", ".join(map(str, names)), must="must have each name once")
    return names


Entry = TypeVar("Entry")
EachOnce = Annotated[list[Entry], AfterValidator(each_once)]
Outputs = Annotated[list[Output], Field(min_length=1), AfterValidator(each_once)]


class BaseScene(StudyModel):
    """Base of all scenes; `name` is the scene's key in the study."""

    title: Title = Field(default="", description="Title of the scene.")
    caption: Prose = Field(
        default="", description="Caption of the figure (default: written from the data)."
    )
    exciter: ExciterKeys = Field(
        default_factory=ExciterKeys,
        description="Parameters of this scene, in place of the study's.",
    )
    physical: Annotated[PhysicalKeys | None, NotNull] = Field(
        default=None,
        description="Parameters of this scene with units; for a study with `physical`.",
    )
    figure: FigureOptions = figure_key(FigureOptions, "picture")
    # Whether the kind computes soft supports and friction.
    COMPUTES_PIECES: ClassVar[bool] = False
    # Whether it computes a housing that slides, too.
    COMPUTES_HOUSING: ClassVar[bool] = False
    # Whether tied parameters follow those that the kind varies; others have them once.
    FOLLOWS_TIES: ClassVar[bool] = False
    if TYPE_CHECKING:  # each kind describes this key itself
        kind: str
    _name: str = PrivateAttr("")
    _shared: dict[str, float] = PrivateAttr(default_factory=dict)
    _shared_ties: dict[str, str] = PrivateAttr(default_factory=dict)
    _mass_and_stiffness: tuple[float, float] | None = PrivateAttr(None)
    _units: Mapping[str, str] = PrivateAttr(default_factory=dict)

    @property
    def name(self) -> str:
        """The scene's name in its study."""
        return self._name

    @property
    def mass_and_stiffness(self) -> tuple[float, float] | None:
        """m (kg) and C (N/m) of a study with units, whose data are stored in SI; None for any other."""
        return self._mass_and_stiffness

    def as_written(self, name: str) -> str:
        """Return the name of a parameter in the study and its data, which are in SI if the study has units."""
        return name if self.mass_and_stiffness is None else physical_name(name)

    @property
    def units_shown(self) -> Shown:
        """The units in which its study shows what it finds."""
        return Shown(self._units)

    @property
    def row_count(self) -> int:
        """Number of rows to solve."""
        return math.prod(grid.size for grid in self.grids().values())

    def grids(self) -> dict[str, ValueGrid | RangeGrid]:
        """Return the grids the scene runs over, in the order of its dimensions."""
        return {}

    def over_arrays(self) -> dict[str, NDArray[np.float64]]:
        """Return the same grids as arrays, each of shape (size of its dimension,)."""
        return {name: grid.array() for name, grid in self.grids().items()}

    def varied_names(self) -> set[str]:
        """Return the names that have several values: swept, followed, searched or measured."""
        keys = (getattr(self, key, ()) for key in ("over", "along", "vary", "measured"))
        return {str(name) for names in (self.grids(), *keys) for name in names}

    def extent(self) -> dict[str, Any]:
        """Return each parameter with the values that it takes, or the ends of their range."""
        return {**self.resolved_exciter(), **self.over_arrays()}

    def warning(self) -> str:
        """Return what is hardly meant: a frequency without a force, or odd lengths of a study with units."""
        values = {**DEFAULTS, **self.extent()}
        free = {*FORCES} - self.tied().texts.keys() - self.varied_names()
        if (
            "nu" in self.varied_names()
            and len(free) == len(FORCES)
            and not any(np.any(values[n]) for n in free)
        ):
            return "no force acts, so that nothing depends on the frequency that varies"
        return "" if self.mass_and_stiffness is None else unit_warning(self.extent())

    def tied(self) -> Ties:
        """Return the ties of its parameters; none unless its kind has the key."""
        return Ties()

    def follow_pair(self) -> tuple[str, str] | None:
        """Return the parameter along which rows seed each other and its direction, or None."""
        return None

    def row_grid(self) -> SweepGrid:
        """Return the grid of its rows, with the parameters that are not swept."""
        return SweepGrid(self.over_arrays(), self.follow_pair(), self.resolved_exciter())

    def given_exciter(self) -> dict[str, float]:
        """Return the parameters that the scene or the study states; the scene's take precedence."""
        return {**self._shared, **self.exciter.explicit()}

    def resolved_exciter(self) -> dict[str, float]:
        """Return the parameters (`without_absent`): the scene's own, else the study's, else "effect absent".

        A swept parameter has the first value of its grid.
        """
        return without_absent({**DEFAULTS, **self.given_exciter()})

    def computed(self) -> dict[str, bool]:
        """Return which further effects its kind computes, as keywords of `all_effects`."""
        return {"pieces": self.COMPUTES_PIECES, "housing": self.COMPUTES_HOUSING}

    def all_effects(self) -> Effects:
        """Return the effects of its exciters."""
        return all_effects(self.extent(), pieces=True, housing=self.COMPUTES_HOUSING)

    def has_l(self) -> bool:
        """Return whether l is given, by the scene, by the study or by a grid."""
        return "l" in (*self.given_exciter(), *self.grids(), *self.tied().parameters)

    @property
    def gives_backbone(self) -> bool:
        """Whether its dataset is the backbone that a sweep may be drawn over."""
        return False

    def method_text(self) -> str:
        """Return the method by name, with its steps per forcing period."""
        return "exact"

    def accuracy_asked(self) -> float | None:
        """Return the accuracy requested in place of a method; None for a method."""
        return None

    def called_effects(self) -> tuple[str, ...]:
        """Return the effects of the scene by name: as stated, else as its parameters require."""
        raise NotImplementedError

    def data_exciter(self) -> dict[str, float]:
        """Return the parameters that the data depend on, without those of several values."""
        varied = self.varied_names()
        return {name: v for name, v in self.resolved_exciter().items() if name not in varied}

    def data_keys(self) -> dict[str, Any]:
        """Return the keys that the data of the scene depend on, with defaults filled in, and their `meaning`."""
        keys = {name: plain(getattr(self, name)) for name in type(self).model_fields}
        keys = {name: value for name, value in keys.items() if name not in NO_DATA}
        for name in ("prove", "ramp"):  # as of scenes before there were proofs and ramps
            if not keys.get(name):
                keys.pop(name, None)
        for name in ("outputs", "effects"):
            if keys.get(name) is not None:
                keys[name] = sorted(keys[name])
        if keys.get("start"):
            ends = {name: [grid.low, grid.high] for name, grid in self.grids().items()}
            keys["start"] = resolved_start(keys["start"], {**self.resolved_exciter(), **ends})
        if self.mass_and_stiffness is not None:
            # what is in SI depends on the table of dimensions as well
            m, C = self.mass_and_stiffness
            keys["physical"] = {"m": m, "C": C, "dimensions": dimensions_hash()}
        return {"meaning": SEMANTICS_VERSION, "exciter": self.data_exciter(), **keys}

    def row_keys(self) -> dict[str, Any] | None:
        """Return the keys that a row depends on beside its values of the grids.

        Rows of two scenes with equal keys are the same where these values are; None if rows depend on each other.
        """
        return None

    def canonical_text(self) -> str:
        """Return the keys that the data depend on as one line of JSON, equal for scenes of the same meaning."""
        return canonical_json(self.data_keys())

    def fingerprint(self) -> str:
        """Return the SHA-256 hash (64 hex digits) of the keys that the data depend on."""
        return hashlib.sha256(self.canonical_text().encode()).hexdigest()


def canonical_json(value: Any) -> str:
    """Return mappings, lists, text and numbers as one line of JSON, keys in alphabetical order."""
    return json.dumps(value, sort_keys=True, separators=(",", ":"), allow_nan=False)


def plain(value: Any) -> Any:
    """Return a value of a study as mappings, lists, text and numbers."""
    if isinstance(value, StudyModel):
        return {name: plain(getattr(value, name)) for name in type(value).model_fields}
    if isinstance(value, dict):
        return {name: plain(entry) for name, entry in value.items()}
    return [plain(entry) for entry in value] if isinstance(value, (list, tuple)) else value


def resolved_start(start: dict[str, Any], values: dict[str, Any]) -> dict[str, Any]:
    """Return a start with x0 = 0 where it is left out and the equilibrium is free in every row."""
    is_equilibrium = start["x0"] is None and largest_start(values, None) == 0.0
    at_zero = is_equilibrium and not np.any(values.get("load", 0.0))
    return {**start, "x0": 0.0} if at_zero else start


def drawn_by_others(scenes: Mapping[str, Any]) -> set[str]:
    """Return the scenes of a study that have no picture of their own.

    Another scene draws them together with itself, and they neither choose pictures nor draw others.
    """
    shown = {name for scene in scenes.values() for name in scene.figure.drawn_together()}
    return {
        name
        for name, scene in scenes.items()
        if name in shown and not scene.figure.chosen() and not scene.figure.drawn_together()
    }
