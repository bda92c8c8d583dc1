"""From a campaign to parameters: truth found, gaps told, what does not belong refused."""

from dataclasses import replace

import numpy as np
import pytest

import flexmodal
from flexmodal.campaign import COHERENT, noise_floor
from flexmodal.errors import InvalidRequest
from flexmodal.identification import build_identification, identify, observe
from flexmodal.identification.as_json import as_json
from flexmodal.identification.page import estimate_cells
from flexmodal.identification.signal import COHERENT_SHARE, roughness
from flexmodal.rig import simulate
from flexmodal.structure import robot_space


@pytest.fixture(scope="module")
def outcome(campaign, fanuc):
    return identify(campaign, fanuc)


def score(outcome, factors):
    """Errors over standard errors."""
    truth = np.array([np.log(factors[name]) for name in outcome.problem.space.names])
    return (outcome.at - truth) / outcome.uncertainty.deviation


def test_it_finds_the_truth(outcome, rig):
    assert np.abs(score(outcome, rig.truth.factors)).max() < 5  # sixteen of them, few degrees of freedom
    for one in outcome.estimates:
        assert one.interval[0] < one.value < one.interval[1]
        if one.name.startswith("stiffness"):
            assert one.value == pytest.approx(one.card * rig.truth.factors[one.name], rel=0.01)


def test_gaps_are_told_fitted_and_held_out(outcome, campaign):
    gap = outcome.gap
    assert gap.after < 1.3 * gap.noise_floor < gap.before
    assert gap.held_out_after < 1.6 * gap.noise_floor
    assert gap.held_out_before == pytest.approx(gap.before)
    names = {(one.kind, one.name) for one in outcome.held_out}
    assert names == {("posture", p.name) for p in campaign.postures} | {
        ("point", p.name) for p in campaign.points
    }
    assert all(one.after < one.before for one in outcome.held_out if one.kind == "posture")
    assert outcome.explained
    assert "× the noise" in outcome.verdict


def test_folds_are_predicted_as_by_fits_of_their_own(outcome):
    """From downdated normal equations and from the fit to all, to the end: gaps agree to 1 %."""
    evidence = outcome.problem.evidence
    folds = evidence.folds()
    for held in outcome.held_out[:3]:
        fold = folds[held.kind, held.name]
        slow = evidence.keeping(~fold).fit(outcome.at, warm=True).x
        part = evidence.keeping(fold)
        assert held.after == pytest.approx(part.gap(part.predicted(slow)).value, rel=0.01)


def test_the_noise_floor_is_that_of_the_campaign(campaign, fanuc):
    """Of all records together, but for those without a signal in them, which the fit leaves out."""
    evidence = build_identification(campaign, fanuc).evidence
    seen = evidence.observations
    frfs = campaign.frfs
    keep = (frfs.frequency >= campaign.band[0]) & (frfs.frequency <= campaign.band[1])
    inside = replace(
        frfs, frequency=frfs.frequency[keep], value=frfs.value[:, keep], coherence=frfs.coherence[:, keep]
    )
    heard = inside.take(np.flatnonzero(np.mean(inside.coherence >= COHERENT, axis=1) >= COHERENT_SHARE))
    assert len(heard) == len(seen.records)
    floor = noise_floor(heard, campaign.band)
    assert evidence.gap(seen.value).noise_floor == pytest.approx(floor, rel=1e-9)
    perfect = evidence.gap(seen.value).value
    assert 0 < perfect < floor * 1.1  # the mean of the repeats is closer than the truth


def test_what_is_named_is_never_fitted(campaign, fanuc):
    name = campaign.postures[1].name
    spoilt = campaign.frfs.value.copy()
    rows = campaign.frfs.posture == campaign.postures[1].id
    spoilt[rows] *= 3.0
    outcome = identify(replace(campaign, frfs=replace(campaign.frfs, value=spoilt)), fanuc, hold_out=[name])
    assert outcome.gap.after < 1.3 * outcome.gap.noise_floor  # untouched by what was spoilt
    assert outcome.gap.held_out_after == pytest.approx(np.log(3), rel=0.05)
    assert [one.name for one in outcome.held_out] == [name]
    assert "does not carry over" in outcome.verdict


def test_a_point_can_be_held_out(campaign, fanuc):
    outcome = identify(campaign, fanuc, hold_out=[campaign.points[0].name])
    assert [(one.kind, one.name) for one in outcome.held_out] == [("point", campaign.points[0].name)]
    assert outcome.gap.held_out_after < outcome.gap.held_out_before


def test_provenance_says_what_was_done(outcome, campaign, fanuc):
    told = outcome.provenance
    assert (told["campaign"], told["robot"], told["source"]) == (campaign.title, fanuc.name, "frf")
    assert told["numbers"] == outcome.problem.evidence.count


def test_the_outcome_is_frozen(outcome):
    with pytest.raises(AttributeError):
        outcome.gap = None


