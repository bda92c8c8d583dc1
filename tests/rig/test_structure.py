"""The structure under the hammer, against closed forms and against Pinocchio."""

import numpy as np
import pytest
import scipy.linalg

import flexmodal
from flexmodal.rig.arms import draw_arm
from flexmodal.rig.believed import Body
from flexmodal.rig.effects.link_flexibility import spread
from flexmodal.rig.integration.exponential import exponential, polynomial
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.plant.beam import ELEMENTS, Beam, sections
from flexmodal.rig.plant.build import build
from flexmodal.rig.plant.chain import reach
from flexmodal.rig.plant.flexure import Hinges
from flexmodal.rig.plant.geometry import across

FIRST, SECOND = 1.875104068711961, 4.694091132974174  # roots of cos x cosh x = -1


def frequencies(plant) -> np.ndarray:
    """Undamped natural frequencies [Hz]."""
    return np.sqrt(scipy.linalg.eigh(plant.stiffness, plant.mass, eigvals_only=True)) / 2 / np.pi


@pytest.mark.parametrize("name", ["fanuc_s360", "six_link", "ur5"])
def test_nothing_hidden_is_the_model_pinocchio_gives(name, stand):
    given = {"stiffness": 2e4, "damping": 10.0} if name == "ur5" else {}
    robot = flexmodal.load(name, **given)
    bench = stand(robot, postures=3)
    for posture in bench.plan.postures:
        plant = build(bench, posture, [])
        posed = robot.at(dict(posture.q))
        system = posed.system
        # Two ways to sum the same bodies: rounding only.
        np.testing.assert_allclose(plant.mass, system.mass, rtol=0, atol=1e-12 * np.abs(system.mass).max())
        np.testing.assert_allclose(plant.stiffness, system.stiffness)
        np.testing.assert_allclose(plant.damping, system.damping)
        for link in ("link_3", "link_6", "wrist_1_link"):
            if link in {part.name for part in robot.urdf.links}:
                motion = plant.motion(link, np.zeros(3))
                np.testing.assert_allclose(motion, posed.jacobian(link), atol=1e-12)


def test_beam_alone_has_the_frequencies_of_a_cantilever():
    beam = Beam(1.3, 700.0, 2.5)
    exact = np.array([FIRST, SECOND]) ** 2 * np.sqrt(700.0 / (2.5 * 1.3**4))
    full = np.sqrt(scipy.linalg.eigh(beam.stiffness, beam.mass, eigvals_only=True))[:2]
    # Cubic elements converge as h⁴: (βh)⁴/720 is 5e-7 and 2e-4 for 8 elements.
    np.testing.assert_allclose(full, exact, rtol=3e-4)
    t = beam.condensation
    kept = np.sqrt(scipy.linalg.eigh(t.T @ beam.stiffness @ t, t.T @ beam.mass @ t, eigvals_only=True))[:2]
    np.testing.assert_allclose(kept, full, rtol=2e-3)  # what the inner modes left out cost


def test_beam_bends_under_a_tip_load_and_a_tip_moment():
    beam = Beam(0.8, 500.0, 1.0)
    load = np.eye(len(beam.condensed_stiffness))[0]
    deflection, slope = beam.shape(0.8)
    bent = np.linalg.solve(beam.condensed_stiffness, load)
    assert deflection @ bent == pytest.approx(0.8**3 / (3 * 500), rel=1e-9)
    assert slope @ bent == pytest.approx(0.8**2 / (2 * 500), rel=1e-9)
    middle, _ = beam.shape(0.4)
    assert middle @ bent == pytest.approx(5 * 0.8**3 / (48 * 500), rel=1e-9)


def test_sections_integrate_polynomials_of_the_shapes():
    places, weights = sections()
    assert len(places) == 4 * ELEMENTS
    assert weights @ places**6 == pytest.approx(1 / 7, rel=1e-13)


def test_stiff_link_that_could_bend_is_rigid(stand, hidden):
    robot = flexmodal.load("fanuc_s360")
    bench = stand(robot)
    posture = bench.plan.postures[0]
    rigid = frequencies(build(bench, posture, []))
    for link in ("link_1", "link_2", "link_2_outer", "link_3"):
        spec = hidden(bench, "link_flexibility", link, bending_stiffness=1e11)
        np.testing.assert_allclose(frequencies(build(bench, posture, [spec]))[:4], rigid, rtol=1e-4)


@pytest.mark.parametrize("name", ["fanuc_s360", "six_link", "ur5"])
def test_spreading_a_link_along_its_beam_keeps_its_inertia(name, stand):
    robot = flexmodal.load(name, **({"stiffness": 2e4} if name == "ur5" else {}))
    bench = stand(robot)
    for link, body in bench.true.bodies.items():
        end = reach(robot, link)
        length = float(np.linalg.norm(end))
        if length < 0.05:
            continue
        axis = end / length
        beam, rest = spread(body, length, axis)
        assert 0 <= beam <= body.mass
        assert beam + rest.mass == pytest.approx(body.mass)
        centre = (beam * length / 2 * axis + rest.mass * rest.com) / body.mass
        np.testing.assert_allclose(centre, body.com, atol=1e-9)
        thin = beam * length**2 / 12 * (np.eye(3) - np.outer(axis, axis))

        def about(mass, lever):
            return mass * (lever @ lever * np.eye(3) - np.outer(lever, lever))

        total = thin + about(beam, length / 2 * axis - body.com)
        total = total + rest.inertia + about(rest.mass, rest.com - body.com)
        np.testing.assert_allclose(total, body.inertia, atol=1e-9 * np.trace(body.inertia))
        second = np.trace(rest.inertia) / 2 * np.eye(3) - rest.inertia  # along, as no mass is negative
        assert beam == 0.0 or np.linalg.eigvalsh(second)[0] >= -1e-9 * np.trace(body.inertia)


