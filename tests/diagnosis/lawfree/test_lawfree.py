"""The law-free look: derivatives against differences, known functions recovered, places and classes found."""

from dataclasses import replace
from unittest.mock import Mock

import numpy as np
import pytest

import flexmodal
from flexmodal.diagnosis.effects import Context, catalogue, rod
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.lawfree import at_parameters, screening
from flexmodal.diagnosis.lawfree.at_parameters import AtParameters
from flexmodal.diagnosis.lawfree.body_ports import ACROSS, ATTACHED_BODY, BODY, GROUND
from flexmodal.diagnosis.lawfree.carried_ports import CARRIED
from flexmodal.diagnosis.lawfree.curve import classes_of, curve_of
from flexmodal.diagnosis.lawfree.elastic_ports import BASE, BEARING
from flexmodal.diagnosis.lawfree.findings import summed_up
from flexmodal.diagnosis.lawfree.geometries import placed_best
from flexmodal.diagnosis.lawfree.joint_ports import BALANCER, COUPLING, DAMPING, HELD, JOINT, ROD, TORQUE
from flexmodal.diagnosis.lawfree.kinds import KINDS, NOTHING
from flexmodal.diagnosis.lawfree.link_ports import CUT, LINK
from flexmodal.diagnosis.lawfree.look import Field
from flexmodal.diagnosis.lawfree.metric import Metric
from flexmodal.diagnosis.lawfree.model import PortedModel
from flexmodal.diagnosis.lawfree.port import Port
from flexmodal.diagnosis.lawfree.ported_fit import profiled
from flexmodal.diagnosis.lawfree.profile import Profile, State
from flexmodal.diagnosis.lawfree.pursuit import MOST, alone, pursued
from flexmodal.diagnosis.lawfree.reading_ports import BLOWS, CHANNEL, SENSOR
from flexmodal.diagnosis.lawfree.related import parts, widened
from flexmodal.diagnosis.lawfree.screening import ALIKE
from flexmodal.diagnosis.lawfree.sighting import Sighting, carried_over, noise_of
from flexmodal.diagnosis.placed import Placed
from flexmodal.errors import SingularResponse
from flexmodal.identification import observe, predict, unlimited
from flexmodal.rig import simulate
from flexmodal.structure import robot_space
from flexmodal.structure.port import CompliancePort
from flexmodal.structure.with_ports import with_ports

PLACES = [
    (JOINT, "q2"),
    (TORQUE, "q2"),
    (TORQUE.wider[0].kind, "q2"),
    (DAMPING, "joints"),
    (COUPLING, "q1+q2"),
    (ROD, "q1+q3"),
    (BALANCER, "q1+q3"),
    (HELD, "q1+q3"),
    (BASE, "base"),
    (LINK, "link_2"),
    (BODY, "link_3"),
    (ATTACHED_BODY, "link_2"),
    (GROUND, "link_2"),
    (ACROSS, "link_2"),
    (CARRIED, "sensor"),
    (SENSOR, None),
]


@pytest.fixture(scope="module")
def root(context):
    return Hypothesis(context, robot_space(context.robot))


def port_of(root, kind, where):
    return Port.at(kind, where or kind.places(root.context)[0], root.context)


def model_of(root, observed, kind, where):
    lines = np.arange(20, len(observed.axis), 41)
    return PortedModel.of([port_of(root, kind, where)], root, observed, lines)


def somewhere(model, seed=4):
    """Parameters and functions away from the card, a small part of their sizes."""
    random = np.random.default_rng(seed)
    z = model.zero()
    z = z + 0.05 * (random.normal(size=z.shape) + 1j * random.normal(size=z.shape))
    return 0.03 * random.normal(size=len(model.space)), z


TOGETHER = {
    "two of one kind": [(BODY, "link_2"), (BODY, "link_3")],
    "two kinds in one place": [(GROUND, "link_2"), (BODY, "link_2"), (LINK, "link_2")],
    "everywhere": [(BASE, "base"), (SENSOR, None), (BODY, "link_3"), (DAMPING, "joints")],
    "blow by blow": [(COUPLING, "q1+q2"), (TORQUE, "q2")],
}
CASES = {kind.name: [(kind, where)] for kind, where in PLACES} | TOGETHER


@pytest.mark.some(3)
@pytest.mark.parametrize("places", CASES.values(), ids=CASES)
def test_derivatives_are_those_of_the_residuals(root, observed, places):
    ports = [port_of(root, kind, where) for kind, where in places]
    has_right_derivatives(PortedModel.of(ports, root, observed, np.arange(20, len(observed.axis), 41)))


