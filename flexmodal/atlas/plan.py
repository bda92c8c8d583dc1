"""What an atlas is to hold, in which chunks, how large it will be, and what tells it from another."""

from __future__ import annotations

import hashlib
import json
import math
import os
import pickle
import shutil
from dataclasses import dataclass
from functools import cached_property
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np

from flexmodal.atlas.layout import Layout, Stored, chunk_shape
from flexmodal.atlas.points import Points
from flexmodal.atlas.quantities import Quantity, Variable
from flexmodal.errors import Fault, InvalidRequest
from flexmodal.model import Robot
from flexmodal.model.batch import position_batch

CHUNK = 1 << 24
"""Size of a chunk aimed at: little to lose, and small beside the memory of a worker [bytes]."""
LARGEST = 1 << 28
"""Of what one posture may hold [bytes]."""
_LIBRARIES = ("flexmodal", "numpy", "pin", "numba")
_SPARE = 0.02
"""Part of a disk that is left free."""


@dataclass(frozen=True, eq=False)
class Plan:
    """An atlas before it is computed."""

    points: Points
    quantity: Quantity
    chunk_bytes: int = CHUNK

    def __post_init__(self) -> None:
        """Refuse what no worker could hold.

        Raises:
            InvalidRequest: a single posture would take more than `LARGEST`; a name of a joint is one of the
                quantity's dimensions.
        """
        faults = []
        if self.bytes_per_posture > LARGEST:
            allowed = f"at most {LARGEST:,}: fewer lines or directions"
            faults.append(
                Fault("call", "atlas", f"{self.bytes_per_posture:,} bytes for each posture", allowed)
            )
        own = {*self.quantity.coordinates(), "axis", "tool", *(one.name for one in self.quantity.variables)}
        taken = sorted(own & {*self.robot.commanded})
        if taken:
            allowed = f"joints that are not called {', '.join(sorted(own))}"
            faults.append(Fault("call", "atlas", f"a joint called {taken[0]}", allowed))
        if self.chunk_bytes < 1:
            faults.append(Fault("call", "chunk_bytes", str(self.chunk_bytes), "at least 1"))
        if faults:
            raise InvalidRequest(faults)

    @property
    def robot(self) -> Robot:
        """The robot."""
        return self.points.robot

    @cached_property
    def variables(self) -> tuple[Variable, ...]:
        """Every array over the postures; the first of the quantity's own is written last."""
        place = Variable("tool", ("axis",), "float64", "m", "position of the end-effector")
        joints = tuple(
            Variable(name, (), "float64", "m" if joint.is_prismatic else "rad", "joint")
            for name, joint in self.robot.commanded.items()
            if name not in self.points.dims and name not in self.points.held
        )
        return (*joints, place, *reversed(self.quantity.variables))

    @cached_property
    def labels(self) -> dict[str, Any]:
        """Labels along the dimensions that are not the postures'."""
        return {"axis": ["x", "y", "z"], **self.quantity.coordinates()}

    def tail(self, variable: Variable) -> tuple[int, ...]:
        """Lengths of a variable's dimensions behind the postures'."""
        return tuple(len(self.labels[name]) for name in variable.dims)

    @cached_property
    def bytes_per_posture(self) -> int:
        """What one posture takes [bytes]."""
        return sum(np.dtype(one.dtype).itemsize * math.prod(self.tail(one)) for one in self.variables)

    @cached_property
    def chunk(self) -> tuple[int, ...]:
        """Shape of a chunk over the postures."""
        most = min(self.quantity.postures_per_chunk, max(1, self.chunk_bytes // self.bytes_per_posture))
        return chunk_shape(self.points.shape, most)

    @cached_property
    def layout(self) -> Layout:
        """Chunks and arrays of the store."""
        stored = (Stored(one.name, self.tail(one), np.dtype(one.dtype).itemsize) for one in self.variables)
        return Layout(self.points.shape, self.chunk, tuple(stored))

    @property
    def chunks(self) -> int:
        """How many there are."""
        return self.layout.chunks

    def compute(self, number: int) -> dict[str, np.ndarray]:
        """Every array of a chunk, in the shape of its region.

        Args:
            number: of the chunk, the last dimension fastest.
        """
        _, region = self.layout.region(number)
        values = self.points.values(region)
        found = {"tool": position_batch(self.robot, values, self.robot.tool), **self.quantity.compute(values)}
        columns = dict(zip(self.robot.commanded, values.T, strict=True))
        shape = tuple(part.stop - part.start for part in region)
        return {
            one.name: (found[one.name] if one.name in found else columns[one.name]).reshape(
                *shape, *self.tail(one)
            )
            for one in self.variables
        }

    @cached_property
    def facts(self) -> dict[str, Any]:
        """All that the numbers follow from, for JSON; two plans with the same make the same store."""
        return {
            "format": 1,
            "robot": self.robot.name,
            "robot_digest": robot_digest(self.robot),
            "points": self.points.facts(),
            "quantity": self.quantity.facts(),
            "chunk": list(self.chunk),
        }

    @cached_property
    def job(self) -> bytes:
        """The plan for another process."""
        return pickle.dumps(self)

    def check_room(self, path: Path, standing: int = 0) -> None:
        """Refuse what the disk has no room for.

        Args:
            path: where the store is to be.
            standing: chunks that are there already.

        Raises:
            InvalidRequest: there is too little.
        """
        usage = shutil.disk_usage(path.parent)
        needed = self.layout.size * (self.chunks - standing) // self.chunks
        room = usage.free - int(_SPARE * usage.total)
        if needed > room:
            found = (
                f"{self.points.count:,} postures of {self.bytes_per_posture:,} bytes, {needed / 1e9:.3g} GB"
            )
            raise InvalidRequest(
                Fault(str(path), "", found, f"at most {max(room, 0) / 1e9:.3g} GB, the room there")
            )


def versions() -> dict[str, str]:
    """Of the libraries that the last digits may hang on."""
    found = {}
    for name in _LIBRARIES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "none"
    return found


def robot_digest(robot: Robot) -> str:
    """A digest of every number of a robot that a result may hang on; names of files do not count."""
    model = robot.pinocchio
    parts: list[Any] = [list(robot.moving), list(robot.joints), robot.tool, list(robot.commanded)]
    parts += [joint.shortname() for joint in model.joints]
    parts += [place.homogeneous.tolist() for place in model.jointPlacements]
    parts += [body.toDynamicParameters().tolist() for body in model.inertias]
    parts += [
        (frame.name, int(frame.parentJoint), frame.placement.homogeneous.tolist()) for frame in model.frames
    ]
    parts += [np.asarray(model.armature).tolist(), robot.stiffness.tolist(), robot.damping.tolist()]
    loss = robot.hysteresis
    if loss is not None:
        parts += [loss.loss_factor.tolist(), loss.frequency]
    parts += [[axis.tolist() for axis in (joint.axis,)] for joint in robot.moving.values()]
    return hashlib.sha256(json.dumps(parts).encode()).hexdigest()[:16]


def differing(one: dict[str, Any], other: dict[str, Any], under: str = "") -> list[str]:
    """Names of the facts in which two plans differ.

    Args:
        one: facts of a plan.
        other: of another.
        under: what their keys stand under.
    """
    found = []
    for key in sorted({*one, *other}):
        left, right = one.get(key), other.get(key)
        if isinstance(left, dict) and isinstance(right, dict):
            found += differing(left, right, f"{under}{key}.")
        elif left != right:
            found.append(f"{under}{key}")
    return found


def path_of(path: str | os.PathLike[str]) -> Path:
    """An absolute path."""
    return Path(os.path.abspath(path))
