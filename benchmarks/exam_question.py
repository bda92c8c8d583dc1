"""A question of the exam: robot, effects and seeds; and its campaign, simulated."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

import flexmodal
from flexmodal.campaign import write_campaign
from flexmodal.errors import InvalidRequest
from flexmodal.model import Robot
from flexmodal.rig import EFFECTS, FORM_SETS, FORMS, ParameterError, Scenario, Truth, draw_scenario, simulate
from flexmodal.rig.arms import draw_arm
from flexmodal.rig.hammer_test import Conduct
from flexmodal.rig.hidden.retuned import retuned_heights
from flexmodal.rig.positions import choose_points
from flexmodal.rig.result import RigResult
from flexmodal.rig.robot_folder import write_robot

ROBOTS = ("fanuc_s360", "six_link", "six_axis")
NAMED = tuple(name for name, effect in EFFECTS.items() if effect.catalogued)
OUTSIDE = tuple(name for name, effect in EFFECTS.items() if not effect.catalogued)
POSTURES, POINTS = 5, 5
ENGINES = ("rig", "mujoco")
"""Who integrates the motion: the virtual rig, or MuJoCo (see `mujoco_campaign`)."""
WHICH = ("own", *FORM_SETS)
"""Physical forms that are hidden: the rig's own, those looked at while tuning, those for the exam alone, and
those that were written once the diagnosis was done, before and after it had met the first of these,
and by authors who did not know how it works."""
ARM = "arm"
"""Instead of the name of a robot: one drawn at random."""
MASS_ERRORS = (0.02, 0.2)
"""Standard deviation of the logarithm of masses and inertias of a drawn arm: 2 to 40 % off at twice that."""
_ARMS_TRIED, _SEEDS_TRIED = 20, 5


@dataclass(frozen=True)
class Question:
    """One campaign of the exam."""

    name: str
    robot: str
    kind: str
    """single, nothing, pair, several or outside."""
    effects: tuple[str, ...]
    seed: int
    forms: tuple[str, ...] = ()
    """Of each effect; the rig's own if none are named."""
    arm: int = 0
    """Seed of a drawn arm."""
    postures: int = POSTURES


def find_robot(question: Question, folder: Path) -> Robot:
    """The robot of a question; of arms the first from its seed on that has places for what is hidden."""
    if question.robot != ARM:
        return flexmodal.load(question.robot)
    for number in range(_ARMS_TRIED):
        place = folder / f"{question.name}-{number}"
        robot = flexmodal.load(draw_arm(place, question.arm + number))
        points = choose_points(robot, min(POINTS, len(robot.points)))
        wanted = zip(question.effects, question.forms, strict=True)
        if all(FORMS[name][form].places(robot, points) for name, form in wanted):
            return robot
    raise RuntimeError(f"no arm from seed {question.arm} on has places for {question.effects}")


def parameter_error(question: Question, usual: float) -> float | ParameterError:
    """How far the card is off; the masses of a drawn arm are off by their own."""
    if question.robot != ARM:
        return usual
    low, high = np.log(MASS_ERRORS)
    mass = float(np.exp(np.random.default_rng([question.seed, 96]).uniform(low, high)))
    return ParameterError(usual, usual, mass, mass)


def pose(question: Question, folder: Path, truth: Path, engine: str = "rig") -> None:
    """Simulate a question's campaign; what is hidden goes elsewhere."""
    if engine == "mujoco":
        from mujoco_campaign import simulate_mujoco as simulated
    else:
        simulated = simulate
    with tempfile.TemporaryDirectory() as scratch:
        _pose(question, find_robot(question, Path(scratch)), folder, truth, simulated)


def _pose(
    question: Question, robot: Robot, folder: Path, truth: Path, simulated: Callable[..., RigResult]
) -> None:
    for number in range(_SEEDS_TRIED):
        try:
            result = _simulated(replace(question, seed=question.seed + number), robot, simulated)
            break
        except InvalidRequest:  # a control loop that rings up with what else is hidden
            if number == _SEEDS_TRIED - 1:
                raise
    truth.parent.mkdir(parents=True, exist_ok=True)
    told = _retuned(question, result) if simulated is simulate else result.truth
    told.write(truth)
    write_campaign(result.campaign, folder)
    write_robot(result.robot, folder, result.plan.postures, result.plan.points)


def _retuned(question: Question, result: RigResult) -> Truth:
    """What is hidden, with how high each effect stands when all else is re-tuned."""
    truth = result.truth
    if not result.hidden:
        return truth
    drawn = replace(question, seed=truth.seed)
    error = parameter_error(drawn, _scenario(drawn, result.robot).parameter_error)
    sizes = error if isinstance(error, ParameterError) else ParameterError.all(error)
    conduct = Conduct(truth.noise, truth.scatter, truth.seed)
    heights = retuned_heights(result.stand, result.hidden, conduct, sizes)
    effects = (replace(one, retuned=high) for one, high in zip(truth.effects, heights, strict=True))
    return replace(truth, effects=tuple(effects))


def _scenario(question: Question, robot: Robot) -> Scenario:
    points = min(POINTS, len(robot.points))
    effects = question.effects or None
    return draw_scenario(robot, question.seed, count=len(question.effects), effects=effects, points=points)


def _simulated(question: Question, robot: Robot, simulated: Callable[..., RigResult]) -> RigResult:
    points, scenario = min(POINTS, len(robot.points)), _scenario(question, robot)
    forms = dict(zip(question.effects, question.forms, strict=False))
    return simulated(
        robot,
        postures=question.postures,
        points=points,
        hide=[replace(item, form=forms.get(item.effect, "own")) for item in scenario.hide],
        parameter_error=parameter_error(question, scenario.parameter_error),
        seed=question.seed,
        time=False,
    )
