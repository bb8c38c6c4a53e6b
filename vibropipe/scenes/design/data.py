"""What pictures and tables of designs show: the wanted quantities and parameters, by name and in words."""

from __future__ import annotations

import re
from collections.abc import Collection
from typing import NamedTuple

import numpy as np
import xarray as xr

from vibropipe.figures.claims import percent
from vibropipe.figures.motion_words import rests_of
from vibropipe.figures.text import REST, format_number, in_brackets, measured, symbol_of, with_units
from vibropipe.figures.units import unit_text
from vibropipe.solve.in_si import stated_start
from vibropipe.solve.shown_units import shown_factor, shown_unit
from vibropipe.words.designs import DesignResult
from vibropipe.words.quantities import FLAGS, QUANTITIES
from vibropipe.words.vocabulary import PHYSICAL_NAMES

# Quantities shown where no goal names any.
USUAL = ("displacement_mean", "displacement_amplitude_1", "impact_velocity_max_1")
INNER = ("support", "harmonic", "multiplier")
ENDS = ("target", "lower", "upper")
NOTHING = 1e-9


class Part(NamedTuple):
    """One number of a vector quantity: its variable, and the label along its own dimension, if any."""

    variable: str
    dim: str = ""
    label: int = 0

    @property
    def name(self) -> str:
        """Its name with index."""
        return f"{self.variable}_{self.label}" if self.dim else self.variable

    def of(self, dataset: xr.Dataset, suffix: str = "") -> xr.DataArray:
        """Return its values, or those of a quantity derived from it."""
        values = dataset[self.variable + suffix]
        if not suffix and "estimate" in values.dims:  # a spread that is to be least
            values = values.sel(estimate="first_order")
        return values.sel({self.dim: self.label}) if self.dim else values

    def symbol(self, dataset: xr.Dataset) -> str:
        """Return its symbol as mathtext."""
        return symbol_of(dataset[self.variable], self.label or None)

    def words(self, dataset: xr.Dataset) -> str:
        """Return its long name as plain text, with the support or harmonic that it is of."""
        long_name = str(dataset[self.variable].attrs.get("long_name", ""))
        return in_words(self.variable, long_name, self.dim, self.label)

    def label_text(self, dataset: xr.Dataset) -> str:
        """Return the label of an axis: words and the unit."""
        return in_brackets(self.words(dataset), dataset[self.variable])

    def value_text(self, dataset: xr.Dataset, row: int, digits: int = 3) -> str:
        """Write its value of a design with the unit."""
        values = self.of(dataset)
        value = float(values.values[row])
        if self.variable == "yield":  # as it is told everywhere else
            return percent(value)
        if np.isnan(value):  # a support that is not struck has no velocity
            return "no value"
        value = 0.0 if is_nothing(dataset, self, value) else value
        write = format_number if value.is_integer() else measured
        return with_units(values, write(value, digits))

    def end(self, dataset: xr.Dataset, which: str) -> float:
        """Return its target, lower or upper bound; NaN without one."""
        if f"{self.variable}_{which}" not in dataset:
            return float("nan")
        return float(self.of(dataset, f"_{which}"))


def is_nothing(dataset: xr.Dataset, part: Part, value: float) -> bool:
    """Return whether a displacement, or a deviation of it, is rounding beside the distance of the supports."""
    return part.variable.startswith("displacement") and abs(value) <= NOTHING * half_distance(
        dataset
    )


def half_distance(dataset: xr.Dataset) -> float:
    """Return half the distance between the supports of design 1."""
    return float(np.ravel(dataset["l"].values)[0])


def in_words(variable: str, long_name: str, dim: str = "", label: int = 0) -> str:
    """Return a quantity in words, with the support or harmonic that it is of."""
    short = QUANTITIES[variable].short if variable in QUANTITIES else ""
    name = short or long_name or variable.replace("_", " ")
    if dim == "harmonic":
        return f"{name.removeprefix('harmonic ')} of harmonic {label}"
    at = " at" if dim == "support" else ","
    return f"{name}{at} {dim} {label}" if dim else name


