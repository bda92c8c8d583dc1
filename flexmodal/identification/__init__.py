"""Changes parameters to match a measurement, with uncertainty."""

from flexmodal.identification.frf_fit import FrfFit as FrfFit
from flexmodal.identification.frf_fit import fit as fit
from flexmodal.identification.gap import Gap as Gap
from flexmodal.identification.gap import gap as gap
from flexmodal.identification.identifiability import Combination as Combination
from flexmodal.identification.identifiability import Identifiability as Identifiability
from flexmodal.identification.identify import identify as identify
from flexmodal.identification.identify import solve_identification as solve_identification
from flexmodal.identification.mode_data import ModeObservations as ModeObservations
from flexmodal.identification.model import FrfModel as FrfModel
from flexmodal.identification.model import ReceptanceModel as ReceptanceModel
from flexmodal.identification.model import RobotModel as RobotModel
from flexmodal.identification.model import predict as predict
from flexmodal.identification.observations import Observations as Observations
from flexmodal.identification.observations import observe as observe
from flexmodal.identification.outcome import Outcome as Outcome
from flexmodal.identification.parameter import Parameter as Parameter
from flexmodal.identification.parameter import ParameterSpace as ParameterSpace
from flexmodal.identification.problem import IdentificationProblem as IdentificationProblem
from flexmodal.identification.problem import build_identification as build_identification
from flexmodal.identification.space import robot_space as robot_space
from flexmodal.identification.uncertainty import Uncertainty as Uncertainty
from flexmodal.identification.uncertainty import uncertainty as uncertainty
