"""Meshes of an arm with as many triangles as a picture needs: pages stay small and swing smoothly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flexmodal_viewer.shapes import Mesh

if TYPE_CHECKING:
    from flexmodal_viewer.visuals import Visual

MOST_FACES = 36_000
"""Triangles of a whole arm: some 450 kB of a page, and what a picture in software still draws in time."""
FEW_FACES = 5_000
"""Of an arm that moves in software, and of one that is translucent: those of a frame in some 20 ms."""
_FEWEST = 300
"""A part of fewer triangles is left as it is."""
_NEAR = 1.3
"""So many times the triangles asked for is near enough."""
_SEAM = 1 / 250
"""Cells in which corners are joined where nothing else helps, beside the extent of a part."""


def thinned(visuals: Sequence[Visual], most: int = MOST_FACES) -> tuple[Visual, ...]:
    """The same parts, those of many triangles with fewer where all together have too many.

    Edges are collapsed where that moves the surface least (quadric error, Garland and Heckbert 1997).

    Args:
        visuals: the parts of an arm.
        most: triangles of them all.
    """
    fewest = min(_FEWEST, most // max(len(visuals), 1))
    counts = [len(visual.shape.faces) if isinstance(visual.shape, Mesh) else 0 for visual in visuals]
    small = sum(count for count in counts if count <= fewest)
    large = sum(counts) - small
    if sum(counts) <= most or not large:
        return tuple(visuals)
    keep = max(most - small, 0) / large
    return tuple(
        replace(visual, shape=_thin(visual.shape, max(int(keep * count), fewest)))
        if isinstance(visual.shape, Mesh) and count > fewest
        else visual
        for visual, count in zip(visuals, counts, strict=True)
    )


def _thin(mesh: Mesh, faces: int) -> Mesh:
    """Fewer triangles; where edges alone do not get there, as among many small shells, with seams closed."""
    found = mesh
    for seam in (0.0, _SEAM * float(np.max(np.ptp(mesh.vertices, axis=0)))):
        found = _collapsed(_welded(mesh, seam), faces)
        if len(found.faces) <= _NEAR * faces:
            break
    return found


def _welded(mesh: Mesh, seam: float) -> Mesh:
    """Corners on one another, or in one cell of that size [m], as one."""
    cells = np.round(mesh.vertices / seam) if seam > 0 else mesh.vertices.astype(np.float32)
    _, first, number = np.unique(cells, axis=0, return_index=True, return_inverse=True)
    joined = number.reshape(-1)[mesh.faces]
    a, b, c = joined.T
    return Mesh(mesh.vertices[first], joined[(a != b) & (b != c) & (c != a)])


def _collapsed(mesh: Mesh, faces: int) -> Mesh:
    import fast_simplification

    if len(mesh.faces) <= faces:
        return mesh
    points, corners = mesh.vertices.astype(np.float32), mesh.faces.astype(np.int32)
    vertices, fewer = fast_simplification.simplify(points, corners, target_count=faces)
    return Mesh(np.asarray(vertices, dtype=float), np.asarray(fewer)) if len(fewer) else mesh
