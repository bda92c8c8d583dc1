"""A campaign to a folder, written whole or not at all."""

from __future__ import annotations

import json
import math
import os
import re
from dataclasses import asdict
from pathlib import Path

from flexmodal.campaign.campaign import Campaign
from flexmodal.campaign.description.tested import CampaignPoint
from flexmodal.campaign.read_campaign import FRF, MODES, TIME, TOML
from flexmodal.campaign.tables.modes import write_modes
from flexmodal.campaign.trial import Trial, Window
from flexmodal.campaign.uff.write import blow_datasets, frf_datasets, has_data, write_uff
from flexmodal.errors import Fault, InvalidCampaign
from flexmodal.files import whole_folder

_BARE = re.compile(r"[A-Za-z0-9_-]+")


def write_campaign(
    campaign: Campaign, folder: str | os.PathLike[str], *, binary: bool = True, overwrite: bool = False
) -> Path:
    """Write a campaign.

    Binary files hold every number exactly. ASCII files hold twelve digits of the values and six of the axis.

    Args:
        campaign: what to write.
        folder: the new folder; its parent has to exist.
        binary: dataset 58b instead of 58.
        overwrite: replace a campaign that stands there; a folder that holds anything else stays.

    Returns:
        The folder, absolute.

    Raises:
        OutputExists: something stands there that may not be replaced, or the parent does not exist.
        InvalidCampaign: there is nothing measured to write.
    """
    target = Path(os.path.abspath(folder))
    if not has_data(campaign):
        raise InvalidCampaign(Fault(str(target), "", "no data", "FRFs, blows or modes"))
    with whole_folder(target, own=(TOML, FRF, TIME, MODES), overwrite=overwrite) as scratch:
        (scratch / TOML).write_text(campaign_toml(campaign), encoding="utf-8")
        if campaign.frfs is not None:
            write_uff(frf_datasets(campaign.frfs, campaign.points, binary), scratch / FRF)
        if campaign.blows:
            write_uff(blow_datasets(campaign.blows, campaign.points, binary), scratch / TIME)
        if campaign.modes is not None:
            write_modes(campaign.modes, scratch / MODES)
    return target


def campaign_toml(campaign: Campaign) -> str:
    """The text of `campaign.toml`."""
    lines = ["format = 1", f"title = {_text(campaign.title)}"]
    if math.isfinite(campaign.band[1]):
        lines.append(f"band = {list(map(float, campaign.band))}")
    lines.append(f"robot = {_text(campaign.robot)}")
    if campaign.separate_modes:
        lines.append("separate_modes = true")
    if campaign.trace_lines:
        lines.append(f"trace_lines = {[list(map(int, one)) for one in campaign.trace_lines]}")
    if not campaign.tolerance.is_exact:
        lines += ["", "[tolerance]"]
        lines += [f"{name} = {float(value)!r}" for name, value in asdict(campaign.tolerance).items()]
    for posture in campaign.postures:
        angles = ", ".join(f"{_key(joint)} = {float(angle)!r}" for joint, angle in posture.q.items())
        q = f"{{ {angles} }}" if angles else "{}"
        lines += ["", "[[posture]]", f"id = {posture.id}", f"name = {_text(posture.name)}", f"q = {q}"]
        if posture.locked:
            lines.append(f"locked = [{', '.join(map(_text, posture.locked))}]")
        if posture.masses:
            bolted = ", ".join(f"{_key(name)} = {float(mass)!r}" for name, mass in posture.masses.items())
            lines.append(f"masses = {{ {bolted} }}")
    for point in campaign.points:
        lines += ["", "[[point]]", f"id = {point.id}", f"name = {_text(point.name)}"]
        lines += [f"link = {_text(point.link)}", f"xyz = {list(map(float, point.xyz))}", *_axes(point)]
    for trial in campaign.trials:
        lines += ["", "[[trial]]", *_trial(trial)]
    return "\n".join(lines) + "\n"


def _axes(point: CampaignPoint) -> list[str]:
    if point.axes is None:
        return ['axes = "link"'] if point.frame == "link" else []
    return [f"axes = {[list(map(float, row)) for row in point.axes]}", f'frame = "{point.frame}"']


def _trial(trial: Trial) -> list[str]:
    lines = [
        f"id = {trial.id}",
        f"force_peak = {float(trial.force_peak)!r}",
        f"averages = {trial.averages}",
        f"tip = {_text(trial.tip)}",
    ]
    if trial.record_length is not None:
        lines.append(f"record_length = {float(trial.record_length)!r}")
    if isinstance(trial.window, Window):
        lines.append(f'window = {{ kind = "{trial.window.kind}", decay = {float(trial.window.decay)!r} }}')
    if trial.repeat_of is not None:
        lines.append(f"repeat_of = {trial.repeat_of}")
    return lines


def _text(text: str) -> str:
    """A TOML basic string: JSON's escapes are TOML's, but for the delete character and half surrogates."""
    whole = text.encode("utf-8", "replace").decode("utf-8")
    return json.dumps(whole, ensure_ascii=False).replace("\x7f", "\\u007f")


def _key(name: str) -> str:
    return name if _BARE.fullmatch(name) else _text(name)
