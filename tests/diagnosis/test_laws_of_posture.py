"""Laws of what is otherwise in each posture, or along each axis: a spring under weight, a knock, a skew."""

import numpy as np
import pytest

from flexmodal.diagnosis.effects.effect import Placement
from flexmodal.diagnosis.effects.under_weight import UNDER_WEIGHT
from flexmodal.diagnosis.effects.weight import moments
from flexmodal.diagnosis.time_domain.law import loaded_knee
from flexmodal.rig.forms.fifth_drives import weights
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.structure.assembly import Assembly
from flexmodal.structure.structure import Axis

from .beside_rig import ours, seen_and_simulated
from .conftest import NEXT, effect_of, known


@pytest.fixture(scope="module", params=["fanuc_s360", "six_axis"])
def arm(request):
    """A short campaign with the card's own parameters, and the rig's stand."""
    return seen_and_simulated(request.param, 3, points=4)


def torque(law, q):
    """Beyond the linear spring, from the point of rest: the formula of the module, by itself."""
    top, bend, wound, linear, over, *_ = law.parameters

    def at(u):
        return top * u * (1 - 2 * bend / (np.hypot(u - bend, over) + np.hypot(u + bend, over)))

    return at(wound + q) - at(wound) + linear * q


def in_each_posture(context, where, values):
    count, none = len(context.postures), np.zeros(len(context.postures), dtype=int)
    ends = np.zeros((count, 2), dtype=int)
    return Placement(context, where, values, np.arange(count), none, ends, ends)


def test_the_weight_winds_a_spring_up_as_in_the_rig(arm):
    """T(q + q₀) − T(q₀) in each posture, q₀ by the torque that holds up the weight."""
    context, observed, stand = arm
    where = UNDER_WEIGHT.places(context)[0]
    values = {"change": 0.8, "deflection": 1e-4, "wound": 0.0, "softness": 0.5, "by_weight": -1.5}
    placement = in_each_posture(context, where, values)
    (law,) = UNDER_WEIGHT.law(Assembly(context.stacked), placement)
    every = [PlantAssembly(stand.robot.at(dict(posture.q))) for posture in observed.postures]
    pulled = np.array([weights(one, stand)[where] for one in every])
    assert np.ptp(pulled) > 0.1 * np.abs(pulled).max()
    stiffness = context.robot.joints[where].stiffness
    q = np.linspace(-3e-4, 3e-4, 7)
    for number, part in enumerate(pulled / np.abs(pulled).max()):
        own = law.of_system(number)
        assert own.wound is None
        assert own.parameters[2] == pytest.approx(-1.5e-4 * part)
        plain = loaded_knee(law.row, 0.8 * stiffness, 1e-4, 0.5, np.zeros(1)).of_system(0)
        rest = own.parameters[2]
        np.testing.assert_allclose(torque(own, q), torque(plain, q + rest) - torque(plain, rest), atol=1e-9)


def test_where_nothing_winds_it_up_it_is_the_spring_that_is_not(arm):
    """The knee of the law before, whose stiffness at rest is that at no load then."""
    context, observed, _ = arm
    where = UNDER_WEIGHT.places(context)[0]
    knee = {"change": 0.8, "deflection": 1e-4, "wound": 0.0, "softness": 0.5}
    found = ours(context, observed, UNDER_WEIGHT, where, {**knee, "by_weight": 0.0})
    curve = ours(context, observed, "nonlinear_stiffness" + NEXT, where, {**knee, "cubic": 0.0, "load": 0.0})
    np.testing.assert_allclose(found, curve, rtol=1e-9)
    loaded = ours(context, observed, UNDER_WEIGHT, where, {**knee, "by_weight": 2.0})
    assert np.abs(np.log(np.abs(found / loaded))).max() > 0.01


def test_a_joint_that_holds_no_weight_has_no_such_spring():
    """One that turns about the upright axis."""
    context, _, _ = seen_and_simulated("six_axis", 2, points=3)
    upright = [joint for joint in context.joints if np.abs(moments(context)[joint]).max() < 1e-6]
    assert len(upright) == 1
    assert set(UNDER_WEIGHT.places(context)) == set(context.joints) - set(upright)


@pytest.mark.parametrize(("second", "third"), [(0.0, 0.0), (3e-4, 1e-3)])
def test_a_converter_takes_one_axis_after_the_other(arm, second, third):
    """Each reads by exp(−iωτ) of its own τ, and the first as without."""
    context, observed, _ = arm
    law = "time_delay" + NEXT
    where = next(one for one in context.sensors if (observed.response[:, 0] == context.point(one).id).any())
    late = ours(context, observed, law, where, {"delay": 5e-4, "second_later": second, "third_later": third})
    plain = ours(context, observed, law, where, {"delay": 5e-4})
    omega = 2 * np.pi * observed.axis.frequency
    here = observed.response[:, 0] == context.point(where).id
    skew = np.array([0.0, second, third])[observed.response[:, 1] - 1] * here
    np.testing.assert_allclose(late / plain, np.exp(-1j * np.outer(skew, omega)), atol=1e-6)


@pytest.mark.parametrize("since", [-0.1, 0.25, 0.75])
def test_a_knock_turns_a_sensor_from_a_posture_on(arm, since):
    """Before it nothing, and afterwards all of the turn."""
    context, observed, _ = arm
    law, where = "sensor_misalignment" + NEXT, context.sensors[0]
    turn = {"angle": 0.4} if context.normal is not None else {"angle_x": 0.2, "angle_z": -0.3}
    knocked = ours(context, observed, law, where, {**turn, "knocked": since})
    always, never = (ours(context, observed, law, where, one) for one in (turn, {}))
    after = np.array([0.0, 0.5, 1.0])[observed.posture] >= since
    np.testing.assert_allclose(knocked, np.where(after[:, None], always, never), rtol=1e-12)


def test_all_three_are_beyond_laws_that_know_nothing_of_posture_and_axis():
    assert effect_of("nonlinear_stiffness" + NEXT + NEXT).law is UNDER_WEIGHT.law
    for name, more in (("time_delay", "second_later"), ("sensor_misalignment", "knocked")):
        context, _, _ = seen_and_simulated("fanuc_s360", 2, points=3)
        where = context.sensors[0]
        narrow, wide = (
            [one.name for one in effect.parameters(context, where)]
            for effect in (known()[name], effect_of(name + NEXT))
        )
        assert more in set(wide) - set(narrow)


def test_lags_of_axes_are_those_of_the_axis_that_was_read(arm):
    """Of the effect alone, as `Axis` has its frequencies."""
    context, observed, _ = arm
    law, where = effect_of("time_delay" + NEXT), context.sensors[0]
    values = {one.name: one.value(0.0) for one in law.parameters(context, where)}
    axis, none = Axis(observed.axis.frequency, observed.axis.middle), np.zeros(3, dtype=int)
    read = np.array([[1, 1], [1, 2], [1, 3]])
    late = {**values, "second_later": 1e-3, "third_later": -2e-3}
    found = law.read(Placement(context, where, late, none, none, np.zeros((3, 2), dtype=int), read), axis)
    np.testing.assert_allclose(
        found - found[0], -np.outer([0.0, 1e-3, -2e-3], 2j * np.pi * observed.axis.frequency), atol=1e-12
    )
