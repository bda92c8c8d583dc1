"""Third forms of what drives joints: acceleration fed back, springs that creep, cylinders that share oil."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmodal.rig.effects.effect import (
    Effect,
    Parameters,
    Site,
    Stand,
    drawing,
    each,
    positive,
    within,
)
from flexmodal.rig.effects.servo_compliance import EFFECT as SERVO
from flexmodal.rig.effects.servo_compliance import free_rotor
from flexmodal.rig.forms.joint_coupling import RATIO
from flexmodal.rig.forms.maxwell_rows import MOST, Series, fitted
from flexmodal.rig.forms.structural_damping import BIOT, acting
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.plant.plant import Branch, Feedback


def _draw_accelerated(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """A rotor that seems as heavy as that of the rig's own form; a filter that is quicker than it swings."""
    drawn = SERVO.draw(stand, where, random)
    seeming, fed = drawn["rotor_inertia"], float(random.uniform(0.4, 0.7))
    stiffness = drawn["proportional_gain"] + stand.true.stiffness[where]
    return {
        **drawn,
        "rotor_inertia": (1 - fed) * seeming,
        "acceleration_gain": fed * seeming,
        "filter_time": float(random.uniform(0.1, 0.5) * np.sqrt(seeming / stiffness)),
    }


def _act_accelerated(assembly: PlantAssembly, site: Site) -> None:
    """K_P + K_D s + K_A s²/(1 + T s) on the rotor: heavier while it is slow, damped beyond.

    s²/(1 + T s) = s/T − 1/T² + 1/T²/(1 + T s).
    """
    motor = free_rotor(assembly, site, site["rotor_inertia"])
    assembly.add_spring(motor, site["proportional_gain"], site["derivative_gain"])
    gain, time = site["acceleration_gain"], site["filter_time"]
    a, b_angle, c = np.array([[-1 / time]]), np.array([1 / time]), np.array([gain / time**2])
    fed = Feedback(motor, motor, a, b_angle, np.zeros(1), c, -gain / time**2, gain / time)
    assembly.feedbacks.append(fed)


def _scaled_accelerated(parameters: Parameters, s: float) -> dict[str, float]:
    """As other loops: gains are divided, and a stiffer loop takes its filter along."""
    factors = {"proportional_gain": 1 / s, "derivative_gain": s**-0.5, "filter_time": min(s, 1.0) ** 0.5}
    return {name: float(value * factors.get(name, 1.0)) for name, value in parameters.items()}


def creeping(loss: float, frequency: float, band: tuple[float, float]) -> Series:
    """A spring that creeps with the logarithm of time.

    Its compliance is 1 + q ln(1 + a t), and 1 + q eᶻ E₁(z) with z = iω/a at a frequency. The loss is nearly
    the same below a, and falls as 1/ω above it.

    Args:
        loss: the largest loss factor in the band.
        frequency: a/(2π) [Hz].
        band: of the campaign [Hz].
    """
    from scipy.optimize import brentq
    from scipy.special import exp1

    def lost(omega: np.ndarray, size: float) -> np.ndarray:
        z = 1j * omega / (2 * np.pi * frequency)
        value = 1 + size * np.exp(z) * exp1(z)
        return np.asarray(-value.imag / value.real)

    every = 2 * np.pi * np.geomspace(*band, 60)
    size = MOST
    if lost(every, MOST).max() > loss:
        size = float(brentq(lambda size: lost(every, size).max() - loss, 0.0, MOST))
    return fitted(lambda omega: lost(omega, size), band, 11, 6.0)


def _draw_creeping(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """It stops losing somewhere in the lower half of the band."""
    low, high = stand.plan.band
    ceasing = float(np.exp(random.uniform(np.log(3 * low), np.log(0.5 * high))))
    drawn = drawing(loss_factor=(0.03, 0.12), viscous=(0.2, 1.0))(stand, where, random)
    return {**drawn, "ceasing": ceasing}


def _creeping(site: Site, joint: int) -> Series:
    return creeping(site["loss_factor"], site["ceasing"], site.stand.plan.band)


def _draw_oil(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """Oil that flows from one to the other up to a frequency within the band."""
    drawn, (low, high) = RATIO.draw(stand, where, random), stand.plan.band
    corner = 2 * np.pi * np.exp(random.uniform(np.log(0.3), np.log(3.0))) * np.sqrt(low * high)
    return {**drawn, "time": float(1 / corner)}


def _act_oil(assembly: PlantAssembly, site: Site) -> None:
    """Two chambers of stiffness k, and a line between them that takes R ż to let oil z through.

    k (a − z) = R ż + k (z − b), with a = q_A and b = r q_B: a spring k/2 on a − b, and on a + b an element of
    Maxwell of k/2 and R/(2 k).
    """
    one, other = site.where.split("+")
    first, second = assembly.row(one), site["ratio"] * assembly.row(other)
    assembly.add_spring(first - second, site["stiffness"] / 2)
    assembly.branches.append(Branch(first + second, site["stiffness"] / 2, site["time"]))


ACCELERATED: Effect = replace(
    SERVO,
    form="accelerated",
    says="the motor on a loop that feeds back its own acceleration besides",
    source="Schmidt and Lorenz, IEEE Trans. Industry Applications 28 (1992) 594 (acceleration feedback)",
    units={
        **SERVO.units,
        "acceleration_gain": "kg·m², by which the rotor seems heavier",
        "filter_time": "s, of the acceleration",
    },
    draw=_draw_accelerated,
    scaled=_scaled_accelerated,
    check=each(SERVO.check, positive("acceleration_gain", "filter_time")),
    act=_act_accelerated,
)
CREEPING: Effect = replace(
    BIOT,
    form="creeping",
    says="springs that creep with the logarithm of time: a loss factor that is there up to one frequency",
    source="Lomnitz, J. Applied Physics 28 (1957) 201, on linear dissipation in solids",
    units={
        "loss_factor": "the largest in the band",
        "viscous": BIOT.units["viscous"],
        "ceasing": "Hz, from where on the loss falls",
    },
    draw=_draw_creeping,
    check=within(loss_factor=(0.0, 0.6), viscous=(0.0, np.inf), ceasing=(1e-3, 1e6)),
    act=acting(_creeping),
)
OIL_LINE: Effect = replace(
    RATIO,
    form="oil_line",
    says="cylinders of two joints share oil through a line: it flows over if they move slowly",
    source="Merritt, Hydraulic Control Systems, Wiley 1967, chapters 2 and 3 (springs of oil, flow in lines)",
    units={
        "stiffness": "N·m/rad, of the oil in a cylinder, at the first joint",
        "ratio": RATIO.units["ratio"],
        "time": "s, of the flow",
    },
    draw=_draw_oil,
    check=positive("stiffness", "time"),
    act=_act_oil,
    active=False,
)

FORMS = (ACCELERATED, CREEPING, OIL_LINE)
