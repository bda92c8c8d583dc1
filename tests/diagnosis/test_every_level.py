"""Whatever law an effect was named with, however wide: its answer is written."""

import json
from dataclasses import replace

import numpy as np
import pytest

from flexmodal.diagnosis.as_json import as_json
from flexmodal.diagnosis.effects import catalogue
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.improved.extend import extend
from flexmodal.diagnosis.placed import Placed
from flexmodal.diagnosis.report.joint_pictures import joint_parts
from flexmodal.identification import predict
from flexmodal.model import check
from flexmodal.structure import robot_space


def levels():
    """Every effect at every level of its law."""
    found = []
    for effect in catalogue().values():
        one, number = effect, 0
        while one is not None:
            found.append(pytest.param(one, id=f"{one.name}-{number}"))
            one, number = None if one.next_level is None else one.next_level.effect, number + 1
    return found


@pytest.mark.some(3)
@pytest.mark.parametrize("effect", levels())
def test_its_answer_is_written(effect, context, observed, diagnosed, tmp_path):
    places = effect.places(context)
    if not places:
        pytest.skip("a planar arm has no place for it")
    hypothesis = Hypothesis(context, robot_space(context.robot)).and_also(Placed(effect, places[-1]))
    start = effect.starts(context, places[-1])[0]
    x = hypothesis.start(hypothesis.placed[-1], start, np.zeros(len(hypothesis.base)))
    assert np.isfinite(predict(hypothesis, x, observed)).all()
    diagnosis = replace(
        diagnosed, model=hypothesis, x=x, deviation=np.zeros(len(x)), frfs=observed,
        predicted={"before": observed.value, "after": observed.value},
    )  # fmt: skip
    json.dumps(as_json(diagnosis), allow_nan=False)
    assert len(joint_parts(diagnosis)) == (2 if effect.law else 0)
    report = check(extend(diagnosis).write(tmp_path))
    assert report.is_sound, report.faults
