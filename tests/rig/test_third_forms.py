"""What the forms of the set `third` are for small motions, against closed forms on uniform bars."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad

import flexmodal
from flexmodal.cards import FrozenDict
from flexmodal.model.placements import link_placements
from flexmodal.rig.forms.third_drives import creeping
from flexmodal.rig.hammer_test import Conduct, h1, strike_posture
from flexmodal.rig.integration.laws import LAWS
from flexmodal.rig.plant.build import build, sensors
from flexmodal.rig.plant.geometry import turn

from .conftest import FREQUENCY, B, I, K, S, inertance, put, tip


def test_a_telescope_gives_as_a_bar_on_two_springs(stiff, hidden):
    """A force at the tip presses both pads by its levers: F ((L − x₁)²/k₂ + (L − x₂)²/k₁)/(x₂ − x₁)²."""
    given = {"pad_stiffness": 3e5, "place": 0.3, "overlap": 0.2, "far": 0.6, "damping_ratio": 0.0}
    plant = put(stiff, hidden(stiff, "link_flexibility:telescoped", "link_1", **given))
    row = tip(plant)
    wanted = (0.7**2 / (0.6 * 3e5) + 0.5**2 / 3e5) / 0.2**2
    assert row @ np.linalg.solve(plant.stiffness, row) == pytest.approx(wanted, rel=1e-6)
    # what the outer tube covers stays where it is, what stands out moves in a straight line
    moved = [tip(plant, place)[1:] for place in (0.45, 0.55, 0.75, 0.95)]
    np.testing.assert_allclose(moved[0], 0.0, atol=1e-12)
    np.testing.assert_allclose(moved[1] + moved[3], 2 * moved[2], atol=1e-12)
    np.testing.assert_allclose(np.abs(moved[1]), np.abs([(0.5 - 0.55) / 0.2, (0.55 - 0.3) / 0.2]))


def test_mounts_that_lean_carry_as_springs_of_rubber(stiff, hidden):
    """Sums over four mounts by hand, times (1 + c s^α) over its real part mid-band."""
    given = {"mount_stiffness": 2e5, "shear": 0.3, "inclination": 0.5, "half_width": 0.4, "below": 0.15}
    rubber = {"loss_factor": 0.15, "order": 0.35, "half_depth": 0.3}
    plant = put(stiff, hidden(stiff, "base_flexibility:rubber_mounts", "base", **given, **rubber))
    c, s = np.cos(0.5), np.sin(0.5)
    across, upright = 4 * 2e5 * (s**2 + 0.3 * c**2), 4 * 2e5 * (c**2 + 0.3 * s**2)
    # along, c up ∓ s ahead at ±w: a shift ahead makes it ∓s, a tilt that lifts the front ±(w c − h s);
    # across, ±s up + c ahead: c, and w s + h c
    tilt = 4 * 2e5 * ((0.4 * c - 0.15 * s) ** 2 + 0.3 * (0.4 * s + 0.15 * c) ** 2)
    mixed = 4 * 2e5 * (0.3 * c * (0.4 * s + 0.15 * c) - s * (0.4 * c - 0.15 * s))
    ahead, at = np.array([1.0, 0, 0]), plant.motion("base", np.zeros(3))[:, 1:]
    way = np.array([ahead @ at[:3], at[2], np.array([0, -1.0, 0]) @ at[3:]])
    static = np.array([[across, 0, mixed], [0, upright, 0], [mixed, 0, tilt]])
    signs = np.sign(np.diag(way))
    np.testing.assert_allclose(way, np.diag(signs), atol=1e-12)

    def found(s_):
        value = plant.stiffness.astype(complex) + s_ * plant.damping
        for one in plant.branches:
            lag = s_ * one.time
            value = value + one.stiffness * lag / (1 + lag) * np.outer(one.row, one.row)
        return signs[:, None] * value[1:, 1:] * signs

    middle = 2j * np.pi * np.sqrt(200.0)
    law = middle**0.35
    size = 0.15 / (law.imag - 0.15 * law.real)
    for line in (4.0, np.sqrt(200.0), 80.0):
        wanted = (1 + size * (2j * np.pi * line) ** 0.35) / (1 + size * law.real)
        value = found(2j * np.pi * line)
        np.testing.assert_allclose(value, static * wanted, rtol=0.01, atol=1e-3)


def test_mounts_in_space_hold_a_yaw_by_their_levers(stand, hidden):
    bench = stand(flexmodal.load("six_axis"), references=["tool_side:+z"], postures=["work"])
    given = {"mount_stiffness": 2e5, "shear": 0.3, "inclination": 0.5, "half_width": 0.4, "below": 0.15}
    spec = hidden(bench, "base_flexibility:rubber_mounts", "base", **given, half_depth=0.3, loss_factor=1e-9)
    plant = put(bench, spec)
    at = plant.coordinates.index("base x")
    c, s = np.cos(0.5), np.sin(0.5)
    k, across = 4 * 2e5, s**2 + 0.3 * c**2
    upright = c**2 + 0.3 * s**2
    wanted = [
        k * across, k * 0.3, k * upright, k * (0.3 * 0.15**2 + upright * 0.3**2),
        k * ((0.4 * c - 0.15 * s) ** 2 + 0.3 * (0.4 * s + 0.15 * c) ** 2), k * (across * 0.09 + 0.3 * 0.16),
    ]  # fmt: skip
    np.testing.assert_allclose(np.diag(plant.stiffness)[at : at + 6], wanted, rtol=1e-6)


def test_acceleration_that_is_fed_back_weighs_and_damps(bench, hidden):
    """From the loop to the link: K_P + K_D s + J s² + K_A s²/(1 + T s), behind the joint's spring."""
    p, d, rotor, fed, time = 9e4, 120.0, 0.3, 0.4, 1.5e-3
    spec = hidden(
        bench, "servo_compliance:accelerated", "q1", proportional_gain=p, derivative_gain=d,
        rotor_inertia=rotor, acceleration_gain=fed, filter_time=time,
    )  # fmt: skip
    motor = p + d * S + (rotor + fed / (1 + time * S)) * S**2
    row = 1 / (1 / (K + S * B) + 1 / motor)
    np.testing.assert_allclose(inertance(put(bench, spec)), S**2 / (row + S**2 * I), rtol=1e-8)


