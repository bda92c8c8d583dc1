"""A joint that sticks stays away from where it was, in records at whose end a robot alone is at rest."""

from dataclasses import replace

import numpy as np
import pytest

import flexmodal
from flexmodal.diagnosis.effects import Context, catalogue
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.placed import Placed
from flexmodal.diagnosis.setup import prepare
from flexmodal.diagnosis.time_domain.model import TimeDomainModel
from flexmodal.identification import observe, predict, unlimited
from flexmodal.rig import Hide
from flexmodal.structure import robot_space

LAW = {"torque": 21.7, "presliding_stiffness": 1.48e5}
"""Strong enough for the joint to stay where a blow has put it."""


@pytest.fixture(scope="module")
def tested():
    """Without noise or scatter."""
    robot = flexmodal.load("fanuc_s360")
    hide = [Hide("coulomb_friction", "q2", LAW)]
    return flexmodal.simulate(
        robot, hide=hide, postures=1, points=1, references=1, trials=2, noise=0.0, scatter=0.0,
        parameter_error=0.0, seed=6,
    )  # fmt: skip


def far(tested, observations):
    """Largest |ln(model / measured)| below 10 Hz, of the law with its own numbers."""
    robot = flexmodal.load("fanuc_s360")
    root = Hypothesis(Context.of(robot, observations), robot_space(robot))
    hypothesis = root.and_also(Placed(catalogue()["coulomb_friction"], "q2"))
    placed = hypothesis.placed[-1]
    x = hypothesis.start(placed, {**LAW, "stiction": 1e-3, "slow_torque": 1e-9}, np.zeros(len(root.space)))
    low = observations.axis.frequency < 10
    predicted = predict(TimeDomainModel(hypothesis), x, observations)
    return float(np.max(np.abs(np.log(predicted / observations.value)[:, low])))


def test_what_stays_away_is_in_the_model_though_nothing_linear_is_cut_off(tested):
    seen = observe(tested.campaign)
    assert far(tested, seen) < 0.02
    assert far(tested, unlimited(seen)) < 0.02
    assert far(tested, replace(seen, lengths=(0.0,) * len(seen.lengths))) > 0.1


def test_a_diagnosis_knows_how_long_records_are_where_the_robot_comes_to_rest(tested):
    robot = flexmodal.load("fanuc_s360")
    noisy = replace(tested.campaign, frfs=None)  # from the blows, whose noise is that of rounding
    setup = prepare(noisy, robot, [], None, None, 0, lambda doing, part: None)
    seen = setup.observations
    assert seen.endless
    assert min(seen.lengths) > 3.5
    assert seen.axis_of(0).length == 0.0
    assert seen.recorded(0).length == seen.lengths[0]
    assert {length for _, length in seen.layout.axes} == {0.0}
