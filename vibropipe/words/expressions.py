"""Arithmetic written as text, `0.02 * nu**2`: read by Python's parser, computed number by number, never run as code.

Each value is that of Python's own arithmetic and `math`, so that it does not depend on how many numbers are computed
together. Derivatives are carried along with the values (forward mode), exact to rounding.
"""

from __future__ import annotations

import ast
import math
import operator
import re
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import cached_property
from typing import Any, NamedTuple

from vibropipe.words.spelling import latin

CONSTANTS = {"pi": math.pi}
# Each function with its derivative by its argument, from the argument and the value of the function.
FUNCTIONS: Mapping[str, tuple[Callable[[float], float], Callable[[float, float], float]]] = {
    "sqrt": (math.sqrt, lambda _u, value: 0.5 / value),
    "exp": (math.exp, lambda _u, value: value),
    "log": (math.log, lambda u, _value: 1.0 / u),
    "sin": (math.sin, lambda u, _value: math.cos(u)),
    "cos": (math.cos, lambda u, _value: -math.sin(u)),
    "tan": (math.tan, lambda _u, value: 1.0 + value * value),
}
OPERATORS: Mapping[type[ast.AST], tuple[str, Callable[[Any, Any], Any]]] = {
    ast.Add: ("+", operator.add),
    ast.Sub: ("-", operator.sub),
    ast.Mult: ("*", operator.mul),
    ast.Div: ("/", operator.truediv),
    ast.Pow: ("**", operator.pow),
}
RESERVED = (*CONSTANTS, *FUNCTIONS)
ALLOWED = f"arithmetic of numbers and names, with + - * / **, brackets and {', '.join(RESERVED)}"
# Longer ones are not what a person writes; parts within parts of a longer one may run out of stack.
MAX_LENGTH = 200
NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,63}", re.ASCII)
Slopes = dict[str, float]


class ExpressionError(ValueError):
    """A text is no expression; its own text says what of it is not taken."""


class Node(NamedTuple):
    """A part of an expression: a number, a name, or an operator or a function with its arguments."""

    kind: str
    of: Any
    parts: tuple[Node, ...] = ()


