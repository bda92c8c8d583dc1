"""What the forms of the set `further` are for small motions, against closed forms on uniform bars."""

import numpy as np
import pytest

import flexmodal
from flexmodal.model.placements import link_placements
from flexmodal.rig.forms.further_drives import oscillators
from flexmodal.rig.forms.further_joints import lever
from flexmodal.rig.hammer_test import Conduct, h1, strike_posture
from flexmodal.rig.plant.build import build, sensors
from flexmodal.rig.plant.geometry import across, turn

from .conftest import FREQUENCY, B, I, K, S, inertance, pulled, put


def test_a_layered_link_is_a_beam_of_complex_rigidity(stiff, hidden):
    """Clamped and free: w/F = L³ (cosh λ sin λ − sinh λ cos λ)/(E I λ³ (1 + cosh λ cos λ)), of complex λ."""
    given = {"bending_stiffness": 900.0, "damping_ratio": 0.0, "relaxing": 1.2, "time": 4e-3}
    plant = put(stiff, hidden(stiff, "link_flexibility:layered", "link_1", **given))
    rigidity = 900.0 * (1 + 1.2 * S * 4e-3 / (1 + S * 4e-3))
    x = (-(S**2) * 4.0 / rigidity) ** 0.25
    moved = (np.cosh(x) * np.sin(x) - np.sinh(x) * np.cos(x)) / (
        rigidity * x**3 * (1 + np.cosh(x) * np.cos(x))
    )
    np.testing.assert_allclose(inertance(plant), S**2 * moved, rtol=2e-3)


def test_a_table_sways_as_a_frame_on_feet_that_turn(stiff, hidden):
    """Sideways 4 · 3 EI/h³; a tilt bends each leg by 3 EI/h and stretches it by E A w²/h."""
    given = {"bending_stiffness": 2e4, "height": 0.8, "half_width": 0.3, "half_depth": 0.2, "gyration": 0.04}
    plant = put(stiff, hidden(stiff, "base_flexibility:table", "base", **given, table_mass=60.0))
    upright = 4 * 2e4 / 0.04**2 / 0.8
    sway, height = 12 * 2e4 / 0.8**3, 0.8
    found = plant.stiffness[1:, 1:]
    np.testing.assert_allclose(np.diag(found), [sway, upright, sway * height**2 + upright * 0.3**2])
    # held at the feet, the table leans about them: that much tilt costs the legs no bending
    ahead = np.array([1.0, 0, 0])
    at = plant.motion("base", np.zeros(3))[:, 1:]
    level, tilt = ahead @ at[:3], np.cross([0, 0, 1.0], ahead) @ at[3:]
    lean = np.linalg.solve(np.array([level, at[2], tilt]), [0.8, 0.0, 1.0])
    assert lean @ found @ lean == pytest.approx(upright * 0.3**2)
    weight = sum(body.mass for body in stiff.true.bodies.values())
    bare = put(stiff, hidden(stiff, "base_flexibility:table", "base", **given, table_mass=0.0))
    added = np.diag(plant.mass - bare.mass)[1:]
    np.testing.assert_allclose(added, [60.0, 60.0, 60.0 * 0.3**2 / 3])
    assert bare.mass[1, 1] == pytest.approx(weight)


def test_a_table_in_space_yaws_on_the_swaying_of_its_legs(stand, hidden):
    bench = stand(flexmodal.load("six_axis"), references=["tool_side:+z"], postures=["work"])
    given = {"bending_stiffness": 2e5, "height": 0.8, "half_width": 0.3, "half_depth": 0.2, "gyration": 0.04}
    plant = put(bench, hidden(bench, "base_flexibility:table", "base", **given))
    at = plant.coordinates.index("base x")
    sway, upright = 12 * 2e5 / 0.8**3, 4 * 2e5 / 0.04**2 / 0.8
    wanted = [sway, sway, upright, sway * 0.64 + upright * 0.04, sway * 0.64 + upright * 0.09, sway * 0.13]
    np.testing.assert_allclose(np.diag(plant.stiffness)[at : at + 6], wanted)


def test_a_belt_stands_between_the_motor_and_the_joint(bench, hidden):
    """From the loop to the link: impedances in turn side by side with an inertia and behind a spring."""
    p, d, belt, loss, wheel, rotor = 9e4, 120.0, 2e5, 3e-4, 0.1, 0.5
    spec = hidden(
        bench, "servo_compliance:belted", "q1", proportional_gain=p, derivative_gain=d, belt_stiffness=belt,
        belt_damping_time=loss, wheel_inertia=wheel, rotor_inertia=rotor,
    )  # fmt: skip
    motor = p + d * S + rotor * S**2
    driven = 1 / (1 / (belt * (1 + loss * S)) + 1 / motor) + wheel * S**2
    row = 1 / (1 / (K + S * B) + 1 / driven)
    np.testing.assert_allclose(inertance(put(bench, spec)), S**2 / (row + S**2 * I), rtol=1e-8)


