"""What the forms that were written last are for small motions, against closed forms on uniform bars."""

import numpy as np
import pytest

import flexmodal
from flexmodal.rig.forms.maxwell_rows import cole_cole
from flexmodal.rig.hammer_test import Conduct, h1, strike_posture

from .conftest import measured, pulled, put

K, B, I = 4e4, 4.0, 4.0 / 3  # the bar: joint stiffness and damping, moment about the joint  # noqa: E741
FREQUENCY = np.linspace(2, 100, 300)
S = 2j * np.pi * FREQUENCY


def tip(plant, place=1.0) -> np.ndarray:
    return plant.row("link_1", np.array([place, 0, 0]), np.array([0, 0, 1.0]))


def test_a_cracked_beam_bends_as_a_whole_one_and_opens_besides(stiff, hidden):
    """1/(3 EI) of a load at the tip, and its lever about the crack over the crack's spring."""
    spec = hidden(stiff, "link_flexibility:cracked", "link_1", bending_stiffness=4000.0, place=0.4, crack=2.0)
    plant = put(stiff, spec)
    found = tip(plant) @ np.linalg.solve(plant.stiffness, tip(plant))
    assert found == pytest.approx(1 / 3 / 4000.0 + 0.6**2 / 8000.0, rel=1e-6)


def test_a_pedestal_is_the_end_of_a_clamped_column(stiff, hidden):
    """Compliance to a force h³/3EI, to a moment h/EI, between them h²/2EI; E A/h upright."""
    given = {"bending_stiffness": 6e5, "height": 0.8, "radius": 0.2, "pedestal_mass": 70.0}
    plant = put(stiff, hidden(stiff, "base_flexibility:pedestal", "base", **given))
    soft = np.linalg.inv(plant.stiffness[1:, 1:])
    assert soft[0, 0] == pytest.approx(0.8**3 / 3 / 6e5)
    assert soft[2, 2] == pytest.approx(0.8 / 6e5)
    assert abs(soft[0, 2]) == pytest.approx(0.8**2 / 2 / 6e5)
    assert 1 / soft[1, 1] == pytest.approx(2 * 6e5 / 0.2**2 / 0.8)
    weight = sum(body.mass for body in stiff.true.bodies.values())
    assert plant.mass[1, 1] == pytest.approx(weight + 33 / 140 * 70.0)
    # a push along +level bends the column so that it leans that way: both signs as on a real one
    up, level = np.array([0, 0, 1.0]), plant.row("base", np.zeros(3), np.array([1.0, 0, 0]))
    higher = plant.row("base", up, np.array([1.0, 0, 0]))
    moved = np.linalg.solve(plant.stiffness, level)
    assert higher @ moved > level @ moved > 0


def test_a_pedestal_in_space_bends_both_ways_and_twists(stand, hidden):
    bench = stand(flexmodal.load("six_axis"), references=["tool_side:+z"], postures=["work"])
    given = {"bending_stiffness": 6e5, "height": 0.8, "radius": 0.2, "ratio": 0.5}
    plant = put(bench, hidden(bench, "base_flexibility:pedestal", "base", **given))
    at = plant.coordinates.index("base x")
    soft = np.linalg.inv(plant.stiffness[at : at + 6, at : at + 6])
    np.testing.assert_allclose(np.diag(soft)[:2], 0.8**3 / 3 / np.array([6e5, 3e5]))
    np.testing.assert_allclose(np.diag(soft)[3:], 0.8 / np.array([3e5, 6e5, 6e5 / 1.3]))
    np.testing.assert_allclose([soft[0, 4], -soft[1, 3]], 0.8**2 / 2 / np.array([6e5, 3e5]))


def test_two_rows_of_balls_hold_back_to_back(stand, hidden):
    """Their levers add up; rows or balls that are pressed unevenly tie tilts and shifts."""
    bench = stand(flexmodal.load("six_axis"), references=["tool_side:+z"], postures=["work"])
    given = {
        "ball_stiffness": 1e7, "radius": 0.1, "apart": 0.06, "contact_angle": 0.6, "damping_time": 0.0,
        "angle": 0.0,
    }  # fmt: skip

    def seat(uneven, rear):
        spec = hidden(bench, "bearing_flexibility:angular_contact", "q3", **given, uneven=uneven, rear=rear)
        plant = put(bench, spec)
        at = [plant.coordinates.index(f"q3 bearing {k + 1}") for k in range(5)]
        return plant.stiffness[np.ix_(at, at)]

    across, along = np.cos(0.6), np.sin(0.6)
    lever = across * 0.03 + along * 0.1
    alike = np.array([across**2, across**2, 2 * along**2, lever**2, lever**2])
    np.testing.assert_allclose(seat(0.0, 1.0), 16e7 * np.diag(alike), atol=1e-3)
    rows = seat(0.0, 0.5)
    np.testing.assert_allclose(np.diag(rows), 0.75 * 16e7 * alike)
    assert rows[0, 4] == pytest.approx(16e7 / 2 * across * lever * 0.5)
    assert rows[1, 3] == pytest.approx(-rows[0, 4])
    assert rows[0, 2] == pytest.approx(0.0, abs=1e-3)
    assert seat(0.6, 0.5)[0, 2] == pytest.approx(-16e7 / 2 * 0.6 * across * along * 0.5)


