"""Effects of the catalogue against the rig's own physics, and their derivatives against differences."""

from dataclasses import replace
from itertools import product
from unittest.mock import Mock

import numpy as np
import pytest
from scipy.linalg import polar
from scipy.spatial.transform import Rotation

import flexmodal
from flexmodal.diagnosis.effects import Context, bearing, catalogue, hinges, link_motion, rod
from flexmodal.diagnosis.effects.added_mass import place_on
from flexmodal.diagnosis.effects.effect import Placement, along, sides
from flexmodal.diagnosis.effects.free_function import FreeFunction
from flexmodal.diagnosis.effects.hinges import gauss, quadrature, shares
from flexmodal.diagnosis.effects.sensors import axes_of, mounted
from flexmodal.diagnosis.effects.servo_compliance import loop, loop_stiffness
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.placed import Placed
from flexmodal.diagnosis.time_domain.law import KNEE
from flexmodal.errors import InvalidRequest
from flexmodal.identification import observe, predict, unlimited
from flexmodal.identification.model import evaluated
from flexmodal.rig import FORMS, simulate
from flexmodal.rig.believed import known_robot
from flexmodal.rig.effects.effect import Site
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.plant.build import build
from flexmodal.rig.plant.geometry import across, turn
from flexmodal.rig.sensing import Sensor
from flexmodal.rig.simulate import make_stand
from flexmodal.structure import robot_space
from flexmodal.structure.assembly import Assembly
from flexmodal.structure.port import StiffnessPort
from flexmodal.structure.with_ports import with_ports

from .beside_rig import STAYS, carried_by_the_rig, ours, seen_and_simulated, theirs
from .conftest import NEXT, effect_of


@pytest.fixture(scope="module")
def bench():
    """A short campaign with the card's own parameters, its context, its observations, and the rig's stand."""
    return seen_and_simulated("fanuc_s360", ["configuration_1", "configuration_6"])


@pytest.fixture(scope="module")
def standing():
    """The same of an arm in space, in one posture."""
    return seen_and_simulated("six_axis", ["work"])


K = 4e5
LIGHT = 1e-5
"""Of the arm's mass: as light as a foundation may be."""
STILL = 1e-9
"""An idler too light to tell [kg·m²]."""
CASES = {
    "servo_compliance": (
        "q2",
        {"gain": 3e5, "frequency": 30.0, "damping_ratio": 0.4},
        None,
    ),
    "joint_coupling": (
        "q1+q3", {"coupling": -0.3, "inertia": STILL, "damping_time": 2e-12, **STAYS}, {"coupling": -0.3},
    ),
    "base_flexibility": (
        "base",
        {
            "horizontal_stiffness": 4e7, "vertical_stiffness": 8e7, "tilt_stiffness": 2e7,
            "translation_damping": 1e3, "tilt_damping": 1e3,
        },
        None,
    ),
    "structural_damping": ("joints", {"loss_factor": 0.1}, {"loss_factor": 0.1, "viscous": 1.0}),
}  # fmt: skip


def rig_values(context, stand, effect, where, values):
    if effect == "servo_compliance":
        k = float(context.robot.joints[where].stiffness)
        inertia, derivative = loop(k, values["gain"], values["frequency"], values["damping_ratio"])
        return {"proportional_gain": values["gain"], "derivative_gain": derivative, "rotor_inertia": inertia}
    return values


@pytest.mark.parametrize("effect", ["servo_compliance", "joint_coupling"])
def test_effect_is_that_of_the_rig(bench, effect):
    context, observed, stand = bench
    where, values, _ = CASES[effect]
    other = theirs(observed, stand, effect, where, rig_values(context, stand, effect, where, values))
    found = ours(context, observed, effect, where, values)
    np.testing.assert_allclose(found, other, rtol=1e-8 if effect == "servo_compliance" else 1e-6)


def test_a_rotor_that_drives_a_wheel_by_a_belt_is_that_of_the_rig(bench):
    context, observed, stand = bench
    k, gain, derivative, inertia = float(context.robot.joints["q2"].stiffness), 1e5, 300.0, 20.0
    belt = {"belt_stiffness": 2e5, "belt_damping_time": 6e-4, "wheel_inertia": 7.0}
    motor = {"proportional_gain": gain, "derivative_gain": derivative, "rotor_inertia": inertia}
    there = theirs(observed, stand, "servo_compliance", "q2", {**motor, **belt}, "belted")
    rotor = {
        "gain": gain, "frequency": np.sqrt((gain + k) / inertia) / (2 * np.pi),
        "damping_ratio": derivative / (2 * np.sqrt(gain * inertia)),
    }  # fmt: skip
    still = {"integral": 1e-4, "lag": 1e-8, "brake": 1e-5}
    values = {**rotor, **still, "belt": 2e5, "belt_damping_time": 6e-4, "wheel": 7.0 / inertia}
    found = ours(context, observed, "servo_compliance" + NEXT, "q2", values)
    np.testing.assert_allclose(found, there, rtol=1e-2, atol=1e-3 * np.abs(there).max())
    alone = ours(context, observed, "servo_compliance", "q2", rotor)
    assert np.abs(np.log(np.abs(alone / there))).max() > 0.1


def test_a_loop_that_integrates_and_lags_is_that_of_the_rig(bench):
    """P around PI on the rate, the torque through a low-pass."""
    context, observed, stand = bench
    k, gain, derivative, inertia = float(context.robot.joints["q2"].stiffness), 2e5, 3e3, 20.0
    outer, lag = 0.6, 7e-4
    other = {"proportional_gain": gain, "derivative_gain": derivative, "rotor_inertia": inertia,
             "outer": outer, "filter_time": lag}  # fmt: skip
    there = theirs(observed, stand, "servo_compliance", "q2", other, "cascade")
    proportional = outer * gain
    values = {
        "gain": proportional, "frequency": np.sqrt((proportional + k) / inertia) / (2 * np.pi),
        "damping_ratio": derivative / (2 * np.sqrt(proportional * inertia)),
        "integral": (1 - outer) * gain / derivative / (2 * np.pi), "lag": lag, "brake": 1e-4,
        "belt": 1e4 * k, "wheel": 1e-4,
    }  # fmt: skip
    found = ours(context, observed, "servo_compliance" + NEXT, "q2", values)
    # w/(s + e) for w/s, and Maxwell elements' ends with an inertia of their own
    np.testing.assert_allclose(found, there, rtol=3e-3, atol=1e-3 * np.abs(there).max())
    site = Site(stand, "q2", other)
    plant = build(stand, observed.postures[0], [(FORMS["servo_compliance"]["cascade"], site)])
    exact = plant.feedbacks[0].stiffness(np.array([2 * np.pi * 31.0]))[0]
    assert loop_stiffness(context, "q2", values, 31.0) == pytest.approx(exact, rel=1e-3)
    plain = ours(context, observed, "servo_compliance" + NEXT, "q2", {**values, "integral": 1e-3})
    assert np.abs(plain / there - 1).max() > 0.1, "the integral is not seen at all"


@pytest.mark.parametrize("ratio", [0.7, -1.3])
@pytest.mark.parametrize("form", ["ratio", "damped", "idler", "belt"])
def test_couplings_of_other_kinds_are_those_of_the_rig(bench, form, ratio):
    context, observed, stand = bench
    k, loss, inertia = 2e5, 3e-4, 4.0
    one, other = (float(context.robot.joints[name].stiffness) for name in ("q1", "q3"))
    spring = {"stiffness": k, "ratio": ratio}
    theirs_of = {
        "ratio": spring,
        "damped": {**spring, "damping": loss * k},
        "idler": {"stiffness": 2 * k, "ratio": ratio, "inertia": inertia, "damping": 2 * loss * k},
        "belt": {**spring, "relaxing": 0.9, "time": 4e-3},
    }
    omega = np.sqrt(4 * k / inertia)
    values = {
        "coupling": -k * ratio / np.sqrt(one * other), "first": k / one, "second": ratio**2 * k / other,
        "damping_time": 2e-12 if form in ("ratio", "belt") else loss, "ratio": abs(ratio),
        "inertia": inertia if form == "idler" else STILL,
        "frequency": omega / (2 * np.pi), "damping_ratio": loss * omega / 2,
        **({"relaxing": 0.9, "relaxation_time": 4e-3} if form == "belt" else STAYS),
    }  # fmt: skip
    found = ours(context, observed, "joint_coupling", "q1+q3", values)
    there = theirs(observed, stand, "joint_coupling", "q1+q3", theirs_of[form], form)
    np.testing.assert_allclose(found, there, rtol=3e-4 if form in ("ratio", "belt") else 1e-6)


@pytest.mark.parametrize("form", ["rod", "hose"])
@pytest.mark.parametrize(("arm", "where"), [("bench", "q1+q2"), ("standing", "q2+q3")])
def test_a_rod_between_two_links_is_that_of_the_rig(request, arm, where, form):
    context, observed, stand = request.getfixturevalue(arm)
    crank, angles = 0.12, (0.7, 1.1)
    held = {"rod": (2e-12, 1e-9), "hose": (8e-4, 0.4)}[form]
    values = {"rod_stiffness": 3e7, "rod_damping_time": held[0], "rod_across": held[1]}
    for side, (link, _, axis), angle in zip(rod.SIDES, rod.links(context, where), angles, strict=True):
        one, other = across(axis / np.linalg.norm(axis), None)
        place = crank * (np.cos(angle) * one + np.sin(angle) * other)
        along = rod.ways(context, link)
        values |= {f"{side}_{name}": place @ way for name, way in zip("xyz", along, strict=False)}
    found = ours(context, observed, "joint_coupling" + NEXT, where, values)
    of_rig = {"stiffness": 3e7, "crank": crank, "angle": angles[0], "turn": angles[1] - angles[0]}
    of_rig |= {"damping_time": held[0], "across": held[1]} if form == "hose" else {}
    other = theirs(observed, stand, "joint_coupling", where, of_rig, form)
    np.testing.assert_allclose(found, other, rtol=1e-6, atol=1e-9 * np.abs(other).max())


@pytest.mark.parametrize(("arm", "where"), [("bench", "q1+q2"), ("standing", "q2+q3")])
def test_a_spring_that_balances_the_arm_is_that_of_the_rig(request, arm, where):
    """Without a length of its own; in another form than its own the rig has no joints between."""
    context, observed, stand = request.getfixturevalue(arm)
    values = {"rod_stiffness": 2e6, "rod_damping_time": 2e-12, "rod_across": 1e-9, "rod_pull": 1.0}
    of_rig = {"stiffness": 2e6}
    for side, (link, _, axis) in zip(rod.SIDES, rod.links(context, where), strict=True):
        angle, crank = {"near": (0.7, 0.25), "far": (1.9, 0.3)}[side]
        one, other = across(axis / np.linalg.norm(axis), None)
        place = crank * (np.cos(angle) * one + np.sin(angle) * other)
        values |= {
            f"{side}_{name}": place @ way for name, way in zip("xyz", rod.ways(context, link), strict=False)
        }
        of_rig |= {f"{side}_crank": crank, f"{side}_angle": angle}
    found = ours(context, observed, "joint_coupling" + NEXT, where, values)
    other = theirs(observed, stand, "joint_coupling", where, of_rig, "balancer")
    np.testing.assert_allclose(found, other, rtol=1e-6, atol=1e-9 * np.abs(other).max())
    slack = ours(context, observed, "joint_coupling" + NEXT, where, {**values, "rod_pull": 0.0})
    assert np.abs(slack / other - 1).max() > 0.1


@pytest.mark.parametrize(("arm", "where"), [("bench", "q1+q3"), ("standing", "q2+q5")])
def test_what_a_pull_adds_are_second_derivatives_of_its_length(request, arm, where):
    """Against differences of half the square of the length, with joints between; and of a stretched line."""
    context, _, _ = request.getfixturevalue(arm)
    robot, step, joints = context.robot, 1e-4, context.joints
    cranks = {"near_x": 0.1, "near_y": -0.2, "far_x": 0.15, "far_y": 0.12}
    cranks |= {} if context.normal is not None else {"near_z": 0.07, "far_z": -0.11}
    placement = Placement.still(context, where, cranks)
    assembly = Assembly(context.stacked)
    found, along = rod.tightened(assembly, placement)[0], rod.stretch(assembly, placement)[0]

    def half_square(*moved):
        q = dict(context.postures[0].q)
        for name, by in moved:
            q[name] += by
        ends = []
        for side, (link, joint, _) in zip(rod.SIDES, rod.links(context, where), strict=True):
            place = joint
            for name, way in zip("xyz", rod.ways(context, link), strict=False):
                place = place + cranks[f"{side}_{name}"] * way
            plant = PlantAssembly(robot.at(q))
            ends.append(plant.origin(link) + plant.orientation(link) @ place)
        return float(np.sum((ends[1] - ends[0]) ** 2)) / 2

    columns = [assembly.number(name) for name in joints]
    for a, one in enumerate(joints):
        for b, other in enumerate(joints):
            moved = {
                (i, j): half_square((one, i * step), (other, j * step)) for i in (-1, 1) for j in (-1, 1)
            }
            second = (moved[1, 1] - moved[1, -1] - moved[-1, 1] + moved[-1, -1]) / (4 * step**2)
            ours_ = found[columns[a], columns[b]] + along[columns[a]] * along[columns[b]]
            assert ours_ == pytest.approx(second, abs=1e-6)


