"""Make robots/fanuc_s360/campaigns/thesis from the tables of the thesis in tests/data/thesis."""

from __future__ import annotations

import math
import tempfile
from pathlib import Path

import numpy as np
from tables import ROOT, thesis

from flexmodal.campaign import (
    Amplitude,
    Campaign,
    CampaignPoint,
    CampaignPosture,
    ModeTable,
    Trial,
    write_campaign,
)
from flexmodal.campaign.tables.receptances import write_receptances
from flexmodal.cards import read_card
from flexmodal.files import whole_file

ROBOT = "fanuc_s360"
FOLDER = ROOT / "robots" / ROBOT / "campaigns" / "thesis"
WRIST = 2
PEAKS = {"8": 1, "38": 2, "51": 3, "58": 4, "94": 5}
"""The nominal names of the peaks, as modes."""
REMARK = """\
# Modal parameters of Appendix C (Tables C.1 to C.4) and receptances of Tables 3.2, 3.3 and 3.5 of J. Hearne,
# Posture Dependent Vibration Resistance of Serial Robot Manipulators to Applied Oscillating Loads, thesis,
# University of Waterloo. Made by benchmarks/thesis_campaign.py from tests/data/thesis.
# Excited at location 2, the wrist. The thesis prints no peak forces: force_peak = 1.0 means "not printed".
# Links and places of the points are those of the card; the thesis prints no distances.
# Modes 1 to 5 are the peaks that the thesis calls 8, 38, 51, 58 and 94 Hz. Flags are field:mark; missing is
# printed so; * and + are marks of the thesis ("*" was "excellent fit" in C.1, "not measured, taken from
# existing values" in C.2 and C.4; "+" in C.3, identified by least squares); *_doubtful and ocr_lost are
# remarks of who typed the tables: the number stands as printed.
"""


def number(text: str) -> float:
    return float(text) if text else math.nan


def modes() -> ModeTable:
    rows = thesis("modal_parameters")
    amplitude = [complex(number(row["amplitude_re"]), number(row["amplitude_im"])) for row in rows]
    return ModeTable(
        posture=np.array([int(row["configuration"]) for row in rows]),
        response=np.array([int(row["location"]) for row in rows]),
        reference=np.full(len(rows), WRIST),
        mode=np.array([PEAKS[row["peak_hz"]] for row in rows]),
        natural_frequency=np.array([number(row["natural_frequency_hz"]) for row in rows]),
        damping_ratio=np.array([number(row["damping_ratio"]) for row in rows]),
        amplitude=np.array(amplitude),
        flag=tuple(row["flag"] for row in rows),
    )


def receptances() -> tuple[Amplitude, ...]:
    return tuple(
        Amplitude(
            source=f"Table {row['table']}",
            posture=int(row["configuration"]),
            frequency=float(row["frequency_hz"]),
            trial=int(row["trial"]) if row["trial"] else None,
            receptance=float(row["receptance_m_per_n"]),
            flag=row["flag"],
        )
        for row in thesis("receptance_predicted_measured")
        if row["kind"] == "measured"
    )


def campaign() -> Campaign:
    card = read_card(ROOT / "robots" / ROBOT / "robot.toml")
    return Campaign(
        title="Fanuc S-360, hammer test of the thesis: modal parameters of Appendix C",
        robot=ROBOT,
        band=(2.0, 200.0),
        postures=tuple(
            CampaignPosture(int(name.rsplit("_", 1)[1]), name, q) for name, q in card.postures.items()
        ),
        points=tuple(
            CampaignPoint(int(name.rsplit("_", 1)[1]), name, point.link, point.xyz)
            for name, point in card.points.items()
        ),
        trials=(Trial(1, 1.0, 3, "soft"), Trial(2, 1.0, 3, "hard")),
        modes=modes(),
    )


def main() -> None:
    FOLDER.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as scratch:
        made = write_campaign(campaign(), Path(scratch) / "thesis")
        texts = {path.name: path.read_text(encoding="utf-8") for path in made.iterdir()}
    texts["campaign.toml"] = REMARK + texts["campaign.toml"]
    for name, text in texts.items():
        with whole_file(FOLDER / name, overwrite=True) as file:
            file.write_text(text, encoding="utf-8")
    with whole_file(FOLDER / "receptances.csv", overwrite=True) as file:
        write_receptances(receptances(), file)
    print(f"{FOLDER.relative_to(ROOT)}: {', '.join(sorted(path.name for path in FOLDER.iterdir()))}")


if __name__ == "__main__":
    main()
