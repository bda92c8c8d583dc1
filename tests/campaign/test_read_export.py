"""Universal files by themselves: what an analyser exports, without a campaign.toml."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from flexmodal.campaign import check_campaign, estimate_frfs, is_campaign, read_campaign
from flexmodal.errors import InvalidCampaign

REAL = Path(__file__).parents[1] / "data" / "real"
EXPORT = REAL / "pyuff_accelerance_points" / "measurement.uff"


@pytest.mark.parametrize("suffix", [".uff", ".unv", ".UFF"])
def test_frfs_are_those_of_the_campaign_with_the_same_file(tmp_path, suffix):
    file = tmp_path / f"from the analyser{suffix}"
    shutil.copy(EXPORT, file)
    assert is_campaign(file)
    alone, described = read_campaign(file).frfs, read_campaign(REAL / "free_free_beam").frfs
    np.testing.assert_array_equal(alone.value, described.value)
    np.testing.assert_array_equal(alone.frequency, described.frequency)
    np.testing.assert_array_equal(alone.reference, described.reference)
    assert alone.form == described.form == "inertance"


def test_blows_give_the_same_frfs_and_their_peaks(tmp_path):
    file = tmp_path / "blows.uff"
    shutil.copy(REAL / "mssp_plate_sweep" / "time.uff", file)
    alone, described = read_campaign(file), read_campaign(REAL / "mssp_plate_sweep")
    np.testing.assert_array_equal(estimate_frfs(alone).value, estimate_frfs(described).value)
    peaks = [np.abs(blow.force).max() for blow in described.blows]
    assert alone.trials[0].force_peak == pytest.approx(np.median(peaks))


@pytest.mark.parametrize("binary", [True, False])
def test_postures_trials_and_points_are_what_the_records_say(written, tmp_path, binary):
    described = read_campaign(written[binary])
    shutil.copy(written[binary] / "frf.uff", tmp_path / "frf.uff")
    found = read_campaign(tmp_path / "frf.uff")
    assert {posture.id for posture in found.postures} == set(described.frfs.posture.tolist())
    assert {trial.id for trial in found.trials} == set(described.frfs.trial.tolist())
    used = set(described.frfs.response[:, 0].tolist()) | set(described.frfs.reference[:, 0].tolist())
    assert {point.id for point in found.points} == used
    assert any("no campaign.toml" in warning for warning in found.warnings)


@pytest.mark.parametrize(
    ("content", "says"),
    [(b"", "no dataset 58"), (EXPORT.read_bytes()[:3000], "101 numbers"), (b"hello", "no start tag")],
)
def test_what_is_no_sound_universal_file_is_refused(tmp_path, content, says):
    file = tmp_path / "export.uff"
    file.write_bytes(content)
    with pytest.raises(InvalidCampaign, match=says):
        read_campaign(file)
    assert not check_campaign(file).is_sound


def test_directions_that_are_none_are_refused(tmp_path):
    """A response direction of 4 in the sixth record, a rotation."""
    lines = EXPORT.read_bytes().split(b"\n")
    place = next(n for n, line in enumerate(lines) if line.strip() == b"58") + 6
    head = lines[place]
    fields = head.rstrip()
    assert fields.endswith(b"1")
    lines[place] = head.replace(fields, fields[:-1] + b"4")
    file = tmp_path / "export.uff"
    file.write_bytes(b"\n".join(lines))
    with pytest.raises(InvalidCampaign, match="reference direction: found 4"):
        read_campaign(file)
