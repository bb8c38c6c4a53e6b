"""Damaged shards, full and read-only disks: the message, the files left, and the result of a rerun."""

import resource
import shutil
import signal

import pytest


def truncated(content: bytes) -> bytes:
    return content[: len(content) // 2]


def flipped(content: bytes) -> bytes:
    damaged = bytearray(content)
    damaged[len(content) // 3] ^= 0x10
    return bytes(damaged)


def empty(_: bytes) -> bytes:
    return b""


@pytest.mark.parametrize("damage", [truncated, flipped, empty])
def test_a_damaged_shard_is_never_joined_and_solved_again_alone(damage, work, said, tmp_path):
    shard, output = work.shards[1], tmp_path / "joined.nc"
    whole = shard.read_bytes()
    try:
        shard.write_bytes(damage(whole))
        assert work.join(output) == 2
        told = said()
        assert str(shard) in told
        assert "delete it and rerun; only missing files are recomputed" in told
        assert not list(tmp_path.iterdir())
        shard.unlink()
        assert work.solve_shard(2) == 0
        assert shard.read_bytes() == whole
    finally:
        shard.write_bytes(whole)
    assert work.join(output) == 0
    assert output.read_bytes() == work.whole.read_bytes()


def test_on_a_full_disk_nothing_is_left_and_with_room_the_same_is_made(work, said, disk):
    place = disk("size=48k")
    (place / "other.bin").write_bytes(bytes(40_000))
    for verb in (work.join, work.solve):
        assert verb(place / "response.nc") == 1
        told = said()
        assert "response.nc: was not written: the disk is full" in told
        assert "Free disk space and rerun the command; completed files are kept" in told
        assert [path.name for path in place.iterdir()] == ["other.bin"]
    disk("size=4m")
    assert work.join(place / "response.nc") == 0
    assert (place / "response.nc").read_bytes() == work.whole.read_bytes()


def test_in_a_read_only_folder_nothing_is_touched(work, said, disk):
    place = disk("size=4m")
    shutil.copy(work.shards[0], place / "response.nc")
    before = (place / "response.nc").read_bytes()
    disk("ro")
    for verb, output in ((work.join, "response.nc"), (work.solve, "new/response.nc")):
        assert verb(place / output) == 1
        told = said()
        assert "response.nc: was not written: " in told
        assert "does not allow it (Read-only file system). Change its permissions" in told
    assert [path.name for path in place.iterdir()] == ["response.nc"]
    assert (place / "response.nc").read_bytes() == before


def test_a_write_cut_off_by_a_limit_leaves_nothing(work, tmp_path):
    def limited() -> None:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))

    done = work.solve_apart(tmp_path / "response.nc", preexec_fn=limited)
    assert done.returncode == 1
    assert "response.nc: was not written" in done.stderr
    assert "Traceback" not in done.stderr
    assert not list(tmp_path.iterdir())
