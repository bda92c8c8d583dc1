"""Each hidden effect changes the measurement in its known way, against a closed form where there is one."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg

import flexmodal
from flexmodal.rig.blow import Strike
from flexmodal.rig.clean import strike_all_points
from flexmodal.rig.effects.structural_damping import maxwell
from flexmodal.rig.hammer_test import Conduct, h1, strike_posture
from flexmodal.rig.integration.linear import Outputs
from flexmodal.rig.integration.nonlinear import fine_records
from flexmodal.rig.plant.build import build

QUIET = Conduct(noise=0.0, scatter=0.0)
K, B, I = 4e4, 4.0, 4.0 / 3  # the bar: joint stiffness and damping, moment about the joint  # noqa: E741
FREQUENCY = np.linspace(2, 100, 400)


@pytest.fixture
def bench(bars, stand):
    return stand(bars(), references=["tip:+z"], postures=["flat"])


def natural(plant) -> np.ndarray:
    return np.sqrt(np.abs(scipy.linalg.eigvals(plant.stiffness, plant.mass).real)) / 2 / np.pi


def tip(plant, frequency=FREQUENCY) -> np.ndarray:
    row = plant.row("link_1", np.array([1.0, 0, 0]), np.array([0, 0, 1.0]))[None]
    return plant.inertance(row, row, frequency)[:, 0, 0]


def measured(bench, *specs, trials=None) -> np.ndarray:
    """Clean FRFs [trial, point, line] of one hammer position and one axis."""
    value = h1(strike_posture(bench, bench.plan.postures[0], specs, QUIET, trials=trials))[0]
    return value[:, 0, :, 0]


def lines(bench) -> np.ndarray:
    return np.fft.rfftfreq(bench.plan.analyser.samples, bench.plan.analyser.interval)


def test_link_flexibility_shows_in_the_measured_frf(bench, hidden):
    spec = hidden(bench, "link_flexibility", "link_1", bending_stiffness=4000.0, damping_ratio=0.02)
    posture = bench.plan.postures[0]
    plant = build(bench, posture, [spec])
    # A spring of k at the root of a cantilever: the characteristic equation of a pinned bar with a root
    # spring, k/EI (1 + cos cosh) = β (sin cosh − cos sinh) for β of a bar 1 m long (Blevins, Formulas, table
    # 8-1).
    from scipy.optimize import brentq

    def equation(x):
        return K / 4000 * (1 + np.cos(x) * np.cosh(x)) - x * (np.sin(x) * np.cosh(x) - np.cos(x) * np.sinh(x))

    root = brentq(equation, 0.3, 1.875)
    first = root**2 * np.sqrt(4000.0 / 4.0) / 2 / np.pi
    assert min(natural(plant)) == pytest.approx(first, rel=2e-4)
    found = np.abs(measured(bench, spec)[0, 1])
    inside = (lines(bench) > 2) & (lines(bench) < 40)
    assert lines(bench)[inside][np.argmax(found[inside])] == pytest.approx(first, abs=0.6)
    assert first < 0.8 * np.sqrt(K / I) / 2 / np.pi


def test_base_flexibility_bounces_at_its_own_frequency(bars, stand, hidden):
    bench = stand(bars(stiffness=1e12), references=["tip:+z"])
    spec = hidden(bench, "base_flexibility", "base", translation_stiffness=3e5, tilt_stiffness=1e12,
                  damping_ratio=0.02, vertical_over_horizontal=2.0)  # fmt: skip
    mass = sum(body.mass for body in bench.true.bodies.values())
    found = sorted(natural(build(bench, bench.plan.postures[0], [spec])))[:2]
    np.testing.assert_allclose(found, np.sqrt(np.array([3e5, 6e5]) / mass) / 2 / np.pi, rtol=1e-6)


def test_base_tilts_about_its_foot_with_the_arm_on_it(bars, stand, hidden):
    bench = stand(bars(stiffness=1e12), references=["tip:+z"])
    spec = hidden(bench, "base_flexibility", "base", translation_stiffness=1e13, tilt_stiffness=2e4)
    about = I + bench.true.bodies["base"].inertia[1, 1]
    found = min(natural(build(bench, bench.plan.postures[0], [spec])))
    assert found == pytest.approx(np.sqrt(2e4 / about) / 2 / np.pi, rel=1e-5)


def test_servo_compliance_is_a_motor_on_its_loop(bench, hidden):
    kp, kd, j = 9e4, 60.0, 0.8
    spec = hidden(bench, "servo_compliance", "q1", proportional_gain=kp, derivative_gain=kd, rotor_inertia=j)
    w = 2 * np.pi * FREQUENCY
    joint, motor = K + 1j * w * B, kp + 1j * w * kd - w**2 * j
    series = joint * motor / (joint + motor)
    exact = -(w**2) / (series - w**2 * I)
    np.testing.assert_allclose(tip(build(bench, bench.plan.postures[0], [spec])), exact, rtol=1e-9)


def test_structural_damping_has_a_flat_loss_factor(bench, hidden):
    spec = hidden(bench, "structural_damping", "joints", loss_factor=0.08, viscous=0.0)
    plant = build(bench, bench.plan.postures[0], [spec])
    w = 2 * np.pi * FREQUENCY
    stiffness = w**2 * I - w**2 / tip(plant)
    loss = stiffness.imag / stiffness.real
    np.testing.assert_allclose(
        loss, 0.08, rtol=0.03
    )  # the ripple of nine elements over five octaves and a half
    middle = np.argmin(np.abs(FREQUENCY - np.sqrt(2 * 100)))
    assert stiffness.real[middle] == pytest.approx(K, rel=2e-3)
    # Kramers and Kronig: 2η/π a unit of ln ω.
    growth = (stiffness.real[-1] - stiffness.real[0]) / K / np.log(50)
    assert growth == pytest.approx(2 * 0.08 / np.pi, rel=0.1)
    # In time: the same FRF comes out of the blows.
    inside = (lines(bench) >= 4) & (lines(bench) <= 100)
    exact = tip(plant, lines(bench)[inside])
    assert np.abs(measured(bench, spec)[0, 1, inside] - exact).max() < 2e-3 * np.abs(exact).max()


@pytest.mark.parametrize("loss", [0.0, 0.02, 0.3])
def test_maxwell_elements_are_passive(loss):
    static, strengths, times = maxwell(loss, (2.0, 200.0))
    assert static > 0
    assert np.all(strengths >= 0)
    assert np.all(times > 0)


def ring(plant, bench, peak, seconds=1.0):
    """Acceleration of the tip over time after one blow, and the grid."""
    row = plant.row("link_1", np.array([1.0, 0, 0]), np.array([0, 0, 1.0]))
    outputs = Outputs(plant.output_row(row)[None, None], (row @ np.linalg.solve(plant.mass, row))[None, None],
                      np.zeros(1))  # fmt: skip
    analyser = replace(bench.plan.analyser, samples=round(seconds * bench.plan.analyser.rate))
    blow = Strike(peak, 4e-3, 0.0, np.zeros(3), np.eye(3))
    fine = fine_records(plant, plant.input_column(row[None]), outputs, row[None], [blow], analyser)[0, 0]
    return np.arange(len(fine)) * analyser.step, fine


def test_friction_takes_the_same_off_every_swing(bars, stand, hidden):
    """Coulomb: the amplitude falls by 4 F_c/k a cycle, along a straight line, until the joint sticks."""
    bench = stand(bars(damping=0.0), references=["tip:+z"])
    spec = hidden(bench, "coulomb_friction", "q1", torque=1.0, presliding_stiffness=1e3 * K)
    time, swing = ring(build(bench, bench.plan.postures[0], [spec]), bench, 400.0, seconds=0.6)
    period = 2 * np.pi * np.sqrt(I / K)
    after = time > 0.01
    # While it slides, I ü = −k u ∓ F_c: extremes of k u are those of the acceleration, F_c less.
    peaks = [np.abs(swing[after][(time[after] >= t) & (time[after] < t + period)]).max() * I - 1.0
             for t in 0.01 + period * np.arange(8)]  # fmt: skip
    # The stick at each reversal takes a little time (presliding 1000 k), the samples miss the very peak.
    np.testing.assert_allclose(np.diff(peaks), -4.0, rtol=0.04)


def test_friction_damps_weak_blows_more(bench, hidden, stand):
    pair = stand(bench.robot, references=["tip:+z"], postures=["flat"], trials=2)
    spec = hidden(pair, "coulomb_friction", "q1")
    weak, hard = np.abs(measured(pair, spec)[:, 1]).max(axis=-1)
    plain = np.abs(measured(pair)[:, 1]).max(axis=-1)
    assert weak < 0.95 * hard < plain[1]
    np.testing.assert_allclose(plain[0], plain[1], rtol=1e-3)  # a linear structure knows no level


@pytest.mark.parametrize("change", [0.4, -0.4])
@pytest.mark.slow
def test_nonlinear_stiffness_follows_its_backbone(change, bars, stand, hidden):
    """Small swings of a cubic spring: ω² = k/I (1 + ¾ a (A/q_r)²); the law levels off only at A ≈ q_r."""
    bench = stand(bars(damping=0.0), references=["tip:+z"])
    plain = natural(build(bench, bench.plan.postures[0], []))[0]
    amplitude = 50.0 * 2e-3 / I / (2 * np.pi * plain)  # impulse P T/2 at 1 m
    scale = amplitude / 0.2
    spec = hidden(bench, "nonlinear_stiffness", "q1", change=change, deflection=scale)
    time, swing = ring(build(bench, bench.plan.postures[0], [spec]), bench, 50.0, seconds=2.0)
    keep = time > 0.005
    crossing = np.flatnonzero(np.diff(np.sign(swing[keep])))
    t, y = time[keep], swing[keep]
    exact = t[crossing] - y[crossing] * (t[crossing + 1] - t[crossing]) / (y[crossing + 1] - y[crossing])
    frequency = (len(exact) - 1) / 2 / (exact[-1] - exact[0])
    shift = frequency / plain - 1
    assert shift == pytest.approx(3 / 8 * change * 0.2**2, rel=0.06)


def test_nonlinear_stiffness_moves_the_peak_with_the_level(bench, hidden, stand):
    pair = stand(bench.robot, references=["tip:+z"], postures=["flat"], trials=2)
    for change, sense in ((0.5, 1), (-0.5, -1)):
        spec = hidden(pair, "nonlinear_stiffness", "q1", change=change)
        weak, hard = lines(pair)[np.argmax(np.abs(measured(pair, spec)[:, 1]), axis=-1)]
        assert sense * (hard - weak) > 0.4


def test_joint_coupling_splits_two_joints(bars, stand, hidden):
    bench = stand(bars(count=2), references=["tip:+z"], postures=["flat"])
    posture = bench.plan.postures[0]
    plain, tied = (
        build(bench, posture, []),
        build(bench, posture, [hidden(bench, "joint_coupling", "q1+q2", coupling=0.4)]),
    )
    np.testing.assert_allclose(tied.stiffness, K * np.array([[1, 0.4], [0.4, 1]]))
    m = plain.mass
    # det(K − λ M) = 0 by hand
    a = np.linalg.det(m)
    b = -(K * m[1, 1] + K * m[0, 0] - 2 * 0.4 * K * m[0, 1])
    c = K * K * (1 - 0.4**2)
    roots = np.sqrt(np.sort(np.roots([a, b, c]))) / 2 / np.pi
    np.testing.assert_allclose(np.sort(natural(tied)), roots, rtol=1e-9)


def test_added_mass_lowers_the_frequency_by_its_moment(bench, hidden):
    spec = hidden(bench, "added_mass", "link_1", mass=0.7, x=0.9, y=0.0, z=0.1, gyration=0.05)
    moment = I + 0.7 * (0.9**2 + 0.1**2 + 0.05**2)
    found = natural(build(bench, bench.plan.postures[0], [spec]))[0]
    assert found == pytest.approx(np.sqrt(K / moment) / 2 / np.pi, rel=1e-12)


def test_absorber_splits_the_peak(bench, hidden):
    """Den Hartog: two degrees of freedom; the drive point stands still at the absorber's own frequency."""
    own = np.sqrt(K / I) / 2 / np.pi
    spec = hidden(bench, "local_absorber", "link_1", mass=0.2, frequency=own, damping_ratio=0.0,
                  x=1.0, y=0.0, z=0.0, dx=0.0, dy=0.0, dz=1.0)  # fmt: skip
    plant = build(bench, bench.plan.postures[0], [spec])
    ratio = 0.2 / I  # at 1 m
    split = 1 + ratio / 2 + np.array([-1, 1]) * np.sqrt(ratio + ratio**2 / 4)
    np.testing.assert_allclose(np.sort(natural(plant)), own * np.sqrt(split), rtol=1e-9)
    at = tip(plant, np.array([0.97 * own, own, 1.03 * own]))
    assert np.abs(at[1]) < 1e-6 * np.abs(at[[0, 2]]).min()
    found = np.abs(measured(bench, spec)[0, 1])
    grid = lines(bench)
    low, high = (
        grid[s][np.argmax(found[s])] for s in ((grid > 10) & (grid < own), (grid > own) & (grid < 60))
    )
    np.testing.assert_allclose([low, high], own * np.sqrt(split), atol=0.5)  # a line is 0.5 Hz


