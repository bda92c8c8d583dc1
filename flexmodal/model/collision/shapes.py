"""Collision shapes from a URDF and from the obstacles of a card; meshes are taken by their convex hulls."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from lxml import etree

from flexmodal.cards import ObstacleCard, Urdf, mesh_path
from flexmodal.errors import Fault, InvalidCard, InvalidUrdf
from flexmodal.model.build import pinocchio, point_frame


def shapes_of(urdf: Urdf, model: Any) -> Any:
    """Pinocchio's geometry model of the URDF's collision shapes.

    Args:
        urdf: whose `<collision>` elements are built; meshes have to be there.
        model: Pinocchio's.

    Raises:
        InvalidUrdf: a mesh that is missing or cannot be read, or shapes that Pinocchio refuses.
    """
    pin = pinocchio()
    root = etree.fromstring(urdf.text)
    faults = []
    for mesh in root.iterfind("link/collision/geometry/mesh"):
        found = mesh_path(str(mesh.get("filename")), urdf.path)
        if isinstance(found, Path):
            mesh.set("filename", str(found.resolve()))
        else:
            allowed = "a mesh file that is there, for its collision shape"
            faults.append(Fault(str(urdf.path), f"mesh {mesh.get('filename')}", found, allowed))
    for visual in root.xpath("link/visual"):
        visual.getparent().remove(visual)
    if faults:
        raise InvalidUrdf(faults)
    try:
        text = etree.tostring(root, encoding="unicode")
        shapes = pin.buildGeomFromUrdfString(model, text, pin.GeometryType.COLLISION)
    except (ValueError, RuntimeError) as error:
        allowed = "collision shapes that Pinocchio can build"
        raise InvalidUrdf(Fault(str(urdf.path), "collision", str(error), allowed)) from None
    for shape in shapes.geometryObjects:
        shape.geometry = _convex(shape.geometry)
    return shapes


def add_obstacle(
    shapes: Any,
    model: Any,
    name: str,
    obstacle: ObstacleCard,
    root: str,
    card: Path,
) -> None:
    """Add an obstacle of a card to a geometry model.

    Args:
        shapes: Pinocchio's geometry model.
        model: Pinocchio's.
        name: of the obstacle.
        obstacle: its shape and place.
        root: the link that stands in the world.
        card: where the obstacle is described, for errors.

    Raises:
        InvalidCard: a mesh that cannot be read.
    """
    pin = pinocchio()
    frame = model.frames[point_frame(model, obstacle.link or root, named=False)]
    turned = pin.rpy.rpyToMatrix(*map(float, obstacle.rpy))
    place = frame.placement * pin.SE3(turned, np.array(obstacle.xyz, dtype=float))
    try:
        geometry = _geometry(obstacle)
    except (ValueError, RuntimeError, OSError) as error:
        allowed = "a mesh that can be read, such as .stl or .obj"
        raise InvalidCard(Fault(str(card), f"obstacle.{name}.mesh", str(error), allowed)) from None
    unique = f"obstacle {name}"
    number = model.getFrameId(frame.name, pin.FrameType.BODY)
    shapes.addGeometryObject(pin.GeometryObject(unique, frame.parentJoint, number, place, geometry))


def _geometry(obstacle: ObstacleCard) -> Any:
    import coal

    if obstacle.box is not None:
        return coal.Box(*map(float, obstacle.box))
    if obstacle.sphere is not None:
        return coal.Sphere(float(obstacle.sphere))
    if obstacle.cylinder is not None:
        radius, length = map(float, obstacle.cylinder)
        return coal.Cylinder(radius, length)
    loaded = coal.MeshLoader().load(str(obstacle.mesh), np.full(3, float(obstacle.scale)))
    return _convex(loaded)


def _convex(geometry: Any) -> Any:
    """The convex hull of a mesh: a little larger, never smaller; other shapes as they are."""
    import coal

    if not isinstance(geometry, coal.BVHModelBase):
        return geometry
    geometry.buildConvexHull(True, "Qt")
    return geometry.convex
