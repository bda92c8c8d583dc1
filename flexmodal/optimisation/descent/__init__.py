"""The descent from a start, written once: interpreted for any problem, compiled for those made of arrays."""

from flexmodal.optimisation.descent.algebra import RANK as RANK
from flexmodal.optimisation.descent.descend import GRADIENT as GRADIENT
from flexmodal.optimisation.descent.descend import descend_all as descend_all
from flexmodal.optimisation.descent.retraction import TOLERANCE as TOLERANCE
from flexmodal.optimisation.descent.retraction import retract as retract
from flexmodal.optimisation.descent.work import PERFECT as PERFECT
from flexmodal.optimisation.descent.work import SETTLED as SETTLED
from flexmodal.optimisation.descent.work import UNBOUNDED as UNBOUNDED
from flexmodal.optimisation.descent.work import UNREACHED as UNREACHED
from flexmodal.optimisation.descent.work import UNSETTLED as UNSETTLED
from flexmodal.optimisation.descent.work import Box as Box
from flexmodal.optimisation.descent.work import Work as Work
from flexmodal.optimisation.descent.work import work_for as work_for
