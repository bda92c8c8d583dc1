"""Functions of every blow beside functions that no blow changes."""

from dataclasses import replace

import numpy as np
import pytest

from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.lawfree.at_parameters import AtParameters
from flexmodal.diagnosis.lawfree.elimination import solved
from flexmodal.diagnosis.lawfree.joint_ports import COUPLING, JOINT, TORQUE
from flexmodal.diagnosis.lawfree.look import Field
from flexmodal.diagnosis.lawfree.model import PortedModel
from flexmodal.diagnosis.lawfree.port import Port
from flexmodal.diagnosis.lawfree.ported_fit import profiled
from flexmodal.diagnosis.lawfree.profile import Profile
from flexmodal.diagnosis.lawfree.reading_ports import SENSOR
from flexmodal.structure import robot_space


@pytest.fixture(scope="module")
def root(context):
    return Hypothesis(context, robot_space(context.robot))


def ported(root, observed, *places):
    ports = [Port.at(kind, where or kind.places(root.context)[0], root.context) for kind, where in places]
    return PortedModel.of(ports, root, observed, np.arange(20, len(observed.axis), 41))


def dense(matrix, right, common):
    """One system of all cells' own functions and the common ones."""
    cells, lines, functions = matrix.shape[:3]
    own = np.flatnonzero(~common)
    count = cells * len(own) + common.sum()
    place = np.empty((cells, functions), dtype=int)
    place[:, own] = np.arange(cells * len(own)).reshape(cells, len(own))
    place[:, common] = cells * len(own) + np.arange(common.sum())
    found = np.empty(right.shape, dtype=complex)
    for line in range(lines):
        whole, sides = (
            np.zeros((count, count), dtype=complex),
            np.zeros((count, right.shape[3]), dtype=complex),
        )
        for cell in range(cells):
            whole[np.ix_(place[cell], place[cell])] += matrix[cell, line]
            sides[place[cell]] += right[cell, line]
        found[:, line] = np.linalg.solve(whole, sides)[place]
    return found


@pytest.mark.parametrize("common", [(1, 0, 1), (0, 0, 0), (1, 1, 1), (0, 1, 0)])
def test_the_arrow_is_solved_as_one_system_is(common):
    random = np.random.default_rng(2)
    root = random.normal(size=(4, 5, 6, 3)) + 1j * random.normal(size=(4, 5, 6, 3))
    matrix = np.conj(np.swapaxes(root, 2, 3)) @ root
    right = random.normal(size=(4, 5, 3, 2)) + 1j * random.normal(size=(4, 5, 3, 2))
    common = np.array(common, dtype=bool)
    np.testing.assert_allclose(solved(matrix, right, common), dense(matrix, right, common), rtol=1e-9)


def test_only_what_a_blow_changes_has_a_function_of_every_blow(root, observed):
    alone = ported(root, observed, (SENSOR, None), (JOINT, "q3"))
    assert not alone.common.any()
    model = ported(root, observed, (SENSOR, None), (TORQUE, "q2"), (COUPLING, "q1+q3"))
    assert model.common.tolist() == [True, False, True, True, True]
    unknown = 2 * len(model.lines) * (model.cells + 4) + len(model.space)
    profile = Profile(model, 0.05)
    nothing = np.ones((len(model.observations), len(model.lines)), dtype=complex)
    values = 2 * np.count_nonzero(profile.weight)
    assert profile.reduced(nothing) == pytest.approx(profile.mean(nothing) * values / (values - unknown))


def with_functions(model, observed):
    """The same model of FRFs that have known functions in them, and these."""
    smooth = 0.15 / (1 + 1j * observed.axis.frequency[model.lines] / 60)
    z = model.zero() + smooth
    torque = ~model.common
    z[:, torque] *= np.linspace(-1.0, 1.5, model.cells)[:, None, None]
    value = observed.value.copy()
    value[:, model.lines] *= np.exp(AtParameters(model, np.zeros(len(model.space))).residual(z))
    return replace(model, observations=replace(observed, value=value, used=np.ones_like(observed.used))), z


def test_both_kinds_come_out_again(root, observed):
    """A reading and a joint are found beside a torque of every blow, alike in all of them."""
    model = ported(root, observed, (TORQUE, "q2"), (SENSOR, None), (JOINT, "q3"))
    clean, z = with_functions(model, observed)
    _, state = profiled(clean, floors=(0.2, 0.05, 0.01, 1e-4), steps=30)
    assert np.abs(state.residual).max() < 1e-3
    shared = state.z[:, model.common]
    assert np.ptp(shared.real, axis=0).max() == np.ptp(shared.imag, axis=0).max() == 0.0
    assert np.median(np.abs(state.z - z)) < 0.02 * np.abs(z).max()


def test_a_wrong_place_does_not_follow_every_blow(root, observed):
    """Beside a torque that is there, a joint takes what it takes in all postures or nothing."""
    clean, _ = with_functions(ported(root, observed, (TORQUE, "q2"), (JOINT, "q3")), observed)
    seen, misfit = clean.observations, {}
    for name in ("q1", "q3"):
        model = ported(root, seen, (TORQUE, "q2"), (JOINT, name))
        profile, state = profiled(model, steps=20)
        misfit[name] = profile.reduced(state.residual)
    assert misfit["q1"] > 10 * misfit["q3"]


@pytest.mark.parametrize(("torques", "enough"), [((), True), (("q2",), True), (("q2", "q3"), False)])
def test_a_third_of_what_was_read_of_a_blow_is_left_to_judge(root, observed, torques, enough):
    """Of three responses two torques leave one; a third torque is not tried."""
    assert set(np.bincount(ported(root, observed, (TORQUE, "q2")).cell)) == {3}
    field = Field.of(root, np.zeros(len(root.space)), observed, None, by_force=True, kinds=[JOINT])
    before, tried = None, [one for one in field.torques if one.where == "q1"]
    for name in torques:
        torque = next(one for one in field.torques if one.where == name)
        before = field.sighted((torque,), before, roughly=True)
    assert bool(field.round(before, tried).sightings) is enough
