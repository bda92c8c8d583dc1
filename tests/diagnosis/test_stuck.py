"""Friction that hardly slides: nothing depends on the force of the blow, and nothing asks for it."""

from unittest.mock import Mock

import numpy as np
import pytest

from flexmodal.diagnosis.effects import catalogue
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.lawfree.result import Findings, Found
from flexmodal.diagnosis.selection import frf_candidates, searches_beside
from flexmodal.diagnosis.selection.frf_candidates import FrfCandidates
from flexmodal.diagnosis.selection.frf_comparison import FittedFrfs
from flexmodal.diagnosis.setup import Setup

RUBS, MOTOR = "coulomb_friction", ("servo_compliance", "q2")


@pytest.mark.parametrize(
    ("port", "explains", "over", "where", "force", "tried"),
    [
        ("joint", True, 1.3, "q2", False, True),
        ("joint", True, 1.05, "q2", False, False),
        ("joint", True, 1.05, "q1+q2", False, True),
        ("joint", True, 1.3, "q2", True, False),
        ("joint", False, 1.3, "q2", False, False),
        ("link", True, 1.3, "q2", False, False),
    ],
    ids=["no law does", "one does", "a wider place does", "it slides", "nothing explains", "elsewhere"],
)
def test_friction_is_tried_where_a_joint_explains_everything_and_no_law_there_does(
    monkeypatch, port, explains, over, where, force, tried
):
    asked, rubs = [], Mock(spec=FittedFrfs, key=(RUBS, "q2"), cost=1.0)

    def explanations(*given, with_force, allowed, **more):
        asked.append((with_force, [key for key in ((RUBS, "q2"), (RUBS, "q1"), MOTOR) if allowed(*key)]))
        return [rubs]

    monkeypatch.setattr(searches_beside, "explanations", explanations)
    monkeypatch.setattr(frf_candidates, "over_noise", lambda setup, model: over)
    bare = Mock(spec=Hypothesis, base=(), placed=(), keys=())
    root = Mock(spec=FittedFrfs, hypothesis=bare, x=np.zeros(0), cost=9.0)
    candidates = FrfCandidates(
        Mock(spec=Setup, effects=tuple(catalogue().values()), advance=Mock()), root, with_force=force
    )
    found = [Mock(spec=FittedFrfs, key=(MOTOR[0], where), cost=2.0)]
    look = Mock(
        spec=Findings, explains=explains, found=(Mock(spec=Found, port=port, where="q2"),), needed=False
    )
    candidates.looks = Mock(one=look)
    assert candidates._stuck(root, 0, found, look) == ([rubs, *found] if tried else found)
    assert asked == ([(True, [(RUBS, "q2")])] if tried else [])
