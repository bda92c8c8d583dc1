"""What the forms of the table `SEVENTH` are for small motions, against closed forms and second routes."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import erfc

import flexmodal
from flexmodal.cards import FrozenDict
from flexmodal.rig.forms.seventh_drives import stretched
from flexmodal.rig.forms.seventh_joints import ring_load
from flexmodal.rig.forms.seventh_sensors import knocked_at
from flexmodal.rig.hammer_test import Conduct, h1, strike_posture
from flexmodal.rig.hidden.severity import noise_floor, predicted
from flexmodal.rig.integration import kernel
from flexmodal.rig.integration.laws import LAWS
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.plant.build import build, sensors
from flexmodal.rig.plant.plant import WOUND

from .conftest import B, I, K, S, inertance, pulled, put, tip

G = 9.81


def six_axis(stand, **given):
    return stand(flexmodal.load("six_axis"), references=["tool_side:+z"], postures=["work"], **given)


def test_a_tube_bends_between_its_castings(stiff, hidden):
    """A force at the end: curvature F (1 − x)/EI where the tube is, integrated twice."""
    given = {"bending_stiffness": 2e4, "near": 0.2, "far": 0.25, "flat": 1.0, "damping_ratio": 0.0}
    plant = put(stiff, hidden(stiff, "link_flexibility:housings", "link_1", **given))
    bent = np.linalg.solve(plant.stiffness, tip(plant))
    x = np.linspace(0, 1, 20001)
    curved = np.where((x > 0.2) & (x < 0.75), (1 - x) / 2e4, 0.0)
    slope = np.cumsum(curved) * (x[1] - x[0])
    deflection = np.cumsum(slope) * (x[1] - x[0])
    for place in (0.1, 0.4, 0.75, 0.9, 1.0):
        wanted = np.interp(place, x, deflection)
        assert tip(plant, place) @ bent == pytest.approx(wanted, rel=2e-3, abs=1e-12)


def test_a_stiff_tube_between_castings_keeps_its_links_mass(bars, stand, hidden):
    bench = stand(bars(), references=["tip:+z"], postures=["flat"])
    found = inertance(
        put(bench, hidden(bench, "link_flexibility:housings", "link_1", bending_stiffness=1e11))
    )
    np.testing.assert_allclose(found, S**2 / (K + B * S + S**2 * I), rtol=1e-4)


def test_a_flat_tube_is_stiffer_one_way(stand, hidden):
    arm = six_axis(stand)
    where = "link_3" if "link_3" in {one.name for one in arm.robot.urdf.links} else arm.robot.tool
    plant = put(arm, hidden(arm, "link_flexibility:housings", where, flat=2.5))
    first, second = (plant.coordinates.index(f"{where} bending {k}.1") for k in (1, 2))
    assert plant.stiffness[second, second] / plant.stiffness[first, first] == pytest.approx(2.5)


AIR = {
    "vertical_stiffness": 2e4, "horizontal_stiffness": 3e4, "damping_ratio": 0.0, "chambers": 1.5,
    "orifice_time": 0.02, "apart": 1.2, "table_mass": 50.0, "thickness": 0.2,
}  # fmt: skip


def dynamic(plant, s):
    """M s² + C s + K, Maxwell elements among it."""
    value = plant.mass * s**2 + plant.damping * s + plant.stiffness
    for branch in plant.branches:
        lag = s * branch.time
        value = value + branch.stiffness * lag / (1 + lag) * np.outer(branch.row, branch.row)
    return value


def test_a_table_on_air_bounces_on_two_chambers(stiff, hidden):
    """Two chambers and a flow from one to the other, eliminated: k (1 + N τs/(1 + τs)) each."""
    plant = put(stiff, hidden(stiff, "base_flexibility:isolated", "base", **AIR))
    plain = put(stiff)
    along, up, tilt = (plant.coordinates.index(f"base {name}") for name in ("along", "up", "tilt"))
    base = stiff.true.bodies["base"].mass
    weight = plant.mass[up, up]
    assert weight == pytest.approx(base + 4.0 + 50.0)
    assert plant.mass[0, 0] == pytest.approx(plain.mass[0, 0])
    for hertz in (0.01, 3.0, 1000.0):
        s = 2j * np.pi * hertz
        # a spring N k beside the mount's, in a row with a damper N k τ: its far end moves by y
        held = np.array([[2e4 + 3e4, -3e4], [-3e4, 3e4 + 3e4 * 0.02 * s]])
        mount = held[0, 0] - held[0, 1] * held[1, 0] / held[1, 1]
        found = dynamic(plant, s) - plant.mass * s**2
        assert found[up, up] == pytest.approx(4 * mount)
        assert found[along, along] == pytest.approx(4 * 3e4)
        # mounts 0.6 m to either side and 0.2 m below
        assert found[tilt, tilt] == pytest.approx(4 * (mount * 0.36 + 3e4 * 0.04))
        assert abs(found[along, tilt]) == pytest.approx(4 * 3e4 * 0.2)
    moment = 50.0 / 12 * (1.44**2 + 0.04) + 50.0 * 0.01
    other = put(stiff, hidden(stiff, "base_flexibility:isolated", "base", **{**AIR, "table_mass": 1e-9}))
    assert plant.mass[tilt, tilt] - other.mass[tilt, tilt] == pytest.approx(moment)


def test_a_table_on_air_in_space_stands_on_four_mounts(stand, hidden):
    arm = six_axis(stand)
    plant, plain = put(arm, hidden(arm, "base_flexibility:isolated", "base", **AIR)), put(arm)
    n = plain.dof
    found = plant.stiffness[n:, n:]
    wanted = np.diag([12e4, 12e4, 8e4, 0, 0, 4 * 3e4 * 2 * 0.36])
    wanted[3, 3] = wanted[4, 4] = 4 * (2e4 * 0.36 + 3e4 * 0.04)
    wanted[0, 4] = wanted[4, 0] = -4 * 3e4 * 0.2
    wanted[1, 3] = wanted[3, 1] = 4 * 3e4 * 0.2
    np.testing.assert_allclose(found, wanted, atol=1e-6)


def test_a_sheet_moves_as_its_crumbs_do(stand, hidden):
    """In space, by a hundred thousand points on it."""
    arm = six_axis(stand)
    link = arm.robot.tool
    along, wide = np.array([0.6, 0.0, 0.8]), np.array([0.0, 1.0, 0.0])
    given = {
        "mass": 2.0, "x": 0.1, "y": 0.02, "z": -0.03, "long": 0.8, "wide": 0.5, "lx": 0.6, "ly": 0.0,
        "lz": 0.8, "wx": 0.3, "wy": 1.0, "wz": 0.4,
    }  # fmt: skip
    plant, plain = put(arm, hidden(arm, "added_mass:sheet", link, **given)), put(arm)
    grid = (np.arange(30) + 0.5) / 30
    wanted = np.zeros_like(plain.mass)
    for one in grid:
        for other in grid:
            place = np.array([0.1, 0.02, -0.03]) + 0.8 * one * along + 0.5 * (other - 0.5) * wide
            moved = plain.motion(link, place)[:3]
            wanted += 2.0 / 900 * moved.T @ moved
    np.testing.assert_allclose(plant.mass - plain.mass, wanted, atol=2e-3 * np.abs(wanted).max())


WIRE = {
    "mass": 0.5, "frequency": 30.0, "damping_ratio": 0.01, "strands": 0.4, "travel": 1e-4,
    "x": 0.8, "y": 0.0, "z": 0.0, "dx": 0.0, "dy": 0.0, "dz": 1.0,
}  # fmt: skip


def test_a_box_on_wire_ropes_softens_as_strands_slide(bench, hidden):
    """Out: (1 − p) k y + p k y₀ tanh(y/y₀); all of k while it is small."""
    spec = hidden(bench, "local_absorber:wire_rope", "link_1", **WIRE)
    plant, spring = put(bench, spec), 0.5 * (2 * np.pi * 30.0) ** 2
    path = np.linspace(0, 5e-4, 400)
    np.testing.assert_allclose(
        pulled(bench, spec, path), 0.4 * spring * 1e-4 * np.tanh(path / 1e-4), rtol=1e-9
    )
    assert plant.stiffness[1, 1] == pytest.approx(0.6 * spring)
    (element,) = plant.elements
    np.testing.assert_allclose(element.row, [0.0, 1.0])
    np.testing.assert_allclose(plant.mass, [[I + 0.5 * 0.64, 0.4], [0.4, 0.5]], rtol=1e-9)


def test_strands_take_work_and_give_none(bench, hidden):
    """Along a path at random no more work ever came out than went in, and a round costs some."""
    spec = hidden(bench, "local_absorber:wire_rope", "link_1", **WIRE)
    random = np.random.default_rng(3)
    corners = np.concatenate([[0.0], random.uniform(-4e-4, 4e-4, 30), [0.0]])
    path = np.interp(np.linspace(0, 31, 12000), np.arange(32), corners)
    work = np.cumsum(pulled(bench, spec, path) * np.diff(path, prepend=0.0))
    assert work.min() > -1e-9
    assert work[-1] > 0


def test_a_box_on_wire_ropes_that_never_slide_is_the_rigs_own(bars, stand, hidden):
    """Struck in time, with strands that stick."""
    bench = stand(bars(damping=60.0), references=["tip:+z"], postures=["flat"])
    rope = hidden(bench, "local_absorber:wire_rope", "link_1", **{**WIRE, "travel": 1e3})
    shared = {name: value for name, value in WIRE.items() if name not in ("strands", "travel")}
    own = hidden(bench, "local_absorber", "link_1", **shared)
    quiet = Conduct(noise=0.0, scatter=0.0)
    found, wanted = (
        h1(strike_posture(bench, bench.plan.postures[0], [one], quiet))[0] for one in (rope, own)
    )
    frequency = np.fft.rfftfreq(bench.plan.analyser.samples, bench.plan.analyser.interval)
    inside = (frequency >= 4) & (frequency <= 100)
    off = np.abs(found - wanted)[..., inside]
    assert off.max() < 5e-3 * np.abs(wanted[..., inside]).max()


def test_a_stepping_motor_is_damped_through_its_winding(bench, hidden):
    """Voltage by speed, current through R and L, torque by current: written out with Kt = 1."""
    given = {"magnetic_stiffness": 9e4, "back_emf": 250.0, "winding_time": 3e-3, "rotor_inertia": 0.9}
    plant = put(bench, hidden(bench, "servo_compliance:stepper", "q1", **given))
    resistance, inductance = 1 / 250.0, 3e-3 / 250.0
    field = 9e4 + S / (resistance + inductance * S) + 0.9 * S**2
    row = 1 / (1 / (K + B * S) + 1 / field)
    np.testing.assert_allclose(inertance(plant), S**2 / (row + S**2 * I), rtol=1e-8)


def test_a_stretched_exponential_has_its_transform():
    """For β = ½: s ∫ exp(−√(t/τ)) e^(−st) dt = 1 − √π x exp(x²) erfc(x), x = 1/(2 √(sτ))."""
    made = stretched(0.1, 5.0, 0.5)
    omega = 2 * np.pi * np.geomspace(1.0, 200.0, 60)
    x = 1 / (2 * np.sqrt(1j * omega / (2 * np.pi * 5.0)))
    kept = 1 - np.sqrt(np.pi) * x * np.exp(x**2) * erfc(x)
    size = made.strengths.sum()
    np.testing.assert_allclose(made.modulus(omega), 1 + size * kept, rtol=2e-3)
    every = made.modulus(2 * np.pi * np.geomspace(1e-3, 1e4, 2000))
    assert (every.imag / every.real).max() == pytest.approx(0.1, rel=1e-3)


def test_polymer_gears_are_as_stiff_as_the_card_in_the_middle_of_the_band(bench, hidden):
    given = {"loss_factor": 0.1, "viscous": 0.0, "exponent": 0.5, "frequency": 5.0}
    plant = put(bench, hidden(bench, "structural_damping:stretched", "joints", **given))
    low, high = bench.plan.band
    value = dynamic(plant, 2j * np.pi * np.sqrt(low * high))[0, 0]
    inertia = -plant.mass[0, 0] * (2 * np.pi) ** 2 * low * high
    assert value.real - inertia == pytest.approx(K, rel=1e-6)
    assert plant.damping[0, 0] == pytest.approx(0.0, abs=1e-9)


def test_a_ring_rubs_by_its_load(bars, stand, hidden):
    """Two postures of a bar about a level axis: all of its weight lies across that, whatever the posture."""
    bench = stand(bars(), references=["tip:+z"], postures=["flat", "raised"])
    given = {"torque": 5.0, "presliding_stiffness": 2e5, "diameter": 0.3, "load": 300.0, "seals": 0.2}
    spec = hidden(bench, "coulomb_friction:slewing", "q1", **given)
    carried = 2.2 * 1.73 * 4 * G / 300.0
    path, most = np.linspace(0, 3e-4, 600), 5.0 * (0.2 + 0.8 * carried)
    np.testing.assert_allclose(pulled(bench, spec, path), most * (1 - np.exp(-2e5 * path / most)), rtol=2e-3)


def test_a_ring_in_space_carries_weight_and_moment(stand):
    """Virtual work: the moment about every axis from the gradient of the height of the mass centre."""
    arm = six_axis(stand)
    assembly = PlantAssembly(arm.robot.at(dict(arm.plan.postures[0].q)))
    joints = [name for name in arm.robot.joints if not arm.robot.urdf.joint_by_name[name].is_prismatic]
    for name in joints[:3]:
        child = arm.robot.urdf.joint_by_name[name].child
        beyond = [n for n, row in assembly._maps.items() if np.any(row[:, assembly.coordinates.index(name)])]
        bodies = [(one, arm.true.bodies[one]) for one in beyond if one in arm.true.bodies]
        axis = assembly.orientation(child) @ np.array(arm.robot.urdf.joint_by_name[name].axis)
        mass = sum(body.mass for _, body in bodies)
        centre = sum(b.mass * (assembly.placed[n] @ [*b.com, 1.0])[:3] for n, b in bodies) / mass
        moment = np.cross(centre - assembly.origin(child), [0, 0, -mass * G])
        along, whole = axis[2] * mass * G, mass * G
        tipping = np.sqrt(moment @ moment - (moment @ axis) ** 2)
        wanted = 4.4 * tipping / 0.3 + abs(along) + 2.2 * 1.73 * np.sqrt(whole**2 - along**2)
        assert ring_load(assembly, arm, name, 0.3) == pytest.approx(wanted, rel=2e-3)


@pytest.mark.parametrize("angle", [0.0, 0.7])
def test_a_gear_is_wound_up_by_the_weight(angle, bench, hidden):
    """T(q₀ + u) − T(q₀) of the rig's own law; q₀ down, as far as cos of the arm's angle."""
    posture = replace(bench.plan.postures[0], q=FrozenDict({"q1": angle}))
    given = {"change": 0.6, "deflection": 2e-3, "wound": 1.5e-3, "load": 4 * G * 0.5}
    plant = build(bench, posture, [hidden(bench, "nonlinear_stiffness:under_weight", "q1", **given)])
    (element,) = plant.elements

    def torque(q):
        return 0.6 * K * q * (q / 2e-3) ** 2 / (1 + (q / 2e-3) ** 2)

    rest, path = -1.5e-3 * np.cos(angle), np.linspace(-4e-3, 4e-3, 101)
    pull, _ = LAWS[element.kind](np.array(element.parameters), path, path, path, path)
    np.testing.assert_allclose(pull, torque(rest + path) - torque(rest), rtol=5e-3, atol=1e-3)
    assert pull[50] == pytest.approx(0.0, abs=1e-9)


def test_the_loop_to_be_compiled_has_the_same_law():
    random = np.random.default_rng(5)
    p, (old, new, memory) = np.array([50.0, 0.03, -0.02]), random.uniform(-0.1, 0.1, (3, 50))
    torque, _ = LAWS[WOUND](p, old, new, np.zeros(50), memory)
    force, fresh = np.zeros((2, 50))
    kernel.act(WOUND, p, old, new, np.zeros(50), np.zeros(50), memory, fresh, force, 0.0)
    np.testing.assert_allclose(force, -torque, rtol=1e-12, atol=1e-12)


BUSH = {
    "radial_stiffness": 2e7, "axial_stiffness": 1e7, "long": 0.1, "washer": 0.04, "aside": 0.03,
    "loss_factor": 0.1,
}  # fmt: skip


def test_a_bush_is_an_even_bed_between_washers(stand, hidden):
    """Slices along the bush and sectors of two washers, each a spring; one loss factor for all of it."""
    arm = six_axis(stand)
    plant = put(arm, hidden(arm, "bearing_flexibility:bush", "q3", **BUSH))
    at = plant.coordinates.index("q3 bearing 1")
    wanted = np.zeros((5, 5))
    for z in 0.03 + 0.1 * ((np.arange(2000) + 0.5) / 2000 - 0.5):
        for row in ([1, 0, 0, 0, z], [0, 1, 0, -z, 0]):
            wanted += 2e7 / 2000 * np.outer(row, row)
    for angle in 2 * np.pi * np.arange(24) / 24:
        x, y = 0.04 * np.cos(angle), 0.04 * np.sin(angle)
        row = np.array([0, 0, 1, y, -x])  # how far the rim there goes along the axis
        wanted += 1e7 / 24 * np.outer(row, row)
    low, high = arm.plan.band
    for hertz in (1.5 * low, np.sqrt(low * high), 0.7 * high):
        s = 2j * np.pi * hertz
        found = (dynamic(plant, s) - plant.mass * s**2)[at : at + 5, at : at + 5]
        np.testing.assert_allclose(found / found[0, 0] * 2e7, wanted, atol=1e-5 * 2e7)
        assert found[0, 0].imag / found[0, 0].real == pytest.approx(0.1, rel=0.05)
    s = 2j * np.pi * np.sqrt(low * high)
    assert (dynamic(plant, s) - plant.mass * s**2)[at, at].real == pytest.approx(2e7, rel=1e-6)


def test_a_bush_in_a_plane_shifts_alone(bench, hidden):
    plant = put(bench, hidden(bench, "bearing_flexibility:bush", "q1", **BUSH))
    assert plant.dof == 3
    np.testing.assert_allclose(plant.stiffness[1:, 1:], plant.stiffness[1, 1] * np.eye(2), atol=1e-6)


def test_a_controller_crosses_two_joints(pair, hidden):
    """Each drive by the other's angle, behind a low-pass: written into K(s) by hand."""
    given = {"coupling": 0.3, "answer": 0.5, "filter_time": 4e-4}
    plant = put(pair, hidden(pair, "joint_coupling:cross_coupled", "q1+q2", **given))
    plain, frequency = put(pair), np.linspace(2, 100, 40)
    row = plant.row("link_2", np.array([1.0, 0, 0]), np.array([0, 0, 1.0]))
    found = plant.inertance(row[None], row[None], frequency)[:, 0, 0]
    for hertz, value in zip(frequency, found, strict=True):
        s = 2j * np.pi * hertz
        z = plain.mass * s**2 + plain.damping * s + plain.stiffness
        z = z + 0.3 * K / (1 + 4e-4 * s) * np.array([[0, 0.5], [1.0, 0]])
        assert value == pytest.approx(s**2 * row @ np.linalg.solve(z, row), rel=1e-9)
    still = plant.state_matrix
    assert np.all(np.linalg.eigvals(still).real < 0)


