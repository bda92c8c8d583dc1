"""Effects at several places at once: from what free functions found there to a model of them all."""

from dataclasses import replace
from unittest.mock import Mock

import numpy as np
import pytest

from flexmodal.diagnosis.disagreement.gaps import over_noise
from flexmodal.diagnosis.effects import catalogue
from flexmodal.diagnosis.effects.free_function import FreeFunction
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.lawfree.result import Findings, Found, told_at
from flexmodal.diagnosis.placed import Placed
from flexmodal.diagnosis.search.close_fit import fitted_closely
from flexmodal.diagnosis.selection.frf_thresholds import FLOOR_REACHED
from flexmodal.diagnosis.selection.in_its_stead import Refits
from flexmodal.diagnosis.selection.together import Together
from flexmodal.diagnosis.setup import Setup
from flexmodal.identification import predict
from flexmodal.structure import robot_space

MASS, DELAY, GAIN = ("added_mass", "link_3"), ("time_delay", "location_6"), ("sensor_gain", "location_6")
TRUTH = {MASS: {"mass": 40.0}, DELAY: {"delay": 8e-4}}
ABLE = ("added_mass", "time_delay", "sensor_gain")


@pytest.fixture(scope="module")
def made(context, observed):
    """FRFs of a heavier link read too late, and the robot re-tuned to them."""
    root = Hypothesis(context, robot_space(context.robot))
    both, x = root, np.zeros(len(root.space))
    for (name, where), values in TRUTH.items():
        placed = Placed(catalogue()[name], where)
        both = both.and_also(placed)
        x = both.start(placed, values, x)
    value = predict(both, x, observed)
    random = np.random.default_rng(3)
    noise = np.sqrt(observed.variance / 2) * (
        random.normal(size=value.shape) + 1j * random.normal(size=value.shape)
    )
    seen = replace(observed, value=value * np.exp(noise))
    setup = Mock(
        spec=Setup, fitted=seen, observations=seen, held=np.zeros(len(seen), dtype=bool), context=context,
        advance=Mock(),
    )  # fmt: skip
    return setup, fitted_closely(setup, root, np.zeros(len(root.space)))


def found(port, where, *, free=None, tells=None):
    return Found(port, where, "", 9.0, ((port, where),), None, (), None, free, tells)


def together(made, *places, able=ABLE):
    setup, root = made
    setup.effects = tuple(catalogue()[name] for name in able)
    look = Findings(9.0, 0.7, (), places, explains=True, needed=True, says="")

    def is_enough(one):
        return over_noise(setup, one) <= FLOOR_REACHED

    return Together(setup, root, look, is_enough, Refits(setup).without)


def test_all_are_fitted_together_and_others_in_each_place_are_compared(made):
    model, others = together(made, found("sensor", "location_6"), found("body", "link_3")).found()
    assert set(model.hypothesis.keys) == {MASS, DELAY}
    assert over_noise(made[0], model) < 1.1
    assert set(others) == {MASS, DELAY}
    for key, (itself, *rest) in others.items():
        assert itself.key == key
        assert set(itself.hypothesis.keys) == {MASS, DELAY}
        assert [one.key for one in rest] == ([GAIN] if key == DELAY else [])
        assert all(one.cost > 0.99 * model.cost for one in rest)


def test_what_a_function_tells_is_put_there_first(made):
    """However much better another effect would begin."""
    asked = together(made, found("sensor", "location_6", tells="sensor_gain"), found("body", "link_3"))
    first, second = asked._options(asked.look.found[0])
    assert first.placed.key == GAIN
    assert second.placed.key == DELAY


def test_effects_set_out_from_what_the_function_was(made, observed):
    frequency = observed.axis.frequency[::4]
    omega, own = 2 * np.pi * frequency, 2 * np.pi * 40.0
    swings = -(omega**2) * 12.0 * own**2 / (own**2 * (1 + 0.04j) - omega**2)
    free = FreeFunction(frequency, np.array([swings, 0 * swings, 0 * swings]), {}, made[1].x)
    place = found("body", "link_3", free=free)
    asked = together(made, found("sensor", "location_6"), place, able=(*ABLE, "local_absorber"))
    absorber = catalogue()["local_absorber"]
    told = told_at(place, absorber, "link_3", made[0].context)
    assert any(one["frequency"] == pytest.approx(40.0, rel=0.05) for one in told)
    (option,) = (one for one in asked._options(place) if one.placed.effect == absorber)
    assert option.starts[: len(told)] == list(told)
    assert told_at(found("body", "link_3"), absorber, "link_3", made[0].context) == []
    assert told_at(place, catalogue()["added_mass"], "link_3", made[0].context) == []  # which nobody can tell


@pytest.mark.parametrize(
    "places",
    [
        [("body", "link_3")],  # one alone is looked for otherwise
        [("body", "link_3"), ("rod", "q1+q3")],  # no effect of the catalogue is there
    ],
)
def test_none_where_there_are_no_two_or_one_has_no_effect(made, places):
    assert together(made, *(found(*one) for one in places)).found() is None
