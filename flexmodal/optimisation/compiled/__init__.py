"""The posture search from hundreds of starts at once, compiled where numba is installed."""

from flexmodal.optimisation.compiled.search import Basins as Basins
from flexmodal.optimisation.compiled.search import Ends as Ends
from flexmodal.optimisation.compiled.search import random_starts as random_starts
from flexmodal.optimisation.compiled.search import search_postures as search_postures
