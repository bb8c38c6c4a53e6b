"""A rerun computes only what has changed."""

import os
import time

TYPESETTING = {"typesetting the report", "everything is made"}
FIGURES = {"drawing free", "drawing forced", "drawing response", *TYPESETTING}
SCENES = {"solving free", "solving forced", "solving response"}


def test_a_shared_number_recomputes_the_scenes_that_use_it(project):
    project.edit("config/tiny.yaml", "f: -1,", "f: -0.9,")
    assert project.planned() == {"solving forced", "drawing forced", *TYPESETTING}


def test_edited_kernels_recompute_all(project):
    project.own_package()
    with project.path("vibropipe/march/loop.py").open("a") as source:
        source.write("# an edit\n")
    assert project.planned() == {*SCENES, *FIGURES}


def test_touched_files_comments_and_spelling_recompute_nothing(project):
    project.own_package()
    project.edit("config/tiny.yaml", "tau_end: 20", "tau_end: 2.0e1  # as long as it was")
    later = time.time() + 60
    for path in project.folder.rglob("*"):
        if path.is_file() and ".snakemake" not in path.parts:
            os.utime(path, (later, later))
    assert project.planned() == set()


def test_edited_figures_recompute_no_data(project):
    project.own_package()
    with project.path("vibropipe/figures/style.py").open("a") as source:
        source.write("# an edit\n")
    assert project.planned() == FIGURES
