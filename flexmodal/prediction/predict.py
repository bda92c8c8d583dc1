"""`predict_posture`: from a campaign, a card and a posture to FRFs with their band."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from threadpoolctl import threadpool_limits

from flexmodal.campaign import Campaign, named_direction
from flexmodal.errors import Fault, InvalidRequest
from flexmodal.identification import build_identification, predict
from flexmodal.identification.evidence.frf import FrfEvidence
from flexmodal.identification.stages import is_poor, staged
from flexmodal.model import Robot
from flexmodal.model.placements import link_placements
from flexmodal.prediction.alignment import natural_frequencies
from flexmodal.prediction.band import band, remoteness
from flexmodal.prediction.frf_prediction import FrfPrediction, PredictedFrf
from flexmodal.prediction.leave_one_out import LeftOut, known_by, leave_each_out
from flexmodal.prediction.methods import METHODS, Known, predicted_by_all
from flexmodal.prediction.panel import Panel, with_posture
from flexmodal.structure.parameter import ParameterSpace
from flexmodal.text.extras import extra

LEAST = 3
"""Postures with FRFs: with two, what is left out is told by one alone."""


@dataclass(frozen=True, eq=False)
class PredictionProblem:
    """A model fitted to a campaign, and how well every method predicts postures that were left out."""

    campaign: Campaign
    robot: Robot
    evidence: FrfEvidence
    x: np.ndarray
    """Coordinates of the fit to everything."""
    left_out: LeftOut
    sliding: tuple[str, ...]

    @cached_property
    def known(self) -> Known:
        """What every posture is predicted from."""
        left = self.left_out
        known = known_by(self.evidence, left.panel, self.x, left.postures, self.sliding)
        return replace(known, beside=left.beside)


def build_prediction(
    campaign: Campaign,
    robot: Robot,
    *,
    space: ParameterSpace | None = None,
    trust: Mapping[str, float] | None = None,
    advance: Callable[[], None] = lambda: None,
) -> PredictionProblem:
    """Fit the physics, and leave every posture out in turn.

    Args:
        campaign: FRFs of three postures or more.
        robot: as its card says.
        space: parameters of the physics; stiffness, damping, mass and inertia of the robot if None.
        trust: standard deviations of ln(true / card) by kind or name, over the card's.
        advance: called after the fit and after each posture.

    Raises:
        InvalidRequest: see `build_identification`; or fewer than three postures with FRFs.
        MissingExtra: scikit-learn is not installed.
    """
    extra("sklearn", "predict", "a prediction between postures")
    problem = build_identification(campaign, robot, source="frf", space=space, trust=trust)
    evidence = problem.evidence
    assert isinstance(evidence, FrfEvidence)
    count = len(np.unique(evidence.observations.posture))
    if count < LEAST:
        source = str(campaign.path or "campaign")
        allowed = f"{LEAST} or more, so that each can be predicted by two others"
        raise InvalidRequest(Fault(source, "posture", f"{count} with FRFs", allowed))
    sliding = tuple(name for name in robot.commanded if robot.urdf.joint_by_name[name].is_prismatic)
    with threadpool_limits(1):  # matrices this small only wait for the threads of a BLAS
        fitted = staged(evidence)[0] if is_poor(evidence) else evidence.fit()
        advance()
        left = leave_each_out(evidence, fitted, sliding=sliding, advance=advance)
    return PredictionProblem(campaign, robot, evidence, fitted.x, left, sliding)


def solve_prediction(
    problem: PredictionProblem, q: Mapping[str, float], *, name: str = "posture", method: str | None = None
) -> FrfPrediction:
    """Predict the FRFs of one posture at every pair of places that was struck.

    Args:
        problem: that `build_prediction` made.
        q: joints of the posture [rad, m]; one left out is 0.
        name: of the posture.
        method: one of `METHODS`; the one that predicts best what was left out if None.

    Raises:
        InvalidPosture: a joint that the robot does not have, or beyond its limits.
        InvalidRequest: no such method.
    """
    if method is not None and method not in METHODS:
        raise InvalidRequest(Fault("call", "method", repr(method), f"one of {', '.join(METHODS)}"))
    return solve_by_all(problem, q, name=name)[method or problem.left_out.chosen]


def solve_by_all(
    problem: PredictionProblem, q: Mapping[str, float], *, name: str = "posture"
) -> dict[str, FrfPrediction]:
    """The same by every method of `METHODS`.

    Args:
        problem: that `build_prediction` made.
        q: joints of the posture [rad, m].
        name: of the posture.

    Raises:
        InvalidPosture: a joint that the robot does not have, or beyond its limits.
    """
    where = dict(problem.robot.posture(dict(q)).values)
    left = problem.left_out
    panel = with_posture(left.panel, name, where)
    target = len(panel.observations.postures) - 1
    model = problem.evidence.model
    with threadpool_limits(1):
        there = panel.observations.keeping(panel.observations.posture == target)
        resonances = natural_frequencies(model, problem.x, where)  # type: ignore[arg-type]
        values = predicted_by_all(
            problem.known, where, predict(model, problem.x, there), np.arange(len(panel.pairs)), resonances,
            left.share, left.mix,
        )  # fmt: skip
    far, outside = remoteness(left, where), beyond(problem, where)
    found = {}
    for method, value in values.items():
        halves = band(left, method, resonances)
        wider = 1.0 if method == "physics" else far
        frfs = _frfs(problem, panel, value, (wider * halves[0], np.minimum(wider * halves[1], np.pi)))
        found[method] = FrfPrediction(
            problem.robot.name, problem.campaign.title, where, panel.axis, frfs, method, left, outside, far,
            _axes(problem, frfs), _ways(problem, panel, where),
        )  # fmt: skip
    return found


def _frfs(
    problem: PredictionProblem, panel: Panel, value: np.ndarray, halves: tuple[np.ndarray, np.ndarray]
) -> tuple[PredictedFrf, ...]:
    """One for each pair of places."""
    points = {point.id: point.name for point in problem.campaign.points}
    return tuple(
        PredictedFrf(
            named_direction(pair[:2], points),
            named_direction(pair[2:], points),
            value[number],
            halves[0][number],
            halves[1][number],
        )
        for number, pair in enumerate(panel.pairs.tolist())
    )


def _axes(problem: PredictionProblem, frfs: tuple[PredictedFrf, ...]) -> dict[str, str]:
    """What x, y, z are, by point, where they are not the world's."""
    used = dict.fromkeys(one.point for frf in frfs for one in (frf.response, frf.reference))
    own = {point.name: point.axes_text() for point in problem.campaign.points if point.own_axes}
    return {name: own[name] for name in used if name in own}


