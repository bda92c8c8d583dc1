"""Diagnosis from modes alone: nothing missing, a link that bends, and verdicts no surer than the data."""

import json

import numpy as np
import pytest

import flexmodal
from flexmodal.campaign import read_campaign, write_campaign
from flexmodal.diagnosis import diagnose
from flexmodal.diagnosis.as_json import as_json
from flexmodal.diagnosis.effects import catalogue
from flexmodal.diagnosis.search import modal_search
from flexmodal.diagnosis.selection import asked, variants
from flexmodal.diagnosis.selection.untestable import of_modes
from flexmodal.diagnosis.write import write_diagnosis
from flexmodal.errors import InvalidRequest
from flexmodal.identification.evidence.likelihood.errors import errors, figures, mean_of_others

KEY = ("link_flexibility", "link_2")
THESIS = "robots/fanuc_s360/campaigns/thesis"


@pytest.fixture(scope="module", autouse=True)
def fewer_beliefs():
    """Three sets of beliefs, the card trusted more and less among them: the others only take longer."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(variants, "VARIANTS", variants.VARIANTS[:3])
        yield


@pytest.fixture(scope="module")
def nothing(as_believed, rigid):
    return diagnose(as_believed, rigid, effects=["link_flexibility@link_2", "joint_coupling@q1+q2"])


@pytest.mark.slow
def test_the_believed_model_with_noise_lacks_nothing(nothing):
    assert nothing.verdict.effects == ()
    assert nothing.verdict.explained
    assert nothing.steps == ()
    assert nothing.next_measurement is None
    assert nothing.modal.missing == ()
    assert nothing.gaps.believed < 0.3  # no mode is lacking in the card either
    assert nothing.gaps.after == nothing.gaps.before <= 2 * nothing.gaps.noise_floor
    comparison = nothing.modal.comparison
    assert all(comparison.first_gain(k) < 8 for k in range(1, len(comparison.models)))  # what it takes
    json.dumps(as_json(nothing), allow_nan=False)


@pytest.fixture(scope="module")
def poor(bending, rigid):
    """Asked for nothing in particular, with a catalogue of two so that it takes less long."""
    with pytest.MonkeyPatch.context() as patch:
        few = [catalogue([name])[name] for name in ("link_flexibility", "local_absorber")]
        patch.setattr(asked, "catalogue", lambda names=None: {one.name: one for one in few})
        return diagnose(bending(shape=1.5), rigid)


@pytest.mark.slow
def test_a_bending_link_with_poor_shapes_is_not_named_surer_than_the_data(poor):
    found = poor.modal
    assert found.missing  # that something is missing is seen
    assert not poor.verdict.explained
    assert poor.steps == ()
    assert poor.verdict.effects[0][0] == "unknown"
    assert len(found.tied) > 1
    truth = next((k for k, c in enumerate(found.comparison.models) if c.key == KEY), None)
    assert truth is not None
    assert found.comparison.probability.max() < 0.98
    assert "cannot say" in poor.verdict.says
    assert found.shapes  # and why the shapes do not decide
    assert poor.next_measurement is not None
    assert poor.next_measurement.expected > 0.1  # in ln H, where noise is some hundredths


@pytest.fixture(scope="module")
def told(bending, rigid):
    return diagnose(
        bending(shape=0.1, frequency=0.003, damping=0.05),
        rigid,
        effects=["link_flexibility@link_2", "joint_coupling@q1+q2"],
    )


@pytest.mark.slow
def test_a_bending_link_with_clean_shapes_is_found_and_shrinks_the_gap(told):
    assert [(s.effect, s.where) for s in told.steps] == [KEY]
    assert told.verdict.effects == (KEY,)
    assert told.verdict.explained, told.verdict.says
    assert told.gaps.after < 0.4 * told.gaps.before
    assert told.gaps.held_out_after < 0.5 * told.gaps.held_out_before
    step = told.steps[0]
    value, error = step.parameters["stiffness"], step.uncertainty["stiffness"]
    assert abs(np.log(value / 3e5)) < 4 * error / value + 0.1
    names = {(one.effect, one.where) for one in step.alternatives}
    assert ("none", "") in names
    assert ("unstructured_mode", "") in names


@pytest.mark.slow
def test_the_improved_robot_loads_and_has_the_modes_of_the_model(told, tmp_path):
    out = tmp_path / "found"
    write_diagnosis(told, out)
    robot = flexmodal.load(out / "robot" / "robot.toml")
    fit = told.modal.modes.after
    seen = np.sort(np.exp(fit.forecasts[0].log_frequency))
    posture = told.model.context.postures[0]
    frequencies = np.sort(robot.at(dict(posture.q)).modes().frequency)
    np.testing.assert_allclose(frequencies[:4], seen[:4], rtol=1e-5)  # links between joints weigh 1e-12
    text = (out / "report.html").read_text(encoding="utf-8")
    for word in ("one more mode with no structure", "the mean of the other postures", "link_2", "held out"):
        assert word in text
    assert 'src="http' not in text
    assert 'href="http' not in text
    assert json.loads((out / "diagnosis.json").read_text(encoding="utf-8"))["steps"][0]["effect"] == KEY[0]


@pytest.mark.slow
def test_what_modes_cannot_tell_of_is_said_to_be_untestable(nothing):
    for name in ("coulomb_friction", "sensor_gain", "structural_damping", "sensor_mass", "time_delay"):
        assert of_modes(catalogue([name])[name], nothing.model.context)
    assert of_modes(catalogue(["base_flexibility"])["base_flexibility"], nothing.model.context) is None


@pytest.mark.slow
def test_a_lacking_mode_counts_in_the_gap(told):
    before = told.modal.modes.before
    table = errors(before)
    lacking = [k for k, m in enumerate(before.pairs) if m < 0]
    assert lacking
    np.testing.assert_allclose(table[lacking], [[1.0, 0.1, 1.0]] * len(lacking))
    assert figures(table).missing == len(lacking)
    assert told.gaps.before == pytest.approx(np.sqrt(np.nanmean(table**2)))


@pytest.mark.slow
def test_the_mean_of_the_others_by_hand(told):
    measured = told.modal.modes.measured
    table = mean_of_others(measured)
    modes = measured.modes
    first = [m.frequency for m in modes if m.number == modes[0].number]
    mean = np.exp(np.mean(np.log(first[1:])))
    assert table[0, 0] == pytest.approx(mean / first[0] - 1, rel=1e-12)
    assert np.median(table[:, 2]) < 0.1  # most shapes of these postures are alike, and clean


def test_points_of_another_card_are_found_by_name(rigid):
    campaign = read_campaign(THESIS)
    from flexmodal.identification.compatibility import placed_on

    moved, said = placed_on(campaign, rigid)
    assert len(said) == 4
    assert {p.link for p in moved.points} == {"link_1", "link_2", "link_3"}
    assert moved.point("location_2").xyz == tuple(rigid.points["location_2"].xyz)


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"effects": ["link_flexibilty"]}, "link_flexibilty"),
        ({"effects": ["link_flexibility@link_9"]}, "link_9"),
        ({"hold_out": ["nowhere"]}, "nowhere"),
        ({"hold_out": [1, 2, 3, 4]}, "every posture"),
    ],
)
def test_what_is_refused(as_believed, rigid, options, says):
    with pytest.raises(InvalidRequest, match=says):
        diagnose(as_believed, rigid, **options)


@pytest.mark.slow
def test_postures_that_are_held_out_are_not_fitted(as_believed, rigid):
    found = diagnose(as_believed, rigid, hold_out=["configuration_6"], effects=["joint_coupling@q1+q2"])
    assert found.held_out == (3,)
    assert found.verdict.effects == ()
    assert "Asked for, joint coupling at q1+q2 gains" in found.verdict.says
    assert "a tie with nothing added" in found.verdict.says
    fit = found.modal.comparison.models[0].fit
    assert all(mode.posture != 2 for mode in fit.measured.modes)
    assert found.gaps.held_out_before is not None


@pytest.mark.slow
def test_the_command_line_takes_a_folder_of_modes(as_believed, tmp_path, monkeypatch):
    """By one set of beliefs and from few starts: what becomes of several is asked of `diagnose` itself."""
    monkeypatch.setattr(variants, "VARIANTS", variants.VARIANTS[:1])
    for name, value in {"QUICK": 2, "NEAR": 2, "FORCED": 1, "CLOSE": 1}.items():
        monkeypatch.setattr(modal_search, name, value)
    from click.testing import CliRunner

    from flexmodal.cli.main import group

    write_campaign(as_believed, tmp_path / "campaign")
    out = tmp_path / "out"
    words = [
        "diagnose",
        str(tmp_path / "campaign"),
        "--out",
        str(out),
        "--effects",
        "joint_coupling@q1+q2",
        "--json",
    ]
    ran = CliRunner().invoke(group, [*words, "--quiet"])
    assert ran.exit_code == 0, ran.output
    verdict = json.loads(ran.stdout)["verdict"]
    assert (verdict["effects"], verdict["explained"]) == ([], True)
    assert sorted(path.name for path in out.iterdir()) == ["diagnosis.json", "report.html", "robot"]
