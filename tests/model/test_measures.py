import numpy as np
import pytest
from scipy.linalg import null_space

import flexmodal
from flexmodal.errors import InvalidFrequencies, InvalidPoint, InvalidRequest
from flexmodal.model.measures import stiffness_measure

from .writing import planar


def jacobian_and_direction(posed, direction, rows):
    point, axis = direction.split(":")
    along = np.zeros(6)
    along[["x", "y", "z", "rx", "ry", "rz"].index(axis[1:])] = -1.0 if axis[0] == "-" else 1.0
    return posed.jacobian(point)[rows], along[rows], along @ posed.jacobian(point)


PLANAR, POSITION = [0, 2, 4], [0, 2]


@pytest.mark.parametrize("direction", ["tool:+z", "tool:-x", "joint_5:+z", "tip:+ry"])
@pytest.mark.parametrize("posture", ["start_1", "start_3", "f2_final"])
def test_formulas(arm, posture, direction):
    posed = arm.at(posture)
    found = arm.measures(posture, direction=direction)
    jacobian, along, row = jacobian_and_direction(posed, direction, PLANAR)
    stiffness = np.diag([joint.stiffness for joint in arm.joints.values()])
    # J has full row rank here: J⁺ = Jᵀ(JJᵀ)⁻¹, whose condition costs some digits
    inverse = jacobian.T @ np.linalg.inv(jacobian @ jacobian.T)
    expected = along @ inverse.T @ stiffness @ inverse @ along
    assert found.stiffness == pytest.approx(expected, rel=1e-10)
    assert found.mobility == pytest.approx(row @ row, rel=1e-13)
    assert found.static_receptance == pytest.approx(np.sum(row**2 / np.diag(stiffness)), rel=1e-13)
    assert (found.frequency, found.receptance) == (None, None)
    np.testing.assert_array_equal(found.tool, posed.position("tool"))


def test_position_alone(arm):
    posed = arm.at("start_2")
    jacobian, along, _ = jacobian_and_direction(posed, "tool:+z", POSITION)
    inverse = np.linalg.pinv(jacobian)
    expected = along @ inverse.T @ arm.stiffness @ inverse @ along
    assert arm.measures("start_2", task="position").stiffness == pytest.approx(expected, rel=1e-12)
    assert arm.measures("start_2", task="full").stiffness > expected


def test_spatial(ur5):
    posture = {"shoulder_lift_joint": -1.0, "elbow_joint": 1.2, "wrist_1_joint": 0.4, "wrist_2_joint": 0.9}
    posed = ur5.at(posture)
    for task, rows in (("full", range(6)), ("position", range(3))):
        jacobian, along, _ = jacobian_and_direction(posed, "tool0:+x", list(rows))
        inverse = np.linalg.pinv(jacobian)
        expected = along @ inverse.T @ ur5.stiffness @ inverse @ along
        found = ur5.measures(posture, direction="tool0:+x", task=task).stiffness
        assert found == pytest.approx(expected, rel=1e-12)


def test_the_stiffness_measure_is_what_it_says(arm):
    """Of all deflections that move the tool by u alone, J⁺u is the shortest; ξ_K is twice its energy."""
    posed = arm.at("start_2")
    jacobian, along, _ = jacobian_and_direction(posed, "tool:+z", PLANAR)
    deflection = np.linalg.lstsq(jacobian, along, rcond=None)[0]
    np.testing.assert_allclose(jacobian @ deflection, along, atol=1e-13)
    assert np.max(np.abs(null_space(jacobian).T @ deflection)) < 1e-13
    found = stiffness_measure(jacobian, arm.stiffness, along)
    assert found == pytest.approx(deflection @ arm.stiffness @ deflection, rel=1e-12)


def test_one_lever_on_paper(tmp_path):
    """A single joint of stiffness k, lever l: ξ_M = l², static receptance l²/k; ξ_K of a crank."""
    robot = flexmodal.load(planar(tmp_path / "one.urdf", [0.8], [5.0], [0.2], [0.35]), stiffness=3e4)
    measures = robot.measures({"q1": 0.0})
    assert measures.mobility == pytest.approx(0.64, rel=1e-14)
    assert measures.static_receptance == pytest.approx(0.64 / 3e4, rel=1e-14)
    # J = (0, l, −1)ᵀ, so J⁺ = (0, l, −1) / (l² + 1)
    assert measures.stiffness == pytest.approx(3e4 * (0.8 / 1.64) ** 2, rel=1e-13)
    assert robot.measures({"q1": 0.0}, task="position").stiffness == pytest.approx(3e4 / 0.64, rel=1e-13)


def test_dynamic_receptance(fanuc):
    found = fanuc.measures("configuration_2", direction="location_3:+z", frequency=8.0)
    expected = fanuc.frf("configuration_2", [8.0], response="location_3:+z").value[0, 0, 0]
    assert (found.frequency, found.receptance) == (8.0, expected)
    static = fanuc.measures("configuration_2", frequency=0.0)
    assert static.receptance.imag == 0
    assert static.receptance == pytest.approx(static.static_receptance, rel=1e-13)


def test_bad_arguments(fanuc):
    with pytest.raises(InvalidRequest, match="full or position"):
        fanuc.measures("configuration_1", task="angles")
    with pytest.raises(InvalidFrequencies):
        fanuc.measures("configuration_1", frequency=-1.0)
    with pytest.raises(InvalidPoint):
        fanuc.measures("configuration_1", direction="hand:+z")
