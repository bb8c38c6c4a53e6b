"""The certificate of an orbit in a report: the sentence, the tube of all motions, bounds, and what is not claimed."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibropipe.figures.canvas import BODY, axes, new_canvas, support_bands
from vibropipe.figures.claims import at_least, outwards
from vibropipe.figures.motion_words import motion_words, regime_by
from vibropipe.figures.palette import EXACT, INK, SUPPORT_MARKERS, SUPPORT_TEXT
from vibropipe.figures.text import (
    axis_label,
    format_number,
    in_brackets,
    plain_symbol_of,
    with_units,
)
from vibropipe.report.parts import Answer, Table
from vibropipe.scenes.certificate import EVENTS, METHOD, proof_of
from vibropipe.scenes.keys.proofs import CERTIFICATE
from vibropipe.scenes.kind import Picture
from vibropipe.solve.in_si import ROWS_WITHIN
from vibropipe.solve.shown_units import shown_factor
from vibropipe.words.proofs import REFUSED, Proved, ProvedStable, Why, tally
from vibropipe.words.wording import capitalised, count, series, share

LEFT, BOTTOM, WIDTH, HIGH = 1.6, 1.1, 14.1, 4.6  # cm, of the tube
TEXT_HIGH = 1.0  # cm, of a figure without a tube
ROOM = 0.12  # of the distance between the supports, beyond each of them
NOT_CLAIMED = (
    "Not claimed: that no other motion coexists, that the motion settles on this one from a given start, and that the "
    "equations describe the machine."
)
# Quantities of the table, with what they are called.
BOUNDED = (
    ("displacement_mean", "mean displacement"),
    ("spectral_radius", "largest multiplier, modulus"),
    ("impact_velocity", "velocity before impact {}"),
    ("displacement_amplitude", "amplitude of harmonic {}"),
    ("impact_phase", "phase of impact {}"),
)


def is_of_impacts(proof: xr.Dataset) -> bool:
    """Return whether a proof is of a motion between rigid supports without friction."""
    return all(
        each.startswith("impact") for each in str(proof.attrs.get(EVENTS, "impact")).split(", ")
    )


def is_proved(proof: xr.Dataset | None) -> bool:
    """Return whether all was proved."""
    return proof is not None and int(proof["proved"]) == Proved.PROVED


def law_text(proof: xr.Dataset) -> str:
    """Write the law of an orbit in words, in brackets."""
    impacts = proof["impacts_per_orbit"].values.tolist()
    multiple = int(proof["period_multiple"])
    return f"({motion_words(regime_by(impacts), multiple, impacts, (0, 0))})"


def limits_text(proof: xr.Dataset) -> str:
    """Write how far each parameter may be off, those alike once; empty for the exciter alone."""
    if "within" not in proof:
        return ""
    symbols: dict[str, list[str]] = {}
    for name, off in of_parameters(proof, "within").items():
        text = with_units(proof[name], format_number(off))
        symbols.setdefault(text, []).append(plain_symbol_of(proof[name]))
    return series(f"{', '.join(each)} ± {text}" for text, each in symbols.items())


def of_parameters(proof: xr.Dataset, variable: str) -> dict[str, float]:
    """Return a variable over parameters, each value in the unit in which that parameter is shown."""
    names, values = proof["parameter"].values.tolist(), proof[variable].values.tolist()
    return {
        name: value * shown_factor(str(proof[name].attrs["units"]))
        for name, value in zip(names, values, strict=True)
    }


def title_certificate(dataset: xr.Dataset) -> str:
    """Return the title: what is certain."""
    proof = proof_of(dataset)
    if proof is None:
        return "Nothing is proved"
    one, each, every = (
        f"{amount} exciter within the limits" if "within" in proof else "the exciter"
        for amount in ("an", "each", "every")
    )
    if int(proof["proved"]) == Proved.DISPROVED:
        return f"Disproved: {one} does not keep the orbit"
    if not is_proved(proof):
        return f"Not decided: whether {each} keeps the orbit"
    kept = "keeps" if int(proof["proved_stable"]) == ProvedStable.STABLE else "has, unstable,"
    return f"Proved: {every} {kept} the orbit"


def certificate_answer(dataset: xr.Dataset) -> Answer | None:
    """Return the certificate as an answer; None if none was asked for."""
    proof = proof_of(dataset)
    if proof is None:
        reason = dataset.attrs.get(REFUSED)
        return Answer("Nothing is proved.", f"{reason}." if reason else "") if reason else None
    lead, limits = f"{title_certificate(dataset)}.", limits_text(proof)
    stated = f"The limits are {limits}; all else is exact." if limits else ""
    if not is_proved(proof):
        return Answer(lead, " ".join(filter(None, [stated, why_text(proof)])))
    struck = series([text for text in (struck_text(proof, n) for n in (1, 2)) if text])
    return Answer(lead, stated or f"It strikes {struck}.")


def struck_text(proof: xr.Dataset, support: int) -> str:
    """Write how hard a support is struck; empty if it is not."""
    low, high = speeds(proof, support)
    if not low.size:
        return ""
    first, last = outwards(float(low.min()), float(high.max()))
    unit = proof["impact_velocity_low"]
    return f"support {support} with {first} to {with_units(unit, last)}"


def speeds(proof: xr.Dataset, support: int) -> tuple[np.ndarray, np.ndarray]:
    """Return bounds of the speeds at which a support is struck, for each impact."""
    at = proof["impact_support"].values == support
    low, high = (proof[f"impact_velocity_{end}"].values[at] for end in ("low", "high"))
    return (low, high) if support == 1 else (-high, -low)


def bounds_of(proof: xr.Dataset, variable: str, label: int = 0) -> tuple[float, float] | None:
    """Return the bounds of a quantity of steady states, of one support or harmonic; None if the proof has none."""
    if variable == "impact_velocity_max":
        low, high = speeds(proof, label)
        return (float(low.max()), float(high.max())) if low.size else None
    ends = [f"{variable}_{end}" for end in ("low", "high")]
    if ends[0] not in proof or "impact" in proof[ends[0]].dims:
        return None
    low, high = (np.ravel(proof[end].values)[max(label - 1, 0)] for end in ends)
    return float(low), float(high)


def why_text(proof: xr.Dataset) -> str:
    """Write what is not proved, or where it is disproved."""
    why = Why(int(proof["why"]))
    if why is Why.PARTS:
        boxes = (
            f"{count(int(proof['parts']), 'box', 'boxes')} were examined, as many as are allowed"
        )
        return f"{boxes}: narrower tolerances need fewer."
    if int(proof["proved"]) != Proved.DISPROVED:
        return f"Not proved {why.reason}."
    what = {
        Why.MOTION: "The mass leaves the supports"
        if is_of_impacts(proof)
        else "The mass leaves its law",
        Why.STABILITY: "The orbit has the other stability",
        Why.PERIOD: "The orbit has a shorter period",
    }[why]
    if "counterexample" not in proof:
        return f"{what}."
    places = series(
        f"{plain_symbol_of(proof[name])} = {with_units(proof[name], format_number(value, 6))}"
        for name, value in of_parameters(proof, "counterexample").items()
    )
    return f"{what} at {places}."


def draw_certificate(dataset: xr.Dataset) -> Figure:
    """Draw the tube of all motions; without a proof why there is none."""
    proof = proof_of(dataset)
    if proof is None or not is_proved(proof):
        figure = new_canvas(TEXT_HIGH)
        told = certificate_answer(dataset)
        text = told.rest if told else ""
        figure.text(0.0, 0.5, text, va="center", fontsize=BODY, wrap=True)
        return figure
    figure = new_canvas(BOTTOM + HIGH + 0.2)
    draw_tube(axes(figure, LEFT, BOTTOM, WIDTH, HIGH), proof)
    return figure


def draw_tube(ax: Axes, proof: xr.Dataset) -> None:
    """Draw between which displacements all motions stay, and where and when they strike."""
    m = int(proof["period_multiple"])
    edges = m * np.append(proof["phase"].values, 1.0)
    low, high = (proof[f"displacement_{end}"].values for end in ("low", "high"))
    half, delta = (float(proof[name]) for name in ("l", "delta"))
    limits = of_parameters(proof, "within") if "within" in proof else {}
    off = limits.get("l", 0.0) + limits.get("delta", 0.0)
    ax.stairs(high, edges, baseline=low, fill=True, color=EXACT, linewidth=0, zorder=2)
    least, most = delta - half, delta + half
    room = ROOM * (most - least)
    # a soft support yields
    deepest, highest = min(least - off, float(low.min())), max(most + off, float(high.max()))
    ax.set(xlim=(0, m), ylim=(deepest - room, highest + room))
    support_bands(ax, least - off, most + off)
    for wall in (least, most):
        ax.axhline(wall, color=INK, linewidth=0.8, zorder=1)
    for n, support in enumerate(proof["impact_support"].values.tolist()):
        ends = [
            float(proof[f"impact_phase_{end}"].values[n]) + int(proof["impact_period"].values[n])
            for end in ("low", "high")
        ]
        wall = most if support == 1 else least
        ax.plot(
            [(sum(ends) / 2) % m], [wall], SUPPORT_MARKERS[support],
            color=SUPPORT_TEXT[support], markersize=6, clip_on=False, zorder=4,
        )  # fmt: skip
    ax.set_xlabel("forcing periods")
    ax.set_ylabel(
        axis_label(proof["displacement_low"]).replace("lower bound of ", "").replace(", proved", "")
    )


def describe_certificate(dataset: xr.Dataset) -> str:
    """Return the caption: for which exciters, what was shown, and what is not claimed."""
    proof = proof_of(dataset)
    if proof is None or not is_proved(proof):
        return NOT_CLAIMED
    limits = limits_text(proof)
    who, kept = (
        "the exciter with exactly its parameters",
        "no flight reaches a support before its end",
    )
    if limits:
        who = f"all exciters with {limits}, at once, all else exact"
    if not is_of_impacts(proof):
        kept = f"it is a motion of just these events ({dataset.attrs[EVENTS]})"
    return (
        f"Bounds over {who}: for each, the equations have exactly one orbit {law_text(proof)} nearby, {kept}, its "
        "period is no shorter, and its stability is the same. Computed in balls that contain all roundings. Steps: the "
        f"bounds between which every orbit is proved to lie; triangles: impacts. {NOT_CLAIMED}"
    )


def bounds_table(scene: str, dataset: xr.Dataset) -> Table | None:
    """Return the bounds of a proof in numbers; None without one."""
    proof = proof_of(dataset)
    if proof is None or not is_proved(proof):
        return None
    rows = []
    for name, label in BOUNDED:
        low, high = (proof[f"{name}_{end}"] for end in ("low", "high"))
        lows, highs = (np.ravel(each.values) for each in (low, high))
        for n, (a, b) in enumerate(zip(lows, highs, strict=True)):
            first, last = outwards(float(a), float(b))
            text = label.format(n + 1)
            if name == "impact_velocity":
                text += f", support {int(proof['impact_support'].values[n])}"
            rows.append([in_brackets(text, low), first, last])
    radius, parts = at_least(float(proof["uniqueness_radius"]), 2), int(proof["parts"])
    within = f"impacts within {radius} forcing periods and {radius} of the largest velocity"
    if not is_of_impacts(proof):
        within = f"events within {radius} forcing periods, {radius} of the largest velocity and {radius} of l"
    note = (
        f"Rounded outwards. No other orbit of this law has all its {within} of these. Examined in "
        f"{count(parts, 'box', 'boxes')} by {dataset.attrs[METHOD]}; `docs/proof.md` tells how."
    )
    return Table(
        ["", "at least", "at most"],
        rows,
        note,
        title="Proved bounds",
        scene=scene,
        picture=CERTIFICATE,
    )


CERTIFICATE_PICTURE = Picture(
    CERTIFICATE,
    draw_certificate,
    describe_certificate,
    lambda dataset: REFUSED in dataset.attrs or proof_of(dataset) is not None,
    titled=title_certificate,
    heading="What is certain?",
)


def proof_answer(dataset: xr.Dataset) -> Answer | None:
    """Return how many orbits are proved; none of a sweep that does not ask for it."""
    if REFUSED in dataset.attrs:
        return Answer("No orbit is proved.", f"Reason: {dataset.attrs[REFUSED]}.")
    if "proved" not in dataset:
        return None
    found = tally(dataset, dataset["proved"].values, dataset["why"].values)
    parts = []
    if found.disproved:
        parts.append(f"{found.disproved:,} {'is' if found.disproved == 1 else 'are'} disproved")
    if found.not_tried:
        which = "without impacts, with rests or without an orbit"
        parts.append(f"{count(found.not_tried, 'row')} {which}, not tried")
    rest = f"{series(parts)}." if parts else ""
    within = rows_within_text(dataset)
    if not found.tried:
        return Answer("No row was tried.", rest)
    where = f", of all exciters within {within}" if within else ""
    proved = capitalised(share(found.proved, found.tried, "orbit"))
    return Answer(f"{proved} proved{where}.", rest)


def rows_within_text(dataset: xr.Dataset) -> str:
    """Write how far the parameters of each row may be off; empty if each is proved for its own exciter alone."""
    texts = []
    for part in filter(None, str(dataset.attrs.get(ROWS_WITHIN, "")).split("; ")):
        name, _, off = part.partition(" +- ")
        of = dataset[name]
        value = float(off) * shown_factor(str(of.attrs["units"]))
        texts.append(f"{plain_symbol_of(of)} ± {with_units(of, format_number(value))}")
    return series(texts)
