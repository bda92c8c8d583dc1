"""What the rest of the program gains by the compiled routes, each against the same code without them.

docs/tables/engine_program.md, made by `make bench`. Before: the numpy or plain form of the same code, which a
program without numba takes; and, where there is one, the way from before the engine. Interleaved, processor
time, one thread; what is compiled was compiled before.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from typing import Any
from unittest.mock import patch

import numpy as np
from engine_harness import interleaved
from engine_search import problem as search_problem
from engine_systems import random_postures
from identification_speed import measured, solves
from tables import write

import flexmodal
from flexmodal import PointDirection
from flexmodal.diagnosis.time_domain import integration
from flexmodal.diagnosis.time_domain.law import friction, hardening
from flexmodal.diagnosis.time_domain.pulse import Pulse
from flexmodal.identification.evidence.frf import FrfEvidence
from flexmodal.model.batch import gradient_batch, receptance_batch
from flexmodal.optimisation.search import random_starts, search_postures
from flexmodal.rig import simulate
from flexmodal.rig.integration import nonlinear
from flexmodal.structure.structure import Axis, Structure

ROUNDS = 3 if "--quick" in sys.argv else 7
UP = PointDirection("tool", "z")
LINES = np.linspace(0.1, 40, 400)

Variants = Mapping[str, Callable[[], object]]


def sweep() -> Variants:
    """300 postures × 400 lines, as a workspace map takes them."""
    robot = flexmodal.load("six_link")
    postures = random_postures(robot, 300)

    def one_by_one() -> object:
        named = (dict(zip(robot.commanded, map(float, q), strict=True)) for q in postures)
        return [robot.at(pose).frf(LINES, response=UP) for pose in named]

    return {
        "after": lambda: receptance_batch(robot, postures, [UP], LINES, threads=1, way="compiled"),
        "numpy form": lambda: receptance_batch(robot, postures, [UP], LINES, threads=1, way="numpy"),
        "one by one": one_by_one,
    }


def slopes() -> Variants:
    """Value and gradient in 300 postures at one frequency."""
    robot = flexmodal.load("six_link")
    postures = random_postures(robot, 300)
    return {
        "after": lambda: gradient_batch(robot, postures, [UP], [5.0], threads=1, way="compiled"),
        "numpy form": lambda: gradient_batch(robot, postures, [UP], [5.0], threads=1, way="numpy"),
    }


def search() -> Variants:
    """Twelve starts of the posture search."""
    task = search_problem()
    starts = random_starts(task, 12, np.random.default_rng(0))
    return {
        "after": lambda: search_postures(task, starts, threads=1, way="compiled"),
        "numpy form": lambda: search_postures(task, starts, threads=1, way="plain"),
    }


def integrating() -> Variants:
    """Time integration of a diagnosis: two joints with friction and hardening, eight blows, 8 s each."""
    mass = np.array([[2.0, 0.3], [0.3, 0.5]])
    stiffness = np.array([[9e3, -2e3], [-2e3, 4e3]])
    rows = np.array([[1.0, 0.5], [0.0, 1.0]])
    arm = Structure(("a", "b"), mass, 2e-3 * stiffness, stiffness, np.zeros((2, 2)), rows, rows, {}, 0.0)
    laws = (friction(rows[1], 3.0, 3e4), hardening(np.array([1.0, 0.0]), 1500.0, 1e-3))
    axis = Axis(np.arange(1, 321) / 8.0, 15.0)
    blows = tuple((k % 2, Pulse(10.0 * (k + 1), 0.02)) for k in range(8))
    struck = [integration.Struck(arm, laws, axis, blows)]
    steps = integration.Steps.behind(axis.frequency)
    return {
        "after": lambda: integration.integrate(struck, steps, compiled=True),
        "numpy form": lambda: integration.integrate(struck, steps, compiled=False),
    }


def rig() -> Variants:
    """The first 4000 steps of the time integration of a simulated campaign with friction in a joint."""
    robot = flexmodal.load("six_link")
    compiled = nonlinear._stepper(float("inf"))
    given: list[tuple[Any, ...]] = []

    def watched(*arguments: Any) -> None:
        given.append(arguments)
        compiled(*arguments)

    with patch.object(nonlinear, "_stepper", lambda seconds: watched):
        simulate(robot, postures=1, points=2, trials=1, hide=["coulomb_friction"], seed=1)
    *before, fine = given[-1]
    origin = int(before[4])
    short = np.ascontiguousarray(fine[:, :, : origin + 4000])
    return {
        "after": lambda: compiled(*before, short),
        "numpy form": lambda: nonlinear.step_through_numpy(*before, short),
    }


PARTS: dict[str, tuple[Callable[[], Variants], tuple[str, ...]]] = {
    "frf: 300 postures × 400 lines": (sweep, ("numpy form", "one by one")),
    "value and gradient: 300 postures": (slopes, ("numpy form",)),
    "optimise: 12 starts of the posture search": (search, ("numpy form",)),
    "diagnose: integration of 8 blows, friction and hardening": (integrating, ("numpy form",)),
    "rig: 4000 steps of its integration, friction in a joint": (rig, ("numpy form",)),
}


def main() -> None:
    rows = []
    for name, (make, befores) in PARTS.items():
        result = interleaved({key: (call, 1) for key, call in make().items()}, ROUNDS)
        for before in befores:
            rows.append(
                (
                    name, before, f"{1e3 * result.median(before):.3g}", f"{1e3 * result.median('after'):.3g}",
                    str(result.faster("after", before)),
                )
            )  # fmt: skip
        print(rows[-1], flush=True)
    evidence = measured().evidence
    assert isinstance(evidence, FrfEvidence)
    found = solves(evidence, 33, ROUNDS)
    rows.append(
        (
            "identify: the solves of a fit of 33 evaluations", "numpy form", f"{1e3 * found['numpy']:.3g}",
            f"{1e3 * found['compiled']:.3g}", f"{found['numpy'] / found['compiled']:.3g}",
        )
    )  # fmt: skip
    write(
        "engine_program",
        "What the program gains",
        f"Made by `make bench`, one thread, processor time, {ROUNDS} interleaved rounds, compiled "
        "beforehand: medians, and the median ratio with its quartiles. The numpy form is the same code "
        "without numba. A whole identification is in [identification_speed.md](identification_speed.md).",
        ["what", "before", "before [ms]", "after [ms]", "times as fast"],
        rows,
    )


if __name__ == "__main__":
    main()
