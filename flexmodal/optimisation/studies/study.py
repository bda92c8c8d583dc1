"""What a study asks, and what is printed of it."""

from __future__ import annotations

from dataclasses import dataclass

from flexmodal.frf import PointDirection
from flexmodal.model import Robot
from flexmodal.optimisation.hold import Hold
from flexmodal.optimisation.objectives import Objective, ReceptanceObjective, StiffnessObjective
from flexmodal.optimisation.problem import PostureProblem

KINDS = ("posture", "sweep", "frequency")


@dataclass(frozen=True)
class Study:
    """One study of a `studies.toml`; which fields count depends on its kind.

    "posture": the best posture, tool held or free. "sweep": |receptance| along a family of postures.
    "frequency": the operating frequency at a posture.
    """

    name: str
    robot: str
    title: str
    kind: str
    says: str
    """Where ours differs from what is printed, and why."""
    direction: str = "tool:+z"
    objective: str = "receptance"
    """"receptance" or "stiffness"."""
    frequency: float = 0.0
    """[Hz]."""
    hold: tuple[float, ...] = ()
    """Where the tool is held [m]; free if empty."""
    start: str = ""
    """Posture that the printed search started from."""
    printed: str = ""
    """Posture that it ended in."""
    printed_start: float | None = None
    printed_final: float | None = None
    """Values printed for both [m/N, N/m]."""
    family: str = ""
    printed_ends: tuple[float, ...] = ()
    """Of a sweep the values printed at its ends [m/N], of a frequency study the ends of its descents [Hz]."""
    printed_best: float | None = None
    """Parameter of the best member of the family [rad]."""
    posture: str = ""
    band: tuple[float, ...] = ()
    """[Hz]."""
    starts: tuple[float, ...] = ()
    """Frequencies that descents started from [Hz]."""

    def problem(self, robot: Robot) -> PostureProblem:
        """The posture problem, of a sweep or a posture study."""
        import numpy as np

        along = PointDirection.parse(self.direction)
        judge: Objective = StiffnessObjective(along)
        if self.objective == "receptance":
            judge = ReceptanceObjective((along,), np.array([self.frequency]))
        return PostureProblem(robot, judge, Hold.at(robot, self.hold) if self.hold else None)
