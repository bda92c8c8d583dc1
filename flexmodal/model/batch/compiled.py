"""The functions for batches of postures that are compiled."""

from __future__ import annotations

from functools import cache

from flexmodal.frf.kernels.compiled import Kernel, together
from flexmodal.model.batch import gradient_kernel, kinematics, planar, spatial, tile

POSES_COMPILED, SLOPES_COMPILED = 6.0, 20.0
"""Seconds to compile mass matrices and gradients [s]."""

_CHAIN = "motions along a chain"

KINEMATICS = (
    kinematics.cross,
    kinematics.turn,
    kinematics.place_joints,
    kinematics.place_bodies,
    kinematics.mass_matrix,
    kinematics.point_jacobian,
)
"""What kernels of a chain's kinematics call, lowest first."""


@cache
def pose_kernel() -> Kernel:
    """`flexmodal.model.batch.kinematics.pose_batch`."""
    purpose = "mass matrices of many postures"
    return together(
        *KINEMATICS, last=kinematics.pose_batch, purpose=purpose, seconds=POSES_COMPILED, merged=True
    )


@cache
def slope_kernel() -> Kernel:
    """`flexmodal.model.batch.gradient_kernel.gradient_batch`."""
    return together(
        *KINEMATICS,
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
        purpose="receptances with their gradients",
        seconds=SLOPES_COMPILED,
        merged=True,
    )


@cache
def plane_kernel() -> Kernel:
    """`flexmodal.model.batch.planar.plane_batch`."""
    return together(*KINEMATICS[:4], planar.plane_wrench, last=planar.plane_batch, purpose=_CHAIN)


@cache
def space_kernel() -> Kernel:
    """`flexmodal.model.batch.spatial.space_batch`."""
    inner = (gradient_kernel.place_arm, spatial.apply_inertia, spatial.gather_inertias)
    joints = (spatial.fill_joint, spatial.fill_wrench)
    return together(*KINEMATICS[:4], *inner, *joints, last=spatial.space_batch, purpose=_CHAIN)