@pytest.fixture(scope="module")
def founded():
    """A foundation in space, free about an axis of its own."""
    robot = flexmodal.load("six_axis")
    result = simulate(
        robot, postures=["work"], points=2, references=1, trials=2, averages=2, record_length=1.0, seed=3,
        band=(2.0, 120.0),
    )  # fmt: skip
    observed = unlimited(observe(result.campaign))
    root = Hypothesis(Context.of(robot, observed), robot_space(robot))
    lines = np.arange(20, len(observed.axis), 29)
    return PortedModel.of([port_of(root, BASE, "base")], root, observed, lines)


def test_derivatives_along_the_axis_of_a_foundation_in_space(founded):
    has_right_derivatives(founded)


@pytest.mark.parametrize(
    ("kind", "effect", "where"),
    [
        (BASE, "base_flexibility", "base"),
        (LINK, "link_flexibility", "link_2"),
        (BEARING, "bearing_flexibility", "q2"),
        (JOINT, "servo_compliance", "q2"),
        (BODY, "local_absorber", "link_2"),
    ],
)
def test_a_port_that_gives_nothing_changes_nothing_in_the_place_of_an_effect(founded, kind, effect, where):
    """Both have coordinates there: the port's are its own, or a look says nothing of what a law leaves."""
    bare = founded.root
    placed = Placed(catalogue()[effect], where)
    root = bare.and_also(placed)
    x = root.start(placed, placed.effect.starts(root.context, where)[0], np.zeros(len(bare.space)))
    model = PortedModel.of([port_of(root, kind, where)], root, founded.observations, founded.lines)
    plain = PortedModel.of([Port.at(NOTHING, "", root.context)], root, founded.observations, founded.lines)
    before = AtParameters(plain, x).residual(plain.zero())
    more = np.concatenate([x, np.zeros(len(model.space) - len(x))])
    after = AtParameters(model, more)
    np.testing.assert_allclose(after.residual(model.zero()), before, rtol=1e-7, atol=1e-9)
    z = model.zero()
    assert np.abs(after.residual(z + (0.3 + 0.01j)) - before).max() > 1e-3


@pytest.mark.parametrize("arm", ["planar", "in space"])
def test_a_wider_foundation_begins_where_the_narrower_one_is(request, root, observed, arm):
    """Between any two motions of the root's origin what was about an axis beside it."""
    narrow = model_of(root, observed, BASE, "base") if arm == "planar" else request.getfixturevalue("founded")
    x, z = somewhere(narrow)
    x[narrow.geometry[0]] = 0.4
    (wider,), context = BASE.wider, narrow.root.context
    values = narrow.hypothesis.values_of(narrow.hypothesis.placed[-1], narrow.space.values(x))
    port = Port.at(wider.kind, "base", context)
    wide = PortedModel.of([port], narrow.root, narrow.observations, narrow.lines)
    found = wider.begin(context, "base", values, z[0] * narrow.size)
    assert len(wide.space) == len(narrow.root.space)
    assert len(port.names) == len(found) > len(narrow.names)
    before = AtParameters(narrow, x).residual(z)
    after = AtParameters(wide, x[: len(wide.space)]).residual((found / wide.size)[None])
    np.testing.assert_allclose(after, before, rtol=1e-7, atol=1e-9)
    assert np.abs(before).max() > 0.05


@pytest.mark.parametrize("number", [0, 1])
@pytest.mark.parametrize("arm", ["planar", "in space"])
@pytest.mark.parametrize(
    ("kind", "where", "functions"),
    [
        (CARRIED, "sensor", {"planar": (5, 3), "in space": (8, 6)}),
        (BEARING, "q3", {"planar": (3, 3), "in space": (15, 15)}),
    ],
    ids=["sensor", "bearing"],
)
def test_what_differs_by_direction_begins_where_it_is_alike(
    request, root, observed, arm, number, kind, where, functions
):
    """Off the surface by as much; by the axes of a link or of the world, as it turns with a joint or not."""
    if arm == "in space":
        founded = request.getfixturevalue("founded")
        root, observed = founded.root, founded.observations
    narrow = model_of(root, observed, kind, where)
    port = begins_alike(narrow, kind.wider[number])
    assert len(port.names) == functions[arm][number]