def test_absorber_moves_stiffly_across_its_direction(bench, hidden):
    """Along the bar it is nothing but a mass that the bar never shakes that way."""
    spec = hidden(bench, "local_absorber", "link_1", mass=0.3, frequency=20.0, x=0.8, y=0.0, z=0.0,
                  dx=1.0, dy=0.0, dz=0.0)  # fmt: skip
    found = np.sort(natural(build(bench, bench.plan.postures[0], [spec])))
    np.testing.assert_allclose(found, [20.0, np.sqrt(K / (I + 0.3 * 0.8**2)) / 2 / np.pi], rtol=1e-9)


def test_sensor_mass_counts_where_the_sensor_sits(bars, stand, hidden):
    bench = stand(bars(damping=40.0), references=["tip:+z"])
    spec = hidden(bench, "sensor_mass", "sensor", mass=0.4)
    value = measured(bench, spec)[0]
    w = 2 * np.pi * lines(bench)
    inside = (lines(bench) >= 4) & (lines(bench) <= 100)
    for number, place in enumerate((0.5, 1.0)):
        exact = -(w**2) * place / (K + 1j * w * 40.0 - w**2 * (I + 0.4 * place**2))
        error = np.abs(value[number] - exact)[inside].max()
        assert error < 1e-5 * np.abs(exact[inside]).max()  # the record is long: exp(−σ T) is 1e-9


