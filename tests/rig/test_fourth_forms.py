"""What the forms of the set `fourth` are for small motions, against closed forms and second routes."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad

import flexmodal
from flexmodal.cards import FrozenDict
from flexmodal.model.placements import link_placements
from flexmodal.rig.forms.fourth_drives import curvature, lopsided
from flexmodal.rig.hammer_test import Conduct, h1, strike_posture
from flexmodal.rig.integration.laws import LAWS
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.plant.build import build, sensors
from flexmodal.rig.plant.geometry import across

from .conftest import B, I, K, S, inertance, measured, put, tip


@pytest.mark.parametrize("load", [0.02, 0.4, 0.8])
def test_a_squeezed_link_gives_as_a_beam_column(load, stiff, hidden):
    """E I w'' + P w = F (L − x) + P w_L x/L: at the far end F L/P (1 − u cot u), u = L √(P/E I)."""
    given = {"bending_stiffness": 3e3, "load": load, "damping_ratio": 0.0}
    plant = put(stiff, hidden(stiff, "link_flexibility:squeezed", "link_1", **given))
    bent = np.linalg.solve(plant.stiffness, tip(plant))
    u, pull = np.pi * np.sqrt(load), load * np.pi**2 * 3e3
    end = (1 - u / np.tan(u)) / pull
    assert tip(plant) @ bent == pytest.approx(end, rel=1e-4)
    for place in (0.3, 0.7):
        wave = (1 / pull - end) / u * np.sin(u * place) - np.cos(u * place) / pull
        assert tip(plant, place) @ bent == pytest.approx(wave + (1 - place) / pull + end * place, rel=1e-3)
    assert np.linalg.eigvalsh(plant.stiffness)[0] > 0


def test_wheels_carry_by_suspension_and_tyre_one_above_the_other(stiff, hidden):
    """Each upright as (k + c s) over (k_t (1 + t s) + m s²), one behind the other; level by the tyre."""
    given = {"suspension_stiffness": 1e5, "tyre": 2.5, "side": 0.6, "half_width": 0.4, "half_depth": 0.3}
    other = {"height": 0.25, "wheel_mass": 3.0, "platform_mass": 20.0, "damping_ratio": 0.1}
    spec = hidden(stiff, "base_flexibility:wheels", "base", **given, **other, damping_time=5e-4)
    plant = put(stiff, spec)
    damper = 0.1 * np.sqrt(1e5 * (stiff.mass + 20.0))
    at = [plant.coordinates.index(name) for name in ("base along", "base up", "base tilt")]
    wheels = [plant.coordinates.index(f"wheel {n}") for n in (1, 2, 3, 4)]
    for line in (1e-3, 12.0, 60.0):
        s = 2j * np.pi * line
        z = plant.stiffness + s * plant.damping + s**2 * plant.mass
        base, both, wheel = z[np.ix_(at, at)], z[np.ix_(at, wheels)], z[np.ix_(wheels, wheels)]
        found = base - both @ np.linalg.solve(wheel, both.T) - s**2 * plant.mass[np.ix_(at, at)]
        tyre = 2.5e5 * (1 + 5e-4 * s)
        upright = 4 / (1 / (1e5 + damper * s) + 1 / (tyre + 3.0 * s**2))
        level = 4 * 0.6 * tyre
        wanted = [level, upright, upright * 0.4**2 + level * 0.25**2]
        np.testing.assert_allclose(np.diag(found), wanted, rtol=1e-9)
        assert abs(found[0, 2]) == pytest.approx(abs(level) * 0.25)
        assert abs(found[0, 1]) + abs(found[1, 2]) < 1e-6 * abs(upright)
    # 20 kg that stand half as high as the root, and 0.8 m by 0.25 m about their centre
    bare = build(stiff, stiff.plan.postures[0], [hidden(stiff, "base_flexibility", "base")])
    added = plant.mass[1:4, 1:4] - bare.mass[1:4, 1:4]
    turned = 20.0 * ((0.8**2 + 0.25**2) / 12 + 0.125**2)
    np.testing.assert_allclose(np.diag(added), [20.0, 20.0, turned])


def test_two_motors_hold_a_joint_side_by_side(bench, hidden):
    p, d, rotor = 9e4, 120.0, 0.4
    spec = hidden(
        bench, "servo_compliance:two_motors", "q1", proportional_gain=p, derivative_gain=d,
        rotor_inertia=rotor, second=0.5, share=0.35,
    )  # fmt: skip
    row = 0.0
    for part, gain in ((0.35, p / 1.5), (0.65, p / 3)):
        row = row + 1 / (1 / (part * (K + S * B)) + 1 / (gain + d / 2 * S + rotor / 2 * S**2))
    np.testing.assert_allclose(inertance(put(bench, spec)), S**2 / (row + S**2 * I), rtol=1e-8)


@pytest.mark.parametrize("above", [0.3, 0.6])
def test_a_lopsided_peak_is_a_spread_of_relaxations(above, bench, hidden):
    """For α = 1 the times t < τ have the weights sin(βπ)/π (t/(τ − t))^β (Davidson and Cole)."""
    made = lopsided(0.1, 12.0, 1.0, above, (2.0, 100.0))

    def spread(line, odd):
        ratio = line / 12.0  # t = τ x; the poles at both ends are the quadrature's own
        power, size = odd + 1, np.sin(above * np.pi) / np.pi
        return quad(
            lambda x: size * ratio**power * x ** (power - 1) / (1 + (ratio * x) ** 2),
            0, 1, weight="alg", wvar=(above, -above),
        )[0]  # fmt: skip

    lines = np.array([3.0, 8.0, 20.0, 45.0, 90.0])
    real, imaginary = np.array([[spread(line, odd) for odd in (1, 0)] for line in lines]).T
    value = made.modulus(2 * np.pi * lines)
    found = value.imag / value.real
    size = found[2] / (imaginary[2] - found[2] * real[2])
    np.testing.assert_allclose(found, size * imaginary / (1 + size * real), rtol=0.02)
    every = made.modulus(2 * np.pi * np.geomspace(2.0, 100.0, 300))
    assert (every.imag / every.real).max() == pytest.approx(0.1, rel=0.02)


def test_a_hub_that_never_slips_is_a_spring_behind_the_joint(bars, stand, hidden):
    """Struck in time: k in a row with k₂ + σ while it sticks, with k₂ alone where nothing rubs."""
    given = {"softer": 0.8, "sticking": 3.0, "frequency": 250.0, "damping_time": 5e-4}
    bench = stand(bars(damping=60.0), references=["tip:+z"], postures=["flat"])
    own = K / 0.8
    hub = (K + 4 * own) / (2 * np.pi * 250.0) ** 2
    frequency = np.fft.rfftfreq(bench.plan.analyser.samples, bench.plan.analyser.interval)
    s = 2j * np.pi * frequency
    for torque, sticks in ((1e6, 3 * own), (1e-6, 0.0)):
        spec = hidden(bench, "coulomb_friction:clamped", "q1", torque=torque, **given)
        behind = own * (1 + 5e-4 * s) + sticks + hub * s**2
        row = 1 / (1 / (K + s * 60.0) + 1 / behind)
        found = measured(bench, spec)[-1]
        inside = (frequency >= 4) & (frequency <= 100)
        wanted = s**2 / (row + s**2 * I)
        np.testing.assert_allclose(found[inside], wanted[inside], atol=5e-3 * np.abs(wanted[inside]).max())


def test_a_flange_gapes_behind_the_joint(bench, hidden):
    """Slowly turned, τ = b k₂ θ + (1 − b) τ₀ tanh(k₂ θ/τ₀) and q = τ/k + θ."""
    given = {"softer": 0.3, "bolts": 0.2, "torque": 12.0, "frequency": 250.0, "damping_time": 5e-4}
    plant = put(bench, hidden(bench, "nonlinear_stiffness:gaping", "q1", **given))
    own = K / 0.3
    (element,) = plant.elements
    law, numbers = LAWS[element.kind], np.array(element.parameters)
    slopes = []
    for opened in (1e-9, 1e-4, -3e-4, 2e-3):
        torque = 0.2 * own * opened + 0.8 * 12.0 * np.tanh(own * opened / 12.0)
        at = np.array([torque / K + opened, opened])
        pull, _ = law(numbers, np.zeros(1), np.array([element.row @ at]), np.zeros(1), np.zeros(1))
        np.testing.assert_allclose(plant.stiffness @ at + element.row * pull, [torque, 0.0], atol=1e-9 * own)
        slopes.append(torque / opened / own)
    assert slopes[0] == pytest.approx(1.0)
    assert slopes[-1] < 0.5
    assert plant.mass[1, 1] == pytest.approx((K + own) / (2 * np.pi * 250.0) ** 2)


def stretched(robot, q, site):
    """|d|²/2 by small turns of both joints; the hooks are placed where the joints stand at q."""
    names = site.where.split("+")
    joints = [robot.urdf.joint_by_name[name] for name in names]
    links, there = (joints[0].parent, joints[1].child), link_placements(robot, q)
    hooks = []
    for joint, link, end in zip(joints, links, ("near", "far"), strict=True):
        mount = there[link][:3, :3]
        axis = mount.T @ there[joint.child][:3, :3] @ joint.axis
        side, angle = across(axis, None)[0], site[f"{end}_angle"]
        stands = np.cos(angle) * side + np.sin(angle) * np.cross(axis, side)
        pivot = mount.T @ (there[joint.child][:3, 3] - there[link][:3, 3])
        hooks.append(np.array([*(pivot + site[f"{end}_crank"] * stands), 1.0]))

    def energy(one, other):
        placed = link_placements(robot, q | {names[0]: q[names[0]] + one, names[1]: q[names[1]] + other})
        near, far = (placed[link] @ hook for link, hook in zip(links, hooks, strict=True))
        return np.sum((far - near)[:3] ** 2) / 2

    return energy


@pytest.mark.parametrize("where", ["q1+q2", "q4+q5"])
def test_a_taut_spring_turns_joints_by_its_second_derivatives(where, pair, hidden, stand):
    """In a plane and in space; beside the joints' springs it is a fifth to two fifths of them."""
    arm = pair
    if where == "q4+q5":
        arm = stand(flexmodal.load("six_axis"), references=["tool_side:+z"], postures=["work"])
    effect, site = hidden(arm, "joint_coupling:balancer", where)
    q, names, h = dict(arm.plan.postures[0].q), where.split("+"), 1e-3
    energy = stretched(arm.robot, q, site)
    mixed = (energy(h, h) - energy(h, -h) - energy(-h, h) + energy(-h, -h)) / 4
    first, second = (energy(h, 0) + energy(-h, 0), energy(0, h) + energy(0, -h))
    wanted = np.array([[first, mixed], [mixed, second]]) - 2 * energy(0, 0) * np.eye(2)
    found = curvature(PlantAssembly(arm.robot.at(q)), where, site.parameters)
    np.testing.assert_allclose(found, wanted / h**2, atol=1e-5 * np.abs(found).max())
    added = put(arm, (effect, site)).stiffness - put(arm).stiffness
    at = [list(arm.robot.joints).index(name) for name in names]
    np.testing.assert_allclose(added[np.ix_(at, at)], site["stiffness"] * found, rtol=1e-6, atol=1e-3)
    own = np.array([arm.true.stiffness[name] for name in names])
    over = np.linalg.eigvalsh(site["stiffness"] * found / np.sqrt(np.outer(own, own)))
    assert 0.19 < np.abs(over).max() < 0.41