@pytest.mark.parametrize("loss", [0.03, 0.3])
def test_creep_by_the_logarithm_of_time_is_what_the_springs_do(loss, bench, hidden):
    """Compliance 1 + q iω ∫ ln(1 + a t) e^{−iωt} dt by quadrature; its loss factor is the springs'."""
    given = {"loss_factor": loss, "viscous": 0.5, "ceasing": 20.0}
    plant = put(bench, hidden(bench, "structural_damping:creeping", "joints", **given))
    made = creeping(loss, 20.0, (2.0, 100.0))
    row = K * made.modulus(S / 1j) + 0.5 * B * S
    np.testing.assert_allclose(inertance(plant), S**2 / (row + S**2 * I), rtol=1e-8)

    def flowed(line):
        ratio = line / 20.0  # with a t for time: q ∫ e^{−i r u}/(1 + u) du, after one step of parts
        real = quad(lambda u: 1 / (1 + u), 0, np.inf, weight="cos", wvar=ratio)[0]
        return real - 1j * quad(lambda u: 1 / (1 + u), 0, np.inf, weight="sin", wvar=ratio)[0]

    lines = np.array([3.0, 8.0, 20.0, 45.0, 90.0])
    flow = np.array([flowed(line) for line in lines])
    value = made.modulus(2 * np.pi * lines)
    found = value.imag / value.real
    # q from one line, and the others by it
    size = found[2] / (-flow[2].imag - found[2] * flow[2].real)
    wanted = -size * flow.imag / (1 + size * flow.real)
    np.testing.assert_allclose(found, wanted, rtol=0.02)
    every = made.modulus(2 * np.pi * np.geomspace(2.0, 100.0, 300))
    assert (every.imag / every.real).max() == pytest.approx(loss, rel=0.02)
    assert made.modulus(np.array([2 * np.pi * np.sqrt(200.0)]))[0].real == pytest.approx(1.0)


