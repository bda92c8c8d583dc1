"""Lobes of predicted receptances: of a file, or of any posture by a campaign."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from flexmodal.cli.options import SOURCE
from flexmodal.cli.printing import busy, say
from flexmodal.cli.sources import FAR, Sourcing
from flexmodal.errors import Fault, InvalidRequest

if TYPE_CHECKING:
    from flexmodal.machining import Cut, MeasuredTip, TipReceptance
    from flexmodal.machining.depth import PostureDepth
    from flexmodal.model import Posture, Robot
    from flexmodal.prediction import PredictedTips


def tips_of(sourcing: Sourcing, arm: Robot, method: str, *, quiet: bool) -> PredictedTips | None:
    """The tips by `--campaign`, if it is given.

    Args:
        sourcing: its options.
        arm: the robot.
        method: of stability.
        quiet: no progress bar.

    Raises:
        InvalidRequest: a method that wants a model.
    """
    if sourcing.campaign is not None:
        refuse_system(method)
    source = sourcing.source(arm, quiet=quiet)
    if source is None:
        return None
    from flexmodal.prediction import PredictedTips

    return PredictedTips(source)


def refuse_system(method: str) -> None:
    """A method that wants more than receptances.

    Args:
        method: of stability.

    Raises:
        InvalidRequest: it does.
    """
    if method == "semi-discretisation":
        allowed = "zero-order or multi-frequency: a prediction is a receptance, not a system"
        raise InvalidRequest(Fault(SOURCE, "--method", method, allowed))


def lobes_of_file(
    arm: Robot, file: Path, cut: Cut, added: MeasuredTip | None, method: str, speeds: int | None, quiet: bool
) -> PostureDepth:
    """Lobes of the FRFs that `flexmodal predict` wrote.

    Args:
        arm: the robot.
        file: the .json.
        cut: the cut.
        added: measured receptance of tool and spindle.
        method: of stability.
        speeds: how many.
        quiet: nothing while it works.
    """
    from flexmodal.machining import lobes_of_tip, read_predicted_tip

    refuse_system(method)
    told = read_predicted_tip(file, arm, cut, added)
    _say_rigid(told.rigid)
    with busy("lobes", quiet=quiet):
        found = lobes_of_tip(told.tip, told.posture, cut, method=method, speeds=speeds, forced=False)
    _say_band(told.posture, cut, (told.softer, told.stiffer))
    return found


def lobes_there(
    arm: Robot,
    posture: Posture,
    cut: Cut,
    added: MeasuredTip | None,
    method: str,
    speeds: int | None,
    quiet: bool,
    tips: PredictedTips,
) -> PostureDepth:
    """Lobes of a posture by predicted receptances.

    Args:
        arm: the robot.
        posture: which.
        cut: the cut.
        added: measured receptance of tool and spindle.
        method: of stability.
        speeds: how many.
        quiet: nothing while it works.
        tips: that are predicted.
    """
    from flexmodal.machining import lobes

    with busy("lobes", quiet=quiet):
        found = lobes(arm, posture, cut, method=method, speeds=speeds, added=added, forced=False, tips=tips)
    say_standing(arm, posture, cut, added, tips)
    return found


def say_standing(
    arm: Robot, posture: Posture, cut: Cut, added: MeasuredTip | None, tips: PredictedTips
) -> None:
    """What the band makes of the depth in a posture, and where that stands beside what was struck.

    Args:
        arm: the robot.
        posture: the answer.
        cut: the cut.
        added: measured receptance of tool and spindle.
        tips: that are predicted.
    """
    posed = arm.at(posture)
    _say_rigid(tips.rigid(posed, cut))
    _say_band(posture, cut, tips.ends(posed, cut, added))
    remote, outside = tips.standing(posed)
    if outside:
        say(f"note: outside what was struck: {', '.join(outside)}; strike a posture there", err=True)
    if remote > FAR:
        say(f"note: {remote:.1f} times as far from the struck postures as these are apart", err=True)


def _say_rigid(count: int) -> None:
    if count:
        along = "one direction" if count == 1 else "two directions"
        say(f"note: along {along} nothing was predicted at the tool; there the arm counts as rigid", err=True)


def _say_band(posture: Posture, cut: Cut, ends: tuple[TipReceptance, TipReceptance]) -> None:
    from flexmodal.machining import lobes_of_tip

    depths = [lobes_of_tip(tip, posture, cut, forced=False).critical_depth for tip in ends]
    low, high = (f"{1e3 * one:.3g}" for one in depths)
    say(
        f"note: within the 95 % band of the FRFs, all of them large or all small, the depth stable at every "
        f"speed is {low} to {high} mm",
        err=True,
    )
