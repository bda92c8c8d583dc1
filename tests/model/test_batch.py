"""Many postures at once: against Pinocchio, and against a model on paper stepped along the imaginary axis."""

import importlib.util
import logging
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import flexmodal
from flexmodal.errors import InvalidInput, InvalidRequest, MissingExtra
from flexmodal.model.batch import gradient_batch, position_batch, posture_array, receptance_batch
from flexmodal.model.batch.chain import chain_of, places_of
from flexmodal.model.batch.compiled import pose_kernel
from flexmodal.model.sensitivity import sensitivity

_SPEC = importlib.util.spec_from_file_location("batch_chains", Path(__file__).with_name("batch_chains.py"))
chains = importlib.util.module_from_spec(_SPEC)
_SPEC.loader.exec_module(chains)

STEP = 1e-30


def random_postures(robot, rng, count):
    lower = np.array([max(joint.lower, -3.0) for joint in robot.commanded.values()])
    upper = np.array([min(joint.upper, 3.0) for joint in robot.commanded.values()])
    return rng.uniform(lower, upper, (count, len(lower)))


@pytest.fixture(scope="module")
def spatial(tmp_path_factory):
    links = chains.random_links(np.random.default_rng(3), 5, slides=(2,))
    return links, chains.load(links, tmp_path_factory.mktemp("spatial") / "chain.urdf")


@pytest.fixture(scope="module")
def long(tmp_path_factory):
    links = chains.random_links(np.random.default_rng(4), 14, planar=True, slides=(5,))
    return links, chains.load(links, tmp_path_factory.mktemp("long") / "chain.urdf")


