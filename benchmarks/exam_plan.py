"""What the exam asks: robots, effects, heights, all drawn from one seed; and the campaigns themselves."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import flexmodal
from flexmodal.campaign import write_campaign
from flexmodal.rig import EFFECTS, draw_scenario, simulate
from flexmodal.rig.robot_folder import write_robot

ROBOTS = ("fanuc_s360", "six_link", "six_axis")
NAMED = tuple(name for name, effect in EFFECTS.items() if effect.catalogued)
OUTSIDE = tuple(name for name, effect in EFFECTS.items() if not effect.catalogued)
EACH, NOTHING, PAIRS, UNKNOWN = 2, 4, 5, 5
"""For each robot: campaigns of each effect, with nothing hidden, with two effects, with an unknown one."""
POSTURES, POINTS = 5, 5
ENGINES = ("rig", "mujoco")
"""Who integrates the motion: the virtual rig, or MuJoCo (see `mujoco_campaign`)."""


@dataclass(frozen=True)
class Question:
    """One campaign of the exam."""

    name: str
    robot: str
    kind: str
    """single, nothing, pair or outside."""
    effects: tuple[str, ...]
    seed: int


def plan(seed: int, engine: str = "rig") -> list[Question]:
    """All questions, in an order in which any beginning is a fair sample."""
    random = np.random.default_rng([seed, 99])
    found = []
    for robot in ROBOTS:
        wanted = _mujoco() if engine == "mujoco" else _rig(random)
        found += [(robot, kind, effects) for kind, effects in wanted]
    order = random.permutation(len(found))
    seeds = np.random.default_rng([seed, 98]).integers(1, 2**31, len(found))
    return [
        Question(f"{place + 1:03d}", *found[k], seed=int(seeds[k])) for place, k in enumerate(order.tolist())
    ]


def _rig(random: np.random.Generator) -> list[tuple[str, tuple[str, ...]]]:
    wanted: list[tuple[str, tuple[str, ...]]] = [("single", (name,)) for name in NAMED for _ in range(EACH)]
    wanted += [("nothing", ())] * NOTHING
    wanted += [("pair", tuple(random.choice(NAMED, 2, replace=False).tolist())) for _ in range(PAIRS)]
    return wanted + [("outside", (OUTSIDE[k % len(OUTSIDE)],)) for k in range(UNKNOWN)]


def _mujoco() -> list[tuple[str, tuple[str, ...]]]:
    from mujoco_model import EFFECTS as HIDDEN

    return [("single", (name,)) for name in HIDDEN] + [("nothing", ())]


def pose(question: Question, folder: Path, truth: Path, engine: str = "rig") -> None:
    """Simulate a question's campaign; what is hidden goes elsewhere."""
    if engine == "mujoco":
        from mujoco_campaign import simulate_mujoco as simulated
    else:
        simulated = simulate
    robot = flexmodal.load(question.robot)
    count = len(question.effects)
    points = min(POINTS, len(robot.points))
    scenario = draw_scenario(
        robot, question.seed, count=count, effects=question.effects or None, points=points
    )
    result = simulated(
        robot,
        postures=POSTURES,
        points=points,
        hide=scenario.hide,
        parameter_error=scenario.parameter_error,
        seed=question.seed,
        time=False,
    )
    truth.parent.mkdir(parents=True, exist_ok=True)
    result.truth.write(truth)
    write_campaign(result.campaign, folder)
    write_robot(result.robot, folder, result.plan.postures, result.plan.points)


if __name__ == "__main__":
    _engine, _seed, _name, _folder, _truth = sys.argv[1:]
    _question = next(one for one in plan(int(_seed), _engine) if one.name == _name)
    pose(_question, Path(_folder), Path(_truth), _engine)
