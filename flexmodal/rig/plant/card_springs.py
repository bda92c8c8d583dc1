"""What a card says of its joints' springs beside stiffness and damping: couplings, and a loss factor.

The model's spring of constant loss factor is a power law of frequency (`Hysteresis`). In time a row of
Maxwell elements stands for it, 2.5 to a decade from a tenth of the first line to ten times the band's end,
their strengths fitted without a negative one: within 10⁻⁴ of the power law for loss factors up to 0.5.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from flexmodal.errors import Fault, InvalidRequest
from flexmodal.modal import Hysteresis
from flexmodal.model import Robot
from flexmodal.rig.believed import TrueRobot
from flexmodal.rig.plan import HammerPlan
from flexmodal.rig.plant.assembly import PlantAssembly

CLOSE = 1e-3
"""How far the elements may be off the power law, relative; of more, a card is refused."""
_EACH_DECADE, _MARGIN, _LINES = 2.5, 10.0, 40


def refuse_springs(robot: Robot, plan: HammerPlan) -> None:
    """Complain about a spring of the card that cannot be simulated in time.

    Args:
        robot: with its card.
        plan: of the test, for its band.

    Raises:
        InvalidRequest: a loss factor without `loss_frequency`, or one that no row of elements comes near.
    """
    faults = []
    for name, joint in robot.joints.items():
        key = f"robot: joint.{name}.loss_factor"
        found = f"{joint.loss_factor:g}"
        if joint.loss_factor and robot.loss_frequency is None:
            allowed = "one with loss_frequency in the card: without, the spring answers before it is pushed"
            faults.append(Fault("call", key, found, allowed))
        elif joint.loss_factor and _row(robot, joint.loss_factor, plan) is None:
            faults.append(Fault("call", key, f"{found}, of which nothing in time comes near", "at most 1"))
    if faults:
        raise InvalidRequest(faults)


def add_card_springs(assembly: PlantAssembly, robot: Robot, true: TrueRobot, plan: HammerPlan) -> None:
    """Put couplings and lossy springs of the card in; the joints' own springs stand already.

    Args:
        assembly: of one posture, its effects put in.
        robot: with its card.
        true: the robot that is struck, for its stiffness.
        plan: of the test, for its band.
    """
    for coupling in robot.couplings.values():
        assembly.add_coupling(*coupling.joints, coupling.stiffness)
    for name, joint in robot.joints.items():
        row = _row(robot, joint.loss_factor, plan) if joint.loss_factor else None
        if row is None:
            continue
        static, strengths, times = row
        stretched, k = assembly.stretch(name), true.stiffness[name]
        assembly.add_spring(stretched, (static - 1) * k)
        assembly.add_relaxation(stretched, strengths * k, times)


def _row(robot: Robot, loss: float, plan: HammerPlan) -> tuple[float, np.ndarray, np.ndarray] | None:
    first = 1 / (plan.analyser.samples * plan.analyser.interval)
    return None if robot.loss_frequency is None else maxwell(loss, robot.loss_frequency, first, plan.band[1])


@lru_cache(maxsize=64)
def maxwell(
    loss: float, frequency: float, low: float, high: float
) -> tuple[float, np.ndarray, np.ndarray] | None:
    """Static spring, strengths and relaxation times that stand for a spring of constant loss factor.

    Args:
        loss: η.
        frequency: where the real part is 1 [Hz].
        low: first line [Hz].
        high: last line [Hz].

    Returns:
        Long-term stiffness, strengths of the elements and their relaxation times [s]; None where no such row
        comes near.
    """
    from scipy.optimize import nnls

    ends = 2 * np.pi * low, 2 * np.pi * high
    count = int(np.ceil(_EACH_DECADE * np.log10(ends[1] / ends[0] * _MARGIN**2))) + 1
    times = 1 / np.geomspace(ends[0] / _MARGIN, ends[1] * _MARGIN, count)
    omega = np.geomspace(*ends, _LINES * int(np.ceil(np.log10(ends[1] / ends[0]) + 1)))
    law = 1 + Hysteresis(np.ones(1), np.array([loss]), frequency).added(1j * omega)[:, 0]
    lag = 1j * omega[:, None] * times
    rows = np.hstack([np.ones((len(omega), 1)), lag / (1 + lag)]) / np.abs(law)[:, None]
    wanted = law / np.abs(law)
    try:
        found, _ = nnls(np.vstack([rows.real, rows.imag]), np.concatenate([wanted.real, wanted.imag]))
    except RuntimeError:  # too steep for any such row
        return None
    if found[0] <= 0 or np.abs(rows @ found - wanted).max() > CLOSE:
        return None
    return float(found[0]), found[1:], times
