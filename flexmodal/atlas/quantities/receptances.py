"""Receptances of an atlas."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.atlas.quantities.quantity import Quantity, Variable, asked_for
from flexmodal.errors import Fault, InvalidRequest, SingularResponse
from flexmodal.frf import PointDirection, frequency_axis
from flexmodal.frf.kernels.route import LONG, WAYS, has_numba
from flexmodal.model import Robot
from flexmodal.model.batch import DirectionPair, read_pairs, receptance_batch
from flexmodal.model.batch.recursion import recursion_of


@dataclass(frozen=True, eq=False)
class Receptances(Quantity):
    """Receptances of pairs of directions over a frequency axis; infinite where an undamped mode is driven."""

    robot: Robot
    pairs: tuple[tuple[PointDirection, PointDirection], ...]
    frequency: Float[np.ndarray, " line"]
    """[Hz]."""
    way: str
    """One of `flexmodal.frf.kernels.route.WAYS` but "auto", so that every chunk goes the same way."""
    single: bool = False
    """Kept in single precision: half the space, seven digits."""

    name = "receptance"
    postures_per_chunk = 1 << 20
    releases = True

    @classmethod
    def of(
        cls,
        robot: Robot,
        pairs: Sequence[str | PointDirection | DirectionPair],
        frequencies: Any,
        *,
        way: str = "auto",
        single: bool = False,
    ) -> Receptances:
        """Check what is asked for, and choose the way.

        Args:
            robot: the robot.
            pairs: (response, reference), or one direction for a drive point.
            frequencies: ascending [Hz].
            way: one of `WAYS`; "auto" is compiled code where numba is installed.
            single: keep single precision.

        Raises:
            InvalidPoint, InvalidFrequencies, InvalidRequest: bad arguments.
        """
        axis = frequency_axis(frequencies)
        read, rows, numbers = read_pairs(robot, pairs)
        if len(set(read)) < len(read):
            raise InvalidRequest(Fault("call", "pairs", "a pair twice", "each pair once"))
        if way not in WAYS:
            raise InvalidRequest(Fault("call", "way", repr(way), ", ".join(WAYS)))
        if way == "auto":
            way = "compiled" if has_numba() else "numpy"
            long = LONG["planar" if robot.is_planar else "spatial"]
            if has_numba() and robot.hysteresis is None and len(robot.joints) >= long:
                one = np.zeros((1, len(robot.commanded)))
                along = recursion_of(robot, one, rows, numbers, 2 * np.pi * axis, 0.0, None)
                way = way if along is None else "recursion"
        return cls(robot, read, axis, way, single)

    def coordinates(self) -> Mapping[str, Sequence[str] | Float[np.ndarray, " label"]]:
        """Frequencies, and pairs as `response/reference`."""
        return {"frequency": self.frequency, "pair": [f"{left}/{right}" for left, right in self.pairs]}

    @property
    def variables(self) -> tuple[Variable, ...]:
        """One complex array."""
        kind, meaning = "complex64" if self.single else "complex128", "displacement over force"
        return (
            Variable("receptance", ("frequency", "pair"), kind, "m/N, rad/N, m/(N m), rad/(N m)", meaning),
        )

    def compute(self, values: Float[np.ndarray, "posture commanded"]) -> dict[str, np.ndarray]:
        """Receptances; infinite where an undamped mode is driven at its natural frequency."""
        found = self._receptances(values, self.frequency)
        return {"receptance": found.astype(np.complex64) if self.single else found}

    def _receptances(self, values: np.ndarray, axis: np.ndarray) -> Complex[np.ndarray, "p l d"]:
        try:
            return receptance_batch(self.robot, values, self.pairs, axis, threads=1, way=self.way).value
        except SingularResponse:
            if len(values) == len(axis) == 1:
                return np.full((1, 1, len(self.pairs)), complex(np.inf, 0.0))
        if len(values) > 1:  # halve until those that are driven at a pole stand alone
            half = len(values) // 2
            return np.concatenate([self._receptances(part, axis) for part in (values[:half], values[half:])])
        half = len(axis) // 2
        return np.concatenate(
            [self._receptances(values, part) for part in (axis[:half], axis[half:])], axis=1
        )

    def facts(self) -> dict[str, Any]:
        """Pairs, frequencies as a digest of their bytes, way, precision."""
        return {
            "name": self.name,
            **asked_for(self.pairs, self.frequency),
            "way": self.way,
            "precision": "single" if self.single else "double",
        }
