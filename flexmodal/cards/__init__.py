"""Robot cards and URDFs as text, frozen dataclasses, and where to find them."""

from flexmodal.cards.card import CouplingCard as CouplingCard
from flexmodal.cards.card import FamilyCard as FamilyCard
from flexmodal.cards.card import JointCard as JointCard
from flexmodal.cards.card import ObstacleCard as ObstacleCard
from flexmodal.cards.card import PointCard as PointCard
from flexmodal.cards.card import RobotCard as RobotCard
from flexmodal.cards.catalogue import example_arms as example_arms
from flexmodal.cards.catalogue import find as find
from flexmodal.cards.catalogue import gripper_joints as gripper_joints
from flexmodal.cards.catalogue import shipped_cards as shipped_cards
from flexmodal.cards.consistency import check_consistency as check_consistency
from flexmodal.cards.coupling import stiffness_matrix as stiffness_matrix
from flexmodal.cards.mass import check_masses as check_masses
from flexmodal.cards.mass import massless_joints as massless_joints
from flexmodal.cards.read_card import read_card as read_card
from flexmodal.cards.read_card import urdf_named_in as urdf_named_in
from flexmodal.cards.urdf.meshes import mesh_path as mesh_path
from flexmodal.cards.urdf.read import read_urdf as read_urdf
from flexmodal.cards.urdf.tool import FoundTool as FoundTool
from flexmodal.cards.urdf.tool import find_tool as find_tool
from flexmodal.cards.urdf.urdf import Urdf as Urdf
from flexmodal.cards.urdf.urdf import UrdfJoint as UrdfJoint
from flexmodal.cards.urdf.urdf import UrdfLink as UrdfLink
from flexmodal.text.frozen import FrozenDict as FrozenDict
