"""What the forms of the table `SIXTH` are for small motions, against closed forms and second routes."""

from dataclasses import replace

import numpy as np
import pytest

import flexmodal
from flexmodal.cards import FrozenDict
from flexmodal.model.placements import link_placements
from flexmodal.rig.forms.sixth_joints import neighbour
from flexmodal.rig.hammer_test import Conduct, h1, strike_posture
from flexmodal.rig.integration.laws import LAWS
from flexmodal.rig.plant.build import build, sensors
from flexmodal.rig.plant.geometry import turn

from .conftest import B, I, K, S, inertance, measured, pulled, put, tip

G = 9.81


def bedded(rigidity, bed, depth, force, moment, count=400):
    """Shift and slope at the mouth of a deep socket, by as many elements on springs at their nodes."""
    h = depth / count
    beam = rigidity / h**3 * np.array(
        [[12, 6 * h, -12, 6 * h], [6 * h, 4 * h * h, -6 * h, 2 * h * h],
         [-12, -6 * h, 12, -6 * h], [6 * h, 2 * h * h, -6 * h, 4 * h * h]]
    )  # fmt: skip
    whole = np.zeros((2 * count + 2, 2 * count + 2))
    for number in range(count):
        whole[2 * number : 2 * number + 4, 2 * number : 2 * number + 4] += beam
    for node in range(count + 1):
        whole[2 * node, 2 * node] += bed * h * (0.5 if node in (0, count) else 1.0)
    pushed = np.zeros(2 * count + 2)
    pushed[-2:] = force, moment
    return np.linalg.solve(whole, pushed)[-2:]


def test_a_tube_gives_in_its_socket_and_bends_beyond_it(stiff, hidden):
    """A force at the end: what the bed gives, by elements, and the cantilever's x² (3 l − x)/6 E I on it."""
    given = {"bending_stiffness": 2e4, "fade": 0.15, "mouth": 0.2, "damping_ratio": 0.0}
    plant = put(stiff, hidden(stiff, "link_flexibility:socket", "link_1", **given))
    bent = np.linalg.solve(plant.stiffness, tip(plant))
    bed = 4 * 2e4 / 0.15**4
    shift, slope = bedded(2e4, bed, 1.5, 1.0, 0.8)
    assert shift == pytest.approx(0.15**3 / 2 / 2e4 + 0.8 * 0.15**2 / 2 / 2e4, rel=1e-3)
    for place in (0.45, 0.7, 1.0):
        out = place - 0.2
        wanted = shift + out * slope + out**2 * (2.4 - out) / 6 / 2e4
        assert tip(plant, place) @ bent == pytest.approx(wanted, rel=1e-3)
    assert tip(plant, 0.19) @ bent == pytest.approx(0.0, abs=1e-12)


def test_a_tube_in_a_socket_keeps_its_links_mass(bars, stand, hidden):
    """Stiff, the link is the rigid one again."""
    bench = stand(bars(), references=["tip:+z"], postures=["flat"])
    found = inertance(put(bench, hidden(bench, "link_flexibility:socket", "link_1", bending_stiffness=1e11)))
    np.testing.assert_allclose(found, S**2 / (K + B * S + S**2 * I), rtol=1e-4)


FLOOR = {"floor_mass": 300.0, "length": 3.0, "width": 3.0, "along": 0.5, "across": 0.5, "damping_ratio": 0.03}


def test_a_floor_sinks_in_its_middle_as_a_plate_does(stiff, hidden):
    """0.01160 P a²/D of a square plate (Timoshenko), nearly all of it by the modes that are kept."""
    plant = put(stiff, hidden(stiff, "base_flexibility:floor", "base", rigidity=4e5, **FLOOR))
    up = plant.motion("base", np.zeros(3))[2]
    sunk = up @ np.linalg.solve(plant.stiffness, up)
    assert sunk == pytest.approx(0.0116 * 9.0 / 4e5, rel=0.05)
    assert sunk < 0.0116 * 9.0 / 4e5
    assert np.all(plant.motion("base", np.zeros(3))[:2] == 0)
    first = plant.coordinates.index("floor 1.1")
    wanted = 2 * np.pi**2 / 9.0 * np.sqrt(4e5 / (300.0 / 9.0))
    assert np.sqrt(plant.stiffness[first, first] / 75.0) == pytest.approx(wanted)
    assert plant.damping[first, first] == pytest.approx(2 * 0.03 * 75.0 * wanted)


