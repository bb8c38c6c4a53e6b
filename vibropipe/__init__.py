"""vibropipe: motions of a vibration exciter that strikes one or both of two supports."""

from __future__ import annotations

# Nothing is imported here but for type checkers: a command begins at once, and can be interrupted at once.
TYPE_CHECKING = False

# Names of the public face and where they live; imported on first use, so that `import vibropipe` is free.
_FACE = {
    "Exciter": "vibropipe.physics.exciter",
    "ParameterError": "vibropipe.physics.exciter",
    "StoreError": "vibropipe.store",
    "UnsolvedWarning": "vibropipe.words.status",
    "simulate": "vibropipe.solve.motion.simulate",
    "steady_state": "vibropipe.solve.rows.steady",
    "sweep": "vibropipe.solve.sweep.sweep",
    "branch": "vibropipe.solve.branch.branch",
    "motor": "vibropipe.solve.branch.motor",
    "attractors": "vibropipe.solve.basins.attractors",
    "basins": "vibropipe.solve.basins.basins",
    "boundary": "vibropipe.solve.boundary.boundary",
    "design": "vibropipe.solve.design.face",
    "identify": "vibropipe.solve.fit.identify",
    "tolerance": "vibropipe.solve.design.tolerance",
    "backbone": "vibropipe.solve.motion.conservative",
    "amplitude_frequency": "vibropipe.solve.motion.conservative",
    "symmetric_orbit": "vibropipe.solve.boundary.closed_orbits",
    "symmetric_orbit_boundaries": "vibropipe.solve.boundary.closed_orbits",
    "one_sided_orbit": "vibropipe.solve.boundary.closed_orbits",
    "one_sided_orbit_boundaries": "vibropipe.solve.boundary.closed_orbits",
    "load": "vibropipe.store",
    "open_study": "vibropipe.store",
    "save": "vibropipe.store",
    "table": "vibropipe.store",
    "plot": "vibropipe.jobs.plot",
    "prove": "vibropipe.proof.face",
    "prove_all": "vibropipe.proof.face",
    "prove_bifurcation": "vibropipe.proof.face",
    "prove_knock": "vibropipe.proof.face",
    "to_physical": "vibropipe.solve.physical",
}
__all__ = sorted(_FACE)
__version__: str  # as installed; pyproject.toml states it

if TYPE_CHECKING:
    from typing import Any

    # with `as`, which tells a type checker that a name is public
    from vibropipe.jobs.plot import plot as plot
    from vibropipe.physics.exciter import Exciter as Exciter
    from vibropipe.physics.exciter import ParameterError as ParameterError
    from vibropipe.proof.face import prove as prove
    from vibropipe.proof.face import prove_all as prove_all
    from vibropipe.proof.face import prove_bifurcation as prove_bifurcation
    from vibropipe.proof.face import prove_knock as prove_knock
    from vibropipe.solve.basins.attractors import attractors as attractors
    from vibropipe.solve.basins.basins import basins as basins
    from vibropipe.solve.boundary.boundary import boundary as boundary
    from vibropipe.solve.boundary.closed_orbits import one_sided_orbit as one_sided_orbit
    from vibropipe.solve.boundary.closed_orbits import (
        one_sided_orbit_boundaries as one_sided_orbit_boundaries,
    )
    from vibropipe.solve.boundary.closed_orbits import symmetric_orbit as symmetric_orbit
    from vibropipe.solve.boundary.closed_orbits import (
        symmetric_orbit_boundaries as symmetric_orbit_boundaries,
    )
    from vibropipe.solve.branch.branch import branch as branch
    from vibropipe.solve.branch.motor import motor as motor
    from vibropipe.solve.design.face import design as design
    from vibropipe.solve.design.tolerance import tolerance as tolerance
    from vibropipe.solve.fit.identify import identify as identify
    from vibropipe.solve.motion.conservative import amplitude_frequency as amplitude_frequency
    from vibropipe.solve.motion.conservative import backbone as backbone
    from vibropipe.solve.motion.simulate import simulate as simulate
    from vibropipe.solve.physical import to_physical as to_physical
    from vibropipe.solve.rows.steady import steady_state as steady_state
    from vibropipe.solve.sweep.sweep import sweep as sweep
    from vibropipe.store import StoreError as StoreError
    from vibropipe.store import load as load
    from vibropipe.store import open_study as open_study
    from vibropipe.store import save as save
    from vibropipe.store import table as table
    from vibropipe.words.status import UnsolvedWarning as UnsolvedWarning


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import PackageNotFoundError, version

        try:
            globals()[name] = version("vibropipe")
        except PackageNotFoundError:
            globals()[name] = "unknown"
        return globals()[name]
    if name not in _FACE:
        raise AttributeError(
            f"module 'vibropipe' has no attribute {name!r}; it has {', '.join(__all__)}"
        )
    from importlib import import_module

    found = getattr(import_module(_FACE[name]), name)
    globals()[name] = found if isinstance(found, type) else _telling_faults(found)
    return globals()[name]


def _telling_faults(function: Any) -> Any:
    """Return a function of the face that says what an unknown keyword could mean, and which type an argument must have.

    Errors of an exciter with units speak of the names and values that were given.
    Warnings of the function itself count this frame as well (`stacklevel`).
    """
    from functools import wraps
    from inspect import Parameter, signature

    from vibropipe.physics.parameter_error import ParameterError
    from vibropipe.solve.argument_types import check_names, check_types, checks_of

    known, types = signature(function).parameters, checks_of(signature(function))
    if any(each.kind is Parameter.VAR_KEYWORD for each in known.values()):
        return function

    @wraps(function)
    def checked(*args: Any, **given: Any) -> Any:
        check_names(given, known)
        by_name = {**dict(zip(known, args, strict=False)), **given}
        check_types(types, by_name)
        try:
            return function(*args, **given)
        except ParameterError as error:
            if getattr(by_name.get("exciter"), "written", None):
                from vibropipe.solve.given_units import in_given_units

                raise in_given_units(error, by_name) from None
            raise

    checked.__module__ = __name__  # where pickle finds it
    return checked


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
