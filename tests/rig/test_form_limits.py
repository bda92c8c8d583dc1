"""What each form is for small motions, against closed forms on uniform bars of 4 kg and 1 m."""

import numpy as np
import pytest
import scipy.linalg

import flexmodal
from flexmodal.rig.effects.link_flexibility import span
from flexmodal.rig.forms.maxwell_rows import fractional, middle, zener
from flexmodal.rig.hammer_test import Conduct, h1, strike_posture
from flexmodal.rig.integration.laws import LAWS
from flexmodal.rig.plant.build import build
from flexmodal.rig.plant.geometry import across, turn

from .conftest import measured, put

K, B, I = 4e4, 4.0, 4.0 / 3  # the bar: joint stiffness and damping, moment about the joint  # noqa: E741
FREQUENCY = np.linspace(2, 100, 300)
W = 2 * np.pi * FREQUENCY


def natural(plant) -> np.ndarray:
    return np.sort(np.sqrt(np.abs(scipy.linalg.eigvals(plant.stiffness, plant.mass).real)) / 2 / np.pi)


def tip(plant, link="link_1", frequency=FREQUENCY) -> np.ndarray:
    row = plant.row(link, np.array([1.0, 0, 0]), np.array([0, 0, 1.0]))[None]
    return plant.inertance(row, row, frequency)[:, 0, 0]


def joint_stiffness(plant) -> np.ndarray:
    """Complex stiffness of the one joint: −ω²/inertance = k(ω) − ω² I."""
    return W**2 * I - W**2 / tip(plant)


# loss


def test_zener_is_its_three_parameter_modulus(bench, hidden):
    spec = hidden(bench, "structural_damping:zener", "joints", loss_factor=0.1, frequency=25.0, viscous=0.0)
    found = joint_stiffness(put(bench, spec))
    strength = 2 * 0.1 * (0.1 + np.sqrt(1.01))
    lag = 1j * W / (2 * np.pi * 25 * np.sqrt(1 + strength))
    law = 1 + strength * lag / (1 + lag)
    omega = 2 * np.pi * np.sqrt(200)
    middle_lag = 1j * omega / (2 * np.pi * 25 * np.sqrt(1 + strength))
    law = law / (1 + strength * middle_lag / (1 + middle_lag)).real
    np.testing.assert_allclose(found, K * law, rtol=1e-9)
    loss = found.imag / found.real
    assert loss.max() == pytest.approx(0.1, rel=1e-4)
    assert FREQUENCY[np.argmax(loss)] == pytest.approx(25.0, abs=0.4)


def test_fractional_damping_is_a_power_of_i_omega(bench, hidden):
    given = {"loss_factor": 0.08, "order": 0.3, "viscous": 0.0}
    found = joint_stiffness(put(bench, hidden(bench, "structural_damping:fractional", "joints", **given)))
    power = (1j * W) ** 0.3
    at = (1j * middle((2.0, 100.0))) ** 0.3
    size = 0.08 / (at.imag - 0.08 * at.real)
    law = (1 + size * power) / (1 + size * at).real
    np.testing.assert_allclose(
        found, K * law, rtol=1e-3
    )  # two elements a decade, cut off a decade and a half away


@pytest.mark.parametrize("exponent", [-0.25, 0.0, 0.25])
def test_a_power_law_of_loss_holds_in_the_band(exponent, bench, hidden):
    given = {"loss_factor": 0.08, "exponent": exponent, "viscous": 0.0}
    found = joint_stiffness(put(bench, hidden(bench, "structural_damping:power_law", "joints", **given)))
    wanted = 0.08 * (W / middle((2.0, 100.0))) ** exponent
    np.testing.assert_allclose(found.imag / found.real, wanted, rtol=0.06)  # the ripple of eleven elements


def test_three_elements_ripple_about_a_constant_loss(bench, hidden):
    spec = hidden(bench, "structural_damping:prony", "joints", loss_factor=0.08, viscous=0.0)
    found = joint_stiffness(put(bench, spec))
    loss = found.imag / found.real
    assert 0.08 * 0.02 < np.ptp(loss) < 0.08
    assert loss.mean() == pytest.approx(0.08, rel=0.15)


