"""What the forms that no diagnosis had met are for small motions, against closed forms on uniform bars."""

import numpy as np
import pytest

import flexmodal
from flexmodal.rig.forms.maxwell_rows import middle
from flexmodal.rig.hammer_test import Conduct, h1, strike_posture

from .conftest import measured, pulled, put

K, B, I = 4e4, 4.0, 4.0 / 3  # the bar: joint stiffness and damping, moment about the joint  # noqa: E741
FREQUENCY = np.linspace(2, 100, 300)
W = 2 * np.pi * FREQUENCY


def compliance(plant, place=1.0) -> float:
    """Deflection of the tip under a load that stands still [m/N]."""
    row = plant.row("link_1", np.array([place, 0, 0]), np.array([0, 0, 1.0]))
    return float(row @ np.linalg.solve(plant.stiffness, row))


def tip(plant) -> np.ndarray:
    row = plant.row("link_1", np.array([1.0, 0, 0]), np.array([0, 0, 1.0]))[None]
    return plant.inertance(row, row, FREQUENCY)[:, 0, 0]


def test_a_stepped_beam_bends_as_its_integral_says(stiff, hidden):
    """∫ (1 − x)²/EI dx, the step at the end of an element."""
    spec = hidden(
        stiff, "link_flexibility:stepped", "link_1", bending_stiffness=4000.0, place=0.5, outer=0.25
    )
    inner, outer = (1 - 0.5**3) / 3, 0.5**3 / 3
    assert compliance(put(stiff, spec)) == pytest.approx((inner + outer / 0.25) / 4000.0, rel=1e-6)
    even = hidden(stiff, "link_flexibility:stepped", "link_1", bending_stiffness=4000.0, outer=1.0)
    assert compliance(put(stiff, even)) == pytest.approx(1 / 3 / 4000.0, rel=1e-6)


def test_two_flanges_tilt_one_after_the_other(stiff, hidden):
    spec = hidden(stiff, "link_flexibility:flanges", "link_1", stiffness=5e3, far=0.5)
    assert compliance(put(stiff, spec)) == pytest.approx(0.97**2 / 5e3 + 0.03**2 / 2.5e3, rel=1e-6)


def test_a_carriage_gives_along_its_rail_and_stands_on_its_blocks(stiff, hidden):
    """Upright four blocks, along the drive alone; the blocks' levers against a tilt about their plane."""
    given = {"drive_stiffness": 3e5, "block_stiffness": 4e5, "half_length": 0.3, "below": 0.2}
    plant = put(stiff, hidden(stiff, "base_flexibility:carriage", "base", **given, carriage_mass=50.0))
    found = plant.stiffness[1:, 1:]
    assert found[0, 0] == pytest.approx(3e5)
    assert found[1, 1] == pytest.approx(1.6e6)
    assert abs(found[0, 2]) == pytest.approx(3e5 * 0.2)
    assert found[2, 2] == pytest.approx(1.6e6 * 0.09 + 3e5 * 0.04)
    total = sum(body.mass for body in stiff.true.bodies.values()) + 50.0
    assert plant.mass[1, 1] == pytest.approx(total)


@pytest.mark.parametrize("angle", [0.0, 1.0])
def test_a_carriage_in_space_is_held_sideways_and_free_along(angle, stand, hidden):
    bench = stand(flexmodal.load("six_axis"), references=["tool_side:+z"], postures=["work"])
    given = {"drive_stiffness": 3e5, "block_stiffness": 4e5, "sideways": 0.5, "angle": angle}
    plant = put(bench, hidden(bench, "base_flexibility:carriage", "base", **given))
    start = plant.coordinates.index("base x")
    level = plant.stiffness[start : start + 2, start : start + 2]
    rail = np.linalg.eigh(level)[1][:, 0]
    np.testing.assert_allclose(np.linalg.eigvalsh(level), [3e5, 8e5])
    level_axis = np.array([1.0, 0.0])
    assert abs(rail @ level_axis) == pytest.approx(abs(np.cos(angle)))
    assert np.linalg.eigvalsh(plant.mass)[0] > 0


def test_tight_bolts_are_the_rigs_own_bearing_and_loose_ones_tie_tilt_and_shift(stand, hidden):
    bench = stand(flexmodal.load("six_axis"), references=["tool_side:+z"], postures=["work"])
    given = {"bolt_stiffness": 1e7, "radius": 0.1, "shear": 0.5, "damping_time": 0.0, "angle": 0.0}

    def seat(**more):
        plant = put(bench, hidden(bench, "bearing_flexibility:bolts", "q3", **given, **more))
        at = [plant.coordinates.index(f"q3 bearing {k + 1}") for k in range(5)]
        return plant.stiffness[np.ix_(at, at)]

    tilt = 8 / 2 * 1e7 * 0.1**2
    np.testing.assert_allclose(seat(tightness=1.0), np.diag([4e7, 4e7, 8e7, tilt, tilt]), atol=1e-4)
    loose = seat(tightness=0.0, loose=1.0)  # the bolt at angle 0 is gone: it held z − r ry
    gone = np.array([0, 0, 1.0, 0, -0.1])
    wanted = np.diag([3.5e7, 3.5e7, 8e7, tilt, tilt]) - 1e7 * np.outer(gone, gone)
    np.testing.assert_allclose(loose, wanted, atol=1e-4)


