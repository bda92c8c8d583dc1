"""What the forms of the table `FIFTH` are for small motions, against closed forms and second routes."""

from dataclasses import replace

import numpy as np
import pytest

import flexmodal
from flexmodal.cards import FrozenDict
from flexmodal.rig.forms.fifth_drives import weights
from flexmodal.rig.hammer_test import Conduct, h1, strike_posture
from flexmodal.rig.integration import kernel
from flexmodal.rig.integration.laws import LAWS
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.plant.build import build, sensors
from flexmodal.rig.plant.plant import DRAGGED

from .conftest import FREQUENCY, B, I, K, S, inertance, measured, pulled, put, tip

G = 9.81


def test_beyond_an_opening_a_link_tilts_and_shifts(stiff, hidden):
    """F at the end, l from the opening: l²/k_t + 1/k_s there, a straight line back, nothing before it."""
    given = {"tilt_stiffness": 3e4, "shift_stiffness": 2e5, "place": 0.4, "damping_ratio": 0.0}
    plant = put(stiff, hidden(stiff, "link_flexibility:opening", "link_1", **given))
    bent = np.linalg.solve(plant.stiffness, tip(plant))
    for place in (0.3, 0.5, 0.8, 1.0):
        wanted = (place - 0.4) * 0.6 / 3e4 + 1 / 2e5 if place > 0.4 else 0.0
        assert tip(plant, place) @ bent == pytest.approx(wanted, abs=1e-12)


def test_an_opening_keeps_its_links_mass(bars, stand, hidden):
    """Stiff, the link is the rigid one again."""
    bench = stand(bars(), references=["tip:+z"], postures=["flat"])
    given = {"tilt_stiffness": 1e11, "shift_stiffness": 1e12}
    found = inertance(put(bench, hidden(bench, "link_flexibility:opening", "link_1", **given)))
    np.testing.assert_allclose(found, S**2 / (K + B * S + S**2 * I), rtol=1e-4)


def test_a_console_gives_as_a_cantilever_on_a_clamp_that_turns(stiff, hidden):
    """l³/3 E I + l²/k up, l/E I + 1/k of turn, l²/2 E I + l/k both; lengthways h² l/12 E I."""
    given = {
        "bending_stiffness": 2e5, "anchor_stiffness": 6e5, "length": 0.7, "depth": 0.3, "console_mass": 30.0,
        "damping_time": 3e-4,
    }  # fmt: skip
    plant = put(stiff, hidden(stiff, "base_flexibility:console", "base", **given))
    at = [plant.coordinates.index(name) for name in ("base along", "base up", "base tilt")]
    soft = np.linalg.inv(plant.stiffness[np.ix_(at, at)])
    rigidity, anchor, length = 2e5, 6e5, 0.7
    wanted = [
        0.3**2 * length / 12 / rigidity,
        length**3 / 3 / rigidity + length**2 / anchor,
        length / rigidity + 1 / anchor,
    ]
    np.testing.assert_allclose(np.diag(soft), wanted, rtol=1e-9)
    assert abs(soft[1, 2]) == pytest.approx(length**2 / 2 / rigidity + length / anchor)
    # pulled up, its end turns so that what lies farther out rises more
    motion = plant.motion("base", np.array([0.1, 0.0, 0.0]))[2]
    pushed = np.linalg.solve(plant.stiffness, plant.motion("base", np.zeros(3))[2])
    level = plant.motion("base", np.zeros(3))[0]
    assert motion @ pushed > plant.motion("base", np.zeros(3))[2] @ pushed
    assert level @ pushed == pytest.approx(0.0, abs=1e-15)
    np.testing.assert_allclose(plant.damping[np.ix_(at, at)], 3e-4 * plant.stiffness[np.ix_(at, at)])
    bare = build(stiff, stiff.plan.postures[0], [hidden(stiff, "base_flexibility", "base")])
    np.testing.assert_allclose(np.diag(plant.mass - bare.mass)[at], [10.0, 10.0, 0.0], atol=1e-9)