def test_a_beam_in_a_plane_has_what_turns_in_that_plane_alone():
    """The card of a planar arm may have any other moments."""
    body = Body(3.0, np.array([0.5, 0.0, 0.0]), np.diag([1e-9, 1e-9, 3.0 / 12]))
    beam, rest = spread(body, 1.0, np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0]))
    assert beam == pytest.approx(3.0)
    assert rest.inertia[2, 2] == pytest.approx(0.0, abs=1e-12)
    assert spread(body, 1.0, np.array([1.0, 0.0, 0.0]))[0] < 0.1


def test_beam_on_a_locked_joint_is_a_cantilever(bars, stand, hidden):
    robot = bars(stiffness=1e12)
    bench = stand(robot)
    spec = hidden(bench, "link_flexibility", "link_1", bending_stiffness=3000.0)
    first = frequencies(build(bench, bench.plan.postures[0], [spec]))[0]
    assert first == pytest.approx(FIRST**2 * np.sqrt(3000.0 / 4.0) / 2 / np.pi, rel=1e-4)


def test_a_link_that_bends_carries_what_a_sliding_joint_has_pushed_out(tmp_path):
    """A hinge at its root moves everything beyond, wherever it slid to, as the joint at that root does."""
    robot = flexmodal.load(str(draw_arm(tmp_path / "arm", 11)))
    assert robot.urdf.joint_by_name["q3"].type == "prismatic"
    assert robot.urdf.joint_by_name["q3"].parent == "link_2"
    posed = PlantAssembly(robot.at({"q3": 0.2}))
    axis = np.asarray(robot.urdf.joint_by_name["q2"].axis)
    along = np.array([1.0, 0.0, 0.0])
    hinge = Hinges(0.4, (0.0,), (1e5,))
    posed.add_flexure("link_2", hinge, along, np.cross(axis, along), 0.0)
    for link in ("link_3", "link_6"):
        motion = posed.motion(link, np.array([0.1, 0.0, 0.05]))
        joint, bend = posed.coordinates.index("q2"), posed.coordinates.index("link_2 bending 1.1")
        np.testing.assert_allclose(motion[:, bend], motion[:, joint], atol=1e-12)


def test_exponentials_of_stiff_links_do_not_grow():
    """Springs of 10² to 10¹⁴ N/m on 0.2 g to a tonne: exp(A t) has the eigenvalues e^(λ t), none beyond 1."""
    random = np.random.default_rng(1)
    turn = np.linalg.qr(random.normal(size=(6, 6)))[0]
    mass = np.diag(np.geomspace(2e-4, 1e3, 6)[::-1])
    root = np.sqrt(mass)
    square = np.geomspace(1e2, 1e17, 6)  # of the natural frequencies; damping is proportional
    stiffness = root @ turn @ np.diag(square) @ turn.T @ root
    a = np.zeros((12, 12))
    a[:6, 6:] = np.eye(6)
    a[6:] = -np.linalg.solve(mass, np.hstack([stiffness, 1e-5 * stiffness + 2.0 * mass]))
    step = 6e-5
    found = np.sort(np.abs(np.linalg.eigvals(exponential(a * step))))
    loss = 1e-5 * square + 2.0
    far = -(loss + np.sqrt((loss**2 - 4 * square).astype(complex))) / 2
    expected = np.sort(np.abs(np.exp(np.concatenate([far, square / far]) * step)))  # Vieta's, no digit lost
    assert expected[-1] < 1
    np.testing.assert_allclose(found[-2:], expected[-2:], rtol=1e-7)
    assert found.max() < 1


def test_exponentials_agree_with_scipy():
    random = np.random.default_rng(0)
    stack = random.standard_normal((5, 7, 7)) * np.array([1e-3, 1.0, 4.0, 10.0, 30.0])[:, None, None]
    for one, other in zip(exponential(stack), scipy.linalg.expm(stack), strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-9 * np.abs(other).max())


def test_polynomial_of_a_matrix():
    random = np.random.default_rng(0)
    a, weights = random.standard_normal((4, 4)) / 4, random.standard_normal(23)
    direct = sum(w * np.linalg.matrix_power(a, k) for k, w in enumerate(weights))
    np.testing.assert_allclose(polynomial(weights, a), direct, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("noise", [(0.0, 0.0), (4e-17, -3e-18), (-3e-18, 4e-17)])
def test_directions_across_an_axis_do_not_hang_on_its_last_digits(noise):
    """An axis that is turned by a posture and back again: what sits across it is fixed to its link."""
    first, second = across(np.array([1.0, *noise]), None)
    np.testing.assert_allclose([first, second], [(0, 0, 1), (0, -1, 0)], atol=1e-15)
