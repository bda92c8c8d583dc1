"""Hysteretic loss in the joints: Im K / Re K constant over the band, in time, hence causal.

K (1 + iη) has no counterpart in time; a row of Maxwell elements whose relaxation times are spread over the
band and beyond comes near it. Their strengths g ≥ 0 are fitted so that Σ g ωτ/(1 + ω²τ²) equals η times the
real part. A causal material stiffens by 2η/π for each unit of ln ω (Kramers and Kronig): the real part is
set to the joint's stiffness at the middle of the band.
"""

from __future__ import annotations

import numpy as np

from flexmodal.rig.effects.effect import Effect, Site, Stand, multiplied, within
from flexmodal.rig.plant.assembly import PlantAssembly

ELEMENTS = 9


def maxwell(loss: float, band: tuple[float, float]) -> tuple[float, np.ndarray, np.ndarray]:
    """Static spring, strengths and relaxation times for a loss factor.

    Args:
        loss: η.
        band: where it is to hold [Hz].

    Returns:
        Long-term stiffness, strengths of the elements and their relaxation times [s], for a real part of 1
        at the middle of the band on a logarithmic scale.
    """
    from scipy.optimize import nnls

    low, high = 2 * np.pi * band[0], 2 * np.pi * band[1]
    times = 1 / np.geomspace(low / 4, high * 4, ELEMENTS)
    omega = np.geomspace(low, high, 120)
    lag = omega[:, None] * times
    real, imaginary = lag**2 / (1 + lag**2), lag / (1 + lag**2)
    strengths, _ = nnls(imaginary - loss * real, np.full(len(omega), loss))
    middle = np.sqrt(low * high) * times
    size = 1 + float(strengths @ (middle**2 / (1 + middle**2)))
    return 1 / size, strengths / size, times


def _draw(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    return {"loss_factor": float(random.uniform(0.03, 0.12)), "viscous": 1.0}


def _act(assembly: PlantAssembly, site: Site) -> None:
    static, strengths, times = maxwell(site["loss_factor"], site.stand.plan.band)
    for joint in site.stand.robot.joints:
        k, b = site.stand.true.stiffness[joint], site.stand.true.damping[joint]
        row = assembly.stretch(joint)
        assembly.add_spring(row, (static - 1) * k, (site["viscous"] - 1) * b)
        assembly.add_relaxation(row, strengths * k, times)


EFFECT = Effect(
    name="structural_damping",
    says="hysteretic loss in the joints",
    units={"loss_factor": "", "viscous": "part of the card's viscous damping that is there too"},
    places=lambda robot, points: ("joints",),
    place_is="all joints together",
    draw=_draw,
    scaled=multiplied("loss_factor"),
    most=lambda parameters: 0.6 / max(parameters["loss_factor"], 1e-9),
    check=within(loss_factor=(0.0, 0.6), viscous=(0.0, np.inf)),
    act=_act,
)
