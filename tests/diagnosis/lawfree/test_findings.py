"""What a look says, which effects it allows, and what a verdict makes of it."""

import json
from dataclasses import replace

import numpy as np
import pytest

from flexmodal.diagnosis.effects import catalogue
from flexmodal.diagnosis.effects.free_function import FreeFunction
from flexmodal.diagnosis.lawfree.as_json import look_json
from flexmodal.diagnosis.lawfree.effects_at import CLASSES_OF, PORT_OF
from flexmodal.diagnosis.lawfree.kinds import KINDS, TORQUE
from flexmodal.diagnosis.lawfree.port import Port
from flexmodal.diagnosis.lawfree.result import Class, Curve, Findings, Found, Loss, PlaceTried
from flexmodal.diagnosis.lawfree.tells import told_by
from flexmodal.diagnosis.lawfree.templates import templates_for
from flexmodal.diagnosis.outcome import Gaps, Remaining, Step
from flexmodal.diagnosis.report.free_look import look_parts
from flexmodal.diagnosis.selection.decision import Answer
from flexmodal.diagnosis.verdict.facts import Facts
from flexmodal.diagnosis.verdict.verdict import DOUBTFUL, verdict
from flexmodal.report import Section, page_text


def place(port, where, misfit, unknowns=1):
    return PlaceTried(port, where, f"what the {port} does", misfit, misfit, unknowns)


def class_of(name, share=0.99):
    return Class(name, f"{name}: k = 1", ((1.0,),), 1.0, share, 0.0)


CURVE = Curve(
    np.array([10.0, 20.0, 40.0]), ("bend 1", "bend 1, outwards"), "rad/(N·m)",
    np.array([[1e-6, 1.1e-6 - 1e-8j, 1e-6], [0, 0, 0]], dtype=complex), np.full((2, 3), 1e-8),
)  # fmt: skip
BENT = Found(
    "link", "link_2", "the bending of the link", 5.0, (("link", "link_2"), ("coupling", "q1+q2")), CURVE,
    (class_of("spring"),),
)  # fmt: skip


@pytest.fixture
def look():
    """A link that bends like a spring; a coupling is nearly as good."""
    link, coupling = place("link", "link_2", 0.7, 2), place("coupling", "q1+q2", 0.8, 3)
    far = place("joint", "q1", 5.0)
    return Findings(5.0, 0.7, (link, coupling, far), (BENT,), True, True, "It bends.")


@pytest.fixture
def both(look):
    """That, and a sensor that lags."""
    lag = Found("sensor", "tip", "what the sensor reads", 3.0, (("sensor", "tip"), ("channel", "tip")), CURVE,
                (class_of("delay"),))  # fmt: skip
    return replace(look, found=(BENT, lag))


def test_a_look_points_to_places_of_effects_as_far_as_it_can_tell_them_apart(look):
    assert look.is_at([("added_mass", "link_3"), ("link_flexibility", "link_2")])
    assert look.is_at([("joint_coupling", "q1+q2")])  # alike
    assert not look.is_at([("joint_coupling", "q2+q3"), ("link_flexibility", "link_3")])


def test_only_effects_of_the_place_and_class_are_allowed():
    assert BENT.could_be("link_flexibility", "link_2")
    assert BENT.could_be("joint_coupling", "q1+q2")  # alike, and its curve was not looked at
    assert not BENT.could_be("link_flexibility", "link_3")
    assert not BENT.could_be("servo_compliance", "q1")
    other = replace(BENT, classes=(class_of("mass"),))
    assert not other.could_be("link_flexibility", "link_2")
    unknown = replace(BENT, classes=())
    assert unknown.could_be("link_flexibility", "link_2")  # of no class that is known: no word against it
    assert not replace(unknown, alike=unknown.alike[:1]).surely("link_flexibility")
    curveless = replace(BENT, curve=None, classes=(), alike=(("link", "link_2"),))  # one for each blow
    assert curveless.could_be("link_flexibility", "link_2")
    assert not curveless.surely("link_flexibility")
    crossed = replace(curveless, port="channel", where="tip", alike=(("channel", "tip"),))
    assert crossed.could_be("sensor_gain", "tip")  # two channels that mix can do what one does
    assert not crossed.could_be("sensor_gain", "elbow")
    assert not crossed.could_be("an effect without a port", "tip")


