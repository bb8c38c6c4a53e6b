"""`figure: {show: [...]}` of the kinds without quantities of motions: what is drawn, written, and refused."""

import re

import numpy as np
import pytest
import xarray as xr
from drawing import draw, picture_of
from figures.figure_text import words
from figures.sample_datasets import hard_cases, sweep
from pydantic import ValidationError

from vibropipe.lab.hard_cases import solvers
from vibropipe.scenes.accuracy.keys import AccuracyFigure
from vibropipe.scenes.boundary.keys import BoundaryFigure
from vibropipe.scenes.hard_cases.keys import HardCasesFigure
from vibropipe.scenes.sweep.figure_keys import SweepFigure
from vibropipe.study import StudyError, study_of_text
from vibropipe.words.quantities import FLAGS
from vibropipe.words.vocabulary import describe

MOTION = "motions: {full: {periods: 1}}"
OVER = "over: {x0: [0.1], v0: [0.1]}"


@pytest.mark.parametrize(
    ("scene", "allowed"),
    [
        (f"kind: accuracy, {MOTION}", "one of error_end, error_impact_tau, error_impact_velocity, error_harmonics"),
        ("kind: hard_cases", "one of exact, newmark 8, newmark 60, newmark 2000"),
        (f"kind: basins, {OVER}", "attractor or periods_to_attractor"),
        ("kind: boundary, of: [fold], over: {nu: [1, 2], f: [0.1, 1]}", "one of grazing, fold, flip, pitchfork, level"),
    ],
)  # fmt: skip
def test_an_unknown_name_is_refused_with_the_list(scene, allowed):
    text = f"title: T\nexciter: {{l: 0.5}}\nscenes:\n  s: {{{scene}, figure: {{show: [size]}}}}\n"
    message = f"scenes.s.figure.show[0]: must be {allowed}, got 'size'"
    with pytest.raises(StudyError, match=re.escape(message)):
        study_of_text(text, "s")


def test_a_kind_of_boundary_that_is_not_sought_is_refused():
    keys = "kind: boundary, of: [fold, flip], over: {nu: [1, 2], f: [0.1, 1]}"
    text = f"title: T\nexciter: {{l: 0.5}}\nscenes:\n  s: {{{keys}, figure: {{show: [grazing]}}}}\n"
    with pytest.raises(StudyError, match=r"figure.show: must be .*\(fold, flip\), got 'grazing'"):
        study_of_text(text, "s")


SOFT = "k1: 20, h1: 0.2"
SWEEP = "kind: sweep, over: {nu: [1, 2]}, outputs: [impacts]"
BRANCH = "kind: branch, along: {nu: {from: 1, to: 2}}"


@pytest.mark.parametrize("keys", [SWEEP, BRANCH], ids=["sweep", "branch"])
def test_forces_of_rigid_supports_are_refused(keys):
    show = "figure: {show: [support_force_max]}"
    text = f"title: T\nexciter: {{l: 0.5, {SOFT}}}\nscenes:\n  s: {{{keys}, {show}}}\n"
    assert study_of_text(text, "s").scenes["s"].figure.show == ["support_force_max"]
    with pytest.raises(StudyError, match=r"figure.show: must leave out support_force_max unless"):
        study_of_text(text.replace(SOFT, "h: 0.1"), "s")


def test_forces_are_drawn_in_curves_and_maps():
    dataset = sweep(12)
    force = 10.0 * dataset["impact_velocity_max"]
    dataset = describe(dataset.assign(support_force_max=force.drop_attrs()))
    figure = draw("sweep", dataset, SweepFigure(show=["support_force_max"]))
    assert "largest force of the support $\\max F_c$" in words(figure)
    finite = force.sel(support=1).values
    drawn = np.concatenate([line.get_ydata() for line in figure.axes[0].lines])
    assert np.isclose(drawn[:, None], finite[np.isfinite(finite)]).any()


def test_a_name_stands_once():
    with pytest.raises(ValidationError):
        HardCasesFigure(show=["exact", "exact"])


def test_the_solvers_of_hard_cases_can_be_shown():
    names = [solver.name for solver in solvers()]
    assert HardCasesFigure(show=names).show == names


def test_hard_cases_of_one_solver():
    options = HardCasesFigure(show=["newmark 8"])
    figure = draw("hard_cases", hard_cases(), options)
    written = [text.get_text() for text in figure.axes[0].texts]
    assert written == ["Newmark, 8 steps"]
    caption = picture_of("hard_cases", hard_cases()).describe(hard_cases(), options, {})
    assert "Cross: grazing free exceeds its bound" in caption


def test_the_error_to_show_is_drawn_alone(work_precision):
    steps = work_precision["setting_value"].values[1]
    work_precision["error_harmonics"][:, 1] = 7e-2 / steps**3
    work_precision["error_harmonics"][1] = np.nan
    options = AccuracyFigure(show=["error_harmonics"])
    figure = draw("accuracy", work_precision, options)
    drawn = [line.get_xdata() for line in figure.axes[0].lines if len(line.get_xdata()) == 3]
    assert any(np.allclose(x, 7e-2 / steps**3) for x in drawn)
    caption = picture_of("accuracy", work_precision).describe(work_precision, options, {})
    assert "Error: of harmonics, against a solution of 40 digits." in caption
    assert "Left out, without this error: with chatter." in caption


def test_the_largest_of_several_errors_is_named(work_precision):
    options = AccuracyFigure(show=["error_end", "error_impact_tau"])
    caption = picture_of("accuracy", work_precision).describe(work_precision, options, {})
    assert "Error: the largest of end state and impact times" in caption


def boundaries() -> xr.Dataset:
    """Return a curve of grazings and one of folds, which meet."""
    kinds = FLAGS["boundary_kind"]
    dataset = xr.Dataset(
        {
            "curve_id": ("point", [0, 0, 1, 1]),
            "boundary_kind": ("point", np.repeat([kinds["grazing"], kinds["fold"]], 2)),
            "stable": ("point", [1, 1, 0, 0]),
            "meeting_kind": ("meeting", [FLAGS["meeting_kind"]["grazing_fold"]]),
            "meeting_point": ("meeting", [1]),
        },
        {
            "nu": ("point", [1.0, 1.2, 1.2, 1.5]), "f": ("point", [0.1, 0.2, 0.2, 0.3]),
            "meeting_nu": ("meeting", [1.2]), "meeting_f": ("meeting", [0.2]),
        },
        {"boundary": "nu f"},
    )  # fmt: skip
    return describe(dataset)


def test_one_kind_of_boundary():
    dataset, options = boundaries(), BoundaryFigure(show=["fold"])
    figure = draw("boundary", dataset, options)
    assert figure.legends[0].get_texts()[0].get_text() == "fold"
    assert figure.axes[0].get_xlim() == (1.0, 1.5)
    assert [list(line.get_xdata()) for line in figure.axes[0].lines] == [[1.2, 1.5], []]
    caption = picture_of("boundary", dataset).describe(dataset, options, {})
    assert "Not drawn: grazing." in caption
    assert "curves meet" not in caption.lower()
    whole = picture_of("boundary", dataset).describe(dataset, None, {})
    assert "Not drawn" not in whole
    assert "Circles: curves meet" in whole