def test_springs_and_rods_follow_what_bears_their_names_closely():
    """Play passes for a spring that is not straight, and a hose to a hook in the world for a rod."""
    every = catalogue()
    close = {name for name, effect in every.items() if effect.comes_close}
    wide = {name for name, one in every.items() if one.next_level and one.next_level.effect.comes_close}
    assert close == {"nonlinear_stiffness"}
    assert wide == {"nonlinear_stiffness", "joint_coupling"}


def test_a_rod_sets_out_from_the_cranks_and_the_stiffness_of_a_free_law(bench):
    context, observed, _ = bench
    effect, where = effect_of("joint_coupling" + NEXT), "q1+q2"
    geometry = rod.cranks_tried(context, where)[5]
    frequency = observed.axis.frequency[:3]
    free = FreeFunction(frequency, np.array([[2e7, 3e7 + 1e6j, 9e7]]), geometry, np.zeros(0))
    told = {**geometry, "rod_stiffness": 3e7}
    assert effect.told(context, where, free) == (told, {**told, "rod_pull": 1.0})
    other = replace(free, geometry={})  # of a port without cranks
    assert effect.told(context, where, other) == ()


def test_hysteresis_is_near_the_rigs_row_of_maxwell_elements(bench):
    context, observed, stand = bench
    where, values, other = CASES["structural_damping"]
    ratio = ours(context, observed, "structural_damping", where, values) / theirs(
        observed, stand, "structural_damping", where, other
    )
    # nine elements hold the loss factor to a few per cent over the band: 5 % of 0.1 of a stiffness
    assert np.sqrt(np.mean(np.abs(np.log(ratio)) ** 2)) < 0.02


def test_each_joint_may_have_a_loss_factor_of_its_own(bench):
    context, observed, stand = bench
    where, drawn = "joints", {"loss_factor": 0.06, "viscous": 1.0, "spread": 0.6, "phase": 1.3}
    turns = 1.3 + 2.399963 * np.arange(len(context.robot.joints))
    found = np.exp(0.6 * np.sin(turns)).tolist()
    ratios = {f"loss_ratio_{joint}": one for joint, one in zip(context.robot.joints, found, strict=True)}
    assert max(ratios.values()) > 1.5 * min(ratios.values())
    other = theirs(observed, stand, "structural_damping", where, drawn, "by_joint")
    values = {"loss_factor": 0.06, "viscous": 1.0, "relaxing": 1e-8, "relaxation_time": 1e-2, **ratios}
    ratio = ours(context, observed, "structural_damping", where, values) / other
    # as the row of Maxwell elements above
    assert np.sqrt(np.mean(np.abs(np.log(ratio)) ** 2)) < 0.02
    alike = {**values, **dict.fromkeys(ratios, 1.0)}
    plain = ours(context, observed, "structural_damping", where, alike) / other
    assert np.sqrt(np.mean(np.abs(np.log(plain)) ** 2)) > 0.04


def test_by_the_wider_law_joints_run_directly_beside_geared_ones(bench):
    """The narrow law holds each near the common loss: one that loses nothing is none of it."""
    context, observed, stand = bench
    narrow, where = catalogue()["structural_damping"], "joints"
    drawn = {"loss_factor": 0.3, "viscous": 1.0, "phase": 1.0}
    other = theirs(observed, stand, "structural_damping", where, drawn, "geared")
    turns = np.sin(1.0 + 2.399963 * np.arange(len(context.robot.joints)))
    assert turns.min() < 0 < turns.max()

    def off(effect):
        """From the rig's, with the joints that lose nothing at the least that there may be."""
        space = {one.name: one for one in effect.parameters(context, where)}
        names = [f"loss_ratio_{joint}" for joint in context.robot.joints]
        ratios = {
            name: 1.0 if turn > 0 else space[name].lower for name, turn in zip(names, turns, strict=True)
        }
        values = {"loss_factor": 0.3, "viscous": 1.0, "relaxing": 1e-8, "relaxation_time": 1e-2, **ratios}
        found = ours(context, observed, effect, where, values)
        return np.sqrt(np.mean(np.abs(np.log(found / other)) ** 2))

    assert off(narrow.next_level.effect) < min(0.03, 0.95 * off(narrow))
    assert narrow.next_level.starts(context, where, drawn)[0] == drawn


def test_added_mass_is_that_of_the_rig(bench):
    context, observed, stand = bench
    stiff = 500 * context.band[1]
    values = {"mass": 3.0, "along": 0.6, "beside": 0.05, "gyration": 0.2, "mount_frequency": stiff}
    from flexmodal.diagnosis.effects.added_mass import place_on

    place = place_on(context, "link_3", values)
    other = {"mass": 3.0, "x": place[0], "y": place[1], "z": place[2], "gyration": 0.2}
    np.testing.assert_allclose(
        ours(context, observed, "added_mass", "link_3", values),
        theirs(observed, stand, "added_mass", "link_3", other),
        rtol=1e-4,  # the mount gives (1/500)² of what it carries at the end of the band, and more at zeros
    )
    soft = {**values, "mount_frequency": 1.5 * context.band[1], "gyration": 2e-3}
    swinging = {
        "mass": 3.0, "frequency": soft["mount_frequency"], "damping_ratio": 0.03, "second": 1.0,
        "x": place[0], "y": place[1], "z": place[2], "dx": 1.0, "dy": 0.0, "dz": 0.0,
    }  # fmt: skip
    np.testing.assert_allclose(
        ours(context, observed, "added_mass", "link_3", soft),
        theirs(observed, stand, "local_absorber", "link_3", swinging, "two_way"),
        rtol=1e-3,  # the ball's own inertia
    )


SOIL = {
    "translation_stiffness": 4e7, "tilt_stiffness": 2e7, "damping_ratio": 0.03,
    "vertical_over_horizontal": 1.6, "aside": 0.0, "below": 0.3,
}  # fmt: skip


def about(context, body):
    """Moment of inertia about the normal of the plane."""
    return float(context.normal @ body.inertia @ context.normal)


def test_a_foundation_with_springs_of_its_own_each_way_is_that_of_the_rig(bench):
    """About a centre below the root, each of the three its own damping; the rig gives the base mass."""
    context, observed, stand = bench
    base = stand.true.bodies[context.robot.urdf.root]
    values = {**SOIL, "spread": 0.5, "phase": 1.0}
    angle = values["phase"] + 2.399963 * np.arange(3)
    spring = np.array([4e7, 1.6 * 4e7, 2e7]) * np.exp(0.5 * np.sin(angle))
    time = np.sqrt(sum(body.mass for body in stand.true.bodies.values()) / 4e7)
    damper = 2 * 0.03 * np.exp(0.5 * np.cos(angle)) * spring * time
    found = ours(context, observed, "base_flexibility", "base", {
        "horizontal_stiffness": spring[0], "vertical_stiffness": spring[1], "tilt_stiffness": spring[2],
        "translation_damping": damper[0], "vertical_damping_ratio": damper[1] / damper[0],
        "tilt_damping": damper[2], "below": 0.3, "mass": base.mass, "mass_below": 0.0,
        "gyration": np.sqrt(about(context, base) / base.mass),
    })  # fmt: skip
    other = theirs(observed, stand, "base_flexibility", "base", values, "directions")
    np.testing.assert_allclose(found, other, rtol=1e-7)


def test_in_space_a_foundation_gives_six_ways(standing):
    """About a centre beside and below the root, each way its own stiffness and damping; next to no mass."""
    context, observed, stand = standing
    values = {**SOIL, "aside": -0.1, "spread": 0.6, "phase": 1.0}
    angle = values["phase"] + 2.399963 * np.arange(6)
    spring = np.array([4e7, 4e7, 1.6 * 4e7, 2e7, 2e7, 2e7]) * np.exp(0.6 * np.sin(angle))
    time = np.sqrt(sum(body.mass for body in stand.true.bodies.values()) / 4e7)
    damper = 2 * 0.03 * np.exp(0.6 * np.cos(angle)) * spring * time
    found = ours(context, observed, "base_flexibility", "base", {
        "horizontal_stiffness": spring[0], "sideways_ratio": spring[1] / spring[0],
        "vertical_stiffness": spring[2], "tilt_stiffness": spring[3], "tilt_ratio": spring[4] / spring[3],
        "twist_stiffness": spring[5], "translation_damping": damper[0],
        "sideways_damping_ratio": damper[1] / damper[0], "vertical_damping_ratio": damper[2] / damper[0],
        "tilt_damping": damper[3], "tilt_damping_ratio": damper[4] / damper[3],
        "twist_damping_ratio": damper[5] / damper[3], "aside": -0.1, "below": 0.3,
        "mass": LIGHT * sum(body.mass for body in stand.true.bodies.values()),
    })  # fmt: skip
    other = theirs(observed, stand, "base_flexibility", "base", values, "directions")
    np.testing.assert_allclose(found, other, rtol=1e-3)


def test_a_foundation_on_feet_tilts_about_axes_that_are_turned(standing):
    """Four feet at the corners of a square, the first softer: it tilts about diagonals."""
    context, observed, stand = standing
    upright, level, loss, width = 2e8, 0.8, 0.04, 0.25
    feet = {"foot_stiffness": upright, "half_width": width, "below": 0.06, "horizontal": level,
            "worst": 0.3, "damping_ratio": loss}  # fmt: skip
    spring = upright * np.array([0.3, 1.0, 1.0, 1.0])
    place = width * np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]])
    total, centre = spring.sum(), spring @ place / spring.sum()
    off = place - centre
    along, across = (spring @ (off @ way) ** 2 / 2 for way in np.array([[1, -1], [1, 1]]))
    time = 2 * loss * np.sqrt(sum(body.mass for body in stand.true.bodies.values()) / (4 * upright))
    found = ours(context, observed, "base_flexibility", "base", {
        "horizontal_stiffness": level * total, "vertical_stiffness": total, "tilt_stiffness": along,
        "tilt_ratio": across / along, "angle": np.pi / 4, "translation_damping": time * level * total,
        "vertical_damping_ratio": 1 / level, "tilt_damping": time * along,
        "tilt_damping_ratio": across / along, "twist_stiffness": level * (along + across),
        "twist_damping_ratio": level * (along + across) / along, "aside": centre[0], "ahead": centre[1],
        "below": 0.06, "mass": LIGHT * sum(body.mass for body in stand.true.bodies.values()),
    })  # fmt: skip
    other = theirs(observed, stand, "base_flexibility", "base", feet, "feet")
    np.testing.assert_allclose(found, other, rtol=1e-3)


def test_a_foundation_on_a_block_is_that_of_the_rig(bench):
    """The mass is at the block's centre, the springs at its bottom; the base's own mass is taken along."""
    context, observed, stand = bench
    base = stand.true.bodies[context.robot.urdf.root]
    values = {**SOIL, "block_mass": 20.0}
    arm = sum(body.mass for body in stand.true.bodies.values())
    loss = 2 * 0.03 * np.sqrt((arm + 20.0) / 4e7)
    whole = base.mass + 20.0
    low = 20.0 * 0.3 / whole
    inertia = about(context, base) + base.mass * low**2 + 20.0 * (0.6**2 / 6 + (0.3 - low) ** 2)
    found = ours(context, observed, "base_flexibility", "base", {
        "horizontal_stiffness": 4e7, "vertical_stiffness": 1.6 * 4e7, "tilt_stiffness": 2e7,
        "translation_damping": loss * 4e7, "vertical_damping_ratio": 1.6, "tilt_damping": loss * 2e7,
        "below": 0.6, "mass": whole, "mass_below": low, "gyration": np.sqrt(inertia / whole),
    })  # fmt: skip
    other = theirs(observed, stand, "base_flexibility", "base", values, "block")
    np.testing.assert_allclose(found, other, rtol=1e-7)


