"""Python as the field writes it: postures as arrays, directions as texts, labelled arrays, plots."""

import numpy as np
import pinocchio as pin
import pytest

import flexmodal
from flexmodal.errors import InvalidPosture, MissingExtra
from flexmodal.text import extras

from .writing import mixed


def test_an_array_in_pinocchios_order_is_the_posture_of_those_names():
    robot = flexmodal.load("six_axis")
    q = np.array([0.1, -0.2, 0.3, -0.4, 0.5, -0.6])
    by_name = robot.at(dict(zip(robot.commanded, q.tolist(), strict=True)))
    for given in (q, q.tolist(), tuple(q)):
        assert robot.at(given).posture == by_name.posture
    data = robot.pinocchio.createData()
    pin.framesForwardKinematics(robot.pinocchio, data, q)
    truth = data.oMf[robot.frame_of("tool")].translation
    assert robot.at(q).position("tool") == pytest.approx(truth, abs=1e-15)


def test_a_configuration_with_a_continuous_joint(tmp_path):
    robot = flexmodal.load(mixed(tmp_path / "m.urdf"), stiffness=1e4)
    model = robot.pinocchio
    assert model.nq > model.nv
    values = np.array([0.3, 0.2, -0.5, 0.4])
    assert len(values) == model.nv
    q = pin.integrate(model, pin.neutral(model), values)
    assert robot.at(q).position("tool") == pytest.approx(robot.at(values).position("tool"), abs=1e-14)


def test_pseudo_joints_may_be_left_out_or_zero():
    robot = flexmodal.load("fanuc_s360")
    assert robot.posture([1.0, 0.2, 0.1]) == robot.posture([1.0, 0.2, 0.0, 0.1])
    with pytest.raises(InvalidPosture, match="pseudo-joint rho"):
        robot.posture([1.0, 0.2, 0.3, 0.1])


@pytest.mark.parametrize("bad", [[1.0, 2.0], np.zeros((6, 1)), [1.0] * 7, ["a"] * 6])
def test_arrays_that_are_no_posture(bad):
    with pytest.raises(InvalidPosture, match="6 values, of q1, q2"):
        flexmodal.load("six_axis").posture(np.array(bad))


def test_limits_hold_for_arrays():
    with pytest.raises(InvalidPosture, match="the joint's limits"):
        flexmodal.load("six_axis").at([0, 0, 0, 0, 99.0, 0])


@pytest.mark.parametrize("axis", ["+z", "-x", "ry", "-rz"])
def test_a_direction_in_two_words(axis):
    assert flexmodal.PointDirection("tool", axis) == flexmodal.PointDirection.parse(f"tool:{axis}")


def _receptance(direction):
    return flexmodal.ReceptanceObjective((direction,), np.array([5.0]))


def test_objectives_take_texts():
    robot, direction = flexmodal.load("six_link"), flexmodal.PointDirection("tool", "+z")
    posed = robot.at("start_1")
    pairs = [
        (flexmodal.ReceptanceObjective("tool:+z", 5.0), _receptance(direction)),
        (flexmodal.StiffnessObjective("tool:+z"), flexmodal.StiffnessObjective(direction)),
        (flexmodal.MobilityObjective("tool:+z"), flexmodal.MobilityObjective(direction)),
    ]  # fmt: skip
    for one, other in pairs:
        assert one.value(posed) == other.value(posed)


def test_what_is_shown_is_short():
    robot = flexmodal.load("six_axis")
    posed = robot.at("work")
    shown = [
        robot, posed, posed.posture, posed.system, posed.modes(), posed.frf([1.0, 2.0]), posed.to_ss(),
        flexmodal.PostureProblem(robot, flexmodal.StiffnessObjective("tool:+z")),
        flexmodal.read_campaign(_thesis()), flexmodal.tune(posed, (5.0, 30.0)),
    ]  # fmt: skip
    for one in shown:
        assert 10 < len(repr(one)) < 400
        assert "\n" not in repr(one)
    assert "<table>" in robot._repr_html_()
    assert repr(flexmodal.PointDirection("tool", "-z")) == "PointDirection('tool:-z')"


def _thesis():
    from flexmodal.files import catalogue_folder

    return catalogue_folder() / "robots" / "fanuc_s360" / "campaigns" / "thesis"


def test_labels_of_arrays_find_the_numbers():
    posed = flexmodal.load("six_axis").at("work")
    found = posed.frf([5.0, 10.0, 20.0], response=["tool:+x", "tool:+z"])
    array = found.to_xarray()
    wanted = found.between("tool:+x", "tool:+z")
    assert np.array_equal(array.sel(response="tool:+x", reference="tool:+z").values, wanted)
    assert complex(array.sel(response="tool:+x", reference="tool:+z", frequency=10.0)) == wanted[1]
    assert np.array_equal(found.to_pandas()["tool:+x", "tool:+z"].to_numpy(), wanted)
    modes = posed.modes()
    assert np.array_equal(modes.to_pandas()["frequency"], modes.frequency)
    assert np.array_equal(modes.to_xarray()["shape"].sel(coordinate="q2").values, modes.shape[1])
    table = flexmodal.read_campaign(_thesis()).modes
    assert table is not None
    assert len(table.to_pandas()) == len(table)


def test_a_package_that_is_not_installed_is_named_with_its_extra(monkeypatch):
    def missing(name):
        raise ImportError(name)

    monkeypatch.setattr(extras, "import_module", missing)
    with pytest.raises(MissingExtra, match=r"to_xarray needs xarray: pip install 'flexmodal\[xarray\]'"):
        flexmodal.load("six_axis").at("work").frf([1.0]).to_xarray()


def test_results_draw_themselves():
    posed = flexmodal.load("six_link").at("start_1")
    assert len(posed.frf([1.0, 2.0, 3.0]).plot().axes) == 2
    assert posed.plot().axes[0].get_xlabel() == "x [m]"
    with pytest.raises(TypeError, match="no picture of a Modes"):
        posed.modes().plot()
