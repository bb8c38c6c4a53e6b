"""Derivative of the return map where a housing may slide: a matrix of three rows, for (x, x', P).

P is the momentum of both bodies (`physics.housing`). Sliding neither depends on it nor changes its derivative: only the
instant at which the housing stops does.
"""

from __future__ import annotations

from typing import NamedTuple

from vibropipe.compiler import jit
from vibropipe.march.piece_log import (
    AT,
    BEGIN,
    BEYOND,
    CAUSE,
    CONTACT,
    ENTER,
    FORM,
    FREE,
    HELD,
    HOME,
    HOUSING_STOP,
    IMPACT,
    LEAVE,
    PIECES,
    REST_BEGINS,
    RESTING,
    SPAN,
    STICK,
    TURN,
    W_END,
    Y_END,
    W,
    Y,
)
from vibropipe.march.state import restitution_of
from vibropipe.orbits.piece_terms import terms_of
from vibropipe.physics.contact import frame_at
from vibropipe.physics.housing import STANDS, momentum_rate, momentum_share
from vibropipe.physics.load import force_at, force_value
from vibropipe.physics.saltation import eigenvalues_of
from vibropipe.physics.stiffness import piece_flow

# Steps of Newton's method for an eigenvalue.
MAX_NEWTON = 200


class Coupling(NamedTuple):
    """The third row and column of a derivative by (x, x', P); zero where no housing may slide."""

    j13: float
    j23: float
    j31: float
    j32: float
    j33: float


class Field(NamedTuple):
    """Rates of (y, w, P) in the frame of a support, at an instant of a piece."""

    y: float
    w: float
    p: float


@jit
def no_coupling() -> Coupling:
    """Return the coupling of a motion without a housing."""
    return Coupling(0.0, 0.0, 0.0, 0.0, 0.0)


@jit
def has_coupling(coupling) -> bool:
    """Return whether the third row or column of a derivative is not zero."""
    size = abs(coupling.j13) + abs(coupling.j23) + abs(coupling.j31) + abs(coupling.j32)
    return size + abs(coupling.j33) != 0.0


@jit
def coupling_of(pieces) -> Coupling:
    """Return the coupling of the last derivative along pieces, or of none: `jacobian_with_housing`."""
    if pieces is None:
        return no_coupling()
    return coupling_in(pieces.housing)


@jit
def coupling_in(log) -> Coupling:
    """Return `coupling_of`; log : `HousingLog` or None."""
    if log is None:
        return no_coupling()
    m = log.product
    return Coupling(m[0, 2], m[1, 2], m[2, 0], m[2, 1], m[2, 2])


@jit
def field_of(e, p, pieces, i, y, w, turn) -> Field:
    """Return the rates in piece i at (y, w) in its frame and a phase in turns."""
    home, way = pieces.codes[i, HOME], pieces.housing.way[i]
    rate = frame_at(e, p, home).sigma * momentum_rate(p, way)
    if pieces.codes[i, FORM] in (HELD, RESTING):
        return Field(0.0, 0.0, rate)
    terms, second = terms_of(e, p, pieces, i), e.second_harmonic
    acceleration = terms.load - terms.stiffness * y - terms.damping * w
    if e.forcing is not None:
        acceleration += terms.factor * force_value(force_at(p, terms.sigma, turn, second), second)
    return Field(w, acceleration, momentum_share(p) * acceleration if way == STANDS else rate)


@jit
def multiply(factor, matrix, room) -> None:
    """Replace a matrix by factor matrix; all (3, 3)."""
    for i in range(3):
        for j in range(3):
            total = 0.0
            for k in range(3):
                total += factor[i, k] * matrix[k, j]
            room[i, j] = total
    for i in range(3):
        for j in range(3):
            matrix[i, j] = room[i, j]


@jit
def fill_saltation(e, p, pieces, i, s) -> None:
    """Fill s, (3, 3), with the saltation matrix at the event that begins piece i > 0.

    With the reset D, the rates before and after it and the normal n of what vanishes there it is
    D + (after - D before) n^T / (n . before).
    """
    codes, values = pieces.codes, pieces.values
    cause, turn = codes[i, CAUSE], values[i, AT]
    if cause == HOUSING_STOP and values[i - 1, SPAN] == 0.0:
        # a housing that did not start
        cause = BEGIN
    for row in range(3):
        for column in range(3):
            s[row, column] = 1.0 if row == column else 0.0
    n_y, n_w, n_p, reset = 0.0, 0.0, 0.0, 1.0
    if cause in (IMPACT, REST_BEGINS, ENTER, LEAVE):
        n_y = 1.0
    elif cause in (TURN, STICK):
        n_w = 1.0
    elif cause == HOUSING_STOP:
        n_w, n_p = -momentum_share(p), 1.0
    else:
        return
    if cause == IMPACT:
        reset = -restitution_of(e, p, codes[i, HOME])
    # From the frame of the piece before to that of this one.
    flip = -1.0 if (codes[i - 1, HOME] == 1) != (codes[i, HOME] == 1) else 1.0
    y, w = values[i - 1, Y_END], values[i - 1, W_END]
    before = field_of(e, p, pieces, i - 1, y, w, turn)
    after = field_of(e, p, pieces, i, values[i, Y], values[i, W], turn)
    speed = flip * (n_y * before.y + n_w * before.w + n_p * before.p)
    s[1, 1] = reset
    if cause == REST_BEGINS:
        s[0, 0], s[1, 1] = 0.0, 0.0
    shift = flip * before.y * s[0, 0], flip * before.w * s[1, 1], flip * before.p
    normal = n_y / speed, n_w / speed, n_p / speed
    add_row(s, 0, after.y - shift[0], normal)
    add_row(s, 1, after.w - shift[1], normal)
    add_row(s, 2, after.p - shift[2], normal)


