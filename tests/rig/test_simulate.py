"""Campaigns as a whole: repeatable, written whole, the truth kept out, and clear about what is wrong."""

import json
import tomllib
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner

import flexmodal
from flexmodal.campaign import read_campaign
from flexmodal.cli.rig import rig
from flexmodal.errors import InvalidPosture, InvalidRequest, OutputExists
from flexmodal.model.placements import link_placements
from flexmodal.rig import EFFECTS, Hide, hide_places, simulate
from flexmodal.rig.hidden.severity import height, limit, noise_floor, severity_for

SMALL = {"postures": 2, "points": 2, "references": 1, "trials": 2, "averages": 2, "record_length": 1.0}
NAMES = [
    "link_flexibility", "base_flexibility", "servo_compliance", "structural_damping", "coulomb_friction",
    "nonlinear_stiffness", "joint_coupling", "added_mass", "local_absorber", "sensor_mass", "sensor_gain",
    "time_delay", "sensor_misalignment", "bearing_flexibility",
]  # fmt: skip


@pytest.fixture(scope="module")
def fanuc():
    return flexmodal.load("fanuc_s360")


@pytest.fixture(scope="module")
def ur5():
    return flexmodal.load("ur5", stiffness=2e4, damping=10.0)


def test_every_named_effect_can_be_hidden_and_four_without_a_name():
    assert [name for name, effect in EFFECTS.items() if effect.catalogued] == NAMES
    assert len(EFFECTS) == len(NAMES) + 4


@pytest.fixture(scope="module")
def clean(fanuc, ur5):
    """A campaign with nothing hidden, by robot."""
    return {name: simulate(arm, **SMALL, seed=4) for name, arm in (("fanuc", fanuc), ("ur5", ur5))}


@pytest.mark.some(3)
@pytest.mark.parametrize("effect", EFFECTS)
@pytest.mark.parametrize("which", ["fanuc", pytest.param("ur5", marks=pytest.mark.slow)])
def test_every_effect_on_a_planar_and_a_spatial_arm(effect, which, clean, request):
    robot = request.getfixturevalue(which)
    spoilt = simulate(robot, **SMALL, hide=[effect], seed=4)
    one, other = clean[which].campaign.frfs, spoilt.campaign.frfs
    assert np.all(np.isfinite(other.value))
    inside = (one.frequency >= 2) & (one.frequency <= 200)
    assert not np.allclose(one.value[:, inside], other.value[:, inside], rtol=1e-3, atol=0)
    np.testing.assert_array_equal(one.response, other.response)
    assert spoilt.truth.effects[0].effect == effect
    assert spoilt.truth.effects[0].where in hide_places(robot, points=2)[effect]


def test_directions_of_the_links_are_those_of_the_robot_turned_with_it(tmp_path):
    """Struck and measured along the axes of the links: `Robot.frf` along the world's, turned by hand."""
    robot = flexmodal.load("six_axis")
    made = simulate(
        robot, postures=1, points=2, references=2, trials=1, averages=1, frame="link", band=(4.0, 60.0),
        record_length=4.0, noise=0.0, scatter=0.0, parameter_error=0.0, seed=2, time=False,
    )  # fmt: skip
    campaign = made.campaign
    made.write(tmp_path / "c")
    assert read_campaign(tmp_path / "c").points == campaign.points
    assert {point.frame for point in campaign.points} == {"link"}
    frfs, q = campaign.frfs.to("receptance"), dict(campaign.postures[0].q)
    inside = np.flatnonzero((frfs.frequency >= 6) & (frfs.frequency <= 55))[::7]
    placed = link_placements(robot, q)
    names = {point.id: [f"{point.name}:+{axis}" for axis in "xyz"] for point in campaign.points}
    for row in range(len(frfs)):
        (r, d), (f, e) = frfs.response[row].tolist(), frfs.reference[row].tolist()
        value = robot.frf(q, frfs.frequency[inside], response=names[r], reference=names[f]).value
        ways = [
            np.sign(axis) * placed[campaign.point(point).link][:3, abs(axis) - 1]
            for point, axis in ((r, d), (f, e))
        ]
        expected = np.einsum("a,lab,b->l", ways[0], value, ways[1])
        # of the largest there: at one's end a record is cut off, and H1 of a cut record is a little off
        size = np.abs(value).max()
        np.testing.assert_allclose(frfs.value[row, inside] / size, expected / size, atol=0.02)