class Expression:
    """An expression of numbers and names, from text in which Greek letters are as in studies.

    Raises ExpressionError if the text is no arithmetic of numbers, names and the functions of `FUNCTIONS`.
    """

    def __init__(self, text: str) -> None:
        self.text = latin(text).strip()
        if len(self.text) > MAX_LENGTH:
            raise ExpressionError(f"longer than {MAX_LENGTH} characters")
        if "^" in self.text:
            raise ExpressionError("^, which is written as **")
        try:
            self.root = _node(ast.parse(self.text, mode="eval").body)
        except ExpressionError:
            raise
        except (SyntaxError, ValueError, MemoryError, RecursionError):
            raise ExpressionError("no expression that can be read") from None

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The names in it, each once, in their order."""
        return tuple(dict.fromkeys(_names(self.root)))

    def value(self, values: Mapping[str, float]) -> float:
        """Return its value; nan where it is no real number or too large."""
        return self.with_slopes(values, {})[0]

    def with_slopes(
        self, values: Mapping[str, float], slopes: Mapping[str, Slopes]
    ) -> tuple[float, Slopes]:
        """Return its value, and its derivatives by whatever the names depend on.

        They are nan where it is no real number, or has no derivative, as sqrt(x) at 0.

        slopes : derivatives of each name that depends on something
        """
        value, own = _computed(self.root, values, slopes)
        return (value if isinstance(value, float) and math.isfinite(value) else math.nan), own


def _node(tree: ast.AST) -> Node:
    """Return a part of a parsed text, or raise an ExpressionError if it is not taken."""
    if isinstance(tree, ast.Constant) and type(tree.value) in (int, float):
        # As floats: whole numbers of Python have no end, and 9**9**9**9 would take as long.
        with suppress(OverflowError):
            if math.isfinite(number := float(tree.value)):  # type: ignore[arg-type]
                return Node("number", number)
        raise ExpressionError("a number that is too large")
    if isinstance(tree, ast.Name):
        if tree.id in FUNCTIONS:
            raise ExpressionError(f"{tree.id} without its argument in brackets")
        if tree.id in CONSTANTS:
            return Node("number", CONSTANTS[tree.id])
        return Node("name", tree.id)
    if isinstance(tree, ast.UnaryOp) and isinstance(tree.op, (ast.USub, ast.UAdd)):
        inner = _node(tree.operand)
        return Node("minus", None, (inner,)) if isinstance(tree.op, ast.USub) else inner
    if isinstance(tree, ast.BinOp) and type(tree.op) in OPERATORS:
        sign, _ = OPERATORS[type(tree.op)]
        return Node("operator", sign, (_node(tree.left), _node(tree.right)))
    if isinstance(tree, ast.Call) and isinstance(tree.func, ast.Name) and not tree.keywords:
        if tree.func.id not in FUNCTIONS:
            raise ExpressionError(f"the unknown function {tree.func.id}")
        if len(tree.args) != 1:
            raise ExpressionError(f"{tree.func.id} of {len(tree.args)} numbers in place of one")
        return Node("function", tree.func.id, (_node(tree.args[0]),))
    raise ExpressionError(f"the part {ast.unparse(tree)[:60]}")


def _names(node: Node) -> list[str]:
    own = [node.of] if node.kind == "name" else []
    return own + [name for part in node.parts for name in _names(part)]


_BY_SIGN = dict(OPERATORS.values())


def _computed(
    node: Node, values: Mapping[str, float], slopes: Mapping[str, Slopes]
) -> tuple[Any, Slopes]:
    """Return the value of a part and its derivatives; nan, or a complex number, where there is no real one."""
    if node.kind == "number":
        return node.of, {}
    if node.kind == "name":
        return values[node.of], slopes.get(node.of, {})
    computed = [_computed(part, values, slopes) for part in node.parts]
    numbers = [value for value, _ in computed]
    function: Callable[..., Any] = {
        "minus": operator.neg,
        "operator": _BY_SIGN.get(node.of),
        "function": FUNCTIONS.get(node.of, (None,))[0],
    }[node.kind]  # type: ignore[assignment]
    try:
        value = function(*numbers)
    except (ArithmeticError, ValueError, TypeError):  # a TypeError of a complex number
        value = math.nan
    total: Slopes = {}
    for n, (_, own) in enumerate(computed):
        if own:
            slope = _slope(node, n, numbers, value)
            for name, each in own.items():
                total[name] = total.get(name, 0.0) + slope * each
    return value, total


def _slope(node: Node, n: int, numbers: list[Any], value: Any) -> float:
    """Return the derivative of a part by the n-th of its arguments; nan where there is none."""
    try:
        slope = _slope_of[node.kind](node.of, n, numbers, value)
    except (ArithmeticError, ValueError, TypeError):
        return math.nan
    return slope if isinstance(slope, float) else math.nan


def _slope_of_operator(sign: str, n: int, numbers: list[Any], value: Any) -> Any:
    u, v = numbers
    if sign in "+-":
        return -1.0 if sign == "-" and n else 1.0
    if sign == "*":
        return v if n == 0 else u
    if sign == "/":
        return 1.0 / v if n == 0 else -value / v
    if n == 0:
        return v * u ** (v - 1.0) if v != 0.0 else 0.0
    return value * math.log(u)


_slope_of: Mapping[str, Callable[[Any, int, list[Any], Any], Any]] = {
    "minus": lambda _of, _n, _numbers, _value: -1.0,
    "operator": _slope_of_operator,
    "function": lambda of, _n, numbers, value: FUNCTIONS[of][1](numbers[0], value),
}