@pytest.mark.parametrize(
    ("robot", "link", "functions"), [("six_link", "link_3", 12), ("six_axis", "link_2", 28)]
)
def test_a_link_that_gives_in_one_place_begins_where_it_does_evenly(robot, link, functions):
    """Seen between its ends: each place where it is cut by itself, and between these."""
    seen = simulate(
        flexmodal.load(robot), postures=2, points=6, references=1, trials=2, averages=2, record_length=1.0,
        seed=3, band=(2.0, 120.0),
    )  # fmt: skip
    observed = unlimited(observe(seen.campaign))
    root = Hypothesis(Context.of(seen.robot, observed), robot_space(seen.robot))
    assert link in CUT.places(root.context)
    port = begins_alike(model_of(root, observed, LINK, link), LINK.wider[0])
    assert len(port.names) == len(set(port.names)) == functions


def begins_alike(narrow, wider):
    """The port of a wider kind, which does at first what the narrower does; all its functions matter."""
    x, z = somewhere(narrow)
    one = Mock(
        spec=Sighting, port=narrow.ports[-1], profile=Mock(spec=Profile, model=narrow),
        state=Mock(spec=State, x=x, z=z),
    )  # fmt: skip
    port, (wide_x, wide_z) = widened(one, wider, narrow.root.context)
    wide = PortedModel.of([port], narrow.root, narrow.observations, narrow.lines)
    before = AtParameters(narrow, x).residual(z)
    after = AtParameters(wide, wide_x)
    np.testing.assert_allclose(after.residual(wide_z), before, rtol=1e-7, atol=1e-9)
    for k, name in enumerate(port.names):
        changed = wide_z.copy()
        changed[:, k] += 0.3
        assert np.abs(after.residual(changed) - before).max() > 1e-4, name
    return port


@pytest.mark.parametrize(("name", "number"), [("q1", 0), ("q3", 2)])
def test_a_mechanism_without_anything_between_is_one_joint(root, observed, name, number):
    wide = model_of(root, observed, COUPLING, "q1+q3")
    x, z = somewhere(wide)
    z[:, [k for k in range(3) if k != number]] = 0.0
    state = Mock(spec=State, x=x, z=z)
    one = Mock(
        spec=Sighting,
        port=port_of(root, COUPLING, "q1+q3"),
        profile=Mock(spec=Profile, model=wide),
        state=state,
    )
    begins = {port.key: start for port, start in parts(one, root.context)}
    assert list(begins) == [("joint", "q1"), ("joint", "q3")]
    narrow = model_of(root, observed, JOINT, name)
    found = AtParameters(narrow, begins["joint", name][0]).residual(begins["joint", name][1])
    np.testing.assert_allclose(found, AtParameters(wide, x).residual(z), rtol=1e-9, atol=1e-12)
    assert np.abs(found).max() > 0.01


def test_joints_of_the_best_mechanism_are_tried_too(root, hinged, observed):
    """Even if each of them alone was left out after a first look."""
    tried = Field.of(root, hinged[1].x, observed, None, kinds=[COUPLING]).round().sightings
    best = next(one.port.where for one in tried if one.port.kind is COUPLING)
    joints = {one.port.where for one in tried if one.port.kind is JOINT}
    assert joints == set(best.split("+"))


def test_the_link_between_two_coupled_joints_is_tried_beside_their_coupling(
    root, hinged, observed, monkeypatch
):
    """Its many hinges come near slowly, so that a first look of few steps may leave it out."""
    kept = screening.kept
    only = [COUPLING.name]
    monkeypatch.setattr(screening, "kept", lambda *a: [port for port in kept(*a) if port.kind.name in only])
    tried = Field.of(root, hinged[1].x, observed, None, kinds=[COUPLING, LINK]).round().sightings
    judged = {one.port.key: one.judged for one in tried}
    assert {where for kind, where in judged if kind == "link"} == {"link_2"}
    assert judged["link", "link_2"] < 1.1 * judged["coupling", "q2+q3"] < 1.6


def test_what_would_leave_nothing_to_fit_or_to_judge_is_not_tried(root, hinged, observed):
    """A sensor that is left out explains all that it has read: where that is everything it says nothing."""
    first, second = list(dict.fromkeys(observed.response[:, 0].tolist()))[:2]
    every, one = observed.response[:, 0], observed.keeping(observed.response[:, 0] == first)
    two = observed.keeping((every == first) | (every == second))
    names = {number: root.context.point(number).name for number in (first, second)}
    channels = [port_of(root, CHANNEL, names[number]) for number in (first, second)]
    x = hinged[1].x[: len(root.space)]
    assert Field.of(root, x, one, None)._possible(channels, None) == channels[1:]
    assert Field.of(root, x, two, None)._possible(channels, None) == channels
    assert Field.of(root, x, two, one)._possible(channels, None) == channels[1:]
    field = Field.of(root, x, two, None, kinds=[CHANNEL])
    found = field.sighted((channels[0],))
    assert not field.round(found, channels).sightings


