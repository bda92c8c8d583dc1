"""The workflow on campaigns of the rig: what is hidden is found, and nothing else."""

from dataclasses import replace
from unittest.mock import Mock

import numpy as np
import pytest

import flexmodal
from flexmodal.campaign import Tolerance
from flexmodal.diagnosis import diagnose
from flexmodal.diagnosis.disagreement.compare import disagreement, force_dependence
from flexmodal.diagnosis.disagreement.gaps import over_noise
from flexmodal.diagnosis.effects import catalogue
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.outcome import Gaps, Step
from flexmodal.diagnosis.placed import Placed
from flexmodal.diagnosis.search.close_fit import NEAR, fitted_closely
from flexmodal.diagnosis.search.coarse import Candidate, look_at
from flexmodal.diagnosis.search.search import restarted, simpler
from flexmodal.diagnosis.search.set_out import SetOut
from flexmodal.diagnosis.selection.asked import asked_of
from flexmodal.diagnosis.selection.decision import SIGNIFICANT, Answer
from flexmodal.diagnosis.selection.frf_comparison import compare_models
from flexmodal.diagnosis.selection.frf_data import FrfData
from flexmodal.diagnosis.selection.frf_thresholds import FLOOR_REACHED
from flexmodal.diagnosis.selection.selection import ForwardSelection
from flexmodal.diagnosis.setup import prepare
from flexmodal.diagnosis.verdict.beyond import beyond_words
from flexmodal.diagnosis.verdict.facts import Facts
from flexmodal.diagnosis.verdict.verdict import verdict
from flexmodal.errors import InvalidRequest
from flexmodal.identification import RobotModel, observe, predict
from flexmodal.rig import Hide, simulate
from flexmodal.structure import robot_space

SMALL = {"postures": 4, "points": 4, "references": 2, "trials": 4, "record_length": 2.0, "band": (2.0, 150.0)}


def campaign(*hidden, seed=11, height=12.0, **more):
    hide = [replace(Hide.parse(one), height=height) for one in hidden]
    result = simulate(flexmodal.load("fanuc_s360"), hide=hide, seed=seed, **{**SMALL, **more})
    return result.campaign, result.robot


def laid_out(measured, robot, names):
    """What a diagnosis works with, of these effects alone."""
    return prepare(measured, robot, None, asked_of(names), None, 0, lambda doing, part: None)


@pytest.fixture(scope="module")
def clean():
    return campaign()


@pytest.fixture(scope="module")
def loaded():
    return campaign("added_mass@link_3")


def test_nothing_hidden_is_nothing_missing(clean):
    found = diagnose(*clean)
    assert found.verdict.effects == ()
    assert found.verdict.explained
    assert "Nothing is missing" in found.verdict.says
    assert found.gaps.after <= 1.2 * found.gaps.noise_floor


def test_a_hidden_mass_is_found_and_compared(loaded):
    found = diagnose(*loaded)
    assert found.verdict.effects == (("added_mass", "link_3"),)
    step = found.steps[0]
    assert step.gaps.after < 1.3 * step.gaps.noise_floor
    assert step.gaps.held_out_after < 0.8 * step.gaps.held_out_before
    assert any(one.effect == "none" for one in step.alternatives), "the robot re-tuned is always compared"
    assert step.confidence > 0.9
    known = sum(one.confidence for one in step.alternatives) + step.confidence
    assert 0.8 < known < 1, "the rest is for what was not considered"
    assert step.units["mass"] == "kg"
    assert 0 < step.uncertainty["mass"] < step.parameters["mass"]


@pytest.mark.slow
def test_a_wrong_effect_is_refused(loaded):
    found = diagnose(*loaded, effects=["time_delay"])
    assert found.steps == ()
    assert all(name != "time_delay" for name, _ in found.verdict.effects)


@pytest.mark.slow
def test_one_level_of_force_leaves_friction_untestable(clean):
    measured, robot = campaign(peaks=(100.0,), trials=2)
    found = diagnose(measured, robot, effects=["coulomb_friction", "sensor_gain"])
    assert "one level" in found.untestable["coulomb_friction"]
    assert "Of coulomb_friction these data cannot tell." in found.verdict.says
    assert found.verdict.effects == ()


