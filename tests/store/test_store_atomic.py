"""Files appear only when complete, and any damage is detected."""

import errno
import os
import shutil
import subprocess
import sys
from collections import namedtuple
from pathlib import Path

import netCDF4
import pytest
from command_line import printed
from store_datasets import motion

from vibropipe import store
from vibropipe.store import StoreError, atomic


@pytest.fixture
def path(tmp_path):
    target = tmp_path / "a.nc"
    store.save(motion(), target)
    return target


def test_an_intact_file_passes(path):
    store.check_intact(path)
    store.check_intact(str(path), every_byte=False)


def test_other_tools_read_a_sealed_file(path):
    with netCDF4.Dataset(path) as file:
        assert file["displacement"].shape == (40,)


@pytest.mark.parametrize("first", ["h5py", "netCDF4"])
def test_h5py_and_netcdf4_read_a_sealed_file_in_one_process(path, first):
    # each has a copy of HDF5 of its own; the order of loading must not matter
    code = f"""
import {first}, h5py, netCDF4, numpy
with h5py.File({str(path)!r}) as raw, netCDF4.Dataset({str(path)!r}) as file:
    for name in file.variables:
        file[name].set_auto_maskandscale(False)
        file[name].set_auto_chartostring(False)
        assert numpy.asarray(file[name][...]).tobytes() == numpy.asarray(raw[name][...]).tobytes()
    print(raw["displacement"].shape)
"""
    assert printed(code) == "(40,)\n"


def test_a_folder_is_no_file(tmp_path):
    with pytest.raises(StoreError, match=r"must be a file, got a folder: name a \.nc file in it"):
        atomic.check_intact(tmp_path)


def test_each_flipped_byte_is_detected(path):
    content = path.read_bytes()
    for position in range(0, len(content), 97):
        damaged = bytearray(content)
        damaged[position] ^= 1
        path.write_bytes(damaged)
        with pytest.raises(StoreError, match=r"a\.nc: is (damaged|truncated)"):
            store.load(path)


@pytest.mark.parametrize("missing", [1, 10, 82, 83, 1000])
@pytest.mark.parametrize("every_byte", [True, False])
def test_a_truncated_file_is_detected(path, missing, every_byte):
    path.write_bytes(path.read_bytes()[:-missing])
    with pytest.raises(StoreError, match=r"a\.nc: is truncated.*delete it and rerun"):
        store.check_intact(path, every_byte=every_byte)


def test_an_added_tail_is_detected(path):
    path.write_bytes(path.read_bytes() + b"\0")
    with pytest.raises(StoreError, match="changed since it was written"):
        store.check_intact(path)


def test_an_empty_file_is_detected(path):
    path.write_bytes(b"")
    with pytest.raises(StoreError, match=r"a\.nc: is empty"):
        store.load(path)


def test_a_foreign_file_is_detected(path):
    path.write_text("not netCDF4 at all" * 20)
    with pytest.raises(StoreError, match="is not a netCDF4 file"):
        store.load(path)


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(StoreError, match=r"b\.nc: cannot be read: No such file"):
        store.load(tmp_path / "b.nc")


def test_any_tool_detects_damaged_values_by_hdf5_checksums(tmp_path):
    path = tmp_path / "a.nc"
    store.save(motion(samples=50_000), path)
    content = bytearray(path.read_bytes())
    for part in (0.3, 0.5, 0.7):  # within the values of displacement, velocity, force
        damaged = content.copy()
        damaged[int(part * len(content))] ^= 1
        path.write_bytes(damaged)
        with netCDF4.Dataset(path) as file, pytest.raises((OSError, RuntimeError)):
            print([file[name][:].sum() for name in ("displacement", "velocity", "force")])


def test_missing_folders_are_created(tmp_path):
    target = tmp_path / "results" / "paper" / "a.nc"
    store.save(motion(), target)
    assert [item.name for item in target.parent.iterdir()] == ["a.nc"]


@pytest.mark.parametrize("error", [ValueError("no"), KeyboardInterrupt(), RuntimeError("HDF")])
def test_an_exception_leaves_nothing_but_the_old_file(path, error):
    before = path.read_bytes()

    def interrupted():
        with atomic.atomic_file(path) as temporary:
            temporary.write_bytes(b"half")
            raise error

    with pytest.raises((type(error), StoreError)):
        interrupted()
    assert path.read_bytes() == before
    assert list(path.parent.iterdir()) == [path]


def test_a_failing_write_leaves_nothing(tmp_path, monkeypatch):
    def fail(*_):
        raise RuntimeError("NetCDF: HDF error")

    monkeypatch.setattr("vibropipe.store.files.define_variables", fail)
    with pytest.raises(StoreError, match=r"a\.nc: was not written: NetCDF: HDF error"):
        store.save(motion(), tmp_path / "a.nc")
    assert list(tmp_path.iterdir()) == []


