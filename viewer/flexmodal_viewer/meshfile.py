"""Mesh files to triangles and a colour, reading nothing but the one file named."""

from __future__ import annotations

import io
import re
import warnings
from collections.abc import Iterable
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from flexmodal_viewer.palette import Colour
from flexmodal_viewer.shapes import Mesh

KINDS = (".stl", ".dae", ".obj", ".ply")
LARGEST = 100_000_000
"""The largest mesh file that is read [bytes]."""
MOST_FACES = 2_000_000
"""The most triangles a mesh may have."""

_READERS = {"collada": "pycollada"}
"""Modules that trimesh imports for a kind of mesh, and the packages that bring them."""

Part = tuple[Mesh, Colour | None]


@lru_cache(maxsize=128)
def load_mesh(path: Path) -> tuple[Part, ...] | str:
    """Read a mesh.

    Textures are not followed: a mesh may name any file of the computer as its picture, and a page is made
    to be sent to others.

    Args:
        path: an STL, COLLADA, OBJ or PLY file.

    Returns:
        Its parts in the frame of the mesh [m], each with its colour if it has one; or a phrase that says
        why there are none.
    """
    kind = path.suffix.lower()
    if kind not in KINDS:
        return f"a mesh of the kind {kind or 'without ending'}; {', '.join(KINDS)} can be shown"
    try:
        if not path.is_file() or path.stat().st_size > LARGEST:
            return f"no regular file of at most {LARGEST // 1_000_000} MB"
        parts = list(_parts(path.read_bytes(), kind[1:]))
    except ImportError as error:  # a reader that trimesh asks for by itself
        return f"its reader is not installed: pip install {_READERS.get(str(error.name), 'trimesh[easy]')}"
    except Exception as error:  # readers of foreign files fail in every way there is
        return f"it cannot be read ({type(error).__name__})"
    if not parts:
        return "there are no triangles in it"
    if sum(len(mesh.faces) for mesh, _ in parts) > MOST_FACES:
        return f"more than {MOST_FACES:,} triangles"
    return tuple(parts)


def _parts(content: bytes, kind: str) -> Iterable[Part]:
    import trimesh

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        loaded = trimesh.load(io.BytesIO(content), file_type=kind, resolver=None)
        scene = loaded if isinstance(loaded, trimesh.Scene) else trimesh.Scene(loaded)
        for node in scene.graph.nodes_geometry:
            place, name = scene.graph[node]
            body = scene.geometry[name]
            if not isinstance(body, trimesh.Trimesh) or not len(body.faces):
                continue
            vertices = trimesh.transform_points(body.vertices, place) * _metres(body)
            if np.all(np.isfinite(vertices)):
                yield Mesh(vertices, np.asarray(body.faces)), _colour(body)


def _metres(body: Any) -> float:
    """COLLADA states its unit; the others are metres by the custom of URDF."""
    match = re.fullmatch(r"([0-9.eE+-]+) \* meters", str(body.metadata.get("units", "")))
    return float(match[1]) if match else 1.0


def _colour(body: Any) -> Colour | None:
    visual = body.visual
    if visual.kind == "texture":
        rgba = visual.material.main_color
    elif visual.kind in ("face", "vertex"):
        rgba = visual.main_color
    else:
        return None
    red, green, blue = (float(value) / 255 for value in rgba[:3])
    return red, green, blue
