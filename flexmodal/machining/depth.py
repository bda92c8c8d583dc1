"""Depth of cut as a judge of postures."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from jaxtyping import Float

from flexmodal.cards import FamilyCard
from flexmodal.errors import Fault, InvalidRequest
from flexmodal.machining.cut import Cut
from flexmodal.machining.forced import ForcedSweep, forced_sweep
from flexmodal.machining.measured_tip import MeasuredTip
from flexmodal.machining.stability.lobes import Lobes
from flexmodal.machining.stability.mode_coupling import ModeCoupling, mode_coupling
from flexmodal.machining.stability.solve import stability_lobes, unconditional_depth
from flexmodal.machining.tip import tool_tip
from flexmodal.machining.tip_receptance import TipReceptance
from flexmodal.machining.tip_source import TipSource, tip_at
from flexmodal.model import Pose, PosedRobot, Posture, Robot
from flexmodal.text.shown import Shown

SPEEDS, FEW = 200, 24
"""How many spindle speeds postures are compared at, and searched by, if nobody says."""


@dataclass(frozen=True, eq=False, repr=False)
class PostureDepth(Shown):
    """What a posture allows a cut."""

    posture: Posture
    lobes: Lobes
    """The stability limit over the cut's range of speeds."""
    unconditional: tuple[float, float]
    """Depth stable at every speed, in range or not [m], and the frequency that limits it [Hz]."""
    coupling: ModeCoupling
    """Where the modes feed each other without regeneration."""
    forced: ForcedSweep | None = None
    """Forced vibration at the cut's own depth, if it says one."""
    parameter: float | None = None
    """Of the family, if there is one [rad, or m]."""
    _PICTURE: ClassVar[str] = "flexmodal.machining.report:lobes_picture_of"

    def _facts(self) -> Mapping[str, object]:
        return {"at": self.posture, "critical depth [mm]": 1e3 * self.critical_depth}

    @property
    def critical_depth(self) -> float:
        """Depth stable at every speed of the range [m]."""
        return self.lobes.critical_depth


@dataclass(frozen=True, eq=False, repr=False)
class Comparison(Shown):
    """Postures of one robot, judged by the depth of one cut."""

    robot: Robot
    cut: Cut
    postures: tuple[PostureDepth, ...]
    """In the order given."""
    family: str | None = None
    _PICTURE: ClassVar[str] = "flexmodal.machining.plot:draw_comparison"

    def _facts(self) -> Mapping[str, object]:
        best = self.postures[self.best]
        return {
            "": self.robot.name,
            "postures": len(self.postures),
            "best": best.posture,
            "its critical depth [mm]": 1e3 * best.critical_depth,
        }

    @property
    def best(self) -> int:
        """Which posture allows the greatest critical depth; of equals the first."""
        return int(np.argmax([one.critical_depth for one in self.postures]))

    @property
    def gain(self) -> float:
        """Greatest critical depth over the least."""
        depths = [one.critical_depth for one in self.postures]
        return float(max(depths) / min(depths)) if min(depths) < np.inf else 1.0


def critical_depth(
    robot: Robot,
    pose: Pose,
    cut: Cut,
    *,
    spindle_speed: float | None = None,
    added: MeasuredTip | None = None,
) -> float:
    """Axial depth of cut below which a cut is stable in a posture, by the zero-order solution [m].

    Args:
        robot: the robot.
        pose: its posture.
        cut: the cut.
        spindle_speed: the speed meant [rev/min]; every speed of the cut's range if none.
        added: measured receptance of tool and spindle at the tip, in the frame of the cut.

    Returns:
        The depth; infinite where nothing limits it.

    Raises:
        InvalidPosture, InvalidPoint, InvalidRequest: bad arguments.
        SingularResponse: a mode that the tip sees has no damping.
    """
    tip = tool_tip(robot.at(pose), cut, added)
    speeds = SPEEDS if spindle_speed is None else np.array([float(spindle_speed)])
    return stability_lobes(tip, cut, speeds=speeds).critical_depth


def depth_over(
    cut: Cut, *, speeds: int = FEW, added: MeasuredTip | None = None, tips: TipSource | None = None
) -> Callable[[PosedRobot], float]:
    """The least depth over the cut's range of speeds as a function of the posed robot, for a search [m].

    Args:
        cut: the cut.
        speeds: at how many it is taken, evenly in their logarithm; in between it may be less.
        added: measured receptance of tool and spindle at the tip, in the frame of the cut.
        tips: where tips come from, such as a prediction; the robot itself if None.
    """
    axis = np.geomspace(*cut.engagement.spindle_speed, speeds)

    def depth(posed: PosedRobot) -> float:
        return stability_lobes(tip_at(posed, cut, added, tips), cut, speeds=axis).critical_depth

    return depth