@pytest.mark.parametrize("loss", [0.03, 0.3])
def test_mini_oscillators_are_those_of_golla_and_hughes(loss, bench, hidden):
    """k + Σ a (s² + 2 ζ ω s)/(s² + 2 ζ ω s + ω²): the largest loss as given, k mid-band."""
    given = {"loss_factor": loss, "viscous": 0.5, "frequency": 12.0, "apart": 3.0, "damping_ratio": 1.5}
    plant = put(bench, hidden(bench, "structural_damping:oscillators", "joints", **given))
    omega = 2 * 1.5 * 2 * np.pi * 12.0 * np.array([1.0, 3.0])
    static, part = oscillators(loss, omega, 1.5, (2.0, 100.0))

    def law(s):
        inner = s[:, None] ** 2 + 3.0 * omega * s[:, None]
        return static + part * np.sum(inner / (inner + omega**2), axis=1)

    row = K * law(S) + 0.5 * B * S
    np.testing.assert_allclose(inertance(plant), S**2 / (row + S**2 * I), rtol=1e-8)
    fine = law(2j * np.pi * np.geomspace(2.0, 100.0, 2000))
    assert (fine.imag / fine.real).max() == pytest.approx(loss, rel=5e-3)
    assert law(2j * np.pi * np.sqrt([200.0]))[0].real == pytest.approx(1.0)


def test_a_cylinder_rubs_over_its_lever(bars, stand, hidden):
    """The lever is the rate of the length between its ends; the seal sticks, then slides at its force."""
    given = {"crank": 0.15, "distance": 0.5, "angle": 0.9, "force": 30.0, "presliding_stiffness": 2e6}
    for posture, angle in (("flat", 0.9), ("raised", 1.6)):
        bench = stand(bars(), references=["tip:+z"], postures=[posture])
        spec = hidden(bench, "coulomb_friction:cylinder", "q1", **given)
        arm = put(bench, spec).elements[0].row[0]
        around = angle + np.array([-1e-5, 1e-5])
        ends = 0.15 * np.exp(1j * around) - 0.5
        assert arm == pytest.approx(np.diff(np.abs(ends))[0] / 2e-5, rel=1e-8)
    path = np.linspace(0.0, 1e-4, 101)
    np.testing.assert_allclose(pulled(bench, spec, path), np.minimum(2e6 * path, 30.0), rtol=1e-9)
    assert lever(0.15, 0.5, np.pi) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_band_goes_slack_one_way(way, bench, hidden):
    """With the joint's spring: k u, but past the slack (1 − c) k beyond it, on that side alone."""
    spec = hidden(bench, "nonlinear_stiffness:slack", "q1", change=0.4, deflection=way * 1e-3)
    assert put(bench, spec).elements[0].row[0] == way
    path = np.linspace(-4e-3, 4e-3, 801)
    torque = K * path + pulled(bench, spec, path)
    past = np.minimum(path + 1e-3, 0.0)
    np.testing.assert_allclose(torque, K * path - 0.4 * K * past, atol=1e-9)


def test_a_seat_makes_each_joint_turn_the_other(pair, hidden):
    """By compliances: diag(1/k) + (1, r)(1, r)ᵀ/k_s; behind a motor that gives, that one's besides."""
    given = {"seat_stiffness": 9e4, "ratio": -0.6, "inertia": 0.2}
    spec = hidden(pair, "joint_coupling:seat", "q1+q2", **given)
    plant = put(pair, spec)
    shared = np.outer([1, -0.6], [1, -0.6]) / 9e4
    np.testing.assert_allclose(np.linalg.inv(plant.stiffness)[:2, :2], np.eye(2) / K + shared)
    assert plant.mass[2, 2] == pytest.approx(0.2)
    loop = {"proportional_gain": 7e4, "derivative_gain": 300.0, "rotor_inertia": 0.8}
    both = put(pair, spec, hidden(pair, "servo_compliance", "q2", **loop))
    soft = np.diag([1 / K, 1 / K + 1 / 7e4])
    np.testing.assert_allclose(np.linalg.inv(both.stiffness)[:2, :2], soft + shared)


