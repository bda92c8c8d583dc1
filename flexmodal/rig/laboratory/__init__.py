"""What goes wrong in a laboratory, done to a campaign that was right."""

from flexmodal.rig.laboratory.mishaps import MISHAPS as MISHAPS
from flexmodal.rig.laboratory.mishaps import Mishap as Mishap
from flexmodal.rig.laboratory.mishaps import draw_mishaps as draw_mishaps
from flexmodal.rig.laboratory.mishaps import with_mishaps as with_mishaps