def test_slung_cables_move_between_their_clips(pair, hidden):
    """The second bar upright: 2000 pieces on a line between the clips, each moved in proportion."""
    given = {"mass": 1.2, "x": 0.9, "y": 0.0, "z": 0.05, "x2": 0.6, "y2": 0.0, "z2": 0.1}
    spec = hidden(pair, "added_mass:slung", "link_2", **given)
    posture = replace(pair.plan.postures[0], q=FrozenDict({"q1": 0.0, "q2": np.pi / 2}))
    added = build(pair, posture, [spec]).mass - build(pair, posture, []).mass
    # in the plane: a clip at (0.9, 0.05), another at (1 − 0.1, 0.6) with the second joint at (1, 0)
    near = np.array([[-0.05, 0.0], [0.9, 0.0]])
    far = np.array([[-0.6, -0.6], [0.9, -0.1]])
    parts = (np.arange(2000) + 0.5) / 2000
    moved = [(1 - part) * near + part * far for part in parts]
    np.testing.assert_allclose(added, 1.2 * np.mean([m.T @ m for m in moved], axis=0), rtol=1e-6)


def test_a_body_on_a_leaf_sways_and_nods(stiff, hidden):
    """A clamped beam's end gives h³/3, h²/2 and h over E I; the lower frequency is the given one."""
    place = {"x": 0.6, "y": 0.0, "z": 0.05, "dx": 0.0, "dy": 0.0, "dz": 1.0}
    given = {"mass": 0.4, "frequency": 30.0, "damping_ratio": 0.02}
    sizes = {"height": 0.12, "overhang": 0.05, "gyration": 0.04}
    plant = put(stiff, hidden(stiff, "local_absorber:leaf", "link_1", **place, **given, **sizes))
    soft = np.linalg.inv(plant.stiffness[1:, 1:])
    h = 0.12
    np.testing.assert_allclose(soft / soft[1, 1], [[h**2 / 3, h / 2], [h / 2, 1.0]], rtol=1e-9)
    swings = np.linalg.eigvals(np.linalg.solve(plant.mass[1:, 1:], plant.stiffness[1:, 1:]))
    assert np.sqrt(swings.min()) / 2 / np.pi == pytest.approx(30.0)
    # stiff, it is a body on the bar, at (0.6, 0.05 + 0.17)
    rigid = 0.4 * (0.6**2 + 0.22**2 + 0.04**2)
    assert plant.mass[0, 0] == pytest.approx(I + rigid)
    # a sway of 1 at the leaf's end is one of the body's centre, and is moved by the bar with its height
    assert abs(plant.mass[0, 1]) == pytest.approx(0.4 * 0.22)
    assert abs(plant.mass[0, 2]) == pytest.approx(0.4 * (0.22 * 0.05 + 0.04**2))


