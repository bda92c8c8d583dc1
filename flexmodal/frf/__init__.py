"""Everything with a frequency axis: receptance, its forms, labelled FRFs and their pictures."""

from flexmodal.frf.axis import frequency_axis as frequency_axis
from flexmodal.frf.direction import PointDirection as PointDirection
from flexmodal.frf.form import Form as Form
from flexmodal.frf.frf import Frf as Frf
from flexmodal.frf.receptance import modal_sum as modal_sum
from flexmodal.frf.receptance import receptance as receptance
