"""Effects of the catalogue against the rig's own physics, and their derivatives against differences."""

import numpy as np
import pytest

import flexmodal
from flexmodal.diagnosis.effects import Context, catalogue, link_flexibility
from flexmodal.diagnosis.effects.link_flexibility import gauss, shares
from flexmodal.diagnosis.effects.servo_compliance import loop
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.placed import Placed
from flexmodal.diagnosis.search.lines import unlimited
from flexmodal.errors import InvalidRequest
from flexmodal.identification import observe, predict
from flexmodal.identification.model import evaluated
from flexmodal.rig import ParameterError, simulate
from flexmodal.rig.effects import EFFECTS
from flexmodal.rig.effects.effect import Site
from flexmodal.rig.plant.build import build
from flexmodal.rig.simulate import make_stand
from flexmodal.structure import robot_space


@pytest.fixture(scope="module")
def bench():
    """A short campaign with the card's own parameters, its context, its observations, and the rig's stand."""
    robot = flexmodal.load("fanuc_s360")
    result = simulate(
        robot, postures=["configuration_1", "configuration_6"], points=3, trials=2, averages=2, seed=3,
        record_length=1.0, band=(2.0, 120.0), parameter_error=0.0,
    )  # fmt: skip
    stand = make_stand(result.robot, result.plan, ParameterError.all(0.0), 3)
    observed = unlimited(observe(result.campaign))
    return Context.of(robot, observed), observed, stand


def ours(context, observed, effect, where, values):
    """Receptances of the robot with one effect, for every observation."""
    placed = Placed(catalogue()[effect], where)
    hypothesis = Hypothesis(context, robot_space(context.robot)).and_also(placed)
    x = hypothesis.start(placed, values, np.zeros(len(hypothesis.base)))
    own = {p.name.rpartition(".")[2]: p.value(v) for p, v in zip(hypothesis.space, x, strict=True)}
    assert all(own[name] == pytest.approx(value, rel=1e-12) for name, value in values.items())
    return predict(hypothesis, x, observed)


def theirs(observations, stand, effect, where, values):
    """The same from the plant that the rig strikes."""
    value = np.zeros(observations.value.shape, dtype=complex)
    frequency = observations.axis.frequency
    for number, posture in enumerate(observations.postures):
        plant = build(stand, posture, [(EFFECTS[effect], Site(stand, where, values))])
        for row in np.flatnonzero(observations.posture == number):
            places = []
            for point, axis in (observations.response[row], observations.reference[row]):
                found = observations.campaign.point(int(point))
                places.append(plant.row(found.link, np.array(found.xyz), np.eye(3)[axis - 1])[None])
            inertance = plant.inertance(*places, frequency)[:, 0, 0]
            value[row] = -inertance / (2 * np.pi * frequency) ** 2
    return value


K = 4e5
CASES = {
    "servo_compliance": (
        "q2",
        {"gain": 3e5, "frequency": 30.0, "damping_ratio": 0.4},
        None,
    ),
    "joint_coupling": ("q1+q3", {"coupling": -0.3}, {"coupling": -0.3}),
    "base_flexibility": (
        "base",
        {
            "horizontal_stiffness": 4e7, "vertical_stiffness": 8e7, "tilt_stiffness": 2e7,
            "translation_damping": 1e3, "tilt_damping": 1e3,
        },
        None,
    ),
    "structural_damping": ("joints", {"loss_factor": 0.1}, {"loss_factor": 0.1, "viscous": 1.0}),
}  # fmt: skip


def rig_values(context, stand, effect, where, values):
    if effect == "servo_compliance":
        k = float(context.robot.joints[where].stiffness)
        inertia, derivative = loop(k, values["gain"], values["frequency"], values["damping_ratio"])
        return {"proportional_gain": values["gain"], "derivative_gain": derivative, "rotor_inertia": inertia}
    return values


@pytest.mark.parametrize("effect", ["servo_compliance", "joint_coupling"])
def test_effect_is_that_of_the_rig(bench, effect):
    context, observed, stand = bench
    where, values, _ = CASES[effect]
    other = theirs(observed, stand, effect, where, rig_values(context, stand, effect, where, values))
    np.testing.assert_allclose(ours(context, observed, effect, where, values), other, rtol=1e-8)


def test_hysteresis_is_near_the_rigs_row_of_maxwell_elements(bench):
    context, observed, stand = bench
    where, values, other = CASES["structural_damping"]
    ratio = ours(context, observed, "structural_damping", where, values) / theirs(
        observed, stand, "structural_damping", where, other
    )
    # nine elements hold the loss factor to a few per cent over the band: 5 % of 0.1 of a stiffness
    assert np.sqrt(np.mean(np.abs(np.log(ratio)) ** 2)) < 0.02


def test_added_mass_is_that_of_the_rig(bench):
    context, observed, stand = bench
    values = {"mass": 3.0, "along": 0.6, "beside": 0.05, "gyration": 0.2}
    from flexmodal.diagnosis.effects.added_mass import place_on

    place = place_on(context, "link_3", values)
    other = {"mass": 3.0, "x": place[0], "y": place[1], "z": place[2], "gyration": 0.2}
    np.testing.assert_allclose(
        ours(context, observed, "added_mass", "link_3", values),
        theirs(observed, stand, "added_mass", "link_3", other),
        rtol=1e-8,
    )


