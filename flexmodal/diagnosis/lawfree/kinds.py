"""The ports that a law-free look tries."""

from flexmodal.diagnosis.lawfree.body_ports import ACROSS, ATTACHED_BODY, BODY, GROUND
from flexmodal.diagnosis.lawfree.carried_ports import CARRIED
from flexmodal.diagnosis.lawfree.elastic_ports import BASE, BEARING
from flexmodal.diagnosis.lawfree.joint_ports import BALANCER, COUPLING, DAMPING, HELD, JOINT, ROD, TORQUE
from flexmodal.diagnosis.lawfree.link_ports import LINK
from flexmodal.diagnosis.lawfree.reading_ports import BLOWS, CHANNEL, HAMMER, NOTHING, SENSOR

KINDS = (JOINT, DAMPING, COUPLING, BASE, BEARING, LINK, BODY, GROUND, CARRIED, SENSOR, HAMMER, CHANNEL, BLOWS)
"""For FRFs that do not depend on the force of the blow; otherwise `TORQUE` besides."""
RARE = (ROD, BALANCER, HELD, ATTACHED_BODY, ACROSS)
"""Tried where none of these explains what is missing."""

__all__ = ["KINDS", "NOTHING", "RARE", "TORQUE"]
