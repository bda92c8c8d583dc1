"""What the forms of the set `blind` are for small motions, against closed forms on uniform bars."""

import numpy as np
import pytest

import flexmodal
from flexmodal.rig.forms.maxwell_rows import biot, middle
from flexmodal.rig.hammer_test import Conduct, h1, strike_posture
from flexmodal.rig.integration import kernel
from flexmodal.rig.integration.laws import LAWS
from flexmodal.rig.plant.build import build, sensors
from flexmodal.rig.plant.geometry import turn
from flexmodal.rig.plant.plant import HERTZ, LOADED

from .conftest import B, I, K, S, inertance, pulled, put, tip


def test_plates_shift_their_far_end_and_do_not_tilt_it(stiff, hidden):
    """Guided at both ends: s at the tip, half of it at the middle, whose slope is 3/2 s over the length."""
    plant = put(stiff, hidden(stiff, "link_flexibility:plates", "link_1", sway_stiffness=5e3))
    moved = np.linalg.solve(plant.stiffness, tip(plant))
    assert tip(plant) @ moved == pytest.approx(1 / 5e3, rel=1e-6)
    assert tip(plant, 0.5) @ moved == pytest.approx(0.5 / 5e3, rel=1e-6)
    slopes = [plant.motion("link_1", np.array([place, 0, 0]))[3:] @ moved for place in (1.0, 0.5)]
    np.testing.assert_allclose(slopes[0], 0.0, atol=1e-9)
    assert np.linalg.norm(slopes[1]) == pytest.approx(1.5 / 5e3, rel=1e-6)


def test_plates_of_a_spatial_arm_are_soft_one_way(stand, hidden):
    bench = stand(flexmodal.load("six_axis"), references=["tool_side:+z"], postures=["work"])
    given = {"sway_stiffness": 5e5, "edgewise": 4.0}
    plant = put(bench, hidden(bench, "link_flexibility:plates", "link_2", **given, angle=0.6))
    bending = [name for name in plant.coordinates if name.startswith("link_2 bending")]
    assert len([name for name in bending if " 1." in name]) == 1
    edge = [plant.coordinates.index(name) for name in bending if " 2." in name]
    far = np.linalg.inv(plant.stiffness[np.ix_(edge, edge)])[0, 0]
    assert far == pytest.approx(1 / (4.0 * 5e5), rel=1e-6)


def test_a_girder_sinks_as_a_beam_held_at_both_ends(stiff, hidden):
    """Under a load P a³b³/(3 EI L³) and a slope of P a²b²(b − a)/(2 EI L³); stretched E A (1/a + 1/b)."""
    a, b, rigidity = 0.6, 1.4, 6e5
    given = {"bending_stiffness": rigidity, "length": 2.0, "place": 0.3, "gyration": 0.1, "girder_mass": 70.0}
    plant = put(stiff, hidden(stiff, "base_flexibility:gantry", "base", **given, below=0.0))
    soft = np.linalg.inv(plant.stiffness[1:, 1:])
    assert soft[1, 1] == pytest.approx(a**3 * b**3 / 3 / rigidity / 8)
    assert abs(soft[1, 2]) == pytest.approx(a**2 * b**2 * (b - a) / 2 / rigidity / 8)
    assert 1 / soft[0, 0] == pytest.approx(rigidity / 0.01 * (1 / a + 1 / b))
    weight = sum(body.mass for body in stiff.true.bodies.values())
    np.testing.assert_allclose(np.diag(plant.mass)[1:3], weight + 70.0 * np.array([1 / 3, 13 / 35]))
    # the robot stands nearer to the support on the −level side: a push down tilts it towards the middle
    level = np.array([1.0, 0, 0]) * np.sign(
        plant.row("base", np.zeros(3), np.array([1.0, 0, 0]))[plant.coordinates.index("base along")]
    )
    down = -plant.row("base", np.zeros(3), np.array([0, 0, 1.0]))
    moved = np.linalg.solve(plant.stiffness, down)
    ahead = -plant.row("base", 0.1 * level, np.array([0, 0, 1.0]))
    assert ahead @ moved > down @ moved > 0
    high = put(stiff, hidden(stiff, "base_flexibility:gantry", "base", **given, below=0.2))
    lever = np.linalg.inv(high.stiffness[1:, 1:])
    assert lever[0, 0] - soft[0, 0] == pytest.approx(0.04 * soft[2, 2])


