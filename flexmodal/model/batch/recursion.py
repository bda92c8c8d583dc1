"""The recursion along a serial chain for many postures, joint by joint and without any matrix."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from flexmodal.frf import PointDirection
from flexmodal.frf.kernels.factor import LANES, Pairs
from flexmodal.frf.kernels.planar import PLANAR
from flexmodal.frf.kernels.recursion import RIGID, SLIDING, TURNING
from flexmodal.frf.kernels.route import has_numba
from flexmodal.frf.kernels.spatial import SPATIAL
from flexmodal.model.batch.chain import chain_of, places_of
from flexmodal.model.batch.planar import empty_plane
from flexmodal.model.batch.request import expand
from flexmodal.model.batch.spatial import empty_space
from flexmodal.model.robot import Robot


def recursion_of(
    robot: Robot,
    values: np.ndarray,
    rows: tuple[PointDirection, ...],
    numbers: Pairs,
    omega: np.ndarray,
    loss_factor: float,
    addition: np.ndarray | None,
) -> Callable[[slice, slice, np.ndarray], int] | None:
    """The recursion along a chain; none where the robot is no such chain or numba is missing.

    Args:
        robot: the robot.
        values: posture × commanded joint [rad, m].
        rows: directions at its points.
        numbers: pairs of them.
        omega: angular frequencies [rad/s].
        loss_factor: structural damping η.
        addition: what is added to Z, if anything; there is no recursion then.
    """
    plain = addition is None and not robot.couplings
    chain = chain_of(robot) if plain and has_numba() else None
    if chain is None:
        return None
    places = places_of(robot, tuple((d.point, d.selector) for d in rows))
    springs = np.zeros((len(robot.moving), 4))
    flexible = robot.flexible_index
    springs[flexible, 0], springs[flexible, 1] = np.diag(robot.stiffness), np.diag(robot.damping)
    springs[flexible, 2], springs[flexible, 3] = loss_factor * np.diag(robot.stiffness), 1.0
    where = (places.joint, places.offset, places.selector)
    kinds = frozenset(
        (TURNING if turns else SLIDING) if soft else RIGID
        for turns, soft in zip(chain.turns, springs[:, 3], strict=True)
    )

    def fill(systems: slice, lines: slice, out: np.ndarray) -> int:
        from flexmodal.frf.kernels.compiled import sweep_along
        from flexmodal.model.batch.compiled import plane_kernel, space_kernel

        moved, here = expand(robot, values[systems]), omega[lines]
        if robot.is_planar:
            algebra, across = PLANAR, robot.task[:2, :3]
            joints, wrenches = empty_plane(moved.shape[0], moved.shape[1], len(rows))
            plane = np.array([*across, np.cross(across[0], across[1])])
            plane_kernel().compiled(chain.arrays, where, plane, springs, moved, joints, wrenches)
        else:
            algebra = SPATIAL
            joints, wrenches = empty_space(moved.shape[0], moved.shape[1], len(rows))
            space_kernel().compiled(chain.arrays, where, springs, moved, joints, wrenches)
        padded = np.pad(here, (0, -len(here) % LANES), mode="edge")
        sweep = sweep_along(algebra, numbers, kinds).compiled
        return int(sweep(joints, wrenches, padded, algebra.before(len(rows)), out))

    return fill
