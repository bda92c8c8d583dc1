"""All effects by name: those of this package, and those of the entry point group `flexmodal.effects`."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.metadata import entry_points

from flexmodal.diagnosis.effects import (
    added_mass,
    base_flexibility,
    joint_coupling,
    joint_laws,
    link_flexibility,
    local_absorber,
    sensors,
    servo_compliance,
    structural_damping,
)
from flexmodal.diagnosis.effects.effect import Effect
from flexmodal.errors import Fault, InvalidRequest

OWN = (
    link_flexibility.EFFECT,
    base_flexibility.EFFECT,
    servo_compliance.EFFECT,
    structural_damping.EFFECT,
    joint_laws.FRICTION,
    joint_laws.NONLINEAR,
    joint_coupling.EFFECT,
    added_mass.EFFECT,
    local_absorber.EFFECT,
    sensors.SENSOR_MASS,
    sensors.SENSOR_GAIN,
    sensors.SENSOR_DELAY,
    sensors.SENSOR_MISALIGNMENT,
)
GROUP = "flexmodal.effects"


def catalogue(names: Sequence[str] | None = None) -> dict[str, Effect]:
    """Effects by name, some or all.

    Raises:
        InvalidRequest: a name that nothing answers to, or an entry point that is no effect.
    """
    found = {effect.name: effect for effect in OWN}
    faults = []
    for point in entry_points(group=GROUP):
        effect = point.load()
        if not isinstance(effect, Effect) or effect.name in found:
            what = f"{point.value}: " + (
                "an effect of a name that is taken" if isinstance(effect, Effect) else type(effect).__name__
            )
            faults.append(Fault("entry points", f"{GROUP}: {point.name}", what, "an Effect of its own name"))
            continue
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