def test_a_loop_that_reads_the_link_pushes_the_rotor_by_both_angles(bench, hidden):
    """Rotor: (k + P_m + D s + J s²) φ = (k − P_l/(1 + T s)) θ, k the joint with its damper."""
    p, d, t, part, inertia = 9e4, 300.0, 4e-4, 0.4, 0.8
    spec = hidden(bench, "servo_compliance:link_side", "q1", rotor_inertia=inertia, proportional_gain=p,
                  derivative_gain=d, link_side=part, filter_time=t)  # fmt: skip
    s = 1j * W
    joint = K + s * B
    rotor = (joint - part * p / (1 + t * s)) / (joint + (1 - part) * p + d * s + inertia * s**2)
    exact = s**2 / (joint * (1 - rotor) + s**2 * I)
    np.testing.assert_allclose(tip(put(bench, spec)), exact, rtol=1e-8)
    motor = hidden(bench, "servo_compliance:link_side", "q1", rotor_inertia=inertia, proportional_gain=p,
                   derivative_gain=d, link_side=0.0, filter_time=t)  # fmt: skip
    row = joint * (p + d * s + inertia * s**2) / (joint + p + d * s + inertia * s**2)
    np.testing.assert_allclose(tip(put(bench, motor)), s**2 / (row + s**2 * I), rtol=1e-8)


def modulus(plant, joint: int) -> np.ndarray:
    """Complex stiffness of a joint over its real part mid-band."""
    branches = [b for b in plant.branches if b.row[joint]]
    lag = 1j * W[:, None] * [b.time for b in branches]
    return plant.stiffness[joint, joint] + (lag / (1 + lag)) @ [b.stiffness for b in branches]


def test_two_relaxations_have_a_loss_of_the_size_that_was_asked_for(bench, hidden):
    given = {"loss_factor": 0.1, "low": 0.2, "apart": 0.5, "second": 1.0, "viscous": 0.0}
    plant = put(bench, hidden(bench, "structural_damping:two_peaks", "joints", **given))
    found = modulus(plant, 0)
    loss = found.imag / found.real
    assert loss.max() == pytest.approx(0.1, rel=1e-3)
    assert sorted(b.time for b in plant.branches) == pytest.approx(
        sorted(1 / (2 * np.pi * 2 * 50 ** np.array([0.2, 0.7])))
    )
    strengths = [b.stiffness for b in plant.branches]
    assert strengths[0] == pytest.approx(strengths[1])
    at = np.interp(middle((2.0, 100.0)), W, found.real)
    assert at == pytest.approx(K, rel=1e-3)


def test_a_geared_joint_loses_and_the_other_does_not(pair, hidden):
    spec = hidden(pair, "structural_damping:geared", "joints", loss_factor=0.08, phase=1.0, viscous=0.0)
    plant = put(pair, spec)
    losses = [np.mean(modulus(plant, k).imag / modulus(plant, k).real) for k in (0, 1)]
    assert np.sin(1.0) > 0 > np.sin(1.0 + 2.399963)
    assert losses[0] == pytest.approx(0.08, rel=0.03)
    assert losses[1] < 2e-4


def test_early_slips_make_a_backbone_that_is_a_power_of_the_deflection(bench, hidden):
    """With limits φ ∝ p^(1/(1+χ)): k u less what slipped; all of it at the largest limit."""
    spec = hidden(
        bench, "coulomb_friction:segalman", "q1", torque=3.0, presliding_stiffness=1e5, exponent=-0.5
    )
    parts = ((np.arange(6) + 0.5) / 6) ** 2
    limits = 3.0 * parts / parts.sum() / (1e5 / 6)
    path = np.linspace(0, 1.2 * limits[-1], 400)
    exact = (1e5 / 6 * np.minimum(path[:, None], limits)).sum(axis=1)
    np.testing.assert_allclose(pulled(bench, spec, path), exact, rtol=1e-9, atol=1e-9)
    assert exact[-1] == pytest.approx(3.0)
    assert np.all(np.diff(limits) > 0)


def test_an_s_shaped_spring_softens_and_then_hardens(bench, hidden):
    given = {"change": 0.4, "deflection": 0.01}
    path = np.linspace(-0.08, 0.08, 801)
    found = pulled(bench, hidden(bench, "nonlinear_stiffness:s_shaped", "q1", **given), path) / K
    exact = 0.4 * (0.01 * np.tanh(path / 0.01) - path + path**3 / 0.06**2)
    np.testing.assert_allclose(found, exact, atol=1e-12)
    slope = 1 + np.gradient(found, path)
    assert slope[400] == pytest.approx(1.0, abs=1e-3)
    assert slope.min() < 0.8 < 2 < slope[-1]
    assert slope.argmin() != 400