def test_a_hanging_load_moves_up_and_down_alone(bars, stand, hidden):
    """Quickly moved the bar feels m upright and nothing sideways, which on the raised bar is a part of it."""
    given = {"mass": 0.7, "x": 0.6, "y": 0.0, "z": 0.0, "length": 0.4, "damping_ratio": 0.0}
    for posture, angle in (("flat", 0.0), ("raised", 0.7)):
        bench = stand(bars(), references=["tip:+z"], postures=[posture])
        plant = put(bench, hidden(bench, "added_mass:hanging", "link_1", **given))
        ahead, up = 0.6 * np.cos(angle), 0.6 * np.sin(angle)
        swung = 0.7 * up**2 / (1 - (2 * np.pi * FREQUENCY) ** 2 / (9.81 / 0.4))
        felt = I + 0.7 * ahead**2 + swung
        wanted = np.cos(angle) ** 2 * S**2 / (K + B * S + S**2 * felt)
        np.testing.assert_allclose(inertance(plant), wanted, rtol=1e-8)


def test_a_body_on_feet_bounces_and_rocks(stiff, hidden):
    """Poles on a link held still: √(k/m), and of shear and rocking those of two by two, by hand."""
    place = {"x": 0.8, "y": 0.0, "z": 0.0, "dx": 0.0, "dy": 0.0, "dz": 1.0}
    given = {"mass": 0.3, "frequency": 40.0, "damping_ratio": 0.0, "height": 0.1, "half_width": 0.08}
    more = {"gyration": 0.05, "shear": 0.5}
    plant = put(stiff, hidden(stiff, "local_absorber:rocking", "link_1", **place, **given, **more))
    mass, inner = plant.mass, slice(1, 4)
    h, w = 0.1, 0.08
    stiffness = np.array([[0.5, 0.0], [0.0, w**2]])
    inertia = np.array([[1.0, h], [h, h**2 + 0.05**2]])
    poles = np.sqrt(np.linalg.eigvals(np.linalg.solve(inertia, stiffness)).real)
    found = np.linalg.eigvals(np.linalg.solve(mass[inner, inner], plant.stiffness[inner, inner])).real
    wanted = 40.0 * np.sort(np.append(poles, 1.0))
    np.testing.assert_allclose(np.sort(np.sqrt(found)) / 2 / np.pi, wanted)
    # all of it moves with the link where the feet are stiff: its centre is 0.1 above the bar
    assert mass[0, 0] == pytest.approx(I + 0.3 * (0.8**2 + 0.1**2 + 0.05**2))
    # a bounce takes its momentum from the bar at the feet's distance, along the feet's direction
    assert abs(mass[0, 1]) == pytest.approx(0.3 * 0.8)
    assert abs(mass[0, 2]) == pytest.approx(0.3 * 0.1)
    assert abs(mass[0, 3]) == pytest.approx(0.3 * (0.1**2 + 0.05**2))
    signs = np.sign(mass[0, 2] * mass[0, 3])
    assert signs == np.sign(mass[2, 3])


def test_a_hand_is_felt_behind_its_flesh(bench, hidden):
    """Sensor and hand at the middle of the bar: m + m_h (ω² + 2 ζ ω s)/(s² + 2 ζ ω s + ω²)."""
    given = {"mass": 0.1, "hand_mass": 0.25, "frequency": 20.0, "damping_ratio": 0.5}
    spec = hidden(bench, "sensor_mass:held", "sensor", **given)
    loaded = build(bench, bench.plan.postures[0], [spec], ("middle", sensors(bench, [spec])["middle"]))
    own = 2 * np.pi * 20.0
    flesh = own**2 + 2 * 0.5 * own * S
    felt = I + 0.25 * (0.1 + 0.25 * flesh / (flesh + S**2))
    np.testing.assert_allclose(inertance(loaded), S**2 / (K + B * S + S**2 * felt), rtol=1e-8)


def test_a_hum_filter_takes_the_mains_away(bench, hidden):
    spec = hidden(bench, "sensor_gain:hum", "tip", frequency=50.0, width=0.2, depth=0.7)
    (shape,) = sensors(bench, [spec])["tip"].filters
    at = shape(2 * np.pi * np.array([1e-3, 50.0, 1e5]))
    np.testing.assert_allclose(at, [1.0, 0.3, 1.0], atol=1e-3)
    # half of what it takes away is taken where |f/f₀ − f₀/f| = 2 ζ
    edge = 50.0 * (0.2 + np.sqrt(1.04))
    taken = 1 - shape(2 * np.pi * np.array([edge, 2500.0 / edge]))
    np.testing.assert_allclose(np.abs(taken) ** 2, 0.7**2 / 2)


