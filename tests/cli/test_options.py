"""Options that are no numbers: the message names the value and the remedy."""

import pytest
from typer.testing import CliRunner

from vibropipe.cli.commands import app


@pytest.mark.parametrize(
    ("option", "text", "hint"),
    [
        ("--l", "0,5", "write 0.5, with a point"),
        ("--l", "8mm", "numbers of this command have no unit"),
        ("--x0", "8 mm", "no unit belongs here: quantities with units go with `physical`"),
        ("--accuracy", "x", "numbers of this command have no unit"),
    ],
)
def test_an_option_that_is_no_number_is_told_with_its_value_and_a_hint(option, text, hint):
    done = CliRunner().invoke(app, ["simulate", "--l", "1", option, text], terminal_width=200)
    assert done.exit_code == 2
    told = " ".join(done.output.replace("│", " ").split())
    assert f"Invalid value for '{option}': must be a number, got '{text}' ({hint})" in told
