"""With nothing hidden and no noise the rig measures the model's own FRF, within leakage."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import flexmodal
from flexmodal.cards import CouplingCard, FrozenDict
from flexmodal.errors import InvalidRequest
from flexmodal.rig import Hide, simulate
from flexmodal.rig.analyser import Analyser
from flexmodal.rig.blow import Strike, strike
from flexmodal.rig.hammer_test import Conduct, h1, strike_posture
from flexmodal.rig.integration.linear import Outputs, records
from flexmodal.rig.integration.nonlinear import fine_records
from flexmodal.rig.plant.build import build

CLEAN = {"noise": 0.0, "scatter": 0.0, "parameter_error": 0.0}


def leakage(robot, posture, response, reference, plan, frequency) -> np.ndarray:
    """What the record cuts off, at most, as inertance [response, line].

    After the pulse the response is Σ a_p exp(λ_p t) with a_p = λ_p² φ_u φ_v F(λ_p), F the Laplace transform
    of the pulse. The samples from the end of the record on add up to a_p e^{(λ_p − iω) T} / (1 − e^{(λ_p −
    iω) Δ}).
    """
    posed = robot.at(posture)
    poles, shapes = posed.modes().expanded()
    from flexmodal.frf import PointDirection

    rows = posed.rows([PointDirection.parse(text) for text in response]) @ shapes
    push = posed.rows([PointDirection.parse(reference)])[0] @ shapes
    blow = strike(60.0, "soft", 0.0, 0.0, 0.0, np.random.default_rng(0))
    time = np.linspace(0, blow.duration, 2001)
    spectrum = np.trapezoid(blow.force(time) * np.exp(-2j * np.pi * frequency[:, None] * time), time)
    laplace = np.trapezoid(blow.force(time) * np.exp(-poles[:, None] * time), time)
    analyser = plan.analyser
    end = analyser.samples * analyser.interval - analyser.trigger - analyser.interval
    step = (poles[None] - 2j * np.pi * frequency[:, None]) * analyser.interval
    tail = np.exp(poles.real * end) / np.abs(1 - np.exp(step)) * analyser.interval
    size = np.abs(poles**2 * push * laplace)
    return np.einsum("up,p,lp->ul", np.abs(rows), size, tail) / np.abs(spectrum)


ROBOTS = {
    "fanuc_s360": ("configuration_1", "location_2:+z"),
    "six_link": ("start_2", "joint_4:+z"),
    "six_axis": ("work", "wrist:+x"),
}
"""Card: posture and hammer."""


@pytest.mark.parametrize("length", [0.5, 2.0])
@pytest.mark.parametrize("name", ROBOTS)
def test_h1_of_the_rig_is_the_models_inertance_within_leakage(name, length):
    robot = flexmodal.load(name)
    posture, reference = ROBOTS[name]
    result = simulate(robot, postures=[posture], references=[reference], trials=1, averages=1,
                      record_length=length, **CLEAN)  # fmt: skip
    campaign = result.campaign
    frfs = campaign.frfs
    inside = (frfs.frequency >= 2) & (frfs.frequency <= 200)
    points = {point.id: point.name for point in campaign.points}
    response = [f"{points[point]}:+{'xyz'[direction - 1]}" for point, direction in frfs.response]
    model = robot.at(posture).frf(
        frfs.frequency[inside], response=response, reference=reference, form="inertance"
    )
    exact = model.value[:, :, 0].T
    bound = leakage(robot, posture, response, reference, result.plan, frfs.frequency[inside])
    error = np.abs(frfs.value[:, inside] - exact)
    # Above the leakage there is only what the pulse's spectrum beyond the fine grid folds back, 1e-6 of the
    # largest.
    assert np.all(error <= bound + 2e-6 * np.abs(exact).max())
    # The bound is the leakage, not a loose cover of it: it falls a thousandfold from 0.5 s to 2 s of the
    # Fanuc, and the largest error reaches 0.87 of it and more (of the six-link arm in 0.5 s, 0.46).
    assert error.max() > 0.4 * bound.max()


def tied_and_lossy(loss=0.1):
    """The Fanuc with what a diagnosis may write into a card: a coupling and joints that lose energy."""
    plain = flexmodal.load("fanuc_s360")
    joints = {n: replace(j, loss_factor=0.0 if j.pseudo else loss) for n, j in plain.joints.items()}
    size = 0.3 * np.sqrt(plain.joints["q1"].stiffness * plain.joints["q2"].stiffness)
    # much loss is little stiffness below a hertz, which such a coupling would overcome
    tied = FrozenDict({"q1+q2": CouplingCard(("q1", "q2"), size)} if loss < 0.5 else {})
    return replace(plain, joints=FrozenDict(joints), couplings=tied, loss_frequency=20.0)


@pytest.mark.parametrize("loss", [0.0, 0.02, 0.1, 0.5])
def test_a_cards_coupling_and_loss_are_struck_too(loss):
    robot = tied_and_lossy(loss)
    result = simulate(robot, postures=["configuration_1"], references=["location_2:+z"], trials=1, averages=1,
                      record_length=4.0, **CLEAN)  # fmt: skip
    frfs = result.campaign.frfs
    inside = (frfs.frequency >= 2) & (frfs.frequency <= 200)
    names = {point.id: point.name for point in result.campaign.points}
    response = [f"{names[point]}:+{'xyz'[direction - 1]}" for point, direction in frfs.response]
    asked = {"response": response, "reference": "location_2:+z", "form": "inertance"}
    exact = robot.at("configuration_1").frf(frfs.frequency[inside], **asked).value[:, :, 0].T
    error = np.abs(frfs.value[:, inside] - exact) / np.abs(exact).max()
    # Leakage of 4 s, and what the row of Maxwell elements is off the power law at a resonance.
    assert error.max() < 1e-3
    plain = flexmodal.load("fanuc_s360").at("configuration_1")
    without = plain.frf(frfs.frequency[inside], **asked).value[:, :, 0].T
    assert np.abs(without - exact).max() > 0.2 * np.abs(exact).max()  # what was dropped without a word


def test_the_true_springs_carry_the_loss_of_the_card():
    """The robot struck is not the card's, and its springs lose energy by their own stiffness."""
    robot = tied_and_lossy()
    result = simulate(robot, postures=["configuration_1"], points=2, references=1, trials=1, seed=3)
    plant = build(result.stand, result.plan.postures[0], ())
    line = np.array([20.0])
    true = result.stand.true.stiffness
    joints = FrozenDict({n: replace(j, stiffness=true[n]) for n, j in robot.joints.items()})
    joints = FrozenDict({n: replace(j, damping=result.stand.true.damping[n]) for n, j in joints.items()})
    own = replace(robot, joints=joints).at("configuration_1").system
    rows = np.eye(plant.dof)
    made = np.linalg.inv(plant.inertance(rows, rows, line)[0] / -((2 * np.pi * 20) ** 2))
    omega = 2 * np.pi * 20
    lost = np.diag([1j * j.loss_factor * j.stiffness for j in joints.values()])
    wanted = own.stiffness + 1j * omega * own.damping + lost - omega**2 * plant.mass
    np.testing.assert_allclose(made, wanted, atol=1e-4 * np.abs(wanted).max())


