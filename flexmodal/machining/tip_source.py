"""Where the tip of a cutter in any posture comes from: the robot as it is posed, or what knows more of it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol, runtime_checkable

from flexmodal.machining.cut import Cut
from flexmodal.machining.measured_tip import MeasuredTip
from flexmodal.machining.tip import tool_tip
from flexmodal.machining.tip_receptance import TipReceptance
from flexmodal.model import PosedRobot


@runtime_checkable
class TipSource(Protocol):
    """Gives the tip of a cut at any posture, and how far it may be off."""

    def tip(self, posed: PosedRobot, cut: Cut, added: MeasuredTip | None = None) -> TipReceptance:
        """The tip in the frame of the cut.

        Args:
            posed: the robot in the posture.
            cut: says where the tip is and how its axes lie.
            added: measured receptance of tool and spindle, in that frame.
        """
        ...

    def ends(
        self, posed: PosedRobot, cut: Cut, added: MeasuredTip | None = None
    ) -> tuple[TipReceptance, TipReceptance]:
        """The tip with every receptance as large, and as small, as its 95 % band allows.

        Args:
            posed: as for `tip`.
            cut: likewise.
            added: likewise.
        """
        ...

    def standing(self, posed: PosedRobot) -> tuple[float, tuple[str, ...]]:
        """Distance from what was struck over that between these, 1 or more; joints outside that range.

        Args:
            posed: the robot in the posture.
        """
        ...

    def facts(self) -> Mapping[str, Any]:
        """What tells this source from another, for JSON, with a `verdict` in words."""
        ...


def tip_at(
    posed: PosedRobot, cut: Cut, added: MeasuredTip | None = None, tips: TipSource | None = None
) -> TipReceptance:
    """The tip by a source, or that of the posed robot itself.

    Args:
        posed: the robot in the posture.
        cut: says where the tip is and how its axes lie.
        added: measured receptance of tool and spindle, in that frame.
        tips: the source; the robot itself if None.
    """
    return tool_tip(posed, cut, added) if tips is None else tips.tip(posed, cut, added)