def test_sensor_gain_is_a_factor_at_one_point(bench, hidden):
    plain, spoilt = measured(bench), measured(bench, hidden(bench, "sensor_gain", "middle", error=0.2))
    np.testing.assert_allclose(spoilt[0, 0], 1.2 * plain[0, 0], rtol=1e-12)
    np.testing.assert_allclose(spoilt[0, 1], plain[0, 1], rtol=1e-12)


def test_time_delay_is_a_phase_slope(bench, hidden):
    delay = 7.3e-4  # no multiple of a sample or of the simulation's step
    plain, late = measured(bench), measured(bench, hidden(bench, "time_delay", "tip", delay=delay))
    inside = (lines(bench) >= 4) & (lines(bench) <= 100)
    f = lines(bench)[inside]
    turned = np.unwrap(np.angle(late[0, 1] / plain[0, 1])[inside])
    slope = np.polyfit(f, turned, 1)[0]
    assert slope == pytest.approx(-2 * np.pi * delay, rel=0.01)
    np.testing.assert_allclose(late[0, 0], plain[0, 0])


def test_sensor_misalignment_mixes_the_axes(bars, stand, hidden):
    bench = stand(bars(), references=["tip:+z"], postures=["raised"], axes="xz", points=1)
    spec = hidden(bench, "sensor_misalignment", "tip", angle=0.3, ax=0.0, ay=1.0, az=0.0)
    posture = bench.plan.postures[0]
    plain, askew = (h1(strike_posture(bench, posture, s, QUIET))[0][0, 0, 0] for s in ([], [spec]))
    c, s = np.cos(0.3), np.sin(0.3)  # about y: x goes to (c, −s), z to (s, c)
    np.testing.assert_allclose(askew[0], c * plain[0] - s * plain[1], atol=1e-12 * np.abs(plain).max())
    np.testing.assert_allclose(askew[1], s * plain[0] + c * plain[1], atol=1e-12 * np.abs(plain).max())


