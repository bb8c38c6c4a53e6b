"""Summary of a dataset in plain text."""

from __future__ import annotations

import json
import re
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.words.vocabulary import quantity
from vibropipe.words.wording import aligned

if TYPE_CHECKING:
    import xarray as xr

LETTERS = {
    "alpha": "α", "beta": "β", "delta": "δ", "Delta": "Δ", "varepsilon": "ε", "mu": "μ", "nu": "ν", "pi": "π",
    "tau": "τ", "kappa": "κ", "lambda": "λ", "varphi": "φ", "psi": "ψ", "omega": "ω", "max": "max ",
    "det": "det", "partial": "∂", "Sigma": "Σ", "chi": "χ", "eta": "η", "gamma": "γ", "sum": "Σ",
}  # fmt: skip
ACCENTS = {"ddot": "\u0308", "dot": "\u0307", "bar": "\u0304"}
# characters shown of a text of several lines
MAX_TEXT = 60


def summary(dataset: xr.Dataset) -> str:
    """Return dimensions, quantities with symbol and range, numbers of regimes and statuses, and provenance as text."""
    parts = [str(dataset.attrs.get("title", "")), _sizes(dataset), _quantities(dataset)]
    parts += [_counts(dataset, name) for name in ("regime", "status") if name in dataset]
    parts.append(_attributes(dataset))
    return "\n\n".join(part for part in parts if part) + "\n"


def plain_symbol(symbol: str) -> str:
    """Return a symbol in matplotlib's mathtext as plain text with Unicode letters and accents."""
    text = symbol.replace("$", "")
    # letters first, since an accent may apply to one; then accents, the innermost one first
    text = re.sub(r"\\(" + "|".join(LETTERS) + r")(?![A-Za-z]) ?", lambda m: LETTERS[m[1]], text)
    accent = re.compile(r"\\(" + "|".join(ACCENTS) + r")\{([^{}]*)\}")
    while accent.search(text):
        text = accent.sub(lambda m: m[2] + ACCENTS[m[1]], text)
    return re.sub(r"[{}]", "", text)


def _sizes(dataset: xr.Dataset) -> str:
    if not dataset.sizes:
        return ""
    lines = [f"  {name}: {size}" for name, size in dataset.sizes.items()]
    return "\n".join(["Dimensions", *lines])


def _quantities(dataset: xr.Dataset) -> str:
    rows = []
    for name in [*dataset.coords, *dataset.data_vars]:
        variable, attrs = dataset[name], dataset[name].attrs
        dims = f"({', '.join(map(str, variable.dims))})" if variable.dims else ""
        symbol = plain_symbol(str(attrs.get("symbol", "")))
        unit = "" if attrs.get("units", "1") == "1" else f" ({attrs['units']})"
        long_name = f"{attrs.get('long_name', '')}{unit}"
        rows.append((f"{name}{dims}", symbol, _range(variable), long_name))
    return "\n".join(["Quantities", *(f"  {line}" for line in aligned(rows))]) if rows else ""


def _range(variable: xr.DataArray) -> str:
    """Return the value of a scalar, or the smallest and the largest finite value."""
    values = np.asarray(variable.values)
    if values.dtype.kind == "c":
        values = np.abs(values)
    if not values.size:
        return "none"
    if values.dtype.kind not in "iufb":
        return "" if values.ndim else str(values)
    if not values.ndim:
        return f"{values:.6g}"
    finite = values[np.isfinite(values)]
    return f"{finite.min():.6g} ... {finite.max():.6g}" if finite.size else "none finite"


def _counts(dataset: xr.Dataset, name: str) -> str:
    values = np.asarray(dataset[name].values).reshape(-1)
    flag_names = {value: flag for flag, value in (quantity(name).flags or {}).items()}
    lines = [
        f"  {flag_names.get(int(value), value)}: {count} ({count / len(values):.1%})"
        for value, count in zip(*np.unique(values, return_counts=True), strict=True)
    ]
    return "\n".join([name.capitalize(), *lines]) if lines else ""


def _attributes(dataset: xr.Dataset) -> str:
    lines = [f"  {name}: {_text(value)}" for name, value in dataset.attrs.items()]
    return "\n".join(["Origin", *lines]) if lines else ""


def _text(value: Any) -> str:
    """Return an attribute on one line; of several lines, their number and the start of the first."""
    text = str(value)
    if text.startswith("{"):
        try:
            return ", ".join(f"{key} {item}" for key, item in json.loads(text).items())
        except ValueError:
            pass
    lines = text.splitlines()
    return text if len(lines) <= 1 else f"{len(lines)} lines: {lines[0][:MAX_TEXT]} ..."
