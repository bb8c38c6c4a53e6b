"""Summary of a dataset as text, its provenance, and a filter and a table of a lazily opened scene."""

import json
import subprocess
from collections.abc import Iterator
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from store_datasets import motion, rows_of_sweep, shard

import vibropipe as vp
from vibropipe import store
from vibropipe.compiler import kernel_hash
from vibropipe.store import StoreError, save
from vibropipe.store.origin import _commit_of, _git_commit
from vibropipe.store.show import plain_symbol
from vibropipe.words.regimes import Regime
from vibropipe.words.vocabulary import VOCABULARY


@pytest.mark.parametrize(
    ("symbol", "plain"),
    [
        (r"$x$", "x"),
        (r"$\nu$", "ν"),
        (r"$\tau_{rest}$", "τ_rest"),
        (r"$\dot{x}_1^-/l$", "x\u0307_1^-/l"),
        (r"$\bar{\dot{x}}$", "x\u0307\u0304"),
        (r"$\bar{\omega}$", "ω\u0304"),
        (r"$\Delta W$", "ΔW"),
        ("regime", "regime"),
    ],
)
def test_symbols_in_plain_text(symbol, plain):
    assert plain_symbol(symbol) == plain


def test_every_symbol_has_a_plain_form():
    for name, entry in VOCABULARY.items():
        assert not set(plain_symbol(entry.symbol)) & set("\\{}$"), name


def test_a_summary_lists_sizes_quantities_and_regimes():
    values = rows_of_sweep(40)
    values["regime"][:] = [Regime.TWO_SIDED] * 30 + [Regime.APERIODIC] * 10
    lines = store.summary(shard(values, 0, 40)).splitlines()
    assert "Response" in lines
    assert "  row: 40" in lines
    assert "  two_sided: 30 (75.0%)" in lines
    assert "  aperiodic: 10 (25.0%)" in lines
    assert "  kernel_hash: 0123456789abcdef" in lines
    quantity = next(line.split() for line in lines if line.startswith("  h "))
    assert quantity == ["h", "h", "0.2", "damping"]
    assert any(line.endswith("mean displacement") for line in lines)


def test_a_range_is_of_finite_values():
    text = store.summary(motion())
    assert "inf" not in next(line for line in text.splitlines() if " rest_end(" in line)[:60]
    mean = xr.Dataset({"residual": ("row", [np.nan, 2.0, -1.0, np.inf])})
    assert "-1 ... 2" in store.summary(mean)
    assert next(line.split() for line in text.splitlines() if " grazing_tau(" in line)[2] == "none"
    assert "none finite" in store.summary(xr.Dataset({"residual": ("row", [np.nan])}))


def test_a_summary_is_short_whatever_the_study():
    text = store.summary(
        xr.Dataset(attrs={"study": "title: A\n" * 500, "versions": '{"numba": "1"}'})
    )
    assert "study: 500 lines: title: A ..." in text
    assert "versions: numba 1" in text


def test_the_summary_of_an_empty_dataset_is_a_line():
    assert store.summary(xr.Dataset()) == "\n"


def test_provenance_suffices_to_recompute_a_dataset():
    text = "title: ν\n"
    attrs = store.provenance(text, "abc", "exact", accuracy_asked=1e-8)
    assert attrs["study"] == text
    assert attrs["fingerprint"] == "abc"
    assert attrs["kernel_hash"] == kernel_hash()
    assert attrs["accuracy_asked"] == 1e-8
    assert attrs["accuracy_reached"] == "none"
    assert len(attrs["study_hash"]) == 64
    assert json.loads(attrs["versions"])["numba"] == version("numba")
    assert attrs["machine"]


def test_provenance_is_the_same_each_time_and_survives_the_file(tmp_path):
    attrs = store.provenance("title: ν\n", "abc", "exact")
    assert attrs == store.provenance("title: ν\n", "abc", "exact")
    store.save(xr.Dataset({"residual": 0.0}, attrs=attrs), tmp_path / "a.nc")
    read = store.load(tmp_path / "a.nc").attrs
    assert read.pop("Conventions")
    assert read == attrs


def test_another_study_has_another_hash():
    first = store.provenance("a: 1", "x", "exact")["study_hash"]
    assert store.provenance("a: 2", "x", "exact")["study_hash"] != first