def test_each_joint_has_its_own_loss(pair, hidden):
    spec = hidden(pair, "structural_damping:by_joint", "joints", loss_factor=0.05, spread=0.7, phase=1.0)
    plant = put(pair, spec)
    found = []
    for joint in (0, 1):
        branches = [b for b in plant.branches if b.row[joint]]
        static = plant.stiffness[joint, joint]
        lag = 1j * W[:, None] * [b.time for b in branches]
        value = static + (lag / (1 + lag)) @ [b.stiffness for b in branches]
        found.append(np.mean(value.imag / value.real))
    wanted = 0.05 * np.exp(0.7 * np.sin(1.0 + 2.399963 * np.arange(2)))
    np.testing.assert_allclose(found, wanted, rtol=0.03)


@pytest.mark.parametrize("series", [zener(0.1, 20.0, (2.0, 100.0)), fractional(0.1, 0.3, (2.0, 100.0))])
def test_series_have_a_real_part_of_one_mid_band(series):
    value = series.modulus(np.array([middle((2.0, 100.0))]))[0]
    assert value.real == pytest.approx(1.0)
    assert np.all(series.strengths >= 0)
    assert series.static > 0


# friction and springs: torque of small motions


def small(bench, spec, size: float, speed: float) -> float:
    """Torque of the joint's elements over a small step from rest, over the step."""
    plant = put(bench, spec)
    total, end = 0.0, np.array([size])
    for element in plant.elements:
        numbers = np.array(element.parameters)
        pull, _ = LAWS[element.kind](numbers, np.zeros(1), end, np.array([speed]), np.zeros(1))
        total += float(pull[0])
    return total


@pytest.mark.parametrize("form", ["iwan", "bouc_wen", "lugre"])
def test_friction_is_a_spring_before_it_slips(form, bench, hidden):
    spec = hidden(bench, f"coulomb_friction:{form}", "q1")
    numbers = spec[1].parameters
    stiffness = numbers.get("presliding_stiffness", numbers.get("bristle_stiffness"))
    size = 1e-4 * numbers["torque"] / stiffness
    assert small(bench, spec, size, 0.0) == pytest.approx(stiffness * size, rel=1e-3)


@pytest.mark.parametrize("form", ["tanh", "stribeck"])
def test_friction_by_speed_is_a_damper_while_slow(form, bench, hidden):
    spec = hidden(bench, f"coulomb_friction:{form}", "q1")
    numbers = spec[1].parameters
    speed = 1e-3 * numbers["speed"]
    most = numbers["torque"] * numbers.get("breakaway", 1.0)
    assert small(bench, spec, 0.0, speed) == pytest.approx(most / numbers["speed"] * speed, rel=1e-4)


@pytest.mark.parametrize("form", ["tanh", "stribeck", "lugre", "iwan", "bouc_wen"])
def test_friction_slides_at_its_torque(form, bench, hidden):
    elements = put(bench, hidden(bench, f"coulomb_friction:{form}", "q1", torque=3.0)).elements
    total = 0.0
    for element in elements:
        law, numbers, memory = LAWS[element.kind], np.array(element.parameters), np.zeros(1)
        for step in range(400):
            old, new = np.array([step * 1e-4]), np.array([(step + 1) * 1e-4])
            pull, memory = law(numbers, old, new, np.array([10.0]), memory)
        total += float(pull[0])
    assert total == pytest.approx(3.0, rel=1e-3)


@pytest.mark.parametrize("form", ["cubic", "wind_up", "levelling", "exponential", "leaning"])
def test_springs_have_the_joints_stiffness_for_small_motions(form, bench, hidden):
    spec = hidden(bench, f"nonlinear_stiffness:{form}", "q1", deflection=0.01)
    for size in (1e-7, -1e-7):
        assert abs(small(bench, spec, size, 0.0)) < 1e-3 * K * 1e-7


