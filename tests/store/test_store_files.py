"""Round trips through a file, the content of files, and studies opened lazily."""

import json
import os
import time

import netCDF4
import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st
from store_datasets import motion, rows_of_sweep, shard

import vibropipe as vp
from vibropipe import store
from vibropipe.store import StoreError
from vibropipe.store.atomic import scenes_of
from vibropipe.store.encoding import CHUNK_BYTES, chunk_shape
from vibropipe.words.vocabulary import VOCABULARY, describe


def written(dataset, folder, name="a.nc"):
    path = folder / name
    store.save(dataset, path)
    return path


def same(read, dataset):
    """Check values, types, dimensions and attributes; the read dataset may have more attributes."""
    xr.testing.assert_equal(read, dataset)
    assert set(read.variables) == set(dataset.variables)
    assert set(read.coords) == set(dataset.coords)
    for name, variable in dataset.variables.items():
        assert read[name].dtype == variable.dtype
        assert read[name].dims == variable.dims
        for key, value in variable.attrs.items():
            np.testing.assert_array_equal(read[name].attrs[key], value)


def test_round_trip_of_a_motion(tmp_path):
    dataset = motion()
    read = store.load(written(dataset, tmp_path))
    same(read, dataset)
    assert read["rest_end"].item() == np.inf
    assert read.attrs == {"Conventions": "CF-1.11"} | dataset.attrs


def test_a_study_whose_file_cannot_be_opened_is_said_to_be_damaged(tmp_path):
    path = written(motion(), tmp_path)
    content = bytearray(path.read_bytes())
    content[64:2000] = bytes(1936)  # of the same length, between signature and seal
    path.write_bytes(content)
    with pytest.raises(StoreError, match=r"a\.nc: is damaged \(its checksum does not match\)"):
        store.open_study(tmp_path)


def test_round_trip_of_a_shard_with_complex_multipliers(tmp_path):
    dataset = shard(rows_of_sweep(30), 4, 20, nu=1.0)
    read = store.load(written(dataset, tmp_path))
    same(read, dataset)
    assert read["floquet_multiplier"].dtype == np.complex128
    assert read["floquet_multiplier"].attrs == dataset["floquet_multiplier"].attrs
    assert (read.attrs["row_start"], read.attrs["row_stop"]) == (4, 20)


def test_an_infinite_imaginary_part_does_not_change_the_real_part(tmp_path):
    values = np.array([[complex(1, np.inf), complex(np.nan, -0.0)]])
    path = written(xr.Dataset({"floquet_multiplier": (("row", "multiplier"), values)}), tmp_path)
    read = store.load(path)["floquet_multiplier"].values
    assert read.tobytes() == values.tobytes()


@settings(max_examples=40)
@given(
    shape=st.lists(st.integers(0, 5), max_size=3),
    dtype=st.sampled_from(["f8", "f4", "i1", "i2", "i4", "i8", "u1", "c16", "?"]),
    seed=st.integers(0, 1000),
)
def test_round_trip_of_any_shape_and_type(tmp_path_factory, shape, dtype, seed):
    random = np.random.default_rng(seed)
    values = (random.normal(size=shape) * 100).astype(dtype)
    if dtype == "c16":
        values = values + 1j * random.normal(size=shape)
    dims = tuple(f"d{axis}" for axis in range(len(shape)))
    dataset = xr.Dataset({"residual": (dims, values)}, {"nu": 1.5})
    folder = tmp_path_factory.mktemp("any")
    read = store.load(written(dataset, folder))
    same(read, dataset)
    assert read["residual"].values.tobytes() == np.ascontiguousarray(values).tobytes()


@pytest.mark.parametrize("text", [["a", "bc"], ["é", "ν δ"], ["", "x"]])
def test_round_trip_of_text_of_fixed_length_on_disk(tmp_path, text):
    dataset = xr.Dataset({"residual": ("setting", [1.0, 2.0])}, {"setting": text})
    path = written(dataset, tmp_path)
    read = store.load(path)
    assert read["setting"].values.tolist() == text
    assert read["residual"].sel(setting=text[1]) == 2.0
    with netCDF4.Dataset(path) as file:
        assert all(variable.dtype != str for variable in file.variables.values())


def test_truth_values_are_flags_on_disk_and_bool_in_memory(tmp_path):
    path = written(describe(xr.Dataset({"stable": ("row", [True, False])})), tmp_path)
    with netCDF4.Dataset(path) as file:
        assert file["stable"].dtype == np.int8
        assert file["stable"].flag_values.tolist() == [0, 1]
        assert file["stable"].flag_meanings == "unstable stable"
    assert store.load(path)["stable"].dtype == bool


