"""The virtual test rig: hammer tests of any robot, simulated in time, with effects hidden in them."""

from flexmodal.rig.arms import draw_arm as draw_arm
from flexmodal.rig.believed import ParameterError as ParameterError
from flexmodal.rig.effects import EFFECTS as EFFECTS
from flexmodal.rig.forms import BLIND as BLIND
from flexmodal.rig.forms import FIFTH as FIFTH
from flexmodal.rig.forms import FORMS as FORMS
from flexmodal.rig.forms import FOURTH as FOURTH
from flexmodal.rig.forms import FURTHER as FURTHER
from flexmodal.rig.forms import LATER as LATER
from flexmodal.rig.forms import LOOKED_AT as LOOKED_AT
from flexmodal.rig.forms import SEALED as SEALED
from flexmodal.rig.forms import THIRD as THIRD
from flexmodal.rig.forms import UNSEEN as UNSEEN
from flexmodal.rig.hidden.hide import Hide as Hide
from flexmodal.rig.hidden.hide import hide_places as hide_places
from flexmodal.rig.hidden.scenario import Scenario as Scenario
from flexmodal.rig.hidden.scenario import draw_scenario as draw_scenario
from flexmodal.rig.result import RigResult as RigResult
from flexmodal.rig.simulate import simulate as simulate
from flexmodal.rig.truth import HiddenEffect as HiddenEffect
from flexmodal.rig.truth import Truth as Truth
