"""Contacts of a motion under the names of dataset variables, read from the log of a march and converted back."""

from __future__ import annotations

import numpy as np

from vibropipe.march.log import COUNTS, GRAZINGS, IMPACTS, RESTS, Log, Samples
from vibropipe.march.piece_log import AT, CAUSE, SLIP, STICK, TURN, PieceLog
from vibropipe.march.state import State
from vibropipe.physics.exciter import Exciter, Parameters
from vibropipe.physics.housing import velocity_of
from vibropipe.words.vocabulary import OF_CONTACT

# Columns of impacts, rests and grazings by variable, each in order of time.
Contacts = dict[str, np.ndarray]
# Columns of a log, by the index of their number of entries in `Log.counts`.
COLUMNS = {
    IMPACTS: ("position", "velocity", "impulse", "support"),
    RESTS: ("rest_start", "rest_end", "rest_support"),
    GRAZINGS: ("grazing", "grazing_support"),
}


def drain_log(log: Log) -> dict[str, np.ndarray]:
    """Return a copy of the entries of a log, and empty the log."""
    columns = {
        name: getattr(log, name)[: int(log.counts[kind])].copy()
        for kind, names in COLUMNS.items()
        for name in names
    }
    log.counts[list(COLUMNS)] = 0
    return columns if log.pieces is None else columns | drain_pieces(log.pieces)


def drain_pieces(pieces: PieceLog) -> dict[str, np.ndarray]:
    """Return a copy of what a motion shows of its pieces, and empty their log."""
    n, leaves = (int(count) for count in pieces.counts)
    at, cause = pieces.values[:n, AT], pieces.codes[:n, CAUSE]
    columns = {
        "leaves": pieces.leaves[:leaves].copy(),
        "turn": at[(cause == TURN) | (cause == STICK)],
        "stick": at[cause == STICK],
        "slip": at[cause == SLIP],
    }
    if pieces.housing is not None:
        columns |= {"housing_at": at.copy(), "housing_way": pieces.housing.way[:n].copy()}
    pieces.counts[:] = 0
    return columns


def contacts_of(columns: dict[str, np.ndarray], period: float) -> Contacts:
    """Convert columns of a log to contacts, with times in tau; `period` is the forcing period."""
    is_impact = columns["support"] > 0
    before = columns["velocity"][is_impact]
    after = before + columns["impulse"][is_impact]
    return {
        "impact_tau": columns["position"][is_impact] * period,
        "impact_support": columns["support"][is_impact],
        "impact_velocity": before,
        "impact_velocity_after": after,
        "rest_start": columns["rest_start"] * period,
        "rest_end": columns["rest_end"] * period,
        "rest_support": columns["rest_support"].astype(np.int8),
        "grazing_tau": columns["grazing"] * period,
        "grazing_support": columns["grazing_support"],
    }


def contacts_of_pieces(columns: dict[str, np.ndarray], exciter: Exciter, period: float) -> Contacts:
    """Convert columns of a motion with soft supports or friction: `contacts_of`, and what these add to them.

    period : what the log counts times in. A contact that lasts beyond the end has no velocity after it, duration,
    force and depth yet: they are NaN.
    """
    contacts = contacts_of(columns, period)
    stiffness = np.array([0.0, exciter.k1, exciter.k2])
    if stiffness.any():
        soft = np.flatnonzero(stiffness[contacts["impact_support"]] > 0.0)
        ended = np.full((soft.size, 4), np.nan)
        ended[: len(columns["leaves"])] = columns["leaves"]
        contacts["impact_velocity_after"][soft] = ended[:, 0]
        for column, name in enumerate(OF_CONTACT, start=1):
            contacts[name] = np.full(contacts["impact_tau"].size, np.nan)
            contacts[name][soft] = ended[:, column]
    if exciter.friction > 0.0:
        contacts["turn_tau"] = columns["turn"] * period
        contacts["stick_start"] = columns["stick"] * period
        contacts["stick_end"] = np.full(columns["stick"].size, np.inf)
        contacts["stick_end"][: columns["slip"].size] = columns["slip"] * period
    if exciter.mass_ratio > 0.0:
        contacts |= slips_of(columns["housing_at"] * period, columns["housing_way"])
    return contacts