def test_oil_flows_over_while_it_has_time(pair, hidden):
    """Two springs with what flows between them: k − k²/(2 k + R s), and k alone where it is quick."""
    given = {"stiffness": 3e4, "ratio": -0.7, "time": 4e-3}
    plant = put(pair, hidden(pair, "joint_coupling:oil_line", "q1+q2", **given))
    resistance = 2 * 3e4 * 4e-3
    levers = np.array([1.0, -0.7])
    for line in (1e-3, 5.0, 40.0, 1e6):
        s = 2j * np.pi * line
        value = plant.stiffness.astype(complex)
        (one,) = plant.branches
        value = value + one.stiffness * s * one.time / (1 + s * one.time) * np.outer(one.row, one.row)
        shared = 3e4**2 / (2 * 3e4 + resistance * s)
        oil = 3e4 * np.eye(2) - shared * np.ones((2, 2))
        np.testing.assert_allclose(value - K * np.eye(2), levers[:, None] * oil * levers, rtol=1e-6, atol=1.0)
    # a joint that is turned slowly turns the other one, as far as its ratio says
    slow = plant.stiffness
    assert slow[0, 1] == pytest.approx(0.7 * 3e4 / 2)


def test_an_eccentric_gear_rubs_by_its_angle(bars, stand, hidden):
    given = {"torque": 5.0, "uneven": 0.6, "times": 2.0, "phase": 0.4, "presliding_stiffness": 2e5}
    for posture, angle in (("flat", 0.0), ("raised", 0.7)):
        bench = stand(bars(), references=["tip:+z"], postures=[posture])
        (element,) = put(bench, hidden(bench, "coulomb_friction:eccentric", "q1", **given)).elements
        law, numbers = LAWS[element.kind], np.array(element.parameters)
        start, far = np.zeros(1), np.ones(1)
        pull, _ = law(numbers, start, far, far, start)
        assert pull[0] == pytest.approx(5.0 * (1 + 0.6 * np.cos(2 * angle + 0.4)))
        little, _ = law(numbers, start, 1e-9 * far, far, start)
        assert little[0] == pytest.approx(2e5 * 1e-9, rel=1e-3)


def test_a_spider_winds_up_behind_the_joint(bench, hidden):
    """Slowly turned, q = τ/k + u_r arsinh(τ/(k₂ u_r)); small and quick, k₂ with its hub, and k on it."""
    given = {"softer": 0.8, "deflection": 2e-4, "frequency": 250.0, "damping_time": 5e-4}
    plant = put(bench, hidden(bench, "nonlinear_stiffness:spider", "q1", **given))
    own = K / 0.8
    (element,) = plant.elements
    law, numbers = LAWS[element.kind], np.array(element.parameters)
    for torque in (0.5, 5.0, 20.0, -20.0):
        wound = 2e-4 * np.arcsinh(torque / (own * 2e-4))
        joint = torque / K + wound
        at = np.array([joint, wound])
        pull, _ = law(numbers, np.zeros(1), np.array([element.row @ at]), np.zeros(1), np.zeros(1))
        np.testing.assert_allclose(plant.stiffness @ at + element.row * pull, [torque, 0.0], atol=1e-9 * own)
    hub = (K + own) / (2 * np.pi * 250.0) ** 2
    behind = own * (1 + 5e-4 * S) + hub * S**2
    row = 1 / (1 / (K + S * B) + 1 / behind)
    np.testing.assert_allclose(inertance(plant), S**2 / (row + S**2 * I), rtol=1e-8)


