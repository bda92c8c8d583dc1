"""Choosing a posture, a frequency or a path: objectives, what is held, and the searches."""

from flexmodal.optimisation.clearance import Clearance as Clearance
from flexmodal.optimisation.frequency import Extremum as Extremum
from flexmodal.optimisation.frequency import FrequencyDescent as FrequencyDescent
from flexmodal.optimisation.frequency import Tuning as Tuning
from flexmodal.optimisation.frequency import fixed_gain_descent as fixed_gain_descent
from flexmodal.optimisation.frequency import tune as tune
from flexmodal.optimisation.hold import Hold as Hold
from flexmodal.optimisation.objectives import CombinedObjective as CombinedObjective
from flexmodal.optimisation.objectives import FunctionObjective as FunctionObjective
from flexmodal.optimisation.objectives import MobilityObjective as MobilityObjective
from flexmodal.optimisation.objectives import Objective as Objective
from flexmodal.optimisation.objectives import ReceptanceObjective as ReceptanceObjective
from flexmodal.optimisation.objectives import RobustObjective as RobustObjective
from flexmodal.optimisation.objectives import SeparationObjective as SeparationObjective
from flexmodal.optimisation.objectives import StiffnessObjective as StiffnessObjective
from flexmodal.optimisation.objectives import TunedObjective as TunedObjective
from flexmodal.optimisation.objectives import sample_robots as sample_robots
from flexmodal.optimisation.objectives import tooth_passing as tooth_passing
from flexmodal.optimisation.optimise import optimise as optimise
from flexmodal.optimisation.outcome import Optimum as Optimum
from flexmodal.optimisation.outcome import Outcome as Outcome
from flexmodal.optimisation.outcome import Start as Start
from flexmodal.optimisation.problem import PostureProblem as PostureProblem
