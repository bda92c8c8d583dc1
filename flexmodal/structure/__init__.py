"""A robot as a second-order system with named parameters: receptance, poles, shapes and their derivatives."""

from flexmodal.structure.arm import Arm as Arm
from flexmodal.structure.arm import Body as Body
from flexmodal.structure.assembly import Assembly as Assembly
from flexmodal.structure.parameter import Parameter as Parameter
from flexmodal.structure.parameter import ParameterSpace as ParameterSpace
from flexmodal.structure.space import robot_space as robot_space
from flexmodal.structure.structure import Axis as Axis
from flexmodal.structure.structure import Change as Change
from flexmodal.structure.structure import Structure as Structure
from flexmodal.structure.structure import receptance as receptance
