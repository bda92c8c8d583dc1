"""Matrices in, modes out. Knows no robot and no frequency axis."""

from flexmodal.modal.hysteresis import Hysteresis as Hysteresis
from flexmodal.modal.mac import auto_mac as auto_mac
from flexmodal.modal.mac import comac as comac
from flexmodal.modal.mac import mac as mac
from flexmodal.modal.mac import phase_collinearity as phase_collinearity
from flexmodal.modal.modes import NO_MODES as NO_MODES
from flexmodal.modal.modes import Modes as Modes
from flexmodal.modal.modes import solve_modes as solve_modes
from flexmodal.modal.state_space import LinearModel as LinearModel
from flexmodal.modal.state_space import linear_model as linear_model
from flexmodal.modal.state_space import modal_model as modal_model
from flexmodal.modal.state_space import model_of_modes as model_of_modes
from flexmodal.modal.system import SecondOrderSystem as SecondOrderSystem
from flexmodal.modal.tracking import track as track
from flexmodal.modal.tracking import track_all as track_all