@pytest.mark.parametrize("name", ["six_link", "fanuc_s360", "spatial", "long"])
def test_kinematics_agree_with_pinocchio(name, request):
    robot = request.getfixturevalue(name)[1] if name in ("spatial", "long") else flexmodal.load(name)
    model, data = robot.pinocchio, robot.pinocchio.createData()
    points = [robot.tool, *robot.points][:2]
    places = places_of(robot, tuple((point, row) for point in points for row in np.eye(6)))
    postures = np.random.default_rng(0).uniform(-3, 3, (20, model.nv))
    masses = np.empty((20, model.nv, model.nv))
    rows = np.empty((20, 6 * len(points), model.nv))
    pose_kernel().compiled(
        chain_of(robot).arrays, places.joint, places.offset, places.selector, np.arange(model.nv), postures,
        masses, rows,
    )  # fmt: skip
    for posture, mass, jacobian in zip(postures, masses, rows, strict=True):
        at = pin.integrate(model, pin.neutral(model), posture)
        expected = pin.crba(model, data, at)
        scale = np.sqrt(np.diag(expected))
        np.testing.assert_allclose(
            mass / np.outer(scale, scale), expected / np.outer(scale, scale), rtol=0, atol=1e-12
        )
        pin.computeJointJacobians(model, data, at)
        pin.updateFramePlacements(model, data)
        for place, point in enumerate(points):
            frame = robot.frame_of(point)
            expected = pin.getFrameJacobian(model, data, frame, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
            np.testing.assert_allclose(jacobian[6 * place : 6 * place + 6], expected, atol=1e-12)


PAIRS = ["tool:+z", ("link_3:+x", "tool:+ry")]
"""A drive point, and one that turns; few rows, for compilation takes the longer the more there are."""


@pytest.mark.parametrize("way", ["numpy", "compiled", "compiled any n", "recursion"])
@pytest.mark.parametrize("loss", [0.0, 0.05])
def test_every_way_gives_the_answer_of_one_at_a_time(way, loss):
    robot = flexmodal.load("six_link")
    postures = random_postures(robot, np.random.default_rng(1), 5)
    frequency = np.linspace(0, 40, 37)
    found = receptance_batch(robot, postures, PAIRS, frequency, loss_factor=loss, way=way, threads=1)
    assert found.route.way == way
    for posture, value in zip(postures, found.value, strict=True):
        system = robot.at(dict(zip(robot.commanded, map(float, posture), strict=True)))
        for place, (response, reference) in enumerate(found.pairs):
            rows = system.rows([response, reference])
            omega = 2 * np.pi * frequency[:, None, None]
            Z = (1 + 1j * loss) * robot.stiffness - omega**2 * system.system.mass + 1j * omega * robot.damping
            expected = np.linalg.solve(Z, rows[1].astype(complex)[None, :, None])[..., 0] @ rows[0]
            atol = 1e-12 * np.max(np.abs(expected))
            np.testing.assert_allclose(value[:, place], expected, rtol=1e-10, atol=atol)


@pytest.mark.parametrize("kind", ["spatial", "long"])
def test_receptance_on_paper(kind, request):
    links, robot = request.getfixturevalue(kind)
    q = np.random.default_rng(2).uniform(-1, 1, (2, len(links)))
    tip = f"l{len(links) - 1}"
    for way in ("LAPACK", "compiled any n", "recursion"):
        found = receptance_batch(robot, q, [(f"{tip}:+x", f"{tip}:+rz")], [0.0, 3.0, 20.0], way=way).value
        for posture, value in zip(q, found, strict=True):
            for line, f in enumerate((0.0, 3.0, 20.0)):
                re, im = chains.on_paper(links, posture, np.eye(6)[[0, 5]], 2 * np.pi * f)
                assert value[line, 0] == pytest.approx(complex(re.real, im.real), rel=1e-10), way


@pytest.mark.parametrize("way", ["numpy", "compiled"])
def test_gradients_against_the_complex_step(spatial, way):
    links, robot = spatial
    q = np.random.default_rng(5).uniform(-1, 1, (3, 5))
    pairs = ["l4:+x", ("l4:+y", "l4:+rz"), ("l4:-rx", "l4:+z")]
    picks = [(np.eye(6)[0],) * 2, (np.eye(6)[1], np.eye(6)[5]), (-np.eye(6)[3], np.eye(6)[2])]
    found = gradient_batch(robot, q, pairs, [0.0, 7.0], way=way)
    assert found.route.way == way
    for posture in range(3):
        for line, f in enumerate((0.0, 7.0)):
            for place, selectors in enumerate(picks):
                expected = []
                for k in range(5):
                    stepped = q[posture] + STEP * 1j * np.eye(5)[k]
                    re, im = chains.on_paper(links, stepped, selectors, 2 * np.pi * f)
                    expected.append(complex(re.imag, im.imag) / STEP)
                slope = found.slope[posture, line, place]
                # Both are exact; what is left is rounding through Z, of condition 1e2.
                np.testing.assert_allclose(slope, expected, rtol=0, atol=1e-12 * np.max(np.abs(expected)))


def test_sensitivities_against_the_complex_step(spatial):
    links, robot = spatial
    q = np.random.default_rng(6).uniform(-1, 1, 5)
    posed = robot.at({f"j{i}": float(value) for i, value in enumerate(q)})
    f, selectors = 6.0, np.eye(6)[[1, 5]]
    omega = 2 * np.pi * f
    found = sensitivity(posed, "l4:+y", "l4:+rz", np.array([f]))

    def step(w=omega, **changes):
        re, im = chains.on_paper(links, q, selectors, w, **changes)
        return complex(re.imag, im.imag) / STEP

    def close(value, expected):
        np.testing.assert_allclose(value, expected, rtol=0, atol=1e-12 * np.max(np.abs(expected)))

    close(found.value[0], complex(*(part.real for part in chains.on_paper(links, q, selectors, omega))))
    close(found.frequency[0], step(w=omega + 2 * np.pi * STEP * 1j))
    unit = np.eye(25).reshape(5, 5, 5, 5)
    close(found.stiffness[0], [[step(stiffness=STEP * 1j * unit[i, j]) for j in range(5)] for i in range(5)])
    close(found.damping[0], [[step(damping=STEP * 1j * unit[i, j]) for j in range(5)] for i in range(5)])
    close(found.mass[0], [step(extra_mass={i: STEP * 1j}) for i in range(5)])
    close(
        found.place[0],
        [[step(moved={i: STEP * 1j * np.eye(3)[a]}) for a in range(3)] for i in range(5)],
    )


def test_threads_do_not_change_a_bit():
    robot = flexmodal.load("six_link")
    postures = random_postures(robot, np.random.default_rng(7), 300)
    runs = [
        receptance_batch(robot, postures, PAIRS, np.linspace(0, 30, 200), way="compiled", threads=threads)
        for threads in (1, 2)
    ]
    assert [run.route.threads for run in runs] == [1, 2]
    assert np.array_equal(runs[0].value, runs[1].value)
    slopes = [gradient_batch(robot, postures, PAIRS, [3.0], way="compiled", threads=t).slope for t in (1, 2)]
    assert np.array_equal(slopes[0], slopes[1])


def test_an_addition_that_depends_on_the_frequency():
    robot = flexmodal.load("six_link")
    frequency = np.array([1.0, 5.0, 9.0])
    addition = np.zeros((3, 6, 6), dtype=complex)
    addition[:, 2, 2] = 1e4 * np.array([1.0, 2.0, 4.0]) * (1 + 0.3j)
    softer = receptance_batch(robot, ["start_1"], ["tool:+z"], frequency, addition=addition)
    system = robot.at("start_1").system
    row = robot.at("start_1").rows(robot.at("start_1").directions("tool:+z"))[0]
    for line, f in enumerate(frequency):
        w = 2 * np.pi * f
        Z = system.stiffness - w**2 * system.mass + 1j * w * system.damping + addition[line]
        assert softer.value[0, line, 0] == pytest.approx(row @ np.linalg.solve(Z, row), rel=1e-12)


def test_names_mappings_and_arrays_are_the_same():
    robot = flexmodal.load("six_link")
    array = posture_array(robot, ["start_1", dict(robot.postures["start_2"])])
    assert np.array_equal(posture_array(robot, array), array)
    assert array[0].tolist() == [robot.postures["start_1"].get(name, 0.0) for name in robot.commanded]


def test_the_choice_is_logged(caplog):
    robot = flexmodal.load("six_link")
    with caplog.at_level(logging.INFO, logger="flexmodal.engine"):
        receptance_batch(robot, ["start_1"], ["tool:+z"], [1.0], explain=True)
    assert caplog.messages == ["LAPACK on 1 thread: few points (1); kinematics by Pinocchio"]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"postures": []}, "postures: found none"),
        ({"postures": np.full((2, 6), np.nan)}, "posture 0: posture: q1: found nan"),
        ({"postures": np.full((2, 6), 99.0)}, "the joint's limits"),
        ({"postures": np.zeros((2, 5))}, r"shape \(2, 5\)"),
        ({"postures": np.zeros((0, 6))}, r"shape \(0, 6\)"),
        ({"pairs": []}, "pairs: found none"),
        ({"pairs": ["nowhere:+z"]}, "'nowhere'"),
        ({"frequencies": [2.0, 1.0]}, "2 Hz followed by 1 Hz"),
        ({"frequencies": [np.nan]}, "nan Hz"),
        ({"threads": 0}, "threads: found 0"),
        ({"loss_factor": -0.1}, "loss_factor: found -0.1"),
        ({"loss_factor": float("nan")}, "loss_factor: found nan"),
        ({"addition": np.zeros((1, 5, 5), dtype=complex)}, "addition: found shape"),
        ({"addition": np.full((1, 6, 6), np.inf + 0j)}, "not finite"),
        ({"addition": np.triu(np.ones((1, 6, 6), dtype=complex))}, "not symmetric"),
        ({"way": "fastest"}, "way: found 'fastest'"),
    ],
)
def test_bad_requests_say_what_is_wrong(change, words):
    given = {"postures": ["start_1"], "pairs": ["tool:+z"], "frequencies": [1.0], **change}
    robot = flexmodal.load("six_link")
    with pytest.raises(InvalidInput, match=words):
        receptance_batch(robot, given.pop("postures"), given.pop("pairs"), given.pop("frequencies"), **given)


