"""Effects told by a free function alone: curves made by hand, each from its physics."""

from dataclasses import replace
from unittest.mock import Mock

import numpy as np
import pytest

from flexmodal.diagnosis.lawfree.losses import loss_of
from flexmodal.diagnosis.lawfree.result import Class, Curve, Found, Loss
from flexmodal.diagnosis.lawfree.sighting import Sighting
from flexmodal.diagnosis.lawfree.tells import told_by
from flexmodal.identification import Observations

FREQUENCY = np.linspace(2.0, 200.0, 397)
OMEGA = 2 * np.pi * FREQUENCY
S = 1j * OMEGA
NOISE = 0.01


def found(port, value=None, *classes, where="here", names=("along",), deviation=None):
    curve = None
    if value is not None:
        value = np.atleast_2d(np.asarray(value, dtype=complex) * np.ones(len(OMEGA)))
        spread = np.full(value.shape, NOISE) if deviation is None else np.broadcast_to(deviation, value.shape)
        curve = Curve(FREQUENCY, names, "", value, spread)
    told = tuple(Class(name, name, (), 1.0, 1.0, 0.0) for name in classes)
    return Found(port, where, "", 5.0, ((port, where),), curve, told)


def resonance(mass, frequency, ratio=0.03):
    """Force on a body over the motion of what a mass is sprung to."""
    own = 2 * np.pi * frequency
    spring = own**2 + 2 * ratio * own * S
    return mass * S**2 * spring / (S**2 + spring)


def notch(frequency, depth, ratio=0.2):
    own = 2 * np.pi * frequency
    return np.log((S**2 + 2 * ratio * (1 - depth) * own * S + own**2) / (S**2 + 2 * ratio * own * S + own**2))


@pytest.mark.parametrize(
    ("value", "name"),
    [
        (-1e-3 * S, "time_delay"),
        (5e-4 * S, "time_delay"),  # one that was taken out though there was none
        (-2e-2 * S, "time_delay"),  # the phase goes round several times
        (2 * np.log((1 - 3e-4 * S) / (1 + 3e-4 * S)) / 2, "time_delay"),  # an all-pass
        (np.log(0.8), "sensor_gain"),
        (notch(50.0, 0.99), "sensor_gain"),
        (notch(50.0, -2.0), "sensor_gain"),
        (np.log(S / (S + 2 * np.pi * 8.0)), "sensor_gain"),  # a high-pass
        (-np.log(1 + 1.2e-3 * S), None),  # a low-pass of first order is as much the one as the other
    ],
)
def test_a_sensor_is_late_or_reads_too_much(value, name):
    assert told_by(found("sensor", value)) == name


@pytest.mark.parametrize(
    ("classes", "name"),
    [
        (("low pass and gain",), "time_delay"),
        (("step and gain",), "sensor_gain"),
        (("low pass and gain", "step and gain"), None),  # either will do
        ((), None),
    ],
)
def test_what_is_as_much_the_one_as_the_other_its_class_tells(classes, name):
    assert told_by(found("sensor", -np.log(1 + 1.2e-3 * S), *classes)) == name


BOUNCES = resonance(4.0, 30.0)
STILL = np.zeros_like(OMEGA)


@pytest.mark.parametrize("port", ["body", "ground"])
@pytest.mark.parametrize(
    ("value", "name"),
    [
        (BOUNCES, "local_absorber"),
        (BOUNCES + 2.0 * S**2, "local_absorber"),  # a part of it is firm
        (resonance(1.0, 15.0) + resonance(1.0, 60.0), "local_absorber"),
        (4.0 * S**2, None),  # a mass has its class
        (2e4, None),  # a hose to the world
        (2e4 + 0.5 * S**2, None),  # a heavy one pulls first, and then moves along
        (STILL, None),
    ],
)
def test_a_body_carries_something_resilient(port, value, name):
    deviation = NOISE * OMEGA**2
    assert told_by(found(port, value, deviation=deviation)) == name
    names = ("along", "along × beside", "beside")
    assert (
        told_by(found(port, np.array([STILL, STILL, value + STILL]), names=names, deviation=deviation))
        == name
    )
    across = np.array([STILL, value + STILL, STILL])
    assert told_by(found(port, across, names=names, deviation=deviation)) is None


def test_what_the_data_do_not_tell_is_not_attached():
    assert told_by(found("body", BOUNCES, deviation=1e5 * NOISE * OMEGA**2)) is None


@pytest.mark.parametrize(
    ("port", "classes", "name"),
    [
        ("carried", (), "sensor_mass"),
        ("joint", (), "servo_compliance"),
        ("joint", ("spring",), None),
        ("joint", ("relaxation",), "servo_compliance"),
        ("link", (), "link_flexibility"),
        ("damping", ("relaxation",), "structural_damping"),
        ("coupling", (), None),
        ("coupling", ("spring",), None),
        ("body", ("mass",), "added_mass"),
        ("body", ("mass", "resonance"), None),  # as good as each other
        ("ground", ("mass",), "added_mass"),
        ("body", ("spring",), None),
        ("base", ("spring",), None),
        ("bearing", ("spring",), None),
        ("rod", ("spring",), None),
        ("hammer", (), None),
    ],
)
def test_where_one_effect_only_sits_its_class_or_none_tells_it(port, classes, name):
    assert told_by(found(port, 1.0, *classes)) == name


def test_a_place_without_a_common_function_tells_nothing():
    assert told_by(found("channel")) is None
    assert told_by(found("torque")) is None


@pytest.mark.parametrize(
    ("share", "weaker", "name"),
    [(0.5, 0.7, "coulomb_friction"), (0.05, 0.7, None), (0.5, 0.02, None), (-0.7, 0.3, None)],
)
def test_a_torque_that_takes_energy_rubs(share, weaker, name):
    assert told_by(replace(found("torque"), loss=Loss(share, weaker))) == name


def blows(z, known=1.0, peaks=(20.0, 80.0)):
    """A torque with a function for a weak and a hard blow in each of two postures, of the same size."""
    z = np.asarray(z, dtype=complex)[:, None, None] * np.ones((1, 1, 5))
    posture, level = np.array([0, 0, 1, 1, 0]), np.array([0, 1, 1, 0, 0])
    seen = Mock(spec=Observations, posture=posture, level=level, reference=np.tile([1, 3], (5, 1)))
    seen.peak = peaks.__getitem__
    model = Mock(observations=seen, cells=4, cell=np.array([0, 1, 3, 2, 0]), spans=(slice(0, 1),))
    equations = Mock(zz=np.full((4, 5, 1, 1), known, dtype=complex))
    profile = Mock(model=model, equations=lambda state, held: equations)
    return Mock(spec=Sighting, profile=profile, state=Mock(z=z))


def test_losses_by_hand():
    """A weak blow in the first posture, a hard one, and likewise in the second: 2i less 1i, 4i less 1i."""
    found = loss_of(blows([2j, 1j, 4j, 1j]), 0)
    assert found.share == pytest.approx(1.0)
    assert found.weaker == pytest.approx(1.0)
    found = loss_of(blows([2.0, 1j, 2.0 - 1j, -1j]), 0)
    assert found.share == pytest.approx((1 - 1 - 1) / (2 + 1 + np.sqrt(5) + 1))
    assert found.weaker == pytest.approx((-1 + 0) / (np.sqrt(5) + 2))


def test_without_hard_and_weak_blows_there_is_no_loss():
    assert loss_of(blows([2j, 1j, 4j, 1j], peaks=(20.0, 20.0)), 0) is None
    assert loss_of(blows([2j, 1j, 4j, 1j], known=0.0), 0) is None
