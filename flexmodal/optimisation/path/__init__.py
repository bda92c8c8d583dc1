"""A posture for each point of a toolpath: smooth, within limits and speeds, and vibrating least."""

from flexmodal.optimisation.path.plan import PathOutcome as PathOutcome
from flexmodal.optimisation.path.plan import greedy_path as greedy_path
from flexmodal.optimisation.path.plan import plan_path as plan_path
from flexmodal.optimisation.path.problem import PathPoint as PathPoint
from flexmodal.optimisation.path.problem import PathProblem as PathProblem
from flexmodal.optimisation.path.toolpath import Toolpath as Toolpath
from flexmodal.optimisation.path.toolpath import arc as arc
from flexmodal.optimisation.path.toolpath import line as line
from flexmodal.optimisation.path.toolpath import read_toolpath as read_toolpath
