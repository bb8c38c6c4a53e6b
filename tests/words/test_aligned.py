"""Columns of a table for a terminal."""

from vibropipe.words.wording import aligned


def test_columns_are_as_wide_as_their_widest_cell():
    assert aligned([("a", "bb", "c"), ("long", "b", "")]) == ["a     bb  c", "long  b"]


def test_an_accent_takes_no_column():
    dotted = "x\u0307"
    assert aligned([(dotted, "1"), ("xy", "2")]) == [f"{dotted}   1", "xy  2"]