def has_right_derivatives(model):
    """Against central differences."""
    x, z = somewhere(model)
    here, step = AtParameters(model, x), 1e-5
    slopes = here.slopes(z)
    parameters = slopes.parameters[:, :, 0] + 1j * slopes.parameters[:, :, 1]
    for number in range(len(x)):
        unit = np.where(np.arange(len(x)) == number, step, 0.0)
        ahead, behind = (AtParameters(model, x + side * unit).residual(z) for side in (1, -1))
        found = (ahead - behind) / (2 * step)
        size = np.abs(found).max() + 1e-3
        assert parameters[number] / size == pytest.approx(found / size, abs=5e-6)
    for number in range(z.shape[1]):
        for way in (1.0, 1j):  # holomorphic: a step along i gives i times the derivative
            unit = np.zeros(z.shape, dtype=complex)
            unit[:, number] = step * way
            found = (here.residual(z + unit) - here.residual(z - unit)) / (2 * step * way)
            size = np.abs(found).max()
            assert slopes.along[:, :, number] / size == pytest.approx(found / size, abs=2e-6)


@pytest.mark.parametrize("kind", [JOINT, COUPLING, LINK], ids=lambda kind: kind.name)
def test_functions_that_were_put_in_come_out_again(root, observed, kind):
    """FRFs made with a known function, no noise: the fit finds it at every line, from nothing."""
    where = {"joint": "q2", "coupling": "q1+q3", "link": "link_2"}[kind.name]
    model = model_of(root, observed, kind, where)
    frequency = observed.axis.frequency[model.lines]
    smooth = 0.15 / (1 + 1j * frequency / 60)
    z = model.zero() + smooth * np.linspace(1.0, 0.4, len(model.names))[:, None]
    x = np.zeros(len(model.space))
    value = observed.value.copy()
    value[:, model.lines] *= np.exp(AtParameters(model, x).residual(z))
    clean = replace(model, observations=replace(observed, value=value, used=np.ones_like(observed.used)))
    _, state = profiled(clean, floors=(0.2, 0.05, 0.01, 1e-4), steps=30)
    assert np.abs(state.residual).max() < 1e-4
    assert np.median(np.abs(state.z - z)) < 0.02 * np.abs(smooth).max()


@pytest.mark.parametrize("beside", [[], [(BASE, "base"), (SENSOR, None)]], ids=["alone", "beside others"])
def test_one_constant_more_is_put_in_without_solving_again(root, observed, beside):
    """On patterns of rank one, by the formula of Sherman and Morrison."""
    ports = [port_of(root, kind, where) for kind, where in [*beside, (COUPLING, "q1+q3")]]
    model = PortedModel.of(ports, root, observed, np.arange(20, len(observed.axis), 41))
    x, z = somewhere(model)
    here, last = AtParameters(model, x), model.spans[-1].start
    found = list(here.residuals_with(z, [0, 2], [0.3, 3.0]))
    assert [one[:2] for one in found] == [(0, 0.3), (0, 3.0), (2, 0.3), (2, 3.0)]
    for number, constant, residual in found:
        other = z.copy()
        other[:, last + number] += constant
        np.testing.assert_allclose(residual, here.residual(other), rtol=1e-8, atol=1e-10)


