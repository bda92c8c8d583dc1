"""What a look without a law takes measurements for: those of a linear robot, struck in one way."""

from dataclasses import replace
from unittest.mock import Mock

import numpy as np
import pytest

import flexmodal
from flexmodal.diagnosis.effects import Context, catalogue
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.lawfree.first_look import LooksWithoutLaw
from flexmodal.diagnosis.lawfree.kinds import SENSOR, TORQUE
from flexmodal.diagnosis.lawfree.look import Field
from flexmodal.diagnosis.lawfree.records import endless, of_first_blow
from flexmodal.diagnosis.lawfree.screening import TORQUES
from flexmodal.diagnosis.placed import Placed
from flexmodal.diagnosis.selection.frf_comparison import FittedFrfs
from flexmodal.diagnosis.setup import Setup
from flexmodal.diagnosis.time_domain.model import TimeDomainModel
from flexmodal.diagnosis.time_domain.straightened import straightened
from flexmodal.errors import SingularResponse
from flexmodal.identification import predict
from flexmodal.structure import robot_space

pytestmark = pytest.mark.usefixtures("one_loop")
SPRING = {"change": -0.5, "deflection": 2e-4}


@pytest.fixture(scope="module")
def struck(softly_struck):
    """A robot with a spring that softens: its hypothesis, coordinates, and what is measured without noise."""
    seen = softly_struck
    context = Context.of(flexmodal.load("fanuc_s360"), seen)
    root = Hypothesis(context, robot_space(context.robot))
    bent = root.and_also(Placed(catalogue()["nonlinear_stiffness"], "q2"))
    x = bent.start(bent.placed[-1], SPRING, np.zeros(len(root.space)))
    return bent, x, replace(seen, value=predict(TimeDomainModel(bent), x, seen))


def test_what_torques_do_beyond_their_stand_ins_is_taken_out(struck):
    """A sensor that reads too much besides stays in the measurement as it was."""
    bent, x, seen = struck
    linear = predict(bent, x, seen)
    assert np.abs(np.log(seen.value / linear)).max() > 0.2
    louder = replace(seen, value=1.3 * seen.value)
    found = straightened(louder, bent, x, seen.value)
    np.testing.assert_allclose(found.value, 1.3 * linear, rtol=1e-9)


def test_where_there_is_nothing_nothing_is_taken_out(struck):
    bent, x, seen = struck
    nowhere = np.where(np.arange(seen.value.shape[1]) == 3, 0.0, seen.value)
    found = straightened(seen, bent, x, nowhere)
    assert np.isfinite(found.value).all()
    np.testing.assert_array_equal(found.value[:, 3], seen.value[:, 3])


def test_blows_of_other_force_become_those_of_the_first(struck):
    bent, x, seen = struck
    linear = replace(seen, value=predict(bent, x, seen))
    assert np.ptp(np.abs(linear.value[seen.level == 0] / linear.value[seen.level == 1])) > 0.05
    found = of_first_blow(linear, bent, x)
    np.testing.assert_allclose(found.value[seen.level == 1], found.value[seen.level == 0], rtol=1e-9)
    np.testing.assert_allclose(found.value[seen.level == 0], linear.value[seen.level == 0], rtol=1e-12)


def test_what_rings_up_says_nothing_of_a_measurement(monkeypatch, struck):
    """Neither of what a record cuts off nor of other blows: the measurement stays as it is."""
    bent, x, seen = struck

    def rings_up(model, x, observations):
        raise SingularResponse("it rings up")

    monkeypatch.setattr("flexmodal.diagnosis.lawfree.records.predict", rings_up)
    cut_off = replace(seen, lengths=(2.0,) * len(seen.lengths), endless=False)
    assert endless(cut_off, bent, x) is cut_off
    assert of_first_blow(seen, bent, x) is seen


@pytest.mark.slow
def test_beside_a_torque_a_look_finds_what_is_missing_besides(struck):
    """Not the torque itself, which its stand-in stands for badly."""
    bent, x, seen = struck
    places = SENSOR.places(bent.context)
    wrong = np.array([bent.context.point(p).name == places[0] for p in seen.response[:, 0].tolist()])
    louder = replace(seen, value=np.where(wrong[:, None], 1.3, 1.0) * seen.value)
    kinds = (SENSOR, TORQUE)
    raw = Field.of(bent, x, louder, None, kinds=kinds).round()
    clean = Field.of(bent, x, straightened(louder, bent, x, seen.value), None, kinds=kinds).round()
    assert clean.best.port.key == ("sensor", places[0])
    assert clean.best.judged < 0.2 * raw.best.judged


def test_what_the_torques_that_are_there_explain_does_not_depend_on_force(struck):
    bent, x, seen = struck
    held = np.zeros(len(seen), dtype=bool)
    root = Hypothesis(bent.context, bent.base)

    def asked(observations, hypothesis, at, predicted):
        model = Mock(spec=FittedFrfs, hypothesis=hypothesis, x=at, predicted=predicted)
        setup = Mock(spec=Setup, observations=observations, held=held)
        return [LooksWithoutLaw(setup, model, by, Mock()).depends_on_force for by in (True, False)]

    assert asked(seen, bent, x, seen.value) == [False, False]
    hard = np.exp(1j * 0.5 * (seen.level == 1))[:, None]  # something more that only the harder blows show
    assert asked(replace(seen, value=seen.value * hard), bent, x, seen.value) == [True, False]
    assert asked(seen, root, x[: len(root.space)], seen.value) == [True, False]


def test_of_many_torques_those_that_do_best_by_some_postures_are_fitted_well(struck, monkeypatch):
    bent, x, seen = struck
    root = Hypothesis(bent.context, bent.base)
    field = Field.of(root, x[: len(root.space)], seen, None, by_force=True, kinds=(SENSOR,))
    assert len(field.torques) > TORQUES
    tried = [port.port.where for port in field.round().sightings if port.port.kind is TORQUE]
    assert len(tried) == TORQUES
    assert tried[0] == "q2"