def test_clearance_shows_only_when_the_contact_opens(bench, hidden, stand):
    pair = stand(bench.robot, references=["tip:+z"], postures=["flat"], trials=2, peaks=(20.0, 240.0))
    low, high = pair.deflection["q1"]
    spec = hidden(pair, "clearance", "q1", gap=high, preload=1.5 * low)
    plain, loose = measured(pair), measured(pair, spec)
    size = np.abs(plain).max()
    assert np.abs(loose[0] - plain[0]).max() < 1e-3 * size  # second-order march against exact propagation
    assert np.abs(loose[1] - plain[1]).max() > 0.1 * size


def test_hose_depends_on_the_posture(bench, hidden, bars, stand):
    pair = stand(bars(count=2), references=["tip:+z"], postures=["flat", "raised"])
    spec = hidden(pair, "hose", "link_2", stiffness=2e4, damping=0.0, slack=1.5, x=0.0, y=0.0, z=1.0)
    added = [build(pair, p, [spec]).stiffness - build(pair, p, []).stiffness for p in pair.plan.postures]
    for extra in added:
        assert np.linalg.matrix_rank(extra, tol=1e-6) == 1
        assert np.linalg.eigvalsh(extra)[0] > -1e-6
    assert np.linalg.norm(added[0] - added[1]) > 0.1 * np.linalg.norm(added[0])