def test_an_effect_is_sure_where_nothing_else_can_be_there(both):
    bent, lag = both.found
    assert not bent.surely("link_flexibility")
    assert replace(bent, alike=bent.alike[:1]).surely("link_flexibility")
    assert lag.surely("time_delay")  # a channel that is left out can do whatever a function of it can
    assert not replace(lag, alike=(*lag.alike, ("sensor", "elbow"))).surely("time_delay")


def test_each_effect_sits_at_a_place_of_its_own(both):
    keys = [("time_delay", "tip"), ("link_flexibility", "link_2")]
    assert {key: one.where for key, one in both.met(keys).items()} == {key: key[1] for key in keys}
    twice = [("time_delay", "tip"), ("time_delay", "tip")]
    assert len(both.met(twice)) == 1
    assert not both.met([("added_mass", "link_2")])
    assert not both.met([])


def test_with_several_places_others_are_not_tried(both):
    assert both.worth_trying("time_delay", "tip")
    assert both.worth_trying("link_flexibility", "link_2")
    assert not both.worth_trying("time_delay", "elbow")


def test_a_motor_is_tried_where_a_torque_is_free_for_every_blow():
    """That does whatever a motor does, even if the motor's own port did not come so far."""
    torque = Found("torque", "q4", "a torque", 10.0, (("torque", "q4"),), None, ())
    place = PlaceTried("torque", "q4", "a torque", 6.0, None, 9)
    look = Findings(10.0, 6.0, (place,), (torque,), False, True, "")
    assert look.worth_trying("servo_compliance", "q4")
    assert not look.worth_trying("servo_compliance", "q3")
    assert not look.worth_trying("added_mass", "q4")
    assert not look.met([("servo_compliance", "q4")])


def test_what_is_far_is_not_tried_and_others_always_are(look):
    assert look.worth_trying("link_flexibility", "link_2")
    assert look.worth_trying("joint_coupling", "q1+q2")
    assert not look.worth_trying("servo_compliance", "q1")
    assert not look.worth_trying("added_mass", "link_2")
    assert look.worth_trying("somebody_elses_effect", "anywhere")


@pytest.mark.parametrize(
    ("misfit", "explains", "expected"), [(3.6, False, True), (4.3, False, False), (3.6, True, False)]
)
def test_a_place_that_only_those_held_out_speak_against_is_tried_while_several_are_missing(
    misfit, explains, expected
):
    """An absorber beside a friction: its function takes most where it is fitted, and misleads elsewhere."""
    best = PlaceTried("torque", "q2", "a torque", 4.2, None, 9)
    body = PlaceTried("body", "link_4", "a body", misfit, 7.6, 5)
    found = Found("torque", "q2", "a torque", 5.4, (("torque", "q2"),), None, ())
    look = Findings(5.4, 4.2, (best, body), (found,), explains, True, "")
    assert look.worth_trying("local_absorber", "link_4") is expected
    assert not look.worth_trying("local_absorber", "link_3")


@pytest.mark.parametrize(
    ("leaves", "tried"), [((6.0, 9.9), True), ((6.0, 10.1), False), ((10.5, 10.9), True)]
)
def test_what_leaves_more_than_nothing_does_is_not_tried_unless_everything_does(leaves, tried):
    """The robot alone leaves 10."""
    kinds = ("torque", "q4"), ("body", "link_2")
    places = tuple(PlaceTried(*kind, "", one, None, 2) for kind, one in zip(kinds, leaves, strict=True))
    torque = Found("torque", "q4", "a torque", 10.0, (kinds[0],), None, ())
    assert (
        Findings(10.0, 6.0, places, (torque,), False, True, "").worth_trying("added_mass", "link_2") is tried
    )


