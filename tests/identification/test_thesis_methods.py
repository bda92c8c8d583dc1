"""The thesis's eigenvalue method and piecewise model."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from flexmodal.campaign import read_campaign
from flexmodal.errors import InvalidRequest
from flexmodal.identification import build_identification
from flexmodal.identification.eigenvalue_method import EigenvalueModel, eigenvalue_method
from flexmodal.identification.evidence.measured_modes import MeasuredMode
from flexmodal.identification.evidence.modal import ModalEvidence
from flexmodal.identification.evidence.mode_sources import modes_of_table
from flexmodal.identification.piecewise import piecewise
from flexmodal.structure.poles import poles

ROOT = Path(__file__).parents[2]

CAMPAIGN = str(ROOT / "robots/fanuc_s360/campaigns/thesis")
TWO = ("configuration_1", "configuration_7")
FOUR = ("configuration_1", "configuration_2", "configuration_6", "configuration_7")
LINKS = ("link_1", "link_2", "link_2_outer", "link_3")


@pytest.fixture(scope="module")
def measured():
    return read_campaign(CAMPAIGN)


@pytest.fixture(scope="module")
def near(fanuc):
    """Bounds around the card."""
    around = {}
    for name, joint in fanuc.joints.items():
        around[f"stiffness.{name}"] = (joint.stiffness / 5, joint.stiffness, joint.stiffness * 5)
        around[f"damping.{name}"] = (joint.damping / 5, joint.damping, joint.damping * 5)
    for link in LINKS:
        body = fanuc.urdf.link_by_name[link]
        around[f"mass.{link}"] = (body.mass / 3, body.mass, body.mass * 3)
        around[f"moment.{link}"] = (body.inertia[1, 1] / 3, body.inertia[1, 1], body.inertia[1, 1] * 3)
    return around


def test_its_model_is_the_robots_and_its_derivatives_are_right(fanuc, near):
    from flexmodal.identification.eigenvalue_method import _space

    space = _space(fanuc, near)
    model, q = EigenvalueModel(fanuc, space), dict(fanuc.postures["configuration_2"])
    card = poles(model.structure_at(np.zeros(len(space)), q, [], []))
    np.testing.assert_allclose(card.frequency, fanuc.at(q).modes().frequency, rtol=1e-9)
    x = np.random.default_rng(2).normal(0, 0.1, len(space))
    middle = poles(model.structure_at(x, q, [], []), space.names)
    for k in range(len(space)):
        shift = 1e-5 * np.eye(len(space))[k]
        up, down = (poles(model.structure_at(x + s * shift, q, [], [])) for s in (1, -1))
        numeric = np.log(up.frequency / down.frequency) / 2e-5
        np.testing.assert_allclose(middle.log_frequency_slope[k], numeric, atol=1e-7, err_msg=space.names[k])


@pytest.mark.slow
def test_stages_come_closer_than_the_table_they_begin_at(measured, fanuc, near):
    stages = eigenvalue_method(measured, fanuc, near, [TWO, FOUR])
    assert [stage.postures for stage in stages] == [TWO, FOUR]
    whole = ModalEvidence(stages[0].model, modes_of_table(measured), ("frequency", "damping"))

    def rms(x):
        return float(np.sqrt(np.nanmean(whole.predicted(x)[:, 0] ** 2)))

    assert rms(stages[1].x) < rms(np.zeros(len(near))) == pytest.approx(0.0115, rel=0.05)
    for stage in stages:
        low, high = stage.model.space.bounds
        assert np.all((stage.x >= low) & (stage.x <= high))
        assert set(stage.at_bound) <= set(near)


def test_the_card_as_prior_predicts_what_it_has_not_seen_better_than_a_mean(measured, fanuc):
    trust = {"stiffness": 0.5, "mass": 0.3, "inertia": 0.3}
    evidence = build_identification(measured, fanuc, trust=trust, model_error=0.01).evidence
    fitted = evidence.predicted(evidence.fit().x)[:, 0]
    card = evidence.predicted(np.zeros(len(evidence.space)))[:, 0]
    apart = np.full(len(card), np.nan)
    for keep in evidence.folds().values():
        apart[keep] = evidence.keeping(keep).predicted(evidence.keeping(~keep).fit().x)[:, 0]
    modes = evidence.observations.modes
    known = np.isfinite(fitted)
    kinds = np.array(
        [int(np.argmin(np.abs(np.array([7.6, 38, 51, 57, 93]) - mode.frequency))) for mode in modes]
    )
    frequency = np.array([mode.frequency for mode in modes])
    mean = np.array([
        frequency[(kinds == kinds[k]) & (np.arange(len(modes)) != k)].mean() / frequency[k] - 1 for k in
    range(len(modes)) ])  # fmt: skip

    def rms(errors):
        return float(np.sqrt(np.mean(errors[known] ** 2)))

    assert known.sum() == 16
    assert rms(fitted) < 0.010 < rms(card)  # Table 2.9 leaves 1.15 %
    assert rms(apart) < 0.014 < rms(mean)


def test_bad_requests_are_refused_together(measured, fanuc, near):
    wrong = {**near, "mass.hand": (1.0, 2.0, 3.0), "mass.link_1": (3.0, 2.0, 1.0)}
    with pytest.raises(InvalidRequest) as error:
        eigenvalue_method(measured, fanuc, wrong, [TWO])
    assert len(error.value.faults) == 2
    with pytest.raises(InvalidRequest, match="configuration_3"):
        eigenvalue_method(measured, fanuc, near, [["configuration_3"]])
    with pytest.raises(InvalidRequest, match="8 numbers"):
        eigenvalue_method(measured, fanuc, near, [["configuration_1"]])


def test_the_switch_is_the_models_own_minimum(fanuc):
    modes = fanuc.at(fanuc.postures["configuration_1"]).modes()
    multiplier = np.array([4.4e-4 - 1.7e-4j, 8.7e-5 - 4.3e-5j, 2.2e-5 - 4.4e-5j, 7.5e-5 - 2.2e-4j])  # C.1
    found = piecewise(modes.pole, multiplier / (2j * modes.pole.imag))
    assert 40 < found.switch < 51  # the thesis types in 46 Hz
    lines = np.linspace(modes.frequency[0], modes.frequency[1], 500)
    below = np.abs(replace(found, switch=1e9).receptance(lines))
    assert lines[np.argmin(below)] == pytest.approx(found.switch, abs=0.2)
    high = found.receptance(np.array([500.0, 1000.0, 1500.0]))
    np.testing.assert_allclose(np.abs(high[1:]), [1.278e-3, 8.50e-4], rtol=2e-3)  # Table 3.4
    together = piecewise(modes.pole, multiplier / (2j * modes.pole.imag), joined=True)
    ends = np.abs(together.receptance(together.switch + np.array([-1e-6, 1e-6])))
    assert ends[0] == pytest.approx(ends[1], rel=1e-4)


def test_a_piecewise_model_needs_two_modes_with_multipliers():
    with pytest.raises(InvalidRequest, match="1 poles and 1 multipliers"):
        piecewise(np.array([-1 + 50j]), np.array([1e-6 + 0j]))


def test_order_of_modes_does_not_matter(measured, fanuc):
    """Pairing goes by what a mode is, not by its place in the table."""
    evidence = build_identification(measured, fanuc).evidence
    turned = replace(
        evidence, observations=replace(evidence.observations, modes=evidence.observations.modes[::-1])
    )
    assert isinstance(evidence.observations.modes[0], MeasuredMode)
    x = np.zeros(len(evidence.space))
    assert evidence.pairs(x) == turned.pairs(x)[::-1]
