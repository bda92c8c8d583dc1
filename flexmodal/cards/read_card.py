"""From the text of a `robot.toml` to a `RobotCard`."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from flexmodal.cards.card import (
    CouplingCard,
    FamilyCard,
    JointCard,
    ObstacleCard,
    PointCard,
    RobotCard,
)
from flexmodal.cards.coupling import couplings_of
from flexmodal.cards.urdf.packages import PREFIX, resolve_package
from flexmodal.errors import Fault, InvalidCard
from flexmodal.text.frozen import FrozenDict
from flexmodal.text.toml import parse_toml
from flexmodal.text.validation import allowed, validated
from flexmodal.text.words import FaultList, shown

if TYPE_CHECKING:
    from flexmodal.cards.schema import CardTable, ObstacleTable


def read_card(path: str | os.PathLike[str]) -> RobotCard:
    """Read a robot card.

    Args:
        path: a `robot.toml`.

    Returns:
        The card, sound in itself, its URDF an existing file.

    Raises:
        InvalidCard: with every fault of the file at once.
    """
    from flexmodal.cards.schema import CardTable

    file = Path(os.path.abspath(path))
    content = _parse(file)
    faults = FaultList(file)
    table = validated(CardTable, content, faults)
    urdf = _find_urdf(content.get("urdf"), faults)
    joints = {} if table is None else {n: JointCard(**joint.model_dump()) for n, joint in table.joint.items()}
    stiffness = {} if table is None else {name: one.stiffness for name, one in table.coupling.items()}
    couplings = couplings_of(stiffness, joints, faults)
    srdf = None if table is None or table.srdf is None else _file("srdf", table.srdf, faults)
    obstacles = {} if table is None else {n: _obstacle(n, one, faults) for n, one in table.obstacle.items()}
    if faults.faults or table is None or urdf is None:
        raise InvalidCard(_in_order(faults.faults))
    card = _card(table, urdf, file, joints, couplings)
    return replace(card, obstacles=FrozenDict(obstacles), srdf=srdf)


def urdf_named_in(path: str | os.PathLike[str]) -> Path | None:
    """The URDF that a card names, whatever else is wrong with the card; None where no file is there.

    Args:
        path: a `robot.toml`.
    """
    file = Path(os.path.abspath(path))
    content = parse_toml(file, kind="a robot card")
    return None if isinstance(content, Fault) else _find_urdf(content.get("urdf"), FaultList(file))


def _parse(file: Path) -> dict[str, Any]:
    content = parse_toml(file, kind="a robot card")
    if isinstance(content, Fault):
        raise InvalidCard(content)
    return content


def _find_urdf(address: object, faults: FaultList) -> Path | None:
    """The URDF that the card names; a fault where there is none."""
    from flexmodal.cards.schema import CardTable

    if not isinstance(address, str) or not address:
        return None  # the schema has said so
    found: Path | str
    if address.startswith(PREFIX):
        found = resolve_package(address, [faults.file.parent])
    else:
        found = Path(os.path.abspath(faults.file.parent / address))
        try:
            found = found if found.is_file() else f"{shown(address)}, where no file is"
        except (OSError, ValueError):
            found = f"{shown(address)}, which is no path"
    if isinstance(found, str):
        faults.add("urdf", found, allowed(CardTable, ["urdf"]))
        return None
    return found


def _obstacle(name: str, table: ObstacleTable, faults: FaultList) -> ObstacleCard:
    box = None if table.box is None else (table.box[0], table.box[1], table.box[2])
    return ObstacleCard(
        box=box,
        sphere=table.sphere,
        cylinder=None if table.cylinder is None else (table.cylinder[0], table.cylinder[1]),
        mesh=None if table.mesh is None else _file(f"obstacle.{name}.mesh", table.mesh, faults),
        scale=table.scale,
        xyz=(table.xyz[0], table.xyz[1], table.xyz[2]),
        rpy=(table.rpy[0], table.rpy[1], table.rpy[2]),
        link=table.link,
    )


def _file(key: str, address: str, faults: FaultList) -> Path:
    """A file that a card names beside its URDF; a fault where there is none."""
    path = Path(os.path.abspath(faults.file.parent / address))
    try:
        there = path.is_file()
    except (OSError, ValueError):
        there = False
    if not there:
        faults.add(key, f"{shown(address)}, where no file is", "a path relative to this file, or absolute")
    return path


def _in_order(faults: Sequence[Fault]) -> list[Fault]:
    """The faults in the order in which a card is written."""
    from flexmodal.cards.schema import CardTable

    sections = list(CardTable.model_fields)

    def place(fault: Fault) -> int:
        section = fault.key.split(".")[0]
        return sections.index(section) if section in sections else -1

    return sorted(faults, key=place)


def _card(
    table: CardTable,
    urdf: Path,
    file: Path,
    joints: dict[str, JointCard],
    couplings: dict[str, CouplingCard],
) -> RobotCard:
    points = {
        name: PointCard(point.link, (point.xyz[0], point.xyz[1], point.xyz[2]))
        for name, point in table.point.items()
    }
    families = {
        name: FamilyCard(family.parameter, family.start, family.stop, FrozenDict(family.follow))
        for name, family in table.family.items()
    }
    return RobotCard(
        name=table.name,
        title=table.title,
        urdf=urdf,
        tool=table.tool,
        source=table.source,
        joints=FrozenDict(joints),
        points=FrozenDict(points),
        postures=FrozenDict({name: FrozenDict(posture) for name, posture in table.posture.items()}),
        families=FrozenDict(families),
        path=file,
        couplings=FrozenDict(couplings),
        loss_frequency=table.loss_frequency,
        tolerance=FrozenDict(table.tolerance.model_dump(exclude_none=True)),
    )
