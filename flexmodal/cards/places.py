"""Where data lie: the catalogue that ships, the optional example arms, ROS packages."""

from __future__ import annotations

import contextlib
import importlib.metadata
import os
from pathlib import Path

from flexmodal.errors import Fault, RobotNotFound

VARIABLE = "FLEXMODAL_CATALOGUE"


def catalogue_folder() -> Path:
    """The folder that holds `robots/` and `urdf/`.

    `FLEXMODAL_CATALOGUE` where it is set, else the data inside an installed package, else the checkout.

    Raises:
        RobotNotFound: no such folder, or it has no `robots/` in it.
    """
    package = Path(__file__).resolve().parent.parent
    override = os.environ.get(VARIABLE)
    if override:
        folder, origin = Path(override).expanduser().resolve(), VARIABLE
    else:
        installed = package / "_catalogue"
        folder, origin = installed if installed.is_dir() else package.parent, "catalogue"
    if not (folder / "robots").is_dir():
        raise RobotNotFound(
            Fault(origin, "", f"{folder} without a folder robots in it", "a folder with robots/ and urdf/")
        )
    return folder


def example_robots_folder() -> Path | None:
    """The data of the optional package example-robot-data, or None where it is not installed."""
    try:
        distribution = importlib.metadata.distribution("example-robot-data")
    except importlib.metadata.PackageNotFoundError:
        return None
    folder = Path(str(distribution.locate_file("cmeel.prefix/share/example-robot-data/robots")))
    return folder if folder.is_dir() else None


def package_roots() -> list[Path]:
    """Folders in which ROS packages may lie, in the order they are searched."""
    roots = [Path(entry) for entry in os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep) if entry]
    for entry in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep):
        if entry:
            roots.append(Path(entry) / "share")
    with contextlib.suppress(RobotNotFound):  # said when somebody asks for the catalogue itself
        roots.append(catalogue_folder())
    examples = example_robots_folder()
    # The meshes of that package are addressed as package://example-robot-data/robots/…
    return roots if examples is None else [*roots, examples, examples.parent.parent]
