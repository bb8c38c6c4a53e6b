"""Keys of identification scenes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from vibropipe.physics.exciter import Exciter, ParameterError
from vibropipe.physics.si import eigenfrequency
from vibropipe.scenes.costs import HEAD_BYTES, Work, slowness
from vibropipe.scenes.keys.checks import (
    EXCITER,
    TIES,
    TOGETHER,
    Check,
    check_numbers,
    check_vary,
    check_vary_corners,
)
from vibropipe.scenes.keys.effects import VariedScene
from vibropipe.scenes.keys.parts import Start, VariedName
from vibropipe.scenes.keys.problems import Problem, argument_path, refused
from vibropipe.scenes.keys.values import (
    Interval,
    NotNull,
    NumberOrUnit,
    NumberRange,
    Sigma,
    TextRule,
    as_number,
    number_hint,
    refuse,
)
from vibropipe.words.designs import DESIGN_SAMPLES
from vibropipe.words.parameters import PARAMETERS
from vibropipe.words.sensors import TAU

# Seconds of a row; sweeps of all samples that searches take as long as.
ROW_SECONDS, SWEEPS = 1e-4, 12
OUTPUTS = ("harmonics", "impacts", "stability")
# Keys that the table is read with.
READ = ("vary", "measured", "noise", "steady_from", "blanking", "sign")
Text = Annotated[str, TextRule(200)]


@dataclass(frozen=True)
class ColumnRule(NumberOrUnit):
    """A column of a table: a list of numbers."""

    allowed = "a list of finite numbers"

    @property
    def schema(self) -> dict[str, Any]:  # noqa: D102
        return {"type": "array", "items": super().schema, "minItems": 1}

    def convert(self, value: Any) -> Any:  # noqa: D102
        numbers = [as_number(entry) for entry in value] if isinstance(value, list) else [None]
        for entry, number in zip(
            value if isinstance(value, list) else [value], numbers, strict=True
        ):
            if number is None or not np.isfinite(number):
                refuse(self.allowed, repr(entry), number_hint(entry))
        return numbers


class IdentifyScene(VariedScene):
    """Parameters that explain a measured motion or response."""

    COMPUTES_PIECES = True
    COMPUTES_HOUSING = True
    kind: Literal["identify"] = Field(
        description="Parameters that explain a measured motion or response."
    )
    measured: Annotated[dict[Text, Annotated[list[float], ColumnRule()]], Field(min_length=2)] = (
        Field(
            description="CSV file, its path from the folder of the study, or its columns as lists: `phase` (forcing "
            "periods) and `displacement`; or swept parameters and quantities, named as columns of tables are; or a "
            "record: `time` (`tau` in a study without units), one or several of `displacement`, `velocity`, "
            "`acceleration`, and `force` or `trigger` if one tells the phase.",
            json_schema_extra={"type": ["string", "object"]},
        )
    )
    vary: Annotated[dict[VariedName, Interval], Field(min_length=1)] = Field(
        description="Ends of each parameter to be found."
    )
    noise: dict[Text, Sigma] = Field(
        default={},
        description="Standard deviation of each measured quantity; needed for several of a response (default: "
        "estimated).",
    )
    steady_from: Annotated[float | None, NumberOrUnit(), NotNull] = Field(
        default=None,
        description="Of a record, the time from which its motion is steady (default: found in its first half).",
    )
    blanking: Annotated[float | None, NumberOrUnit(0), NotNull] = Field(
        default=None,
        description="Of a record, the time on each side of an impact on a rigid support in which velocities and "
        "accelerations do not count (default: 1.5 intervals between samples).",
    )
    sign: Literal["known", "unknown"] = Field(
        default="unknown",
        description="Of a record, whether it is known that sensors count towards support 1.",
    )
    start: Start = Field(default_factory=Start, description="Start of every motion.")
    samples: Annotated[int, NumberRange(*DESIGN_SAMPLES, whole=True)] = Field(
        default=128, description="Samples of a round."
    )

    @property
    def row_count(self) -> int:  # noqa: D102 - as BaseScene
        return self.samples * (self.points if self.swept else 1)

    @property
    def points(self) -> int:
        """Number of lines of the table."""
        return len(next(iter(self.measured.values())))

    def first_values(self) -> dict[str, float]:  # noqa: D102 - as TiedScene
        return {**super().first_values(), **{n: v[0] for n, v in self.swept.items()}}

    def known_exciter(self) -> dict[str, float]:
        """Return the parameters that are not tied, without the frequency where it is that of a record."""
        exciter = self.untied_exciter()
        return {n: value for n, value in exciter.items() if n != "nu" or not self.finds_frequency}

    @property
    def finds_frequency(self) -> bool:
        """Whether the forcing frequency is that of a record."""
        is_stated = "nu" in self.given_exciter() or "nu" in self.ranges()
        return TAU in self.measured and not is_stated

    def varied_names(self) -> set[str]:  # noqa: D102 - as BaseScene
        return super().varied_names() | ({"nu"} if self.finds_frequency else set())

    @property
    def swept(self) -> dict[str, list[float]]:
        """Columns of the table that are parameters."""
        return {n: values for n, values in self.measured.items() if n in PARAMETERS}


def _measured(scene: IdentifyScene) -> Iterator[Problem]:
    """Check the table as `vibropipe.identify` does, and that its parameters are in range and stated once."""
    from vibropipe.solve.fit.reading import read_table
    from vibropipe.solve.fit.record import Reading

    try:
        p = eigenfrequency(*scene.mass_and_stiffness) if scene.mass_and_stiffness else None
        reading = Reading(scene.steady_from, scene.blanking, scene.sign, p)
        known, noise = Exciter(**scene.known_exciter()), scene.noise or None
        read_table(known, scene.measured, scene.ranges(), noise, reading, scene.tied())
    except ParameterError as error:
        owner = {"nu": ("exciter",), "omega": ("physical",)}.get(error.name, ())
        yield refused((*owner, *argument_path(error)), error)
        return
    yield from check_numbers(scene, "measured", scene.swept)


CHECKS = (
    TIES,
    TOGETHER,
    Check((("vary",),), check_vary),
    Check((*EXCITER, ("vary",), ("start",), ("measured",)), check_vary_corners),
    Check((*EXCITER, *((key,) for key in READ)), _measured),
)


def plan(scene: IdentifyScene) -> Work:
    """Return the work of a search of usual length, which is not known before."""
    names = ", ".join(scene.as_written(str(name)) for name in scene.vary)
    beside = {TAU, "phase", "force", "trigger"}
    quantities = len(scene.measured.keys() - scene.swept.keys() - beside)
    of = "" if quantities == 1 else f" of {quantities} quantities"
    return Work(
        size=f"{scene.points} measurements{of}, {scene.samples} samples over {names}",
        rows=scene.row_count,
        outputs=OUTPUTS,
        seconds=1.0 + SWEEPS * scene.row_count * ROW_SECONDS * slowness(scene),
        bytes=HEAD_BYTES + 16 * scene.points * len(scene.measured),
        is_foreseen=False,
    )
