"""FRFs of a posture that nobody struck: physics as the mean, what it leaves learnt from the others."""

from flexmodal.prediction.frf_prediction import FrfPrediction as FrfPrediction
from flexmodal.prediction.frf_prediction import PredictedFrf as PredictedFrf
from flexmodal.prediction.leave_one_out import LeftOut as LeftOut
from flexmodal.prediction.methods import METHODS as METHODS
from flexmodal.prediction.predict import PredictionProblem as PredictionProblem
from flexmodal.prediction.predict import build_prediction as build_prediction
from flexmodal.prediction.predict import predict_posture as predict_posture
from flexmodal.prediction.predict import solve_by_all as solve_by_all
from flexmodal.prediction.predict import solve_prediction as solve_prediction
from flexmodal.prediction.source import PredictedReceptances as PredictedReceptances
from flexmodal.prediction.tips import PredictedTips as PredictedTips
