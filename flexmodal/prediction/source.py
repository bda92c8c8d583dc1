"""A prediction as a source of receptances at any posture, for searches and atlases.

It gives at every posture what `solve_prediction` gives there, by the same fit and the same surface, only
at the frequencies and places asked for.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.campaign import CampaignPoint, named_direction
from flexmodal.errors import Fault, InvalidPoint, InvalidRequest
from flexmodal.frf import PointDirection
from flexmodal.frf.direction import AXES
from flexmodal.identification.spot import places_of
from flexmodal.model import PosedRobot
from flexmodal.model.placements import link_placements
from flexmodal.model.receptance_source import Band, Pair, by_differences, check_within
from flexmodal.prediction.alignment import natural_frequencies, resampled
from flexmodal.prediction.band import band, remoteness
from flexmodal.prediction.frf_prediction import worth
from flexmodal.prediction.methods import DATA_ALONE, METHODS
from flexmodal.prediction.predict import PredictionProblem, beyond
from flexmodal.structure.structure import receptance

AT = 1e-3
"""Distance within which a point of the robot is one that was struck or measured [m]."""


@dataclass(frozen=True, eq=False)
class PredictedReceptances:
    """Receptances by one method of `METHODS`; see `ReceptanceSource`.

    Directions are those of the campaign: the axes of its points, which may turn with a link. A point of the
    robot at the place of one of these, such as the tool, stands for it.
    """

    problem: PredictionProblem
    method: str = ""
    """The one that predicts best what was left out, if empty."""

    def __post_init__(self) -> None:
        """Check the method.

        Raises:
            InvalidRequest: none of `METHODS`; or the mean, which is the same in every posture.
        """
        method = self.method or self.problem.left_out.chosen
        if method not in METHODS:
            raise InvalidRequest(Fault("call", "method", repr(method), f"one of {', '.join(METHODS)}"))
        if method == "mean":
            found = "the mean of the struck postures, which predicts best" if not self.method else "mean"
            allowed = (
                "a method that knows postures: these data and this card tell no posture from another, so "
                "that none can be chosen by them; look at flexmodal predict and flexmodal check"
            )
            raise InvalidRequest(Fault("prediction", "method", found, allowed))
        object.__setattr__(self, "method", method)

    @property
    def is_data_alone(self) -> bool:
        """Whether physics has no part in it."""
        return self.method in DATA_ALONE

    @property
    def verdict(self) -> str:
        """What the method is worth on postures it had not seen."""
        return "; ".join(worth(self.problem.left_out, self.method))

    @property
    def lines(self) -> Float[np.ndarray, " line"]:
        """Those that were measured [Hz]."""
        return self.problem.left_out.panel.axis

    def receptances(
        self, posed: PosedRobot, pairs: Sequence[Pair], frequency: Float[np.ndarray, " line"]
    ) -> Complex[np.ndarray, "line pair"]:
        """See `ReceptanceSource`.

        Args:
            posed: the robot in the posture.
            pairs: responses and forces.
            frequency: within the band that was measured [Hz].

        Raises:
            InvalidPoint: a pair that was not struck and measured, nor its mirror.
            InvalidFrequencies, InvalidRequest: frequencies outside the band that was measured.
        """
        axis, q = check_within(frequency, self.lines), dict(posed.posture.values)
        rows, sign = self._places(posed, pairs)
        known = self.problem.known
        if self.method == "nearest":
            return (sign * self._between(known.nearest(q)[rows], axis)).T
        if self.method == "process":
            return (sign * known.by_process(q, rows, axis)).T
        if self.method == "physics":
            return (sign * self._physics(q, rows, axis)).T
        left, every = self.problem.left_out, np.arange(len(self.problem.left_out.panel.pairs))
        physics, resonances = self._physics(q, every, axis), self._resonances(q)
        value = known.by_hybrid(q, physics, every, resonances, axis, left.share, left.mix)
        return (sign * value[rows]).T

    def band(self, posed: PosedRobot, pairs: Sequence[Pair], frequency: Float[np.ndarray, " line"]) -> Band:
        """See `ReceptanceSource`.

        Args:
            posed: the robot in the posture.
            pairs: responses and forces.
            frequency: within the band that was measured [Hz].

        Raises:
            InvalidPoint, InvalidFrequencies, InvalidRequest: as `receptances` does.
        """
        axis, q = check_within(frequency, self.lines), dict(posed.posture.values)
        rows, _ = self._places(posed, pairs)
        left = self.problem.left_out
        half = band(left, self.method, self._resonances(q))[0][rows]
        far = remoteness(left, q)
        wider = 1.0 if self.method == "physics" else far
        between = np.array([np.interp(axis, self.lines, wider * row) for row in half])
        return Band(between.T, far, beyond(self.problem, q))

    def matrix_and_gradient(
        self, posed: PosedRobot, directions: Sequence[PointDirection], frequency: Float[np.ndarray, " line"]
    ) -> tuple[Complex[np.ndarray, "line dir dir"], Complex[np.ndarray, "line dir dir moving"]]:
        """See `ReceptanceSource`; by central differences, raises as `receptances` does.

        Args:
            posed: the robot in the posture.
            directions: rows and columns of the matrix.
            frequency: [Hz].
        """
        return by_differences(self, posed, directions, frequency)

    def facts(self) -> Mapping[str, Any]:
        """The campaign, the method, and a digest of what was fitted and learnt."""
        left = self.problem.left_out
        parts = (self.problem.x, np.array([left.share, left.mix, left.beside]), left.panel.observations.value)
        digest = hashlib.sha256(b"".join(np.ascontiguousarray(one).tobytes() for one in parts))
        return {
            "campaign": self.problem.campaign.title,
            "method": self.method,
            "data_alone": self.is_data_alone,
            "verdict": self.verdict,
            "digest": digest.hexdigest()[:16],
        }

    def drive(
        self, posed: PosedRobot, point: str
    ) -> tuple[list[Pair], dict[str, tuple[float, float, float]]]:
        """Pairs of directions at one point that were struck and measured, and where they point in the world.

        Args:
            posed: the robot in the posture.
            point: of the campaign, or of the robot at the same place.

        Raises:
            InvalidPoint: no FRF between two directions there.
        """
        campaign, panel = self.problem.campaign, self.problem.left_out.panel
        names = {one.id: one.name for one in campaign.points}
        placed = link_placements(posed.robot, dict(posed.posture.values))
        own = {one.id for one in campaign.points if one.name == point}
        if not own and point in (posed.robot.tool, *posed.robot.points):
            place = posed.position(point)
            own = {one.id for one in campaign.points if _apart(one, placed, place) < AT}
        pairs: list[Pair] = []
        ways: dict[str, tuple[float, float, float]] = {}
        for row in panel.pairs.tolist():
            if row[0] not in own or row[2] != row[0]:
                continue
            pairs.append((named_direction(row[:2], names), named_direction(row[2:], names)))
            for number, direction in (row[:2], row[2:]):
                one = campaign.point(number)
                x, y, z = (float(part) for part in one.way(direction, placed[one.link][:3, :3]))
                ways[str(named_direction((number, direction), names))] = (x, y, z)
        if not pairs:
            there = dict.fromkeys(names[row[0]] for row in panel.pairs.tolist() if row[0] == row[2])
            allowed = f"a point struck and measured: {', '.join(there) or 'none'}"
            raise InvalidPoint(Fault("prediction", "point", point, allowed))
        return pairs, ways

    def _resonances(self, q: Mapping[str, float]) -> Float[np.ndarray, " mode"]:
        model = self.problem.evidence.model
        return natural_frequencies(model, self.problem.x, q)  # type: ignore[arg-type]

    def _between(self, value: np.ndarray, axis: np.ndarray) -> np.ndarray:
        return resampled(value, self.lines, axis)

    def _physics(
        self, q: Mapping[str, float], rows: np.ndarray, axis: np.ndarray
    ) -> Complex[np.ndarray, "pair line"]:
        """The fitted model's receptances at some places of the panel [m/N]."""
        panel, campaign = self.problem.left_out.panel, self.problem.campaign
        one = panel.pairs[rows]
        structure = self.problem.evidence.model.structure_at(  # type: ignore[attr-defined]
            self.problem.x,
            q,
            places_of(campaign, one[:, :2].tolist()),
            places_of(campaign, one[:, 2:].tolist()),
        )
        lines = panel.observations.axis
        every = np.repeat(np.arange(len(one))[:, None], 2, axis=1)
        return receptance(structure, type(lines)(axis, lines.middle), every)[0]

    def _places(self, posed: PosedRobot, pairs: Sequence[Pair]) -> tuple[np.ndarray, np.ndarray]:
        """Number of the place of each pair, and the sign with which its record is taken."""
        found = [self._place(posed, pair) for pair in pairs]
        return np.array([row for row, _ in found]), np.array([[sign] for _, sign in found])

    def _place(self, posed: PosedRobot, pair: Pair) -> tuple[int, int]:
        panel = self.problem.left_out.panel
        one, other = (self._at(posed, direction) for direction in pair)
        for first, second in ((one, other), (other, one)):  # or the mirror: a receptance is symmetric
            wanted = (first[0], abs(first[1]), second[0], abs(second[1]))
            for number, row in enumerate(panel.pairs.tolist()):
                if wanted == (row[0], abs(row[1]), row[2], abs(row[3])):
                    return number, int(np.sign(first[1] * second[1] * row[1] * row[3]))
        names = {point.id: point for point in self.problem.campaign.points}
        there = [
            f"{names[a].name}:{AXES[abs(b) - 1]} per {names[c].name}:{AXES[abs(d) - 1]}"
            for a, b, c, d in panel.pairs.tolist()
        ]
        raise InvalidPoint(
            Fault(
                "prediction",
                "direction",
                f"{pair[0]} per {pair[1]}",
                f"struck and measured: {', '.join(there)}",
            )
        )

    def _at(self, posed: PosedRobot, direction: PointDirection) -> tuple[int, int]:
        """Point id and direction ±1 ±2 ±3 of the campaign."""
        points = self.problem.campaign.points
        found = [point for point in points if point.name == direction.point]
        if not found and direction.point in (posed.robot.tool, *posed.robot.points):
            placed = link_placements(posed.robot, dict(posed.posture.values))
            own = posed.position(direction.point)
            found = [one for one in points if not one.own_axes and _apart(one, placed, own) < AT]
        if not found or direction.is_rotation:
            allowed = f"one of {', '.join(point.name for point in points)}, along x, y or z as measured there"
            raise InvalidPoint(Fault("prediction", "direction", str(direction), allowed))
        return found[0].id, direction.sign * (AXES.index(direction.axis) + 1)


def _apart(
    point: CampaignPoint, placed: Mapping[str, Float[np.ndarray, "4 4"]], place: Float[np.ndarray, "3"]
) -> float:
    """Distance of a point of the campaign from a place in the world [m]."""
    frame = placed[point.link]
    return float(np.linalg.norm(frame[:3, :3] @ np.array(point.xyz) + frame[:3, 3] - place))
