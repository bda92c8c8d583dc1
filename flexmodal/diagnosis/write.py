"""A diagnosis as a folder: `diagnosis.json`, `report.html`, and the improved robot in `robot/`."""

from __future__ import annotations

from pathlib import Path

from flexmodal.diagnosis.as_json import as_json
from flexmodal.diagnosis.improved.extend import extend
from flexmodal.diagnosis.outcome import Diagnosis
from flexmodal.diagnosis.report import write_report
from flexmodal.files import whole_folder
from flexmodal.model import load
from flexmodal.model.written import CARD
from flexmodal.report import write_json

JSON, REPORT, ROBOT = "diagnosis.json", "report.html", "robot"
OWN = (JSON, REPORT, f"{ROBOT}/{CARD}", f"{ROBOT}/*.urdf")
"""All that a diagnosis writes: a folder that holds anything else is never replaced."""


def write_diagnosis(diagnosis: Diagnosis, folder: str | Path, *, overwrite: bool = False) -> None:
    """Write the folder whole or not at all.

    The robot is loaded once before the folder appears, as any card is.

    Args:
        diagnosis: what `diagnose` found.
        folder: a new folder.
        overwrite: replace a folder that an earlier diagnosis wrote and that holds nothing else.

    Raises:
        OutputExists: something stands there already, or its own folder does not exist.
        NotWritten: the disk is full, or the folder may not be written.
        InvalidInput: the improved robot is not one that loads.
    """
    target = Path(folder)
    found = as_json(diagnosis)
    extension = extend(diagnosis)
    with whole_folder(target, own=OWN, overwrite=overwrite) as scratch:
        robot = scratch / ROBOT
        robot.mkdir()
        extension.write(robot, home=target / ROBOT)
        load(robot / CARD)
        write_json(found, scratch / JSON)
        write_report(diagnosis, scratch / REPORT, notes=extension.notes)
