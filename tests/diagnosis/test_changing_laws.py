"""Laws of what changes with the posture or from point to point: against the rig's own, and narrower laws."""

from unittest.mock import Mock

import numpy as np
import pytest

from flexmodal.diagnosis.effects.behind_spring import BEHIND
from flexmodal.diagnosis.effects.effect import Placement
from flexmodal.diagnosis.effects.sensor_sets import SIZES, neighbours
from flexmodal.diagnosis.effects.weight import carried
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.improved.draft import Draft
from flexmodal.diagnosis.placed import Placed
from flexmodal.identification import predict
from flexmodal.rig.forms.fifth_drives import weights
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.structure import robot_space

from .beside_rig import STAYS, carried_by_the_rig, ours, seen_and_simulated, theirs
from .conftest import NEXT, effect_of


@pytest.fixture(scope="module", params=["fanuc_s360", "six_axis"])
def arm(request):
    """A short campaign in two postures with the card's own parameters, and the rig's stand."""
    postures = {"fanuc_s360": ["configuration_1", "configuration_6"], "six_axis": 2}
    return seen_and_simulated(request.param, postures[request.param], points=4)


def test_grain_that_has_settled_is_that_of_the_rig(arm):
    """Half a ball, 3/8 R below the middle of its vessel in every posture; it turns more easily one way."""
    context, observed, stand = arm
    where, radius, mass = context.links[-1], 0.2, 12.0
    values = {
        "mass": mass, "along": 0.7, "beside": 0.05, "gyration": radius * (83 / 320) ** 0.5,
        "sunk": 3 / 8 * radius, "sloshing": 1e-4, "slosh_height": 0.0,
    }  # fmt: skip
    wide = effect_of("added_mass" + NEXT)
    found = ours(context, observed, wide, where, values)
    x, y, z = (wide.physical(context, where, {**values, "above": 0.0})[name] for name in "xyz")
    of_rig = {"mass": mass, "x": x, "y": y, "z": z, "radius": radius}
    other = theirs(observed, stand, "added_mass", where, of_rig, "heap")
    off = np.abs(np.log(np.abs(found / other)))
    fixed = ours(context, observed, wide, where, {**values, "sunk": 0.0})
    away = np.median(np.abs(np.log(np.abs(fixed / other))))
    assert away > 0.05
    assert np.median(off) < (1e-5 if context.normal is not None else 0.1 * away)


@pytest.mark.parametrize("size", SIZES)
def test_sensors_that_move_on_in_sets_are_those_of_the_rig(arm, size):
    context, observed, stand = arm
    level = effect_of("sensor_mass" + NEXT)
    for _ in range(size - 1):
        level = level.next_level.effect
    bare = {"mass": 3.0, "off": 0.0, "gyration": 1e-4}
    found = ours(context, observed, level, "sensor", bare)
    other = carried_by_the_rig(observed, stand, "in_sets", {"mass": 3.0, "together": float(size)})
    np.testing.assert_allclose(found, other, rtol=1e-3)
    alone = ours(context, observed, "sensor_mass", "sensor", {**bare, "cable": 1e-4})
    assert np.abs(np.log(np.abs(alone / other))).max() > 0.05
    assert level.next_level is None or size < SIZES[-1]


def test_neighbours_are_those_listed_beside(arm):
    context, *_ = arm
    ids = [point.id for point in context.points]
    found = neighbours(context, 3)
    assert found[ids[1]] == tuple(ids[:3])
    assert found[ids[3]] == tuple(ids[3:6])
    assert set(found) == set(ids)


def by_posture(context, observed, effect, where, values):
    """Receptances by values of its own in each posture."""
    value = np.zeros_like(observed.value)
    for posture, own in enumerate(values):
        rows = observed.posture == posture
        value[rows] = ours(context, observed, effect, where, own)[rows]
    return value


def test_a_clock_drifts_from_posture_to_posture(arm):
    context, observed, _ = arm
    where, late = context.sensors[0], effect_of("time_delay")
    own = {"delay": 1e-3, "time_constant": 1e-5}
    found = ours(
        context, observed, effect_of("time_delay" + NEXT), where, {**own, "further_time": 1e-6, "drift": 2e-3}
    )
    other = by_posture(context, observed, late, where, [own, {**own, "delay": 3e-3}])
    np.testing.assert_allclose(found, other, rtol=5e-3)


def test_what_a_sensor_reads_grows_from_posture_to_posture(arm):
    context, observed, _ = arm
    where, step = context.sensors[0], {"gain": 0.8, "exponent": 0.0}
    found = ours(context, observed, effect_of("sensor_gain" + NEXT), where, {**step, "drift": 0.4})
    other = ours(context, observed, effect_of("sensor_gain" + NEXT), where, step)
    read = observed.response[:, 0] == context.point(where).id
    grown = np.where(read & (observed.posture == 1), np.exp(0.4), 1.0)
    np.testing.assert_allclose(found, other * grown[:, None], rtol=1e-12)
    assert read.any()
    assert not read.all()


