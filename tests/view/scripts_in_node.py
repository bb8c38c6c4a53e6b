"""The scripts of the page run by node, with plain objects in place of the models of Bokeh."""

import json
import shutil
import subprocess
from typing import Any

import pytest

from vibropipe.view.words import source_of

NODE = shutil.which("node")
needs_node = pytest.mark.skipif(NODE is None, reason="needs node (Debian: apt-get install nodejs)")
HEAD = """
const given = JSON.parse(require("fs").readFileSync(0, "utf8"), (key, value) => value === "NaN" ? NaN : value)
const told = (value) => console.log(JSON.stringify(value, (key, each) => Number.isNaN(each) ? "NaN" : each))
"""


def run(code: str, given: Any) -> Any:
    """Return what code tells of what it is given."""
    done = subprocess.run(
        [NODE, "-e", HEAD + code],
        input=json.dumps(given)
        .replace("Infinity", "NaN")
        .replace("-NaN", "NaN")
        .replace("NaN", '"NaN"'),
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.replace('"NaN"', "NaN"))


def call(name: str, arguments: dict[str, Any], after: str) -> Any:
    """Run a callback of the page with its arguments, then return the value of an expression."""
    names = ", ".join(arguments)
    body = f"(() => {{ {source_of(name)} }})()"
    return run(f"const {{{names}}} = given; {body}; told({after})", arguments)