def lobes(
    robot: Robot,
    pose: Pose,
    cut: Cut,
    *,
    method: str = "zero-order",
    speeds: int | Float[np.ndarray, " speed"] | None = None,
    added: MeasuredTip | None = None,
    parameter: float | None = None,
    forced: bool = True,
    tips: TipSource | None = None,
    advance: Callable[[], None] = lambda: None,
) -> PostureDepth:
    """Stability lobes of a cut in a posture, with everything else that the posture allows it.

    Args:
        robot: the robot.
        pose: its posture.
        cut: the cut.
        method: see `stability_lobes`.
        speeds: see `stability_lobes`.
        added: measured receptance of tool and spindle at the tip, in the frame of the cut.
        parameter: of the family, to be carried along.
        forced: whether forced vibration is wanted, where the cut says feed and depth.
        tips: where tips come from, such as a prediction; the robot itself if None.
        advance: see `stability_lobes`.

    Raises:
        FlexmodalError: as `critical_depth` and `stability_lobes`.
    """
    posed = robot.at(pose)
    return lobes_of_tip(
        tip_at(posed, cut, added, tips), posed.posture, cut, method=method, speeds=speeds,
        parameter=parameter, forced=forced, advance=advance,
    )  # fmt: skip


def lobes_of_tip(
    tip: TipReceptance,
    posture: Posture,
    cut: Cut,
    *,
    method: str = "zero-order",
    speeds: int | Float[np.ndarray, " speed"] | None = None,
    parameter: float | None = None,
    forced: bool = True,
    advance: Callable[[], None] = lambda: None,
) -> PostureDepth:
    """The same for a tip that is known otherwise, by a prediction say.

    Args:
        tip: receptance of the tip, in the frame of the cut.
        posture: that it is of.
        cut: the cut.
        method: see `stability_lobes`.
        speeds: see `stability_lobes`.
        parameter: of the family, to be carried along.
        forced: whether forced vibration is wanted, where the cut says feed and depth.
        advance: see `stability_lobes`.

    Raises:
        FlexmodalError: as `stability_lobes`.
    """
    found = stability_lobes(tip, cut, method=method, speeds=speeds, advance=advance)
    return PostureDepth(
        posture=posture,
        lobes=found,
        unconditional=unconditional_depth(tip, cut),
        coupling=mode_coupling(tip, cut),
        forced=forced_sweep(tip, cut, found.speed) if forced and cut.engagement.depth else None,
        parameter=parameter,
    )


def compare_postures(
    robot: Robot,
    poses: Sequence[Pose],
    cut: Cut,
    *,
    speeds: int = SPEEDS,
    added: MeasuredTip | None = None,
    tips: TipSource | None = None,
    advance: Callable[[], None] = lambda: None,
) -> Comparison:
    """Judge a list of postures by depth of cut, zero-order solution.

    Args:
        robot: the robot.
        poses: the postures.
        cut: the cut.
        speeds: how many spindle speeds over the cut's range; more are taken where the limit bends.
        added: measured receptance of tool and spindle at the tip, in the frame of the cut.
        tips: where tips come from, such as a prediction; the robot itself if None.
        advance: called after each posture.

    Raises:
        InvalidRequest: no posture.
        FlexmodalError: as `critical_depth`.
    """
    if not poses:
        raise InvalidRequest(Fault("call", "postures", "none", "at least one"))
    checked = [robot.posture(pose) for pose in poses]  # all of them, before the work
    found = []
    for pose in checked:
        found.append(lobes(robot, pose, cut, speeds=speeds, added=added, forced=False, tips=tips))
        advance()
    return Comparison(robot, cut, tuple(found))


def compare_family(
    robot: Robot,
    family: str,
    cut: Cut,
    *,
    members: int = 21,
    speeds: int = SPEEDS,
    added: MeasuredTip | None = None,
    tips: TipSource | None = None,
    advance: Callable[[], None] = lambda: None,
) -> Comparison:
    """Judge a one-parameter family of the robot's card, evenly from end to end.

    Args:
        robot: the robot.
        family: name of the family.
        cut: the cut.
        members: how many.
        speeds: as for `compare_postures`.
        added: as for `compare_postures`.
        tips: where tips come from, such as a prediction; the robot itself if None.
        advance: as for `compare_postures`.

    Raises:
        InvalidRequest: no such family, or fewer than two members.
        FlexmodalError: as `critical_depth`.
    """
    card = robot.family(family)
    if isinstance(members, bool) or not 2 <= members <= 10_000:
        raise InvalidRequest(Fault("call", "members", repr(members), "a whole number from 2 to 10000"))
    found = []
    for parameter in np.linspace(card.start, card.stop, members).tolist():
        values = family_member(card, parameter)
        one = lobes(
            robot, values, cut, speeds=speeds, added=added, parameter=parameter, forced=False, tips=tips
        )
        found.append(one)
        advance()
    return Comparison(robot, cut, tuple(found), family)


def family_member(card: FamilyCard, parameter: float) -> dict[str, float]:
    """Joint values of a member of a family; joints it does not name are 0.

    Args:
        card: the family.
        parameter: value of its parameter [rad, m].
    """
    return {card.parameter: parameter} | {joint: factor * parameter for joint, factor in card.follow.items()}
