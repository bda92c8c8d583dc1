"""Parameters from modes: derivatives, pairing, agreement with the FRF evidence, zeros."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import flexmodal
from flexmodal.campaign import read_campaign
from flexmodal.identification import Identifiability, RobotModel, build_identification, identify
from flexmodal.identification.evidence.antiresonance import nearest_dip
from flexmodal.identification.evidence.measured_modes import (
    Antiresonance,
    MeasuredMode,
    MeasuredShape,
    ModeObservations,
)
from flexmodal.identification.evidence.modal import ModalEvidence
from flexmodal.identification.evidence.mode_sources import modes_of_table
from flexmodal.identification.spot import places_of
from flexmodal.structure import robot_space
from flexmodal.structure.poles import poles
from flexmodal.structure.structure import Axis, receptance

ROOT = Path(__file__).parents[2]

DIP = 83.0
"""Where the drive point has an antiresonance in these postures, within 15 % [Hz]."""
EVERYTHING = ("frequency", "damping", "shape", "residue", "antiresonance")


@pytest.fixture(scope="module")
def made(campaign, fanuc):
    """Modes and one antiresonance of a robot off its card, without noise."""
    space = robot_space(fanuc)
    model = RobotModel(fanuc, space)
    x = np.random.default_rng(5).normal(0, 0.05, len(space))
    places, struck = [(1, 3), (2, 3), (3, 3)], (1, 3)
    modes, dips = [], []
    for number, posture in enumerate(campaign.postures):
        one = model.structure_at(x, posture.q, places_of(campaign, places), places_of(campaign, [struck]))
        found = poles(one)
        for k in range(found.count):
            residue = (one.response @ found.shape[:, k]) * (one.reference[0] @ found.shape[:, k])
            shape = MeasuredShape(struck, np.array(places), residue, np.full(3, 0.01))
            modes.append(
                MeasuredMode(number, k + 1, found.frequency[k], 1e-3, found.damping_ratio[k], 1e-2, (shape,))
            )
        dip, _ = nearest_dip(one, Axis(np.zeros(1), 10.0), (0, 0), DIP)
        dips.append(Antiresonance(number, (1, 3), struck, float(dip), 1e-3))
    return space, model, x, ModeObservations(campaign, campaign.postures, tuple(modes), tuple(dips))


def test_residuals_vanish_at_the_truth(made):
    _, model, x, observed = made
    misfit = ModalEvidence(model, observed, EVERYTHING).misfit(x, 0.01)
    assert misfit.pairs == (0, 1, 2, 3) * 3
    found = misfit.residuals(x, slopes=False)
    # each mode has a frequency, a damping ratio, a shape and a residue at three places, as real numbers
    assert len(found.away) == len(observed.modes) * (2 + 6 + 6) + len(observed.antiresonances)
    assert np.abs(found.away).max() < 1e-7  # a minimum is placed to 1e-8


def test_the_gradient_is_that_of_central_differences(made):
    space, model, x, observed = made
    away = x + np.random.default_rng(6).normal(0, 0.01, len(space))
    misfit = ModalEvidence(model, observed, EVERYTHING).misfit(away, 0.01)
    normal = misfit.equations(away, apart=True)
    np.testing.assert_allclose(normal.blocks.sum(axis=0), normal.curvature, rtol=1e-9, atol=1e-6)
    step = 1e-6
    for k in range(len(space)):
        shift = step * np.eye(len(space))[k]
        numeric = (misfit.cost(away + shift) - misfit.cost(away - shift)) / (4 * step)
        # the gradient is that of half the cost; rounding of the cost 1e-13 over 1e-6
        assert normal.gradient[k] == pytest.approx(numeric, abs=2e-5 * np.abs(normal.gradient).max()), (
            space.names[k]
        )


def test_perfect_modes_give_the_truth_back(made, campaign, fanuc):
    space, _, x, observed = made

    loose = space.trusting({name: 2.0 for name in space.names})
    evidence = ModalEvidence(RobotModel(fanuc, loose), observed, EVERYTHING)
    fitted = evidence.fit()
    deviation = evidence.uncertainty(fitted).deviation
    known = deviation < 0.5
    assert known.sum() >= 12
    # the data are exact: what is left is the draw of the priors, much less than the standard error
    assert np.abs((fitted.x - x) / deviation)[known].max() < 0.5


def test_dips_are_dips_and_their_derivatives_are_right(made, campaign):
    space, model, x, _ = made
    q, places = campaign.postures[1].q, places_of(campaign, [(1, 3), (2, 3)])
    axis = Axis(np.zeros(1), 10.0)

    def dip(x, names=()):
        return nearest_dip(model.structure_at(x, q, places, places), axis, (0, 0), DIP, names)

    place, slope = dip(x, space.names)
    lines = place * (1 + np.array([-1e-3, 0.0, 1e-3]))
    level = np.abs(
        receptance(
            model.structure_at(x, q, places, places), replace(axis, frequency=lines), np.array([[0, 0]])
        )[0][0]
    )
    assert level[1] < level[0]
    assert level[1] < level[2]
    for k in range(0, len(space), 2):
        shift = 1e-3 * np.eye(len(space))[k]
        numeric = (dip(x + shift)[0] - dip(x - shift)[0]) / 2e-3
        # the minimum is placed to some 1e-7 of itself, a thousandth beside it
        assert slope[k] == pytest.approx(numeric, abs=2e-3 * np.abs(slope).max()), space.names[k]
    assert nearest_dip(model.structure_at(x, q, places, places), axis, (0, 0), 1e4) is None


def test_both_routes_agree_within_their_intervals(campaign, fanuc, rig):
    by_lines = identify(campaign, fanuc)
    by_modes = identify(campaign, fanuc, source="modes")
    apart = by_lines.at - by_modes.at
    reach = 2.5 * np.hypot(by_lines.uncertainty.deviation, by_modes.uncertainty.deviation)
    assert np.all(np.abs(apart) < reach), dict(zip(by_lines.problem.space.names, apart / reach, strict=True))
    assert by_modes.gap.after < by_modes.gap.before
    truth = np.array([np.log(rig.truth.factors[n]) for n in by_modes.problem.space.names])
    assert np.abs((by_modes.at - truth) / by_modes.uncertainty.deviation).max() < 4


@pytest.mark.slow
def test_antiresonances_tell_what_frequencies_do_not(campaign, fanuc, rig):
    use = ["frequency", "antiresonance"]
    problem = build_identification(campaign, fanuc, source="modes", use=use)
    assert len(problem.evidence.observations.antiresonances) >= 6
    outcome = identify(campaign, fanuc, source="modes", use=use)
    x, deviation = outcome.at, outcome.uncertainty.deviation
    truth = np.array([np.log(rig.truth.factors[name]) for name in problem.space.names])
    assert np.abs((x - truth) / deviation).max() < 4
    without = Identifiability(problem.space, _frequencies_only(problem).information())
    gained = {
        name: problem.identifiability.expected[name] / without.expected[name] for name in without.expected
    }
    assert max(gained.values()) < 1.001  # more data never tell less
    assert min(gained.values()) < 0.5


def _frequencies_only(problem):
    return replace(problem.evidence, use=("frequency",))


def test_the_table_of_the_thesis_is_read_with_its_doubts():
    campaign = read_campaign(ROOT / "robots/fanuc_s360/campaigns/thesis")
    observed = modes_of_table(campaign)
    first = next(mode for mode in observed.modes if (mode.posture, mode.number) == (0, 1))
    assert first.frequency == pytest.approx(7.45)  # 7.4 7.5 7.4 7.5 7.4 7.5
    assert 0.0 < first.frequency_error < 0.01
    assert 2 not in first.shapes[0].places[:, 0]  # exponent doubtful
    assert 5 not in first.shapes[0].places[:, 0]
    assert len(first.shapes[0].places) == 4
    assert [posture.id for posture in observed.postures] == [1, 2, 6, 7]


def test_a_mode_that_the_model_lacks_stays_single(fanuc):
    campaign = read_campaign(ROOT / "robots/fanuc_s360/campaigns/thesis")
    problem = build_identification(campaign, fanuc, use=["frequency", "damping"])
    pairs = problem.evidence.pairs(np.zeros(len(problem.space)))
    single = [m for m, p in zip(problem.evidence.observations.modes, pairs, strict=True) if p < 0]
    assert {round(mode.frequency) for mode in single} <= {37, 38, 39}
    assert len(single) == 3


def test_fewer_modes_than_parameters_are_refused(fanuc):
    campaign = read_campaign(ROOT / "robots/fanuc_s360/campaigns/thesis")
    few = replace(campaign, modes=_only(campaign.modes, 1))
    with pytest.raises(
        flexmodal.errors.InvalidRequest, match=r"4 numbers .frequency. of modes for 16 parameters"
    ):
        identify(few, fanuc, use=["frequency"])


def _only(table, posture):
    keep = np.flatnonzero(table.posture == posture)
    fields = ("posture", "response", "reference", "mode", "natural_frequency", "damping_ratio", "amplitude")
    return replace(
        table,
        **{name: getattr(table, name)[keep] for name in fields},
        flag=tuple(table.flag[k] for k in keep),
    )
