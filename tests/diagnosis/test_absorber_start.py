"""An absorber by its dynamic stiffness: closed form against the effect, and found again from functions."""

from dataclasses import replace

import numpy as np
import pytest

import flexmodal
from flexmodal.diagnosis.effects import Context, catalogue
from flexmodal.diagnosis.effects.absorber_start import effective_mass
from flexmodal.diagnosis.effects.free_function import FreeFunction
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.lawfree.body_ports import BODY
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


@pytest.mark.parametrize("roll", [0.5 * np.pi, 0.25 * np.pi])
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


@pytest.mark.parametrize("value", [0.0, np.nan])
def test_nothing_at_the_port_tells_nothing(seen, value):
    context, _ = seen
    where = context.links[-1]
    count = len(BODY.functions(context, where))
    free = FreeFunction(np.linspace(0, 100, 20), np.full((count, 20), value, dtype=complex), {}, np.zeros(3))
    assert catalogue()["local_absorber"].told(context, where, free) == []