def test_the_same_seed_gives_the_same_campaign(fanuc):
    small = {**SMALL, "postures": 1}
    one, two, three = (simulate(fanuc, **small, hide=["coulomb_friction"], seed=seed) for seed in (5, 5, 6))
    for first, second in zip(one.campaign.blows, two.campaign.blows, strict=True):
        np.testing.assert_array_equal(first.force, second.force)
        np.testing.assert_array_equal(first.response, second.response)
    assert one.truth == two.truth
    assert not np.array_equal(one.campaign.blows[0].response, three.campaign.blows[0].response)


def test_blows_do_not_depend_on_what_is_hidden(fanuc):
    one, two = (simulate(fanuc, **SMALL, noise=0.0, hide=hide) for hide in ([], ["local_absorber"]))
    for first, second in zip(one.campaign.blows, two.campaign.blows, strict=True):
        np.testing.assert_array_equal(first.force, second.force)


def test_noise_is_as_loud_as_asked(fanuc):
    clean, noisy = (simulate(fanuc, **SMALL, noise=noise, scatter=0.0) for noise in (0.0, 0.03))
    ratios = []
    for one, other in zip(clean.campaign.blows, noisy.campaign.blows, strict=True):
        ratios.append(np.std(other.response - one.response) / np.sqrt(np.mean(one.response**2)))
    # 3 % of a channel's own record and 0.3 % of them all; 32 records of 512 samples
    assert np.median(ratios) == pytest.approx(0.03, rel=0.05)


def test_more_noise_less_coherence_and_repeats_differ_by_it(fanuc):
    floors = []
    for noise in (0.005, 0.02):
        result = simulate(fanuc, **{**SMALL, "trials": 4, "averages": 3}, noise=noise)
        frfs = result.campaign.frfs
        inside = (frfs.frequency >= 5) & (frfs.frequency <= 150)
        floors.append(
            np.median(
                [np.abs(np.log(frfs.value[a] / frfs.value[b]))[inside].mean() for a, b in frfs.repeats()]
            )
        )
        assert np.median(frfs.coherence[:, inside]) > 0.95
    assert floors[1] > 1.5 * floors[0]


@pytest.mark.parametrize(
    ("effect", "target"),
    [
        ("link_flexibility", 3.0),
        ("link_flexibility", 20.0),
        ("time_delay", 3.0),
        ("time_delay", 20.0),
        ("nonlinear_stiffness", 3.0),
        pytest.param("nonlinear_stiffness", 20.0, marks=pytest.mark.slow),
    ],
)
def test_severity_brings_an_effect_to_the_height_asked_for(effect, target, fanuc):
    result = simulate(fanuc, **SMALL, hide=[Hide(effect, height=target)], seed=2)
    entry = result.truth.effects[0]
    assert entry.height == pytest.approx(target, rel=0.2)
    assert result.truth.noise_floor > 0
    # The campaigns themselves, with noise, stand that far apart as well: the root of the squares, floor √2.
    stand, floor = result.stand, noise_floor(result.stand, replace_conduct(result))
    again = height(stand, result.hidden, floor) / floor.height
    assert again == pytest.approx(entry.height, rel=1e-6)


def replace_conduct(result):
    from flexmodal.rig.hammer_test import Conduct

    return Conduct(result.truth.noise, result.truth.scatter, result.truth.seed)


def test_severity_stops_where_it_makes_no_sense(fanuc):
    result = simulate(fanuc, **SMALL, hide=["sensor_gain@location_1"], noise=0.05)
    effect, site = result.hidden[0]
    floor = noise_floor(result.stand, replace_conduct(result))
    severity, reached = severity_for(result.stand, effect, site, 1000.0, floor)
    assert severity == pytest.approx(effect.most(site.parameters))
    assert reached < 1000


