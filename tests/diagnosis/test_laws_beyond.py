"""Laws of a bell that warms, a battery, pads, nested shafts, a held tool and a swivel: those of the rig."""

from unittest.mock import Mock

import numpy as np
import pytest

from flexmodal.diagnosis.effects.absorber_ways import directions
from flexmodal.diagnosis.effects.added_mass import place_on
from flexmodal.diagnosis.effects.bearing import frame_of, ways
from flexmodal.diagnosis.effects.dry_friction import beside
from flexmodal.diagnosis.effects.effect import Placement, along, sides
from flexmodal.diagnosis.effects.free_function import FreeFunction
from flexmodal.diagnosis.effects.held_tool import HELD_TOOL, stiffness_of
from flexmodal.diagnosis.effects.swivel import SWIVEL
from flexmodal.diagnosis.improved.draft import Draft
from flexmodal.model.placements import link_placements
from flexmodal.rig.effects.bearing_flexibility import frame
from flexmodal.rig.forms.sixth_joints import load_on
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.plant.geometry import across
from flexmodal.structure.assembly import Assembly
from flexmodal.structure.structure import Axis

from .beside_rig import carried_by_the_rig, ours, seen_and_simulated, theirs
from .conftest import NEXT, effect_of


@pytest.fixture(scope="module", params=["fanuc_s360", "six_axis"])
def arm(request):
    """A short campaign in two postures with the card's own parameters, and the rig's stand."""
    postures = {"fanuc_s360": ["configuration_1", "configuration_6"], "six_axis": 2}
    return seen_and_simulated(request.param, postures[request.param], points=4)


def off(found, other):
    return np.abs(np.log(np.abs(found / other)))


def test_pads_that_stay_are_those_of_the_rig(arm):
    context, observed, stand = arm
    rigid = {"mount_frequency": 300 * context.band[1], "cable_frequency": 1e-3, "line_mass": 1e-5}
    bare = {"mass": 2.0, "off": 0.0, "gyration": 1e-4, "cable": 1e-4, "firm": 1e-5, **rigid}
    found = ours(context, observed, "sensor_mass" + NEXT, "sensor", {**bare, "pads": 0.4})
    other = carried_by_the_rig(observed, stand, "pads", {"mass": 2.0, "pad_mass": 0.8})
    np.testing.assert_allclose(found, other, rtol=3e-3)
    alone = ours(context, observed, "sensor_mass" + NEXT, "sensor", {**bare, "pads": 1e-7})
    assert off(alone, other).max() > 0.05


def test_what_holds_the_tool_is_that_of_the_rig(arm):
    """And in the files as in the mean of the postures."""
    context, observed, stand = arm
    joints = list(context.joints)
    where = f"{joints[0]}+{joints[-1]}"
    size = stiffness_of(context, where)
    values = {"held_stiffness": size, "held_damping_time": 5e-4, "elevation": 0.6}
    values |= {"bearing": -0.7} if context.normal is None else {}
    found = ours(context, observed, HELD_TOOL, where, values)
    level = np.array([np.cos(-0.7), np.sin(-0.7), 0.0])
    if context.normal is not None:
        level = np.cross(context.normal, [0.0, 0.0, 1.0])
    way = np.cos(0.6) * level + np.sin(0.6) * np.array([0.0, 0.0, 1.0])
    of_rig = {"stiffness": size, "damping_time": 5e-4, **dict(zip(("dx", "dy", "dz"), way, strict=True))}
    other = theirs(observed, stand, "joint_coupling", where, of_rig, "tool_held")
    np.testing.assert_allclose(found, other, rtol=1e-6, atol=1e-9 * np.abs(other).max())
    soft = {**values, "held_stiffness": 1e-3 * stiffness_of(context, where)}
    soft = ours(context, observed, HELD_TOOL, where, soft)
    assert off(soft, other).max() > 0.1
    draft = Mock(spec=Draft, notes=[])
    HELD_TOOL.extend(draft, Placement.still(context, where, values))
    (one, first), (last, second) = [each.args for each in draft.stiffen.call_args_list]
    a, b, between = draft.couple.call_args.args
    assert (one, last) == (a, b) == (joints[0], joints[-1])
    assert first > 0 < second
    assert abs(between) <= np.sqrt(first * second)  # less, as its ratio changes


