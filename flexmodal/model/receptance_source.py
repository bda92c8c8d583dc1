"""Where receptances of any posture come from: the robot as it is posed, or what knows more of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.errors import Fault, InvalidRequest
from flexmodal.frf import PointDirection, frequency_axis
from flexmodal.model.gradient import receptance_and_gradient
from flexmodal.model.posed import PosedRobot

Pair = tuple[PointDirection, PointDirection]
"""A response and a force."""
STEP = 1e-4
"""Of central differences along the joints [rad, m]: the error of a receptance's slope is some 10⁻⁸ of it."""


@dataclass(frozen=True, eq=False)
class Band:
    """How far receptances of one posture may be off."""

    log_size: Float[np.ndarray, "line pair"]
    """Half width of the 95 % band of ln|α|."""
    remote: float = 1.0
    """Distance to the nearest posture that was struck over the typical one between these, 1 or more."""
    beyond: tuple[str, ...] = ()
    """Joints outside the range that was struck."""


@runtime_checkable
class ReceptanceSource(Protocol):
    """Gives receptances at any posture, with their band where it knows one."""

    def receptances(
        self, posed: PosedRobot, pairs: Sequence[Pair], frequency: Float[np.ndarray, " line"]
    ) -> Complex[np.ndarray, "line pair"]:
        """Displacement over force [m/N].

        Args:
            posed: the robot in the posture.
            pairs: responses and forces.
            frequency: [Hz].
        """
        ...

    def band(
        self, posed: PosedRobot, pairs: Sequence[Pair], frequency: Float[np.ndarray, " line"]
    ) -> Band | None:
        """How far these may be off; None where the source does not know.

        Args:
            posed: the robot in the posture.
            pairs: responses and forces.
            frequency: [Hz].
        """
        ...

    def matrix_and_gradient(
        self, posed: PosedRobot, directions: Sequence[PointDirection], frequency: Float[np.ndarray, " line"]
    ) -> tuple[Complex[np.ndarray, "line dir dir"], Complex[np.ndarray, "line dir dir moving"]]:
        """Receptances among some directions, and their derivatives along every moving joint.

        Args:
            posed: the robot in the posture.
            directions: rows and columns of the matrix.
            frequency: [Hz].
        """
        ...

    @property
    def verdict(self) -> str:
        """What the receptances are worth, in words; empty for a model by itself."""
        ...

    @property
    def lines(self) -> Float[np.ndarray, " line"] | None:
        """Frequencies between whose ends it knows receptances [Hz]; None where it does at any."""
        ...

    def facts(self) -> Mapping[str, Any]:
        """What tells this source from another, for JSON; nothing for a model by itself."""
        ...


@dataclass(frozen=True)
class ModelReceptances:
    """Those of the posed robot itself; see `ReceptanceSource`."""

    verdict: str = ""
    lines: None = None

    def receptances(
        self, posed: PosedRobot, pairs: Sequence[Pair], frequency: Float[np.ndarray, " line"]
    ) -> Complex[np.ndarray, "line pair"]:
        """See `ReceptanceSource`.

        Raises:
            SingularResponse: an undamped mode is driven at its natural frequency.
        """
        responses, references = (list(dict.fromkeys(pair[side] for pair in pairs)) for side in (0, 1))
        found = posed.frf(frequency, response=responses, reference=references).value
        rows = [responses.index(pair[0]) for pair in pairs]
        return found[:, rows, [references.index(pair[1]) for pair in pairs]]

    def band(
        self, posed: PosedRobot, pairs: Sequence[Pair], frequency: Float[np.ndarray, " line"]
    ) -> Band | None:
        """None: a card says nothing of its own errors."""
        return None

    def matrix_and_gradient(
        self, posed: PosedRobot, directions: Sequence[PointDirection], frequency: Float[np.ndarray, " line"]
    ) -> tuple[Complex[np.ndarray, "line dir dir"], Complex[np.ndarray, "line dir dir moving"]]:
        """See `ReceptanceSource`; exact.

        Raises:
            SingularResponse: an undamped mode is driven at its natural frequency.
        """
        return receptance_and_gradient(posed, directions, frequency)

    def facts(self) -> Mapping[str, Any]:
        """Nothing but the robot."""
        return {}


MODEL = ModelReceptances()
"""The robot by itself."""


def by_differences(
    source: ReceptanceSource,
    posed: PosedRobot,
    directions: Sequence[PointDirection],
    frequency: Float[np.ndarray, " line"],
) -> tuple[Complex[np.ndarray, "line dir dir"], Complex[np.ndarray, "line dir dir moving"]]:
    """`ReceptanceSource.matrix_and_gradient` by central differences; at a joint's limit, to the inside.

    Args:
        source: asked for the matrices.
        posed: the robot in the posture.
        directions: rows and columns of the matrix.
        frequency: [Hz].
    """
    pairs = [(row, column) for row in directions for column in directions]
    count = len(directions)

    def matrix(at: PosedRobot) -> Complex[np.ndarray, "line dir dir"]:
        return source.receptances(at, pairs, frequency).reshape(len(frequency), count, count)

    here, order = matrix(posed), list(posed.robot.moving)
    slopes = np.zeros((*here.shape, len(order)), dtype=complex)
    values = posed.posture.values
    for name, joint in posed.robot.commanded.items():
        ends = (max(values[name] - STEP, joint.lower), min(values[name] + STEP, joint.upper))
        if ends[1] > ends[0]:
            low, high = (PosedRobot(posed.robot, posed.robot.posture({**values, name: end})) for end in ends)
            slopes[..., order.index(name)] = (matrix(high) - matrix(low)) / (ends[1] - ends[0])
    return here, slopes


def check_within(
    frequency: Float[np.ndarray, " wanted"], lines: Float[np.ndarray, " line"]
) -> Float[np.ndarray, " wanted"]:
    """A frequency axis inside the lines that were measured.

    Args:
        frequency: asked for [Hz].
        lines: measured [Hz].

    Raises:
        InvalidFrequencies, InvalidRequest: no axis, or beyond the lines.
    """
    axis = frequency_axis(frequency)
    if axis[0] < lines[0] or axis[-1] > lines[-1]:
        found = f"{axis[0]:g} Hz" if len(axis) == 1 else f"{axis[0]:g} to {axis[-1]:g} Hz"
        allowed = f"{lines[0]:g} to {lines[-1]:g} Hz, the band that was measured"
        raise InvalidRequest(Fault("call", "frequency", found, allowed))
    return axis