def test_liquid_in_a_pipe_is_moved_sideways_alone(pair, hidden):
    """m (x₁² + x₁ x₂ + x₂²)/3, its ends from either joint of a stretched arm."""
    given = {"mass": 1.2, "x": 0.2, "y": 0.0, "z": 0.0, "x2": 0.9, "y2": 0.0, "z2": 0.0}
    bare = build(pair, pair.plan.postures[0], [])
    spec = hidden(pair, "added_mass:pipe", "link_2", **given)
    added = put(pair, spec).mass - bare.mass

    def moment(start, end):
        return 1.2 * (start**2 + start * end + end**2) / 3

    middle = 1.2 * 0.55
    np.testing.assert_allclose(added, [
        [moment(1.2, 1.9), moment(0.2, 0.9) + middle], [moment(0.2, 0.9) + middle, moment(0.2, 0.9)],
    ])  # fmt: skip


def test_a_pipe_square_to_the_arm_is_not_taken_along_by_what_goes_its_way(bars, stand, hidden):
    """The second bar upright: the first joint moves it along itself, and aside by its own height."""
    robot = bars(count=2)
    bench = stand(robot, references=["tip:+z"], postures=["flat"])
    given = {"mass": 1.2, "x": 0.2, "y": 0.0, "z": 0.0, "x2": 0.9, "y2": 0.0, "z2": 0.0}
    spec = hidden(bench, "added_mass:pipe", "link_2", **given)
    posture = bench.plan.postures[0]
    raised = replace(posture, q=FrozenDict({"q1": 0.0, "q2": np.pi / 2}))
    added = build(bench, raised, [spec]).mass - build(bench, raised, []).mass
    own = 1.2 * (0.2**2 + 0.2 * 0.9 + 0.9**2) / 3
    np.testing.assert_allclose(added, np.full((2, 2), own))


def test_a_panel_swings_as_a_plate_held_at_its_edges(stiff, hidden):
    """Effective masses by integrating sin(nπx/a) sin(πy/b); frequencies as n²/a² + 1/b²; none lost."""
    place = {"x": 0.6, "y": 0.0, "z": 0.05, "dx": 0.0, "dy": 0.0, "dz": 1.0}
    given = {"mass": 0.4, "frequency": 30.0, "damping_ratio": 0.0, "length": 0.5, "width": 0.25}
    plant = put(stiff, hidden(stiff, "local_absorber:panel", "link_1", **place, **given))
    assert plant.dof == 4
    inner = np.diag(plant.mass)[1:]
    x, weight = (np.polynomial.legendre.leggauss(30)[0] + 1) / 2, np.polynomial.legendre.leggauss(30)[1] / 2
    aside = weight @ np.sin(np.pi * x)
    for n, lever in ((1, 1.0), (2, 0.5 * (x - 0.5)), (3, 1.0)):
        shape = np.sin(n * np.pi * x)
        swung = 0.4 * (weight @ (lever * shape)) * aside  # ∫ of the sheet's mass by lever and shape
        assert inner[n - 1] == pytest.approx(swung**2 / (0.4 / 4), rel=1e-9)
    omega = np.sqrt(np.diag(plant.stiffness)[1:] / inner)
    np.testing.assert_allclose(omega / 2 / np.pi, 30.0 * (np.array([1, 4, 9]) / 0.25 + 16) / 20)
    # held in its shape it is a rigid sheet, off the joint by (0.6, 0.05) and 0.5 m long
    assert plant.mass[0, 0] == pytest.approx(I + 0.4 * (0.6**2 + 0.05**2 + 0.5**2 / 12))
    assert abs(plant.mass[0, 1]) == pytest.approx(inner[0] * 0.6)
    assert abs(plant.mass[0, 2]) == pytest.approx(inner[1])