@pytest.fixture(scope="module")
def slender():
    """The same of an arm whose links have modes of their own in the band."""
    robot = flexmodal.load("six_link")
    result = simulate(
        robot, postures=1, points=3, trials=2, averages=2, seed=3, record_length=1.0, band=(2.0, 200.0),
        parameter_error=0.0,
    )  # fmt: skip
    stand = make_stand(result.robot, result.plan, ParameterError.all(0.0), 3)
    observed = unlimited(observe(result.campaign))
    return Context.of(robot, observed), observed, stand


def test_a_slender_link_has_the_modes_of_a_beam(slender, monkeypatch):
    context, observed, stand = slender
    bending, length = 2.5e4, float(np.linalg.norm(context.reach("link_1")))
    beam = {"bending_stiffness": bending, "damping_ratio": 0.02}
    first = 1.875104**2 * np.sqrt(bending / (10.0 / length * length**4))
    loss = 2 * 0.02 / first  # the rig's beam: damping in proportion to stiffness
    values = {"stiffness": bending / length, "damping": loss * bending / length, "position": 0.5}
    there = theirs(observed, stand, "link_flexibility", "link_1", beam)

    def off(grown=1.0):
        here = ours(
            context, observed, "link_flexibility", "link_1",
            {**values, "stiffness": grown * values["stiffness"], "damping": grown * values["damping"]},
        )  # fmt: skip
        return float(np.sqrt(np.mean(np.abs(np.log(here / there)) ** 2)))

    assert off() < 0.4 * off(1.2), "a beam a fifth stiffer is far off"
    assert off() < 0.2 * _with_hinges(monkeypatch, 2, off), "two hinges lack modes"


def _with_hinges(monkeypatch, count, then):
    monkeypatch.setattr(link_flexibility, "hinges", lambda context, where: gauss(count)[0])
    return then()


@pytest.mark.parametrize("count", [2, 4])
@pytest.mark.parametrize("position", [0.3, 0.5, 0.62])
def test_hinges_are_worth_one_of_the_stiffness_at_the_position(count, position):
    compliance = 1 / shares(7e4, position, count)
    assert np.all(compliance > 0)
    assert compliance.sum() == pytest.approx(1 / 7e4, rel=1e-12)
    assert compliance @ gauss(count)[0] / compliance.sum() == pytest.approx(position, rel=1e-9)
    if position == 0.5:
        np.testing.assert_allclose(compliance / compliance.sum(), gauss(count)[1], rtol=1e-12)


def test_bending_is_that_of_a_beam_where_it_is_slow(bench):
    context, observed, stand = bench
    length, bending = float(np.linalg.norm(context.reach("link_1"))), 2e5
    found = ours(
        context, observed, "link_flexibility", "link_1",
        {"stiffness": bending / length, "damping": 0.1, "position": 0.5},
    )  # fmt: skip
    other = theirs(
        observed, stand, "link_flexibility", "link_1", {"bending_stiffness": bending, "damping_ratio": 1e-6}
    )
    low = observed.axis.frequency < 15
    # statically the two hinges are the beam; the mass between them tells at (15 Hz / 100 Hz)²
    np.testing.assert_allclose(np.abs(found[:, low] / other[:, low]), 1, atol=0.02)
    stiff = ours(
        context, observed, "link_flexibility", "link_1", {"stiffness": 1e8, "damping": 10.0, "position": 0.5}
    )
    assert np.max(np.abs(np.log(np.abs(stiff[:, low] / other[:, low])))) > 0.2, "the beam is not seen at all"


@pytest.mark.parametrize("effect", sorted(set(catalogue()) - {"coulomb_friction", "nonlinear_stiffness"}))
def test_derivatives_are_those_of_central_differences(bench, effect):
    context, observed, _ = bench
    known = catalogue()[effect]
    where = known.places(context)[-1]
    placed = Placed(known, where)
    root = Hypothesis(context, robot_space(context.robot))
    hypothesis = root.and_also(placed)
    start = known.starts(context, where)[0]
    x = hypothesis.start(placed, start, np.full(len(root.space), 0.03))
    lines = np.array([4, 11, 60])

    def at(x, slopes=False):
        value = np.zeros((len(observed), len(lines)), dtype=complex)
        change = np.zeros((len(x), *value.shape), dtype=complex)
        for rows, found, moved in evaluated(hypothesis, x, observed, lines, slopes=slopes):
            value[rows] = found
            if slopes:
                change[:, rows] = moved
        return value, change

    value, slopes = at(x, slopes=True)
    step = 1e-5
    for k, name in enumerate(hypothesis.space.names):
        shift = step * np.eye(len(x))[k]
        numeric = (at(x + shift)[0] - at(x - shift)[0]) / (2 * step)
        # forward differences of matrices with a step of 1e-6, times the curvature of what they are of
        np.testing.assert_allclose(slopes[k] / value, numeric / value, atol=2e-3, rtol=1e-3, err_msg=name)


def test_unknown_effects_are_named_all_at_once():
    with pytest.raises(InvalidRequest) as error:
        catalogue(["added_mass", "ghosts", "goblins"])
    assert "ghosts" in str(error.value)
    assert "goblins" in str(error.value)
    assert "local_absorber" in str(error.value)


def test_a_structure_seen_anywhere_is_that_of_the_observations(hinged, observed):
    _, _, hypothesis, after = hinged
    (group,) = hypothesis.groups(after.x, observed, slopes=True)
    places = [(int(n), int(d)) for n, d in np.unique(observed.response, axis=0)]
    structures = hypothesis.structures(after.x, places, places[:1], slopes=True)
    for number, posture in enumerate(group.part.posture.tolist()):
        structure, other = structures[posture], group.structures[number]
        np.testing.assert_array_equal(structure.mass, other.mass)
        np.testing.assert_array_equal(structure.response, other.response)