def test_attributes_without_a_netcdf_type_are_json(tmp_path):
    odd = {"solver": {"accuracy": 1e-8}, "none": None, "yes": True, "list": ["a", "b"], "empty": []}
    plain = {
        "n": 3,
        "x": 0.5,
        "text": "ν = 1",
        "flags": np.array([1, 2], np.int8),
        "xs": [1.0, 2.5],
    }
    odd["array"] = {"of": np.arange(3), "number": np.float64(0.5), "truth": np.bool_(True)}
    read = store.load(written(xr.Dataset({"residual": 1.0}, attrs=odd | plain), tmp_path))
    decoded = {name: json.loads(read.attrs[name]) for name in odd}
    assert decoded.pop("array") == {"of": [0, 1, 2], "number": 0.5, "truth": True}
    assert decoded == {name: value for name, value in odd.items() if name != "array"}
    for name, value in plain.items():
        np.testing.assert_array_equal(read.attrs[name], value)


def test_an_attribute_that_cannot_be_stored_is_refused(tmp_path):
    with pytest.raises(TypeError, match="cannot hold"):
        store.save(xr.Dataset(attrs={"odd": {"of": object()}}), tmp_path / "a.nc")
    assert list(tmp_path.iterdir()) == []


def test_coordinates_without_variables_stay_coordinates(tmp_path):
    dataset = xr.Dataset(coords={"nu": 1.0, "tau": [0.0, 1.0], "harmonic": ("tau", [1, 2])})
    same(store.load(written(dataset, tmp_path)), dataset)


def test_two_writes_give_the_same_bytes(tmp_path):
    dataset = shard(rows_of_sweep(50, phases=8), 0, 50, nu=1.0)
    first = written(dataset, tmp_path, "a.nc")
    time.sleep(1.1)  # HDF5 would store times in whole seconds
    second = written(dataset.copy(deep=True), tmp_path, "b.nc")
    assert first.read_bytes() == second.read_bytes()
    assert written(store.load(first), tmp_path, "c.nc").read_bytes() == first.read_bytes()


def test_one_changed_number_gives_other_bytes(tmp_path):
    dataset = motion()
    first = written(dataset, tmp_path, "a.nc").read_bytes()
    dataset["displacement"][3] += 1e-15
    assert written(dataset, tmp_path, "b.nc").read_bytes() != first


def test_the_header_of_a_file_describes_it(tmp_path):
    path = written(shard(rows_of_sweep(30), 0, 30, nu=1.0), tmp_path)
    with netCDF4.Dataset(path) as file:
        assert file.Conventions == "CF-1.11"
        for name, variable in file.variables.items():
            known = VOCABULARY[name.removesuffix("_re").removesuffix("_im")]
            assert variable.units == known.units
            assert known.long_name in variable.long_name
            if variable.dimensions:
                whole_numbers = variable.dtype.kind == "i"
                assert variable.filters()["zlib"] == whole_numbers
                assert variable.filters()["shuffle"] == whole_numbers
                assert variable.filters()["fletcher32"]
        assert file["regime"].flag_values.dtype == file["regime"].dtype
        assert "two_sided" in file["regime"].flag_meanings
        assert file["row_size"].sample_dimension == "impact"
        assert file["floquet_multiplier_im"].long_name == "Floquet multiplier, imaginary part"
        assert file["displacement_mean"].coordinates == "nu h l"


def test_no_missing_value_in_coordinates(tmp_path):
    with netCDF4.Dataset(written(motion(), tmp_path)) as file:
        assert "_FillValue" not in file["tau"].ncattrs()
        assert np.isnan(file["displacement"]._FillValue)


@given(
    shape=st.lists(st.integers(1, 5000), min_size=1, max_size=3), max_elements=st.integers(1, 10**6)
)
def test_chunks_are_blocks_in_c_order_within_bounds(shape, max_elements):
    chunks = chunk_shape(tuple(shape), max_elements)
    assert np.prod(chunks) <= max_elements
    cut = [axis for axis, (c, n) in enumerate(zip(chunks, shape, strict=True)) if c < n]
    if cut:
        assert all(c == 1 for c in chunks[: cut[-1]])
        axis = cut[-1]
        assert 16 * np.prod(chunks) > max_elements or chunks[axis] == 1
        assert -shape[axis] % chunks[axis] <= max(shape[axis] / 8, 1)


