"""Every choice of outputs is solved, drawn and reported; where nothing is to be drawn, words say why."""

import json
from itertools import combinations

import numpy as np
import pytest
from drawing import caption, draw
from figures.figure_text import words
from sampling import sampled

from vibropipe.jobs.drawing import draw_study
from vibropipe.jobs.report_data import report_data
from vibropipe.jobs.reporting import build_report
from vibropipe.jobs.solving import solve_to_file
from vibropipe.report.exciter import said_beside
from vibropipe.scenes.motion.report import steady_tables
from vibropipe.store import load
from vibropipe.study import parse_study

OUTPUTS = ("harmonics", "impacts", "motion", "stability", "energy")
SUBSETS = [list(part) for size in range(1, 6) for part in combinations(OUTPUTS, size)]
# each makes another picture: with nothing to draw, impacts, samples or averages, all, further ones
FEW = [
    ["energy"],
    ["impacts"],
    ["motion"],
    ["harmonics"],
    list(OUTPUTS),
    ["subharmonics", "poincare"],
]

FORCED = {"nu": 1, "f": -1, "h": 0.2, "R1": 0.7, "R2": 0.7}
NEWMARK = {"method": "newmark", "steps_per_period": 100}
MOTIONS = {
    "exact": {"exciter": FORCED},
    "newmark": {"exciter": FORCED, "solver": NEWMARK},
    "accurate": {"exciter": FORCED, "solver": {"accuracy": 1e-4}},
    "settled": {"exciter": FORCED, "settle_periods": 3},
    "unsampled": {"exciter": FORCED, "samples_per_period": 0},
    "two_samples": {"exciter": FORCED, "samples_per_period": 1, "tau_end": 3},
    "unstruck": {"exciter": FORCED | {"l": 50}},
    "free": {"start": {"v0": 1}},
    "still": {},
    "resting": {"exciter": {"nu": 0.1, "f": -1, "h": 0.2, "R1": 0, "R2": 0}, "tau_end": 70},
}
RANGE = {"start": 0.5, "stop": 1.5, "points": 8}
SWEEPS = {
    "one": {"over": {"nu": [0.8, 1, 1.2]}},
    "point": {"over": {"nu": [1]}},
    "two": {"over": {"nu": [0.8, 1, 1.2], "delta": [0, 0.01]}},
    "three": {"over": {"nu": [0.8, 1.2], "delta": [0, 0.01], "R1": [0, 0.5, 1]}},
    "far_and_near": {"over": {"l": [0.2, 30]}},
    "unstruck": {"over": {"nu": [3.0, 3.2]}},
    "followed": {"over": {"nu": [1, 1.2], "f": [1, 2]}, "follow": {"along": "nu", "direction": "up"}},
    "accurate": {"over": {"nu": [1, 1.2]}, "solver": {"accuracy": 1e-6}},
    "map": {"over": {"nu": RANGE, "f": RANGE}},
    "bands": {"over": {"nu": RANGE, "f": RANGE, "R1": [0.5, 0.6]}},
}  # fmt: skip


def motions(variants, subsets):
    """Return scenes, one for each variant and subset, named by both."""
    return {
        f"{name}_{'_'.join(part)}": {"kind": "motion", "tau_end": 8, **keys, "outputs": part}
        for name, keys in variants.items()
        for part in subsets
    }


def sweeps(variants, subsets):
    return {
        f"{name}_{'_'.join(part)}": {
            "kind": "sweep",
            **keys,
            "exciter": {k: v for k, v in FORCED.items() if k not in keys["over"]}
            | keys.get("exciter", {}),
            "outputs": part,
        }
        for name, keys in variants.items()
        for part in subsets
    }


def solved(scenes, folder):
    """Return a study of these scenes and its datasets, solved into ``folder``."""
    tree = {"title": "T", "scenes": scenes}
    for scene in scenes.values():
        if "l" not in scene.get("over", {}):
            scene["exciter"] = {"l": 0.5} | scene.get("exciter", {})
    file = folder / "mine.yaml"
    file.write_text(json.dumps(tree), encoding="utf-8")
    study = parse_study(tree, name="mine", source=str(file))
    for name in scenes:
        solve_to_file(study, name, folder / "mine" / f"{name}.nc", None, threads=1)
    return study, {name: load(folder / "mine" / f"{name}.nc") for name in scenes}


def alone(study, name):
    """Return the study with one of its scenes."""
    return study.model_copy(update={"scenes": {name: study.scenes[name]}})


@pytest.mark.parametrize("scenes", [motions, sweeps])
@pytest.mark.parametrize("subsets", sampled(["some", "all"]))
def test_every_subset_of_outputs_is_solved_and_reported(scenes, subsets, tmp_path):
    first = {motions: "exact", sweeps: "two"}[scenes]
    variants = {motions: MOTIONS, sweeps: SWEEPS}[scenes]
    chosen = SUBSETS if subsets == "all" else SUBSETS[::4]
    study, datasets = solved(scenes({first: variants[first]}, chosen), tmp_path)
    assert len(datasets) == len(chosen)
    for name, dataset in datasets.items():
        data = report_data(alone(study, name), {name: dataset}, {})
        json.dumps(data, allow_nan=False)
        entry = data["hero"]
        whole = caption(study.scenes[name], dataset, datasets)
        # The parameters stand beside the exciter.
        assert entry["caption"] == said_beside(whole, dataset, {name: dataset}) != ""


