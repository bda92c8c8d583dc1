"""An absorber by its dynamic stiffness: closed form against the effect, and found again from functions."""

from dataclasses import replace

import numpy as np
import pytest

import flexmodal
from flexmodal.diagnosis.effects import Context, catalogue
from flexmodal.diagnosis.effects.absorber_start import effective_mass, softer_first, ways_of
from flexmodal.diagnosis.effects.effect import along
from flexmodal.diagnosis.effects.free_function import FreeFunction
from flexmodal.diagnosis.effects.local_absorber import WIDE
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.lawfree.body_ports import ATTACHED_BODY, BODY
from flexmodal.diagnosis.lawfree.model import PortedModel
from flexmodal.diagnosis.lawfree.port import Port
from flexmodal.diagnosis.lawfree.profile import Profile
from flexmodal.diagnosis.placed import Placed
from flexmodal.identification import observe, predict, unlimited
from flexmodal.rig import simulate
from flexmodal.structure import robot_space

ARMS = {"fanuc_s360": ["configuration_1", "configuration_6"], "six_axis": ["work"]}
PLACE = {"along": 0.7, "beside": 0.05, "above": -0.03}
SIMPLE = {"mass": 4.0, "frequency": 31.0, "damping_ratio": 0.04, "angle": 0.3, "turn": 0.9}
WIDER = {
    "two ways": {**SIMPLE, "across_ratio": 2.2, "roll": 0.4},
    "two masses": {**SIMPLE, "other": 0.6, "other_ratio": 1.6, "roll": 0.4},
}


@pytest.fixture(scope="module", params=ARMS)
def seen(request):
    """A context and its observations, of a planar arm and of one in space."""
    robot = flexmodal.load(request.param)
    result = simulate(
        robot, postures=ARMS[request.param], points=3, trials=1, averages=2, seed=3, record_length=1.0,
        band=(2.0, 120.0), parameter_error=0.0,
    )  # fmt: skip
    observed = unlimited(observe(result.campaign))
    return Context.of(robot, observed), observed


def of(context, where, values):
    """Values that the effect has on this arm, and its parameters."""
    known = {one.name: one for one in catalogue()["local_absorber"].parameters(context, where)}
    return {name: value for name, value in values.items() if name in known}, known


def coordinates(known, values):
    """What `effective_mass` takes."""
    full = {name: values.get(name, one.card) for name, one in known.items()}
    angles = [name for name in ("angle", "turn", "roll") if name in known]
    logs = [full["mass"], 2 * np.pi * full["frequency"], full["damping_ratio"]]
    more = [full[name] for name in ("across_ratio", "other", "other_ratio")]
    return np.concatenate([np.log(logs), [full[name] for name in angles], np.log(more)]), len(angles)


def relative(one, other):
    """Distance of one from another."""
    return float(np.sqrt(np.mean(np.abs(one - other) ** 2) / np.mean(np.abs(other) ** 2)))


@pytest.mark.parametrize("values", [SIMPLE, *WIDER.values()], ids=["one way", *WIDER])
def test_the_closed_form_at_a_free_port_is_the_effect(seen, values):
    context, observed = seen
    where = context.links[-1]
    given, known = of(context, where, {**values, **PLACE, "relaxing": 1e-8})
    root = Hypothesis(context, robot_space(context.robot))
    placed = Placed(catalogue()["local_absorber"], where)
    hypothesis = root.and_also(placed)
    expected = predict(hypothesis, hypothesis.start(placed, given, np.zeros(len(root.space))), observed)
    lines = np.arange(5, len(observed.axis), 7)
    port = Port.at(BODY, where, context)
    model = PortedModel.of([port], root, replace(observed, value=expected), lines)
    omega = 2 * np.pi * observed.axis.frequency[lines]
    mass = effective_mass(omega, *coordinates(known, given))
    z = -(omega**2)[:, None, None] * mass
    rows, columns = np.triu_indices(z.shape[-1])
    geometry = of(context, where, PLACE)[0]
    x = model.hypothesis.start(model.hypothesis.placed[-1], geometry, np.zeros(len(root.space)))
    profile = Profile(model, 1e-3)
    none, whole = (
        profile.state(x, one).residual for one in (model.zero(), (z[:, rows, columns].T / model.size)[None])
    )
    assert np.sqrt(np.mean(np.abs(whole) ** 2)) < 1e-6 < 1e-3 < np.sqrt(np.mean(np.abs(none) ** 2))