@pytest.mark.parametrize("flat", [True, False])
def test_a_floor_tilts_by_its_slopes(flat, stiff, stand, hidden):
    """What lies beside the root rises as the floor does there: sin sin at another place."""
    arm = stiff if flat else stand(flexmodal.load("six_axis"), references=["tool_side:+z"], postures=["work"])
    given = {**FLOOR, "width": 4.0, "along": 0.3, "across": 0.4}
    plant = put(arm, hidden(arm, "base_flexibility:floor", "base", rigidity=4e5, **given))
    at = [plant.coordinates.index(f"floor {m}.{n}") for m in (1, 2, 3) for n in (1, 2, 3)]
    root = arm.robot.urdf.root
    level = plant.motion(root, np.zeros(3))[:3, at]
    up = np.argmax(np.abs(level).sum(axis=1))
    step = 1e-4
    ways = np.eye(3)[:1] if flat else np.eye(3)[:2]
    for way in ways:
        x, y = 0.9 + step * way[0], 1.6 + step * way[1]
        wanted = [np.sin(m * np.pi * x / 3) * np.sin(n * np.pi * y / 4) for m in (1, 2, 3) for n in (1, 2, 3)]
        rises = plant.motion(root, step * way)[up, at]
        sign = 1.0 if np.allclose(rises, wanted, atol=1e-6) else -1.0
        if flat:  # which way along the plane the floor is counted is its own affair
            x = 0.9 + sign * step
            wanted = [
                np.sin(m * np.pi * x / 3) * np.sin(n * np.pi * 0.4) for m in (1, 2, 3) for n in (1, 2, 3)
            ]
        np.testing.assert_allclose(rises, wanted, atol=1e-6)


def test_a_torque_arm_gives_behind_the_loop(bench, hidden):
    """Joint, rotor in its housing and housing on its bush, each in its own balance of torques."""
    given = {
        "proportional_gain": 9e4, "derivative_gain": 250.0, "rotor_inertia": 0.9, "bush_stiffness": 1.4e5,
        "bush_loss": 0.1, "housing_inertia": 0.5,
    }  # fmt: skip
    plant = put(bench, hidden(bench, "servo_compliance:torque_arm", "q1", **given))
    joint, loop = K + B * S, 9e4 + 250.0 * S
    bush = 1.4e5 + 0.1 * np.sqrt(1.4e5 * 0.5) * S + 0.5 * S**2
    rotor = loop + 0.9 * S**2
    row = 1 / (1 / joint + 1 / rotor + 1 / bush)  # the same torque goes through all three
    np.testing.assert_allclose(inertance(plant), S**2 / (row + S**2 * I), rtol=1e-8)


def test_loss_lies_higher_in_a_gear_that_is_warm(bars, stand, hidden):
    """A bell of relaxations in each posture, whose largest loss is the same and lies at another frequency."""
    bench = stand(bars(), references=["tip:+z"], postures=["flat", "raised"])
    given = {"loss_factor": 0.1, "viscous": 0.0, "width": 1.0, "frequency": 8.0, "warming": 5.0}
    spec = hidden(bench, "structural_damping:warming", "joints", **given)
    frequency = np.geomspace(0.05, 3000.0, 4000)
    peaks, slow, fast = [], [], []
    for posture in bench.plan.postures:
        plant = build(bench, posture, [spec])
        assert plant.damping[0, 0] == pytest.approx(0.0, abs=1e-9)
        value = plant.stiffness[0, 0] + 0j
        for branch in plant.branches:
            lag = 2j * np.pi * frequency * branch.time
            value = value + branch.stiffness * lag / (1 + lag)
        loss = value.imag / value.real
        assert loss.max() == pytest.approx(0.1, rel=1e-3)
        peaks.append(frequency[np.argmax(value.imag)])
        slow.append(value[0].real)
        fast.append(value[-1].real)
        if posture is bench.plan.postures[0]:
            assert np.interp(np.sqrt(200.0), frequency, value.real) == pytest.approx(K, rel=1e-4)
    assert peaks[0] == pytest.approx(8.0, rel=0.01)
    assert peaks[1] / peaks[0] == pytest.approx(5.0, rel=0.01)
    np.testing.assert_allclose([slow[1], fast[1]], [slow[0], fast[0]], rtol=5e-3)


