"""Which port each effect of the catalogue sits at and its curve's classes; which ports hold others."""

from __future__ import annotations

from collections.abc import Mapping

PORT_OF: Mapping[str, str] = {
    "joint_coupling": "coupling",
    "structural_damping": "damping",
    "base_flexibility": "base",
    "bearing_flexibility": "bearing",
    "link_flexibility": "link",
    "added_mass": "body",
    "local_absorber": "body",
    "servo_compliance": "joint",
    "sensor_mass": "carried",
    "sensor_gain": "sensor",
    "time_delay": "sensor",
    "sensor_misalignment": "channel",
    "coulomb_friction": "torque",
    "nonlinear_stiffness": "torque",
}
"""The kind of port that each effect of the catalogue sits at."""
_WIDER = {
    "channel": "sensor", "blows": "hammer", "coupling": "joint", "rod": "coupling",
    "balancer": "coupling", "held": "coupling", "attached": "body", "ground": "body", "across": "body",
}  # fmt: skip
"""Kinds of port that can do whatever one of another kind in the same place can."""
WIDE = {wide for wide, held in _WIDER.items() if wide not in PORT_OF.values() and held in PORT_OF.values()}
"""Kinds of port that do what the narrow law of an effect cannot, but a wider one can: a rod, what holds the
tool, what turns, what is not alike in every direction of the world, what hangs on two links."""
DOES_MUCH = ("base",)
"""Kinds of port whose effects can do what many plainer ones do that touch them."""
_ELASTIC = ("spring", "spring and damper", "spring with constant loss", "spring, damper and mass")
CLASSES_OF: Mapping[str, tuple[str, ...]] = {
    "joint_coupling": (
        "spring",
        "spring and damper",
        "relaxation",
        "something in series, with a resonance of its own",
    ),
    "structural_damping": ("constant loss", "relaxation", "fractional loss", "row of relaxations"),
    "base_flexibility": _ELASTIC,
    "bearing_flexibility": _ELASTIC,
    "link_flexibility": _ELASTIC,
    "added_mass": ("mass",),
    "local_absorber": ("resonance",),
    "servo_compliance": ("resonance", "something in series, with a resonance of its own", "relaxation"),
    "sensor_mass": ("mass", "resonance", "spring, damper and mass"),
    "sensor_gain": (
        "gain",
        "gain and phase",
        "gain with a power of frequency",
        "high pass and gain",
        "resonance of its mount and gain",
        "step and gain",
    ),
    "time_delay": ("delay", "gain and delay", "low pass and gain", "all-pass and gain"),
}
"""The classes that its curve can be of; effects that are not listed have no common curve to be of a class."""


def holds(wide: tuple[str, str], narrow: tuple[str, str]) -> bool:
    """Whether a port is the same as another, or can do whatever it can.

    Args:
        wide: kind and place of the port that may do more.
        narrow: the same of the other.
    """
    same = narrow[1] in (wide[1], *wide[1].split("+"))
    return wide == narrow or (_WIDER.get(wide[0]) == narrow[0] and same)
