"""Every effect in several physical forms, and which of them may be looked at when a diagnosis is tuned.

`FORMS[name]["own"]` is the effect as the rig has always had it. Forms of one effect share its name, and
nothing of their laws. Those `SEALED`, `UNSEEN`, `LATER`, `BLIND`, `FURTHER`, `THIRD`, `FOURTH` and `FIFTH`
are for exams alone.
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
    structural_damping,
    third_bodies,
    third_drives,
    third_joints,
    third_sensors,
)

FORMS: dict[str, dict[str, Effect]] = {name: {effect.form: effect} for name, effect in EFFECTS.items()}
"""By name of the effect, then of the form."""
for _room in (
    link_flexibility, base_flexibility, servo_compliance, structural_damping, coulomb_friction,
    nonlinear_stiffness, joint_coupling, added_mass, local_absorber, sensor_mass, sensors,
    sensor_alignment, bearing_flexibility, base_carriage, base_pedestal, base_gantry,
    link_plates, joint_remote, further_bodies, further_drives, further_joints,
    further_sensors, third_bodies, third_drives, third_joints, third_sensors,
    fourth_bodies, fourth_drives, fourth_joints, fourth_sensors, fifth_bodies, fifth_drives,
    fifth_joints, fifth_sensors,
):  # fmt: skip
    for _effect in _room.FORMS:
        FORMS[_effect.name][_effect.form] = _effect

LOOKED_AT: dict[str, tuple[str, ...]] = {
    "link_flexibility": ("hinge", "tapered", "flange"),
    "base_flexibility": ("directions", "block"),
    "servo_compliance": ("brake", "cascade"),
    "structural_damping": ("power_law", "zener", "prony"),
    "coulomb_friction": ("tanh", "iwan"),
    "nonlinear_stiffness": ("cubic", "wind_up", "play"),
    "joint_coupling": ("ratio", "idler"),
    "added_mass": ("point", "two"),
    "local_absorber": ("two_way", "pendulum"),
    "sensor_mass": ("block", "cable"),
    "sensor_gain": ("inverted", "aged"),
    "time_delay": ("low_pass", "all_pass"),
    "sensor_misalignment": ("cross", "stand_off"),
    "bearing_flexibility": ("rows",),
}
"""Forms that may be simulated and studied while a diagnosis is being tuned."""
SEALED: dict[str, tuple[str, ...]] = {
    "link_flexibility": ("timoshenko", "twisting", "pieces"),
    "base_flexibility": ("feet", "bolted", "radiating"),
    "servo_compliance": ("delayed", "current"),
    "structural_damping": ("fractional", "by_joint"),
    "coulomb_friction": ("stribeck", "lugre", "bouc_wen"),
    "nonlinear_stiffness": ("levelling", "exponential", "leaning"),
    "joint_coupling": ("damped", "belt", "rod"),
    "added_mass": ("disc", "rod", "stalk"),
    "local_absorber": ("twin", "rubber"),
    "sensor_mass": ("sprung", "dragged"),
    "sensor_gain": ("high_pass", "resonant"),
    "time_delay": ("bessel", "hold"),
    "sensor_misalignment": ("leaning", "skewed"),
    "bearing_flexibility": ("housing", "relaxing"),
}
"""Forms of the exam: whoever tunes a diagnosis leaves them alone."""
UNSEEN: dict[str, tuple[str, ...]] = {
    "link_flexibility": ("stepped", "flanges"),
    "base_flexibility": ("carriage",),
    "servo_compliance": ("link_side",),
    "structural_damping": ("two_peaks", "geared"),
    "coulomb_friction": ("segalman",),
    "nonlinear_stiffness": ("s_shaped", "stop"),
    "joint_coupling": ("differential",),
    "added_mass": ("duct",),
    "local_absorber": ("whip",),
    "sensor_mass": ("bracket",),
    "sensor_gain": ("amplifier",),
    "time_delay": ("anti_alias",),
    "sensor_misalignment": ("cross_axis",),
    "bearing_flexibility": ("bolts",),
}
"""Forms that were written when the diagnosis was done; docs/diagnosis_accuracy.md says which of them have
been looked into since."""

LATER: dict[str, tuple[str, ...]] = {
    "link_flexibility": ("cracked",),
    "base_flexibility": ("pedestal",),
    "servo_compliance": ("notched",),
    "structural_damping": ("cole_cole",),
    "coulomb_friction": ("seal",),
    "nonlinear_stiffness": ("gradual",),
    "joint_coupling": ("hose",),
    "added_mass": ("counterweight",),
    "local_absorber": ("string",),
    "sensor_mass": ("taped",),
    "sensor_gain": ("shelf",),
    "time_delay": ("decimated",),
    "sensor_misalignment": ("swapped",),
    "bearing_flexibility": ("angular_contact",),
}
"""Likewise, written once those before had been met and what they showed was mended."""

BLIND: dict[str, tuple[str, ...]] = {
    "link_flexibility": ("plates",),
    "base_flexibility": ("gantry",),
    "servo_compliance": ("torque_fed",),
    "structural_damping": ("biot",),
    "coulomb_friction": ("loaded",),
    "nonlinear_stiffness": ("rolling",),
    "joint_coupling": ("remote",),
    "added_mass": ("half_full",),
    "local_absorber": ("stacked",),
    "sensor_mass": ("along_arm",),
    "sensor_gain": ("one_axis",),
    "time_delay": ("smoothed",),
    "sensor_misalignment": ("following",),
    "bearing_flexibility": ("pinion",),
}
"""Likewise, by an author who did not know how the diagnosis works."""

FURTHER: dict[str, tuple[str, ...]] = {
    "link_flexibility": ("layered",),
    "base_flexibility": ("table",),
    "servo_compliance": ("belted",),
    "structural_damping": ("oscillators",),
    "coulomb_friction": ("cylinder",),
    "nonlinear_stiffness": ("slack",),
    "joint_coupling": ("seat",),
    "added_mass": ("hanging",),
    "local_absorber": ("rocking",),
    "sensor_mass": ("held",),
    "sensor_gain": ("hum",),
    "time_delay": ("taken_out",),
    "sensor_misalignment": ("round",),
    "bearing_flexibility": ("overhung",),
}
"""Likewise, by a second author who did not know how the diagnosis works."""

THIRD: dict[str, tuple[str, ...]] = {
    "link_flexibility": ("telescoped",),
    "base_flexibility": ("rubber_mounts",),
    "servo_compliance": ("accelerated",),
    "structural_damping": ("creeping",),
    "coulomb_friction": ("eccentric",),
    "nonlinear_stiffness": ("spider",),
    "joint_coupling": ("oil_line",),
    "added_mass": ("pipe",),
    "local_absorber": ("panel",),
    "sensor_mass": ("whipping",),
    "sensor_gain": ("equalised",),
    "time_delay": ("interpolated",),
    "sensor_misalignment": ("sagging",),
    "bearing_flexibility": ("load_zone",),
}
"""Likewise, by a third such author."""

FOURTH: dict[str, tuple[str, ...]] = {
    "link_flexibility": ("squeezed",),
    "base_flexibility": ("wheels",),
    "servo_compliance": ("two_motors",),
    "structural_damping": ("lopsided",),
    "coulomb_friction": ("clamped",),
    "nonlinear_stiffness": ("gaping",),
    "joint_coupling": ("balancer",),
    "added_mass": ("slung",),
    "local_absorber": ("leaf",),
    "sensor_mass": ("converter",),
    "sensor_gain": ("adapter",),
    "time_delay": ("long_line",),
    "sensor_misalignment": ("reset",),
    "bearing_flexibility": ("slotted",),
}
"""Likewise, by a fourth such author."""

FIFTH: dict[str, tuple[str, ...]] = {
    "link_flexibility": ("opening",),
    "base_flexibility": ("console",),
    "servo_compliance": ("observer",),
    "structural_damping": ("pressed",),
    "coulomb_friction": ("splined",),
    "nonlinear_stiffness": ("strands",),
    "joint_coupling": ("tensioner",),
    "added_mass": ("heap",),
    "local_absorber": ("loop",),
    "sensor_mass": ("in_sets",),
    "sensor_gain": ("droop",),
    "time_delay": ("drifting",),
    "sensor_misalignment": ("loosening",),
    "bearing_flexibility": ("fork",),
}
"""Likewise, by a fifth author who had read the rig and nothing of the diagnosis."""


def find(name: str, form: str = "own") -> Effect:
    """An effect in one of its forms; both have to be there.

    Args:
        name: of the effect.
        form: of its forms.
    """
    return FORMS[name][form]
