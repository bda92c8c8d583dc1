"""What a search beside torques that are integrated in time looks at, and how far its trials go."""

from dataclasses import replace
from unittest.mock import Mock

import numpy as np
import pytest

import flexmodal
from flexmodal.diagnosis.effects import Context, catalogue
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.placed import Placed
from flexmodal.diagnosis.search import close_fit, coarse
from flexmodal.diagnosis.search.beside import seen_beside
from flexmodal.diagnosis.search.close_fit import FAR_OFF, tried_closely
from flexmodal.diagnosis.search.refine import Refined, Rounds, refined
from flexmodal.diagnosis.selection.frf_comparison import FittedFrfs
from flexmodal.diagnosis.setup import Setup
from flexmodal.diagnosis.time_domain.model import TimeDomainModel
from flexmodal.diagnosis.time_domain.straightened import straightened
from flexmodal.identification import predict
from flexmodal.identification.frf_fit import FrfMisfit, Weighting
from flexmodal.structure import robot_space

pytestmark = pytest.mark.usefixtures("one_loop")
SPRING = {"change": -0.5, "deflection": 2e-4}
MASS = {"mass": 6.0, "x": 0.1, "y": 0.0, "z": 0.0}


def with_effect(root, name, where, values, x):
    placed = Placed(catalogue()[name], where)
    hypothesis = root.and_also(placed)
    return hypothesis, hypothesis.start(hypothesis.placed[-1], values, x)


def carrying(seen, mass):
    """Beside a spring that softens, which is known, a mass that is not: all there is to a search."""
    context = Context.of(flexmodal.load("fanuc_s360"), seen)
    root = Hypothesis(context, robot_space(context.robot))
    bent, x = with_effect(root, "nonlinear_stiffness", "q2", SPRING, np.zeros(len(root.space)))
    both, true = with_effect(bent, "added_mass", "link_3", {**MASS, "mass": mass}, x)
    measured = replace(seen, value=predict(TimeDomainModel(both), true, seen))
    model = Mock(spec=FittedFrfs, hypothesis=bent, x=x, predicted=predict(TimeDomainModel(bent), x, seen))
    setup = Mock(
        spec=Setup, fitted=measured, observations=measured, held=np.zeros(len(seen), dtype=bool),
        context=context, advance=Mock(),
    )  # fmt: skip
    return setup, model, both, true


@pytest.fixture(scope="module")
def heavier(softly_struck):
    return carrying(softly_struck, MASS["mass"])


@pytest.mark.parametrize("mass", [0.3, 6.0])
def test_what_is_linear_is_looked_for_without_integrations(softly_struck, monkeypatch, mass):
    """Less is left there by measurements as they are, or straightened, whichever a look takes."""
    setup, model, both, true = carrying(softly_struck, mass)
    look = seen_beside(setup, model)
    monkeypatch.setattr(coarse, "TimeDomainModel", Mock(side_effect=AssertionError("nothing is integrated")))
    straight = straightened(setup.fitted, model.hypothesis, model.x, model.predicted)
    raw, within = (coarse.look_at(one, look.lines) for one in (setup.fitted, straight))
    there, as_measured, otherwise = (
        replace(one, straight=True).started(both, [true], 0.05, 1)[0].cost for one in (look, raw, within)
    )
    assert there == pytest.approx(min(as_measured, otherwise))
    assert as_measured != pytest.approx(otherwise, rel=0.2)
    half = both.start(both.placed[-1], {**MASS, "mass": mass / 2}, model.x)
    found = both.space.values(look.fitted(coarse.Candidate(both, half, np.inf), 0.05, 8).x)
    assert found["added_mass@link_3.mass"] == pytest.approx(mass, rel=0.1)


def test_torques_are_integrated_beside_others(heavier):
    setup, model, both, _ = heavier
    assert not seen_beside(setup, model, by_force=True).integrates(Hypothesis(both.context, both.base))
    assert seen_beside(setup, model, by_force=True).integrates(both)
    assert not seen_beside(setup, model).integrates(both)
    plain = Mock(spec=FittedFrfs, hypothesis=Hypothesis(both.context, both.base), predicted=model.predicted)
    look = seen_beside(setup, plain)
    assert not look.straight
    np.testing.assert_array_equal(look.apart.value, setup.fitted.value)


def test_one_round_after_the_other_comes_where_both_come(heavier):
    setup, _, both, true = heavier
    start = both.start(both.placed[-1], {**MASS, "mass": 5.0}, true[: -len(MASS)])
    seen = setup.fitted
    rough = refined(both, start, seen, rounds=Rounds.ROUGH)
    last = refined(both, rough.x, seen, rounds=Rounds.LAST)
    whole = refined(both, start, seen)
    assert last.cost <= rough.cost
    assert last.cost == pytest.approx(whole.cost, rel=1e-6)
    misfit = last.fitted.misfit
    assert rough.cost == pytest.approx(misfit.cost(rough.x), rel=1e-9)  # all by one model and model error
    assert rough.fitted.misfit.weighing.floor == misfit.weighing.floor


def test_derivatives_after_the_rough_round_are_nearly_right(heavier):
    """Along what no law depends on they are those of the stand-ins: good enough to count parameters."""
    setup, _, both, true = heavier
    lines = np.arange(0, len(setup.fitted.axis), 5)
    exact, rough = (
        FrfMisfit(TimeDomainModel(both, rough=one), setup.fitted, Weighting(0.01, lines)).equations(true)
        for one in (False, True)
    )
    known = [np.diag(one.curvature) > both.space.precision for one in (exact, rough)]
    assert known[0].tolist() == known[1].tolist()


@pytest.mark.parametrize(("over", "rounds"), [(1.1 * FAR_OFF, ["rough"]), (0.9 * FAR_OFF, ["rough", "last"])])
def test_a_trial_far_from_the_noise_ends_after_the_rough_round(heavier, monkeypatch, over, rounds):
    setup, _, both, true = heavier
    taken, made = [], Mock(spec=FittedFrfs, x=true)

    def once(hypothesis, start, observations, *, steps, rounds):
        taken.append(rounds.value)
        return Mock(spec=Refined, x=true, fitted=None, model=None)

    monkeypatch.setattr(close_fit, "refined", once)
    monkeypatch.setattr(close_fit, "fitted_model", lambda *given: made)
    monkeypatch.setattr(close_fit, "predict", lambda *given: None)
    monkeypatch.setattr(close_fit, "over_noise", lambda *given: over)
    assert tried_closely(setup, both, true) == [made]
    assert taken == rounds
