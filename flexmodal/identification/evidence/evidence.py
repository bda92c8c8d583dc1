"""What data say of a model: the interface that FRFs, modes, and both together have in common."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Bool, Float, Int, Shaped

from flexmodal.errors import Fault, InvalidRequest
from flexmodal.identification.descent import Normal, descend
from flexmodal.identification.frf_fit import FINE, SETTLED
from flexmodal.identification.gap import Gap
from flexmodal.identification.uncertainty import Uncertainty
from flexmodal.structure.parameter import ParameterSpace

Advance = Callable[[int, float], None]
Key = tuple[str, str]
"""Kind, "posture" or "point", and name of what could be held out."""
PAIRINGS = 4
"""Fits at one model error at most, while pairs of modes still change."""


@runtime_checkable
class Misfit(Protocol):
    """Sum of squares of a model on some data at one model error, with its prior."""

    def cost(self, x: Float[np.ndarray, " parameter"]) -> float:
        """Robust sum of squares plus the prior's; infinite where there is no model."""
        ...

    def equations(self, x: Float[np.ndarray, " parameter"], *, apart: bool = False) -> Normal:
        """Cost, gradient and curvature; `apart`: with what each observation adds.

        Args:
            x: coordinates of the parameters, 0 at the card's values.
            apart: with what each observation adds.
        """
        ...

    def same_pairs(self, other: Misfit) -> bool:
        """Whether both take the same mode of the model for each measured one."""
        ...


@dataclass(frozen=True, eq=False)
class Fitted:
    """Where a fit ended."""

    x: Float[np.ndarray, " parameter"]
    misfit: Misfit
    """At the last model error."""
    cost: float
    converged: bool
    steps: int

    @cached_property
    def normal(self) -> Normal:
        """Normal equations there, with what each observation adds."""
        return self.misfit.equations(self.x, apart=True)


class Evidence(ABC):
    """Data and a model that is to agree with them."""

    most = 30
    """Steps at each model error at most."""

    @property
    @abstractmethod
    def space(self) -> ParameterSpace:
        """What is fitted."""

    @property
    @abstractmethod
    def what(self) -> str:
        """The data in words."""

    @property
    @abstractmethod
    def count(self) -> int:
        """How many real numbers were measured."""

    @abstractmethod
    def faults(self) -> list[Fault]:
        """Why no number should come out of these data."""

    @abstractmethod
    def floors(self, *, quick: bool = False, warm: bool = False) -> Sequence[float]:
        """Relative model errors, lowered one after the other; see `fit`.

        Args:
            quick: the first two alone, for a look.
            warm: the last alone, from a start that is near.
        """

    @abstractmethod
    def misfit(
        self, x: Float[np.ndarray, " parameter"], floor: float, *, near: bool = True, quick: bool = False
    ) -> Misfit:
        """The misfit at a model error, modes paired at x; `near`: x is close to the answer.

        Args:
            x: coordinates of the parameters, 0 at the card's values.
            floor: relative error that the model is granted.
            near: whether x is close to the answer, for the pairing of modes.
            quick: on few lines.
        """

    @abstractmethod
    def information(self) -> Float[np.ndarray, "parameter parameter"]:
        """Fisher information of data like these, at the card."""

    @abstractmethod
    def clusters(self) -> Int[np.ndarray, " observation"]:
        """Which observations share their errors."""

    @abstractmethod
    def uncertainty(self, fitted: Fitted) -> Uncertainty:
        """How sure the parameters are."""

    @abstractmethod
    def predicted(self, x: Float[np.ndarray, " parameter"]) -> Shaped[np.ndarray, "observation *entry"]:
        """What `gap` judges."""

    @abstractmethod
    def gap(self, predicted: Shaped[np.ndarray, "observation *entry"]) -> Gap:
        """Distance from the data, beside the noise."""

    @abstractmethod
    def over_noise(self, predicted: Shaped[np.ndarray, "observation *entry"]) -> float:
        """Distance from the data over that of the noise alone, where the data are more than noise."""

    def shared_misfit(self, predicted: Shaped[np.ndarray, "observation *entry"]) -> float | None:
        """Misfit that neighbouring lines share, in variances of the noise; None where there are no lines."""
        return None

    @abstractmethod
    def folds(self) -> Mapping[Key, Bool[np.ndarray, " observation"]]:
        """What could be held out, with its observations."""

    @abstractmethod
    def keeping(self, keep: Bool[np.ndarray, " observation"]) -> Evidence:
        """The same with some of the observations."""

    def fit(
        self,
        start: Float[np.ndarray, " parameter"] | None = None,
        *,
        quick: bool = False,
        warm: bool = False,
        hold: Mapping[str, float] | None = None,
        settled: float = FINE,
        advance: Advance = lambda step, cost: None,
    ) -> Fitted:
        """Fit; pairs of modes are looked for anew whenever a round has ended.

        Args:
            start: coordinates; the card by default.
            quick: a first look.
            warm: `start` is near.
            hold: coordinates that stay where they are put, by name.
            settled: a step that changes the cost relatively by less is the last.
            advance: called after each step with its number and the cost.
        """
        x = np.zeros(len(self.space)) if start is None else np.array(start, dtype=float)
        floors, steps, near = self.floors(quick=quick, warm=warm), 0, warm
        for number, floor in enumerate(floors):
            last = number == len(floors) - 1
            misfit = self.misfit(x, floor, near=near, quick=quick)
            for _ in range(PAIRINGS):
                found = descend(
                    self.space,
                    misfit.equations,
                    misfit.cost,
                    x,
                    most=self.most,
                    settled=settled if last else SETTLED,
                    hold=hold,
                    advance=lambda step, cost, before=steps: advance(before + step, cost),  # type: ignore[misc]
                )
                x, steps, before = found.x, steps + found.steps, misfit
                misfit = self.misfit(x, floor, quick=quick)
                if misfit.same_pairs(before):
                    break
            near = True
        return Fitted(x, before, found.cost, found.converged, steps)


def few(source: str, count: int, parameters: int, what: str) -> list[Fault]:
    """What there is to say of fewer numbers than parameters.

    Args:
        source: file or folder at fault.
        count: how many numbers there are.
        parameters: how many of those.
        what: the numbers are, in words.
    """
    if count >= parameters:
        return []
    found = f"{count} {what} for {parameters} parameters"
    allowed = "at least as many: more postures or points, or fewer kinds of parameters"
    return [Fault(source, "", found, allowed)]


def refuse(faults: list[Fault]) -> None:
    """Raise what is wrong.

    Raises:
        InvalidRequest: anything is.
    """
    if faults:
        raise InvalidRequest(faults)
