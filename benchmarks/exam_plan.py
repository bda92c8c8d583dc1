"""What the exam asks: robots, effects, heights, all drawn from one seed; and the campaigns themselves.

The exam of the rig's own forms is on the shipped robots; those of forms looked at and of sealed ones, planned
in `exam_forms`, are on arms drawn at random besides.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
from exam_forms import plan_forms
from exam_question import NAMED, OUTSIDE, ROBOTS, Question, pose

SINCE = ("bearing_flexibility",)
"""Effects that came after the published exam: asked for at its end, its questions stay what they were."""
EACH, NOTHING, PAIRS, UNKNOWN = 2, 4, 5, 5
"""For each robot: campaigns of each effect, with nothing hidden, with two effects, with an unknown one."""


def plan(seed: int, engine: str = "rig", forms: str = "own") -> list[Question]:
    """All questions, in an order in which any beginning is a fair sample."""
    if forms != "own":
        return plan_forms(seed, forms)
    random = np.random.default_rng([seed, 99])
    found = []
    for robot in ROBOTS:
        wanted = _mujoco() if engine == "mujoco" else _rig(random)
        found += [(robot, kind, effects) for kind, effects in wanted]
    order = random.permutation(len(found))
    if engine == "rig":
        later = [(robot, "single", (name,)) for name in SINCE for robot in ROBOTS for _ in range(EACH)]
        found, order = found + later, np.append(order, len(found) + np.arange(len(later)))
    seeds = np.random.default_rng([seed, 98]).integers(1, 2**31, len(found))
    return [
        Question(f"{place + 1:03d}", *found[k], seed=int(seeds[k])) for place, k in enumerate(order.tolist())
    ]


def _rig(random: np.random.Generator) -> list[tuple[str, tuple[str, ...]]]:
    names = [name for name in NAMED if name not in SINCE]
    wanted: list[tuple[str, tuple[str, ...]]] = [("single", (name,)) for name in names for _ in range(EACH)]
    wanted += [("nothing", ())] * NOTHING
    wanted += [("pair", tuple(random.choice(names, 2, replace=False).tolist())) for _ in range(PAIRS)]
    return wanted + [("outside", (OUTSIDE[k % len(OUTSIDE)],)) for k in range(UNKNOWN)]


def _mujoco() -> list[tuple[str, tuple[str, ...]]]:
    from mujoco_model import EFFECTS as HIDDEN

    return [("single", (name,)) for name in HIDDEN] + [("nothing", ())]


if __name__ == "__main__":
    _engine, _forms, _seed, _name, _folder, _truth, *_postures = sys.argv[1:]
    _question = next(one for one in plan(int(_seed), _engine, _forms) if one.name == _name)
    _question = replace(_question, postures=int(_postures[0])) if _postures else _question
    pose(_question, Path(_folder), Path(_truth), _engine)