def test_a_girder_in_space_bends_both_ways_and_twists(stand, hidden):
    bench = stand(flexmodal.load("six_axis"), references=["tool_side:+z"], postures=["work"])
    given = {"bending_stiffness": 6e5, "length": 2.0, "place": 0.5, "gyration": 0.1, "below": 0.0}
    more = {"sideways": 0.5, "torsion": 0.7, "angle": 0.0}
    plant = put(bench, hidden(bench, "base_flexibility:gantry", "base", **given, **more))
    at = plant.coordinates.index("base x")
    bent, tilted = 192 * 6e5 / 8, 16 * 6e5 / 2
    wanted = [4 * 6e5 / 0.01 / 2, bent / 2, bent, 0.7 * 4 * 6e5 / 2, tilted, tilted / 2]
    np.testing.assert_allclose(plant.stiffness[at : at + 6, at : at + 6], np.diag(wanted), atol=1e-6)


def test_torque_that_is_fed_back_makes_the_rotor_seem_lighter(bench, hidden):
    """(J s² + D s + P) φ = (1 + K_T/(1 + T s)) τ, τ = (k + b s)(θ − φ)."""
    p, d, t, gain, inertia = 9e4, 300.0, 4e-4, 1.5, 0.8
    spec = hidden(bench, "servo_compliance:torque_fed", "q1", rotor_inertia=inertia, proportional_gain=p,
                  derivative_gain=d, torque_gain=gain, filter_time=t)  # fmt: skip
    rotor = (p + d * S + inertia * S**2) / (1 + gain / (1 + t * S))
    row = 1 / (1 / (K + S * B) + 1 / rotor)
    np.testing.assert_allclose(inertance(put(bench, spec)), S**2 / (row + S**2 * I), rtol=1e-8)


@pytest.mark.parametrize("onset", [4.0, 30.0])
def test_a_loss_that_sets_in_is_biots_logarithm(onset):
    """Passive elements alone come within a twentieth of the largest loss, in stiffness too."""
    band = (2.0, 100.0)
    made = biot(0.1, onset, band)
    omega = 2 * np.pi * np.geomspace(*band, 60)
    found = made.modulus(omega)

    def law(at):
        return 1 + 0.2 / np.pi * np.log(1 + 1j * at / (2 * np.pi * onset))

    exact = law(omega) / law(middle(band)).real
    np.testing.assert_allclose(found, exact, atol=0.005)
    assert np.all(made.strengths >= 0)


def test_a_mesh_rubs_more_the_more_it_carries(bench, hidden):
    """Stuck, then sliding at F + μ k |u + u₀|; as it turns back it sticks first."""
    given = {"torque": 2.0, "presliding_stiffness": 2e5, "growing": 0.1, "weight": 5e-5}
    spec = hidden(bench, "coulomb_friction:loaded", "q1", **given)
    out = np.linspace(1e-6, 4e-4, 400)
    back = out[-1] - np.linspace(1e-7, 8e-4, 4000)
    found = pulled(bench, spec, np.concatenate([out, back]))
    most = 2.0 + 0.1 * K * np.abs(np.concatenate([out, back]) + 5e-5)
    np.testing.assert_allclose(found[:400], np.minimum(2e5 * out, most[:400]), rtol=1e-9)
    stuck = found[399] - 2e5 * (out[-1] - back)
    np.testing.assert_allclose(found[400:], np.maximum(stuck, -most[400:]), rtol=1e-9, atol=1e-9)


def test_rolling_contacts_are_two_of_hertz(bench, hidden):
    """c (δ₀ + u)^1.5 − c (δ₀ − u)^1.5 of stiffness 3 c √δ₀, less the straight part that they stand for."""
    spec = hidden(bench, "nonlinear_stiffness:rolling", "q1", change=0.8, deflection=0.01)
    path = np.linspace(-0.1, 0.1, 2001)
    found = pulled(bench, spec, path)
    c = 0.8 * K / 3 / np.sqrt(0.01)
    one, other = np.maximum(0.01 + path, 0), np.maximum(0.01 - path, 0)
    np.testing.assert_allclose(found, c * (one**1.5 - other**1.5) - 0.8 * K * path, atol=1e-9)
    slope = 1 + np.gradient(found / K, path)
    assert slope[1000] == pytest.approx(1.0, abs=1e-3)
    assert slope.min() == pytest.approx(1 - 0.8 * (1 - np.sqrt(0.5)), abs=5e-3)
    assert slope[-1] > 1.2


@pytest.mark.parametrize(("kind", "numbers"), [(LOADED, (50.0, 0.1, 6.0, 0.02)), (HERTZ, (50.0, 0.03))])
def test_the_loop_to_be_compiled_has_the_same_laws(kind, numbers):
    random = np.random.default_rng(5)
    p, (old, new, memory) = np.array(numbers), random.uniform(-0.1, 0.1, (3, 50))
    torque, kept = LAWS[kind](p, old, new, np.zeros(50), memory)
    force, fresh = np.zeros((2, 50))
    kernel.act(kind, p, old, new, np.zeros(50), np.zeros(50), memory, fresh, force, 0.0)
    np.testing.assert_allclose(force, -torque, rtol=1e-12)
    if kind == LOADED:
        np.testing.assert_allclose(fresh, kept, rtol=1e-12)


