"""Values added to the grids of a sweep: only new rows are solved, and the file is that of a sweep solved at once."""

import json
from pathlib import Path

import pytest

from vibropipe.jobs import solving
from vibropipe.jobs.earlier import earlier_file
from vibropipe.jobs.solving import join_to_file, solve_stale, solve_to_file
from vibropipe.scenes.sweep import solve as sweep_solve
from vibropipe.store import earlier_rows, origin, read_sidecar
from vibropipe.study import load_study
from vibropipe.words.outputs import OUTPUTS

NU, FINER = ({"start": 0.5, "stop": 1.5, "points": points} for points in (6, 11))
BEFORE = {"f": [0.2, 1], "nu": NU}
EXCITER = {"l": 0.5, "h": 0.2, "R1": 0.7, "R2": 0.6}
SOFT = {**EXCITER, "k1": 1000, "friction": 0.02}
SI = {
    "physical": {"m": "0.4 kg", "C": "900 N/m", "H": "3 N s/m", "l": "5 mm"},
    "exciter": {"R1": 0.7, "R2": 0.6},
}
IN_SI = {"F": ["2 N", "5 N"], "omega": {"start": "5 Hz", "stop": "10 Hz", "points": 5}}


def study_in(folder: Path, over: dict, head: dict | None = None, **keys: object):
    scene = {"kind": "sweep", "over": over, **keys}
    text = {"title": "t", "exciter": EXCITER, **(head or {}), "scenes": {"s": scene}}
    folder.mkdir(exist_ok=True)
    (folder / "t.yaml").write_text(json.dumps(text))
    return load_study(folder / "t.yaml")


@pytest.fixture
def solved_rows(monkeypatch):
    """Numbers of rows that are solved, one for each job."""
    numbers, solve = [], sweep_solve.solve_blocks

    def counted(grid, rows, *arguments, **options):
        numbers.append(len(rows))
        return solve(grid, rows, *arguments, **options)

    monkeypatch.setattr(sweep_solve, "solve_blocks", counted)
    return numbers


def made(study, folder: Path) -> bytes:
    """Solve the scene of a study unless it is up to date, and return its bytes."""
    assert solve_stale(study, ["s"], folder, None, 1) == []
    return (folder / "s.nc").read_bytes()


GROWN = {
    "a value": (BEFORE, {**BEFORE, "f": [0.2, 0.6, 1]}, {}, 6),
    "a last value": (BEFORE, {**BEFORE, "f": [0.2, 1, 1.5]}, {}, 6),
    "finer": (BEFORE, {**BEFORE, "nu": FINER}, {}, 10),
    "both": (BEFORE, {"f": [0.1, 0.2, 1], "nu": FINER}, {}, 33 - 12),
    "a value less": (BEFORE, {**BEFORE, "f": [1]}, {}, 1),
    "others": (BEFORE, {"f": [0.2, 0.6], "nu": NU}, {}, 6),
    "starts": ({**BEFORE, "x0": [0, 0.2]}, {**BEFORE, "x0": [0, 0.1, 0.2]}, {}, 12),
    "all outputs": (BEFORE, {**BEFORE, "nu": FINER}, {"outputs": list(OUTPUTS)}, 10),
    "an accuracy": (BEFORE, {**BEFORE, "nu": FINER}, {"solver": {"accuracy": 1e-6}}, 10),
    "in SI": (IN_SI, {**IN_SI, "F": ["2 N", "3 N", "5 N"]}, {"head": SI}, 5),
    "finer in SI": (IN_SI, {**IN_SI, "omega": IN_SI["omega"] | {"points": 9}}, {"head": SI}, 8),
    "pieces": (BEFORE, {**BEFORE, "f": [0.2, 0.6, 1]}, {"head": {"exciter": SOFT}}, 6),
}


