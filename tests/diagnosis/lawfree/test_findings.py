"""What a look says, which effects it allows, and what a verdict makes of it."""

import json
from dataclasses import replace

import numpy as np
import pytest

from flexmodal.diagnosis.effects import catalogue
from flexmodal.diagnosis.lawfree.as_json import look_json
from flexmodal.diagnosis.lawfree.kinds import KINDS, TORQUE
from flexmodal.diagnosis.lawfree.port import Port
from flexmodal.diagnosis.lawfree.result import CLASSES_OF, PORT_OF, Class, Curve, Findings, PlaceTried
from flexmodal.diagnosis.lawfree.templates import templates_for
from flexmodal.diagnosis.outcome import Gaps, Step
from flexmodal.diagnosis.report.free_look import look_parts
from flexmodal.diagnosis.selection.decision import Answer
from flexmodal.diagnosis.verdict.facts import Facts
from flexmodal.diagnosis.verdict.verdict import verdict
from flexmodal.report import Section, page_text


def place(port, where, misfit, unknowns=1):
    return PlaceTried(port, where, f"what the {port} does", misfit, misfit, unknowns)


def class_of(name, share=0.99):
    return Class(name, f"{name}: k = 1", ((1.0,),), 1.0, share, 0.0)


@pytest.fixture
def look():
    """A link that bends like a spring; a coupling is nearly as good."""
    link, coupling = place("link", "link_2", 0.7, 2), place("coupling", "q1+q2", 0.8, 3)
    far = place("joint", "q1", 5.0)
    curve = Curve(
        np.array([10.0, 20.0, 40.0]), ("bend 1", "bend 1, outwards"), "rad/(N·m)",
        np.array([[1e-6, 1.1e-6 - 1e-8j, 1e-6], [0, 0, 0]], dtype=complex), np.full((2, 3), 1e-8),
    )  # fmt: skip
    return Findings(
        5.0, (link, coupling, far), (link, coupling), True, True, curve, (class_of("spring"),), "It bends."
    )


def test_only_effects_of_the_place_and_class_are_allowed(look):
    assert look.could_be("link_flexibility", "link_2")
    assert look.could_be("joint_coupling", "q1+q2")  # alike, and its curve was not looked at
    assert not look.could_be("link_flexibility", "link_3")
    assert not look.could_be("servo_compliance", "q1")
    heavy = replace(look, classes=(class_of("spring, damper and mass"),))
    assert not heavy.could_be("link_flexibility", "link_2")
    assert not replace(look, classes=()).could_be("link_flexibility", "link_2")


def test_what_is_far_is_not_tried_and_others_always_are(look):
    assert look.worth_trying("link_flexibility", "link_2")
    assert look.worth_trying("joint_coupling", "q1+q2")
    assert not look.worth_trying("servo_compliance", "q1")
    assert not look.worth_trying("added_mass", "link_2")
    assert look.worth_trying("somebody_elses_effect", "anywhere")
    blind = replace(look, explains=False)
    assert blind.worth_trying("added_mass", "link_2")


def test_every_effect_of_the_catalogue_has_a_port_and_classes_there_are(context):
    kinds = {kind.name: kind for kind in (*KINDS, TORQUE)}
    assert set(PORT_OF) == set(catalogue())
    assert set(PORT_OF.values()) <= set(kinds)
    for effect, classes in CLASSES_OF.items():
        kind = kinds[PORT_OF[effect]]
        port = Port.at(kind, kind.places(context)[0], context)
        assert set(classes) <= {one.name for one in templates_for(port)}


def test_the_share_is_of_what_is_above_the_noise(look):
    assert look.share == 1.0
    rest = place("link", "link_2", 2.0, 2)
    some = replace(look, places=(rest,), alike=(rest,))
    assert some.share == pytest.approx(1 - 3 / 24)


def test_json_holds_plain_numbers(look):
    found = json.loads(json.dumps(look_json(look), allow_nan=False))
    assert found["places"][0] == {
        "port": "link", "where": "link_2", "misfit": 0.7, "held_out": 0.7, "unknowns": 2,
    }  # fmt: skip
    assert found["alike"] == [["link", "link_2"], ["coupling", "q1+q2"]]
    assert found["curve"]["functions"][0]["imaginary"] == [0.0, -1e-8, 0.0]
    assert found["classes"][0]["class"] == "spring"
    assert look_json(replace(look, alone=np.inf, curve=None))["misfit_alone"] is None


def test_the_report_shows_places_and_curve(look):
    text = page_text("t", [], [Section("Without a law", look_parts(look))])
    assert "It bends." in text
    assert "coupling q1+q2" in text
    assert "alike" in text
    assert text.count("<svg") + text.count("data:image") >= 1
    hostile = replace(look, places=(place("link", "<script>", 0.7),), alike=(place("link", "<script>", 0.7),))
    assert "<script>" not in page_text("t", [], [Section("Without a law", look_parts(hostile))])


@pytest.fixture
def facts(look):
    gaps = Gaps(0.2, 0.06, 0.2, 0.07, 0.04)
    step = Step("link_flexibility", "link_2", {}, {}, {}, 1.0, gaps, ())
    return Facts(
        steps=(step,), says={"link_flexibility": "the link bends"}, gaps=gaps, over_noise=1.9,
        reached=Answer.NO, lacking={}, open_=False, place="link_2", share=0.94, look=look,
    )  # fmt: skip


def test_an_effect_of_another_law_is_named_with_its_share(facts):
    says = verdict(replace(facts, named=True))
    assert says.effects == (("link_flexibility", "link_2"),)
    assert not says.explained
    assert says.share == 0.94
    assert "takes 94" in says.says
    assert "It bends." in says.says


def test_two_effects_for_what_one_place_explains_are_not_named(facts):
    both = replace(facts, steps=facts.steps * 2, reached=Answer.YES, over_noise=1.0)
    assert verdict(both).explained
    says = verdict(replace(both, contradicted=True))
    assert says.effects == (("unknown", "link_2"),)
    assert not says.explained
    assert "none of them sits there" in says.says


def test_without_the_look_behind_it_the_answer_stays_unknown(facts):
    says = verdict(facts)
    assert says.effects == (("unknown", "link_2"),)
    assert says.share is None
