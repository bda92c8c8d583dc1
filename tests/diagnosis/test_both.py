"""FRFs and modes of one campaign diagnosed together."""

from dataclasses import fields, replace

import numpy as np
import pytest

import flexmodal
from flexmodal.campaign import estimate_frfs
from flexmodal.diagnosis import diagnose
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.placed import Placed
from flexmodal.diagnosis.report.page import report_text
from flexmodal.diagnosis.search.close_fit import fitted_closely
from flexmodal.diagnosis.selection.asked import asked_of
from flexmodal.diagnosis.selection.beside_frfs import SETTINGS, ModesBeside
from flexmodal.diagnosis.selection.frf_data import FrfData
from flexmodal.diagnosis.setup import prepare
from flexmodal.ema import fit, mode_table
from flexmodal.identification.evidence.mode_sources import modes_of_table
from flexmodal.rig import Hide, simulate

SMALL = {"postures": 3, "points": 3, "references": 2, "trials": 4, "record_length": 2.0, "band": (2.0, 150.0)}
PEAK = 30.0
"""Where the robot has no mode in any posture [Hz]."""


def campaign_with(*hidden):
    """A campaign of the rig with frf.uff and modes.csv, and the robot as believed."""
    hide = [replace(Hide.parse(one), height=12.0) for one in hidden]
    made = simulate(flexmodal.load("fanuc_s360"), hide=hide, seed=11, **SMALL)
    frfs = replace(made.campaign, frfs=estimate_frfs(made.campaign), blows=())
    return replace(frfs, modes=mode_table(fit(frfs, "least-squares", per="posture"))), made.robot


@pytest.fixture(scope="module")
def clean():
    return campaign_with()


def with_a_peak(campaign):
    """One more mode in every posture, in the table alone."""
    old = campaign.modes
    first = old.mode == old.mode.min()
    names = [field.name for field in fields(old) if isinstance(getattr(old, field.name), np.ndarray)]
    columns = {name: np.concatenate([getattr(old, name), getattr(old, name)[first]]) for name in names}
    columns["mode"][len(old.mode) :] = old.mode.max() + 1
    columns["natural_frequency"][len(old.mode) :] = PEAK
    flags = (*old.flag, *(old.flag[k] for k in np.flatnonzero(first)))
    return replace(campaign, modes=replace(old, **columns, flag=flags))


@pytest.mark.slow
def test_where_nothing_is_missing_both_say_so(clean):
    found = diagnose(*clean, effects=["sensor_gain"])
    assert len(found.warnings) == 1
    assert found.verdict.effects == ()
    assert found.verdict.explained, found.verdict.says


@pytest.mark.slow
def test_a_mode_that_only_the_table_has_is_missing(clean):
    campaign, robot = clean
    found = diagnose(with_a_peak(campaign), robot, effects=["sensor_gain"])
    assert not found.verdict.explained
    assert found.verdict.effects[0][0] == "unknown"
    assert f"no mode for those measured near {PEAK:.3g} Hz" in found.verdict.says
    # the page shows both kinds, and each measured mode beside the models'
    page = report_text(found)
    assert all(f"<h2>{head}</h2>" in page for head in ("Measured and modelled", "Modes"))
    assert page.count("30.00 ±") == len(campaign.postures)
    assert found.modes is not None
    lacks = [k for k, partner in enumerate(found.modes.after.pairs) if partner < 0]
    assert {round(found.modes.measured.modes[k].frequency) for k in lacks} == {30}
    held = found.modes.held_after
    away = [m.posture in held_out_places(found) for m in found.modes.measured.modes]
    np.testing.assert_array_equal(np.isfinite(held.errors[:, 0]), away)


def held_out_places(found):
    """Numbers of the postures held out, among those with modes."""
    return {k for k, one in enumerate(found.modes.measured.postures) if one.id in found.held_out}


@pytest.mark.slow
def test_evidence_of_modes_adds_to_that_of_frfs():
    campaign, robot = campaign_with("added_mass@link_3")
    setup = prepare(campaign, robot, None, asked_of(["added_mass"]), None, 0, lambda doing, part: None)
    modes = ModesBeside(modes_of_table(campaign))
    root = Hypothesis(setup.context, setup.base)
    before = fitted_closely(setup, root, np.zeros(len(setup.base)))
    placed = Placed(setup.effects[0], "link_3")
    mass = root.and_also(placed)
    start = mass.start(placed, placed.effect.starts(setup.context, "link_3")[0], np.zeros(len(setup.base)))
    after = fitted_closely(setup, mass, start)
    alone = FrfData(setup).compare([before, after])
    both = FrfData(setup, modes).compare([before, after])
    more = [modes.predicted(one)[0].evidence for one in (before, after)]
    np.testing.assert_allclose(both.scores, alone.scores + more)
    assert both.table.shape[1] == len(SETTINGS) * alone.table.shape[1]
    assert more[1] > more[0]  # the modes speak for the mass too
    assert both.gain(1) > alone.gain(1)
    assert all(partner >= 0 for partner in modes.predicted(after)[0].pairs)