def test_a_cable_that_whips_is_felt_by_its_modes(bench, hidden):
    """Sensor at the middle of the bar, cable along it: m + Σ parts at their heights, each ω²/(ω² + s²)."""
    given = {"mass": 0.1, "cable_mass": 0.2, "length": 0.2, "frequency": 25.0, "damping_ratio": 0.04}
    spec = hidden(bench, "sensor_mass:whipping", "sensor", **given)
    loaded = build(bench, bench.plan.postures[0], [spec], ("middle", sensors(bench, [spec])["middle"]))
    still = I + 0.1 * 0.25
    # the modes of a clamped beam: βL, and of w = cosh − cos − σ (sinh − sin) the mass and its height
    x, weight = (np.polynomial.legendre.leggauss(40)[0] + 1) / 2, np.polynomial.legendre.leggauss(40)[1] / 2
    left, first = 1.0, 0.5
    for beta in (1.8751040687, 4.6940911330):
        sigma = (np.cosh(beta) + np.cos(beta)) / (np.sinh(beta) + np.sin(beta))
        shape = np.cosh(beta * x) - np.cos(beta * x) - sigma * (np.sinh(beta * x) - np.sin(beta * x))
        part = (weight @ shape) ** 2 / (weight @ shape**2)
        high = (weight @ (x * shape)) / (weight @ shape)
        omega = 2 * np.pi * 25.0 * (beta / 1.8751040687) ** 2
        flows = omega**2 + 2 * 0.04 * omega * S
        still = still + 0.2 * part * (0.5 + 0.2 * high) ** 2 * flows / (flows + S**2)
        left, first = left - part, first - part * high
    still = still + 0.2 * left * (0.5 + 0.2 * first / left) ** 2
    np.testing.assert_allclose(inertance(loaded), S**2 / (K + B * S + S**2 * still), rtol=1e-3)


def test_a_resonance_taken_out_in_vain_leaves_its_inverse(bench, hidden):
    given = {"resonance": 180.0, "damping_ratio": 0.05}
    (wrong,) = sensors(bench, [hidden(bench, "sensor_gain:equalised", "tip", **given)])["tip"].filters
    (mount,) = sensors(bench, [hidden(bench, "sensor_gain:resonant", "tip", **given)])["tip"].filters
    omega = 2 * np.pi * FREQUENCY
    np.testing.assert_allclose(wrong(omega) * mount(omega), 1.0)
    assert wrong(2 * np.pi * np.array([90.0]))[0] == pytest.approx(0.75 + 0.05j)


def test_values_between_the_last_two_are_late_and_too_small(bench, hidden):
    """A wave that is sampled and joined by straight lines, read d of the way back."""
    given = {"time": 1.2e-3, "part": 0.4}
    (shape,) = sensors(bench, [hidden(bench, "time_delay:interpolated", "tip", **given)])["tip"].filters
    small = np.array([1e-2])
    assert -np.angle(shape(small))[0] / small[0] == pytest.approx(1.2e-3, rel=1e-6)
    omega, step = 2 * np.pi * 70.0, 1.2e-3 / 0.4
    times = step * np.arange(50)
    wave = np.exp(1j * omega * times)
    read = np.interp(times[1:] - 0.4 * step, times, wave)
    np.testing.assert_allclose(read / wave[1:], shape(np.array([omega]))[0])