def wanted_parts(dataset: xr.Dataset) -> list[Part]:
    """Return the parts with a target or a bound, then those to be least; the usual ones if there are none."""
    found: list[Part] = []
    for name in map(str, dataset.data_vars):
        stem, _, end = name.rpartition("_")
        if end in ENDS and stem in dataset and stem not in varied(dataset):
            values = dataset[name]
            dim = str(values.dims[0]) if values.dims else ""
            labels = (
                [int(n) for n in values[dim].values[np.isfinite(values.values)]] if dim else [0]
            )
            found += [Part(stem, dim, label) for label in labels]
    found += [Part(name) for name in ("displacement_misfit",) if name in dataset]
    named = [text.removeprefix("-") for text in objectives(dataset)]
    found += [part for name in named if (part := part_of(dataset, name))]
    return list(dict.fromkeys(found or usual_parts(dataset)))


def usual_parts(dataset: xr.Dataset) -> list[Part]:
    """Return the usual quantities that a dataset has."""
    return [part for name in USUAL if (part := part_of(dataset, name))]


def spread_parts(dataset: xr.Dataset) -> list[Part]:
    """Return the wanted quantities whose spread is known of design 1; the usual ones if there are none."""
    for parts in (wanted_parts(dataset), usual_parts(dataset)):
        held = [part for part in parts if f"{part.variable}_contribution" in dataset]
        if kept := [each for each in held if each.of(dataset).notnull().values.flat[0]]:
            return kept
    return []


def objectives(dataset: xr.Dataset) -> list[str]:
    """Return the quantities to be least, as they are written."""
    return str(dataset.attrs.get("minimise", "")).split("; ") if "minimise" in dataset.attrs else []


def part_of(dataset: xr.Dataset, name: str) -> Part | None:
    """Return a quantity of a dataset by its name with index; None if it is another one."""
    if name in dataset:
        return Part(name)
    if PHYSICAL_NAMES.get(name) in dataset:
        return Part(PHYSICAL_NAMES[name])
    stem, _, label = name.rpartition("_")
    if stem in dataset and label.isdigit():
        dims = [str(dim) for dim in dataset[stem].dims if dim in INNER]
        return Part(stem, dims[0], int(label)) if dims else None
    return None


def varied(dataset: xr.Dataset) -> list[str]:
    """Return the names of the varied parameters."""
    return str(dataset.attrs["vary"]).split()


def numbers(dataset: xr.Dataset) -> np.ndarray:
    """Return the numbers of the designs, from 1."""
    return np.arange(1, dataset.sizes["design"] + 1)


def has_spread(dataset: xr.Dataset) -> bool:
    """Return whether tolerances of parameters were given."""
    return "law_change_share" in dataset


def has_yield(dataset: xr.Dataset) -> bool:
    """Return whether it is known how many scattered parts keep all that is wanted."""
    return "yield" in dataset


def has_tolerances(dataset: xr.Dataset) -> bool:
    """Return whether the tolerances that parameters need were asked for."""
    return "tolerance_result" in dataset


class Goal(NamedTuple):
    """A target, a bound, or what is least or largest: of what, and its text, such as `< 0.8`."""

    words: str
    text: str


# A number of a goal, `displacement_mean = -0.05 m; ...`, with its unit if any.
_NUMBER = re.compile(r"(?<![\w.])([-+]?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?)(?: ([A-Za-z][^,;]*))?")
_SHOWN_DIGITS = 6
# A start as an attribute, without units or in SI, and the digits that its six are shown with.
_START_DIGITS = 5
MOST = {False: "least", True: "greatest"}


def goals(dataset: xr.Dataset) -> list[Goal]:
    """Return all that is wanted, with numbers in the units that the dataset shows."""
    allowed = dict(shown_goals(dataset, "allow"))
    found = []
    for name, text in shown_goals(dataset, "target"):
        shown = text.removeprefix("= ")
        if name in allowed:
            shown = f"{_bare(shown, allowed[name])} ± {allowed[name].removeprefix('= ')}"
        found.append(Goal(words_of(dataset, name), shown))
    found += [
        Goal(words_of(dataset, name), text) for name, text in shown_goals(dataset, "subject_to")
    ]
    for text in objectives(dataset):
        most = MOST[text.startswith("-")]
        found.append(Goal(words_of(dataset, text.removeprefix("-")), most))
    return found


def off_allowed(dataset: xr.Dataset, part: Part) -> float:
    """Return how far the target of a quantity may be off, in the unit shown; 0 if that is not said."""
    for text in str(dataset.attrs.get("allow", "")).split("; "):
        name, _, rest = text.partition(" = ")
        if part_of(dataset, name) == part:
            number, _, units = rest.partition(" ")
            return shown_unit(dataset, units or "1")[1] * float(number)
    return 0.0