def test_a_notch_takes_the_loop_away_at_its_frequency(bench, hidden):
    """Rotor: (k + N(s)(P + D s) + J s²) φ = k θ, N = (1 + 2 ζ r T s + T² s²)/(1 + 2 ζ T s + T² s²)."""
    p, d, t, wide, left, inertia = 9e4, 300.0, 9e-4, 0.5, 0.2, 0.8
    spec = hidden(bench, "servo_compliance:notched", "q1", rotor_inertia=inertia, proportional_gain=p,
                  derivative_gain=d, notch_time=t, width=wide, left=left)  # fmt: skip
    joint = K + S * B
    notch = (1 + 2 * wide * left * t * S + (t * S) ** 2) / (1 + 2 * wide * t * S + (t * S) ** 2)
    row = 1 / (1 / joint + 1 / (notch * (p + d * S) + inertia * S**2))
    plant = put(bench, spec)
    found = plant.inertance(tip(plant)[None], tip(plant)[None], FREQUENCY)[:, 0, 0]
    np.testing.assert_allclose(found, S**2 / (row + S**2 * I), rtol=1e-8)


@pytest.mark.parametrize("order", [0.45, 0.8])
def test_a_spread_of_times_loses_as_its_formula_says(order):
    """Passive elements alone come within a tenth of the largest loss, which is met."""
    band = (2.0, 100.0)
    made = cole_cole(0.1, 20.0, order, band)
    omega = 2 * np.pi * np.geomspace(*band, 60)
    found = made.modulus(omega)
    loss = found.imag / found.real
    assert loss.max() == pytest.approx(0.1, rel=0.02)
    assert np.all(made.strengths >= 0)
    turned = (1j * omega / (2 * np.pi * 20.0)) ** order
    value = [1 + size * turned / (1 + turned) for size in np.linspace(0.05, 2, 4000)]
    best = min(value, key=lambda one: abs((one.imag / one.real).max() - 0.1))
    np.testing.assert_allclose(loss, best.imag / best.real, atol=0.004)
    beyond = cole_cole(2 * np.tan(order * np.pi / 2), 20.0, order, band).modulus(omega)
    assert 0.1 < (beyond.imag / beyond.real).max() < np.tan(order * np.pi / 2)


def test_a_seal_and_a_gear_rub_each_for_itself(bench, hidden):
    given = {"torque": 3.0, "presliding_stiffness": 1e5, "share": 0.4, "speed": 0.02}
    spec = hidden(bench, "coulomb_friction:seal", "q1", **given)
    path = np.linspace(1e-6, 1e-4, 100)
    dry = np.minimum(1e5 * path, 0.6 * 3.0)
    wet = 0.4 * 3.0 * np.tanh(1e-6 / 1e-4 / 0.02)
    np.testing.assert_allclose(pulled(bench, spec, path), dry + wet, rtol=1e-9)


def test_teeth_come_to_bear_over_decades(bench, hidden):
    spec = hidden(bench, "nonlinear_stiffness:gradual", "q1", change=0.6, deflection=0.01)
    path = np.array([-1e-5, 1e-5, 1e-3, 0.01, 1.0])
    exact = -sum(0.2 * K * at * np.tanh(path / at) for at in (0.002, 0.01, 0.05))
    np.testing.assert_allclose(pulled(bench, spec, path), exact, rtol=1e-9)


