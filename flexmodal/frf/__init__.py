"""Everything with a frequency axis: receptance, its forms, labelled FRFs and their pictures."""

from flexmodal.frf.assurance import fdac as fdac
from flexmodal.frf.assurance import frac as frac
from flexmodal.frf.axis import frequency_axis as frequency_axis
from flexmodal.frf.consistency import DrivePointCheck as DrivePointCheck
from flexmodal.frf.consistency import antiresonances as antiresonances
from flexmodal.frf.consistency import check_drive_point as check_drive_point
from flexmodal.frf.consistency import reciprocity as reciprocity
from flexmodal.frf.direction import PointDirection as PointDirection
from flexmodal.frf.direction import directions_of as directions_of
from flexmodal.frf.form import POWER as POWER
from flexmodal.frf.form import Form as Form
from flexmodal.frf.frf import Frf as Frf
from flexmodal.frf.receptance import modal_sum as modal_sum
from flexmodal.frf.receptance import receptance as receptance
