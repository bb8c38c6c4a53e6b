"""The motion at a point as code and as a study, to be copied."""

from __future__ import annotations

import json
import math

import xarray as xr

from vibropipe.physics.si import eigenfrequency
from vibropipe.solve.physical import is_physical
from vibropipe.solve.rebuild import exciter_of, mass_and_stiffness, section_of
from vibropipe.solve.shown_units import in_si
from vibropipe.words.parameters import PARAMETERS, PHYSICAL
from vibropipe.words.units import plain_units

PERIODS = 4


def _stated(row: xr.Dataset) -> dict[str, float]:
    """Return the parameters of a row that differ from the defaults, in its units."""
    names = dict.fromkeys(name for name in (*PHYSICAL, *PARAMETERS) if name in row.variables)
    is_si = is_physical(row)
    return {
        name: value
        for name, value in ((name, float(row[name])) for name in names)
        if (is_si and name in PHYSICAL) or PARAMETERS[name].default != value
    }


def _start(row: xr.Dataset) -> tuple[float, float]:
    """Return the stored section in the units of the row, 0 where there is none."""
    x, v = (float(row[f"{name}_strobe"]) for name in ("displacement", "velocity"))
    return (x, v) if math.isfinite(x) and math.isfinite(v) else (0.0, 0.0)


def as_python(row: xr.Dataset) -> str:
    """Return code that finds the steady state of a row again, from its section."""
    given = ", ".join(f"{name}={float(in_si(row[name]))!r}" for name in _stated(row))
    call = "Exciter.from_physical" if is_physical(row) else "Exciter"
    exciter = exciter_of(row)
    x, v = section_of(row, exciter)
    if not math.isfinite(x + v):
        x, v = exciter.check_start(None, 0.0)
    si = mass_and_stiffness(row)
    lines = [
        "import vibropipe as vp",
        "",
        f"exciter = vp.{call}({given})",
        f"row = vp.steady_state(exciter, x0={x!r}, v0={v!r})",
        f"motion = vp.simulate(exciter, tau_end={PERIODS} * exciter.period, x0={x!r}, v0={v!r})",
    ]
    if si is not None:
        lines.append(
            f"row, motion = (vp.to_physical(each, m={si['m']!r}, C={si['C']!r}) for each in (row, motion))"
        )
    return "\n".join(lines) + "\n"


def as_yaml(row: xr.Dataset, title: str) -> str:
    """Return a study of the motion of a row, from its section on."""
    is_si, (x, v) = is_physical(row), _start(row)

    def written(name: str, value: float, of: str = "") -> str:
        units = str(row[of or name].attrs.get("units", "1"))
        unit = f" {plain_units(units)}" if is_si and units != "1" else ""
        return f"{name}: {value!r}{unit}"

    values = _stated(row)
    own = [written(name, value) for name, value in values.items() if is_si and name in PHYSICAL]
    others = [
        written(name, value) for name, value in values.items() if not (is_si and name in PHYSICAL)
    ]
    start = f"{{{written('x0', x, 'displacement_strobe')}, {written('v0', v, 'velocity_strobe')}}}"
    length = PERIODS * exciter_of(row).period
    lines = [f"title: {json.dumps(title, ensure_ascii=False)}"]
    lines += [f"physical: {{{', '.join(own)}}}"] if own else []
    lines += [f"exciter: {{{', '.join(others)}}}"] if others else []
    lines += ["scenes:", "  point:", "    kind: motion", f"    start: {start}"]
    lines += [
        f"    tau_end: {_end(length, row)}",
        "    outputs: [motion, impacts, harmonics, stability]",
    ]
    return "\n".join(lines) + "\n"


def _end(length: float, row: xr.Dataset) -> str:
    """Write the end of a motion of a length in tau, in the units of a row."""
    si = mass_and_stiffness(row)
    if si is None:
        return repr(length)
    return f"{length / eigenfrequency(**si)!r} s"
