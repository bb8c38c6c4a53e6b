"""Contacts of a motion by the names of variables: from the log that a march leaves, and back to one."""

from __future__ import annotations

import numpy as np

from vibropipe.march.log import COUNTS, GRAZINGS, IMPACTS, RESTS, Log
from vibropipe.physics.exciter import Exciter

# Impacts, rests and grazings, each in order of time.
Contacts = dict[str, np.ndarray]
# Columns of a log by the place of their number.
COLUMNS = {
    IMPACTS: ("position", "velocity", "impulse", "support"),
    RESTS: ("rest_start", "rest_end", "rest_support"),
    GRAZINGS: ("grazing", "grazing_support"),
}


def take(log: Log) -> dict[str, np.ndarray]:
    """Copy the entries of a log and empty it."""
    taken = {
        name: getattr(log, name)[: int(log.counts[kind])].copy()
        for kind, names in COLUMNS.items()
        for name in names
    }
    log.counts[list(COLUMNS)] = 0
    return taken


def contacts_of(columns: dict[str, np.ndarray], period: float) -> Contacts:
    """Columns of a log by the names of a dataset, in tau."""
    struck = columns["support"] > 0
    before = columns["velocity"][struck]
    return {
        "impact_tau": columns["position"][struck] * period,
        "impact_support": columns["support"][struck],
        "impact_velocity": before,
        "impact_velocity_after": before + columns["impulse"][struck],
        "rest_start": columns["rest_start"] * period,
        "rest_end": columns["rest_end"] * period,
        "rest_support": columns["rest_support"].astype(np.int8),
        "grazing_tau": columns["grazing"] * period,
        "grazing_support": columns["grazing_support"],
    }


def tail_speeds(contacts: Contacts) -> np.ndarray:
    """Speed with which the last impact made before each rest left the support; 0 where none led to it.

    The impacts of a chatter below that speed were completed in one piece.
    """
    touched = np.concatenate([contacts["impact_tau"], contacts["grazing_tau"]])
    speed = np.concatenate([contacts["impact_velocity_after"], 0.0 * contacts["grazing_tau"]])
    order = np.argsort(touched, kind="stable")
    last = np.searchsorted(touched[order], contacts["rest_start"], side="right") - 1
    return np.append(np.abs(speed[order]), 0.0)[last]


def log_of(exciter: Exciter, contacts: Contacts, stop: float) -> Log:
    """The log of kernels that these contacts were read from; a rest without end lasts until `stop`."""
    speed, side = tail_speeds(contacts), contacts["rest_support"].astype(np.int8)
    restitution = np.where(side == 1, exciter.R1, exciter.R2)
    restitution = np.where(restitution < 1.0, restitution, 0.0)
    tail = speed > 0.0
    tau = np.concatenate([contacts["impact_tau"], contacts["rest_start"][tail]])
    order = np.argsort(tau, kind="stable")
    before = np.append(contacts["impact_velocity"], np.zeros(tail.sum()))
    impulse = np.concatenate(
        [
            contacts["impact_velocity_after"] - contacts["impact_velocity"],
            (speed * (1.0 + restitution) / (1.0 - restitution))[tail],
        ]
    )
    support = np.concatenate([contacts["impact_support"], -side[tail]]).astype(np.int8)
    counts = np.zeros(COUNTS, np.int64)
    counts[IMPACTS], counts[RESTS] = tau.size, side.size
    return Log(
        tau[order] / exciter.period,
        before[order],
        impulse[order],
        support[order],
        contacts["rest_start"] / exciter.period,
        np.minimum(contacts["rest_end"] / exciter.period, stop),
        side,
        np.empty(0),
        np.empty(0, np.int8),
        counts,
    )
