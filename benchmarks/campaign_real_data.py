"""Make the campaigns in tests/data/real from the published measurements they hold.

`python benchmarks/campaign_real_data.py FOLDER`, where FOLDER holds mssp_plate_sweep/,
pyuff_accelerance_points/ and vibrationtesting_lab_frf/ as their repositories publish them; needs h5py.
"""

from __future__ import annotations

import argparse
import shutil
from pathlib import Path

import numpy as np
from tables import ROOT

from flexmodal.campaign import (
    Blow,
    Campaign,
    CampaignPoint,
    CampaignPosture,
    FrfRecords,
    Trial,
    write_campaign,
)

REAL = ROOT / "tests" / "data" / "real"
VIEWS = ("view_0", "view_0_02", "view_0_03", "view_0_04", "view_1")
ORIGIN = (0.0, 0.0, 0.0)


def plate(source: Path) -> None:
    """Five runs of a swept sine as five records of one trial: force and acceleration."""
    import h5py

    blows = []
    for number, view in enumerate(VIEWS, start=1):
        with h5py.File(source / f"{view}.hdf5") as file:
            data = np.asarray(file["InputTask"]["data"], dtype=float)
        time = np.arange(len(data)) / 25_600
        blows.append(Blow(1, 1, number, (1, 3), time, data[:, 0].copy(), ((2, 3),), data[None, :, 1].copy()))
    peak = float(max(np.abs(blow.force).max() for blow in blows))
    campaign = Campaign(
        title="Thin plate, swept sine from 60 to 500 Hz by a shaker",
        robot="none",
        band=(60.0, 500.0),
        postures=(CampaignPosture(1, "as mounted", {}),),
        points=(CampaignPoint(1, "shaker", "plate", ORIGIN), CampaignPoint(2, "sensor", "plate", ORIGIN)),
        trials=(Trial(1, round(peak, 3), len(VIEWS), "shaker", record_length=2.0),),
        blows=tuple(blows),
    )
    folder = REAL / "mssp_plate_sweep"
    if folder.exists():
        shutil.rmtree(folder)
    remark = "force and acceleration of the five HDF5 files as datasets 58b in time.uff, every digit kept"
    finish(source, write_campaign(campaign, folder), remark)


def beam(source: Path) -> None:
    """The UFF file as it was published, with a campaign.toml beside it."""
    folder = REAL / "free_free_beam"
    folder.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(source / "measurement.uff", folder / "frf.uff")
    lines = ["format = 1", 'title = "Three accelerances of a free-free beam"', "band = [10.0, 990.0]"]
    lines += ['robot = "none"', "", "[[posture]]", "id = 1", 'name = "as hung"', "q = {}"]
    for number in (1, 2, 3):
        lines += ["", "[[point]]", f"id = {number}", f'name = "point {number}"', 'link = "beam"']
        lines += ["xyz = [0.0, 0.0, 0.0] # not published"]
    lines += ["", "[[trial]]", "id = 1", "force_peak = 1.0 # not published", "averages = 1 # not published"]
    lines += ['tip = "not published"']
    (folder / "campaign.toml").write_text("\n".join(lines) + "\n", encoding="utf-8")
    finish(source, folder, "frf.uff is measurement.uff, unchanged; the text files were left out")


def laboratory(source: Path) -> None:
    """The analyser's averaged FRF of a hammer test; its units are not published and taken for SI."""
    from scipy.io import loadmat

    table = loadmat(source / "case1.mat")
    frequency = table["Freq_domain"].ravel().astype(float)
    value = table["Hf_chan_2"].ravel().astype(complex)[None, :]
    one, place = np.ones(1, dtype=int), np.array([[1, 3]])
    campaign = Campaign(
        title="Laboratory hammer test, one averaged FRF",
        robot="none",
        band=(190.0, 235.0),
        postures=(CampaignPosture(1, "as mounted", {}),),
        points=(CampaignPoint(1, "channel 2", "structure", ORIGIN),),
        trials=(Trial(1, 1.0, 1, "not published"),),
        frfs=FrfRecords(frequency, value, None, one, one, place, place, "receptance"),
    )
    folder = REAL / "laboratory_hammer"
    if folder.exists():
        shutil.rmtree(folder)
    remark = (
        "the FRF of case1.mat as dataset 58b, every digit kept; its coherence, above 1 in places, left out"
    )
    finish(source, write_campaign(campaign, folder), remark)


def finish(source: Path, folder: Path, remark: str) -> None:
    shutil.copyfile(source / "LICENSE", folder / "LICENSE")
    text = (source / "PROVENANCE.md").read_text(encoding="utf-8").rstrip("\n")
    text += f"\n- Here: {remark}. Made by benchmarks/campaign_real_data.py.\n"
    (folder / "PROVENANCE.md").write_text(text, encoding="utf-8")
    size = sum(path.stat().st_size for path in folder.iterdir())
    print(f"{folder.relative_to(ROOT)}: {size / 1e6:.1f} MB")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    source = parser.parse_args().folder
    REAL.mkdir(parents=True, exist_ok=True)
    plate(source / "mssp_plate_sweep")
    beam(source / "pyuff_accelerance_points")
    laboratory(source / "vibrationtesting_lab_frf")


if __name__ == "__main__":
    main()