@pytest.mark.parametrize("change", [{"threads": 0}, {"way": "fastest"}, {"pairs": []}, {"postures": []}])
def test_bad_requests_for_gradients(change):
    given = {"postures": ["start_1"], "pairs": ["tool:+z"], "frequencies": [1.0], **change}
    robot = flexmodal.load("six_link")
    with pytest.raises(InvalidInput):
        gradient_batch(robot, given.pop("postures"), given.pop("pairs"), given.pop("frequencies"), **given)


@pytest.mark.parametrize("function", [receptance_batch, gradient_batch])
def test_bad_threads_and_ways_are_named_together(function):
    for threads in (0, True):
        with pytest.raises(InvalidRequest) as caught:
            function(flexmodal.load("six_link"), ["start_1"], ["tool:+z"], [5.0], threads=threads, way="fast")
        assert sorted(fault.key for fault in caught.value.faults) == ["threads", "way"]


@pytest.mark.parametrize("function", [receptance_batch, gradient_batch])
def test_without_numba(function, monkeypatch):
    for module in ("model.batch.receptances", "model.batch.gradients", "frf.kernels.route"):
        monkeypatch.setattr(f"flexmodal.{module}.has_numba", lambda: False)
    robot = flexmodal.load("six_link")
    with pytest.raises(MissingExtra, match="numba"):
        function(robot, ["start_1"], ["tool:+z"], [1.0], way="compiled")
    assert function(robot, ["start_1"] * 3, ["tool:+z"], np.linspace(1, 2, 500)).route.way == "numpy"


