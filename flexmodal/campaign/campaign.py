"""A campaign of measurements: what was tested, how, and the data, as frozen dataclasses."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Never

from flexmodal.campaign.blow import Blow
from flexmodal.campaign.consistency import campaign_faults
from flexmodal.campaign.description.tested import EXACT, CampaignPoint, CampaignPosture, Tolerance
from flexmodal.campaign.mode_table import ModeTable
from flexmodal.campaign.records import FrfRecords
from flexmodal.campaign.trial import Trial
from flexmodal.errors import Fault, InvalidCampaign
from flexmodal.text.shown import Shown, several

LOWEST = 2.0
"""Where the lines to compare begin when the campaign does not say [Hz]."""


@dataclass(frozen=True, eq=False, repr=False)
class Campaign(Shown):
    """A sound campaign: every record belongs to a posture, points and a trial that are described.

    Raises:
        InvalidCampaign: with every contradiction at once.
    """

    title: str
    robot: str
    """A card's name, or a path relative to the campaign's folder; not looked up here."""
    band: tuple[float, float]
    """The lines to compare [Hz]; the upper end is infinite where neither the file nor the data give one."""
    postures: tuple[CampaignPosture, ...]
    points: tuple[CampaignPoint, ...]
    trials: tuple[Trial, ...]
    frfs: FrfRecords | None = None
    blows: tuple[Blow, ...] = ()
    modes: ModeTable | None = None
    path: Path | None = None
    """The folder it was read from."""
    warnings: tuple[str, ...] = ()
    """What is odd about it but does not keep it from being used."""
    separate_modes: bool = False
    """Whether the modes are a measurement of their own, not an estimate from these FRFs."""
    tolerance: Tolerance = EXACT
    """How well the test was set up."""
    trace_lines: tuple[tuple[int, ...], ...] = ()
    """Ids of points that a picture joins one after the other."""

    def __post_init__(self) -> None:
        faults = campaign_faults(self, self.frfs, self.blows, self.modes, self.path)
        if faults:
            raise InvalidCampaign(faults)

    def _facts(self) -> Mapping[str, object]:
        counts = {
            "FRFs": 0 if self.frfs is None else len(self.frfs),
            "blows": len(self.blows),
            "modes": 0 if self.modes is None else len(self.modes),
        }
        return {
            "": self.title,
            "robot": self.robot,
            "postures": several((posture.name for posture in self.postures), 4),
            "points": several((point.name for point in self.points), 4),
            "data": ", ".join(f"{count} {kind}" for kind, count in counts.items() if count) or "none",
        }

    def to_xarray(self) -> Any:
        """Its FRFs as a data set with the names of postures; see `FrfRecords.to_xarray`.

        Raises:
            InvalidCampaign: it has no FRFs.
            MissingExtra: xarray is not installed.
        """
        if self.frfs is None:
            raise InvalidCampaign(Fault(self.title, "frfs", "none", "a campaign with measured FRFs"))
        names = {posture.id: posture.name for posture in self.postures}
        found = self.frfs.to_xarray()
        named = [names[int(one)] for one in self.frfs.posture]
        return found.assign_coords(posture_name=("record", named)).assign_attrs(title=self.title)

    def posture(self, which: int | str) -> CampaignPosture:
        """The posture of that id or name; KeyError without one."""
        return next((p for p in self.postures if which in (p.id, p.name)), None) or _missing(which)

    def point(self, which: int | str) -> CampaignPoint:
        """The point of that id or name; KeyError without one."""
        return next((p for p in self.points if which in (p.id, p.name)), None) or _missing(which)

    def trial(self, which: int) -> Trial:
        """The trial of that id; KeyError without one."""
        return next((t for t in self.trials if t.id == which), None) or _missing(which)


def default_band(frfs: FrfRecords | None, blows: tuple[Blow, ...]) -> tuple[float, float]:
    """From 2 Hz to the last line: of the FRFs, else of the spectra of the blows, else without end [Hz].

    Args:
        frfs: the FRFs of a campaign, if any.
        blows: its hammer blows.
    """
    if frfs is not None:
        last = float(frfs.frequency[-1])
    elif blows:
        last = min(0.5 / blow.step for blow in blows)
    else:
        last = math.inf
    return (min(LOWEST, last / 2), last)


def _missing(which: object) -> Never:
    raise KeyError(which)