def test_a_box_below_the_sensor_bounces_and_stays_behind(bench, hidden):
    """Flat bar, motion upright: m + m_b ω²/(ω² + s²) with what damps it."""
    given = {"mass": 0.1, "box_mass": 0.2, "length": 0.4, "frequency": 25.0, "damping_ratio": 0.06}
    spec = hidden(bench, "sensor_mass:converter", "sensor", **given)
    loaded = build(bench, bench.plan.postures[0], [spec], ("tip", sensors(bench, [spec])["tip"]))
    omega = 2 * np.pi * 25.0
    flows = omega**2 + 2 * 0.06 * omega * S
    felt = I + 0.1 + 0.2 * flows / (flows + S**2)
    np.testing.assert_allclose(inertance(loaded), S**2 / (K + B * S + S**2 * felt), rtol=1e-8)
    (slow,) = {round(float(x), 6) for x in np.sqrt(np.diag(loaded.stiffness)[1:3] / 0.2)}
    assert slow == pytest.approx(np.sqrt(9.81 / 0.4), rel=1e-5)


def test_an_adapter_rocks_under_its_sensor(bench, hidden):
    """From m, h, J and a spring: what a sensor at e reads over how the surface moves."""
    mass, high, inertia, at, spring, damper = 0.2, 0.03, 4e-4, 0.04, 60.0, 0.02
    own = np.sqrt(spring / inertia)
    given = {"share": mass * high * at / inertia, "resonance": own / 2 / np.pi}
    ratio = damper / 2 / np.sqrt(spring * inertia)
    spec = hidden(bench, "sensor_gain:adapter", "tip", **given, damping_ratio=ratio)
    (shape,) = sensors(bench, [spec])["tip"].filters
    turned = -mass * high / (inertia * S**2 + damper * S + spring)
    np.testing.assert_allclose(shape(S.imag), 1 + at * S**2 * turned, rtol=1e-9)