def test_a_remote_drive_is_stretched_by_both_joints(pair, hidden):
    """Tᵀ diag(k) T with T = [[1, 0], [−r, 1]], likewise the dampers; with a motor that gives, behind it."""
    spec = hidden(pair, "joint_coupling:remote", "q1+q2", ratio=-0.4)
    plant = put(pair, spec)
    both = np.array([[1, 0], [0.4, 1.0]])
    np.testing.assert_allclose(plant.stiffness, K * both.T @ both)
    np.testing.assert_allclose(plant.damping, B * both.T @ both)
    given = {"proportional_gain": 9e4, "derivative_gain": 300.0, "rotor_inertia": 0.8}
    motor = put(pair, spec, hidden(pair, "servo_compliance", "q2", **given)).stiffness
    condensed = motor[:2, :2] - np.outer(motor[:2, 2], motor[2, :2]) / motor[2, 2]
    soft = np.diag([K, 1 / (1 / K + 1 / 9e4)])
    np.testing.assert_allclose(condensed, both.T @ soft @ both)
    dry = put(pair, spec, hidden(pair, "coulomb_friction", "q2")).elements[0]
    np.testing.assert_allclose(dry.row, [0.4, 1.0])


@pytest.mark.parametrize("angle", [0.0, 0.7])
def test_a_liquid_goes_up_and_down_as_a_whole_and_partly_sideways(angle, bars, stand, hidden):
    """Above its sloshing the bar feels m upright, and of what goes sideways the part that does not slosh."""
    bench = stand(bars(), references=["tip:+z"], postures=["flat" if angle == 0 else "raised"])
    given = {"mass": 0.7, "x": 0.6, "y": 0.0, "z": 0.0, "radius": 0.1, "depth": 1.0, "damping_ratio": 0.05}
    plant = put(bench, hidden(bench, "added_mass:half_full", "link_1", **given))
    mass, at = plant.mass, plant.coordinates.index("slosh x")
    assert mass[at, at] / 0.7 == pytest.approx(np.tanh(1.84) / 2.2, rel=0.01)
    swings = np.sqrt(plant.stiffness[at, at] / mass[at, at])
    assert swings == pytest.approx(np.sqrt(1.8412 * 9.81 / 0.1 * np.tanh(1.8412)), rel=1e-4)
    part = mass[at, at] / 0.7
    high = 0.1 * (0.5 - 2 / 1.8412 * np.tanh(1.8412 / 2))
    low = -high * part / (1 - part)
    ahead, up = 0.6 * np.cos(angle), 0.6 * np.sin(angle)
    fast = mass[0, 0] - mass[0, at] ** 2 / mass[at, at]
    assert fast == pytest.approx(I + 0.7 * (ahead**2 + (1 - part) * (up + low) ** 2))
    slow = I + 0.7 * (ahead**2 + (1 - part) * (up + low) ** 2 + part * (up + high) ** 2)
    assert mass[0, 0] == pytest.approx(slow)


def test_a_stack_pulls_as_one_mass_behind_the_other(bench, hidden):
    """Dynamic mass seen from below: of a mass m behind a spring Z it is m/(1 + m s²/Z), inside first."""
    place = {"x": 0.8, "y": 0.0, "z": 0.0, "dx": 0.0, "dy": 0.0, "dz": 1.0}
    given = {"mass": 0.2, "frequency": 30.0, "second": 1.3, "share": 0.4, "damping_ratio": 0.03}
    plant = put(bench, hidden(bench, "local_absorber:stacked", "link_1", **place, **given))

    def behind(mass, inertia, omega):
        return mass / (1 + mass * S**2 / (inertia * (omega**2 + 2 * 0.03 * omega * S)))

    omega = 2 * np.pi * 30.0
    seen = behind(0.6 * 0.2 + behind(0.08, 0.08, 1.3 * omega), 0.2, omega)
    exact = S**2 / (K + B * S + S**2 * (I + 0.64 * seen))
    np.testing.assert_allclose(inertance(plant), exact, rtol=1e-8)


def test_a_cable_along_the_arm_weighs_on_each_link_on_its_way(pair, hidden):
    """A line of mass over both bars, or over the first and a half of the second."""
    spec = hidden(pair, "sensor_mass:along_arm", "sensor", mass=0.3, line_mass=0.6)
    plain = put(pair).mass
    for name, end in (("tip", 2.0), ("middle", 1.5)):
        loaded = build(pair, pair.plan.postures[0], [spec], (name, sensors(pair, [spec])[name]))
        added = loaded.mass - plain
        assert added[0, 0] == pytest.approx(0.3 * end**2 + 0.6 * end**3 / 3)
        assert added[1, 1] == pytest.approx(0.3 * (end - 1) ** 2 + 0.6 * (end - 1) ** 3 / 3)


