"""State-space models against the receptance they are of, and what python-control and scipy make of them."""

from pathlib import Path

import control
import numpy as np
import pytest
import scipy.signal

import flexmodal
from flexmodal.errors import InvalidRequest

ROOT = Path(__file__).parents[2]

FREQUENCY = np.linspace(0.5, 120.0, 60)


@pytest.fixture(scope="module")
def posed():
    return flexmodal.load("six_axis").at("work")


def _far(found, wanted):
    return np.max(np.abs(found - wanted)) / np.max(np.abs(wanted))


@pytest.mark.parametrize("form", ["receptance", "mobility", "inertance"])
def test_neighbours_give_the_same_frf(posed, form):
    asked = {"response": ["tool:+x", "tool:+z"], "reference": ["tool:+z", "wrist:+y"], "form": form}
    wanted = posed.frf(FREQUENCY, **asked).value
    model = posed.to_ss(**asked)
    assert _far(model.response(FREQUENCY), wanted) < 1e-11
    theirs = model.to_control()
    assert theirs.input_labels == ["tool:+z", "wrist:+y"]
    answer = theirs(2j * np.pi * FREQUENCY, squeeze=False)
    assert _far(np.moveaxis(answer, -1, 0), wanted) < 1e-10


def test_scipy_gives_the_same_impulse_response(posed):
    """Against the modal sum over time; by its frequency responses scipy goes through a polynomial."""
    model = posed.to_ss(response="tool:+z")
    time = np.linspace(0.0, 0.5, 400)
    _, answer = scipy.signal.impulse(model.to_scipy(), T=time)
    poles, shapes = posed.modes().expanded()
    seen = posed.rows(posed.directions("tool:+z")) @ shapes
    wanted = np.sum(seen[0] ** 2 * np.exp(np.outer(time, poles)), axis=1).real
    assert _far(np.squeeze(answer), wanted) < 1e-9


def test_neighbours_find_the_same_poles(posed):
    modes = posed.modes()
    poles = np.sort_complex(control.poles(posed.to_ss().to_control()))
    assert poles == pytest.approx(np.sort_complex(modes.expanded()[0]), rel=1e-10)
    frequency, _, _ = control.damp(posed.to_ss().to_control(), doprint=False)
    assert np.unique(np.round(frequency / (2 * np.pi), 8)) == pytest.approx(modes.frequency, rel=1e-8)


def test_all_modes_are_the_whole_and_the_first_are_most_of_it(posed):
    asked = {"response": ["tool:+x", "tool:+z"]}
    wanted = posed.frf(FREQUENCY, **asked).value
    assert _far(posed.modal_ss(**asked).response(FREQUENCY), wanted) < 1e-11
    low = FREQUENCY < 15
    some = posed.modal_ss(**asked, keep=3)
    assert len(some.A) == 6
    assert _far(some.response(FREQUENCY[low]), wanted[low]) < 0.2


def test_overdamped_poles_have_one_state_each(tmp_path):
    robot = flexmodal.load("ur5", stiffness=100.0, damping=1e4)
    posed = robot.at(dict.fromkeys(robot.commanded, 0.4))
    model = posed.modal_ss(response=["tool:+x", "tool:+z"])
    wanted = posed.frf([0.001, 0.01, 1.0], response=["tool:+x", "tool:+z"]).value
    assert np.all(posed.modes().overdamped)
    assert _far(model.response(np.array([0.001, 0.01, 1.0])), wanted) < 1e-8


def test_a_loss_factor_has_no_state_space(posed):
    from dataclasses import replace

    joints = {name: replace(joint, loss_factor=0.02) for name, joint in posed.robot.joints.items()}
    lossy = replace(posed.robot, joints=joints)
    with pytest.raises(InvalidRequest, match="loss factor"):
        lossy.at("work").to_ss()


def test_measured_modes_as_a_model():
    measured = flexmodal.read_campaign(ROOT / "tests/data/real/laboratory_hammer/frf.uff")
    (fit,) = flexmodal.fit(measured, per="posture")
    model = fit.to_ss()
    s = 2j * np.pi * FREQUENCY
    wanted = sum(
        mode.residue / (s - mode.pole) + mode.residue.conj() / (s - np.conj(mode.pole)) for mode in fit.modes
    )
    assert _far(model.response(FREQUENCY)[:, 0, 0], wanted) < 1e-12
    assert model.to_control().ninputs == 1
