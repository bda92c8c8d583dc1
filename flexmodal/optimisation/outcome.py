"""What a search found, and how far it can be trusted."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from flexmodal.model import Posture
from flexmodal.optimisation.objectives import Limit
from flexmodal.optimisation.problem import PostureProblem
from flexmodal.text.extras import extra
from flexmodal.text.shown import Shown


@dataclass(frozen=True)
class Optimum:
    """One distinct local optimum."""

    posture: Posture
    objective: float
    hits: int
    """How many starts ended here, or in one of `equals`."""
    equals: tuple[Posture, ...] = ()
    """Other postures of the same value: an idle joint turned, or a wrist turned over."""


@dataclass(frozen=True)
class Start:
    """The posture a search was asked to compare with, as it was given and brought onto the hold."""

    given: Posture
    objective: float
    """At the posture as given; infinite at an undamped resonance."""
    away: float
    """Distance of the held point from its target there [m]; 0 without a hold."""
    held: Posture | None
    """The posture that holds the target and is nearest to it; itself where it holds, None where none was
    found."""
    held_objective: float | None
    """There: what an optimum is to be compared with."""

    @property
    def is_held(self) -> bool:
        """Whether the posture as given holds the target, so that there is one thing to compare with."""
        return self.held is self.given


@dataclass(frozen=True, eq=False, repr=False)
class Outcome(Shown):
    """Result of a posture search."""

    problem: PostureProblem
    optima: tuple[Optimum, ...]
    """Distinct optima, best first."""
    compared: Start | None
    """The posture the user started from."""
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
    seed: int | None = None
    """Of the random starts; None of a search that had none."""

    _PICTURE: ClassVar[str] = "flexmodal.optimisation.pictures.plot:draw_outcome"

    def _facts(self) -> Mapping[str, object]:
        unit = self.problem.objective.unit
        return {
            "": f"{self.problem.robot.name}: {self.best.objective:.4g} {unit}",
            "at": self.best.posture,
            "start": "none" if self.start is None else f"{self.start:.4g} {unit}",
            "optima": len(self.optima),
            "verdict": self.verdict,
        }

    def to_pandas(self) -> Any:
        """A table of the optima: objective, hits, and a column for each joint [rad, m].

        Raises:
            MissingExtra: pandas is not installed.
        """
        pandas = extra("pandas", "pandas", "to_pandas")
        rows = [
            {"objective": one.objective, "hits": one.hits, "equals": len(one.equals), **one.posture.values}
            for one in self.optima
        ]
        index = pandas.RangeIndex(1, len(rows) + 1, name="optimum")
        return pandas.DataFrame(rows, index=index)

    @property
    def start(self) -> float | None:
        """Objective at the start brought onto the hold, or as given where there is nothing to hold.

        Infinite at an undamped resonance; None without a start, or where none was found that holds.
        """
        if self.compared is None:
            return None
        return self.compared.held_objective

    @property
    def best(self) -> Optimum:
        """The best optimum found."""
        return self.optima[0]

    @property
    def nearest(self) -> tuple[float, tuple[str, str]] | None:
        """What is nearest to each other in the best posture, and how near [m]; None where unchecked."""
        clearance = self.problem.clearance
        if clearance is None:
            return None
        return clearance.scene.nearest(self.problem.robot.at(self.best.posture))

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
            return f"the best of {self.starts} starts, found once only: more starts may find a better" + aside
        return f"converged; {best.hits} of {self.starts} starts ended here" + aside

    def _is_zero(self, optimum: Optimum) -> bool:
        """Whether nothing is left to gain; such postures form families, each start may end in its own."""
        judge = self.problem.objective
        cost = float(np.log(max(optimum.objective, np.finfo(float).tiny)))
        cost = -cost if judge.larger_is_better else cost
        return judge.limit(cost, self.problem.robot) is Limit.PERFECT
