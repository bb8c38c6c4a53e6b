"""A fact stands once: a parameter is its record and its equation, a quantity its record and its function.

An effect that acts through parameters is its record. They are registered from the folder `toys` and go from YAML to the
PDF, in a process of their own, since all other modules make their lists from the records when they are imported.
"""

import csv
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pdf_pages import page_texts

import vibropipe as vp

STUDY = """
title: Worn supports
exciter: {l: 0.5, delta: 0.1, nu: 1.2, f: 0.8, h: 0.1, R1: 0.7, R2: 0.6}
scenes:
  worn:
    kind: sweep
    over: {wear: {start: 0, stop: 0.5, points: 6}}
    outputs: [impacts]
    figure: {show: [impact_difference]}
  motion: {kind: motion, exciter: {wear: 0.2}, tau_end: 20, outputs: [impacts]}
"""
COMMANDS = (
    "plan toy.yaml",
    *(f"solve toy.yaml --scene {name} --output results/toy/{name}.nc" for name in ("worn", "motion")),
    "figure toy.yaml",
    "report toy.yaml --output results/toy/report.pdf",
    "table results/toy/worn.nc -o worn.csv",
    "simulate --l 0.5 --nu 1.2 --f 0.8 --wear 0.2 --tau-end 20",
)  # fmt: skip

FOLDERS = os.pathsep.join([str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")])
ENVIRONMENT = {**os.environ, "PYTHONPATH": FOLDERS}


def run(folder: Path, *commands: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "toys", *commands], cwd=folder, capture_output=True, text=True,
        env=ENVIRONMENT, check=False,
    )  # fmt: skip


def printed(script: str, folder: Path) -> Any:
    """Return what a script with the toys prints as JSON."""
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=folder, capture_output=True, text=True,
        env=ENVIRONMENT, check=True,
    )  # fmt: skip
    return json.loads(done.stdout)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("toys")
    folder.joinpath("toy.yaml").write_text(STUDY)
    done = run(folder, *COMMANDS)
    assert done.returncode == 0, done.stderr
    assert "6 wear" in done.stdout
    return folder


def test_a_parameter_acts_as_its_equation_says(folder):
    worn = vp.load(folder / "results/toy/worn.nc")
    np.testing.assert_allclose(worn["wear"], np.linspace(0, 0.5, 6), atol=1e-15)
    assert (float(worn["R1"]), float(worn["R2"])) == (0.7, 0.6)
    share = 1.0 - worn["wear"].values
    for n in range(6):
        expected = vp.steady_state(
            vp.Exciter(l=0.5, delta=0.1, nu=1.2, f=0.8, h=0.1, R1=0.7 * share[n], R2=0.6 * share[n]),
            outputs=["impacts"],
        )  # fmt: skip
        row = worn.isel(wear=n)
        assert (
            row["impact_velocity_max"].values.tolist()
            == expected["impact_velocity_max"].values.tolist()
        )
    motion = vp.load(folder / "results/toy/motion.nc")
    expected = vp.simulate(
        vp.Exciter(l=0.5, delta=0.1, nu=1.2, f=0.8, h=0.1, R1=0.7 * 0.8, R2=0.6 * 0.8), tau_end=20
    )
    np.testing.assert_allclose(motion["impact_velocity"], expected["impact_velocity"], rtol=1e-12)
    assert float(motion["wear"]) == 0.2
    assert float(motion["R1"]) == 0.7