@pytest.mark.parametrize(("loss", "frequency"), [(0.1, None), (10.0, 20.0)])
def test_a_loss_that_time_cannot_have_is_refused(loss, frequency):
    robot = replace(tied_and_lossy(loss), loss_frequency=frequency)
    with pytest.raises(InvalidRequest, match=r"joint\.q1\.loss_factor"):
        simulate(robot, postures=1)


def test_what_is_hidden_beside_a_coupling_must_hold_with_it():
    hide = [Hide("joint_coupling", "q1+q2", parameters={"coupling": 0.8})]
    with pytest.raises(InvalidRequest, match=r"q1\+q2"):
        simulate(tied_and_lossy(0.0), postures=1, points=2, references=1, trials=1, hide=hide)


def test_leakage_falls_as_the_record_grows(bars):
    robot = bars(count=2, damping=20.0)
    lines = np.arange(4.0, 60.0)
    errors = []
    for length in (1.0, 2.0):
        result = simulate(robot, postures=["flat"], references=["tip:+z"], trials=1, averages=1,
                          band=(2.0, 100.0), record_length=length, **CLEAN)  # fmt: skip
        frfs = result.campaign.frfs
        found = frfs.value[:, np.round(lines * length).astype(int)]
        model = robot.at("flat").frf(
            lines, response=["middle:+z", "tip:+z"], reference="tip:+z", form="inertance"
        )
        errors.append(np.sqrt(np.mean(np.abs(found - model.value[:, :, 0].T) ** 2)))
    slowest = -max(robot.modes("flat").pole.real)
    # A second more of the decay takes exp(−σ); the blow's later place in the longer record gives 2 % of it
    # back.
    assert np.log(errors[0] / errors[1]) == pytest.approx(slowest, rel=0.1)


