"""From the text of a `campaign.toml` to what was tested."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from flexmodal.campaign.consistency import add_contradictions
from flexmodal.campaign.description.tested import EXACT, CampaignPoint, CampaignPosture, Tested, Tolerance
from flexmodal.campaign.trial import Trial, Window
from flexmodal.errors import Fault, InvalidCampaign
from flexmodal.text.frozen import FrozenDict
from flexmodal.text.toml import parse_toml
from flexmodal.text.validation import validated
from flexmodal.text.words import FaultList

if TYPE_CHECKING:
    from flexmodal.campaign.description.schema import CampaignTable, PointTable, TrialTable


def read_toml(file: Path) -> Tested:
    """Read a `campaign.toml`.

    Raises:
        InvalidCampaign: with every fault of the file at once.
    """
    from flexmodal.campaign.description.schema import CampaignTable

    content = parse_toml(file, kind="a campaign.toml")
    if isinstance(content, Fault):
        raise InvalidCampaign(content)
    faults = FaultList(file)
    table = validated(CampaignTable, content, faults)
    if table is None:
        raise InvalidCampaign(faults.faults)
    tested = _tested(table)
    add_contradictions(faults, tested)
    if faults.faults:
        raise InvalidCampaign(faults.faults)
    return tested


def _tested(table: CampaignTable) -> Tested:
    return Tested(
        title=table.title,
        robot=table.robot,
        band=None if table.band is None else (table.band[0], table.band[1]),
        postures=tuple(
            CampaignPosture(p.id, p.name, FrozenDict(p.q), tuple(p.locked), FrozenDict(p.masses))
            for p in table.posture
        ),
        points=tuple(map(_point, table.point)),
        trials=tuple(_trial(trial) for trial in table.trial),
        separate_modes=table.separate_modes,
        tolerance=EXACT if table.tolerance is None else Tolerance(**table.tolerance.model_dump()),
        trace_lines=tuple(map(tuple, table.trace_lines)),
    )


def _point(table: PointTable) -> CampaignPoint:
    x, y, z = table.xyz
    if not isinstance(table.axes, list):
        return CampaignPoint(
            table.id, table.name, table.link, (x, y, z), frame="world" if table.axes is None else "link"
        )
    first, second, third = ((row[0], row[1], row[2]) for row in table.axes)
    frame = table.frame or "world"
    return CampaignPoint(table.id, table.name, table.link, (x, y, z), (first, second, third), frame)


def _trial(table: TrialTable) -> Trial:
    fields = table.model_dump(exclude={"window"})
    window = table.window
    return Trial(**fields, window="none" if window == "none" else Window(window.kind, window.decay))