@pytest.mark.parametrize(("before", "after", "keys", "new"), GROWN.values(), ids=GROWN)
def test_only_new_rows_are_solved_and_the_bytes_are_those_of_a_fresh_run(
    before, after, keys, new, tmp_path, solved_rows, capsys
):
    made(study_in(tmp_path, before, **keys), tmp_path / "t")
    study = study_in(tmp_path, after, **keys)
    bytes_of_fresh = made(study, tmp_path / "fresh")
    all_rows = study.scenes["s"].row_count
    solved_rows.clear()
    capsys.readouterr()
    assert made(study, tmp_path / "t") == bytes_of_fresh
    assert solved_rows == [new]
    told = f"s: {all_rows - new} of {all_rows} rows taken from the earlier result"
    assert told in capsys.readouterr().err
    assert read_sidecar(tmp_path / "t/s.nc")["taken"] == all_rows - new
    # and nothing is left of the earlier one
    assert sorted(path.name for path in (tmp_path / "t").rglob("*")) == ["s.json", "s.nc"]
    assert made(study, tmp_path / "t") == bytes_of_fresh
    assert solved_rows == [new]


@pytest.mark.parametrize("count", [1, 2, 5])
def test_shards_take_rows_as_well(count, tmp_path, solved_rows):
    target = tmp_path / "t/s.nc"
    made(study_in(tmp_path, BEFORE), target.parent)
    study = study_in(tmp_path, {"f": [0.2, 0.6, 1], "nu": FINER})
    fresh = made(study, tmp_path / "fresh")
    earlier_file(target).parent.mkdir(parents=True)
    target.rename(earlier_file(target))
    solved_rows.clear()
    shards = [earlier_file(target).with_name(f"{i:04d}.nc") for i in range(1, count + 1)]
    for number, path in enumerate(shards, 1):
        solve_to_file(study, "s", path, (number, count), 1, earlier=earlier_file(target))
    join_to_file(study, "s", shards, target)
    assert target.read_bytes() == fresh
    assert sum(solved_rows) == 33 - 12
    assert read_sidecar(target)["taken"] == 12
    assert not earlier_file(target).exists()


def test_one_file_may_be_added_to_again_and_again(tmp_path, solved_rows):
    values = [0.6, 0.8, 1, 1.2]
    for count in range(1, 5):
        made(study_in(tmp_path, {"f": values[:count], "nu": NU}), tmp_path / "t")
    assert solved_rows == [6, 6, 6, 6]
    fresh = made(study_in(tmp_path, {"f": values, "nu": NU}), tmp_path / "fresh")
    assert (tmp_path / "t/s.nc").read_bytes() == fresh


AFTER = {**BEFORE, "f": [0.2, 0.6, 1]}
NOT_TAKEN = {
    "a parameter": (AFTER, {"head": {"exciter": {**EXCITER, "h": 0.21}}}, "more than the values"),
    "an output": (AFTER, {"outputs": ["harmonics"]}, "more than the values"),
    "harmonics": (AFTER, {"harmonics": 4}, "more than the values"),
    "a start": (AFTER, {"start": {"v0": 0.1}}, "more than the values"),
    "an accuracy": (AFTER, {"solver": {"accuracy": 1e-6}}, "more than the values"),
    "patience": (AFTER, {"patience": 300}, "more than the values"),
    "another grid": ({**AFTER, "R1": [0.7, 0.8]}, {}, "more than the values"),
    "another order": (dict(reversed(AFTER.items())), {}, "more than the values"),
    "an effect": ({**BEFORE, "f": [0, 0.2, 1]}, {"effects": ["damping", "forcing"]}, "more than"),
}


@pytest.mark.parametrize(("after", "keys", "reason"), NOT_TAKEN.values(), ids=NOT_TAKEN)
def test_no_row_is_taken_where_more_has_changed(after, keys, reason, tmp_path, solved_rows, capsys):
    made(study_in(tmp_path, BEFORE), tmp_path / "t")
    study = study_in(tmp_path, after, **keys)
    solved_rows.clear()
    assert made(study, tmp_path / "t") == made(study, tmp_path / "fresh")
    assert solved_rows == [study.scenes["s"].row_count] * 2
    assert f"s: no row taken from the earlier result: {tmp_path}/t/s.nc: {reason}" in (
        capsys.readouterr().err
    )