@pytest.mark.some(2)
@pytest.mark.parametrize(
    "values", [SIMPLE, *(pytest.param(one, marks=pytest.mark.slow) for one in WIDER.values())],
    ids=["one way", *WIDER],
)  # fmt: skip
def test_is_found_again_in_functions_with_lines_gone_astray(seen, values):
    context, _ = seen
    where, random = context.links[-1], np.random.default_rng(5)
    given, known = of(context, where, values)
    frequency = np.linspace(3.0, 118.0, 90)
    omega = 2 * np.pi * frequency
    mass = effective_mass(omega, *coordinates(known, given))
    z = -(omega**2)[:, None, None] * mass
    rows, columns = np.triu_indices(z.shape[-1])
    functions = z[:, rows, columns].T
    astray = random.random(90) < 0.1
    functions[:, astray] *= 1 + 3 * random.standard_normal((len(functions), int(astray.sum())))
    free = FreeFunction(frequency, functions, of(context, where, PLACE)[0], np.zeros(3))
    told = catalogue()["local_absorber"].told(context, where, free)
    assert all(one["along"] == PLACE["along"] for one in told)
    assert min(relative(effective_mass(omega, *coordinates(known, one)), mass) for one in told) < 0.02


@pytest.mark.parametrize("roll", [0.5 * np.pi, pytest.param(0.25 * np.pi, marks=pytest.mark.slow)])
def test_another_mass_is_found_that_swings_across_the_first(seen, roll):
    """In space neither has to have a part along the link: nothing tells then to which side to roll."""
    context, _ = seen
    where = context.links[-1]
    twin = {**SIMPLE, "angle": 0.0, "other": 0.9, "other_ratio": 1.9, "roll": roll}
    given, known = of(context, where, twin)
    frequency = np.linspace(3.0, 118.0, 60)
    omega = 2 * np.pi * frequency
    mass = effective_mass(omega, *coordinates(known, given))
    rows, columns = np.triu_indices(mass.shape[-1])
    functions = -(omega**2) * mass[:, rows, columns].T
    free = FreeFunction(frequency, functions, of(context, where, PLACE)[0], np.zeros(3))
    told = catalogue()["local_absorber"].told(context, where, free)
    assert min(relative(effective_mass(omega, *coordinates(known, one)), mass) for one in told) < 0.02


LINE = {
    **SIMPLE, "angle": 0.3, "turn": 0.2, "roll": 0.5, "across_ratio": 1.0, "other": 1e-6, "other_ratio": 5.0,
    "relaxing": 1e-8, "further": 0.11, "further_ratio": 3.0, "foot": 0.12, "below": 0.0,
    "turning": 0.13, "turning_ratio": 2.0, "still": 0.1,
}  # fmt: skip
"""Taut, and swinging where the link carries it."""


def of_line(context, where):
    """Its values on this arm."""
    known = {one.name for one in WIDE.parameters(context, where)}
    own = {name: value for name, value in {**LINE, **PLACE}.items() if name in known}
    return own if context.normal is None else {**own, "across_ratio": 1e4}


def at_the_middle(context, where, values, omega):
    """What the line is to motions and turns of the middle of its link, put together from its parts."""
    angles = [values[name] for name in ("angle", "turn", "roll") if name in values]
    more = [
        values[name] for name in ("across_ratio", "other", "other_ratio", "further", "further_ratio", "foot")
    ]
    logs = [values["mass"], 2 * np.pi * values["frequency"], values["damping_ratio"]]
    moves = effective_mass(omega, np.concatenate([np.log(logs), angles, np.log(more)]), len(angles))
    ways, own = ways_of(np.array(angles)), values["turning_ratio"] * 2 * np.pi * values["frequency"]
    spring = own**2 + 2j * values["damping_ratio"] * own * omega
    each = values["mass"] * (values["turning"] ** 2 * spring / (spring - omega**2) + values["still"] ** 2)
    length, _ = along(context, where)
    place = np.array(
        [(values["along"] - 0.5) * max(length, 0.05), values["beside"], values.get("above", 0.0)]
    )
    if len(angles) == 1:
        about, sweep = np.ones((1, 1)), np.array([[-place[1]], [place[0]]])
    else:
        about, sweep = np.eye(3) - np.outer(ways[2], ways[2]), np.cross(np.eye(3), place).T
    across = moves @ sweep
    turns = each[:, None, None] * about + sweep.T @ across
    across, turns = across / max(length, 0.05), turns / max(length, 0.05) ** 2
    upper = np.concatenate([moves, across], axis=2)
    return np.concatenate([upper, np.concatenate([np.swapaxes(across, 1, 2), turns], axis=2)], axis=1)


