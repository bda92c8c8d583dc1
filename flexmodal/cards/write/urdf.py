"""A URDF being changed.

What is not touched stays as its author wrote it: comments, transmissions, simulators' elements, tags that
nobody knows. Links and joints that are new, and mass properties that change, are written by yourdfpy. The
file is read again before it counts as written, and every number put into it has to be there.
"""

from __future__ import annotations

import copy
import os
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from jaxtyping import Float
from lxml import etree

from flexmodal.cards.urdf.meshes import mesh_path
from flexmodal.cards.urdf.read import read_urdf
from flexmodal.cards.urdf.urdf import Urdf, UrdfJoint, UrdfLink
from flexmodal.cards.write.elements import joint_element, link_element, origin_of, set_origin
from flexmodal.errors import Fault, InvalidUrdf
from flexmodal.files import whole_file

Vector = Float[np.ndarray, "3"]


class UrdfDraft:
    """A copy of a URDF, to be changed and written."""

    def __init__(self, urdf: Urdf) -> None:
        self._old = urdf.path
        self._root = etree.fromstring(urdf.text)
        self._links: dict[str, UrdfLink] = {}
        self.joints: dict[str, UrdfJoint] = dict(urdf.joint_by_name)
        """As they are by now, by name."""

    @property
    def names(self) -> set[str]:
        """Of all links and joints."""
        return {str(one.get("name")) for tag in ("link", "joint") for one in self._root.findall(tag)}

    def add_link(self, name: str, *, first: bool = False) -> None:
        """Add a link without mass.

        Args:
            name: of the link.
            first: whether it is to be the first, and not the last.
        """
        links = self._root.findall("link")
        place = self._root.index(links[0]) if first else self._root.index(links[-1]) + 1
        self._root.insert(place, link_element(UrdfLink(name, None, np.zeros(3), None, ())))

    def add_joint(self, joint: UrdfJoint, *, before: str = "") -> None:
        """Add a joint.

        Args:
            joint: the joint.
            before: name of the joint that it is to stand before; it is the last if none.
        """
        element = joint_element(joint)
        if before:
            self._root.insert(self._root.index(self._named("joint", before)), element)
        else:
            self._root.append(element)
        self.joints[joint.name] = joint

    def set_body(self, link: str, mass: float, centre: Vector, inertia: Float[np.ndarray, "3 3"]) -> None:
        """Give a link mass properties, in place of those it has.

        Args:
            link: its name.
            mass: [kg].
            centre: mass centre in the frame of the link [m].
            inertia: about the mass centre, along the axes of the link [kg·m²].
        """
        element = self._named("link", link)
        self._links[link] = UrdfLink(link, mass, centre, inertia, ())
        for old in element.findall("inertial"):
            element.remove(old)
        element.insert(0, link_element(self._links[link])[0])

    def change_joint(
        self, name: str, *, parent: str = "", xyz: Vector | None = None, rpy: Vector | None = None
    ) -> None:
        """Hang a joint on another link, or put it elsewhere in the frame of its link.

        Args:
            name: of the joint.
            parent: the link that is to carry it; as it was if not given.
            xyz: its place [m]; as it was if not given.
            rpy: its orientation [rad]; as it was if not given.
        """
        joint, element = self.joints[name], self._named("joint", name)
        joint = replace(joint, parent=parent or joint.parent)
        joint = replace(joint, xyz=joint.xyz if xyz is None else xyz, rpy=joint.rpy if rpy is None else rpy)
        element.find("parent").set("link", joint.parent)
        set_origin(element, joint.xyz, rpy)
        self.joints[name] = joint

    def shift_joints(
        self, link: str, by: Vector, *, onto: str = "", keep: frozenset[str] = frozenset()
    ) -> None:
        """Move the joints on a link, but those to keep, and hang them on another link if one is named.

        Args:
            link: whose joints.
            by: how far, in the frame of the link [m].
            onto: the link that carries them then.
            keep: names of joints that stay.
        """
        for name, joint in list(self.joints.items()):
            if joint.parent == link and name not in keep:
                self.change_joint(name, parent=onto, xyz=joint.xyz + by)

    def shift_shapes(self, link: str, by: Vector) -> None:
        """Move what is drawn of a link, and what collides.

        Args:
            link: its name.
            by: how far, in its frame [m].
        """
        for shape in self._shapes(link):
            set_origin(shape, origin_of(shape)[0] + by)

    def split_shapes(self, link: str, outer: str, place: Vector, way: Vector) -> None:
        """Give what is drawn of a link beyond a place to another link, whose frame sits there.

        Args:
            link: that is cut.
            outer: the link beyond.
            place: of the cut, in the frame of the link [m].
            way: unit vector towards what is beyond.
        """
        inner, beyond = self._named("link", link), self._named("link", outer)
        for shape in self._shapes(link):
            middle = origin_of(shape)[0]
            if (middle - place) @ way > 0:
                moved = copy.deepcopy(shape)
                inner.remove(shape)
                set_origin(moved, middle - place)
                beyond.append(moved)

    def drop_meshes(self) -> None:
        """Leave out what is drawn by files that lie beside the old URDF."""
        for link in self._root.findall("link"):
            for shape in self._shapes(str(link.get("name"))):
                mesh = shape.find("geometry/mesh")
                if mesh is not None and "://" not in str(mesh.get("filename")):
                    link.remove(shape)

    def write(self, path: Path, *, home: Path | None = None, overwrite: bool = False) -> None:
        """Write the file, and read it again before it takes its name.

        Args:
            path: where to.
            home: folder in which it will stand in the end, for the addresses of meshes.
            overwrite: replace a file that stands there.

        Raises:
            OutputExists: the file exists.
            InvalidUrdf: what was written is not a sound URDF, or holds other numbers than were put into it.
            NotWritten: the disk is full, or the folder may not be written.
        """
        root = copy.deepcopy(self._root)
        _find_meshes(root, self._old, (home or path.parent).absolute())
        etree.indent(root)
        text = etree.tostring(root, encoding="unicode")
        with whole_file(path, overwrite=overwrite) as scratch:
            scratch.write_text(f'<?xml version="1.0" encoding="utf-8"?>\n{text}\n', encoding="utf-8")
            faults = [Fault(str(path), key, "other numbers", "those that were written")
                      for key in self._differences(read_urdf(scratch))]  # fmt: skip
            if faults:
                raise InvalidUrdf(faults)

    def _differences(self, found: Urdf) -> Iterator[str]:
        """Links and joints that came back with other numbers."""
        for name, link in self._links.items():
            one = found.link_by_name[name]
            same = link.mass == one.mass and np.array_equal(link.com, one.com)
            if not same or not np.array_equal(np.asarray(link.inertia), np.asarray(one.inertia)):
                yield f"link.{name}.inertial"
        for name, joint in self.joints.items():
            other = found.joint_by_name[name]
            placed = np.array_equal(joint.xyz, other.xyz) and np.array_equal(joint.rpy, other.rpy)
            ends = (joint.type, joint.parent, joint.child) == (other.type, other.parent, other.child)
            # an axis is made a unit vector as it is read
            if not (placed and ends and np.allclose(joint.axis, other.axis, rtol=0, atol=1e-15)):
                yield f"joint.{name}"

    def _named(self, tag: str, name: str) -> etree._Element:
        return next(one for one in self._root.findall(tag) if one.get("name") == name)

    def _shapes(self, link: str) -> list[etree._Element]:
        element = self._named("link", link)
        return [*element.findall("visual"), *element.findall("collision")]


def _find_meshes(root: etree._Element, old: Path, home: Path) -> None:
    """Let meshes that lie beside the old URDF be found from the folder of the new one."""
    for mesh in root.iter("mesh"):
        address = str(mesh.get("filename", ""))
        if "://" in address or os.path.isabs(address):
            continue
        found = mesh_path(address, old)
        if isinstance(found, Path):
            mesh.set("filename", Path(os.path.relpath(found.resolve(), home.resolve())).as_posix())
