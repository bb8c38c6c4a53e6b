"""A whole study opened lazily."""

from __future__ import annotations

from contextlib import ExitStack
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

from vibropipe.store.atomic import check_intact
from vibropipe.store.files import files_in, open_lazily

if TYPE_CHECKING:
    import xarray as xr


def open_study(folder: str | PathLike[str]) -> xr.DataTree:
    """Open the results of a study lazily: a slice reads only its values.

    Parameters
    ----------
    folder : path-like
        Results of a study: one file per scene.

    Returns
    -------
    xarray.DataTree
        One group per scene with its dimensions, its quantities in dask chunks, their units in the attribute `units`
        ("1": non-dimensional) and the provenance in its attributes. A group has the methods `where` and `to_dataframe`
        (`vibropipe.store.tree.StudyTree`), which leave ragged impacts out. Closing the tree closes all files.

    Raises
    ------
    StoreError
        If there is no such folder, it holds no scene, or a scene's file is truncated. Single flipped bytes are detected
        by `vibropipe verify` only.

    References
    ----------
    CF Conventions, section 9.3.3, contiguous ragged array representation (the lists of impacts).
    """
    from vibropipe.store.tree import StudyTree

    paths = files_in(Path(folder))
    for path in paths:
        check_intact(path, every_byte=False)
    scenes = {path.stem: open_lazily(path, chunks="auto") for path in paths}
    tree = StudyTree.from_dict(dict(scenes), name=Path(folder).name)
    files = ExitStack()
    for scene in scenes.values():
        files.callback(scene.close)
    tree.set_close(files.close)
    return tree