def test_a_sensor_sags_as_far_as_it_stands_out_level(bars, stand, hidden):
    """On a bar at 0.7 rad it stands off the vertical by as much: it turns by α sin 0.7, to the floor."""
    for posture, lift in (("flat", 0.0), ("raised", 0.7)):
        bench = stand(bars(), references=["tip:+z"], postures=[posture], axes="xz", points=1)
        given = {"angle": 0.4, "nx": 0.0, "ny": 0.0, "nz": 1.0}
        spec = hidden(bench, "sensor_misalignment:sagging", "tip", **given)
        sensor = sensors(bench, [spec])["tip"]
        axes = link_placements(bench.robot, {"q1": lift})["link_1"][:3, :3]
        normal = axes @ np.array([0.0, 0.0, 1.0])
        sagged = sensor.direction(axes, normal)
        # cos of the angle to "down" before and after: π − 0.7, and less by what it turned
        before, after = np.arccos(-normal[2]), np.arccos(np.clip(-sagged[2], -1, 1))
        assert before - after == pytest.approx(0.4 * np.sin(lift), abs=1e-7)
        assert sagged[1] == pytest.approx(0.0, abs=1e-12)
        quiet = Conduct(noise=0.0, scatter=0.0)
        found = h1(strike_posture(bench, bench.plan.postures[0], [spec], quiet))[0][0, 0, 0]
        plain = h1(strike_posture(bench, bench.plan.postures[0], [], quiet))[0][0, 0, 0]
        turned = turn(np.array([0.0, -1.0, 0.0]), 0.4 * np.sin(lift))
        ways = np.array([turned @ np.eye(3)[k] for k in (0, 2)])
        wanted = ways[:, [0, 2]] @ plain
        np.testing.assert_allclose(found, wanted, atol=1e-9 * np.abs(plain).max())


def test_a_bearing_lies_in_its_weight_however_the_arm_stands(bars, stand, hidden):
    """In the world k up and down and ρ k level, on a flat bar and on a raised one."""
    given = {"radial_stiffness": 3e7, "ratio": 0.3, "damping_time": 0.0}
    for posture in ("flat", "raised"):
        bench = stand(bars(), references=["tip:+z"], postures=[posture])
        plant = put(bench, hidden(bench, "bearing_flexibility:load_zone", "q1", **given))
        moved = plant.motion("link_1", np.zeros(3))[[0, 2], 1:]
        stiffness = np.linalg.inv(moved @ np.linalg.inv(plant.stiffness[1:, 1:]) @ moved.T)
        np.testing.assert_allclose(stiffness, np.diag([0.3 * 3e7, 3e7]), atol=1.0)


def test_a_bearing_in_space_tilts_less_where_the_weight_holds_it(stand, hidden):
    arm = stand(flexmodal.load("six_axis"), references=["tool_side:+z"], postures=["work"])
    given = {"radial_stiffness": 3e7, "tilt_stiffness": 2e5, "axial_stiffness": 5e7, "ratio": 0.3}
    placed = link_placements(arm.robot, dict(arm.plan.postures[0].q))
    seen = set()
    for name in arm.robot.joints:
        plant = put(arm, hidden(arm, "bearing_flexibility:load_zone", name, **given))
        joint = arm.robot.urdf.joint_by_name[name]
        axis = placed[joint.child][:3, :3] @ joint.axis
        at = plant.coordinates.index(f"{name} bearing 1")
        child = plant.motion(joint.child, np.zeros(3))[:, at : at + 5]
        soft = child @ np.linalg.inv(plant.stiffness[at : at + 5, at : at + 5]) @ child.T
        radial = np.array([0, 0, -1.0]) - (np.array([0, 0, -1.0]) @ axis) * axis
        part = float(radial @ radial)
        seen.add(round(part, 3))
        shift, tilt = np.linalg.eigvalsh(soft[:3, :3]), np.linalg.eigvalsh(soft[3:, 3:])
        along = 0.3 + 0.7 * part
        np.testing.assert_allclose(shift, np.sort([1 / 5e7, 1 / (0.3 * 3e7), 1 / (along * 3e7)]), rtol=1e-6)
        np.testing.assert_allclose(tilt[1:], np.sort([1 / (0.3 * 2e5), 1 / (along * 2e5)]), rtol=1e-6)
        if part > 0.01:  # stiff where a force along the weight's radial part pushes, and about an axis across
            pressed = radial / np.sqrt(part)
            assert pressed @ soft[:3, :3] @ pressed == pytest.approx(1 / (along * 3e7), rel=1e-6)
            about = np.cross(axis, pressed)
            assert about @ soft[3:, 3:] @ about == pytest.approx(1 / (along * 2e5), rel=1e-6)
    assert len(seen) > 1