def test_a_killed_writer_leaves_a_hidden_file_that_the_next_one_removes(tmp_path):
    path = tmp_path / "a.nc"
    code = (
        "import os, signal\n"
        "from vibropipe.store import atomic_file\n"
        f"with atomic_file({str(path)!r}) as temporary:\n"
        "    temporary.write_bytes(b'half')\n"
        "    os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    subprocess.run([sys.executable, "-c", code], check=False)
    left = list(tmp_path.iterdir())
    assert len(left) == 1
    assert left[0].name.startswith(".a.nc.")
    store.save(motion(), path)
    assert list(tmp_path.iterdir()) == [path]


def test_the_file_of_a_running_writer_is_left_alone(tmp_path):
    path = tmp_path / "a.nc"
    own = atomic._temporary(path).name
    other = tmp_path / own.replace(f".{os.getpid()}.", f".{os.getppid()}.")
    other.write_bytes(b"half")
    store.save(motion(), path)
    assert other.read_bytes() == b"half"


def test_no_process_is_signalled_on_windows(monkeypatch):
    class Windows:
        name = "nt"

    monkeypatch.setattr(atomic, "os", Windows)
    assert atomic._is_running(1)


def test_files_are_written_to_a_folder_that_cannot_be_opened(tmp_path, monkeypatch):
    def refuse(path, *flags):
        if os.path.isdir(path):
            raise PermissionError(errno.EACCES, "Permission denied", path)
        return opened(path, *flags)

    opened = os.open
    monkeypatch.setattr(atomic.os, "open", refuse)
    store.save(motion(), tmp_path / "a.nc")
    store.check_intact(tmp_path / "a.nc")


def test_leftovers_of_killed_writers_of_any_machine_are_removed_on_request(tmp_path):
    running = atomic._temporary(tmp_path / "1.nc").name
    dead = running.replace(f".{os.getpid()}.", ".999999999.")
    foreign = [".1.nc.node-7.12.part", ".2.nc.node-7.12.part"]
    others = [".1.nc.part", ".hidden", "1.nc", "1.nc.node-7.12.part"]
    for name in (running, dead, *foreign, *others):
        (tmp_path / name).write_bytes(b"half")

    atomic.remove_leftovers(tmp_path, ["1.nc"])
    kept = {running, foreign[1], *others}
    assert {path.name for path in tmp_path.iterdir()} == kept

    atomic.remove_leftovers(tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == kept - {foreign[1]}
    atomic.remove_leftovers(tmp_path / "absent")


@pytest.mark.parametrize("number", [errno.EROFS, errno.EACCES])
def test_a_folder_that_cannot_be_written_is_explained(tmp_path, monkeypatch, number):
    def refuse(*_, **__):
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(Path, "touch", refuse)
    with pytest.raises(StoreError, match=r"a\.nc: was not written: .* does not allow it .*Change"):
        store.save(motion(), tmp_path / "a.nc")


def test_a_full_disk_is_explained_though_hdf5_hides_it(tmp_path, monkeypatch):
    usage = namedtuple("usage", "total used free")
    monkeypatch.setattr(shutil, "disk_usage", lambda _: usage(10**9, 10**9, 4096))

    def fail(*_):
        raise RuntimeError("NetCDF: HDF error")

    monkeypatch.setattr("vibropipe.store.files.define_variables", fail)
    with pytest.raises(
        StoreError,
        match=r"the disk is full \(0\.0 MB free .*Free disk space and rerun the command; completed files are kept",
    ):
        store.save(motion(), tmp_path / "a.nc")


def test_a_write_cut_off_by_the_system_is_an_error_and_leaves_nothing(tmp_path):
    path = tmp_path / "a.nc"
    code = (
        "import resource, signal, sys\n"
        f"sys.path.insert(0, {str(Path(__file__).parent)!r})\n"
        "from store_datasets import motion\n"
        "from vibropipe import store\n"
        "signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (200_000, 200_000))\n"
        "try:\n"
        f"    store.save(motion(samples=200_000), {str(path)!r})\n"
        "except store.StoreError as error:\n"
        "    print(error)\n"
    )
    assert f"{path}: was not written" in printed(code)
    assert list(tmp_path.iterdir()) == []


def test_a_file_in_the_way_of_a_folder_is_explained(tmp_path):
    (tmp_path / "results").write_text("a file")
    with pytest.raises(StoreError, match=r"was not written"):
        store.save(motion(), tmp_path / "results" / "a.nc")