def test_a_tool_that_is_held_ties_two_joints_by_the_jacobian(pair, hidden):
    """Two bars, the inner one raised: k uᵀ j jᵀ u with the tip's motion by finite differences."""
    given = {"stiffness": 2e4, "damping_time": 1e-3, "dx": 0.6, "dy": 0.0, "dz": 0.8}
    spec = hidden(pair, "joint_coupling:tool_held", "q1+q2", **given)
    asked = {"q1": 0.4, "q2": -0.9}
    posture = replace(pair.plan.postures[0], q=FrozenDict(asked))
    plant, plain = build(pair, posture, [spec]), build(pair, posture, [])

    def along(**off):
        placed = link_placements(pair.robot, {name: asked[name] + off.get(name, 0.0) for name in asked})
        return np.array([0.6, 0.0, 0.8]) @ (placed["link_2"] @ [1.0, 0, 0, 1.0])[:3]

    row = np.array([(along(**{name: 1e-5}) - along(**{name: -1e-5})) / 2e-5 for name in asked])
    np.testing.assert_allclose(plant.stiffness - plain.stiffness, 2e4 * np.outer(row, row), rtol=1e-6)
    np.testing.assert_allclose(plant.damping - plain.damping, 20.0 * np.outer(row, row), rtol=1e-6)


def test_nested_shafts_rub_by_how_they_turn_against_each_other(pair, hidden):
    """Out: F (1 − e^(−σ u/F)); nothing at all where one turns as far as the other takes its shaft."""
    given = {"torque": 5.0, "presliding_stiffness": 2e5, "ratio": 0.6}
    spec = hidden(pair, "coulomb_friction:nested", "q1", **given)
    path = np.linspace(0, 3e-4, 600)
    np.testing.assert_allclose(pulled(pair, spec, path), 5.0 * (1 - np.exp(-2e5 * path / 5.0)), rtol=1e-9)
    (element,) = put(pair, spec).elements
    np.testing.assert_allclose(element.row, [1.0, -0.6])
    assert element.row @ [0.6e-3, 1e-3] == pytest.approx(0.0, abs=1e-18)
    assert (neighbour(pair.robot, "q1"), neighbour(pair.robot, "q2")) == ("q2", "q1")


def test_a_joint_alone_has_no_shaft_within(bench, pair):
    from flexmodal.rig.forms import find

    effect = find("coulomb_friction", "nested")
    assert effect.places(bench.robot, bench.plan.points) == ()
    assert effect.places(pair.robot, pair.plan.points) == ("q1", "q2")


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_worm_lifts_off_one_way(sign, bench, hidden):
    """q = τ/k + θ with θ = τ/k₂ up to τ₀ that way, τ₀/k₂ + (τ − τ₀)/(p k₂) beyond."""
    given = {"softer": 1.2, "torque": sign * 9.0, "pack": 0.25, "frequency": 250.0, "damping_time": 5e-4}
    plant = put(bench, hidden(bench, "nonlinear_stiffness:worm", "q1", **given))
    seated = K / 1.2
    (element,) = plant.elements
    law, numbers = LAWS[element.kind], np.array(element.parameters)
    for torque in (1e-3, 8.9, -8.9, 12.0, -12.0, 60.0, -60.0):
        beyond = max(sign * torque - 9.0, 0.0)
        turned = torque / seated + sign * beyond * (1 / 0.25 - 1) / seated
        at = np.array([torque / K + turned, turned])
        pull, _ = law(numbers, np.zeros(1), np.array([element.row @ at]), np.zeros(1), np.zeros(1))
        np.testing.assert_allclose(plant.stiffness @ at + element.row * pull, [torque, 0.0], atol=1e-7)
    assert plant.mass[1, 1] == pytest.approx((K + seated) / (2 * np.pi * 250.0) ** 2)


def test_a_worm_that_never_lifts_off_is_a_spring_behind(bars, stand, hidden):
    """Struck in time, under a preload that no blow reaches."""
    bench = stand(bars(damping=60.0), references=["tip:+z"], postures=["flat"])
    given = {"softer": 1.0, "torque": 1e8, "pack": 0.25, "frequency": 250.0, "damping_time": 5e-4}
    found = measured(bench, hidden(bench, "nonlinear_stiffness:worm", "q1", **given))[-1]
    frequency = np.fft.rfftfreq(bench.plan.analyser.samples, bench.plan.analyser.interval)
    s = 2j * np.pi * frequency
    behind = K * (1 + 5e-4 * s) + 2 * K / (2 * np.pi * 250.0) ** 2 * s**2
    wanted = s**2 / (1 / (1 / (K + s * 60.0) + 1 / behind) + s**2 * I)
    inside = (frequency >= 4) & (frequency <= 100)
    np.testing.assert_allclose(found[inside], wanted[inside], atol=5e-3 * np.abs(wanted[inside]).max())


