"""Contacts of a motion under the names of dataset variables, read from the log of a march and converted back."""

from __future__ import annotations

import numpy as np

from vibropipe.march.log import COUNTS, GRAZINGS, IMPACTS, RESTS, Log
from vibropipe.physics.exciter import Exciter

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
    return columns


def contacts_of(columns: dict[str, np.ndarray], period: float) -> Contacts:
    """Convert columns of a log to contacts, with times in tau; `period` is the forcing period."""
    is_impact = columns["support"] > 0
    before = columns["velocity"][is_impact]
    return {
        "impact_tau": columns["position"][is_impact] * period,
        "impact_support": columns["support"][is_impact],
        "impact_velocity": before,
        "impact_velocity_after": before + columns["impulse"][is_impact],
        "rest_start": columns["rest_start"] * period,
        "rest_end": columns["rest_end"] * period,
        "rest_support": columns["rest_support"].astype(np.int8),
        "grazing_tau": columns["grazing"] * period,
        "grazing_support": columns["grazing_support"],
    }


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
    """Convert contacts back to the log of a march, with the tail of each chatter before a rest.

    Parameters
    ----------
    exciter : Exciter
    contacts : Contacts
        Columns of `simulate`.
    stop : float
        End of the motion in forcing periods; a rest without release lasts until then.

    Returns
    -------
    Log
        Impacts, tails and rests; without grazings.
    """
    speed, rest_support = tail_speeds(contacts), contacts["rest_support"].astype(np.int8)
    restitution = np.where(rest_support == 1, exciter.R1, exciter.R2)
    restitution = np.where(restitution < 1.0, restitution, 0.0)
    has_tail = speed > 0.0
    tau = np.concatenate([contacts["impact_tau"], contacts["rest_start"][has_tail]])
    permutation = np.argsort(tau, kind="stable")
    before = np.append(contacts["impact_velocity"], np.zeros(has_tail.sum()))
    impulse = np.concatenate(
        [
            contacts["impact_velocity_after"] - contacts["impact_velocity"],
            (speed * (1.0 + restitution) / (1.0 - restitution))[has_tail],
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
