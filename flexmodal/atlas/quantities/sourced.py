"""Receptances of an atlas from a source that knows how far they may be off."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float

from flexmodal.atlas.quantities.quantity import Quantity, Variable, asked_for, posed_at
from flexmodal.errors import Fault, InvalidRequest
from flexmodal.frf import PointDirection
from flexmodal.model import Robot
from flexmodal.model.receptance_source import Pair, ReceptanceSource, check_within


@dataclass(frozen=True, eq=False)
class SourcedReceptances(Quantity):
    """Receptances of pairs of directions, the band of each, and how far the posture is from those struck."""

    robot: Robot
    pairs: tuple[Pair, ...]
    frequency: Float[np.ndarray, " line"]
    """[Hz]."""
    source: ReceptanceSource

    name = "receptance"
    postures_per_chunk = 256
    releases = False

    @classmethod
    def of(
        cls,
        robot: Robot,
        pairs: Sequence[str | PointDirection | tuple[str | PointDirection, str | PointDirection]],
        frequencies: Any,
        source: ReceptanceSource,
    ) -> SourcedReceptances:
        """Check what is asked for.

        Args:
            robot: the robot.
            pairs: (response, reference), or one direction for a drive point.
            frequencies: ascending [Hz], within what the source knows.
            source: such as a prediction.

        Raises:
            InvalidPoint, InvalidFrequencies, InvalidRequest: bad arguments, or what the source does not know.
        """
        read = tuple(
            (PointDirection.parse(one), PointDirection.parse(one))
            if isinstance(one, str | PointDirection)
            else (PointDirection.parse(one[0]), PointDirection.parse(one[1]))
            for one in pairs
        )
        if not read or len({*read}) < len(read):
            found = "none" if not read else "a pair twice"
            raise InvalidRequest(Fault("call", "pairs", found, "one or several, each once"))
        lines = source.lines
        axis = np.atleast_1d(np.asarray(frequencies, dtype=float))
        checked = check_within(axis, axis if lines is None else lines)
        middle = {
            name: (max(joint.lower, -np.pi) + min(joint.upper, np.pi)) / 2
            for name, joint in robot.commanded.items()
        }
        if source.band(robot.at(middle), read, checked) is None:
            allowed = "Receptances, of the robot itself"
            raise InvalidRequest(Fault("call", "source", "one without a band", allowed))
        return cls(robot, read, checked, source)

    def coordinates(self) -> Mapping[str, Sequence[str] | Float[np.ndarray, " label"]]:
        """Frequencies, and pairs as `response/reference`."""
        return {"frequency": self.frequency, "pair": [f"{left}/{right}" for left, right in self.pairs]}

    @property
    def variables(self) -> tuple[Variable, ...]:
        """The receptances, half the width of their band, and where the posture stands."""
        lines = ("frequency", "pair")
        return (
            Variable("receptance", lines, "complex128", "m/N", "displacement over force"),
            Variable("log_size", lines, "float64", "1", "half width of the 95 % band of ln abs(receptance)"),
            Variable("remote", (), "float64", "1", "distance from what was struck over that between these"),
            Variable("beyond", (), "float64", "1", "how many joints are outside the range that was struck"),
        )

    def compute(self, values: Float[np.ndarray, "posture commanded"]) -> dict[str, np.ndarray]:
        """Those of each posture by itself."""
        shape = (len(values), len(self.frequency), len(self.pairs))
        receptance, width = np.empty(shape, dtype=complex), np.empty(shape)
        remote, beyond = np.empty(len(values)), np.empty(len(values))
        for place, posed in enumerate(posed_at(self.robot, values)):
            receptance[place] = self.source.receptances(posed, self.pairs, self.frequency)
            band = self.source.band(posed, self.pairs, self.frequency)
            assert band is not None
            width[place], remote[place], beyond[place] = band.log_size, band.remote, len(band.beyond)
        return {"receptance": receptance, "log_size": width, "remote": remote, "beyond": beyond}

    def facts(self) -> dict[str, Any]:
        """Pairs, frequencies as a digest of their bytes, and the source."""
        return {
            "name": self.name,
            **asked_for(self.pairs, self.frequency),
            "source": dict(self.source.facts()),
        }