def test_error_falls_with_the_step_as_the_pulses_spectrum_does(bars, stand):
    """The tail of a haversine's spectrum falls as 1/f³: half the step folds back an eighth, or less."""
    bench = stand(bars(damping=60.0), references=["tip:+z"], tip="hard", record_length=2.0)
    posture = bench.plan.postures[0]
    frequency = np.fft.rfftfreq(bench.plan.analyser.samples, bench.plan.analyser.interval)
    inside = (frequency >= 2) & (frequency <= 100)
    plant = build(bench, posture, [])
    push = plant.row("link_1", np.array([1.0, 0, 0]), np.array([0, 0, 1.0]))[None]
    exact = plant.inertance(push, push, frequency[inside])[:, 0, 0]
    errors = []
    for fold in (8, 16, 32):
        analyser = replace(bench.plan.analyser, oversampling=fold)
        finer = replace(bench, plan=replace(bench.plan, analyser=analyser))
        value, _ = h1(strike_posture(finer, posture, [], Conduct(noise=0.0, scatter=0.0)))
        errors.append(np.abs(value[0, 0, 1, 0, inside] - exact).max() / np.abs(exact).max())
    assert errors[2] < 2e-4
    assert np.log2(errors[0] / errors[2]) / 2 > 2.5


def _integrated(plant, strike_, row, push, laws, times):
    """Acceleration along `row` by scipy's integrator, laws(u, v, z) -> force, rate of z."""
    n = plant.dof
    inverse = np.linalg.inv(plant.mass)

    def rate(t, state):
        x, v, z = state[:n], state[n : 2 * n], state[2 * n :]
        force, change = laws(plant.element_rows @ x, plant.element_rows @ v, z)
        pull = push * strike_.force(np.array([t]))[0] - plant.stiffness @ x - plant.damping @ v
        return np.concatenate([v, inverse @ (pull - plant.element_rows.T @ force), change])

    count = len(plant.elements)
    found = solve_ivp(rate, (0, times[-1]), np.zeros(2 * n + count), t_eval=times, method="LSODA",
                      rtol=1e-9, atol=1e-13, max_step=2e-4)  # fmt: skip
    assert found.success
    return np.array([row @ rate(t, s)[n : 2 * n] for t, s in zip(times, found.y.T, strict=True)])


LAWS = {
    "nonlinear_stiffness": lambda p: lambda u, v, z: (
        p[0] * u * (u / p[1]) ** 2 / (1 + (u / p[1]) ** 2), z * 0,
    ),
    "coulomb_friction": lambda p: lambda u, v, z: (z, p[1] * (v - np.abs(v) * z / p[0])),
    "clearance": lambda p: lambda u, v, z: (
        np.maximum(p[0] * u + p[2], 0) + np.minimum(p[0] * u + p[2] + p[0] * p[1], 0) - p[2] - p[0] * u,
        z * 0,
    ),
}  # fmt: skip