@pytest.mark.parametrize(
    ("hidden", "answer"),
    [((), Answer.NO), (("joint_coupling@q1+q2",), Answer.YES)],
)
@pytest.mark.slow
def test_a_coupling_of_nothing_is_no_coupling(hidden, answer):
    """Its block could bring the card's damping back to what is believed, with nothing off its diagonal."""
    measured, robot = campaign(*hidden, points=3, trials=2)
    data = FrfData(laid_out(measured, robot, ["joint_coupling"]))
    hypothesis = data.root.hypothesis.and_also(Placed(catalogue()["joint_coupling"], "q1+q2"))
    begin = hypothesis.start(hypothesis.placed[-1], {"coupling": 0.15}, data.root.x)
    coupled = fitted_closely(data.setup, hypothesis, begin)
    assert data.worth(replace(data.root, prior=400.0), replace(coupled, prior=5.0), 0) is answer


def test_what_is_beyond_belief_is_told():
    space = robot_space(flexmodal.load("fanuc_s360"), trust={"damping": 0.1})
    x = np.zeros(len(space))
    assert beyond_words(space, x, len(x)) == ()
    x[space.index["damping.q2"]] = np.log(5.0)
    (said,) = beyond_words(space, x, len(x))
    assert "damping.q2 to 5 times the card's value, 16 standard deviations" in said
    assert beyond_words(space, x, space.index["damping.q2"]) == ()


def test_ties_are_said_in_words():
    ties = (("unstructured_mode", ""), ("none", ""), ("local_absorber", "link_2"))
    gaps = Gaps(0.2, 0.1, None, None, 0.1)
    step = Step("added_mass", "link_3", {}, {}, {}, 0.9, gaps, (), ties)
    facts = Facts((step,), {"added_mass": "a mass"}, gaps, 1.0, Answer.YES, {}, open_=False, place="link_3")
    says = verdict(facts).says
    assert "from a mode with no structure, nothing added, local_absorber at link_2." in says


@pytest.mark.slow
def test_one_posture_holds_nothing_out():
    measured, robot = campaign("sensor_gain@location_1", postures=1)
    found = diagnose(measured, robot, effects=["sensor_gain", "time_delay"])
    assert found.held_out == ()
    assert found.gaps.held_out_before is None
    assert found.verdict.effects == (("sensor_gain", "location_1"),)


@pytest.mark.slow
def test_friction_shows_in_the_levels_of_force(clean):
    assert force_dependence(observe(clean[0])) < 1.4
    rubbing, _ = campaign("coulomb_friction@q2", height=8.0)
    assert force_dependence(observe(rubbing)) > 3


def test_regions_name_what_a_gain_does(clean):
    measured, robot = clean
    observations = observe(measured)
    value = predict(RobotModel(robot, robot_space(robot)), np.zeros(len(robot_space(robot))), observations)
    with_force = replace(observations, value=value.copy(), variance=np.full(value.shape, 1e-6))
    with_force.value[with_force.response[:, 0] == with_force.response[0, 0]] *= 1.3
    regions = disagreement(with_force, value)
    assert {region.kind for region in regions} == {"level"}
    assert {region.response[0] for region in regions} == {int(with_force.response[0, 0])}
    assert sum(region.share for region in regions) == pytest.approx(1, abs=0.01)
    assert "1.3" in regions[0].says


def test_a_campaign_of_another_robot_is_refused(clean):
    with pytest.raises(InvalidRequest) as error:
        diagnose(clean[0], flexmodal.load("six_axis"))
    assert "link" in str(error.value)


def test_unknown_postures_are_named(clean):
    with pytest.raises(InvalidRequest, match="configuration_1"):
        diagnose(*clean, hold_out=["upside_down"])


