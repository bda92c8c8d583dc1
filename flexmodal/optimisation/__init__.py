"""Choosing a posture, a frequency or a path: objectives, what is held, and the searches."""

from flexmodal.optimisation.combined import CombinedObjective as CombinedObjective
from flexmodal.optimisation.fixed_gain import FrequencyDescent as FrequencyDescent
from flexmodal.optimisation.fixed_gain import fixed_gain_descent as fixed_gain_descent
from flexmodal.optimisation.function import FunctionObjective as FunctionObjective
from flexmodal.optimisation.hold import Hold as Hold
from flexmodal.optimisation.measures import MobilityObjective as MobilityObjective
from flexmodal.optimisation.measures import StiffnessObjective as StiffnessObjective
from flexmodal.optimisation.objective import Objective as Objective
from flexmodal.optimisation.objective import ReceptanceObjective as ReceptanceObjective
from flexmodal.optimisation.objective import tooth_passing as tooth_passing
from flexmodal.optimisation.optimise import optimise as optimise
from flexmodal.optimisation.outcome import Optimum as Optimum
from flexmodal.optimisation.outcome import Outcome as Outcome
from flexmodal.optimisation.problem import PostureProblem as PostureProblem
from flexmodal.optimisation.robust import RobustObjective as RobustObjective
from flexmodal.optimisation.robust import sample_robots as sample_robots
from flexmodal.optimisation.separation import SeparationObjective as SeparationObjective
from flexmodal.optimisation.tune import Extremum as Extremum
from flexmodal.optimisation.tune import Tuning as Tuning
from flexmodal.optimisation.tune import tune as tune
from flexmodal.optimisation.tuned import TunedObjective as TunedObjective