def struck(bench, posture, *specs) -> np.ndarray:
    """Clean FRFs of the first point [axis, line]."""
    quiet = Conduct(noise=0.0, scatter=0.0)
    return h1(strike_posture(bench, bench.plan.postures[posture], specs, quiet))[0][0, 0, 0]


def test_an_axis_that_is_calibrated_wrongly_stands_out_along_itself(bars, stand, hidden):
    """Readings along the world's axes are worked out from the link's: 1 + e along one of these."""
    bench = stand(bars(), references=["tip:+z"], postures=["raised"], axes="xz", points=1)
    plain = struck(bench, 0)
    way = np.array([np.cos(0.7), np.sin(0.7)])  # the bar's own axis, and across it
    for axis, along in ((0, way), (2, np.array([-way[1], way[0]]))):
        spec = hidden(bench, "sensor_gain:one_axis", "tip", error=0.3, axis=float(axis))
        wanted = (np.eye(2) + 0.3 * np.outer(along, along)) @ plain
        np.testing.assert_allclose(struck(bench, 0, spec), wanted, atol=1e-9 * np.abs(plain).max())
    drawn = hidden(bench, "sensor_gain:one_axis", "tip")[1]
    assert drawn["axis"] == 2.0  # the tip does not move along the bar


def test_a_digital_sensor_smooths_by_its_recursion(bench, hidden):
    """y[n] = α x[n − 1] + (1 − α) y[n − 1], run on a sine until nothing of the start is left."""
    spec = hidden(bench, "time_delay:smoothed", "tip", time=1.5e-3, newest=0.3)
    (shape,) = sensors(bench, [spec])["tip"].filters
    step, omega, value = 0.3 * 1.5e-3, 2 * np.pi * 70.0, 0.0
    for n in range(1, 400):
        value = 0.3 * np.exp(1j * omega * step * (n - 1)) + 0.7 * value
    assert shape(np.array([omega]))[0] == pytest.approx(value / np.exp(1j * omega * step * 399))
    small = np.array([1e-2])
    assert -np.angle(shape(small))[0] / small[0] == pytest.approx(1.5e-3, rel=1e-6)


def test_a_sensor_follows_its_link_by_a_part(bars, stand, hidden):
    """Right in the first posture, turned by a part of 0.7 rad in the second; with the link's axes it lags."""
    names = {"references": ["tip:+z"], "postures": ["flat", "raised"], "points": 1}
    bench = stand(bars(), **names, axes="xz")
    spec = hidden(bench, "sensor_misalignment:following", "tip", part=0.5)
    np.testing.assert_allclose(struck(bench, 0, spec), struck(bench, 0), rtol=1e-9, atol=1e-12)
    plain, found = struck(bench, 1), struck(bench, 1, spec)
    c, s = np.cos(0.35), np.sin(0.35)
    wanted = np.array([[c, s], [-s, c]]) @ plain  # its x looks up as the bar does
    np.testing.assert_allclose(found, wanted, atol=1e-9 * np.abs(plain).max())
    own = stand(bars(), **names, axes="xz", frame="link")
    sensor = sensors(own, [hidden(own, "sensor_misalignment:following", "tip", part=0.5)])["tip"]
    axes = turn(np.array([0, -1.0, 0]), 0.7)
    looked = sensor.direction(axes, axes @ np.array([1.0, 0, 0]))
    np.testing.assert_allclose(looked, [c, 0, s], atol=1e-12)


def test_a_pinion_pushes_the_bearing_aside(bench, hidden):
    """A torque winds up the mesh and, over the base radius, the bearing: 1/k + 1/(r² k_r)."""
    given = {"radial_stiffness": 3e7, "base_radius": 0.08, "angle": 0.5}
    plant = put(bench, hidden(bench, "bearing_flexibility:pinion", "q1", **given))
    moved = np.linalg.solve(plant.stiffness, np.eye(plant.dof)[0])
    assert moved[0] == pytest.approx(1 / K + 1 / 0.08**2 / 3e7)
    np.testing.assert_allclose(moved[1:], -np.array([np.cos(0.5), np.sin(0.5)]) / 0.08 / 3e7)
    far = put(bench, hidden(bench, "bearing_flexibility:pinion", "q1", **{**given, "base_radius": 1e9}))
    own = {name: value for name, value in given.items() if name == "radial_stiffness"}
    plain = put(bench, hidden(bench, "bearing_flexibility", "q1", **own))
    np.testing.assert_allclose(far.stiffness, plain.stiffness, atol=1e-3)
