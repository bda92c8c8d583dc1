"""Finding a robot by name or path."""

from __future__ import annotations

from pathlib import Path

from flexmodal.cards.places import example_robots_folder
from flexmodal.errors import Fault, RobotNotFound
from flexmodal.files import catalogue_folder, complete
from flexmodal.text.words import listing, nearest, shown

CARD = "robot.toml"

# Serial arms of example-robot-data 6.0 whose URDF read_urdf accepts, grippers' fingers fixed.
ARMS = {
    "ur3": "ur_description/urdf/ur3_robot.urdf",
    "ur5": "ur_description/urdf/ur5_robot.urdf",
    "ur10": "ur_description/urdf/ur10_robot.urdf",
    "panda": "panda_description/urdf/panda.urdf",
    "kinova": "kinova_description/robots/kinova.urdf",
    "xarm7": "xarm_description/urdf/xarm7.urdf",
    "z1": "z1_description/urdf/z1.urdf",
    "so100": "so_arm_description/urdf/so100.urdf",
    "so101": "so_arm_description/urdf/so101.urdf",
}

FINGERS = {"panda": ("panda_finger_joint1", "panda_finger_joint2")}


def shipped_cards() -> dict[str, Path]:
    """The cards of the catalogue: name to `robot.toml`, sorted by name.

    Raises:
        RobotNotFound: there is no catalogue.
    """
    cards = sorted((catalogue_folder() / "robots").glob(f"*/{CARD}"))
    return {card.parent.name: card for card in cards}


def example_arms() -> dict[str, Path]:
    """The serial arms of the optional package example-robot-data: name to URDF; empty without it."""
    folder = example_robots_folder()
    if folder is None:
        return {}
    return {name: folder / path for name, path in ARMS.items() if (folder / path).is_file()}


def gripper_joints(path: Path) -> tuple[str, ...]:
    """Joints of an example arm that are fixed when it is read: those of its gripper."""
    return next((FINGERS.get(name, ()) for name, arm in example_arms().items() if arm == path), ())


def find(reference: str) -> Path:
    """Find a robot.

    Args:
        reference: the name of a shipped card or an example arm, or a path: to a `robot.toml`, to a folder
            with one, or to a `.urdf`. Names come first; write `./name` for a folder of the same name.

    Returns:
        The path of a card (`.toml`) or a URDF (`.urdf`).

    Raises:
        RobotNotFound: with the names there are.
    """
    cards, arms = shipped_cards(), example_arms()
    named = cards.get(reference) or arms.get(reference)
    if named is not None:
        return named
    try:
        path = Path(reference).expanduser()
    except RuntimeError:  # a user that there is not
        path = Path(reference)
    complete(path)
    try:
        if path.is_dir() and (path / CARD).is_file():
            return path / CARD
        there = path.exists() and not path.is_dir()
    except (OSError, ValueError):  # too long for a path, or a null byte in it
        there = False
    if there and path.suffix in {".toml", ".urdf"}:
        return path
    raise RobotNotFound(_not_found(reference, path, there, {**cards, **arms}))


def _not_found(reference: str, path: Path, there: bool, names: dict[str, Path]) -> Fault:
    paths = f"or a path to a {CARD}, a folder with one, or a .urdf"
    if there:
        advice = "; expand xacro first: xacro robot.xacro > robot.urdf" if path.suffix == ".xacro" else ""
        found = f"a file of the kind {shown(path.suffix)}"
        return Fault(reference, "", found, f"a {CARD} or a .urdf{advice}")
    if reference in ARMS:
        allowed = (
            f"pip install 'flexmodal[arms]', or in a checkout pip install --editable '.[arms]'; "
            f"without it the names are {listing(names)}"
        )
        found = f"{shown(reference)}, an arm of example-robot-data, which is not installed"
        return Fault("robot", "", found, allowed)
    hint = nearest(reference, names)
    found = f"no robot of the name {shown(reference)}, and no such file"
    return Fault("robot", "", found, f"{hint}the names are {listing(names)}; {paths}")
