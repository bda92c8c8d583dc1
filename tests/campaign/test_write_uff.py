"""What pyuff alone would write, byte for byte, and its errors as what they are."""

import errno
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import pyuff

from flexmodal.campaign import Campaign, write_campaign
from flexmodal.campaign.uff import frame as uff_frame
from flexmodal.campaign.uff.frame import framed, splice, with_size
from flexmodal.campaign.uff.write import blow_datasets, frf_datasets
from flexmodal.errors import NotWritten


def alone(dataset: dict, piece: Path) -> bytes:
    """The whole dataset by pyuff, with its count of bytes put right."""
    piece.unlink(missing_ok=True)
    pyuff.UFF(str(piece)).write_sets([dict(dataset)], mode="add")
    return with_size(piece.read_bytes(), dataset) if dataset["binary"] else piece.read_bytes()


@pytest.mark.filterwarnings("ignore::ResourceWarning")  # pyuff leaves a file open
@pytest.mark.parametrize("binary", [True, False])
@pytest.mark.parametrize("even", [True, False])
def test_frames_are_what_pyuff_writes(campaign: Campaign, tmp_path: Path, binary: bool, even: bool) -> None:
    assert campaign.frfs is not None
    axis = campaign.frfs.frequency if even else np.sqrt(campaign.frfs.frequency)
    frfs = replace(campaign.frfs, frequency=axis)
    datasets = [
        *frf_datasets(frfs, campaign.points, binary),
        *blow_datasets(campaign.blows, campaign.points, binary),
    ]
    kinds = {(np.iscomplexobj(d["data"]), bool(d["abscissa_spacing"])) for d in datasets}
    assert {(True, even), (False, even)} <= kinds
    for dataset in datasets[::3]:
        assert framed(dataset, tmp_path / "one") == alone(dataset, tmp_path / "other")


def test_the_values_go_in_as_a_block(campaign: Campaign, tmp_path: Path) -> None:
    """The quick way is the one taken: pyuff gets two values of each dataset and no more."""
    assert campaign.frfs is not None
    dataset = next(frf_datasets(campaign.frfs, campaign.points, True))
    stub = {**dataset, "data": dataset["data"][:2], "x": dataset["x"][:2]}
    frame = uff_frame._by_pyuff(stub, tmp_path / "stub")
    assert splice(frame, stub, dataset) == framed(dataset, tmp_path / "piece")


@pytest.mark.filterwarnings("ignore::ResourceWarning")
def test_a_frame_laid_out_otherwise_is_left_to_pyuff(
    campaign: Campaign, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert campaign.frfs is not None
    dataset = next(frf_datasets(campaign.frfs, campaign.points, True))
    whole, real = alone(dataset, tmp_path / "whole"), uff_frame._by_pyuff
    for spoilt in (b"\n    -1\n", b"    -1  \n"):

        def odd(given: dict, piece: Path, tail: bytes = spoilt) -> bytes:
            written = real(given, piece)
            return written[: -len(b"    -1\n")] + tail if len(given["data"]) == 2 else written

        monkeypatch.setattr(uff_frame, "_by_pyuff", odd)
        assert framed(dataset, tmp_path / "piece") == whole
    header = real({**dataset, "data": dataset["data"][:2], "x": dataset["x"][:2]}, tmp_path / "stub")
    stub = {**dataset, "data": dataset["data"][:2], "x": dataset["x"][:2]}
    assert splice(b"\n" + header, stub, dataset) is None
    assert splice(header.replace(b"         6         2", b"         6         3"), stub, dataset) is None


def test_a_full_disk_is_told_as_such(
    campaign: Campaign, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """pyuff wraps whatever happens in a bare Exception."""

    def full(self: object, sets: object, mode: str) -> None:
        try:
            raise OSError(errno.ENOSPC, "No space left on device")
        except OSError:
            raise Exception("Error writing data-set #58")  # noqa: B904  as pyuff does

    monkeypatch.setattr(pyuff.UFF, "write_sets", full)
    with pytest.raises(NotWritten, match="No space left"):
        write_campaign(campaign, tmp_path / "c")
    assert list(tmp_path.iterdir()) == []
