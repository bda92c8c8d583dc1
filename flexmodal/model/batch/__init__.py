"""Many postures at once: receptances and their derivatives, compiled where that pays."""

from flexmodal.model.batch.gradients import gradient_batch as gradient_batch
from flexmodal.model.batch.positions import position_batch as position_batch
from flexmodal.model.batch.receptances import receptance_batch as receptance_batch
from flexmodal.model.batch.request import DirectionPair as DirectionPair
from flexmodal.model.batch.request import ReceptanceBatch as ReceptanceBatch
from flexmodal.model.batch.request import expand as expand
from flexmodal.model.batch.request import posture_array as posture_array
from flexmodal.model.batch.request import read_pairs as read_pairs
