"""Compiles the functions that take longest, so that tests find them on disk.

Run in the background as the tests begin (`conftest.py`). In a fresh clone each process of the tests would
otherwise go on without them until compiling has paid for itself, or compile the same function as another one.
"""

import os
import sys

import numpy as np

import flexmodal
from flexmodal.campaign import Campaign
from flexmodal.diagnosis.effects import Context, catalogue
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.placed import Placed
from flexmodal.diagnosis.time_domain.model import TimeDomainModel
from flexmodal.frf.kernels import worth
from flexmodal.identification import observe
from flexmodal.optimisation.search.descents import descend_from
from flexmodal.rig import Hide
from flexmodal.structure import robot_space


class Known(dict):
    """Every function counts as compiled: it is worth compiling now."""

    def __contains__(self, kind: object) -> bool:
        return True

    def __missing__(self, kind: object) -> bool:
        return True


def of_the_rig() -> Campaign:
    """Steps in time of the rig; what it measured."""
    hide = [Hide.parse("coulomb_friction")]
    return flexmodal.simulate(
        flexmodal.load("six_link"), hide=hide, postures=1, points=1, references=1, trials=1,
        record_length=1.0, seed=1,
    ).campaign  # fmt: skip


def of_a_diagnosis(tested: Campaign) -> None:
    """Steps in time of a hypothesis."""
    robot, seen = flexmodal.load("six_link"), observe(tested)
    bare = Hypothesis(Context.of(robot, seen), robot_space(robot))
    rubs = bare.and_also(Placed(catalogue()["coulomb_friction"], "q2"))
    TimeDomainModel(rubs).receptances(np.zeros(len(rubs.space)), seen, slice(None), slopes=False)


def descents() -> None:
    """Descents of the posture search."""
    arm = flexmodal.load("six_link")
    x, _, z = arm.at("start_2").position("tool")
    goal = flexmodal.ReceptanceObjective("tool:+z", 5.0)
    problem = flexmodal.PostureProblem(arm, goal, flexmodal.Hold.at(arm, (x, z)))
    descend_from(problem, np.zeros((1, len(arm.commanded))), iterations=1, way="compiled")


def main(meanwhile: str) -> None:
    """Compile all of it.

    Args:
        meanwhile: file that is removed at the end.
    """
    worth.IMPORT = worth.LOAD = 0.0
    worth._stored = worth._stored_at_first = Known()
    try:
        of_a_diagnosis(of_the_rig())
        descents()
    finally:
        os.unlink(meanwhile)


if __name__ == "__main__":
    main(sys.argv[1])