@pytest.mark.parametrize("point", ["middle", "tip"])
def test_a_transmitter_rides_beside_its_sensor(point, bench, hidden):
    at = {"middle": 0.5, "tip": 1.0}[point]
    given = {"mass": 0.1, "box_mass": 0.3, "apart": 0.15, "size": 0.06}
    spec = hidden(bench, "sensor_mass:transmitter", "sensor", **given)
    loaded = build(bench, bench.plan.postures[0], [spec], (point, sensors(bench, [spec])[point]))
    wanted = I + 0.1 * at**2 + 0.3 * ((at - 0.15) ** 2 + 0.06**2 / 6)
    assert loaded.mass[0, 0] == pytest.approx(wanted, rel=1e-9)


AXIS = {"ax": 0.0, "ay": -1.0, "az": 0.0}
OWN = {
    "sensor_gain:warm_up": ({"error": 0.3, "postures": 2.0}, "error", (0.3, 0.3 * np.exp(-0.5)), {}),
    "sensor_misalignment:knocked": ({"angle": 0.2, "when": 0.5, **AXIS}, "angle", (0.0, 0.2), AXIS),
}
"""What they are in each of two postures, as numbers of the rig's own forms."""


@pytest.mark.parametrize("key", OWN)
def test_some_things_are_others_in_each_posture(key, bars, stand, hidden):
    bench = stand(bars(), references=["tip:+z"], postures=["flat", "raised"], axes="xz")
    given, number, sizes, more = OWN[key]
    name, quiet = key.split(":")[0], Conduct(noise=0.0, scatter=0.0)
    for posture, size in zip(bench.plan.postures, sizes, strict=True):
        spec, same = hidden(bench, key, "tip", **given), hidden(bench, name, "tip", **{number: size}, **more)
        found, wanted = (h1(strike_posture(bench, posture, [one], quiet))[0] for one in (spec, same))
        np.testing.assert_allclose(found, wanted, rtol=1e-7, atol=1e-9 * np.abs(wanted).max())


