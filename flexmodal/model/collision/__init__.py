"""What an arm may run into: shapes of its URDF and of its card, and how near they come to each other."""

from flexmodal.model.collision.scene import Nearness as Nearness
from flexmodal.model.collision.scene import Scene as Scene
from flexmodal.model.collision.scene import scene_of as scene_of