def test_a_parameter_at_its_bound_is_flagged(campaign, fanuc):
    space = robot_space(fanuc)
    tight = [
        replace(p, upper=p.card * 1.0001, lower=p.card * 0.9999) if p.name == "stiffness.q2" else p
        for p in space
    ]
    outcome = identify(campaign, fanuc, space=type(space)(tuple(tight)))
    assert outcome.at_bound == ("stiffness.q2",)
    assert "at a bound: stiffness.q2" in outcome.verdict
    (held,) = (one for one in outcome.estimates if one.at_bound)
    assert np.isnan([held.standard_error, *held.interval]).all()  # a bound has no ±
    assert estimate_cells(held)[2:4] == ("–", "–")
    assert as_json(outcome)["parameters"]["stiffness.q2"]["interval"] is None


def test_where_the_model_is_wrong_no_intervals_are_given(campaign, fanuc, outcome):
    """One point's records tenfold: at many times the noise, and none for the fit that meets the data."""
    frfs = campaign.frfs
    rows = frfs.response[:, 0] == campaign.points[0].id
    value = np.where(rows[:, None], 10 * frfs.value, frfs.value)
    wrong = identify(replace(campaign, frfs=replace(frfs, value=value)), fanuc)
    assert not wrong.explained
    assert wrong.withheld
    assert "no intervals are given" in wrong.verdict
    assert all(np.isnan(one.standard_error) for one in wrong.estimates)
    assert {estimate_cells(one)[3] for one in wrong.estimates} == {"–"}
    assert all(one["interval"] is None for one in as_json(wrong)["parameters"].values())
    assert not outcome.withheld


def test_outliers_do_not_carry_the_fit_away(campaign, fanuc, rig):
    random = np.random.default_rng(0)
    value = campaign.frfs.value.copy()
    hit = random.random(value.shape) < 0.01
    value[hit] *= np.exp(random.normal(0, 3, hit.sum()))
    spoilt = replace(campaign, frfs=replace(campaign.frfs, value=value))
    # The variance from repeats notices most of them; from coherence it would not.
    calm = build_identification(campaign, fanuc).evidence.observations
    problem = build_identification(spoilt, fanuc)
    evidence = replace(
        problem.evidence,
        observations=replace(problem.evidence.observations, variance=calm.variance, used=calm.used),
    )
    found = evidence.fit()
    truth = np.array([np.log(rig.truth.factors[n]) for n in problem.space.names])
    stiff = [k for k, n in enumerate(problem.space.names) if n.startswith("stiffness")]
    assert np.abs(found.x - truth)[stiff].max() < 0.02


def test_configuration_4_works_like_any_other(fanuc):
    """Its first link stands along the measured axis: the thesis's matrix has no inverse there. The point at
    the end of that link stands still in the model; what the sensor hears there is not taken for motion."""
    made = simulate(
        fanuc, postures=["configuration_4", "configuration_6"], points=3, trials=2, peaks=(100.0,), seed=3
    )
    outcome = identify(replace(made.campaign, blows=()), fanuc)
    assert outcome.over_noise < 1.2
    assert outcome.explained
    one = next(one for one in outcome.held_out if one.name == "configuration_4")
    assert one.after < one.before
    assert np.abs(score(outcome, made.truth.factors)).max() < 5


# what is refused


def refused(campaign, robot, **options):
    with pytest.raises(InvalidRequest) as error:
        identify(campaign, robot, **options)
    return [str(fault) for fault in error.value.faults]


def test_a_campaign_of_another_robot_is_refused_with_every_fault(campaign, fanuc):
    turned = replace(campaign.postures[0], q={"q1": 99.0, "shoulder": 0.1})
    lost = replace(campaign.points[0], link="hand")
    faults = refused(
        replace(campaign, postures=(turned, *campaign.postures[1:]), points=(lost, *campaign.points[1:])),
        fanuc,
    )
    text = "\n".join(faults)
    assert "unknown joint 'shoulder'" in text
    assert "the joint's limits" in text
    assert "unknown link 'hand'" in text
    assert len(faults) == 3


def test_a_point_that_no_joint_moves_is_refused(campaign, fanuc):
    still = replace(campaign.points[0], link=fanuc.urdf.root)
    assert "no flexible joint" in refused(replace(campaign, points=(still, *campaign.points[1:])), fanuc)[0]


def test_the_six_link_arm_does_not_take_a_fanuc_campaign(campaign):
    assert refused(campaign, flexmodal.load("six_link"))


def as_noise(campaign, **change):
    random = np.random.default_rng(1)
    shape = campaign.frfs.value.shape
    noise = (random.normal(size=shape) + 1j * random.normal(size=shape)) * 1e-2
    return replace(campaign, frfs=replace(campaign.frfs, value=noise, **change))