def test_a_foundation_that_moves_under_bolts_is_that_of_the_rig(bench):
    """The block stands on its springs by itself, bolts between it and the root."""
    context, observed, stand = bench
    root, values = context.robot.urdf.root, {**SOIL, "aside": 0.05, "block_mass": 20.0, "bolts": 1.7}
    light = {name: body for name, body in stand.true.bodies.items() if name != root}
    floats = replace(stand, true=replace(stand.true, bodies=light))
    arm = sum(body.mass for body in light.values())
    time, own = np.sqrt((arm + 20.0) / 4e7), np.sqrt(arm / (1.7 * 4e7))
    found = ours(context, observed, "base_flexibility" + NEXT, "base", {
        "horizontal_stiffness": 4e7, "vertical_stiffness": 1.6 * 4e7, "tilt_stiffness": 2e7,
        "translation_damping": 0.06 * time * 4e7, "vertical_damping_ratio": 1.6,
        "tilt_damping": 0.06 * time * 2e7, "aside": 0.05, "below": 0.6, "mass": 20.0, "mass_below": 0.3,
        "gyration": 0.6 / np.sqrt(6), "bolts_horizontal_ratio": 1.7, "bolts_vertical_ratio": 1.7,
        "bolts_tilt_ratio": 1.7, "bolts_damping_ratio": own / (2 * time),
    })  # fmt: skip
    other = theirs(observed, floats, "base_flexibility", "base", values, "bolted")
    np.testing.assert_allclose(found, other, rtol=1e-6)


def test_joints_relax(bench):
    """Beside a dynamic stiffness put in line by line."""
    context, observed, _ = bench
    part, time = 0.4, 2e-3
    values = {"loss_factor": 1e-5, "viscous": 1.0, "relaxing": part, "relaxation_time": time}
    found = ours(context, observed, "structural_damping", "joints", values)
    root = Hypothesis(context, robot_space(context.robot))
    lag = 2j * np.pi * observed.axis.frequency * time
    expected = np.zeros_like(found)
    for group in root.groups(np.zeros(len(root.space)), observed, slopes=False):
        springs = np.zeros_like(group.structures.stiffness)
        springs[:] = np.diag([context.robot.joints[name].stiffness for name in group.structures.coordinates])
        axis = observed.axis_of(group.part.level)
        ported = with_ports(group.structures, axis, group.part.entries, [StiffnessPort(springs)])
        value = ported.at((part * lag / (1 + lag))[None, None]).value
        expected[group.part.observations] = value[group.part.entry]
    np.testing.assert_allclose(found, expected, rtol=2e-3, atol=1e-3 * np.abs(expected).max())


def test_a_mass_that_is_long_is_a_row_of_masses(standing):
    """Spread along the link it is two masses there, as far apart as its radius of gyration says."""
    context, observed, stand = standing
    from flexmodal.diagnosis.effects.added_mass import place_on

    where = context.links[1]
    values = {
        "mass": 3.0, "along": 0.6, "beside": 0.05, "above": -0.02, "gyration": 0.01, "length_ratio": 20.0,
        "side_ratio": 0.1, "mount_frequency": 500 * context.band[1],
    }  # fmt: skip
    place, axis = place_on(context, where, values), along(context, where)[1]
    half = 20.0 * 0.01 / np.sqrt(2)
    ends = [
        {"mass": 1.5, **dict(zip("xyz", (place + way * half * axis).tolist(), strict=True)), "gyration": 1e-4}
        for way in (1, -1)
    ]
    expected = theirs(observed, stand, "added_mass", where, ends[0], more=ends[1:])
    found = ours(context, observed, "added_mass", where, values)
    np.testing.assert_allclose(found, expected, rtol=5e-3, atol=1e-4 * np.abs(expected).max())


def test_a_disc_turned_as_it_likes_is_that_of_the_rig(standing):
    """It spreads by m r²/4 across its axis, and along it hardly at all."""
    context, observed, stand = standing
    from flexmodal.diagnosis.effects.added_mass import place_on

    where = context.links[1]
    axis = along(context, where)[1]
    first, *_ = sides(context, where, axis)
    normal, radius = np.array([2.0, -1.0, 2.0]) / 3, 0.5
    own = np.stack([axis, first, np.cross(axis, first)]) @ normal
    thin = np.log(1e-3)  # of the spread along the axis over that across it
    grown = thin * np.outer(own, own)
    grown, size = grown - grown[2, 2] * np.eye(3), radius**2 / 2 * np.exp(grown[2, 2])
    values = {
        "mass": 3.0, "along": 0.6, "beside": 0.05, "above": -0.02, "gyration": np.sqrt(size),
        "length_ratio": np.exp(grown[0, 0] / 2), "side_ratio": np.exp(grown[1, 1] / 2),
        "length_side_lean": grown[0, 1], "length_across_lean": grown[0, 2], "side_across_lean": grown[1, 2],
        "mount_frequency": 500 * context.band[1],
    }  # fmt: skip
    disc = {
        "mass": 3.0, **dict(zip("xyz", place_on(context, where, values).tolist(), strict=True)),
        **dict(zip(("ax", "ay", "az"), normal.tolist(), strict=True)), "radius": radius,
    }  # fmt: skip
    expected = theirs(observed, stand, "added_mass", where, disc, form="disc")
    found = ours(context, observed, "added_mass", where, values)
    np.testing.assert_allclose(found, expected, rtol=5e-3, atol=1e-4 * np.abs(expected).max())
    straight = {
        **values,
        **dict.fromkeys(("length_side_lean", "length_across_lean", "side_across_lean"), 0.0),
    }
    apart = np.abs(ours(context, observed, "added_mass", where, straight) - expected)
    assert np.any(apart > 0.05 * np.abs(expected) + 1e-3 * np.abs(expected).max())


APART = (
    *("across_ratio", "stiffness", "other", "other_ratio", "across_x", "across_y", "across_z"),
    *("relaxing", "relaxation_time"),
)
LASTING = {"relaxing": 1e-8, "relaxation_time": 1e-2}
"""Of a spring of which nothing relaxes."""


@pytest.mark.parametrize(("arm", "turns"), [("bench", {}), ("standing", {"turn": 0.3, "roll": 0.8})])
def test_two_absorbers_across_one_another_are_those_of_the_rig(request, arm, turns):
    context, observed, stand = request.getfixturevalue(arm)
    where, effect = context.links[1], catalogue()["local_absorber"]
    values = {
        "mass": 6.0, "frequency": 21.0, "damping_ratio": 0.06, "along": 0.7, "beside": 0.05, "angle": 0.4,
        "across_ratio": 1e4, "other": 0.6, "other_ratio": 1.6, **LASTING, **turns,
    }  # fmt: skip
    if turns:
        values["above"] = -0.03
    physical = effect.physical(context, where, values)
    first = np.array([physical[name] for name in ("dx", "dy", "dz")])
    if context.normal is not None:
        second = np.cross(context.axes(where).T @ context.normal, first)
    else:
        second = np.array([physical[f"across_{name}"] for name in "xyz"])
        assert second @ first == pytest.approx(0.0, abs=1e-12)
        assert abs(second @ np.cross(first, along(context, where)[1])) > 0.5  # not in the plane of the axis
    one = {name: value for name, value in physical.items() if name not in APART}
    other = {**one, "mass": 3.6, "frequency": 33.6, **dict(zip(("dx", "dy", "dz"), second, strict=True))}
    expected = theirs(observed, stand, "local_absorber", where, one, more=(other,))
    found = ours(context, observed, "local_absorber", where, values)
    np.testing.assert_allclose(found, expected, rtol=3e-3, atol=1e-3 * np.abs(expected).max())


def test_an_absorber_is_free_two_ways(bench):
    context, observed, stand = bench
    where, effect = "link_2", catalogue()["local_absorber"]
    values = {
        "mass": 12.0, "frequency": 21.0, "damping_ratio": 0.06, "along": 0.7, "beside": 0.05, "angle": 0.4,
        "across_ratio": 1.7, "other": 1e-6, "other_ratio": 5.0, **LASTING,
    }  # fmt: skip
    found = ours(context, observed, "local_absorber", where, values)
    drawn = {**effect.physical(context, where, values), "second": np.sqrt(values["across_ratio"])}
    drawn = {name: value for name, value in drawn.items() if name not in APART}
    other = theirs(observed, stand, "local_absorber", where, drawn, "two_way")
    np.testing.assert_allclose(found, other, rtol=1e-4)  # another mass of a millionth
    one_way = ours(context, observed, "local_absorber", where, {**values, "across_ratio": 1e4})
    own = {name: value for name, value in drawn.items() if name != "second"}
    plain = theirs(observed, stand, "local_absorber", where, own)
    np.testing.assert_allclose(one_way, plain, rtol=3e-3, atol=1e-3 * np.abs(plain).max())


@pytest.mark.parametrize(("arm", "turns"), [("bench", {}), ("standing", {"turn": 0.3, "roll": 0.8})])
def test_an_absorber_with_a_further_mode_on_a_foot_is_that_of_the_rig(request, arm, turns):
    """Two masses that are free two ways and a point, the last two where the first one stands."""
    context, observed, stand = request.getfixturevalue(arm)
    where, effect = context.links[1], effect_of("local_absorber" + NEXT)
    values = {
        "mass": 6.0, "frequency": 21.0, "damping_ratio": 0.06, "along": 0.7, "beside": 0.05, "angle": 0.4,
        "across_ratio": 1.7, "other": 1e-6, "other_ratio": 5.0, **LASTING, **turns,
        "further": 0.3, "further_ratio": 2.5, "foot": 0.2, "below": 0.12,
    }  # fmt: skip
    if turns:  # the second direction is where the rig has it
        values["above"] = -0.03
        level, upright = (
            effect.physical(context, where, {**values, "roll": roll}) for roll in (0.0, np.pi / 2)
        )
        (rig, *_) = across(np.array([level[f"d{k}"] for k in "xyz"]), None)
        parts = [rig @ [one[f"across_{k}"] for k in "xyz"] for one in (upright, level)]
        values["roll"] = float(np.arctan2(*parts))
    physical = effect.physical(context, where, values)
    first, second = (np.array([physical[f"{name}{k}"] for k in "xyz"]) for name in ("d", "across_"))
    least = np.cross(first, second) if turns else second
    low = dict(zip("xyz", [physical[k] for k in "xyz"] - 0.12 * least, strict=True))
    one = {name: physical[name] for name in ("mass", "frequency", "damping_ratio", *"xyz", "dx", "dy", "dz")}
    one["second"] = np.sqrt(1.7)
    other = {**one, **low, "mass": 0.3 * 6.0, "frequency": 2.5 * 21.0}
    foot = ("added_mass", "point", {**low, "mass": 0.2 * 6.0})
    expected = theirs(observed, stand, "local_absorber", where, one, "two_way", (other,), (foot,))
    found = ours(context, observed, "local_absorber" + NEXT, where, values)
    np.testing.assert_allclose(found, expected, rtol=1e-3, atol=1e-4 * np.abs(expected).max())


@pytest.mark.parametrize(("arm", "turns"), [("bench", {}), ("standing", {"turn": 0.3, "roll": 0.8})])
def test_an_absorber_that_turns_too_is_the_taut_line_of_the_rig(request, arm, turns):
    """Three modes of a line of 0.4 m, a third faster than another, and what these leave."""
    context, observed, stand = request.getfixturevalue(arm)
    where, effect = context.links[1], effect_of("local_absorber" + NEXT)
    modes = 8 / (np.pi * np.array([1, 3])) ** 2
    mass, length, swinging, rod = 6.0, 0.4, 24 / (2 * np.pi) ** 2, 1 / 12
    first = modes[0] * mass
    values = {
        "mass": first, "frequency": 21.0, "damping_ratio": 0.06, "along": 0.7, "beside": 0.05, "angle": 0.4,
        "across_ratio": 1.0 if turns else 1e4, "other": 1e-6, "other_ratio": 5.0, **LASTING, **turns,
        "further": modes[1] / modes[0], "further_ratio": 3.0,
        "foot": (1 - modes.sum()) / modes[0], "below": 0.0,
        "turning": length * np.sqrt(swinging * rod / modes[0]), "turning_ratio": 2.0,
        "still": length * np.sqrt((1 - swinging) * rod / modes[0]),
    }  # fmt: skip
    if turns:
        values["above"] = -0.03
    physical = effect.physical(context, where, values)
    ways = [np.array([physical[f"{name}{k}"] for k in "xyz"]) for name in ("d", "across_")]
    line = np.cross(*ways) if turns else ways[1]
    given = {name: physical[name] for name in ("frequency", "damping_ratio", *"xyz")}
    given |= {"mass": mass, "length": length, **dict(zip(("dx", "dy", "dz"), line, strict=True))}
    expected = theirs(observed, stand, "local_absorber", where, given, "string")
    found = ours(context, observed, "local_absorber" + NEXT, where, values)
    np.testing.assert_allclose(found, expected, rtol=2e-3, atol=2e-4 * np.abs(expected).max())
    still = ours(context, observed, "local_absorber" + NEXT, where, {**values, "turning": 1e-4})
    assert np.max(np.abs(np.log(still / expected))) > 0.1, "the turning is not seen at all"