def test_a_stop_is_a_second_spring_from_its_deflection_on(bench, hidden):
    spec = hidden(bench, "nonlinear_stiffness:stop", "q1", change=1.5, deflection=0.01)
    path = np.array([-0.05, -0.01, 0.0, 0.005, 0.01, 0.03, 0.1])
    exact = 1.5 * K * np.sign(path) * np.maximum(np.abs(path) - 0.01, 0)
    np.testing.assert_allclose(pulled(bench, spec, path), exact, atol=1e-9)


def test_a_differential_is_its_two_meshes(pair, hidden):
    given = {"stiffness": 1e4, "ratio": 0.7, "second": 0.3, "loss": 1e-3}
    plant = put(pair, hidden(pair, "joint_coupling:differential", "q1+q2", **given))
    meshes = 1e4 * (np.outer([1, 0.7], [1, 0.7]) + 0.3 * np.outer([1, -0.7], [1, -0.7]))
    np.testing.assert_allclose(plant.stiffness - K * np.eye(2), meshes)
    np.testing.assert_allclose(plant.damping - B * np.eye(2), 1e-3 * meshes)


def test_a_duct_is_a_line_of_mass(bench, hidden):
    ends = {"x": 0.2, "y": 0.0, "z": 0.1, "x2": 0.9, "y2": 0.0, "z2": 0.1}
    plant = put(bench, hidden(bench, "added_mass:duct", "link_1", mass=0.7, **ends))
    moment = (0.9**3 - 0.2**3) / 3 / 0.7 + 0.1**2
    assert plant.mass[0, 0] == pytest.approx(I + 0.7 * moment)


def test_a_whip_weighs_as_a_stiff_one_while_slow_and_swings_at_its_frequencies(bench, hidden):
    place = {"x": 1.0, "y": 0.0, "z": 0.0, "dx": 0.0, "dy": 0.0, "dz": 1.0}
    given = {"mass": 0.2, "frequency": 30.0, "damping_ratio": 0.03, "length": 0.3}
    plant = put(bench, hidden(bench, "local_absorber:whip", "link_1", **place, **given))
    assert plant.dof == 3
    own = np.diag(plant.stiffness)[1:] / np.diag(plant.mass)[1:]
    np.testing.assert_allclose(np.sqrt(own) / 2 / np.pi, [30.0, 30.0 * 6.2669], rtol=1e-6)
    sign = 1 if plant.mass[0, 0] > I + 0.2 else -1  # it stands along the bar, out or in
    exact = ((1 + sign * 0.3) ** 3 - 1) / 3 / (sign * 0.3)
    assert plant.mass[0, 0] == pytest.approx(I + 0.2 * exact, rel=2e-3)


def test_a_chip_feels_across_its_axes_unevenly(bars, stand, hidden):
    bench = stand(bars(), references=["tip:+z"], postures=["flat"], axes="xz", points=1)
    posture, quiet = bench.plan.postures[0], Conduct(noise=0.0, scatter=0.0)
    cross = dict.fromkeys(("xy", "yx", "yz", "zy"), 0.9) | {"xz": 0.5, "zx": -1.0}

    def struck(*specs):
        return h1(strike_posture(bench, posture, specs, quiet))[0][0, 0, 0]

    plain = struck()
    found = struck(hidden(bench, "sensor_misalignment:cross_axis", "tip", angle=0.2, **cross))
    size = np.abs(plain).max()
    np.testing.assert_allclose(found, np.array([[1, 0.1], [-0.2, 1]]) @ plain, atol=1e-9 * size)
    assert np.abs(plain[0]).max() < 1e-9 * size  # the tip of a level bar moves upright


def test_a_bracket_weighs_as_a_mass_above_the_surface_that_swings(bars, stand, hidden):
    """Along the bar's own axis it is stiff, so that its height counts by h²."""
    bench = stand(bars(damping=40.0), references=["tip:+z"], postures=["flat"])
    given = {"mass": 0.4, "height": 0.1, "frequency": 250.0, "damping_ratio": 0.0}
    value = measured(bench, hidden(bench, "sensor_mass:bracket", "sensor", **given))[1]
    lines = np.fft.rfftfreq(bench.plan.analyser.samples, bench.plan.analyser.interval)
    inside = (lines >= 4) & (lines <= 100)
    s = 2j * np.pi * lines[inside]
    swing = 0.4 / (1 + (s / (500 * np.pi)) ** 2)
    exact = s**2 / (K + 40.0 * s + s**2 * (I + 0.4 + swing * 0.1**2))  # it stands upright on a level bar
    assert np.abs(value[inside] - exact).max() < 2e-5 * np.abs(exact).max()