def test_no_row_is_taken_from_another_kernel(tmp_path, solved_rows, capsys):
    """A wider range of forces reaches the supports, for which another kernel is compiled."""
    weak = {"f": [0.01], "nu": NU}
    made(study_in(tmp_path, weak), tmp_path / "t")
    study = study_in(tmp_path, {**weak, "f": [0.01, 1]})
    solved_rows.clear()
    assert made(study, tmp_path / "t") == made(study, tmp_path / "fresh")
    assert solved_rows == [12, 12]
    assert "other effects are computed with the values of its grids now" in capsys.readouterr().err


def test_a_followed_sweep_is_solved_as_a_whole(tmp_path, solved_rows):
    keys = {"follow": {"along": "nu", "direction": "up"}}
    made(study_in(tmp_path, BEFORE, **keys), tmp_path / "t")
    made(study_in(tmp_path, AFTER, **keys), tmp_path / "t")
    assert solved_rows == [12, 18]
    assert "taken" not in read_sidecar(tmp_path / "t/s.nc")


@pytest.mark.parametrize("what", ["kernels", "machine", "kind", "packages"])
def test_no_row_is_taken_from_another_version(what, tmp_path, monkeypatch, solved_rows, capsys):
    with monkeypatch.context() as other:
        if what == "kernels":
            for module in (origin, solving):
                other.setattr(module, "kernel_hash", lambda: "0" * 16)
        elif what == "machine":
            other.setattr(origin, "_machine", lambda: "abacus")
        elif what == "packages":
            other.setattr(origin, "_versions", lambda more=(): '{"numpy": "0.1"}')
        else:
            other.setattr(solving, "hash_name", lambda kind: "lab_hash")
        made(study_in(tmp_path, BEFORE), tmp_path / "t")
    study = study_in(tmp_path, AFTER)
    assert made(study, tmp_path / "t") == made(study, tmp_path / "fresh")
    assert solved_rows == [12, 18, 18]
    assert "s: no row taken from the earlier result" in capsys.readouterr().err


def test_a_damaged_file_is_told_and_no_row_is_taken(tmp_path, solved_rows, capsys):
    path = tmp_path / "t/s.nc"
    whole = made(study_in(tmp_path, BEFORE), path.parent)
    middle = len(whole) // 2
    path.write_bytes(whole[:middle] + bytes([whole[middle] ^ 1]) + whole[middle + 1 :])
    study = study_in(tmp_path, AFTER)
    assert made(study, path.parent) == made(study, tmp_path / "fresh")
    assert solved_rows == [12, 18, 18]
    reason = (
        f"no row taken from the earlier result: {path}: is damaged (its checksum does not match)"
    )
    assert f"s: {reason}\n" in capsys.readouterr().err
    assert read_sidecar(path)["not_taken"] == reason


def test_a_file_that_cannot_be_read_on_is_given_up(tmp_path, solved_rows, monkeypatch, capsys):
    made(study_in(tmp_path, BEFORE), tmp_path / "t")
    study = study_in(tmp_path, AFTER)

    def broken(*_):
        raise OSError("the disk is gone")

    monkeypatch.setattr(earlier_rows._Earlier, "_consecutive", broken)
    assert made(study, tmp_path / "t") == made(study, tmp_path / "fresh")
    assert solved_rows == [12, 6, 18, 18]
    assert "t/s.nc: cannot be read: the disk is gone" in capsys.readouterr().err


def test_an_interrupted_job_leaves_the_earlier_file(tmp_path, monkeypatch):
    before = made(study_in(tmp_path, BEFORE), tmp_path / "t")
    study = study_in(tmp_path, AFTER)

    def interrupted(*_):
        raise KeyboardInterrupt

    with monkeypatch.context() as now:
        now.setattr(earlier_rows._Earlier, "_consecutive", interrupted)
        with pytest.raises(KeyboardInterrupt):
            made(study, tmp_path / "t")
    assert (tmp_path / "t/s.nc").read_bytes() == before
    assert sorted(path.name for path in (tmp_path / "t").iterdir()) == ["s.json", "s.nc"]
    assert made(study, tmp_path / "t") == made(study, tmp_path / "fresh")