def test_part_of_an_absorbers_spring_relaxes_as_rubber_does(bench):
    context, observed, stand = bench
    where, effect = "link_2", catalogue()["local_absorber"]
    omega, part = 2 * np.pi * 24.0, 0.4
    static = omega / np.sqrt(1 + part / 2)
    values = {
        "mass": 12.0, "frequency": static / (2 * np.pi), "damping_ratio": 1e-4, "along": 0.7, "beside": 0.05,
        "angle": 0.4, "across_ratio": 1e4, "other": 1e-6, "other_ratio": 5.0,
        "relaxing": part, "relaxation_time": 1 / omega,
    }  # fmt: skip
    physical = effect.physical(context, where, values)
    rubber = {name: physical[name] for name in ("mass", "x", "y", "z", "dx", "dy", "dz", "relaxing")}
    other = theirs(observed, stand, "local_absorber", where, {**rubber, "frequency": 24.0}, "rubber")
    found = ours(context, observed, "local_absorber", where, values)
    np.testing.assert_allclose(found, other, rtol=2e-3, atol=1e-3 * np.abs(other).max())
    lasting = ours(context, observed, "local_absorber", where, {**values, "relaxing": 1e-8})
    assert np.max(np.abs(np.log(lasting / other))) > 0.5


def test_a_sensor_off_the_surface_is_a_body_there(bench):
    """While it is on one point it is like a mass that is attached for good."""
    context, observed, _ = bench
    point = context.point(int(observed.response[0, 0]))
    values = {"mass": 1.5, "off": 0.08, "gyration": 0.05, "cable": 1e-4}
    place = mounted(context, point.id, values)
    length, axis = along(context, point.link)
    across = sides(context, point.link, axis)[0]
    fixed = {"mass": 1.5, "along": place @ axis / length, "beside": place @ across, "gyration": 0.05}
    rows = observed.response[:, 0] == point.id
    found = ours(context, observed, "sensor_mass", "sensor", values)[rows]
    other = ours(context, observed, "added_mass", point.link, fixed)[rows]
    np.testing.assert_allclose(found, other, rtol=1e-3)


@pytest.mark.parametrize(
    ("form", "mount", "cable"), [("sprung", (200.0, 0.1), (1e-3, 0.2)), ("dragged", (9e3, 0.05), (3.0, 0.4))]
)
def test_a_sensor_gives_on_its_mount_and_is_held_by_its_cable_as_that_of_the_rig(bench, form, mount, cable):
    context, observed, stand = bench
    values = {
        "mass": 2.0, "off": 0.0, "gyration": 1e-4, "cable": 1e-4, "mount_frequency": mount[0],
        "mount_damping_ratio": mount[1], "cable_frequency": cable[0], "cable_damping_ratio": cable[1],
        "line_mass": 1e-6, "firm": 1e-5, "pads": 1e-7,
    }  # fmt: skip
    frequency, ratio = mount if form == "sprung" else cable
    sized = {"mass": 2.0, "frequency": frequency, "damping_ratio": ratio}
    other = carried_by_the_rig(observed, stand, form, sized)
    plain = ours(context, observed, "sensor_mass", "sensor", {"mass": 2.0})
    found = ours(context, observed, "sensor_mass" + NEXT, "sensor", values)
    np.testing.assert_allclose(found, other, rtol=2e-3)
    assert np.max(np.abs(plain / other - 1)) > 0.05, "neither is seen at all"


def test_a_sensor_that_a_hand_presses_on_is_that_of_the_rig(bench):
    """The sensor is firm on the surface, and the hand behind it a mass on a spring."""
    context, observed, stand = bench
    hand = {"hand_mass": 0.9, "frequency": 21.0, "damping_ratio": 0.5}
    values = {
        "mass": 0.9, "firm": 1.5, "off": 0.0, "gyration": 1e-4, "cable": 1e-4, "mount_frequency": 21.0,
        "mount_damping_ratio": 0.5, "cable_frequency": 1e-3, "line_mass": 1e-5,
        "pads": 1e-7,
    }  # fmt: skip
    found = ours(context, observed, "sensor_mass" + NEXT, "sensor", values)
    other = carried_by_the_rig(observed, stand, "held", {"mass": 1.35, **hand})
    np.testing.assert_allclose(found, other, rtol=2e-3)
    rigid = ours(context, observed, "sensor_mass", "sensor", {"mass": 2.25})
    assert np.abs(np.log(np.abs(rigid / other))).max() > 0.05


@pytest.mark.parametrize("arm", ["bench", "spatial"])
def test_a_cable_that_whips_in_one_mode_is_that_of_the_rig(request, arm):
    """Along the link all of it goes along with the sensor; the rig's second mode lies above the band."""
    context, observed, stand = request.getfixturevalue(arm)
    own, mass, length = 0.7 * context.band[1], 3.0, 0.3
    part, high = 0.6131, 0.7265  # of the first mode of a clamped beam
    values = {
        "mass": part * mass, "firm": (1.0 - part + 0.5) / part, "off": 0.0, "gyration": 1e-4, "cable": 1e-4,
        "mount_frequency": own, "mount_damping_ratio": 0.04, "cable_frequency": 1e-3, "line_mass": 1e-5,
        "pads": 1e-7,
        "along_ratio": 300.0, "off_along": high * length,
    }  # fmt: skip
    found = ours(context, observed, "sensor_mass" + NEXT, "sensor", values)
    beam = {"cable_mass": mass, "length": length, "frequency": own, "damping_ratio": 0.04}
    other = carried_by_the_rig(observed, stand, "whipping", {"mass": 0.5 * mass, **beam})
    apart = np.abs(np.log(np.abs(found / other)))
    alike = {**values, "along_ratio": 1.0, "off_along": 0.0}
    plain = ours(context, observed, "sensor_mass" + NEXT, "sensor", alike)
    before = np.abs(np.log(np.abs(plain / other)))
    assert np.median(before) > 0.02
    assert np.median(apart) < 0.1 * np.median(before)


@pytest.mark.parametrize("arm", ["bench", "spatial"])
def test_a_cable_that_is_laid_along_the_arm_is_that_of_the_rig(request, arm):
    """A thin line of mass on each link, from its frame to where the cable leaves it."""
    context, observed, stand = request.getfixturevalue(arm)
    rigid = {"mount_frequency": 300 * context.band[1], "cable_frequency": 1e-3}
    bare = {"mass": 2.0, "off": 0.0, "gyration": 1e-4, "cable": 1e-4, "firm": 1e-5, "pads": 1e-7, **rigid}
    found = ours(context, observed, "sensor_mass" + NEXT, "sensor", {**bare, "line_mass": 1.5})
    other = carried_by_the_rig(observed, stand, "along_arm", {"mass": 2.0, "line_mass": 1.5})
    np.testing.assert_allclose(found, other, rtol=3e-3)
    alone = ours(context, observed, "sensor_mass" + NEXT, "sensor", {**bare, "line_mass": 1e-3})
    assert np.abs(np.log(np.abs(alone / other))).max() > 0.05


FAR = {"mount_frequency": 5e3, "mount_damping_ratio": 0.05, "high_pass": 1e-4, "high_pass_order": 0.0}


def amplified(frequency, mount_frequency, mount_damping_ratio, high_pass, high_pass_order):
    """What a sensor makes of a motion: a mount of second order, and a high pass."""
    s, own = 2j * np.pi * frequency, 2 * np.pi * mount_frequency
    mount = own**2 / (s**2 + 2 * mount_damping_ratio * own * s + own**2)
    corner = 2 * np.pi * high_pass
    return mount * s**2 / (s**2 + corner * s + high_pass_order * corner**2)


@pytest.mark.parametrize("order", [0.0, 0.5])
def test_the_mount_of_a_sensor_resonates_and_its_amplifier_passes_what_is_high(bench, order):
    context, observed, _ = bench
    where = context.sensors[0]
    here = observed.response[:, 0] == next(p.id for p in observed.campaign.points if p.name == where)
    mount = {
        "mount_frequency": 40.0, "mount_damping_ratio": 0.03, "high_pass": 2.0, "high_pass_order": order,
    }  # fmt: skip
    plain, other = (
        ours(context, observed, "sensor_gain", where, {"gain": 1.3, **values}) for values in (FAR, mount)
    )
    frequency = observed.axis.frequency
    factor = amplified(frequency, **mount) / amplified(frequency, **FAR)
    np.testing.assert_allclose(other[here], factor * plain[here], rtol=1e-9)
    np.testing.assert_allclose(other[~here], plain[~here], rtol=1e-12)


def test_a_sensitivity_may_step_from_one_value_to_another(bench):
    context, observed, _ = bench
    narrow, where = effect_of("sensor_gain"), context.sensors[0]
    here = observed.response[:, 0] == next(p.id for p in observed.campaign.points if p.name == where)
    values = {"gain": 1.3, "exponent": 0.0, **FAR}
    plain = ours(context, observed, narrow, where, values)
    step = {**values, "step": 0.7, "step_frequency": 12.0}
    found = ours(context, observed, narrow.next_level.effect, where, step)
    over = 1j * observed.axis.frequency / 12.0
    np.testing.assert_allclose(found[here], plain[here] * (1 + 0.7 * over) / (1 + over), rtol=1e-12)
    np.testing.assert_allclose(found[~here], plain[~here], rtol=1e-12)
    tried = narrow.next_level.starts(context, where, values)
    assert {one["step"] for one in tried if "step" in one} == {0.7, 1.4}
    assert {one.get("second_sensitivity", 1.0) for one in tried} == {1.0, 0.7, 0.85, 1.15, 1.4}
    assert {one["gain"] for one in tried} == {1.3, 1.0}


def test_a_sensor_lags_by_a_delay_a_low_pass_an_all_pass_and_an_average(bench):
    context, observed, _ = bench
    where = context.sensors[0]
    plain = ours(context, observed, "sensor_gain", where, {"gain": 1.0, **FAR})
    plain = np.where(
        (observed.response[:, 0] == next(p.id for p in observed.campaign.points if p.name == where))[:, None],
        plain / amplified(observed.axis.frequency, **FAR),
        plain,
    )
    lags = {"delay": 2e-3, "time_constant": 3e-3, "all_pass_time": 4e-3, "averaged_over": 1e-6}
    found = ours(context, observed, "time_delay", where, lags)
    omega = 2 * np.pi * observed.axis.frequency
    here = observed.response[:, 0] == next(p.id for p in observed.campaign.points if p.name == where)
    late = np.exp(-2e-3j * omega) / (1 + 3e-3j * omega) * (1 - 2e-3j * omega) / (1 + 2e-3j * omega)
    np.testing.assert_allclose(found[here] / plain[here], np.broadcast_to(late, found[here].shape), rtol=4e-4)
    np.testing.assert_allclose(found[~here], plain[~here], rtol=1e-12)
    mean = ours(context, observed, "time_delay", where, {**lags, "averaged_over": 9e-3})
    every = np.sinc(9e-3 * observed.axis.frequency) * np.exp(-4.5e-3j * omega)
    expected = found[here] * every / (np.sinc(1e-6 * observed.axis.frequency) * np.exp(-0.5e-6j * omega))
    near = np.abs(every) > 1e-3  # beside its zeros
    assert not near.all() or observed.axis.frequency[-1] < 1 / 9e-3
    np.testing.assert_allclose(mean[here][:, near], expected[:, near], rtol=1e-6)


