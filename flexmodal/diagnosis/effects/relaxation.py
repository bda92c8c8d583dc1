"""Part of a spring that relaxes: a Maxwell element beside it, as in a standard linear solid.

K (1 + r iωτ/(1 + iωτ)): Zener, Elasticity and Anelasticity of Metals, University of Chicago Press 1948.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import positive
from flexmodal.structure import Parameter
from flexmodal.structure.assembly import Assembly

LIGHT = 1e-4
"""Inertia of a relaxing element's end, over that at which it would matter at the end of the band."""
RELAXING = 0.4
"""Part that relaxes over what stays, from which some fits start; from none it is not found."""
HELD = 0.02
"""Part of the stiffness that relaxes from which it is told that no file holds it."""
PART = ("relaxing", "relaxation_time")
"""The parameters of what relaxes."""


def relaxation(context: Context) -> tuple[Parameter, Parameter]:
    """The part of a stiffness that relaxes, next to none unless the data ask for it, and its time."""
    low, high = (2 * np.pi * edge for edge in context.band)
    return (
        positive("relaxing", "", 2e-3, 2.5, 1e-8, 3.0),
        positive("relaxation_time", "s", float(1 / np.sqrt(low * high)), 1.2, 0.1 / high, 10 / low),
    )


def add_relaxing(
    assembly: Assembly,
    row: np.ndarray,
    end: np.ndarray,
    stiffness: float,
    time: float | Float[np.ndarray, " system"],
    highest: float,
    *names: str,
) -> None:
    """A spring and a damper in a row.

    Args:
        assembly: to which they are added.
        row: elongation of both.
        end: of the damper alone, a coordinate of its own.
        stiffness: of the spring [N/m, N·m/rad].
        time: in which it relaxes, the same in every system or one for each [s].
        highest: end of the band [Hz].
        names: parameters of the robot that all of it is proportional to.
    """
    add_all_relaxing(assembly, row[..., None, :], end[None], np.array([stiffness]), time, highest, *names)


def add_all_relaxing(
    assembly: Assembly,
    rows: Float[np.ndarray, "*posture spring dof"],
    ends: Float[np.ndarray, "spring dof"],
    stiffness: Float[np.ndarray, "*system spring"],
    time: float | Float[np.ndarray, " system"],
    highest: float,
    *names: str,
) -> None:
    """The same of several that relax in one time.

    Args:
        assembly: to which they are added.
        rows: elongations.
        ends: of the dampers alone, coordinates of their own.
        stiffness: of the springs, likewise in all systems or in each [N/m, N·m/rad].
        time: in which they relax, likewise [s].
        highest: end of the band [Hz].
        names: parameters of the robot that all of it is proportional to.
    """
    damping = stiffness * np.asarray(time)[..., None]
    assembly.add_together("stiffness", rows - ends, stiffness, *names)
    assembly.add_together("damping", ends, damping, *names)
    assembly.add_together("mass", ends, LIGHT * damping / (2 * np.pi * highest), *names)
