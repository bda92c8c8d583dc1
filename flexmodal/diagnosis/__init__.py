"""Says what is still missing between a model and a measurement, and adds it."""

from flexmodal.diagnosis.effects import Context as Context
from flexmodal.diagnosis.effects import Effect as Effect
from flexmodal.diagnosis.effects import Placement as Placement
from flexmodal.diagnosis.effects import catalogue as catalogue
from flexmodal.diagnosis.outcome import Diagnosis as Diagnosis
from flexmodal.diagnosis.workflow import diagnose as diagnose
