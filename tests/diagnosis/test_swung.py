"""Joints swung steadily to and fro, against closed forms."""

from unittest.mock import Mock

import numpy as np
import pytest

from flexmodal.diagnosis.effects.friction_felt import dahl, levelling
from flexmodal.diagnosis.effects.nonlinear_stiffness import hardened
from flexmodal.diagnosis.effects.swing import largest
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.joint_laws import joint_laws
from flexmodal.diagnosis.outcome import Diagnosis
from flexmodal.diagnosis.placed import Placed
from flexmodal.diagnosis.report.joint_pictures import draw_swing, joint_parts
from flexmodal.diagnosis.time_domain.law import friction, hardening, knee, slow_friction
from flexmodal.diagnosis.time_domain.swung import swung
from flexmodal.structure import robot_space

from .conftest import NEXT, effect_of

ROW = np.ones(1)
K, OMEGA = 9e3, 120.0
AMPLITUDE = np.array([2e-4, 1e-3, 4e-3])


def test_a_straight_spring_is_as_stiff_in_every_swing_and_loses_nothing():
    found = swung([], K, AMPLITUDE, OMEGA)
    np.testing.assert_allclose(found.stiffness, K, rtol=1e-12)
    np.testing.assert_allclose(found.loss_factor, 0.0, atol=1e-12)
    np.testing.assert_allclose(found.torque, K * found.deflection)
    np.testing.assert_allclose(np.abs(found.deflection).max(axis=1), AMPLITUDE)


def test_a_spring_that_hardens_has_its_describing_function():
    found = swung([hardening(ROW, 6e3, 2e-3)], K, AMPLITUDE, OMEGA)
    np.testing.assert_allclose(found.stiffness, K + 6e3 * hardened(AMPLITUDE / 2e-3), rtol=1e-4)
    np.testing.assert_allclose(found.loss_factor, 0.0, atol=1e-10)


def test_a_stop_is_nothing_before_its_deflection():
    found = swung([knee(ROW, 5e3, 2e-3, 0.01, 0.0, K)], K, AMPLITUDE, OMEGA)
    np.testing.assert_allclose(found.stiffness[:2], K, rtol=1e-3)
    far = found.deflection[2].max()
    assert found.torque[2].max() == pytest.approx(K * far + 5e3 * (far - 2e-3), rel=1e-3)


def test_friction_has_dahls_loop():
    found = swung([friction(ROW, 3.0, 3e4)], K, AMPLITUDE, OMEGA)
    stiffness, loss = dahl(AMPLITUDE, 3.0, 3e4)
    np.testing.assert_allclose(found.stiffness, K + stiffness, rtol=3e-3)
    np.testing.assert_allclose(found.loss_factor, loss / (K + stiffness), rtol=0.02, atol=1e-4)
    area = -np.trapezoid(found.deflection, found.torque)
    np.testing.assert_allclose(np.abs(area), np.pi * loss * AMPLITUDE**2, rtol=0.02)


def test_bristles_that_stick_and_damp_are_a_spring_with_a_damper():
    found = swung([friction(ROW, 1e6, 3e4, lag=1e-3)], K, AMPLITUDE, OMEGA)
    np.testing.assert_allclose(found.stiffness, K + 3e4, rtol=2e-3)
    np.testing.assert_allclose(found.loss_factor, 3e4 * OMEGA * 1e-3 / (K + 3e4), rtol=0.02)


def test_slow_friction_goes_by_the_speed():
    found = swung([slow_friction(ROW, 1.5, 0.3)], K, AMPLITUDE, OMEGA)
    damping = levelling(OMEGA * AMPLITUDE, 1.5, 0.3)
    np.testing.assert_allclose(found.loss_factor, OMEGA * damping / K, rtol=1e-3)


@pytest.mark.parametrize(
    ("name", "softer"),
    [
        ("coulomb_friction", None),
        ("coulomb_friction" + NEXT, None),
        ("nonlinear_stiffness" + NEXT, None),
        ("nonlinear_stiffness" + NEXT + NEXT, None),
        ("nonlinear_stiffness" + NEXT + NEXT + NEXT, 0.5),
    ],
)
def test_a_report_tells_what_was_found_in_a_joint(context, name, softer):
    joint = context.joints[0]
    robot = Hypothesis(context, robot_space(context.robot))
    model = robot.and_also(Placed(effect_of("added_mass"), context.links[-1])).and_also(
        Placed(effect_of(name), joint)
    )
    diagnosis = Mock(spec=Diagnosis, model=model, x=np.zeros(len(model.space)))
    ((key, swing),) = joint_laws(diagnosis)
    assert key == (name.partition(NEXT)[0], joint)
    own, most = context.robot.joints[joint].stiffness, largest(context, joint)
    if softer is None:
        assert (swing.straight, swing.amplitude[-1]) == pytest.approx((own, most))
    else:  # a spring behind, which takes a third of a swing that is farther by the root of 1.5
        assert (swing.straight, swing.amplitude[-1]) == pytest.approx((own / softer, most * 1.5**0.5 / 3))
    assert np.isfinite(swing.torque).all()
    assert (swing.loss_factor.max() > 0.01) == name.startswith("coulomb")
    figure = draw_swing(swing, "a joint")
    assert [axes.get_ylabel() for axes in figure.axes] == [
        "Torque [N·m]",
        "Stiffness\n[N·m/rad]",
        "Loss factor [–]",
    ]
    assert len(joint_parts(diagnosis)) == 2
    assert joint_parts(Mock(spec=Diagnosis, model=robot, x=np.zeros(len(robot.space)))) == []