def _ways(
    problem: PredictionProblem, panel: Panel, q: Mapping[str, float]
) -> dict[str, tuple[float, float, float]]:
    """Unit vector in the world of every direction that is predicted, by its text."""
    placed = link_placements(problem.robot, dict(q))
    names = {point.id: point.name for point in problem.campaign.points}
    found = {}
    for pair in panel.pairs.tolist():
        for number, direction in (pair[:2], pair[2:]):
            point = problem.campaign.point(number)
            x, y, z = (float(part) + 0.0 for part in point.way(direction, placed[point.link][:3, :3]))
            found[str(named_direction((number, direction), names))] = (x, y, z)
    return found


def predict_posture(
    campaign: Campaign,
    robot: Robot,
    q: Mapping[str, float],
    *,
    space: ParameterSpace | None = None,
    trust: Mapping[str, float] | None = None,
    method: str | None = None,
    name: str = "posture",
    advance: Callable[[], None] = lambda: None,
) -> FrfPrediction:
    """The FRFs of a posture that nobody struck.

    Args:
        campaign: FRFs of three postures or more.
        robot: as its card says; the physics is fitted to the campaign first.
        q: joints of the posture [rad, m].
        space: parameters of the physics; see `build_prediction`.
        trust: likewise.
        method: one of `METHODS`; the one that predicts best what was left out if None.
        name: of the posture.
        advance: called after the fit and after each posture that was left out.

    Raises:
        InvalidPosture, InvalidRequest, MissingExtra: see `build_prediction` and `solve_prediction`.
    """
    robot.posture(dict(q))  # refused before the work starts
    problem = build_prediction(campaign, robot, space=space, trust=trust, advance=advance)
    return solve_prediction(problem, q, name=name, method=method)


def beyond(problem: PredictionProblem, q: Mapping[str, float]) -> tuple[str, ...]:
    """Joints outside the range that was measured.

    Args:
        problem: with the measured postures.
        q: a posture [rad, m].
    """
    measured = [
        problem.left_out.panel.observations.postures[number].q for number in problem.left_out.postures
    ]
    found = []
    for joint, value in q.items():
        ways = [one.get(joint, 0.0) for one in measured]
        if not min(ways) - 1e-9 <= value <= max(ways) + 1e-9:
            found.append(joint)
    return tuple(found)
