"""From where to descend, how, and what the ends are."""

from flexmodal.optimisation.search.descents import WAYS as WAYS
from flexmodal.optimisation.search.descents import Watch as Watch
from flexmodal.optimisation.search.descents import choose_way as choose_way
from flexmodal.optimisation.search.descents import descend as descend
from flexmodal.optimisation.search.descents import descend_from as descend_from
from flexmodal.optimisation.search.descents import is_compilable as is_compilable
from flexmodal.optimisation.search.descents import random_starts as random_starts
from flexmodal.optimisation.search.descents import search_postures as search_postures
from flexmodal.optimisation.search.ends import Basins as Basins
from flexmodal.optimisation.search.ends import Descent as Descent
from flexmodal.optimisation.search.ends import Ends as Ends
from flexmodal.optimisation.search.ends import tell_apart as tell_apart
from flexmodal.optimisation.search.equals import merged as merged
from flexmodal.optimisation.search.equals import nearest_held as nearest_held
from flexmodal.optimisation.search.equals import within_a_turn as within_a_turn
from flexmodal.optimisation.search.family import search_family as search_family
from flexmodal.optimisation.search.null_space import null_space_descent as null_space_descent
from flexmodal.optimisation.search.starts import BLOCK as BLOCK
from flexmodal.optimisation.search.starts import DEFAULT_STARTS as DEFAULT_STARTS
from flexmodal.optimisation.search.starts import Advance as Advance
from flexmodal.optimisation.search.starts import Improved as Improved
from flexmodal.optimisation.search.starts import beside as beside
from flexmodal.optimisation.search.starts import search as search
from flexmodal.optimisation.search.unreachable import unreachable as unreachable
