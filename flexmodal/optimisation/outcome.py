"""What a search found, and how far it can be trusted."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmodal.model import Posture
from flexmodal.optimisation.objectives import Limit
from flexmodal.optimisation.problem import PostureProblem


@dataclass(frozen=True)
class Optimum:
    """One distinct local optimum."""

    posture: Posture
    objective: float
    hits: int
    """How many starts ended here."""


@dataclass(frozen=True, eq=False)
class Outcome:
    """Result of a posture search."""

    problem: PostureProblem
    optima: tuple[Optimum, ...]
    """Distinct optima, best first."""
    start: float | None
    """Objective at the posture the user started from; infinite at an undamped resonance."""
    converged: bool
    """Whether the best one met the tolerance."""
    starts: int
    """Starts that reached the target."""
    unbounded: int
    """Starts that ran into singular postures, where the measure grows without bound; not among `optima`."""
    method: str
    tried: int = 0
    """Starts in all, those included that did not reach the target."""
    interrupted: bool = False
    """Whether Ctrl-C ended the search; the optima are those found until then."""

    @property
    def best(self) -> Optimum:
        """The best optimum found."""
        return self.optima[0]

    @property
    def tool(self) -> tuple[float, float, float]:
        """Where the end-effector is in the best posture [m]."""
        robot = self.problem.robot
        x, y, z = robot.at(self.best.posture).position(robot.tool)
        return float(x), float(y), float(z)

    @property
    def verdict(self) -> str:
        """What to think of it, and what to do next."""
        if self.interrupted:
            return f"interrupted after {self.tried} starts; the best so far is kept"
        if self.unbounded == self.starts:
            return (
                "not converged: every start ran into a singular posture, where the measure grows without "
                "bound; hold the end-effector elsewhere, or judge by receptance"
            )
        if not self.converged:
            return "not converged: allow more starts, or look at the limits near this posture"
        best = self.best
        aside = (
            f"; {self.unbounded} ran into singular postures, where the measure grows without bound, "
            "and are left out"
            if self.unbounded
            else ""
        )
        zeros = [optimum.hits for optimum in self.optima if self._is_zero(optimum)]
        if zeros:
            ended = f"{sum(zeros)} of {self.starts} starts ended in such a posture"
            return f"converged; nothing left to gain, the value is zero but for rounding; {ended}" + aside
        if self.method == "newton" and best.hits == 1 and self.starts > 1:
            return f"converged; only 1 of {self.starts} starts ended here, so try more starts" + aside
        return f"converged; {best.hits} of {self.starts} starts ended here" + aside

    def _is_zero(self, optimum: Optimum) -> bool:
        """Whether nothing is left to gain; such postures form families, each start may end in its own."""
        judge = self.problem.objective
        cost = float(np.log(max(optimum.objective, np.finfo(float).tiny)))
        cost = -cost if judge.larger_is_better else cost
        return judge.limit(cost, self.problem.robot) is Limit.PERFECT
