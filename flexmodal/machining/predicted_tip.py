"""The tip of a cutter in a posture of which FRFs were predicted: what `flexmodal predict` wrote, as a tip."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Complex

from flexmodal.errors import Fault, InvalidCut
from flexmodal.machining.cut import Cut
from flexmodal.machining.measured_tip import MeasuredTip
from flexmodal.machining.world import point_of_cut, tip_in_cut, world_receptance
from flexmodal.model import Posture, Robot
from flexmodal.text.reading import read_regular
from flexmodal.text.words import listing

AT = 1e-3
"""Distance within which a point that was predicted is the point of the cut [m]."""
WRITTEN = "what flexmodal predict --out FILE.json wrote"
_LARGEST = 500_000_000


@dataclass(frozen=True, eq=False)
class PredictedTip:
    """A tip, and what it may be with a probability of 95 %."""

    posture: Posture
    tip: MeasuredTip
    softer: MeasuredTip
    """Every receptance as large as its band allows."""
    stiffer: MeasuredTip
    """As small."""
    rigid: int
    """Directions of the world, 0 to 2, along which nothing was predicted."""


def read_predicted_tip(
    path: str | os.PathLike[str], robot: Robot, cut: Cut, added: MeasuredTip | None = None
) -> PredictedTip:
    """Read a prediction as the tip of a cut.

    Args:
        path: a .json that `flexmodal predict` wrote.
        robot: of the prediction, for where the cut is.
        cut: with the point, the axes and the tool's own modes.
        added: measured receptance of tool and spindle, in the frame of the cut.

    Raises:
        InvalidCut: no prediction, of other joints, or of no point of the cut.
        InvalidFrequencies: `added` does not cover the predicted lines.
    """
    file = Path(os.path.abspath(path))
    content = _content(file)
    posture = robot.posture({str(k): float(v) for k, v in content["posture"].items()}, source=str(file))
    point = _point(file, content, robot, posture, cut)
    frequency = np.array(content["frequency"], dtype=float)
    found: dict[str, MeasuredTip] = {}
    rigid = 0
    for kind in ("re", "high", "low"):
        world, seen = world_receptance(_known(content, point, kind), content["ways"])
        rigid = 3 - seen
        found[kind] = tip_in_cut(robot.at(posture), cut, frequency, world, added)
    return PredictedTip(posture, found["re"], found["high"], found["low"], rigid)


def _content(file: Path) -> dict[str, Any]:
    """What stands in the file, if it is a prediction."""
    raw = read_regular(file, limit=_LARGEST, kind="a prediction")
    if isinstance(raw, Fault):
        raise InvalidCut(raw)
    try:
        content = json.loads(raw)
        lines = len(content["frequency"])
        sound = isinstance(content["posture"], dict) and lines > 1 and bool(content["frfs"])
        for one in content["frfs"]:
            sound = sound and {one["response"], one["reference"]} <= set(content["ways"])
            for key in ("re", "im", "low", "high"):
                sound = sound and len(one[key]) == lines and all(math.isfinite(x) for x in one[key])
        sound = sound and all(
            len(way) == 3 and all(math.isfinite(part) for part in way) for way in content["ways"].values()
        )
    except (ValueError, KeyError, TypeError):
        sound = False
    if not sound:
        raise InvalidCut(Fault(str(file), "", "no prediction of FRFs", WRITTEN))
    assert isinstance(content, dict)
    return content


def _point(file: Path, content: Mapping[str, Any], robot: Robot, posture: Posture, cut: Cut) -> str:
    """The predicted point that the cut is at: of its name, or of its place."""
    posed = robot.at(posture)
    wanted = point_of_cut(posed, cut)
    names = dict.fromkeys(way.rpartition(":")[0] for way in content["ways"])
    if wanted in names:
        return wanted
    place = posed.position(wanted)
    for name in names:
        if name in robot.points and np.linalg.norm(posed.position(name) - place) < AT:
            return name
    allowed = f"a cut at one of them (frame.point), or FRFs struck and measured at {wanted}"
    raise InvalidCut(Fault(str(file), "frfs", f"FRFs at {listing(names)}", allowed))


def _known(
    content: Mapping[str, Any], point: str, kind: str
) -> dict[tuple[str, str], Complex[np.ndarray, " line"]]:
    """Receptances of the point by the names of their directions [m/N].

    Args:
        content: of the file.
        point: its name there.
        kind: "re" for the prediction itself, "high" or "low" for an end of its band.
    """
    known: dict[tuple[str, str], np.ndarray] = {}
    for one in content["frfs"]:
        if not one["response"].rpartition(":")[0] == point == one["reference"].rpartition(":")[0]:
            continue
        h = np.array(one["re"]) + 1j * np.array(one["im"])
        if kind != "re":
            h = h * np.array(one[kind]) / np.maximum(np.abs(h), 1e-300)
        known[one["response"], one["reference"]] = h
    if not known:
        raise InvalidCut(Fault("prediction", "frfs", f"no FRF between two directions at {point}", "one"))
    return known
