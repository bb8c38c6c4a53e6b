"""Expressions: values are those of Python's own arithmetic, derivatives those of complex steps, all else is refused."""

import cmath
import math
import pickle
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vibropipe.words.expressions import MAX_LENGTH, Expression, ExpressionError

TEXTS = [
    "0.02 * nu**2",
    "2 * zeta",
    "-nu + +zeta - 3",
    "nu - zeta - 1",
    "nu / zeta / 2",
    "-nu**2",
    "2**-nu",
    "nu**zeta",
    "(nu + zeta) * (nu - zeta)",
    "2 * zeta * sqrt(nu)",
    "exp(-nu) * cos(2 * pi * zeta)",
    "log(nu) + tan(zeta) - sin(nu * zeta)",
    "exp(-pi * zeta / sqrt(1 - zeta**2))",
    "nu**3 / 3 + nu * 1e-3",
]
numbers = st.floats(0.05, 0.95)


def by_python(text: str, functions: Any, **values: Any) -> Any:
    """Return the value that Python gives the text."""
    names = {name: getattr(functions, name) for name in ("sqrt", "exp", "log", "sin", "cos", "tan")}
    return eval(text, {"__builtins__": {}}, {**names, "pi": math.pi, **values})


@pytest.mark.parametrize("text", TEXTS)
@given(nu=numbers, zeta=numbers)
def test_values_are_those_of_python_to_the_bit(text: str, nu: float, zeta: float) -> None:
    expression = Expression(text)
    assert expression.value({"nu": nu, "zeta": zeta}) == by_python(text, math, nu=nu, zeta=zeta)


@pytest.mark.parametrize("text", TEXTS)
@given(nu=numbers, zeta=numbers)
def test_derivatives_are_those_of_complex_steps(text: str, nu: float, zeta: float) -> None:
    values = {"nu": nu, "zeta": zeta}
    _, slopes = Expression(text).with_slopes(values, {name: {name: 1.0} for name in values})
    for name in values:
        moved = by_python(text, cmath, **{**values, name: values[name] + 1e-100j})
        assert slopes.get(name, 0.0) == pytest.approx(
            complex(moved).imag / 1e-100, rel=1e-11, abs=1e-13
        )


def test_derivatives_pass_through_names_that_depend_on_others() -> None:
    value, slopes = Expression("m * nu**2").with_slopes(
        {"m": 3.0, "nu": 2.0}, {"m": {"r": 5.0}, "nu": {"nu": 1.0}}
    )
    assert (value, slopes) == (12.0, {"r": 20.0, "nu": 12.0})


@pytest.mark.parametrize(
    ("text", "values"),
    [("1 / x", 0.0), ("log(x)", -1.0), ("sqrt(x)", -1.0), ("x**0.5", -1.0), ("exp(x)", 1e4), ("9**9**9**x", 9.0),
     ("sqrt(x**0.5)", -1.0)],
)  # fmt: skip
def test_what_is_no_finite_real_number_is_nan(text: str, values: float) -> None:
    assert math.isnan(Expression(text).value({"x": values}))


def test_a_value_without_a_derivative_has_nan_as_derivative() -> None:
    value, slopes = Expression("sqrt(x)").with_slopes({"x": 0.0}, {"x": {"x": 1.0}})
    assert value == 0.0
    assert math.isnan(slopes["x"])


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("nu^2", r"\^, which is written as \*\*"),
        ("__import__('os')", "the unknown function __import__"),
        ("abs(nu)", "the unknown function abs"),
        ("max(nu, 1)", "the unknown function max"),
        ("sqrt(nu, 2)", "sqrt of 2 numbers"),
        ("sqrt", "sqrt without its argument"),
        ("sqrt(x=nu)", "the part sqrt"),
        ("nu.real", "the part nu.real"),
        ("nu[0]", r"the part nu\[0\]"),
        ("[nu]", r"the part \[nu\]"),
        ("nu if zeta else 1", "the part nu if"),
        ("nu < 1", "the part nu < 1"),
        ("nu // 2", "the part nu // 2"),
        ("nu % 2", "the part nu % 2"),
        ("not nu", "the part not nu"),
        ("'text'", "the part 'text'"),
        ("True", "the part True"),
        ("1j", "the part 1j"),
        ("lambda: nu", "the part lambda"),
        ("(a := nu)", "the part"),
        ("nu; zeta", "no expression"),
        ("0,5", r"the part \(0, 5\)"),
        ("", "no expression"),
        ("2 nu", "no expression"),
        ("(" * 300 + "nu" + ")" * 300, "longer than"),
        ("(" * 99 + "nu" + ")" * 98, "no expression"),
        ("1e999", "a number that is too large"),
    ],
)  # fmt: skip
def test_other_text_is_refused_in_words(text: str, told: str) -> None:
    with pytest.raises(ExpressionError, match=told):
        Expression(text)


def test_the_longest_expressions_are_computed() -> None:
    deepest = "-" * (MAX_LENGTH - 1) + "x"
    assert Expression(deepest).value({"x": 2.0}) == (-1) ** (MAX_LENGTH - 1) * 2.0
    chain = "+".join(["x"] * (MAX_LENGTH // 2))
    assert Expression(chain).value({"x": 1.0}) == MAX_LENGTH // 2


def test_greek_letters_are_names() -> None:
    assert Expression("0.5 * ν**2 + δ").names == ("nu", "delta")


def test_expressions_can_be_sent_to_other_processes() -> None:
    sent = pickle.loads(pickle.dumps(Expression("2 * zeta")))
    assert sent.value({"zeta": 0.5}) == 1.0