def test_a_quantity_has_the_values_of_its_function_and_the_words_of_its_record(folder):
    worn = vp.load(folder / "results/toy/worn.nc")
    hardest = worn["impact_velocity_max"]
    difference = hardest.sel(support=1) - hardest.sel(support=2)
    np.testing.assert_array_equal(worn["impact_difference"], difference)
    assert worn["impact_difference"].attrs["symbol"] == "$d$"
    with (folder / "worn.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [float(row["impact_difference"]) for row in rows] == difference.values.tolist()
    assert [float(row["wear"]) for row in rows] == worn["wear"].values.tolist()


def test_both_stand_in_figure_and_report(folder):
    text = " ".join(" ".join(page_texts(folder / "results/toy/report.pdf")).split())
    assert "How does the motion change with the wear?" in text
    assert "impact velocity by which support 1 is struck harder d" in text  # the ordinate
    assert "wear of the supports w" in text  # the abscissa
    assert "w 0 … 0.5 wear" in text  # beside the drawing of the exciter
    assert "w = 0.2" in text  # the caption of the motion


def test_an_effect_is_named_where_it_occurs(folder):
    worn = vp.load(folder / "results/toy/worn.nc")
    assert worn.attrs["effects"].split()[-1] == "wear"
    text = " ".join(" ".join(page_texts(folder / "results/toy/report.pdf")).split())
    assert "wear takes its share of both restitutions" in text
    without = STUDY.replace(
        "outputs: [impacts]\n    figure",
        "outputs: [impacts]\n    effects: [damping, forcing]\n    figure",
    )
    folder.joinpath("without.yaml").write_text(without)
    done = run(folder, "plan without.yaml")
    assert done.returncode != 0
    assert "wear unless wear = 0" in done.stderr


def test_a_wrong_value_is_refused_in_words_of_the_record(folder):
    folder.joinpath("toy.yaml").write_text(STUDY.replace("stop: 0.5", "stop: 1.5"))
    done = run(folder, "plan toy.yaml")
    folder.joinpath("toy.yaml").write_text(STUDY)
    assert done.returncode != 0
    assert "scenes.worn.over.wear" in done.stderr
    assert "must be a number from 0 to 1" in done.stderr


def test_keys_schema_goals_and_units_are_made_from_the_records(tmp_path):
    script = (
        "import json\n"
        "from toys import effect, parameter, quantity\n"
        "from vibropipe.study import json_schema, table_of_keys\n"
        "from vibropipe.solve.rows.named import named\n"
        "from vibropipe.words.vocabulary import physical_attributes\n"
        "from vibropipe.solve.design.tolerance import SPREAD\n"
        "name = named('impact_difference', 'target')\n"
        "print(json.dumps([json.dumps(json_schema()), table_of_keys(), name.is_never_negative,\n"
        "                  physical_attributes('impact_difference')['units'], SPREAD]))\n"
    )
    schema, table, is_never_negative, units, spread = printed(script, tmp_path)
    assert "Share of the restitutions that wear has taken (0)." in schema
    assert "impact_difference" in schema
    assert "Share of the restitutions that wear has taken (0)." in table
    assert (is_never_negative, units) == (False, "m s-1")
    assert "impact_difference" in spread


def test_a_parameter_acts_once_on_copies_and_on_numbers(tmp_path):
    script = (
        "import json, pickle\n"
        "from dataclasses import replace\n"
        "from toys import effect, parameter, quantity\n"
        "import vibropipe as vp\n"
        "from vibropipe.physics.exciter import Exciter\n"
        "worn = vp.Exciter(l=1.0, R1=0.5, wear=0.5)\n"
        "copies = worn, replace(worn, nu=2.0), pickle.loads(pickle.dumps(worn)), worn.mirrored().mirrored()\n"
        "again = Exciter(**worn.parameters()._asdict())\n"
        "print(json.dumps([[e.R1 for e in (*copies, again)], [e.stated()['R1'] for e in copies],\n"
        "                  [e.wear for e in (*copies, again)], replace(worn, wear=0.0).R1,\n"
        "                  worn == copies[2], worn.numbers().R1, worn.parameters().wear]))\n"
    )
    assert printed(script, tmp_path) == [
        [0.25] * 5, [0.5] * 4, [0.5] * 4 + [0.0], 0.5, True, 0.5, 0.0,
    ]  # fmt: skip


def test_orbits_are_followed_along_a_parameter_that_acts_through_others(tmp_path):
    script = (
        "import json\n"
        "import numpy as np\n"
        "from toys import effect, parameter, quantity\n"
        "import vibropipe as vp\n"
        "given = {'l': 0.5, 'delta': 0.1, 'nu': 1.2, 'f': 0.8, 'h': 0.1}\n"
        "worn = vp.Exciter(**given, R1=0.7, R2=0.6, wear=0.1)\n"
        "branch = vp.branch(worn, 'wear', (0.0, 0.4), at=[0.05, 0.3])\n"
        "print(json.dumps([[float(p.wear), float(p.displacement_strobe), float(p.velocity_strobe)]\n"
        "                  for p in (branch.isel(point=n) for n in range(branch.sizes['point']))\n"
        "                  if float(p.wear) in (0.05, 0.3) and p.stable]))\n"
    )
    points = printed(script, tmp_path)
    assert [wear for wear, _x, _v in points] == [0.05, 0.3]
    for wear, x, v in points:
        given = {"l": 0.5, "delta": 0.1, "nu": 1.2, "f": 0.8, "h": 0.1}
        exciter = vp.Exciter(**given, R1=0.7 * (1.0 - wear), R2=0.6 * (1.0 - wear))
        settled = vp.steady_state(exciter, x, v)
        np.testing.assert_allclose(settled["displacement_strobe"], x, atol=1e-11)
        np.testing.assert_allclose(settled["velocity_strobe"], v, atol=1e-11)


def test_without_the_folder_neither_is_known(tmp_path):
    tmp_path.joinpath("toy.yaml").write_text(STUDY)
    done = subprocess.run(
        ["vibropipe", "plan", "toy.yaml"], cwd=tmp_path, capture_output=True,
        text=True, check=False,
    )  # fmt: skip
    assert done.returncode != 0
    assert "wear: is an unknown key" in done.stderr
