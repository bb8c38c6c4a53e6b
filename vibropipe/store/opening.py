"""A whole study opened lazily."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from contextlib import ExitStack
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

from vibropipe.store.atomic import StoreError, check_intact, scenes_of
from vibropipe.store.files import REPORT, files_in, open_lazily, selected_attributes
from vibropipe.words.wording import series

if TYPE_CHECKING:
    import xarray as xr


# Attribute of datasets: the scenes of the study that they were made from. Attribute of an opened study: other datasets
# in its folder.
SCENES, LEFT_OUT = "scenes", "left_out"


def open_study(folder: str | PathLike[str]) -> xr.DataTree:
    """Open the scenes of a study lazily: a slice reads only its values.

    The scenes are those of the study that the folder is named after or, if none of its results was made from one of
    that name, of its newest result, as they were when that result was made. If other datasets lie in the folder, a
    warning names them.

    Parameters
    ----------
    folder : path-like
        Results of a study: one file per scene.

    Returns
    -------
    xarray.DataTree
        One group per scene with its dimensions, its quantities in dask chunks, their units in the attribute `units`
        ("1": non-dimensional) and the provenance in its attributes. A group has the methods `where` and `to_dataframe`
        (`vibropipe.store.tree.StudyTree`), which leave ragged impacts out. Closing the tree closes all files. The
        attribute `left_out` of the tree, if there is one, names the other datasets.

    Raises
    ------
    StoreError
        If there is no such folder, it is a file, it holds no scene, or a scene's file is truncated. Single flipped
        bytes are detected by `vibropipe verify` only.

    References
    ----------
    CF Conventions, section 9.3.3, contiguous ragged array representation (the lists of impacts).
    """
    from vibropipe.store.tree import StudyTree

    if Path(folder).is_file():
        raise StoreError(
            f"{folder}: must be the folder of a study, got a file: open it with vp.load"
        )
    files_there = files_in(Path(folder))
    paths = scenes_in(Path(folder), files_there) or files_there
    left_out = series(path.stem for path in files_there if path not in paths)
    for path in paths:
        check_intact(path, every_byte=False)
    scenes = {path.stem: open_lazily(path, chunks="auto") for path in paths}
    tree = StudyTree.from_dict(dict(scenes), name=Path(folder).name)
    if left_out:
        tree.attrs[LEFT_OUT] = left_out
        text = f"{folder}: holds also {left_out}, not in the study; open them with vp.load"
        warnings.warn(text, stacklevel=3)
    files = ExitStack()
    for scene in scenes.values():
        files.callback(scene.close)
    tree.set_close(files.close)
    return tree


def scenes_in(folder: Path, files: Sequence[Path]) -> list[Path]:
    """Return the files of the scenes of the study in a folder; none if no result says what they are."""
    made = {path: _made_from(path) for path in sorted(files, key=_time)}
    studies = [study for study, _ in made.values()]
    name = folder.resolve().name
    study = name if name in studies else studies[-1]
    own = {path: scenes for path, (other, scenes) in made.items() if other in ("", study)}
    report = folder / REPORT
    told = {**own, report: scenes_of(report)}
    named: list[str] = next((told[p] for p in sorted(told, key=_time, reverse=True) if told[p]), [])
    return [path for path in files if path in own and path.stem in named]


def _time(path: Path) -> int:
    return path.stat().st_mtime_ns if path.exists() else 0


def _made_from(path: Path) -> tuple[str, list[str]]:
    """Return name and scenes of the study from which a dataset was made; empty if it does not say."""
    try:
        attrs = selected_attributes(path, [SCENES, "title"])
    except StoreError:
        return "", []
    name, colon, _ = str(attrs.get("title", "")).partition(": ")
    return name if colon else "", str(attrs.get(SCENES, "")).split()