def test_it_sets_out_from_what_a_port_tells(arm):
    context, *_ = arm
    where, frequency = "+".join(list(context.joints)[:2]), np.linspace(*context.band, 30)
    free = FreeFunction(frequency, np.full((1, 30), 2e5 + 1e3j), {"elevation": 0.3}, np.zeros(3))
    assert HELD_TOOL.told(context, where, free) == [{"elevation": 0.3, "held_stiffness": 2e5}]
    crank = FreeFunction(frequency, free.value, {"near_x": 0.1}, np.zeros(3))
    assert not HELD_TOOL.told(context, where, crank)


def test_a_swivel_is_that_of_the_rig(arm):
    """A thin bar: as much moment about the direction across it in which it is firm."""
    context, observed, stand = arm
    where = context.links[-2]
    values = {
        "mass": 9.0, "gyration": 0.3, "frequency": 33.0, "damping_ratio": 0.04, "along": 0.6, "beside": 0.05,
    }  # fmt: skip
    if context.normal is None:
        bar = np.array([0.2, 0.5, -0.8]) / np.linalg.norm([0.2, 0.5, -0.8])
        second = across(bar, None)[0]
        turned = turned_to(context, where, np.cross(bar, second), second)
        values |= {"above": -0.03, "firm": 1.0, **turned}
    else:
        bar = directions(context, where, {"angle": 0.4})[0]
    found = ours(context, observed, SWIVEL, where, values)
    place = dict(zip("xyz", place_on(context, where, values).tolist(), strict=True))
    of_rig = {
        **{name: values[name] for name in ("mass", "frequency", "damping_ratio")}, **place,
        **dict(zip(("dx", "dy", "dz"), bar.tolist(), strict=True)), "long": 0.3 * 12**0.5,
    }  # fmt: skip
    other = theirs(observed, stand, "local_absorber", where, of_rig, "swivel")
    still = ours(context, observed, SWIVEL, where, {**values, "gyration": 1e-3})
    assert off(still, other).max() > 0.1
    np.testing.assert_allclose(found, other, rtol=1e-5, atol=1e-8 * np.abs(other).max())
    if context.normal is None:
        told = SWIVEL.physical(context, where, values)
        axis = np.cross(bar, second)
        np.testing.assert_allclose([told[name] for name in ("dx", "dy", "dz")], axis, atol=1e-12)


def turned_to(context, where, first, second):
    """Angles at which the directions of something attached are these."""
    _, axis = along(context, where)
    basis = np.array([axis, *sides(context, where, axis)])
    out, side, upright = basis @ first
    angles = {"angle": float(np.arcsin(out)), "turn": float(np.arctan2(upright, side)), "roll": 0.0}
    _, level, above = directions(context, where, angles)
    return {**angles, "roll": float(np.arctan2(second @ above, second @ level))}


def test_what_rubs_between_two_shafts_is_along_one_less_the_other(arm):
    context, *_ = arm
    law = effect_of("coulomb_friction" + 2 * NEXT)
    joints, assembly = list(context.joints), Assembly(context.arms[0])
    for where, other in ((joints[0], joints[1]), (joints[-1], joints[-2])):
        assert beside(context, where) == other
        values = {one.name: one.value(0.0) for one in law.parameters(context, where)} | {"nested": 0.6}
        first, *_ = law.law(assembly, Placement.still(context, where, values))
        expected = assembly.stretch_of(where) - 0.6 * assembly.stretch_of(other)
        np.testing.assert_allclose(np.ravel(first.row), np.ravel(expected))
    assert set(law.places(context)) == set(joints)


