"""`package://` addresses, resolved without leaving the package."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path

from flexmodal.cards.places import package_roots

PREFIX = "package://"


def resolve_package(address: str, extra_roots: Iterable[Path] = ()) -> Path | str:
    """Find the file that a `package://<package>/<path>` address names.

    Args:
        address: the address.
        extra_roots: folders to search before ROS_PACKAGE_PATH, AMENT_PREFIX_PATH/share and the catalogue.

    Returns:
        The path of an existing file, or a phrase that says why there is none.

    Raises:
        RobotNotFound: no package of that name is installed.
    """
    package, _, inside = address.removeprefix(PREFIX).partition("/")
    if not package or package in {".", ".."} or not inside or "\0" in address:
        return "an address without a package and a path in it"
    inside = os.path.normpath(inside)
    if inside.startswith(("..", "/")):
        return "a path that leaves its package"
    homes = []
    for root in [*extra_roots, *package_roots()]:
        homes += [root / package] + ([root] if root.name == package else [])
    existing = [home for home in homes if home.is_dir()]
    for home in existing:
        if (home / inside).is_file():
            return home / inside
    if existing:
        return f"no such file in the package {package}"
    return f"a package {package} that is in none of ROS_PACKAGE_PATH, AMENT_PREFIX_PATH and the catalogue"