def tail_speeds(contacts: Contacts) -> np.ndarray:
    """Return the speed after the last impact or grazing before each rest; 0 if there is none.

    The march completes the impacts of a chatter below that speed in one piece, its tail.
    """
    contact_tau = np.concatenate([contacts["impact_tau"], contacts["grazing_tau"]])
    speed = np.concatenate([contacts["impact_velocity_after"], 0.0 * contacts["grazing_tau"]])
    permutation = np.argsort(contact_tau, kind="stable")
    last = np.searchsorted(contact_tau[permutation], contacts["rest_start"], side="right") - 1
    return np.append(np.abs(speed[permutation]), 0.0)[last]


def log_of(exciter: Exciter, contacts: Contacts, stop: float) -> Log:
    """Convert contacts back to the log of a march, with the tail of each chatter before a rest, without grazings.

    contacts : columns of `simulate`
    stop : end of the motion in forcing periods; a rest without release lasts until then
    """
    speed, rest_support = tail_speeds(contacts), contacts["rest_support"].astype(np.int8)
    restitution = np.where(rest_support == 1, exciter.R1, exciter.R2)
    restitution = np.where(restitution < 1.0, restitution, 0.0)
    has_tail, away = speed > 0.0, np.where(rest_support == 1, -1.0, 1.0)
    tau = np.concatenate([contacts["impact_tau"], contacts["rest_start"][has_tail]])
    permutation = np.argsort(tau, kind="stable")
    before = np.append(contacts["impact_velocity"], np.zeros(has_tail.sum()))
    impulse = np.concatenate(
        [
            contacts["impact_velocity_after"] - contacts["impact_velocity"],
            (away * speed * (1.0 + restitution) / (1.0 - restitution))[has_tail],
        ]
    )
    support = np.concatenate([contacts["impact_support"], -rest_support[has_tail]]).astype(np.int8)
    counts = np.zeros(COUNTS, np.int64)
    counts[IMPACTS], counts[RESTS] = tau.size, rest_support.size
    return Log(
        tau[permutation] / exciter.period,
        before[permutation],
        impulse[permutation],
        support[permutation],
        contacts["rest_start"] / exciter.period,
        np.minimum(contacts["rest_end"] / exciter.period, stop),
        rest_support,
        np.empty(0),
        np.empty(0, np.int8),
        counts,
    )


def slips_of(start: np.ndarray, way: np.ndarray) -> dict[str, np.ndarray]:
    """Return the slips of a housing, each one way, from the starts of pieces (n,) and its ways in them (n,)."""
    begins = np.flatnonzero(np.append(True, way[1:] != way[:-1])) if way.size else np.empty(0, int)
    ends = np.append(start[begins[1:]], np.inf)[: begins.size]
    slides = way[begins] != 0
    return {
        "housing_slip_start": start[begins][slides],
        "housing_slip_end": ends[slides],
        "housing_slip_direction": way[begins][slides],
    }


def housing_of(
    p: Parameters, state: State, v: float, samples: Samples | None, velocity: float
) -> np.ndarray | None:
    """Return what a motion from a velocity of its housing, which ends in a state, shows of that (`MotionResult`)."""
    if state.housing is None:
        return None
    # nan where the motion was stopped
    end = velocity_of(p, state.housing, v) + 0.0 * v, state.housing.displacement + 0.0 * v
    recorded = np.empty((0, 2))
    if samples is not None and samples.housing is not None:
        recorded = samples.housing
    if len(recorded) > 0:
        # As of the mass, the first sample is the start that was asked for.
        recorded[0] = velocity, 0.0
    return np.vstack([recorded, [end]])
