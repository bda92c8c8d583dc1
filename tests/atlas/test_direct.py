"""Large files go past the page cache where the system lets them, and hold the same bytes where not."""

import errno
import os

import google_crc32c
import numpy as np
import pytest

from flexmodal.atlas import Plan, Receptances, Sample, build_atlas, direct, whole_range
from flexmodal.atlas.direct import BLOCK, LARGE, memory_for, write_file
from flexmodal.atlas.store import is_sound


@pytest.mark.parametrize("size", [0, 1, BLOCK, LARGE - 1, LARGE, LARGE + BLOCK, 3 * LARGE + 17])
def test_the_bytes_are_those(tmp_path, size):
    content = memory_for(size, 0)
    content[:] = np.random.default_rng(size).bytes(size)
    write_file(tmp_path / "file", content)
    assert (tmp_path / "file").read_bytes() == content


def test_memory_is_kept_apart_by_place_and_aligned():
    one, other = memory_for(LARGE, 0), memory_for(2 * LARGE, 1)
    one[:] = b"\1" * LARGE
    other[:] = b"\2" * 2 * LARGE
    assert one[0] == 1
    assert np.frombuffer(one, np.uint8).ctypes.data % BLOCK == 0
    again = memory_for(LARGE, 1)
    assert np.frombuffer(again, np.uint8).ctypes.data == np.frombuffer(other, np.uint8).ctypes.data


@pytest.mark.parametrize("when", ["opened", "written"])
def test_a_file_system_without_it(tmp_path, monkeypatch, when):
    plain, asked = os.open, []

    def refuses(path, flags, mode=0o777):
        if flags & direct._FLAG:
            asked.append(path)
            raise OSError(errno.EINVAL, "Invalid argument")
        return plain(path, flags, mode)

    if when == "opened":
        if not direct._FLAG:
            pytest.skip("a system that does not know it")
        monkeypatch.setattr(direct.os, "open", refuses)
        content = memory_for(LARGE + 5, 0)
    else:  # memory that is not aligned is refused with the first write
        content = memoryview(bytearray(LARGE + 5 + 8))[8:][: LARGE + 5]
    content[:] = np.random.default_rng(1).bytes(LARGE + 5)
    write_file(tmp_path / "file", content)
    assert (tmp_path / "file").read_bytes() == content
    assert bool(asked) == (when == "opened")


def test_a_write_that_takes_a_part(tmp_path):
    """As on a disk that is nearly full; what follows goes the ordinary way."""
    content = memory_for(2 * LARGE, 0)
    content[:] = np.random.default_rng(2).bytes(2 * LARGE)

    class Slow(direct.io.FileIO):
        def write(self, given):
            return super().write(given[:10_000])

    with Slow(tmp_path / "file", "wb") as out:
        done = direct._write_blocks(out, content)
        assert done == 10_000  # no whole number of blocks: it stops there
        while done < len(content):
            done += out.write(content[done:])
    assert (tmp_path / "file").read_bytes() == content


def test_a_disk_that_is_full_is_said(tmp_path, monkeypatch):
    def full(out, content):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(direct, "_write_blocks", full)
    with pytest.raises(OSError, match="No space"):
        write_file(tmp_path / "file", memory_for(LARGE, 0))


def test_chunks_of_some_megabytes(six_link, tmp_path):
    """As zarr reads them, and as the batch engine says them; the last chunk is not full."""
    xarray = pytest.importorskip("xarray")
    quantity = Receptances.of(six_link, ["tool:+z"], np.linspace(1, 20, 400))
    plan = Plan(Sample(six_link, 499, whole_range(six_link)), quantity, chunk_bytes=3_000_000)
    build_atlas(plan, tmp_path / "a.zarr")
    assert plan.layout.files(tmp_path, 0)[-1][1] > LARGE
    values = plan.points.values((slice(0, 499),))
    wanted = quantity.compute(values)["receptance"]
    found = xarray.open_zarr(tmp_path / "a.zarr").receptance.values
    np.testing.assert_array_equal(found, wanted)
    for number in range(plan.chunks):
        assert is_sound(plan.layout, tmp_path / "a.zarr", number)
    file = plan.layout.files(tmp_path / "a.zarr", 0)[-1][0]
    content = file.read_bytes()
    assert int.from_bytes(content[-4:], "little") == google_crc32c.value(content[:-4])