def test_a_long_line_is_many_short_ones(bench, hidden):
    """400 resistors with a capacitor each, from the open end backwards; late by R C/2."""
    (shape,) = sensors(bench, [hidden(bench, "time_delay:long_line", "tip", time=1.5e-3)])["tip"].filters
    count = 400
    voltage, current = np.ones(len(S), complex), np.zeros(len(S), complex)
    for _ in range(count):
        current = current + S * 3e-3 / count * voltage
        voltage = voltage + current / count
    np.testing.assert_allclose(shape(S.imag), 1 / voltage, rtol=5e-3)
    small = np.array([1e-2])
    assert -np.angle(shape(small))[0] / small[0] == pytest.approx(1.5e-3, rel=1e-6)


def test_a_sensor_that_is_reset_looks_another_way_in_each_posture(bars, stand, hidden):
    bench = stand(bars(), references=["tip:+z"], postures=["flat", "raised"], axes="xz", points=1)
    turns = []
    for throw in range(1, 200):
        spec = hidden(bench, "sensor_misalignment:reset", "tip", angle=0.2, throw=float(throw))
        sensor = sensors(bench, [spec])["tip"]
        for lift in (0.0, 0.7):
            axes = link_placements(bench.robot, {"q1": lift})["link_1"][:3, :3]
            way = sensor.direction(axes, np.array([0.0, 0.0, 1.0]))
            assert way[1] == pytest.approx(0.0, abs=1e-12)
            turns.append(np.arctan2(way[0], way[2]))
    turns = np.array(turns).reshape(-1, 2)
    assert np.sqrt(np.mean(turns**2)) == pytest.approx(0.2, rel=0.1)
    assert abs(np.corrcoef(turns.T)[0, 1]) < 0.2
    # and so it reads in each of them
    quiet = Conduct(noise=0.0, scatter=0.0)
    for posture, turned in zip(bench.plan.postures, turns[-1], strict=True):
        found = h1(strike_posture(bench, posture, [spec], quiet))[0][0, 0, 0]
        plain = h1(strike_posture(bench, posture, [], quiet))[0][0, 0, 0]
        wanted = np.cos(turned) * plain[1] + np.sin(turned) * plain[0]
        np.testing.assert_allclose(found[1], wanted, atol=1e-9 * np.abs(plain).max())


