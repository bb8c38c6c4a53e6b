"""Which sources a piece of the program depends on, and their hash: the import closure, read from the text.

Nothing is imported to find it, so a command knows its hash before anything slow is loaded. An import that
stands inside a function counts like one at the head; one that only type checkers see does not.
"""

from __future__ import annotations

import functools
import hashlib
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

PACKAGE = Path(__file__).parents[1]
# Makes machine code of kernels; nothing imports it, a process of its own runs it.
COMPILER = "vibropipe.compiler.server"
# What turns parameters into numbers: the public faces.
SOLVERS = (
    "vibropipe.solve.conservative",
    "vibropipe.solve.motion",
    "vibropipe.solve.steady",
    "vibropipe.solve.sweep",
    COMPILER,
)
# Units, symbols and long names of quantities: words beside the numbers, never part of them.
WORDS = ("vibropipe.words.vocabulary",)
_IMPORT = re.compile(
    r"^[ \t]*(?:from[ \t]+(?P<module>vibropipe[\w.]*)[ \t]+import[ \t]+(?P<names>\([^)]*\)|[^\n]*)"
    r"|import[ \t]+(?P<plain>vibropipe[\w.]*))",
    re.MULTILINE,
)
_FOR_TYPES = re.compile(r"^if TYPE_CHECKING:\n(?:[ \t]+[^\n]*\n|\n)*", re.MULTILINE)


class Source(NamedTuple):
    """SHA-256 of a file, and the names that its import lines may mean."""

    digest: bytes
    imports: frozenset[str]


@functools.cache
def kernel_hash() -> str:
    """Hash (16 hex digits) of all sources that the numbers of a solver depend on; needs no compiler."""
    return source_hash(SOLVERS)


def file_hash(path: Path, package: Path = PACKAGE) -> str:
    """Return the hash (16 hex digits) of a source file, wherever it lies, and all of the package that it imports.

    What the solvers import is told by `kernel_hash` already.
    """
    text = path.read_bytes()
    modules = {name for name in _imports(text.decode()) if _read(name, package) is not None}
    digest = hashlib.sha256(text)
    digest.update(source_hash(modules, closure(SOLVERS, package=package), package).encode())
    return digest.hexdigest()[:16]


def source_hash(roots: Iterable[str], left_out: Iterable[str] = (), package: Path = PACKAGE) -> str:
    """Return the hash (16 hex digits) of the import closure of modules.

    Parameters
    ----------
    roots, left_out : iterable of str
        Modules, and those that are not followed beside `WORDS`, by their dotted names.
    package : Path
        Folder of the package whose sources are read.
    """
    digest = hashlib.sha256()
    for name, source in sorted(closure(roots, left_out, package).items()):
        digest.update(name.encode() + b"\0" + source.digest + b"\0")
    return digest.hexdigest()[:16]


def closure(
    roots: Iterable[str], left_out: Iterable[str] = (), package: Path = PACKAGE
) -> dict[str, Source]:
    """Return modules and all that they import within the package, by dotted name.

    Parameters and their meaning are those of `source_hash`. A package counts by its `__init__`, but for the
    outermost one, which holds the version and the names of the face.

    Raises
    ------
    ValueError
        If a root is no module of the package.
    """
    ends = {*WORDS, *left_out, package.name}
    found: dict[str, Source] = {}
    todo = list(roots)
    for name in todo:
        if _read(name, package) is None:
            raise ValueError(f"roots: must be modules of {package}, got {name}")
    while todo:
        name = todo.pop()
        source = None if name in found or name in ends else _read(name, package)
        if source is not None:
            found[name] = source
            todo += [*source.imports, name.rpartition(".")[0]]
    return found


@functools.cache
def _read(name: str, package: Path) -> Source | None:
    """Return the source of a module, or None if the package has none of that name."""
    first, *parts = name.split(".")
    place = package.joinpath(*parts)
    for file in (place / "__init__.py", place.with_name(f"{place.name}.py")):
        if first == package.name and file.is_file():
            text = file.read_bytes()
            return Source(hashlib.sha256(text).digest(), frozenset(_imports(text.decode())))
    return None


def _imports(text: str) -> Iterator[str]:
    """Yield the names that may be modules in the import lines of a source."""
    for match in _IMPORT.finditer(_FOR_TYPES.sub("", text)):
        module = match["module"] or match["plain"]
        yield module
        for name in re.findall(r"\w+", match["names"] or ""):
            yield f"{module}.{name}"
