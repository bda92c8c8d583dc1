"""Where the data that ship lie, and those of them that have a name."""

from __future__ import annotations

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


def shipped(kind: str, ending: str = "") -> dict[str, Path]:
    """What ships of a kind, by name: `fanuc_s360/thesis`, and `thesis` where no other robot has one.

    Args:
        kind: the folder of a robot that it is in, `campaigns` or `cuts`.
        ending: of the file names, left out of the names.

    Returns:
        Name to path, sorted; empty where there is no catalogue.
    """
    try:
        found = sorted((catalogue_folder() / "robots").glob(f"*/{kind}/*{ending}"))
    except RobotNotFound:
        return {}
    short = [path.name.removesuffix(ending) for path in found]
    long = [f"{path.parent.parent.name}/{name}" for path, name in zip(found, short, strict=True)]
    alone = {name: path for name, path in zip(short, found, strict=True) if short.count(name) == 1}
    return alone | dict(zip(long, found, strict=True))


def path_or_shipped(path: str | os.PathLike[str], kind: str, ending: str = "") -> Path:
    """A path as it was given, or of what ships by that name where there is nothing at the path.

    Args:
        path: a path or a name of `shipped`.
        kind: as of `shipped`.
        ending: as of `shipped`.
    """
    given = Path(path)
    try:
        if os.path.lexists(given):
            return given
    except (OSError, ValueError):  # too long for a path, or a null byte in it
        return given
    return shipped(kind, ending).get(os.fspath(path), given)
