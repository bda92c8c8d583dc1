"""Searches stopped by Ctrl-C, and those that end by themselves: what was found until then is kept."""

import time

import numpy as np
import pytest

from flexmodal.frf import PointDirection
from flexmodal.optimisation import Hold, PostureProblem, ReceptanceObjective, optimise
from flexmodal.optimisation.search import random_starts, search_postures

pytestmark = pytest.mark.usefixtures("types_unchecked")


def problem(robot, hold, frequency=5.0, axes="z", **more):
    directions = tuple(PointDirection(robot.tool, axis) for axis in axes)
    return PostureProblem(robot, ReceptanceObjective(directions, np.array([frequency]), **more), hold)


def stop_now():
    raise KeyboardInterrupt


def test_interrupted_with_the_best_so_far(arm):
    held = problem(arm, Hold.at(arm, (-2.0, 2.0)))
    seen, count = [], 0

    def stop():
        nonlocal count
        count += 1
        if count == 4:
            raise KeyboardInterrupt

    outcome = optimise(held, starts=1000, seed=7, way="plain", advance=stop, improved=seen.append)
    assert outcome.interrupted
    assert "interrupted after 4 starts" in outcome.verdict
    assert seen == sorted(seen, reverse=True)
    assert outcome.best.objective == pytest.approx(seen[-1])
    whole = optimise(held, starts=4, seed=7, way="plain")
    assert outcome.best.objective == pytest.approx(whole.best.objective)
    with pytest.raises(KeyboardInterrupt):  # nothing to keep
        optimise(problem(arm, Hold.at(arm, (7.0, 0.0))), starts=3, advance=stop_now)


def test_a_compiled_search_interrupted(arm):
    """It stops between two batches of starts and keeps what they found."""
    held = problem(arm, Hold.at(arm, (-2.0, 2.0)))
    seen = []

    def stop(value):
        seen.append(value)
        raise KeyboardInterrupt

    outcome = optimise(held, starts=1000, seed=7, way="compiled", improved=stop)
    assert outcome.interrupted
    assert 0 < outcome.tried < 1000
    assert outcome.best.objective == pytest.approx(seen[0])
    with pytest.raises(KeyboardInterrupt):
        optimise(problem(arm, Hold.at(arm, (7.0, 0.0))), starts=1000, way="compiled", advance=stop_now)


def test_of_a_million_starts_the_first_are_searched_at_once(arm):
    """A million random vectors alone take half a minute; what is drawn is searched before more are."""
    held = problem(arm, Hold.at(arm, (-2.0, 2.0)))
    optimise(held, starts=16, way="compiled")  # whatever is compiled is compiled now
    count = 0

    def stop():
        nonlocal count
        count += 1
        if count == 700:
            raise KeyboardInterrupt

    begun = time.process_time()
    outcome = optimise(held, starts=1_000_000, seed=7, way="compiled", advance=stop)
    assert time.process_time() - begun < 10
    assert outcome.interrupted
    assert 512 < outcome.tried < 1000
    assert outcome.starts == outcome.tried  # every start reaches this target
    whole = optimise(held, starts=outcome.tried, seed=7, way="compiled")
    assert [(o.objective, o.hits) for o in outcome.optima] == [(o.objective, o.hits) for o in whole.optima]


def test_blocks_are_the_same_as_all_at_once(arm):
    held, given = problem(arm, Hold.at(arm, (-2.0, 2.0))), arm.posture("start_2")
    drawn = random_starts(held, 599, np.random.default_rng(3))
    expected = search_postures(held, np.concatenate([[held.vector(given)], drawn]), way="compiled")
    found = optimise(held, start=given, starts=600, seed=3, way="compiled")
    assert sum(optimum.hits for optimum in found.optima) == np.sum(expected.hits)
    assert found.tried == 600
    postures = [held.vector(one) for o in found.optima for one in (o.posture, *o.equals)]
    assert len(postures) == len(expected.values)
    turns = [np.min(np.max(np.abs(_within(one - expected.values)), axis=1)) for one in postures]
    assert max(turns) < 1e-12  # the same postures but for whole turns


def _within(gap):
    return gap - 2 * np.pi * np.round(gap / (2 * np.pi))


def test_nothing_left_to_gain_ends_the_search(arm):
    """Motion across the force vanishes in a family of postures: each start ends in one of its own."""
    across = problem(arm, Hold.at(arm, (0.0, 1.5)), 3.0, "xz", weights=(1.0, 0.2), toward=(0.1, 1.0))
    outcome = optimise(across, starts=2000, seed=1, way="compiled")
    assert outcome.best.objective < 1e-15
    assert outcome.best.hits == 1
    assert outcome.tried == 256
    assert outcome.converged
    assert "nothing left to gain" in outcome.verdict
    assert "try more" not in outcome.verdict