@pytest.mark.some(3)
@pytest.mark.parametrize("effect", EFFECTS)
def test_the_highest_severity_is_allowed(effect, fanuc, ur5):
    """Whatever is drawn, the search may end at its limit; rounding must not carry it over."""
    for robot in (fanuc, ur5):
        stand = simulate(robot, **{**SMALL, "postures": 1}, noise=0.0).stand
        where = hide_places(robot, points=2)[effect][0]
        for seed in range(200):
            drawn = EFFECTS[effect].draw(stand, where, np.random.default_rng(seed))
            most = EFFECTS[effect].scaled(drawn, limit(EFFECTS[effect], drawn))
            assert EFFECTS[effect].check(most) is None, most


@pytest.mark.parametrize("coupling", [-0.2, 0.3, -0.7, 0.9, -3.0])
def test_a_coupling_searched_up_to_its_limit_is_put_in(coupling, fanuc):
    hide = Hide("joint_coupling", parameters={"coupling": coupling}, height=1000.0)
    (entry,) = simulate(fanuc, **SMALL, hide=[hide], seed=1).truth.effects
    assert abs(entry.parameters["coupling"]) == pytest.approx(0.9, rel=1e-8)
    assert abs(entry.parameters["coupling"]) < 0.9
    assert np.sign(entry.parameters["coupling"]) == np.sign(coupling)


def test_parameter_errors_are_what_was_asked_for(fanuc):
    drawn = []
    for seed in range(12):
        result = simulate(fanuc, **{**SMALL, "postures": 1, "trials": 1}, seed=seed, parameter_error=0.05)
        drawn += [np.log(v) for k, v in result.truth.factors.items() if not k.startswith("mass_centre")]
    assert len(drawn) == 12 * 16
    assert np.std(drawn) == pytest.approx(0.05, rel=0.2)  # 192 draws: standard error 5 %
    assert np.max(np.abs(drawn)) <= 2.5 * 0.05 + 1e-12
    exact = simulate(fanuc, **SMALL, parameter_error=0.0)
    assert set(exact.truth.factors.values()) == {1.0}


@pytest.mark.parametrize("which", ["fanuc", "ur5"])
def test_folder_reads_back_and_holds_nothing_of_the_truth(which, request, tmp_path):
    robot = request.getfixturevalue(which)
    hide = [
        Hide("added_mass", parameters={"mass": 1.2345678}),
        Hide("time_delay", parameters={"delay": 0.00098765}),
    ]
    result = simulate(robot, **SMALL, hide=hide, seed=7)
    truth = result.write(tmp_path / "test")
    assert truth == tmp_path / "test.truth.toml"
    again = read_campaign(tmp_path / "test")
    assert again.band == (2.0, 200.0)
    assert len(again.blows) == len(result.campaign.blows)
    np.testing.assert_allclose(again.frfs.value, result.campaign.frfs.value, rtol=1e-12)
    np.testing.assert_allclose(again.blows[-1].response, result.campaign.blows[-1].response, rtol=1e-12)
    believed = flexmodal.load(tmp_path / "test" / again.robot)
    for joint, card in robot.joints.items():
        assert believed.joints[joint].stiffness == card.stiffness
    assert believed.families == robot.families
    for posture in again.postures:
        np.testing.assert_allclose(
            believed.at(dict(posture.q)).system.mass, robot.at(dict(posture.q)).system.mass
        )
    said = tomllib.loads(truth.read_text(encoding="utf-8"))
    assert said["effect"][0]["parameters"]["mass"] == 1.2345678
    assert said["true_over_believed"] == pytest.approx(dict(result.truth.factors))
    secrets = ["1.2345678", "added_mass", "time_delay", "0.00098765", "seed", "truth"]
    secrets += [repr(v) for v in result.truth.factors.values() if v != 1.0]
    for file in (tmp_path / "test").rglob("*"):
        if file.is_file():
            content = file.read_bytes()
            assert not [secret for secret in secrets if secret.encode() in content], file
    names = {file.name for file in (tmp_path / "test").rglob("*")}
    assert names == {"campaign.toml", "frf.uff", "time.uff", "robot", "robot.toml", f"{robot.name}.urdf"}
    assert sorted(p.name for p in tmp_path.iterdir()) == ["test", "test.truth.toml"]