def test_chunks_are_about_a_megabyte(tmp_path):
    dataset = xr.Dataset({"displacement": (("nu", "phase"), np.zeros((3000, 256)))})
    with netCDF4.Dataset(written(dataset, tmp_path)) as file:
        chunks = file["displacement"].chunking()
    assert CHUNK_BYTES / 4 < 8 * np.prod(chunks) <= CHUNK_BYTES


@pytest.fixture
def study(tmp_path):
    folder = tmp_path / "results" / "paper"
    values = rows_of_sweep(30)
    store.save(motion(), folder / "forced.nc")
    store.save(shard(values, 0, 30, nu=1.0), folder / "response.nc")
    store.save(shard(values, 0, 10), folder / "shards" / "response" / "0000.nc")
    store.write_sidecar(folder / "response.nc", 1.5, 2)
    (folder / ".response.nc.host.1.part").write_bytes(b"half")
    (folder / ".hidden.nc").write_bytes(b"half")
    return folder


def test_a_study_is_a_tree_of_its_scenes(study):
    with store.open_study(study) as tree:
        assert list(tree.children) == ["forced", "response"]
        assert tree.name == "paper"
        same(tree["forced"].to_dataset().load(), motion())
        loaded = tree["response"].to_dataset().load()
    same(loaded, shard(rows_of_sweep(30), 0, 30, nu=1.0))


def test_a_study_is_opened_lazily(study):
    with store.open_study(str(study)) as tree:
        multiplier = tree["response/floquet_multiplier"]
        assert multiplier.dtype == np.complex128
        assert all(item.chunks is not None for item in tree["response"].data_vars.values())
        expected = rows_of_sweep(30)["floquet_multiplier"][3:5]
        np.testing.assert_array_equal(multiplier[3:5].values, expected)


def test_a_study_with_text_is_opened_as_written(tmp_path):
    words = ["free, no force", "pushed for ever"]
    dataset = describe(
        xr.Dataset(
            {"asked": ("case", words), "measured": (("case", "solver"), np.eye(2))},
            {"case": ["one", "two"], "solver": ["exact", "newmark"]},
        )
    )
    store.save(dataset, tmp_path / "hard.nc")
    with store.open_study(tmp_path) as tree:
        opened = tree["hard"].to_dataset()
        assert opened["measured"].chunks is not None
        assert list(opened.data_vars) == ["asked", "measured"]
        assert list(opened["asked"].values) == words
        xr.testing.assert_equal(opened.load(), dataset)


def test_a_slice_reads_a_slice(tmp_path):
    # a damaged chunk affects only reads of that chunk
    values = np.random.default_rng(0).normal(size=400_000)
    path = written(xr.Dataset({"residual": ("row", values)}), tmp_path)
    content = bytearray(path.read_bytes())
    content[int(0.6 * len(content))] ^= 1
    path.write_bytes(content)
    with store.open_study(tmp_path) as tree:
        residual = tree["a/residual"]
        np.testing.assert_array_equal(residual[:1000].values, values[:1000])
        np.testing.assert_array_equal(residual[-1000:].values, values[-1000:])
        with pytest.raises((OSError, RuntimeError), match="HDF error"):
            residual.load()


def test_a_closed_study_can_be_written_again(study):
    with store.open_study(study):
        pass
    store.save(motion(seed=1), study / "forced.nc")
    with store.open_study(study) as tree:
        same(tree["forced"].to_dataset().load(), motion(seed=1))


def test_a_missing_study_is_named_with_the_nearest_one(study):
    with pytest.raises(vp.StoreError, match=r"papre: does not exist \(there is .*paper\): solve"):
        vp.open_study(study.with_name("papre"))


def test_a_study_without_scenes_says_so(tmp_path):
    with pytest.raises(StoreError, match="holds no scene"):
        store.open_study(tmp_path)


def test_the_folder_of_all_results_names_its_studies(study):
    folder = study.parent
    told = "holds no scene but the results of studies: name "
    with pytest.raises(StoreError, match=f"^{folder}: {told}it: {study}$"):
        store.open_study(folder)
    other = folder / "another"
    other.mkdir()
    store.save(motion(seed=1), other / "forced.nc")
    (folder / "logs").mkdir()
    with pytest.raises(StoreError, match=f"^{folder}: {told}one: {other}, {study}$"):
        store.scene_files(folder)


def test_a_study_with_a_truncated_scene_names_it(study):
    content = (study / "forced.nc").read_bytes()
    (study / "forced.nc").write_bytes(content[:-100])
    with pytest.raises(StoreError, match=r"forced\.nc: is truncated"):
        store.open_study(study)


