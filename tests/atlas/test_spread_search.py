"""Searches and commands spread over workers come to what they come to here."""

import json
import sys
from pathlib import Path

import numpy as np
import pytest

import flexmodal
from flexmodal import Hold, PointDirection, PostureProblem, ReceptanceObjective
from flexmodal.atlas import search_spread
from flexmodal.atlas.search import EACH, gathered
from flexmodal.cli.main import main
from flexmodal.errors import FlexmodalError, InvalidRequest
from flexmodal.optimisation import RobustObjective, optimise, sample_robots

pytest.importorskip("distributed")
BENCHMARKS = Path(__file__).parents[2] / "benchmarks"


@pytest.fixture(scope="module")
def robust():
    """Three robots that an arm of three joints might be."""
    robot = flexmodal.load("fanuc_s360")
    judge = ReceptanceObjective((PointDirection("tool", "z"),), np.array([8.0]))
    return PostureProblem(
        robot, RobustObjective(judge, sample_robots(robot, 3), "worst"), Hold.at(robot, (0.9, 0.7))
    )


def numbers(outcome):
    return [(one.objective, dict(one.posture.values), one.hits) for one in outcome.optima]


@pytest.mark.slow
def test_robust_optimisation_on_a_cluster_is_that_of_one_process(robust, cluster):
    for _ in range(2):
        cluster.add_worker()
    there = search_spread(robust, 2 * EACH, seed=3, scheduler=cluster.address)
    here = search_spread(robust, 2 * EACH, seed=3, workers=1)
    assert numbers(there) == numbers(here)
    assert there.tried == 2 * EACH
    assert sum(one.hits for one in there.optima) + there.unbounded <= there.starts
    seeds = np.random.SeedSequence(3).generate_state(2).tolist()
    alone = [optimise(robust, starts=EACH, seed=seed) for seed in seeds]
    assert there.best.objective == min(one.best.objective for one in alone)
    assert there.starts == sum(one.starts for one in alone)


def test_optima_of_several_searches_are_counted_once(robust):
    one = optimise(robust, starts=EACH, seed=1)
    both = gathered(robust, [one, one], tried=2 * EACH)
    assert [opt.objective for opt in both.optima] == [opt.objective for opt in one.optima]
    assert [opt.hits for opt in both.optima] == [2 * opt.hits for opt in one.optima]
    assert [opt.equals for opt in both.optima] == [opt.equals for opt in one.optima]


@pytest.mark.slow
def test_what_no_start_reaches_and_bad_numbers(robust):
    away = PostureProblem(robust.robot, robust.objective, Hold.at(robust.robot, (30.0, 0.0)))
    with pytest.raises(FlexmodalError):
        search_spread(away, 2, workers=1)
    with pytest.raises(InvalidRequest, match="at least 1"):
        search_spread(robust, 0)


@pytest.mark.slow
def test_the_command_spreads_a_robust_search(cluster, capsys):
    cluster.add_worker()

    def call(*words):
        with pytest.raises(SystemExit) as left:
            main(["optimise", "fanuc_s360", "--frequency", "8", *words])
        return left.value.code, capsys.readouterr()

    robust = (
        "--hold",
        "0.9,0.7",
        "--robust",
        "worst",
        "--samples",
        "2",
        "--starts",
        "4",
        "--quiet",
        "--json",
    )
    status, told = call(*robust, "--scheduler", cluster.address)
    assert status == 0
    _, near = call(*robust)
    assert json.loads(told.out)["objective"] == pytest.approx(json.loads(near.out)["objective"], rel=1e-3)
    status, told = call(*robust, "--scheduler", "tcp://nowhere")
    assert (status, "tcp://HOST:8786" in told.err) == (2, True)
    status, told = call("--family", "second_link_horizontal", "--scheduler", cluster.address)
    assert (status, "--scheduler: found with --family" in told.err) == (2, True)


@pytest.fixture(scope="module")
def scripts():
    sys.path.insert(0, str(BENCHMARKS))
    try:
        import spreading
        import task_statistics
    finally:
        sys.path.remove(str(BENCHMARKS))
    return {"spreading": spreading, "task_statistics": task_statistics}


@pytest.mark.slow
def test_statistics_of_tasks_on_a_cluster(scripts, cluster, tmp_path, monkeypatch, capsys):
    """The rows that a worker prints are those made here; a run that goes on asks for what is missing."""
    cluster.add_worker()
    module = scripts["task_statistics"]
    monkeypatch.setattr(module, "FILE", tmp_path / "rows.csv")
    monkeypatch.setattr(module, "ARMS", {"six_link": module.ARMS["six_link"]})
    module.compute(1, cluster.address, None)
    (row,) = module.rows_there()
    capsys.readouterr()
    module.one("six_link:0:1")
    printed = capsys.readouterr().out.split(",")
    assert list(row.values()) == [cell.strip() for cell in printed]
    module.compute(1, cluster.address, None)
    assert len(module.rows_there()) == 1


def test_a_piece_that_fails_says_so(scripts, capsys):
    given = {"scheduler": None, "workers": 1}
    found = dict(scripts["spreading"].pieces("identification_recovery.py", ["nobody:1"], [], **given))
    assert found == {"nobody:1": None}
    assert "nobody:1 failed" in capsys.readouterr().err
