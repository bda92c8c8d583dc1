"""All effects by name: those of this package, and those of the entry point group `flexmodal.effects`."""

from __future__ import annotations

from collections.abc import Sequence

from flexmodal.diagnosis.effects import (
    added_mass,
    base_flexibility,
    bearing_flexibility,
    dry_friction,
    joint_coupling,
    link_flexibility,
    local_absorber,
    nonlinear_stiffness,
    sensor_alignment,
    sensor_delay,
    sensor_mass,
    sensors,
    servo_compliance,
    structural_damping,
)
from flexmodal.diagnosis.effects.effect import Effect
from flexmodal.errors import Fault, InvalidRequest
from flexmodal.plugins import left_out, plugins

OWN = (
    link_flexibility.EFFECT,
    base_flexibility.EFFECT,
    bearing_flexibility.EFFECT,
    servo_compliance.EFFECT,
    structural_damping.EFFECT,
    dry_friction.EFFECT,
    nonlinear_stiffness.EFFECT,
    joint_coupling.EFFECT,
    added_mass.EFFECT,
    local_absorber.EFFECT,
    sensor_mass.EFFECT,
    sensors.SENSOR_GAIN,
    sensor_delay.EFFECT,
    sensor_alignment.SENSOR_MISALIGNMENT,
)
GROUP = "flexmodal.effects"


def catalogue(names: Sequence[str] | None = None) -> dict[str, Effect]:
    """Effects by name, some or all.

    Raises:
        InvalidRequest: a name that nothing answers to.
    """
    found = {effect.name: effect for effect in OWN}
    faults = []
    for point, effect in plugins(GROUP):
        if not isinstance(effect, Effect):
            left_out(GROUP, point.name, f"{point.value}: no Effect but {type(effect).__name__}")
        elif effect.name in found:
            left_out(
                GROUP, point.name, f"{point.value}: an effect of the name {effect.name!r}, which is taken"
            )
        else:
            found[effect.name] = effect
    if names is not None:
        faults += [
            Fault("call", "effects", repr(name), ", ".join(found)) for name in names if name not in found
        ]
        if not names:
            faults.append(Fault("call", "effects", "none", ", ".join(found)))
    if faults:
        raise InvalidRequest(faults)
    return found if names is None else {name: found[name] for name in dict.fromkeys(names)}
