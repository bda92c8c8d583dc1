"""The road from a campaign to parameters: what a route can do, and what both have in common."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Bool, Float, Shaped

from flexmodal.errors import Fault, InvalidRequest
from flexmodal.identification.descent import Normal
from flexmodal.identification.gap import Gap
from flexmodal.identification.uncertainty import Uncertainty
from flexmodal.structure.parameter import ParameterSpace

Advance = Callable[[int, float], None]


@dataclass(frozen=True, eq=False)
class Fitted:
    """Where a route's fit ended."""

    x: Float[np.ndarray, " parameter"]
    normal: Normal
    converged: bool
    steps: int


@runtime_checkable
class Route(Protocol):
    """Data and a model that is to agree with them."""

    @property
    def space(self) -> ParameterSpace:
        """What is fitted."""
        ...

    @property
    def count(self) -> int:
        """How many real numbers were measured."""
        ...

    def faults(self) -> list[Fault]:
        """Why no number should come out of these data."""
        ...

    def fit(
        self,
        start: Float[np.ndarray, " parameter"] | None = None,
        *,
        quick: bool = False,
        warm: bool = False,
        hold: Mapping[str, float] | None = None,
        advance: Advance = lambda step, cost: None,
    ) -> Fitted:
        """Fit; `quick` for a first look, `warm` where `start` is near, coordinates in `hold` as put."""
        ...

    def information(self) -> Float[np.ndarray, "parameter parameter"]:
        """Fisher information of data like these, at the card."""
        ...

    def uncertainty(self, fitted: Fitted) -> Uncertainty:
        """How sure the parameters are."""
        ...

    def predicted(self, x: Float[np.ndarray, " parameter"]) -> Shaped[np.ndarray, "observation entry"]:
        """What `gap` judges."""
        ...

    def gap(self, predicted: Shaped[np.ndarray, "observation entry"]) -> Gap:
        """Distance from the data, beside the noise."""
        ...

    def over_noise(self, predicted: Shaped[np.ndarray, "observation entry"]) -> float:
        """Distance from the data over that of the noise alone, where the data are more than noise."""
        ...

    def folds(self) -> Mapping[tuple[str, str], Bool[np.ndarray, " observation"]]:
        """What could be held out: kind ("posture" or "point") and name, with its observations."""
        ...

    def keeping(self, keep: Bool[np.ndarray, " observation"]) -> Route:
        """The same with some of the observations."""
        ...


def few(source: str, count: int, parameters: int, what: str) -> list[Fault]:
    """What there is to say of fewer numbers than parameters."""
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