def test_a_port_that_turns_too_is_a_line_at_its_place(seen):
    context, observed = seen
    where, lines = context.links[-1], np.arange(5, len(observed.axis), 7)
    root, placed = Hypothesis(context, robot_space(context.robot)), Placed(WIDE, where)
    hypothesis, values = root.and_also(placed), of_line(context, where)
    expected = predict(hypothesis, hypothesis.start(placed, values, np.zeros(len(root.space))), observed)
    model = PortedModel.of(
        [Port.at(ATTACHED_BODY, where, context)], root, replace(observed, value=expected), lines
    )
    omega = 2 * np.pi * observed.axis.frequency[lines]
    z = -(omega**2)[:, None, None] * at_the_middle(context, where, values, omega)
    rows, columns = np.triu_indices(z.shape[-1])
    profile, x = Profile(model, 1e-3), np.zeros(len(model.space))
    none, whole = (
        profile.state(x, one).residual for one in (model.zero(), (z[:, rows, columns].T / model.size)[None])
    )
    assert np.sqrt(np.mean(np.abs(whole) ** 2)) < 2e-3 * np.sqrt(np.mean(np.abs(none) ** 2))


@pytest.mark.some(2)
def test_its_place_and_what_turns_are_told_by_such_a_port(seen):
    context, _ = seen
    where, frequency = context.links[-1], np.linspace(0.0, 118.0, 90)
    values, random = of_line(context, where), np.random.default_rng(5)
    omega = 2 * np.pi * frequency
    z = -(omega**2)[:, None, None] * at_the_middle(context, where, values, omega)
    rows, columns = np.triu_indices(z.shape[-1])
    functions = z[:, rows, columns].T
    functions = functions * (1 + 0.01 * random.standard_normal(functions.shape))
    free = FreeFunction(frequency, functions, {}, np.zeros(3), turns=True)
    told = WIDE.told(context, where, free)
    near = min(told, key=lambda one: abs(np.log(one["turning_ratio"] / 2) + np.log(one["frequency"] / 30)))
    wanted = {"along": 0.05, "beside": 0.01, "mass": 0.1, "frequency": 0.3, "turning": 0.01, "still": 0.01}
    for name, within in wanted.items():
        assert near[name] == pytest.approx(values[name], abs=within), name
    assert near["turning_ratio"] == pytest.approx(2.0, rel=0.02)


@pytest.mark.parametrize("value", [0.0, np.nan])
@pytest.mark.parametrize("kind", [BODY, ATTACHED_BODY], ids=lambda kind: kind.name)
@pytest.mark.parametrize("effect", [catalogue()["local_absorber"], WIDE], ids=["narrow", "wide"])
def test_nothing_at_the_port_tells_nothing(seen, value, kind, effect):
    context, _ = seen
    where = context.links[-1]
    functions = np.full((len(kind.functions(context, where)), 20), value, dtype=complex)
    free = FreeFunction(np.linspace(0, 100, 20), functions, {}, np.zeros(3), turns=kind.turns)
    assert effect.told(context, where, free) == []


@pytest.mark.parametrize("angles", [[0.7], [-1.2], [0.3, 0.9, 0.4], [-0.8, -2.5, 2.9], [1.2, 2.0, -1.4]])
def test_an_absorber_with_its_softer_direction_first_is_the_same(angles):
    omega = 2 * np.pi * np.linspace(5.0, 120.0, 40)
    x = np.array([1.3, np.log(400.0), -3.0, *angles, np.log(0.07), np.log(1e-9), 0.3, -2.0, 1.1, -2.5])
    found = softer_first(x, len(angles))
    assert found[1] == pytest.approx(np.log(400.0 * np.sqrt(0.07)))
    np.testing.assert_allclose(
        effective_mass(omega, found, len(angles)), effective_mass(omega, x, len(angles)), rtol=1e-6, atol=1e-6
    )
    np.testing.assert_array_equal(softer_first(found, len(angles)), found)
    heavy = x.copy()
    heavy[4 + len(angles)] = np.log(0.5)
    np.testing.assert_array_equal(softer_first(heavy, len(angles)), heavy)