def test_springs_far_out(bench, hidden):
    """At u = q_r, or far beyond: c k u for a cubic spring, and so on."""

    def torque(form, size, **given):
        spec = hidden(bench, f"nonlinear_stiffness:{form}", "q1", change=0.4, deflection=0.01, **given)
        return small(bench, spec, size, 0.0) / K

    assert torque("cubic", 0.01) == pytest.approx(0.4 * 0.01)
    assert torque("wind_up", 0.05) == pytest.approx(0.2 * (0.05 - 0.01) + 0.2 * (0.05 - 0.03))
    assert torque("levelling", 1.0) == pytest.approx(0.4 * (0.01 - 1.0))
    assert torque("play", 1.0) == pytest.approx(-0.4 * 0.01)
    assert torque("play", 1e-6) == pytest.approx(-0.4 * 1e-6, rel=1e-3)
    assert torque("exponential", 0.01) == pytest.approx(0.4 * 0.01 * (np.sinh(1) - 1))
    assert torque("leaning", 0.02, load=0.5) == pytest.approx(
        0.4 * ((0.02 + 0.005) ** 3 - 0.005**3 - 3 * 0.005**2 * 0.02) / 0.01**2
    )


# couplings


def matrices(pair, hidden, form, **given):
    return put(pair, hidden(pair, f"joint_coupling:{form}", "q1+q2", **given))


def test_a_ratio_ties_with_a_whole_block(pair, hidden):
    plant = matrices(pair, hidden, "ratio", stiffness=1e4, ratio=-0.7)
    np.testing.assert_allclose(plant.stiffness - K * np.eye(2), 1e4 * np.array([[1, 0.7], [0.7, 0.49]]))
    damped = matrices(pair, hidden, "damped", stiffness=1e4, ratio=-0.7, damping=30.0)
    np.testing.assert_allclose(damped.damping - B * np.eye(2), 30 * np.array([[1, 0.7], [0.7, 0.49]]))


def test_an_idler_is_two_springs_in_a_row_while_slow(pair, hidden):
    """Without its inertia k/2 between the joints; it swings at √(2k/J) with both held."""
    plant = matrices(pair, hidden, "idler", stiffness=1e4, ratio=0.7, inertia=0.05, damping=0.0)
    k, inner = plant.stiffness, plant.stiffness[:2, 2:]
    condensed = k[:2, :2] - inner @ inner.T / k[2, 2]
    np.testing.assert_allclose(condensed - K * np.eye(2), 5e3 * np.array([[1, -0.7], [-0.7, 0.49]]))
    assert k[2, 2] / plant.mass[2, 2] == pytest.approx(2 * 1e4 / 0.05)


def test_a_belt_goes_from_its_spring_to_both(pair, hidden):
    plant = matrices(pair, hidden, "belt", stiffness=1e4, ratio=0.7, relaxing=0.5, time=0.01)
    row = np.array([1, -0.7])
    np.testing.assert_allclose(plant.stiffness - K * np.eye(2), 1e4 * np.outer(row, row))
    (branch,) = plant.branches
    np.testing.assert_allclose(branch.stiffness * np.outer(branch.row, branch.row), 5e3 * np.outer(row, row))


def test_a_rod_is_stretched_as_its_ends_move_apart(pair, hidden):
    """By differences of its length, as the two bars turn about −y."""
    spec = hidden(pair, "joint_coupling:rod", "q1+q2", stiffness=1e6, crank=0.2, angle=0.4, turn=0.3)
    added = put(pair, spec).stiffness - K * np.eye(2)
    axis = np.array([0.0, -1.0, 0.0])
    one, other = across(axis, None)

    def length(first, second):
        fixed = 0.2 * (np.cos(0.4) * one + np.sin(0.4) * other)
        crank = 0.2 * (np.cos(0.7) * one + np.sin(0.7) * other)
        elbow = turn(axis, first) @ np.array([1.0, 0, 0])
        return np.linalg.norm(elbow + turn(axis, first + second) @ crank - fixed)

    step = 1e-6
    row = np.array([length(step, 0.0) - length(-step, 0.0), length(0.0, step) - length(0.0, -step)]) / (
        2 * step
    )
    np.testing.assert_allclose(added, 1e6 * np.outer(row, row), atol=1e-3 * np.abs(added).max())


# links


def test_a_link_on_one_hinge_swings_beyond_it(stiff, hidden):
    spec = hidden(stiff, "link_flexibility:hinge", "link_1", stiffness=5e3, place=0.4)
    outer = 4.0 * 0.6**3 / 3
    assert natural(put(stiff, spec))[0] == pytest.approx(np.sqrt(5e3 / outer) / 2 / np.pi, rel=1e-5)