def _bare(number: str, other: str) -> str:
    """Return a number without its unit if the other number has the same one."""
    value, _, unit = number.partition(" ")
    return value if unit and other.endswith(f" {unit}") else number


def shown_goals(dataset: xr.Dataset, key: str) -> list[tuple[str, str]]:
    """Return the name and the text of each goal of an attribute."""
    texts = str(dataset.attrs[key]).split("; ") if key in dataset.attrs else []
    pairs = [text.partition(" ") for text in texts]
    return [
        (name, _NUMBER.sub(lambda match: _shown(dataset, *match.groups()), rest))
        for name, _, rest in pairs
    ]


def _shown(dataset: xr.Dataset, number: str, units: str | None) -> str:
    """Write a number of a goal, given in stored units, in the units shown."""
    unit, factor = shown_unit(dataset, units or "1")
    return f"{format_number(factor * float(number), _SHOWN_DIGITS)} {unit_text(unit)}".strip()


def words_of(dataset: xr.Dataset, name: str) -> str:
    """Return the words of a quantity by its name with index."""
    part = part_of(dataset, name)
    return part.words(dataset) if part else name.replace("_", " ")


def wanted_text(dataset: xr.Dataset, told: Collection[str] = ()) -> str:
    """Write what is wanted, one goal after the other, without goals of quantities that are told of."""
    texts = []
    for goal in (each for each in goals(dataset) if each.words not in told):
        if goal.text in MOST.values():
            texts.append(f"{goal.text} possible {goal.words}")
        else:
            sign = " " if goal.text.startswith(("<", ">", "at ")) else " = "
            texts.append(f"{goal.words}{sign}{goal.text}")
    return "; ".join(texts)


def struck_texts(dataset: xr.Dataset) -> list[str]:
    """Write how often each design strikes supports 1 and 2: `3 + 1`, or `2 + 1 in 2 periods`."""
    impacts = dataset["impacts_per_orbit"].transpose("design", "support")
    rests = rests_of(dataset, impacts).transpose("design", "support").values
    texts = []
    for m, counts, rested in zip(
        dataset["period_multiple"].values, impacts.values, rests, strict=True
    ):
        text = " + ".join(
            REST if rest > 0 else f"{n:g}" for n, rest in zip(counts, rested, strict=True)
        )
        texts.append(text if m == 1 else f"{text} in {m:g} periods")
    return texts


def from_rest_texts(dataset: xr.Dataset) -> list[str]:
    """Write of each design whether the mass settles on it from rest; nothing of a dataset that does not say it."""
    if "from_rest" not in dataset:
        return []
    known = {FLAGS["settled_same"]["same"]: "yes", FLAGS["settled_same"]["other"]: "no"}
    return [known.get(int(code), "unknown") for code in dataset["from_rest"].values]


def start_words(dataset: xr.Dataset) -> str:
    """Write from where all motions of the search start, in the units shown; empty where it is not one state."""
    start = stated_start(str(dataset.attrs.get("start", "")))
    if start is None:
        return ""
    texts = []
    for name, number in zip(("displacement", "velocity"), start, strict=True):
        of = dataset[f"{name}_strobe"]
        value = shown_factor(of.attrs["units"]) * number
        texts.append(f"the {name} {with_units(of, format_number(value, _START_DIGITS))}")
    return " and ".join(texts)


def is_met(dataset: xr.Dataset) -> np.ndarray:
    """Return of each design whether all that is wanted holds."""
    return dataset["design_result"].values == DesignResult.MET


def is_front(dataset: xr.Dataset) -> bool:
    """Return whether designs are a Pareto front that can be drawn."""
    return (
        len(ends_of(dataset)) == 2 and dataset.sizes["design"] > 1 and bool(is_met(dataset).all())
    )


def ends_of(dataset: xr.Dataset) -> list[tuple[Part, float]]:
    """Return the two quantities of a front with their signs, -1 of one that is to be largest."""
    found = [(part_of(dataset, text.removeprefix("-")), text) for text in objectives(dataset)]
    return [(part, -1.0 if text.startswith("-") else 1.0) for part, text in found if part]
