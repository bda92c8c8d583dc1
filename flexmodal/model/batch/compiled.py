"""The compiled functions for batches of postures, made when first asked for."""

from __future__ import annotations

from functools import cache
from typing import Any

from flexmodal.frf.kernels.compiled import compile_together
from flexmodal.model.batch import gradient_kernel as gradient
from flexmodal.model.batch import kinematics, planar, spatial, tile

_KINEMATICS = (
    kinematics.cross,
    kinematics.turn,
    kinematics.place_joints,
    kinematics.place_bodies,
    kinematics.mass_matrix,
    kinematics.point_jacobian,
)


@cache
def compiled_poses() -> Any:
    """`flexmodal.model.batch.kinematics.pose_batch`, compiled."""
    return compile_together(*_KINEMATICS, last=kinematics.pose_batch, merged=True)


@cache
def compiled_gradient() -> Any:
    """`flexmodal.model.batch.gradient_kernel.gradient_batch`, compiled."""
    return compile_together(
        *_KINEMATICS,
        tile.fill_lane,
        tile.subtract_product,
        tile.factor_tile,
        tile.solve_tile,
        gradient.place_arm,
        gradient.sweep_momenta,
        gradient.mass_slope,
        gradient.row_slopes,
        gradient.pose_rows,
        gradient.fill_rows,
        gradient.sweep_rows,
        gradient.gradients,
        last=gradient.gradient_batch,
        merged=True,
    )


@cache
def compiled_planes() -> Any:
    """`flexmodal.model.batch.planar.plane_batch`, compiled."""
    return compile_together(*_KINEMATICS[:4], last=planar.plane_batch)


@cache
def compiled_spaces() -> Any:
    """`flexmodal.model.batch.spatial.space_batch`, compiled."""
    inner = (gradient.place_arm, spatial.apply_inertia, spatial.gather_inertias)
    return compile_together(
        *_KINEMATICS[:4], *inner, spatial.fill_joint, spatial.fill_wrench, last=spatial.space_batch
    )
