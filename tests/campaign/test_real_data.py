"""Measurements that others published, read and turned into FRFs."""

from pathlib import Path

import numpy as np
import pytest
import pyuff

from flexmodal.campaign import Campaign, check_campaign, estimate_frfs, read_campaign

REAL = Path(__file__).parents[1] / "data" / "real"


@pytest.fixture(scope="module")
def plate() -> Campaign:
    return read_campaign(REAL / "mssp_plate_sweep")


def test_the_beam_reads_as_pyuff_reads_it() -> None:
    campaign = read_campaign(REAL / "free_free_beam")
    frfs = campaign.frfs
    assert frfs is not None
    assert frfs.form == "inertance"
    assert frfs.reference[:, 0].tolist() == [1, 2, 3]
    for row, record in enumerate(pyuff.UFF(str(REAL / "free_free_beam" / "frf.uff")).read_sets()):
        np.testing.assert_array_equal(frfs.value[row], record["data"])
        np.testing.assert_array_equal(frfs.frequency, record["x"])
    # The analyser left version and load case at 0; there is one trial and one posture.
    assert any("load case" not in warning and "version number 0" in warning for warning in campaign.warnings)
    assert check_campaign(REAL / "free_free_beam").is_sound


def test_the_peaks_of_the_beam_lie_where_the_reference_says() -> None:
    frfs = read_campaign(REAL / "free_free_beam").frfs
    assert frfs is not None
    size = np.abs(frfs.value).sum(axis=0)
    # Peak lines, 1 Hz apart, against natural frequencies fitted by sdypy-EMA (PROVENANCE.md).
    for frequency in (51.52, 142.18, 278.66, 460.40, 687.17, 958.54):
        inside = np.abs(frfs.frequency - frequency) < 20
        peak = frfs.frequency[inside][np.argmax(size[inside])]
        assert abs(peak - frequency) <= 1.0


def test_h1_of_the_plate_has_the_coherence_that_was_found_before(plate: Campaign) -> None:
    frfs = estimate_frfs(plate)
    assert len(plate.blows) == 5
    assert frfs.coherence is not None
    inside = (frfs.frequency >= 60) & (frfs.frequency <= 500)
    assert frfs.frequency[1] == pytest.approx(0.5, rel=1e-9)
    # PROVENANCE.md: H1 of five runs, df 0.5 Hz, median coherence 0.997 from 60 to 500 Hz.
    assert np.median(frfs.coherence[0, inside]) == pytest.approx(0.997, abs=0.0006)


def test_h1_of_the_plate_by_numpy_alone(plate: Campaign) -> None:
    frfs = estimate_frfs(plate)
    force = np.array([np.fft.rfft(blow.force) for blow in plate.blows])
    response = np.array([np.fft.rfft(blow.response[0]) for blow in plate.blows])
    wanted = (force.conj() * response).mean(axis=0) / (np.abs(force) ** 2).mean(axis=0)
    np.testing.assert_allclose(frfs.value[0, 1:-1], wanted[1:-1], rtol=1e-9)  # the same quotient, rounding


def test_peaks_of_the_plate_lie_near_the_reference(plate: Campaign) -> None:
    frfs = estimate_frfs(plate)
    inside = (frfs.frequency >= 60) & (frfs.frequency <= 400)
    size, lines = np.abs(frfs.value[0, inside]), frfs.frequency[inside]
    for frequency in (76.95, 125.9, 214.0):
        near = np.abs(lines - frequency) < 0.06 * frequency
        # A peak of inertance with some 2 % of damping lies within 2 % of its natural frequency.
        assert lines[near][np.argmax(size[near])] == pytest.approx(frequency, rel=0.02)