def test_a_flange_tilts_what_it_carries(bars, stand, hidden):
    locked = stand(bars(count=2, stiffness=1e13, damping=0.0), references=["tip:+z"], postures=["flat"])
    spec = hidden(locked, "link_flexibility:flange", "link_1", stiffness=5e3)
    moment = I + 4.0 * ((0.03 + 0.5) ** 2 - 0.5**2) + 4.0 * 0.03 * 0.03**2 / 3
    assert natural(put(locked, spec))[0] == pytest.approx(np.sqrt(5e3 / moment) / 2 / np.pi, rel=1e-3)


def compliance(plant) -> float:
    """Deflection of the tip under a load that stands still [m/N]."""
    row = plant.row("link_1", np.array([1.0, 0, 0]), np.array([0, 0, 1.0]))
    return float(row @ np.linalg.solve(plant.stiffness, row))


def test_a_tapered_beam_bends_as_its_integral_says(stiff, hidden):
    spec = hidden(stiff, "link_flexibility:tapered", "link_1", bending_stiffness=4000.0, taper=0.6)
    place = (np.arange(8000) + 0.5) / 8000
    rigidity = 4000.0 * (1 - 0.6 * (np.floor(place * 8) + 0.5) / 8)
    assert compliance(put(stiff, spec)) == pytest.approx(np.mean((1 - place) ** 2 / rigidity), rel=1e-4)


def test_a_beam_that_shears_adds_a_straight_part(stiff, hidden):
    spec = hidden(stiff, "link_flexibility:timoshenko", "link_1", bending_stiffness=4000.0, shear=1.5)
    assert compliance(put(stiff, spec)) == pytest.approx((1 / 3 + 1.5 / 12) / 4000.0, rel=1e-6)


def test_pieces_add_up(stiff, hidden):
    spec = hidden(stiff, "link_flexibility:pieces", "link_1", stiffness=5e3, fall=0.5)
    levers = 1 - np.array([1, 3, 5]) / 6
    wanted = np.sum(levers**2 / (5e3 * 0.5 ** np.arange(3)))
    assert compliance(put(stiff, spec)) == pytest.approx(wanted, rel=1e-6)


def test_a_twisting_link_turns_what_it_carries(stand, hidden):
    """A moment about the link, taken at its far end: turned by M L/(G J) more than without the twist."""
    bench = stand(flexmodal.load("six_axis"), points=2)
    turned = []
    for torsion in (0.5, 100.0):
        spec = hidden(bench, "link_flexibility:twisting", "link_2", bending_stiffness=1e6, torsion=torsion)
        plant = build(bench, bench.plan.postures[0], [spec])
        length, axis = span("link_2", bench)
        row = (plant.orientation("link_2") @ axis) @ plant.motion("link_2", length * axis)[3:]
        turned.append(row @ np.linalg.solve(plant.stiffness, row))
    assert turned[0] - turned[1] == pytest.approx(length / 1e6 * (1 / 0.5 - 1 / 100), rel=1e-6)


# foundations


def root_mass(bench) -> float:
    return sum(body.mass for body in bench.true.bodies.values())


def test_directions_without_spread_are_the_rigs_own(stiff, hidden):
    given = {"translation_stiffness": 3e5, "tilt_stiffness": 2e4, "damping_ratio": 0.02,
             "vertical_over_horizontal": 2.0}  # fmt: skip
    one = put(stiff, hidden(stiff, "base_flexibility", "base", **given))
    other = put(
        stiff, hidden(stiff, "base_flexibility:directions", "base", **given, spread=0.0, aside=0.0, below=0.0)
    )
    np.testing.assert_allclose(other.stiffness, one.stiffness)
    np.testing.assert_allclose(other.damping, one.damping)


def test_springs_below_the_root_tie_shift_and_tilt(stiff, hidden):
    """A spring at height −h: k between shift and tilt times h, k h² beside the tilt's own."""
    spec = hidden(stiff, "base_flexibility:directions", "base", translation_stiffness=3e5, tilt_stiffness=2e4,
                  vertical_over_horizontal=1.0, spread=0.0, aside=0.0, below=0.3)  # fmt: skip
    k = put(stiff, spec).stiffness[1:, 1:]
    assert k[0, 0] == pytest.approx(3e5)
    assert abs(k[0, 2]) == pytest.approx(3e5 * 0.3)
    assert k[2, 2] == pytest.approx(2e4 + 3e5 * 0.09)


