"""The import closure of modules, read from their text, and the hash of its sources.

Nothing is imported to find it, so a command knows its hash before anything slow is loaded. An import within a function
counts like one at the top; one under TYPE_CHECKING does not.
"""

from __future__ import annotations

import functools
import hashlib
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

from vibropipe.words import exciter, quantities

PACKAGE = Path(__file__).parents[1]
# Modules that turn parameters into numbers: the public functions.
SOLVERS = (
    "vibropipe.solve.motion.conservative",
    "vibropipe.solve.motion.simulate",
    "vibropipe.solve.rows.steady",
    "vibropipe.solve.sweep.sweep",
)
# Units, symbols and long names of quantities, and numbers in SI of text with units: no kernel depends on them. Of the
# records numbers depend on `facts`, not on the texts.
WORDS = (
    "vibropipe.words.vocabulary",
    "vibropipe.words.units",
    "vibropipe.words.exciter",
    "vibropipe.words.quantities",
    "vibropipe.words.records",
)
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
    """Return the hash (16 hex digits) of all sources that the numbers of a solver depend on; needs no compiler."""
    return source_hash(SOLVERS)


def file_hash(path: Path, package: Path = PACKAGE) -> str:
    """Return the hash (16 hex digits) of a source file and of the modules of the package that it imports.

    The import closure of the solvers is left out: `kernel_hash` covers it.
    """
    text = path.read_bytes()
    modules = {name for name in _imports(text.decode()) if _read(name, package) is not None}
    digest = hashlib.sha256(text)
    digest.update(source_hash(modules, closure(SOLVERS, package=package), package).encode())
    return digest.hexdigest()[:16]


def source_hash(roots: Iterable[str], left_out: Iterable[str] = (), package: Path = PACKAGE) -> str:
    """Return the hash (16 hex digits) of the import closure of modules, and of the facts of the records.

    roots, left_out : dotted names of modules, and of those that are not followed (beside `WORDS`)
    package : folder of the package whose sources are read
    """
    digest = hashlib.sha256(f"{exciter.facts()}{quantities.facts()}".encode())
    for name, source in sorted(closure(roots, left_out, package).items()):
        digest.update(name.encode() + b"\0" + source.digest + b"\0")
    return digest.hexdigest()[:16]


def closure(
    roots: Iterable[str], left_out: Iterable[str] = (), package: Path = PACKAGE
) -> dict[str, Source]:
    """Return modules and all that they import within the package, by dotted name; arguments as of `source_hash`.

    A package counts by its `__init__`, except the outermost one, which holds the version and the public names.
    """
    ends = {*WORDS, *left_out, package.name}
    sources: dict[str, Source] = {}
    todo = list(roots)
    for name in todo:
        if _read(name, package) is None:
            raise ValueError(f"roots: must be modules of {package}, got {name}")
    while todo:
        name = todo.pop()
        source = None if name in sources or name in ends else _read(name, package)
        if source is not None:
            sources[name] = source
            todo += [*source.imports, name.rpartition(".")[0]]
    return sources


@functools.cache
def _read(name: str, package: Path) -> Source | None:
    """Return the source of a module, or None if the package has none of that name."""
    first, *parts = name.split(".")
    path = package.joinpath(*parts)
    for file in (path / "__init__.py", path.with_name(f"{path.name}.py")):
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
