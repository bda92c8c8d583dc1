"""The improved robot: URDF and card with what a diagnosis found in them, its parameters re-tuned.

What they cannot hold is said in a note: effects of sensors, which are not of the robot, and effects that
depend on the force of the blow.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from flexmodal.cards import CouplingCard, FrozenDict, ObstacleCard, PointCard, RobotCard
from flexmodal.cards.write import UrdfDraft, write_robot
from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import Placement
from flexmodal.diagnosis.improved.draft import Draft
from flexmodal.diagnosis.outcome import Diagnosis
from flexmodal.diagnosis.placed import Placed
from flexmodal.errors import InvalidPosture
from flexmodal.model import Robot
from flexmodal.model.written import card_of
from flexmodal.text.words import is_card_name, safe_name


@dataclass(frozen=True, eq=False)
class Extension:
    """A robot as files that are not written yet."""

    urdf: UrdfDraft
    card: RobotCard
    notes: tuple[str, ...]
    """What the files do not hold, or hold differently."""

    def write(self, folder: Path, *, home: Path | None = None) -> Path:
        """Write `robot.toml` and the URDF into an existing folder.

        Args:
            folder: where to.
            home: where the folder will stand in the end, for the addresses of meshes.

        Returns:
            The path of the card.

        Raises:
            InvalidInput: what was written is not a sound card with its URDF.
        """
        place = folder.absolute()
        card = replace(self.card, path=place / self.card.path.name, urdf=place / self.card.urdf.name)
        return write_robot(card, self.urdf, notes=self.notes, home=home)


def extend(diagnosis: Diagnosis) -> Extension:
    """Put the parameters and effects of a diagnosis' final model into the robot."""
    model, context = diagnosis.model, diagnosis.model.context
    values = model.space.values(diagnosis.x)
    draft = Draft(context.robot, {name: values[name] for name in model.base.names})
    for placed in model.placed:
        if placed.effect.extend is None:
            draft.notes.append(_left_out(placed, model.values_of(placed, values), context))
        else:
            placed.effect.extend(
                draft, Placement.still(context, placed.where, model.values_of(placed, values))
            )
    return Extension(draft.finish(), _card(draft, diagnosis), tuple(draft.notes))


def _left_out(placed: Placed, values: Mapping[str, float], context: Context) -> str:
    """Why an effect is not in the files, and what it amounts to."""
    effect = placed.effect
    if effect.read is not None or effect.turn is not None or "response" in effect.variants:
        why = "is of the sensors, not of the robot"
    elif effect.by_force:
        why = "depends on the force of the blow; the joint is here as it is without"
    else:
        why = "says nothing of how it changes the files of a robot"
    own = {p.name for p in effect.parameters(context, placed.where)}
    found = effect.physical(context, placed.where, values)
    numbers = ", ".join(f"{k} {v:.4g}" for k, v in found.items() if k in own or "." not in k)
    return f"{effect.name} at {placed.where} ({numbers}) {why}"


def _card(draft: Draft, diagnosis: Diagnosis) -> RobotCard:
    """The card, in a folder that is not known yet."""
    robot = draft.robot
    found = " and ".join(f"{placed.effect.name} at {placed.where}" for placed in diagnosis.model.placed)
    source = f"the card {robot.name}, re-tuned on the campaign {diagnosis.campaign}"
    source = f"{source}; with {found}" if found else source
    card = card_of(robot, Path(), name=f"{safe_name(robot.name)}_diagnosed", source=source)
    couplings = {}
    for name, stiffness in draft.couplings.items():
        one, _, other = name.partition("+")
        couplings[name] = CouplingCard((one, other), stiffness)
    return replace(
        card,
        tool=draft.place_of(robot.tool, np.zeros(3))[0],
        joints=FrozenDict(draft.joints),
        couplings=FrozenDict(couplings),
        points=FrozenDict(_points(draft, diagnosis)),
        postures=FrozenDict({**robot.postures, **_postures(robot, diagnosis)}),
        loss_frequency=draft.loss_frequency,
        obstacles=FrozenDict({name: _obstacle(draft, one) for name, one in robot.obstacles.items()}),
    )


def _obstacle(draft: Draft, obstacle: ObstacleCard) -> ObstacleCard:
    """Something that a link carries, on the half where its middle sits; what stands in the world stays."""
    if not obstacle.link:
        return obstacle
    carrier, place = draft.place_of(obstacle.link, np.array(obstacle.xyz, dtype=float))
    x, y, z = place.tolist()
    return replace(obstacle, link=carrier, xyz=(x, y, z))


def _points(draft: Draft, diagnosis: Diagnosis) -> dict[str, PointCard]:
    """The card's points and those of the campaign that it lacks, on the halves where they sit."""
    places = {name: (point.link, point.xyz) for name, point in draft.robot.points.items()}
    for point in diagnosis.model.context.points:
        if is_card_name(point.name):
            places.setdefault(point.name, (point.link, point.xyz))
    found = {}
    for name, (link, xyz) in places.items():
        carrier, place = draft.place_of(link, np.array(xyz, dtype=float))
        x, y, z = place.tolist()
        found[name] = PointCard(carrier, (x, y, z))
    return found


def _postures(robot: Robot, diagnosis: Diagnosis) -> dict[str, FrozenDict[float]]:
    """Postures of the campaign that the card lacks."""
    found = {}
    for posture in diagnosis.model.context.postures:
        if posture.name in robot.postures or not is_card_name(posture.name):
            continue
        try:
            robot.posture(dict(posture.q))
        except InvalidPosture:
            continue
        found[posture.name] = FrozenDict({name: float(value) for name, value in posture.q.items()})
    return found
