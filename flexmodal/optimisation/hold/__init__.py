"""What is held while the arm moves: a point, its orientation, or an axis of it."""

from flexmodal.optimisation.hold.hold import Hold as Hold
from flexmodal.optimisation.hold.orientation import FixedOrientation as FixedOrientation
