"""Diagnosis of a campaign of modes: the same course as with FRFs, on frequencies, damping and shapes.

Fit every effect that adds to the structure in every place, one mode without structure beside them, compare
under several sets of beliefs, and add what is decided. What is tied is said to be. Where the caller names
effects, the best of them is added even so, with its ties.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from threadpoolctl import threadpool_limits

from flexmodal.campaign import Campaign
from flexmodal.diagnosis.effects import catalogue
from flexmodal.diagnosis.modal_result import diagnosis_of
from flexmodal.diagnosis.outcome import Diagnosis
from flexmodal.diagnosis.selection.modal_selection import ModalSelection
from flexmodal.diagnosis.setup import Advance, numbers_of, trust_of
from flexmodal.identification.compatibility import check_compatible, placed_on
from flexmodal.identification.evidence.mode_sources import modes_of_table
from flexmodal.model import Robot
from flexmodal.structure import robot_space

TRUST = {"stiffness": 0.5, "damping": 1.0, "mass": 0.2, "inertia": 0.2}
"""Standard deviation of ln(true / card) unless the card or the caller says other; weighing halves and
doubles it."""


def is_modal(campaign: Campaign) -> bool:
    """Whether a campaign has modes and nothing else."""
    return campaign.frfs is None and not campaign.blows and campaign.modes is not None


def diagnose_modes(
    campaign: Campaign,
    robot: Robot,
    *,
    hold_out: Sequence[int | str] | None = None,
    effects: Sequence[str] | None = None,
    trust: Mapping[str, float] | None = None,
    seed: int = 0,
    advance: Advance = lambda doing, part: None,
) -> Diagnosis:
    """Find what is missing between a robot and measured modes; see `flexmodal.diagnosis.diagnose`.

    Args:
        campaign: with `modes.csv`; a point on a link that the robot lacks is taken where its card has a point
            of that name.
        robot: as it is believed to be.
        hold_out: postures that no fit sees. By default each is left out in turn, with three or more.
        effects: names; what explains best among them is added if it is needed, tied or not. Or `NAME@WHERE`:
            that is added if it gains more than a tie under the first beliefs.
        trust: standard deviation of ln(true / card) by kind or name.
        seed: of the postures tried for the next measurement.
        advance: called with what is being done and the part of it that is done.

    Raises:
        InvalidRequest: no modes, unknown effects or postures, a campaign that does not belong to the robot.
    """
    placed, moved = placed_on(campaign, robot)
    check_compatible(placed, robot)
    measured = modes_of_table(placed)
    asked = _asked(effects)
    base = robot_space(robot, trust={**trust_of(robot, TRUST), **(trust or {})})
    held = None
    if hold_out is not None:
        away = numbers_of(measured.postures, hold_out, seen_by="modes")
        held = np.array([mode.posture in away for mode in measured.modes])
    with threadpool_limits(1):
        selection = ModalSelection(measured, robot, base, asked, held, advance)
        selection.run()
        return diagnosis_of(selection, moved, seed)


def _asked(effects: Sequence[str] | None) -> dict[str, tuple[str, ...]] | None:
    """Names with the places that were named along; none for all."""
    if effects is None:
        return None
    found: dict[str, tuple[str, ...]] = {}
    for one in effects:
        name, _, where = one.partition("@")
        found[name] = (*found.get(name, ()), *([where] if where else []))
    catalogue(list(found))  # says what is unknown
    return found