@pytest.mark.slow
def test_a_mode_with_no_structure_is_always_compared(clean, loaded):
    nothing, mass = diagnose(*clean, effects=["sensor_gain"]), diagnose(*loaded, effects=["added_mass"])
    assert {one.effect for one in nothing.refused} >= {"none", "unstructured_mode", "sensor_gain"}
    compared = {one.effect: one for one in mass.steps[0].alternatives}
    assert compared["unstructured_mode"].parameters > 4
    assert compared["unstructured_mode"].evidence < -SIGNIFICANT


def test_parameters_beyond_belief_count_against_whoever_needs_them(loaded):
    """A heavy payload that a re-tuned mass could take up as well: nobody believes that mass."""
    setup = laid_out(*loaded, ["added_mass"])
    root = Hypothesis(setup.context, setup.base)
    here = fitted_closely(setup, root, np.zeros(len(setup.base)))
    far = replace(here, prior=here.prior + 2 * SIGNIFICANT + 1)
    comparison = compare_models([far, here], setup.observations)
    assert comparison.gain(1) > SIGNIFICANT
    assert here.prior == pytest.approx(float(np.sum(root.space.precision * here.fitted.x**2)))


@pytest.mark.slow
def test_started_from_everywhere_it_leaves_a_local_minimum():
    """A soft foundation: from a stiff tilt a fit ends beside the truth, from all starts it ends on it."""
    measured, robot = campaign("base_flexibility@base", seed=4)
    setup = laid_out(measured, robot, ["base_flexibility"])
    placed = Placed(setup.effects[0], "base")
    hypothesis = Hypothesis(setup.context, setup.base).and_also(placed)
    card = np.zeros(len(setup.base))
    lost = max(placed.effect.starts(setup.context, "base"), key=lambda one: one["tilt_stiffness"])
    stiff = {**lost, "horizontal_stiffness": lost["horizontal_stiffness"] * 100}
    seen = look_at(setup.fitted)
    beside = seen.fitted(Candidate(hypothesis, hypothesis.start(placed, stiff, card), np.inf), 0.1, 10)
    again = restarted(hypothesis, beside.x, SetOut([card]), seen)
    assert again.cost < 0.5 * beside.cost
    assert over_noise(setup, fitted_closely(setup, hypothesis, again.x, floors=NEAR)) < FLOOR_REACHED


@pytest.mark.slow
@pytest.mark.parametrize("last", ["local_absorber@link_1", "added_mass@link_3"])
def test_an_effect_that_nobody_misses_goes_whether_found_first_or_last(loaded, last):
    setup = prepare(
        *loaded, None, asked_of(["added_mass", "local_absorber"]), None, 0, lambda doing, part: None
    )
    selection = ForwardSelection(FrfData(setup))
    names = sorted(["local_absorber@link_1", "added_mass@link_3"], key=lambda name: name == last)
    effects = {effect.name: effect for effect in setup.effects}
    hypothesis, start = selection.root.hypothesis, np.zeros(len(setup.base))
    for name in names:
        effect, where = name.split("@")
        placed = Placed(effects[effect], where)
        hypothesis = hypothesis.and_also(placed)
        start = hypothesis.start(placed, placed.effect.starts(setup.context, where)[0], start)
        selection.steps.append(Step(effect, where, {}, {}, {}, 0.5, Mock(spec=Gaps), ()))
    selection.current = fitted_closely(setup, hypothesis, start)
    selection.drop_needless()
    assert [(step.effect, step.where) for step in selection.steps] == [("added_mass", "link_3")]
    assert selection.current.hypothesis.keys == (("added_mass", "link_3"),)
    assert over_noise(setup, selection.current) < FLOOR_REACHED


@pytest.fixture(scope="module")
def two():
    return campaign("local_absorber@link_2", "sensor_gain@location_3", seed=5)


