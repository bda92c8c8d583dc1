"""What is written reads back the same."""

import sys
from pathlib import Path

import numpy as np
import pytest

from flexmodal.campaign import Campaign, check_campaign, read_campaign, write_campaign
from flexmodal.errors import NotWritten, OutputExists

# pyuff's ASCII holds twelve digits of a value; binary holds all of them.
TOLERANCE = {True: 0.0, False: 1e-11}


@pytest.mark.parametrize("binary", [True, False])
def test_every_part_comes_back(campaign: Campaign, tmp_path: Path, binary: bool) -> None:
    back = read_campaign(write_campaign(campaign, tmp_path / "c", binary=binary))
    rtol = TOLERANCE[binary]
    for name in ("title", "robot", "band", "points", "trials"):
        assert getattr(back, name) == getattr(campaign, name)
    assert [(p.id, p.name, dict(p.q)) for p in back.postures] == [
        (p.id, p.name, dict(p.q)) for p in campaign.postures
    ]
    assert back.frfs is not None
    assert campaign.frfs is not None
    assert back.frfs.form == campaign.frfs.form
    for name in ("frequency", "value", "coherence", "posture", "trial", "response", "reference"):
        np.testing.assert_allclose(
            getattr(back.frfs, name), getattr(campaign.frfs, name), rtol=rtol, err_msg=name
        )
    assert len(back.blows) == 3
    for one, other in zip(back.blows, campaign.blows, strict=True):
        assert (one.posture, one.trial, one.sequence) == (other.posture, other.trial, other.sequence)
        assert (one.reference, one.channels, one.quantity) == (
            other.reference,
            other.channels,
            other.quantity,
        )
        np.testing.assert_allclose(one.force, other.force, rtol=rtol)
        np.testing.assert_allclose(one.response, other.response, rtol=rtol)
        # 1/2048 s has eight digits: exact in binary, which stores the axis, six digits of a step in ASCII.
        np.testing.assert_allclose(one.time, other.time, rtol=1e-15 if binary else 1e-6)
    assert back.modes is not None
    assert campaign.modes is not None
    for name in (
        "posture",
        "response",
        "reference",
        "mode",
        "natural_frequency",
        "damping_ratio",
        "amplitude",
    ):
        np.testing.assert_array_equal(getattr(back.modes, name), getattr(campaign.modes, name), err_msg=name)
    assert back.modes.flag == campaign.modes.flag
    assert back.warnings == ()
    assert check_campaign(tmp_path / "c").is_sound


def test_nothing_is_replaced_unasked(campaign: Campaign, tmp_path: Path) -> None:
    write_campaign(campaign, tmp_path / "c")
    with pytest.raises(OutputExists, match="existing folder"):
        write_campaign(campaign, tmp_path / "c")
    write_campaign(campaign, tmp_path / "c", overwrite=True)
    (tmp_path / "c" / "notes.txt").write_text("precious")
    with pytest.raises(OutputExists, match=r"notes\.txt"):
        write_campaign(campaign, tmp_path / "c", overwrite=True)
    assert (tmp_path / "c" / "notes.txt").read_text() == "precious"


def test_written_whole_or_not_at_all(
    campaign: Campaign, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object) -> None:
        raise OSError("disk full")

    module = sys.modules["flexmodal.campaign.write_campaign"]  # the package's function has the same name
    monkeypatch.setattr(module, "write_modes", full)
    with pytest.raises(NotWritten, match="disk full"):
        write_campaign(campaign, tmp_path / "c")
    assert list(tmp_path.iterdir()) == []
