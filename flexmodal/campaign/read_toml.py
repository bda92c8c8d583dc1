"""From the text of a `campaign.toml` to what was tested."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from flexmodal.campaign.campaign import CampaignPoint, CampaignPosture
from flexmodal.campaign.toml_faults import ALLOWED, add_faults
from flexmodal.campaign.trial import Trial, Window
from flexmodal.errors import Fault, InvalidCampaign
from flexmodal.text.frozen import FrozenDict
from flexmodal.text.toml import parse_toml
from flexmodal.text.words import FaultList, shown

if TYPE_CHECKING:
    from flexmodal.campaign.schema import CampaignTable, TrialTable


@dataclass(frozen=True)
class Tested:
    """What a `campaign.toml` says."""

    title: str
    robot: str
    band: tuple[float, float] | None
    postures: tuple[CampaignPosture, ...]
    points: tuple[CampaignPoint, ...]
    trials: tuple[Trial, ...]


def read_toml(file: Path) -> Tested:
    """Read a `campaign.toml`.

    Raises:
        InvalidCampaign: with every fault of the file at once.
    """
    from pydantic import ValidationError

    from flexmodal.campaign.schema import CampaignTable

    content = parse_toml(file, kind="a campaign.toml")
    if isinstance(content, Fault):
        raise InvalidCampaign(content)
    faults = FaultList(file)
    try:
        table = CampaignTable.model_validate(content)
    except ValidationError as error:
        add_faults(faults, error.errors(include_url=False))
        raise InvalidCampaign(faults.faults) from None
    if type(content["format"]) is not int:  # true and 1.0 equal 1
        faults.add("format", shown(content["format"]), ALLOWED[""]["format"])
    tested = _tested(table)
    add_contradictions(faults, tested)
    if faults.faults:
        raise InvalidCampaign(faults.faults)
    return tested


def add_contradictions(faults: FaultList, tested: Any) -> None:
    """Add a fault for each id or name given twice, each repeat of no trial, and a band that runs backward.

    Args:
        faults: where they go.
        tested: anything with the fields of `Tested`.
    """
    for section, entries in (
        ("posture", tested.postures),
        ("point", tested.points),
        ("trial", tested.trials),
    ):
        _add_twice(faults, section, "id", [entry.id for entry in entries])
        if section != "trial":
            _add_twice(faults, section, "name", [entry.name for entry in entries])
    ids = {trial.id for trial in tested.trials}
    for place, trial in enumerate(tested.trials):
        if trial.repeat_of is not None and trial.repeat_of not in ids - {trial.id}:
            faults.add(f"trial[{place}].repeat_of", str(trial.repeat_of), "the id of another trial")
    if tested.band is not None and not 0 <= tested.band[0] < tested.band[1]:
        faults.add("band", f"{tested.band[0]:g} to {tested.band[1]:g}", ALLOWED[""]["band"])


def _add_twice(faults: FaultList, section: str, key: str, values: Sequence[object]) -> None:
    for place, value in enumerate(values):
        if value in values[:place]:
            first = values.index(value)
            faults.add(
                f"{section}[{place}].{key}", f"{shown(value)}, as in {section}[{first}]", "one of its own"
            )


def _tested(table: CampaignTable) -> Tested:
    return Tested(
        title=table.title,
        robot=table.robot,
        band=None if table.band is None else (table.band[0], table.band[1]),
        postures=tuple(CampaignPosture(p.id, p.name, FrozenDict(p.q)) for p in table.posture),
        points=tuple(
            CampaignPoint(p.id, p.name, p.link, (p.xyz[0], p.xyz[1], p.xyz[2])) for p in table.point
        ),
        trials=tuple(_trial(trial) for trial in table.trial),
    )


def _trial(table: TrialTable) -> Trial:
    fields = table.model_dump(exclude={"window"})
    window = table.window
    return Trial(**fields, window="none" if window == "none" else Window(window.kind, window.decay))
