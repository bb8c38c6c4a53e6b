"""Orbits that repeat or mirror themselves half an orbit later: their halves, and the doubled sequence."""

from __future__ import annotations

import numpy as np

from vibropipe.orbits.law.law import Law

# Weighted difference of the halves of an orbit at which they count as equal. Where a branch of doubled orbits turns at
# its parent the difference goes with the root of the error of the parameter.
EQUAL_HALVES = 1e-4
# Weighted difference of the parts of an orbit that are the same.
SAME_PARTS = 1e-5


def _halves(sequence: Law, u: np.ndarray, mirrored: bool) -> tuple[np.ndarray, np.ndarray] | None:
    """Return both halves of times and states, the second moved (and mirrored) onto the first; None without."""
    n = len(sequence.supports)
    half = n // 2
    if n == 0 or n % 2 or sequence.mirrored:
        return None
    first, second = sequence.supports[:half], sequence.supports[half:]
    if not np.array_equal(second, sequence.image(first) if mirrored else first):
        return None
    times, states = _parts(sequence, u)
    sign = -1.0 if mirrored else 1.0
    later = np.concatenate([times[half:] - 0.5 * sequence.m, sign * states[:, half:].ravel()])
    return np.concatenate([times[:half], states[:, :half].ravel()]), later


def _parts(sequence: Law, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the times of n events, and what is free of their states (w - 1, n), of unknowns (w n + 1,) or more."""
    n, width = len(sequence.supports), sequence.width
    return u[:n], u[n : width * n].reshape(width - 1, n)


def halves_difference(
    sequence: Law, u: np.ndarray, weights: np.ndarray, kind: str
) -> np.ndarray | None:
    """Return the weighted difference of the halves of an orbit; None if their impact sequences differ.

    u, weights : (w n + 1,), times, what is free of the states, and the parameter; weights of the unknowns
    kind : "flip": the second half repeats the first; "pitchfork": it is its mirror image
    """
    n = len(sequence.supports)
    halves = _halves(sequence, u, kind == "pitchfork")
    if halves is None:
        return None
    times, states = _parts(sequence, weights)
    of_first = np.concatenate([times[: n // 2], states[:, : n // 2].ravel()])
    difference: np.ndarray = (halves[0] - halves[1]) * of_first
    return difference


def halves_agree(
    sequence: Law,
    u: np.ndarray,
    weights: np.ndarray,
    symmetric: bool,
    tolerance: float = EQUAL_HALVES,
) -> str:
    """Return how the halves of an orbit agree: "flip" if it repeats, "pitchfork" if it mirrors itself, "" if not.

    sequence, u, weights : as for `halves_difference`
    symmetric : whether the exciter is its own mirror image; an orbit of another may nearly mirror itself
    tolerance : largest weighted difference of the halves
    """
    # The force repeats after whole periods and mirrors itself after odd halves.
    kind = "pitchfork" if sequence.m % 2 else "flip"
    if kind == "pitchfork" and not symmetric:
        return ""
    difference = halves_difference(sequence, u, weights, kind)
    return kind if difference is not None and np.abs(difference).max() < tolerance else ""


def halved(sequence: Law, u: np.ndarray, kind: str) -> tuple[Law, np.ndarray]:
    """Return the sequence of half an orbit whose halves agree, and the mean of both halves with the parameter.

    sequence, u : as for `halves_agree`
    kind : what that returned: "flip" or "pitchfork"
    """
    halves = _halves(sequence, u, kind == "pitchfork")
    assert halves is not None
    mean = np.append(0.5 * (halves[0] + halves[1]), u[-1])
    supports = sequence.supports[: len(sequence.supports) // 2].copy()
    if kind == "pitchfork":
        return sequence.like(sequence.m, 1, supports), mean
    return sequence.like(sequence.m // 2, 0, supports), mean


def doubled(sequence: Law, u: np.ndarray, by: np.ndarray) -> tuple[Law, np.ndarray, np.ndarray]:
    """Return the sequence of two turns of an orbit, its unknowns, and a perturbation that changes sign between them.

    sequence, u : as for `halves_agree`. The second turn of a mirrored sequence is the mirror image of the first
    by : (w n + 1,), perturbation over the first turn

    Unknowns and perturbation are (2 w n + 1,).
    """
    sign = -1.0 if sequence.mirrored else 1.0
    first, (times, states), (late, change) = (
        sequence.supports,
        _parts(sequence, u),
        _parts(sequence, by),
    )
    second = sequence.image(first) if sequence.mirrored else first
    m = sequence.m if sequence.mirrored else 2 * sequence.m
    later = [times, times + sequence.span, np.hstack([states, sign * states]).ravel(), u[-1:]]
    turned = [late, -late, np.hstack([change, -sign * change]).ravel(), np.zeros(1)]
    whole = sequence.like(m, 0, np.concatenate([first, second]))
    return whole, np.concatenate(later), np.concatenate(turned)


def whole_orbit(sequence: Law, u: np.ndarray) -> tuple[Law, np.ndarray]:
    """Return the sequence of the whole orbit and its unknowns: both halves if it is mirrored."""
    if not sequence.mirrored:
        return sequence, u
    whole, unknowns, _change = doubled(sequence, u, np.zeros(u.size))
    return whole, unknowns


def primitive(
    sequence: Law, u: np.ndarray, weights: np.ndarray, symmetric: bool
) -> tuple[Law, np.ndarray]:
    """Return an orbit in its least number of periods, by half of its impacts if it is its own mirror image.

    sequence, u, weights : as for `halves_difference`
    symmetric : whether the exciter is its own mirror image
    """
    n = len(sequence.supports)
    for parts in range(n, 1, -1):
        if repeats(sequence, u, weights, parts):
            size, last = n // parts, sequence.width * n
            kept = np.append(np.arange(last).reshape(-1, n)[:, :size].ravel(), last)
            sequence = sequence.like(
                sequence.m // parts, sequence.mirrored, sequence.supports[:size]
            )
            u, weights = u[kept], weights[kept]
            break
    if halves_agree(sequence, u, weights, symmetric, SAME_PARTS) == "pitchfork":
        return halved(sequence, u, "pitchfork")
    return sequence, u


def repeats(sequence: Law, u: np.ndarray, weights: np.ndarray, parts: int) -> bool:
    """Return whether an orbit consists of a number of equal parts.

    sequence, u, weights : as for `halves_difference`
    parts : an odd number if the sequence is mirrored: its parts are mirror images in turn
    """
    n, m = len(sequence.supports), sequence.m
    if n % parts or m % parts or (sequence.mirrored and parts % 2 == 0):
        return False
    size, sign = n // parts, -1.0 if sequence.mirrored else 1.0
    supports, turned = sequence.supports, np.roll(sequence.supports, -size, axis=0)
    if sequence.mirrored:
        turned = sequence.image(turned)
        turned[n - size :] = supports[:size]
    if not np.array_equal(turned, supports):
        return False
    later = np.concatenate([u[size:n], u[:size] + sequence.span]) - sequence.span / parts
    # Of a mirrored sequence, what follows the last impact is the mirror image of the first.
    _times, states = _parts(sequence, u)
    turned_states = np.hstack([sign * states[:, size:], states[:, :size]])
    change = np.concatenate([later, turned_states.ravel(), u[-1:]]) - u
    return bool(np.abs(change * weights).max() < SAME_PARTS)
