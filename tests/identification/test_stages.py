"""A card whose stiffness and damping were guessed: the answer is found in stages where a descent is lost."""

from dataclasses import replace

import numpy as np
import pytest

import flexmodal
from flexmodal.cards import FrozenDict
from flexmodal.identification import build_identification, identify
from flexmodal.identification.as_json import as_json
from flexmodal.identification.page import STAGES, stage_cells, write_identification_page
from flexmodal.identification.poor import DECADE, POOR
from flexmodal.identification.stages import CARD, JOINTS, MASSES, SCALE, is_poor, staged
from flexmodal.rig import ParameterError, simulate

SEED = 15
OFF = 1.5
"""Standard deviation of the card, over that of the prior."""


@pytest.fixture(scope="module")
def robot():
    return flexmodal.load("fanuc_s360")


@pytest.fixture(scope="module")
def guessed(robot):
    random, joints = np.random.default_rng([SEED, 71]), {}
    for joint, own in robot.joints.items():
        factor = np.exp(random.normal(0, OFF * DECADE, 2))
        joints[joint] = replace(own, stiffness=own.stiffness * factor[0], damping=own.damping * factor[1])
    return replace(robot, joints=FrozenDict(joints))


@pytest.fixture(scope="module")
def made(robot):
    return simulate(
        robot, postures=3, points=2, references=1, trials=2, band=(2.0, 100.0), record_length=2.0,
        parameter_error=ParameterError(mass=0.2, inertia=0.2), seed=SEED, time=False,
    )  # fmt: skip


@pytest.fixture(scope="module")
def evidence(made, guessed):
    return build_identification(made.campaign, guessed, source="frf", trust=POOR).evidence


@pytest.fixture(scope="module")
def outcome(made, guessed):
    return identify(made.campaign, guessed, source="frf", trust=POOR)


@pytest.mark.slow
def test_the_answer_is_found_where_a_descent_from_the_card_is_lost(evidence, outcome, made, robot):
    straight = evidence.fit()
    assert evidence.over_noise(evidence.predicted(straight.x)) > 2
    assert outcome.over_noise < 1.2
    for one in outcome.estimates:
        if one.name.startswith("stiffness."):
            joint = one.name.removeprefix("stiffness.")
            true = robot.joints[joint].stiffness * made.truth.factors[one.name]
            assert abs(np.log(one.value / true)) < 0.3


@pytest.mark.slow
def test_each_stage_is_told_with_its_gap_and_the_share_it_took(outcome, tmp_path):
    stages = outcome.stages
    assert [one.name for one in stages] == [CARD, SCALE, JOINTS, MASSES]
    first, last = stages[0], stages[-1]
    assert last.gap == pytest.approx(outcome.gap.after)
    assert first.gap == pytest.approx(outcome.gap.before)
    above = [max(one.over_noise**2 - 1, 0.0) for one in stages]
    for before, here, one in zip(above[:-1], above[1:], stages[1:], strict=True):
        assert one.share == pytest.approx((before - here) / above[0])
    assert [one["name"] for one in as_json(outcome)["stages"]] == [one.name for one in stages]
    write_identification_page(outcome, tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text()
    assert all(text in page for row in stage_cells(outcome) for text in (row[0], STAGES[2]))


def test_a_card_that_is_trusted_is_fitted_straight(made, robot, evidence):
    problem = build_identification(made.campaign, robot, source="frf")
    assert not is_poor(problem.evidence)
    assert is_poor(evidence)
    guessed = build_identification(made.campaign, robot, source="frf", trust={"stiffness": 1.0})
    assert is_poor(guessed.evidence)  # as flexmodal card new writes it


@pytest.mark.slow
def test_it_is_never_worse_than_straight(made, robot):
    """From a card that is nearly right, where there is nothing to look for."""
    near = build_identification(made.campaign, robot, source="frf", trust=POOR).evidence
    assert staged(near)[0].cost <= 1.01 * near.fit().cost


def test_modes_alone_are_fitted_straight(guessed, made):
    """A model without a mode near the measured ones would have nothing to be compared with."""
    assert not is_poor(build_identification(made.campaign, guessed, source="modes", trust=POOR).evidence)
