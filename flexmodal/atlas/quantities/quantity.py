"""What every quantity of an atlas can be asked."""

from __future__ import annotations

import hashlib
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float

from flexmodal.model import PosedRobot, Robot
from flexmodal.model.receptance_source import Pair


@dataclass(frozen=True)
class Variable:
    """One array of an atlas, without the dimensions of the postures."""

    name: str
    dims: tuple[str, ...]
    dtype: str
    unit: str
    meaning: str


class Quantity(ABC):
    """Something that every posture of a robot has."""

    robot: Robot
    name: str
    postures_per_chunk: int
    """Most postures of a chunk: some seconds of work, so that little is lost to an interruption."""
    releases: bool
    """Whether threads of one process can work side by side."""

    @abstractmethod
    def coordinates(self) -> Mapping[str, Sequence[str] | Float[np.ndarray, " label"]]:
        """Labels along the quantity's own dimensions."""

    @property
    @abstractmethod
    def variables(self) -> tuple[Variable, ...]:
        """The arrays it fills."""

    @abstractmethod
    def compute(self, values: Float[np.ndarray, "posture commanded"]) -> dict[str, np.ndarray]:
        """The arrays at some postures, posture first."""

    @abstractmethod
    def facts(self) -> dict[str, Any]:
        """What tells it from others, for JSON."""


def asked_for(pairs: Sequence[Pair], frequency: Float[np.ndarray, " line"]) -> dict[str, Any]:
    """Pairs, and frequencies as a digest of their bytes, of the facts of receptances.

    Args:
        pairs: responses and forces.
        frequency: [Hz].
    """
    return {
        "pairs": [[str(left), str(right)] for left, right in pairs],
        "frequencies": [len(frequency), float(frequency[0]), float(frequency[-1])],
        "frequencies_digest": hashlib.sha256(frequency.tobytes()).hexdigest()[:16],
    }


def posed_at(robot: Robot, values: np.ndarray) -> Iterator[PosedRobot]:
    """The robot in one posture after another.

    Args:
        robot: the robot.
        values: of the commanded joints, posture × joint [rad, m].
    """
    names = list(robot.commanded)
    for vector in values:
        yield robot.at(dict(zip(names, map(float, vector), strict=True)))
