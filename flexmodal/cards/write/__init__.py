"""Cards and URDFs written: by `identify`, by `diagnose` and by the rig."""

from flexmodal.cards.write.program import joint_state as joint_state
from flexmodal.cards.write.program import krl as krl
from flexmodal.cards.write.program import rapid as rapid
from flexmodal.cards.write.robot import write_robot as write_robot
from flexmodal.cards.write.urdf import UrdfDraft as UrdfDraft