@pytest.mark.slow
def test_the_first_of_two_effects_is_looked_for_again_beside_the_second(two):
    """Alone it may have been put in the wrong place."""
    names = ["local_absorber", "sensor_gain"]
    setup = laid_out(*two, names)
    selection = ForwardSelection(FrfData(setup))
    absorber, gain = (next(one for one in setup.effects if one.name == name) for name in names)
    wrong, second = Placed(absorber, "link_1"), Placed(gain, "location_3")
    beside = selection.root.hypothesis.and_also(wrong)
    x = beside.start(wrong, absorber.starts(setup.context, "link_1")[0], np.zeros(len(setup.base)))
    pair = beside.and_also(second)
    selection.current = fitted_closely(setup, pair, pair.start(second, {"gain": 1.1}, x))
    assert over_noise(setup, selection.current) > FLOOR_REACHED
    selection.exchange(selection.current)
    assert {(step.effect, step.where) for step in selection.steps} == {
        ("sensor_gain", "location_3"), ("local_absorber", "link_2"),
    }  # fmt: skip
    assert over_noise(setup, selection.current) < FLOOR_REACHED


@pytest.mark.slow
def test_an_exchange_that_does_not_help_is_taken_back(loaded):
    setup = laid_out(*loaded, ["sensor_gain"])
    selection = ForwardSelection(FrfData(setup))
    hypothesis, x = selection.root.hypothesis, np.zeros(len(setup.base))
    for where in setup.context.sensors[:2]:
        placed = Placed(setup.effects[0], where)
        hypothesis = hypothesis.and_also(placed)
        x = hypothesis.start(placed, {"gain": 1.1}, x)
    selection.current = was = fitted_closely(setup, hypothesis, x)
    selection.exchange(was)
    assert selection.current is was
    assert selection.steps == []


@pytest.mark.slow
def test_an_absorber_too_stiff_to_be_told_from_a_mass_is_a_mass(loaded):
    """Its rigid limit is looked at from where the fit of the absorber ended."""
    setup = prepare(
        *loaded, None, asked_of(["added_mass", "local_absorber"]), None, 0, lambda doing, part: None
    )
    absorber = next(one for one in setup.effects if one.name == "local_absorber")
    placed = Placed(absorber, "link_3")
    hypothesis = Hypothesis(setup.context, setup.base).and_also(placed)
    start = {"frequency": 1.4 * setup.context.band[1], "along": 0.6}
    at = fitted_closely(setup, hypothesis, hypothesis.start(placed, start, np.zeros(len(setup.base))))
    (less,) = simpler(hypothesis, at.fitted.x, setup.effects, look_at(setup.fitted))
    assert less.key == ("added_mass", "link_3")
    assert over_noise(setup, fitted_closely(setup, less.hypothesis, less.x, floors=NEAR)) < FLOOR_REACHED
    assert not simpler(less.hypothesis, less.x, setup.effects, look_at(setup.fitted))
    assert not simpler(hypothesis, at.fitted.x, [absorber], look_at(setup.fitted))


def test_an_effect_can_be_asked_for_by_its_place(loaded):
    setup = laid_out(*loaded, ["added_mass@link_3", "sensor_gain"])
    mass, gain = setup.effects
    assert mass.places(setup.context) == ("link_3",)
    assert gain.places(setup.context) == setup.context.sensors
    assert setup.asked == {"added_mass": ("link_3",), "sensor_gain": ()}
    with pytest.raises(InvalidRequest, match="added_mass@link_9"):
        laid_out(*loaded, ["added_mass@link_9"])


@pytest.mark.slow
def test_what_lies_within_tolerance_is_no_effect():
    """Angles and places a little off look like something missing, until the campaign says how far off."""
    measured, robot = campaign(seed=31, postures=5, trials=2)
    random = np.random.default_rng(31)
    postures = tuple(
        replace(one, q={name: value + random.normal(0, 0.01) for name, value in one.q.items()})
        for one in measured.postures
    )
    points = tuple(
        replace(one, xyz=tuple(float(x + random.normal(0, 0.004)) for x in one.xyz))
        for one in measured.points
    )
    off = replace(measured, postures=postures, points=points)
    assert diagnose(off, robot).verdict.effects
    told = diagnose(replace(off, tolerance=Tolerance(posture=0.01, position=0.005)), robot)
    assert told.verdict.effects == ()
    assert told.verdict.explained