def test_a_console_in_space_bends_both_ways_and_twists(stand, hidden):
    """Turned to its own axes: six stiffnesses of which two pairs are tied."""
    arm = stand(flexmodal.load("six_axis"), references=["tool_side:+z"], postures=["work"])
    given = {
        "bending_stiffness": 2e5, "anchor_stiffness": 6e5, "length": 0.7, "depth": 0.3, "sideways": 0.5,
        "torsion": 0.6, "angle": 0.0,
    }  # fmt: skip
    plant = put(arm, hidden(arm, "base_flexibility:console", "base", **given))
    at = [plant.coordinates.index(f"base {name}") for name in ("x", "y", "z", "rx", "ry", "rz")]
    soft = np.linalg.inv(plant.stiffness[np.ix_(at, at)])
    sink, turned = 0.7**3 / 3 / 2e5 + 0.7**2 / 6e5, 0.7 / 2e5 + 1 / 6e5
    wanted = [0.09 * 0.7 / 12 / 2e5, 2 * sink, sink, 0.7 / 0.6 / 2e5, turned, 2 * turned]
    np.testing.assert_allclose(np.diag(soft), wanted, rtol=1e-8)
    assert soft[2, 4] < 0 < soft[1, 5]
    assert np.count_nonzero(np.abs(soft) > 1e-12) == 10


def test_an_observer_stiffens_a_loop_while_it_is_slow(bench, hidden):
    """The diagram as it is drawn: u = −C q + d̂, d̂ = Q (u − J s² q), solved for u over q."""
    given = {"proportional_gain": 9e4, "derivative_gain": 250.0, "rotor_inertia": 0.9}
    other = {"trust": 0.6, "filter_time": 8e-4}
    plant = put(bench, hidden(bench, "servo_compliance:observer", "q1", **given, **other))
    rotor, loop = 0.4 * 0.9, 0.4 * (9e4 + 250.0 * S)
    told = 0.6 / (1 + 0.4 * 8e-4 * S)
    torque = np.linalg.solve(
        np.stack([np.ones_like(S), -np.ones_like(S), -told, np.ones_like(S)], -1).reshape(-1, 2, 2),
        np.stack([-loop, -told * rotor * S**2], -1)[..., None],
    )[:, 0, 0]
    behind = -torque + rotor * S**2
    row = 1 / (1 / (K + S * B) + 1 / behind)
    np.testing.assert_allclose(inertance(plant), S**2 / (row + S**2 * I), rtol=1e-8)


@pytest.mark.parametrize("lift", [0.0, 0.8])
def test_a_joint_that_carries_weight_loses_less(lift, pair, hidden):
    """Two bars, each in its middle; a loss factor of η/(1 + |τ|/τ₀) across the band."""
    posture = replace(pair.plan.postures[0], q=FrozenDict({"q1": lift, "q2": 0.3}))
    inner, outer = 4 * G * 0.5 * np.cos(lift), 4 * G * 0.5 * np.cos(lift + 0.3)
    wanted = {"q1": inner + 4 * G * np.cos(lift) + outer, "q2": outer}
    assembly = PlantAssembly(pair.robot.at(dict(posture.q)))
    assert weights(assembly, pair) == pytest.approx(wanted, rel=1e-3)
    given = {"loss_factor": 0.15, "viscous": 0.0, "load": 20.0}
    plant = build(pair, posture, [hidden(pair, "structural_damping:pressed", "joints", **given)])
    np.testing.assert_allclose(plant.damping, 0.0, atol=1e-9)
    for number, name in enumerate(("q1", "q2")):
        omega = 2 * np.pi * np.array([4.0, 14.0, 60.0])
        value = plant.stiffness[number, number] + 0j
        for branch in plant.branches:
            if branch.row[number]:
                lag = 1j * omega * branch.time
                value = value + branch.stiffness * lag / (1 + lag)
        loss = 0.15 / (1 + wanted[name] / 20.0)
        np.testing.assert_allclose(value.imag / value.real, loss, rtol=0.06)
        assert value[1].real == pytest.approx(K, rel=0.02)


def test_a_released_disc_has_play_and_then_drags(bench, hidden):
    """Out and back: nothing within the play, a slope, F; on the way back twice the play is free."""
    given = {"torque": 6.0, "spline_stiffness": 3e5, "play": 1e-4}
    spec = hidden(bench, "coulomb_friction:splined", "q1", **given)
    path = np.concatenate([np.linspace(0, 5e-4, 501), np.linspace(5e-4, -5e-4, 1001)])
    torque = pulled(bench, spec, path)
    full = 6.0 / 3e5
    out, back = path[:501], path[501:]
    np.testing.assert_allclose(torque[:501], np.clip(3e5 * (out - 1e-4), 0, 6.0), atol=1e-9)
    turned = 5e-4 - back
    eased = np.clip(6.0 - 3e5 * turned, 0, None) - np.clip(3e5 * (turned - full - 2e-4), 0, 6.0)
    np.testing.assert_allclose(torque[501:], eased, atol=1e-9)
    # around a whole loop it slips twice by 2 a less twice the play and what the splines give
    loop = np.concatenate([path[501:], np.linspace(-5e-4, 5e-4, 1001)])
    pull = pulled(bench, spec, np.concatenate([path[:501], loop]))[501:]
    lost = np.sum((pull[1:] + pull[:-1]) / 2 * np.diff(loop))
    assert lost == pytest.approx(2 * 6.0 * (1e-3 - 2e-4 - 2 * full), rel=1e-3)


