"""The effects that the rig can hide, one file each; those outside any catalogue in `outside`."""

from flexmodal.rig.effects import (
    added_mass,
    base_flexibility,
    bearing_flexibility,
    coulomb_friction,
    joint_coupling,
    link_flexibility,
    local_absorber,
    nonlinear_stiffness,
    outside,
    sensors,
    servo_compliance,
    structural_damping,
)
from flexmodal.rig.effects.effect import Effect as Effect
from flexmodal.rig.effects.effect import Site as Site
from flexmodal.rig.effects.effect import Stand as Stand

EFFECTS: dict[str, Effect] = {
    effect.name: effect
    for effect in (
        link_flexibility.EFFECT,
        base_flexibility.EFFECT,
        servo_compliance.EFFECT,
        structural_damping.EFFECT,
        coulomb_friction.EFFECT,
        nonlinear_stiffness.EFFECT,
        joint_coupling.EFFECT,
        added_mass.EFFECT,
        local_absorber.EFFECT,
        sensors.SENSOR_MASS,
        sensors.SENSOR_GAIN,
        sensors.TIME_DELAY,
        sensors.SENSOR_MISALIGNMENT,
        bearing_flexibility.EFFECT,
        outside.CLEARANCE,
        outside.HOSE,
        outside.SATURATION,
        outside.NEIGHBOUR,
    )
}
"""By name; the names of a diagnosis first, then those it has no name for."""
