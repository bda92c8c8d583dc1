"""Where data lie: the optional example arms, ROS packages."""

from __future__ import annotations

import contextlib
import importlib.metadata
import os
from pathlib import Path

from flexmodal.errors import RobotNotFound
from flexmodal.files import catalogue_folder


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
