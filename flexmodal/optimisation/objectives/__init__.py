"""What postures are judged by, each with its gradient."""

from flexmodal.optimisation.objectives.combined import CombinedObjective as CombinedObjective
from flexmodal.optimisation.objectives.function import FunctionObjective as FunctionObjective
from flexmodal.optimisation.objectives.measures import LEVER as LEVER
from flexmodal.optimisation.objectives.measures import MobilityObjective as MobilityObjective
from flexmodal.optimisation.objectives.measures import StiffnessObjective as StiffnessObjective
from flexmodal.optimisation.objectives.objective import BLIND as BLIND
from flexmodal.optimisation.objectives.objective import SHARPNESS as SHARPNESS
from flexmodal.optimisation.objectives.objective import Limit as Limit
from flexmodal.optimisation.objectives.objective import Objective as Objective
from flexmodal.optimisation.objectives.objective import ReceptanceObjective as ReceptanceObjective
from flexmodal.optimisation.objectives.objective import tooth_passing as tooth_passing
from flexmodal.optimisation.objectives.robust import RobustObjective as RobustObjective
from flexmodal.optimisation.objectives.robust import sample_robots as sample_robots
from flexmodal.optimisation.objectives.separation import SeparationObjective as SeparationObjective
from flexmodal.optimisation.objectives.tuned import TunedObjective as TunedObjective
