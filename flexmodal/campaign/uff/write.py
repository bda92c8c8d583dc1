"""FRFs and blows as datasets 58 and 58b, one after the other in a file."""

from __future__ import annotations

import tempfile
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from flexmodal.campaign.blow import Blow
from flexmodal.campaign.campaign import Campaign
from flexmodal.campaign.description.tested import CampaignPoint
from flexmodal.campaign.records import FrfRecords
from flexmodal.campaign.uff.codes import (
    ACCELERATION,
    CODE_OF,
    COHERENCE,
    DISPLACEMENT,
    EXPONENTS,
    FORCE,
    FRF,
    TIME_RESPONSE,
    VELOCITY,
)
from flexmodal.campaign.uff.frame import framed

_UNIT = {DISPLACEMENT: "m", VELOCITY: "m/s", ACCELERATION: "m/s^2", FORCE: "N", 0: "NONE"}
_SECONDS, _HERTZ = 17, 18
DIGITS = 1e-9
"""An axis is written as start and step where the six digits of these hold it this well, in steps."""


def write_uff(datasets: Iterable[dict[str, Any]], path: Path) -> None:
    """Write datasets to a new file. A `Campaign` has refused what dataset 58 cannot hold.

    Args:
        datasets: as pyuff takes them.
        path: a new file.
    """
    with tempfile.TemporaryDirectory(prefix="flexmodal-") as folder, path.open("wb") as file:
        piece = Path(folder) / "piece.uff"
        for dataset in datasets:
            file.write(framed(dataset, piece))


def frf_datasets(frfs: FrfRecords, points: Iterable[CampaignPoint], binary: bool) -> Iterator[dict[str, Any]]:
    """Each FRF, followed by its coherence where there is one.

    Args:
        frfs: in SI units of their form.
        points: whose names go into the records.
        binary: whether as dataset 58b.
    """
    names = {point.id: point.name for point in points}
    axis = _abscissa(frfs.frequency, _HERTZ, binary)
    code = CODE_OF[frfs.form]
    for row in range(len(frfs)):
        common = {
            **_places(frfs.response[row].tolist(), frfs.reference[row].tolist(), names),
            **axis,
            "load_case_id": int(frfs.posture[row]),
            "ver_num": int(frfs.trial[row]),
            "func_id": 1,
            "binary": int(binary),
        }
        yield {"func_type": FRF, "data": frfs.value[row], **_ordinate(code, FORCE), **common}
        if frfs.coherence is not None:
            yield {"func_type": COHERENCE, "data": frfs.coherence[row], **_ordinate(0, 0), **common}


def blow_datasets(
    blows: Iterable[Blow], points: Iterable[CampaignPoint], binary: bool
) -> Iterator[dict[str, Any]]:
    """The force of each blow, followed by its responses.

    Args:
        blows: time records in SI units.
        points: whose names go into the records.
        binary: whether as dataset 58b.
    """
    names = {point.id: point.name for point in points}
    forces = set()
    for blow in blows:
        common = {
            **_abscissa(blow.time, _SECONDS, binary),
            "load_case_id": blow.posture,
            "ver_num": blow.trial,
            "func_id": blow.sequence,
            "func_type": TIME_RESPONSE,
            "binary": int(binary),
        }
        key = (blow.posture, blow.trial, blow.sequence, blow.reference)
        if key not in forces:  # another quantity of the same blow shares its force
            forces.add(key)
            places = _places(blow.reference, blow.reference, names)
            yield {"data": blow.force, **_ordinate(FORCE, 0), **places, **common}
        for channel, values in zip(blow.channels, blow.response, strict=True):
            places = _places(channel, blow.reference, names)
            yield {"data": values, **_ordinate(CODE_OF[blow.quantity], 0), **places, **common}


def _places(response: Any, reference: Any, names: dict[int, str]) -> dict[str, Any]:
    place: dict[str, Any] = {"type": 58}
    for key, (node, direction) in (("rsp", response), ("ref", reference)):
        name = names[node].encode("ascii", "replace").decode().strip()
        plain = "".join(letter if letter.isprintable() else "?" for letter in name)
        place |= {f"{key}_node": node, f"{key}_dir": direction, f"{key}_ent_name": plain[:10] or "NONE"}
    return place


def _abscissa(axis: np.ndarray, code: int, binary: bool) -> dict[str, Any]:
    """Start and step where six digits of them hold the axis, or where ASCII would hold it no better."""
    start, step = float(f"{axis[0]:.5e}"), float(f"{axis[1] - axis[0]:.5e}")
    held = np.abs(start + step * np.arange(len(axis)) - axis).max() <= DIGITS * step
    even = np.abs(np.linspace(axis[0], axis[-1], len(axis)) - axis).max() <= DIGITS * step
    return {
        "x": axis,
        "abscissa_spacing": int(held or (even and not binary)),
        "abscissa_spec_data_type": code,
        "abscissa_axis_lab": "Time" if code == _SECONDS else "Frequency",
        "abscissa_axis_units_lab": "s" if code == _SECONDS else "Hz",
    }


def _ordinate(numerator: int, denominator: int) -> dict[str, Any]:
    fields: dict[str, Any] = {}
    for key, code in (("ordinate", numerator), ("orddenom", denominator)):
        length, force = EXPONENTS[code]
        fields |= {
            f"{key}_spec_data_type": code,
            f"{key}_axis_units_lab": _UNIT[code],
            f"{key}_len_unit_exp": length,
            f"{key}_force_unit_exp": force,
        }
    return fields


def has_data(campaign: Campaign) -> bool:
    """Whether there is anything measured in it."""
    return campaign.frfs is not None or bool(campaign.blows) or campaign.modes is not None
