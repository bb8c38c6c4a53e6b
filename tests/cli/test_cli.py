"""The command line: output, files, exit codes and messages."""

import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from command_line import printed, run

from vibropipe import cli
from vibropipe.store import load, save
from vibropipe.words.status import Status

STUDY = """\
title: A study of seconds
exciter: {l: 0.5, nu: 1, f: -1, h: 0.2, R1: 0.7, R2: 0.7}
scenes:
  forced:
    kind: motion
    settle_periods: 30
    tau_end: 7
    samples_per_period: 16
    solver: {method: newmark, steps_per_period: 500}
    outputs: [motion, impacts, harmonics, stability]
  quiet: {kind: motion, tau_end: 7, outputs: [impacts]}
  curves: {kind: backbone, delta_over_l: [0, 0.2], tau_bar: {start: 2.5, stop: 6, points: 15}}
  free: {kind: backbone, amplitude: [0.3, 0.6]}
  response: {kind: sweep, over: {f: [0.2, 1], nu: [0.9, 1, 1.1]}}
"""
COMMANDS = (
    "plan",
    "simulate",
    "solve",
    "join",
    "figure",
    "report",
    "show",
    "compare",
    "verify",
    "bench",
    "run",
    "new",
)


@pytest.fixture
def study(tmp_path):
    file = tmp_path / "tiny.yaml"
    file.write_text(STUDY)
    return file


def solve(study: Path, scene: str, *more: object) -> xr.Dataset:
    output = study.parent / "out" / f"{scene}.nc"
    assert run("solve", study, "--scene", scene, "--output", output, *more) == 0
    return load(output)


def test_help_names_every_command(capsys):
    assert run("--help") == 0
    printed = capsys.readouterr().out
    assert all(f" {command} " in printed for command in COMMANDS)


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_help(command, capsys):
    assert run(command, "--help") == 0
    assert "Usage: vibropipe " + command in capsys.readouterr().out


# scipy by one of its parts: reading units imports its empty shell.
LIBRARIES = {"numba", "scipy.linalg", "xarray", "pandas", "netCDF4", "matplotlib"}


@pytest.mark.parametrize(
    ("call", "heavy"),
    [
        (
            "from vibropipe.cli import main\ntry: main(['--help'])\nexcept SystemExit: pass",
            {"numpy", "pydantic", "yaml", *LIBRARIES},
        ),
        # what the workflow does before the first job
        ("from vibropipe.jobs.run import read_run; read_run(None, {})", LIBRARIES),
    ],
    ids=["help", "plans"],
)
def test_what_computes_nothing_imports_nothing_heavy(call, heavy):
    code = f"import sys\n{call}\nsys.exit(', '.join({heavy} & set(sys.modules)) or 0)"
    printed(code)


@pytest.mark.parametrize(
    ("command", "words"),
    [
        ("plan absent.yaml", ["absent.yaml"]),
        ("solve {study} --scene forcd --output {out}", ["'forcd'", "forced"]),
        (
            "solve {study} --scene forced --shard 1/2 --output {out}",
            ["scenes.forced: must be of kind sweep or basins to be cut into shards, got motion"],
        ),
        (
            "solve {study} --scene response --shard 1/7 --output {out}",
            ["scenes.response: must be cut into 1 to 6 shards, got 7"],
        ),
        (
            "solve {study} --scene response --shard 3/2 --output {out}",
            ["shard: must be a number from 1 to 2, got 3"],
        ),
        (
            "solve {study} --scene response --shard a --output {out}",
            ["--shard", "must be I/N", "'a'"],
        ),
        (
            "join {study} --scene free --output {out} a.nc",
            ["scenes.free: must be of kind sweep or basins"],
        ),
        ("join {study} --scene response --output {out} a.nc", ["a.nc"]),
        ("show absent.nc", ["absent.nc"]),
        ("figure {study} --results absent", ["absent"]),
        ("report {study} --results absent --output r.pdf", ["absent"]),
        ("report {study} --output r.html", ["--output", ".pdf", "r.html"]),
        ("solve {study} --scene forced --output x.csv", ["--output", ".nc", "x.csv"]),
        ("table x.nc -o x.ods", ["--output", ".csv, .xlsx", "x.ods"]),
        ("simulate --l 1 --f 1", ["nu: is required beside f"]),
        ("simulate --l -1", ["l: must be a finite number > 0, got -1.0"]),
        ("simulate --l 1 --R1 1.5", ["R1: must be a number from 0 to 1, got 1.5"]),
        ("simulate --l 1 --method euler", ["method: must be exact or newmark, got 'euler'"]),
        ("simulate --l 1 --plot a.xyz", ["--plot", "a.xyz", ".svg"]),
        ("simulate", ["--l"]),
        ("sovle", ["sovle", "solve"]),
    ],
)
def test_a_mistake_is_one_message_and_exit_code_2(command, words, study, capsys, monkeypatch):
    monkeypatch.chdir(study.parent)
    out = study.parent / "out.nc"
    assert run(*(part.format(study=study, out=out) for part in command.split())) == 2
    printed = capsys.readouterr()
    assert not printed.out
    assert "Traceback" not in printed.err
    for word in words:
        assert word in printed.err
    assert [path.name for path in study.parent.iterdir()] == ["tiny.yaml"]


