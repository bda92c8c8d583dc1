"""Meshcat scenes of flexmodal robots: postures, deflections, modes, and self-contained pages."""

from flexmodal_viewer.campaign_scene import campaign_scene as campaign_scene
from flexmodal_viewer.diagnosis_scene import diagnosis_scene as diagnosis_scene
from flexmodal_viewer.live_scene import live_scene as live_scene
from flexmodal_viewer.notebook import CellView as CellView
from flexmodal_viewer.outcome_scene import outcome_scene as outcome_scene
from flexmodal_viewer.page import write_page as write_page
from flexmodal_viewer.photograph import write_picture as write_picture
from flexmodal_viewer.robot_scene import robot_scene as robot_scene
from flexmodal_viewer.serve import close_all as close_all
from flexmodal_viewer.show import show_campaign as show_campaign
from flexmodal_viewer.show import show_diagnosis as show_diagnosis
from flexmodal_viewer.show import show_outcome as show_outcome
from flexmodal_viewer.show import show_robot as show_robot