@pytest.mark.parametrize(
    ("leaves", "found", "tells"),
    [(7.9, "torque", True), (8.1, "torque", False), (9.9, "base", True)],
    ids=["gains by itself", "hardly gains", "is what was found"],
)
def test_a_place_tells_where_fits_set_out_even_beside_one_that_leaves_less(context, leaves, found, tells):
    """The robot alone leaves 10."""
    fitted = np.array([0.1])
    free = FreeFunction(np.array([10.0]), np.array([[1e-6 + 0j]]), {}, fitted)
    kinds = ("torque", "q4"), ("base", "base")
    places = (
        PlaceTried(*kinds[0], "", 6.0, None, 9),
        PlaceTried(*kinds[1], "", leaves, leaves, 36, free),
    )
    at = next(kind for kind in kinds if kind[0] == found)
    look = Findings(10.0, 6.0, places, (Found(*at, "", 10.0, (at,), None, ()),), False, True, "")

    def told(context, where, free):
        return [{"mass": 2.0}, {"mass": 3.0}]

    effect = replace(catalogue()["base_flexibility"], told=told)
    expected = [({"mass": 2.0}, fitted), ({"mass": 3.0}, fitted)] if tells else []
    assert look.told(effect, "base", context) == expected
    assert bool(replace(look, explains=True).told(effect, "base", context)) is (found == "base")
    assert look.told(replace(effect, told=None), "base", context) == []


def test_every_effect_of_the_catalogue_has_a_port_and_classes_there_are(context):
    kinds = {kind.name: kind for kind in (*KINDS, TORQUE)}
    assert set(PORT_OF) == set(catalogue())
    assert set(PORT_OF.values()) <= set(kinds)
    for effect, classes in CLASSES_OF.items():
        kind = kinds[PORT_OF[effect]]
        port = Port.at(kind, kind.places(context)[0], context)
        assert set(classes) <= {one.name for one in templates_for(port)}


def test_json_holds_plain_numbers(look):
    found = json.loads(json.dumps(look_json(look), allow_nan=False))
    assert found["places"][0] == {
        "port": "link", "where": "link_2", "misfit": 0.7, "held_out": 0.7, "unknowns": 2,
    }  # fmt: skip
    one = found["found"][0]
    assert one["alike"] == [["link", "link_2"], ["coupling", "q1+q2"]]
    assert one["curve"]["functions"][0]["imaginary"] == [0.0, -1e-8, 0.0]
    assert one["classes"][0]["class"] == "spring"
    assert one["tells"] is None  # a coupling would do as well
    assert one["loss"] is None
    assert look_json(replace(look, alone=np.inf))["misfit_alone"] is None


def test_the_report_shows_places_and_curve(look):
    text = page_text("t", [], [Section("Without a law", look_parts(look))])
    assert "It bends." in text
    assert "coupling q1+q2" in text
    assert "alike" in text
    assert text.count("<svg") + text.count("data:image") >= 1
    named = replace(BENT, where="<script>", alike=(("link", "<script>"),))
    hostile = replace(look, places=(place("link", "<script>", 0.7),), found=(named,))
    assert "<script>" not in page_text("t", [], [Section("Without a law", look_parts(hostile))])


@pytest.fixture
def facts(look):
    gaps = Gaps(0.2, 0.06, 0.2, 0.07, 0.04)
    step = Step("link_flexibility", "link_2", {}, {}, {}, 1.0, gaps, ())
    return Facts(
        steps=(step,), says={"link_flexibility": "the link bends"}, gaps=gaps, over_noise=1.9,
        reached=Answer.NO, lacking={}, open_=False, place="link_2", kind="damping", share=0.94, look=look,
    )  # fmt: skip


