"""The catalogue: every effect the diagnosis knows, ours and those that others add."""

from flexmodal.diagnosis.effects.catalogue import catalogue as catalogue
from flexmodal.diagnosis.effects.effect import Effect as Effect
from flexmodal.diagnosis.effects.effect import Scene as Scene
from flexmodal.diagnosis.effects.effect import Site as Site
