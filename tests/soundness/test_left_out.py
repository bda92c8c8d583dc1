"""A joint left out of a posture stands at 0, wherever it is read, and `check` has a word for it."""

from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner

from flexmodal.campaign import write_campaign
from flexmodal.cli.check import check
from flexmodal.cli.identify import identify as identify_command
from flexmodal.errors import InvalidRequest
from flexmodal.identification import identify, observe
from flexmodal.soundness import check_soundness


@pytest.fixture(scope="module")
def silent(planar):
    """The campaign without a word of q3, which stood at 0."""
    assert all(posture.q["q3"] == 0 for posture in planar.postures)
    postures = tuple(
        replace(one, q={name: value for name, value in one.q.items() if name != "q3"})
        for one in planar.postures
    )
    return replace(planar, postures=postures, robot="fanuc_s360")


def test_it_is_a_finding_and_the_only_one(silent, fanuc):
    (found,) = check_soundness(silent, fanuc)
    assert found.kind == "joint left out"
    assert found.where == "q3 in posture configuration_1, configuration_3, configuration_7"
    assert not found.harmless
    (bare,) = check_soundness(replace(silent, frfs=None, blows=()), fanuc)
    assert bare == found


def test_it_is_at_zero_in_a_card_and_in_a_fit(planar, silent, fanuc):
    q = dict(silent.postures[0].q)
    np.testing.assert_array_equal(
        fanuc.frf(q, [5.0, 50.0]).value, fanuc.frf({**q, "q3": 0.0}, [5.0, 50.0]).value
    )
    whole, left = (identify(one, fanuc, hold_out=["configuration_7"]) for one in (planar, silent))
    np.testing.assert_allclose(whole.at, left.at, atol=1e-9)
    assert observe(silent).postures[0].q == q


def test_a_joint_that_no_posture_mentions_is_another_arms(silent, fanuc):
    other = replace(silent, robot="of_somebody_else")
    with pytest.raises(InvalidRequest, match="nothing of q3, which fanuc_s360 is posed by"):
        identify(other, fanuc)
    once = replace(silent.postures[0], q={**silent.postures[0].q, "q3": 0.0})
    known = replace(other, postures=(once, *silent.postures[1:]))
    (found,) = check_soundness(known, fanuc)
    assert found.where == "q3 in posture configuration_3, configuration_7"


def test_the_commands_say_it_and_go_on(silent, tmp_path):
    folder = write_campaign(silent, tmp_path / "c")
    ran = CliRunner().invoke(check, [str(folder)])
    assert ran.exit_code == 1
    assert "finding: joint left out, q3 in posture" in ran.stdout
    ran = CliRunner().invoke(identify_command, [str(folder), "--quiet"])
    assert ran.exit_code == 0, ran.stderr
    assert "finding: joint left out, q3 in posture" in ran.stderr
