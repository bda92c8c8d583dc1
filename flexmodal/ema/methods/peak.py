"""A resonance to be fitted: found by rule, or put there by a person."""

from __future__ import annotations

from dataclasses import dataclass

from flexmodal.errors import Fault, InvalidRequest


@dataclass(frozen=True)
class Peak:
    """Where a mode is looked for, and what about it is held.

    Raises:
        InvalidRequest: a frequency that is not positive or lies outside its own band, or a damping ratio
            to hold that is not between 0 and 1.
    """

    frequency: float
    """[Hz]."""
    low: float
    """First frequency that belongs to this peak rather than to its neighbour [Hz]."""
    high: float
    """Last one [Hz]."""
    width: float
    """Half-power bandwidth as the lines show it [Hz]."""
    by_hand: bool = False
    holds_frequency: bool = False
    """Whether the fit leaves the frequency where it is."""
    damping: float | None = None
    """A damping ratio that the fit must take as it is, as the thesis did for some peaks."""

    def __post_init__(self) -> None:
        faults = []
        if not 0 <= self.low < self.frequency < self.high:
            found = f"{self.frequency:g} Hz in {self.low:g} to {self.high:g} Hz"
            faults.append(Fault("call", "peak", found, "0 ≤ low < frequency < high"))
        if not self.width > 0:
            faults.append(Fault("call", "peak width", f"{self.width:g} Hz", "above 0"))
        if self.damping is not None and not 0 < self.damping < 1:
            faults.append(Fault("call", "damping", f"{self.damping:g}", "between 0 and 1"))
        if faults:
            raise InvalidRequest(faults)

    @property
    def holds_damping(self) -> bool:
        """Whether the damping ratio is forced."""
        return self.damping is not None

    @property
    def start_damping(self) -> float:
        """The forced damping ratio, or the half-power guess width/2f, kept below 0.5."""
        if self.damping is not None:
            return self.damping
        return min(max(self.width / (2 * self.frequency), 1e-6), 0.5)
