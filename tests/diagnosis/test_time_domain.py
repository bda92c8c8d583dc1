"""Integration in time against closed forms, another integrator, and transforms by quadrature."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from flexmodal.diagnosis.effects.friction_felt import dahl, levelling, mean_load
from flexmodal.diagnosis.effects.nonlinear_stiffness import AS_NARROW, FAR, bent, hardened
from flexmodal.diagnosis.time_domain.integration import Steps, Struck, integrate, loop_of, torques
from flexmodal.diagnosis.time_domain.law import (
    FRICTION,
    HARDENING,
    KNEE,
    SLOW,
    friction,
    hardening,
    knee,
    slow_friction,
)
from flexmodal.diagnosis.time_domain.law_kernel import exponential, logarithm
from flexmodal.diagnosis.time_domain.numpy_form import law as law_of_blows
from flexmodal.diagnosis.time_domain.pulse import Pulse, haversine, usual
from flexmodal.diagnosis.time_domain.record import record_receptance
from flexmodal.diagnosis.time_domain.spectrum import spectrum
from flexmodal.structure.structure import Axis, Structure, receptance
from flexmodal.structure.truncation import missing

MASS = np.array([[2.0, 0.3], [0.3, 0.5]])
STIFFNESS = np.array([[9e3, -2e3], [-2e3, 4e3]])
DAMPING = 2e-3 * STIFFNESS  # modes at 10 and 17 Hz, damping ratios 6 and 10 %
ROWS = np.array([[1.0, 0.5], [0.0, 1.0]])
FIRST = np.array([1.0, 0.0])
PULSE = Pulse(100.0, 0.02)
PAIRS = np.array([[0, 0], [1, 0]])
HIGH = 40.0


pytestmark = pytest.mark.usefixtures("one_loop")


def structure(*, damping=DAMPING, extra=0.0, loss_factor=0.0):
    stiffness = STIFFNESS + extra * np.outer(FIRST, FIRST)
    hysteretic = STIFFNESS if loss_factor else np.zeros((2, 2))
    return Structure(("a", "b"), MASS, damping, stiffness, hysteretic, ROWS, ROWS, {}, loss_factor)


def lines(period, **more):
    return Axis(np.arange(1, int(HIGH * period) + 1) / period, 15.0, **more)


def struck(axis, *laws, blows=((0, PULSE),), **more):
    return Struck(structure(**more), laws, axis, blows)


def integrated_receptance(one, length, *, fineness=20.0, **more):
    steps = Steps.behind(one.axis.frequency, length, fineness)
    back = np.transpose(one.structure.solve(one.axis)[0], (2, 1, 0))
    return record_receptance(one, integrate([one], steps, **more)[0], steps, PAIRS, back)


# laws

NO_MORE = (0.0, 0.0, 0.0)
"""Friction neither damps what sticks nor grows with what the joint carries; other laws lack such numbers."""


def law(kind, parameters, old, new, memory):
    """Of one blow."""
    torque, slope = law_of_blows(kind, parameters[None], *(np.array([one]) for one in (old, new, memory)))
    return torque[0], slope[0]


def driven(kind, first, second, way, third=1.0):
    """Torques along a prescribed elongation."""
    return driven_side_by_side(kind, np.array([[first, second, third, 0.0, 1.0, *NO_MORE]]), way)[:, 0]


def driven_side_by_side(kind, parameters, way):
    """Of several laws along the same elongation."""
    held = [np.zeros(len(parameters))]
    for old, new in itertools.pairwise(way):
        both = (np.full(len(parameters), one) for one in (old, new))
        held.append(law_of_blows(kind, parameters, *both, held[-1])[0])
    return np.array(held)


def test_exponential_and_logarithm_are_right_to_the_last_digits():
    with np.errstate(over="ignore"):
        for x in (-700.0, -31.7, -1e-9, 0.0, 1e-3, 0.34, 0.35, 1.0, 12.3, 699.0):
            assert exponential(x) == pytest.approx(np.exp(x), rel=5e-16)
        for x in (1e-300, 1e-9, 0.5, 0.70710678, 0.7071068, 1 - 1e-12, 1.0, 1.4142135, 3.0, 1e300):
            assert logarithm(x) == pytest.approx(np.log(x), rel=5e-16, abs=1e-300)
        assert np.isnan(exponential(np.nan))
        assert exponential(-1e5) == pytest.approx(np.exp(-700.0), rel=1e-15)


@pytest.mark.slow
def test_friction_loses_what_the_closed_form_says():
    torque, amplitude, presliding = 0.7, 3e-3, np.array([300.0, 900.0, 9000.0])
    way = -amplitude * np.cos(np.linspace(0, 10 * np.pi, 25_001))
    given = np.array([[torque, one, 1.0, 0.0, 1.0, *NO_MORE] for one in presliding])
    held = driven_side_by_side(FRICTION, given, way)[20_000:]  # the fifth loop, closed to e^(−16 A σ/T_c)
    lost = np.sum((held[1:] + held[:-1]) / 2 * np.diff(way[20_000:])[:, None], axis=0)
    slack = torque / presliding
    expected = 4 * torque * (amplitude - slack * np.tanh(amplitude / slack))
    np.testing.assert_allclose(lost, expected, rtol=1e-5)  # trapezium of 5000 steps
    for stiffness, loop in zip(presliding, expected, strict=True):
        _, (loss,) = dahl(np.array([amplitude]), torque, stiffness)
        assert np.pi * amplitude**2 * loss == pytest.approx(loop, rel=2e-3)  # 32 points of a half turn


@pytest.mark.slow
def test_a_stand_in_loses_what_the_loop_does():
    torque, amplitude = 0.7, 3e-3
    way = -amplitude * np.cos(np.linspace(0, 10 * np.pi, 25_001))
    given = np.array(
        [[torque, p, i, 0.0, 1.0, *NO_MORE] for p in (300.0, 9000.0) for i in (0.0, 0.5, 0.99, 1.4)]
    )
    held = driven_side_by_side(FRICTION, given, way)[20_000:]
    lost = np.sum((held[1:] + held[:-1]) / 2 * np.diff(way[20_000:])[:, None], axis=0)
    inward = np.sum(held[1:] * way[20_001:, None] + held[:-1] * way[20_000:-1, None], axis=0) / 2
    for one, loop, elastic in zip(given, lost, inward * 2 * np.pi / 5000, strict=True):
        (stiffness,), (loss,) = dahl(np.array([amplitude]), *one[:3])  # 32 points of a half turn
        assert np.pi * amplitude**2 * loss == pytest.approx(loop, rel=2e-2)
        assert np.pi * amplitude**2 * stiffness == pytest.approx(elastic, rel=2e-2)


@pytest.mark.parametrize("exponent", [0.0, 0.5, 1.0, 1.4])
def test_a_joint_that_stands_still_sticks(exponent):
    stiffness, loss = dahl(np.array([0.0, 1e-12]), np.array([0.7, 0.7]), 900.0, exponent)
    np.testing.assert_allclose(stiffness, 900.0, rtol=1e-4)
    np.testing.assert_allclose(loss, 0.0, atol=1e-2)


def test_friction_of_exponent_0_is_a_spring_that_slides():
    way = np.array([0.0, 5e-4, 5e-3, 4.5e-3, -1e-2])
    held = driven(FRICTION, 0.7, 900.0, way, 0.0)
    np.testing.assert_allclose(held, [0.0, 0.45, 0.7, 0.25, -0.7], atol=1e-12)


def test_friction_is_exact_at_any_step_while_the_direction_holds():
    fine = driven(FRICTION, 0.7, 900.0, np.linspace(0, 2e-3, 1001))[-1]
    coarse = driven(FRICTION, 0.7, 900.0, np.array([0, 2e-3]))[-1]
    assert coarse == pytest.approx(fine, rel=1e-12)
    assert coarse == pytest.approx(0.7 * (1 - np.exp(-900 * 2e-3 / 0.7)), rel=1e-12)


@pytest.mark.parametrize(
    ("kind", "parameters"),
    [(FRICTION, (0.7, 900.0, 1.0, 0.0, 1.0)), (FRICTION, (0.7, 300.0, 0.3, 0.0, 1.0)),
     (FRICTION, (0.7, 900.0, 1.5, 0.0, 1.0)), (HARDENING, (-300.0, 1e-3, 0.0, 0.0, 0.0)),
     (HARDENING, (500.0, 1e-3, 7e-4, 40.0, 0.0)), (KNEE, (500.0, 6e-4, 3e-4, 40.0, 2e-4))],
)  # fmt: skip
@pytest.mark.parametrize("new", [-1e-3, 4e-4, 1.2e-3])
def test_slope_of_a_law_is_its_derivative(kind, parameters, new):
    step, given = 1e-9, np.array([*parameters, *NO_MORE])
    up, down = (law(kind, given, 5e-4, new + way * step, 0.2)[0] for way in (1, -1))
    # central differences: rounding 1e-16 · 1 N·m / 1e-9 rad beside slopes of 10 and more
    assert law(kind, given, 5e-4, new, 0.2)[1] == pytest.approx((up - down) / (2 * step), rel=1e-5)


def test_a_hardening_spring_levels_off():
    given = np.array([500.0, 1e-3, 0.0, 0.0, 0.0, *NO_MORE])
    assert law(HARDENING, given, 0.0, 1e-5, 0.0)[0] == pytest.approx(500 * 1e-15 / 1e-6, rel=1e-3)
    assert law(HARDENING, given, 0.0, 10.0, 0.0)[0] == pytest.approx(5000.0, rel=1e-7)


def test_a_spring_that_is_wound_up_is_the_spring_of_the_card_where_it_rests():
    at_rest, q = 800.0, np.array([-3e-3, 0.0, 1e-3])
    given = np.array(hardening(FIRST, 500.0, 1e-3, 7e-4, at_rest).parameters)
    assert law(HARDENING, given, 0.0, 0.0, 0.0) == pytest.approx((0.0, 0.0), abs=1e-12)
    whole = [at_rest * one + law(HARDENING, given, 0.0, one, 0.0)[0] for one in q]
    spring = at_rest * (q + 7e-4) + 500 * (q + 7e-4) ** 3 / (1e-6 + (q + 7e-4) ** 2)
    scale = at_rest / (at_rest + 500 * 0.49 * 3.49 / 1.49**2)
    np.testing.assert_allclose(whole, scale * (spring - spring[1]), rtol=1e-12, atol=1e-15)


def test_the_stand_in_of_a_wound_spring_is_its_first_harmonic():
    amplitude, wound, phase = 1.7e-3, 7e-4, np.linspace(0, 2 * np.pi, 4001)[1:]
    swing = amplitude * np.cos(phase)
    given = np.array(hardening(FIRST, 500.0, 1e-3, wound).parameters)
    torque = [law(HARDENING, given, 0.0, one, 0.0)[0] for one in swing]
    first = 2 * np.mean(torque * np.cos(phase)) / amplitude - given[3]
    assert 500 * hardened(np.array([1.7]), 0.7)[0] == pytest.approx(first, rel=1e-6)
    assert hardened(np.array([1.7]), 1e-9)[0] == pytest.approx(hardened(np.array([1.7]))[0], rel=1e-6)


def test_a_spring_with_a_cubic_part_under_load_is_what_it_says_within_some_deflections():
    """T = k (u + c u³ + 3 c l u²) for a change of next to nothing, u in deflections."""
    k, c, load, bend = 800.0, 0.7, -0.4, 1e-3
    given = np.array(hardening(FIRST, c * FAR**2 * k, FAR * bend, load * bend).parameters)
    u = np.array([-1.5, -0.3, 0.0, 0.4, 2.0])
    torque = [law(HARDENING, given, 0.0, bend * one, 0.0)[0] for one in u]
    np.testing.assert_allclose(torque, k * bend * c * (u**3 + 3 * load * u**2), rtol=0.02, atol=1e-3)


def test_a_sharp_knee_is_a_stop():
    """Nothing before its deflection, and the second spring beyond it, whatever the first one is."""
    given = np.array(knee(FIRST, 500.0, 1e-3, 1e-4, 0.0, 800.0).parameters)
    q = np.array([-4e-3, -1e-3, -5e-4, 0.0, 9e-4, 3e-3])
    torque = [law(KNEE, given, 0.0, one, 0.0)[0] for one in q]
    np.testing.assert_allclose(torque, 500 * np.sign(q) * np.maximum(np.abs(q) - 1e-3, 0), atol=1e-4)


@pytest.mark.parametrize("wound", [0.0, 7e-4, -2e-3])
def test_a_knee_has_the_stiffness_of_the_card_where_it_rests(wound):
    given = np.array(knee(FIRST, 500.0, 1e-3, 0.6, wound, 800.0).parameters)
    assert law(KNEE, given, 0.0, 0.0, 0.0) == pytest.approx((0.0, 0.0), abs=1e-10)
    far = law(KNEE, given, 0.0, 100.0, 0.0)[1]
    if wound == 0.0:
        assert far == pytest.approx(500.0, rel=1e-6)
    felt = np.array([law(KNEE, given, 0.0, one, 0.0)[0] for one in np.linspace(-3e-3, 3e-3, 7)])
    np.testing.assert_allclose(felt, bending(given, np.linspace(-3e-3, 3e-3, 7)), rtol=1e-9, atol=1e-12)


def test_a_round_knee_is_the_narrower_law_but_for_little():
    change, bend, soft = AS_NARROW
    narrow = np.array(hardening(FIRST, 500.0, 1e-3).parameters)
    wide = np.array(knee(FIRST, 500.0 * change, 1e-3 * bend, soft, 0.0, 800.0).parameters)
    q = np.linspace(0.0, 4e-3, 200)
    one, other = (
        [law(kind, p, 0.0, each, 0.0)[0] for each in q] for kind, p in ((HARDENING, narrow), (KNEE, wide))
    )
    assert np.std(np.subtract(one, other)) < 0.006 * np.sqrt(np.mean(np.square(one)))


@pytest.mark.parametrize("softness", [0.05, 0.7])
def test_the_stand_in_of_a_knee_is_its_first_harmonic(softness):
    amplitude, wound, at = 2.3e-3, 4e-4, 1e-3
    phase = np.linspace(0, 2 * np.pi, 20001)[1:]
    given = np.array(knee(FIRST, 500.0, at, softness, wound, 800.0).parameters)
    torque = np.array([law(KNEE, given, 0.0, one, 0.0)[0] for one in amplitude * np.cos(phase)])
    first = 2 * np.mean(torque * np.cos(phase)) / amplitude - given[3]
    seen = given[0] * bent(np.array([amplitude / at]), softness, wound / at)[0]
    assert seen == pytest.approx(first, rel=2e-3)


@pytest.mark.parametrize("speed", [1e-4, 0.05, 3.0])
def test_the_stand_in_of_slow_friction_loses_what_it_does(speed):
    phase = np.linspace(0, 2 * np.pi, 20001)[1:]
    given = np.array([0.7, 0.04, 0.0, 0.0, 0.0, *NO_MORE])
    lost = np.mean([law(SLOW, given, 0.0, v, 0.0)[0] * v for v in speed * np.cos(phase)])
    assert levelling(np.array([speed]), 0.7, 0.04)[0] * speed**2 / 2 == pytest.approx(lost, rel=2e-3)


@pytest.mark.parametrize("speed", [0.05, 0.2, 1.0])
def test_friction_falls_with_speed(speed):
    """What a joint that slides at a steady speed is held by."""
    step = 1e-3
    given = np.array([0.7, 3e6, 1.0, 0.5, 0.2 * step, *NO_MORE])
    held = law(FRICTION, given, 0.0, speed * step, 0.0)[0]
    assert held == pytest.approx(0.7 * (1 + 0.5 * np.exp(-((speed / 0.2) ** 2))), rel=1e-9)


GROWS, WOUND = 120.0, 4e-4


def test_friction_grows_with_what_the_joint_carries():
    """It slips at F + c |q + u₀|: a spring that follows the limit once it is there, out and back."""
    way = np.array([0.0, 5e-4, 5e-3, 4.5e-3, 1e-3, -6e-3])
    given = np.array([[0.7, 900.0, 0.0, 0.0, 1.0, 0.0, GROWS, WOUND]])
    held = driven_side_by_side(FRICTION, given, way)[:, 0]
    limit = 0.7 + GROWS * np.abs(way + WOUND)
    expected = [0.0, 0.45, limit[2], limit[2] - 0.45, -limit[4], -limit[5]]
    np.testing.assert_allclose(held, expected, rtol=1e-9)


@pytest.mark.some(4)
@pytest.mark.parametrize("wound", [0.0, WOUND, -WOUND, 5e-3])
def test_the_stand_in_of_friction_by_load_loses_what_the_loop_does(wound):
    """Sliding from −A to A and back it loses 4 F A + 2 c (A² + u₀²), or 4 (F + c |u₀|) A under more load."""
    torque, amplitude = 0.7, 3e-3
    way = -amplitude * np.cos(np.linspace(0, 4 * np.pi, 20_001))
    given = np.array([[torque, 1e6, 0.0, 0.0, 1.0, 0.0, GROWS, wound]])
    held = driven_side_by_side(FRICTION, given, way)[10_000:, 0]
    lost = np.sum((held[1:] + held[:-1]) / 2 * np.diff(way[10_000:]))
    limit = torque + GROWS * mean_load(np.array([amplitude]), wound)[0]
    assert lost == pytest.approx(4 * limit * amplitude, rel=2e-3)


# spectra


@pytest.mark.parametrize("decay", [0.0, 3.0])
def test_spectrum_of_straight_lines_is_the_integral(decay):
    step, count = 1e-3, 600
    samples = np.cumsum(np.random.default_rng(1).normal(size=count + 1))
    samples -= samples[0]
    axis = Axis(np.array([10, 55, 100]) / (count * step), 15.0, decay)
    time = np.linspace(0, count * step, count * 200 + 1)
    inside = np.interp(time, np.arange(count + 1) * step, samples)
    expected = np.trapezoid(inside * np.exp(-np.outer(axis.s, time)), time, axis=1)
    # trapezium at 200 points a step: (ω h/200)²/12 relative
    np.testing.assert_allclose(spectrum(samples, axis, step), expected, rtol=3e-5)


def test_spectrum_by_fast_transform_and_by_sums():
    step, count = 1e-3, 900
    samples = np.random.default_rng(2).normal(size=(3, 701))  # the record goes on in silence
    axis = Axis(np.arange(1, 200) / (count * step), 15.0, 2.0)
    fast = spectrum(samples, axis, step, count)
    slow = spectrum(samples, Axis(axis.frequency * (1 + 1e-9), 15.0, 2.0), step, 700)
    np.testing.assert_allclose(fast, slow, atol=1e-6 * np.abs(fast).max())  # lines off by 1e-9


def test_haversine_transforms_as_its_formula_says():
    step = PULSE.length / 4000
    frequency = np.array([1.0, 30.0, 1 / PULSE.length, 80.0])
    found = spectrum(PULSE.force(np.arange(4001) * step), Axis(frequency, 1.0), step)
    np.testing.assert_allclose(found, PULSE.peak * haversine(frequency, PULSE.length), rtol=1e-5, atol=1e-8)


def test_harder_blows_are_shorter():
    assert usual("soft", 100.0).length == 5e-3
    assert usual("soft", 6400.0).length == pytest.approx(2.5e-3)
    assert usual("a tip nobody knows", 100.0) == usual("medium", 100.0)


# linear laws: what an integration gives is known


def stiffer(extra):
    """A hardening spring so early past its bend that it is linear."""
    return hardening(FIRST, extra, 1e-12)


@pytest.mark.parametrize("power", [0, 1, 2])
def test_linear_law_gives_what_quadrature_makes_of_the_record(power):
    length = 1.6
    axis = lines(2.0, length=length, power=power)
    found = integrated_receptance(struck(axis, stiffer(1500.0)), length, fineness=80.0)
    other = structure(extra=1500.0)
    time = np.linspace(0, length, 32_001)
    states, rates = histories_of(other, time)
    signal = (states[:, :2], states[:, 2:], rates[:, 2:])[power] @ ROWS.T
    turned = np.exp(-np.outer(axis.s, time))
    recorded = np.trapezoid(turned[:, None] * signal.T, time)
    force = np.trapezoid(turned * PULSE.force(time), time)
    expected = (recorded / force[:, None] / axis.s[:, None] ** power).T
    # straight lines of the torque: (ω h)²/12 at 80 steps of the highest line; of the quadrature less
    np.testing.assert_allclose(found, expected, atol=1e-4 * np.abs(expected).max())
    plain, _ = receptance(other, axis, PAIRS)
    cut, _ = missing(other, axis, PAIRS)  # taken from the middle of a blow that is short
    leakage = np.abs(found - plain).max()
    assert leakage > 0.005 * np.abs(plain).max()
    late = integrated_receptance(struck(axis, stiffer(1500.0)), length + PULSE.length / 2, fineness=80.0)
    assert np.abs(late - plain - cut).max() < 0.05 * leakage


def histories_of(other, time):
    """States of a linear structure under the blow, and their rates."""
    inverse = np.linalg.inv(MASS)
    a = np.block([[np.zeros((2, 2)), np.eye(2)], [-inverse @ other.stiffness, -inverse @ other.damping]])
    column = np.concatenate([[0, 0], inverse @ ROWS[0]])
    force = lambda t: PULSE.force(np.atleast_1d(t))  # noqa: E731
    done = solve_ivp(
        lambda t, x: a @ x + column * force(t)[0], (0, time[-1]), np.zeros(4), t_eval=time, rtol=1e-10,
        atol=1e-13, max_step=2e-3,
    ).y  # fmt: skip
    return done.T, (a @ done + np.outer(column, force(time))).T


def test_record_without_end_gives_the_receptance_itself():
    axis = lines(2.0)
    one = struck(axis, stiffer(1500.0), damping=5 * DAMPING)  # decays by e^-25 within the record
    plain, _ = receptance(structure(damping=5 * DAMPING, extra=1500.0), axis, PAIRS)
    coarse, fine = (
        np.abs(integrated_receptance(one, 0.0, fineness=f) / plain - 1).max() for f in (20.0, 40.0)
    )
    assert coarse < 1e-3
    assert coarse / fine == pytest.approx(4, rel=0.1)  # second order


def test_windowed_record():
    axis = lines(2.0, decay=4.0, length=2.0)
    one = struck(axis, stiffer(1500.0))
    plain, _ = receptance(structure(extra=1500.0), axis, PAIRS)
    found = integrated_receptance(one, 2.0, fineness=80.0)
    assert np.abs(found - plain).max() < 1e-4 * np.abs(plain).max()  # e^-8 times what is left after 2 s


def test_bristles_that_hardly_bend_are_a_spring_and_a_damper():
    stiffness, lag = 1500.0, 2e-3
    axis = lines(4.0)
    damping = DAMPING + stiffness * lag * np.outer(FIRST, FIRST)
    plain, _ = receptance(structure(extra=stiffness, damping=damping), axis, PAIRS)
    one = struck(axis, friction(FIRST, 1e6, stiffness, lag=lag))
    errors = [
        np.abs(integrated_receptance(one, 0.0, fineness=fineness) - plain).max() / np.abs(plain).max()
        for fineness in (40.0, 80.0)
    ]
    assert errors[1] < 1e-3
    assert errors[1] < 0.3 * errors[0]  # of second order in the step


def test_hysteretic_springs_as_a_march_sees_them():
    axis = lines(4.0)
    one = struck(axis, stiffer(300.0), damping=DAMPING, loss_factor=0.05)
    plain, _ = receptance(structure(extra=300.0, loss_factor=0.05), axis, PAIRS)
    bare, _ = receptance(structure(loss_factor=0.05), axis, PAIRS)
    found = integrated_receptance(one, 0.0, fineness=40.0)
    # the torque alone feels the stand-in: a small part of what it does
    assert np.abs(found - plain).max() < 0.02 * np.abs(bare - plain).max()


# other integrators


def histories(one, fineness):
    steps = Steps.behind(one.axis.frequency, 0.5, fineness)
    _, torque, last = torques([one], steps, loop_of([one], steps))
    return steps, torque, last


def bending(parameters, q):
    """A knee as the difference of two roots that its derivation begins with."""
    top, at, wound, linear, over, *_ = parameters

    def torque(u):
        return u + (np.sqrt((u - at) ** 2 + over**2) - np.sqrt((u + at) ** 2 + over**2)) / 2

    return top * (torque(q + wound) - torque(wound)) + linear * q


def integrated(laws, end, tolerance=1e-10):
    """The same blow by an adaptive Runge–Kutta method; torques of friction are states of their own."""
    rubbing = [one for one in laws if one.kind == FRICTION]
    inverse = np.linalg.inv(MASS)

    def rate(time, state):
        q, v, held = state[:2], state[2:4], state[4:]
        force = ROWS[0] * PULSE.force(np.array([time]))[0] - STIFFNESS @ q - DAMPING @ v
        rates = []
        for one, torque in zip(rubbing, held, strict=True):
            force = force - one.row * torque
            speed = one.row @ v
            most, stiffness, exponent, stiction, fall, lag, growing, wound = one.parameters
            most = most * (1 + stiction * np.exp(-((speed / fall) ** 2))) + growing * abs(one.row @ q + wound)
            share = 1 - np.sign(speed) * torque / most
            if stiction == growing == 0.0:
                share = max(share, 0.0)  # rounding
            rates.append(stiffness * speed * np.sign(share) * abs(share) ** exponent)
            force = force - one.row * (lag * rates[-1])
        for one in laws:
            if one.kind == SLOW:
                force = force - one.row * (one.parameters[0] * np.tanh(one.row @ v / one.parameters[1]))
            if one.kind == HARDENING:
                top, deflection, wound, linear, *_ = one.parameters
                now, rest = (one.row @ q + wound) / deflection, wound / deflection
                torque = top * deflection * (now**3 / (1 + now**2) - rest**3 / (1 + rest**2))
                force = force - one.row * (torque + linear * (one.row @ q))
            if one.kind == KNEE:
                force = force - one.row * bending(one.parameters, one.row @ q)
        return np.concatenate([v, inverse @ force, rates])

    start = np.zeros(4 + len(rubbing))
    return solve_ivp(rate, (0, end), start, rtol=tolerance, atol=1e-14, max_step=1e-3).y[:, -1]


LAWS = {
    "friction": (friction(FIRST, 3.0, 3e4),),
    "abrupt friction": (friction(FIRST, 3.0, 3e4, 0.4),),
    "hardening": (hardening(FIRST, 6e3, 2e-3),),
    "softening": (hardening(FIRST, -6e3, 2e-3),),
    "friction at rest": (friction(FIRST, 3.0, 3e4, 1.0, 0.4, 0.05),),
    "bristles that damp": (friction(FIRST, 3.0, 3e4, 1.0, 0.0, 1.0, 3e-3),),
    "friction by load": (friction(FIRST, 1.0, 3e4, growing=900.0, wound=1e-3),),
    "slow friction": (slow_friction(FIRST, 3.0, 0.02),),
    "both kinds of friction": (friction(FIRST, 2.0, 3e4), slow_friction(FIRST, 1.5, 0.3)),
    "two sliders": (friction(FIRST, 2.0, 3e4), slow_friction(FIRST, 1.5, 0.3), friction(FIRST, 4.0, 9e3)),
    "knee": (knee(FIRST, 9e3, 1.5e-3, 0.3, 0.0, 9e3),),
    "knee, wound up": (knee(FIRST, -4e3, 1.5e-3, 1.0, 1e-3, 9e3),),
    "wound up": (hardening(FIRST, 6e3, 2e-3, 1e-3, 9e3),),
    "both": (hardening(np.array([-1.0, 1.0]), 3e3, 2e-3), friction(FIRST, 3.0, 3e4)),
}


@pytest.mark.some(3)
@pytest.mark.parametrize("name", LAWS)
def test_march_follows_an_adaptive_integrator(name):
    one = struck(Axis(np.arange(2, 81) / 2.0, 15.0), *LAWS[name])
    expected = integrated(LAWS[name], 0.5)
    errors = []
    for fineness in (25.0, 50.0, 100.0):
        steps, torque, last = histories(one, fineness)
        assert steps.length == pytest.approx(0.5)
        errors.append(np.abs(last[0] - expected[:4]).max() / np.abs(expected[:4]).max())
        for number, own in enumerate(LAWS[name]):
            if own.kind == FRICTION:
                if own.parameters[5] > 0.0 or own.parameters[6] > 0.0:
                    continue
                most = own.parameters[0] * (1 + own.parameters[3])
                assert np.abs(torque[0, number]).max() <= most * (1 + 1e-9)
    order = np.log2(errors[0] / errors[2]) / 2
    assert errors[2] < 2e-3
    assert order > 1.5, errors  # 2 while the direction holds; each reversal falls somewhere into a step


def test_stiff_friction_stays_bounded_at_a_coarse_step():
    one = struck(Axis(np.arange(2, 81) / 2.0, 15.0), friction(FIRST, 3.0, 3e9))
    _, torque, last = histories(one, 10.0)
    assert np.abs(torque).max() <= 3.0 * (1 + 1e-9)
    assert np.all(np.isfinite(last))


@pytest.mark.some(3)
@pytest.mark.parametrize("name", LAWS)
def test_compiled_and_plain_loops_agree(name):
    pytest.importorskip("numba")
    axis = lines(1.0, length=0.98)
    blows = ((0, PULSE), (0, Pulse(30.0, 0.03)), (1, PULSE), (1, Pulse(1.0, 0.02)), (0, Pulse(5.0, 0.02)))
    some = [struck(axis, *LAWS[name], blows=blows, damping=f * DAMPING) for f in (1.0, 2.0)]
    steps = Steps.behind(axis.frequency, 0.98, 10.0)
    one, other = (integrate(some, steps, compiled=which) for which in (True, False))
    for a, b in zip(one, other, strict=True):
        np.testing.assert_allclose(a.torque, b.torque, atol=1e-8 * np.abs(a.torque).max())
        np.testing.assert_allclose(a.last, b.last, atol=1e-8 * np.abs(a.last).max())
        np.testing.assert_array_equal(a.force, b.force)


def test_structures_that_occur_twice_are_integrated_once(monkeypatch):
    from flexmodal.diagnosis.time_domain import integration

    axis = lines(1.0)
    one, other = (struck(axis, stiffer(1500.0), damping=f * DAMPING) for f in (1.0, 2.0))
    seen = []
    real = integration._integrated
    monkeypatch.setattr(
        integration, "_integrated", lambda some, *rest: seen.append(len(some)) or real(some, *rest)
    )
    found = integrate([one, other, one], Steps.behind(axis.frequency))
    assert sum(seen) == 2
    assert found[0] is found[2] is not found[1]


def test_batches_do_not_change_anything(monkeypatch):
    from flexmodal.diagnosis.time_domain import integration

    axis = lines(1.0)
    some = [struck(axis, *LAWS["both"], damping=f * DAMPING) for f in (1.0, 2.0, 3.0)]
    together = integrate(some, Steps.behind(axis.frequency))
    monkeypatch.setattr(integration, "_TOGETHER", 1)
    for a, b in zip(together, integrate(some, Steps.behind(axis.frequency)), strict=True):
        np.testing.assert_array_equal(a.torque, b.torque)


def test_structures_may_be_struck_at_different_numbers_of_points():
    """As in a campaign whose postures were not all struck in the same places."""
    axis = lines(2.0)
    laws = [hardening(FIRST, size, 1e-3) for size in (2e3, 3e3)]
    several = struck(axis, laws[0], blows=((0, PULSE), (1, PULSE)))
    one = replace(several.structure, reference=ROWS[1:])
    few = Struck(one, (laws[1],), axis, ((0, PULSE),))
    steps = Steps.behind(axis.frequency)
    together = integrate([several, few], steps)
    apart = [integrate([some], steps)[0] for some in (several, few)]
    for a, b in zip(together, apart, strict=True):
        np.testing.assert_allclose(a.torque, b.torque, rtol=1e-12, atol=1e-15)
        np.testing.assert_allclose(a.last, b.last, rtol=1e-12, atol=1e-15)


def test_records_longer_than_the_lines_say():
    frequency = np.arange(1, 41) * 0.5
    assert Steps.behind(frequency, 3.92).whole * Steps.behind(frequency, 3.92).step == pytest.approx(4.0)
    assert Steps.behind(frequency, 3.92).length == pytest.approx(3.92, abs=0.01)
    assert Steps.behind(frequency).length == pytest.approx(2.0)
    assert Steps.behind(frequency, 2.0).length == pytest.approx(2.0)