def test_a_sensor_lags_by_a_low_pass_of_second_order(bench):
    """Bessel's and Butterworth's by their poles, against that of a quarter, twice the first order."""
    context, observed, _ = bench
    where = context.sensors[0]
    here = observed.response[:, 0] == next(p.id for p in observed.campaign.points if p.name == where)
    s = 2j * np.pi * observed.axis.frequency
    rest = {"delay": 0.0, "all_pass_time": 1e-6, "averaged_over": 1e-6}
    time = 6e-3

    def lagging(order):
        values = {"time_constant": time, "second_order": order, **rest}
        return ours(context, observed, "time_delay", where, values)[here]

    twice = 1 / (1 + s * time / 2) ** 2
    for order, pole in ((1 / 3, -1.5 + 0.5j * 3**0.5), (1 / 2, -1 + 1j)):
        product = abs(pole) ** 2 / ((s * time - pole) * (s * time - pole.conjugate()))
        found = lagging(order) / lagging(1 / 4)
        np.testing.assert_allclose(found, np.broadcast_to(product / twice, found.shape), rtol=1e-9)


def test_two_low_passes_are_a_filter_of_fourth_order(bench):
    """Butterworth's, by its polynomial."""
    context, observed, _ = bench
    where, time = context.sensors[0], 1.5e-3
    here = observed.response[:, 0] == next(p.id for p in observed.campaign.points if p.name == where)
    slow, fast = 2 * np.cos(np.pi * np.array([1, 3]) / 8)
    rest = {"delay": 0.0, "all_pass_time": 1e-6, "averaged_over": 1e-6}
    found = ours(context, observed, "time_delay" + NEXT, where, {
        **rest, "time_constant": slow * time, "second_order": 1 / slow**2,
        "further_time": fast * time, "further_order": 1 / fast**2,
    })  # fmt: skip
    plain = ours(context, observed, "sensor_gain", where, {"gain": 1.0, **FAR})
    s = 2j * np.pi * observed.axis.frequency
    late = 1 / np.polyval([1, 2.6131259, 3.4142136, 2.6131259, 1], s * time)
    late = late / amplified(observed.axis.frequency, **FAR)
    np.testing.assert_allclose(found[here] / plain[here], np.broadcast_to(late, found[here].shape), rtol=2e-3)
    np.testing.assert_allclose(found[~here], plain[~here], rtol=1e-12)


def test_a_gain_has_either_sign_and_may_change_with_frequency(bench):
    context, observed, _ = bench
    where = context.sensors[0]
    here = observed.response[:, 0] == next(p.id for p in observed.campaign.points if p.name == where)
    plain, other = (
        ours(context, observed, "sensor_gain", where, values)
        for values in ({"gain": 1.0, "exponent": 0.0, **FAR}, {"gain": -0.8, "exponent": 0.1, **FAR})
    )
    factor = -0.8 * (observed.axis.frequency / 50.0) ** 0.1
    np.testing.assert_allclose(other[here], factor * plain[here], rtol=1e-9)
    np.testing.assert_allclose(other[~here], plain[~here], rtol=1e-12)


def test_a_sensor_that_sits_off_its_point_reads_what_is_there(bench):
    """Two sensors side by side read the turn of the link between them."""
    context, observed, _ = bench
    where = context.sensors[0]
    point = next(p for p in observed.campaign.points if p.name == where)
    here = observed.response[:, 0] == point.id
    flat = {"angle": 0.0, "sensitivity": 1.0, "off": 0.0, "off_along": 0.0}
    on, off, further = (
        ours(context, observed, "sensor_misalignment", where, {**flat, "off_along": size})[here]
        for size in (0.0, 0.02, 0.04)
    )
    assert np.max(np.abs(off - on)) > 0
    np.testing.assert_allclose(further - on, 2 * (off - on), rtol=1e-6, atol=1e-9 * np.abs(on).max())
    wide = ours(context, observed, "sensor_misalignment", where, {**flat, "sensitivity": 1.3})[here]
    np.testing.assert_allclose(wide, 1.3 * on, rtol=1e-12)


@pytest.fixture(scope="module")
def slender():
    """The same of an arm whose links have modes of their own in the band."""
    return seen_and_simulated("six_link", 1, top=200.0)


def test_a_slender_link_has_the_modes_of_a_beam(slender, monkeypatch):
    context, observed, stand = slender
    bending, length = 2.5e4, float(np.linalg.norm(context.reach("link_1")))
    beam = {"bending_stiffness": bending, "damping_ratio": 0.02}
    first = 1.875104**2 * np.sqrt(bending / (10.0 / length * length**4))
    loss = 2 * 0.02 / first  # the rig's beam: damping in proportion to stiffness
    values = {
        "stiffness": bending / length,
        "damping": loss * bending / length,
        "position": 0.5,
        "shear": 1e-4,
    }
    there = theirs(observed, stand, "link_flexibility", "link_1", beam)

    def off(grown=1.0):
        here = ours(
            context, observed, "link_flexibility", "link_1",
            {**values, "stiffness": grown * values["stiffness"], "damping": grown * values["damping"]},
        )  # fmt: skip
        return float(np.sqrt(np.mean(np.abs(np.log(here / there)) ** 2)))

    assert off() < 0.4 * off(1.2), "a beam a fifth stiffer is far off"
    many = off()
    context.frames.kept.clear()
    link_motion.shares_at.cache_clear()
    for room in (hinges, link_motion):
        monkeypatch.setattr(room, "fixed", lambda context, where: gauss(2))
    assert many < 0.2 * off(), "two hinges lack modes"
    context.frames.kept.clear()
    link_motion.shares_at.cache_clear()


@pytest.mark.parametrize(("start", "end"), [(0.0, 1.0), (0.0, 0.4), (0.4, 1.0), (0.3, 0.6)])
@pytest.mark.parametrize("count", [4, 5, 7])
def test_hinges_of_a_piece_integrate_polynomials(start, end, count):
    place, weight = quadrature(start, end, count)
    assert np.all(weight > 0)
    assert np.all(np.diff(place) > 0)
    assert (place[0] == 0.02) == (start == 0.0)
    assert (place[-1] == 0.98) == (end == 1.0)
    for degree in range(4):
        exact = (end ** (degree + 1) - start ** (degree + 1)) / (degree + 1)
        assert weight @ place**degree == pytest.approx(exact, rel=1e-12)


def test_hinges_of_a_link_have_the_moments_of_an_even_beam(slender):
    context, _, _ = slender
    known = [hinges.fixed(context, link) for link in context.links]
    assert any(one is not None for one in known)
    for place, weight in filter(None, known):
        assert np.all(np.diff(place) > 1e-3)
        assert np.stack([place**0, place, place**2]) @ weight == pytest.approx([1, 1 / 2, 1 / 3])


def test_a_rough_link_has_few_hinges(slender, inside):
    for context, _, _ in (slender, inside):
        links = [link for link in context.links if hinges.fixed(context, link) is not None]
        assert links
        for link in links:
            (place, weight), (many, _) = hinges.fixed(context.rough, link), hinges.fixed(context, link)
            assert len(place) == len(hinges.pieces(context, link)) + 1 < len(many)
            assert np.all(np.diff(place) > 1e-3)
            assert np.stack([place**0, place]) @ weight == pytest.approx([1, 1 / 2])


@pytest.mark.parametrize("shift", [-0.8, 0.0, 0.5])
def test_shifted_hinges_stay_in_order_and_in_their_pieces(slender, shift):
    context, _, _ = slender
    links = [link for link in context.links if hinges.fixed(context, link) is not None]
    assert links
    for link in links:
        was, now = hinges.fixed(context, link)[0], hinges.shifted(context, link, shift)
        assert np.all(np.diff(now) > 0)
        assert np.sign(now - was) == pytest.approx(np.sign(shift))
        for end in hinges.pieces(context, link):
            np.testing.assert_array_equal(now < end, was < end)


@pytest.mark.parametrize("mean", [0.03, 0.17175, 0.5, 0.97])
@pytest.mark.parametrize("spread", [0.02, 0.19686, 0.98])
def test_no_hinge_is_so_stiff_that_nothing_else_has_digits(mean, spread):
    compliance = shares(mean, spread, *gauss(4))
    assert np.all(compliance >= 1e-6)
    assert compliance.sum() == pytest.approx(1.0, abs=1e-5)


@pytest.mark.parametrize("count", [4, 6])
@pytest.mark.parametrize(("mean", "spread"), [(0.3, 0.5), (0.5, 3**-0.5), (0.62, 0.45), (0.5, 0.75)])
def test_hinges_have_the_mean_and_the_spread_of_the_compliance(count, mean, spread):
    place, weight = gauss(count)
    compliance = shares(mean, spread, place, weight)
    assert np.all(compliance > 0)
    assert compliance.sum() == pytest.approx(1, rel=1e-12)
    assert compliance @ place == pytest.approx(mean, rel=1e-9)
    deviation = np.sqrt(compliance @ (place - mean) ** 2)
    assert deviation == pytest.approx(spread * np.sqrt(mean * (1 - mean)), rel=1e-9)
    if mean == 0.5 and spread < 0.6:
        np.testing.assert_allclose(compliance, weight, rtol=1e-9)


@pytest.mark.parametrize(("mean", "spread"), [(0.02, 0.9), (0.98, 0.02), (0.5, 0.01), (0.5, 0.99)])
def test_hinges_come_as_near_as_they_can(mean, spread):
    compliance = shares(mean, spread, *gauss(4))
    assert np.all(compliance > 0)
    assert compliance.sum() == pytest.approx(1, rel=1e-12)


def test_bending_is_that_of_a_beam_where_it_is_slow(bench):
    context, observed, stand = bench
    length, bending = float(np.linalg.norm(context.reach("link_1"))), 2e5
    found = ours(
        context, observed, "link_flexibility", "link_1",
        {"stiffness": bending / length, "damping": 0.1, "position": 0.5},
    )  # fmt: skip
    other = theirs(
        observed, stand, "link_flexibility", "link_1", {"bending_stiffness": bending, "damping_ratio": 1e-6}
    )
    low = observed.axis.frequency < 15
    # statically the two hinges are the beam; the mass between them tells at (15 Hz / 100 Hz)²
    np.testing.assert_allclose(np.abs(found[:, low] / other[:, low]), 1, atol=0.02)
    stiff = ours(
        context, observed, "link_flexibility", "link_1", {"stiffness": 1e8, "damping": 10.0, "position": 0.5}
    )
    assert np.max(np.abs(np.log(np.abs(stiff[:, low] / other[:, low])))) > 0.2, "the beam is not seen at all"


@pytest.fixture(scope="module")
def inside():
    """An arm in space with a sensor between the ends of its upper arm, off the axis."""
    return seen_and_simulated("six_axis", ["work"], points=5)


@pytest.mark.parametrize(
    ("form", "ours_has", "theirs_has", "without"),
    [
        ("timoshenko", {"shear": 2.0, "twist_ratio": 1e4}, {"shear": 2.0}, {"shear": 1e-4}),
        ("twisting", {"shear": 1e-4, "twist_ratio": 0.2}, {"torsion": 0.2}, {"twist_ratio": 1e4}),
    ],
)
def test_a_link_that_is_seen_inside_shears_and_twists_there(inside, form, ours_has, theirs_has, without):
    """Where it is slow, relative to what is seen most of each point."""
    context, observed, stand = inside
    length, bending = float(np.linalg.norm(context.reach("link_2"))), 2.5e5
    k = bending / length
    values = {"stiffness": k, "damping": 1e-4 * k, "position": 0.5, "ratio": 0.7}
    beam = {"bending_stiffness": bending, "damping_ratio": 1e-3, "ratio": 0.7}
    point = next(p for p in observed.campaign.points if p.link == "link_2")
    seen, low = observed.response[:, 0] == point.id, observed.axis.frequency < 5
    there = theirs(observed, stand, "link_flexibility", "link_2", {**beam, **theirs_has}, form)[seen][:, low]

    def off(more):
        here = ours(context, observed, "link_flexibility", "link_2", {**values, **ours_has, **more})
        return np.abs(here[seen][:, low] - there).max() / np.abs(there).max()

    assert off({}) < 0.01
    assert off(without) > 0.1, "it is not seen at all"