def test_a_delay_that_is_taken_out_leaves_the_sensor_early(bench, hidden):
    """Slowly moved it leads by (c − 1) τ; how much is read is what the low-pass leaves."""
    spec = hidden(bench, "time_delay:taken_out", "tip", time=1e-3, taken_out=2.2)
    (shape,) = sensors(bench, [spec])["tip"].filters
    small = np.array([1e-2])
    assert np.angle(shape(small))[0] / small[0] == pytest.approx(1.2e-3, rel=1e-6)
    omega = 2 * np.pi * 70.0
    assert abs(shape(np.array([omega]))[0]) == pytest.approx(1 / np.hypot(1, omega * 1e-3))


def test_a_sensor_farther_round_a_tube_looks_along_its_radius(bars, stand, hidden):
    """About the tube's centre marked and true place are alike, turned; so are the axes."""
    bench = stand(bars(), references=["tip:+z"], postures=["raised"], axes="xz", points=1)
    given = {"angle": 0.3, "radius": 0.12, "phase": 0.8}
    spec = hidden(bench, "sensor_misalignment:round", "tip", **given)
    sensor, axis = sensors(bench, [spec])["tip"], spec[1].vector("ax", "ay", "az")
    turned = turn(axis, 0.3)
    np.testing.assert_allclose(sensor.turned, turned)
    assert np.linalg.norm(sensor.offset) == pytest.approx(2 * 0.12 * np.sin(0.15))
    assert sensor.offset @ axis == pytest.approx(0.0, abs=1e-12)
    outward = np.linalg.solve(turned - np.eye(3) + np.outer(axis, axis), sensor.offset)
    np.testing.assert_allclose(outward, 0.12 * turn(axis, 0.8) @ across(axis, None)[0], atol=1e-12)
    quiet = Conduct(noise=0.0, scatter=0.0)
    found = h1(strike_posture(bench, bench.plan.postures[0], [spec], quiet))[0][0, 0, 0]
    plain = h1(strike_posture(bench, bench.plan.postures[0], [], quiet))[0][0, 0, 0]
    axes = link_placements(bench.robot, {"q1": 0.7})["link_1"][:3, :3]
    spin = np.cross([0, -1.0, 0], axes @ (np.array([1.0, 0, 0]) + sensor.offset))
    ways = [axes @ turned @ axes.T @ np.eye(3)[k] for k in (0, 2)]
    angular = plain[1] / np.cross([0, -1.0, 0], axes @ np.array([1.0, 0, 0]))[2]
    np.testing.assert_allclose(found, [way @ spin * angular for way in ways], atol=1e-9 * np.abs(plain).max())


def test_an_overhung_shaft_bends_as_in_the_books(bench, stand, hidden):
    """P a² (l + a)/(3 EI); in space a force and a moment at its end, by integrating M(x) along the shaft."""
    given = {"bending_stiffness": 3e4, "span": 0.15, "overhang": 0.08, "axial_stiffness": 2e8}
    plant = put(bench, hidden(bench, "bearing_flexibility:overhung", "q1", **given))
    far = 0.08**2 * 0.23 / 3 / 3e4
    np.testing.assert_allclose(np.linalg.inv(plant.stiffness[1:, 1:]), far * np.eye(2), atol=1e-6 * far)
    arm = stand(flexmodal.load("six_axis"), references=["tool_side:+z"], postures=["work"])
    joint = arm.robot.urdf.joints[0].name
    joint = joint if joint in arm.robot.joints else next(iter(arm.robot.joints))
    space = put(arm, hidden(arm, "bearing_flexibility:overhung", joint, **given))
    at = space.coordinates.index(f"{joint} bearing 1")
    soft = np.linalg.inv(space.stiffness[at : at + 5, at : at + 5])
    # moments of a unit force and a unit moment at the end, over span and overhang
    x, weight = np.polynomial.legendre.leggauss(4)
    total = np.zeros((2, 2))
    for length, moments in ((0.15, lambda u: [0.08 * u, u]), (0.08, lambda u: [0.08 * (1 - u), 0 * u + 1])):
        found = np.array(moments((x + 1) / 2))
        total += length / 2 * (weight * found) @ found.T / 3e4
    np.testing.assert_allclose(soft[np.ix_([0, 4], [0, 4])], total, rtol=1e-8)
    np.testing.assert_allclose(soft[np.ix_([1, 3], [1, 3])], total * [[1, -1], [-1, 1]], rtol=1e-8)
    assert 1 / soft[2, 2] == pytest.approx(2e8)