def test_a_block_bounces_with_the_robot_on_it(stiff, hidden):
    given = {
        "translation_stiffness": 3e5,
        "tilt_stiffness": 1e13,
        "vertical_over_horizontal": 2.0,
        "aside": 0.0,
    }
    for form in ("block", "radiating"):
        spec = hidden(stiff, f"base_flexibility:{form}", "base", **given, block_mass=80.0)
        found = natural(put(stiff, spec))[:2]
        total = root_mass(stiff) + 80.0
        np.testing.assert_allclose(found, np.sqrt(np.array([3e5, 6e5]) / total) / 2 / np.pi, rtol=1e-4)


def test_bolts_and_soil_are_springs_in_a_row(stiff, hidden):
    """A load upright on the robot that stands still: 1/k + 1/(c k)."""
    spec = hidden(stiff, "base_flexibility:bolted", "base", translation_stiffness=3e5, aside=0.0, bolts=2.0,
                  vertical_over_horizontal=1.5)  # fmt: skip
    plant = put(stiff, spec)
    row = np.eye(plant.dof)[plant.coordinates.index("base up")]
    found = row @ np.linalg.solve(plant.stiffness, row)
    assert found == pytest.approx((1 + 1 / 2) / (1.5 * 3e5), rel=1e-6)


def test_feet_carry_and_right_the_robot(stiff, hidden):
    """Equal feet: four springs upright, and their levers against a tilt."""
    spec = hidden(stiff, "base_flexibility:feet", "base", foot_stiffness=1e5, half_width=0.3, below=0.0,
                  worst=1.0)  # fmt: skip
    k = put(stiff, spec).stiffness[1:, 1:]
    assert k[1, 1] == pytest.approx(4e5)
    assert k[2, 2] == pytest.approx(4e5 * 0.09)
    assert abs(k[1, 2]) < 1e-6


def test_soil_of_a_tilt_is_free_when_slow_and_a_damper_when_fast(stiff, hidden):
    spec = hidden(stiff, "base_flexibility:radiating", "base")
    (feedback,) = put(stiff, spec).feedbacks
    slow, fast = feedback.stiffness(np.array([1e-3, 1e6]))
    assert abs(slow) < 1e-6 * abs(fast)
    assert fast == pytest.approx(1e6j * feedback.d_rate, rel=1e-2)


# masses and absorbers


@pytest.mark.parametrize(
    ("form", "given", "moment"),
    [
        ("point", {}, 0.82),
        ("two", {"x2": 0.5, "y2": 0.0, "z2": 0.0, "share": 0.4}, 0.6 * 0.82 + 0.4 * 0.25),
        ("disc", {"ax": 1.0, "ay": 0.0, "az": 0.0, "radius": 0.2}, 0.82 + 0.04 / 4),
        ("rod", {"ax": 0.0, "ay": 0.0, "az": 1.0, "length": 0.4}, 0.81 + 0.3**2 + 0.16 / 12),
    ],
)
def test_an_added_mass_counts_by_its_moment(form, given, moment, bench, hidden):
    place = {"mass": 0.7, "x": 0.9, "y": 0.0, "z": 0.1}
    plant = put(bench, hidden(bench, f"added_mass:{form}", "link_1", **place, **given))
    assert plant.mass[0, 0] == pytest.approx(I + 0.7 * moment)


def test_a_stalk_weighs_more_the_nearer_its_resonance(bench, hidden):
    spec = hidden(bench, "added_mass:stalk", "link_1", mass=0.7, x=1.0, y=0.0, z=0.0, frequency=150.0,
                  damping_ratio=0.0)  # fmt: skip
    felt = 0.7 / (1 - (FREQUENCY / 150) ** 2)
    exact = -(W**2) / (K + 1j * W * B - W**2 * (I + felt))
    np.testing.assert_allclose(tip(put(bench, spec)), exact, rtol=1e-9)


