"""From receptances at one point, along whatever was struck and measured there, to the tip of a cutter.

Of receptances H_ij along unit vectors u_i under forces along v_j, the receptance in the world is that α of
least norm with u_iᵀ α v_j = H_ij, and αᵀ where only that is known. Along directions that nobody struck or
measured it is 0: there the arm counts as rigid.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.errors import Fault, InvalidCut
from flexmodal.machining.cut import Cut
from flexmodal.machining.measured_tip import MeasuredTip
from flexmodal.machining.tip import modal_tip
from flexmodal.model import PosedRobot
from flexmodal.model.placements import link_placements
from flexmodal.text.words import listing


def world_receptance(
    known: Mapping[tuple[str, str], Complex[np.ndarray, " line"]], ways: Mapping[str, Sequence[float]]
) -> tuple[Complex[np.ndarray, "line 3 3"], int]:
    """Receptance of a point in the world [m/N], and along how many directions anything is known.

    Args:
        known: displacement over force by the names of the two directions, one pair or more.
        ways: unit vector in the world of each direction.

    Raises:
        InvalidCut: a pair is missing, and its mirror too.
    """
    responses, references = (list(dict.fromkeys(pair[side] for pair in known)) for side in (0, 1))
    lines = len(next(iter(known.values())))
    value = np.zeros((lines, len(responses), len(references)), dtype=complex)
    for r, f in product(responses, references):
        if (r, f) not in known and (f, r) not in known:
            raise InvalidCut(
                Fault("prediction", "frfs", f"no FRF of {r} per {f}", "every pair, or its mirror")
            )
        value[:, responses.index(r), references.index(f)] = known.get((r, f), known.get((f, r)))
    left, right = (_inverse([ways[name] for name in names]) for names in (responses, references))
    alpha = np.einsum("ai,lij,bj->lab", left[0], value, right[0])
    mirrored = np.swapaxes(alpha, 1, 2)
    alpha = alpha + mirrored - left[1] @ mirrored @ right[1]
    return alpha, int(np.linalg.matrix_rank(np.vstack([left[1], right[1]])))


def tip_in_cut(
    posed: PosedRobot,
    cut: Cut,
    frequency: Float[np.ndarray, " line"],
    world: Complex[np.ndarray, "line 3 3"],
    added: MeasuredTip | None = None,
) -> MeasuredTip:
    """The tip in the frame of the cut, with the modes of its tool and a measured receptance.

    Args:
        posed: the robot in the posture, whose link the frame may turn with.
        cut: with the point, the axes and the tool's own modes.
        frequency: of the lines [Hz].
        world: receptance of the point in the world [m/N].
        added: measured receptance of tool and spindle, in the frame of the cut.

    Raises:
        InvalidFrequencies: `added` does not cover the lines.
    """
    robot = posed.robot
    placed = link_placements(robot, posed.posture.values)
    at = cut.frame.point or robot.tool
    turn = placed[robot.points[at].link if at in robot.points else at][:3, :3]
    axes = cut.frame.rows @ turn.T if cut.frame.relative_to == "tool" else cut.frame.rows
    value = np.einsum("ai,lij,bj->lab", axes, world, axes)
    if cut.modes:
        value = value + modal_tip(cut.modes).receptance(frequency)
    if added is not None:
        value = value + added.receptance(frequency)
    return MeasuredTip(frequency, value)


def point_of_cut(posed: PosedRobot, cut: Cut) -> str:
    """The point that a cut is at, which has to be one without an offset.

    Args:
        posed: the robot whose tool it is, if the cut names no point.
        cut: the cut.

    Raises:
        InvalidCut: the tip stands off the point.
    """
    wanted = cut.frame.point or posed.robot.tool
    if any(cut.frame.offset):
        found = f"{listing(map(str, cut.frame.offset))} m from {wanted}"
        raise InvalidCut(Fault("cut", "frame.offset", found, "0: the tip is where the FRFs are predicted"))
    return wanted


def _inverse(ways: list[Sequence[float]]) -> tuple[Float[np.ndarray, "3 way"], Float[np.ndarray, "3 3"]]:
    """Pseudo-inverse of unit vectors as rows, and the projection onto what they span."""
    rows = np.array(ways, dtype=float)
    inverse = np.linalg.pinv(rows)
    return inverse, inverse @ rows