def test_a_knock_falls_between_two_postures():
    assert [knocked_at(when, 5) for when in (0.0, 0.2, 0.5, 0.8, 1.0)] == [1, 1, 2, 4, 4]
    assert [knocked_at(0.7, count) for count in (1, 2, 3)] == [0, 1, 2]


def test_channels_in_a_row_are_each_later(bars, stand, hidden):
    """Of two axes each as the rig's own delay of its own; struck in time, and as told for the heights."""
    bench = stand(bars(damping=60.0), references=["tip:+z"], postures=["raised"], axes="xz")
    posture, quiet = bench.plan.postures[0], Conduct(noise=0.0, scatter=0.0)
    spec = hidden(bench, "time_delay:scanned", "tip", delay=3e-4, step=2e-4)
    found = h1(strike_posture(bench, posture, [spec], quiet))[0]
    floor = noise_floor(bench, Conduct(noise=0.01, scatter=0.0))
    told = predicted(bench, [spec], floor)
    for axis, delay in enumerate((3e-4, 5e-4)):
        same = hidden(bench, "time_delay", "tip", delay=delay)
        wanted = h1(strike_posture(bench, posture, [same], quiet))[0]
        off = np.abs(found - wanted)[:, :, :, axis]
        inside = slice(5, 190)
        assert off[..., inside].max() < 1e-3 * np.abs(wanted).max()
        other = predicted(bench, [same], floor)
        np.testing.assert_allclose(told[:, :, :, axis], other[:, :, :, axis], rtol=1e-9)


def test_numbers_that_are_varied_too_far_still_give_a_link_and_a_loss(stiff, hidden):
    plant = put(stiff, hidden(stiff, "link_flexibility:housings", "link_1", near=0.8, far=0.7))
    assert np.all(np.linalg.eigvalsh(plant.stiffness) > 0)
    assert np.all(np.isfinite(stretched(3.0, 5.0, 0.4).strengths))