def test_the_compiled_loop_drags_the_same_disc():
    random = np.random.default_rng(5)
    p, (old, new, memory) = np.array([50.0, 0.6, 0.02]), random.uniform(-0.1, 0.1, (3, 50))
    torque, kept = LAWS[DRAGGED](p, old, new, np.zeros(50), memory)
    force, fresh = np.zeros((2, 50))
    kernel.act(DRAGGED, p, old, new, np.zeros(50), np.zeros(50), memory, fresh, force, 0.0)
    np.testing.assert_allclose(force, -torque, rtol=1e-12)
    np.testing.assert_allclose(fresh, kept, rtol=1e-12)
    assert np.any(torque == 0)
    assert np.abs(torque).max() == pytest.approx(0.6)


def test_a_hard_blow_leaves_one_strand(bench, hidden):
    """τ = k₂ θ up to θ₀, then k₂/2 more; q = τ/k + θ."""
    given = {"softer": 0.8, "deflection": 5e-4, "frequency": 250.0, "damping_time": 5e-4}
    plant = put(bench, hidden(bench, "nonlinear_stiffness:strands", "q1", **given))
    own = K / 0.8
    (element,) = plant.elements
    law, numbers = LAWS[element.kind], np.array(element.parameters)
    for turned in (1e-9, 3e-4, -4.9e-4, 8e-4, -3e-3):
        size = abs(turned)
        torque = np.sign(turned) * own * (min(size, 5e-4) + max(size - 5e-4, 0) / 2)
        at = np.array([torque / K + turned, turned])
        pull, _ = law(numbers, np.zeros(1), np.array([element.row @ at]), np.zeros(1), np.zeros(1))
        np.testing.assert_allclose(plant.stiffness @ at + element.row * pull, [torque, 0.0], atol=1e-9 * own)
    assert plant.mass[1, 1] == pytest.approx((K + own) / (2 * np.pi * 250.0) ** 2)


def test_a_tight_belt_that_never_goes_slack_is_a_spring_behind(bars, stand, hidden):
    """Struck in time, at a deflection that no blow reaches."""
    bench = stand(bars(damping=60.0), references=["tip:+z"], postures=["flat"])
    given = {"softer": 0.8, "deflection": 1e3, "frequency": 250.0, "damping_time": 5e-4}
    found = measured(bench, hidden(bench, "nonlinear_stiffness:strands", "q1", **given))[-1]
    frequency = np.fft.rfftfreq(bench.plan.analyser.samples, bench.plan.analyser.interval)
    s, own = 2j * np.pi * frequency, K / 0.8
    behind = own * (1 + 5e-4 * s / 2) + (K + own) / (2 * np.pi * 250.0) ** 2 * s**2
    wanted = s**2 / (1 / (1 / (K + s * 60.0) + 1 / behind) + s**2 * I)
    inside = (frequency >= 4) & (frequency <= 100)
    np.testing.assert_allclose(found[inside], wanted[inside], atol=5e-3 * np.abs(wanted[inside]).max())


def test_a_roller_makes_a_belt_swing(pair, hidden):
    """1/(1/k + 1/(k_t + c s + m s²)) on q₁ − r q₂; held joints let it swing at its frequency."""
    given = {"stiffness": 3e4, "ratio": -0.7, "tightness": 1.4, "frequency": 40.0, "damping_ratio": 0.08}
    spec = hidden(pair, "joint_coupling:tensioner", "q1+q2", **given)
    plant, plain = put(pair, spec), put(pair)
    omega = 2 * np.pi * 40.0
    inertia = 3e4 * 2.4 / omega**2
    assert np.sqrt(plant.stiffness[2, 2] / plant.mass[2, 2]) == pytest.approx(omega)
    for line in (0.0, 15.0, 40.0, 90.0):
        s = 2j * np.pi * line
        whole = plant.stiffness + s * plant.damping + s**2 * plant.mass
        found = whole[:2, :2] - np.outer(whole[:2, 2], whole[2, :2]) / whole[2, 2]
        bare = plain.stiffness + s * plain.damping + s**2 * plain.mass
        roller = 4.2e4 + 2 * 0.08 * omega * inertia * s + inertia * s**2
        belt = 1 / (1 / 3e4 + 1 / roller)
        np.testing.assert_allclose(found - bare, belt * np.outer([1, 0.7], [1, 0.7]), atol=1e-6 * K)


