"""The picture that a study would draw of a dataset, as a figure of matplotlib."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

import numpy as np
import xarray as xr
from pydantic import ValidationError

from vibropipe.figures.text import clock, frequency
from vibropipe.figures.units import display_units
from vibropipe.physics.exciter import ParameterError
from vibropipe.scenes.keys.parts import FigureOptions
from vibropipe.scenes.keys.problems import Problem, StudyError
from vibropipe.scenes.kind import Kind, Picture
from vibropipe.scenes.registry import kind_of_dataset, kinds
from vibropipe.solve.shown_units import DISPLAY_UNITS, checked_units, units_as_text, units_of
from vibropipe.store import load
from vibropipe.study import study_at_hand, study_of_text
from vibropipe.study.key_text import problem_of
from vibropipe.words.spelling import did_you_mean
from vibropipe.words.vocabulary import VOCABULARY, held_name
from vibropipe.words.wording import series

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    Source = xr.Dataset | xr.DataTree | str | PathLike[str]

SHOWN = "shown"  # the dataset among others, where it has no name
OWN = {"show", "pictures"}  # options of a study that name no other scene
UNSAMPLED = "must hold the trajectory of its steady state: ask for the output motion, or draw what simulate returns"
WITHOUT_ORBIT = (
    "must hold a periodic motion, of which one period is drawn: draw what simulate returns"
)


def plot(
    dataset: Source | Sequence[Source] | Mapping[str, Source],
    picture: str | None = None,
    **options: Any,
) -> Figure:
    """Draw the picture that a study would draw of a dataset.

    Parameters
    ----------
    dataset : xarray.Dataset, xarray.DataTree, path, or several of them
        Any dataset of this package, in SI or not, a scene of what `open_study` returns, or a file of results. Several
        motions, or several sweeps of one parameter and branches along it, in a list or by name, are drawn over one
        another. Of a steady state with the output motion one period of its orbit is drawn.
    picture : str, optional
        The name of a picture in the key `figure` of a study (default: the one that the study of the dataset chooses,
        else the first that fits it).
    **options
        Options of the key `figure` of a scene of this kind, such as `show=["displacement_mean"]`. Where a study names
        another scene, as in `backbone`, a dataset or a path takes its place. `units={"frequency": "rpm"}` chooses
        units of datasets in SI by dimension (default: those of the study, or of `to_physical`).

    Returns
    -------
    matplotlib.figure.Figure
        16 or 7.75 cm wide, in units for display. `savefig` writes it as in a report.

    Raises
    ------
    ParameterError
        If there is no such picture or option, the picture does not fit the dataset, or datasets cannot be drawn over
        one another; the message lists what can.
    StoreError
        If a file is missing or damaged.

    Examples
    --------
    >>> import vibropipe as vp
    >>> exciter = vp.Exciter(l=0.5, nu=1.0, f=0.5, h=0.2, R1=0.7, R2=0.7)
    >>> figure = vp.plot(vp.simulate(exciter, tau_end=30))
    """
    from vibropipe.figures.style import in_style

    units = checked_units(options.pop("units", {}))
    if isinstance(dataset, Mapping) and not hasattr(dataset, "dims"):
        return _overlay(dict(dataset), picture, options, units)
    if isinstance(dataset, Sequence) and not isinstance(dataset, str):
        return _overlay(dict(enumerate(dataset, 1)), picture, options, units)
    data = opened(dataset)
    if picture is None and _is_steady_state(data):
        data = as_motion(data)
    kind = kind_of_data(data)
    data = with_a_grid(data)
    choice, others = _options(kind, data, dataset, picture, options)
    shown = display_units({SHOWN: with_units(data, units), **others})
    chosen = _picture(kind, shown[SHOWN], choice.chosen(), picture)
    return in_style(lambda: chosen.draw(shown[SHOWN], choice, shown))


def opened(dataset: Any) -> xr.Dataset:
    """Return a dataset from itself, a node of a tree, or a file, with its study as it is now if it is at hand."""
    if isinstance(dataset, str | PathLike):
        dataset = load(dataset)
    elif isinstance(dataset, xr.DataTree):
        if dataset.children and not dataset.data_vars:
            must = f"must be a scene of a study ({', '.join(dataset.children)})"
            raise ParameterError("dataset", dataset, must=must, got="the whole study")
        dataset = dataset.to_dataset()
    elif not isinstance(dataset, xr.Dataset):
        allowed = "an xarray.Dataset, a scene of open_study or a path"
        raise ParameterError("dataset", dataset, allowed, got=type(dataset).__name__)
    study = study_at_hand([dataset])
    return dataset.assign_attrs(study=study.text, **study.units_attrs) if study else dataset


def kind_of_data(data: xr.Dataset) -> Kind:
    """Return the kind of scenes that draws a dataset, or raise a ParameterError."""
    kind = kind_of_dataset(data)
    if kind is None:
        must = f"must be what a scene of a study holds ({series(kinds())})"
        held = series(map(str, [*data.data_vars][:4])) or "nothing"
        raise ParameterError("dataset", data, must=must, got=f"a dataset of {held}")
    return kind


def _is_steady_state(data: xr.Dataset) -> bool:
    return kind_of_data(data).name == "sweep" and is_steady_state(data)


def with_units(data: xr.Dataset, units: Mapping[str, str]) -> xr.Dataset:
    """Return a dataset whose units for display are chosen."""
    if not units:
        return data
    return data.assign_attrs({DISPLAY_UNITS: units_as_text({**units_of(data), **units})})


def with_a_grid(data: xr.Dataset) -> xr.Dataset:
    """Return one steady state as a sweep of one row, that of `tolerance` as one design; any other as it is."""
    if "law_change_share" in data and "design" not in data.dims:
        return data.expand_dims("design")
    return as_row(data) if is_steady_state(data) else data


def _options(
    kind: Kind, data: xr.Dataset, source: Any, picture: str | None, given: Mapping[str, Any]
) -> tuple[FigureOptions, dict[str, xr.Dataset]]:
    """Return the options of the pictures, and the datasets of other scenes that they name."""
    model: Any = kind.keys.model_fields["figure"].annotation
    own = {} if picture is not None else _options_of_study(data)
    if own and any(_beside(source, name) is None for name in model(**own).shown_scenes()):
        own = {name: own[name] for name in OWN & own.keys()}
    others: dict[str, xr.Dataset] = {}
    values = {**_shown_by_default(data, model), **own, **given}
    for name, value in given.items():
        if name in model.model_fields and not isinstance(value, list | tuple | str | None):
            values[name], others[name] = name, opened(value)
        elif isinstance(value, PathLike | str) and str(value).endswith(".nc"):
            values[name], others[name] = name, load(value)
    if picture is not None and "pictures" in model.model_fields:
        names = [each.name for each in kind.pictures]
        if picture not in names:
            raise _unknown(picture, [p.name for p in kind.pictures if p.fits(data)])
        values["pictures"] = [picture]
    try:
        options: FigureOptions = model.model_validate(values)
    except ValidationError as error:
        raise _refused(problem_of(error.errors(include_url=False)[0], model)) from None
    _check_shown(data, model, getattr(options, "show", ()))
    for name in options.shown_scenes():
        if name not in others:
            found = _beside(source, name)
            if found is None:
                must = (
                    f"must be a dataset or a path, since {name!r} is a scene that is not known here"
                )
                raise ParameterError("options", name, must=must, got="")
            others[name] = found
    return options, others


def _options_of_study(data: xr.Dataset) -> dict[str, Any]:
    """Return the options that the study of a dataset has for its scene; none of a dataset made in Python."""
    study_name, _, scene = str(data.attrs.get("title", "")).partition(": ")
    if "study" not in data.attrs or not scene:
        return {}
    try:
        figure = study_of_text(str(data.attrs["study"]), study_name).scene(scene).figure
    except StudyError:  # written for another version
        return {}
    return dict(figure.model_dump(exclude_unset=True))


def _beside(source: Any, name: str) -> xr.Dataset | None:
    """Return the dataset of another scene of the study from which a dataset comes; None where it is not known."""
    if isinstance(source, xr.DataTree) and source.parent is not None and name in source.parent:
        return source.parent[name].to_dataset()
    if (
        isinstance(source, str | PathLike)
        and (path := Path(source).with_name(f"{name}.nc")).exists()
    ):
        return load(path)
    return None


def _refused(problem: Problem) -> ParameterError:
    """Return a fault of an option as the error of an argument."""
    name = str(problem.path[0]) if problem.path else "options"
    must = problem.must or f"must be {problem.allowed}"
    must += f" ({problem.hint})" if problem.hint and not problem.found else ""
    got = f"{problem.found} ({problem.hint})" if problem.found and problem.hint else problem.found
    return ParameterError(name, problem.found, must=must, got=got)


def _shown_by_default(data: xr.Dataset, model: Any) -> dict[str, Any]:
    """Return the option `show` where the data lack a default one: those that they hold, else the first two held."""
    default = model.model_fields["show"].default if "show" in model.model_fields else ()
    known = [name for name in default if _is_held(data, name)]
    return {} if len(known) == len(default) else {"show": known or _held(data, model)[:2]}


def _is_held(data: xr.Dataset, name: str) -> bool:
    is_derived = name not in VOCABULARY or name == "impacts_per_period"
    return is_derived or held_name(data.variables, name) in data.variables


def _held(data: xr.Dataset, model: Any) -> list[str]:
    """Return the quantities of a dataset that can be shown."""
    shown = get_args(get_args(model.model_fields["show"].annotation)[0])
    return [str(each) for each in data.data_vars if each in shown]


def _check_shown(data: xr.Dataset, model: Any, show: Sequence[str]) -> None:
    """Raise a ParameterError for a quantity to show that the dataset does not hold."""
    for name in show:
        if not _is_held(data, name):
            must = f"must name quantities that the dataset holds ({series(_held(data, model))})"
            raise ParameterError("show", show, must=must, got=repr(name))


def _picture(kind: Kind, data: xr.Dataset, chosen: Sequence[str], picture: str | None) -> Picture:
    """Return the picture that is drawn: the one that is named, that the study chooses, or the first that fits."""
    fitting = [each for each in kind.pictures if each.fits(data)]
    wanted = picture if picture is not None else next(iter(chosen), None)
    if wanted is None and fitting:
        return fitting[0]
    found = next((each for each in fitting if each.name == wanted), None)
    if found is None:
        raise _unknown(wanted, [each.name for each in fitting])
    return found


def _unknown(picture: str | None, fitting: Sequence[str]) -> ParameterError:
    must = f"must be a picture that fits the dataset ({series(fitting) or 'there is none'})"
    hint = did_you_mean(picture, fitting)
    got = f"{picture!r} ({hint})" if hint else repr(picture)
    return ParameterError("picture", picture, must=must, got=got)


def _overlay(
    sources: Mapping[Any, Source],
    picture: str | None,
    options: Mapping[str, Any],
    units: Mapping[str, str],
) -> Figure:
    """Draw datasets over one another."""
    from vibropipe.figures.style import in_style
    from vibropipe.scenes.overlay import draw_overlay

    if not sources:
        raise ParameterError("dataset", sources, "at least one dataset", got="none")
    if picture is not None or options.keys() - {"show"}:
        name = "picture" if picture is not None else next(iter(options.keys() - {"show"}))
        must = "must be left out where datasets are drawn over one another: only show is taken"
        raise ParameterError(name, picture, must=must, got="")
    datasets = {key: opened(source) for key, source in sources.items()}
    steady = [key for key, data in datasets.items() if _is_steady_state(data)]
    others = (kind_of_data(data).name for key, data in datasets.items() if key not in steady)
    if all(name == "motion" for name in others):
        datasets |= {key: as_motion(datasets[key]) for key in steady}
    datasets = {key: with_units(with_a_grid(data), units) for key, data in datasets.items()}
    names = [kind_of_data(data).name for data in datasets.values()]
    show = tuple(options.get("show", ()))
    return in_style(lambda: draw_overlay(display_units(datasets), names, show))


def is_steady_state(data: xr.Dataset) -> bool:
    """Return whether a dataset is one steady state, or one row of a sweep."""
    is_row = "regime" in data and not data["regime"].dims and "displacement_end" not in data
    return is_row and clock(data) not in data.dims and frequency(data) in data.coords


def as_row(data: xr.Dataset) -> xr.Dataset:
    """Return one steady state as a sweep of one row."""
    return data.drop_dims("impact", errors="ignore").expand_dims(frequency(data))


def as_motion(data: xr.Dataset) -> xr.Dataset:
    """Return one period of one steady state as a motion, or raise a ParameterError where its trajectory is not held."""
    if "phase" not in data.dims:
        raise ParameterError("dataset", data, must=UNSAMPLED, got="")
    if not int(data["period_multiple"]) or not np.isfinite(data["displacement"].values).all():
        raise ParameterError("dataset", data, must=WITHOUT_ORBIT, got="")
    time, span = clock(data), 2.0 * math.pi / float(data["base_frequency"])
    units = {"units": "s" if time == "time" else "1"}
    data = data.isel(phase=[*range(data.sizes["phase"]), 0]).assign_attrs(kind="motion")
    samples = (time, span * np.append(data["phase"].values[:-1], 1.0), units)
    data = data.drop_vars("phase").rename(phase=time).assign_coords({time: samples})
    if "row_size" in data or "impact_phase" not in data:
        # impacts may be those of all rows of a sweep
        return data.drop_dims("impact", errors="ignore")
    multiple, support = int(data["period_multiple"]), data["impact_support"]
    at = span / multiple * (data["impact_period"] + data["impact_phase"])
    after = -xr.where(support == 1, data["R1"], data["R2"]) * data["impact_velocity"]
    after = data.get("impact_velocity_after", after)
    impacts = {f"impact_{time}": at.assign_attrs(units), "impact_velocity_after": after}
    return data.assign(impacts).sortby(at)