def test_a_link_with_modes_of_its_own_shears_where_it_lags_behind_its_ends():
    """The shear wave of the link is a factor of two above the band; even slides alone are 30 % off there."""
    context, observed, stand = seen_and_simulated("six_link", ["start_2"], points=4, top=200.0)
    bending, shear = 5e5, 1.3  # EI and Φ
    length, mass = float(np.linalg.norm(context.reach("link_5"))), stand.true.bodies["link_5"].mass
    k = bending / length
    time = 2 * 0.02 * float(np.sqrt(mass * length**2 / 3 / (3 * k)))
    values = {"stiffness": k, "damping": time * k, "position": 0.5, "shear": shear}
    beam = {"bending_stiffness": bending, "damping_ratio": 0.02, "ratio": 1.0, "shear": shear}
    there = theirs(observed, stand, "link_flexibility", "link_5", beam, "timoshenko")

    def off(more):
        here = ours(context, observed, "link_flexibility", "link_5", {**values, **more})
        return np.median(np.abs(np.log(here / there)), axis=1).max()

    assert off({}) < 0.01
    assert off({"shear": 1e-4}) > 0.1, "it is not seen at all"


def test_a_link_with_a_crack_gives_there_besides():
    """The hinges beside it share it: it sits where it is on average."""
    context, observed, stand = seen_and_simulated("six_link", ["start_2"], points=4, top=200.0)
    bending, crack = 5e5, 0.6
    length, mass = float(np.linalg.norm(context.reach("link_5"))), stand.true.bodies["link_5"].mass
    k = bending / length
    time = 2 * 0.02 * float(np.sqrt(mass * length**2 / 3 / (3 * k)))
    whole = k / (1 + 1 / crack)
    values = {
        "stiffness": whole, "damping": time * whole, "position": 0.5, "shear": 1e-4, "crack": 1 / crack,
        "crack_at": 0.17,
    }  # fmt: skip
    beam = {"bending_stiffness": bending, "damping_ratio": 0.02, "ratio": 1.0, "place": 0.17, "crack": crack}
    there = theirs(observed, stand, "link_flexibility", "link_5", beam, "cracked")

    def off(more):
        here = ours(context, observed, "link_flexibility" + NEXT, "link_5", {**values, **more})
        return np.median(np.abs(np.log(here / there)), axis=1).max()

    assert off({}) < 0.02
    assert off({"crack": 1e-4}) > 0.1, "where it is does not matter at all"


def test_a_link_with_an_opening_tilts_and_slides_there():
    """The hinges and the slides beside it share it."""
    context, observed, stand = seen_and_simulated("six_link", ["start_2"], points=4, top=100.0)
    length, mass = float(np.linalg.norm(context.reach("link_5"))), stand.true.bodies["link_5"].mass
    tilt, place = 3e5, 0.4
    shift = tilt / (0.6 * length) ** 2
    time = 2 * 0.02 * float(np.sqrt(mass * length**2 / 3 / tilt))
    values = {
        "stiffness": tilt, "damping": time * tilt, "shear": 1e-4, "crack": 30.0, "crack_at": place,
        "crack_slide": 12 * tilt / (shift * length**2),
    }  # fmt: skip
    box = {
        "tilt_stiffness": tilt, "shift_stiffness": shift, "place": place, "sideways": 1.0,
        "damping_ratio": 0.02,
    }  # fmt: skip
    there = theirs(observed, stand, "link_flexibility", "link_5", box, "opening")

    def off(more):
        here = ours(context, observed, "link_flexibility" + NEXT, "link_5", {**values, **more})
        return np.median(np.abs(np.log(here / there)), axis=1).max()

    assert off({}) < 0.02
    assert off({"crack_slide": 1e-4}) > 0.2, "it does not slide at all"
    assert off({"crack_slide": 1e-4, "shear": values["crack_slide"]}) > 3 * off({}), "it may slide anywhere"
    assert off({"crack": 1e-3}) > 2 * off({}), "it may tilt anywhere"


@pytest.mark.parametrize(
    "effect",
    [
        *sorted(set(catalogue()) - {"coulomb_friction", "nonlinear_stiffness"}),
        "base_flexibility" + NEXT,
        "joint_coupling" + NEXT,
        "link_flexibility" + NEXT,
        "local_absorber" + NEXT,
        "sensor_mass" + NEXT,
        "servo_compliance" + NEXT,
        "time_delay" + NEXT,
    ],
)
def test_derivatives_are_those_of_central_differences(bench, effect):
    context, observed, _ = bench
    known = effect_of(effect)
    where = known.places(context)[-1]
    placed = Placed(known, where)
    root = Hypothesis(context, robot_space(context.robot))
    hypothesis = root.and_also(placed)
    start = known.starts(context, where)[0]
    x = hypothesis.start(placed, start, np.full(len(root.space), 0.03))
    lines = np.array([4, 11, 60])

    def at(x, slopes=False):
        value = np.zeros((len(observed), len(lines)), dtype=complex)
        change = np.zeros((len(x), *value.shape), dtype=complex)
        for rows, found, moved in evaluated(hypothesis, x, observed, lines, slopes=slopes):
            value[rows] = found
            if slopes:
                change[:, rows] = moved
        return value, change

    value, slopes = at(x, slopes=True)
    step = 1e-5
    for k, name in enumerate(hypothesis.space.names):
        shift = step * np.eye(len(x))[k]
        numeric = (at(x + shift)[0] - at(x - shift)[0]) / (2 * step)
        # forward differences of matrices with a step of 1e-6, times the curvature of what they are of
        np.testing.assert_allclose(slopes[k] / value, numeric / value, atol=2e-3, rtol=1e-3, err_msg=name)


@pytest.fixture(scope="module")
def fixed(bench):
    """The same places along the axes of their links, aslant to them."""
    _, observed, stand = bench
    rows = ((0.8, 0.0, 0.6), (0.0, 1.0, 0.0), (-0.6, 0.0, 0.8))
    points = tuple(replace(one, axes=rows, frame="link") for one in observed.campaign.points)
    seen = replace(observed, campaign=replace(observed.campaign, points=points))
    return Context.of(stand.robot, seen), seen, stand


@pytest.mark.parametrize(
    ("effect", "values"),
    [
        ("sensor_misalignment", {"angle": 0.3, "sensitivity": 1.0, "off": 0.0, "off_along": 0.0}),
        ("local_absorber", None),
    ],
)
def test_effects_along_the_axes_of_a_link(fixed, effect, values):
    """The model turned by hand: along x and z of the world, put together by the link's own angles."""
    context, observed, _ = fixed
    where = catalogue()[effect].places(context)[-1]
    placed = Placed(catalogue()[effect], where)
    hypothesis = Hypothesis(context, robot_space(context.robot)).and_also(placed)
    start = values or catalogue()[effect].starts(context, where)[0]
    x = hypothesis.start(placed, start, np.zeros(len(hypothesis.base)))
    found = predict(hypothesis, x, observed)
    plain = replace(observed.campaign, points=tuple(
        replace(one, axes=None, frame="world") for one in observed.campaign.points))  # fmt: skip
    parts = {}
    for r, f in product((1, 3), repeat=2):
        turned = {name: getattr(observed, name).copy() for name in ("response", "reference")}
        turned["response"][:, 1], turned["reference"][:, 1] = r, f
        world = replace(observed, campaign=plain, **turned)
        other = replace(hypothesis, context=Context.of(context.robot, world))
        parts[r, f] = predict(other, x, world)
    expected = np.zeros_like(found)
    for row in range(len(observed)):
        arm = context.arms[int(observed.posture[row])]
        ways = []
        for number, direction in (observed.response[row], observed.reference[row]):
            point = context.point(int(number))
            ways.append(arm.placed[point.link][:3, :3] @ point.rows()[direction - 1])
        expected[row] = sum(
            ways[0][r - 1] * ways[1][f - 1] * parts[r, f][row] for r, f in product((1, 3), repeat=2)
        )
    size = np.abs(expected).max(axis=1, keepdims=True)
    # an entry may be a small difference of large ones
    np.testing.assert_allclose(found / size, expected / size, atol=1e-10)


@pytest.mark.parametrize("cubic", [0.0, 0.2])
def test_a_spring_has_as_many_laws_whatever_its_cubic_part(bench, cubic):
    """Systems that are integrated side by side, along differences too, have the same number of them."""
    context = bench[0]
    effect, where = effect_of("nonlinear_stiffness" + NEXT), context.joints[0]
    values = {"change": 0.3, "deflection": 1e-3, "wound": 0.1, "softness": 0.4, "cubic": cubic, "load": 0.2,
              "far": 5.0}  # fmt: skip
    assembly = Mock(spec=Assembly, stretch_of=lambda joint: np.eye(3)[0])
    first, second = effect.law(assembly, Placement.still(context, where, values))
    assert first.kind == KNEE
    assert first.parameters[1:5:3] == pytest.approx((1e-3, 4e-4))
    assert second.parameters[0] == pytest.approx(cubic * 5.0**2 * context.robot.joints[where].stiffness)
    assert second.parameters[1] == pytest.approx(5e-3)


SQUARE = {"across_1_2": 0.0, "across_1_3": 0.0, "across_2_3": 0.0,
          "second_sensitivity": 1.0, "third_sensitivity": 1.0}  # fmt: skip
AS_SET = {**SQUARE, "sensitivity": 1.0, "mirrored": 0.0, **{f"angle_{axis}": 0.0 for axis in "xyz"},
          **{f"lean_{axis}": 0.0 for axis in "xyz"}, "angle": 0.0}  # fmt: skip


@pytest.mark.parametrize(
    "skew",
    [
        SQUARE,
        {"across_1_2": 0.1, "across_1_3": -0.2, "across_2_3": 0.05,
         "second_sensitivity": 0.9, "third_sensitivity": 1.2},
    ],
    ids=["square", "skew"],
)  # fmt: skip
@pytest.mark.parametrize("mirrored", [0.0, 1.0])
def test_a_sensor_set_up_anew_leans_alike_in_the_world(standing, skew, mirrored):
    """Its own axes first, then the turn with the link, then one of the world, the same in every posture."""
    context, _, _ = standing
    effect, where = effect_of("sensor_misalignment" + NEXT), context.sensors[-1]
    values = {"sensitivity": 1.1, "angle_x": 0.2, "angle_y": -0.1, "angle_z": 0.3,
              "lean_x": -0.6, "lean_y": 0.5, "lean_z": 0.2, "mirrored": mirrored, "following": 0.0,
              **skew}  # fmt: skip
    link, world = ([values[f"{name}_{axis}"] for axis in "xyz"] for name in ("angle", "lean"))
    xy, xz, yz, y, z = skew.values()
    axes = Rotation.random(4, random_state=1)
    way = np.array([0.6, 0.0, 0.8])
    assembly = Mock(spec=Assembly, axes=lambda link: axes.as_matrix())
    placement = Placement.still(context, where, values)
    felt = axes.inv().apply(way) @ np.array([[1 - 2 * mirrored, xy, xz], [xy, y, yz], [xz, yz, z]])
    expected = 1.1 * (Rotation.from_rotvec(world) * axes * Rotation.from_rotvec(link)).apply(felt)
    found = effect.turn(assembly, placement, where, way)
    np.testing.assert_allclose(found, expected, atol=1e-12)
    np.testing.assert_array_equal(effect.turn(assembly, placement, "another", way), way)


def test_two_axes_in_a_plane_may_turn_apart(bench):
    """Of an accelerometer whose axes are not square: what one of them feels says nothing of the other."""
    context = bench[0]
    effect, where = effect_of("sensor_misalignment" + NEXT), context.sensors[-1]
    assert context.normal is not None
    link = context.point(where).link
    axes = Rotation.from_rotvec(0.7 * np.asarray(context.normal))
    first = axes.apply(along(context, link)[1])
    second = np.cross(context.normal, first)
    wanted = np.array([[np.cos(0.5), -np.sin(0.2)], [np.sin(0.5), np.cos(0.2)]])  # columns: each axis turned
    turn, metric = polar(wanted)
    values = {
        "angle": np.arctan2(turn[1, 0], turn[0, 0]), "sensitivity": metric[0, 0],
        "second_sensitivity": metric[1, 1] / metric[0, 0], "across_1_2": metric[0, 1] / metric[0, 0],
        "mirrored": 0.0, "following": 0.0,
    }  # fmt: skip
    assembly = Mock(spec=Assembly, axes=lambda link: axes.as_matrix())
    placement = Placement.still(context, where, values)
    for k, way in enumerate((first, second)):
        found = effect.turn(assembly, placement, where, way)
        np.testing.assert_allclose([found @ first, found @ second], wanted[:, k], atol=1e-12)
    assert effect.starts(context, where)
    assert effect_of("sensor_misalignment").next_level.starts(context, where, {"angle": 0.1})


