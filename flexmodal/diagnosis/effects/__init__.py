"""The catalogue: every effect the diagnosis knows, ours and those that others add."""

from flexmodal.diagnosis.effects.catalogue import catalogue as catalogue
from flexmodal.diagnosis.effects.context import Context as Context
from flexmodal.diagnosis.effects.effect import Effect as Effect
from flexmodal.diagnosis.effects.effect import Placement as Placement