@pytest.mark.parametrize("lift", [0.0, 0.8])
def test_a_bearing_stiffens_by_the_cube_root_of_its_load(lift, bench, hidden):
    """A bar on one tooth 0.1 m away that holds 4 g cos/2: both forces added as they stand."""
    posture = replace(bench.plan.postures[0], q=FrozenDict({"q1": lift}))
    given = {
        "tilt_stiffness": 3e5, "radial_stiffness": 2e7, "axial_stiffness": 1e7, "damping_time": 3e-4,
        "radius": 0.1, "mesh": 0.7, "load": 150.0, "preload": 0.1,
    }  # fmt: skip
    plant = build(bench, posture, [hidden(bench, "bearing_flexibility:by_load", "q1", **given)])
    held = 4 * G * 0.5 * np.cos(lift) / 0.1
    carried = np.sqrt(held**2 + (4 * G) ** 2 - 2 * held * 4 * G * np.cos(0.7))  # the law of cosines
    wanted = 2e7 * ((carried / 150.0 + 0.1) / 1.1) ** (1 / 3)
    found = plant.stiffness[1:, 1:]
    assert found[0, 0] == pytest.approx(found[1, 1])
    assert found[0, 1] == pytest.approx(0.0, abs=1e-6)
    assert found[0, 0] == pytest.approx(wanted, rel=2e-3)
    np.testing.assert_allclose(plant.damping[1:, 1:], 3e-4 * found)


def test_a_loaded_bearing_in_space_has_five_springs(stand, hidden):
    """All of them in one proportion."""
    arm = stand(flexmodal.load("six_axis"), references=["tool_side:+z"], postures=["work"])
    given = {"tilt_stiffness": 3e5, "radial_stiffness": 2e7, "axial_stiffness": 1e7}
    plant = put(arm, hidden(arm, "bearing_flexibility:by_load", "q3", **given))
    at = plant.coordinates.index("q3 bearing 1")
    found = plant.stiffness[at : at + 5, at : at + 5]
    np.testing.assert_allclose(found, found[0, 0] / 2e7 * np.diag([2e7, 2e7, 1e7, 3e5, 3e5]), atol=1e-3)
    assert found[0, 0] == pytest.approx(2e7, rel=1e-6)  # the only posture is the one that loads it most


def test_a_jacket_lies_over_all_links_beyond(pair, hidden):
    """A hundred thousand crumbs on two tubes, moved by both joints."""
    given = {"mass": 3.0, "radius": 0.12}
    random = np.random.default_rng(2)
    place, angle = random.uniform(0, 2, 200000), random.uniform(0, 2 * np.pi, 200000)
    height = 0.12 * np.sin(angle)
    inner = np.stack([-height, place])  # by the first joint; along x and up
    outer = np.where(place > 1, np.stack([-height, place - 1]), 0.0)
    for where, part in (("link_1", np.ones(len(place))), ("link_2", (place > 1) * 2.0)):
        plant = put(pair, hidden(pair, "added_mass:jacket", where, **given))
        added = plant.mass - put(pair).mass
        rows = np.stack([inner, outer])
        wanted = 3.0 * np.einsum("akn,bkn,n->ab", rows, rows, part) / len(place)
        np.testing.assert_allclose(added, wanted, rtol=0.02)


def test_a_bar_on_a_swivel_feels_turns_alone(bench, hidden):
    """m r² goes along; m l²/12 swings: J s² (k + c s)/(J s² + c s + k) about the joint."""
    place = {"x": 0.6, "y": 0.0, "z": 0.1, "dx": 1.0, "dy": 0.0, "dz": 0.0}
    given = {"mass": 0.8, "frequency": 30.0, "damping_ratio": 0.04, "long": 0.9}
    found = inertance(put(bench, hidden(bench, "local_absorber:swivel", "link_1", **place, **given)))
    moment, omega = 0.8 * 0.9**2 / 12, 2 * np.pi * 30.0
    spring = moment * (omega**2 + 2 * 0.04 * omega * S)
    swung = moment * S**2 * spring / (moment * S**2 + spring)
    rigid = I + 0.8 * (0.6**2 + 0.1**2)
    np.testing.assert_allclose(found, S**2 / (K + B * S + rigid * S**2 + swung), rtol=1e-8)


