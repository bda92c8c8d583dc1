"""The only door to Pinocchio: a URDF and a card to a robot, a posture to a second-order system."""

from flexmodal.model.check import check as check
from flexmodal.model.load import load as load
from flexmodal.model.load import robots as robots
from flexmodal.model.measures import Measures as Measures
from flexmodal.model.posed import PosedRobot as PosedRobot
from flexmodal.model.posture import Pose as Pose
from flexmodal.model.posture import Posture as Posture
from flexmodal.model.robot import Robot as Robot
