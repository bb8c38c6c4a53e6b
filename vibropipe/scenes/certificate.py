"""The proof of an orbit in the dataset of its scene, under names with a prefix, and those of the rows of a sweep."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import xarray as xr

from vibropipe.physics.exciter import ParameterError
from vibropipe.solve.in_si import ROWS_WITHIN
from vibropipe.solve.physical import stored
from vibropipe.words.proofs import PREFIX, REFUSED
from vibropipe.words.vocabulary import of_proof

if TYPE_CHECKING:
    from vibropipe.physics.exciter import Exciter
    from vibropipe.scenes.keys.proofs import Prove

# Attributes: what was found, the events of the law, and by which arithmetic.
STATEMENT, EVENTS, METHOD = (f"{PREFIX}{name}" for name in ("statement", "events", "method"))
# Stretches of the tube that is drawn; parts of a box that are examined at most, some 10 s, and of that of a row.
STRETCHES, PARTS, ROW_PARTS = 256, 1000, 200
# Cells of starts that are examined about a motion, some 5 s for each of both knocks.
CELLS = 1000


def with_certificate(dataset: xr.Dataset, scene: Any, exciter: Exciter) -> xr.Dataset:
    """Add the proof of the steady state of an exciter to the stored dataset of a scene that asks for it.

    The exciter has no units. What cannot be proved is said in the dataset.
    """
    from vibropipe.proof.face import prove
    from vibropipe.solve.rows.steady import steady_state

    orbit = steady_state(exciter, x0=scene.start.x0, v0=scene.start.v0, outputs=("impacts",))
    try:
        proof = prove(orbit, scene.prove.limits() or None, parts=PARTS, stretches=STRETCHES)
    except (ParameterError, ModuleNotFoundError) as error:
        return dataset.assign_attrs({REFUSED: f"{error}"})
    attrs = {name: proof.attrs[name.removeprefix(PREFIX)] for name in (STATEMENT, EVENTS, METHOD)}
    proof = stored(proof, scene.mass_and_stiffness).drop_vars(["m", "C"], errors="ignore")
    names = {str(name): of_proof(str(name)) for name in (*proof.variables, *proof.dims)}
    renamed = proof.rename({old: new for old, new in names.items() if old != new})
    return dataset.merge(renamed, compat="no_conflicts", join="exact").assign_attrs(attrs)


def proof_of(dataset: xr.Dataset) -> xr.Dataset | None:
    """Return the proof in the dataset of a scene under its own names, as of `prove`; None if there is none."""
    if STATEMENT not in dataset.attrs:
        return None
    kept = [str(name) for name in dataset.variables if str(name).startswith(PREFIX)]
    others = [name for name in dataset.coords if name not in (*kept, "support")]
    proof = dataset[kept].drop_vars(others, errors="ignore")
    names = [name for name in (*kept, *map(str, proof.dims)) if name.startswith(PREFIX)]
    return proof.rename({name: name.removeprefix(PREFIX) for name in names})


def with_row_proofs(rows: xr.Dataset, prove: Prove) -> xr.Dataset:
    """Add to rows, without units, whether their orbits are proved; where that cannot be tried, why they are not."""
    try:
        from vibropipe.proof.rows import prove_rows

        limits = prove.limits()
        proof = prove_rows(rows, None, limits or None, ROW_PARTS)
    except (ParameterError, ModuleNotFoundError) as error:
        return rows.assign_attrs({REFUSED: f"{error}"})
    proved = rows.assign({str(name): values for name, values in proof.data_vars.items()})
    within = "; ".join(f"{name} +- {most!r}" for name, most in limits.items())
    return proved.assign_attrs({ROWS_WITHIN: within}) if within else proved


def with_knock_proofs(attractors: xr.Dataset) -> xr.Dataset:
    """Add to attractors, without units, what is proved of their knocks; where that cannot be tried, why it is not."""
    try:
        from vibropipe.proof.knock import with_proved_knocks
    except ModuleNotFoundError as error:
        return attractors.assign_attrs({REFUSED: f"{error}"})
    return with_proved_knocks(attractors, CELLS)
