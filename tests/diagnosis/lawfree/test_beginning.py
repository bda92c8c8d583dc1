"""Where the fits of a law-free look set out."""

import numpy as np
import pytest

from flexmodal.diagnosis.effects import catalogue
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.lawfree.beginning import beginnings
from flexmodal.diagnosis.lawfree.kinds import NOTHING
from flexmodal.diagnosis.lawfree.look import Field
from flexmodal.diagnosis.lawfree.model import PortedModel
from flexmodal.diagnosis.lawfree.port import Port
from flexmodal.diagnosis.lawfree.port_fits import PortFits
from flexmodal.diagnosis.placed import Placed
from flexmodal.identification import fit
from flexmodal.structure import robot_space


@pytest.fixture(scope="module")
def root(context):
    return Hypothesis(context, robot_space(context.robot))


def test_without_effects_too_at_the_card_and_at_the_robot_re_tuned(root, observed):
    x = np.random.default_rng(5).normal(size=len(root.space))
    nothing = [Port.at(NOTHING, "", root.context)]
    card, tuned = beginnings(PortedModel.of(nothing, root, observed, np.arange(20, 80), x))
    np.testing.assert_array_equal(card, 0.0)
    np.testing.assert_array_equal(tuned, x)
    assert len(beginnings(PortedModel.of(nothing, root, observed, np.arange(20, 80)))) == 1


def test_a_robot_that_is_fitted_far_from_its_card_leaves_no_more_there(root, observed):
    """What a look says is left without any port is not what a worse minimum leaves."""
    x = fit(root, observed).x
    bare = {start: Field.of(root, at, observed, None).bare for start, at in {"card": 0 * x, "fit": x}.items()}
    assert bare["fit"] <= bare["card"] * (1 + 1e-6)


@pytest.mark.parametrize(
    ("placed", "card", "tuned"), [(False, 10.0, False), (False, 13.0, True), (True, 10.0, True)]
)
def test_alone_only_where_the_card_leaves_far_more(root, observed, monkeypatch, placed, card, tuned):
    """From the robot re-tuned 6.4 are left."""
    if placed:
        root = root.and_also(Placed(catalogue()["added_mass"], "link_3"))
    x = np.ones(len(root.space))
    bare = property(lambda field: card if field.fitted is None else 6.4)
    monkeypatch.setattr(PortFits, "bare", bare)
    assert (Field.of(root, x, observed, None).fitted is not None) is tuned