def test_a_hose_along_which_nothing_gives_across_is_a_rod(pair, hidden):
    given = {"stiffness": 1e5, "crank": 0.3, "angle": 0.7, "turn": 0.4}
    rod = put(pair, hidden(pair, "joint_coupling:rod", "q1+q2", **given))
    bare = put(pair, hidden(pair, "joint_coupling:hose", "q1+q2", **given, across=0.0, damping_time=1e-3))
    np.testing.assert_allclose(bare.stiffness, rod.stiffness, atol=1e-6)
    np.testing.assert_allclose(
        bare.damping - B * np.eye(2), 1e-3 * (rod.stiffness - K * np.eye(2)), atol=1e-9
    )
    thick = put(pair, hidden(pair, "joint_coupling:hose", "q1+q2", **given, across=1.0, damping_time=0.0))
    added = np.linalg.eigvalsh(thick.stiffness - K * np.eye(2))
    alone = np.linalg.eigvalsh(rod.stiffness - K * np.eye(2))
    assert alone[0] == pytest.approx(0.0, abs=1e-6 * alone[1])  # a rod ties both by one number
    assert added[0] > 1e-3 * added[1]


def test_a_counterweight_is_a_cuboid(bench, hidden):
    place = {"x": -0.4, "y": 0.0, "z": 0.05}
    spec = hidden(bench, "added_mass:counterweight", "link_1", mass=0.7, thickness=0.1, depth=0.3, **place)
    about = 0.7 * (0.4**2 + 0.05**2 + (0.3**2 + 0.1**2) / 12)  # the joint's axis is the frame's y
    assert put(bench, spec).mass[0, 0] == pytest.approx(I + about)


def test_a_string_weighs_as_a_rod_while_slow_and_swings_at_its_harmonics(bench, hidden):
    place = {"x": 0.6, "y": 0.0, "z": 0.0, "dx": 1.0, "dy": 0.0, "dz": 0.0}
    given = {"mass": 0.2, "frequency": 30.0, "damping_ratio": 0.03, "length": 0.5}
    plant = put(bench, hidden(bench, "local_absorber:string", "link_1", **place, **given))
    assert plant.dof == 4
    own = np.diag(plant.stiffness)[1:] / np.diag(plant.mass)[1:]
    np.testing.assert_allclose(np.sqrt(own) / 2 / np.pi, [30.0, 60.0, 90.0], rtol=1e-9)
    assert plant.mass[0, 0] == pytest.approx(I + 0.2 * (0.6**2 + 0.5**2 / 12))
    # what all of it does on a bar that turns: the string's own formula, m ∫∫ of its Green's function
    omega = 2 * np.pi * 20.0
    seen = plant.mass[0, 0] + sum(
        plant.mass[0, k] ** 2 * omega**2 / (plant.stiffness[k, k] - plant.mass[k, k] * omega**2)
        for k in (1, 2, 3)
    )
    x = np.linspace(0, 0.5, 20001)
    c, moved = 2 * 0.5 * 30.0, 0.35 + x  # wave speed; the ends move as the bar does at 0.35 and 0.85 m
    k = omega / c
    wave = (0.35 * np.sin(k * (0.5 - x)) + 0.85 * np.sin(k * x)) / np.sin(k * 0.5)
    exact = I + 0.2 / 0.5 * np.trapezoid(moved * wave, x)
    assert seen == pytest.approx(exact, rel=0.01)


def test_exchanged_cables_exchange_two_axes(bars, stand, hidden):
    bench = stand(bars(), references=["tip:+z"], postures=["flat"], axes="xz", points=1)
    posture, quiet = bench.plan.postures[0], Conduct(noise=0.0, scatter=0.0)

    def struck(*specs):
        return h1(strike_posture(bench, posture, specs, quiet))[0][0, 0, 0]

    plain, found = struck(), struck(hidden(bench, "sensor_misalignment:swapped", "tip", stays=0.0))
    np.testing.assert_allclose(found, plain[::-1], atol=1e-9 * np.abs(plain).max())


def test_tape_is_a_standard_solid_under_the_sensor(bars, stand, hidden):
    """The sensor's mass swings on k_s (1 + r iωτ/(1 + iωτ)), whose mean over both limits is m ω₀²."""
    bench = stand(bars(damping=40.0), references=["tip:+z"], postures=["flat"])
    given = {"mass": 0.4, "frequency": 150.0, "relaxing": 0.8}
    value = measured(bench, hidden(bench, "sensor_mass:taped", "sensor", **given))[1]
    lines = np.fft.rfftfreq(bench.plan.analyser.samples, bench.plan.analyser.interval)
    inside = (lines >= 4) & (lines <= 100)
    s, own = 2j * np.pi * lines[inside], 2 * np.pi * 150.0
    tape = 0.4 * own**2 / 1.4 * (1 + 0.8 * s / own / (1 + s / own))
    swing = 0.4 * tape / (tape + 0.4 * s**2)
    exact = s**2 / (K + 40.0 * s + s**2 * (I + swing))
    assert np.abs(value[inside] - exact).max() < 1e-4 * np.abs(exact).max()
