"""Pictures of every kind: whole files, the same to the byte, legible, and nothing left out."""

from itertools import combinations, pairwise

import numpy as np
import pytest
from drawing import draw
from figures.figure_text import texts, words
from matplotlib import rcParams, style
from sampling import sampled

from vibropipe.figures.canvas import CM_PER_INCH, SMALL, WIDE
from vibropipe.figures.text import plain_value
from vibropipe.jobs.drawing import draw_scene
from vibropipe.scenes.backbone.curves import parts
from vibropipe.scenes.backbone.keys import BackboneFigure
from vibropipe.scenes.motion.keys import MotionFigure
from vibropipe.scenes.sweep.captions import describe_map, describe_sweep
from vibropipe.scenes.sweep.keys import SweepFigure
from vibropipe.scenes.sweep.pictures import PICTURES
from vibropipe.words.regimes import Regime
from vibropipe.words.vocabulary import label, quantity

NAMES = [
    "forced",
    "impacts",
    "conservative",
    "law",
    "free_0",
    "free_1",
    "hard",
    "line",
    "lines",
    "columns",
    "map",
    "bands",
]


@pytest.mark.parametrize("name", sampled(NAMES, "forced", "free_0", "lines"))
def test_files_are_whole_and_the_same_to_the_byte(name, study, made, tmp_path):
    others = {scene: dataset for scene, (_, dataset) in made.items()}
    first = draw_scene(study.scenes[name], made[name][1], tmp_path / "a", others)
    second = draw_scene(study.scenes[name], made[name][1], tmp_path / "b", others)
    assert [path.name for path in first] == [f"{name}.svg", f"{name}.pdf"]
    for one, two in zip(first, second, strict=True):
        assert one.read_bytes() == two.read_bytes()
    assert first[0].read_bytes().lstrip().startswith(b"<?xml")
    assert first[1].read_bytes().startswith(b"%PDF-")
    assert sorted(path.name for path in (tmp_path / "a").iterdir()) == sorted(
        path.name for path in first
    )


@pytest.mark.parametrize("name", NAMES)
def test_nothing_overlaps_and_nothing_sticks_out(name, figures):
    figure = figures[name]
    boxes = [(text.get_text(), text.get_window_extent().padded(-1.0)) for text in texts(figure)]
    touching = [
        (one, other)
        for (one, box), (other, second) in combinations(boxes, 2)
        if box.width > 0 and second.width > 0 and box.overlaps(second)
    ]
    assert not touching
    width, height = figure.get_window_extent().size
    for text, box in boxes:
        assert min(box.x0, box.y0) >= -1, text
        assert box.x1 <= width + 1, text
        assert box.y1 <= height + 1, text


@pytest.mark.parametrize("name", NAMES)
def test_print_width_and_size_of_letters(name, figures):
    assert figures[name].get_figwidth() * CM_PER_INCH == pytest.approx(WIDE)
    assert min(text.get_fontsize() for text in texts(figures[name])) >= SMALL


@pytest.mark.parametrize(
    ("name", "quantities"),
    [
        ("forced", ["tau", "force", "displacement", "velocity"]),
        ("conservative", ["tau", "displacement", "velocity"]),
        ("law", ["tau_bar", "omega_bar", "velocity_over_l", "delta_over_l"]),
        ("free_1", ["eigenfrequency", "displacement_mean"]),
        ("lines", ["nu", "f"]),
        ("columns", ["nu", "f", "delta"]),
        ("map", ["nu", "f"]),
    ],
)
def test_symbols_of_the_vocabulary_are_on_the_picture(name, quantities, figures):
    for each in quantities:
        assert quantity(each).symbol in words(figures[name])


def test_symbols_of_chosen_quantities_and_of_maps_of_quantities_are_on_the_picture(made):
    mean = quantity("displacement_mean").symbol
    assert mean in words(draw("sweep", made["lines"][1], SweepFigure(show=["displacement_mean"])))
    (of_map,) = (picture for picture in PICTURES if picture.name == "quantities")
    quantities = words(of_map.draw(made["map"][1], SweepFigure(), {}))
    assert mean in quantities
    assert "largest velocity before impact, either support" in quantities


@pytest.mark.parametrize("name", ["lines", "map"])
def test_captions_of_sweeps_have_the_parameters_of_all_rows(made, name):
    dataset = made[name][1]
    describe = describe_map if name == "map" else describe_sweep
    for parameter in ("h", "l", "R1"):
        assert plain_value(dataset[parameter]) in describe(dataset)


def test_parts_of_a_curve_join(made):
    regime = made["free_1"][1]["regime"].values
    pieces = [piece for _, piece in parts(regime)]
    assert [code for code, _ in parts(regime)] == [
        Regime.NO_IMPACT, Regime.ONE_SIDED_2, Regime.TWO_SIDED,
    ]  # fmt: skip
    assert pieces[0].start == 0
    assert pieces[-1].stop == regime.size
    assert all(after.start == before.stop - 1 for before, after in pairwise(pieces))


def test_harmonics_that_vanish_are_not_drawn(made, figures):
    labels = [ax.get_ylabel().partition("\n")[0] for ax in figures["free_0"].axes]
    assert sorted({*labels}) == ["first harmonic", "third harmonic"]
    alone = draw("backbone", made["free_0"][1], BackboneFigure(show=["velocity_mean"]))
    assert np.ptp(alone.axes[0].get_ylim()) > 1e-3


def test_a_backbone_that_is_not_at_hand_is_named(made):
    others = {"free": made["free_1"][1]}
    with pytest.raises(
        KeyError, match=r"backbone: must be a scene of the study \(free\), got 'fre'"
    ):
        draw("sweep", made["line"][1], SweepFigure(backbone="fre"), others)


def test_chosen_panels_and_quantities_alone_are_drawn(made):
    panels = draw("motion", made["forced"][1], MotionFigure(show=["velocity", "force"]))
    assert [ax.get_ylabel() for ax in panels.axes] == [label("force"), label("velocity")]
    means = draw("sweep", made["line"][1], SweepFigure(show=["displacement_mean"]))
    (title,) = (text.get_text() for text in means.axes[0].texts)
    assert title == rf"mean displacement {quantity('displacement_mean').symbol}"
    assert len(means.axes) == 2
    assert "harmonic" not in words(means)


def test_chosen_quantities_of_a_backbone_alone_are_drawn(made):
    free = made["free_1"][1]
    options = BackboneFigure(show=["displacement_mean", "velocity_amplitude"])
    figure = draw("backbone", free, options)
    names = [ax.get_ylabel().partition("\n")[0] for ax in figure.axes if ax.get_visible()]
    assert sorted(names) == [
        "first harmonic",
        "mean displacement",
        "second harmonic",
        "third harmonic",
    ]
    law = draw("backbone", made["law"][1], BackboneFigure(show=["tau_bar"]))
    assert [ax.get_xlabel() for ax in law.axes] == [label("tau_bar")]


def test_a_study_may_choose_several_pictures(study, made, tmp_path):
    scene = study.scenes["columns"]
    scene.figure = SweepFigure(pictures=["curves", "map"])
    paths = draw_scene(scene, made["columns"][1], tmp_path, {})
    assert [path.name for path in paths] == [
        f"columns{part}{suffix}" for part in ("", "-map") for suffix in (".svg", ".pdf")
    ]


def test_drawing_leaves_the_settings_of_matplotlib_alone(made):
    with style.context("default"):
        before = dict(rcParams)
        draw("motion", made["forced"][1])
        assert dict(rcParams) == before