@pytest.mark.parametrize("part", [-0.7, 0.4])
@pytest.mark.parametrize("arm", ["bench", "spatial"])
def test_a_sensor_may_follow_its_link_by_a_part_of_its_turn(request, arm, part):
    """As it does in the rig: none in the first posture, and about the axis of the turn since that."""
    context, *_ = request.getfixturevalue(arm)
    effect, where = effect_of("sensor_misalignment" + NEXT), context.sensors[-1]
    link, way = context.point(where).link, np.array([0.6, 0.0, 0.8])
    axes = np.array([one.placed[link][:3, :3] for one in context.arms])
    assembly = Mock(spec=Assembly, axes=lambda link: axes)
    placement = Placement.still(context, where, {**AS_SET, "following": part})
    found = effect.turn(assembly, placement, where, way)
    sensor = Sensor(following=(axes[0], part))
    expected = [sensor.direction(one, way) for one in axes]
    np.testing.assert_allclose(found, expected, atol=1e-12)
    np.testing.assert_allclose(found[0], way, atol=1e-12)
    assert np.abs(found[1:] - way).max() > 0.01


@pytest.mark.parametrize("arm", ["bench", "spatial"])
def test_a_sensor_may_sag_under_its_weight_as_that_of_the_rig(request, arm):
    context, *_ = request.getfixturevalue(arm)
    effect, where = effect_of("sensor_misalignment" + NEXT), context.sensors[-1]
    link, way = context.point(where).link, np.array([0.6, 0.0, 0.8])
    axes = np.array([one.placed[link][:3, :3] for one in context.arms])
    assembly = Mock(spec=Assembly, axes=lambda link: axes)
    sags = {"following": 0.0, "sag_1": 0.3, "sag_2": -0.2, "sag_3": 0.1}
    placement = Placement.still(context, where, {**AS_SET, **sags})
    found = effect.turn(assembly, placement, where, way)
    frame = axes_of(assembly, context, link)
    out = frame[0] @ [0.3, -0.2, 0.1 if context.normal is None else 0.0]
    sensor = Sensor(sagging=axes[0].T @ out)
    expected = [sensor.direction(one, way) for one in axes]
    np.testing.assert_allclose(found, expected, atol=1e-12)
    assert np.abs(found - way).max() > 0.01
    starts = effect_of("sensor_misalignment").next_level.starts(context, where, {})
    assert any(start.get("sag_1") for start in starts)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_sensor_may_read_too_much_along_one_axis(standing, axis):
    """As in the rig; the first axis alone is a gain of all and less along the other two."""
    context, _, _ = standing
    effect, where = effect_of("sensor_gain" + NEXT), context.sensors[-1]
    axes, way, size = Rotation.random(3, random_state=2).as_matrix(), np.array([0.6, 0.0, 0.8]), 1.3
    every = np.ones(3)
    every[axis] = size
    sensor = Sensor(turned=np.diag(every))
    gain, one = (size, 1 / size) if axis == 0 else (1.0, 1.0)
    values = dict(zip(("second_sensitivity", "third_sensitivity"), every[1:] * one, strict=True))
    assembly = Mock(spec=Assembly, axes=lambda link: axes)
    found = gain * effect.turn(assembly, Placement.still(context, where, values), where, way)
    np.testing.assert_allclose(found, [sensor.direction(each, way) for each in axes], atol=1e-12)
    placement = Placement.still(context, where, values)
    np.testing.assert_array_equal(effect.turn(assembly, placement, "another", way), way)


@pytest.mark.parametrize(("arm", "stays"), [("bench", 1.0), ("standing", 0.0), ("standing", 2.0)])
def test_exchanged_channels_are_among_the_starts(request, arm, stays):
    """A turn of a cube, one axis mirrored or not: one of the starts is what the rig does."""
    context, observed, stand = request.getfixturevalue(arm)
    narrow, where = effect_of("sensor_misalignment"), context.sensors[-1]
    other = theirs(observed, stand, "sensor_misalignment", where, {"stays": stays}, "swapped")

    def off(effect, given):
        plain = {one.name: one.card for one in effect.parameters(context, where)}
        found = ours(context, observed, effect, where, {**plain, **given})
        return np.abs(found - other).max() / np.abs(other).max()

    card = {one.name: one.card for one in narrow.parameters(context, where)}
    tried = narrow.next_level.starts(context, where, card)
    assert min(off(narrow.next_level.effect, one) for one in tried) < 1e-6
    assert min(off(narrow, one) for one in narrow.starts(context, where)) > 1e-3


@pytest.mark.parametrize("arm", ["standing", "bench"])
def test_derivatives_of_a_sensor_that_leans(request, arm):
    test_derivatives_are_those_of_central_differences(
        request.getfixturevalue(arm), "sensor_misalignment" + NEXT
    )


@pytest.mark.parametrize("effect", ["sensor_misalignment", "base_flexibility", "base_flexibility" + NEXT])
def test_derivatives_along_the_axes_of_a_link(fixed, effect):
    test_derivatives_are_those_of_central_differences(fixed, effect)


def test_unknown_effects_are_named_all_at_once():
    with pytest.raises(InvalidRequest) as error:
        catalogue(["added_mass", "ghosts", "goblins"])
    assert "ghosts" in str(error.value)
    assert "goblins" in str(error.value)
    assert "local_absorber" in str(error.value)


@pytest.mark.slow
def test_a_structure_seen_anywhere_is_that_of_the_observations(hinged, observed):
    _, _, hypothesis, after = hinged
    places = [(int(n), int(d)) for n, d in np.unique(observed.response, axis=0)]
    structures = hypothesis.structures(after.x, places, places[:1], slopes=True)
    for group in hypothesis.groups(after.x, observed, slopes=True):
        for number, posture in enumerate(group.part.posture.tolist()):
            structure, other = structures[posture], group.structures[number]
            np.testing.assert_array_equal(structure.mass, other.mass)
            np.testing.assert_array_equal(structure.response, other.response)


@pytest.fixture(scope="module")
def spatial():
    """The same on an arm in space."""
    result = simulate(
        flexmodal.load("six_axis"), postures=2, points=3, trials=2, averages=2, seed=3,
        record_length=1.0, band=(2.0, 120.0), parameter_error=0.0,
    )  # fmt: skip
    stand = make_stand(result.robot, result.plan, known_robot(result.robot, {}))
    observed = unlimited(observe(result.campaign))
    return Context.of(result.robot, observed), observed, stand


BEARING = {"tilt_stiffness": 4e5, "radial_stiffness": 6e7, "axial_stiffness": 9e7, "damping_time": 4e-4}


@pytest.mark.parametrize("joint", ["q1", "q3", "q5"])
def test_a_bearing_is_that_of_the_rig(spatial, joint):
    context, observed, stand = spatial
    found = ours(context, observed, "bearing_flexibility", joint, {**BEARING, **STAYS})
    other = theirs(observed, stand, "bearing_flexibility", joint, BEARING)
    np.testing.assert_allclose(found, other, rtol=1e-6)


def test_a_bearing_whose_tilts_are_not_turned_and_lose_no_more_is_the_narrower_one(spatial):
    """And turned by a right angle, with the inverse ratio, the same: the first direction is the second."""
    context, observed, _ = spatial
    values = {**BEARING, **STAYS, "ratio": 2.0, "angle": 0.3}
    narrow = ours(context, observed, "bearing_flexibility", "q3", values)
    alike = {"tilt_ratio": 1.0, "tilt_angle": 0.0, "second_loss_ratio": 1.0}
    more = {**alike, "radial_loss_ratio": 1.0, "axial_loss_ratio": 1.0}
    same = ours(context, observed, "bearing_flexibility" + NEXT, "q3", {**values, **more})
    np.testing.assert_allclose(same, narrow, rtol=1e-9)
    turned = {
        **more,
        "tilt_stiffness": 2 * BEARING["tilt_stiffness"],
        "tilt_ratio": 0.25,
        "tilt_angle": np.pi / 2,
    }
    again = ours(context, observed, "bearing_flexibility" + NEXT, "q3", {**values, **turned})
    np.testing.assert_allclose(again, narrow, rtol=1e-9)
    other = ours(context, observed, "bearing_flexibility" + NEXT, "q3", {**values, **more, "tilt_angle": 1.0})
    assert np.abs(np.log(np.abs(other / narrow))).max() > 0.1


@pytest.mark.parametrize("follows", [1.0, 0.0])
def test_a_bearing_whose_directions_turn_with_the_joint_is_the_slotted_shaft_of_the_rig(spatial, follows):
    """A stub of length l and rigidity E I: E I/l of tilt and 12 E I/l³ of shift about its middle."""
    context, observed, stand = spatial
    joint, length, rigidity, ratio, phase = "q5", 0.1, 2e4, 0.3, 0.6
    of_rig = {
        "bending_stiffness": rigidity, "length": length, "ratio": ratio, "phase": phase,
        "axial_stiffness": 9e7, "damping_time": 4e-4,
    }  # fmt: skip
    alike = {
        "tilt_ratio": 1 / ratio**2, "tilt_angle": 0.0, "second_loss_ratio": 1.0,
        "radial_loss_ratio": 1.0, "axial_loss_ratio": 1.0,
    }  # fmt: skip
    values = {
        # the stub bends about the axis across the way it gives; the rig's axes are a right angle on
        "tilt_stiffness": ratio * rigidity / length, "radial_stiffness": 12 * rigidity / length**3,
        "axial_stiffness": 9e7, "damping_time": 4e-4, "ratio": ratio, "angle": phase - np.pi / 2,
        "offset": -length / 2, "follows": follows,
    }  # fmt: skip
    angles = [posture.q[joint] for posture in observed.postures]
    assert np.ptp(angles) > 0.3
    found = ours(context, observed, "bearing_flexibility" + NEXT, joint, {**values, **alike, **STAYS})
    other = theirs(observed, stand, "bearing_flexibility", joint, of_rig, "slotted")
    same = np.abs(found / other - 1).max() < 1e-5
    assert same == (follows == 1.0)


def test_one_bearing_gives_beside_all_of_them(spatial):
    """Each has coordinates of its own, by the same names: all as stiff as can be leave that of the one."""
    context, observed, _ = spatial
    values = {**BEARING, **STAYS}
    alone = ours(context, observed, "bearing_flexibility", "q3", values)
    every, one = (Placed(effect_of("bearing_flexibility"), where) for where in ("joints", "q3"))
    bare = Hypothesis(context, robot_space(context.robot))

    def far(found, expected):
        return np.linalg.norm(found - expected) / np.linalg.norm(expected)

    for order in ((every, one), (one, every)):
        hypothesis = bare
        x = np.zeros(len(bare.base))
        for placed in order:
            hypothesis = hypothesis.and_also(placed)
            given = values if placed is one else {"tilt_factor": 1e4}
            x = hypothesis.start(placed, given, x)
        assert far(predict(hypothesis, x, observed), alone) < 0.02
    assert far(predict(bare, np.zeros(len(bare.base)), observed), alone) > 0.2


@pytest.mark.parametrize("joint", ["q1", "q4"])
def test_a_bearing_relaxes_as_that_of_the_rig(spatial, joint):
    """Maxwell's elements, there as states of the plant, here with an end that is too light to tell."""
    context, observed, stand = spatial
    values = {**BEARING, "relaxing": 0.6, "relaxation_time": 1.8e-3}
    found = ours(context, observed, "bearing_flexibility", joint, values)
    other = theirs(
        observed,
        stand,
        "bearing_flexibility",
        joint,
        {**BEARING, "relaxing": 0.6, "time": 1.8e-3},
        "relaxing",
    )
    np.testing.assert_allclose(found, other, rtol=1e-3)
    stays = ours(context, observed, "bearing_flexibility", joint, {**BEARING, **STAYS})
    assert np.abs(np.log(np.abs(stays / other))).max() > 0.1


def test_two_rows_are_springs_that_meet_off_the_joint(spatial):
    """k₁ at a and k₂ at b shift about their mean and tilt on Σ k (z − mean)²."""
    context, observed, stand = spatial
    rows = {"front_stiffness": 4e7, "rear": 0.4, "apart": 0.16, "middle": 0.03, "axial": 0.5,
            "damping_time": 4e-4}  # fmt: skip
    spring, place = np.array([4e7, 1.6e7]), np.array([0.11, -0.05])
    mean = spring @ place / spring.sum()
    values = {
        "radial_stiffness": spring.sum(), "tilt_stiffness": spring @ (place - mean) ** 2,
        "axial_stiffness": 0.5 * spring.sum(), "offset": mean, "damping_time": 4e-4, **STAYS,
    }  # fmt: skip
    found = ours(context, observed, "bearing_flexibility", "q2", values)
    other = theirs(observed, stand, "bearing_flexibility", "q2", rows, "rows")
    np.testing.assert_allclose(found, other, rtol=1e-6)


