"""FRFs and modes of one campaign together: sums add, and what both tell is told better."""

from dataclasses import replace

import numpy as np
import pytest

from flexmodal.campaign import ModeTable, read_campaign, write_campaign
from flexmodal.errors import InvalidCampaign
from flexmodal.identification import RobotModel, build_identification, identify
from flexmodal.identification.evidence.both import Both
from flexmodal.identification.page import write_identification_page
from flexmodal.identification.spot import places_of
from flexmodal.structure import robot_space
from flexmodal.structure.poles import poles

PLACES, STRUCK = [(1, 3), (2, 3), (3, 3)], (1, 3)
FREQUENCY, DAMPING = 0.002, 0.03
"""Scatter of a second test, in which modes alone were found [relative]."""


@pytest.fixture(scope="module")
def tested_twice(campaign, rig, fanuc):
    """The FRFs of the rig, and modes of the same robot from another test."""
    random, rows = np.random.default_rng(8), []
    space = robot_space(fanuc)
    x = np.array([np.log(rig.truth.factors[name]) for name in space.names])
    for posture in campaign.postures:
        one = RobotModel(fanuc, space).structure_at(
            x, posture.q, places_of(campaign, PLACES), places_of(campaign, [STRUCK])
        )
        found = poles(one)
        for k in range(found.count):
            middle, ratio = found.frequency[k], found.damping_ratio[k]
            for point, _ in PLACES:
                f = middle * np.exp(FREQUENCY * random.normal())
                z = ratio * np.exp(DAMPING * random.normal())
                rows.append((posture.id, point, STRUCK[0], k + 1, f, z))
    columns = list(zip(*rows, strict=True))
    table = ModeTable(
        *(np.array(column, dtype=int) for column in columns[:4]), np.array(columns[4]), np.array(columns[5]),
        np.full(len(rows), np.nan, dtype=complex), ("",) * len(rows),
    )  # fmt: skip
    return replace(campaign, modes=table)


@pytest.fixture(scope="module")
def problem(tested_twice, fanuc):
    return build_identification(tested_twice, fanuc)


def test_both_are_taken_where_both_were_measured(problem, campaign, fanuc):
    assert isinstance(problem.evidence, Both)
    assert problem.source == "both"
    assert problem.what == "the FRFs and the natural frequencies and damping ratios"
    assert build_identification(campaign, fanuc).source == "frf"


def test_sums_of_squares_add_and_the_prior_counts_once(problem):
    both = problem.evidence
    x = np.random.default_rng(1).normal(0, 0.03, len(problem.space))
    for floor in both.floors():
        whole = both.misfit(x, floor)
        total = whole.equations(x, apart=True)
        parts = [part.equations(x, apart=True) for part in whole.parts]
        prior = float(np.sum(problem.space.precision * x**2))
        assert total.cost == pytest.approx(sum(one.data_cost for one in parts) + prior)
        assert whole.cost(x) == pytest.approx(total.cost)
        np.testing.assert_allclose(total.curvature, parts[0].curvature + parts[1].curvature)
        np.testing.assert_allclose(
            total.gradient, total.scores.sum(axis=0) + problem.space.precision * x, rtol=1e-9, atol=1e-6
        )


@pytest.mark.slow
def test_together_they_tell_more_than_each_alone(problem, tested_twice, fanuc, rig, tmp_path):
    expected = problem.identifiability.expected
    for source in ("frf", "modes"):
        alone = build_identification(tested_twice, fanuc, source=source).identifiability.expected
        assert max(expected[name] / alone[name] for name in expected) < 1 + 1e-6
    outcome = identify(tested_twice, fanuc)
    truth = np.array([np.log(rig.truth.factors[name]) for name in problem.space.names])
    assert np.abs((outcome.at - truth) / outcome.uncertainty.deviation).max() < 4
    assert outcome.fitted.converged
    assert outcome.explained
    assert outcome.gap.held_out_after < outcome.gap.held_out_before
    assert {one.kind for one in outcome.held_out} == {"posture", "point"}
    write_identification_page(outcome, tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert (
        page.index("Measured and modelled") < page.index("Errors of the modes") < page.index("Gaps of what")
    )


def test_a_posture_that_is_held_out_loses_its_frfs_and_its_modes(tested_twice, fanuc):
    name = tested_twice.postures[1].name
    held = build_identification(tested_twice, fanuc, hold_out=[name])
    frfs, modes = held.evidence.parts
    assert not np.any(frfs.observations.posture == 1)
    assert all(mode.posture != 1 for mode in modes.observations.modes)
    assert len(modes.observations.modes) == 8


def test_data_that_may_count_twice_are_warned_of_unless_somebody_chose_or_says_they_are_apart(
    tested_twice, fanuc
):
    (warning,) = build_identification(tested_twice, fanuc).warnings
    for word in ("count twice", "--from frf", "separate_modes = true"):
        assert word in warning
    assert build_identification(tested_twice, fanuc, source="both").warnings == ()
    assert build_identification(tested_twice, fanuc, source="modes").warnings == ()
    assert build_identification(replace(tested_twice, separate_modes=True), fanuc).warnings == ()
    assert build_identification(replace(tested_twice, modes=None), fanuc).warnings == ()


def test_that_modes_were_measured_apart_is_kept_in_the_campaigns_folder(tested_twice, tmp_path):
    folder = write_campaign(replace(tested_twice, modes=None, separate_modes=True), tmp_path / "apart")
    assert "separate_modes = true" in (folder / "campaign.toml").read_text(encoding="utf-8")
    assert read_campaign(folder).separate_modes
    text = (folder / "campaign.toml").read_text(encoding="utf-8")
    (folder / "campaign.toml").write_text(text.replace("= true", '= "yes"'), encoding="utf-8")
    with pytest.raises(InvalidCampaign, match=r"separate_modes.*true or false"):
        read_campaign(folder)
