"""Where model and measurement disagree is told by kind: a model changed on purpose, beside itself."""

from dataclasses import replace

import numpy as np
import pytest

from flexmodal.diagnosis.disagreement.compare import (
    FEWEST_PAIRS,
    but_for_the_blow,
    disagreement,
    force_dependence,
)
from flexmodal.diagnosis.effects import catalogue
from flexmodal.diagnosis.placed import Placed
from flexmodal.identification import predict


@pytest.fixture(scope="module")
def exact(observed, hinged):
    """Observations that the fitted model meets exactly, and that model."""
    _, _, hypothesis, made = hinged
    value = predict(hypothesis, made.x, observed)
    observations = replace(observed, value=value, used=np.ones(value.shape, dtype=bool))
    return observations, hypothesis, made.x


def changed(exact, values):
    """What the model predicts with some parameters multiplied."""
    observations, hypothesis, x = exact
    names = list(hypothesis.space.names)
    moved = x.copy()
    for name, factor in values.items():
        moved[names.index(name)] += np.log(factor)
    return predict(hypothesis, moved, observations)


def test_a_model_that_is_right_disagrees_nowhere(exact):
    observations, _, _ = exact
    assert disagreement(observations, observations.value) == ()


def test_a_factor_is_a_level(exact):
    observations, _, _ = exact
    regions = disagreement(observations, 1.3 * observations.value)
    assert {region.kind for region in regions} == {"level"}
    assert "0.769" in regions[0].says
    assert 0.95 < sum(region.share for region in regions) < 1 + 1e-9  # twelve regions are listed


def test_a_delay_is_a_phase_slope(exact):
    observations, _, _ = exact
    late = np.exp(-2j * np.pi * observations.axis.frequency * 8e-4)
    regions = disagreement(replace(observations, value=observations.value * late), observations.value)
    assert {region.kind for region in regions} == {"phase slope"}
    assert "0.8 ms" in regions[0].says


def test_a_stiffer_joint_shifts_resonances(exact):
    observations, _, _ = exact
    kinds = {region.kind for region in disagreement(observations, changed(exact, {"stiffness.q2": 1.08}))}
    assert "shifted resonance" in kinds
    assert not {"missing resonance", "extra resonance"} & kinds


@pytest.mark.parametrize(("factor", "kind"), [(1.6, "too much damping"), (0.6, "too little damping")])
def test_a_peak_that_is_lower_is_damping(exact, factor, kind):
    observations, _, _ = exact
    regions = disagreement(observations, changed(exact, {"damping.q2": factor}))
    assert regions[0].kind == kind
    ratio = float(regions[0].says.split("its peak is ")[1].split(" ")[0])
    assert ratio == pytest.approx(1 / factor, rel=0.15)


def test_no_peak_that_is_as_high_is_called_damped(exact):
    observations, _, _ = exact
    for predicted in (changed(exact, {"stiffness.q2": 1.003}), changed(exact, {"mass.link_3": 1.01})):
        for region in disagreement(observations, predicted):
            assert "its peak is 1.0" not in region.says


def test_a_resonance_that_the_model_lacks_is_missing_and_one_too_many_extra(observed, exact):
    observations, hypothesis, x = exact
    placed = Placed(catalogue()["local_absorber"], "link_3")
    resilient = hypothesis.and_also(placed)
    start = {"mass": 2.0, "frequency": 27.0, "damping_ratio": 0.01, "along": 0.9}
    value = predict(resilient, resilient.start(placed, start, x), observations)
    found = disagreement(replace(observations, value=value), observations.value)
    missing = [region.says for region in found if region.kind == "missing resonance"]
    assert missing, found
    assert all(20 < float(says.split("resonance at ")[1].split(" ")[0]) < 35 for says in missing), missing
    assert "extra resonance" in {region.kind for region in disagreement(observations, value)}


def test_blows_of_other_force_on_one_pair_go_together(observed):
    owner = but_for_the_blow(observed)
    seen = observed
    for number in np.unique(owner):
        rows = np.flatnonzero(owner == number)
        assert len(np.unique(seen.level[rows])) == len(rows) == 2
        assert (
            len(np.unique(np.column_stack([seen.posture, seen.response, seen.reference])[rows], axis=0)) == 1
        )


def test_what_changes_with_the_force_under_one_hammer_point_in_one_posture_counts(observed):
    """A stop that one blow reaches in one posture changes few of all FRFs, but all of those."""
    reference = observed.reference[0]
    here = (observed.posture == 0) & np.all(observed.reference == reference, axis=1)
    assert here.mean() <= 0.25
    assert here.sum() >= 2 * FEWEST_PAIRS
    louder = here & (observed.level == 1)
    noise = np.sqrt(observed.variance)
    changed = replace(observed, value=observed.value * np.exp(5 * noise * louder[:, None]))
    assert force_dependence(observed) < 1.5
    assert force_dependence(changed) > 5
    one = np.flatnonzero(louder)[:1]
    alone = observed.value.copy()
    alone[one] *= np.exp(5 * noise[one])
    assert force_dependence(replace(observed, value=alone)) < 1.5  # a sensor may be at fault


def test_blows_with_records_of_another_length_are_not_compared(observed):
    """The end of a record cuts off part of the motion: a difference that the force has no part in."""
    first, second = observed.lengths
    rows = np.arange(len(observed))
    assert len(np.unique(but_for_the_blow(observed))) == len(rows) // 2
    jitter = replace(observed, lengths=(first, 1.005 * second))
    np.testing.assert_array_equal(but_for_the_blow(jitter), but_for_the_blow(observed))
    shorter = replace(observed, lengths=(first, second / 2))
    assert len(np.unique(but_for_the_blow(shorter))) == len(rows)
    windowed = replace(observed, decays=(0.0, 2.0))
    assert len(np.unique(but_for_the_blow(windowed))) == len(rows)
    assert np.isnan(force_dependence(shorter))
    assert np.isfinite(force_dependence(observed))
