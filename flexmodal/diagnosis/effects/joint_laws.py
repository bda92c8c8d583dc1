"""Joints whose stiffness or loss depends on how far they swing, by describing functions.

At an amplitude A a non-linear torque acts, in the first harmonic, as a spring and a damper (Gelb and Vander
Velde, Multiple-Input Describing Functions, 1968). A is taken for each posture, hammer point and level of
force from the believed robot's own swing; one factor on all of them is fitted along, since a swing that dies
away has no single amplitude.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from flexmodal.diagnosis.effects.effect import Effect, Scene, Site, positive, signed
from flexmodal.diagnosis.march.law import friction, hardening
from flexmodal.diagnosis.swing import Swing, swings
from flexmodal.structure import Parameter
from flexmodal.structure.assembly import Assembly

_PHASE = (np.arange(32) + 0.5) * np.pi / 32


def _swing(site: Site) -> Swing:
    """Of the joint at this site under this blow."""
    scene, key = site.scene, (site.posture, site.reference, site.level)
    table = scene.memory.setdefault("swings", {})
    if key not in table:
        table[key] = swings(scene, site.posture, site.reference, scene.pulses[site.level])
    one = table[key][site.where]
    return Swing(one.amplitude * site.values.get("reach", 1.0), one.omega)


def _typical(scene: Scene, where: str) -> float:
    """Swing of a joint under the blows of the campaign, geometric mean [rad]."""
    observations = scene.observations
    found = []
    for level in np.unique(observations.level).tolist():
        for reference in np.unique(observations.reference, axis=0).tolist():
            blank = Site(scene, where, {}, 0, int(level), (reference[0], reference[1]))
            found.append(_swing(blank).amplitude)
    return float(np.exp(np.mean(np.log(np.maximum(found, 1e-300)))))


def _one_level(scene: Scene) -> str | None:
    return "one level of force only: what depends on it cannot be told" if scene.level_count < 2 else None


def dahl(amplitude: float, torque: float, presliding: float, exponent: float = 1.0) -> tuple[float, float]:
    """Stiffness and loss (torque a radian, in and out of phase) of Dahl's friction at an amplitude.

    On the way up from −A the part of the way to sliding that is left, r = 1 − F/F_c, falls as
    dr/dq = −(σ/F_c) rⁱ; where it starts is found by bisection, so that loops close.
    """
    size = min(presliding * amplitude / torque, 300.0)

    def left(start: float, way: np.ndarray) -> np.ndarray:
        power = 1 - exponent
        if abs(power) < 1e-9:
            return np.asarray(start * np.exp(-way))
        if start <= 0:
            return np.zeros_like(way)
        return np.asarray(np.maximum(start**power - power * way, 0.0) ** (1 / power))

    low, high = 1.0, 2.0  # r starts at 1 + F₀/F_c and ends at 1 − F₀/F_c
    for _ in range(50):
        middle = (low + high) / 2
        ends = float(left(middle, np.array([2 * size]))[0])
        low, high = (middle, high) if middle + ends < 2 else (low, middle)
    q = -np.cos(_PHASE)  # from −A to A
    force = torque * (1 - left((low + high) / 2, size * (q + 1)))
    stiffness = 2 / len(_PHASE) * float(np.sum(force * q)) / amplitude
    loss = 2 / len(_PHASE) * float(np.sum(force * np.sin(_PHASE))) / amplitude
    return stiffness, loss


def hardened(amplitude: float) -> float:
    """Part of the change of stiffness that an amplitude sees, 0 to 1: for u³/(1 + u²), amplitude over q_r."""
    a = max(amplitude, 1e-4)
    return float(1 - 2 / a**2 * (1 - 1 / np.sqrt(1 + a**2)))


_FRICTION = ("torque", "presliding_stiffness", "exponent")


def _rub(assembly: Assembly, site: Site) -> None:
    swing = _swing(site)
    torque, bristles, exponent = (site[name] for name in _FRICTION)
    stiffness, loss = dahl(swing.amplitude, torque, bristles, exponent)
    row = assembly.stretch_of(site.where)
    assembly.add_spring(row, stiffness)
    assembly.add_damper(row, loss / swing.omega)


def _friction_parameters(scene: Scene, where: str) -> tuple[Parameter, ...]:
    k = float(scene.robot.joints[where].stiffness)
    torque = 0.1 * k * _typical(scene, where)
    return (
        positive("torque", "N·m", torque, 1.2, torque / 1e3, torque * 1e3),
        positive("presliding_stiffness", "N·m/rad", 5 * k, 0.7, 0.1 * k, 200 * k),
        signed("exponent", "", 0.4, 0.0, 1.6, centre=1.0),
        positive("reach", "", 1.0, 0.7, 0.05, 20.0),
    )


FRICTION = Effect(
    name="coulomb_friction",
    says="the joint has dry friction",
    looks_like="resonances that are lower and less damped the harder the blow",
    places=lambda scene: scene.joints,
    parameters=_friction_parameters,
    starts=lambda scene, where: [
        {"torque": share * float(scene.robot.joints[where].stiffness) * _typical(scene, where)}
        for share in (0.02, 0.1, 0.4)
    ],
    act=_rub,
    law=lambda assembly, site: friction(assembly.stretch_of(site.where), *(site[name] for name in _FRICTION)),
    variants=("blow",),
    untestable=_one_level,
    physical=lambda scene, where, values: {name: values[name] for name in _FRICTION},
)


def _stiffness(site: Site) -> float:
    """Of the joint at small swings [N·m/rad]."""
    return site.values.get(f"stiffness.{site.where}", float(site.scene.robot.joints[site.where].stiffness))


def _stiffen(assembly: Assembly, site: Site) -> None:
    swing = _swing(site)
    part = hardened(swing.amplitude / site["deflection"])
    assembly.add_spring(assembly.stretch_of(site.where), site["change"] * part * _stiffness(site))


def _hardening_parameters(scene: Scene, where: str) -> tuple[Parameter, ...]:
    size = _typical(scene, where)
    return (
        signed("change", "", 0.6, -0.85, 6.0),
        positive("deflection", "rad", size, 1.0, size / 100, size * 100),
    )


def _hardening_physical(scene: Scene, where: str, values: Mapping[str, float]) -> dict[str, float]:
    k = values.get(f"stiffness.{where}", float(scene.robot.joints[where].stiffness))
    return {
        "change": values["change"],
        "deflection": values["deflection"],
        "cubic_stiffness": values["change"] * k / values["deflection"] ** 2,
    }


NONLINEAR = Effect(
    name="nonlinear_stiffness",
    says="the joint's spring hardens or softens",
    looks_like="resonances that move with the force of the blow, their damping unchanged",
    places=lambda scene: scene.joints,
    parameters=_hardening_parameters,
    starts=lambda scene, where: [
        {"change": change, "deflection": share * _typical(scene, where)}
        for change in (0.3, -0.3)
        for share in (0.6, 2.0)
    ],
    act=_stiffen,
    law=lambda assembly, site: hardening(
        assembly.stretch_of(site.where), site["change"] * _stiffness(site), site["deflection"]
    ),
    variants=("blow",),
    untestable=_one_level,
    physical=_hardening_physical,
    units={"cubic_stiffness": "N·m/rad³"},
)
