"""The functions for batches of postures that are compiled."""

from __future__ import annotations

from functools import cache

from flexmodal.frf.kernels.compiled import Kernel, together
from flexmodal.model.batch import gradient_kernel, kinematics, planar, spatial, tile

_KINEMATICS = (
    kinematics.cross,
    kinematics.turn,
    kinematics.place_joints,
    kinematics.place_bodies,
    kinematics.mass_matrix,
    kinematics.point_jacobian,
)


@cache
def pose_kernel() -> Kernel:
    """`flexmodal.model.batch.kinematics.pose_batch`."""
    return together(*_KINEMATICS, last=kinematics.pose_batch, merged=True)


@cache
def slope_kernel() -> Kernel:
    """`flexmodal.model.batch.gradient_kernel.gradient_batch`."""
    return together(
        *_KINEMATICS,
        tile.fill_lane,
        tile.subtract_product,
        tile.factor_tile,
        tile.solve_tile,
        gradient_kernel.place_arm,
        gradient_kernel.sweep_momenta,
        gradient_kernel.mass_slope,
        gradient_kernel.row_slopes,
        gradient_kernel.pose_rows,
        gradient_kernel.fill_rows,
        gradient_kernel.sweep_rows,
        gradient_kernel.gradients,
        gradient_kernel.hand_out,
        last=gradient_kernel.gradient_batch,
        merged=True,
    )


@cache
def plane_kernel() -> Kernel:
    """`flexmodal.model.batch.planar.plane_batch`."""
    return together(*_KINEMATICS[:4], planar.plane_wrench, last=planar.plane_batch)


@cache
def space_kernel() -> Kernel:
    """`flexmodal.model.batch.spatial.space_batch`."""
    inner = (gradient_kernel.place_arm, spatial.apply_inertia, spatial.gather_inertias)
    return together(
        *_KINEMATICS[:4], *inner, spatial.fill_joint, spatial.fill_wrench, last=spatial.space_batch
    )
