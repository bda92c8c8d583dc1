"""Choosing the operating frequency at a posture."""

from flexmodal.optimisation.frequency.fixed_gain import FrequencyDescent as FrequencyDescent
from flexmodal.optimisation.frequency.fixed_gain import fixed_gain_descent as fixed_gain_descent
from flexmodal.optimisation.frequency.tune import Extremum as Extremum
from flexmodal.optimisation.frequency.tune import Tuning as Tuning
from flexmodal.optimisation.frequency.tune import tune as tune
