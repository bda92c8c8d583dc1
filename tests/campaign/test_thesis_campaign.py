"""The shipped campaign of the thesis, against the tables it was made from, cell by cell."""

import csv
import math
from pathlib import Path

import numpy as np
import pytest

from flexmodal.campaign import read_campaign, read_receptances
from flexmodal.errors import InvalidCampaign

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "robots" / "fanuc_s360" / "campaigns" / "thesis"


def table(name: str) -> list[dict[str, str]]:
    with (ROOT / "tests" / "data" / "thesis" / f"{name}.csv").open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_every_cell_of_appendix_c_is_there_with_its_flag() -> None:
    campaign = read_campaign(FOLDER)
    assert campaign.warnings == ()
    assert campaign.modes is not None
    rows = table("modal_parameters")
    assert len(campaign.modes) == len(rows) == 120
    for place, row in enumerate(rows):
        printed = [
            row["natural_frequency_hz"],
            row["damping_ratio"],
            row["amplitude_re"],
            row["amplitude_im"],
        ]
        amplitude = campaign.modes.amplitude[place]
        held = [campaign.modes.natural_frequency[place], campaign.modes.damping_ratio[place]]
        held += [amplitude.real, amplitude.imag]
        for text, value in zip(printed, held, strict=True):
            assert (math.isnan(value) and not text) or float(text) == value
        assert campaign.modes.posture[place] == int(row["configuration"])
        assert campaign.modes.response[place] == int(row["location"])
        assert campaign.modes.flag[place] == row["flag"]
    assert set(campaign.modes.reference.tolist()) == {2}


def test_postures_are_those_of_table_2_5() -> None:
    campaign = read_campaign(FOLDER)
    for row in table("configurations"):
        posture = campaign.posture(int(row["configuration"]))
        assert posture.q["q1"] == pytest.approx(math.radians(float(row["q1_deg"])), rel=1e-12)
        assert posture.q["q2"] == pytest.approx(-posture.q["q1"], rel=1e-12)


def test_receptances_and_their_printed_means() -> None:
    amplitudes = read_receptances(FOLDER / "receptances.csv")
    assert len(amplitudes) == 7 + 14 + 36
    # The means printed below Table 3.5.
    for frequency, mean in ((500, 2.61e-12), (1000, 6.75e-13), (1500, 3.32e-12)):
        values = [a.receptance for a in amplitudes if a.source == "Table 3.5" and a.frequency == frequency]
        assert np.mean(values) == pytest.approx(mean, rel=2e-3)  # three printed digits


def test_bad_receptances_are_refused(tmp_path: Path) -> None:
    file = tmp_path / "receptances.csv"
    file.write_text("source,posture,frequency,trial,receptance,flag\nT,0,nan,x,-1,\nT,1,2\n")
    with pytest.raises(InvalidCampaign) as caught:
        read_receptances(file)
    assert [fault.key for fault in caught.value.faults] == [
        "line 2: posture",
        "line 2: trial",
        "line 2: frequency",
        "line 2: receptance",
        "line 3",
    ]