@pytest.mark.parametrize("order", [3, 5])
def test_what_a_sensor_reads_droops_towards_the_bands_end(arm, order):
    """(sinc f/f₀)ᴺ, in phase."""
    context, observed, _ = arm
    where, high, null = context.sensors[0], context.band[1], 2.5
    droop = {"droop": order * (np.pi / null) ** 2 / 6, "droop_null": null}
    found = ours(context, observed, effect_of("sensor_gain" + NEXT), where, {"gain": 1.0, **droop})
    other = ours(context, observed, effect_of("sensor_gain" + NEXT), where, {"gain": 1.0})
    read = (observed.response[:, 0] == context.point(where).id)[:, None]
    lost = np.sinc(observed.axis.frequency / (null * high)) ** order
    np.testing.assert_allclose(found, other * np.where(read, lost, 1.0), rtol=1e-9)


def test_a_sensor_comes_loose_from_posture_to_posture(arm):
    context, observed, _ = arm
    where, name = context.sensors[-1], "angle" if context.normal is not None else "angle_x"
    wide, last = effect_of("sensor_misalignment" + NEXT), {name: 0.6}
    found = ours(context, observed, wide, where, {**last, "loosens": 0.75})
    other = by_posture(context, observed, wide, where, [{name: 0.15}, last])
    np.testing.assert_allclose(found, other, rtol=1e-9)


def test_what_joints_carry_is_what_the_rig_has_them_carry(arm):
    context, _, stand = arm
    found = carried(context)
    for number, posture in enumerate(context.postures):
        rig = weights(PlantAssembly(stand.robot.at(dict(posture.q))), stand)
        for joint, load in found.items():
            assert load[number] == pytest.approx(abs(rig[joint]) / most(context, stand), rel=1e-6, abs=1e-9)


def most(context, stand):
    standing = [PlantAssembly(stand.robot.at(dict(posture.q))) for posture in context.postures]
    return max(abs(torque) for one in standing for torque in weights(one, stand).values())


@pytest.mark.parametrize("by", [-3.0, 2.0])
def test_joints_lose_by_the_weight_that_they_carry(arm, by):
    """As with a ratio of its own for each joint, another one in each posture."""
    context, observed, _ = arm
    wide, own = effect_of("structural_damping" + NEXT), {"loss_factor": 0.1, "viscous": 1.0, **STAYS}
    found = ours(context, observed, wide, "joints", {**own, "by_load": by})
    loads = carried(context)
    ratios = [
        {
            f"loss_ratio_{joint}": 1 + by * load[number] if by > 0 else 1 / (1 - by * load[number])
            for joint, load in loads.items()
        }
        for number in range(len(context.postures))
    ]
    other = by_posture(context, observed, wide, "joints", [{**own, **one} for one in ratios])
    np.testing.assert_allclose(found, other, rtol=1e-9)


def test_a_belt_over_a_roller_on_a_spring_is_that_of_the_rig(arm):
    """And in the files as while it is slow."""
    context, observed, stand = arm
    where, belt = "q1+q3", 2e5
    values = {
        "belt_stiffness": belt, "belt_ratio": -0.7, "tightness": 0.8, "roller_frequency": 30.0,
        "roller_damping_ratio": 0.05,
    }  # fmt: skip
    law = effect_of("joint_coupling" + 3 * NEXT)
    found = ours(context, observed, law, where, values)
    of_rig = {"stiffness": belt, "ratio": -0.7, "tightness": 0.8, "frequency": 30.0, "damping_ratio": 0.05}
    other = theirs(observed, stand, "joint_coupling", where, of_rig, "tensioner")
    np.testing.assert_allclose(found, other, rtol=1e-6, atol=1e-9 * np.abs(other).max())
    stiff = ours(context, observed, law, where, {**values, "tightness": 100.0})
    assert np.abs(np.log(np.abs(stiff / other))).max() > 0.1
    draft = Mock(spec=Draft, notes=[])
    law.extend(draft, Placement.still(context, where, values))
    still = belt * 0.8 / 1.8
    assert draft.couple.call_args.args == ("q1", "q3", pytest.approx(0.7 * still))
    assert [one.args for one in draft.stiffen.call_args_list] == [
        ("q1", pytest.approx(still)), ("q3", pytest.approx(0.49 * still)),
    ]  # fmt: skip
    assert "lack its roller, 30 Hz" in draft.notes[0]


def test_a_spring_behind_the_joints_own_sets_out_from_the_card(arm):
    """Whatever a fit without it made of the joint."""
    context, observed, _ = arm
    joint = context.joints[0]
    hypothesis = Hypothesis(context, robot_space(context.robot)).and_also(Placed(BEHIND, joint))
    before = np.full(len(hypothesis.base), 0.3)
    given = effect_of("nonlinear_stiffness" + NEXT + NEXT).next_level.starts(context, joint, {})[0]
    x = hypothesis.start(hypothesis.placed[-1], given, before)
    values = hypothesis.space.values(x)
    for kind in ("stiffness", "damping"):
        assert values[f"{kind}.{joint}"] == pytest.approx(getattr(context.robot.joints[joint], kind))
    assert np.isfinite(predict(hypothesis, x, observed)).all()
    others = [k for k, name in enumerate(hypothesis.base.names) if not name.endswith(f".{joint}")]
    np.testing.assert_array_equal(x[others], 0.3)
