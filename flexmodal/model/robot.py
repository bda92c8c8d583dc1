"""A robot: its chain from the URDF, its flexibility from the card."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flexmodal.frf import Frf, PointDirection
from flexmodal.modal import Modes
from flexmodal.model.chain import FlexibleChain
from flexmodal.model.measures import Measures, measure
from flexmodal.model.posed import Directions, PosedRobot
from flexmodal.model.posture import Pose


@dataclass(frozen=True, eq=False, repr=False)
class Robot(FlexibleChain):
    """A loaded robot; `at` puts it in a posture, all else follows from there.

    Get one with `flexmodal.load`.
    """

    def at(self, pose: Pose) -> PosedRobot:
        """Put the robot in a posture: its name, values by joint, or an array in Pinocchio's order.

        Raises:
            InvalidPosture: see `posture`.
            InvalidUrdf: the mass matrix there is not positive definite; names the link at fault.

        >>> import flexmodal
        >>> robot = flexmodal.load("six_link")
        >>> by_name = robot.at({"q1": 1.0, "q2": 0.5})
        >>> by_order = robot.at([1.0, 0.5, 0, 0, 0, 0])
        >>> bool((by_name.position("tool") == by_order.position("tool")).all())
        True
        """
        posed = PosedRobot(self, self.posture(pose))
        _ = posed.system  # judges the mass matrix
        return posed

    def frf(
        self,
        posture: Pose,
        frequencies: Sequence[float] | np.ndarray,
        *,
        response: Directions = None,
        reference: Directions = None,
        form: str = "receptance",
    ) -> Frf:
        """FRFs at a posture; see `PosedRobot.frf`.

        Args:
            posture: see `at`.
            frequencies: ascending [Hz].
            response: directions of the motion.
            reference: directions of the forces.
            form: receptance, mobility or inertance.

        Raises:
            InvalidPosture: see `at`.
            InvalidPoint, InvalidFrequencies, InvalidRequest, SingularResponse: see `PosedRobot.frf`.
        """
        return self.at(posture).frf(frequencies, response=response, reference=reference, form=form)

    def modes(self, posture: Pose) -> Modes:
        """Modes at a posture; see `PosedRobot.modes`."""
        return self.at(posture).modes()

    def measures(
        self,
        posture: Pose,
        *,
        direction: str | PointDirection | None = None,
        frequency: float | None = None,
        task: str = "full",
    ) -> Measures:
        """Stiffness, mobility and receptance at a posture; see `flexmodal.model.measures.measure`.

        Args:
            posture: see `at`.
            direction: such as "tool:+z".
            frequency: of the dynamic receptance [Hz].
            task: "full" or "position".

        Raises:
            InvalidPosture: see `at`.
            InvalidPoint, InvalidRequest, InvalidFrequencies, SingularResponse: see `measure`.
        """
        return measure(self.at(posture), direction, frequency, task=task)
