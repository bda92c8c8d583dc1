"""Profile intervals, several starts, models that vary over the workspace or with the force."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import stdtrit

from flexmodal.errors import InvalidRequest
from flexmodal.identification import RobotModel, build_identification, predict
from flexmodal.identification.identify import solve_identification
from flexmodal.identification.local import level_models, local_models
from flexmodal.identification.optima import search
from flexmodal.identification.profile import profile
from flexmodal.rig import simulate
from flexmodal.structure import robot_space


@pytest.fixture(scope="module")
def outcome(campaign, fanuc):
    problem = build_identification(campaign, fanuc, space=robot_space(fanuc, ["stiffness", "damping"]))
    return solve_identification(problem, in_turn=False)


def test_the_profile_of_a_well_known_parameter_is_laplaces(outcome):
    found = profile(outcome, "stiffness.q2")
    width = found.laplace[1] - found.laplace[0]
    np.testing.assert_allclose(found.interval, found.laplace, atol=0.1 * width)
    assert found.refits < 20


def test_along_a_profile_the_cost_has_risen_as_much_as_it_may(outcome):
    """At the end of a 68 % interval the refitted cost is higher by the adjusted t²."""
    found = profile(outcome, "damping.q1", level=0.68)
    space, k = outcome.problem.space, outcome.problem.space.index["damping.q1"]
    at = float(np.log(found.interval[1] / space.parameters[k].card))
    again = outcome.problem.evidence.fit(outcome.at, warm=True, hold={"damping.q1": at})
    assert again.x[k] == at
    inverse = np.linalg.inv(outcome.fitted.normal.curvature + np.diag(space.precision))
    factor = stdtrit(outcome.uncertainty.freedom[k], 0.84)
    wanted = factor**2 * outcome.uncertainty.covariance[k, k] / inverse[k, k]
    assert (again.normal.cost - outcome.fitted.normal.cost) / wanted == pytest.approx(1.0, rel=0.15)


def test_bad_profiles_are_refused(outcome):
    with pytest.raises(InvalidRequest, match=r"mass\.hand"):
        profile(outcome, "mass.hand")
    with pytest.raises(InvalidRequest, match="level"):
        profile(outcome, "stiffness.q1", level=2.0)


def test_several_starts_end_in_one_place(campaign, fanuc):
    problem = build_identification(campaign, fanuc, space=robot_space(fanuc, ["stiffness", "damping"]))
    fitted, optima = search(problem.evidence, starts=4, seed=1)
    assert len(optima) >= 1
    assert sum(one.hits for one in optima) >= 2
    card = problem.evidence.fit()
    # the last step changed the cost by less than a millionth: some tenths of a naive standard error
    error = problem.evidence.uncertainty(card).deviation
    assert np.all(np.abs(fitted.x - card.x) < 0.3 * error)
    again, same = search(problem.evidence, starts=4, seed=1)  # the same starts; sums may be rounded otherwise
    assert np.all(np.abs(again.x - fitted.x) < 1e-6 * error)
    assert [one.hits for one in same] == [one.hits for one in optima]


def drawn(outcome, change):
    """The same campaign as if the robot's parameters were elsewhere for some observations."""
    problem = outcome.problem
    seen, space = problem.evidence.observations, problem.space
    model = RobotModel(problem.robot, space)
    value = np.zeros_like(seen.value)
    for k in range(len(seen)):
        only = np.arange(len(seen)) == k
        value[only] = predict(model, space.coordinates(change(seen, k)), seen.keeping(only))
    random = np.random.default_rng(8)
    noise = np.sqrt(seen.variance / 2) * (
        random.normal(size=value.shape) + 1j * random.normal(size=value.shape)
    )
    value *= 1 + np.where(seen.used, noise, 0.0)
    records = replace(seen.records, value=value[seen.of_record])
    evidence = replace(problem.evidence, observations=replace(seen, value=value, records=records))
    return solve_identification(replace(problem, evidence=evidence, whole=evidence), in_turn=False)


@pytest.fixture(scope="module")
def workspace(fanuc):
    postures = [f"configuration_{k}" for k in (1, 2, 3, 5, 7)]
    made = simulate(fanuc, postures=postures, points=2, references=1, trials=4, peaks=(60.0, 240.0), seed=4)
    space = robot_space(fanuc, ["stiffness", "damping"])
    problem = build_identification(replace(made.campaign, blows=()), fanuc, space=space)
    return solve_identification(problem, in_turn=False)


def test_a_stiffness_that_varies_over_the_workspace_is_met_by_local_models(workspace):
    def softer_outside(seen, k):
        q1 = seen.postures[int(seen.posture[k])].q["q1"]
        return {"stiffness.q2": 20000.0 * (1 + 0.3 * (q1 - 1.5))}

    found = local_models(drawn(workspace, softer_outside), widths=(0.4, 1.0))
    assert found.worth_it
    assert found.held_out[found.width] < 0.8 * found.held_out[np.inf]
    stiffness = [found.values[f"configuration_{k}"]["stiffness.q2"] for k in (1, 3, 7)]
    assert stiffness[0] < stiffness[1] < stiffness[2]
    assert "vary over the workspace" in found.verdict


def test_one_set_is_enough_where_nothing_varies(workspace):
    found = local_models(workspace, widths=(0.4,))
    assert not found.worth_it
    assert "one set of parameters serves all" in found.verdict


def test_a_stiffness_that_falls_with_the_force_is_told(workspace):
    def softer_when_hit_harder(seen, k):
        return {"stiffness.q2": 20000.0 * (0.97 if seen.peak(int(seen.level[k])) > 100 else 1.0)}

    found = level_models(drawn(workspace, softer_when_hit_harder))
    assert found.peaks == (60.0, 240.0)
    assert found.different[0] == "stiffness.q2"
    assert found.each < found.together
    k = workspace.problem.space.index["stiffness.q2"]
    assert found.at[1][k] - found.at[0][k] == pytest.approx(np.log(0.97), abs=0.005)


def test_linear_joints_have_no_levels(workspace, outcome):
    assert level_models(workspace).different == ()
    with pytest.raises(InvalidRequest, match="one force level"):
        level_models(outcome)