def absorbed(bench, hidden, form, **given) -> np.ndarray:
    """Effective mass at the tip: what the force needs beyond the bare bar, over −ω²."""
    place = {"mass": 0.2, "frequency": 30.0, "x": 1.0, "y": 0.0, "z": 0.0, "dx": 0.0, "dy": 0.0, "dz": 1.0}
    spec = hidden(bench, f"local_absorber:{form}", "link_1", **place, **given)
    return (K + 1j * W * B - W**2 * I + W**2 / tip(put(bench, spec))) / W**2


def hung(mass, frequency, ratio) -> np.ndarray:
    r = FREQUENCY / frequency
    return mass * (1 + 2j * ratio * r) / (1 - r**2 + 2j * ratio * r)


def test_absorbers_weigh_as_den_hartog_says(bench, hidden):
    found = absorbed(bench, hidden, "two_way", damping_ratio=0.03, second=1.7)
    np.testing.assert_allclose(found, hung(0.2, 30.0, 0.03), rtol=1e-6, atol=1e-9)
    found = absorbed(bench, hidden, "twin", damping_ratio=0.03, second=1.7, share=0.4)
    np.testing.assert_allclose(found, hung(0.12, 30.0, 0.03) + 0.08, rtol=1e-6, atol=1e-9)


def test_a_pendulum_weighs_by_its_arm(bench, hidden):
    """Hinged at the tip, the arm along the bar: the link carries it and its sweep is upright.

    For the angle θ of the bar and φ of the arm: J_P (θ̈ + φ̈) + m l θ̈ + … with J_P = m (l² + g²).
    """
    spec = hidden(bench, "local_absorber:pendulum", "link_1", mass=0.2, frequency=30.0, damping_ratio=0.0,
                  x=1.0, y=0.0, z=0.0, dx=1.0, dy=0.0, dz=0.0, arm=0.2, gyration=0.05)  # fmt: skip
    plant = put(bench, spec)
    swing = 0.2 * (0.2**2 + 0.05**2)
    assert plant.mass[0, 0] == pytest.approx(I + 0.2 * 1.2**2 + 0.2 * 0.05**2)
    assert abs(plant.mass[0, 1]) == pytest.approx(0.2 * 1.2 * 0.2 + 0.2 * 0.05**2)
    assert plant.mass[1, 1] == pytest.approx(swing)
    assert np.sqrt(plant.stiffness[1, 1] / swing) / 2 / np.pi == pytest.approx(30.0)


def test_rubber_is_a_relaxing_spring(bench, hidden):
    found = absorbed(bench, hidden, "rubber", relaxing=0.4)
    lag = 1j * FREQUENCY / 30
    spring = 0.2 * (2 * np.pi * 30) ** 2 / 1.2 * (1 + 0.4 * lag / (1 + lag))
    np.testing.assert_allclose(found, 0.2 * spring / (spring - 0.2 * W**2), rtol=1e-6, atol=1e-9)


# servos


def served(bench, hidden, form, loop, **given) -> None:
    """The joint's spring in a row with rotor and loop."""
    spec = hidden(bench, f"servo_compliance:{form}", "q1", rotor_inertia=0.8, **given)
    joint, motor = K + 1j * W * B, loop(1j * W) - W**2 * 0.8
    series = joint * motor / (joint + motor)
    np.testing.assert_allclose(tip(put(bench, spec)), -(W**2) / (series - W**2 * I), rtol=1e-8)


def test_servos_are_the_joint_in_a_row_with_their_loops(bench, hidden):
    p, d = 9e4, 300.0
    gains = {"proportional_gain": p, "derivative_gain": d}
    t, late = 4e-4, 8e-4
    served(bench, hidden, "current", lambda s: (p + d * s) / (1 + t * s) + 0.05 * d * s, **gains,
           current_time=t, back_emf=0.05)  # fmt: skip
    served(bench, hidden, "delayed",
           lambda s: (p + d * s) * (1 - s * late / 2 + (s * late) ** 2 / 12)
           / (1 + s * late / 2 + (s * late) ** 2 / 12), **gains, delay=late)  # fmt: skip
    outer = 0.2 * p / d
    served(bench, hidden, "cascade",
           lambda s: (d + d * (0.8 * p / d) / s) * (outer + s) / (1 + t * s), **gains, outer=0.2,
           filter_time=t)  # fmt: skip
    served(bench, hidden, "brake", lambda s: p * (1 + 0.3 * s * t / (1 + s * t)), brake_stiffness=p,
           relaxing=0.3, relaxation_time=t)  # fmt: skip