def draw_and_report(scenes, folder):
    study, datasets = solved(scenes, folder)
    drawn = draw_study(study, folder)
    assert len(drawn) == 2 * len(scenes)
    pdf = build_report(study, folder, folder / "report.pdf")
    assert pdf.read_bytes().startswith(b"%PDF-")
    return study, datasets


@pytest.mark.slow
def test_few_subsets_are_drawn_and_typeset(tmp_path):
    draw_and_report(
        {
            **motions({"exact": MOTIONS["exact"]}, [part for part in FEW if part != ["harmonics"]]),
            **motions({k: MOTIONS[k] for k in ("newmark", "unsampled")}, [["motion"]]),
            **sweeps({"one": SWEEPS["one"]}, [part for part in FEW if part != ["motion"]]),
            **sweeps({k: SWEEPS[k] for k in ("unstruck", "map")}, [["impacts"]]),
        },
        tmp_path,
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("scenes", "variants", "name"),
    [*((motions, MOTIONS, name) for name in MOTIONS), *((sweeps, SWEEPS, name) for name in SWEEPS)],
)
def test_every_subset_is_drawn_and_typeset(scenes, variants, name, tmp_path):
    draw_and_report(scenes({name: variants[name]}, SUBSETS), tmp_path)


@pytest.mark.parametrize(
    ("variant", "outputs", "said"),
    [
        ("exact", ["energy"], ["add motion to outputs", "add impacts to outputs"]),
        ("exact", ["stability", "harmonics"], ["add motion to outputs", "add impacts to outputs"]),
        ("unsampled", ["motion"], ["samples_per_period above 0", "add impacts to outputs"]),
        ("unstruck", ["impacts"], ["add motion to outputs", "No support is struck"]),
    ],
)
def test_a_motion_without_anything_to_draw_says_what_is_not_stored(
    variant, outputs, said, tmp_path
):
    study, datasets = solved(motions({variant: MOTIONS[variant]}, [outputs]), tmp_path)
    ((name, dataset),) = datasets.items()
    figure = draw("motion", dataset)
    for text in said:
        assert text in words(figure)
        assert text in caption(study.scenes[name], dataset, datasets)
    assert not any(ax.axison for ax in figure.axes)


def test_a_motion_without_its_impacts_is_drawn_and_its_caption_says_so(tmp_path):
    study, datasets = solved(motions({"exact": MOTIONS["exact"]}, [["motion"]]), tmp_path)
    ((name, dataset),) = datasets.items()
    assert "impact_tau" not in dataset
    assert [ax.get_ylabel() for ax in draw("motion", dataset).axes][1:] != []
    said = caption(study.scenes[name], dataset, datasets)
    assert said.count(" Impacts are not stored: add impacts to outputs. ") == 1
    assert said.endswith("R₁ = 0.7, R₂ = 0.7.")


def test_grazings_alone_are_drawn(tmp_path):
    keys = {"exciter": {"l": 1}, "start": {"v0": 1}, "tau_end": 13, "samples_per_period": 0}
    _, datasets = solved(motions({"grazing": keys}, [["impacts"]]), tmp_path)
    (dataset,) = datasets.values()
    assert dataset.sizes["impact"] == 0 < dataset.sizes["grazing"]
    figure = draw("motion", dataset)
    rings = [line for ax in figure.axes for line in ax.lines if line.get_marker() == "o"]
    assert np.array_equal(rings[0].get_xdata(), dataset["grazing_tau"].values)
    assert f"{dataset.sizes['grazing']} grazing" in words(figure)


def test_a_sweep_that_strikes_nothing_says_so(tmp_path):
    _, datasets = solved(sweeps({"unstruck": SWEEPS["unstruck"]}, [["impacts"]]), tmp_path)
    said = words(draw("sweep", next(iter(datasets.values()))))
    assert "No support is struck" in said


def test_a_sweep_without_curves_has_no_legend_of_them(tmp_path):
    study, datasets = solved(sweeps({"two": SWEEPS["two"]}, [["stability"]]), tmp_path)
    ((name, dataset),) = datasets.items()
    dataset["period_multiple"][:] = 2
    said = words(draw("sweep", dataset))
    assert "both supports struck" in said
    assert "m>1" not in said
    text = caption(study.scenes[name], dataset, datasets)
    assert "outputs include neither harmonics nor impacts" in text
    assert "a stable orbit of several forcing periods" in text
    assert "(circles)" not in text
    dataset["stable"][0] = 0  # two rows, neutral as without damping
    dataset["floquet_multiplier"][0] = 1.0
    text = caption(study.scenes[name], dataset, datasets)
    assert "an orbit of several forcing periods" in text
    assert "2 are neutral" in text


def test_a_sweep_of_impacts_alone_is_described_by_the_largest_velocities(tmp_path):
    study, datasets = solved(sweeps({"one": SWEEPS["one"]}, [["impacts"]]), tmp_path)
    ((name, dataset),) = datasets.items()
    largest = dataset["impact_velocity_max"]
    assert float(largest.sel(support=2).max()) == float(largest.max())
    leads = [answer["lead"] for answer in report_data(alone(study, name), datasets, {})["answers"]]
    assert (
        f"From rest, the hardest impact of an orbit is {float(largest.max()):.3g}, on support 2."
        in leads
    )


@pytest.mark.slow
def test_motions_at_rest_in_the_middle_stand_in_the_table(tmp_path):
    """Their first harmonic is 0."""
    subsets = [["stability"], ["energy"]]
    _, datasets = solved(motions({"still": MOTIONS["still"]}, subsets), tmp_path)
    (table,) = steady_tables(datasets)
    assert len(table.rows) == 2
    assert "All motions are" in table.note