def test_the_commit_of_a_checkout_is_marked_when_changed(tmp_path):
    def git(*words):
        identity = ("-c", "user.name=a", "-c", "user.email=a@b", "-c", "core.hooksPath=/dev/null")
        command = ["git", "-C", str(tmp_path), *identity, *words]
        return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()

    assert _git_commit(str(tmp_path / "absent")) == "unknown"
    git("init", "-q")
    (tmp_path / "a").write_text("1")
    git("add", "a")
    git("commit", "-q", "-m", "one")
    commit = git("rev-parse", "HEAD")
    assert _git_commit(str(tmp_path)) == commit
    _git_commit.cache_clear()
    (tmp_path / "a").write_text("2")
    assert _git_commit(str(tmp_path)) == f"{commit}-dirty"


def test_the_commit_is_that_of_the_program_in_its_clone_alone(tmp_path):
    installed = tmp_path / "study" / "env" / "site-packages" / "vibropipe"
    installed.mkdir(parents=True)
    subprocess.run(["git", "init", "-q", str(tmp_path / "study")], check=True)
    (tmp_path / "study" / "a.yaml").touch()
    identity = ("-c", "user.name=a", "-c", "user.email=a@b", "-c", "core.hooksPath=/dev/null")
    for words in (("add", "."), ("commit", "-q", "-m", "one")):
        subprocess.run(["git", "-C", str(tmp_path / "study"), *identity, *words], check=True)
    assert _commit_of(installed) == "unknown"
    assert _commit_of(tmp_path / "study" / "vibropipe") != "unknown"


def test_the_folder_of_the_study_is_no_part_of_the_provenance(tmp_path, monkeypatch):
    here = store.provenance("a: 1", "x", "exact")["git_commit"]
    monkeypatch.chdir(tmp_path)
    assert store.provenance("a: 1", "x", "exact")["git_commit"] == here


def test_times_and_hosts_go_to_a_sidecar(tmp_path):
    path = tmp_path / "paper" / "response.nc"
    assert store.read_sidecar(path) == {}
    store.write_sidecar(path, seconds=2.5, threads=2, rows=40)
    record = store.read_sidecar(path)
    assert (record["seconds"], record["threads"], record["rows"]) == (2.5, 2, 40)
    assert record["host"]
    assert [item.name for item in path.parent.iterdir()] == ["response.json"]


@pytest.mark.parametrize("content", ["{", "[1]", ""])
def test_a_broken_sidecar_is_named(tmp_path, content):
    (tmp_path / "a.json").write_text(content)
    with pytest.raises(StoreError, match=r"a\.json: .*: delete it"):
        store.read_sidecar(tmp_path / "a.nc")


EXCITER = vp.Exciter(l=0.5, nu=1.0, f=-1, h=0.2, R1=0.7, R2=0.7)
OVER = {"nu": [0.6, 1.0, 1.7, 2.9], "f": [0.02, 0.5, 1.0]}


@pytest.fixture(scope="module")
def sweep() -> xr.Dataset:
    return vp.sweep(EXCITER, OVER, harmonics=2)


@pytest.fixture
def node(sweep: xr.Dataset, tmp_path: Path) -> Iterator[xr.DataTree]:
    save(sweep, tmp_path / "map.nc")
    with vp.open_study(tmp_path) as tree:
        yield tree["map"]


def test_a_condition_on_points_leaves_impacts_out(node: xr.DataTree, sweep: xr.Dataset) -> None:
    stored, is_two_sided = sweep.drop_dims("impact"), sweep.regime == Regime.TWO_SIDED
    expected = stored.where(is_two_sided, drop=True)
    assert expected.sizes["f"] < sweep.sizes["f"]
    selected = node.where(node.regime == Regime.TWO_SIDED, drop=True)
    assert all(values.chunks is not None for values in selected.data_vars.values())
    xr.testing.assert_equal(selected.load(), expected)
    masked = node.where(node.regime == Regime.TWO_SIDED)
    assert masked.regime.dims == ("nu", "f")
    xr.testing.assert_equal(masked.load(), stored.where(is_two_sided))


def test_a_condition_on_impacts_selects_impacts(node: xr.DataTree, sweep: xr.Dataset) -> None:
    hard = np.abs(sweep.impact_velocity.values) > 0.8
    assert 0 < hard.sum() < hard.size
    selected = node.where(abs(node.impact_velocity) > 0.8, drop=True)
    assert set(selected.dims) == {"impact"}
    np.testing.assert_array_equal(selected.impact_velocity, sweep.impact_velocity.values[hard])


def test_a_node_becomes_the_table_of_its_points(node: xr.DataTree, sweep: xr.Dataset) -> None:
    pd.testing.assert_frame_equal(node.to_dataframe(), vp.table(sweep))
    part = node.isel(nu=1).sel(f=0.5)
    assert float(part.base_frequency) == 1.0
