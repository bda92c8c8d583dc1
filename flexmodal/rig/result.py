"""A simulated campaign with what is behind it, and the folder it goes to."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from flexmodal.campaign import Campaign
from flexmodal.errors import Fault, OutputExists
from flexmodal.files import whole_set
from flexmodal.model import Robot
from flexmodal.rig.effects import Stand
from flexmodal.rig.plan import HammerPlan
from flexmodal.rig.plant.build import Hidden
from flexmodal.rig.robot_folder import write_robot
from flexmodal.rig.truth import Truth, truth_path


@dataclass(frozen=True, eq=False)
class RigResult:
    """A simulated campaign and what is behind it."""

    campaign: Campaign
    truth: Truth
    robot: Robot
    """As the tester believes it to be."""
    plan: HammerPlan
    stand: Stand
    hidden: tuple[Hidden, ...]

    def write(self, folder: str | Path, *, binary: bool = True) -> Path:
        """Write the campaign to a new folder and the truth beside it, both or neither.

        Args:
            folder: a new one.
            binary: whether universal files are binary.

        Returns:
            Where the truth is.

        Raises:
            OutputExists: the folder or the file of the truth is there already; nothing is written.
            NotWritten: the disk is full, or the folder may not be written.
        """
        from flexmodal.campaign import write_campaign

        target = Path(os.path.abspath(folder))
        refuse_existing(target)
        with whole_set([target, truth_path(target)]) as scratch:
            inside = scratch / target.name
            write_campaign(self.campaign, inside, binary=binary)
            write_robot(self.robot, inside, self.plan.postures, self.plan.points)
            self.truth.write(truth_path(inside))
        return truth_path(target)


def refuse_existing(folder: Path) -> None:
    """Complain where a campaign would land on something.

    Raises:
        OutputExists: folder or truth exist, or the folder they belong in does not.
    """
    faults = [
        Fault(str(path), "", "something that exists", "a new name")
        for path in (folder, truth_path(folder))
        if os.path.lexists(path)
    ]
    if not folder.parent.is_dir():
        faults.append(Fault(str(folder.parent), "", "no such folder", "an existing folder to put it in"))
    if faults:
        raise OutputExists(faults)
