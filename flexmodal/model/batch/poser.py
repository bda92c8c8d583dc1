"""Mass matrices and Jacobian rows of many postures, by compiled code or by Pinocchio."""

from __future__ import annotations

import numpy as np

from flexmodal.frf import PointDirection
from flexmodal.frf.kernels.route import has_numba
from flexmodal.frf.kernels.worth import is_worth_it
from flexmodal.model.batch.chain import chain_of, places_of
from flexmodal.model.batch.compiled import pose_kernel
from flexmodal.model.batch.request import expand
from flexmodal.model.build import pinocchio
from flexmodal.model.robot import Robot

FEW = 64
"""Postures up to which Pinocchio is as quick as the call of compiled kinematics."""

_SECONDS = 2e-5
"""That Pinocchio takes for a posture [s]."""


def is_worth_compiling(count: int) -> bool:
    """Whether compiled kinematics pay in this process for so many postures more."""
    if count < FEW or not has_numba():
        return False
    kernel = pose_kernel()
    return is_worth_it("poses", count * _SECONDS, kernel.seconds, kernel.is_stored)


class Poser:
    """Mass matrices and rows of a slice of the postures."""

    def __init__(
        self, robot: Robot, values: np.ndarray, rows: tuple[PointDirection, ...], *, compiled: bool
    ) -> None:
        self.robot, self.values, self.rows = robot, values, rows
        self.chain = chain_of(robot) if compiled else None
        self.compiled = self.chain is not None
        self.places = places_of(robot, tuple((d.point, d.selector) for d in rows))

    def __call__(self, part: slice) -> tuple[np.ndarray, np.ndarray]:
        """Mass matrices, posture × joint × joint, and rows, posture × row × joint.

        Raises:
            InvalidUrdf: a mass matrix is not positive definite.
        """
        pick = self.robot.flexible_index
        values = self.values[part]
        masses = np.empty((len(values), len(pick), len(pick)))
        rows = np.empty((len(values), len(self.rows), len(pick)))
        if self.chain is not None:
            places = self.places
            pose_kernel().compiled(
                self.chain.arrays, places.joint, places.offset, places.selector, pick,
                expand(self.robot, values), masses, rows,
            )  # fmt: skip
        else:
            self._by_pinocchio(expand(self.robot, values), masses, rows)
        try:
            np.linalg.cholesky(masses)
        except np.linalg.LinAlgError:
            for vector in values:  # the first that fails names the link at fault
                _ = self.robot.at(dict(zip(self.robot.commanded, map(float, vector), strict=True))).system
            raise
        return masses, rows

    def _by_pinocchio(self, moved: np.ndarray, masses: np.ndarray, rows: np.ndarray) -> None:
        pin, model = pinocchio(), self.robot.pinocchio
        data, pick = model.createData(), self.robot.flexible_index
        frames = [self.robot.frame_of(direction.point) for direction in self.rows]
        for place, vector in enumerate(moved):
            configuration = pin.integrate(model, pin.neutral(model), vector)
            masses[place] = pin.crba(model, data, configuration)[np.ix_(pick, pick)]
            pin.computeJointJacobians(model, data, configuration)
            pin.updateFramePlacements(model, data)
            for row, (frame, direction) in enumerate(zip(frames, self.rows, strict=True)):
                full = pin.getFrameJacobian(model, data, frame, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
                rows[place, row] = (direction.selector @ full)[pick]
