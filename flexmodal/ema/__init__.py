"""Measured FRFs to modes: peak picking, circle fit, least squares, stabilisation. Knows no robot."""

from flexmodal.ema.choices import Choices as Choices
from flexmodal.ema.estimate import estimate as estimate
from flexmodal.ema.estimate import modes_of as modes_of
from flexmodal.ema.fit import Fit as Fit
from flexmodal.ema.fit import as_json as as_json
from flexmodal.ema.measured import Measured as Measured
from flexmodal.ema.methods.circle import CircleFit as CircleFit
from flexmodal.ema.methods.circle import fit_circle as fit_circle
from flexmodal.ema.methods.least_squares import LeastSquaresProblem as LeastSquaresProblem
from flexmodal.ema.methods.least_squares import build_least_squares as build_least_squares
from flexmodal.ema.methods.least_squares import solve_least_squares as solve_least_squares
from flexmodal.ema.methods.peak import Peak as Peak
from flexmodal.ema.methods.picking import pick_peak as pick_peak
from flexmodal.ema.methods.select import choose_peaks as choose_peaks
from flexmodal.ema.methods.standing import mode_indicator as mode_indicator
from flexmodal.ema.methods.stabilisation import Stabilisation as Stabilisation
from flexmodal.ema.methods.stabilisation import Tolerances as Tolerances
from flexmodal.ema.methods.stabilisation import stabilise as stabilise
from flexmodal.ema.mode import EstimatedModes as EstimatedModes
from flexmodal.ema.mode import ModeEstimate as ModeEstimate
from flexmodal.ema.of_campaign import fit as fit
from flexmodal.ema.of_campaign import mode_table as mode_table
from flexmodal.ema.of_campaign import records_of as records_of
from flexmodal.ema.window import without_window as without_window
