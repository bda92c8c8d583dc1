"""How sure an explanation is: by hand where the formula is simple, and what has to lower it."""

from dataclasses import replace
from unittest.mock import Mock

import numpy as np
import pytest

from flexmodal.diagnosis.lawfree.effects_at import PORT_OF
from flexmodal.diagnosis.lawfree.result import Curve, Findings, Found
from flexmodal.diagnosis.lawfree.tells import told_by
from flexmodal.diagnosis.selection import confidence
from flexmodal.diagnosis.selection.comparison import Comparison
from flexmodal.diagnosis.selection.confidence import probabilities
from flexmodal.diagnosis.selection.frf_comparison import FittedFrfs
from flexmodal.diagnosis.selection.frf_data import FrfData
from flexmodal.diagnosis.setup import Setup

NOTHING = np.zeros(2)


def of(costs, *, pieces=8.0, noise=1.0, odds=0.1, sizes=NOTHING, priors=NOTHING):
    """Probabilities of two models, the second of them named."""
    return probabilities(np.array(costs), sizes, priors, 1, pieces, noise, odds)


def test_by_hand():
    """Costs of 4 and 1 at the noise, ν = 8: (1/4)⁴ against 1 and a tenth."""
    first, second = of([4.0, 1.0])
    assert first == pytest.approx(4.0**-4 / (4.0**-4 + 1 + 0.1), rel=1e-12)
    assert second == pytest.approx(1 / (4.0**-4 + 1 + 0.1), rel=1e-12)


def test_it_is_never_surer_than_the_odds_of_something_else():
    assert of([1e300, 1e-9], pieces=1e3)[1] == pytest.approx(1 / 1.1)
    assert of([1e300, 1e-9], pieces=1e3, odds=0.01)[1] == pytest.approx(1 / 1.01)


def test_what_is_left_above_the_noise_is_somebody_elses():
    at, above, far = (of([50.0, cost])[1] for cost in (1.0, 1.5, 3.0))
    assert at > above > far
    assert above == pytest.approx(1.5**-4 / (50.0**-4 + 1.5**-4 + 0.1), rel=1e-12)


def test_few_frfs_make_nobody_sure():
    few, many = (of([1.3, 1.0], pieces=pieces)[1] for pieces in (3.0, 60.0))
    assert few < 0.6
    assert many > 0.9


def test_parameters_and_odd_values_of_them_cost():
    plain = of([2.0, 1.0])[1]
    assert of([2.0, 1.0], sizes=np.array([0.0, 3.0]))[0] > of([2.0, 1.0])[0]
    assert of([2.0, 1.0], priors=np.array([0.0, 4.0]))[1] < plain
    assert of([2.0, 1.0], priors=np.array([4.0, 4.0]))[1] == pytest.approx(plain, rel=1e-12)


@pytest.mark.parametrize(
    ("over", "rest", "expected"),
    [(1.2, 0.5, True), (1.78, 0.02, True), (1.78, 0.2, False), (3.0, 0.001, False)],
)
def test_what_counts_as_explained_is_not_doubted_for_what_it_leaves(monkeypatch, over, rest, expected):
    """Half the disagreement may be left at the noise; up to twice the noise next to none of it."""
    monkeypatch.setattr(confidence, "over_noise", lambda setup, model: over)
    monkeypatch.setattr(confidence, "left", lambda setup, first, last: rest)
    variance, many = np.full((20, 1, 50), 1e-4), np.full(20, 100.0)
    seen = Mock(variance=variance, used=np.ones_like(variance, dtype=bool))
    look = Mock(spec=Findings, left=5.0, found=(), lone=None, met=lambda keys: {})
    setup = Mock(spec=Setup, observations=seen)
    data = Mock(spec=FrfData, setup=setup, root=None, look_for=lambda model: look)
    key, weighing = ("sensor_gain", "point_2"), Mock(floor=0.0)
    models = [
        Mock(
            spec=FittedFrfs,
            key=key,
            costs=costs,
            strong=1.0,
            prior=0.0,
            parameters=1,
            fitted=Mock(weighing=weighing),
            hypothesis=Mock(placed=(key,)),
        )
        for costs in (50 * many, 3 * many)
    ]
    compared = Mock(spec=Comparison, models=models, probability=np.array([0.0, 1.0]), order=[1, 0])
    sure = confidence.confidences(data, compared, 1)[1]
    assert (sure == pytest.approx(1 / 1.2)) if expected else (sure < 0.01)