def test_saturation_clips_hard_blows_only(bench, hidden, stand):
    pair = stand(bench.robot, references=["tip:+z"], postures=["flat"], trials=2)
    spec = hidden(pair, "saturation", "tip", range=0.5 * pair.acceleration["tip"])
    plain, clipped = measured(pair), measured(pair, spec)
    size = np.abs(plain).max()
    assert np.abs(clipped[0] - plain[0]).max() < 1e-6 * size
    inside = (lines(pair) >= 10) & (lines(pair) <= 100)
    assert np.abs(clipped[1, 1] / plain[1, 1] - 1)[inside].max() > 0.05
    assert np.abs(clipped[1, 0] - plain[1, 0]).max() < 1e-6 * size  # another point's sensor


def test_neighbour_stills_the_floor_at_its_frequency(bars, stand, hidden):
    bench = stand(bars(), references=["tip:+z"])
    spec = hidden(bench, "neighbour", "base", floor_stiffness=2e6, floor_mass=50.0, mass=80.0, frequency=23.0,
                  damping_ratio=0.0)  # fmt: skip
    plant = build(bench, bench.plan.postures[0], [spec])
    push = plant.row("link_1", np.array([1.0, 0, 0]), np.array([0, 0, 1.0]))[None]
    floor = np.eye(plant.dof)[plant.coordinates.index("floor")][None]
    still = np.abs(plant.inertance(floor, push, np.array([22.5, 23.0, 23.5]))[:, 0, 0])
    assert still[1] < 1e-9 * still[[0, 2]].min()
    assert plant.dof == 3


@pytest.mark.parametrize(
    "pair", [("servo_compliance", "coulomb_friction"), ("link_flexibility", "added_mass")]
)
def test_effects_combine(pair, stand, hidden):
    bench = stand(flexmodal.load("fanuc_s360"), points=2, trials=2, band=(2.0, 200.0))
    places = {
        "servo_compliance": "q2",
        "coulomb_friction": "q2",
        "link_flexibility": "link_1",
        "added_mass": "link_1",
    }
    specs = [hidden(bench, name, places[name]) for name in pair]
    both, one, other = (
        strike_all_points(bench, bench.plan.postures[0], s, bench.plan.trials)
        for s in (specs, specs[:1], specs[1:])
    )
    for alone in (one, other):
        assert np.abs(both - alone).max() > 1e-3 * np.abs(both).max()