# sensors


FILTERS = [
    ("sensor_gain:inverted", {"error": 0.2}, lambda s: -1.2 + 0 * s),
    ("sensor_gain:aged", {"exponent": 0.1}, lambda s: (s / (200j * np.pi)) ** -0.1),
    ("sensor_gain:high_pass", {"corner": 3.0}, lambda s: s / (s + 6 * np.pi)),
    ("sensor_gain:resonant", {"resonance": 180.0, "damping_ratio": 0.05},
     lambda s: 1 / (1 + (s / (360 * np.pi)) ** 2 + 0.1 * s / (360 * np.pi))),
    ("time_delay:low_pass", {"time": 8e-4}, lambda s: 1 / (1 + 8e-4 * s)),
    ("time_delay:all_pass", {"time": 8e-4}, lambda s: (1 - 4e-4 * s) / (1 + 4e-4 * s)),
    ("time_delay:bessel", {"time": 8e-4}, lambda s: 3 / (3 + 3 * 8e-4 * s + (8e-4 * s) ** 2)),
    ("time_delay:hold", {"time": 8e-4}, lambda s: (1 - np.exp(-8e-4 * s)) / (8e-4 * s)),
    ("sensor_gain:amplifier", {"corner": 3.0, "error": 0.2},
     lambda s: 1.2 * s**2 / (s**2 + np.sqrt(2) * 6 * np.pi * s + (6 * np.pi) ** 2)),
    ("sensor_gain:shelf", {"corner": 20.0, "error": -0.3},
     lambda s: (1 + 0.7 * s / (40 * np.pi)) / (1 + s / (40 * np.pi))),
    ("time_delay:anti_alias", {"time": 8e-4},
     lambda s: 1 / np.polyval([1, 2.6131259, 3.4142136, 2.6131259, 1], s * 8e-4 / 2.6131259)),
    ("time_delay:decimated", {"time": 8e-4}, lambda s: ((1 - np.exp(-s * 8e-4)) / (s * 8e-4)) ** 3),
]  # fmt: skip


@pytest.mark.parametrize(("key", "given", "law"), FILTERS)
def test_filters_multiply_the_measured_frf(key, given, law, bars, stand, hidden):
    """Struck in time and in the height's own prediction; another point's sensor is as it was."""
    bench = stand(bars(damping=40.0), references=["tip:+z"], postures=["flat"])
    spec = hidden(bench, key, "tip", **given)
    plain, spoilt = measured(bench), measured(bench, spec)
    lines = np.fft.rfftfreq(bench.plan.analyser.samples, bench.plan.analyser.interval)
    inside = (lines >= 4) & (lines <= 90)
    exact = plain[1] * law(2j * np.pi * np.maximum(lines, 1e-9))
    # What rings back over the end of the filter's transform, cut off at half the sampling rate.
    assert np.abs(spoilt[1] - exact)[inside].max() < 3e-3 * np.abs(exact[inside]).max()
    np.testing.assert_array_equal(spoilt[0], plain[0])


