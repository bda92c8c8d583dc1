"""Lines of a free function that ended elsewhere go on from what their neighbours lead to."""

from dataclasses import replace

import numpy as np
import pytest

from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.lawfree.at_parameters import AtParameters
from flexmodal.diagnosis.lawfree.joint_ports import JOINT
from flexmodal.diagnosis.lawfree.model import PortedModel
from flexmodal.diagnosis.lawfree.port import Port
from flexmodal.diagnosis.lawfree.profile import Profile
from flexmodal.diagnosis.lawfree.repair import offers, repaired
from flexmodal.structure import robot_space

JOINT_NAME = "q2"


def rotor(frequency):
    """What a rotor on a soft loop adds to the stiffness of its joint, in units of that; it rings at 40 Hz."""
    motor = 0.1 - (frequency / 40) ** 2 * 1.1 + 0.04j * frequency / 40
    return motor / (1 + motor) - 1


@pytest.fixture(scope="module")
def fit(context, observed):
    """FRFs of a robot with a rotor without noise, and the functions that made them."""
    root = Hypothesis(context, robot_space(context.robot))
    lines = np.arange(20, len(observed.axis), 12)
    model = PortedModel.of([Port.at(JOINT, JOINT_NAME, root.context)], root, observed, lines)
    z = model.zero() + rotor(observed.axis.frequency[lines])
    value = observed.value.copy()
    value[:, lines] *= np.exp(AtParameters(model, np.zeros(len(model.space))).residual(z))
    clean = replace(observed, value=value, used=np.ones_like(observed.used))
    return Profile(replace(model, observations=clean), 0.01), z


@pytest.mark.parametrize("line", [0, 3, 6])
def test_a_line_beside_a_resonance_comes_back(fit, line):
    profile, true = fit
    wrong = true.copy()
    wrong[..., line] = -1.5 + 0.9j
    x = np.zeros(len(profile.model.space))
    state = profile.state(x, wrong)
    found = repaired(profile, state)
    assert found.cost < 1.01 * profile.state(x, true).cost < 1e-2 * state.cost
    assert np.abs(found.z - true)[..., line].max() < 1e-2
    others = np.delete(np.abs(found.z - true), line, axis=-1)
    assert others.max() < 1e-2


def test_what_two_lines_lead_to_is_on_a_straight_line(fit):
    _, true = fit
    straight = np.linspace(0.0, 1.0, true.shape[-1]) * (1 + 2j) + np.zeros_like(true)
    led_to = offers(straight)[2:4]
    for offered in led_to:
        assert offered == pytest.approx(straight)


def test_nothing_is_touched_where_nothing_stands_out(fit):
    profile, true = fit
    state = profile.state(np.zeros(len(profile.model.space)), true)
    found = repaired(profile, state)
    assert found.cost <= state.cost
    assert found.z == pytest.approx(true, abs=1e-3)