@pytest.mark.some(2)
@pytest.mark.parametrize("name", [None, *LAWS])
def test_another_integrator_agrees(name, stand, hidden):
    robot = flexmodal.load("fanuc_s360")
    bench = stand(robot, references=["location_1:+z"], band=(2.0, 200.0), trials=2)
    opens = {"preload": 1e-5, "gap": 5e-4} if name == "clearance" else {}
    spec = [] if name is None else [hidden(bench, name, "q2", **opens)]
    posture = bench.plan.postures[0]
    plant = build(bench, posture, spec)
    blow = Strike(240.0, 4.3e-3, 0.01037, np.zeros(3), np.eye(3))
    tip = bench.plan.points[0]
    row = plant.row(tip.link, np.array(tip.xyz), np.array([0, 0, 1.0]))
    outputs = Outputs(plant.output_row(row)[None, None], (row @ np.linalg.solve(plant.mass, row))[None, None],
                      np.zeros(1))  # fmt: skip
    errors = []
    for fold in (16, 32, 64):
        analyser = Analyser(512.0, 64, fold)
        fine = fine_records(plant, plant.input_column(row[None]), outputs, row[None], [blow], analyser)[0, 0]
        if fold == 16:
            times = np.arange(0, 0.08, analyser.step)
            law = LAWS[name](plant.elements[0].parameters) if name else lambda u, v, z: (u, z)
            exact = _integrated(plant, blow, row, row, law, times)
        same = fine[:: fold // 16][: len(times)]
        errors.append(np.abs(same - exact).max() / np.abs(exact).max())
    if name is None:
        assert max(errors) < 1e-6  # no step in it: scipy's tolerance
    else:
        assert errors[2] < 2e-3
        # Second order; laws with a corner (stick, contact) lose some of it where the corner falls in a step.
        assert np.log2(errors[0] / errors[2]) / 2 > (1.7 if name == "nonlinear_stiffness" else 0.8)


def _limit(p, v):
    return p[0] + (p[1] - p[0]) * np.exp(-((v / p[2]) ** 2))


def _bouc_wen(p, v, z):
    part = z / p[1]
    return p[0] * (v - (np.abs(v) * part * np.abs(part) + v * part**2) / 2)


FORMS = {
    "coulomb_friction:tanh": lambda p: lambda u, v, z: (_limit(p, v) * np.tanh(v / p[3]), z * 0),
    "coulomb_friction:stribeck": lambda p: lambda u, v, z: (_limit(p, v) * np.tanh(v / p[3]), z * 0),
    "coulomb_friction:lugre": lambda p: lambda u, v, z: (
        p[0] * z + p[1] * (v - p[0] * np.abs(v) * z / _limit(p[2:], v)),
        v - p[0] * np.abs(v) * z / _limit(p[2:], v),
    ),
    "coulomb_friction:bouc_wen": lambda p: lambda u, v, z: (z, _bouc_wen(p, v, z)),
    "nonlinear_stiffness:cubic": lambda p: lambda u, v, z: (p[0] * u**2 + p[1] * u**3, z * 0),
    "nonlinear_stiffness:wind_up": lambda p: lambda u, v, z: (
        np.sign(u) * (p[0] * np.maximum(np.abs(u) - p[1], 0) + p[2] * np.maximum(np.abs(u) - p[3], 0)), z * 0,
    ),
    "nonlinear_stiffness:levelling": lambda p: lambda u, v, z: (p[0] * np.tanh(u / p[1]) + p[2] * u, z * 0),
    "nonlinear_stiffness:exponential": lambda p: lambda u, v, z: (
        p[0] * (p[1] * np.sinh(u / p[1]) - u), z * 0,
    ),
}  # fmt: skip
"""Torque and rate of what is remembered, of the laws as they are printed; numbers by element.

A slider's corner is too sharp for scipy, and has a closed form in its own test."""


@pytest.mark.some(2)
@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] if k % 2 else []) for k, name in enumerate(FORMS)]
)
def test_another_integrator_agrees_on_every_form(name, stand, hidden):
    bench = stand(flexmodal.load("fanuc_s360"), references=["location_1:+z"], band=(2.0, 200.0), trials=2)
    plant = build(bench, bench.plan.postures[0], [hidden(bench, name, "q2")])
    blow = Strike(240.0, 4.3e-3, 0.01037, np.zeros(3), np.eye(3))
    point = bench.plan.points[0]
    row = plant.row(point.link, np.array(point.xyz), np.array([0, 0, 1.0]))
    outputs = Outputs(plant.output_row(row)[None, None], (row @ np.linalg.solve(plant.mass, row))[None, None],
                      np.zeros(1))  # fmt: skip
    times = np.arange(0, 0.08, Analyser(512.0, 64, 16).step)
    law = FORMS[name](np.array([element.parameters for element in plant.elements]).T)
    exact = _integrated(plant, blow, row, row, law, times)
    plain = build(bench, bench.plan.postures[0], [])
    without = _integrated(plain, blow, row, row, lambda u, v, z: (u, z), times)
    errors = []
    for fold in (16, 64):
        analyser = Analyser(512.0, 64, fold)
        fine = fine_records(plant, plant.input_column(row[None]), outputs, row[None], [blow], analyser)[0, 0]
        errors.append(np.abs(fine[:: fold // 16][: len(times)] - exact).max())
    # Of what the law does at all, which is far more than the error; it falls with the step.
    assert errors[1] < 0.03 * np.abs(without - exact).max()
    assert errors[1] < 0.5 * errors[0]


@pytest.mark.parametrize(
    "name",
    ["coulomb_friction:iwan", *(pytest.param(name, marks=pytest.mark.slow) for name in FORMS)],
)
@pytest.mark.slow
def test_compiled_and_plain_loops_agree_on_every_form(name, stand, hidden, monkeypatch):
    pytest.importorskip("numba")
    from flexmodal.rig.integration import nonlinear

    bench = stand(flexmodal.load("fanuc_s360"), points=1, trials=2, record_length=0.3)
    spec = [hidden(bench, name, "q1"), hidden(bench, "clearance", "q3")]
    compiled = strike_posture(bench, bench.plan.postures[0], spec, Conduct(noise=0.0))
    monkeypatch.setattr(nonlinear, "_stepper", lambda seconds: nonlinear.step_through_numpy)
    plain = strike_posture(bench, bench.plan.postures[0], spec, Conduct(noise=0.0))
    size = np.abs(compiled.response).max()
    np.testing.assert_allclose(plain.response, compiled.response, atol=1e-9 * size)


def test_marching_a_linear_plant_is_the_exact_propagation(stand):
    bench = stand(flexmodal.load("fanuc_s360"), references=["location_2:+z"], band=(2.0, 200.0))
    plant = build(bench, bench.plan.postures[0], [])
    point = bench.plan.points[0]
    row = plant.row(point.link, np.array(point.xyz), np.array([0, 0, 1.0]))
    column = plant.input_column(row[None])
    outputs = Outputs(plant.output_row(row)[None, None], (row @ np.linalg.solve(plant.mass, row))[None, None],
                      np.array([7e-4]))  # fmt: skip
    blow = Strike(100.0, 5e-3, 0.0213, np.zeros(3), np.eye(3))
    analyser = Analyser(512.0, 512)
    exact = records(plant.state_matrix, column, outputs, [blow], analyser)
    fine = fine_records(plant, column, outputs, row[None], [blow], analyser)
    again = analyser.sampled(fine, analyser.weights(7e-4), 0, analyser.samples)
    np.testing.assert_allclose(again, exact, atol=1e-9 * np.abs(exact).max())


@pytest.mark.slow
def test_compiled_and_plain_loops_agree(stand, hidden, monkeypatch):
    pytest.importorskip("numba")
    from flexmodal.rig.integration import nonlinear

    bench = stand(flexmodal.load("fanuc_s360"), points=1, trials=2, record_length=0.4)
    posture = bench.plan.postures[0]
    spec = [hidden(bench, name, joint) for name, joint in zip(LAWS, ("q1", "q2", "q3"), strict=True)]
    compiled = strike_posture(bench, posture, spec, Conduct(noise=0.0))
    monkeypatch.setattr(nonlinear, "_stepper", lambda seconds: nonlinear.step_through_numpy)
    plain = strike_posture(bench, posture, spec, Conduct(noise=0.0))
    size = np.abs(compiled.response).max()
    np.testing.assert_allclose(plain.response, compiled.response, atol=1e-9 * size)


def test_filter_keeps_the_band_and_stops_what_folds_back():
    analyser = Analyser(512.0, 512)
    weights = analyser.weights()
    lag = (np.arange(len(weights)) - analyser.reach) * analyser.step

    def gain(frequency):
        return np.abs(np.exp(-2j * np.pi * np.multiply.outer(frequency, lag)) @ weights)

    assert np.abs(gain(np.linspace(0, 200, 50)) - 1).max() < 2e-5
    assert gain(np.linspace(312, 2000, 400)).max() < 2e-5  # 512 − 200 Hz folds back to 200 Hz: 94 dB and more