@pytest.mark.parametrize("arm", ["bench", "spatial"])
def test_a_tank_that_is_half_full_is_that_of_the_rig(request, arm):
    """Closed forms of Abramson for the part that swings, its frequency and its height over the centre."""
    context, observed, stand = request.getfixturevalue(arm)
    where = context.links[1]  # heavy enough that what a point would not turn with does not count
    given = {"along": 0.6, "beside": 0.05, "mass": 7.0, "gyration": 2e-3}
    given |= {} if context.normal is not None else {"above": -0.04}
    place = dict(zip("xyz", place_on(context, where, given).tolist(), strict=True))
    radius, depth, zero = 0.15, 0.9, 1.8411837813406593
    part = 2 * np.tanh(zero * depth) / (zero * (zero**2 - 1) * depth)
    values = {
        **given, "sloshing": part, "slosh_damping_ratio": 0.04,
        "slosh_frequency": np.sqrt(zero * 9.81 / radius * np.tanh(zero * depth)) / (2 * np.pi),
        "slosh_height": radius * (depth / 2 - 2 / zero * np.tanh(zero * depth / 2)),
    }  # fmt: skip
    tank = {**place, "mass": 7.0, "radius": radius, "depth": depth, "damping_ratio": 0.04}
    found = ours(context, observed, effect_of("added_mass" + NEXT), where, values)
    other = theirs(observed, stand, "added_mass", where, tank, "half_full")
    np.testing.assert_allclose(found, other, rtol=1e-3)
    frozen = ours(context, observed, "added_mass", where, given)
    assert np.abs(np.log(np.abs(frozen / other))).max() > 0.05


@pytest.mark.parametrize(("arm", "link"), [("bench", "link_2"), ("slender", "link_3"), ("spatial", "link_2")])
def test_a_link_of_two_plates_sways_as_that_of_the_rig(request, arm, link):
    """On two hinges that sit anywhere, and where hinges are fixed; in space edgewise as a beam."""
    context, observed, stand = request.getfixturevalue(arm)
    length, _ = along(context, link)
    spring, edge, loss = 3e5 if arm != "spatial" else 5e6, 4.0, 0.02
    mass = stand.true.bodies[link].mass
    plates = {"sway_stiffness": spring, "edgewise": edge, "angle": 0.6, "damping_ratio": loss}
    other = theirs(observed, stand, "link_flexibility", link, plates, "plates")
    stiff, time = 300 * spring * length**2, 2 * loss * np.sqrt(mass / 3 / spring)
    even = {"position": 0.5, "spread": 3**-0.5}
    values = {**even, "stiffness": stiff, "damping": time * stiff, "sway": 12 * stiff / (spring * length**2)}
    if context.normal is None:
        values |= {"ratio": edge / 900, "second_sway": 1e-7, "angle": turned_to(context, link, plates)}
        values["twist_ratio"] = 1e3
    wide = effect_of("link_flexibility" + NEXT)
    names = {one.name for one in wide.parameters(context, link)}
    values |= {name: 1e-4 for name in ("shear", "crack") if name in names}
    found = ours(context, observed, wide, link, values)
    far = np.sqrt(np.mean(np.abs(np.log(found / other)) ** 2))
    bends = {**even, "stiffness": spring * length**2 / 3, "damping": time * spring * length**2 / 3}
    straight = ours(context, observed, "link_flexibility", link, bends)
    assert far < 0.2 * np.sqrt(np.mean(np.abs(np.log(straight / other)) ** 2))


def turned_to(context, link, plates):
    """The angle of the rig's thin way among our sides."""
    _, axis = along(context, link)
    first = turn(axis, plates["angle"]) @ across(axis, None)[0]
    one, other = sides(context, link, axis)
    angle = float(np.arctan2(first @ other, first @ one))
    return (angle + np.pi / 2) % np.pi - np.pi / 2


@pytest.mark.parametrize("arm", ["bench", "spatial"])
def test_a_load_that_hangs_on_a_rope_is_that_of_the_rig(request, arm):
    """It goes up and down with its link, and sideways stays behind nearly altogether."""
    context, observed, stand = request.getfixturevalue(arm)
    where = context.links[1]
    given = {"along": 0.6, "beside": 0.05, "mass": 7.0, "gyration": 2e-3}
    given |= {} if context.normal is not None else {"above": -0.04}
    place = dict(zip("xyz", place_on(context, where, given).tolist(), strict=True))
    swing = {"slosh_frequency": np.sqrt(9.81 / 0.4) / (2 * np.pi), "slosh_damping_ratio": 0.03}
    values = {**given, **swing, "sloshing": 0.999, "slosh_height": 0.0}
    rope = {**place, "mass": 7.0, "length": 0.4, "damping_ratio": 0.03}
    found = ours(context, observed, effect_of("added_mass" + NEXT), where, values)
    other = theirs(observed, stand, "added_mass", where, rope, "hanging")
    np.testing.assert_allclose(found, other, rtol=1e-2, atol=1e-3 * np.abs(other).max())
    rigid = ours(context, observed, "added_mass", where, given)
    assert np.abs(np.log(np.abs(rigid / other))).max() > 0.1


@pytest.mark.parametrize("depth", [0.7, -2.0])
def test_a_hum_filter_takes_the_mains_out_of_what_a_sensor_reads(standing, depth):
    """As the rig's; a peak is one that takes less than nothing."""
    context, observed, stand = standing
    where = context.sensors[0]
    here = observed.response[:, 0] == next(p.id for p in observed.campaign.points if p.name == where)
    notch = {"notch_depth": depth, "notch_frequency": 50.0, "notch_width": 0.2}
    still = {"gain": 1.0, "exponent": 0.0, "high_pass": 1e-3, "mount_frequency": 1e4, "step": 1.0}
    wide = effect_of("sensor_gain" + NEXT)
    plain = ours(context, observed, wide, where, {**still, "notch_depth": 0.0})
    found = ours(context, observed, wide, where, {**still, **notch})
    sensor = Sensor()
    hum = Site(stand, where, {"frequency": 50.0, "width": 0.2, "depth": depth})
    FORMS["sensor_gain"]["hum"].sense({where: sensor}, hum)
    (told,) = sensor.filters
    factor = told(2 * np.pi * observed.axis.frequency)
    np.testing.assert_allclose(found[here], plain[here] * factor, rtol=1e-9)
    np.testing.assert_allclose(found[~here], plain[~here], rtol=1e-12)
    assert abs(factor[np.argmin(np.abs(observed.axis.frequency - 50.0))]) == pytest.approx(
        1 - depth, rel=0.01
    )


def test_a_resonance_may_be_taken_out_of_readings_in_which_it_is_not(standing):
    context, observed, stand = standing
    where = context.sensors[0]
    here = observed.response[:, 0] == next(p.id for p in observed.campaign.points if p.name == where)
    wide, still = effect_of("sensor_gain" + NEXT), {"gain": 1.0, "exponent": 0.0, "high_pass": 1e-3}
    taken = {"mount_order": -1.0, "mount_frequency": 300.0, "mount_damping_ratio": 0.05}
    plain = ours(context, observed, wide, where, {**still, "mount_frequency": 1e5})
    found = ours(context, observed, wide, where, {**still, **taken})
    sensor, site = Sensor(), Site(stand, where, {"resonance": 300.0, "damping_ratio": 0.05})
    FORMS["sensor_gain"]["equalised"].sense({where: sensor}, site)
    (told,) = sensor.filters
    factor = told(2 * np.pi * observed.axis.frequency)
    np.testing.assert_allclose(found[here], plain[here] * factor, rtol=1e-3)
    assert np.abs(np.log(np.abs(factor))).max() > 0.1


def test_an_adapter_that_rocks_is_that_of_the_rig(standing):
    context, observed, stand = standing
    where, wide = context.sensors[0], "sensor_gain" + NEXT
    here = observed.response[:, 0] == next(p.id for p in observed.campaign.points if p.name == where)
    still = {"gain": 1.0, "exponent": 0.0, "high_pass": 1e-3, "mount_frequency": 1e5, "step": 1.0}
    rocks = {"share": 0.4, "damping_ratio": 0.1, "resonance": 0.5 * context.band[1]}
    biquad = {
        "notch_depth": 0.0, "notch_beyond": rocks["share"], "notch_frequency": rocks["resonance"],
        "notch_width": rocks["damping_ratio"],
    }  # fmt: skip
    plain = ours(context, observed, wide, where, {**still, "notch_depth": 0.0, "notch_beyond": 0.0})
    found = ours(context, observed, wide, where, {**still, **biquad})
    sensor = Sensor()
    FORMS["sensor_gain"]["adapter"].sense({where: sensor}, Site(stand, where, rocks))
    (told,) = sensor.filters
    factor = told(2 * np.pi * observed.axis.frequency)
    np.testing.assert_allclose(found[here], plain[here] * factor, rtol=1e-9)
    assert np.abs(np.log(np.abs(factor))).max() > 0.3


@pytest.mark.parametrize("joint", ["q1", "q4"])
def test_a_pinion_pushes_aside_what_a_bearing_carries(spatial, joint):
    """As in the rig: the spring and damper of the joint feel its turn and the shift over the base radius."""
    context, observed, stand = spatial
    wide, radius, angle = effect_of("bearing_flexibility" + NEXT), 0.12, 0.7
    sides = [way.vector for way in bearing.ways(context, joint) if way.kind == "radial"]
    line = -np.cos(angle) * sides[1] + np.sin(angle) * sides[0]  # the rig's first side is ours the second
    mesh = {f"mesh_radial_{k + 1}": float(line @ side) / radius for k, side in enumerate(sides)}
    values = {**BEARING, **STAYS, **mesh, "mesh_axial_1": 0.0}
    alike = {"tilt_ratio": 1.0, "tilt_angle": 0.0, "second_loss_ratio": 1.0}
    found = ours(context, observed, wide, joint, {**values, **alike})
    other = theirs(observed, stand, "bearing_flexibility", joint,
                   {**BEARING, "base_radius": radius, "angle": angle}, "pinion")  # fmt: skip
    np.testing.assert_allclose(found, other, rtol=1e-6)
    without = ours(context, observed, "bearing_flexibility", joint, {**BEARING, **STAYS})
    assert np.abs(np.log(np.abs(without / other))).max() > 0.01


def test_a_bearing_in_a_plane_shifts_alone(bench):
    context, observed, stand = bench
    values = {"radial_stiffness": 5e6, "damping_time": 4e-4}
    found = ours(context, observed, "bearing_flexibility", "q2", {**values, **STAYS})
    other = {**values, "tilt_stiffness": 1e5, "axial_stiffness": 1e6}
    np.testing.assert_allclose(found, theirs(observed, stand, "bearing_flexibility", "q2", other), rtol=1e-7)


def test_all_bearings_alike_are_each_of_them(spatial):
    """Tilts of all joints on a multiple of their own stiffness; shifts so stiff that they do not count."""
    context, observed, stand = spatial
    found = ours(context, observed, "bearing_flexibility", "joints",
                 {"tilt_factor": 3.0, "damping_time": 4e-4})  # fmt: skip
    specs = []
    for joint, card in context.robot.joints.items():
        tilt = 3.0 * float(card.stiffness)
        values = {"tilt_stiffness": tilt, "radial_stiffness": 1e13, "axial_stiffness": 1e13,
                  "damping_time": 4e-4}  # fmt: skip
        specs.append((FORMS["bearing_flexibility"]["own"], Site(stand, joint, values)))
    posture = observed.postures[0]
    plant = build(stand, posture, specs)
    row = int(np.flatnonzero(observed.posture == 0)[0])
    places = []
    for point, axis in (observed.response[row], observed.reference[row]):
        place = observed.campaign.point(int(point))
        places.append(plant.row(place.link, np.array(place.xyz), np.eye(3)[axis - 1])[None])
    frequency = observed.axis.frequency
    other = -plant.inertance(*places, frequency)[:, 0, 0] / (2 * np.pi * frequency) ** 2
    np.testing.assert_allclose(found[row], other, rtol=1e-4)