def test_all_faults_of_a_study_are_listed(study, capsys):
    study.write_text(STUDY.replace("tau_end: 7\n", "tau_ende: 7\n").replace("nu: [0.9", "mu: [0.9"))
    assert run("plan", study) == 2
    printed = capsys.readouterr().err
    assert "scenes.forced.tau_ende" in printed
    assert "scenes.response.over.mu" in printed


def test_a_fault_of_the_program_keeps_its_traceback(study, monkeypatch):
    def broken(*arguments):
        raise ZeroDivisionError

    monkeypatch.setattr("vibropipe.jobs.terminal_tables.plan_text", broken)
    with pytest.raises(ZeroDivisionError):
        cli.main(["plan", "--rough", str(study)])


def test_plan_lists_every_scene(study, capsys):
    assert run("plan", study) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "tiny: A study of seconds"
    assert [line.split()[0] for line in lines[2:7]] == [
        "forced", "quiet", "curves", "free", "response",
    ]  # fmt: skip
    assert "newmark, 500 steps" in lines[2]
    assert lines[7].startswith("5 scenes, 40 rows")


def test_simulate_prints_the_impacts_of_the_motion(capsys):
    options = ["--l", 0.5, "--v0", -0.51, "--tau-end", 10]
    assert run("simulate", *options) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("nu = 1  f = 0  h = 0  l = 0.5")
    # x = -0.51 sin(tau) reaches support 2 at asin(0.5 / 0.51), at the speed sqrt(0.51^2 - 0.5^2)
    tau, event, support, before, after = lines[2].split()
    assert float(tau) == pytest.approx(np.arcsin(0.5 / 0.51), abs=1e-11)
    assert (event, support) == ("impact", "2")
    assert float(before) == pytest.approx(-np.sqrt(0.51**2 - 0.5**2), abs=1e-9)
    assert float(after) == -float(before)
    assert lines[-1].startswith("end: displacement ")


@pytest.mark.parametrize("word", ["no_pull", "1"])
def test_simulate_takes_the_word_of_a_contact(word, capsys):
    options = ["--l", 0.5, "--k1", 3, "--h1", 1, "--v0", 1, "--tau-end", 3]
    assert run("simulate", *options, "--contact_1", word) == 0
    assert "contact_1 = no_pull" in capsys.readouterr().out
    assert run("simulate", *options, "--contact_1", "let_go") == 2
    assert "contact_1: must be pull or no_pull, got 'let_go'" in capsys.readouterr().err


def test_simulate_starts_where_the_mass_is_at_rest(capsys):
    """Without a force it stays there: at the equilibrium, or on the support that it is pressed on."""
    for options, x in ((["--load", 0.2], 0.2), (["--delta", 0.6], 0.1), (["--delta", -0.6], -0.1)):
        assert run("simulate", "--l", 0.5, *options) == 0
        end = capsys.readouterr().out.splitlines()[-1]
        assert end.startswith(f"end: displacement {x}, velocity 0")


def test_simulate_prints_the_accuracy_it_reached(capsys):
    command = "simulate --l 0.5 --nu 1 --f 1 --h 0.1 --R1 0.8 --R2 0.8 --accuracy 1e-6"
    assert run(*command.split()) == 0
    printed = re.search(
        r"(exact|newmark).*: error (\S+) \(requested (\S+)\)$", capsys.readouterr().out, re.M
    )
    assert printed is not None
    assert float(printed[2]) <= float(printed[3]) == 1e-6


def test_simulate_draws_and_keeps_the_motion(tmp_path, capsys):
    plot, output = tmp_path / "new" / "motion.svg", tmp_path / "new" / "motion.nc"
    options = ["--l", 0.5, "--nu", 1, "--f", 1, "--tau-end", 7, "--plot", plot, "--output", output]
    assert run("simulate", *options) == 0
    assert plot.read_text().startswith("<?xml")
    assert load(output)["displacement"].dims == ("tau",)


def test_simulate_shortens_a_long_table(capsys):
    assert run("simulate", "--l", 0.5, "--v0", 5, "--tau-end", 100) == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 64
    assert any(line.startswith("... ") for line in lines)


def test_a_motion_is_recorded_after_its_settling(study):
    motion = solve(study, "forced")
    begin = 30 * 2 * np.pi
    assert motion["tau"].values[[0, -1]] == pytest.approx([begin, begin + 7], abs=1e-12)
    assert (motion["impact_tau"] >= begin).all()
    # the exact motion beside newmark's, which is of second order in a step of 2 pi / 500
    difference = np.abs(motion["displacement"] - motion["displacement_exact"]).max()
    assert 0 < difference < 1e-3
    # impacts of the settled motion are those of the orbit
    assert motion["period_multiple"] == 1
    assert set(motion["orbit_impact_support"].values) == {1, 2}
    fastest = float(np.abs(motion["orbit_impact_velocity"]).max())
    assert float(np.abs(motion["impact_velocity"]).max()) == pytest.approx(fastest, rel=1e-3)


