"""Matrices in, modes out. Knows no robot and no frequency axis."""

from flexmodal.modal.modes import Modes as Modes
from flexmodal.modal.modes import solve_modes as solve_modes
from flexmodal.modal.system import SecondOrderSystem as SecondOrderSystem
