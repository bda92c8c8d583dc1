"""The tip of a cutter in a posture of which FRFs were predicted: what `flexmodal predict` wrote, as a tip.

Of receptances H_ij at one point along unit vectors u_i under forces along v_j, the receptance in the world is
that α of least norm with u_iᵀ α v_j = H_ij, and αᵀ where only that is known. Along directions that nobody
struck or measured it is 0: there the arm counts as rigid.
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.errors import Fault, InvalidCut
from flexmodal.machining.cut import Cut
from flexmodal.machining.measured_tip import MeasuredTip
from flexmodal.machining.tip import modal_tip
from flexmodal.model import Posture, Robot
from flexmodal.model.placements import link_placements
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
    placed = link_placements(robot, posture.values)
    at = cut.frame.point or robot.tool
    turn = placed[robot.points[at].link if at in robot.points else at][:3, :3]
    axes = cut.frame.rows @ turn.T if cut.frame.relative_to == "tool" else cut.frame.rows
    beside = np.zeros((len(frequency), 3, 3), dtype=complex)
    if cut.modes:
        beside += modal_tip(cut.modes).receptance(frequency)
    if added is not None:
        beside += added.receptance(frequency)
    found: dict[str, MeasuredTip] = {}
    rigid = 0
    for kind in ("re", "high", "low"):
        world, seen = _in_world(content, point, kind)
        rigid = 3 - seen
        found[kind] = MeasuredTip(frequency, np.einsum("ai,lij,bj->lab", axes, world, axes) + beside)
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
    wanted = cut.frame.point or robot.tool
    names = dict.fromkeys(way.rpartition(":")[0] for way in content["ways"])
    if any(cut.frame.offset):
        found = f"{listing(map(str, cut.frame.offset))} m from {wanted}"
        raise InvalidCut(Fault("cut", "frame.offset", found, "0: the tip is where the FRFs are predicted"))
    if wanted in names:
        return wanted
    posed = robot.at(posture)
    place = posed.position(wanted)
    for name in names:
        if name in robot.points and np.linalg.norm(posed.position(name) - place) < AT:
            return name
    allowed = f"a cut at one of them (frame.point), or FRFs struck and measured at {wanted}"
    raise InvalidCut(Fault(str(file), "frfs", f"FRFs at {listing(names)}", allowed))


def _in_world(
    content: Mapping[str, Any], point: str, kind: str
) -> tuple[Complex[np.ndarray, "line 3 3"], int]:
    """Receptance of the point in the world [m/N], and along how many directions anything is known.

    Args:
        content: of the file.
        point: its name there.
        kind: "re" for the prediction itself, "high" or "low" for an end of its band.
    """
    own = [
        one for one in content["frfs"]
        if one["response"].rpartition(":")[0] == point == one["reference"].rpartition(":")[0]
    ]  # fmt: skip
    if not own:
        raise InvalidCut(Fault("prediction", "frfs", f"no FRF between two directions at {point}", "one"))
    responses = list(dict.fromkeys(one["response"] for one in own))
    references = list(dict.fromkeys(one["reference"] for one in own))
    value = np.zeros((len(content["frequency"]), len(responses), len(references)), dtype=complex)
    known: dict[tuple[str, str], np.ndarray] = {}
    for one in own:
        h = np.array(one["re"]) + 1j * np.array(one["im"])
        if kind != "re":
            h = h * np.array(one[kind]) / np.maximum(np.abs(h), 1e-300)
        known[one["response"], one["reference"]] = h
    for r, f in product(responses, references):
        if (r, f) not in known and (f, r) not in known:
            raise InvalidCut(
                Fault("prediction", "frfs", f"no FRF of {r} per {f}", "every pair, or its mirror")
            )
        value[:, responses.index(r), references.index(f)] = known.get((r, f), known.get((f, r)))
    left, right = (_inverse([content["ways"][name] for name in names]) for names in (responses, references))
    alpha = np.einsum("ai,lij,bj->lab", left[0], value, right[0])
    mirrored = np.swapaxes(alpha, 1, 2)
    alpha = alpha + mirrored - left[1] @ mirrored @ right[1]
    return alpha, int(np.linalg.matrix_rank(np.vstack([left[1], right[1]])))


def _inverse(ways: list[list[float]]) -> tuple[Float[np.ndarray, "3 way"], Float[np.ndarray, "3 3"]]:
    """Pseudo-inverse of unit vectors as rows, and the projection onto what they span."""
    rows = np.array(ways, dtype=float)
    inverse = np.linalg.pinv(rows)
    return inverse, inverse @ rows
