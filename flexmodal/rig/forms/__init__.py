"""Every effect in several physical forms, and which of them may be looked at when a diagnosis is tuned.

`FORMS[name]["own"]` is the effect as the rig has always had it. Forms of one effect share its name, and
nothing of their laws. `FORM_SETS` says which may be looked at and which are for exams alone.
"""

from __future__ import annotations

from flexmodal.rig.effects import EFFECTS, Effect
from flexmodal.rig.forms import (
    added_mass,
    base_carriage,
    base_flexibility,
    base_gantry,
    base_pedestal,
    bearing_flexibility,
    coulomb_friction,
    fifth_bodies,
    fifth_drives,
    fifth_joints,
    fifth_sensors,
    fourth_bodies,
    fourth_drives,
    fourth_joints,
    fourth_sensors,
    further_bodies,
    further_drives,
    further_joints,
    further_sensors,
    joint_coupling,
    joint_remote,
    link_flexibility,
    link_plates,
    local_absorber,
    nonlinear_stiffness,
    sensor_alignment,
    sensor_mass,
    sensors,
    servo_compliance,
    seventh_bodies,
    seventh_drives,
    seventh_joints,
    seventh_sensors,
    sixth_bodies,
    sixth_drives,
    sixth_joints,
    sixth_sensors,
    structural_damping,
    third_bodies,
    third_drives,
    third_joints,
    third_sensors,
)
from flexmodal.rig.forms.sets import FORM_SETS as FORM_SETS

FORMS: dict[str, dict[str, Effect]] = {name: {effect.form: effect} for name, effect in EFFECTS.items()}
"""By name of the effect, then of the form."""
for _room in (
    link_flexibility, base_flexibility, servo_compliance, structural_damping, coulomb_friction,
    nonlinear_stiffness, joint_coupling, added_mass, local_absorber, sensor_mass, sensors,
    sensor_alignment, bearing_flexibility, base_carriage, base_pedestal, base_gantry,
    link_plates, joint_remote, further_bodies, further_drives, further_joints,
    further_sensors, third_bodies, third_drives, third_joints, third_sensors,
    fourth_bodies, fourth_drives, fourth_joints, fourth_sensors,
    fifth_bodies, fifth_drives, fifth_joints, fifth_sensors,
    sixth_bodies, sixth_drives, sixth_joints, sixth_sensors,
    seventh_bodies, seventh_drives, seventh_joints, seventh_sensors,
):  # fmt: skip
    for _effect in _room.FORMS:
        FORMS[_effect.name][_effect.form] = _effect


def find(name: str, form: str = "own") -> Effect:
    """An effect in one of its forms; both have to be there.

    Args:
        name: of the effect.
        form: of its forms.
    """
    return FORMS[name][form]