@jit
def add_row(s, row, change, normal) -> None:
    """Add the change of a rate times a normal to a row of s, (3, 3)."""
    s[row, 0] += change * normal[0]
    s[row, 1] += change * normal[1]
    s[row, 2] += change * normal[2]


@jit
def constrain(p, pieces, i, matrix) -> None:
    """Set the rows of a derivative to what piece i leaves free: a held mass has no velocity, a held housing none."""
    form = pieces.codes[i, FORM]
    for column in range(3):
        if form == RESTING:
            matrix[0, column] = 0.0
        if form in (HELD, RESTING):
            matrix[1, column] = 0.0
        if pieces.housing.way[i] == STANDS:
            matrix[2, column] = momentum_share(p) * matrix[1, column]


@jit
def jacobian_with_housing(e, p, pieces):
    """Return the Jacobian (j11, j12, j21, j22) over all logged pieces; `pieces.housing.product` has all of it."""
    log = pieces.housing
    total, factor = log.product, log.factor
    for row in range(3):
        for column in range(3):
            total[row, column] = 1.0 if row == column else 0.0
    for i in range(pieces.counts[PIECES]):
        if pieces.codes[i, CAUSE] != BEGIN and i > 0:
            fill_saltation(e, p, pieces, i, factor)
            multiply(factor, total, log.room)
        constrain(p, pieces, i, total)
        form = pieces.codes[i, FORM]
        if form in (FREE, CONTACT, BEYOND):
            terms = terms_of(e, p, pieces, i)
            e11, e12, e21, e22 = piece_flow(terms.stiffness, terms.damping, pieces.values[i, SPAN])
            for column in range(3):
                y, w = total[0, column], total[1, column]
                total[0, column] = e11 * y + e12 * w
                total[1, column] = e21 * y + e22 * w
            constrain(p, pieces, i, total)
    return total[0, 0], total[0, 1], total[1, 0], total[1, 1]


@jit
def solve_with_coupling(derivative, coupling, dy, dw, dp):
    """Return ((I - J)^-1 r, determinant of I - J) of a residual r = (dy, dw, dp), by Cramer's rule."""
    j11, j12, j21, j22 = derivative
    a, b, c = 1.0 - j11, -j12, -coupling.j13
    d, e, f = -j21, 1.0 - j22, -coupling.j23
    g, h, k = -coupling.j31, -coupling.j32, 1.0 - coupling.j33
    determinant = a * (e * k - f * h) - b * (d * k - f * g) + c * (d * h - e * g)
    y = (dy * (e * k - f * h) - b * (dw * k - f * dp) + c * (dw * h - e * dp)) / determinant
    w = (a * (dw * k - f * dp) - dy * (d * k - f * g) + c * (d * dp - dw * g)) / determinant
    q = (a * (e * dp - dw * h) - b * (d * dp - dw * g) + dy * (d * h - e * g)) / determinant
    return y, w, q, determinant


@jit
def eigenvalues_of_three(derivative, coupling):
    """Return the three eigenvalues of a derivative with its coupling, complex, the largest modulus first.

    A real root of the characteristic polynomial by Newton's method from beyond all roots, where it converges
    monotonically; the other two are those of the quadratic that is left.
    """
    j11, j12, j21, j22 = derivative
    j13, j23, j31, j32, j33 = coupling.j13, coupling.j23, coupling.j31, coupling.j32, coupling.j33
    trace = j11 + j22 + j33
    minors = j11 * j22 - j12 * j21 + j11 * j33 - j13 * j31 + j22 * j33 - j23 * j32
    determinant = (
        j11 * (j22 * j33 - j23 * j32)
        - j12 * (j21 * j33 - j23 * j31)
        + j13 * (j21 * j32 - j22 * j31)
    )
    bound = 1.0 + max(abs(trace), max(abs(minors), abs(determinant)))
    inflection = trace / 3.0
    value = ((inflection - trace) * inflection + minors) * inflection - determinant
    root = -bound if value > 0.0 else bound
    for _ in range(MAX_NEWTON):
        value = ((root - trace) * root + minors) * root - determinant
        slope = (3.0 * root - 2.0 * trace) * root + minors
        if slope == 0.0 or value == 0.0:
            break
        change = value / slope
        root -= change
        if abs(change) <= 2.0**-52 * abs(root):
            break
    one, two = eigenvalues_of(trace - root, minors - root * (trace - root))
    three = complex(root, 0.0)
    if abs(three) > abs(one):
        return three, one, two
    return (one, three, two) if abs(three) > abs(two) else (one, two, three)


@jit
def eigenvalues_of_cubic(trace, minors, determinant):
    """Return the roots of mu^3 - trace mu^2 + minors mu - determinant, the largest modulus first."""
    # Those of a companion matrix.
    companion = trace, -minors, 1.0, 0.0
    return eigenvalues_of_three(companion, Coupling(determinant, 0.0, 0.0, 1.0, 0.0))
