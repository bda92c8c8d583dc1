"""The last fit: which parts of an effect are told as nothing."""

from types import SimpleNamespace
from unittest.mock import Mock

import numpy as np
import pytest

from flexmodal.diagnosis.effects import catalogue
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.placed import Placed
from flexmodal.diagnosis.search import close_fit
from flexmodal.diagnosis.search.close_fit import AT_LAST, FAR, IDLE, LAST, fitted_to_everything
from flexmodal.diagnosis.selection.frf_comparison import FittedFrfs
from flexmodal.diagnosis.setup import Setup
from flexmodal.structure import robot_space

IDLER = {"inertia", "frequency", "damping_ratio", "ratio"}
RELAXES = {"relaxing", "relaxation_time", "ratio"}


def hypothesis_of(context, *keys):
    found = Hypothesis(context, robot_space(context.robot))
    for name, where in keys:
        found = found.and_also(Placed(catalogue()[name], where))
    return found


@pytest.mark.parametrize(
    ("takes", "keys", "held"),
    [
        ({"inertia": 1.0, "relaxing": 1.0}, [("joint_coupling", "q1+q3")], IDLER | RELAXES),
        ({"inertia": 900.0, "relaxing": 1.0}, [("joint_coupling", "q1+q3")], RELAXES),
        ({"inertia": 1.0, "relaxing": 900.0}, [("joint_coupling", "q1+q3")], IDLER),
        ({"inertia": 900.0, "relaxing": 900.0}, [("joint_coupling", "q1+q3")], set()),
        ({"relaxing": 1.0}, [("structural_damping", "joints")], {"relaxing", "relaxation_time"}),
        ({"relaxing": IDLE + 0.1}, [("structural_damping", "joints")], set()),
        ({}, [("added_mass", "link_1")], set()),
    ],
)
def test_parts_that_take_hardly_anything_are_told_as_nothing(monkeypatch, context, takes, keys, held):
    """What each part takes off the cost is known here; what is held adds that to it."""
    hypothesis = hypothesis_of(context, *keys)

    def fitted(setup, hypothesis, start, *, floors=FAR, near, hold=None, fitted_to):
        assert near == AT_LAST
        short = {name.rpartition(".")[2] for name in hold or {}}
        cost = 100.0 + (0.5 if floors == LAST else 0.0) + sum(takes.get(name, 0.0) for name in short)
        assert not any((hold or {}).values())
        return Mock(
            spec=FittedFrfs, hypothesis=hypothesis, x=start, fitted=SimpleNamespace(cost=cost), short=short
        )

    monkeypatch.setattr(close_fit, "fitted_closely", fitted)
    model = Mock(spec=FittedFrfs, hypothesis=hypothesis, x=np.zeros(3))
    found = fitted_to_everything(Mock(spec=Setup, observations=None), model)
    assert found.short == held


@pytest.mark.parametrize(
    ("far", "near", "found", "fits"),
    [(50.0, 10.0, 50.0, 1), (52.0, 10.0, 52.0, 1), (90.0, 51.0, 51.0, 2), (90.0, 95.0, 90.0, 2)],
)
def test_what_is_integrated_in_time_does_not_end_farther_off_than_it_was(
    monkeypatch, context, far, near, found, fits
):
    """The prior counts: the model as it was leaves 40 and is 12 from belief."""
    hypothesis, made = hypothesis_of(context, ("coulomb_friction", "q1")), []

    def fitted(setup, hypothesis, start, *, floors, near=None, fitted_to=None):
        made.append(floors)
        return costing(far if floors == FAR else left_near)

    def costing(cost):
        return Mock(spec=FittedFrfs, costs=np.array([cost - 2, 1.0]), prior=1.0, hypothesis=hypothesis)

    left_near = near
    monkeypatch.setattr(close_fit, "fitted_closely", fitted)
    model = Mock(
        spec=FittedFrfs, hypothesis=hypothesis, x=np.zeros(3), costs=np.array([30.0, 10.0]), prior=12.0
    )
    last = fitted_to_everything(Mock(spec=Setup, observations=None), model)
    assert last.costs.sum() + last.prior == found
    assert made == [FAR, LAST][:fits]


def test_parts_are_parameters_of_their_effects(context):
    for effect in catalogue().values():
        for where in effect.places(context)[:1]:
            names = {parameter.name for parameter in effect.parameters(context, where)}
            assert {name for part in effect.parts for name in part} <= names
