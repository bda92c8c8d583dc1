"""What a diagnosis works with: observations that belong to the robot, its parameters, postures held out."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool

from flexmodal.campaign import Campaign, CampaignPosture
from flexmodal.diagnosis.effects import Context, Effect
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.search.lines import COARSE, some_lines
from flexmodal.diagnosis.selection.asked import effects_of
from flexmodal.diagnosis.selection.decision import Asked
from flexmodal.errors import Fault, InvalidRequest
from flexmodal.identification import Observations, fit, gap, observe, predict, unlimited
from flexmodal.identification.compatibility import check_compatible
from flexmodal.identification.ringing import rings_on
from flexmodal.identification.setting_up import Found
from flexmodal.identification.tolerance import as_set_up, with_tolerance
from flexmodal.model import Robot
from flexmodal.structure import ParameterSpace, robot_space
from flexmodal.structure.truncation import missing

TRUST = {"stiffness": 0.08, "damping": 0.08, "mass": 0.08, "inertia": 0.08}
"""Standard deviation of ln(true / card) in re-tuning, unless the card or the user says other."""
_FEWEST = 3
"""Postures from which on some are held out."""

Advance = Callable[[str, float], None]


@dataclass(frozen=True, eq=False)
class Setup:
    """What a diagnosis works with."""

    context: Context
    base: ParameterSpace
    observations: Observations
    fitted: Observations
    """Without the postures held out."""
    held: Bool[np.ndarray, " observation"]
    effects: tuple[Effect, ...]
    asked: Asked | None
    """Effects that the caller named; None for the whole catalogue."""
    seed: int
    advance: Advance
    moved: tuple[Found, ...] = ()
    """What was not set up as it is said to have been, within its tolerance or an angle of a posture."""
    said: Observations | None = None
    """The observations as the campaign says that they were set up, if that is not exact."""
    wide: Observations | None = None
    """The same with the variance of the tolerances."""

    @property
    def untestable(self) -> dict[str, str]:
        """Effects that these data cannot tell of, and why."""
        return {effect.name: why for effect in self.effects if (why := effect.untestable(self.context))}


def prepare(
    campaign: Campaign,
    robot: Robot,
    hold_out: Sequence[int | str] | None,
    asked: Asked | None,
    trust: Mapping[str, float] | None,
    seed: int,
    advance: Advance,
) -> Setup:
    """Lay everything out.

    Args:
        campaign: with FRFs.
        robot: as it is believed to be.
        hold_out: see `diagnose`; None for one posture in four.
        asked: effects that the caller named; None for the whole catalogue.
        trust: see `diagnose`; goes before the trust of card and workflow.
        seed: see `diagnose`.
        advance: called with what is being done and the part of it that is done.

    Raises:
        InvalidRequest: no data, unknown effects or postures, a campaign that does not belong to the robot.
    """
    check_compatible(campaign, robot)
    said = observe(campaign)
    context = Context.of(robot, said)
    said = _whole(said, context)
    observations = wide = with_tolerance(said, robot)
    known = effects_of(asked, context)
    base = robot_space(robot, trust={**trust_of(robot, TRUST), **(trust or {})})
    if hold_out is None:
        held = _middling(context, base, observations)
    else:
        held = np.isin(observations.posture, numbers_of(observations.postures, hold_out, seen_by="FRFs"))
    found = as_set_up(said, robot, base, held, far=False, in_sample=True)
    if found.left is not None:
        observations, context = found.observations, Context.of(robot, found.observations)
    fitted = observations.keeping(~held)
    told = (None, None) if found.left is None else (said, wide)
    return Setup(context, base, observations, fitted, held, known, asked, seed, advance, found.found, *told)


def trust_of(robot: Robot, trust: Mapping[str, float]) -> dict[str, float]:
    """The workflow's own trust where the card gives none.

    Args:
        robot: with its card.
        trust: the workflow's, by kind.
    """
    found = {**trust, **robot.tolerance}
    for name, joint in robot.joints.items():
        if joint.scale is not None:
            found[f"stiffness.{name}"] = joint.scale
            if joint.damping > 0:
                found[f"damping.{name}"] = joint.scale
    return found


def _whole(observations: Observations, context: Context) -> Observations:
    """The observations, without the length of their records where robot and measurement are at rest by then.

    What is missing may leave a mode with less damping than any of the card's.
    """
    if _outlasts(observations, context) or rings_on(observations):
        return replace(observations, cut_slopes=False)  # steps need not be exact, and are much faster so
    return unlimited(observations)


def _outlasts(observations: Observations, context: Context) -> bool:
    """Whether the robot as the card has it still moves at the end of some record."""
    root = Hypothesis(context, robot_space(context.robot))
    for group in root.groups(np.zeros(len(root.space)), observations, slopes=False):
        axis, pairs = observations.axis_of(group.part.level), group.part.entries.table[:1, 1:]
        if axis.length > 0 and any(
            missing(group.structures[k], axis, pairs) is not None for k in range(len(group.structures))
        ):
            return True
    return False


def _middling(
    context: Context, base: ParameterSpace, observations: Observations
) -> Bool[np.ndarray, " observation"]:
    """Observations of the postures in the middle, by how far the re-tuned robot is from each.

    A posture that alone shows the effect must not be held out, nor one that does not show it at all.
    """
    count = len(observations.postures)
    if count < _FEWEST:
        return np.zeros(len(observations), dtype=bool)
    root = Hypothesis(context, base)
    lines = some_lines(observations, COARSE)
    tuned = fit(root, observations, floors=(0.2, 0.05), steps=10, lines=lines, apart=False)
    value = predict(root, tuned.x, observations)
    far = [gap(observations, value, observations.posture == k).value for k in range(count)]
    order = np.argsort(np.nan_to_num(far), kind="stable")
    number = max(1, count // 4)
    first = (count - number) // 2
    return np.isin(observations.posture, order[first : first + number])


def numbers_of(
    postures: Sequence[CampaignPosture], wanted: Sequence[int | str], *, seen_by: str
) -> list[int]:
    """Numbers of postures to hold out, by their ids or names.

    Args:
        postures: those with data.
        wanted: ids or names.
        seen_by: what the data are, for the message.

    Raises:
        InvalidRequest: one that is not there, or all of them.
    """
    known = {str(name): k for k, p in enumerate(postures) for name in (p.id, p.name)}
    allowed = f"a posture with {seen_by}: {', '.join(p.name for p in postures)}"
    faults = [Fault("call", "hold_out", repr(one), allowed) for one in wanted if str(one) not in known]
    numbers = sorted({known[str(one)] for one in wanted if str(one) in known})
    if len(numbers) >= len(postures) and not faults:
        faults.append(Fault("call", "hold_out", "every posture", "one left to fit at least"))
    if faults:
        raise InvalidRequest(faults)
    return numbers