def test_a_campaign_looks_alike_whatever_is_hidden(fanuc):
    """Numbers of blows, channels and order must not give an effect away."""
    shapes = set()
    for hide in ([], ["sensor_mass"], ["coulomb_friction"], ["saturation"]):
        blows = simulate(fanuc, **SMALL, hide=hide).campaign.blows
        shapes.add(
            tuple((b.posture, b.trial, b.sequence, b.reference, b.channels, b.response.shape) for b in blows)
        )
    assert len(shapes) == 1


def test_nothing_is_written_over(fanuc, tmp_path):
    result = simulate(fanuc, **SMALL)
    result.write(tmp_path / "test")
    with pytest.raises(OutputExists) as caught:
        result.write(tmp_path / "test")
    assert len(caught.value.faults) == 2
    (tmp_path / "other.truth.toml").write_text("mine")
    with pytest.raises(OutputExists):
        result.write(tmp_path / "other")
    assert not (tmp_path / "other").exists()
    with pytest.raises(OutputExists, match="no such folder"):
        result.write(tmp_path / "nowhere" / "test")


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"hide": ["link_flexibilty"]}, "allowed: link_flexibility, base_flexibility"),
        ({"hide": ["link_flexibility@link_9"]}, "long enough to bend: link_1, link_2, link_2_outer, link_3"),
        ({"hide": ["servo_compliance@rho"]}, "a flexible joint: q1, q2, q3"),
        ({"hide": ["joint_coupling@q1"]}, r"jointA\+jointB: q1\+q2, q1\+q3, q2\+q3"),
        ({"hide": ["base_flexibility@link_1"]}, "the base: base"),
        ({"hide": ["sensor_gain@nowhere"]}, "a point with a sensor: location_1"),
        ({"hide": ["added_mass@link_1,weight=3"]}, "unknown parameter 'weight'; allowed: mass, x, y, z"),
        ({"hide": ["added_mass@link_1,mass=-3"]}, "mass = -3, where a number above 0"),
        ({"hide": ["added_mass@link_1,mass"]}, "parameter=value"),
        ({"hide": ["added_mass,mass=nan"]}, "mass = nan; allowed: a finite number"),
        ({"hide": ["added_mass", "added_mass"]}, "the same effect twice"),
        ({"hide": [Hide("added_mass", height=3.0)], "noise": 0.0, "scatter": 0.0}, "noise above 0"),
        ({"noise": -1.0}, "noise: found -1"),
        ({"noise": float("nan")}, "noise: found nan"),
        ({"parameter_error": 3.0}, "parameter_error: found 3; allowed: 0 to 0.5"),
        ({"postures": 0}, "postures: found 0"),
        ({"postures": 10**9}, "1 to 1000"),
        ({"points": 99}, "points: found 99; allowed: 1 to 6: location_1"),
        ({"references": ["nowhere:+z"]}, "one of location_1"),
        ({"references": ["location_1:+q"]}, "location_1:"),
        ({"references": ["location_1:+z", "location_1:+z"]}, "twice"),
        ({"references": 99}, "1 to 6 with these points"),
        ({"axes": "w"}, "some of x, y, z"),
        ({"trials": 0}, "trials: found 0"),
        ({"peaks": (0.0,)}, "peaks: found 0; allowed: forces from"),
        ({"tip": "rubber"}, "soft, medium, hard"),
        ({"band": (200.0, 2.0)}, "LOW:HIGH"),
        ({"band": (float("nan"), 2.0)}, "LOW:HIGH"),
        ({"record_length": 1e9}, "samples"),
        ({"record_length": 1e-9}, "samples"),
        ({"seed": -1}, "seed: found -1"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_named(fanuc, given, says):
    with pytest.raises(InvalidRequest, match=says):
        simulate(
            fanuc,
            **{"postures": 1, "points": None, "trials": 1, "averages": 1, "record_length": 0.5, **given},
        )


def test_several_faults_come_together(fanuc):
    with pytest.raises(InvalidRequest) as caught:
        simulate(fanuc, trials=0, tip="rubber", band=(3.0, 1.0))
    assert len(caught.value.faults) == 3
    with pytest.raises(InvalidRequest) as caught:
        simulate(fanuc, **SMALL, hide=["servo_compliance@q9", "nonsense"])
    assert len(caught.value.faults) == 2
    with pytest.raises(InvalidPosture):
        simulate(fanuc, **{**SMALL, "postures": ["configuration_99"]})


def test_a_pair_of_joints_in_either_order(fanuc):
    one, two = (
        simulate(fanuc, **SMALL, hide=[f"joint_coupling@{w},coupling=0.3"]) for w in ("q1+q2", "q2+q1")
    )
    assert one.truth.effects[0].where == two.truth.effects[0].where == "q1+q2"
    np.testing.assert_array_equal(one.campaign.frfs.value, two.campaign.frfs.value)


ARGUMENTS = ["fanuc_s360", "--postures", "1", "--points", "2", "--references", "1", "--trials", "2",
             "--averages", "1", "--record-length", "0.5"]  # fmt: skip


def test_command_line(tmp_path):
    out = tmp_path / "test"
    run = CliRunner().invoke(
        rig, [*ARGUMENTS, "--out", str(out), "--hide", "added_mass@link_3,mass=0.5", "--seed", "3", "--json"]
    )
    assert run.exit_code == 0, run.output
    said = json.loads(run.stdout)
    assert said["blows"] == 4
    assert said["campaign"] == str(out)
    truth = tomllib.loads((tmp_path / "test.truth.toml").read_text(encoding="utf-8"))
    assert truth["effect"][0]["where"] == "link_3"
    assert truth["effect"][0]["parameters"]["mass"] == 0.5
    assert "added_mass" not in run.stdout
    same = simulate(flexmodal.load("fanuc_s360"), postures=1, points=2, references=1, trials=2, averages=1,
                    record_length=0.5, hide=["added_mass@link_3,mass=0.5"], seed=3)  # fmt: skip
    np.testing.assert_array_equal(read_campaign(out).frfs.value, same.campaign.frfs.value)
    again = CliRunner().invoke(rig, [*ARGUMENTS, "--out", str(out)])
    assert isinstance(again.exception, OutputExists)


def test_command_line_prints_a_table_and_takes_references_by_name(tmp_path):
    out = tmp_path / "test"
    run = CliRunner().invoke(
        rig, [*ARGUMENTS[:5], "--references", "location_1:-z", *ARGUMENTS[7:], "--out", str(out), "--ascii"]
    )
    assert run.exit_code == 0, run.output
    assert "location_1:-z" in run.output
    assert "test.truth.toml" in run.output
    assert read_campaign(out).frfs.reference[0].tolist() == [1, -3]


def test_height_on_the_command_line(tmp_path):
    run = CliRunner().invoke(
        rig, [*ARGUMENTS, "--out", str(tmp_path / "t"), "--hide", "added_mass", "--height", "5"]
    )
    assert run.exit_code == 0, run.output
    truth = tomllib.loads((tmp_path / "t.truth.toml").read_text(encoding="utf-8"))
    assert truth["effect"][0]["times_noise_floor"] == pytest.approx(5, rel=0.3)


def test_spatial_arm_measures_three_axes(ur5):
    campaign = simulate(ur5, **SMALL).campaign
    assert {direction for _, direction in campaign.frfs.response.tolist()} == {1, 2, 3}
    single = simulate(ur5, **SMALL, axes="y").campaign
    assert {direction for _, direction in single.frfs.response.tolist()} == {2}


def test_progress_is_told(fanuc):
    calls = []
    simulate(fanuc, **SMALL, advance=lambda: calls.append(1))
    assert len(calls) == 4


def test_hide_reads_text():
    hide = Hide.parse("local_absorber@link_2, mass=3, frequency=20")
    assert hide == Hide("local_absorber", "link_2", {"mass": 3.0, "frequency": 20.0})
    assert replace(hide, height=3.0).height == 3.0