@pytest.mark.parametrize("angle", [0.0, 0.7])
def test_grain_lies_at_the_bottom_of_its_vessel(angle, bars, stand, hidden):
    """A million grains of a half ball below the vessel's middle, wherever the bar stands."""
    bench = stand(bars(), references=["tip:+z"], postures=["flat" if angle == 0 else "raised"])
    given = {"mass": 0.9, "x": 0.6, "y": 0.0, "z": 0.05, "radius": 0.15}
    added = put(bench, hidden(bench, "added_mass:heap", "link_1", **given)).mass[0, 0] - I
    grains = np.random.default_rng(3).uniform(-0.15, 0.15, (1000000, 3))
    grains = grains[(np.sum(grains**2, axis=1) < 0.15**2) & (grains[:, 2] < 0)]
    middle = [0.6 * np.cos(angle) - 0.05 * np.sin(angle), 0.6 * np.sin(angle) + 0.05 * np.cos(angle)]
    placed = grains[:, [0, 2]] + middle
    assert added == pytest.approx(0.9 * np.mean(np.sum(placed**2, axis=1)), rel=1e-3)


def test_a_loop_swings_between_two_links(pair, hidden):
    """m/3 (a² + a b + b²) + 2 m/π (a + b) y + m/2 y², on a spring of m/2 ω²."""
    place = {"x": 0.6, "y": 0.0, "z": 0.1, "nx": 0.8, "ny": 0.0, "nz": 0.05, "dx": 0.0, "dy": 0.0, "dz": 1.0}
    given = {"mass": 1.5, "frequency": 22.0, "damping_ratio": 0.03}
    plant, plain = put(pair, hidden(pair, "local_absorber:loop", "link_2", **place, **given)), put(pair)
    near = np.array([[-0.05, 0.0], [0.8, 0.0]])  # along x and up, by both joints
    far = np.array([[-0.1, -0.1], [1.6, 0.6]])
    wanted = 0.5 * (near.T @ near + (near.T @ far + far.T @ near) / 2 + far.T @ far)
    np.testing.assert_allclose((plant.mass - np.pad(plain.mass, (0, 1)))[:2, :2], wanted, rtol=1e-9)
    np.testing.assert_allclose(plant.mass[:2, 2], 1.5 / np.pi * (near + far)[1], rtol=1e-9)
    assert plant.mass[2, 2] == pytest.approx(0.75)
    assert np.sqrt(plant.stiffness[2, 2] / 0.75) == pytest.approx(2 * np.pi * 22.0)
    assert plant.damping[2, 2] == pytest.approx(2 * 0.03 * 0.75 * 2 * np.pi * 22.0)


@pytest.mark.parametrize("point", ["middle", "tip"])
def test_sensors_that_move_on_together_all_weigh(point, bench, hidden):
    """A bar with two points: both carry one whichever is measured, or each its own where it comes alone."""
    at = {"middle": 0.5, "tip": 1.0}
    names = [one.name for one in bench.plan.points]
    assert set(names) == set(at)
    for together, felt in ((2.0, 0.2 * (0.5**2 + 1.0)), (1.0, 0.2 * at[point] ** 2)):
        spec = hidden(bench, "sensor_mass:in_sets", "sensor", mass=0.2, together=together)
        loaded = build(bench, bench.plan.postures[0], [spec], (point, sensors(bench, [spec])[point]))
        assert loaded.mass[0, 0] == pytest.approx(I + felt, rel=1e-9)


def test_a_decimator_droops(bench, hidden):
    """Three running means of 200 values each, one after the other, turned back by what they are late."""
    null, count = 160.0, 200
    spec = hidden(bench, "sensor_gain:droop", "tip", null=null, order=3.0)
    (shape,) = sensors(bench, [spec])["tip"].filters
    taps = np.arange(count) - (count - 1) / 2
    mean = np.exp(-S[:, None] * taps / (null * count)).mean(axis=1)
    np.testing.assert_allclose(shape(S.imag), mean.real**3, rtol=1e-3)
    np.testing.assert_allclose(mean.imag, 0.0, atol=1e-9)
    drawn = hidden(bench, "sensor_gain:droop", "tip")[1]
    assert 0.4 < np.sinc(100.0 / drawn["null"]) ** drawn["order"] < 0.77