def test_grease_that_warms_relaxes_faster_from_posture_to_posture(arm):
    """As with a time of its own in each; of a bell that is narrow three elements are one."""
    context, observed, _ = arm
    wide, bell = effect_of("structural_damping" + NEXT), effect_of("structural_damping" + 2 * NEXT)
    own = {"loss_factor": 0.01, "viscous": 1.0, "relaxing": 0.2}
    found = ours(context, observed, wide, "joints", {**own, "relaxation_time": 0.01, "warming": 4.0})
    value = np.zeros_like(found)
    for posture, time in enumerate((0.01, 0.0025)):
        rows = observed.posture == posture
        value[rows] = ours(context, observed, wide, "joints", {**own, "relaxation_time": time})[rows]
    np.testing.assert_allclose(found, value, rtol=1e-9)
    narrow = {**own, "relaxation_time": 0.01, "warming": 4.0, "relaxation_width": 0.01}
    np.testing.assert_allclose(ours(context, observed, bell, "joints", narrow), found, rtol=1e-3)
    broad = ours(context, observed, bell, "joints", {**narrow, "relaxation_width": 1.5})
    assert off(broad, found).max() > 0.02


def test_a_battery_runs_down_ever_faster(arm):
    """By a power of how much of the campaign is over."""
    context, observed, _ = arm
    law, where = effect_of("sensor_gain" + NEXT), context.sensors[0]
    values = {one.name: one.value(0.0) for one in law.parameters(context, where)}
    axis, count = Axis(observed.axis.frequency, observed.axis.middle), len(context.postures)
    for bend in (1.0, 2.5):
        placement = Placement(
            context, where, {**values, "drift": -0.6, "drift_bend": bend}, np.arange(count),
            np.zeros(count, dtype=int), *np.zeros((2, count, 2), dtype=int),
        )  # fmt: skip
        read = law.read(placement, axis)
        expected = -0.6 * (np.arange(count) / (count - 1)) ** bend
        np.testing.assert_allclose((read - read[0]).real, np.outer(expected, np.ones(len(axis))), atol=1e-12)


def test_a_bearing_that_carries_more_is_stiffer_as_that_of_the_rig(arm):
    """Whose angles are counted from another direction across the joint's axis."""
    context, observed, stand = arm
    where = context.joints[1]
    law, shift = effect_of("bearing_flexibility" + NEXT), 4e6
    values = {one.name: one.value(0.0) for one in law.parameters(context, where)}
    springs = {"radial_stiffness": shift, "damping_time": 3e-4, "relaxing": 1e-8, "ratio": 1.0}
    springs |= {"tilt_stiffness": 2e5, "axial_stiffness": 2 * shift} if context.normal is None else {}
    loads = {"loaded": 20.0, "tooth_radius": 0.09, "tooth_angle": 0.7}
    values = {**{name: one for name, one in values.items() if name == "offset"}, **springs, **loads}
    found = ours(context, observed, law, where, values)
    from_rigs = turned_from_the_rigs(context, stand, where)
    assemblies = [PlantAssembly(stand.robot.at(dict(posture.q))) for posture in observed.postures]
    mesh = 0.7 - from_rigs
    most = max(load_on(one, stand, where, 0.09, mesh) for one in assemblies)
    own = {
        "radial_stiffness": shift,
        "damping_time": 3e-4,
        "tilt_stiffness": 2e5,
        "axial_stiffness": 2 * shift,
    }
    of_rig = {**own, "radius": 0.09, "mesh": mesh, "load": most, "preload": 0.05}
    other = theirs(observed, stand, "bearing_flexibility", where, of_rig, "by_load")
    np.testing.assert_allclose(found, other, rtol=1e-4, atol=1e-7 * np.abs(other).max())
    firm = ours(context, observed, law, where, {**values, "loaded": 0.0})
    assert off(firm, other).max() > 0.02


def turned_from_the_rigs(context, stand, joint):
    """Angle about the axis of a joint from the rig's first direction across it to ours."""
    posture = dict(stand.plan.postures[0].q)
    axes = frame(PlantAssembly(stand.robot.at(posture)), joint)
    parent = context.robot.urdf.joint_by_name[joint].parent
    placed = link_placements(context.robot, posture)[parent][:3, :3]
    first = next(way.vector for way in ways(context, joint) if way.kind == "radial")
    ours_ = axes.T @ (placed @ frame_of(context, joint) @ first)
    return -float(np.arctan2(ours_[1], ours_[0]))
