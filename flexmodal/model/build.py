"""A checked URDF to a Pinocchio model without gravity, with a frame for each named point."""

from __future__ import annotations

import os
import sys
import tempfile
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import numpy as np

from flexmodal.cards import PointCard, Urdf
from flexmodal.errors import Fault, InvalidUrdf, MissingExtra

_STANDARD_ERROR = threading.Lock()
"""The file that standard error leads to belongs to the whole process: one thread at a time."""


def pinocchio() -> Any:
    """Import Pinocchio, and say so plainly when another package has taken its name.

    Raises:
        MissingExtra: another package stands where Pinocchio should.
    """
    import pinocchio as pin

    if not hasattr(pin, "buildModelFromXML"):
        raise MissingExtra(
            "the module named pinocchio is not the rigid-body library: uninstall the package "
            "'pinocchio' and install 'pin'"
        )
    return pin


def build_model(urdf: Urdf, points: Mapping[str, PointCard], rotor_inertia: Mapping[str, float]) -> Any:
    """Build the Pinocchio model.

    Args:
        urdf: a checked URDF; its own text is what is built.
        points: named points, each carried by a link; they become frames of the same name.
        rotor_inertia: reflected rotor inertia by joint [kg·m²]; only Pinocchio's armature enters
            the mass matrix.

    Raises:
        InvalidUrdf: Pinocchio refuses the text, or drops part of it.
        MissingExtra: another package stands where Pinocchio should.
    """
    pin = pinocchio()
    with _native_errors() as complaint:
        try:
            model = pin.buildModelFromXML(urdf.text.encode())
        except (ValueError, RuntimeError) as error:
            raise InvalidUrdf(Fault(str(urdf.path), "", str(error), "a URDF Pinocchio can build")) from None
    if complaint:
        raise InvalidUrdf(
            Fault(str(urdf.path), "", complaint[0], "a URDF Pinocchio builds without complaint")
        )
    model.gravity.setZero()
    armature = np.zeros(model.nv)
    for joint, inertia in rotor_inertia.items():
        armature[model.joints[model.getJointId(joint)].idx_v] = inertia
    model.armature = armature
    for name, point in points.items():
        link = model.frames[point_frame(model, point.link, named=False)]
        place = link.placement * pin.SE3(np.eye(3), np.array(point.xyz, dtype=float))
        model.addFrame(pin.Frame(name, link.parentJoint, 0, place, pin.FrameType.OP_FRAME), False)
    return model


def point_frame(model: Any, name: str, *, named: bool) -> int:
    """Number of the frame of a named point, or of a link; the name must exist.

    Joints, links and points may share a name, so the kind is asked for as well.

    Args:
        model: Pinocchio's.
        name: of a point or a link.
        named: whether it is a point of the card.

    Raises:
        MissingExtra: another package stands where Pinocchio should.
    """
    kind = pinocchio().FrameType
    return int(model.getFrameId(name, kind.OP_FRAME if named else kind.BODY))


@contextmanager
def _native_errors() -> Iterator[list[str]]:
    """Collect what the C++ side writes to its standard error: it drops bad numbers with a line there."""
    lines: list[str] = []
    with _STANDARD_ERROR, tempfile.TemporaryFile() as file:
        sys.stderr.flush()
        saved = os.dup(2)
        os.dup2(file.fileno(), 2)
        try:
            yield lines
        finally:
            os.dup2(saved, 2)
            os.close(saved)
            file.seek(0)
            text = file.read().decode(errors="replace")
            lines += [line.strip() for line in text.splitlines() if "error" in line.lower()]
