"""The server: who may see the page, answers over its socket, and its end."""

import re
import signal
import subprocess
import time
from urllib.error import HTTPError
from urllib.parse import parse_qs, urlsplit
from urllib.request import urlopen

import pytest
from bokeh.client import pull_session
from sharded_study import PROGRAM, read_until

from vibropipe.cli.commands import app
from vibropipe.store import load


@pytest.fixture(scope="module")
def served(study):
    """The address of a page that the command serves; the server ends with Ctrl-C."""
    command = [*PROGRAM, "view", str(study), "--no-browser", "--scene", "map"]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        address = re.search(r"http\S+", read_until("http", process))[0]
        assert "Ctrl-C ends the page" in read_until("Ctrl-C", process)
        yield address
        process.send_signal(signal.SIGINT)
        told, errors = process.communicate(timeout=30)
    assert told.strip() == "ended"
    assert process.returncode == 0
    assert "Traceback" not in errors


def status_of(address):
    try:
        with urlopen(address) as answer:
            return answer.status
    except HTTPError as error:
        return error.code


def test_only_the_printed_token_opens_the_page(served):
    parts = urlsplit(served)
    assert parts.hostname == "localhost"
    assert status_of(served) == 200
    assert status_of(served[:-1] + ("A" if served[-1] != "A" else "B")) == 403
    assert status_of(f"http://localhost:{parts.port}/") == 403


def test_the_page_asks_nothing_of_the_network(served):
    with urlopen(served) as answer:
        text = answer.read().decode()
    assert set(re.findall(r'(?:src|href)="(\w+:)?//', text)) == set()


def test_a_moved_crosshair_is_answered_over_the_socket(served, study, monkeypatch):
    """As a browser does it: a property changes there, and the panels change here."""
    with urlopen(served) as answer:
        token = re.search(r'"token":"([^"]+)"', answer.read().decode())[1]
    monkeypatch.setattr("bokeh.client.session.generate_jwt_token", lambda *_a, **_k: token)
    parts = urlsplit(served)
    name = parse_qs(parts.query)["bokeh-session-id"][0]
    session = pull_session(session_id=name, url=f"http://localhost:{parts.port}/")
    try:
        crosshair = session.document.select_one({"name": "crosshair"})
        nu, moved = float(load(study / "map.nc")["nu"].values[1]), time.monotonic()
        crosshair.data, law = {**crosshair.data, "x": [nu]}, ""
        session.force_roundtrip()  # the server has it before the document here is replaced
        while f"ν = {nu:g}" not in law and time.monotonic() < moved + 20:
            session.pull()
            law = session.document.select_one({"name": "law"}).text
        assert f"ν = {nu:g}" in law
        assert "<table" in session.document.select_one({"name": "numbers"}).text
    finally:
        session.close()


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["nowhere"], "nowhere: does not exist"),
        (["."], "holds no scene"),
        (["{study}", "--scene", "none"], "has no sweep and no basins 'none': name one of"),
        (["{study}", "--scene", "starts", "--save", "x.html"], "starts: is no sweep"),
    ],
)
def test_mistakes_are_messages(arguments, expected, study, tmp_path, monkeypatch):
    from vibropipe.store import StoreError

    monkeypatch.chdir(tmp_path)
    given = [each.format(study=study) for each in arguments]
    with pytest.raises(StoreError, match=re.escape(expected)):
        app(args=["view", *given], standalone_mode=False)


def test_a_study_file_names_its_results(study, tmp_path):
    from vibropipe.view.results import open_results

    file = tmp_path / f"{study.name}.yaml"
    file.write_text(
        "title: Small\nexciter: {l: 0.5}\nscenes: {one: {kind: motion, tau_end: 5}}\n", "utf-8"
    )
    opened = open_results(file, study.parent)
    assert opened.title == "Small"
    assert opened.note == (
        "both_ways, map and starts: no longer in the study; one: not solved yet. "
        f"Solve it with: vibropipe run {file}"
    )


STUDY = """title: Small
exciter: {l: 0.5, nu: 1, f: -1, h: 0.2, R1: 0.7, R2: 0.7}
scenes: {map: {kind: sweep, over: {nu: [1.0, 1.2]}}}
"""


def test_the_page_of_an_edited_study_says_that_its_results_are_old(tmp_path, monkeypatch):
    from vibropipe.view.page import Page
    from vibropipe.view.results import open_results

    file = tmp_path / "small.yaml"
    file.write_text(STUDY, "utf-8")
    monkeypatch.chdir(tmp_path)
    app(["solve", "small.yaml", "--scene", "map", "--output", "results/small/map.nc"],
        standalone_mode=False)  # fmt: skip
    opened = open_results(file, tmp_path / "results")
    assert opened.note == ""
    file.write_text(STUDY.replace("1.2", "1.3"), "utf-8")
    opened = open_results(file, tmp_path / "results")
    expected = f"map: from before the study was changed. Solve it with: vibropipe run {file}"
    assert opened.note == expected
    assert expected in [getattr(model, "text", "") for model in Page(opened).root.references()]


def test_without_bokeh_the_command_says_how_to_get_it(monkeypatch):
    from vibropipe.store import StoreError
    from vibropipe.view.results import check_installed

    monkeypatch.setattr("vibropipe.view.results.find_spec", lambda name: None)
    with pytest.raises(StoreError, match=r"pip install 'vibropipe\[view\]'"):
        check_installed()