def test_a_bar_on_a_swivel_in_space_turns_about_one_axis(stand, hidden):
    """Held still it is a slender bar: m l²/12 about both axes across it, nothing along it."""
    arm = stand(flexmodal.load("six_axis"), references=["tool_side:+z"], postures=["work"])
    link = "link_3" if "link_3" in {one.name for one in arm.robot.urdf.links} else arm.robot.tool
    place = {"x": 0.1, "y": 0.0, "z": 0.0, "dx": 0.0, "dy": 0.6, "dz": 0.8}
    given = {"mass": 0.8, "long": 0.9, **place}
    plant, plain = put(arm, hidden(arm, "local_absorber:swivel", link, **given)), put(arm)
    n = plain.dof
    motion, axes = plain.motion(link, np.array([0.1, 0, 0])), plain.orientation(link)
    bar = axes @ [0.0, 0.6, 0.8]
    tensor = 0.8 * 0.81 / 12 * (np.eye(3) - np.outer(bar, bar))
    wanted = 0.8 * motion[:3].T @ motion[:3] + motion[3:].T @ tensor @ motion[3:]
    np.testing.assert_allclose(plant.mass[:n, :n] - plain.mass, wanted, atol=1e-9)
    assert plant.mass[n, n] == pytest.approx(0.8 * 0.81 / 12)


@pytest.mark.parametrize("point", ["middle", "tip"])
def test_pads_weigh_on_every_point(point, bench, hidden):
    """A bar with pads in its middle and at its tip, and the sensor on one of them."""
    at = {"middle": 0.5, "tip": 1.0}
    spec = hidden(bench, "sensor_mass:pads", "sensor", mass=0.2, pad_mass=0.07)
    loaded = build(bench, bench.plan.postures[0], [spec], (point, sensors(bench, [spec])[point]))
    assert loaded.mass[0, 0] == pytest.approx(I + 0.07 * (0.5**2 + 1.0) + 0.2 * at[point] ** 2, rel=1e-9)


OWN = {
    "sensor_gain:battery": ({"drop": 0.4, "bend": 2.0}, "error", (-0.1, -0.4)),
    "time_delay:restarted": ({"delay": 1e-3, "first": 0.7}, "delay", (0.7e-3, 0.3180339887e-3)),
}
"""What they are in each of two postures, as numbers of the rig's own forms."""


@pytest.mark.parametrize("key", OWN)
def test_some_things_are_others_in_each_posture(key, bars, stand, hidden):
    bench = stand(bars(), references=["tip:+z"], postures=["flat", "raised"], axes="xz")
    given, number, sizes = OWN[key]
    name, quiet = key.split(":")[0], Conduct(noise=0.0, scatter=0.0)
    for posture, size in zip(bench.plan.postures, sizes, strict=True):
        spec, same = hidden(bench, key, "tip", **given), hidden(bench, name, "tip", **{number: size})
        found, wanted = (h1(strike_posture(bench, posture, [one], quiet))[0] for one in (spec, same))
        np.testing.assert_allclose(found, wanted, rtol=1e-7, atol=1e-9 * np.abs(wanted).max())


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_sensor_in_a_clip_falls_to_the_lower_side(side, bars, stand, hidden):
    """Of both ends of its play it lies at that where its mass is lower: another one as the bar leans over."""
    bench = stand(bars(), references=["tip:+z"], postures=[{"q1": 0.5}, {"q1": -0.5}])
    pin, up = np.array([0.0, -1.0, 0.0]), np.array([0.0, 0.0, 1.0])
    given = {"angle": 0.2, "ax": 0.0, "ay": -1.0, "az": 0.0, "ox": 0.0, "oy": 0.0, "oz": side}
    sensor = sensors(bench, [hidden(bench, "sensor_misalignment:clip", "tip", **given)])["tip"]
    lies = []
    for angle in (0.5, -0.5):
        axes = link_placements(bench.robot, {"q1": angle})["link_1"][:3, :3]
        lies.append(min((0.2, -0.2), key=lambda way: (turn(pin, way) @ (side * axes[:, 2]))[2]))
        np.testing.assert_allclose(sensor.direction(axes, up), turn(pin, lies[-1]) @ up, atol=1e-12)
    assert lies[0] == -lies[1]
