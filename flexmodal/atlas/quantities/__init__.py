"""What an atlas holds of each posture: receptances, modes, stiffness or depth of cut."""

from flexmodal.atlas.quantities.depth import DepthOfCut as DepthOfCut
from flexmodal.atlas.quantities.modes import NaturalModes as NaturalModes
from flexmodal.atlas.quantities.quantity import Quantity as Quantity
from flexmodal.atlas.quantities.quantity import Variable as Variable
from flexmodal.atlas.quantities.receptances import Receptances as Receptances
from flexmodal.atlas.quantities.sourced import SourcedReceptances as SourcedReceptances
from flexmodal.atlas.quantities.stiffness import Stiffnesses as Stiffnesses