def test_a_slotted_stub_is_softer_a_way_that_turns_with_the_joint(bars, stand, hidden):
    given = {"bending_stiffness": 4e3, "length": 0.1, "ratio": 0.3, "phase": 0.4, "damping_time": 0.0}
    for posture, angle in (("flat", 0.4), ("raised", 1.1)):
        bench = stand(bars(), references=["tip:+z"], postures=[posture])
        plant = put(bench, hidden(bench, "bearing_flexibility:slotted", "q1", **given))
        moved = plant.motion("link_1", np.zeros(3))[[0, 2], 1:]
        stiffness = np.linalg.inv(moved @ np.linalg.inv(plant.stiffness[1:, 1:]) @ moved.T)
        values, vectors = np.linalg.eigh(stiffness)
        np.testing.assert_allclose(values, 3 * 4e3 / 0.1**3 * np.array([0.3, 1.0]))
        stands = np.arctan2(vectors[1, 1], vectors[0, 1])
        side = plant.motion("link_1", np.zeros(3))[[0, 2], 1]  # where the phase counts from
        start = np.arctan2(side[1], side[0])
        assert np.sin(stands - start - angle) == pytest.approx(0.0, abs=1e-9)


def test_a_slotted_stub_in_space_gives_as_a_cantilever(stand, hidden):
    """h³/3, h²/2 and h over E I one way, over a part of it the other; the inverse of the springs."""
    arm = stand(flexmodal.load("six_axis"), references=["tool_side:+z"], postures=["work"])
    given = {"bending_stiffness": 4e3, "length": 0.1, "ratio": 0.3, "axial_stiffness": 5e7}
    plant = put(arm, hidden(arm, "bearing_flexibility:slotted", "q3", **given))
    at = plant.coordinates.index("q3 bearing 1")
    soft = np.linalg.inv(plant.stiffness[at : at + 5, at : at + 5])
    shift, tilt = np.linalg.eigvalsh(soft[:2, :2]), np.linalg.eigvalsh(soft[3:, 3:])
    np.testing.assert_allclose(shift, 0.1**3 / 3 / 4e3 * np.array([1.0, 1 / 0.3]))
    np.testing.assert_allclose(tilt, 0.1 / 4e3 * np.array([1.0, 1 / 0.3]))
    mixed = np.linalg.svd(soft[:2, 3:], compute_uv=False)
    np.testing.assert_allclose(mixed, 0.1**2 / 2 / 4e3 * np.array([1 / 0.3, 1.0]))
    # pushed aside along x it tilts about y, the way a beam's end does
    assert soft[0, 4] > 0 > soft[1, 3]
    assert soft[2, 2] == pytest.approx(1 / 5e7)
