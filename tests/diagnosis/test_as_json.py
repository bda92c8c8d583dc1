"""`diagnosis.json` has the keys that the file formats give it, and nothing but finite numbers."""

import json
from dataclasses import replace

import pytest

from flexmodal.diagnosis.as_json import as_json
from flexmodal.diagnosis.outcome import Remaining
from flexmodal.errors import FlexmodalError

GAP = {"before", "after", "held_out_before", "held_out_after", "noise_floor"}
TOP = {"format", "campaign", "robot", "gap", "disagreement", "steps", "verdict", "warnings"}
TOP |= {"next_measurement", "law_free", "stand_in", "baselines", "set_up"}
REGION = {"rank", "posture", "response", "reference", "trial", "band", "share", "kind", "says"}
STEP = {"effect", "where", "parameters", "uncertainty", "confidence", "share", "alternatives", "swing", "gap"}


def plain(diagnosis):
    """Through the text, as a reader gets it."""
    return json.loads(json.dumps(as_json(diagnosis), allow_nan=False))


def test_keys_are_those_of_the_format(diagnosed):
    found = plain(diagnosed)
    assert set(found) == TOP
    assert found["format"] == 1
    assert set(found["gap"]) == GAP | {"believed"}
    (region,) = found["disagreement"]
    assert set(region) == REGION
    assert region["rank"] == 1
    (step,) = found["steps"]
    assert set(step) == STEP
    assert set(step["gap"]) == GAP
    assert all(set(one) == {"effect", "where", "confidence"} for one in step["alternatives"])
    assert set(found["verdict"]) == {"effects", "explained", "says", "share", "undecided", "remaining"}
    named = {"posture", "response", "reference", "separates", "gain"}
    assert set(found["next_measurement"]) == named | {"force_peak", "new_points", "locked", "masses"}


def test_values_are_those_of_the_diagnosis(diagnosed):
    found = plain(diagnosed)
    (step,), (own,) = found["steps"], diagnosed.steps
    assert step["parameters"] == dict(own.parameters)
    assert [one["effect"] for one in step["alternatives"]] == ["local_absorber", "unstructured_mode", "none"]
    assert found["gap"]["after"] == diagnosed.gaps.after
    assert found["gap"]["held_out_after"] is None
    assert step["gap"]["held_out_after"] == 0.05
    assert found["verdict"]["effects"] == [["link_flexibility", "link_2"]]
    assert found["next_measurement"]["separates"] == ["link_flexibility", "local_absorber"]


def test_one_effect_in_two_places_is_told_apart_by_them(diagnosed):
    pair = ("added_mass@link_1", "added_mass@link_2")
    measurement = replace(diagnosed.next_measurement, separates=pair)
    assert plain(replace(diagnosed, next_measurement=measurement))["next_measurement"]["separates"] == list(
        pair
    )


def test_nothing_found(diagnosed):
    found = plain(replace(diagnosed, steps=(), next_measurement=None, disagreement=()))
    assert (found["steps"], found["disagreement"], found["next_measurement"]) == ([], [], None)


def test_what_remains_is_told_beside_the_names(diagnosed):
    assert plain(diagnosed)["verdict"]["remaining"] is None
    left = replace(diagnosed.verdict, explained=False, remaining=Remaining(1.8, "link_2", "damping"))
    (step,) = diagnosed.steps
    found = plain(replace(diagnosed, verdict=left, steps=(replace(step, share=0.7),)))
    assert found["verdict"]["remaining"] == {"over_noise": 1.8, "where": "link_2", "kind": "damping"}
    assert found["steps"][0]["share"] == 0.7


def test_numbers_that_are_none(diagnosed):
    (step,) = diagnosed.steps
    gaps = replace(step.gaps, held_out_after=float("nan"))
    loose = replace(step, uncertainty={"stiffness": float("inf"), "damping": 3.0}, gaps=gaps)
    (found,) = plain(replace(diagnosed, steps=(loose,)))["steps"]
    assert found["uncertainty"] == {"damping": 3.0}
    assert found["gap"]["held_out_after"] is None
    broken = replace(diagnosed, gaps=replace(diagnosed.gaps, after=float("nan")))
    with pytest.raises(FlexmodalError, match="gap after is nan"):
        as_json(broken)