def test_an_arm_of_one_joint(tmp_path):
    """Pinocchio gives a single column of a Jacobian as a flat array."""
    (tmp_path / "one.urdf").write_text(
        '<robot name="one"><link name="base"/><link name="arm"><inertial><origin xyz="0.5 0 0"/>'
        '<mass value="2"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>'
        '<link name="tip"/><joint name="q1" type="revolute"><parent link="base"/><child link="arm"/>'
        '<axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
        '<joint name="end" type="fixed"><parent link="arm"/><child link="tip"/><origin xyz="1 0 0"/></joint>'
        "</robot>"
    )
    arm = flexmodal.load(tmp_path / "one.urdf", stiffness=100.0, damping=1.0, tool="tip")
    found = receptance_batch(arm, np.array([[0.3], [-0.2]]), ["tip:+y"], [1.0, 2.0], way="compiled").value
    one = arm.frf({"q1": 0.3}, [1.0, 2.0], response="tip:+y").value[:, 0, 0]
    np.testing.assert_allclose(found[0, :, 0], one, rtol=1e-12)


def test_positions_are_those_of_each_posture(tmp_path):
    for name, named in (("six_axis", ""), ("six_link", "tip"), ("fanuc_s360", "")):
        arm = flexmodal.load(name)
        low = np.maximum([joint.lower for joint in arm.commanded.values()], -1.0)
        high = np.minimum([joint.upper for joint in arm.commanded.values()], 1.0)
        values = np.random.default_rng(0).uniform(low, high, (5, len(low)))
        point = named or arm.tool
        for vector, found in zip(values, position_batch(arm, values, point), strict=True):
            posed = arm.at(dict(zip(arm.commanded, map(float, vector), strict=True)))
            np.testing.assert_allclose(found, posed.position(point), atol=1e-12)