@pytest.mark.parametrize("source", ["frf", "modes"])
def test_noise_alone_gives_no_number(campaign, fanuc, source):
    """Even where repeats or coherence claim that it is none."""
    shape = campaign.frfs.value.shape
    for coherence in (None, np.ones(shape), np.full(shape, 0.95)):
        faults = refused(as_noise(campaign, coherence=coherence), fanuc, source=source)
        assert "nothing but noise" in faults[0]
    dull = replace(campaign.frfs, coherence=np.full(shape, 0.3))
    assert "coherence below 0.8" in refused(replace(campaign, frfs=dull), fanuc, source=source)[0]
    mute = replace(campaign.frfs, value=np.zeros(shape, complex))
    assert "zero throughout" in refused(replace(campaign, frfs=mute), fanuc, source=source)[0]


def test_what_is_zero_but_for_rounding_is_no_measurement(campaign, fanuc):
    frfs = campaign.frfs
    place = (frfs.response[0].tolist(), frfs.reference[0].tolist())
    rows = [k for k in range(len(frfs)) if (frfs.response[k].tolist(), frfs.reference[k].tolist()) == place]
    value = frfs.value.copy()
    value[rows] *= 1e-14
    seen = observe(replace(campaign, frfs=replace(frfs, value=value)))
    assert len(seen.silent) == len(observe(campaign).silent) + len(rows)
    assert all(str(place[0]) in one and str(place[1]) in one for one in seen.silent)


def test_roughness_tells_noise_from_a_response(campaign):
    assert roughness(as_noise(campaign).frfs) == pytest.approx(3 * (1 - np.sqrt(0.5)), abs=0.12)
    assert np.median(roughness(campaign.frfs)) < 0.01


def test_noisy_lines_alone_give_no_number(campaign, fanuc):
    """Smooth enough to be a response, but the repeats do not agree."""
    random = np.random.default_rng(1)
    frfs = campaign.frfs
    value = frfs.value * np.exp(random.normal(0, 2, len(frfs)) + 6j * random.random(len(frfs)))[:, None]
    faults = refused(replace(campaign, frfs=replace(frfs, value=value, coherence=None)), fanuc)
    assert "of the lines above the noise" in faults[0]


def test_records_that_say_nothing_of_their_noise_are_judged_by_their_lines(campaign, fanuc, outcome):
    """One trial without coherence: the noise is that of neighbouring lines, within a factor of the
    repeats'."""
    alone = campaign.frfs.select(trial=int(campaign.frfs.trial[0]))
    bare = replace(campaign, frfs=replace(alone, coherence=None), blows=())
    problem = build_identification(bare, fanuc)
    assert any("neighbouring lines disagree" in warning for warning in problem.warnings)
    assert outcome.problem.warnings == ()
    there = observe(replace(campaign, frfs=alone, blows=()))
    seen = observe(bare, bare=True)
    ratio = np.median(seen.variance[there.used] / there.variance[there.used])
    assert 0.4 < ratio < 2.5  # three averages tell a variance to half of itself
    found = identify(bare, fanuc)
    assert found.over_noise < 1.6
    with pytest.raises(InvalidRequest, match="nothing that says how noisy it is"):
        observe(bare)


def test_one_posture_is_said_to_be_one(campaign, fanuc):
    one = campaign.frfs.select(posture=campaign.postures[0].id)
    outcome = identify(replace(campaign, frfs=one), fanuc)
    assert "one posture was measured" in outcome.verdict
    assert {held.kind for held in outcome.held_out} == {"point"}


def test_fewer_data_than_parameters_give_no_number(campaign, fanuc):
    frfs = campaign.frfs
    few = replace(
        frfs, frequency=frfs.frequency[40:42], value=frfs.value[:, 40:42], coherence=frfs.coherence[:, 40:42]
    )
    one = few.select(posture=campaign.postures[0].id, response=1, reference=(1, 3))
    faults = refused(replace(campaign, frfs=one), fanuc)
    assert "4 usable values in FRFs for 16 parameters" in faults[0]


def test_names_to_hold_out_have_to_exist(campaign, fanuc):
    assert "configuration_1" in refused(campaign, fanuc, hold_out=["configuration_11"])[0]
    every = [posture.name for posture in campaign.postures]
    assert "every posture" in refused(campaign, fanuc, hold_out=every)[0]


def test_kinds_and_uses_have_to_exist(campaign, fanuc):
    assert "'colour'" in refused(campaign, fanuc, source="modes", use=["colour"])[0]
    assert "while FRFs are fitted" in refused(campaign, fanuc, use=["frequency"])[0]
    assert "payload" in refused(campaign, fanuc, trust={"payload": 0.1})[0]
    assert "0" in refused(campaign, fanuc, starts=0)[0]


def test_nothing_measured_is_refused(campaign, fanuc):
    assert "no FRFs and no blows" in refused(replace(campaign, frfs=None), fanuc, source="frf")[0]
    assert "neither FRFs nor blows" in refused(replace(campaign, frfs=None), fanuc)[0]