def test_sensors_that_look_askew_mix_the_axes(bars, stand, hidden):
    bench = stand(bars(), references=["tip:+z"], postures=["raised"], axes="xz", points=1)
    posture, quiet = bench.plan.postures[0], Conduct(noise=0.0, scatter=0.0)
    axis = {"ax": 0.0, "ay": 1.0, "az": 0.0}

    def struck(*specs):
        return h1(strike_posture(bench, posture, specs, quiet))[0][0, 0, 0]

    plain = struck()
    size = np.abs(plain).max()
    found = struck(hidden(bench, "sensor_misalignment:cross", "tip", angle=0.2, **axis))
    np.testing.assert_allclose(found[0], plain[0] - 0.2 * plain[1], atol=1e-12 * size)
    np.testing.assert_allclose(found[1], plain[1] + 0.2 * plain[0], atol=1e-12 * size)
    c, s = np.cos(0.3), np.sin(0.3)
    found = struck(hidden(bench, "sensor_misalignment:leaning", "tip", angle=0.3, **axis))
    sign = 1 if bench.normal[1] > 0 else -1
    sign *= np.sign(bench.normal_in("link_1") @ [0, 1, 0])
    np.testing.assert_allclose(found[0], c * plain[0] - sign * s * plain[1], atol=1e-12 * size)
    level = {"x": 0.0, "y": 0.0, "z": 0.0}
    turned = struck(hidden(bench, "sensor_misalignment", "tip", angle=0.3, **axis))
    found = struck(hidden(bench, "sensor_misalignment:stand_off", "tip", angle=0.3, **axis, **level))
    np.testing.assert_allclose(found, turned, atol=1e-12 * size)
    found = struck(
        hidden(bench, "sensor_misalignment:skewed", "tip", angle=0.3, **axis, second=1.0, third=1.0)
    )
    np.testing.assert_allclose(found, turned, atol=1e-12 * size)
    far = {"x": 0.5, "y": 0.0, "z": 0.0}
    found = struck(hidden(bench, "sensor_misalignment:stand_off", "tip", angle=0.0, **axis, **far))
    np.testing.assert_allclose(found, 1.5 * plain, rtol=1e-9, atol=1e-12 * size)


@pytest.mark.parametrize(
    ("form", "given", "felt"),
    [
        ("block", {"height": 0.1}, lambda s: 0.4 * (1 + 0.05**2 + 0.1**2 / 6)),
        ("cable", {"share": 0.25}, lambda s: 0.3),
        ("sprung", {"frequency": 250.0, "damping_ratio": 0.0},
         lambda s: 0.4 / (1 + (s / (500 * np.pi)) ** 2)),
        ("dragged", {"frequency": 3.0, "damping_ratio": 0.3},
         lambda s: 0.4 * (1 + 0.6 * 6 * np.pi / s + (6 * np.pi / s) ** 2)),
    ],
)  # fmt: skip
def test_sensors_weigh_on_what_they_measure(form, given, felt, bars, stand, hidden):
    bench = stand(bars(damping=40.0), references=["tip:+z"], postures=["flat"])
    value = measured(bench, hidden(bench, f"sensor_mass:{form}", "sensor", mass=0.4, **given))[1]
    lines = np.fft.rfftfreq(bench.plan.analyser.samples, bench.plan.analyser.interval)
    inside = (lines >= 4) & (lines <= 100)
    s = 2j * np.pi * lines[inside]
    exact = s**2 / (K + 40.0 * s + s**2 * (I + felt(s)))
    assert np.abs(value[inside] - exact).max() < 2e-5 * np.abs(exact).max()


# bearings

SEAT = {"tilt_stiffness": 3e5, "radial_stiffness": 4e7, "axial_stiffness": 5e7, "damping_time": 0.0}


@pytest.fixture
def spatial(stand):
    return stand(flexmodal.load("six_axis"), references=["tool_side:+z"], postures=["work"])


def of_tool(plant) -> np.ndarray:
    rows = [plant.row("link_6", np.zeros(3), way)[None] for way in np.eye(3)]
    rows = np.concatenate(rows)
    return plant.inertance(rows, rows, FREQUENCY)


def test_a_housing_as_stiff_every_way_is_no_housing(spatial, hidden):
    own = hidden(spatial, "bearing_flexibility", "q3", **SEAT)
    other = hidden(spatial, "bearing_flexibility:housing", "q3", **SEAT, ratio=1.0, angle=0.7)
    np.testing.assert_allclose(of_tool(put(spatial, other)), of_tool(put(spatial, own)), rtol=1e-8)


@pytest.mark.parametrize(("time", "factor"), [(1e-7, 1.0), (1e4, 1.5)])
def test_a_seat_that_relaxes_at_once_or_never_is_a_spring(time, factor, spatial, hidden):
    given = {name: value * factor for name, value in SEAT.items()}
    own = hidden(spatial, "bearing_flexibility", "q3", **given)
    other = hidden(spatial, "bearing_flexibility:relaxing", "q3", **SEAT, relaxing=0.5, time=time)
    scale = np.abs(of_tool(put(spatial, own))).max()
    np.testing.assert_allclose(of_tool(put(spatial, other)), of_tool(put(spatial, own)), atol=2e-3 * scale)
