"""Parameters of a robot as a space: names, units, the card's values, bounds, and the trust put in them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Float

from flexmodal.errors import Fault, InvalidRequest


@dataclass(frozen=True)
class Parameter:
    """One number that an identification may change.

    Inside a fit it is a coordinate x, zero at the card: ln(value / card) where `log`, else value − card.
    """

    name: str
    """Kind and place, such as `stiffness.q1`, `mass.link_2`."""
    unit: str
    card: float
    """The value it starts from; above 0 where `log`."""
    deviation: float
    """Standard deviation of the normal prior on x around 0; infinite for none."""
    lower: float = -np.inf
    """Bounds of the value, in its unit."""
    upper: float = np.inf
    log: bool = True

    def value(self, x: float) -> float:
        """The value at a coordinate."""
        return float(self.card * np.exp(x)) if self.log else float(self.card + x)

    def coordinate(self, value: float) -> float:
        """The coordinate of a value; infinite for 0 on a logarithmic scale."""
        if not self.log:
            return value - self.card
        return float(np.log(value / self.card)) if value > 0 else -np.inf

    def slope(self, x: float) -> float:
        """Derivative of the value along x."""
        return self.value(x) if self.log else 1.0


@dataclass(frozen=True, eq=False)
class ParameterSpace:
    """Parameters in a fixed order.

    Raises:
        InvalidRequest: two of one name, values outside their bounds, or a logarithm of what is not
            positive; all at once.
    """

    parameters: tuple[Parameter, ...]

    def __post_init__(self) -> None:
        faults = [fault for parameter in self.parameters if (fault := _fault(parameter))]
        names = [parameter.name for parameter in self.parameters]
        faults += [
            Fault("parameters", name, "the name of two of them", "different names")
            for name in dict.fromkeys(names)
            if names.count(name) > 1
        ]
        if faults:
            raise InvalidRequest(faults)

    def __len__(self) -> int:
        """How many there are."""
        return len(self.parameters)

    def __iter__(self) -> Iterator[Parameter]:
        """In their order."""
        return iter(self.parameters)

    @cached_property
    def index(self) -> Mapping[str, int]:
        """Position by name."""
        return {parameter.name: k for k, parameter in enumerate(self.parameters)}

    @cached_property
    def names(self) -> tuple[str, ...]:
        """In their order."""
        return tuple(parameter.name for parameter in self.parameters)

    @cached_property
    def precision(self) -> Float[np.ndarray, " parameter"]:
        """Diagonal of the inverse prior covariance of x; 0 where there is no prior."""
        with np.errstate(divide="ignore"):
            return np.array([1 / p.deviation**2 if p.deviation > 0 else np.inf for p in self.parameters])

    @cached_property
    def bounds(self) -> tuple[Float[np.ndarray, " parameter"], Float[np.ndarray, " parameter"]]:
        """Lower and upper bounds of x."""
        low = np.array([p.coordinate(p.lower) for p in self.parameters])
        high = np.array([p.coordinate(p.upper) for p in self.parameters])
        return low, high

    def values(self, x: Float[np.ndarray, " parameter"]) -> dict[str, float]:
        """Values by name at coordinates x."""
        return {p.name: p.value(float(c)) for p, c in zip(self.parameters, x, strict=True)}

    def coordinates(self, values: Mapping[str, float]) -> Float[np.ndarray, " parameter"]:
        """Coordinates of values by name; those left out stand at the card.

        Raises:
            InvalidRequest: a name that is no parameter.
        """
        unknown = [name for name in values if name not in self.index]
        if unknown:
            allowed = ", ".join(self.names)
            raise InvalidRequest([Fault("call", "values", repr(name), allowed) for name in unknown])
        return np.array([p.coordinate(values[p.name]) if p.name in values else 0.0 for p in self.parameters])

    def and_also(self, more: Iterable[Parameter]) -> ParameterSpace:
        """These and others behind them."""
        return ParameterSpace((*self.parameters, *more))

    def only(self, names: Iterable[str]) -> ParameterSpace:
        """Those of these names, in the order of this space."""
        kept = set(names)
        return ParameterSpace(tuple(p for p in self.parameters if p.name in kept))

    def trusting(self, deviations: Mapping[str, float]) -> ParameterSpace:
        """With another prior for some names or kinds (`mass` for every `mass.…`); a name wins over a kind."""
        changed = []
        for p in self.parameters:
            given = deviations.get(p.name, deviations.get(p.name.split(".")[0]))
            changed.append(p if given is None else replace(p, deviation=given))
        return ParameterSpace(tuple(changed))


def _fault(parameter: Parameter) -> Fault | None:
    if not np.isfinite(parameter.card) or (parameter.log and parameter.card <= 0):
        allowed = "a finite number above 0" if parameter.log else "a finite number"
        return Fault("parameters", parameter.name, f"{parameter.card:g}", allowed)
    if not parameter.lower <= parameter.card <= parameter.upper:
        allowed = f"{parameter.lower:g} to {parameter.upper:g}"
        return Fault("parameters", parameter.name, f"{parameter.card:g}", allowed)
    if not parameter.deviation > 0:
        found = f"a standard deviation of {parameter.deviation:g}"
        return Fault("parameters", parameter.name, found, "one above 0; leave out what is known exactly")
    return None
