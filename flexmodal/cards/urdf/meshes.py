"""Which mesh files of a URDF are not where it says."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from urllib.parse import urlparse
from urllib.request import url2pathname

from flexmodal.cards.urdf.packages import PREFIX, resolve_package
from flexmodal.cards.urdf.urdf import UrdfLink


def mesh_path(address: str, urdf: Path) -> Path | str:
    """The file of a mesh.

    Args:
        address: its `filename` in the URDF: package://, file://, absolute, or relative to the URDF.
        urdf: path of the URDF; packages that contain it are found through its folders.

    Returns:
        The path of an existing file, or a phrase that says why there is none.
    """
    if address.startswith(PREFIX):
        return resolve_package(address, urdf.parents)
    parts = urlparse(address)
    if parts.scheme not in ("", "file"):
        return f"an address of the kind {parts.scheme}, which is not fetched"
    path = urdf.parent / (url2pathname(parts.path) if parts.scheme else address)
    try:
        return path if path.is_file() else "no such file"
    except (OSError, ValueError):
        return "no path"


def mesh_warnings(urdf: Path, links: Iterable[UrdfLink]) -> list[str]:
    """A sentence for each mesh file that cannot be shown.

    Args:
        urdf: the file that addresses are relative to.
        links: whose meshes are looked for.
    """
    warnings = []
    for link in links:
        for address in link.meshes:
            found = mesh_path(address, urdf)
            if isinstance(found, str):
                warnings.append(f"mesh {address[:200]} of link {link.name} is not shown: {found}")
    return warnings
