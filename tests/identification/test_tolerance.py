"""What was not set up exactly counts as variance, by the derivatives of the robot's own FRFs."""

import tomllib
from dataclasses import replace

import numpy as np
import pytest

import flexmodal
from flexmodal.campaign import Tolerance, read_campaign, write_campaign
from flexmodal.campaign.description.tested import EXACT, USUAL
from flexmodal.campaign.new import new_campaign_toml
from flexmodal.errors import InvalidCampaign
from flexmodal.identification import build_identification, observe
from flexmodal.identification.tolerance import MOST, with_tolerance
from flexmodal.rig import simulate
from flexmodal.structure import robot_space


@pytest.fixture(scope="module")
def made():
    result = simulate(
        flexmodal.load("six_axis"), postures=2, points=2, references=1, trials=2, averages=1, peaks=(60.0,),
        noise=0.005, record_length=1.0, band=(3.0, 90.0), parameter_error=0.0, time=False,
    )  # fmt: skip
    return result.campaign, result.robot


def added(made, **given):
    campaign, robot = made
    plain = observe(campaign)
    seen = observe(replace(campaign, tolerance=Tolerance(**given)))
    return plain, with_tolerance(seen, robot).variance - plain.variance


def receptance(robot, observations, row, *, q=None, response=None, reference=None):
    """Of the robot as its card says, by its own command's way."""
    names = {point.id: point for point in observations.campaign.points}

    def direction(place):
        point = names[int(place[0])]
        return f"{point.name}:+{'xyz'[int(place[1]) - 1]}"

    posture = observations.postures[int(observations.posture[row])].q
    return robot.frf(
        q or dict(posture), observations.axis.frequency,
        response=direction(observations.response[row] if response is None else response),
        reference=direction(observations.reference[row] if reference is None else reference),
    ).value[:, 0, 0]  # fmt: skip


def test_what_is_exact_stays_as_it_was_measured(made):
    campaign, robot = made
    seen = observe(campaign)
    assert with_tolerance(seen, robot) is seen


def test_a_gain_is_one_of_the_sensor_and_one_of_the_hammer(made):
    _, more = added(made, gain=0.03)
    np.testing.assert_allclose(more, 2 * 0.03**2, rtol=1e-9)


def test_angles_count_by_the_derivative_along_each_joint(made):
    plain, more = added(made, posture=1e-4)
    row, total = 1, 0.0
    for joint in made[1].moving:
        values = []
        for side in (1, -1):
            q = dict(plain.postures[int(plain.posture[row])].q)
            q[joint] = q.get(joint, 0.0) + side * 1e-5
            values.append(receptance(made[1], plain, row, q=q))
        total = total + np.abs(np.log(values[0] / values[1]) / 2e-5 * 1e-4) ** 2
    np.testing.assert_allclose(more[row], total, rtol=0.02)


def test_a_direction_lets_in_what_moves_across(made):
    plain, more = added(made, direction=0.01)
    row = 2
    total, own = 0.0, receptance(made[1], plain, row)
    for name in ("response", "reference"):
        place = getattr(plain, name)[row]
        for other in {1, 2, 3} - {int(place[1])}:
            across = receptance(made[1], plain, row, **{name: (int(place[0]), other)})
            total = total + np.minimum(np.abs(0.01 * across / own) ** 2, MOST)
    np.testing.assert_allclose(more[row], total, rtol=1e-6)


def test_a_place_counts_more_where_the_link_turns(made):
    """Of one point with both, sensor and hammer are off by themselves."""
    plain, more = added(made, position=1e-4)
    assert np.all(more > 0)
    _, twice = added(made, position=2e-4)
    np.testing.assert_allclose(np.median(twice / more), 4.0, rtol=0.02)
    same = np.flatnonzero(np.all(plain.response == plain.reference, axis=1))
    assert same.size


def test_what_the_table_leaves_out_is_as_usual(made, tmp_path):
    """Without a table everything is exact, and a new campaign says what is usual."""
    write_campaign(made[0], tmp_path / "test")
    assert read_campaign(tmp_path / "test").tolerance == EXACT
    file = tmp_path / "test" / "campaign.toml"
    file.write_text(file.read_text() + "\n[tolerance]\ngain = 0\nposition = 0.002\n")
    found = read_campaign(tmp_path / "test").tolerance
    assert found == replace(USUAL, gain=0.0, position=0.002)
    drawn_up = new_campaign_toml("a test", "fanuc_s360", {"one": {"q1": 0.1}}, {"tip": ("link_3", (0, 0, 0))})
    assert Tolerance(**tomllib.loads(drawn_up)["tolerance"]) == USUAL


def test_it_is_written_and_read(made, tmp_path):
    given = Tolerance(posture=0.01, gain=0.03)
    write_campaign(replace(made[0], tolerance=given), tmp_path / "test")
    assert read_campaign(tmp_path / "test").tolerance == given
    text = (tmp_path / "test" / "campaign.toml").read_text()
    (tmp_path / "test" / "campaign.toml").write_text(text.replace("gain = 0.03", 'gain = 3.0\nangle = "x"'))
    with pytest.raises(InvalidCampaign) as raised:
        read_campaign(tmp_path / "test")
    assert {"tolerance.gain", "tolerance.angle"} <= {fault.key for fault in raised.value.faults}


def test_a_card_says_how_far_its_masses_are_trusted(tmp_path):
    card = flexmodal.load("fanuc_s360").path
    text = card.read_text().replace("[joint", "[tolerance]\nmass = 0.2\ninertia = 0.4\n\n[joint", 1)
    for name in card.parent.iterdir():
        if name.is_file() and name != card:
            (tmp_path / name.name).write_bytes(name.read_bytes())
    urdf = flexmodal.load("fanuc_s360").urdf.path
    text = text.replace(text.split('urdf = "')[1].split('"')[0], str(urdf))
    (tmp_path / "robot.toml").write_text(text)
    robot = flexmodal.load(tmp_path / "robot.toml")
    assert robot.tolerance == {"mass": 0.2, "inertia": 0.4}
    deviation = {p.name: p.deviation for p in robot_space(robot)}
    assert deviation["mass.link_2"] == pytest.approx(0.2)
    assert deviation["inertia.link_2"] == pytest.approx(0.4)
    own = {p.name: p.deviation for p in robot_space(robot, trust={"mass": 0.05})}
    assert own["mass.link_2"] == pytest.approx(0.05)


def test_an_identification_takes_it_in(made):
    campaign, robot = made
    loose = replace(campaign, tolerance=Tolerance(posture=0.01))
    tight, wide = (build_identification(one, robot).evidence.observations for one in (campaign, loose))
    assert np.all(wide.variance > tight.variance)