def test_outputs_that_are_not_requested_are_absent(study):
    motion = solve(study, "quiet")
    assert "impact_tau" in motion
    assert not {"displacement", "displacement_amplitude", "floquet_multiplier"} & set(motion)


def test_simulated_points_lie_on_their_curves(study):
    """Eq. (10) for delta/l = d: v/l = (1 - d + (1 + d) cos(tau/2)) / sin(tau/2)."""
    curves = solve(study, "curves")
    offset = curves["delta_over_l"]
    half = curves["simulated_tau_bar"] / 2
    velocity = (1 - offset + (1 + offset) * np.cos(half)) / np.sin(half)
    assert curves["simulated_velocity_over_l"].dims == ("delta_over_l", "point")
    assert np.isfinite(velocity).all()
    np.testing.assert_allclose(curves["simulated_velocity_over_l"], velocity, rtol=1e-10)


def test_shards_join_to_the_whole_sweep_in_any_order(study):
    whole = solve(study, "response")
    shards = []
    for shard in (3, 1, 2):
        shards.append(study.parent / f"{shard}.nc")
        cut = ["--shard", f"{shard}/3", "--threads", 1, "--output", shards[-1]]
        assert run("solve", study, "--scene", "response", *cut) == 0
    output = study.parent / "joined.nc"
    assert run("join", study, "--scene", "response", "--output", output, *shards) == 0
    xr.testing.assert_identical(whole, load(output))

    assert run("join", study, "--scene", "response", "--output", output, *shards[:2]) == 2
    xr.testing.assert_identical(whole, load(output))


def test_show_prints_what_a_dataset_holds(tmp_path, capsys):
    dataset = xr.Dataset({"displacement_end": ((), 0.25)}, attrs={"title": "a small one"})
    save(dataset, tmp_path / "small.nc")
    for path in (tmp_path / "small.nc", tmp_path):
        assert run("show", path) == 0
        printed = capsys.readouterr().out
        assert "a small one" in printed
        assert "displacement_end" in printed


def test_threads_beyond_the_machine_are_taken_as_all(study):
    solve(study, "quiet", "--threads", 4096)
    assert run("solve", study, "--scene", "quiet", "--output", "x.nc", "--threads", 0) == 2


def test_interrupt_ends_with_130_and_leaves_nothing_behind(study):
    """A sweep of minutes is interrupted while its kernels are compiled, or run."""
    grids = "f: {start: 0.1, stop: 2, points: 1000}, nu: {start: 0.3, stop: 3, points: 1000}"
    study.write_text(STUDY.replace("f: [0.2, 1], nu: [0.9, 1, 1.1]", grids))
    output = study.parent / "out" / "response.nc"
    code = (
        "import vibropipe.scenes.sweep.solve as scenes\n"
        "from vibropipe.cli import main\n"
        "solve = scenes.solve_blocks\n"
        "def announced(*arguments, **keywords):\n"
        "    print('solving', flush=True)\n"
        "    return solve(*arguments, **keywords)\n"
        "scenes.solve_blocks = announced\n"
        f"main(['solve', {str(study)!r}, '--scene', 'response', '--output', {str(output)!r}])\n"
    )
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen([sys.executable, "-c", code], **pipes) as process:
        assert process.stdout.readline() == "solving\n"
        time.sleep(1)
        process.send_signal(signal.SIGINT)
        _, printed = process.communicate(timeout=120)
    assert process.returncode == 130
    assert printed.splitlines()[-1].startswith("vibropipe: interrupted; ")
    told = ("response: ", "compiling ")
    assert all(line.startswith(told) for line in printed.splitlines()[:-1])
    assert not output.parent.exists()


def test_commands_report_a_status_without_warnings_of_python(tmp_path):
    """In processes of their own, since pytest shows warnings itself."""
    chaotic = "{l: 0.5, nu: 0.6, f: 1, h: 0.1, R1: 0.9, R2: 0.9}"
    (tmp_path / "t.yaml").write_text(
        f"title: t\nexciter: {chaotic}\n"
        "scenes: {m: {kind: motion, tau_end: 9, outputs: [impacts, harmonics]}}\n"
    )
    options = ["--l", "0.5", "--nu", "0.6", "--f", "1", "--h", "0.1", "--R1", "0.9", "--R2", "0.9"]
    accurate = ["simulate", *options, "--tau-end", "900", "--accuracy", "1e-12"]
    solve = ["solve", "t.yaml", "--scene", "m", "-o", "m.nc"]
    for command in (solve, ["table", "m.nc"], accurate):
        program = [sys.executable, "-c", "from vibropipe.cli import main; main()", *command]
        done = subprocess.run(program, capture_output=True, text=True, check=True, cwd=tmp_path)
        assert "Warning" not in done.stderr
    assert "Rounding errors grow beyond the requested accuracy" in done.stdout
    assert int(load(tmp_path / "m.nc").status) == Status.MAX_PERIODS