def test_an_effect_of_another_law_is_named_with_its_share(facts):
    says = verdict(replace(facts, standing=(("link_flexibility", "link_2"),)))
    assert says.effects == (("link_flexibility", "link_2"), ("unknown", "link_2"))
    assert not says.explained
    assert says.share == 0.94
    assert "takes 94" in says.says
    assert "It bends." in says.says


@pytest.mark.parametrize(("confidence", "named"), [(1e-20, False), (1e-4, False), (0.3, True)])
def test_a_single_effect_that_is_hardly_possible_is_not_named_whatever_it_takes(facts, confidence, named):
    """A bearing passed for a foundation that took 99 % with parameters far from the card."""
    (step,) = facts.steps
    there = (("link_flexibility", "link_2"),)
    link = replace(step, confidence=confidence, share=0.94)
    other = replace(step, effect="added_mass", where="link_1", confidence=0.9, share=0.05)  # does not stand
    says = verdict(replace(facts, steps=(link, other), standing=there, share=0.99))
    assert says.effects == ((*there, ("unknown", "link_2")) if named else (("unknown", "link_2"),))
    assert (says.share is not None) is named
    assert ("takes 94" in says.says) is named


@pytest.mark.parametrize("rounding", [-1e-9, 1e-9])
def test_at_the_border_of_being_hardly_possible_it_is_named_and_told(facts, rounding):
    (step,) = facts.steps
    doubtful = replace(step, confidence=0.0141 * (1 + rounding))
    says = verdict(replace(facts, steps=(doubtful,), standing=(("link_flexibility", "link_2"),)))
    assert says.effects[0] == ("link_flexibility", "link_2")
    assert says.undecided == (DOUBTFUL,)


def test_of_several_effects_one_that_is_hardly_possible_alone_stays(facts):
    """What each gains before the others are there says little."""
    (step,) = facts.steps
    other = replace(step, effect="added_mass", where="link_1", confidence=1e-20)
    both = (("link_flexibility", "link_2"), ("added_mass", "link_1"))
    says = verdict(
        replace(facts, steps=(step, other), standing=both, says={**facts.says, "added_mass": "a mass"})
    )
    assert says.effects == (*both, ("unknown", "link_2"))


def test_what_is_missing_besides_is_unknown_beside_the_names(facts):
    says = verdict(replace(facts, standing=(("link_flexibility", "link_2"),), lacking_at=("tip",)))
    assert says.effects == (("link_flexibility", "link_2"), ("unknown", "tip"))
    assert not says.explained
    assert "look at tip" in says.says
    assert says.named
    assert says.remaining == Remaining(1.9, "tip", "damping")


def test_two_effects_for_what_one_place_explains_are_not_named(facts):
    both = replace(facts, steps=facts.steps * 2, reached=Answer.YES, over_noise=1.0)
    assert verdict(both).explained
    assert verdict(both).remaining is None
    says = verdict(replace(both, contradicted=True))
    assert says.effects == (("unknown", "link_2"),)
    assert not says.explained
    assert "none of them sits there" in says.says


def test_without_the_look_behind_it_the_answer_stays_unknown(facts):
    says = verdict(facts)
    assert says.effects == (("unknown", "link_2"),)
    assert says.share is None


def test_what_a_function_alone_tells_is_in_the_json(look):
    alone = replace(BENT, alike=(("link", "link_2"),))
    rubs = Found("torque", "q2", "a torque", 5.4, (("torque", "q2"),), None, (), Loss(0.5, 0.75))
    alone, rubs = (replace(one, tells=told_by(one)) for one in (alone, rubs))
    one, other = look_json(replace(look, found=(alone, rubs)))["found"]
    assert one["tells"] == "link_flexibility"
    assert other["tells"] == "coulomb_friction"
    assert other["loss"] == {"share": 0.5, "weaker": 0.75}
    assert look_json(replace(look, found=(alone,), explains=False))["found"][0]["tells"] is None