@pytest.mark.parametrize("key", ["time_delay:drifting", "sensor_misalignment:loosening"])
def test_some_things_grow_from_posture_to_posture(key, bars, stand, hidden):
    """As the rig's own form of a half in the first of two postures, and of the whole in the second."""
    bench = stand(bars(), references=["tip:+z"], postures=["flat", "raised"], axes="xz")
    name, quiet = key.split(":")[0], Conduct(noise=0.0, scatter=0.0)
    number, size = ("delay", 1e-3) if name == "time_delay" else ("angle", 0.4)
    for posture, part in zip(bench.plan.postures, (0.5, 1.0), strict=True):
        spec, same = (hidden(bench, k, "tip", **{number: n}) for k, n in ((key, size), (name, part * size)))
        found, wanted, plain = (
            h1(strike_posture(bench, posture, specs, quiet))[0] for specs in ([spec], [same], [])
        )
        np.testing.assert_allclose(found, wanted, rtol=1e-9, atol=1e-12 * np.abs(wanted).max())
        lines = (FREQUENCY[0] < np.arange(found.shape[-1])) & (np.arange(found.shape[-1]) < 100)
        assert np.abs(found - plain)[..., lines].max() > 0.05 * np.abs(plain)[..., lines].max()


def test_a_fork_gives_across_its_prongs(bars, stand, hidden):
    """The joint of a second bar: 12 E I/(h² l) along the first one, 3 E I/l³ across it, from both prongs."""
    bench = stand(bars(count=2), references=["tip:+z"], postures=["raised"])
    given = {"bending_stiffness": 3e3, "length": 0.2, "depth": 0.1, "uneven": 0.6, "damping_time": 2e-4}
    plant = put(bench, hidden(bench, "bearing_flexibility:fork", "q2", **given))
    moved = plant.motion("link_2", np.zeros(3))[[0, 2], 2:]
    stiffness = np.linalg.inv(moved @ np.linalg.inv(plant.stiffness[2:, 2:]) @ moved.T)
    along = np.array([np.cos(0.7), np.sin(0.7)])
    across = np.array([-along[1], along[0]])
    assert along @ stiffness @ along == pytest.approx(1.6 * 12 * 3e3 / 0.1**2 / 0.2)
    assert across @ stiffness @ across == pytest.approx(1.6 * 3 * 3e3 / 0.2**3)
    assert along @ stiffness @ across == pytest.approx(0.0, abs=1e-3)
    np.testing.assert_allclose(plant.damping[2:, 2:], 2e-4 * plant.stiffness[2:, 2:])


def test_a_fork_in_space_holds_a_tilt_by_its_width(stand, hidden):
    """Springs at ±w along the axis: sums of k, k p and k p², a plate's softness along the axis."""
    arm = stand(flexmodal.load("six_axis"), references=["tool_side:+z"], postures=["work"])
    given = {
        "bending_stiffness": 3e3, "length": 0.2, "depth": 0.1, "thickness": 0.4, "wide": 0.12, "uneven": 0.6,
    }  # fmt: skip
    plant = put(arm, hidden(arm, "bearing_flexibility:fork", "q3", **given))
    at = plant.coordinates.index("q3 bearing 1")
    found = plant.stiffness[at : at + 5, at : at + 5]
    soft, stiff = 3 * 3e3 / 0.2**3, 12 * 3e3 / 0.1**2 / 0.2
    np.testing.assert_allclose(np.linalg.eigvalsh(found[:2, :2]), 1.6 * np.array([soft, stiff]))
    np.testing.assert_allclose(np.linalg.eigvalsh(found[3:, 3:]), 1.6 * 0.12**2 * np.array([soft, stiff]))
    assert found[2, 2] == pytest.approx(1.6 * soft * 0.4**2)
    # the stiffer prong stands at −w: its line through the axis is where a push does not tilt
    mixed = found[:2, 3:] @ [[0, -1], [1, 0]]  # by ry and −rx
    np.testing.assert_allclose(mixed, -0.4 / 1.6 * 0.12 * found[:2, :2], atol=1e-6 * soft)
