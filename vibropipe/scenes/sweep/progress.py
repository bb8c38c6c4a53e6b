"""Answers of a sweep whose housing slides: how fast it progresses, which way, and with what power of the force."""

from __future__ import annotations

import xarray as xr

from vibropipe.figures.claims import rising_text
from vibropipe.figures.motion_words import way_of
from vibropipe.report.findings import largest, point_text, value_text
from vibropipe.report.parts import Answer
from vibropipe.scenes.sweep.neighbours import is_followed
from vibropipe.scenes.sweep.sweep_rows import is_from_rest
from vibropipe.words.regimes import Regime

DIGITS = 3


def fastest(dataset: xr.Dataset) -> tuple[xr.DataArray, xr.DataArray | None, xr.DataArray | None]:
    """Return the mean velocities of the housing in orbits, the largest of them, and the largest velocity of any."""
    is_orbit = dataset["regime"] < Regime.APERIODIC
    mean = dataset["housing_velocity_mean"].where(is_orbit)
    return mean, largest(mean), largest(dataset["housing_velocity_max"].where(is_orbit))


def progress_answer(dataset: xr.Dataset) -> Answer | None:
    """Return how fast the housing progresses in orbits, and which way; none where it is fixed."""
    if "housing_velocity_mean" not in dataset:
        return None
    values, top, speed = fastest(dataset)
    if top is None or speed is None:
        return None
    way, dims = way_of(float(top), float(speed)), dataset["regime"].dims
    if way is None:
        return Answer("In no orbit does the housing progress.")
    orbits = "reached from rest" if is_from_rest(dataset) else "on which the starts settle"
    orbits = "that are followed" if is_followed(dataset) else orbits
    most = value_text(top, abs(top), DIGITS)
    lead = f"In the orbits {orbits}, the fastest progression of the housing is {most}, {way}."
    back = largest(values.where(values * float(top) < 0))
    rises = rising_text(values, top, dims)
    other = None if back is None else way_of(float(back), float(speed))
    rest = f"Its speed {rises.removeprefix('it ')}" if rises else ""
    if back is not None and other is not None:
        most = value_text(back, abs(back), DIGITS)
        rest = f"{rest}; {other} it reaches {most}" if rest else f"It reaches {most} {other}"
    return Answer(lead, f"{rest or f'That is at {point_text(top, dims)}'}.")


def cost_answer(dataset: xr.Dataset) -> Answer | None:
    """Return the power of the force in the orbit with the fastest progression; none where no housing progresses."""
    if "power_input" not in dataset or "housing_velocity_mean" not in dataset:
        return None
    _, top, speed = fastest(dataset)
    if top is None or speed is None or way_of(float(top), float(speed)) is None:
        return None
    power = dataset["power_input"].sel({name: top[name] for name in dataset["regime"].dims})
    most = value_text(power, power, DIGITS)
    return Answer(
        f"With the fastest progression of an orbit, the mean power of the force is {most}."
    )