@pytest.mark.parametrize(("nearest", "first"), [(0.0, 2), (10.0, 2), (400.0, 1)])
def test_a_card_that_everything_contradicts_decides_less(monkeypatch, nearest, first):
    """Twenty nats of belief between two that leave noise; of 10 parameters that are off by 10 at least."""
    monkeypatch.setattr(
        confidence, "over_noise", lambda setup, model: 1.05 if model.hypothesis.placed else 3.0
    )
    monkeypatch.setattr(confidence, "left", lambda setup, first, last: 0.0)
    given = [(900.0, nearest), (100.0, nearest + 40.0), (110.0, nearest)]
    models = [
        Mock(
            spec=FittedFrfs,
            key=(f"effect {k}", ""),
            costs=np.array([cost]),
            strong=1.0,
            prior=prior,
            hypothesis=Mock(placed=(k,) if k else ()),
        )
        for k, (cost, prior) in enumerate(given)
    ]
    models[0].parameters = 10
    monkeypatch.setattr(confidence, "PIECES", 100.0)
    found = confidence.plausible(
        Mock(spec=FrfData, setup=None, root=None), Mock(spec=Comparison, models=models)
    )
    assert sorted(found) == [1, 2]
    assert max(found, key=found.get) == first


def test_where_nothing_added_is_at_the_noise_too_evidence_decides(monkeypatch):
    """A mass that re-tuning takes up gains 239 nats over all lines, and next to nothing by whole FRFs."""
    monkeypatch.setattr(confidence, "over_noise", lambda setup, model: 1.0)
    monkeypatch.setattr(confidence, "left", lambda setup, first, last: 1.0)
    look = Mock(spec=Findings, left=0.5, found=(), lone=None, met=lambda keys: {})
    setup = Mock(spec=Setup, observations=Mock(variance=np.ones((1, 1, 1)), used=np.ones((1, 1, 1), bool)))
    data = Mock(spec=FrfData, setup=setup, root=None, look_for=lambda model: look)
    models = [
        Mock(
            spec=FittedFrfs,
            key=key,
            costs=np.array([cost]),
            strong=1.0,
            prior=0.0,
            parameters=1,
            fitted=Mock(weighing=Mock(floor=0.0)),
            hypothesis=Mock(placed=placed),
        )
        for key, cost, placed in ((("none", ""), 31954.0, ()), (("added_mass", "link_1"), 30691.0, (1,)))
    ]
    compared = Mock(spec=Comparison, models=models, probability=np.array([0.0, 1.0]), order=[1, 0])
    assert confidence.plausible(data, compared) == {}
    sure = confidence.confidences(data, compared, 1)
    np.testing.assert_allclose(sure, [0.0, 1 / (1 + confidence.ALONE)])


@pytest.mark.parametrize(
    ("key", "alike", "others"),
    [
        (("link_flexibility", "link_3"), (), 0.0),
        (("link_flexibility", "link_3"), (("damping", "joints"),), 0.9),
        (("base_flexibility", "base"), (), 0.9),  # a machine beside the robot acts there in the same way
    ],
)
def test_where_a_function_alone_tells_what_is_there_nothing_elsewhere_counts(monkeypatch, key, alike, others):
    """A law of many parameters that leaves much, where the re-tuned robot would be more plausible."""
    monkeypatch.setattr(
        confidence, "over_noise", lambda setup, model: 1.6 if model.hypothesis.placed else 2.4
    )
    monkeypatch.setattr(confidence, "left", lambda setup, first, last: 0.3)
    port = PORT_OF[key[0]], key[1]
    link = Found(*port, "", 4.6, (port, *alike), Mock(spec=Curve), ())
    link = replace(link, tells=told_by(link))
    look = Findings(4.6, 0.6, (), (link,), explains=True, needed=True, says="")
    seen = Mock(variance=np.ones((1, 1, 1)), used=np.ones((1, 1, 1), bool))
    data = Mock(
        spec=FrfData, setup=Mock(spec=Setup, observations=seen), root=None, look_for=lambda model: look
    )
    models = [
        Mock(
            spec=FittedFrfs,
            key=one,
            costs=np.full(20, cost),
            strong=strong,
            prior=0.0,
            parameters=1,
            fitted=Mock(weighing=Mock(floor=0.0)),
            hypothesis=Mock(placed=(one,) if strong else ()),
        )
        for one, cost, strong in ((("none", ""), 2.0, 0.0), (key, 1.0, 12.0))
    ]
    compared = Mock(spec=Comparison, models=models, probability=np.array([0.9, 0.1]), order=[0, 1])
    found = confidence.confidences(data, compared, 1)
    assert found[0] == pytest.approx(others, abs=0.1)
    assert found[1] == pytest.approx(0.04 if others else 1 / (1 + confidence.AGREES), abs=0.04)