@pytest.mark.parametrize(("robot", "where"), [("fanuc_s360_rigid_link", "q1+q3"), ("six_axis", "q2+q3")])
def test_the_best_places_of_a_rod_are_those_of_least_misfit(robot, where, request, root, observed):
    if robot == "six_axis":
        founded = request.getfixturevalue("founded")
        root, observed = founded.root, founded.observations
    model = model_of(root, observed, ROD, where)
    profile = Profile(model, 0.2, pooled=True)
    at, none = AtParameters(model, np.zeros(len(model.space))), model.zero()
    found = placed_best(profile, at, none, 3)
    places = rod.cranks_tried(root.context, where)
    every = []
    for place in places[:: len(places) // 12]:
        x = at.x.copy()
        for k in model.geometry[-1].tolist():
            parameter = model.space.parameters[k]
            x[k] = parameter.coordinate(place[parameter.name.rpartition(".")[2]])
        every += [profile.state(x, none + constant) for constant in (0.3, 3.0)]
    misfits = [profile.misfit(one.residual) for one in found]
    assert misfits == sorted(misfits)
    assert misfits[-1] <= min(profile.misfit(one.residual) for one in every) * (1 + 1e-9)
    rough = placed_best(profile, at, none, len(places), roughly=True)
    assert len(rough) == 2 * len(places[::3])
    assert misfits[0] <= profile.misfit(rough[0].residual) <= profile.misfit(rough[-1].residual)
    tried = {tuple(one.x[model.geometry[-1]].tolist()) for one in rough}
    assert [len({one[k] for one in tried}) for k in range(len(model.geometry[-1]))] == [
        len({place[name] for place in places}) for name in places[0]
    ]


def test_what_is_eliminated_line_by_line_is_the_step_of_the_whole_system(root, observed):
    """Schur's complement against one dense real system of all unknowns."""
    model = model_of(root, observed, COUPLING, "q1+q2")
    profile = Profile(model, 0.05)
    state = profile.state(*somewhere(model))
    equations = profile.equations(state)
    prior = model.space.precision
    undamped = 0.0, np.zeros((model.cells, len(model.lines)))
    step, along = profile.step(state, equations, undamped, prior)
    zz, zp = equations.zz[0], equations.zp[0]
    lines, functions = zz.shape[:2]
    size, count = lines * functions, len(step)
    dense = np.zeros((2 * size + count,) * 2)
    block = np.zeros((size, size), dtype=complex)
    for line in range(lines):
        part = slice(line * functions, (line + 1) * functions)
        block[part, part] = zz[line]
    flat, pull = zp.reshape(size, count), equations.z[0].reshape(size)
    dense[: 2 * size, : 2 * size] = np.block([[block.real, -block.imag], [block.imag, block.real]])
    dense[: 2 * size, 2 * size :] = np.concatenate([flat.real, flat.imag])
    dense[2 * size :, : 2 * size] = dense[: 2 * size, 2 * size :].T
    dense[2 * size :, 2 * size :] = equations.pp + np.diag(prior)
    right = -np.concatenate([pull.real, pull.imag, equations.p + prior * state.x])
    found = np.linalg.solve(dense, right)
    scale = min(1.0, 1.0 / np.abs(found[2 * size :]).max())
    assert step == pytest.approx(scale * found[2 * size :], rel=1e-5, abs=1e-9)
    if scale == 1.0:
        both = found[:size] + 1j * found[size : 2 * size]
        assert along[0].T.ravel() == pytest.approx(both, rel=1e-4, abs=1e-7)


@pytest.mark.parametrize("value", [5.0, 50.0])
def test_where_a_step_overshoots_a_line_is_damped_until_it_does_not(root, observed, value):
    """By itself: it comes to where it comes from nearby, the others to where they come without it."""
    model = model_of(root, observed, JOINT, "q2")
    x, near = somewhere(model)
    far, others = near.copy(), [k for k in range(len(model.lines)) if k != 3]
    far[:, :, 3] = value

    def descended(z, some):
        profile = Profile(replace(model, lines=model.lines[some]), 0.05, settled=0.0)
        return profile.descended(profile.state(x, z[..., some]), 20, held=True).z

    found, every = descended(far, others), descended(far, slice(None))
    np.testing.assert_allclose(every[..., others], found, rtol=1e-6)
    assert abs(every[0, 0, 3] - descended(near, [3])[0, 0, 0]) < 0.1  # on its way


@pytest.fixture(scope="module")
def found(root, hinged, observed):
    """The look at a campaign in which link_2 bends; its second posture judges."""
    first = observed.posture == 0
    return alone(Field.of(root, hinged[1].x, observed.keeping(first), observed.keeping(~first)))


def test_the_place_is_found_without_a_law(found):
    assert found.whole.port.key == ("link", "link_2")
    assert found.whole.judged < 1.2
    assert found.believed > 3 * found.whole.misfit
    others = [one.judged for one in found.first.sightings if one not in found.first.alike]
    assert all(other > ALIKE * found.whole.judged for other in others)


def test_one_place_that_is_enough_stays_alone(root, hinged, observed, found):
    first = observed.posture == 0
    field = Field.of(root, hinged[1].x, observed.keeping(first), observed.keeping(~first))
    assert pursued(field, found) is found


def test_a_rare_port_that_is_hinted_at_is_tried_with_the_others(root, hinged, observed):
    plain, hinted = (
        Field.of(root, hinged[1].x, observed, None, hinted=keys) for keys in ((), [("rod", "q1+q3")])
    )
    assert ("rod", "q1+q3") in [port.key for port in plain.rare]
    assert [port.key for port in hinted.ports] == [*(port.key for port in plain.ports), ("rod", "q1+q3")]
    assert len(hinted.rare) == len(plain.rare) - 1


def test_what_rubs_between_two_shafts_is_along_one_less_the_other(root, observed):
    """The same way round or the other: each sets out from where both springs are even."""
    for wider, sign in zip(TORQUE.wider, (1, -1), strict=True):
        model = model_of(root, observed, wider.kind, "q2")
        x, z = np.zeros(len(model.space)), model.zero() + 0.2
        size = np.sqrt(root.context.robot.joints["q3"].stiffness / root.context.robot.joints["q2"].stiffness)
        values = model.space.values(x)
        assert next(v for name, v in values.items() if name.endswith("nested")) == pytest.approx(
            sign * size / 2
        )
        plain = model_of(root, observed, TORQUE, "q2")
        apart = AtParameters(model, x).residual(z) - AtParameters(plain, x[: len(plain.space)]).residual(z)
        assert np.abs(apart).max() > 1e-3


def test_the_class_is_read_off_the_curve(root, hinged, observed):
    """A bending link is a spring with a little damping, as stiff as the parametric fit has it."""
    port = Port.at(LINK, "link_2", root.context)
    one = Field.of(root, hinged[1].x, observed, None).sighted((port,))
    curve, metric = curve_of(one)
    classes = classes_of(one, curve, metric)
    assert classes[0].name.startswith("spring")
    _, _, hypothesis, fitted = hinged
    stiffness = hypothesis.space.values(fitted.x)["link_flexibility@link_2.stiffness"]
    assert classes[0].coefficients[0][0] * stiffness == pytest.approx(1.0, rel=0.25)


def test_a_change_of_one_function_counts_as_one_of_all_in_which_the_others_stay(root, hinged, observed):
    port = Port.at(COUPLING, "q1+q2", root.context)
    _, metric = curve_of(Field.of(root, hinged[1].x, observed, None).sighted((port,)))
    lines, functions = metric.root.shape[:2]
    draw = np.random.default_rng(5)
    terms = draw.normal(size=(2, lines)) + 1j * draw.normal(size=(2, lines))
    size = draw.uniform(0.5, 2.0, (functions, lines))
    plain = []
    for number in range(functions):
        for term in terms:
            change = np.zeros(size.shape, dtype=complex)
            change[number] = term / size[number]
            plain.append(metric.of(change))
    np.testing.assert_allclose(metric.of_each(terms, size), np.array(plain).T, rtol=1e-9, atol=1e-12)


def by_one_matrix(profile, state, span):
    """The metric over all lines and ports in one real matrix, what is not the port's own eliminated."""
    equations = profile.equations(state)
    zz, zp = equations.zz[0], equations.zp[0]
    lines, functions = zz.shape[:2]
    block = np.zeros((lines, functions, lines, functions), dtype=complex)
    block[range(lines), :, range(lines)] = zz
    block = block.reshape((lines * functions,) * 2)
    flat = zp.reshape(len(block), -1)
    pull = np.concatenate([flat.real, flat.imag])
    prior = profile.temper(state.residual) * profile.model.space.precision
    full = np.block([[block.real, -block.imag], [block.imag, block.real]])
    full = full - pull @ np.linalg.solve(equations.pp + np.diag(prior), pull.T)
    own = np.zeros(functions, dtype=bool)
    own[span] = True
    own = np.tile(np.tile(own, lines), 2)
    kept, between, beside = (full[np.ix_(a, b)] for a, b in ((own, own), (~own, own), (~own, ~own)))
    return kept - between.T @ np.linalg.solve(beside, between) if len(beside) else kept


@pytest.mark.parametrize(
    "chosen", [[("coupling", "q1+q2")], [("joint", "q2"), ("coupling", "q1+q2")]], ids=str
)
def test_what_a_change_of_a_curve_costs_is_what_one_matrix_over_all_lines_says(
    root, hinged, observed, chosen
):
    field = Field.of(root, hinged[1].x, observed, None)
    one = field.sighted(tuple(port for key in chosen for port in field.ports if port.key == key))
    curve, metric = curve_of(one)
    profile, state, span = one.profile, one.state, one.profile.model.spans[-1]
    plain, draw = by_one_matrix(profile, state, span), np.random.default_rng(6)
    size = profile.model.size[span]
    for _ in range(5):
        change = draw.normal(size=size.shape) + 1j * draw.normal(size=size.shape)
        flat = np.concatenate([change.T.ravel().real, change.T.ravel().imag])
        assert np.sum(metric.of(change) ** 2) == pytest.approx(flat @ plain @ flat, rel=1e-6)
    scale = max(profile.reduced(state.residual), 1.0)
    variance = np.diag(np.linalg.inv(plain)).reshape(2, *size.T.shape).sum(axis=0).T / 2
    np.testing.assert_allclose(curve.deviation, np.sqrt(variance * scale) * size, rtol=1e-4)


def test_parameters_of_which_only_rounding_is_known_leave_a_metric(root, hinged, observed):
    """What nothing is known of once other functions have followed may come out below 0."""
    one = Field.of(root, hinged[1].x, observed, None).sighted((Port.at(COUPLING, "q1+q2", root.context),))
    known = one.profile.equations(one.state)
    below = replace(known, pp=known.pp - 1.001 * np.linalg.eigvalsh(known.pp)[-1] * np.eye(len(known.pp)))
    profile = Mock(spec=Profile, model=one.profile.model, temper=lambda residual: 0.0)
    profile.equations = lambda state: below
    metric = Metric.of_port(profile, one.state, one.profile.model.spans[-1])
    assert np.isfinite(metric.variance).all()
    assert np.isfinite(metric.of(one.state.z[0])).all()


def test_beside_a_named_effect_a_look_begins_where_that_was_fitted(hinged, observed):
    """A sensor the wrong way round is far from what is expected of a gain, and no descent turns its sign."""
    _, _, hypothesis, fitted = hinged
    context = hypothesis.context
    sensor = Placed(catalogue()["sensor_gain"], context.sensors[0])
    with_sensor = hypothesis.and_also(sensor)
    x = with_sensor.start(sensor, {"gain": -1.0, "exponent": 0.0}, fitted.x)
    number = next(p.id for p in observed.campaign.points if p.name == context.sensors[0])
    turned = np.where(observed.response[:, 0] == number, -1.0, 1.0)[:, None] * observed.value
    seen = replace(observed, value=turned)
    one = Field.of(with_sensor, x, seen, None, kinds=(JOINT,))
    other = Field.of(hypothesis, fitted.x, observed, None, kinds=(JOINT,))
    assert one.bare == pytest.approx(other.bare, rel=0.05)
    at_card = replace(one, fitted=np.zeros(len(x)))
    assert at_card.bare > 5 * one.bare


def test_where_nothing_is_missing_no_port_gains(root, observed, hinged):
    """The model's own FRFs with the measured noise: every port ends where the robot alone does."""
    random = np.random.default_rng(3)
    noise = np.sqrt(observed.variance / 2)
    noisy = noise * (random.normal(size=noise.shape) + 1j * random.normal(size=noise.shape))
    still = unlimited(observed)
    made = replace(still, value=predict(root, np.zeros(len(root.space)), still) * np.exp(noisy))
    field = Field.of(root, np.zeros(len(root.space)), made, None, kinds=(JOINT, DAMPING, LINK, SENSOR))
    look = pursued(field, alone(field))
    assert look.believed < 1.2
    assert not look.needed
    assert len(look.members) == 1
    assert all(one.misfit > 0.75 * look.believed for one in look.first.sightings)


@pytest.fixture(scope="module")
def several(root, observed):
    """FRFs with noise of a robot with a spring between two joints, a sensor that lags, a motor's loop."""
    random = np.random.default_rng(8)
    sensor = SENSOR.places(root.context)[-1]
    ports = [port_of(root, COUPLING, "q1+q3"), port_of(root, SENSOR, sensor), port_of(root, JOINT, "q2")]
    lines = np.arange(len(observed.axis))
    still = unlimited(observed)
    model = PortedModel.of(ports, root, still, lines)
    z = model.zero()
    omega = 2 * np.pi * observed.axis.frequency
    z[0, 1] = 0.2
    z[0, 3] = -1j * omega * 1e-3
    z[0, 4] = 0.3 / (1 - (omega / 250) ** 2 + 0.3j * omega / 250)
    noise = np.sqrt(observed.variance / 2)
    noisy = noise * (random.normal(size=noise.shape) + 1j * random.normal(size=noise.shape))
    x = np.zeros(len(model.space))
    made = replace(still, value=still.value * np.exp(AtParameters(model, x).residual(z) + noisy))
    return sensor, Field.of(
        root, np.zeros(len(root.space)), made, None, kinds=(JOINT, COUPLING, SENSOR, CHANNEL)
    )


@pytest.mark.slow
def test_several_places_are_found_together(several):
    sensor, field = several
    first = alone(field)
    assert not first.explains
    found = pursued(field, first)
    assert found.explains
    assert {one.key for one in found.whole.ports} == {
        ("coupling", "q1+q3"), ("sensor", sensor), ("joint", "q2")
    }  # fmt: skip
    assert len(found.members) <= MOST
    assert all(one.without > 1.25 * found.whole.judged for one in found.members)


def test_the_curve_of_one_of_several_is_its_own(several):
    """A delay of 1 ms, the functions of the others free beside it."""
    sensor, field = several
    keys = [("coupling", "q1+q3"), ("joint", "q2"), ("sensor", sensor)]
    ports = tuple(port for key in keys for port in field.ports if port.key == key)
    whole = field.sighted(ports)
    curve, metric = curve_of(whole, 2)
    classes = classes_of(whole, curve, metric, 2)
    assert classes[0].name == "delay"
    assert classes[0].coefficients[0][0] == pytest.approx(1e-3, rel=0.03)
    curve, metric = curve_of(whole, 0)
    spring = next(one for one in classes_of(whole, curve, metric, 0) if one.name == "spring")
    assert spring.share > 0.98
    assert spring.misfit < 4  # at a few lines other functions of all three follow the noise better


@pytest.mark.parametrize("kinds", [[JOINT, LINK], [LINK]], ids=["one of two", "all"])
def test_ports_without_a_model_are_left_out(root, observed, monkeypatch, kinds):
    """Where the receptance is infinite with them; where that is so of all, nothing stands out."""

    def solved(structures, axis, entries, ports):
        if any(isinstance(port, CompliancePort) for port in ports):
            raise SingularResponse("the receptance is infinite here")
        return with_ports(structures, axis, entries, ports)

    monkeypatch.setattr(at_parameters, "with_ports", solved)
    found = alone(Field.of(root, np.zeros(len(root.space)), observed, observed, kinds=kinds))
    assert {one.port.kind.name for one in found.first.sightings} == {kinds[0].name}
    assert np.isfinite(found.whole.judged) == (JOINT in kinds)
    assert np.isfinite(found.believed)
    if JOINT not in kinds:
        assert not found.needed
        assert "nothing stands out" in summed_up(found).says


def test_no_place_of_a_rod_is_best_where_there_is_no_model(root, observed, monkeypatch):
    def solved(*given):
        raise SingularResponse("the receptance is infinite here")

    monkeypatch.setattr(at_parameters, "with_ports", solved)
    model = model_of(root, observed, ROD, "q1+q3")
    at = AtParameters(model, np.zeros(len(model.space)))
    assert placed_best(Profile(model, 0.2, pooled=True), at, model.zero(), 3) == []
    assert not np.isfinite(profiled(model, steps=2)[1].cost)


def test_every_kind_has_places_on_a_planar_arm(root):
    for kind in KINDS:
        for where in kind.places(root.context):
            port = Port.at(kind, where, root.context)
            assert port.names
            assert port.label == f"{kind.name}@{where}"


def test_noise_is_never_below_what_a_model_can_reach(observed):
    silent = replace(observed, variance=np.zeros_like(observed.variance))
    assert noise_of(silent, np.arange(10)) > 0


def test_a_port_that_leaves_blows_out_stands_beside_one_of_each_blow(root, observed):
    """A torque has a function for each posture and blow; those of blows that are left out go with them."""
    field = Field.of(root, np.zeros(len(root.space)), observed, None, by_force=True, kinds=[BLOWS])
    torque = next(one for one in field.torques if one.where == "q2")
    first = field.sighted((torque,))
    seen = field.ports[0].kind.reads(first.profile.model.observations, root.context, field.ports[0].where)
    assert 0 < seen.sum() < len(seen)
    both = field.sighted((field.ports[0],), first)
    model = both.profile.model
    assert len(model.observations) == len(seen) - seen.sum()
    assert both.state.z.shape[0] == model.cells < first.profile.model.cells
    begun = carried_over(first, model, 2)
    assert begun.residual.shape[1] == begun.z.shape[2]
    kept = np.flatnonzero(~seen)[0]
    there = first.state.z[first.profile.model.cell[kept]]
    np.testing.assert_array_equal(begun.z[model.cell[0]], there[..., ::2])
    lacking = both.state.x, both.state.z[:-1]  # as a look at a part of the data has it, without some blows
    again = field.sighted((field.ports[0],), first, lacking)
    assert again.judged == pytest.approx(both.judged)