def test_the_scenes_of_the_study_are_opened_and_others_named(tmp_path):
    for name, scenes in (("old", "old map"), ("map", "old map"), ("new", "map new")):
        dataset = xr.Dataset({"residual": ("row", [1.0])}, attrs={"scenes": scenes})
        store.save(dataset, tmp_path / f"{name}.nc")
    os.utime(tmp_path / "new.nc", (2e9, 2e9))
    with pytest.warns(UserWarning, match="holds also old, not in the study; open them with"):
        tree = store.open_study(tmp_path)
    assert list(tree.children) == ["map", "new"]
    assert tree.attrs["left_out"] == "old"
    # a report may be newer than all datasets
    content = store.with_fingerprint(b"%PDF-1.7\nstartxref\n9\n%%EOF", "0" * 64, ["map"])
    (tmp_path / "report.pdf").write_bytes(content)
    os.utime(tmp_path / "report.pdf", (2.1e9, 2.1e9))
    with pytest.warns(UserWarning, match="holds also new and old"):
        assert list(store.open_study(tmp_path).children) == ["map"]


def test_a_newer_file_of_another_study_does_not_replace_the_one_that_the_folder_is_named_after(
    tmp_path,
):
    folder = tmp_path / "mine"
    for name, study, scenes in (
        ("map", "mine", "map way"),
        ("way", "mine", "map way"),
        ("x", "other", "x map"),
    ):
        attrs = {"scenes": scenes, "title": f"{study}: {name}"}
        store.save(xr.Dataset({"residual": ("row", [1.0])}, attrs=attrs), folder / f"{name}.nc")
    os.utime(folder / "x.nc", (2e9, 2e9))
    with pytest.warns(UserWarning, match="holds also x, not in the study"):
        assert list(store.open_study(folder).children) == ["map", "way"]
    # of a folder with a name of its own it is the newest result that tells
    folder = folder.rename(tmp_path / "copy")
    with pytest.warns(UserWarning, match="holds also map and way"):
        assert list(store.open_study(folder).children) == ["x"]


def test_a_newer_report_tells_the_units_of_data_in_si(tmp_path):
    attrs = {"display_units": "length: mm"}
    store.save(xr.Dataset({"displacement": ("row", [1.0])}, attrs=attrs), tmp_path / "map.nc")
    report = tmp_path / "report.pdf"
    content = store.with_fingerprint(
        b"%PDF-1.7\nstartxref\n9\n%%EOF", "0" * 64, ["map"], "length: µm; force: N"
    )
    report.write_bytes(content)
    assert scenes_of(report) == ["map"]
    for made, units in ((2.1e9, "length: µm; force: N"), (1e9, "length: mm")):
        os.utime(report, (made, made))
        assert store.load(tmp_path / "map.nc").attrs["display_units"] == units
        assert store.open_study(tmp_path)["map"].attrs["display_units"] == units


def test_a_file_in_place_of_a_study_says_what_opens_it(study):
    with pytest.raises(
        StoreError, match=r"forced\.nc: must be .*, got a file: open it with vp.load"
    ):
        store.open_study(study / "forced.nc")


def test_a_figure_and_a_report_carry_a_fingerprint_within_their_format(tmp_path):
    for name, content in (
        ("a.pdf", b"%PDF-1.7\nstartxref\n9\n%%EOF"),
        ("a.svg", b"<svg>\n</svg>\n"),
    ):
        path = tmp_path / name
        path.write_bytes(content)
        assert store.fingerprint_of(path) == ""
        path.write_bytes(store.with_fingerprint(content, "0af" * 21 + "1", ["one", "two"]))
        assert store.fingerprint_of(path) == "0af" * 21 + "1"
        assert scenes_of(path) == ["one", "two"]
        assert path.read_bytes().endswith(content[-5:])
    assert store.fingerprint_of(tmp_path / "none.svg") == ""


def test_a_steady_state_is_saved_with_its_complex_multipliers(tmp_path):
    state = vp.steady_state(vp.Exciter(l=0.5, nu=1.2, f=0.8, h=0.1, R1=0.7, R2=0.7))
    vp.save(state, tmp_path / "new" / "state.nc")
    loaded = vp.load(tmp_path / "new" / "state.nc")
    assert loaded["floquet_multiplier"].dtype.kind == "c"
    del loaded.attrs["Conventions"]
    assert loaded.identical(state)


def test_what_is_no_dataset_is_not_saved(tmp_path):
    with pytest.raises(vp.ParameterError) as error:
        vp.save([1.0], tmp_path / "state.nc")
    assert str(error.value) == "dataset: must be an xarray.Dataset, got list"
    assert not list(tmp_path.iterdir())
